//! From an expression to a linear combination of signals.

use quell_expression::{
    BinaryOperator, Dimension, Expression, ExpressionError, Node, Quantity, Scope, Span, nearest,
};

use crate::host::NamedElement;
use crate::linear::{CoordinateKind, InputKind, LinearForm, LinearHost, Signal};

/// The highest derivative of a motion that an output may contain: the acceleration.
const HIGHEST_DERIVATIVE: usize = 2;

/// A part (element or component) of a device, as a study knows it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct DevicePart {
    /// Name of the device.
    pub device: String,
    /// Index of the host's port on which the device stands.
    pub port: usize,
    /// Name of the part, dotted within a component (`track1.I`).
    pub part: String,
}

/// What the names in an expression stand for, beside the host's own coordinates, inputs and outputs.
#[derive(Debug, Clone, Copy, Default)]
pub struct SignalNames<'a> {
    /// Constants: the host's parameters and whatever a study adds.
    pub constants: &'a [(String, Quantity)],
    /// Elements of the host that `force` and `stroke` may name.
    pub elements: &'a [NamedElement],
    /// Devices, each with the index of its port: `force(device)` is the force on that port.
    pub devices: &'a [(String, usize)],
    /// Parts of the devices that `force` and `stroke` may name.
    pub parts: &'a [DevicePart],
    /// True for end points and ports: an input's name then is its displacement, however it is given.
    pub motions: bool,
}

/// Reads `expression` as Σ coefficient · signal.
///
/// - `host`: coordinates, inputs, outputs and ports that the expression may name;
/// - `expression`: sums of signals times constants; `'` differentiates in time, `force(…)` and `stroke(…)` take the name
///   of a port, a device, an element of the host or a part of a device;
/// - `names`: what further names stand for.
///
/// Returns the form and its SI dimension. The name of an input is the input as given: of kind velocity it is u',
/// of kind acceleration u''. A sum may mix m with m·rad, since an angle times a lever arm is a displacement.
///
/// # Errors
/// An unknown name, a sum of unlike dimensions, a product of signals, a function of a signal, a constant added to a signal,
/// or more than two derivatives; each with the place in the expression's text.
pub fn linear_form(
    host: &LinearHost,
    expression: &Expression,
    names: &SignalNames<'_>,
) -> Result<(LinearForm, Dimension), ExpressionError> {
    let reader = Reader { host, names };
    match reader.read(expression)? {
        Value::Form(form, dimension) => Ok((form, dimension)),
        Value::Constant(_) => Err(ExpressionError::new(
            expression.span,
            "this is a constant; expected a combination of displacements, velocities, accelerations or forces",
        )),
    }
}

impl LinearForm {
    /// Adds `coefficient · signal`, keeping each signal once.
    pub fn add(&mut self, signal: Signal, coefficient: f64) {
        match self.terms.iter_mut().find(|(known, _)| *known == signal) {
            Some((_, total)) => *total += coefficient,
            None => self.terms.push((signal, coefficient)),
        }
    }

    /// The form times a number.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        for (_, coefficient) in &mut self.terms {
            *coefficient *= factor;
        }
        self
    }

    /// The sum of two forms.
    #[must_use]
    pub fn plus(mut self, other: Self) -> Self {
        for (signal, coefficient) in other.terms {
            self.add(signal, coefficient);
        }
        self
    }
}

/// A value on the way: a constant, or a combination of signals.
enum Value {
    Constant(Quantity),
    Form(LinearForm, Dimension),
}

struct Reader<'a> {
    host: &'a LinearHost,
    names: &'a SignalNames<'a>,
}

/// Constants for expressions without signals; lists all names, so that suggestions do.
struct Constants<'a>(&'a Reader<'a>);

impl Scope for Constants<'_> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        self.0.constant(name)
    }

    fn names(&self) -> Vec<&str> {
        self.0.all_names()
    }
}

