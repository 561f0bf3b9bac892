//! Sums of products: chains of operations on registers that one instruction computes.

use super::code::{Code, Instruction};

/// A term ± (a b) c of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Term {
    pub(super) a: u32,
    pub(super) b: u32,
    pub(super) c: u32,
    /// The bits to turn over in its product: the sign of a term that is subtracted.
    pub(super) mask: u64,
}

impl Term {
    const fn of(factors: [u32; 3]) -> Self {
        let [a, b, c] = factors;
        Self { a, b, c, mask: 0 }
    }

    const fn negated(self) -> Self {
        Self {
            mask: self.mask ^ (1 << 63),
            ..self
        }
    }
}

/// What one dispatch computes.
#[derive(Debug, Clone)]
pub(super) enum Step {
    One(Instruction),
    /// The terms, added from the left, each rounded: products first, then the sum.
    Row(u32, Vec<Term>),
}

/// Whether terms of a row have three factors, not two; the third of others is the number 1.
pub(super) fn has_third_factors(terms: &[Term], one: u32) -> bool {
    terms.iter().any(|term| term.c != one)
}

impl Step {
    pub(super) const fn target(&self) -> u32 {
        match self {
            Self::One(instruction) => instruction.target,
            Self::Row(target, _) => *target,
        }
    }

    /// Every slot that it reads, perhaps more than once.
    pub(super) fn reads(&self) -> Vec<u32> {
        match self {
            Self::One(instruction) => instruction.reads().to_vec(),
            Self::Row(_, terms) => terms
                .iter()
                .flat_map(|term| [term.a, term.b, term.c])
                .collect(),
        }
    }
}

/// Joins sums, differences and products with the one that reads them into rows, which compute the same roundings in the
/// same order without a dispatch and a register for each. `one` is the slot of the number 1, `read` says how often a slot
/// is read.
pub(super) fn join(streams: Vec<Vec<Instruction>>, read: &[u32], one: u32) -> Vec<Vec<Step>> {
    let mut parts: Vec<Option<Vec<Term>>> = vec![None; read.len()];
    let mut joined = vec![false; read.len()];
    for instruction in streams.iter().flatten() {
        let [a, b, ..] = instruction.operands;
        let own = match instruction.code {
            Code::Multiply => {
                // (a b) c: one factor may be a product of two itself.
                let mut inner = |slot: u32| {
                    let part = parts[slot as usize].take_if(|part| {
                        read[slot as usize] == 1
                            && part.len() == 1
                            && part[0].b != one
                            && part[0].c == one
                    });
                    joined[slot as usize] |= part.is_some();
                    part.and_then(|part| part.first().copied())
                };
                vec![match inner(a) {
                    Some(term) => Term { c: b, ..term },
                    None => match inner(b) {
                        Some(term) => Term { c: a, ..term },
                        None => Term::of([a, b, one]),
                    },
                }]
            }
            Code::Negate => {
                let part = parts[a as usize]
                    .take_if(|part| read[a as usize] == 1 && part.len() == 1)
                    .and_then(|part| part.first().copied());
                joined[a as usize] |= part.is_some();
                let term = part.unwrap_or(Term::of([a, one, one]));
                vec![term.negated()]
            }
            Code::Add | Code::Subtract => {
                let mut take = |slot: u32, single: bool| {
                    let part = parts[slot as usize]
                        .take_if(|part| read[slot as usize] == 1 && (!single || part.len() == 1));
                    joined[slot as usize] |= part.is_some();
                    part.unwrap_or_else(|| vec![Term::of([slot, one, one])])
                };
                let adds = instruction.code == Code::Add;
                // A sum may begin with either side; of two chains one stays a term.
                let (mut terms, last) = {
                    let left = take(a, false);
                    if adds && left.len() == 1 {
                        (take(b, false), left)
                    } else {
                        (left, take(b, true))
                    }
                };
                terms.extend(
                    last.into_iter()
                        .map(|term| if adds { term } else { term.negated() }),
                );
                terms
            }
            _ => continue,
        };
        parts[instruction.target as usize] = Some(own);
    }
    let finish = |instruction: Instruction| {
        let slot = instruction.target as usize;
        if joined[slot] {
            return None;
        }
        Some(match parts[slot].take() {
            Some(terms) => row(instruction.target, terms, one),
            None => Step::One(instruction),
        })
    };
    let mut finish = finish;
    streams
        .into_iter()
        .map(|stream| stream.into_iter().filter_map(&mut finish).collect())
        .collect()
}

/// The shortest code for a sum.
fn row(target: u32, mut terms: Vec<Term>, one: u32) -> Step {
    let single = |code: Code, operands: [u32; 3]| {
        let [a, b, c] = operands;
        Step::One(Instruction {
            code,
            target,
            operands: [a, b, c, 0],
        })
    };
    // The first two commute to the last bit, so a row begins with what is added, if it can.
    if let [first, second, ..] = terms.as_mut_slice()
        && first.mask > second.mask
    {
        std::mem::swap(first, second);
    }
    match *terms.as_slice() {
        [only] if only.b == one && only.c == one => match only.mask {
            0 => single(Code::Copy, [only.a, 0, 0]),
            _ => single(Code::Negate, [only.a, 0, 0]),
        },
        [only] if only.mask == 0 && only.c == one => single(Code::Multiply, [only.a, only.b, 0]),
        [only] if only.mask == 0 => single(Code::Product, [only.a, only.b, only.c]),
        [first, second] if first.mask == 0 && !has_third_factors(&terms, one) => {
            let adds = second.mask == 0;
            match (first.b == one, second.b == one) {
                (true, true) if adds => single(Code::Add, [first.a, second.a, 0]),
                (true, true) => single(Code::Subtract, [first.a, second.a, 0]),
                (false, true) if adds => single(Code::MultiplyAdd, [first.a, first.b, second.a]),
                (false, true) => single(Code::MultiplySubtract, [first.a, first.b, second.a]),
                (true, false) if adds => single(Code::MultiplyAdd, [second.a, second.b, first.a]),
                (true, false) => single(Code::SubtractProduct, [second.a, second.b, first.a]),
                (false, false) => Step::Row(target, terms),
            }
        }
        _ => Step::Row(target, terms),
    }
}
