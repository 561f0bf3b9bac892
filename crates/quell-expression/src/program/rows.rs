//! Sums of products: chains of operations on registers that one instruction computes.

use super::code::{Code, Instruction};

/// A term ± a b of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Term {
    pub(super) a: u32,
    pub(super) b: u32,
    /// The sign bit of a term that is subtracted.
    pub(super) sign: u64,
}

/// What one dispatch computes.
#[derive(Debug, Clone)]
pub(super) enum Step {
    One(Instruction),
    /// The terms, added from the left, each rounded: products first, then the sum.
    Row(u32, Vec<Term>),
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
            Self::Row(_, terms) => terms.iter().flat_map(|term| [term.a, term.b]).collect(),
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
            Code::Multiply => vec![Term { a, b, sign: 0 }],
            Code::Square => vec![Term { a, b: a, sign: 0 }],
            Code::Add | Code::Subtract => {
                let mut take = |slot: u32, single: bool| {
                    let part = parts[slot as usize]
                        .take_if(|part| read[slot as usize] == 1 && (!single || part.len() == 1));
                    joined[slot as usize] |= part.is_some();
                    part.unwrap_or_else(|| {
                        vec![Term {
                            a: slot,
                            b: one,
                            sign: 0,
                        }]
                    })
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
                let sign = if adds { 0 } else { 1 << 63 };
                terms.extend(last.into_iter().map(|term| Term { sign, ..term }));
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
            Some(terms) => row(instruction, terms, one),
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
fn row(instruction: Instruction, terms: Vec<Term>, one: u32) -> Step {
    let single = |code: Code, operands: [u32; 3]| {
        let [a, b, c] = operands;
        Step::One(Instruction {
            code,
            target: instruction.target,
            operands: [a, b, c, 0],
        })
    };
    match *terms.as_slice() {
        [_] => Step::One(instruction),
        [first, second] if first.b == one && second.b == one => {
            let code = if second.sign == 0 {
                Code::Add
            } else {
                Code::Subtract
            };
            single(code, [first.a, second.a, 0])
        }
        [first, second] if second.b == one => {
            let code = if second.sign == 0 {
                Code::MultiplyAdd
            } else {
                Code::MultiplySubtract
            };
            single(code, [first.a, first.b, second.a])
        }
        [first, second] if first.b == one => {
            let code = if second.sign == 0 {
                Code::MultiplyAdd
            } else {
                Code::SubtractProduct
            };
            single(code, [second.a, second.b, first.a])
        }
        _ => Step::Row(instruction.target, terms),
    }
}
