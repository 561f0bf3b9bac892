//! How displacements without mass of their own move, and what that does to elements.

use quell_expression::{Differentiation, Graph, Slot};
use quell_network::Node;

use super::device::{Device, ForceLaw};
use super::elimination::{combination, plus};
use super::error::SystemError;
use super::inputs::Inputs;
use super::structure::{Directions, Rows, dot, unit};
use crate::equations::{EquationHost, Symbol};

/// The across-variable of a port and its two derivatives, with rates of first-order states put in.
#[derive(Debug, Clone)]
pub(crate) struct Across {
    /// x, x', x''.
    pub(crate) motion: [Slot; 3],
    /// ∂x/∂q_i of every coordinate.
    pub(crate) slopes: Vec<Option<Slot>>,
    /// ∂R_j/∂F of every coordinate: how the port's force acts.
    pub(crate) levers: Vec<Option<Slot>>,
}

/// Which displacements U there are: massless coordinates of the host, then nodes of devices.
#[derive(Debug, Clone, Default)]
pub(crate) struct Displacements {
    /// The host's massless coordinates.
    pub(crate) massless: Vec<usize>,
    /// First node of each device.
    pub(crate) nodes: Vec<usize>,
    pub(crate) size: usize,
    /// Massless coordinates at ports whose coefficients are no plain numbers: they must stand alone in directions.
    pub(crate) alone: Vec<Option<usize>>,
}

impl Displacements {
    pub(crate) fn new(host: &EquationHost, devices: &[Device]) -> Self {
        let massless: Vec<usize> = host
            .coordinates
            .iter()
            .enumerate()
            .filter(|(_, coordinate)| coordinate.massless)
            .map(|(index, _)| index)
            .collect();
        let mut size = massless.len();
        let mut nodes = Vec::with_capacity(devices.len());
        for device in devices {
            nodes.push(size);
            size += device.mechanism.internal_nodes();
        }
        let alone = vec![None; massless.len()];
        Self {
            massless,
            nodes,
            size,
            alone,
        }
    }

    /// Place of a coordinate of the host among them.
    pub(crate) fn place(&self, coordinate: usize) -> Option<usize> {
        self.massless.iter().position(|known| *known == coordinate)
    }

    /// What a displacement is called.
    pub(crate) fn name(&self, host: &EquationHost, devices: &[Device], index: usize) -> String {
        if let Some(coordinate) = self
            .massless
            .get(index)
            .and_then(|place| host.coordinates.get(*place))
        {
            return format!("the coordinate `{}`", coordinate.name);
        }
        let found = self
            .nodes
            .iter()
            .zip(devices)
            .rev()
            .find(|(first, _)| **first <= index);
        match found {
            Some((first, device)) => {
                let node = index - first;
                let touching: Vec<String> = device
                    .mechanism
                    .elements()
                    .iter()
                    .filter(|element| [element.from, element.to].contains(&Node::Internal(node)))
                    .map(|element| format!("`{}`", element.name))
                    .collect();
                format!(
                    "the point between {} in the device `{}`",
                    touching.join(", "),
                    device.name
                )
            }
            None => format!("displacement {index}"),
        }
    }

    /// What the largest entry of a direction is called.
    pub(crate) fn largest(
        &self,
        host: &EquationHost,
        devices: &[Device],
        direction: &[f64],
    ) -> String {
        let mut best = (0.0, 0);
        for (index, entry) in direction.iter().enumerate() {
            if entry.abs() > best.0 {
                best = (entry.abs(), index);
            }
        }
        self.name(host, devices, best.1)
    }

