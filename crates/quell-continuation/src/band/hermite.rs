//! Cubics through values and slopes at both ends of [0, 1].

/// f(0), f(1) and the slopes there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic {
    pub(super) ends: [f64; 2],
    pub(super) slopes: [f64; 2],
}

impl Cubic {
    /// Coefficients of 1, t, t², t³.
    fn coefficients(&self) -> [f64; 4] {
        let ([a, b], [c, d]) = (self.ends, self.slopes);
        [a, c, 3.0 * (b - a) - 2.0 * c - d, 2.0 * (a - b) + c + d]
    }

    pub(super) fn value(&self, t: f64) -> f64 {
        let [a, b, c, d] = self.coefficients();
        a + t * (b + t * (c + t * d))
    }

    /// f″.
    pub(super) fn curvature(&self, t: f64) -> f64 {
        let [_, _, c, d] = self.coefficients();
        2.0 * c + 6.0 * d * t
    }

    /// Stationary points in (0, 1).
    fn stationary(&self) -> impl Iterator<Item = f64> {
        let [_, b, c, d] = self.coefficients();
        // 3 d t² + 2 c t + b = 0, without cancellation.
        let discriminant = c * c - 3.0 * d * b;
        let roots = if discriminant < 0.0 {
            [f64::NAN; 2]
        } else {
            let w = -(c + discriminant.sqrt().copysign(c));
            [w / (3.0 * d), b / w]
        };
        roots.into_iter().filter(|t| *t > 0.0 && *t < 1.0)
    }

    /// The largest value on [0, 1] and where it is.
    pub(super) fn highest(&self) -> (f64, f64) {
        let mut best = if self.ends[0] >= self.ends[1] {
            (0.0, self.ends[0])
        } else {
            (1.0, self.ends[1])
        };
        for t in self.stationary() {
            let value = self.value(t);
            if value > best.1 {
                best = (t, value);
            }
        }
        best
    }

    /// The least value on [0, 1] and where it is.
    pub(super) fn lowest(&self) -> (f64, f64) {
        let negated = Self {
            ends: self.ends.map(|x| -x),
            slopes: self.slopes.map(|x| -x),
        };
        let (t, value) = negated.highest();
        (t, -value)
    }

    /// A local maximum inside, if there is one.
    pub(super) fn crest(&self) -> Option<f64> {
        self.stationary().find(|t| self.curvature(*t) < 0.0)
    }

    /// A zero of a cubic whose ends differ in sign, by bisection: it only starts Newton's method.
    pub(super) fn zero(&self) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if (self.value(middle) > 0.0) == (self.ends[0] > 0.0) {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// All zeros in (0, 1), by bisection between its ends and stationary points.
    pub(super) fn zeros(&self) -> Vec<f64> {
        let mut parts: Vec<f64> = std::iter::once(0.0)
            .chain(self.stationary())
            .chain([1.0])
            .collect();
        parts.sort_by(f64::total_cmp);
        let mut found = Vec::new();
        for pair in parts.windows(2) {
            let (mut low, mut high) = (pair[0], pair[1]);
            let rises = self.value(high) > 0.0;
            if (self.value(low) > 0.0) == rises {
                continue;
            }
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if (self.value(middle) > 0.0) == rises {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            found.push(0.5 * (low + high));
        }
        found
    }

    /// How far the two tangents are apart in the middle: of third order in the length of the interval.
    pub(super) fn mismatch(&self) -> f64 {
        (self.ends[0] + 0.5 * self.slopes[0] - self.ends[1] + 0.5 * self.slopes[1]).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// t³ - 1.5 t² + 0.5 t + 0.1 has a crest at (3 - √3)/6 and its least value at (3 + √3)/6.
    #[test]
    fn extremes_of_a_known_cubic() {
        let f = |t: f64| t * t * t - 1.5 * t * t + 0.5 * t + 0.1;
        let cubic = Cubic {
            ends: [f(0.0), f(1.0)],
            slopes: [0.5, 0.5],
        };
        let crest = (3.0 - 3.0_f64.sqrt()) / 6.0;
        assert!((cubic.crest().unwrap() - crest).abs() < 1e-14);
        assert!((cubic.highest().1 - f(crest)).abs() < 1e-14);
        assert!((cubic.lowest().0 - (1.0 - crest)).abs() < 1e-14);
        assert!((cubic.value(0.3) - f(0.3)).abs() < 1e-14);
    }

    /// (t - 0.2) (t - 0.5) (t - 0.9) has its zeros where it says, to the bisection's 2^-40.
    #[test]
    fn all_zeros_of_a_known_cubic() {
        let f = |t: f64| (t - 0.2) * (t - 0.5) * (t - 0.9);
        let slope = |t: f64| 3.0 * t * t - 3.2 * t + 0.73;
        let cubic = Cubic {
            ends: [f(0.0), f(1.0)],
            slopes: [slope(0.0), slope(1.0)],
        };
        let zeros = cubic.zeros();
        assert_eq!(zeros.len(), 3);
        for (found, known) in zeros.iter().zip([0.2, 0.5, 0.9]) {
            assert!((found - known).abs() < 1e-11);
        }
    }
}
