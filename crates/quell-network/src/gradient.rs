//! Gradients and shares of parts by one reverse sweep.
//!
//! Every part of a network carries a stroke a · D_part and a force a · N_part, with one amplitude a for each pair (N, D).
//! The amplitude of the whole is one; a series pair (1, 2) hands down a1 = a N2 and a2 = a N1, a parallel pair a1 = a D2
//! and a2 = a D1. Nothing is divided, so poles and zeros inside the network are ordinary values. By Tellegen's theorem
//! the derivative of the dynamic stiffness K = N/D is dK/dvalue_i = (stroke_i / stroke)² dK_i/dvalue_i.

use num_complex::Complex64;

use crate::network::{Shape, quotient};
use crate::program::{Operation, Step, scale};
use crate::{Element, Network, Part, Workspace};

/// Relative distance at which a limit is taken where a network is 0/0 at an exact frequency (2^-26).
const NUDGE: f64 = 1.490_116_119_384_765_6e-8;

/// Stroke and force of a part of a network, and of the network itself, up to one common factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartShare {
    /// Relative displacement of the part.
    pub stroke: Complex64,
    /// Force through the part.
    pub force: Complex64,
    /// Force through the network (N).
    pub numerator: Complex64,
    /// Relative displacement of the network (D).
    pub denominator: Complex64,
}

impl Default for PartShare {
    fn default() -> Self {
        let zero = Complex64::ZERO;
        Self {
            stroke: zero,
            force: zero,
            numerator: zero,
            denominator: zero,
        }
    }
}

impl PartShare {
    /// Stroke of the part over the stroke of the network.
    #[must_use]
    pub fn stroke_share(&self) -> Complex64 {
        quotient(self.stroke, self.denominator)
    }

    /// Force through the part over the force through the network.
    #[must_use]
    pub fn force_share(&self) -> Complex64 {
        quotient(self.force, self.numerator)
    }
}

/// What the sweeps need of numbers.
trait Number: Copy {
    const ZERO: Self;
    const ONE: Self;
    fn sum(self, other: Self) -> Self;
    fn product(self, other: Self) -> Self;
}

impl Number for Complex64 {
    const ZERO: Self = Complex64::new(0.0, 0.0);
    const ONE: Self = Complex64::new(1.0, 0.0);

    #[inline]
    fn sum(self, other: Self) -> Self {
        self + other
    }

    #[inline]
    fn product(self, other: Self) -> Self {
        self * other
    }
}

/// The leading term c · s^p as s goes to zero; networks of positive values never cancel.
#[derive(Clone, Copy)]
struct Leading {
    coefficient: f64,
    power: u32,
}

impl Number for Leading {
    const ZERO: Self = Self {
        coefficient: 0.0,
        power: u32::MAX,
    };
    const ONE: Self = Self {
        coefficient: 1.0,
        power: 0,
    };

    fn sum(self, other: Self) -> Self {
        match self.power.cmp(&other.power) {
            std::cmp::Ordering::Less => self,
            std::cmp::Ordering::Greater => other,
            std::cmp::Ordering::Equal => Self {
                coefficient: self.coefficient + other.coefficient,
                power: self.power,
            },
        }
    }

    fn product(self, other: Self) -> Self {
        Self {
            coefficient: self.coefficient * other.coefficient,
            power: self.power.saturating_add(other.power),
        }
        .reduced()
    }
}

impl Leading {
    const fn reduced(self) -> Self {
        if self.coefficient == 0.0 {
            Self::ZERO
        } else {
            self
        }
    }

    /// The limit at s = 0 of this over another.
    fn over(self, other: Self) -> f64 {
        if self.coefficient == 0.0 || self.power > other.power {
            0.0
        } else if self.power == other.power {
            self.coefficient / other.coefficient
        } else {
            f64::INFINITY
        }
    }
}