impl<'a> Reader<'a> {
    fn read(&self, expression: &Expression) -> Result<Value, ExpressionError> {
        let span = expression.span;
        if !matches!(expression.node, Node::Binary { .. }) && !self.has_signal(expression) {
            return expression.evaluate(&Constants(self)).map(Value::Constant);
        }
        match &expression.node {
            Node::Name(name) => match self.signal(name) {
                Some((form, dimension)) => Ok(Value::Form(form, dimension)),
                None => expression.evaluate(&Constants(self)).map(Value::Constant),
            },
            Node::Negate(operand) => Ok(match self.read(operand)? {
                Value::Form(form, dimension) => Value::Form(form.scaled(-1.0), dimension),
                Value::Constant(quantity) => Value::Constant(Quantity {
                    value: -quantity.value,
                    ..quantity
                }),
            }),
            Node::Binary { .. } => self.chain(expression),
            Node::Derivative { order, operand } => match self.read(operand)? {
                Value::Form(form, dimension) => differentiate(form, dimension, *order, span),
                Value::Constant(_) => Err(ExpressionError::new(
                    operand.span,
                    "`'` differentiates in time, but this is a constant",
                )),
            },
            Node::Call {
                function,
                arguments,
                ..
            } => {
                if let Some(of) = Quality::of(function) {
                    return self.named_part(of, function, arguments, span);
                }
                Err(
                    ExpressionError::new(span, format!("`{function}` of a signal is not linear"))
                        .with_help("expected a sum of signals, each times a constant; criteria may use functions"),
                )
            }
            Node::Comparison { .. } => Err(ExpressionError::new(
                span,
                "a comparison is not a combination of signals",
            )),
            Node::Logic { .. } | Node::Not(_) => Err(ExpressionError::new(
                span,
                "a condition is not a combination of signals",
            )),
            Node::Choice { .. } => Err(ExpressionError::new(
                span,
                "a choice between signals is not linear",
            )
            .with_help("expected a sum of signals, each times a constant")),
            _ => expression.evaluate(&Constants(self)).map(Value::Constant),
        }
    }

    /// A chain such as a - b + c, in a loop: it may be thousands long.
    fn chain(&self, expression: &Expression) -> Result<Value, ExpressionError> {
        let mut operations = Vec::new();
        let mut first = expression;
        while let Node::Binary {
            operator,
            left,
            right,
        } = &first.node
        {
            operations.push((first, *operator, left, right));
            first = left;
        }
        operations.reverse();
        // What comes before the first signal is a constant, with the rules of constants.
        let start = if self.has_signal(first) {
            0
        } else {
            operations
                .iter()
                .position(|(.., right)| self.has_signal(right))
                .unwrap_or(operations.len())
        };
        let mut value = match operations.get(start) {
            Some((_, _, prefix, _)) => self.read(prefix)?,
            None => return expression.evaluate(&Constants(self)).map(Value::Constant),
        };
        for (whole, operator, left, right) in operations.into_iter().skip(start) {
            let other = self.read(right)?;
            value = combine(operator, (value, left), (other, right), whole.span)?;
        }
        Ok(value)
    }

    /// Whether anything in the expression is a signal, or tries to be.
    fn has_signal(&self, expression: &Expression) -> bool {
        let mut left_to_see = vec![expression];
        while let Some(expression) = left_to_see.pop() {
            match &expression.node {
                Node::Name(name) if self.signal(name).is_some() => return true,
                Node::Derivative { .. } => return true,
                Node::Call { function, .. } if Quality::of(function).is_some() => return true,
                _ => left_to_see.extend(expression.parts()),
            }
        }
        false
    }

