//! A configuration as a system with free parameters.

use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::Fault;
use quell_expression::{Dimension, Quantity, Slot, Span, Unit};
use quell_model::system::{EquilibriumStatus, Owner, Slopes, StateKind, System};
use quell_model::{EquationHost, Measure as CoordinateMeasure};

use super::ask::{ContinuationTask, Measure, ParameterRange};
use super::field::{Assignment, Field};
use super::forcing::Forcing;
use super::measure::{self, Compiled};
use super::moving::{Entry, Moving};
use crate::amount::Amount;
use crate::built::{Built, Places, ValueScratch, Values};
use crate::configuration;
use crate::outcome::BuiltDevice;
use crate::situation::Situation;
use crate::study::{Bounds, ConfigurationSpec, Study};
use crate::transient::{ValuePlaces, Watching, sources};

/// A free parameter.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    /// Its name in the study.
    pub(super) name: String,
    /// Its SI unit.
    pub(super) unit: String,
    /// Its SI dimension.
    pub(super) dimension: Dimension,
    /// Its value in the configuration, SI.
    pub(super) base: f64,
    /// Its range, SI.
    pub(super) range: (f64, f64),
    /// Whether its lower end is left out.
    pub(super) open: bool,
    /// Where it enters the system.
    entry: Entry,
}

/// Which parameter is wanted free, with its range where the study gives one.
#[derive(Debug, Clone)]
pub(super) struct Wanted {
    pub(super) name: String,
    pub(super) span: Span,
    pub(super) range: Option<ParameterRange>,
}

impl Wanted {
    /// The free parameters of a task.
    pub(super) fn of(task: &ContinuationTask) -> Vec<Self> {
        task.parameters
            .iter()
            .map(|(name, span)| Self {
                name: name.clone(),
                span: *span,
                range: task.ranges.get(name).cloned(),
            })
            .collect()
    }
}

/// A configuration of a study as a system with free parameters.
#[derive(Debug)]
pub(super) struct Model {
    host: Arc<EquationHost>,
    system: System,
    slopes: Slopes,
    axes: Vec<Axis>,
    free: Moving<Built>,
    forcing: Option<Forcing>,
    /// Measures that are shown, then those by which oscillations are named.
    pub(super) measures: Vec<Compiled>,
    /// How many are shown.
    pub(super) shown: usize,
    pub(super) devices: Vec<BuiltDevice>,
}

impl Model {
    /// Compiles a configuration with free parameters and measures.
    ///
    /// # Errors
    /// Whatever is wrong with configuration, parameters, ranges or measures, at its place.
    pub(super) fn new(
        study: &Study,
        situation: &Situation,
        spec: &ConfigurationSpec,
        wanted: &[Wanted],
        (measures, oscillations): (&IndexMap<String, Measure>, &IndexMap<String, Measure>),
        period: Option<&Amount>,
    ) -> Result<Self, Fault> {
        let written = situation.equations()?;
        let driven = written
            .driven()
            .map_err(|error| Fault::new(error.to_string()))?;
        let (frequencies, others) = (driven.frequencies, driven.others);
        let host = Arc::new(driven.host);
        let built = configuration::built(study, situation, spec)?;
        let devices = built.system_devices(study, &host)?;
        let watching = Watching::new(&host, &devices);
        let mut compiled = Vec::with_capacity(measures.len() + oscillations.len());
        for (name, measure) in measures.iter().chain(oscillations) {
            let one = measure::compiled(study, situation, &watching, name, measure)?;
            if compiled.len() > measures.len()
                && let Some(first) = compiled.get(measures.len())
            {
                measure::comparable(study, first, &one, measure)?;
            }
            compiled.push(one);
        }
        let place = wanted.first().map_or(spec.span, |one| one.span);
        let system = watching
            .system()
            .map_err(|error| Fault::at(&study.source, place, error.to_string()))?;
        let first_elements = built.first_elements();
        let places = ValuePlaces {
            elements: &first_elements,
            law: &|device, name| built.law_place(device, name),
        };
        let sources = sources(&system, &devices, &places);
        let mut axes = Vec::new();
        for one in wanted {
            axes.push(axis(study, situation, spec, &built, &host, &system, one)?);
        }
        let mut values = ValueScratch::default();
        built.values(&[], &mut values);
        let shown = built.devices(&[]);
        let entries = axes.iter().map(|axis| axis.entry.clone()).collect();
        let free = Moving::new(built, values, sources, entries);
        let slopes = system.slopes(free.slopes());
        let drive = Drive {
            period,
            frequencies: &frequencies,
            others: &others,
            place,
        };
        let forcing = forcing(study, &host, &system, &slopes, &drive)?;
        Ok(Self {
            system,
            axes,
            free,
            slopes,
            forcing,
            measures: compiled,
            shown: measures.len(),
            devices: shown,
            host,
        })
    }

