//! Criteria and runs in words.

use std::fmt::Write as _;

use quell_expression::{Expression, Node};
use quell_model::InputKind;
use quell_study::study::{Criterion, Run};

use super::Bridge;

impl Bridge<'_> {
    /// What a criterion means: what is taken of the run, and the expression around it.
    pub(super) fn meaning(&self, criterion: &Criterion) -> String {
        let Some((name, run)) = criterion
            .run
            .as_ref()
            .and_then(|name| Some((name, self.study.runs.get(name)?)))
        else {
            return format!("`{}`", criterion.value);
        };
        let mut found = None;
        criterion.value.walk(&mut |part| {
            if found.is_none() {
                found = taken(part, run);
            }
        });
        match found {
            Some((words, whole)) if whole == criterion.value.to_string() => {
                format!("{words}: `{whole}`")
            }
            Some((words, _)) => format!("`{}`, from the {words}", criterion.value),
            None => format!("`{}` of run `{name}`", criterion.value),
        }
    }

    /// What excites the host in a run, and over which band.
    pub(super) fn excitation(&self, run: &Run) -> String {
        match run {
            Run::Frequency(run) => {
                let input = &run.input;
                let mut text = match self.input_kind(input) {
                    Some(kind) => format!("{kind} `{input}`"),
                    None => format!("`{input}`"),
                };
                match &run.band {
                    Some((low, high)) => {
                        let _ = write!(text, ", {} to {}", low.expression(), high.expression());
                    }
                    None => text.push_str(", all frequencies"),
                }
                if let Some(spectrum) = &run.spectrum {
                    let _ = write!(text, ", spectrum `{}` per Hz", spectrum.expression());
                }
                text
            }
            Run::Modes {
                oscillatory: true, ..
            } => "free oscillatory modes".to_owned(),
            Run::Modes {
                oscillatory: false, ..
            } => "free modes".to_owned(),
            Run::Transient(run) => {
                let mut text = "motion in time".to_owned();
                match &run.end {
                    Some(end) => {
                        let way = match end.rising {
                            Some(true) => " rises through",
                            Some(false) => " falls through",
                            None => " goes through",
                        };
                        let _ = write!(text, " until `{}`{way} zero", end.event);
                        if let Some(armed) = &end.armed {
                            let _ = write!(text, " after `{armed}`");
                        }
                        let _ = write!(text, ", at most {}", run.duration.expression());
                    }
                    None => {
                        let _ = write!(text, " for {}", run.duration.expression());
                    }
                }
                text
            }
        }
    }

    fn input_kind(&self, name: &str) -> Option<&'static str> {
        let host = &self.standing.as_ref()?.host;
        let input = host.inputs.iter().find(|input| input.name == name)?;
        Some(match input.kind {
            InputKind::Force => "force",
            InputKind::Displacement => "prescribed displacement",
            InputKind::Velocity => "prescribed velocity",
            InputKind::Acceleration => "prescribed acceleration",
        })
    }
}

/// Words for a call that takes a number from a run, with the call itself.
fn taken(part: &Expression, run: &Run) -> Option<(String, String)> {
    let Node::Call {
        function,
        arguments,
        ..
    } = &part.node
    else {
        return None;
    };
    let first = arguments.first()?;
    let words = match (run, function.as_str(), &first.node) {
        (
            Run::Frequency(run),
            "max",
            Node::Call {
                function,
                arguments,
                ..
            },
        ) if function == "abs" => format!(
            "greatest magnitude of `{}` over `{}` in the band",
            arguments.first()?,
            run.input
        ),
        (Run::Frequency(run), "abs", _) => format!(
            "magnitude of `{first}` over `{}` at {}",
            run.input,
            arguments.get(1)?
        ),
        (Run::Frequency(run), "h2", _) => {
            format!("H2 norm of `{first}` over `{}`", run.input)
        }
        (Run::Frequency(_), "rms", _) => format!("root mean square of `{first}`"),
        (Run::Frequency(_), "variance", _) => format!("variance of `{first}`"),
        (Run::Modes { .. }, "min" | "max", Node::Name(name)) => format!(
            "{} {} of the modes",
            if function == "min" {
                "smallest"
            } else {
                "greatest"
            },
            name.replace('_', " ")
        ),
        _ => return None,
    };
    Some((words, part.to_string()))
}