    /// The element as a row over its nodes, and how often its port's head is in it.
    fn nodes_of(&self, devices: &[Device], device: usize, element: usize) -> (f64, Vec<f64>) {
        let mut row = vec![0.0; self.size];
        let mut head = 0.0;
        let first = self.nodes.get(device).copied().unwrap_or(0);
        if let Some(item) = devices
            .get(device)
            .and_then(|device| device.mechanism.elements().get(element))
        {
            for (node, sign) in [(item.from, 1.0), (item.to, -1.0)] {
                match node {
                    Node::Head => head += sign,
                    Node::Internal(node) => {
                        if let Some(entry) = row.get_mut(first + node) {
                            *entry += sign;
                        }
                    }
                    Node::Tail => {}
                }
            }
        }
        (head, row)
    }
}

/// An element as rows: how U stretches it, and how its force acts on U.
#[derive(Debug, Clone)]
pub(crate) struct ElementRow {
    pub(crate) device: usize,
    pub(crate) element: usize,
    /// How often the port's head is in it: 1, 0 (or -1).
    pub(crate) head: f64,
    /// Over nodes alone.
    pub(crate) nodes: Vec<f64>,
    /// Over U, with plain numbers for massless coordinates at the head.
    pub(crate) right: Vec<f64>,
    /// The same for its force.
    pub(crate) left: Vec<f64>,
    /// Over U for the structure: one where the coefficient is no plain number.
    right_touch: Vec<f64>,
    left_touch: Vec<f64>,
}

impl ElementRow {
    pub(crate) fn new(
        inputs: &Inputs,
        displacements: &Displacements,
        devices: &[Device],
        across: &[Across],
        held: Option<usize>,
        device: usize,
        element: usize,
    ) -> Self {
        let (head, nodes) = displacements.nodes_of(devices, device, element);
        let port = devices.get(device).map_or(0, |device| device.port);
        let mut row = Self {
            device,
            element,
            head,
            right: nodes.clone(),
            left: nodes.clone(),
            right_touch: nodes.clone(),
            left_touch: nodes.clone(),
            nodes,
        };
        if head == 0.0 {
            return row;
        }
        let Some(across) = across.get(port) else {
            return row;
        };
        for (place, coordinate) in displacements.massless.iter().enumerate() {
            let alone = displacements.alone.get(place).copied().flatten().is_some();
            let number = |slot: Option<Slot>| slot.map(|slot| inputs.graph.as_constant(slot));
            if let Some(known) = number(across.slopes.get(*coordinate).copied().flatten()) {
                row.right_touch[place] += head * known.unwrap_or(1.0);
                if !alone {
                    row.right[place] += head * known.unwrap_or(1.0);
                }
            }
            if held == Some(port) {
                continue;
            }
            if let Some(known) = number(across.levers.get(*coordinate).copied().flatten()) {
                row.left_touch[place] += head * known.unwrap_or(1.0);
                if !alone {
                    row.left[place] += head * known.unwrap_or(1.0);
                }
            }
        }
        row
    }
}

/// x, x' and x'' of the ports, and how forces act there.
pub(crate) fn across(host: &EquationHost, inputs: &mut Inputs, rates: &[Slot]) -> Vec<Across> {
    let seeds = formal_seeds(host, inputs, rates);
    let first: Vec<usize> = (0..host.coordinates.len())
        .map(|index| inputs.find(Symbol::Coordinate { index, order: 0 }))
        .collect();
    host.ports
        .iter()
        .map(|port| {
            let mut motion = [port.across; 3];
            for order in 1..3 {
                let slope = inputs
                    .graph
                    .tangent(&[motion[order - 1]], &seeds, Differentiation::Exact)
                    .first()
                    .copied()
                    .flatten();
                motion[order] = match slope {
                    Some(slope) => slope,
                    None => inputs.graph.constant(0.0),
                };
            }
            let slopes = inputs.graph.jacobian(&[port.across], &first);
            let levers = if port.force.is_some() {
                inputs.graph.jacobian(&host.residuals, &[port.force_input])
            } else {
                slopes.clone()
            };
            Across {
                motion,
                slopes,
                levers,
            }
        })
        .collect()
}

