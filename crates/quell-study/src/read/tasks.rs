//! Tasks: configurations to evaluate, designs to find, sweeps over both.

use indexmap::IndexMap;
use quell_document::{Fault, Table, Value};
use quell_expression::{ComparisonOperator, Expression, Node, Span};
use quell_network::{Budget, Domain, Enumeration, EnumerationError, Equivalence, Kinds, Layout};

use super::{
    amounts_of, continuation, devices, immittance, objectives, resolve, sweep, transient, unknown,
};
use crate::amount::Amount;
use crate::keys;
use crate::study::{
    Bounds, CandidateSet, ConfigurationSpec, Constraint, DesignTask, Run, Sense, Slot, Study, Task,
    TaskKind,
};

/// A search gives up on nothing, but a list of more layouts than this would not end within a working day.
const MOST_LAYOUTS: u128 = 1_000_000;

/// What to do about too many layouts.
const FEWER: &str = "lower the numbers, or list the layouts of interest";

pub(super) fn tasks(value: &Value<'_>, study: &Study) -> Result<Vec<Task>, Fault> {
    let list = value
        .as_array()
        .map_err(|fault| fault.help("write `[[tasks]]` for each task"))?;
    if list.is_empty() {
        return Err(value
            .fault("the study asks for nothing")
            .help("add a `[[tasks]]`"));
    }
    let mut tasks: Vec<Task> = Vec::new();
    let mut configurations: Vec<String> = Vec::new();
    for value in &list {
        let table = value.as_table()?;
        table.check(&keys::TASK)?;
        let name_value = table.require("name")?;
        let name = name_value.as_str()?.to_owned();
        if name.trim().is_empty() {
            return Err(name_value.fault("a task needs a name"));
        }
        if tasks.iter().any(|task| task.name == name) {
            return Err(name_value
                .fault(format!("there are two tasks `{name}`"))
                .help("give each its own name"));
        }
        let kind = table.require("kind")?.one_of(&KINDS)?;
        refuse_strangers(&table, kind)?;
        let kind = if continuation::KINDS.contains(&kind) {
            TaskKind::Continuation(Box::new(continuation::task(&table, kind, study, &tasks)?))
        } else if kind == "evaluate" {
            let found = evaluate(&table, study)?;
            for (name, spec) in &found {
                if configurations.contains(name) {
                    return Err(Fault::at(&study.source, spec.span, format!("there are two configurations `{name}`"))
                        .help("names of configurations are unique within a study, since tasks refer to them"));
                }
                configurations.push(name.clone());
            }
            TaskKind::Evaluate(found)
        } else {
            TaskKind::Design(Box::new(design(&table, study)?))
        };
        let sweep = sweep::sweep(&table, study, &kind)?;
        tasks.push(Task {
            name,
            kind,
            sweep,
            span: name_value.span(),
        });
    }
    Ok(tasks)
}

/// The kinds of task.
pub(crate) const KINDS: [&str; 7] = [
    "evaluate", "design", "branch", "curve", "diagram", "region", "simulate",
];

/// Keys of the other kinds of task.
fn refuse_strangers(table: &Table<'_>, kind: &str) -> Result<(), Fault> {
    const DESIGN: [&str; 13] = [
        "minimise",
        "maximise",
        "subject_to",
        "references",
        "candidates",
        "fixed",
        "bounds",
        "starts",
        "agree",
        "most_starts",
        "front_points",
        "feasibility",
        "simplify",
    ];
    let mut strangers: Vec<&str> = Vec::new();
    if kind != "design" {
        // Motions have starts too.
        strangers.extend(
            DESIGN
                .iter()
                .filter(|key| !(kind == "simulate" && **key == "starts")),
        );
    }
    if kind != "evaluate" {
        strangers.push("configurations");
    }
    strangers.extend(continuation::own_keys().filter(|key| !continuation::takes(kind, key)));
    if matches!(kind, "curve" | "region" | "simulate") {
        strangers.push("sweep");
    }
    for key in strangers {
        if let Some(span) = table.key_span(key) {
            return Err(Fault::at(
                table.source(),
                span,
                format!("`{key}` is no key of a task of kind `{kind}`"),
            ));
        }
    }
    Ok(())
}

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

