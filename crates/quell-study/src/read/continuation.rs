//! Tasks of kind `branch`, `curve`, `diagram` and `region` as typed; of kind `simulate` see `simulate`.

use indexmap::IndexMap;
use quell_continuation::Correction;
use quell_document::{Fault, Table, Value};
use quell_expression::Unit;

use super::tasks::configuration_of;
use super::unknown;
use crate::amount::Amount;
use crate::continuation::{BranchStart, ContinuationTask, Follows, Measure, ParameterRange};
use crate::keys;
use crate::study::{ConfigurationSpec, Run, Study, Task, TaskKind};

/// The keys of tasks that follow branches; those of one kind alone with that kind.
const KEYS: [(&str, &[Follows]); 19] = {
    use Follows::{Branch, Curve, Diagram, Motions, Region};
    const ALL: &[Follows] = &[Branch, Curve, Diagram, Region];
    const WITH_MOTIONS: &[Follows] = &[Branch, Curve, Diagram, Region, Motions];
    [
        ("configuration", WITH_MOTIONS),
        ("parameter", &[Branch, Diagram, Motions]),
        ("parameters", &[Curve, Region, Motions]),
        ("ranges", WITH_MOTIONS),
        ("start", &[Branch, Curve]),
        ("at", &[Branch, Curve, Diagram, Motions]),
        ("measures", WITH_MOTIONS),
        ("oscillations", WITH_MOTIONS),
        ("of", &[Motions]),
        ("duration", &[Motions]),
        ("cycles", &[Branch]),
        ("depth", &[Diagram]),
        ("search", &[Diagram]),
        ("corrector", ALL),
        ("points", ALL),
        ("mesh_tolerance", ALL),
        ("longest_period", ALL),
        ("period", &[Branch, Curve, Diagram, Motions]),
        ("sweep", &[Branch, Diagram]),
    ]
};

/// The kinds of task that follow branches, or check them.
pub(super) const KINDS: [&str; 5] = ["branch", "curve", "diagram", "region", "simulate"];

/// Whether a study asks for nothing but branches.
pub(super) fn alone(root: &Table<'_>) -> bool {
    let tasks = root.get("tasks").and_then(|value| value.as_array().ok());
    tasks.is_some_and(|tasks| {
        !tasks.is_empty()
            && tasks.iter().all(|task| {
                let kind = task.as_table().ok().and_then(|table| table.get("kind"));
                kind.is_some_and(|kind| kind.as_str().is_ok_and(|kind| KINDS.contains(&kind)))
            })
    })
}

/// Whether a key belongs to tasks of a kind that follows branches.
pub(super) fn takes(kind: &str, key: &str) -> bool {
    KEYS.iter()
        .any(|(known, kinds)| *known == key && kinds.iter().any(|one| one.kind() == kind))
}

/// All keys that only such tasks have.
pub(super) fn own_keys() -> impl Iterator<Item = &'static str> {
    KEYS.iter()
        .map(|(key, _)| *key)
        .filter(|key| *key != "sweep")
}

/// Most points in each direction that anybody waits for.
const MOST_POINTS: usize = 100_000;