    fn constant(&self, name: &str) -> Option<Quantity> {
        self.names
            .constants
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, quantity)| *quantity)
    }

    fn signal(&self, name: &str) -> Option<(LinearForm, Dimension)> {
        let one = |signal, dimension| {
            let form = LinearForm {
                terms: vec![(signal, 1.0)],
            };
            Some((form, dimension))
        };
        if let Some((index, coordinate)) = self
            .host
            .coordinates
            .iter()
            .enumerate()
            .find(|(_, coordinate)| coordinate.name == name)
        {
            return one(
                Signal::Coordinate { index, order: 0 },
                coordinate.kind.dimension(),
            );
        }
        if let Some((index, input)) = self
            .host
            .inputs
            .iter()
            .enumerate()
            .find(|(_, input)| input.name == name)
        {
            return if self.names.motions && input.kind != InputKind::Force {
                one(Signal::Input { index, order: 0 }, input.motion.dimension())
            } else {
                let order = input.kind.integrations();
                one(Signal::Input { index, order }, input.dimension)
            };
        }
        self.host
            .outputs
            .iter()
            .find(|output| output.name == name)
            .map(|output| (output.form.clone(), output.dimension))
    }

    fn all_names(&self) -> Vec<&'a str> {
        let constants = self.names.constants.iter().map(|(name, _)| name.as_str());
        let coordinates = self
            .host
            .coordinates
            .iter()
            .map(|coordinate| coordinate.name.as_str());
        let inputs = self.host.inputs.iter().map(|input| input.name.as_str());
        let outputs = self.host.outputs.iter().map(|output| output.name.as_str());
        constants
            .chain(coordinates)
            .chain(inputs)
            .chain(outputs)
            .collect()
    }

    /// `force(name)` or `stroke(name)`.
    fn named_part(
        &self,
        quality: Quality,
        function: &str,
        arguments: &[Expression],
        span: Span,
    ) -> Result<Value, ExpressionError> {
        let [
            Expression {
                node: Node::Name(name),
                span: place,
            },
        ] = arguments
        else {
            return Err(ExpressionError::new(
                span,
                format!("`{function}` takes the name of one port, element or part of a device"),
            )
            .with_help(format!("for example `{function}({})`", self.example())));
        };
        let mut found: Vec<(String, Named<'a>)> = Vec::new();
        let mut add = |called: String, named: Named<'a>| {
            if !found.iter().any(|(_, known)| *known == named) {
                found.push((called, named));
            }
        };
        for (index, port) in self.host.ports.iter().enumerate() {
            if port.name == *name {
                add(format!("the port `{name}`"), Named::Port(index));
            }
        }
        for (device, port) in self.names.devices {
            if device == name {
                add(format!("the device `{name}`"), Named::Port(*port));
            }
        }
        for (index, element) in self.names.elements.iter().enumerate() {
            if element.name == *name {
                add(
                    format!("the host's element `{name}`"),
                    Named::Element(index),
                );
            }
        }
        for part in self.names.parts {
            let full = format!("{}.{}", part.device, part.part);
            if part.part == *name || full == *name {
                add(format!("`{full}`"), Named::Part(part));
            }
        }
        match &found[..] {
            [] => Err(self.unknown_part(name, *place)),
            [(_, named)] => self.value_of(quality, *named, *place),
            several => {
                let called: Vec<&str> = several.iter().map(|(called, _)| called.as_str()).collect();
                Err(ExpressionError::new(
                    *place,
                    format!("`{name}` may be {}", called.join(" or ")),
                )
                .with_help("write the device's name before the part's, `device.part`, or give them different names"))
            }
        }
    }

    fn value_of(
        &self,
        quality: Quality,
        named: Named<'_>,
        place: Span,
    ) -> Result<Value, ExpressionError> {
        let gone = || ExpressionError::new(place, "this names a port that the host does not have");
        let one = |signal, dimension| {
            Value::Form(
                LinearForm {
                    terms: vec![(signal, 1.0)],
                },
                dimension,
            )
        };
        Ok(match (quality, named) {
            (Quality::Force, Named::Port(index)) => {
                let port = self.host.ports.get(index).ok_or_else(gone)?;
                one(Signal::PortForce { index }, port.kind.force_dimension())
            }
            (Quality::Stroke, Named::Port(index)) => {
                let port = self.host.ports.get(index).ok_or_else(gone)?;
                Value::Form(
                    motion_form(&port.coordinates, &port.inputs),
                    port.kind.dimension(),
                )
            }
            (Quality::Force, Named::Element(index)) => {
                let element = self.names.elements.get(index).ok_or_else(gone)?;
                match &element.force {
                    Some(force) => Value::Form(force.clone(), element.kind.force_dimension()),
                    None => {
                        return Err(ExpressionError::new(
                            place,
                            format!("the force in `{}` is complex, since it has a loss factor, and outputs are real", element.name),
                        )
                        .with_help(format!("use its stroke, `stroke({})`", element.name)));
                    }
                }
            }
            (Quality::Stroke, Named::Element(index)) => {
                let element = self.names.elements.get(index).ok_or_else(gone)?;
                Value::Form(element.stroke.clone(), element.kind.dimension())
            }
            (Quality::Force, Named::Part(part)) => {
                let port = self.host.ports.get(part.port).ok_or_else(gone)?;
                let signal = Signal::PartForce {
                    port: part.port,
                    part: part.part.clone(),
                };
                one(signal, port.kind.force_dimension())
            }
            (Quality::Stroke, Named::Part(part)) => {
                let port = self.host.ports.get(part.port).ok_or_else(gone)?;
                let signal = Signal::PartStroke {
                    port: part.port,
                    part: part.part.clone(),
                    order: 0,
                };
                one(signal, port.kind.dimension())
            }
        })
    }

    fn part_names(&self) -> Vec<&str> {
        let ports = self.host.ports.iter().map(|port| port.name.as_str());
        let devices = self.names.devices.iter().map(|(name, _)| name.as_str());
        let elements = self
            .names
            .elements
            .iter()
            .map(|element| element.name.as_str());
        let parts = self.names.parts.iter().map(|part| part.part.as_str());
        let mut names: Vec<&str> = ports.chain(devices).chain(elements).chain(parts).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    fn example(&self) -> &str {
        self.part_names().first().copied().unwrap_or("port")
    }

    fn unknown_part(&self, name: &str, place: Span) -> ExpressionError {
        let names = self.part_names();
        let error = ExpressionError::new(
            place,
            format!("there is no port, named element or part of a device called `{name}`"),
        );
        if let Some(near) = nearest(name, names.iter().copied()) {
            error.with_help(format!("did you mean `{near}`?"))
        } else if names.is_empty() {
            error.with_help("give an element a name, `{ between = [\"x1\", \"x2\"], value = \"k\", name = \"rubber\" }`")
        } else {
            let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
            error.with_help(format!("the names are {}", quoted.join(", ")))
        }
    }
}