fn evaluate(
    table: &Table<'_>,
    study: &Study,
) -> Result<IndexMap<String, ConfigurationSpec>, Fault> {
    const EXAMPLE: &str =
        "write `[tasks.configurations.NAME]`, below it a layout for each device and its values";
    let value = table.get("configurations").ok_or_else(|| {
        table
            .fault("the task does not say which configurations to evaluate")
            .help(EXAMPLE)
    })?;
    let mut found = IndexMap::new();
    for (name, span, value) in value.as_table()?.entries() {
        let entry = value.as_table().map_err(|fault| fault.help(EXAMPLE))?;
        found.insert(name.to_owned(), configuration_of(&entry, span, study)?);
    }
    if found.is_empty() {
        return Err(value
            .fault("there is no configuration to evaluate")
            .help(EXAMPLE));
    }
    Ok(found)
}

/// One configuration: a layout for each slot, and values.
pub(super) fn configuration_of(
    entry: &Table<'_>,
    span: Span,
    study: &Study,
) -> Result<ConfigurationSpec, Fault> {
    let mut layouts = IndexMap::new();
    let mut values = IndexMap::new();
    let mut runs: IndexMap<String, Run> = IndexMap::new();
    for (key, key_span, value) in entry.entries() {
        if let Some(path) = key.strip_prefix("runs.") {
            override_run(study, &mut runs, path, key_span, &value)?;
            continue;
        }
        match slot_of(study, key, key_span)? {
            Some(slot) => {
                let layout = devices::layout(&value, &kinds_of(study, study.domain_of(&slot)))?;
                let taken = layouts.insert(slot, (layout, value.span()));
                refuse_second(taken.is_some(), key, key_span, study)?;
            }
            None if value.as_str().is_ok_and(|text| text.contains('|')) => {
                return Err(no_such_slot(study, key, key_span));
            }
            None => {
                values.insert(key.to_owned(), Amount::read(&value, &study.source)?);
            }
        }
    }
    Ok(ConfigurationSpec {
        runs,
        layouts,
        values,
        span,
    })
}

/// `runs.RUN.KEY` of a configuration: the run with another value of the key.
fn override_run(
    study: &Study,
    runs: &mut IndexMap<String, Run>,
    path: &str,
    span: Span,
    value: &Value<'_>,
) -> Result<(), Fault> {
    let fault = |message: String| Fault::at(&study.source, span, message);
    let Some((name, key)) = path.split_once('.') else {
        return Err(
            fault(format!("`runs.{path}` does not say which key of the run"))
                .help("write `\"runs.RUN.KEY\"`"),
        );
    };
    let Some(base) = runs.get(name).or_else(|| study.runs.get(name)) else {
        return Err(unknown(
            fault(format!("there is no run `{name}`")),
            name,
            "run",
            study.runs.keys().map(String::as_str),
        ));
    };
    let Run::Transient(base) = base else {
        return Err(fault(format!(
            "only keys of runs of kind `transient` can differ between configurations, and `{name}` is none"
        )));
    };
    let mut changed = base.clone();
    if let Some(input) = key.strip_prefix("inputs.") {
        transient::excite(&mut changed, input, span, value)?;
        runs.insert(name.to_owned(), Run::Transient(changed));
        return Ok(());
    }
    if !transient::KEYS.contains(&key) {
        return Err(unknown(
            fault(format!("a `transient` run has no key `{key}`")),
            key,
            "key",
            transient::KEYS.iter().copied(),
        ));
    }
    transient::set(&mut changed, key, value, &study.source)?;
    runs.insert(name.to_owned(), Run::Transient(changed));
    Ok(())
}