/// Seeds of the derivative in time: q' of q, q'' of q', rates of states, u' of u, one of t.
pub(crate) fn formal_seeds(
    host: &EquationHost,
    inputs: &mut Inputs,
    rates: &[Slot],
) -> Vec<(usize, Slot)> {
    let mut seeds = Vec::new();
    for index in 0..host.coordinates.len() {
        for order in 0..2 {
            let input = inputs.find(Symbol::Coordinate { index, order });
            let rate = inputs.slot(Symbol::Coordinate {
                index,
                order: order + 1,
            });
            seeds.push((input, rate));
        }
    }
    for (index, rate) in rates.iter().enumerate() {
        let input = inputs.find(Symbol::State { index });
        seeds.push((input, *rate));
    }
    for index in 0..host.inputs.len() {
        for order in 0..2 {
            let input = inputs.find(Symbol::Input { index, order });
            let rate = inputs.slot(Symbol::Input {
                index,
                order: order + 1,
            });
            seeds.push((input, rate));
        }
    }
    let time = inputs.find(Symbol::Time);
    let one = inputs.graph.constant(1.0);
    seeds.push((time, one));
    seeds
}

/// Directions of motion, and directions along which forces balance, with the graph inputs of the motions.
#[derive(Debug, Clone, Default)]
pub(crate) struct Motions {
    pub(crate) right: Directions,
    pub(crate) left: Directions,
    /// Position, rate and acceleration along every direction (in the order of [`Directions::all`]), where there is one.
    pub(crate) slots: Vec<[Option<Slot>; 3]>,
    /// Unknown positions of algebraic directions, and their rates.
    pub(crate) algebraic: Vec<usize>,
    pub(crate) algebraic_rates: Vec<usize>,
    /// Positions and unknown rates of first-order directions; rates of neutral ones.
    pub(crate) first: Vec<usize>,
    pub(crate) first_rates: Vec<usize>,
    pub(crate) neutral_rates: Vec<usize>,
    /// Unknown accelerations of conserved directions.
    pub(crate) conserved: Vec<usize>,
    /// Positions, rates and unknown accelerations of second-order directions; rates and accelerations of neutral ones.
    pub(crate) second: Vec<usize>,
    pub(crate) second_rates: Vec<usize>,
    pub(crate) second_accelerations: Vec<usize>,
    pub(crate) second_neutral_rates: Vec<usize>,
    pub(crate) second_neutral_accelerations: Vec<usize>,
}

impl Motions {
    pub(crate) fn new(right: Directions, left: Directions, inputs: &mut Inputs) -> Self {
        let [a, f, fn_, conserved, s, sn] = right.counts();
        let mut motions = Self {
            algebraic: inputs.others(a),
            algebraic_rates: inputs.others(a),
            first: inputs.others(f),
            first_rates: inputs.others(f),
            neutral_rates: inputs.others(fn_),
            conserved: inputs.others(conserved),
            second: inputs.others(s),
            second_rates: inputs.others(s),
            second_accelerations: inputs.others(s),
            second_neutral_rates: inputs.others(sn),
            second_neutral_accelerations: inputs.others(sn),
            right,
            left,
            slots: Vec::new(),
        };
        let groups: [[Option<&Vec<usize>>; 3]; 6] = [
            [
                Some(&motions.algebraic),
                Some(&motions.algebraic_rates),
                None,
            ],
            [Some(&motions.first), Some(&motions.first_rates), None],
            [None, Some(&motions.neutral_rates), None],
            [None, None, Some(&motions.conserved)],
            [
                Some(&motions.second),
                Some(&motions.second_rates),
                Some(&motions.second_accelerations),
            ],
            [
                None,
                Some(&motions.second_neutral_rates),
                Some(&motions.second_neutral_accelerations),
            ],
        ];
        let mut slots = Vec::new();
        for (group, count) in groups.iter().zip(motions.right.counts()) {
            for index in 0..count {
                slots.push(group.map(|known| {
                    known
                        .and_then(|known| known.get(index))
                        .map(|input| inputs.graph.input(*input))
                }));
            }
        }
        motions.slots = slots;
        motions
    }