    /// The free parameters.
    pub(super) fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Names of the states.
    pub(super) fn states(&self) -> Vec<String> {
        let states = self.system.states().iter();
        states.map(|state| state.name.clone()).collect()
    }

    /// Which states are angles: coordinates that the host declares as rotations.
    pub(super) fn angles(&self) -> Vec<bool> {
        let angle = |name: &str| {
            let mut coordinates = self.host.coordinates.iter();
            coordinates.any(|one| one.name == name && one.kind == CoordinateMeasure::Rotation)
        };
        let states = self.system.states().iter();
        states
            .map(|state| state.kind != StateKind::Rate && angle(&state.name))
            .collect()
    }

    /// Coordinates, rates and states of the host with their dimensions.
    pub(super) fn beginnings(&self) -> Vec<(String, Dimension)> {
        self.host.beginnings()
    }

    /// The system.
    pub(super) const fn system(&self) -> &System {
        &self.system
    }

    /// Whether something forces it in time.
    pub(super) const fn forced(&self) -> bool {
        self.forcing.is_some()
    }

    /// The period of what forces it, s.
    pub(super) fn forcing_period(&self, free: &[f64]) -> Option<f64> {
        let forcing = self.forcing.as_ref()?;
        Some(forcing.period(&self.values(free)))
    }

    /// As a continuation problem.
    pub(super) fn field(&self) -> Field<'_> {
        Field::new(
            &self.system,
            &self.slopes,
            &self.free,
            self.forcing.as_ref(),
        )
    }

    /// Values of the free parameters in the configuration, brought into their ranges.
    pub(super) fn base(&self) -> Vec<f64> {
        self.axes()
            .iter()
            .map(|axis| axis.base.clamp(axis.range.0, axis.range.1))
            .collect()
    }

    /// All values of the system's parameters.
    pub(super) fn values(&self, free: &[f64]) -> Vec<f64> {
        self.free.values(free)
    }

    /// The equilibrium near the start of runs in time; else why there is none.
    pub(super) fn equilibrium(&self, free: &[f64]) -> Result<Vec<f64>, String> {
        let mut prepared = self.system.prepare(&self.values(free));
        let start = prepared.start(0.0);
        let found = prepared.equilibrium(0.0, &start);
        if found.status == EquilibriumStatus::NotFound {
            Err(format!(
                "no equilibrium was found to start from (relative residual {:.1e})",
                found.residual
            ))
        } else {
            Ok(found.state)
        }
    }

    /// Parameters of the host for values of the free ones, for measures that name them.
    pub(super) fn parameters(&self, free: &[f64]) -> Vec<(String, Quantity)> {
        if !self.measures.iter().any(|measure| measure.names) {
            return Vec::new();
        }
        let values = self.values(free);
        let mut point = self.host.nominal();
        for (parameter, value) in self.system.parameters().iter().zip(&values) {
            let known = self
                .host
                .parameters
                .iter()
                .find(|known| parameter.owner == Owner::Host && known.name == parameter.name);
            if let Some(entry) = known
                .and_then(|known| known.input)
                .and_then(|input| point.get_mut(input))
            {
                *entry = *value;
            }
        }
        let slots: Vec<_> = self.host.parameters.iter().map(|one| one.slot).collect();
        let found = self.host.graph.values(&slots, &point);
        self.host
            .parameters
            .iter()
            .zip(found)
            .map(|(one, value)| (one.name.clone(), Quantity::new(value, one.value.dimension)))
            .collect()
    }
}