fn design(table: &Table<'_>, study: &Study) -> Result<DesignTask, Fault> {
    let source = &study.source;
    let (first, further, place) = objectives::objectives(table, study)?;
    let constraints = match table.get("subject_to") {
        Some(value) => value
            .as_array()
            .map_err(|fault| fault.help("write `subject_to = [\"CRITERION <= VALUE\"]`"))?
            .iter()
            .map(|value| constraint(value, study))
            .collect::<Result<_, _>>()?,
        None => Vec::new(),
    };
    let references = match table.get("references") {
        Some(value) => references(&value)?,
        None => Vec::new(),
    };
    let starts = match table.get("starts") {
        Some(value) => {
            let starts = value.as_count()?;
            if starts == 0 || starts > 10_000 {
                return Err(value.fault("the number of starts lies between 1 and 10000"));
            }
            Some(starts)
        }
        None => None,
    };
    let agree = objectives::agree(table, starts)?;
    let front_points = objectives::front_points(table, further.len())?;
    let feasibility = match table.get("feasibility") {
        Some(value) => {
            let tolerance = value.as_f64()?;
            if !(0.0..1.0).contains(&tolerance) {
                return Err(
                    value.fault("the feasibility tolerance is relative and lies between 0 and 1")
                );
            }
            tolerance
        }
        None => 1e-6,
    };
    let bounds: IndexMap<String, Bounds> = match table.get("bounds") {
        Some(value) => value
            .as_table()?
            .entries()
            .map(|(name, _, value)| Ok((name.to_owned(), devices::bounds(&value, source)?)))
            .collect::<Result<_, Fault>>()?,
        None => IndexMap::new(),
    };
    let fixed = amounts_of(table.get("fixed"), source)?;
    if let Some((name, bounds)) = bounds.iter().find(|(name, _)| fixed.contains_key(*name)) {
        return Err(Fault::at(
            source,
            bounds.span,
            format!("`{name}` has bounds here and a value under `fixed`"),
        )
        .help("keep one of the two"));
    }
    Ok(DesignTask {
        objective: first.criterion,
        sense: first.sense,
        further,
        front_points,
        constraints,
        references,
        candidates: candidates(table, study)?,
        fixed,
        bounds,
        starts,
        agree,
        feasibility,
        simplify: simplify(table, study)?,
        place,
    })
}

/// Whether the best design is made smaller.
fn simplify(table: &Table<'_>, study: &Study) -> Result<bool, Fault> {
    let Some(value) = table.get("simplify") else {
        return Ok(false);
    };
    let wanted = value.as_bool()?;
    let slots = table
        .get("candidates")
        .and_then(|value| Some(value.as_table().ok()?.entries().count()));
    if wanted && slots.is_some_and(|slots| slots != 1) {
        return Err(Fault::at(
            &study.source,
            value.span(),
            "several slots are designed at once, and one at a time can be made smaller",
        )
        .help("leave `simplify` out, or design one slot in this task"));
    }
    Ok(wanted)
}

fn references(value: &Value<'_>) -> Result<Vec<(String, Span)>, Fault> {
    let mut found: Vec<(String, Span)> = Vec::new();
    for value in value.as_array()? {
        let name = value.as_str()?;
        if found.iter().any(|(known, _)| known == name) {
            return Err(value
                .fault(format!("the reference `{name}` is given twice"))
                .help("keep one of the two"));
        }
        found.push((name.to_owned(), value.span()));
    }
    Ok(found)
}

