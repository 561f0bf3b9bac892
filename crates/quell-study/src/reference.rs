//! References: what designs are measured against.

use indexmap::IndexMap;
use quell_document::Fault;
use quell_expression::Span;
use quell_network::Layout;

use crate::candidates::{Candidate, single_slot};
use crate::study::{ConfigurationSpec, DesignTask, Study, TaskKind};

/// A reference: a configuration of the study, or a layout to be designed.
pub(crate) enum Reference<'a> {
    /// Its values are given.
    Configuration(&'a ConfigurationSpec),
    /// Its values are searched within the bounds of the task.
    Layout(Candidate),
}

impl<'a> Reference<'a> {
    /// The reference of a name.
    ///
    /// # Errors
    /// The name is neither a configuration nor a layout that the task could design.
    pub(crate) fn of(
        study: &'a Study,
        design: &DesignTask,
        name: &str,
        span: Span,
    ) -> Result<Self, Fault> {
        let configurations = || {
            study.tasks.iter().filter_map(|task| match &task.kind {
                TaskKind::Evaluate(configurations) => Some(configurations),
                TaskKind::Design(_) | TaskKind::Continuation(_) => None,
            })
        };
        if let Some(spec) = configurations().find_map(|known| known.get(name)) {
            return Ok(Self::Configuration(spec));
        }
        let fault = |message: String| Fault::at(&study.source, span, message);
        let Some(slot) = single_slot(design) else {
            return Err(fault(format!("there is no configuration `{name}`"))
            .help("where several slots are designed, a reference is a configuration of an `evaluate` task"));
        };
        let domain = study.domain_of(slot);
        let kinds = study
            .kinds
            .of(domain)
            .cloned()
            .unwrap_or_else(|| quell_network::Kinds::new(domain));
        match Layout::parse(name, &kinds) {
            Ok(_) if !design.further.is_empty() => Err(fault(
                "for several objectives no one design of a layout is the best".to_owned(),
            )
            .help("refer to a configuration of an `evaluate` task, or list the layout under `candidates`")),
            Ok(layout) => Ok(Self::Layout(Candidate {
                layouts: vec![(slot.clone(), layout, span)],
            })),
            Err(error) => {
                let names: Vec<&String> = configurations().flat_map(IndexMap::keys).collect();
                let fault = fault(format!(
                    "`{name}` is neither a configuration nor a layout: {}",
                    error.message
                ));
                let near = quell_expression::nearest(name, names.iter().map(|name| name.as_str()));
                if let Some(near) = near {
                    return Err(fault.help(format!("did you mean `{near}`?")));
                }
                let all: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
                let mut help = error.help.unwrap_or_default();
                if !all.is_empty() {
                    help = format!("configurations are {}. {help}", all.join(", "));
                }
                Err(fault.help(help.trim().to_owned()))
            }
        }
    }
}
