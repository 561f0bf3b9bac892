//! A host whose dynamics are equations, lowered into one graph of operations.

use quell_expression::{Dimension, Graph, Quantity, Slot};

use super::driven::HarmonicLaw;
use super::names::Vocabulary;
use super::waveform::Waveform;
use crate::linear::{CoordinateKind, InputKind};

/// What an input of the graph stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Symbol {
    /// Time t, s.
    Time,
    /// A primary parameter, by index into [`EquationHost::parameters`].
    Parameter {
        /// Which.
        index: usize,
    },
    /// A coordinate, differentiated `order` times (0, 1, 2).
    Coordinate {
        /// Index into [`EquationHost::coordinates`].
        index: usize,
        /// Number of time derivatives.
        order: usize,
    },
    /// A first-order state, by index into [`EquationHost::states`].
    State {
        /// Which.
        index: usize,
    },
    /// The rate of a first-order state; its expression is [`FirstOrderState::rate`].
    StateRate {
        /// Index into [`EquationHost::states`].
        index: usize,
    },
    /// An input as it is given, differentiated `order` times (0, 1, 2).
    Input {
        /// Index into [`EquationHost::inputs`].
        index: usize,
        /// Number of time derivatives.
        order: usize,
    },
    /// The force of the device on a port, positive where it resists stretching; there is one for every port.
    PortForce {
        /// Index into [`EquationHost::ports`].
        index: usize,
    },
    /// The force of a constraint; a host has none, a system adds it.
    Reaction,
    /// Whatever else a system adds: values of elements, internal nodes, directions.
    Other(usize),
}

/// What a coordinate or a port measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Measure {
    /// A displacement, m.
    Translation,
    /// An angle, rad.
    Rotation,
    /// A plain number.
    Number,
}

impl Measure {
    /// SI dimension: m, rad or none.
    #[must_use]
    pub const fn dimension(self) -> Dimension {
        match self {
            Self::Translation => Dimension::LENGTH,
            Self::Rotation => Dimension::ANGLE,
            Self::Number => Dimension::NONE,
        }
    }

    /// SI dimension of the force that does work on it: N, N m; J on a plain number.
    #[must_use]
    pub const fn force_dimension(self) -> Dimension {
        match self {
            Self::Translation => Dimension::FORCE,
            Self::Rotation | Self::Number => Dimension::MOMENT,
        }
    }
}

impl From<CoordinateKind> for Measure {
    fn from(kind: CoordinateKind) -> Self {
        match kind {
            CoordinateKind::Translation => Self::Translation,
            CoordinateKind::Rotation => Self::Rotation,
        }
    }
}

/// A second-order coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct EquationCoordinate {
    /// The name in the host file.
    pub name: String,
    /// Displacement, angle or plain number.
    pub kind: Measure,
    /// SI dimension; none throughout a dimensionless host.
    pub dimension: Dimension,
    /// Whether its own acceleration is in no equation.
    pub massless: bool,
    /// Where a run in time begins, of parameters alone.
    pub start: Slot,
    /// The rate at which a run in time begins, of parameters alone.
    pub rate: Slot,
}

/// A first-order state.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstOrderState {
    /// The name in the host file.
    pub name: String,
    /// SI dimension.
    pub dimension: Dimension,
    /// Its rate of change in time.
    pub rate: Slot,
    /// Where a run in time begins, of parameters alone.
    pub start: Slot,
}

/// What an input of an equation host is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EquationInputKind {
    /// A force, or a prescribed displacement, velocity or acceleration.
    Mechanical(InputKind),
    /// Any other number, with or without unit.
    Number,
}

/// An excitation of an equation host.
#[derive(Debug, Clone, PartialEq)]
pub struct EquationInput {
    /// The name in the host file.
    pub name: String,
    /// What it is.
    pub kind: EquationInputKind,
    /// SI dimension of the input as it is given.
    pub dimension: Dimension,
    /// What it is in a run in time: its value and two derivatives; none: zero unless a run says otherwise.
    pub waveform: Option<Waveform>,
    /// How a harmonic one without sweep was typed, by parameters of the host.
    pub harmonic: Option<HarmonicLaw>,
}

