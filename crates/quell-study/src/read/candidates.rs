//! Candidate layouts of a design: named, listed, or enumerated from a budget.

use indexmap::IndexMap;
use quell_document::{Fault, Table, Value};
use quell_expression::Span;
use quell_network::{Budget, Enumeration, EnumerationError, Equivalence, Kinds, Layout};

use super::slots::{kinds_of, no_such_slot, refuse_second, slot_of};
use super::{devices, immittance, resolve, unknown};
use crate::keys;
use crate::study::{CandidateSet, Slot, Study};

/// A search gives up on nothing, but a list of more layouts than this would not end within a working day.
const MOST_LAYOUTS: u128 = 1_000_000;

/// What to do about too many layouts.
const FEWER: &str = "lower the numbers, or list the layouts of interest";

pub(super) fn candidates(
    table: &Table<'_>,
    study: &Study,
) -> Result<IndexMap<Slot, CandidateSet>, Fault> {
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
pub(super) fn named_or_layout(value: &Value<'_>, kinds: &Kinds) -> Result<Layout, Fault> {
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
