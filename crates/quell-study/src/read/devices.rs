//! Declared elements, components and devices.

use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::{Fault, Source, Table, Value};
use quell_expression::Span;
use quell_model::LinearHost;
use quell_model::linear::CoordinateKind;
use quell_network::{Domain, Element, Kind, KindError, Kinds, Layout, LayoutError};
use quell_search::Scale;

use super::{amounts_of, check_name, counted, named_tables, resolve, unknown};
use crate::amount::Amount;
use crate::keys;
use crate::study::{Bounds, Component, Declared, Device, ForceLawSpec};

/// The slot of a device that lists none.
const USUAL_SLOT: &str = "network";

/// A component before its layout is parsed: the text and its place in the file.
pub(super) struct RawComponent<'a> {
    domain: Domain,
    layout: Value<'a>,
    values: IndexMap<String, Amount>,
    value_spans: IndexMap<String, Span>,
    variables: IndexMap<String, Bounds>,
}

pub(super) fn domain(value: &Value<'_>) -> Result<Domain, Fault> {
    Ok(
        match value.one_of(&["translational", "rotational", "electrical", "hydraulic"])? {
            "rotational" => Domain::Rotational,
            "electrical" => Domain::Electrical,
            "hydraulic" => Domain::Hydraulic,
            _ => Domain::Translational,
        },
    )
}

pub(super) fn components<'a>(
    value: Option<Value<'a>>,
    source: &Arc<Source>,
) -> Result<IndexMap<String, RawComponent<'a>>, Fault> {
    let mut components = IndexMap::new();
    let Some(value) = value else {
        return Ok(components);
    };
    let table = value.as_table()?;
    for (name, span, value) in table.entries() {
        check_name(name, span, &table)?;
        let entry = value.as_table()?;
        entry.check(&keys::COMPONENT)?;
        let domain = entry
            .get("domain")
            .map_or(Ok(Domain::Translational), |value| domain(&value))?;
        let values_table = entry.require("values")?.as_table()?;
        let mut variables = IndexMap::new();
        if let Some(value) = entry.get("variables") {
            let table = value.as_table()?;
            for (variable, span, value) in table.entries() {
                check_name(variable, span, &table)?;
                variables.insert(variable.to_owned(), bounds(&value, source)?);
            }
        }
        components.insert(
            name.to_owned(),
            RawComponent {
                domain,
                layout: entry.require("layout")?,
                value_spans: values_table
                    .entries()
                    .map(|(name, span, _)| (name.to_owned(), span))
                    .collect(),
                values: amounts_of(entry.get("values"), source)?,
                variables,
            },
        );
    }
    Ok(components)
}

/// The nonlinear elements.
pub(super) fn laws(
    elements: Option<Value<'_>>,
    source: &Arc<Source>,
) -> Result<IndexMap<String, ForceLawSpec>, Fault> {
    let mut laws = IndexMap::new();
    let Some(value) = elements else {
        return Ok(laws);
    };
    let table = value.as_table()?;
    for (name, span, value) in table.entries() {
        let entry = value.as_table()?;
        entry.check(&keys::ELEMENT)?;
        let Some(force) = entry.get("force") else {
            for key in ["parameters", "stores", "dissipates"] {
                if let Some(stranger) = entry.key_span(key) {
                    return Err(Fault::at(
                        source,
                        stranger,
                        format!("`{key}` belongs to a nonlinear element, which has a `force`"),
                    ));
                }
            }
            continue;
        };
        for key in ["kind", "domain"] {
            if let Some(stranger) = entry.key_span(key) {
                return Err(Fault::at(
                    source,
                    stranger,
                    format!("an element has a `{key}` or a `force`, not both"),
                )
                .help("a `force` makes it nonlinear, in translation and rotation alike"));
            }
        }
        let mut parameters = IndexMap::new();
        if let Some(value) = entry.get("parameters") {
            let table = value.as_table()?;
            for (parameter, span, value) in table.entries() {
                check_name(parameter, span, &table)?;
                if matches!(parameter, "x" | "v") {
                    return Err(Fault::at(
                        source,
                        span,
                        format!("`{parameter}` is the element's own motion"),
                    )
                    .help("choose another name: `x` is its relative displacement, `v` the rate"));
                }
                parameters.insert(parameter.to_owned(), Amount::read(&value, source)?);
            }
        }
        let force = force.expression()?;
        if !force.names().iter().any(|own| matches!(*own, "x" | "v")) {
            return Err(Fault::at(
                source,
                span,
                format!("the force of `{name}` depends neither on `x` nor on `v`"),
            )
            .help(
                "`x` is the element's relative displacement, `v` its rate: `force = \"k3*x^3\"`",
            ));
        }
        let flag = |key: &str| entry.get(key).map(|value| value.as_bool()).transpose();
        let law = ForceLawSpec {
            force,
            parameters,
            stores: flag("stores")?.unwrap_or(false),
            dissipates: flag("dissipates")?.unwrap_or(false),
            span,
        };
        if law.stores && law.dissipates {
            return Err(Fault::at(
                source,
                span,
                format!("`{name}` cannot both store and dissipate all that it takes"),
            )
            .help("split it into two elements side by side, or say neither"));
        }
        laws.insert(name.to_owned(), law);
    }
    Ok(laws)
}