/// A place where a device can act.
#[derive(Debug, Clone, PartialEq)]
pub struct EquationPort {
    /// The name in the host file.
    pub name: String,
    /// What the across-variable measures.
    pub kind: Measure,
    /// The across-variable x (relative displacement of the device's ends): of coordinates, inputs, parameters and time.
    pub across: Slot,
    /// SI dimension of the across-variable; none in a dimensionless host.
    pub dimension: Dimension,
    /// SI dimension of the device's force; none in a dimensionless host.
    pub force_dimension: Dimension,
    /// The graph input of the device's force F, [`Symbol::PortForce`].
    pub force_input: usize,
    /// The symbol of F if equations name it. Otherwise F acts by virtual work: F ∂x/∂q is to be added to each residual.
    pub force: Option<String>,
    /// Whether the device hangs: its far end is in the inertial frame, so it must end in a mass.
    pub hangs: bool,
    /// Whether the far side is the inertial frame, so that a mass may end a device there.
    pub grounded: bool,
}

/// A parameter of an equation host.
#[derive(Debug, Clone, PartialEq)]
pub struct HostParameter {
    /// The name in the host file.
    pub name: String,
    /// Its value as the file or an override gives it.
    pub value: Quantity,
    /// A graph input for a primary parameter; an expression of primary ones for a derived one.
    pub slot: Slot,
    /// The graph input of a primary parameter, [`Symbol::Parameter`].
    pub input: Option<usize>,
}

/// A named output.
#[derive(Debug, Clone, PartialEq)]
pub struct EquationOutput {
    /// The name in the host file.
    pub name: String,
    /// What it is.
    pub value: Slot,
    /// SI dimension.
    pub dimension: Dimension,
}

/// A named element within the equations, for `force(name)` and `stroke(name)`: those of a linear host.
#[derive(Debug, Clone, PartialEq)]
pub struct EquationElement {
    /// The name in the host file.
    pub name: String,
    /// What it is stretched by.
    pub stroke: Slot,
    /// Its force, where it has one in time.
    pub force: Option<Slot>,
    /// Displacement or angle.
    pub kind: Measure,
}

/// A host as equations.
///
/// With coordinates q, states s, inputs u, port forces F and parameters p the equations are
///
/// ```text
/// R_i(t, q, q', q'', s, s', u, u', u'', F, p) + Σ_ports F ∂x/∂q_i = 0     for each coordinate
/// s' = S(t, q, q', q'', s, u, …)                                          for each state
/// ```
///
/// where the sum is over the ports whose force has no symbol. Every residual has the sign in which inertia is positive:
/// ∂R_i/∂q_i'' > 0 at the start; for a massless coordinate ∂R_i/∂q_i > 0 or, where it is absent, ∂R_i/∂q_i' > 0. So the
/// force F of a device resists the motion it is stretched by, and F x' is power into the device.
///
/// All expressions are in one [`Graph`], whose inputs are [`symbols`](Self::symbols).
#[derive(Debug, Clone, Default)]
pub struct EquationHost {
    /// The title, or the file's name.
    pub name: String,
    /// The operations of everything below.
    pub graph: Graph,
    /// What graph input i is.
    pub symbols: Vec<Symbol>,
    /// Whether all numbers are plain and no units are checked.
    pub dimensionless: bool,
    /// The second-order coordinates.
    pub coordinates: Vec<EquationCoordinate>,
    /// R_i by coordinate, with the forces of those ports inside that have a symbol.
    pub residuals: Vec<Slot>,
    /// SI dimension of each residual; none where it is not known.
    pub residual_dimensions: Vec<Option<Dimension>>,
    /// The first-order states.
    pub states: Vec<FirstOrderState>,
    /// The inputs.
    pub inputs: Vec<EquationInput>,
    /// The ports.
    pub ports: Vec<EquationPort>,
    /// The parameters, in file order.
    pub parameters: Vec<HostParameter>,
    /// The named outputs.
    pub outputs: Vec<EquationOutput>,
    /// Named elements.
    pub elements: Vec<EquationElement>,
    /// Ranges of parameters in which the host works.
    pub operating: Vec<OperatingRange>,
    /// What the names of the file stand for.
    pub(crate) vocabulary: Vocabulary,
}

impl EquationHost {
    /// The graph input of a symbol.
    #[must_use]
    pub fn input(&self, symbol: Symbol) -> Option<usize> {
        self.symbols.iter().position(|known| *known == symbol)
    }

    /// Values of all graph inputs with parameters as they are in the file, time and all else zero.
    #[must_use]
    pub fn nominal(&self) -> Vec<f64> {
        self.symbols
            .iter()
            .map(|symbol| match symbol {
                Symbol::Parameter { index } => self
                    .parameters
                    .get(*index)
                    .map_or(f64::NAN, |parameter| parameter.value.value),
                _ => 0.0,
            })
            .collect()
    }

