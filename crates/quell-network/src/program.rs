//! The evaluation of a network as a flat program of homogeneous operations.
//!
//! A pair (N, D) stands for the dynamic stiffness N/D. One kernel over `B` frequencies at a time serves the scalar form
//! (`B` = 1) and the grid, so that both give the same bits.

use num_complex::Complex64;

use crate::network::Shape;
use crate::{Element, Network, NetworkElement};

/// Frequencies evaluated together.
const LANES: usize = 8;

/// A pair may hold products of this many elements before it is scaled back to magnitude one.
const FACTOR_LIMIT: usize = 6;

/// Slots that any program gets along with: a group that needs n slots has at least 2^(n-1) elements.
const SLOT_LIMIT: usize = 40;

/// Slots for which the scalar form uses its small stack.
const SLOTS_SMALL: usize = 4;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Operation {
    /// slot ← element.
    Load,
    /// slot ← slot in series with an element.
    SeriesElement,
    /// slot ← slot beside an element.
    ParallelElement,
    /// slot ← slot in series with the next slot.
    Series,
    /// slot ← slot beside the next slot.
    Parallel,
}

/// One operation. Steps are in single-assignment form as well: each names the steps whose results it reads.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub(crate) operation: Operation,
    /// Where the result goes and the left operand is.
    slot: usize,
    /// The element read by the first three operations.
    pub(crate) element: usize,
    /// Its kind.
    pub(crate) kind: Element,
    /// The step of the left operand.
    pub(crate) left: usize,
    /// The step of the right operand, for the last two operations.
    pub(crate) right: usize,
    /// Whether the left (right) operand has D = 1.
    left_unit: bool,
    right_unit: bool,
    /// Whether the result is scaled back.
    pub(crate) rescale: bool,
}

/// A compiled network.
#[derive(Debug, Clone)]
pub(crate) struct Program {
    pub(crate) steps: Vec<Step>,
    /// The step that computes each shape; none for elements that are operands.
    pub(crate) step_of_shape: Vec<Option<usize>>,
    slots: usize,
    unit: bool,
}

/// What is known about a compiled operand.
#[derive(Clone, Copy)]
struct Operand {
    step: usize,
    unit: bool,
    factors: usize,
}

impl Program {
    pub(crate) fn compile(elements: &[NetworkElement], shapes: &[Shape]) -> Self {
        // Slots that each shape needs: the neediest child goes first (Sethi and Ullman 1970).
        let mut need: Vec<usize> = Vec::with_capacity(shapes.len());
        for shape in shapes {
            let slots = match shape {
                Shape::Element(_) => 1,
                Shape::Series(children) | Shape::Parallel(children) => {
                    let mut needs: Vec<usize> = children
                        .iter()
                        .filter(|child| !is_element(shapes, **child))
                        .map(|child| need.get(*child).copied().unwrap_or(1))
                        .collect();
                    needs.sort_unstable_by(|a, b| b.cmp(a));
                    needs
                        .iter()
                        .enumerate()
                        .map(|(index, need)| need + usize::from(index > 0))
                        .max()
                        .unwrap_or(1)
                }
            };
            need.push(slots);
        }
        let mut compiler = Compiler {
            elements,
            shapes,
            need: &need,
            steps: Vec::new(),
            step_of_shape: vec![None; shapes.len()],
        };
        let root = compiler.shape(shapes.len().saturating_sub(1), 0);
        let (steps, step_of_shape) = (compiler.steps, compiler.step_of_shape);
        let slots = steps.iter().map(|step| step.slot + 1).max().unwrap_or(1);
        Self {
            steps,
            step_of_shape,
            slots,
            unit: root.unit,
        }
    }

    /// N and D at one frequency.
    pub(crate) fn ratio(&self, omega: f64, values: &[f64]) -> (Complex64, Complex64) {
        let fast = self.scalar::<false>(omega, values);
        if is_plain(fast) {
            fast
        } else {
            self.scalar::<true>(omega, values)
        }
    }

