//! A run in time of one candidate, compiled.

use std::cell::RefCell;

use quell_document::Fault;
use quell_expression::{
    BinaryOperator, ComparisonOperator, Dimension, Expression, ExpressionError, Node, nearest,
};
use quell_model::system::{
    Device, EquilibriumStatus, Owner, Phase, Prepared, Quantity, System, SystemError, Vocabulary,
    Watched,
};
use quell_model::{EquationHost, Waveform};
use quell_network::Law;
use quell_response::transient::{
    Condition, Direction, Dynamics, End, Event, Method, Record, Settings, Trajectory, simulate,
};

use super::excitation::excitations;
use super::history::{History, histories};
use super::ledger::LedgerSignals;
use super::observation::{COMPUTED_BUT, Observation};
use crate::results::Ledger;
use crate::situation::Situation;
use crate::study::{Integration, PhaseSpec, StartAt, Study, TransientRun};

/// An end event is nearly grazed when its signal goes less than this beyond the level, relative to its largest size.
const SHALLOW: f64 = 0.01;

/// Signals of a run, gathered while criteria are read.
#[derive(Debug)]
pub(crate) struct Watching<'a> {
    host: &'a EquationHost,
    devices: &'a [Device],
    vocabulary: RefCell<Vocabulary<'a>>,
    signals: RefCell<Vec<Watched>>,
    /// Text and dimension of each signal that came as text.
    labels: RefCell<Vec<Option<(String, Dimension)>>>,
}

impl<'a> Watching<'a> {
    pub(crate) fn new(host: &'a EquationHost, devices: &'a [Device]) -> Self {
        Self {
            host,
            devices,
            vocabulary: RefCell::new(Vocabulary::new(host, devices)),
            signals: RefCell::default(),
            labels: RefCell::default(),
        }
    }