/// Pairs of every step, ahead.
fn forward<T: Number>(
    steps: &[Step],
    element: impl Fn(&Step) -> T,
    rescale: impl Fn(&mut (T, T)) -> f64,
    pairs: &mut Vec<(T, T)>,
    scales: &mut Vec<f64>,
) {
    pairs.clear();
    scales.clear();
    for step in steps {
        let left = pairs.get(step.left).copied().unwrap_or((T::ZERO, T::ONE));
        let mut pair = match step.operation {
            Operation::Load => (element(step), T::ONE),
            Operation::SeriesElement => {
                let d = element(step);
                (left.0.product(d), left.0.sum(left.1.product(d)))
            }
            Operation::ParallelElement => (left.0.sum(left.1.product(element(step))), left.1),
            Operation::Series | Operation::Parallel => {
                let right = pairs.get(step.right).copied().unwrap_or((T::ZERO, T::ONE));
                let crossed = left.0.product(right.1).sum(right.0.product(left.1));
                if step.operation == Operation::Series {
                    (left.0.product(right.0), crossed)
                } else {
                    (crossed, left.1.product(right.1))
                }
            }
        };
        scales.push(if step.rescale {
            rescale(&mut pair)
        } else {
            1.0
        });
        pairs.push(pair);
    }
}

/// Amplitudes of every step and strokes of every element, backwards; the last step has amplitude one.
fn backward<T: Number>(
    steps: &[Step],
    element: impl Fn(&Step) -> T,
    rescale: impl Fn(T, f64) -> T,
    pairs: &[(T, T)],
    scales: &[f64],
    amplitudes: &mut Vec<T>,
    strokes: &mut [T],
) {
    amplitudes.clear();
    amplitudes.resize(steps.len(), T::ONE);
    for (index, step) in steps.iter().enumerate().rev() {
        let (Some(amplitude), Some(scale)) = (amplitudes.get(index), scales.get(index)) else {
            return;
        };
        let amplitude = if step.rescale {
            rescale(*amplitude, *scale)
        } else {
            *amplitude
        };
        let left = pairs.get(step.left).copied().unwrap_or((T::ZERO, T::ONE));
        let (to_left, stroke) = match step.operation {
            Operation::Load => (None, Some(amplitude)),
            Operation::SeriesElement => (
                Some(amplitude.product(element(step))),
                Some(amplitude.product(left.0)),
            ),
            Operation::ParallelElement => (Some(amplitude), Some(amplitude.product(left.1))),
            Operation::Series | Operation::Parallel => {
                let right = pairs.get(step.right).copied().unwrap_or((T::ZERO, T::ONE));
                let (to_left, to_right) = if step.operation == Operation::Series {
                    (amplitude.product(right.0), amplitude.product(left.0))
                } else {
                    (amplitude.product(right.1), amplitude.product(left.1))
                };
                if let Some(target) = amplitudes.get_mut(step.right) {
                    *target = to_right;
                }
                (Some(to_left), None)
            }
        };
        if let (Some(to_left), Some(target)) = (to_left, amplitudes.get_mut(step.left)) {
            *target = to_left;
        }
        if let (Some(stroke), Some(target)) = (stroke, strokes.get_mut(step.element)) {
            *target = stroke;
        }
    }
}

/// D of a unit element.
fn base(kind: Element, omega: f64) -> Complex64 {
    match kind.power() {
        0 => Complex64::ONE,
        1 => Complex64::new(0.0, omega),
        _ => Complex64::new(-omega * omega, 0.0),
    }
}

fn is_plain((numerator, denominator): (Complex64, Complex64)) -> bool {
    numerator.is_finite()
        && denominator.is_finite()
        && (numerator != Complex64::ZERO || denominator != Complex64::ZERO)
}

