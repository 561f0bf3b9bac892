//! A linear host as equations.

use faer::Mat;
use quell_document::Fault;
use quell_expression::{Dimension, Graph, Slot};

use super::host::{
    EquationCoordinate, EquationElement, EquationHost, EquationInput, EquationInputKind,
    EquationOutput, EquationPort, FirstOrderState, HostParameter, Symbol,
};
use super::names::Vocabulary;
use crate::host::Host;
use crate::linear::{LinearForm, Signal};

impl EquationHost {
    /// The equations of a linear host, R = M q'' + C q' + K q - F0 u - F1 u' - F2 u''.
    ///
    /// Device forces act by virtual work on x_p = h_p·q + g_p·u. Where an input is a velocity or an acceleration and its
    /// integrals are needed, they are first-order states called after it, `NAME_displacement` and `NAME_velocity`, which
    /// begin at zero. Matrix entries are constants, the host's parameters having gone into them.
    ///
    /// # Errors
    /// A loss factor, which has no meaning in time; a mass matrix that is singular although each of some coordinates has
    /// mass, since their equations do not determine their accelerations.
    pub fn from_linear(host: &Host) -> Result<Self, Fault> {
        let linear = &host.linear;
        if linear.loss.is_some() {
            return Err(Fault::new(format!(
                "`{}` has a loss factor, which is defined for frequency responses only",
                linear.name
            ))
            .help("write dampers instead, or `damping = { modal = … }`"));
        }
        let massless: Vec<bool> = (0..linear.coordinates.len())
            .map(|row| {
                (0..linear.coordinates.len()).all(|column| linear.mass[(row, column)] == 0.0)
            })
            .collect();
        if is_singular(&linear.mass, &massless) {
            return Err(Fault::new(format!(
                "the mass matrix of `{}` is singular, though every coordinate concerned has mass",
                linear.name
            ))
            .help(
                "choose the coordinates so that each either has mass of its own or none at all",
            ));
        }
        Ok(Lowering::new(host).finish(&massless))
    }
}

/// Whether the rows that are not empty have a combination without mass: Cholesky's method with a pivot that is a rounding
/// of its diagonal entry.
fn is_singular(mass: &Mat<f64>, massless: &[bool]) -> bool {
    let rows: Vec<usize> = (0..massless.len()).filter(|&row| !massless[row]).collect();
    let count = rows.len();
    let mut factor = Mat::<f64>::zeros(count, count);
    for i in 0..count {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| factor[(i, k)] * factor[(j, k)]).sum();
            let rest = mass[(rows[i], rows[j])] - sum;
            if i == j {
                // Written so that not-a-number is refused as well.
                let positive = rest > 1e-13 * mass[(rows[i], rows[i])];
                if !positive {
                    return true;
                }
                factor[(i, i)] = rest.sqrt();
            } else {
                factor[(i, j)] = rest / factor[(j, j)];
            }
        }
    }
    false
}

struct Lowering<'a> {
    host: &'a Host,
    graph: Graph,
    symbols: Vec<Symbol>,
    states: Vec<FirstOrderState>,
    /// u, u' and u'' of each input.
    motions: Vec<[Slot; 3]>,
}

impl<'a> Lowering<'a> {
    fn new(host: &'a Host) -> Self {
        let linear = &host.linear;
        let mut symbols = vec![Symbol::Time];
        symbols.extend((0..host.parameters.len()).map(|index| Symbol::Parameter { index }));
        let orders = [0, 1, 2];
        for index in 0..linear.coordinates.len() {
            symbols.extend(orders.map(|order| Symbol::Coordinate { index, order }));
        }
        for index in 0..linear.inputs.len() {
            symbols.extend(orders.map(|order| Symbol::Input { index, order }));
        }
        symbols.extend((0..linear.ports.len()).map(|index| Symbol::PortForce { index }));
        let mut lowering = Self {
            host,
            graph: Graph::default(),
            symbols,
            states: Vec::new(),
            motions: Vec::new(),
        };
        for index in 0..linear.inputs.len() {
            let motion = lowering.motion(index);
            lowering.motions.push(motion);
        }
        lowering
    }