fn constraint(value: &Value<'_>, study: &Study) -> Result<Constraint, Fault> {
    let expression = value.expression()?;
    let Node::Comparison {
        operator,
        left,
        right,
    } = &expression.node
    else {
        return Err(value
            .fault(format!("`{}` is no constraint", expression.excerpt()))
            .help("write `CRITERION <= VALUE` or `CRITERION >= VALUE`"));
    };
    let sense = match operator {
        ComparisonOperator::Less | ComparisonOperator::LessOrEqual => Sense::Minimise,
        ComparisonOperator::Greater | ComparisonOperator::GreaterOrEqual => Sense::Maximise,
        ComparisonOperator::Equal | ComparisonOperator::NotEqual => {
            return Err(value
                .fault("a constraint is an inequality")
                .help("write `CRITERION <= VALUE` or `CRITERION >= VALUE`"));
        }
    };
    let criterion = |side: &Expression| match &side.node {
        Node::Name(name) if study.criteria.contains_key(name) => Some(name.clone()),
        _ => None,
    };
    let flipped = match sense {
        Sense::Minimise => Sense::Maximise,
        Sense::Maximise => Sense::Minimise,
    };
    let (criterion, sense, bound) = match (criterion(left), criterion(right)) {
        (Some(first), Some(second)) => {
            return Err(Fault::at(
                &study.source,
                right.span,
                format!("a bound is a value, but `{second}` is a criterion"),
            )
            .help(format!(
                "define a criterion for their difference, `{first} - {second}` written out, and bound it by 0"
            )));
        }
        (Some(name), None) => (name, sense, right.as_ref()),
        (None, Some(name)) => (name, flipped, left.as_ref()),
        (None, None) => {
            let Node::Name(name) = &left.node else {
                return Err(Fault::at(
                    &study.source,
                    expression.span,
                    "neither side of this constraint is a criterion",
                )
                .help("write `CRITERION <= VALUE` or `CRITERION >= VALUE`; an expression of criteria becomes a criterion under `[criteria]`"));
            };
            let fault = Fault::at(
                &study.source,
                left.span,
                format!("there is no criterion `{name}`"),
            );
            return Err(unknown(
                fault,
                name,
                "criterion",
                study.criteria.keys().map(String::as_str),
            ));
        }
    };
    Ok(Constraint {
        criterion,
        sense,
        bound: Amount::from_expression(bound.clone(), &study.source),
        swept: None,
    })
}

fn candidates(table: &Table<'_>, study: &Study) -> Result<IndexMap<Slot, CandidateSet>, Fault> {
    let value = table.get("candidates").ok_or_else(|| {
        table
            .fault("the task does not say which layouts to try")
            .help("add `candidates.DEVICE = [\"k1 | c1\", …]` or a budget `{ springs = 1, dampers = 1, inerters = 1 }`")
    })?;
    let mut found = IndexMap::new();
    for (name, span, value) in value.as_table()?.entries() {
        let slot = slot_of(study, name, span)?.ok_or_else(|| no_such_slot(study, name, span))?;
        let kinds = kinds_of(study, study.domain_of(&slot));
        let set = if value
            .as_table()
            .is_ok_and(|table| table.get("immittance").is_some())
        {
            immittance::candidates(&value, &kinds)?
        } else if value.is_table() {
            budget(&value, &kinds, study, &slot)?
        } else {
            let layouts = value
                .as_array()
                .map_err(|fault| {
                    fault.help("write a list of layouts, `[\"k1 | c1\"]`, or a budget, `{ springs = 1, dampers = 1 }`")
                })?
                .iter()
                .map(|value| Ok((named_or_layout(value, &kinds)?, value.span())))
                .collect::<Result<Vec<(Layout, Span)>, Fault>>()?;
            if layouts.is_empty() {
                return Err(value
                    .fault("there is no layout to try")
                    .help("list layouts such as `\"k1 | c1\"`"));
            }
            CandidateSet::Layouts(layouts)
        };
        let taken = found.insert(slot, set);
        refuse_second(taken.is_some(), name, span, study)?;
    }
    if found.is_empty() {
        return Err(value.fault("there is no layout to try").help(
            "add `candidates.DEVICE = [\"k1 | c1\", …]` or a budget `{ springs = 1, dampers = 1, inerters = 1 }`",
        ));
    }
    let total = crate::candidates::count(&found);
    if total > MOST_LAYOUTS {
        return Err(value
            .fault(format!(
                "these candidates give {} combinations, more than can be searched",
                rounded(total)
            ))
            .help(FEWER));
    }
    Ok(found)
}

