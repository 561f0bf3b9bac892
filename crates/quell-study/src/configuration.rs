//! A configuration of a study: built, and with the values of its criteria.

use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::Fault;

use crate::built::{Built, Values};
use crate::candidates::Candidate;
use crate::evaluator::{Certified, Evaluator, EvaluatorScratch};
use crate::outcome::Evaluated;
use crate::situation::Situation;
use crate::study::{ConfigurationSpec, Study};

/// Builds a configuration with all its criteria.
pub(crate) fn configuration(
    study: &Study,
    situation: &Situation,
    spec: &ConfigurationSpec,
) -> Result<Evaluator, Fault> {
    let built = built(study, situation, spec)?;
    Evaluator::new(study, situation, Arc::new(built), None, &spec.runs)
}

/// The layouts of a configuration, as a candidate has them.
pub(crate) fn candidate(spec: &ConfigurationSpec) -> Candidate {
    Candidate {
        layouts: spec
            .layouts
            .iter()
            .map(|(slot, (layout, span))| (slot.clone(), layout.clone(), *span))
            .collect(),
    }
}

/// Builds a configuration.
pub(crate) fn built(
    study: &Study,
    situation: &Situation,
    spec: &ConfigurationSpec,
) -> Result<Built, Fault> {
    let candidate = candidate(spec);
    let bounds = IndexMap::new();
    let built = Built::new(
        study,
        situation,
        &candidate,
        Values {
            given: &spec.values,
            bounds: &bounds,
            searched: false,
        },
    )?;
    for (key, amount) in &spec.values {
        if !built.used.contains(key) {
            let fault = amount.fault(format!("`{key}` is in no layout of this configuration"));
            let names = built.value_names();
            return Err(
                match quell_expression::nearest(key, names.iter().map(String::as_str)) {
                    Some(near) => fault.help(format!("did you mean `{near}`?")),
                    None => fault.help("remove it, or mend its name"),
                },
            );
        }
    }
    if let Some((name, value)) = built.impossible_value(&[]) {
        return Err(Fault::at(
            &study.source,
            spec.span,
            format!(
                "the value {value} of `{name}` cannot be: an element's value is finite and not negative"
            ),
        ));
    }
    Ok(built)
}

/// Criteria of a candidate at values of its design variables, with what is known about each.
pub(crate) fn evaluated(name: &str, evaluator: &Evaluator, point: &[f64]) -> Evaluated {
    let built = evaluator.built();
    let mut scratch = EvaluatorScratch::default();
    let certified: Vec<Certified> = if point.len() == built.variables.len() {
        built.values(point, &mut scratch.values);
        evaluator.certified(&mut scratch).0
    } else {
        Vec::new()
    };
    let energy = evaluator.ledgers(&scratch.values);
    let mut criteria = IndexMap::new();
    let mut details = IndexMap::new();
    for (name, known) in evaluator.names().zip(certified) {
        criteria.insert(name.to_owned(), known.value);
        details.insert(name.to_owned(), known.detail);
    }
    Evaluated {
        name: name.to_owned(),
        devices: built.devices(point),
        criteria,
        details,
        energy,
    }
}