    fn symbol(&mut self, symbol: Symbol) -> Slot {
        let index = self
            .symbols
            .iter()
            .position(|known| *known == symbol)
            .unwrap_or(self.symbols.len());
        if index == self.symbols.len() {
            self.symbols.push(symbol);
        }
        self.graph.input(index)
    }

    fn zero(&mut self) -> Slot {
        self.graph.constant(0.0)
    }

    /// Whether anything depends on u of an input differentiated `order` times.
    fn is_needed(&self, input: usize, order: usize) -> bool {
        let linear = &self.host.linear;
        let forms = linear.outputs.iter().map(|output| &output.form);
        let elements = &self.host.elements;
        let named = elements
            .iter()
            .flat_map(|element| std::iter::once(&element.stroke).chain(&element.force));
        let signal = Signal::Input {
            index: input,
            order,
        };
        let mut forms = forms.chain(named);
        let ports = order == 0 && linear.ports.iter().any(|port| port.inputs[input] != 0.0);
        let forcing =
            (0..linear.coordinates.len()).any(|row| linear.forcing[order][(row, input)] != 0.0);
        ports || forcing || forms.any(|form| form.terms.iter().any(|(known, _)| *known == signal))
    }

    /// u, u' and u'' of an input: what is not given is integrated.
    fn motion(&mut self, index: usize) -> [Slot; 3] {
        let input = &self.host.linear.inputs[index];
        let given = input.kind.integrations();
        let mut motion = [self.zero(); 3];
        for (order, slot) in motion.iter_mut().enumerate().skip(given) {
            *slot = self.symbol(Symbol::Input {
                index,
                order: order - given,
            });
        }
        let mut needed = false;
        let wanted: Vec<bool> = (0..given)
            .map(|order| {
                needed |= self.is_needed(index, order);
                needed
            })
            .collect();
        // u' is a state before u is, which is its integral.
        for order in (0..given).rev().filter(|&order| wanted[order]) {
            let (what, dimension) = match order {
                0 => ("displacement", input.motion.dimension()),
                _ => ("velocity", input.motion.dimension() / Dimension::TIME),
            };
            let start = self.zero();
            let state = Symbol::State {
                index: self.states.len(),
            };
            self.states.push(FirstOrderState {
                name: format!("{}_{what}", input.name),
                dimension,
                rate: motion[order + 1],
                start,
            });
            motion[order] = self.symbol(state);
        }
        motion
    }

    fn times(&mut self, coefficient: f64, slot: Slot) -> Slot {
        let coefficient = self.graph.constant(coefficient);
        self.graph.multiply(coefficient, slot)
    }

    fn sum(&mut self, terms: Vec<(f64, Slot)>) -> Slot {
        let mut total: Option<Slot> = None;
        for (coefficient, slot) in terms {
            if coefficient == 0.0 {
                continue;
            }
            let term = self.times(coefficient, slot);
            total = Some(match total {
                Some(total) => self.graph.add(total, term),
                None => term,
            });
        }
        match total {
            Some(total) => total,
            None => self.zero(),
        }
    }

    fn signal(&mut self, signal: &Signal) -> Slot {
        match *signal {
            Signal::Coordinate { index, order } => self.symbol(Symbol::Coordinate { index, order }),
            Signal::Input { index, order } => self.motions[index][order],
            Signal::PortForce { index } => self.symbol(Symbol::PortForce { index }),
            // Parts of devices are unknown to a host.
            Signal::PartStroke { .. } | Signal::PartForce { .. } => self.graph.constant(f64::NAN),
        }
    }

    fn form(&mut self, form: &LinearForm) -> Slot {
        let terms = form
            .terms
            .iter()
            .map(|(signal, coefficient)| (*coefficient, self.signal(signal)))
            .collect();
        self.sum(terms)
    }

