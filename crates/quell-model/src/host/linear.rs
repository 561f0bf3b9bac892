//! `[linear]`: elements, matrices, base and damping become the host's matrices.

use std::path::Path;

use faer::Mat;
use quell_document::{Fault, Table, Value};
use quell_expression::Dimension;

use super::coordinates::Layout;
use super::damping::{self, DampingError, Indefinite, Ratios};
use super::elements::{self, amount, direction, motions, ratio};
use super::file::Host;
use super::keys;
use super::matrices::{self, Given};
use super::system::{Base, Motion, System};
use crate::linear::InputKind;

/// Fills in the matrices and the forcing by motions; returns the moving base if there is one.
pub(super) fn stamp(
    host: &mut Host,
    layout: &Layout,
    linear: &Table<'_>,
    folder: &Path,
) -> Result<Option<Base>, Fault> {
    let mut system = System::new(layout.free.len(), layout.inputs.len());
    let base = linear
        .get("base")
        .map(|value| base(host, layout, linear, &value))
        .transpose()?;
    for (index, &row) in layout.free.iter().enumerate() {
        let row = &layout.rows[row];
        if row.inertia > 0.0 {
            let mut motion = Motion::none(layout.free.len(), layout.inputs.len(), row.kind);
            motion.coordinates[index] = 1.0;
            system.mass(&motion, row.inertia);
        }
    }
    elements::stamp(host, &mut system, linear, base.as_ref())?;
    if let Some(value) = linear.get("matrices") {
        let given = matrices::read(&value, layout, &host.parameters, folder)?;
        add(&mut system, layout, &given);
        if let Some(place) = &given.mass_place {
            check_mass(&system, host, place)?;
        }
    }
    if let Some(base) = &base {
        system.base_excitation(base);
    }
    let mut loss = None;
    if let Some(value) = linear.get("damping") {
        loss = damp(host, &mut system, &value)?;
    }
    let own_loss = system.loss.norm_max() > 0.0;
    if loss.is_some() || own_loss {
        let factor = loss.unwrap_or(0.0);
        host.linear.loss = Some(Mat::from_fn(
            layout.free.len(),
            layout.free.len(),
            |row, column| factor * system.stiffness[(row, column)] + system.loss[(row, column)],
        ));
    }
    host.linear.mass = system.total_mass();
    host.linear.stiffness = system.total_stiffness();
    host.linear.damping = system.damping;
    host.linear.forcing = system.forcing;
    Ok(base)
}

/// Adds the columns of forces and moments to F0.
pub(super) fn forces(
    host: &mut Host,
    inputs: &Table<'_>,
    base: Option<&Base>,
) -> Result<(), Fault> {
    for index in 0..host.linear.inputs.len() {
        if host.linear.inputs[index].kind != InputKind::Force {
            continue;
        }
        let entry = inputs
            .require(&host.linear.inputs[index].name)?
            .as_table()?;
        let column = direction(host, &entry.require("on")?, index, base)?;
        for (row, coefficient) in column.into_iter().enumerate() {
            host.linear.forcing[0][(row, index)] += coefficient;
        }
    }
    Ok(())
}

/// Adds given matrices; rows and columns of supports become forcing.
fn add(system: &mut System, layout: &Layout, given: &Given) {
    let mut place =
        |matrix: &Option<Mat<f64>>, target: fn(&mut System) -> &mut Mat<f64>, order: usize| {
            let Some(matrix) = matrix else {
                return;
            };
            for (i, &row) in layout.free.iter().enumerate() {
                for (j, &column) in layout.free.iter().enumerate() {
                    target(system)[(i, j)] += matrix[(row, column)];
                }
                for (column, support) in layout.rows.iter().enumerate() {
                    if let Some(input) = support.input {
                        system.forcing[order][(i, input)] -= matrix[(row, column)];
                    }
                }
            }
        };
    place(&given.mass, |system| &mut system.mass, 2);
    place(&given.damping, |system| &mut system.damping, 1);
    place(&given.stiffness, |system| &mut system.stiffness, 0);
}

