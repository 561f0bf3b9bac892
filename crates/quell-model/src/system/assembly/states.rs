//! The states, their rates, and where a run begins.

use quell_expression::Slot;

use super::{Assembler, ElementState, State, StateKind};
use crate::equations::Symbol;
use crate::system::elimination::combination;
use crate::system::motion::ElementRow;
use crate::system::structure::{dot, least_squares};

impl Assembler<'_> {
    /// Names of directions, `strut.1`, or of the massless coordinate that they are.
    pub(super) fn direction_name(&self, direction: &[f64]) -> String {
        let largest = direction
            .iter()
            .fold(0.0_f64, |most, entry| most.max(entry.abs()));
        let place = direction
            .iter()
            .position(|entry| entry.abs() >= 0.999 * largest)
            .unwrap_or(0);
        if let Some(coordinate) = self
            .displacements
            .massless
            .get(place)
            .and_then(|index| self.host.coordinates.get(*index))
        {
            return coordinate.name.clone();
        }
        self.displacements
            .nodes
            .iter()
            .zip(self.devices)
            .rev()
            .find(|(first, _)| **first <= place)
            .map_or_else(
                || format!("motion{place}"),
                |(first, device)| format!("{}.{}", device.name, place - first + 1),
            )
    }

    pub(super) fn states(&mut self) -> Vec<State> {
        let mut states = Vec::new();
        let massive: Vec<usize> = (0..self.host.coordinates.len())
            .filter(|index| self.displacements.place(*index).is_none())
            .collect();
        let motions = self.motions.clone();
        let first_rate = massive.len() + motions.second.len() + motions.first.len();
        for (place, index) in massive.iter().enumerate() {
            states.push(State {
                name: self.host.coordinates[*index].name.clone(),
                kind: StateKind::Position {
                    rate: first_rate + place,
                },
                input: self.inputs.find(Symbol::Coordinate {
                    index: *index,
                    order: 0,
                }),
            });
        }
        for (place, (direction, input)) in
            motions.right.second.iter().zip(&motions.second).enumerate()
        {
            states.push(State {
                name: self.direction_name(direction),
                kind: StateKind::Position {
                    rate: first_rate + massive.len() + place,
                },
                input: *input,
            });
        }
        for (direction, input) in motions.right.first.iter().zip(&motions.first) {
            states.push(State {
                name: self.direction_name(direction),
                kind: StateKind::Displacement,
                input: *input,
            });
        }
        for index in &massive {
            states.push(State {
                name: format!("{}'", self.host.coordinates[*index].name),
                kind: StateKind::Rate,
                input: self.inputs.find(Symbol::Coordinate {
                    index: *index,
                    order: 1,
                }),
            });
        }
        let seconds = motions.right.second.iter().zip(&motions.second_rates);
        let neutral = motions
            .right
            .second_neutral
            .iter()
            .zip(&motions.second_neutral_rates);
        for (direction, input) in seconds.chain(neutral) {
            states.push(State {
                name: format!("{}'", self.direction_name(direction)),
                kind: StateKind::Rate,
                input: *input,
            });
        }
        for (index, state) in self.host.states.iter().enumerate() {
            states.push(State {
                name: state.name.clone(),
                kind: StateKind::FirstOrder,
                input: self.inputs.find(Symbol::State { index }),
            });
        }
        states
    }

    /// Rates in the order of [`Self::states`].
    pub(super) fn state_rates(&mut self, states: &[State], massive: &[usize]) -> Vec<Slot> {
        let mut rates = Vec::with_capacity(states.len());
        for index in massive {
            rates.push(self.inputs.slot(Symbol::Coordinate {
                index: *index,
                order: 1,
            }));
        }
        let motions = self.motions.clone();
        rates.extend(self.inputs.slots(&motions.second_rates));
        rates.extend(self.inputs.slots(&motions.first_rates));
        for index in massive {
            rates.push(self.inputs.slot(Symbol::Coordinate {
                index: *index,
                order: 2,
            }));
        }
        rates.extend(self.inputs.slots(&motions.second_accelerations));
        rates.extend(self.inputs.slots(&motions.second_neutral_accelerations));
        rates.extend(&self.rates);
        rates
    }

    /// Where a run begins: the host as it says; within devices springs unstretched and inerters at rest as far as
    /// possible, where not as evenly as possible.
    pub(super) fn start(&mut self, states: &[State]) -> Vec<Slot> {
        let host = self.host;
        let mut begin = Vec::new();
        for (index, coordinate) in host.coordinates.iter().enumerate() {
            for (order, slot) in [coordinate.start, coordinate.rate].into_iter().enumerate() {
                begin.push((self.inputs.find(Symbol::Coordinate { index, order }), slot));
            }
        }
        for (index, state) in host.states.iter().enumerate() {
            begin.push((self.inputs.find(Symbol::State { index }), state.start));
        }
        let mut found: Vec<(usize, Slot)> = begin.clone();
        let size = self.displacements.size;
        let count = self.displacements.massless.len();
        let components = self.motions.right.components(size);
        let elements: Vec<ElementState> = self.elements.clone();
        for order in 0..2 {
            // Rows of what is to be unstretched, over nodes; the head's part is given.
            let chosen: Vec<&ElementRow> = elements
                .iter()
                .map(|element| &element.row)
                .filter(|row| {
                    let law = self
                        .devices
                        .get(row.device)
                        .and_then(|device| device.mechanism.elements().get(row.element))
                        .map(|item| &item.law);
                    law.is_some_and(|law| {
                        if order == 0 {
                            law.is_spring_like()
                        } else {
                            law.is_inertial()
                        }
                    })
                })
                .collect();
            let over_nodes: Vec<Vec<f64>> = chosen
                .iter()
                .map(|row| row.nodes.get(count..).unwrap_or_default().to_vec())
                .collect();
            let share = least_squares(&over_nodes, size - count);
            let mut displacement: Vec<Option<Slot>> = self
                .displacements
                .massless
                .iter()
                .map(|index| {
                    let coordinate = host.coordinates.get(*index)?;
                    Some(if order == 0 {
                        coordinate.start
                    } else {
                        coordinate.rate
                    })
                })
                .collect();
            for row in &share {
                let mut terms = Vec::new();
                for (factor, element) in row.iter().zip(&chosen) {
                    let port = self
                        .devices
                        .get(element.device)
                        .map_or(0, |device| device.port);
                    let factor = dot(&[*factor], &[element.head]);
                    if let (true, Some(across)) = (factor != 0.0, self.across.get(port)) {
                        terms.push((factor, across.motion[order]));
                    }
                }
                let slot = combination(&mut self.inputs.graph, &terms);
                displacement.push(slot.and_then(|slot| {
                    self.inputs
                        .graph
                        .substitute(&[slot], &begin)
                        .first()
                        .copied()
                }));
            }
            let groups = self.motions.right.counts();
            let offsets: Vec<usize> = groups
                .iter()
                .scan(0, |sum, count| {
                    let first = *sum;
                    *sum += count;
                    Some(first)
                })
                .collect();
            let targets: Vec<(usize, usize)> = if order == 0 {
                let first = self.motions.first.iter().enumerate();
                let second = self.motions.second.iter().enumerate();
                first
                    .map(|(i, input)| (offsets[1] + i, *input))
                    .chain(second.map(|(i, input)| (offsets[4] + i, *input)))
                    .collect()
            } else {
                let second = self.motions.second_rates.iter().enumerate();
                let neutral = self.motions.second_neutral_rates.iter().enumerate();
                second
                    .map(|(i, input)| (offsets[4] + i, *input))
                    .chain(neutral.map(|(i, input)| (offsets[5] + i, *input)))
                    .collect()
            };
            for (component, input) in targets {
                let terms: Vec<(f64, Slot)> = components
                    .get(component)
                    .map(|row| {
                        row.iter()
                            .zip(&displacement)
                            .filter_map(|(factor, slot)| Some((*factor, (*slot)?)))
                            .collect()
                    })
                    .unwrap_or_default();
                let slot = match combination(&mut self.inputs.graph, &terms) {
                    Some(slot) => slot,
                    None => self.inputs.graph.constant(0.0),
                };
                found.push((input, slot));
            }
        }
        states
            .iter()
            .map(|state| {
                found
                    .iter()
                    .find(|(input, _)| *input == state.input)
                    .map_or_else(|| self.inputs.graph.constant(0.0), |(_, slot)| *slot)
            })
            .collect()
    }
}
