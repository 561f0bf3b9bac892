//! Interpolation between samples in time.

/// Samples with a curve through them; before the first and after the last it has their values.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    times: Vec<f64>,
    /// c0 + c1 s + c2 s² + c3 s³ with s from the beginning of each interval.
    intervals: Vec<[f64; 4]>,
    /// The first and last value.
    ends: [f64; 2],
    /// Whether slopes jump at every sample.
    linear: bool,
}

impl Samples {
    /// Straight lines through the samples. None if there are not as many values as times, fewer than two, or times that
    /// do not rise.
    #[must_use]
    pub fn linear(times: Vec<f64>, values: &[f64]) -> Option<Self> {
        let ends = check(&times, values)?;
        let intervals = times
            .windows(2)
            .zip(values.windows(2))
            .map(|(t, y)| [y[0], (y[1] - y[0]) / (t[1] - t[0]), 0.0, 0.0])
            .collect();
        Some(Self {
            times,
            intervals,
            ends,
            linear: true,
        })
    }

    /// The cubic spline through the samples, twice continuously differentiable, its third derivative continuous at the
    /// second sample and the last but one ("not a knot"): a parabola for three samples, a line for two. None as for
    /// [`linear`](Self::linear).
    ///
    /// Source: C. de Boor, A Practical Guide to Splines, Springer 1978, chapter IV.
    #[must_use]
    pub fn cubic(times: Vec<f64>, values: &[f64]) -> Option<Self> {
        let ends = check(&times, values)?;
        let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let secants: Vec<f64> = values
            .windows(2)
            .zip(&steps)
            .map(|(pair, step)| (pair[1] - pair[0]) / step)
            .collect();
        let slopes = slopes(&steps, &secants);
        let intervals = steps
            .iter()
            .zip(&secants)
            .zip(slopes.windows(2).zip(values))
            .map(|((step, secant), (slope, value))| {
                let bend = slope[0] + slope[1] - 2.0 * secant;
                [
                    *value,
                    slope[0],
                    (secant - slope[0] - bend) / step,
                    bend / (step * step),
                ]
            })
            .collect();
        Some(Self {
            times,
            intervals,
            ends,
            linear: false,
        })
    }

    /// Value, first and second derivative, by the law in force at `inside`.
    pub(super) fn value(&self, t: f64, inside: f64) -> [f64; 3] {
        let index = self.times.partition_point(|&time| time <= inside);
        if index == 0 {
            return [self.ends[0], 0.0, 0.0];
        }
        let (Some([c0, c1, c2, c3]), Some(begin)) =
            (self.intervals.get(index - 1), self.times.get(index - 1))
        else {
            return [self.ends[1], 0.0, 0.0];
        };
        let s = t - begin;
        [
            c0 + s * (c1 + s * (c2 + s * c3)),
            c1 + s * (2.0 * c2 + s * 3.0 * c3),
            2.0 * c2 + 6.0 * c3 * s,
        ]
    }

    pub(super) fn breakpoints(&self) -> Vec<f64> {
        if self.linear {
            return self.times.clone();
        }
        let first = self.times.first().copied();
        first
            .into_iter()
            .chain(self.times.last().copied())
            .collect()
    }
}

fn check(times: &[f64], values: &[f64]) -> Option<[f64; 2]> {
    let rising = times.windows(2).all(|pair| pair[0] < pair[1]);
    let finite = times.iter().chain(values).all(|number| number.is_finite());
    if times.len() != values.len() || times.len() < 2 || !rising || !finite {
        return None;
    }
    Some([*values.first()?, *values.last()?])
}