    /// The devices.
    pub(crate) const fn devices(&self) -> &'a [Device] {
        self.devices
    }

    /// The system in which all that was gathered is watched.
    ///
    /// # Errors
    /// Why host and devices are no system of equations.
    pub(crate) fn system(&self) -> Result<System, SystemError> {
        self.vocabulary
            .borrow()
            .system(&self.signals.borrow(), Phase::Free)
    }

    pub(crate) fn port_name(&self, port: usize) -> String {
        self.host
            .ports
            .get(port)
            .map_or_else(String::new, |port| port.name.clone())
    }

    fn index(&self, watched: Watched) -> usize {
        let mut signals = self.signals.borrow_mut();
        if let Some(index) = signals.iter().position(|known| *known == watched) {
            return index;
        }
        signals.push(watched);
        self.labels.borrow_mut().push(None);
        signals.len() - 1
    }

    /// The signal of an expression.
    ///
    /// # Errors
    /// As [`EquationHost::lower`].
    pub(crate) fn signal(
        &self,
        expression: &Expression,
    ) -> Result<(usize, Dimension), ExpressionError> {
        let (watched, dimension) = self.vocabulary.borrow_mut().lower(expression)?;
        let index = self.index(watched);
        if let Some(label) = self.labels.borrow_mut().get_mut(index) {
            label.get_or_insert_with(|| (expression.excerpt(), dimension));
        }
        Ok((index, dimension))
    }

    /// Whether an expression is a signal; it is not watched for that.
    pub(crate) fn knows(&self, expression: &Expression) -> bool {
        self.vocabulary.borrow_mut().lower(expression).is_ok()
    }

    /// The signal of a quantity.
    pub(crate) fn quantity(&self, quantity: Quantity) -> usize {
        self.index(Watched::Quantity(quantity))
    }

    /// The energy that the named part has taken as far as it meets a wish, with its dimension.
    ///
    /// # Errors
    /// There is no such part.
    pub(crate) fn energy(
        &self,
        function: &str,
        arguments: &[Expression],
        wanted: impl Fn(&Device, usize) -> bool,
    ) -> Result<(Vec<usize>, Dimension), ExpressionError> {
        let (device, only) = self.part(function, arguments)?;
        let mut signals = Vec::new();
        if let Some(attached) = self.devices.get(device) {
            for element in 0..attached.mechanism.elements().len() {
                if only.is_none_or(|only| only == element) && wanted(attached, element) {
                    signals.push(self.quantity(Quantity::ElementPower { device, element }));
                }
            }
        }
        Ok((signals, self.energy_dimension()))
    }

    /// J; none in a dimensionless host.
    pub(crate) fn energy_dimension(&self) -> Dimension {
        if self.host.dimensionless {
            Dimension::NONE
        } else {
            Dimension::ENERGY
        }
    }

    /// s; none in a dimensionless host.
    pub(crate) fn time_dimension(&self) -> Dimension {
        if self.host.dimensionless {
            Dimension::NONE
        } else {
            Dimension::TIME
        }
    }

    /// The device, and the element of it, of a name: `strut`, `c1` or `strut.c1`.
    fn part(
        &self,
        function: &str,
        arguments: &[Expression],
    ) -> Result<(usize, Option<usize>), ExpressionError> {
        let [
            Expression {
                node: Node::Name(name),
                span,
            },
        ] = arguments
        else {
            let span = arguments.first().map(|one| one.span).unwrap_or_default();
            return Err(ExpressionError::new(
                span,
                format!("`{function}` takes the name of one device or of an element of a device"),
            ));
        };
        if let Some(device) = self.devices.iter().position(|device| device.name == *name) {
            return Ok((device, None));
        }
        let found = self.devices.iter().enumerate().find_map(|(index, device)| {
            let short = name
                .strip_prefix(device.name.as_str())
                .and_then(|rest| rest.strip_prefix('.'))
                .unwrap_or(name);
            Some((index, device.mechanism.element_index(short)?))
        });
        if let Some((device, element)) = found {
            return Ok((device, Some(element)));
        }
        let known = self.devices.iter().flat_map(|device| {
            let elements = device.mechanism.elements().iter();
            std::iter::once(device.name.as_str())
                .chain(elements.map(|element| element.name.as_str()))
        });
        let error = ExpressionError::new(
            *span,
            format!("there is no device or element called `{name}` here"),
        );
        Err(match nearest(name, known) {
            Some(near) => error.with_help(format!("did you mean `{near}`?")),
            None => error,
        })
    }

    /// The margin of a condition: positive where it holds.
    fn margin(&self, condition: &Expression) -> Result<Watched, ExpressionError> {
        let Node::Comparison {
            operator,
            left,
            right,
        } = &condition.node
        else {
            return Err(ExpressionError::new(
                condition.span,
                "expected a comparison, such as `x > 0`",
            ));
        };
        let (larger, smaller) = match operator {
            ComparisonOperator::Greater | ComparisonOperator::GreaterOrEqual => (left, right),
            ComparisonOperator::Less | ComparisonOperator::LessOrEqual => (right, left),
            ComparisonOperator::Equal | ComparisonOperator::NotEqual => {
                return Err(ExpressionError::new(
                    condition.span,
                    "a moment is waited for with `<` or `>`: equality holds nearly nowhere",
                ));
            }
        };
        let difference = Expression {
            node: Node::Binary {
                operator: BinaryOperator::Subtract,
                left: larger.clone(),
                right: smaller.clone(),
            },
            span: condition.span,
        };
        let (watched, _) = self.vocabulary.borrow_mut().lower(&difference)?;
        Ok(watched)
    }
}

/// Where the value of a parameter of a system comes from.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Source {
    /// It is the host's.
    Host(f64),
    /// The value of a linear element, among all mechanical ones.
    Element(usize),
    /// The parameter of a force law, among all of them.
    Law(usize),
}

/// A phase of a run.
#[derive(Debug)]
struct PhasePlan {
    system: System,
    events: Vec<Event>,
    /// Margin of the condition that ends it; its own last signal.
    until: Option<usize>,
}

/// A run in time of one candidate, compiled; values of elements come later.
#[derive(Debug)]
pub(crate) struct TransientPlan {
    phases: Vec<PhasePlan>,
    sources: Vec<Source>,
    duration: f64,
    needs_event: bool,
    settings: Settings,
    from_equilibrium: bool,
    ledger: Option<LedgerSignals>,
    /// Signals of inputs that are the run's own.
    inputs: Vec<(usize, Waveform)>,
    labels: Vec<Option<(String, Dimension)>>,
}