/// Reads a task.
///
/// # Errors
/// Whatever is wrong with it, at its place.
pub(super) fn task(
    table: &Table<'_>,
    kind: &str,
    study: &Study,
    above: &[Task],
) -> Result<ContinuationTask, Fault> {
    let follows = match kind {
        "simulate" => return super::simulate::task(table, study, above),
        "curve" => Follows::Curve,
        "diagram" => Follows::Diagram,
        "region" => Follows::Region,
        _ => Follows::Branch,
    };
    let source = &study.source;
    let parameters = parameters(table, follows)?;
    let ranges = match table.get("ranges") {
        Some(value) => ranges(&value, study, &parameters)?,
        None => IndexMap::new(),
    };
    let mut more = Vec::new();
    let start = match table.get("start") {
        Some(value) if follows == Follows::Curve && value.is_array() => {
            const EXAMPLE: &str = "write `start = [\"TASK:H1\", \"TASK:H2\"]`";
            let mut all = Vec::new();
            for one in &value.as_array()? {
                all.push(start(one, study, above)?);
            }
            let mut all = all.into_iter();
            let first = all
                .next()
                .ok_or_else(|| value.fault("no point is named to start from").help(EXAMPLE))?;
            more.extend(all);
            first
        }
        Some(value) => start(&value, study, above)?,
        None if follows == Follows::Curve => {
            return Err(table
                .fault("the curve does not say at which point it starts")
                .help("add `start = \"TASK:H1\"`, with a task above and a label that it finds"));
        }
        None => BranchStart::Equilibrium,
    };
    let configuration = match table.get("configuration") {
        Some(value) => Some(configuration(&value, study, above)?),
        None => None,
    };
    let at = match table.get("at") {
        Some(value) => value
            .as_array()
            .map_err(|fault| fault.help("write a list: `at = [\"20 m/s\"]`"))?
            .iter()
            .map(|value| Amount::read(value, source))
            .collect::<Result<_, _>>()?,
        None => Vec::new(),
    };
    let amount = |key: &str| {
        table
            .get(key)
            .map(|value| Amount::read(&value, source))
            .transpose()
    };
    let usual = ContinuationTask::new(follows, table.require("name")?.span());
    Ok(ContinuationTask {
        configuration,
        parameters,
        ranges,
        start,
        more,
        at,
        measures: measures(
            table,
            study,
            "measures",
            "write `measures = { sway = \"max(abs(x))\" }`",
        )?,
        oscillations: oscillations(table, study)?,
        cycles: table
            .get("cycles")
            .map(|value| value.as_bool())
            .transpose()?
            .unwrap_or(false),
        search: match table.get("search") {
            Some(value) => boxed(&value, study)?,
            None => IndexMap::new(),
        },
        correction: correction(table)?,
        depth: count(table, "depth", usual.depth, 1..=10)?,
        points: count(table, "points", usual.points, 2..=MOST_POINTS)?,
        tolerance: tolerance(table, usual.tolerance)?,
        longest_period: amount("longest_period")?,
        period: amount("period")?,
        ..usual
    })
}

fn count(
    table: &Table<'_>,
    key: &str,
    usual: usize,
    allowed: std::ops::RangeInclusive<usize>,
) -> Result<usize, Fault> {
    let Some(value) = table.get(key) else {
        return Ok(usual);
    };
    let number = value.as_count()?;
    if allowed.contains(&number) {
        Ok(number)
    } else {
        Err(value.fault(format!(
            "`{key}` lies between {} and {}, found {number}",
            allowed.start(),
            allowed.end()
        )))
    }
}

fn correction(table: &Table<'_>) -> Result<Correction, Fault> {
    let Some(value) = table.get("corrector") else {
        return Ok(Correction::PseudoArclength);
    };
    match value.as_str()? {
        "pseudo-arclength" => Ok(Correction::PseudoArclength),
        "Moore-Penrose" => Ok(Correction::MoorePenrose),
        other => Err(unknown(
            value.fault(format!("there is no corrector `{other}`")),
            other,
            "corrector",
            keys::CORRECTORS.iter().copied(),
        )),
    }
}

/// Where equilibria are sought.
fn boxed(value: &Value<'_>, study: &Study) -> Result<IndexMap<String, ParameterRange>, Fault> {
    const EXAMPLE: &str = "write `search = { x = [\"-5 mm\", \"5 mm\"] }`";
    let mut found = IndexMap::new();
    let table = value.as_table().map_err(|fault| fault.help(EXAMPLE))?;
    for (name, _, value) in table.entries() {
        found.insert(name.to_owned(), range(&value, study, EXAMPLE)?);
    }
    Ok(found)
}

fn range(value: &Value<'_>, study: &Study, example: &str) -> Result<ParameterRange, Fault> {
    let ends = value.as_array().map_err(|fault| fault.help(example))?;
    let [from, to] = ends.as_slice() else {
        return Err(value
            .fault("a range has a lower and an upper end")
            .help(example));
    };
    Ok(ParameterRange {
        from: Amount::read(from, &study.source)?,
        to: Amount::read(to, &study.source)?,
        span: value.span(),
    })
}

fn tolerance(table: &Table<'_>, usual: f64) -> Result<f64, Fault> {
    let Some(value) = table.get("mesh_tolerance") else {
        return Ok(usual);
    };
    let tolerance = value.as_f64()?;
    if (1e-12..=1e-2).contains(&tolerance) {
        Ok(tolerance)
    } else {
        Err(value
            .fault(format!("the tolerance {tolerance} is out of reach"))
            .help("the error of a cycle's mesh lies between 1e-12 and 1e-2 of its size; 1e-8 unless given"))
    }
}