/// One operation, at least one operand of which has signals.
fn combine(
    operator: BinaryOperator,
    (a, left): (Value, &Expression),
    (b, right): (Value, &Expression),
    span: Span,
) -> Result<Value, ExpressionError> {
    match (operator, a, b) {
        (
            BinaryOperator::Add | BinaryOperator::Subtract,
            Value::Form(a, first),
            Value::Form(b, second),
        ) => {
            if !first.agrees(&second) {
                return Err(ExpressionError::new(
                    span,
                    format!(
                        "`{}` is in {first}, but `{}` is in {second}",
                        left.excerpt(),
                        right.excerpt()
                    ),
                ));
            }
            let sign = if operator == BinaryOperator::Add {
                1.0
            } else {
                -1.0
            };
            Ok(Value::Form(a.plus(b.scaled(sign)), joined(first, second)))
        }
        (BinaryOperator::Add | BinaryOperator::Subtract, a, _) => {
            let constant = if matches!(a, Value::Constant(_)) {
                left
            } else {
                right
            };
            Err(ExpressionError::new(
                constant.span,
                format!(
                    "`{}` is a constant, which cannot be added to a signal",
                    constant.excerpt()
                ),
            )
            .with_help("displacements and forces are counted from the state at rest"))
        }
        (BinaryOperator::Multiply, Value::Constant(constant), Value::Form(form, dimension))
        | (BinaryOperator::Multiply, Value::Form(form, dimension), Value::Constant(constant)) => {
            scale(form, constant.value, dimension * constant.dimension, span)
        }
        (BinaryOperator::Divide, Value::Form(form, dimension), Value::Constant(constant)) => {
            if constant.value == 0.0 {
                return Err(ExpressionError::new(
                    right.span,
                    format!("`{}` is zero, and it divides", right.excerpt()),
                ));
            }
            scale(
                form,
                1.0 / constant.value,
                dimension / constant.dimension,
                span,
            )
        }
        (BinaryOperator::Multiply, ..) => Err(not_linear(span, "a product of two signals")),
        (BinaryOperator::Divide, ..) => Err(not_linear(span, "division by a signal")),
        (BinaryOperator::Power, ..) => Err(not_linear(span, "a power of a signal")),
    }
}

/// What is asked of a port, an element or a part.
#[derive(Clone, Copy)]
enum Quality {
    Force,
    Stroke,
}