/// Places of a candidate's values.
pub(crate) struct ValuePlaces<'a> {
    /// Of each device, the first of its elements among all mechanical values.
    pub elements: &'a [usize],
    /// Of each device and parameter of a law (`gas.n`), its place among all of them.
    pub law: &'a dyn Fn(usize, &str) -> Option<usize>,
}

impl TransientPlan {
    /// Compiles a run whose signals have been gathered.
    ///
    /// # Errors
    /// What is wrong with the run, or why host and devices are no system of equations, at its place.
    pub(crate) fn new(
        study: &Study,
        situation: &Situation,
        run: &TransientRun,
        watching: &Watching<'_>,
        ledger: bool,
        places: &ValuePlaces<'_>,
    ) -> Result<Self, Fault> {
        let located = |error: ExpressionError| Fault::from_expression(&study.source, error);
        let ledger = ledger.then(|| LedgerSignals::of(study, watching));
        let mut end = Vec::new();
        if let Some(event) = &run.end {
            let (signal, _) = watching.signal(&event.event).map_err(located)?;
            let direction = match event.rising {
                Some(true) => Direction::Rising,
                Some(false) => Direction::Falling,
                None => Direction::Either,
            };
            let mut found = Event::on(signal, direction).ending();
            if let Some(condition) = &event.armed {
                let margin = watching.margin(condition).map_err(located)?;
                let margin = watching.index(margin);
                found = found.armed(Condition::above(margin, 0.0));
            }
            end.push(found);
        }
        let common = watching.signals.borrow().clone();
        let free = [PhaseSpec {
            hold: None,
            until: None,
            span: run.span,
        }];
        let wanted = if run.phases.is_empty() {
            &free
        } else {
            run.phases.as_slice()
        };
        let mut phases = Vec::new();
        for (index, spec) in wanted.iter().enumerate() {
            let held = match &spec.hold {
                Some(hold) => watching
                    .vocabulary
                    .borrow_mut()
                    .hold(hold)
                    .map_err(located)?,
                None => Phase::Free,
            };
            let mut watched = common.clone();
            let mut events = Vec::new();
            let mut margin = None;
            if let Some(condition) = &spec.until {
                watched.push(watching.margin(condition).map_err(located)?);
                margin = Some(common.len());
                events.push(Event::on(common.len(), Direction::Rising).ending());
            }
            if index + 1 == wanted.len() {
                events.extend(end.iter().copied());
            }
            let system = watching
                .vocabulary
                .borrow()
                .system(&watched, held)
                .map_err(|error| Fault::at(&study.source, spec.span, error.to_string()))?;
            phases.push(PhasePlan {
                system,
                events,
                until: margin,
            });
        }
        let dimension = watching.time_dimension();
        let seconds = |amount: &crate::amount::Amount| -> Result<f64, Fault> {
            let value = amount.value(&situation.parameters, dimension)?;
            if value > 0.0 && value.is_finite() {
                Ok(value)
            } else {
                Err(amount.fault("a time to run for is above zero"))
            }
        };
        let mut settings = Settings::with_method(match run.method {
            Integration::Automatic => Method::Automatic,
            Integration::Explicit => Method::Explicit,
            Integration::Stiff => Method::Stiff,
            Integration::StiffOscillating => Method::StiffOscillating,
        });
        settings.relative = run.tolerance;
        settings.step_limit = run.most_steps;
        if let Some(beyond) = &run.beyond {
            settings.continuation = seconds(beyond)?;
        }
        Ok(Self {
            sources: phases.first().map_or_else(Vec::new, |phase| {
                sources(&phase.system, watching.devices, places)
            }),
            phases,
            duration: seconds(&run.duration)?,
            needs_event: run.end.is_some(),
            settings,
            from_equilibrium: matches!(run.start, StartAt::Equilibrium),
            ledger,
            inputs: excitations(study, situation, run)?,
            labels: watching.labels.borrow().clone(),
        })
    }