/// The kinds of branch that layouts may name, in each domain.
pub(super) fn declared(
    elements: Option<Value<'_>>,
    laws: &IndexMap<String, ForceLawSpec>,
    components: &IndexMap<String, RawComponent<'_>>,
    components_value: Option<Value<'_>>,
) -> Result<Declared, Fault> {
    let mut tables: Vec<(Domain, Kinds)> = Domain::ALL
        .into_iter()
        .map(|domain| (domain, Kinds::new(domain)))
        .collect();
    let mut declare = |wanted: Domain, act: &dyn Fn(&mut Kinds) -> Result<(), KindError>| {
        tables
            .iter_mut()
            .filter(|(domain, _)| *domain == wanted)
            .try_for_each(|(_, kinds)| act(kinds))
    };
    if let Some(value) = elements {
        let table = value.as_table()?;
        for (name, span, value) in table.entries() {
            check_name(name, span, &table)?;
            let entry = value.as_table()?;
            entry.check(&keys::ELEMENT)?;
            if let Some(law) = laws.get(name) {
                let names = law.force.names();
                let [displacement, rate] = ["x", "v"].map(|own| names.contains(&own));
                for domain in [Domain::Translational, Domain::Rotational] {
                    declare(domain, &|kinds| {
                        kinds.declare_custom(name, displacement, rate)
                    })
                    .map_err(|error| Fault::at(table.source(), span, error.to_string()))?;
                }
                continue;
            }
            let element = match entry
                .require("kind")
                .map_err(|fault| {
                    fault.help(
                        "say what it is, `kind = \"spring\"`, or its force, `force = \"k*x^3\"`",
                    )
                })?
                .one_of(&["spring", "damper", "inerter", "mass"])?
            {
                "spring" => Element::Spring,
                "damper" => Element::Damper,
                "inerter" => Element::Inerter,
                _ => Element::Mass,
            };
            let wanted = entry
                .get("domain")
                .map_or(Ok(Domain::Translational), |value| domain(&value))?;
            declare(wanted, &|kinds| kinds.declare_element(name, element))
                .map_err(|error| Fault::at(table.source(), span, error.to_string()))?;
        }
    }
    if let Some(value) = components_value {
        let table = value.as_table()?;
        for (name, span, _) in table.entries() {
            let Some(component) = components.get(name) else {
                continue;
            };
            declare(component.domain, &|kinds| kinds.declare_component(name))
                .map_err(|error| Fault::at(table.source(), span, error.to_string()))?;
        }
    }
    Ok(Declared { tables })
}

/// Parses a layout that stands in a text value; faults point into the text.
pub(super) fn layout(value: &Value<'_>, kinds: &Kinds) -> Result<Layout, Fault> {
    Layout::parse(value.as_str()?, kinds).map_err(|error| layout_fault(value, error))
}

fn layout_fault(value: &Value<'_>, error: LayoutError) -> Fault {
    let fault = Fault::at(value.source(), value.text_span(error.span), error.message);
    match error.help {
        Some(help) => fault.help(help),
        None => fault,
    }
}

