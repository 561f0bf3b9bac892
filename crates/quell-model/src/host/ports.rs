//! `[ports.NAME]`: where devices can act.

use quell_document::{Fault, Table};

use super::elements::carried;
use super::file::Host;
use super::keys;
use super::names::Names;
use super::points;
use super::system::Base;
use crate::linear::Port;

/// Reads all ports.
pub(super) fn ports(
    host: &Host,
    table: &Table<'_>,
    base: Option<&Base>,
) -> Result<Vec<Port>, Fault> {
    let mut names = Names::default();
    let mut ports = Vec::new();
    for (name, span, value) in table.entries() {
        names.define(table.source(), name, span, "a port")?;
        if host.elements.iter().any(|element| element.name == name) {
            return Err(Fault::at(
                table.source(),
                span,
                format!("`{name}` is already the name of an element"),
            ));
        }
        let entry = value.as_table()?;
        entry.check(&keys::PORT)?;
        if let Some(force) = entry.get("force") {
            return Err(force
                .fault("a symbol for the force belongs to a host written as equations")
                .help("leave `force` out: it acts by virtual work"));
        }
        let given: Vec<_> = entry.entries().collect();
        let [(key, _, value)] = &given[..] else {
            return Err(entry
                .fault(format!(
                    "the port `{name}` needs one of `between`, `across` and `at`"
                ))
                .help("for example `between = [\"x1\", \"ground\"]`"));
        };
        let (mut motion, grounded) = match *key {
            "between" => points::between(host, &points::pair(value)?, base)?,
            "across" => {
                let motion = points::motion(host, value, &value.expression()?, base)?;
                // One coordinate alone is its motion relative to the ground.
                let terms = motion
                    .coordinates
                    .iter()
                    .filter(|&&coefficient| coefficient != 0.0)
                    .count();
                let grounded = terms == 1 && motion.is_free_of_inputs();
                (motion, grounded)
            }
            _ => {
                let motion = points::point(host, value, base)?
                    .ok_or_else(|| value.fault("a device cannot hang on the ground"))?;
                (motion, true)
            }
        };
        if motion.is_free_of_coordinates() {
            return Err(value.fault("no coordinate of the host moves this port"));
        }
        let hangs = *key == "at";
        if let Some(base) = base
            && hangs
        {
            // The far end of a hanging device is in the inertial frame, so the base's motion counts.
            motion.inputs[base.input] += carried(&motion.coordinates, base);
        }
        ports.push(Port {
            name: name.to_owned(),
            coordinates: motion.coordinates,
            inputs: motion.inputs,
            kind: motion.kind,
            hangs,
            grounded: grounded && (hangs || base.is_none()),
        });
    }
    Ok(ports)
}