    /// Lets it run with values of the elements and of the parameters of force laws.
    ///
    /// It goes on `beyond` its end only where somebody looks there: a search seldom does.
    pub(crate) fn simulate(&self, mechanical: &[f64], laws: &[f64], beyond: bool) -> Simulated<'_> {
        let parameters = parameters(&self.sources, mechanical, laws);
        let mut simulated = Simulated {
            plan: self,
            moving: Vec::new(),
            trajectories: Vec::new(),
            failure: None,
        };
        let mut t = 0.0;
        let mut carried: Option<Carried> = None;
        for (index, phase) in self.phases.iter().enumerate() {
            let mut moving = phase.system.prepare(&parameters);
            for (input, waveform) in &self.inputs {
                moving.set_waveform(*input, Some(waveform.clone()));
            }
            let mut x = moving.start(t);
            if let Some(Carried { names, values }) = &carried {
                for (state, target) in phase.system.states().iter().zip(&mut x) {
                    if let Some(place) = names.iter().position(|name| *name == state.name) {
                        *target = values.get(place).copied().unwrap_or(f64::NAN);
                    }
                }
            } else if self.from_equilibrium {
                let found = moving.equilibrium(t, &x);
                if found.status == EquilibriumStatus::NotFound {
                    simulated.failure = Some(format!(
                        "no static equilibrium was found to start from (relative residual {:.1e}); give `start` values near it in the host",
                        found.residual
                    ));
                    return simulated;
                }
                x = found.state;
            }
            if let Some(margin) = phase.until {
                let mut signals = vec![0.0; phase.system.signals()];
                moving.watch(t, &x, &mut signals);
                if signals.get(margin).is_some_and(|margin| *margin > 0.0) {
                    carried = Some(Carried::new(&phase.system, x));
                    continue;
                }
            }
            let mut settings = self.settings.clone();
            let is_last = index + 1 == self.phases.len();
            if !is_last || !beyond {
                settings.continuation = 0.0;
            }
            let span = (t, t + self.duration);
            match simulate(&mut moving, &x, span, &phase.events, &settings) {
                Ok(trajectory) => {
                    t = trajectory.to();
                    carried = Some(Carried::new(&phase.system, trajectory.end_state()));
                    let regular = match trajectory.end() {
                        End::Event { .. } => Ok(()),
                        End::Time if is_last && !self.needs_event => Ok(()),
                        End::Time if is_last => Err(format!(
                            "the run did not reach its end event within {} s",
                            self.duration
                        )),
                        End::Time => Err(format!(
                            "phase {} did not end within {} s",
                            index + 1,
                            self.duration
                        )),
                        other => Err(in_words(other, t)),
                    };
                    simulated.trajectories.push(trajectory);
                    simulated.moving.push(moving);
                    if let Err(why) = regular {
                        simulated.failure = Some(why);
                        return simulated;
                    }
                }
                Err(error) => {
                    simulated.failure = Some(error.to_string());
                    return simulated;
                }
            }
        }
        simulated
    }
}

/// States that one phase hands to the next, by name.
struct Carried {
    names: Vec<String>,
    values: Vec<f64>,
}

impl Carried {
    fn new(system: &System, values: Vec<f64>) -> Self {
        let names = system.states().iter().map(|state| state.name.clone());
        Self {
            names: names.collect(),
            values,
        }
    }
}

fn in_words(end: &End, t: f64) -> String {
    match end {
        End::StepLimit => format!(
            "the integration has taken `most_steps` steps of the run, and is at {t} s: something moves very fast, or `most_steps` is too small"
        ),
        End::Diverged => format!("the motion grows beyond all bounds at {t} s"),
        End::Chattering { .. } => format!(
            "at {t} s the motion would slide along a jump of the equations, which is not supported: smooth the jump"
        ),
        End::Failed { why } => format!("the integration failed at {t} s: {why}"),
        _ => format!("the run was stopped at {t} s"),
    }
}

/// Where the parameters of a system come from.
pub(crate) fn sources(
    system: &System,
    devices: &[Device],
    places: &ValuePlaces<'_>,
) -> Vec<Source> {
    system
        .parameters()
        .iter()
        .map(|parameter| match parameter.owner {
            Owner::Host => Source::Host(parameter.value),
            Owner::Element { device, element } => {
                let linear = devices
                    .get(device)
                    .and_then(|device| device.mechanism.elements().get(element))
                    .is_some_and(|element| matches!(element.law, Law::Linear(_)));
                if linear {
                    let start = places.elements.get(device).copied().unwrap_or(usize::MAX);
                    Source::Element(start.saturating_add(element))
                } else {
                    (places.law)(device, &parameter.name)
                        .map_or(Source::Host(parameter.value), Source::Law)
                }
            }
        })
        .collect()
}