pub(super) fn component_layouts(
    raw: IndexMap<String, RawComponent<'_>>,
    kinds: &Declared,
) -> Result<IndexMap<String, Component>, Fault> {
    raw.into_iter()
        .map(|(name, raw)| {
            let table = kinds.of(raw.domain).cloned().unwrap_or_else(|| Kinds::new(raw.domain));
            let layout = layout(&raw.layout, &table)?;
            for branch in layout.branches() {
                if !matches!(branch.kind, Kind::Element(_)) {
                    return Err(raw.layout.fault(format!(
                        "the component `{name}` holds `{}`, which is no element; components cannot be nested",
                        branch.name
                    )));
                }
                if !raw.values.contains_key(&branch.name) {
                    return Err(raw
                        .layout
                        .fault(format!("the element `{}` of `{name}` has no value", branch.name))
                        .help(format!("write it under `values`: `{} = …`", branch.name)));
                }
            }
            for (element, span) in &raw.value_spans {
                if layout.branch(element).is_none() {
                    return Err(unknown(
                        Fault::at(
                            raw.layout.source(),
                            *span,
                            format!("`{element}` is not in the layout `{layout}`"),
                        ),
                        element,
                        "element",
                        layout.branches().map(|branch| branch.name.as_str()).collect::<Vec<_>>().into_iter(),
                    ));
                }
            }
            let component = Component {
                domain: raw.domain,
                layout,
                values: raw.values,
                variables: raw.variables,
            };
            refuse_idle_variables(&name, &component, raw.layout.source())?;
            Ok((name, component))
        })
        .collect()
}

/// A variable that no value uses would be searched in vain.
fn refuse_idle_variables(
    name: &str,
    component: &Component,
    source: &Arc<Source>,
) -> Result<(), Fault> {
    for (variable, bounds) in &component.variables {
        let used = component
            .values
            .values()
            .any(|value| value.expression().names().contains(&variable.as_str()));
        if !used {
            return Err(Fault::at(
                source,
                bounds.span,
                format!("no value of the component `{name}` uses its variable `{variable}`"),
            )
            .help("remove it, or use it under `values`"));
        }
    }
    Ok(())
}

/// `[lower, upper]`, or a table with `bounds` and `scale`.
pub(super) fn bounds(value: &Value<'_>, source: &Arc<Source>) -> Result<Bounds, Fault> {
    let (list, scale) = if value.is_table() {
        let table = value.as_table()?;
        table.check(&keys::BOUNDS_TABLE)?;
        let scale = table
            .get("scale")
            .map(|value| value.one_of(&["linear", "log"]))
            .transpose()?
            .map(|scale| {
                if scale == "log" {
                    Scale::Logarithmic
                } else {
                    Scale::Linear
                }
            });
        (table.require("bounds")?, scale)
    } else {
        (value.clone(), None)
    };
    match list.as_array()?.as_slice() {
        [lower, upper] => Ok(Bounds {
            lower: Amount::read(lower, source)?,
            upper: Amount::read(upper, source)?,
            scale,
            span: list.span(),
        }),
        other => Err(list
            .fault(format!(
                "bounds are a lower and an upper value, found {}",
                counted(other.len(), "value")
            ))
            .help("write `[lower, upper]`")),
    }
}