    fn scalar<const CAREFUL: bool>(&self, omega: f64, values: &[f64]) -> (Complex64, Complex64) {
        let bases = Bases::<1>::new([omega]);
        let slot = if self.slots <= SLOTS_SMALL {
            let mut slots = [Slot::<1>::ZERO; SLOTS_SMALL];
            self.run::<1, CAREFUL>(&bases, values, &mut slots);
            slots[0]
        } else {
            let mut slots = [Slot::<1>::ZERO; SLOT_LIMIT];
            self.run::<1, CAREFUL>(&bases, values, &mut slots);
            slots[0]
        };
        let denominator = if self.unit {
            Complex64::ONE
        } else {
            Complex64::new(slot.dr[0], slot.di[0])
        };
        (Complex64::new(slot.nr[0], slot.ni[0]), denominator)
    }

    #[inline]
    fn run<const B: usize, const CAREFUL: bool>(
        &self,
        bases: &Bases<B>,
        values: &[f64],
        slots: &mut [Slot<B>],
    ) {
        for step in &self.steps {
            let value = values.get(step.element).copied().unwrap_or(f64::NAN);
            let (below, above) = slots.split_at_mut((step.slot + 1).min(slots.len()));
            let Some(slot) = below.last_mut() else { return };
            match (step.operation, step.kind) {
                (Operation::Load, Element::Damper) => slot.load::<true>(&bases.damper, value),
                (Operation::Load, kind) => slot.load::<false>(bases.real(kind), value),
                (Operation::SeriesElement, Element::Damper) => {
                    slot.series_element::<true>(&bases.damper, value, step.left_unit);
                }
                (Operation::SeriesElement, kind) => {
                    slot.series_element::<false>(bases.real(kind), value, step.left_unit);
                }
                (Operation::ParallelElement, Element::Damper) => {
                    slot.parallel_element::<true>(&bases.damper, value, step.left_unit);
                }
                (Operation::ParallelElement, kind) => {
                    slot.parallel_element::<false>(bases.real(kind), value, step.left_unit);
                }
                (Operation::Series, _) => {
                    let Some(other) = above.first() else { return };
                    slot.series(other, step.left_unit, step.right_unit);
                }
                (Operation::Parallel, _) => {
                    let Some(other) = above.first() else { return };
                    slot.parallel(other, step.left_unit, step.right_unit);
                }
            }
            let unit = step.result_is_unit();
            if CAREFUL && !unit {
                slot.resolve(matches!(
                    step.operation,
                    Operation::Series | Operation::SeriesElement
                ));
            }
            if (step.rescale || CAREFUL) && !unit {
                slot.rescale();
            }
        }
    }
}

impl Step {
    /// Whether the result has D = 1, known from the structure; its D is then not written.
    pub(crate) fn result_is_unit(&self) -> bool {
        match self.operation {
            Operation::Load => true,
            Operation::ParallelElement => self.left_unit,
            Operation::Parallel => self.left_unit && self.right_unit,
            Operation::SeriesElement | Operation::Series => false,
        }
    }
}

/// Whether N/D can be used as it is: finite, and not 0/0.
fn is_plain((numerator, denominator): (Complex64, Complex64)) -> bool {
    numerator.is_finite()
        && denominator.is_finite()
        && (numerator != Complex64::ZERO || denominator != Complex64::ZERO)
}

fn is_element(shapes: &[Shape], shape: usize) -> bool {
    matches!(shapes.get(shape), Some(Shape::Element(_)) | None)
}

struct Compiler<'a> {
    elements: &'a [NetworkElement],
    shapes: &'a [Shape],
    need: &'a [usize],
    steps: Vec<Step>,
    step_of_shape: Vec<Option<usize>>,
}

