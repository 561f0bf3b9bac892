//! A system compiled.

use std::sync::OnceLock;

use quell_expression::{Program, Slot};

use super::assembly::{Assembled, Assembler, State};
use super::device::Device;
use super::error::SystemError;
use super::inputs::Parameter;
use super::prepared::Prepared;
use super::watched::{Phase, Quantity, Watched};
use crate::equations::{EquationHost, Symbol, Waveform};

/// A host with devices on its ports as x' = f(t, x), compiled; parameters may change from one evaluation to the next.
///
/// The state x is minimal: displacements of host coordinates with mass and of those internal motions of devices that a
/// spring holds, their rates where inertia moves them, first-order states of the host. What has no inertia follows from
/// equations within f: in closed form where they are affine, by Newton's method where not, with exact derivatives either way.
///
/// ```text
/// x = [q, displacements with inertia, displacements without, q', rates with inertia, first-order states]
/// ```
#[derive(Debug)]
pub struct System {
    pub(crate) states: Vec<State>,
    pub(crate) parameters: Vec<Parameter>,
    /// What does not change: the number of inputs.
    pub(crate) inputs: usize,
    pub(crate) time: usize,
    pub(crate) waves: Vec<[usize; 3]>,
    pub(crate) waveforms: Vec<Option<Waveform>>,
    pub(crate) implicit: Vec<Implicit>,
    pub(crate) rates: Program,
    pub(crate) jacobian: Program,
    /// Places of the Jacobian's entries, row-major.
    pub(crate) entries: Vec<usize>,
    pub(crate) signals: Program,
    pub(crate) signal_count: usize,
    pub(crate) switches: Program,
    pub(crate) switch_count: usize,
    pub(crate) start: Program,
    affine: bool,
    /// Whether inputs move the rates.
    pub(crate) excited: bool,
    assembled: Assembled,
    watched: Vec<Slot>,
    linear: OnceLock<Linear>,
    higher: OnceLock<Higher>,
}

/// Unknowns that Newton's method finds.
#[derive(Debug)]
pub(crate) struct Implicit {
    pub(crate) unknowns: Vec<usize>,
    /// Level 0: residuals; level 1: their Jacobian's entries.
    pub(crate) program: Program,
    pub(crate) entries: Vec<usize>,
}

/// Derivatives with respect to states and inputs, of rates and signals.
#[derive(Debug)]
pub(crate) struct Linear {
    pub(crate) program: Program,
    /// Places in the matrix [A B; C D] with columns x, u, u', u''.
    pub(crate) entries: Vec<usize>,
}

/// Directional derivatives: levels 0, 1, 2 for the first, second and third.
#[derive(Debug)]
pub(crate) struct Higher {
    pub(crate) program: Program,
    pub(crate) directions: [Vec<usize>; 3],
    pub(crate) inputs: usize,
}

impl System {
    /// Compiles a host with devices in a phase of its motion, with signals to watch.
    ///
    /// Which internal motions are states is decided by which elements touch which points, never by values. A watched stroke
    /// of an element on which nothing depends (a damper and an inerter in series) adds a state.
    ///
    /// # Errors
    /// See [`SystemError`].
    pub fn new(
        host: &EquationHost,
        devices: &[Device],
        watched: &[Watched],
        phase: Phase,
    ) -> Result<Self, SystemError> {
        Self::with_placeholders(host, &[], devices, watched, phase)
    }

    pub(crate) fn with_placeholders(
        host: &EquationHost,
        placeholders: &[(usize, Quantity)],
        devices: &[Device],
        watched: &[Watched],
        phase: Phase,
    ) -> Result<Self, SystemError> {
        let wanted = wanted(host, watched);
        let (mut assembler, mut assembled) =
            Assembler::assemble(host, placeholders, devices, &wanted, phase)?;
        let watched = assembler.watch(&mut assembled, watched)?;
        let is_parameter = parameter_mask(&assembled);
        let implicit = implicit(&mut assembled, &is_parameter);
        let count = assembled.states.len();

        let state_inputs: Vec<usize> = assembled.states.iter().map(|state| state.input).collect();
        let open = assembled.rates.clone();
        let jacobian = assembled.jacobian(&open, &state_inputs);
        let entries: Vec<usize> = present(&jacobian);
        let slots: Vec<Slot> = jacobian.into_iter().flatten().collect();
        // One closing for all, so that parts are shared.
        let mut roots = open.clone();
        roots.extend(&slots);
        let closed = assembled.close(&roots);
        let (rates, jacobian) = closed.split_at(count);
        refuse_loops(host, &assembled, rates)?;
        let affine = is_affine(&mut assembled, jacobian, &open);
        let waves: Vec<usize> = assembled.waves.iter().flatten().copied().collect();
        let excited = assembled
            .jacobian(&open, &waves)
            .iter()
            .any(Option::is_some);
        let mut kinks = rates.to_vec();
        for layer in assembled.layers.clone() {
            if layer.solution.is_none() {
                kinks.extend(assembled.close(&layer.residuals));
            }
        }
        let graph = &mut assembled.inputs.graph;
        let moving = |input: usize| !is_parameter.get(input).copied().unwrap_or(false);
        let switches: Vec<Slot> = graph
            .switches(&kinks)
            .into_iter()
            .filter(|slot| graph.dependence(&[*slot]).into_iter().any(moving))
            .collect();
        let signals = assembled.close(&watched);
        let graph = &assembled.inputs.graph;
        let compile = |levels: &[Vec<Slot>]| {
            Program::compile(graph, levels, |input| {
                is_parameter.get(input).copied().unwrap_or(false)
            })
        };
        let compiled_rates = compile(&[rates.to_vec()]);
        let compiled_jacobian = compile(&[rates.to_vec(), jacobian.to_vec()]);
        let compiled_signals = compile(std::slice::from_ref(&signals));
        let compiled_switches = compile(std::slice::from_ref(&switches));
        let start = compile(std::slice::from_ref(&assembled.start));
        Ok(Self {
            states: assembled.states.clone(),
            parameters: assembled.parameters.clone(),
            inputs: assembled.inputs.symbols.len(),
            time: assembled.time,
            waves: assembled.waves.clone(),
            waveforms: host
                .inputs
                .iter()
                .map(|input| input.waveform.clone())
                .collect(),
            implicit,
            rates: compiled_rates,
            jacobian: compiled_jacobian,
            entries,
            signal_count: signals.len(),
            signals: compiled_signals,
            switch_count: switches.len(),
            switches: compiled_switches,
            start,
            affine,
            excited,
            watched,
            assembled,
            linear: OnceLock::new(),
            higher: OnceLock::new(),
        })
    }