impl Network {
    /// Fills the workspace's pairs, amplitudes and strokes; returns N and D.
    fn sweep(
        &self,
        omega: f64,
        values: &[f64],
        workspace: &mut Workspace,
    ) -> (Complex64, Complex64) {
        let steps = &self.program.steps;
        let element = |step: &Step| {
            base(step.kind, omega) * values.get(step.element).copied().unwrap_or(f64::NAN)
        };
        let rescale = |pair: &mut (Complex64, Complex64)| {
            let scale = scale(pair.0.re, pair.0.im, pair.1.re, pair.1.im);
            pair.0 *= scale;
            pair.1 *= scale;
            scale
        };
        let Workspace {
            pairs,
            scales,
            amplitudes,
            strokes,
            ..
        } = workspace;
        forward(steps, element, rescale, pairs, scales);
        strokes.resize(self.elements.len(), Complex64::ZERO);
        backward(
            steps,
            element,
            |amplitude, scale| amplitude * scale,
            pairs,
            scales,
            amplitudes,
            strokes,
        );
        pairs
            .last()
            .copied()
            .unwrap_or((Complex64::ZERO, Complex64::ONE))
    }

    /// As [`Network::sweep`], a little beside a frequency at which the network is 0/0.
    fn sweep_beside(
        &self,
        omega: f64,
        values: &[f64],
        workspace: &mut Workspace,
    ) -> (f64, (Complex64, Complex64)) {
        let ratio = self.sweep(omega, values, workspace);
        if is_plain(ratio) || omega == 0.0 {
            return (omega, ratio);
        }
        let beside = omega * (1.0 + NUDGE);
        (beside, self.sweep(beside, values, workspace))
    }

    /// D(jω) = jω Y(jω) (N/m) and its derivatives with respect to every element's mechanical value.
    ///
    /// dD/dvalue_i = (stroke of i / stroke of the network)² · (1, jω or -ω²), by one reverse sweep. `out` has one place
    /// for each element. At ω = 0 the limit is given; at an isolated 0/0 the limit is taken at ω(1 + 2^-26); at a pole
    /// the derivatives are +∞. Nothing is allocated once the workspace has been used (save at a 0/0 at ω = 0).
    pub fn gradient(
        &self,
        omega: f64,
        values: &[f64],
        workspace: &mut Workspace,
        out: &mut [Complex64],
    ) -> Complex64 {
        let (numerator, denominator) = self.gradient_ratio(omega, values, workspace, out);
        let square = denominator * denominator;
        for derivative in out.iter_mut().take(self.elements.len()) {
            *derivative = if *derivative == Complex64::ZERO {
                Complex64::ZERO
            } else {
                quotient(*derivative, square)
            };
        }
        quotient(numerator, denominator)
    }

    /// N and D of the dynamic stiffness N/D, and D² d(N/D)/dvalue_i, all up to one common factor (its square for the
    /// latter): finite at poles as well.
    ///
    /// With x = x0 D/(D + G N) for a device on a port of receptance G, dx/dvalue_i = -x0 G out_i/(D + G N)².
    pub fn gradient_ratio(
        &self,
        omega: f64,
        values: &[f64],
        workspace: &mut Workspace,
        out: &mut [Complex64],
    ) -> (Complex64, Complex64) {
        let (at, ratio) = self.sweep_beside(omega, values, workspace);
        if omega == 0.0 && !is_plain(ratio) {
            let rest = self.at_rest(values);
            for ((target, stroke), element) in out.iter_mut().zip(&rest.strokes).zip(&self.elements)
            {
                let share = if element.element == Element::Spring {
                    stroke.over(rest.pair.1)
                } else {
                    0.0
                };
                *target = Complex64::new(share * share, 0.0);
            }
            return (
                Complex64::new(rest.pair.0.over(rest.pair.1), 0.0),
                Complex64::ONE,
            );
        }
        for ((target, stroke), element) in
            out.iter_mut().zip(&workspace.strokes).zip(&self.elements)
        {
            *target = stroke * stroke * base(element.element, at);
        }
        ratio
    }