impl Compiler<'_> {
    fn push(
        &mut self,
        operation: Operation,
        slot: usize,
        element: usize,
        left: Operand,
        right: Operand,
    ) -> Operand {
        let step = self.steps.len();
        let mut next = Step {
            operation,
            slot,
            element,
            kind: self
                .elements
                .get(element)
                .map_or(Element::Spring, |element| element.element),
            left: left.step,
            right: right.step,
            left_unit: left.unit,
            right_unit: right.unit,
            rescale: false,
        };
        let unit = next.result_is_unit();
        let mut factors = if unit {
            1
        } else {
            left.factors + right.factors
        };
        if factors > FACTOR_LIMIT {
            next.rescale = true;
            factors = 1;
        }
        self.steps.push(next);
        Operand {
            step,
            unit,
            factors,
        }
    }

    fn element(&mut self, shape: usize) -> usize {
        match self.shapes.get(shape) {
            Some(Shape::Element(element)) => *element,
            _ => usize::MAX,
        }
    }

    /// Computes a shape into a slot.
    fn shape(&mut self, shape: usize, slot: usize) -> Operand {
        let none = Operand {
            step: 0,
            unit: true,
            factors: 0,
        };
        let leaf = Operand {
            step: 0,
            unit: true,
            factors: 1,
        };
        let shapes = self.shapes;
        let (series, children) = match shapes.get(shape) {
            Some(Shape::Series(children)) => (true, children),
            Some(Shape::Parallel(children)) => (false, children),
            Some(Shape::Element(_)) | None => {
                let element = self.element(shape);
                let loaded = self.push(Operation::Load, slot, element, none, none);
                if let Some(entry) = self.step_of_shape.get_mut(shape) {
                    *entry = Some(loaded.step);
                }
                return Operand {
                    factors: 1,
                    ..loaded
                };
            }
        };
        let (mut groups, leaves): (Vec<usize>, Vec<usize>) = children
            .iter()
            .copied()
            .partition(|child| !is_element(shapes, *child));
        let need = self.need;
        groups.sort_by_key(|group| std::cmp::Reverse(need.get(*group).copied().unwrap_or(1)));
        let (join, join_element) = if series {
            (Operation::Series, Operation::SeriesElement)
        } else {
            (Operation::Parallel, Operation::ParallelElement)
        };
        let mut result: Option<Operand> = None;
        for group in groups {
            result = Some(match result {
                None => self.shape(group, slot),
                Some(left) => {
                    let right = self.shape(group, slot + 1);
                    self.push(join, slot, usize::MAX, left, right)
                }
            });
        }
        for child in leaves {
            let element = self.element(child);
            result = Some(match result {
                None => self.push(Operation::Load, slot, element, none, none),
                Some(left) => self.push(join_element, slot, element, left, leaf),
            });
        }
        let result = result.unwrap_or(none);
        if let Some(entry) = self.step_of_shape.get_mut(shape) {
            *entry = Some(result.step);
        }
        result
    }
}

/// D of a unit element of each kind at `B` frequencies: 1, ω (times j), -ω².
struct Bases<const B: usize> {
    spring: [f64; B],
    damper: [f64; B],
    inerter: [f64; B],
}

impl<const B: usize> Bases<B> {
    #[inline]
    fn new(omega: [f64; B]) -> Self {
        Self {
            spring: [1.0; B],
            damper: omega,
            inerter: omega.map(|omega| -omega * omega),
        }
    }

    #[inline]
    fn real(&self, kind: Element) -> &[f64; B] {
        if kind.power() == 0 {
            &self.spring
        } else {
            &self.inerter
        }
    }
}

/// Real and imaginary parts of N and D at `B` frequencies.
#[derive(Debug, Clone, Copy)]
struct Slot<const B: usize> {
    nr: [f64; B],
    ni: [f64; B],
    dr: [f64; B],
    di: [f64; B],
}

#[expect(
    clippy::needless_range_loop,
    reason = "lanes are indexed alike in several arrays of constant length"
)]
impl<const B: usize> Slot<B> {
    const ZERO: Self = Self {
        nr: [0.0; B],
        ni: [0.0; B],
        dr: [0.0; B],
        di: [0.0; B],
    };

    #[inline]
    fn load<const IMAGINARY: bool>(&mut self, base: &[f64; B], value: f64) {
        for l in 0..B {
            let d = value * base[l];
            if IMAGINARY {
                self.nr[l] = 0.0;
                self.ni[l] = d;
            } else {
                self.nr[l] = d;
                self.ni[l] = 0.0;
            }
        }
    }

    /// N d / (N + D d).
    #[inline]
    fn series_element<const IMAGINARY: bool>(&mut self, base: &[f64; B], value: f64, unit: bool) {
        if unit {
            for l in 0..B {
                let d = value * base[l];
                let (nr, ni) = (self.nr[l], self.ni[l]);
                if IMAGINARY {
                    (self.dr[l], self.di[l]) = (nr, ni + d);
                    (self.nr[l], self.ni[l]) = (-ni * d, nr * d);
                } else {
                    (self.dr[l], self.di[l]) = (nr + d, ni);
                    (self.nr[l], self.ni[l]) = (nr * d, ni * d);
                }
            }
        } else {
            for l in 0..B {
                let d = value * base[l];
                let (nr, ni, dr, di) = (self.nr[l], self.ni[l], self.dr[l], self.di[l]);
                if IMAGINARY {
                    (self.dr[l], self.di[l]) = (nr - di * d, ni + dr * d);
                    (self.nr[l], self.ni[l]) = (-ni * d, nr * d);
                } else {
                    (self.dr[l], self.di[l]) = (nr + dr * d, ni + di * d);
                    (self.nr[l], self.ni[l]) = (nr * d, ni * d);
                }
            }
        }
    }