/// The layout around a device's slots, and the slots; neither where the whole device is designed.
fn frame(entry: &Table<'_>, mut kinds: Kinds) -> Result<(Option<Layout>, Vec<String>), Fault> {
    let Some(value) = entry.get("layout") else {
        for key in ["slots", "values"] {
            if let Some(span) = entry.key_span(key) {
                return Err(Fault::at(
                    entry.source(),
                    span,
                    format!("`{key}` belongs to a device with a `layout` of its own"),
                )
                .help("without `layout` the whole device is designed, and tasks give its values"));
            }
        }
        return Ok((None, Vec::new()));
    };
    let listed = match entry.get("slots") {
        Some(value) => value.as_array()?,
        None => Vec::new(),
    };
    let mut slots = Vec::new();
    for slot in &listed {
        let name = slot.as_str()?;
        kinds
            .declare_placeholder(name)
            .map_err(|error| slot.fault(error.to_string()))?;
        slots.push(name.to_owned());
    }
    if entry.get("slots").is_none() {
        kinds
            .declare_placeholder(USUAL_SLOT)
            .map_err(|error| value.fault(error.to_string()))?;
    }
    let layout = layout(&value, &kinds)?;
    if entry.get("slots").is_none() && layout.branch(USUAL_SLOT).is_some() {
        slots.push(USUAL_SLOT.to_owned());
    }
    for slot in &listed {
        let name = slot.as_str()?;
        if layout.branch(name).is_none() {
            return Err(slot
                .fault(format!("the slot `{name}` is not in the layout `{layout}`"))
                .help("put it into the layout, or remove it here"));
        }
    }
    if let Some(values) = entry.get("values") {
        for (name, span, _) in values.as_table()?.entries() {
            let branch = name.split_once('.').map_or(name, |(branch, _)| branch);
            if layout.branch(branch).is_none() || slots.iter().any(|slot| slot == branch) {
                let elements: Vec<&str> = layout
                    .branches()
                    .map(|branch| branch.name.as_str())
                    .filter(|name| !slots.iter().any(|slot| slot == name))
                    .collect();
                let fault = Fault::at(
                    entry.source(),
                    span,
                    format!("`{name}` is no element of the layout `{layout}`"),
                );
                return Err(unknown(fault, name, "element", elements.into_iter()));
            }
        }
    }
    Ok((Some(layout), slots))
}

pub(super) fn devices(
    value: &Value<'_>,
    kinds: &Declared,
    host: &LinearHost,
    source: &Arc<Source>,
) -> Result<IndexMap<String, Device>, Fault> {
    let table = named_tables(value, "devices")?;
    let mut devices = IndexMap::new();
    for (name, span, value) in table.entries() {
        check_name(name, span, &table)?;
        let entry = named_tables(&value, "devices")?;
        entry.check(&keys::DEVICE)?;
        let port_value = entry.require("port")?;
        let index = resolve(
            &port_value,
            "port",
            host.ports.iter().map(|port| port.name.as_str()),
        )?;
        let port = host
            .ports
            .get(index)
            .ok_or_else(|| port_value.fault("there is no such port"))?;
        let own = match port.kind {
            CoordinateKind::Translation => Domain::Translational,
            CoordinateKind::Rotation => Domain::Rotational,
        };
        let domain = entry.get("domain").map_or(Ok(own), |value| {
            let stated = domain(&value)?;
            let mechanical = matches!(stated, Domain::Translational | Domain::Rotational);
            if mechanical && stated != own {
                return Err(value.fault(format!(
                    "the port `{}` is {own}, the device {stated}",
                    port.name
                )));
            }
            Ok(stated)
        })?;
        let piston = entry
            .get("piston")
            .map(|value| Amount::read(&value, source))
            .transpose()?;
        match (&piston, domain) {
            (None, Domain::Hydraulic) => {
                return Err(Fault::at(
                    source,
                    span,
                    format!(
                        "the hydraulic device `{name}` acts through a piston, whose area is missing"
                    ),
                )
                .help("add `piston = \"2.5e-3 m^2\"`"));
            }
            (Some(piston), other) if other != Domain::Hydraulic => {
                return Err(piston
                    .fault(format!(
                        "a piston belongs to a hydraulic device, and `{name}` is {other}"
                    ))
                    .help("write `domain = \"hydraulic\"` for a device whose layouts are of fluid, or remove the piston"));
            }
            _ => {}
        }
        let own = kinds
            .of(domain)
            .cloned()
            .unwrap_or_else(|| Kinds::new(domain));
        let (fixed, slots) = frame(&entry, own)?;
        devices.insert(
            name.to_owned(),
            Device {
                port: port.name.clone(),
                port_span: port_value.span(),
                domain,
                piston,
                layout: fixed,
                slots,
                values: amounts_of(entry.get("values"), source)?,
                span,
            },
        );
    }
    Ok(devices)
}
