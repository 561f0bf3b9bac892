//! Candidates that are positive-real functions: read twice, first to declare what their layouts are made of.

use quell_document::{Fault, Value};
use quell_network::{Domain, Kinds, Layout};

use super::slots::slot_of;
use crate::immittance::Form;
use crate::keys;
use crate::study::{CandidateSet, Study};

/// Declares the functions that tasks ask for as components of the study.
///
/// # Errors
/// A component of the user's that has a function's name, or a device of a domain that has none.
pub(super) fn declare(tasks: &Value<'_>, study: &mut Study) -> Result<(), Fault> {
    // Whatever has not the shape that is expected here is refused where the tasks are read.
    for task in tasks.as_array().unwrap_or_default() {
        let candidates = task.as_table().ok().and_then(|task| task.get("candidates"));
        let Some(candidates) = candidates.and_then(|value| value.as_table().ok()) else {
            continue;
        };
        for (name, span, value) in candidates.entries() {
            let Some(wanted) = value
                .as_table()
                .ok()
                .and_then(|table| table.get("immittance"))
            else {
                continue;
            };
            let Some(slot) = slot_of(study, name, span)? else {
                continue;
            };
            let domain = study.domain_of(&slot);
            if !matches!(domain, Domain::Translational | Domain::Rotational) {
                return Err(wanted
                    .fault(format!("a {domain} device cannot be designed as a function"))
                    .help("the function is the mechanical admittance of a translational or rotational device"));
            }
            for form in Form::of(wanted.one_of(&Form::ORDERS)?) {
                let name = form.name();
                let fault = |message: String| wanted.fault(message);
                let known = study.components.get(name);
                if let Some(known) = known
                    && (!study.immittances.contains_key(name) || known.domain != domain)
                {
                    return Err(if study.immittances.contains_key(name) {
                        fault(format!("`{name}` is wanted at devices of two domains"))
                            .help("ask for it in two studies")
                    } else {
                        fault(format!("a component of the study is called `{name}` too"))
                            .help("give the component another name")
                    });
                }
                if known.is_some() {
                    continue;
                }
                let component = form
                    .component(domain, &study.source, wanted.span())
                    .map_err(|error| Fault::from_expression(&study.source, error))?;
                for (of, kinds) in &mut study.kinds.tables {
                    if *of == domain {
                        kinds
                            .declare_component(name)
                            .map_err(|error| fault(error.to_string()))?;
                    }
                }
                study.components.insert(name.to_owned(), component);
                study.immittances.insert(name.to_owned(), *form);
            }
        }
    }
    Ok(())
}

/// `{ immittance = "biquadratic" }` as layouts of one component each.
pub(super) fn candidates(value: &Value<'_>, kinds: &Kinds) -> Result<CandidateSet, Fault> {
    let table = value.as_table()?;
    table.check(&keys::IMMITTANCE)?;
    let order = table.require("immittance")?;
    let layouts = Form::of(order.one_of(&Form::ORDERS)?)
        .iter()
        .map(|form| {
            let layout = Layout::parse(&format!("{}1", form.name()), kinds)
                .map_err(|error| order.fault(error.message))?;
            Ok((layout, order.span()))
        })
        .collect::<Result<_, Fault>>()?;
    Ok(CandidateSet::Layouts(layouts))
}
