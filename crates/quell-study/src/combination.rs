//! Criteria that are expressions of other criteria: weighted sums, the worst of several runs.

use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::{Fault, Source};
use quell_expression::{
    Dimension, Expression, ExpressionError, Node, Quantity, Scope, Tape, TapeBuilder,
};

use crate::study::Criterion;

/// An expression over the values of other criteria.
#[derive(Debug)]
pub(crate) struct Combination {
    /// Names of the criteria, in the order of the tape's inputs.
    pub parts: Vec<String>,
    /// The arithmetic.
    pub tape: Tape,
    /// The dimension of the whole.
    pub dimension: Dimension,
    /// Where the whole is the largest of terms that take one criterion each (or one such term): the criterion of each, by
    /// place among the parts, and the term. Empty otherwise.
    pub terms: Vec<(usize, Tape)>,
}

impl Combination {
    /// Compiles an expression over criteria of the given dimensions and constants.
    ///
    /// # Errors
    /// A name that is neither, or dimensions that do not fit.
    pub(crate) fn new(
        value: &Expression,
        criteria: &[(&str, Dimension)],
        constants: &dyn Scope,
    ) -> Result<Self, ExpressionError> {
        let names = value.names();
        let parts: Vec<(&str, Dimension)> = criteria
            .iter()
            .filter(|(name, _)| names.contains(name))
            .copied()
            .collect();
        let scope = WithCriteria {
            criteria: &parts,
            outer: constants,
        };
        let dimension = value.evaluate(&scope)?.dimension;
        let inputs: Vec<String> = parts.iter().map(|(name, _)| (*name).to_owned()).collect();
        let alternatives = match &value.node {
            Node::Call {
                function,
                arguments,
                ..
            } if function == "max" => arguments.iter().collect(),
            _ => vec![value],
        };
        let mut terms = Vec::new();
        for alternative in alternatives {
            let names = alternative.names();
            let mut own = inputs.iter().enumerate();
            let mut own = own
                .by_ref()
                .filter(|(_, name)| names.contains(&name.as_str()));
            let (Some((place, name)), None) = (own.next(), own.next()) else {
                terms.clear();
                break;
            };
            let mut builder = TapeBuilder::new(std::slice::from_ref(name));
            builder.add(alternative, constants)?;
            terms.push((place, builder.build()));
        }
        let mut builder = TapeBuilder::new(&inputs);
        builder.add(value, constants)?;
        Ok(Self {
            parts: inputs,
            tape: builder.build(),
            dimension,
            terms,
        })
    }
}

/// Criteria, as one in their dimension, before constants.
struct WithCriteria<'a> {
    criteria: &'a [(&'a str, Dimension)],
    outer: &'a dyn Scope,
}

impl Scope for WithCriteria<'_> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        match self.criteria.iter().find(|(known, _)| *known == name) {
            Some((_, dimension)) => Some(Quantity::new(1.0, *dimension)),
            None => self.outer.quantity(name),
        }
    }

    fn names(&self) -> Vec<&str> {
        let mut names = self.outer.names();
        names.extend(self.criteria.iter().map(|(name, _)| *name));
        names
    }
}

/// The criteria of an expression of criteria, in the order of the study.
pub(crate) fn parts<'a>(
    criterion: &Criterion,
    criteria: &'a IndexMap<String, Criterion>,
) -> Vec<&'a str> {
    if criterion.run.is_some() || criterion.band.is_some() {
        return Vec::new();
    }
    let names = criterion.value.names();
    criteria
        .keys()
        .map(String::as_str)
        .filter(|name| names.contains(name))
        .collect()
}

/// Names with all criteria that they are made of, each after what it is made of; one that is taken over several points
/// has its parts there, unless it is `within`.
pub(crate) fn with_parts<'a>(
    names: impl Iterator<Item = &'a str>,
    criteria: &'a IndexMap<String, Criterion>,
    within: Option<&str>,
) -> Vec<&'a str> {
    let mut found: Vec<&str> = Vec::new();
    let mut waiting: Vec<(&str, bool)> = names.map(|name| (name, false)).collect();
    waiting.reverse();
    while let Some((name, entered)) = waiting.pop() {
        if found.contains(&name) {
            continue;
        }
        if entered {
            found.push(name);
            continue;
        }
        waiting.push((name, true));
        let elsewhere =
            |criterion: &&Criterion| criterion.variation.is_some() && within != Some(name);
        if let Some(criterion) = criteria.get(name).filter(|found| !elsewhere(found)) {
            let parts = parts(criterion, criteria);
            waiting.extend(parts.into_iter().rev().map(|part| (part, false)));
        }
    }
    found
}

/// Refuses criteria that are made of themselves.
///
/// # Errors
/// The first such criterion, with the way round.
pub(crate) fn refuse_cycles(
    criteria: &IndexMap<String, Criterion>,
    source: &Arc<Source>,
) -> Result<(), Fault> {
    // 1: on the way from the root, 2: sound.
    let mut known: IndexMap<&str, u8> = IndexMap::new();
    for root in criteria.keys() {
        let mut way: Vec<(&str, Vec<&str>)> = Vec::new();
        let mut next = Some(root.as_str());
        loop {
            if let Some(name) = next.take() {
                match known.get(name) {
                    Some(2) => {}
                    Some(_) => {
                        let from = way.iter().position(|(known, _)| *known == name);
                        let round: Vec<String> = way
                            .iter()
                            .skip(from.unwrap_or(0))
                            .map(|(name, _)| format!("`{name}`"))
                            .chain(std::iter::once(format!("`{name}`")))
                            .collect();
                        let span = criteria.get(name).map(|criterion| criterion.span);
                        return Err(Fault::at(
                            source,
                            span.unwrap_or_default(),
                            format!("`{name}` is made of itself: {}", round.join(" of ")),
                        )
                        .help("break the circle"));
                    }
                    None => {
                        known.insert(name, 1);
                        let parts = criteria
                            .get(name)
                            .map(|criterion| parts(criterion, criteria))
                            .unwrap_or_default();
                        way.push((name, parts));
                    }
                }
            }
            let Some((name, parts)) = way.last_mut() else {
                break;
            };
            next = parts.pop();
            if next.is_none() {
                known.insert(name, 2);
                way.pop();
            }
        }
    }
    Ok(())
}