/// A layout as written, or the one of a device of the catalogue: `catalogue: TVMD`.
fn named_or_layout(value: &Value<'_>, kinds: &Kinds) -> Result<Layout, Fault> {
    let Some(name) = value
        .as_str()
        .ok()
        .and_then(|text| text.trim().strip_prefix("catalogue:"))
        .map(str::trim)
    else {
        return devices::layout(value, kinds);
    };
    let Some(entry) = quell_network::device(name) else {
        let names = quell_network::CATALOGUE.iter().map(|entry| entry.name);
        return Err(unknown(
            value.fault(format!("the catalogue has no device `{name}`")),
            name,
            "device of the catalogue",
            names,
        ));
    };
    let Some(text) = entry.text() else {
        return Err(value
            .fault(format!(
                "`{}` joins three points, and a port has two",
                entry.name
            ))
            .help("give the host a coordinate for its mass, and a device at each of two ports"));
    };
    Layout::parse(text, kinds).map_err(|error| {
        value
            .fault(format!("`{}`: {}", entry.name, error.message))
            .help("devices of the catalogue are mechanical")
    })
}

/// A count that may be beyond what anybody reads digit by digit.
fn rounded(count: u128) -> String {
    if count < 1_000_000_000 {
        count.to_string()
    } else {
        format!("some {:.0e}", count as f64)
    }
}

