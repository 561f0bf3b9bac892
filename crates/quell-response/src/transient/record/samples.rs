//! Evaluating signals: once at the points of every step, and wherever else they are asked for.

use super::super::chebyshev::nodes;
use super::{Panel, Part, Record};

impl Record<'_> {
    pub(super) fn part_at(&self, t: f64) -> usize {
        self.parts
            .iter()
            .position(|part| t <= part.trajectory.to())
            .unwrap_or(self.parts.len() - 1)
    }

    /// Fills `values` with the signals at a time.
    pub(super) fn evaluate(&mut self, part: usize, segment: Option<usize>, t: f64) {
        let Part {
            trajectory,
            dynamics,
        } = &mut self.parts[part];
        let x = &mut self.x[..trajectory.states()];
        let segment = segment.unwrap_or_else(|| trajectory.segment_at(t));
        trajectory.evaluate(segment, t, x);
        dynamics.0.watch(t, x, &mut self.values);
    }

    pub(super) fn at(&mut self, signal: usize, t: f64) -> f64 {
        self.value(signal, t)
    }

    pub(super) fn sample(&self, panel: &Panel, node: usize, signal: usize) -> f64 {
        if signal < self.signals {
            panel.values[node * self.signals + signal]
        } else {
            f64::NAN
        }
    }

    /// Samples the window, once.
    pub(super) fn prepare(&mut self) {
        if !self.panels.is_empty() {
            return;
        }
        let mut panels = Vec::new();
        let parts = self.parts.len();
        for part in 0..parts {
            let trajectory = self.parts[part].trajectory;
            // Phases end at their event; only the last one may be read beyond.
            let most = if part + 1 < parts {
                trajectory.to()
            } else {
                trajectory.last()
            };
            let to = self.to.min(most);
            for (index, segment) in trajectory.segments().iter().enumerate() {
                let (a, b) = (segment.from.max(self.from), segment.to.min(to));
                if a < b {
                    let whole = a == segment.from
                        && b >= segment.from + segment.length * (1.0 - 1e-15)
                        && segment.degree >= 4;
                    let degree = segment.degree.max(6);
                    let panel = if whole {
                        self.whole(part, index, b)
                    } else {
                        self.panel(part, index, (a, b), degree)
                    };
                    panels.push(panel);
                }
            }
        }
        if panels.is_empty() {
            // An empty window still has a value.
            let part = self.part_at(self.from);
            let segment = self.parts[part].trajectory.segment_at(self.from);
            panels.push(self.panel(part, segment, (self.from, self.from), 2));
        }
        self.panels = panels;
    }

    /// The panel of a whole step, whose states need no interpolation.
    fn whole(&mut self, part: usize, index: usize, to: f64) -> Panel {
        let Part {
            trajectory,
            dynamics,
        } = &mut self.parts[part];
        let segment = trajectory.segments()[index];
        let points = &nodes(segment.degree).points;
        let n = trajectory.states();
        let mut values = Vec::with_capacity(points.len() * self.signals);
        let rows = trajectory.node_values(index).chunks_exact(n.max(1));
        for (point, x) in points.iter().zip(rows) {
            let t = segment.from + point * segment.length;
            dynamics.0.watch(t, x, &mut self.values);
            values.extend_from_slice(&self.values[..self.signals]);
        }
        Panel {
            part,
            segment: index,
            from: segment.from,
            to,
            degree: segment.degree,
            values,
        }
    }

    pub(super) fn panel(
        &mut self,
        part: usize,
        segment: usize,
        (from, to): (f64, f64),
        degree: usize,
    ) -> Panel {
        let points = &nodes(degree).points;
        let mut values = Vec::with_capacity(points.len() * self.signals);
        for point in points {
            self.evaluate(part, Some(segment), from + point * (to - from));
            values.extend_from_slice(&self.values[..self.signals]);
        }
        Panel {
            part,
            segment,
            from,
            to,
            degree,
            values,
        }
    }
}
