//! The energy ledger of a run in time.

use quell_model::system::{Device, Quantity};
use quell_network::{Element, Law};
use quell_response::transient::Record;

use super::plan::Watching;
use crate::results::{ElementEnergy, Ledger, PortEnergy};
use crate::study::Study;

/// What becomes of the energy that an element takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fate {
    /// A spring's, or that of an element that stores.
    Potential,
    /// An inerter's or mass's.
    Kinetic,
    /// Turned into heat.
    Dissipated,
    /// A nonlinear element that says neither.
    Other,
}

impl Fate {
    /// What becomes of the energy of an element of a device.
    pub(crate) fn of(study: &Study, device: &Device, element: usize) -> Self {
        let Some(element) = device.mechanism.elements().get(element) else {
            return Self::Other;
        };
        match &element.law {
            Law::Linear(linear) => match linear.element {
                Element::Spring => Self::Potential,
                Element::Damper => Self::Dissipated,
                Element::Inerter | Element::Mass => Self::Kinetic,
            },
            Law::Custom(custom) => match study.laws.get(&custom.law) {
                Some(law) if law.stores => Self::Potential,
                Some(law) if law.dissipates => Self::Dissipated,
                _ => Self::Other,
            },
        }
    }

    const fn word(self) -> &'static str {
        match self {
            Self::Potential => "potential",
            Self::Kinetic => "kinetic",
            Self::Dissipated => "dissipated",
            Self::Other => "other",
        }
    }
}

/// The signals from which a ledger is made.
#[derive(Debug)]
pub(crate) struct LedgerSignals {
    kinetic: usize,
    host: usize,
    inputs: usize,
    /// Port, what the host gives there, what its devices receive.
    ports: Vec<(String, usize, usize)>,
    /// Name, fate and power of every element.
    elements: Vec<(String, Fate, usize)>,
}

impl LedgerSignals {
    pub(crate) fn of(study: &Study, watching: &Watching<'_>) -> Self {
        let devices = watching.devices();
        let mut ports: Vec<usize> = devices.iter().map(|device| device.port).collect();
        ports.sort_unstable();
        ports.dedup();
        let mut elements = Vec::new();
        for (index, device) in devices.iter().enumerate() {
            for (place, element) in device.mechanism.elements().iter().enumerate() {
                elements.push((
                    format!("{}.{}", device.name, element.name),
                    Fate::of(study, device, place),
                    watching.quantity(Quantity::ElementPower {
                        device: index,
                        element: place,
                    }),
                ));
            }
        }
        Self {
            kinetic: watching.quantity(Quantity::Kinetic),
            host: watching.quantity(Quantity::HostPower),
            inputs: watching.quantity(Quantity::InputPower),
            ports: ports
                .into_iter()
                .map(|port| {
                    (
                        watching.port_name(port),
                        watching.quantity(Quantity::PortPower { port }),
                        watching.quantity(Quantity::PortReceived { port }),
                    )
                })
                .collect(),
            elements,
        }
    }

    /// The ledger from the start of a run to its end.
    ///
    /// ```text
    /// kinetic_end - kinetic_start = host - Σ_ports given,   Σ_ports received = Σ_elements
    /// error = |kinetic_end - kinetic_start - host + Σ_ports (given - received) + Σ_elements| / largest entry
    /// ```
    pub(crate) fn read(&self, record: &mut Record<'_>, start: f64, end: f64) -> Ledger {
        record.between(Some(start), Some(end));
        let kinetic_start = record.value(self.kinetic, start);
        let kinetic_end = record.value(self.kinetic, end);
        let host = record.integral(self.host).value;
        let inputs = record.integral(self.inputs).value;
        let mut error = kinetic_end - kinetic_start - host;
        let mut largest = kinetic_start.abs().max(kinetic_end.abs()).max(host.abs());
        let mut ports = indexmap::IndexMap::new();
        for (name, given, received) in &self.ports {
            let (given, received) = (
                record.integral(*given).value,
                record.integral(*received).value,
            );
            error += given - received;
            largest = largest.max(given.abs());
            ports.insert(
                name.clone(),
                PortEnergy {
                    given,
                    received,
                    mismatch: given - received,
                },
            );
        }
        let mut elements = indexmap::IndexMap::new();
        for (name, fate, power) in &self.elements {
            let energy = record.integral(*power).value;
            error += energy;
            largest = largest.max(energy.abs());
            elements.insert(
                name.clone(),
                ElementEnergy {
                    kind: fate.word(),
                    energy,
                },
            );
        }
        Ledger {
            kinetic_start,
            kinetic_end,
            host,
            inputs,
            ports,
            elements,
            error: if largest > 0.0 {
                error.abs() / largest
            } else {
                0.0
            },
        }
    }
}