fn parameters(
    table: &Table<'_>,
    follows: Follows,
) -> Result<Vec<(String, quell_expression::Span)>, Fault> {
    const EXAMPLE: &str = "write `parameters = [\"V\", \"c1\"]`";
    let named = |value: &Value<'_>| Ok::<_, Fault>((value.as_str()?.to_owned(), value.span()));
    if !matches!(follows, Follows::Curve | Follows::Region) {
        let value = table.get("parameter").ok_or_else(|| {
            table
                .fault(format!(
                    "the {} does not say which parameter it follows",
                    follows.kind()
                ))
                .help("add `parameter = \"NAME\"`: a parameter of the host or a value of the configuration")
        })?;
        return Ok(vec![named(&value)?]);
    }
    let value = table.get("parameters").ok_or_else(|| {
        table
            .fault(if follows == Follows::Curve {
                "the curve does not say in which two parameters it runs"
            } else {
                "the region does not say which two parameters span it"
            })
            .help(EXAMPLE)
    })?;
    two_parameters(
        &value,
        if follows == Follows::Curve {
            "a curve runs in two parameters"
        } else {
            "a region is of two parameters"
        },
    )
}

/// Two names of parameters; `why` says that there must be two.
pub(super) fn two_parameters(
    value: &Value<'_>,
    why: &str,
) -> Result<Vec<(String, quell_expression::Span)>, Fault> {
    const EXAMPLE: &str = "write `parameters = [\"V\", \"c1\"]`";
    let list = value.as_array().map_err(|fault| fault.help(EXAMPLE))?;
    let [first, second] = list.as_slice() else {
        return Err(value.fault(why).help(EXAMPLE));
    };
    let name = first.as_str()?;
    if name == second.as_str()? {
        return Err(second
            .fault(format!("`{name}` is named twice"))
            .help(EXAMPLE));
    }
    let named = |value: &Value<'_>| Ok::<_, Fault>((value.as_str()?.to_owned(), value.span()));
    Ok(vec![named(first)?, named(second)?])
}

pub(super) fn ranges(
    value: &Value<'_>,
    study: &Study,
    parameters: &[(String, quell_expression::Span)],
) -> Result<IndexMap<String, ParameterRange>, Fault> {
    const EXAMPLE: &str = "write `ranges = { V = [\"5 m/s\", \"80 m/s\"] }`";
    let mut found = IndexMap::new();
    let table = value.as_table().map_err(|fault| fault.help(EXAMPLE))?;
    for (name, span, value) in table.entries() {
        if !parameters.iter().any(|(known, _)| known == name) {
            let fault = Fault::at(
                &study.source,
                span,
                format!("`{name}` is no parameter that this task follows"),
            );
            return Err(unknown(
                fault,
                name,
                "parameter",
                parameters.iter().map(|(name, _)| name.as_str()),
            ));
        }
        found.insert(name.to_owned(), range(&value, study, EXAMPLE)?);
    }
    Ok(found)
}

fn start(value: &Value<'_>, study: &Study, above: &[Task]) -> Result<BranchStart, Fault> {
    const EXAMPLE: &str =
        "write `\"equilibrium\"`, `\"TASK:LABEL\"` with a task above, or `{ run = \"NAME\" }`";
    if value.is_table() {
        let table = value.as_table()?;
        table.check(&keys::START)?;
        let run = table.require("run")?;
        let name = run.as_str()?;
        let Some(known) = study.runs.get(name) else {
            return Err(unknown(
                run.fault(format!("there is no run `{name}`")),
                name,
                "run",
                study.runs.keys().map(String::as_str),
            ));
        };
        if !matches!(known, Run::Transient(_)) {
            return Err(run
                .fault(format!("`{name}` is no run in time"))
                .help("a branch starts at the end of a run of `kind = \"transient\"`"));
        }
        return Ok(BranchStart::Run {
            run: name.to_owned(),
            span: run.span(),
        });
    }
    let text = value.as_str().map_err(|fault| fault.help(EXAMPLE))?;
    if text == "equilibrium" {
        return Ok(BranchStart::Equilibrium);
    }
    let followed: Vec<&Task> = above
        .iter()
        .filter(|task| matches!(task.kind, TaskKind::Continuation(_)))
        .collect();
    // Names of tasks may hold colons themselves: the longest that fits.
    let found = followed
        .iter()
        .filter_map(|task| {
            let label = text.strip_prefix(task.name.as_str())?.strip_prefix(':')?;
            Some((*task, label))
        })
        .max_by_key(|(task, _)| task.name.len());
    let Some((task, label)) = found else {
        let fault = value.fault(format!("`{text}` is nothing to start from"));
        let name = text.split(':').next().unwrap_or(text);
        let names = followed.iter().map(|task| task.name.as_str());
        return Err(match quell_expression::nearest(name, names) {
            Some(near) if text.contains(':') && near != name => {
                fault.help(format!("did you mean the task `{near}`?"))
            }
            Some(near) if !text.contains(':') && near == name => {
                fault.help(format!("say at which of its points: `\"{near}:H1\"`"))
            }
            _ => fault.help(EXAMPLE),
        });
    };
    if !task.sweep.is_empty() {
        return Err(value.fault(format!(
            "the task `{}` is swept, so its labels are not unique",
            task.name
        )));
    }
    if label.is_empty() {
        return Err(value
            .fault(format!(
                "`{text}` does not say which point of `{}`",
                task.name
            ))
            .help(format!(
                "write `\"{}:H1\"` with a label that it finds",
                task.name
            )));
    }
    Ok(BranchStart::Label {
        task: task.name.clone(),
        label: label.to_owned(),
        span: value.span(),
    })
}