/// A layout for something that takes none.
fn no_such_slot(study: &Study, name: &str, span: Span) -> Fault {
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
fn refuse_second(taken: bool, name: &str, span: Span, study: &Study) -> Result<(), Fault> {
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

fn budget(
    value: &Value<'_>,
    kinds: &Kinds,
    study: &Study,
    slot: &Slot,
) -> Result<CandidateSet, Fault> {
    let table = value.as_table()?;
    table.check(&keys::BUDGET)?;
    let equivalence = match table
        .get("reducible")
        .map(|value| value.as_bool())
        .transpose()?
    {
        Some(true) => Equivalence::Commutative,
        _ => Equivalence::Irreducible,
    };
    let by_element = ["springs", "dampers", "inerters", "masses"];
    let (budgets, branches) = match table.get("components") {
        Some(components) => {
            if let Some(span) = by_element.iter().find_map(|key| table.key_span(key)) {
                return Err(Fault::at(
                    table.source(),
                    span,
                    "a budget counts elements or components, not both",
                ));
            }
            component_budget(&table, &components, kinds, study)?
        }
        None => (element_budget(&table, kinds, &by_element)?, vec![None]),
    };
    // Names that the device's own layout has taken are left to it.
    let taken: Vec<String> = study
        .devices
        .get(&slot.device)
        .and_then(|device| device.layout.as_ref())
        .map(|layout| {
            layout
                .branches()
                .map(|branch| branch.name.clone())
                .collect()
        })
        .unwrap_or_default();
    let mut enumerations = Vec::new();
    let mut total: u128 = 0;
    for number in branches {
        let enumeration = Enumeration::new(kinds, &budgets, number, equivalence)
            .map_err(|error| match error {
                EnumerationError::TooMany => value
                    .fault("this budget has more layouts than can be numbered")
                    .help(FEWER),
                other => value.fault(other.to_string()),
            })?
            .avoiding(taken.iter().map(String::as_str));
        total = total.saturating_add(enumeration.count());
        enumerations.push(enumeration);
    }
    if total == 0 {
        return Err(value
            .fault("no layout meets this budget")
            .help("compare `branches` with `at_least` and `at_most`"));
    }
    if total > MOST_LAYOUTS {
        return Err(value
            .fault(format!(
                "this budget has {} layouts, more than can be searched",
                rounded(total)
            ))
            .help(FEWER));
    }
    Ok(CandidateSet::Budget {
        enumerations,
        span: value.span(),
    })
}

fn element_budget(
    table: &Table<'_>,
    kinds: &Kinds,
    keys: &[&str; 4],
) -> Result<Vec<Budget>, Fault> {
    use quell_network::Element::{Damper, Inerter, Mass, Spring};
    for key in ["branches", "at_least", "at_most"] {
        if let Some(span) = table.key_span(key) {
            return Err(Fault::at(
                table.source(),
                span,
                format!("`{key}` belongs to a budget of `components`"),
            ));
        }
    }
    let domain = kinds.domain();
    let mut budgets = Vec::new();
    for (key, element) in keys.iter().zip([Spring, Damper, Inerter, Mass]) {
        let Some(value) = table.get(key) else {
            continue;
        };
        let number = value.as_count()?;
        if number == 0 {
            continue;
        }
        let letter = domain
            .letter(element)
            .ok_or_else(|| value.fault(format!("a {domain} layout has no {element}")))?;
        budgets.push(Budget::exactly(&letter.to_string(), number));
    }
    if budgets.is_empty() {
        return Err(table
            .fault("this budget holds no element")
            .help("write `{ springs = 1, dampers = 1, inerters = 1 }`"));
    }
    Ok(budgets)
}

fn component_budget(
    table: &Table<'_>,
    components: &Value<'_>,
    kinds: &Kinds,
    study: &Study,
) -> Result<(Vec<Budget>, Vec<Option<usize>>), Fault> {
    let mut budgets = Vec::new();
    for value in components.as_array()? {
        let index = resolve(
            &value,
            "component",
            study.components.keys().map(String::as_str),
        )?;
        let Some((name, component)) = study.components.get_index(index) else {
            continue;
        };
        if component.domain != kinds.domain() {
            return Err(value
                .fault(format!(
                    "the component `{name}` is {}, the device {}",
                    component.domain,
                    kinds.domain()
                ))
                .help(format!(
                    "a component says its domain: `domain = \"{}\"`",
                    kinds.domain()
                )));
        }
        if budgets.iter().any(|budget: &Budget| budget.kind == *name) {
            return Err(value
                .fault(format!("the component `{name}` is listed twice"))
                .help("once is enough: `at_least` and `at_most` say how many"));
        }
        let single = component.layout.branches().count() == 1;
        budgets.push(Budget::any(name).single_element(single));
    }
    if budgets.is_empty() {
        return Err(components.fault("this budget lists no component").help(
            "write `components = [\"NAME\"]`, or a budget of elements such as `{ springs = 1 }`",
        ));
    }
    for (key, least) in [("at_least", true), ("at_most", false)] {
        let Some(value) = table.get(key) else {
            continue;
        };
        for (name, span, value) in value.as_table()?.entries() {
            let number = value.as_count()?;
            let Some(budget) = budgets.iter_mut().find(|budget| budget.kind == name) else {
                let names: Vec<String> = budgets.iter().map(|budget| budget.kind.clone()).collect();
                let fault = Fault::at(
                    table.source(),
                    span,
                    format!("`{name}` is not among the components of this budget"),
                );
                return Err(unknown(
                    fault,
                    name,
                    "component",
                    names.iter().map(String::as_str),
                ));
            };
            *budget = if least {
                budget.clone().at_least(number)
            } else {
                budget.clone().at_most(number)
            };
        }
    }
    let branches = table.get("branches").ok_or_else(|| {
        table
            .fault("this budget does not say how many branches a layout has")
            .help("add `branches = 2` or `branches = [1, 2]`")
    })?;
    let list = if branches.is_array() {
        branches.as_array()?
    } else {
        vec![branches.clone()]
    };
    let mut numbers: Vec<Option<usize>> = Vec::new();
    for value in list {
        let number = value.as_count()?;
        if number == 0 {
            return Err(value.fault("a layout has at least one branch"));
        }
        if numbers.contains(&Some(number)) {
            return Err(value.fault(format!("{number} branches are listed twice")));
        }
        numbers.push(Some(number));
    }
    Ok((budgets, numbers))
}