/// Slopes at the samples of the not-a-knot spline: continuity of the second derivative gives
/// h₁ s₀ + 2 (h₀ + h₁) s₁ + h₀ s₂ = 3 (h₁ d₀ + h₀ d₁) inside, with the steps h and secants d.
fn slopes(h: &[f64], d: &[f64]) -> Vec<f64> {
    match (h, d) {
        ([_], [d]) => return vec![*d; 2],
        ([h0, h1], [d0, d1]) => {
            let bend = (d1 - d0) / (h0 + h1);
            return vec![d0 - bend * h0, d0 + bend * h0, d1 + bend * h1];
        }
        _ => {}
    }
    let last = h.len();
    // Rows (before, own, after, right side) of the tridiagonal system.
    let mut rows = Vec::with_capacity(last + 1);
    let width = h[0] + h[1];
    rows.push([
        0.0,
        h[1],
        width,
        ((h[0] + 2.0 * width) * h[1] * d[0] + h[0] * h[0] * d[1]) / width,
    ]);
    for i in 1..last {
        rows.push([
            h[i],
            2.0 * (h[i - 1] + h[i]),
            h[i - 1],
            3.0 * (h[i] * d[i - 1] + h[i - 1] * d[i]),
        ]);
    }
    let (near, far) = (h[last - 1], h[last - 2]);
    let width = near + far;
    rows.push([
        width,
        far,
        0.0,
        (near * near * d[last - 2] + (2.0 * width + near) * far * d[last - 1]) / width,
    ]);
    // Elimination: all pivots are positive, the first being h₁, the second h₀ + h₁, the others dominant.
    for i in 1..rows.len() {
        let factor = rows[i][0] / rows[i - 1][1];
        rows[i][1] -= factor * rows[i - 1][2];
        rows[i][3] -= factor * rows[i - 1][3];
    }
    let mut slopes = vec![0.0; rows.len()];
    let mut after = 0.0;
    for (slope, row) in slopes.iter_mut().zip(&rows).rev() {
        after = (row[3] - row[2] * after) / row[1];
        *slope = after;
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A not-a-knot spline reproduces every cubic; a few roundings of numbers of order 100.
    #[test]
    fn a_cubic_is_reproduced_with_its_derivatives() {
        let cubic = |t: f64| 2.0 - t + 3.0 * t * t - 0.5 * t * t * t;
        for count in [4_usize, 5, 9] {
            let times: Vec<f64> = (0..count)
                .map(|i| i as f64 + 0.3 * (i as f64).sin())
                .collect();
            let values: Vec<f64> = times.iter().map(|&t| cubic(t)).collect();
            let end = times[count - 1];
            let samples = Samples::cubic(times, &values).unwrap();
            for k in 0..20 {
                let t = end * f64::from(k) / 20.0;
                let [value, first, second] = samples.value(t, t);
                assert!((value - cubic(t)).abs() < 1e-11);
                assert!((first - (-1.0 + 6.0 * t - 1.5 * t * t)).abs() < 1e-11);
                assert!((second - (6.0 - 3.0 * t)).abs() < 1e-11);
            }
        }
    }

    /// What defines the spline: it passes through the samples, its first two derivatives are continuous at all of them,
    /// the third at the second and the last but one.
    #[test]
    fn the_spline_is_the_one_defined() {
        let times = vec![0.0, 0.1, 0.25, 0.3, 0.5, 0.8, 1.0];
        let values = [0.0, 1.9, 2.9, 2.6, -1.1, -1.9, 2.0];
        let samples = Samples::cubic(times.clone(), &values).unwrap();
        for (index, (&t, &value)) in times.iter().zip(&values).enumerate() {
            let after = samples.value(t, t);
            // After the last sample its value is held.
            if index + 1 < times.len() {
                assert!((after[0] - value).abs() < 1e-12);
            }
            if index == 0 || index + 1 == times.len() {
                continue;
            }
            let before = samples.value(t, t - 1e-3);
            for order in 0..3 {
                let size = 1.0 + before[order].abs();
                assert!(
                    (before[order] - after[order]).abs() < 1e-11 * size,
                    "{t} {order}"
                );
            }
            let third = |interval: usize| samples.intervals[interval][3];
            if index == 1 || index + 2 == times.len() {
                assert!((third(index - 1) / third(index) - 1.0).abs() < 1e-10, "{t}");
            }
        }
    }

    #[test]
    fn few_samples_give_a_parabola_and_a_line() {
        let parabola = Samples::cubic(vec![0.0, 1.0, 3.0], &[0.0, 1.0, 9.0]).unwrap();
        assert!((parabola.value(2.0, 2.0)[0] - 4.0).abs() < 1e-14);
        assert!((parabola.value(2.0, 2.0)[2] - 2.0).abs() < 1e-14);
        let line = Samples::cubic(vec![0.0, 2.0], &[1.0, 5.0]).unwrap();
        assert_eq!(line.value(0.5, 0.5), [2.0, 2.0, 0.0]);
    }

    #[test]
    fn outside_the_ends_hold_and_inside_lines_are_straight() {
        let samples = Samples::linear(vec![1.0, 2.0, 4.0], &[3.0, 5.0, 1.0]).unwrap();
        assert_eq!(samples.value(0.0, 0.0), [3.0, 0.0, 0.0]);
        assert_eq!(samples.value(4.0, 4.0), [1.0, 0.0, 0.0]);
        assert_eq!(samples.value(3.0, 3.0), [3.0, -2.0, 0.0]);
        assert_eq!(samples.value(2.0, 1.5), [5.0, 2.0, 0.0]);
        assert_eq!(samples.breakpoints(), [1.0, 2.0, 4.0]);
        assert!(Samples::linear(vec![1.0, 1.0], &[0.0, 1.0]).is_none());
        assert!(Samples::cubic(vec![1.0], &[0.0]).is_none());
    }
}
