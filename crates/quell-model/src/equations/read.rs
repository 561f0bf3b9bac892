//! From a host file to its equations.

use quell_document::{Fault, Table, Value};
use quell_expression::{Dimension, Expression, Graph, Lowering, Quantity, Slot, Span};

use super::amounts::Amounts;
use super::host::{
    EquationCoordinate, EquationHost, EquationInput, EquationOutput, EquationPort, FirstOrderState,
    HostParameter, Measure, Symbol,
};
use super::names::{HostNames, NoExtraNames, Vocabulary};
use super::residuals::Residual;
use super::sections::{TypedCoordinate, TypedState};
use super::{lagrangian, place, ports, residuals, sections};
use crate::host::file::section;
use crate::host::names::Names;
use crate::host::order::order;
use crate::host::parameters::parameters;
use crate::host::{HostFile, Override};

impl HostFile {
    /// The host as equations, some parameters replaced; a linear host becomes one by [`EquationHost::from_linear`].
    ///
    /// A parameter that a study replaces is a primary one, even if the file derives it from others.
    ///
    /// # Errors
    /// Whatever is wrong in the file, with its place: unknown names with the nearest valid ones, units that do not fit, a
    /// coordinate without an equation, an equation that does not determine its coordinate, definitions that need
    /// themselves.
    pub fn equations(&self, overrides: &[Override]) -> Result<EquationHost, Fault> {
        if !self.is_equations() {
            return EquationHost::from_linear(&self.assemble(overrides)?);
        }
        Reader::new(self, overrides)?.read()
    }
}

