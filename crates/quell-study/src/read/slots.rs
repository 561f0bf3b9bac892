//! Slots: places of devices in which a task may put layouts.

use quell_document::Fault;
use quell_expression::Span;
use quell_network::{Domain, Kinds};

use super::unknown;
use crate::study::{Slot, Study};

/// The kinds with which layouts of a slot's domain are read.
pub(crate) fn kinds_of(study: &Study, domain: Domain) -> Kinds {
    study
        .kinds
        .of(domain)
        .cloned()
        .unwrap_or_else(|| Kinds::new(domain))
}

/// Every slot of the study.
fn slots(study: &Study) -> Vec<Slot> {
    let mut slots = Vec::new();
    for (name, device) in &study.devices {
        if device.layout.is_none() {
            slots.push(Slot {
                device: name.clone(),
                placeholder: None,
            });
        }
        for placeholder in &device.slots {
            slots.push(Slot {
                device: name.clone(),
                placeholder: Some(placeholder.clone()),
            });
        }
    }
    slots
}

impl Slot {
    /// As a study file may write it: the device, the placeholder where only one device has it, or `device.placeholder`.
    fn answers_to(&self, name: &str) -> bool {
        match &self.placeholder {
            None => self.device == name,
            Some(placeholder) => {
                placeholder == name || format!("{}.{placeholder}", self.device) == name
            }
        }
    }
}

/// The slot of a name; none where no slot answers to it.
pub(super) fn slot_of(study: &Study, name: &str, span: Span) -> Result<Option<Slot>, Fault> {
    let mut answering: Vec<Slot> = slots(study)
        .into_iter()
        .filter(|slot| slot.answers_to(name))
        .collect();
    if answering.is_empty()
        && let Some(device) = study.devices.get(name)
    {
        let fault = Fault::at(
            &study.source,
            span,
            format!("the device `{name}` has a layout of its own"),
        );
        return Err(match device.slots.first() {
            Some(slot) => fault.help(format!("what can be chosen is its slot: write `{slot}`")),
            None => fault.help("it has no slot in which another layout could go"),
        });
    }
    if answering.len() > 1 {
        let full: Vec<String> = answering
            .iter()
            .map(|slot| {
                format!(
                    "`{}.{}`",
                    slot.device,
                    slot.placeholder.as_deref().unwrap_or_default()
                )
            })
            .collect();
        return Err(Fault::at(
            &study.source,
            span,
            format!("several devices have a slot `{name}`"),
        )
        .help(format!("write {}", full.join(" or "))));
    }
    Ok(answering.pop())
}

/// A layout for something that takes none.
pub(super) fn no_such_slot(study: &Study, name: &str, span: Span) -> Fault {
    let names: Vec<String> = slots(study)
        .into_iter()
        .map(|slot| slot.placeholder.unwrap_or(slot.device))
        .collect();
    let fault = Fault::at(
        &study.source,
        span,
        format!("there is no device or slot `{name}` that takes a layout"),
    );
    unknown(
        fault,
        name,
        "device or slot",
        names.iter().map(String::as_str),
    )
}

/// A slot may be called by its own name and by the device's and its own.
pub(super) fn refuse_second(
    taken: bool,
    name: &str,
    span: Span,
    study: &Study,
) -> Result<(), Fault> {
    if taken {
        return Err(Fault::at(
            &study.source,
            span,
            format!("the slot `{name}` is filled twice"),
        )
        .help("keep one of the two"));
    }
    Ok(())
}
