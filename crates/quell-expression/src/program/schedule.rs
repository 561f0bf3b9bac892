//! The order of instructions: like after like.
//!
//! What follows its like is run without a decision, and a processor that guesses a decision wrongly loses more time than
//! most operations take. Sums of the same length count as like.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use super::code::Code;
use super::rows::{Step, has_third_factors};

/// Reorders a stream so that steps of the same code follow one another, each still after what it reads.
///
/// Fewest runs are a hard problem, so the best of a few rules is taken, from the front and from the back.
pub(super) fn schedule(steps: Vec<Step>, slots: usize, one: u32) -> Vec<Step> {
    let graph = Precedence::of(&steps, slots, one);
    let forward = [Rule::Longest, Rule::Completest].map(|rule| graph.order(rule));
    let backward = [Rule::Longest, Rule::Completest].map(|rule| {
        let (runs, mut order) = graph.reversed().order(rule);
        order.reverse();
        (runs, order)
    });
    let best = forward
        .into_iter()
        .chain(backward)
        .min_by_key(|(runs, _)| *runs);
    let mut steps: Vec<Option<Step>> = steps.into_iter().map(Some).collect();
    let (_, order) = best.unwrap_or_default();
    let step = |place: usize| steps.get_mut(place).and_then(Option::take);
    order.into_iter().filter_map(step).collect()
}

/// Which of the codes that could come next does.
#[derive(Clone, Copy)]
enum Rule {
    /// That of which most can be run.
    Longest,
    /// That of which the largest part of what is left can be run.
    Completest,
}

/// What must come before what.
struct Precedence {
    /// Number of each step's code.
    codes: Vec<usize>,
    before: Vec<Vec<usize>>,
    after: Vec<Vec<usize>>,
}

impl Precedence {
    fn of(steps: &[Step], slots: usize, one: u32) -> Self {
        let mut places: Vec<Option<usize>> = vec![None; slots];
        for (place, step) in steps.iter().enumerate() {
            places[step.target() as usize] = Some(place);
        }
        let mut after: Vec<Vec<usize>> = vec![Vec::new(); steps.len()];
        let mut before = Vec::with_capacity(steps.len());
        let mut numbers = BTreeMap::new();
        let mut codes = Vec::with_capacity(steps.len());
        for (place, step) in steps.iter().enumerate() {
            let reads = step.reads().into_iter();
            let mut reads: Vec<usize> = reads.filter_map(|read| places[read as usize]).collect();
            reads.sort_unstable();
            reads.dedup();
            for read in &reads {
                after[*read].push(place);
            }
            before.push(reads);
            let code = match step {
                Step::One(instruction) => (instruction.code as u8, 0),
                Step::Row(_, terms) if has_third_factors(terms, one) => {
                    (Code::ProductRow as u8, terms.len())
                }
                Step::Row(_, terms) => (Code::Row as u8, terms.len()),
            };
            let next = numbers.len();
            codes.push(*numbers.entry(code).or_insert(next));
        }
        Self {
            codes,
            before,
            after,
        }
    }

    /// The same with time turned round.
    fn reversed(&self) -> Self {
        Self {
            codes: self.codes.clone(),
            before: self.after.clone(),
            after: self.before.clone(),
        }
    }

    /// Number of runs and the order of steps by a rule.
    fn order(&self, rule: Rule) -> (usize, Vec<usize>) {
        let count = self.codes.iter().max().map_or(0, |code| code + 1);
        let mut waiting: Vec<usize> = self.before.iter().map(Vec::len).collect();
        let mut left = vec![0_usize; count];
        let mut ready: Vec<Vec<usize>> = vec![Vec::new(); count];
        for (place, code) in self.codes.iter().enumerate() {
            left[*code] += 1;
            if waiting[place] == 0 {
                ready[*code].push(place);
            }
        }
        let mut order: Vec<usize> = Vec::with_capacity(self.codes.len());
        let mut runs = 0;
        loop {
            let candidates = (0..count).filter(|code| !ready[*code].is_empty());
            let best = candidates.max_by_key(|code| {
                let length = self.cascade(*code, &ready[*code], &mut waiting).len();
                let key = match rule {
                    Rule::Longest => (length, 0),
                    // In thousandths.
                    Rule::Completest => (1000 * length / left[*code].max(1), length),
                };
                (key, Reverse(*code))
            });
            let Some(code) = best else {
                return (runs, order);
            };
            let run = self.cascade(code, &ready[code], &mut waiting);
            ready[code].clear();
            left[code] -= run.len();
            for place in &run {
                for reader in &self.after[*place] {
                    waiting[*reader] -= 1;
                    if waiting[*reader] == 0 && self.codes[*reader] != code {
                        ready[self.codes[*reader]].push(*reader);
                    }
                }
            }
            order.extend(run);
            runs += 1;
        }
    }

    /// The steps of a code that can be run now, those included that the run itself makes ready.
    fn cascade(&self, code: usize, ready: &[usize], waiting: &mut [usize]) -> Vec<usize> {
        let mut run = ready.to_vec();
        let mut next = 0;
        while let Some(place) = run.get(next).copied() {
            for reader in self.after[place]
                .iter()
                .filter(|reader| self.codes[**reader] == code)
            {
                waiting[*reader] -= 1;
                if waiting[*reader] == 0 {
                    run.push(*reader);
                }
            }
            next += 1;
        }
        for place in &run {
            for reader in self.after[*place]
                .iter()
                .filter(|reader| self.codes[**reader] == code)
            {
                waiting[*reader] += 1;
            }
        }
        run
    }
}