    /// (N + D d) / D.
    #[inline]
    fn parallel_element<const IMAGINARY: bool>(&mut self, base: &[f64; B], value: f64, unit: bool) {
        if unit {
            let part = if IMAGINARY {
                &mut self.ni
            } else {
                &mut self.nr
            };
            for l in 0..B {
                part[l] += value * base[l];
            }
        } else {
            for l in 0..B {
                let d = value * base[l];
                if IMAGINARY {
                    self.nr[l] -= self.di[l] * d;
                    self.ni[l] += self.dr[l] * d;
                } else {
                    self.nr[l] += self.dr[l] * d;
                    self.ni[l] += self.di[l] * d;
                }
            }
        }
    }

    /// N1 N2 / (N1 D2 + N2 D1).
    #[inline]
    fn series(&mut self, other: &Self, unit: bool, other_unit: bool) {
        let (n1, n2) = ((self.nr, self.ni), (other.nr, other.ni));
        (self.dr, self.di) = cross(
            (self.nr, self.ni),
            (self.dr, self.di),
            unit,
            n2,
            (other.dr, other.di),
            other_unit,
        );
        (self.nr, self.ni) = product(n1, n2);
    }

    /// (N1 D2 + N2 D1) / (D1 D2).
    #[inline]
    fn parallel(&mut self, other: &Self, unit: bool, other_unit: bool) {
        let (d1, d2) = ((self.dr, self.di), (other.dr, other.di));
        (self.nr, self.ni) = cross(
            (self.nr, self.ni),
            d1,
            unit,
            (other.nr, other.ni),
            d2,
            other_unit,
        );
        (self.dr, self.di) = match (unit, other_unit) {
            (_, true) => d1,
            (true, false) => d2,
            (false, false) => product(d1, d2),
        };
    }

    /// Scales N and D by the power of two that brings the largest part near one; exact.
    #[inline]
    fn rescale(&mut self) {
        for l in 0..B {
            let scale = scale(self.nr[l], self.ni[l], self.dr[l], self.di[l]);
            self.nr[l] *= scale;
            self.ni[l] *= scale;
            self.dr[l] *= scale;
            self.di[l] *= scale;
        }
    }

    /// Gives 0/0 its meaning: two free branches in series are free, two rigid ones side by side rigid.
    fn resolve(&mut self, series: bool) {
        for l in 0..B {
            if self.nr[l] == 0.0 && self.ni[l] == 0.0 && self.dr[l] == 0.0 && self.di[l] == 0.0 {
                if series {
                    self.dr[l] = 1.0;
                } else {
                    self.nr[l] = 1.0;
                }
            }
        }
    }
}

/// The power of two that brings the largest of four numbers near one.
#[inline]
pub(crate) fn scale(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let largest = larger(larger(a.abs(), b.abs()), larger(c.abs(), d.abs()));
    let exponent = largest.to_bits() & 0x7FF0_0000_0000_0000;
    f64::from_bits(0x7FE0_0000_0000_0000 - exponent.min(0x7FD0_0000_0000_0000))
}

type Lanes<const B: usize> = ([f64; B], [f64; B]);

#[inline]
fn product<const B: usize>(a: Lanes<B>, b: Lanes<B>) -> Lanes<B> {
    let mut result = ([0.0; B], [0.0; B]);
    for l in 0..B {
        result.0[l] = a.0[l] * b.0[l] - a.1[l] * b.1[l];
        result.1[l] = a.0[l] * b.1[l] + a.1[l] * b.0[l];
    }
    result
}