/// What a free parameter is, and where it enters.
fn axis(
    study: &Study,
    situation: &Situation,
    spec: &ConfigurationSpec,
    built: &Built,
    host: &EquationHost,
    system: &System,
    wanted: &Wanted,
) -> Result<Axis, Fault> {
    let name = wanted.name.as_str();
    let fault = |message: String| Fault::at(&study.source, wanted.span, message);
    let own = host.parameters.iter().find(|known| known.name == name);
    let given = spec.values.contains_key(name);
    let names = built.value_names();
    let in_devices = given || names.iter().any(|known| known == name);
    if own.is_none() && !in_devices {
        let known = host.parameters.iter().map(|known| known.name.as_str());
        let all: Vec<&str> = known.chain(names.iter().map(String::as_str)).collect();
        let fault = fault(format!(
            "neither the host nor a device has a parameter `{name}`"
        ));
        return Err(match quell_expression::nearest(name, all.iter().copied()) {
            Some(near) => fault.help(format!("did you mean `{near}`?")),
            None => fault.help("name a parameter of the host, or a value of the configuration"),
        });
    }
    // A value that the configuration gives is the device's own, whatever the host calls so.
    let own = own.filter(|_| !given);
    if let Some(derived) = own.filter(|own| own.input.is_none()) {
        return Err(fault(format!(
            "`{name}` follows from other parameters ({} here), so it cannot be free",
            derived.value.value
        ))
        .help("name one of those that it follows from"));
    }
    let index = own.and_then(|_| {
        system
            .parameters()
            .iter()
            .position(|known| known.owner == Owner::Host && known.name == name)
    });
    let operating = host.operating.iter().find(|range| range.parameter == name);
    let missing = || {
        fault(format!("nothing says over which range `{name}` goes")).help(format!(
            "add `ranges = {{ {name} = [\"…\", \"…\"] }}` to the task, or `{name}` to `[operating]` of the host"
        ))
    };
    let mut places = Places::default();
    let mut range = None;
    let mut open = false;
    let (mut unit, mut dimension, mut base) = own.map_or_else(
        || (String::new(), Dimension::NONE, f64::NAN),
        |own| {
            let dimension = own.value.dimension;
            (dimension.unit_text(), dimension, own.value.value)
        },
    );
    if in_devices {
        let typed = wanted.range.as_ref().ok_or_else(missing)?;
        let freed = freed(study, situation, spec, name, typed)?;
        places = freed.searched();
        let found = freed.variables.first();
        if places.is_empty() && own.is_none() {
            return Err(fault(format!(
                "nothing in the layouts of this configuration takes its value from `{name}`"
            )));
        }
        if let Some(found) = found {
            range = Some((found.lower, found.upper));
        }
        if own.is_none() {
            base = built.given(&places).unwrap_or(f64::NAN);
            let shown = freed.devices(&[f64::NAN]);
            let named = shown
                .iter()
                .flat_map(|device| device.variables.iter().chain(&device.elements))
                .find(|value| value.name == name || name.ends_with(&format!(".{}", value.name)));
            unit = named.map_or_else(String::new, |value| value.unit.clone());
            dimension = Unit::parse(&unit).map_or(Dimension::NONE, |unit| unit.dimension);
        }
    }
    if range.is_none() {
        range = match (&wanted.range, operating) {
            (Some(typed), _) => {
                let from = typed.from.value(&situation.parameters, dimension)?;
                let to = typed.to.value(&situation.parameters, dimension)?;
                if from >= to {
                    return Err(Fault::at(
                        &study.source,
                        typed.span,
                        format!(
                            "the range of `{name}` does not rise from its first value to its second"
                        ),
                    )
                    .help("write `[lower, upper]`"));
                }
                Some((from, to))
            }
            (None, Some(known)) => {
                // An end that is left out is approached, not met: what is marginal there stays away.
                open = known.open;
                let inset = if known.open {
                    OPEN * (known.to - known.from)
                } else {
                    0.0
                };
                Some((known.from + inset, known.to))
            }
            (None, None) => None,
        };
    }
    Ok(Axis {
        name: name.to_owned(),
        unit,
        dimension,
        base,
        range: range.ok_or_else(missing)?,
        open,
        entry: Entry {
            host: index,
            places,
        },
    })
}