impl Quality {
    fn of(function: &str) -> Option<Self> {
        match function {
            "force" => Some(Self::Force),
            "stroke" => Some(Self::Stroke),
            _ => None,
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Named<'a> {
    Port(usize),
    Element(usize),
    Part(&'a DevicePart),
}

fn not_linear(span: Span, what: &str) -> ExpressionError {
    ExpressionError::new(span, format!("{what} is not linear")).with_help(
        "expected a sum of signals, each times a constant; criteria may use anything else",
    )
}

fn scale(
    form: LinearForm,
    factor: f64,
    dimension: Dimension,
    span: Span,
) -> Result<Value, ExpressionError> {
    let form = form.scaled(factor);
    if form
        .terms
        .iter()
        .all(|(_, coefficient)| coefficient.is_finite())
    {
        Ok(Value::Form(form, dimension))
    } else {
        Err(ExpressionError::new(
            span,
            "the result is too large for a number",
        ))
    }
}

fn differentiate(
    form: LinearForm,
    dimension: Dimension,
    times: usize,
    span: Span,
) -> Result<Value, ExpressionError> {
    let mut terms = Vec::with_capacity(form.terms.len());
    for (mut signal, coefficient) in form.terms {
        match &mut signal {
            Signal::Coordinate { order, .. }
            | Signal::Input { order, .. }
            | Signal::PartStroke { order, .. } => {
                *order = order.saturating_add(times);
                if *order > HIGHEST_DERIVATIVE {
                    return Err(ExpressionError::new(
                        span,
                        "this differentiates a displacement more than twice",
                    )
                    .with_help("displacements, velocities and accelerations can be used"));
                }
            }
            Signal::PortForce { .. } | Signal::PartForce { .. } => {
                return Err(ExpressionError::new(
                    span,
                    "the force of a device cannot be differentiated",
                ));
            }
        }
        terms.push((signal, coefficient));
    }
    let dimension = (0..times).fold(dimension, |dimension, _| dimension / Dimension::TIME);
    Ok(Value::Form(LinearForm { terms }, dimension))
}

/// h·q + g·u as a form.
pub(crate) fn motion_form(coordinates: &[f64], inputs: &[f64]) -> LinearForm {
    let q = coordinates
        .iter()
        .enumerate()
        .map(|(index, &coefficient)| (Signal::Coordinate { index, order: 0 }, coefficient));
    let u = inputs
        .iter()
        .enumerate()
        .map(|(index, &coefficient)| (Signal::Input { index, order: 0 }, coefficient));
    LinearForm {
        terms: q
            .chain(u)
            .filter(|(_, coefficient)| *coefficient != 0.0)
            .collect(),
    }
}

/// The dimension of a sum of two that agree: an angle keeps its rad, a displacement by way of a lever arm loses it.
fn joined(first: Dimension, second: Dimension) -> Dimension {
    let plain = first.without_angle();
    if plain == Dimension::NONE
        || plain == Dimension::NONE / Dimension::TIME
        || plain == Dimension::NONE / Dimension::TIME / Dimension::TIME
    {
        first.joined(second)
    } else if first == second {
        first
    } else {
        plain
    }
}

impl CoordinateKind {
    /// SI dimension of the motion: m or rad.
    #[must_use]
    pub const fn dimension(self) -> Dimension {
        match self {
            Self::Translation => Dimension::LENGTH,
            Self::Rotation => Dimension::ANGLE,
        }
    }

    /// SI dimension of the force that does work on it: N or N m.
    #[must_use]
    pub const fn force_dimension(self) -> Dimension {
        match self {
            Self::Translation => Dimension::FORCE,
            Self::Rotation => Dimension::MOMENT,
        }
    }

    /// Dimensions of a spring, a damper and an inerter on it.
    #[must_use]
    pub const fn element_dimensions(self) -> [Dimension; 3] {
        match self {
            Self::Translation => [Dimension::STIFFNESS, Dimension::DAMPING, Dimension::MASS],
            Self::Rotation => [
                Dimension::ROTATIONAL_STIFFNESS,
                Dimension::ROTATIONAL_DAMPING,
                Dimension::ROTATIONAL_INERTIA,
            ],
        }
    }
}