/// N1 D2 + N2 D1.
#[inline]
fn cross<const B: usize>(
    n1: Lanes<B>,
    d1: Lanes<B>,
    unit1: bool,
    n2: Lanes<B>,
    d2: Lanes<B>,
    unit2: bool,
) -> Lanes<B> {
    let a = if unit2 { n1 } else { product(n1, d2) };
    let b = if unit1 { n2 } else { product(n2, d1) };
    let mut result = a;
    for l in 0..B {
        result.0[l] += b.0[l];
        result.1[l] += b.1[l];
    }
    result
}

/// Memory that evaluations reuse; one per thread.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    slots: Vec<Slot<LANES>>,
    pub(crate) pairs: Vec<(Complex64, Complex64)>,
    pub(crate) scales: Vec<f64>,
    pub(crate) amplitudes: Vec<Complex64>,
    pub(crate) strokes: Vec<Complex64>,
}

impl Workspace {
    /// An empty workspace; it grows at first use and is then reused without allocation.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }
}

/// N and D on a grid of frequencies, real and imaginary parts apart.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RatioGrid {
    /// Re N.
    pub numerator_re: Vec<f64>,
    /// Im N.
    pub numerator_im: Vec<f64>,
    /// Re D.
    pub denominator_re: Vec<f64>,
    /// Im D.
    pub denominator_im: Vec<f64>,
}

impl RatioGrid {
    /// An empty grid; it takes its length at first use.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of frequencies.
    #[must_use]
    pub fn len(&self) -> usize {
        self.numerator_re.len()
    }

    /// Whether there is no frequency.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.numerator_re.is_empty()
    }

    /// N and D at a frequency's index.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<(Complex64, Complex64)> {
        Some((
            Complex64::new(
                *self.numerator_re.get(index)?,
                *self.numerator_im.get(index)?,
            ),
            Complex64::new(
                *self.denominator_re.get(index)?,
                *self.denominator_im.get(index)?,
            ),
        ))
    }

    fn resize(&mut self, length: usize) {
        for part in [
            &mut self.numerator_re,
            &mut self.numerator_im,
            &mut self.denominator_re,
            &mut self.denominator_im,
        ] {
            part.resize(length, 0.0);
        }
    }
}

impl Network {
    /// N and D at every angular frequency ω of a grid (rad/s), as by [`Network::ratio`] to the last bit.
    ///
    /// Nothing is allocated once `workspace` and `out` have been used at this size.
    pub fn ratio_grid(
        &self,
        omegas: &[f64],
        values: &[f64],
        workspace: &mut Workspace,
        out: &mut RatioGrid,
    ) {
        let program = &self.program;
        out.resize(omegas.len());
        if workspace.slots.len() < program.slots {
            workspace.slots.resize(program.slots, Slot::ZERO);
        }
        let targets = out
            .numerator_re
            .chunks_mut(LANES)
            .zip(out.numerator_im.chunks_mut(LANES))
            .zip(
                out.denominator_re
                    .chunks_mut(LANES)
                    .zip(out.denominator_im.chunks_mut(LANES)),
            );
        for (chunk, ((nr, ni), (dr, di))) in omegas.chunks(LANES).zip(targets) {
            // A short last block is filled up with ω = 1.
            let mut block = [1.0; LANES];
            for (lane, omega) in block.iter_mut().zip(chunk) {
                *lane = *omega;
            }
            program.run::<LANES, false>(&Bases::new(block), values, &mut workspace.slots);
            let Some(slot) = workspace.slots.first_mut() else {
                return;
            };
            if program.unit {
                (slot.dr, slot.di) = ([1.0; LANES], [0.0; LANES]);
            }
            let length = chunk.len();
            nr.copy_from_slice(slot.nr.get(..length).unwrap_or_default());
            ni.copy_from_slice(slot.ni.get(..length).unwrap_or_default());
            dr.copy_from_slice(slot.dr.get(..length).unwrap_or_default());
            di.copy_from_slice(slot.di.get(..length).unwrap_or_default());
            let mut odd = false;
            for l in 0..LANES {
                let sum = slot.nr[l].abs() + slot.ni[l].abs() + slot.dr[l].abs() + slot.di[l].abs();
                odd |= !(sum > 0.0 && sum < f64::INFINITY);
            }
            if odd {
                for (l, omega) in chunk.iter().enumerate() {
                    let (numerator, denominator) = program.ratio(*omega, values);
                    (nr[l], ni[l], dr[l], di[l]) =
                        (numerator.re, numerator.im, denominator.re, denominator.im);
                }
            }
        }
    }
}
