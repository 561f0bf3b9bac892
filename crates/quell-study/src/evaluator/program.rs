//! A criterion as arithmetic over what is read of runs, or over other criteria.

use quell_expression::{Dimension, Tape};

/// A criterion over the values of functionals, or of other criteria.
#[derive(Debug)]
pub(super) struct Program {
    pub(super) name: String,
    pub(super) dimension: Dimension,
    /// Indices of its functionals among all readings; of one of criteria, all that those read.
    pub(super) readings: Vec<usize>,
    pub(super) inputs: Inputs,
    pub(super) tape: Tape,
}

/// What the tape of a criterion takes.
#[derive(Debug)]
pub(super) enum Inputs {
    /// Its readings, in order.
    Readings,
    /// The values of other criteria, which stand before it.
    Criteria {
        /// Which, in order.
        parts: Vec<usize>,
        /// Where it is the largest of terms of one criterion each: which, and the term.
        terms: Vec<(usize, Tape)>,
    },
    /// Itself at several points, by index; and the names in its expression.
    Varied(usize, Vec<String>),
}

impl Program {
    /// The value, of those of the readings and of the criteria before this one.
    pub(super) fn value(
        &self,
        readings: &[f64],
        criteria: &[f64],
        inputs: &mut Vec<f64>,
        work: &mut Vec<f64>,
    ) -> f64 {
        let (places, values) = match &self.inputs {
            Inputs::Readings => (&self.readings, readings),
            Inputs::Criteria { parts, .. } => (parts, criteria),
            Inputs::Varied(..) => return f64::NAN,
        };
        inputs.clear();
        inputs.extend(
            places
                .iter()
                .map(|index| values.get(*index).copied().unwrap_or(f64::NAN)),
        );
        let mut out = [f64::NAN];
        self.tape.evaluate(inputs, work, &mut out);
        out[0]
    }
}