    /// The states, in the order of x.
    #[must_use]
    pub fn states(&self) -> &[State] {
        &self.states
    }

    /// Index of a state by its name: `z1'`, `strut.1`.
    #[must_use]
    pub fn state(&self, name: &str) -> Option<usize> {
        self.states.iter().position(|state| state.name == name)
    }

    /// The parameters: the host's primary ones, then those of every device, element by element.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Default values of the parameters.
    #[must_use]
    pub fn defaults(&self) -> Vec<f64> {
        self.parameters
            .iter()
            .map(|parameter| parameter.value)
            .collect()
    }

    /// Number of signals, those that were to be watched.
    #[must_use]
    pub const fn signals(&self) -> usize {
        self.signal_count
    }

    /// Number of inputs, those of the host.
    #[must_use]
    pub const fn inputs(&self) -> usize {
        self.waves.len()
    }

    /// Number of margins at whose zeros the rates have kinks or jumps.
    #[must_use]
    pub const fn switches(&self) -> usize {
        self.switch_count
    }

    /// Number of unknowns that Newton's method finds in each evaluation; zero where all have closed forms.
    #[must_use]
    pub fn implicit_unknowns(&self) -> usize {
        self.implicit
            .iter()
            .map(|implicit| implicit.unknowns.len())
            .sum()
    }

    /// Whether x' = A x + b with a constant A on every piece between zeros of the switches, and b constant wherever all
    /// inputs are.
    #[must_use]
    pub const fn affine(&self) -> bool {
        self.affine
    }

    /// Puts in values of the parameters, in the order of [`Self::parameters`]; what is missing reads as not-a-number.
    ///
    /// What depends on parameters alone is computed here, once.
    #[must_use]
    pub fn prepare(&self, parameters: &[f64]) -> Prepared<'_> {
        Prepared::new(self, parameters)
    }

    /// Where a run begins, with waveforms of inputs at t = 0.
    ///
    /// Coordinates and first-order states begin as the host says. Within devices springs begin unstretched and inerters
    /// without relative velocity as far as the ports' across-variables allow it; where they do not (two springs in series
    /// on a port that begins stretched), as evenly as possible.
    #[must_use]
    pub fn start(&self, parameters: &[f64]) -> Vec<f64> {
        self.prepare(parameters).start(0.0)
    }

    pub(crate) const fn assembled(&self) -> &Assembled {
        &self.assembled
    }

    pub(crate) fn mask(&self) -> Vec<bool> {
        parameter_mask(&self.assembled)
    }

    pub(crate) fn linear(&self) -> &Linear {
        self.linear.get_or_init(|| {
            let mut assembled = self.assembled.clone();
            let mut by: Vec<usize> = assembled.states.iter().map(|state| state.input).collect();
            for order in 0..3 {
                by.extend(assembled.waves.iter().map(|wave| wave[order]));
            }
            let mut roots = assembled.rates.clone();
            roots.extend(&self.watched);
            let jacobian = assembled.jacobian(&roots, &by);
            let entries = present(&jacobian);
            let slots: Vec<Slot> = jacobian.into_iter().flatten().collect();
            let closed = assembled.close(&slots);
            let mask = self.mask();
            let program = Program::compile(&assembled.inputs.graph, &[closed], |input| {
                mask.get(input).copied().unwrap_or(false)
            });
            Linear { program, entries }
        })
    }

    pub(crate) fn higher(&self) -> &Higher {
        self.higher.get_or_init(|| {
            let mut assembled = self.assembled.clone();
            let count = assembled.states.len();
            let directions = [0, 1, 2].map(|_| assembled.inputs.others(count));
            let mut roots = assembled.rates.clone();
            let mut levels = Vec::new();
            for direction in &directions {
                let slots = assembled.inputs.slots(direction);
                let seeds = assembled.along(&slots);
                let slopes = assembled.inputs.graph.tangent(
                    &roots,
                    &seeds,
                    quell_expression::Differentiation::Exact,
                );
                let zero = assembled.inputs.graph.constant(0.0);
                roots = slopes
                    .into_iter()
                    .map(|slope| slope.unwrap_or(zero))
                    .collect();
                levels.push(roots.clone());
            }
            let all: Vec<Slot> = levels.iter().flatten().copied().collect();
            let closed = assembled.close(&all);
            let levels: Vec<Vec<Slot>> =
                closed.chunks(count.max(1)).map(<[Slot]>::to_vec).collect();
            let mask = self.mask();
            let program = Program::compile(&assembled.inputs.graph, &levels, |input| {
                mask.get(input).copied().unwrap_or(false)
            });
            Higher {
                program,
                directions,
                inputs: assembled.inputs.symbols.len(),
            }
        })
    }
}

