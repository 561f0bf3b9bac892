//! What inputs are in a run in time.

use quell_document::Fault;
use quell_expression::nearest;
use quell_model::Waveform;

use crate::situation::Situation;
use crate::study::{Study, TransientRun};

/// The signals that a run gives to inputs in place of the host's, by the input's index.
///
/// # Errors
/// There is no such input; what is wrong with the signal, at its place in the study.
pub(crate) fn excitations(
    study: &Study,
    situation: &Situation,
    run: &TransientRun,
) -> Result<Vec<(usize, Waveform)>, Fault> {
    let inputs = &situation.host.inputs;
    run.inputs
        .iter()
        .map(|(name, excitation)| {
            let fault = |message: String| Fault::at(&study.source, excitation.span, message);
            let known = || inputs.iter().map(|input| input.name.as_str());
            let Some(index) = known().position(|input| input == name) else {
                let fault = fault(format!("the host has no input `{name}`"));
                return Err(match nearest(name, known()) {
                    Some(near) => fault.help(format!("did you mean `{near}`?")),
                    None if inputs.is_empty() => fault.help("add it to the host under `[inputs]`"),
                    None => {
                        let all: Vec<String> = known().map(|name| format!("`{name}`")).collect();
                        fault.help(format!("its inputs are {}", all.join(", ")))
                    }
                });
            };
            let table = study
                .document
                .table(&excitation.path)
                .ok_or_else(|| fault(format!("the input `{name}` has no signal")))?;
            let waveform = Waveform::read(
                &table,
                situation.input_dimension(index),
                &situation.parameters,
                situation.is_dimensionless(),
                &study.folder,
            )?;
            Ok((index, waveform))
        })
        .collect()
}