    /// What a run in time may be told to begin with: coordinates, their rates (`x'`) and states, with their SI dimensions.
    #[must_use]
    pub fn beginnings(&self) -> Vec<(String, Dimension)> {
        let time = if self.dimensionless {
            Dimension::NONE
        } else {
            Dimension::TIME
        };
        let coordinates = self.coordinates.iter().flat_map(|coordinate| {
            let rate = coordinate.dimension / time;
            [
                (coordinate.name.clone(), coordinate.dimension),
                (format!("{}'", coordinate.name), rate),
            ]
        });
        let states = self
            .states
            .iter()
            .map(|state| (state.name.clone(), state.dimension));
        coordinates.chain(states).collect()
    }

    /// Has runs in time begin with one of [`beginnings`](Self::beginnings) at a value (SI). False if there is none of this name.
    pub fn begin_with(&mut self, name: &str, value: f64) -> bool {
        let slot = self.graph.constant(value);
        let (plain, is_rate) = match name.strip_suffix('\'') {
            Some(plain) => (plain, true),
            None => (name, false),
        };
        if let Some(coordinate) = self.coordinates.iter_mut().find(|one| one.name == plain) {
            if is_rate {
                coordinate.rate = slot;
            } else {
                coordinate.start = slot;
            }
            return true;
        }
        match self.states.iter_mut().find(|one| one.name == name) {
            Some(state) => {
                state.start = slot;
                true
            }
            None => false,
        }
    }

    /// As [`nominal`](Self::nominal), with coordinates, rates and states where a run begins, and inputs at t = 0.
    #[must_use]
    pub fn start(&self) -> Vec<f64> {
        let mut inputs = self.nominal();
        let mut slots = Vec::new();
        for coordinate in &self.coordinates {
            slots.extend([coordinate.start, coordinate.rate]);
        }
        slots.extend(self.states.iter().map(|state| state.start));
        let values = self.graph.values(&slots, &inputs);
        let second = 2 * self.coordinates.len();
        let waves: Vec<[f64; 3]> = self
            .inputs
            .iter()
            .map(|input| {
                input
                    .waveform
                    .as_ref()
                    .map_or([0.0; 3], |wave| wave.value(0.0))
            })
            .collect();
        for (value, symbol) in inputs.iter_mut().zip(&self.symbols) {
            let found = match *symbol {
                Symbol::Coordinate { index, order } if order < 2 => {
                    values.get(2 * index + order).copied()
                }
                Symbol::State { index } => values.get(second + index).copied(),
                Symbol::Input { index, order } => {
                    waves.get(index).and_then(|wave| wave.get(order)).copied()
                }
                _ => None,
            };
            if let Some(found) = found {
                *value = found;
            }
        }
        inputs
    }
}

/// The range of a parameter in which a host works.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatingRange {
    /// Name of the parameter.
    pub parameter: String,
    /// Its SI dimension.
    pub dimension: Dimension,
    /// Lower end, SI.
    pub from: f64,
    /// Whether the lower end itself is left out (`above`).
    pub open: bool,
    /// Upper end, SI, included.
    pub to: f64,
}

impl OperatingRange {
    /// `count` values spread evenly over the range, the last at its upper end; the first at its lower end, unless that
    /// is left out: then one step above it.
    ///
    /// ```
    /// use quell_expression::Dimension;
    /// use quell_model::OperatingRange;
    ///
    /// let mut speeds = OperatingRange {
    ///     parameter: "V".to_owned(),
    ///     dimension: Dimension::VELOCITY,
    ///     from: 0.0,
    ///     open: true,
    ///     to: 200.0,
    /// };
    /// assert_eq!(speeds.samples(4), [50.0, 100.0, 150.0, 200.0]);
    /// speeds.open = false;
    /// assert_eq!(speeds.samples(3), [0.0, 100.0, 200.0]);
    /// ```
    #[must_use]
    pub fn samples(&self, count: usize) -> Vec<f64> {
        let steps = if self.open {
            count
        } else {
            count.saturating_sub(1)
        };
        let first = usize::from(self.open);
        (first..first + count)
            .map(|step| {
                if step == steps {
                    return self.to;
                }
                let part = step as f64 / steps as f64;
                self.from + (self.to - self.from) * part
            })
            .collect()
    }

    /// Whether a value lies in the range.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        value <= self.to && (value > self.from || (value == self.from && !self.open))
    }
}