    /// Σ_k (row · direction_k) times the motion along it; an error where that motion is in no state.
    ///
    /// Position, rate and acceleration by `order`. None for an empty sum.
    pub(crate) fn along(
        &self,
        graph: &mut Graph,
        row: &[f64],
        order: usize,
    ) -> Result<Option<Slot>, ()> {
        let mut terms = Vec::new();
        for (direction, slots) in self.right.all().zip(&self.slots) {
            let coefficient = dot(row, direction);
            if coefficient != 0.0 {
                terms.push((coefficient, slots.get(order).copied().flatten().ok_or(())?));
            }
        }
        Ok(combination(graph, &terms))
    }
}

/// The structure of host and devices: which rows hold what.
pub(crate) struct Structure<'a> {
    pub(crate) host: &'a EquationHost,
    pub(crate) devices: &'a [Device],
    pub(crate) displacements: &'a Displacements,
    pub(crate) elements: &'a [ElementRow],
    /// First-order rates, whose dependence on massless coordinates counts as well.
    pub(crate) rates: &'a [Slot],
}

impl Structure<'_> {
    /// Adapted directions for motions and for forces; `watched` are rows over U of which position (0) or rate (1) is
    /// needed besides.
    pub(crate) fn motions(
        &self,
        inputs: &mut Inputs,
        watched: &[(usize, Vec<f64>)],
    ) -> Result<Motions, SystemError> {
        let size = self.displacements.size;
        let mut right = Rows {
            size,
            ..Rows::default()
        };
        let mut left = right.clone();
        for row in self.elements {
            let Some(device) = self.devices.get(row.device) else {
                continue;
            };
            let Some(item) = device.mechanism.elements().get(row.element) else {
                continue;
            };
            let law = device.law(row.element);
            let springs = law.map_or(item.law.is_spring_like(), ForceLaw::depends_on_displacement);
            let dampers = law.map_or(item.law.is_damper_like(), ForceLaw::depends_on_rate);
            for (rows, touch) in [(&mut right, &row.right_touch), (&mut left, &row.left_touch)] {
                if springs {
                    rows.stiffness.push(touch.clone());
                }
                if dampers {
                    rows.damping.push(touch.clone());
                }
                if item.law.is_inertial() {
                    rows.inertia.push(touch.clone());
                }
            }
        }
        self.host_rows(inputs, &mut right, &mut left);
        for (order, row) in watched {
            for rows in [&mut right, &mut left] {
                if let Some(watched) = rows.watched.get_mut(*order) {
                    watched.push(row.clone());
                }
            }
        }
        let floating = |direction: Vec<f64>| SystemError::Floating {
            what: self
                .displacements
                .largest(self.host, self.devices, &direction),
        };
        let right = right.directions().map_err(floating)?;
        let left = left.directions().map_err(floating)?;
        if right.counts() != left.counts() {
            let what = right
                .all()
                .zip(left.all())
                .find(|(a, b)| a != b)
                .map_or_else(Vec::new, |(a, _)| a.clone());
            return Err(SystemError::Undetermined {
                what: self.displacements.largest(self.host, self.devices, &what),
            });
        }
        for direction in right.all().chain(left.all()) {
            let several = direction.iter().filter(|entry| **entry != 0.0).count() > 1;
            for (place, alone) in self.displacements.alone.iter().enumerate() {
                if let (Some(port), true) = (alone, several)
                    && direction.get(place).is_some_and(|entry| *entry != 0.0)
                {
                    let coordinate = self.displacements.massless.get(place);
                    return Err(SystemError::MasslessPort {
                        coordinate: coordinate
                            .and_then(|index| self.host.coordinates.get(*index))
                            .map(|coordinate| coordinate.name.clone())
                            .unwrap_or_default(),
                        port: self
                            .host
                            .ports
                            .get(*port)
                            .map(|port| port.name.clone())
                            .unwrap_or_default(),
                    });
                }
            }
        }
        Ok(Motions::new(right, left, inputs))
    }

    /// Rows of the host's own equations over its massless coordinates.
    fn host_rows(&self, inputs: &mut Inputs, right: &mut Rows, left: &mut Rows) {
        let count = self.displacements.massless.len();
        if count == 0 {
            return;
        }
        let size = self.displacements.size;
        let roots: Vec<Slot> = self
            .host
            .residuals
            .iter()
            .chain(self.rates)
            .copied()
            .collect();
        for order in 0..3 {
            let all: Vec<usize> = (0..self.host.coordinates.len())
                .map(|index| inputs.find(Symbol::Coordinate { index, order }))
                .collect();
            let columns: Vec<usize> = self
                .displacements
                .massless
                .iter()
                .filter_map(|coordinate| all.get(*coordinate).copied())
                .collect();
            let by_row = inputs.graph.jacobian(&roots, &columns);
            let own: Vec<Slot> = self
                .displacements
                .massless
                .iter()
                .filter_map(|coordinate| self.host.residuals.get(*coordinate).copied())
                .collect();
            let by_equation = inputs.graph.jacobian(&own, &all);
            let by_column: Vec<Option<Slot>> = (0..all.len())
                .flat_map(|column| {
                    (0..own.len())
                        .map(move |row| (row, column))
                        .collect::<Vec<_>>()
                })
                .map(|(row, column)| by_equation.get(row * all.len() + column).copied().flatten())
                .collect();
            for (rows, entries) in [(&mut *right, by_row), (&mut *left, by_column)] {
                let target = match order {
                    0 => &mut rows.stiffness,
                    1 => &mut rows.damping,
                    _ => &mut rows.inertia,
                };
                for entries in entries.chunks(count) {
                    host_row(inputs, entries, size, target);
                }
            }
        }
    }
}