pub(super) fn configuration(
    value: &Value<'_>,
    study: &Study,
    above: &[Task],
) -> Result<ConfigurationSpec, Fault> {
    if value.is_table() {
        return configuration_of(&value.as_table()?, value.span(), study);
    }
    let name = value.as_str().map_err(|fault| {
        fault.help("write `{ DEVICE = \"k1 | c1\", k1 = \"…\" }`, or the name of a configuration of an `evaluate` task")
    })?;
    let known = || {
        above.iter().filter_map(|task| match &task.kind {
            TaskKind::Evaluate(configurations) => Some(configurations),
            _ => None,
        })
    };
    if let Some(found) = known().find_map(|all| all.get(name)) {
        return Ok(found.clone());
    }
    let names: Vec<&str> = known()
        .flat_map(|all| all.keys().map(String::as_str))
        .collect();
    Err(unknown(
        value.fault(format!("there is no configuration `{name}` above")),
        name,
        "configuration",
        names.iter().copied(),
    ))
}

/// Names of oscillations with the measures that are compared.
pub(super) fn oscillations(
    table: &Table<'_>,
    study: &Study,
) -> Result<IndexMap<String, Measure>, Fault> {
    const EXAMPLE: &str = "write `oscillations = { torsion = \"max(abs(p))\", bending = \"max(abs(d))\" }`: an oscillation is named by the largest";
    let found = measures(table, study, "oscillations", EXAMPLE)?;
    let typed = table.get("oscillations");
    if let (1, Some(value)) = (found.len(), &typed) {
        return Err(value
            .fault("one name tells no oscillation from another")
            .help(EXAMPLE));
    }
    for (name, measure) in &found {
        if let Some((_, span)) = &measure.unit {
            return Err(Fault::at(
                &study.source,
                *span,
                format!("`{name}` names an oscillation and is not shown, so it has no unit"),
            )
            .help(EXAMPLE));
        }
    }
    Ok(found)
}

pub(super) fn measures(
    table: &Table<'_>,
    study: &Study,
    key: &str,
    example: &str,
) -> Result<IndexMap<String, Measure>, Fault> {
    let Some(value) = table.get(key) else {
        return Ok(IndexMap::new());
    };
    let mut found = IndexMap::new();
    let all = value.as_table().map_err(|fault| fault.help(example))?;
    for (name, span, value) in all.entries() {
        super::check_name(name, span, &all)?;
        let (expression, unit) = if value.is_table() {
            let own = value.as_table()?;
            own.check(&keys::MEASURE)?;
            (own.require("value")?, own.get("unit"))
        } else {
            (value, None)
        };
        let unit = unit
            .map(|value| {
                Unit::parse(value.as_str()?)
                    .map(|unit| (unit, value.span()))
                    .map_err(|mut error| {
                        error.span = value.text_span(error.span);
                        Fault::from_expression(&study.source, error)
                    })
            })
            .transpose()?;
        found.insert(
            name.to_owned(),
            Measure {
                value: expression.expression()?,
                unit,
            },
        );
    }
    Ok(found)
}
