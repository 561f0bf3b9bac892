//! Where a run in time begins, if it does not begin where the host says.

use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::Fault;
use quell_expression::nearest;
use quell_model::EquationHost;

use crate::amount::Amount;
use crate::situation::Situation;
use crate::study::{Run, StartAt, Study};

/// The host as a run has it begin.
///
/// # Errors
/// A value for something that the host does not have, or of another dimension.
pub(crate) fn beginning(
    study: &Study,
    situation: &Situation,
    host: &Arc<EquationHost>,
    run: &Run,
) -> Result<Arc<EquationHost>, Fault> {
    let Run::Transient(run) = run else {
        return Ok(Arc::clone(host));
    };
    let StartAt::States(states) = &run.start else {
        return Ok(Arc::clone(host));
    };
    begun(study, situation, host, states)
}

/// The host with other values where it begins, by the names of coordinates, rates and states.
///
/// # Errors
/// As [`beginning`].
pub(crate) fn begun(
    study: &Study,
    situation: &Situation,
    host: &Arc<EquationHost>,
    states: &IndexMap<String, Amount>,
) -> Result<Arc<EquationHost>, Fault> {
    let known = host.beginnings();
    let mut begun = EquationHost::clone(host);
    for (name, amount) in states {
        let Some((_, dimension)) = known.iter().find(|(known, _)| known == name) else {
            let fault = Fault::at(
                &study.source,
                amount.span(),
                format!("the host has no coordinate, rate or state `{name}` to begin with"),
            );
            return Err(
                match nearest(name, known.iter().map(|(name, _)| name.as_str())) {
                    Some(near) => fault.help(format!("did you mean `{near}`?")),
                    None => fault,
                },
            );
        };
        let value = amount.value(&situation.parameters, *dimension)?;
        begun.begin_with(name, value);
    }
    Ok(Arc::new(begun))
}