/// A row of coefficients as numbers, if its direction does not depend on where it is looked at; else each entry by itself.
fn host_row(inputs: &Inputs, entries: &[Option<Slot>], size: usize, rows: &mut Vec<Vec<f64>>) {
    let touched: Vec<usize> = (0..entries.len())
        .filter(|place| entries[*place].is_some())
        .collect();
    let slots: Vec<Slot> = entries.iter().flatten().copied().collect();
    let normalised = |point: &[f64]| {
        let values = inputs.graph.values(&slots, point);
        let largest = values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        values
            .iter()
            .map(|value| value / largest)
            .collect::<Vec<f64>>()
    };
    let moved: Vec<f64> = inputs
        .sample
        .iter()
        .enumerate()
        .map(|(i, value)| value * (1.0 + 0.1 * ((i as f64) * 0.414_21).fract()) + 1e-3)
        .collect();
    let (here, there) = (normalised(&inputs.sample), normalised(&moved));
    // Written so that not-a-number is no direction.
    let fixed = here
        .iter()
        .zip(&there)
        .all(|(a, b)| (a - b).abs() <= 1e-12 || (a + b).abs() <= 1e-12);
    if fixed && touched.len() > 1 {
        let mut row = vec![0.0; size];
        for (place, value) in touched.iter().zip(&here) {
            row[*place] = *value;
        }
        rows.push(row);
    } else {
        rows.extend(touched.iter().map(|place| unit(size, *place)));
    }
}

/// head · (the port's motion) + the rest: the motion of an element.
pub(crate) fn element_motion(
    graph: &mut Graph,
    head: f64,
    across: Slot,
    rest: Option<Slot>,
) -> Slot {
    let own = combination(graph, &[(head, across)]);
    match plus(graph, own, rest) {
        Some(slot) => slot,
        None => graph.constant(0.0),
    }
}