/// How near a branch comes to an end of a range that is left out, relative to the range.
const OPEN: f64 = 1e-6;

/// The configuration with one value of its devices searched.
fn freed(
    study: &Study,
    situation: &Situation,
    spec: &ConfigurationSpec,
    name: &str,
    range: &ParameterRange,
) -> Result<Built, Fault> {
    let mut given = spec.values.clone();
    given.shift_remove(name);
    let bounds = IndexMap::from([(
        name.to_owned(),
        Bounds {
            lower: range.from.clone(),
            upper: range.to.clone(),
            scale: None,
            span: range.span,
        },
    )]);
    let mut freed = study.clone();
    for (device, own) in &mut freed.devices {
        own.values
            .retain(|known, _| *known != name && format!("{device}.{known}") != name);
    }
    Built::new(
        &freed,
        situation,
        &configuration::candidate(spec),
        Values {
            given: &given,
            bounds: &bounds,
            searched: true,
        },
    )
}

/// What forces a system.
struct Drive<'a> {
    /// The period that the task states.
    period: Option<&'a Amount>,
    /// Frequencies of harmonic inputs.
    frequencies: &'a [Slot],
    /// Inputs that are no harmonics.
    others: &'a [String],
    place: Span,
}

/// The period of what forces the system.
fn forcing(
    study: &Study,
    host: &EquationHost,
    system: &System,
    slopes: &Slopes,
    drive: &Drive<'_>,
) -> Result<Option<Forcing>, Fault> {
    let fault = |message: String| Fault::at(&study.source, drive.place, message);
    if let Some(other) = drive.others.first() {
        return Err(fault(format!(
            "the input `{other}` of the host has no period: branches are of equilibria and of periodic motions"
        ))
        .help("give it a `harmonic` signal without `sweep`, or leave its `signal` out"));
    }
    let Some(period) = drive.period else {
        if slopes.timeless() {
            return Ok(None);
        }
        if let [frequency] = drive.frequencies {
            let mut graph = host.graph.clone();
            let turn = graph.constant(std::f64::consts::TAU);
            let slot = graph.divide(turn, *frequency);
            return Ok(Some(Forcing::new(host, graph, slot, system)));
        }
        return Err(fault(
            "the equations depend on time, and nothing says with which period".to_owned(),
        )
        .help("add `period = \"2*pi/Omega\"` with what the forcing's frequency is called"));
    };
    if slopes.timeless() {
        return Err(period
            .fault("nothing in the equations depends on time, so there is no period of a forcing")
            .help("leave `period` out: cycles find their own"));
    }
    let mut graph = host.graph.clone();
    let (slot, _) = host
        .lower(&mut graph, period.expression(), &quell_model::NoExtraNames)
        .map_err(|error| Fault::from_expression(&study.source, error))?;
    Ok(Some(Forcing::new(host, graph, slot, system)))
}