/// Quantities that are watched, massless coordinates within expressions included.
fn wanted(host: &EquationHost, watched: &[Watched]) -> Vec<Quantity> {
    let mut found = Vec::new();
    for item in watched {
        match item {
            Watched::Quantity(quantity) => found.push(*quantity),
            Watched::Host(slot) => {
                for input in host.graph.dependence(&[*slot]) {
                    if let Some(Symbol::Coordinate { index, order }) = host.symbols.get(input) {
                        found.push(Quantity::Coordinate {
                            index: *index,
                            order: *order,
                        });
                    }
                }
            }
        }
    }
    found
}

/// Refuses rates in which something is left that has no value.
fn refuse_loops(
    host: &EquationHost,
    assembled: &Assembled,
    rates: &[Slot],
) -> Result<(), SystemError> {
    let found = assembled.inputs.graph.dependence(rates);
    let known: Vec<usize> = assembled
        .implicit()
        .flat_map(|layer| layer.unknowns.iter().copied())
        .collect();
    let open = found.into_iter().find_map(|input| {
        if known.contains(&input) {
            return None;
        }
        let what = match *assembled.inputs.symbols.get(input)? {
            Symbol::PortForce { index } => {
                format!("the force on the port `{}`", host.ports.get(index)?.name)
            }
            Symbol::StateRate { index } => {
                format!("the rate of the state `{}`", host.states.get(index)?.name)
            }
            Symbol::Coordinate { index, order: 2 } => format!(
                "the acceleration of the coordinate `{}`",
                host.coordinates.get(index)?.name
            ),
            _ => return None,
        };
        Some(what)
    });
    match open {
        Some(what) => Err(SystemError::Circular { what }),
        None => Ok(()),
    }
}

/// Which graph inputs are parameters.
fn parameter_mask(assembled: &Assembled) -> Vec<bool> {
    let mut mask = vec![false; assembled.inputs.symbols.len()];
    for parameter in &assembled.parameters {
        if let Some(entry) = mask.get_mut(parameter.input) {
            *entry = true;
        }
    }
    mask
}

fn present(entries: &[Option<Slot>]) -> Vec<usize> {
    let found = entries.iter().enumerate();
    found
        .filter(|(_, entry)| entry.is_some())
        .map(|(place, _)| place)
        .collect()
}

fn implicit(assembled: &mut Assembled, is_parameter: &[bool]) -> Vec<Implicit> {
    let layers: Vec<_> = assembled.implicit().cloned().collect();
    layers
        .into_iter()
        .map(|layer| {
            let mut roots = layer.residuals.clone();
            roots.extend(layer.matrix.iter().flatten());
            let closed = assembled.close(&roots);
            let (residuals, matrix) = closed.split_at(layer.residuals.len());
            Implicit {
                program: Program::compile(
                    &assembled.inputs.graph,
                    &[residuals.to_vec(), matrix.to_vec()],
                    |input| is_parameter.get(input).copied().unwrap_or(false),
                ),
                entries: present(&layer.matrix),
                unknowns: layer.unknowns,
            }
        })
        .collect()
}

/// Whether the closed Jacobian is constant piece by piece, and the rates depend on time through inputs alone.
fn is_affine(assembled: &mut Assembled, jacobian: &[Slot], rates: &[Slot]) -> bool {
    let in_time = assembled.jacobian(rates, &[assembled.time]);
    if in_time.iter().any(Option::is_some) {
        return false;
    }
    let mut moving: Vec<usize> = assembled.states.iter().map(|state| state.input).collect();
    moving.extend(assembled.waves.iter().flatten());
    moving.extend(
        assembled
            .layers
            .iter()
            .flat_map(|layer| layer.unknowns.iter().copied()),
    );
    jacobian.iter().all(|slot| {
        let depends = assembled.inputs.graph.smooth_dependence(*slot);
        !moving.iter().any(|input| depends.contains(input))
    })
}