fn check_mass(system: &System, host: &Host, place: &quell_document::Fault) -> Result<(), Fault> {
    let name = |index: usize| host.linear.coordinates[index].name.as_str();
    let message = match damping::check_semi_definite(&system.mass) {
        Ok(()) => return Ok(()),
        Err(Indefinite::Diagonal(index)) => {
            format!("the mass on the diagonal of `{}` is negative", name(index))
        }
        Err(Indefinite::Coupled(index, other)) => format!(
            "the mass matrix couples `{}` to `{}`, but gives `{}` no mass on the diagonal",
            name(index),
            name(other),
            name(index)
        ),
        Err(Indefinite::Combination) => {
            "the mass matrix has a negative eigenvalue, so some motion would have negative kinetic energy".to_owned()
        }
    };
    Err(Fault {
        message,
        ..place.clone()
    })
}

fn base(
    host: &Host,
    layout: &Layout,
    linear: &Table<'_>,
    value: &Value<'_>,
) -> Result<Base, Fault> {
    let table = value.as_table()?;
    table.check(&keys::BASE)?;
    if linear.get("supports").is_some() {
        return Err(value
            .fault("`base` and `supports` cannot be used together")
            .help("`base` makes all coordinates relative to it, `supports` keeps them absolute"));
    }
    let named = table.require("input")?;
    let name = named.as_str()?;
    let Some(input) = layout.inputs.iter().position(|input| input.name == name) else {
        let fault = named.fault(format!("there is no input `{name}`"));
        let names = layout.inputs.iter().map(|input| input.name.as_str());
        return Err(match quell_expression::nearest(name, names) {
            Some(near) => fault.help(format!("did you mean `{near}`?")),
            None => fault.help("inputs are declared under `[inputs]`"),
        });
    };
    let moved = &layout.inputs[input];
    if moved.kind == InputKind::Force {
        return Err(named.fault(format!(
            "`{name}` is a force; a base is moved by a displacement, a velocity or an acceleration"
        )));
    }
    let list = table.require("influence")?;
    let entries = list.as_array()?;
    if entries.len() != layout.free.len() {
        return Err(list.fault(format!(
            "`influence` has {} entries, but there are {} coordinates",
            entries.len(),
            layout.free.len()
        )));
    }
    let influence = entries
        .iter()
        .zip(&layout.free)
        .map(|(entry, &row)| {
            let dimension = layout.rows[row].kind.dimension() / moved.motion.dimension();
            ratio(&host.parameters, entry, dimension)
        })
        .collect::<Result<_, _>>()?;
    Ok(Base { influence, input })
}

/// Adds damping of the host as a whole; returns its loss factor if that is how it is given.
fn damp(host: &Host, system: &mut System, value: &Value<'_>) -> Result<Option<f64>, Fault> {
    let table = value.as_table()?;
    table.check(&keys::DAMPING)?;
    let motions = motions(host);
    let fail = |error: DampingError| Fault {
        help: error.help,
        ..value.fault(error.message)
    };
    let given: Vec<_> = table.entries().collect();
    let [(key, _, given)] = &given[..] else {
        return Err(value.fault("expected one of `modal`, `rayleigh` and `loss`"));
    };
    match *key {
        "modal" => {
            let ratio = |value: &Value<'_>| {
                amount(&host.parameters, value, Dimension::NONE, "damping ratio")
            };
            let ratios = if given.is_array() {
                Ratios::Each(
                    given
                        .as_array()?
                        .iter()
                        .map(ratio)
                        .collect::<Result<_, _>>()?,
                )
            } else {
                Ratios::All(ratio(given)?)
            };
            system.add_modal(&ratios, &motions).map_err(fail)?;
            Ok(None)
        }
        "rayleigh" => {
            let pair = given.as_table()?;
            pair.check(&keys::RAYLEIGH)?;
            let rate = Dimension::NONE / Dimension::TIME;
            let read = |key: &str, dimension| {
                pair.get(key).map_or(Ok(0.0), |value| {
                    amount(&host.parameters, &value, dimension, key)
                })
            };
            let (alpha, beta) = (read("alpha", rate)?, read("beta", Dimension::TIME)?);
            system.add_rayleigh(alpha, beta, &motions).map_err(fail)?;
            Ok(None)
        }
        _ => {
            let factor = amount(&host.parameters, given, Dimension::NONE, "loss factor")?;
            if factor > 0.0 && system.stiffness_touches(&motions) {
                return Err(given
                    .fault("a loss factor cannot be given to stiffness that ends on a prescribed motion")
                    .help("make the coordinates relative to the moving base, `base = { influence = […], input = … }`, and end the springs on `ground`"));
            }
            Ok(Some(factor).filter(|factor| *factor > 0.0))
        }
    }
}