    fn residual(&mut self, row: usize) -> Slot {
        let linear = &self.host.linear;
        let matrices = [&linear.stiffness, &linear.damping, &linear.mass];
        let mut terms = Vec::new();
        for order in [2, 1, 0] {
            for index in 0..linear.coordinates.len() {
                let coefficient = matrices[order][(row, index)];
                terms.push((
                    coefficient,
                    self.symbol(Symbol::Coordinate { index, order }),
                ));
            }
        }
        for (order, forcing) in linear.forcing.iter().enumerate() {
            for input in 0..linear.inputs.len() {
                terms.push((-forcing[(row, input)], self.motions[input][order]));
            }
        }
        self.sum(terms)
    }

    fn finish(mut self, massless: &[bool]) -> EquationHost {
        let (host, linear) = (self.host, &self.host.linear);
        let residuals = (0..linear.coordinates.len())
            .map(|row| self.residual(row))
            .collect();
        let coordinates = linear
            .coordinates
            .iter()
            .zip(massless)
            .enumerate()
            .map(|(index, (coordinate, &massless))| {
                let [start, rate] = host.starts.get(index).copied().unwrap_or_default();
                EquationCoordinate {
                    name: coordinate.name.clone(),
                    kind: coordinate.kind.into(),
                    dimension: coordinate.kind.dimension(),
                    massless,
                    start: self.graph.constant(start),
                    rate: self.graph.constant(rate),
                }
            })
            .collect();
        let mut ports = Vec::new();
        for (index, port) in linear.ports.iter().enumerate() {
            let mut terms = Vec::new();
            for (index, &coefficient) in port.coordinates.iter().enumerate() {
                terms.push((
                    coefficient,
                    self.symbol(Symbol::Coordinate { index, order: 0 }),
                ));
            }
            for (input, &coefficient) in port.inputs.iter().enumerate() {
                terms.push((coefficient, self.motions[input][0]));
            }
            let across = self.sum(terms);
            let symbol = Symbol::PortForce { index };
            ports.push(EquationPort {
                name: port.name.clone(),
                kind: port.kind.into(),
                across,
                dimension: port.kind.dimension(),
                force_dimension: port.kind.force_dimension(),
                force_input: self
                    .symbols
                    .iter()
                    .position(|known| *known == symbol)
                    .unwrap_or(usize::MAX),
                force: None,
                hangs: port.hangs,
                grounded: port.grounded,
            });
        }
        let inputs = linear
            .inputs
            .iter()
            .enumerate()
            .map(|(index, input)| EquationInput {
                name: input.name.clone(),
                kind: EquationInputKind::Mechanical(input.kind),
                dimension: input.dimension,
                waveform: host.waveforms.get(index).cloned().flatten(),
                harmonic: None,
            })
            .collect();
        let mut parameters = Vec::new();
        for (index, (name, value)) in host.parameters.iter().enumerate() {
            let slot = self.symbol(Symbol::Parameter { index });
            parameters.push(HostParameter {
                name: name.clone(),
                value: *value,
                slot,
                input: self.graph.as_input(slot),
            });
        }
        let mut outputs = Vec::new();
        for output in &linear.outputs {
            outputs.push(EquationOutput {
                name: output.name.clone(),
                value: self.form(&output.form),
                dimension: output.dimension,
            });
        }
        let mut elements = Vec::new();
        for element in &host.elements {
            elements.push(EquationElement {
                name: element.name.clone(),
                stroke: self.form(&element.stroke),
                force: element.force.as_ref().map(|force| self.form(force)),
                kind: element.kind.into(),
            });
        }
        EquationHost {
            name: linear.name.clone(),
            graph: self.graph,
            symbols: self.symbols,
            dimensionless: false,
            residual_dimensions: linear
                .coordinates
                .iter()
                .map(|coordinate| Some(coordinate.kind.force_dimension()))
                .collect(),
            coordinates,
            residuals,
            states: self.states,
            inputs,
            ports,
            parameters,
            outputs,
            elements,
            operating: Vec::new(),
            vocabulary: Vocabulary::default(),
        }
    }
}
