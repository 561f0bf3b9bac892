//! Devices with their values and drawings.

use quell_model::Port;
use quell_study::{BuiltDevice, NamedValue};

use super::Bridge;
use crate::layout::Annotations;
use crate::page::{Bounds, DesignValue, Device, Quantity, Side};
use crate::schematic::Terminal;

impl Bridge<'_> {
    /// The devices of a configuration; `active` names the variables at a bound, as in `k1 = lower`.
    pub(super) fn devices(&self, built: &[BuiltDevice], active: &[String]) -> Vec<Device> {
        built
            .iter()
            .map(|device| self.device(device, active))
            .collect()
    }

    fn device(&self, built: &BuiltDevice, active: &[String]) -> Device {
        let components = self
            .study
            .components
            .iter()
            .map(|(name, component)| (name.clone(), component.layout.clone()))
            .collect();
        let known = Annotations {
            components,
            ..Annotations::default()
        };
        let values = built
            .variables
            .iter()
            .map(|value| design_value(value, &built.name, active))
            .collect();
        let (head, tail) = self.terminals(&built.name);
        Device {
            // The frame around a slot is the same everywhere: the picture shows it, the words need not.
            layout: built.designed.clone(),
            ..Device::drawn(&built.name, &built.layout, values, &known, head, tail)
        }
    }

    /// What the ends of a device are connected to.
    fn terminals(&self, device: &str) -> (Terminal, Terminal) {
        let Some(device) = self.study.devices.get(device) else {
            return (Terminal::Open, Terminal::Open);
        };
        let names = self.standing.as_ref().and_then(|standing| {
            let port = standing
                .host
                .ports
                .iter()
                .find(|port| port.name == device.port)?;
            let coordinates = standing.host.coordinates.iter().map(|known| &known.name);
            let inputs = standing.host.inputs.iter().map(|known| &known.name);
            let terms: Vec<(&String, f64)> = coordinates
                .zip(&port.coordinates)
                .chain(inputs.zip(&port.inputs))
                .map(|(name, share)| (name, *share))
                .filter(|(_, share)| *share != 0.0)
                .collect();
            Some(ends(port, &terms))
        });
        names.unwrap_or_else(|| (Terminal::Point(device.port.clone()), Terminal::Open))
    }
}

/// The points of a port where each end is just one, else the port's name.
fn ends(port: &Port, terms: &[(&String, f64)]) -> (Terminal, Terminal) {
    let ground = port.grounded || port.hangs;
    match terms {
        [(head, share)] if *share == 1.0 && ground => {
            (Terminal::Point((*head).clone()), Terminal::Ground)
        }
        [(one, 1.0), (other, -1.0)] | [(other, -1.0), (one, 1.0)] if !ground => (
            Terminal::Point((*one).clone()),
            Terminal::Point((*other).clone()),
        ),
        _ if ground => (Terminal::Point(port.name.clone()), Terminal::Ground),
        _ => (Terminal::Point(port.name.clone()), Terminal::Open),
    }
}

fn design_value(value: &NamedValue, device: &str, active: &[String]) -> DesignValue {
    let side = active.iter().find_map(|text| {
        let (name, side) = text.split_once(" = ")?;
        let own = name
            .strip_prefix(device)
            .and_then(|rest| rest.strip_prefix('.'));
        if name != value.name && own != Some(value.name.as_str()) {
            return None;
        }
        match side {
            "lower" => Some(Side::Lower),
            "upper" => Some(Side::Upper),
            _ => None,
        }
    });
    DesignValue {
        name: value.name.clone(),
        value: Quantity::new(value.value, &value.unit),
        bounds: value.bounds.map(|(lower, upper)| Bounds {
            lower,
            upper,
            logarithmic: value.logarithmic,
        }),
        active: side,
    }
}