/// Values of the parameters of a system.
pub(crate) fn parameters(sources: &[Source], mechanical: &[f64], laws: &[f64]) -> Vec<f64> {
    let value = |source: &Source| match source {
        Source::Host(value) => *value,
        Source::Element(place) => mechanical.get(*place).copied().unwrap_or(f64::NAN),
        Source::Law(place) => laws.get(*place).copied().unwrap_or(f64::NAN),
    };
    sources.iter().map(value).collect()
}

/// A run that has run.
#[derive(Debug)]
pub(crate) struct Simulated<'s> {
    plan: &'s TransientPlan,
    moving: Vec<Prepared<'s>>,
    trajectories: Vec<Trajectory>,
    /// Why its numbers do not count, in words.
    pub failure: Option<String>,
}

impl Simulated<'_> {
    /// Start, end and last time, s.
    pub(crate) fn times(&self) -> [f64; 3] {
        let start = self.trajectories.first().map_or(0.0, Trajectory::from);
        let last = self.trajectories.last();
        [
            start,
            last.map_or(start, Trajectory::to),
            last.map_or(start, Trajectory::last),
        ]
    }

    /// Everything that can be read of it; none where it did not even begin.
    pub(crate) fn record(&mut self) -> Option<Record<'_>> {
        let mut parts = self.trajectories.iter().zip(&mut self.moving);
        let (trajectory, moving) = parts.next()?;
        let mut record = Record::new(trajectory, moving);
        for (trajectory, moving) in parts {
            record = record.then(trajectory, moving);
        }
        Some(record)
    }

    /// Numbers of it, each with the time at which it is taken; not-a-number where the run failed.
    ///
    /// All of them are read from one record, so that the signals are evaluated along the run once.
    pub(crate) fn read(&mut self, observations: &[&Observation]) -> Vec<(f64, Option<f64>)> {
        const NOTHING: (f64, Option<f64>) = (f64::NAN, None);
        if self.failure.is_some() {
            return vec![NOTHING; observations.len()];
        }
        let error = observations
            .contains(&&Observation::EnergyError)
            .then(|| self.ledger().map_or(f64::NAN, |ledger| ledger.error));
        let times = self.times();
        let Some(mut record) = self.record() else {
            return vec![NOTHING; observations.len()];
        };
        observations
            .iter()
            .map(|observation| match error {
                Some(error) if **observation == Observation::EnergyError => (error, None),
                _ => observation.read(&mut record, times),
            })
            .collect()
    }

    /// What should be known of its numbers beside them, by observation.
    pub(crate) fn remarks(&mut self, observations: &[&Observation]) -> Vec<Option<String>> {
        if self.failure.is_some() {
            return vec![None; observations.len()];
        }
        let times = self.times();
        let Some(mut record) = self.record() else {
            return vec![None; observations.len()];
        };
        observations
            .iter()
            .map(|observation| observation.remark(&mut record, times))
            .collect()
    }

    /// What is drawn of it.
    pub(crate) fn histories(&mut self, run: &str, observations: &[&Observation]) -> Vec<History> {
        let times = self.times();
        let labels = &self.plan.labels;
        match self.record() {
            Some(mut record) => histories(run, labels, observations, &mut record, times),
            None => Vec::new(),
        }
    }

    /// Its energy ledger, where that was asked for.
    pub(crate) fn ledger(&mut self) -> Option<Ledger> {
        let signals = self.plan.ledger.as_ref()?;
        let [start, end, _] = self.times();
        Some(signals.read(&mut self.record()?, start, end))
    }

    /// What should be known where the end event, or another one, is touched rather than crossed, or hardly crossed.
    pub(crate) fn grazing(&self) -> Option<String> {
        let last = self.trajectories.last()?;
        if last.ends_grazing() || !last.grazings().is_empty() {
            return Some(format!(
                "{COMPUTED_BUT}an event is grazed: it is touched rather than crossed, so a small change of any value may end the run much later"
            ));
        }
        let depth = last.ending_depth().filter(|depth| *depth < SHALLOW)?;
        Some(format!(
            "{COMPUTED_BUT}the end event is nearly grazed: its signal goes only {depth:.1e} of its largest size beyond the level, so a small change of any value may end the run much later"
        ))
    }
}