/// What was typed, before anything is lowered.
struct Reader<'a> {
    file: &'a HostFile,
    root: Table<'a>,
    coordinates: Vec<TypedCoordinate<'a>>,
    states: Vec<TypedState<'a>>,
    definitions: Vec<(String, Value<'a>, Expression)>,
    outputs: Vec<(String, Value<'a>, Expression)>,
    ports: Vec<ports::TypedPort<'a>>,
    /// Derived parameters, definitions and outputs: what has no slot of its own yet.
    pending: Vec<(String, Expression)>,
    /// The host so far: symbols and names, with places for what follows.
    host: EquationHost,
}

impl<'a> Reader<'a> {
    fn new(file: &'a HostFile, overrides: &[Override]) -> Result<Self, Fault> {
        let root = file.document().root();
        let dimensionless = root
            .get("dimensionless")
            .map_or(Ok(false), |value| value.as_bool())?;
        let mut names = Names::default();
        names.reserve("t", "time");
        let table = section(&root, "parameters")?;
        let mut values = parameters(table.as_ref(), overrides, &mut names)?;
        if dimensionless {
            for (name, quantity) in &mut values {
                let place = table.as_ref().and_then(|table| table.get(name));
                if let Some(place) = place
                    && !quantity.dimension.without_angle().is_none()
                {
                    return Err(place
                        .fault(format!(
                            "`{name}` is in `{}`, but the host is dimensionless",
                            quantity.dimension.unit_text()
                        ))
                        .help("leave out the unit, or `dimensionless`"));
                }
                quantity.dimension = Dimension::NONE;
            }
        }
        let amounts = Amounts {
            parameters: &values,
            dimensionless,
        };
        let coordinates = section(&root, "coordinates")?
            .map(|table| sections::coordinates(&table, amounts, &mut names))
            .transpose()?
            .unwrap_or_default();
        let inputs = section(&root, "inputs")?
            .map(|table| sections::inputs(&table, amounts, file.folder(), &mut names))
            .transpose()?
            .unwrap_or_default();
        let states = section(&root, "states")?
            .map(|table| sections::states(&table, amounts, &mut names))
            .transpose()?
            .unwrap_or_default();
        let definitions = sections::expressions(
            section(&root, "definitions")?.as_ref(),
            "a definition",
            &mut names,
        )?;
        let functions = section(&root, "functions")?
            .map(|table| sections::functions(&table, &mut names))
            .transpose()?
            .unwrap_or_default();
        let ports = section(&root, "ports")?
            .map(|table| ports::typed(&table, &mut names))
            .transpose()?
            .unwrap_or_default();
        let outputs =
            sections::expressions(section(&root, "outputs")?.as_ref(), "an output", &mut names)?;
        let operating = section(&root, "operating")?
            .map(|table| sections::operating(&table, amounts))
            .transpose()?
            .unwrap_or_default();
        let mut reader = Self {
            file,
            coordinates,
            states,
            ports,
            pending: Vec::new(),
            host: EquationHost {
                name: file.title().to_owned(),
                graph: Graph::default(),
                symbols: Vec::new(),
                dimensionless,
                coordinates: Vec::new(),
                residuals: Vec::new(),
                residual_dimensions: Vec::new(),
                states: Vec::new(),
                inputs,
                ports: Vec::new(),
                parameters: Vec::new(),
                outputs: Vec::new(),
                elements: Vec::new(),
                operating,
                vocabulary: Vocabulary {
                    definitions: Vec::new(),
                    functions,
                },
            },
            definitions,
            outputs,
            root,
        };
        let derived = reader.derived(&values, overrides)?;
        reader.host.symbols = reader.symbols(&derived);
        reader.outline(values, derived);
        Ok(reader)
    }

    /// By parameter the expression from which it is derived; none for a primary or replaced one.
    fn derived(
        &self,
        values: &[(String, Quantity)],
        overrides: &[Override],
    ) -> Result<Vec<Option<Expression>>, Fault> {
        let table = section(&self.root, "parameters")?;
        values
            .iter()
            .map(|(name, _)| {
                let typed = table
                    .as_ref()
                    .and_then(|table| table.get(name))
                    .map(|value| value.expression())
                    .transpose()?;
                Ok(typed.filter(|typed| {
                    let replaced = overrides.iter().any(|one| one.name == *name);
                    !replaced && typed.names().iter().any(|used| *used != "pi")
                }))
            })
            .collect()
    }

    /// The graph inputs.
    fn symbols(&self, derived: &[Option<Expression>]) -> Vec<Symbol> {
        let mut symbols = vec![Symbol::Time];
        for (index, derived) in derived.iter().enumerate() {
            if derived.is_none() {
                symbols.push(Symbol::Parameter { index });
            }
        }
        let orders = [0, 1, 2];
        for index in 0..self.coordinates.len() {
            symbols.extend(orders.map(|order| Symbol::Coordinate { index, order }));
        }
        for index in 0..self.states.len() {
            symbols.extend([Symbol::State { index }, Symbol::StateRate { index }]);
        }
        for index in 0..self.host.inputs.len() {
            symbols.extend(orders.map(|order| Symbol::Input { index, order }));
        }
        symbols.extend((0..self.ports.len()).map(|index| Symbol::PortForce { index }));
        symbols
    }

    /// Fills the host with everything that has a name; slots that are not known yet are zero.
    fn outline(&mut self, values: Vec<(String, Quantity)>, derived: Vec<Option<Expression>>) {
        let host = &mut self.host;
        let zero = host.graph.constant(0.0);
        for (index, ((name, value), derived)) in values.into_iter().zip(derived).enumerate() {
            let input = host.input(Symbol::Parameter { index });
            if let Some(derived) = derived {
                self.pending.push((name.clone(), derived));
            }
            host.parameters.push(HostParameter {
                name,
                value,
                slot: input.map_or(zero, |input| host.graph.input(input)),
                input,
            });
        }
        let expressions = self.definitions.iter().chain(&self.outputs);
        self.pending
            .extend(expressions.map(|(name, _, expression)| (name.clone(), expression.clone())));
        host.coordinates = self
            .coordinates
            .iter()
            .map(|typed| EquationCoordinate {
                name: typed.name.clone(),
                kind: typed.kind,
                dimension: typed.dimension,
                massless: typed.massless,
                start: zero,
                rate: zero,
            })
            .collect();
        host.states = self
            .states
            .iter()
            .map(|typed| FirstOrderState {
                name: typed.name.clone(),
                dimension: typed.dimension.unwrap_or_default(),
                rate: zero,
                start: zero,
            })
            .collect();
        for (index, typed) in self.ports.iter().enumerate() {
            host.ports.push(EquationPort {
                name: typed.name.clone(),
                kind: Measure::Number,
                across: zero,
                dimension: Dimension::NONE,
                force_dimension: Dimension::NONE,
                force_input: host
                    .input(Symbol::PortForce { index })
                    .unwrap_or(usize::MAX),
                force: typed.force.clone(),
                hangs: typed.hangs,
                grounded: false,
            });
        }
    }

    fn read(mut self) -> Result<EquationHost, Fault> {
        self.parameters()?;
        self.starts()?;
        self.units_of_states()?;
        self.across()?;
        let residuals = self.dynamics()?;
        let mut graph = std::mem::take(&mut self.host.graph);
        let oriented = self.orient(residuals, &mut graph);
        self.host.graph = graph;
        oriented?;
        Ok(self.host)
    }

    /// Lowers something into the host's graph in its vocabulary.
    fn lowered<T>(
        &mut self,
        work: impl FnOnce(&Self, &HostNames<'_>, &mut Lowering<'_>, &mut Graph) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        let mut graph = std::mem::take(&mut self.host.graph);
        let names = HostNames::new(&self.host, &self.pending, &NoExtraNames);
        let mut lowering = Lowering::new(&names);
        let done = work(self, &names, &mut lowering, &mut graph);
        drop(lowering);
        drop(names);
        self.host.graph = graph;
        done
    }

    /// Slots of derived parameters.
    fn parameters(&mut self) -> Result<(), Fault> {
        let slots = self.lowered(|reader, _, lowering, graph| {
            let mut slots = Vec::new();
            for (index, parameter) in reader.host.parameters.iter().enumerate() {
                let pending = reader
                    .pending
                    .iter()
                    .find(|(name, _)| *name == parameter.name);
                if let (None, Some((_, expression))) = (parameter.input, pending) {
                    let (slot, _) = lowering
                        .lower(graph, expression)
                        .map_err(|error| reader.at(error))?;
                    slots.push((index, slot));
                }
            }
            Ok(slots)
        })?;
        for (index, slot) in slots {
            let parameter = &mut self.host.parameters[index];
            parameter.slot = slot;
            self.pending.retain(|(name, _)| *name != parameter.name);
        }
        Ok(())
    }

    fn at(&self, error: quell_expression::ExpressionError) -> Fault {
        place::fault(self.file.source(), error)
    }

    /// Where runs begin.
    fn starts(&mut self) -> Result<(), Fault> {
        let slots = self.lowered(|reader, _, lowering, graph| {
            let mut slots = Vec::new();
            for typed in &reader.coordinates {
                let rate = reader.per_time(typed.dimension);
                let mut read = |value: &Option<Value<'_>>, dimension| match value {
                    Some(value) => reader.start(value, Some(dimension), lowering, graph),
                    None => Ok((graph.constant(0.0), dimension)),
                };
                let (start, _) = read(&typed.start, typed.dimension)?;
                let (rate, _) = read(&typed.rate, rate)?;
                slots.push([start, rate]);
            }
            Ok(slots)
        })?;
        for (coordinate, [start, rate]) in self.host.coordinates.iter_mut().zip(slots) {
            coordinate.start = start;
            coordinate.rate = rate;
        }
        Ok(())
    }

    fn per_time(&self, dimension: Dimension) -> Dimension {
        if self.host.dimensionless {
            dimension
        } else {
            dimension / Dimension::TIME
        }
    }

    /// An initial value, of parameters alone; a number is SI.
    fn start(
        &self,
        value: &Value<'_>,
        wanted: Option<Dimension>,
        lowering: &mut Lowering<'_>,
        graph: &mut Graph,
    ) -> Result<(Slot, Dimension), Fault> {
        if value.is_number() {
            let slot = graph.constant(value.as_f64()?);
            return Ok((slot, wanted.unwrap_or_default()));
        }
        let expression = value.expression()?;
        let (slot, dimension) = lowering
            .lower(graph, &expression)
            .map_err(|error| self.at(error))?;
        let varies = graph
            .dependence(&[slot])
            .into_iter()
            .any(|input| !matches!(self.host.symbols.get(input), Some(Symbol::Parameter { .. })));
        if varies {
            return Err(value
                .fault("where a run begins must follow from parameters alone")
                .help("leave out whatever moves"));
        }
        match wanted {
            Some(wanted)
                if !self.host.dimensionless
                    && wanted.without_angle() != dimension.without_angle() =>
            {
                Err(value.fault(format!("expected {wanted}, found {dimension}")))
            }
            _ => Ok((slot, wanted.unwrap_or(dimension))),
        }
    }

    /// Finds the units of states that do not say theirs, and lowers where they begin.
    fn units_of_states(&mut self) -> Result<(), Fault> {
        for index in 0..self.states.len() {
            if self.states[index].dimension.is_none() {
                let dimension = self.unit_of_state(index)?;
                self.host.states[index].dimension = dimension;
            }
        }
        let starts = self.lowered(|reader, _, lowering, graph| {
            let mut starts = Vec::new();
            for (typed, state) in reader.states.iter().zip(&reader.host.states) {
                starts.push(match &typed.start {
                    Some(value) => {
                        reader
                            .start(value, Some(state.dimension), lowering, graph)?
                            .0
                    }
                    None => graph.constant(0.0),
                });
            }
            Ok(starts)
        })?;
        for (state, start) in self.host.states.iter_mut().zip(starts) {
            state.start = start;
        }
        Ok(())
    }

    /// The one unit, of those that occur in the host, with which the rate of a state is consistent. Further states without
    /// unit are taken to be of the same.
    ///
    /// What the unit must satisfy is linear in its exponents: one unit does, or none, or all. So one that nobody has tells
    /// whether all do, and otherwise the first that fits is the only one.
    fn unit_of_state(&mut self, index: usize) -> Result<Dimension, Fault> {
        let place = self.states[index].rate.clone();
        let expression = place.expression()?;
        let open: Vec<usize> = (0..self.states.len())
            .filter(|&other| {
                other == index || (other > index && self.states[other].dimension.is_none())
            })
            .collect();
        let candidates = self.candidates(index);
        let strange = Dimension::new(7, -11, 13, 0);
        let (mut found, mut refusals) = (None, Vec::new());
        for &candidate in std::iter::once(&strange).chain(&candidates) {
            for &other in &open {
                self.host.states[other].dimension = candidate;
            }
            let names = HostNames::new(&self.host, &self.pending, &NoExtraNames);
            let mut scratch = self.host.graph.clone();
            match Lowering::new(&names).lower(&mut scratch, &expression) {
                Ok((_, rate)) => {
                    let wanted = candidate / Dimension::TIME;
                    if rate.without_angle() == wanted.without_angle() {
                        found = Some(candidate);
                        break;
                    }
                }
                Err(error) => refusals.push(error),
            }
        }
        for &other in &open {
            self.host.states[other].dimension = Dimension::NONE;
        }
        if let Some(found) = found.filter(|found| *found != strange) {
            return Ok(found);
        }
        // Whatever is wrong with any unit is not about units.
        if let Some(first) = refusals.first()
            && refusals.len() > candidates.len()
            && refusals.iter().all(|error| error == first)
        {
            return Err(self.at(first.clone()));
        }
        let name = &self.states[index].name;
        Err(place
            .fault(format!(
                "the unit of `{name}` does not follow from its rate"
            ))
            .help(format!(
                "write `{name} = {{ rate = \"…\", unit = \"m\" }}` with its unit"
            )))
    }

    /// Units that a state may have, rad left out, likely ones first: those of earlier states, the common ones, those of
    /// inputs and parameters.
    fn candidates(&self, state: usize) -> Vec<Dimension> {
        let host = &self.host;
        let states = host.states.iter().take(state).map(|one| one.dimension);
        let common = [
            Dimension::LENGTH,
            Dimension::NONE,
            Dimension::FORCE,
            Dimension::MOMENT,
            Dimension::VELOCITY,
            Dimension::PRESSURE,
            Dimension::TEMPERATURE,
            Dimension::CURRENT,
        ];
        let inputs = host.inputs.iter().map(|one: &EquationInput| one.dimension);
        let parameters = host.parameters.iter().map(|one| one.value.dimension);
        let mut candidates: Vec<Dimension> = Vec::new();
        for dimension in states.chain(common).chain(inputs).chain(parameters) {
            let plain = dimension.without_angle();
            if !candidates.contains(&plain) {
                candidates.push(plain);
            }
        }
        candidates
    }

    /// The across-variables of ports.
    fn across(&mut self) -> Result<(), Fault> {
        let found = self.lowered(|reader, _, lowering, graph| {
            reader
                .ports
                .iter()
                .map(|port| ports::across(port, &reader.host, graph, lowering))
                .collect::<Result<Vec<_>, _>>()
        })?;
        let dimensionless = self.host.dimensionless;
        for (port, found) in self.host.ports.iter_mut().zip(found) {
            port.across = found.slot;
            port.kind = found.kind;
            port.grounded = found.grounded;
            if !dimensionless {
                port.dimension = found.kind.dimension();
                port.force_dimension = found.kind.force_dimension();
            }
        }
        Ok(())
    }

    /// Lowers equations, rates, definitions and outputs.
    fn dynamics(&mut self) -> Result<Vec<Residual<'a>>, Fault> {
        let (residuals, rates, definitions, outputs) =
            self.lowered(|reader, names, lowering, graph| {
                // Definitions first: what is wrong in one is shown there.
                let mut lower = |list: &[(String, Value<'_>, Expression)],
                                 lowering: &mut Lowering<'_>| {
                    list.iter()
                        .map(|(name, _, expression)| {
                            let (slot, dimension) = lowering
                                .lower(graph, expression)
                                .map_err(|error| reader.at(error))?;
                            Ok((name.clone(), slot, dimension))
                        })
                        .collect::<Result<Vec<_>, Fault>>()
                };
                let definitions = lower(&reader.definitions, lowering)?;
                let outputs = lower(&reader.outputs, lowering)?;
                let rates = reader.rates(lowering, graph)?;
                let residuals = reader.residuals(names, lowering, graph)?;
                Ok((residuals, rates, definitions, outputs))
            })?;
        for (state, rate) in self.host.states.iter_mut().zip(rates) {
            state.rate = rate;
        }
        self.host.vocabulary.definitions = definitions;
        self.host.outputs = outputs
            .into_iter()
            .map(|(name, value, dimension)| EquationOutput {
                name,
                value,
                dimension,
            })
            .collect();
        self.pending.clear();
        self.check_rates()?;
        Ok(residuals)
    }

    fn rates(&self, lowering: &mut Lowering<'_>, graph: &mut Graph) -> Result<Vec<Slot>, Fault> {
        let mut rates = Vec::new();
        for (typed, state) in self.states.iter().zip(&self.host.states) {
            let expression = typed.rate.expression()?;
            let (slot, dimension) = lowering
                .lower(graph, &expression)
                .map_err(|error| self.at(error))?;
            let wanted = self.per_time(state.dimension);
            let zero = graph.as_constant(slot) == Some(0.0);
            if !self.host.dimensionless
                && !zero
                && wanted.without_angle() != dimension.without_angle()
            {
                return Err(typed.rate.fault(format!(
                    "the rate of `{}` is in {wanted}, but this is {dimension}",
                    typed.name
                )));
            }
            rates.push(slot);
        }
        Ok(rates)
    }

    fn residuals(
        &self,
        names: &HostNames<'_>,
        lowering: &mut Lowering<'_>,
        graph: &mut Graph,
    ) -> Result<Vec<Residual<'a>>, Fault> {
        let places: Vec<Span> = self.coordinates.iter().map(|typed| typed.span).collect();
        match (self.root.get("equations"), self.root.get("lagrangian")) {
            (Some(_), Some(lagrangian)) => Err(lagrangian
                .fault("`[equations]` and `[lagrangian]` cannot be used together")
                .help("forces that have no potential go into `forces` of the Lagrangian")),
            (Some(equations), None) => {
                residuals::equations(&equations.as_table()?, &self.host, &places, graph, lowering)
            }
            (None, Some(lagrangian)) => {
                lagrangian::residuals(&lagrangian, &self.host, graph, lowering, names)
            }
            (None, None) => match self.coordinates.first() {
                Some(first) => Err(Fault::at(
                    self.file.source(),
                    first.span,
                    format!("the coordinate `{}` has no equation", first.name),
                )
                .help("write `[equations]`, or `[lagrangian]`")),
                None => Ok(Vec::new()),
            },
        }
    }

    /// Refuses rates of states that need each other.
    fn check_rates(&self) -> Result<(), Fault> {
        let host = &self.host;
        let needs: Vec<Vec<usize>> = host
            .states
            .iter()
            .map(|state| {
                host.graph
                    .dependence(&[state.rate])
                    .into_iter()
                    .filter_map(|input| match host.symbols.get(input) {
                        Some(Symbol::StateRate { index }) => Some(*index),
                        _ => None,
                    })
                    .collect()
            })
            .collect();
        let Err(cycle) = order(&needs) else {
            return Ok(());
        };
        let chain: Vec<String> = cycle
            .iter()
            .chain(cycle.first())
            .filter_map(|&index| self.states.get(index))
            .map(|state| format!("`{}'`", state.name))
            .collect();
        let message = format!("these rates need each other: {}", chain.join(" needs "));
        Err(
            match cycle.first().and_then(|&index| self.states.get(index)) {
                Some(state) => state.rate.fault(message),
                None => Fault::new(message),
            },
        )
    }

    /// Signs of residuals, and whether forces of devices reach them.
    fn orient(&mut self, mut residuals: Vec<Residual<'a>>, graph: &mut Graph) -> Result<(), Fault> {
        // The start is evaluated in the graph, which is out of the host meanwhile.
        let mut host = self.host.clone();
        host.graph = graph.clone();
        residuals::orient(&mut residuals, &host, graph, &host.start())?;
        residuals::check_virtual_work(&residuals, &host, graph)?;
        let slots: Vec<Slot> = residuals.iter().map(|residual| residual.slot).collect();
        let rates = host.states.iter().map(|state| state.rate);
        let reached = graph.dependence(&slots.iter().copied().chain(rates).collect::<Vec<_>>());
        for (port, typed) in host.ports.iter().zip(&self.ports) {
            if let (Some(symbol), Some(place)) = (&port.force, &typed.force_place)
                && !reached.contains(&port.force_input)
            {
                return Err(place
                    .fault(format!(
                        "`{symbol}` is in no equation, so a device on `{}` would do nothing",
                        port.name
                    ))
                    .help(
                        "write it into the equations, or leave out `force`: it then acts by virtual work",
                    ));
            }
        }
        self.host.residual_dimensions = residuals
            .iter()
            .map(|residual| residual.dimension)
            .collect();
        self.host.residuals = slots;
        Ok(())
    }
}