    /// Stroke and force of several parts by one sweep.
    pub fn part_shares(
        &self,
        parts: &[Part],
        omega: f64,
        values: &[f64],
        workspace: &mut Workspace,
        out: &mut [PartShare],
    ) {
        let (at, ratio) = self.sweep_beside(omega, values, workspace);
        if omega == 0.0 && !is_plain(ratio) {
            let rest = self.at_rest(values);
            let real = |value: f64| Complex64::new(value, 0.0);
            for (part, target) in parts.iter().zip(out) {
                let (stroke, force) = self.stroke_and_force(
                    *part,
                    &rest.strokes,
                    &rest.amplitudes,
                    &rest.pairs,
                    |index| self.leading(index, values),
                );
                *target = PartShare {
                    stroke: real(stroke.over(rest.pair.1)),
                    force: real(force.over(rest.pair.1)),
                    numerator: real(rest.pair.0.over(rest.pair.1)),
                    denominator: Complex64::ONE,
                };
            }
            return;
        }
        for (part, target) in parts.iter().zip(out) {
            let Workspace {
                strokes,
                amplitudes,
                pairs,
                ..
            } = &*workspace;
            let (stroke, force) =
                self.stroke_and_force(*part, strokes, amplitudes, pairs, |index| {
                    let kind = self
                        .elements
                        .get(index)
                        .map_or(Element::Spring, |element| element.element);
                    base(kind, at) * values.get(index).copied().unwrap_or(f64::NAN)
                });
            *target = PartShare {
                stroke,
                force,
                numerator: ratio.0,
                denominator: ratio.1,
            };
        }
    }

    /// Relative displacement across a part over that across the network; +∞ where only the part moves.
    #[must_use]
    pub fn stroke_share(&self, part: Part, omega: f64, values: &[f64]) -> Complex64 {
        let mut share = [PartShare::default()];
        self.part_shares(&[part], omega, values, &mut Workspace::new(), &mut share);
        share[0].stroke_share()
    }

    /// Force through a part over that through the network.
    #[must_use]
    pub fn force_share(&self, part: Part, omega: f64, values: &[f64]) -> Complex64 {
        let mut share = [PartShare::default()];
        self.part_shares(&[part], omega, values, &mut Workspace::new(), &mut share);
        share[0].force_share()
    }

    fn stroke_and_force<T: Number>(
        &self,
        part: Part,
        strokes: &[T],
        amplitudes: &[T],
        pairs: &[(T, T)],
        element: impl Fn(usize) -> T,
    ) -> (T, T) {
        if let Some(Shape::Element(index)) = self.shapes.get(part.shape) {
            let stroke = strokes.get(*index).copied().unwrap_or(T::ZERO);
            return (stroke, stroke.product(element(*index)));
        }
        let step = self
            .program
            .step_of_shape
            .get(part.shape)
            .copied()
            .flatten();
        match step.and_then(|step| Some((amplitudes.get(step)?, pairs.get(step)?))) {
            Some((amplitude, pair)) => (amplitude.product(pair.1), amplitude.product(pair.0)),
            None => (T::ZERO, T::ZERO),
        }
    }

    fn leading(&self, index: usize, values: &[f64]) -> Leading {
        let power = self
            .elements
            .get(index)
            .map_or(0, |element| element.element.power() as u32);
        Leading {
            coefficient: values.get(index).copied().unwrap_or(f64::NAN),
            power,
        }
        .reduced()
    }

    /// Leading terms as s goes to zero.
    fn at_rest(&self, values: &[f64]) -> Rest {
        let steps = &self.program.steps;
        let element = |step: &Step| self.leading(step.element, values);
        let (mut pairs, mut scales, mut amplitudes) = (Vec::new(), Vec::new(), Vec::new());
        let mut strokes = vec![Leading::ZERO; self.elements.len()];
        forward(steps, element, |_| 1.0, &mut pairs, &mut scales);
        backward(
            steps,
            element,
            |amplitude, _| amplitude,
            &pairs,
            &scales,
            &mut amplitudes,
            &mut strokes,
        );
        let pair = pairs
            .last()
            .copied()
            .unwrap_or((Leading::ZERO, Leading::ONE));
        Rest {
            pair,
            pairs,
            amplitudes,
            strokes,
        }
    }
}

struct Rest {
    pair: (Leading, Leading),
    pairs: Vec<(Leading, Leading)>,
    amplitudes: Vec<Leading>,
    strokes: Vec<Leading>,
}
