//! Hosts written as equations against textbook equations, energies and matrices.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "helpers of tests fail by panicking"
)]

use std::path::Path;
use std::sync::Arc;

use quell_document::Source;
use quell_expression::{Differentiation, Dimension, Expression, Graph, Quantity, Rate, Slot};
use quell_model::{EquationHost, HostFile, Measure, NoExtraNames, Override, Symbol};

#[track_caller]
fn read(text: &str, overrides: &[Override]) -> EquationHost {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    HostFile::parse(Arc::new(Source::new("host.toml", text)), folder)
        .and_then(|file| file.equations(overrides))
        .unwrap_or_else(|fault| panic!("{}", fault.render()))
}

#[track_caller]
fn gallery(name: &str) -> EquationHost {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies/hosts");
    HostFile::read(path.join(name))
        .and_then(|file| file.equations(&[]))
        .unwrap_or_else(|fault| panic!("{}", fault.render()))
}

/// Nominal parameters; everything that moves has a value of its own in -1 … 1.
fn anywhere(host: &EquationHost, seed: usize) -> Vec<f64> {
    let mut values = host.nominal();
    for (index, (value, symbol)) in values.iter_mut().zip(&host.symbols).enumerate() {
        if !matches!(symbol, Symbol::Parameter { .. }) {
            *value = ((7 * seed + 3 * index + 1) as f64 * 0.754_877_666).fract() * 2.0 - 1.0;
        }
    }
    values
}

fn coordinate(host: &EquationHost, values: &[f64], index: usize, order: usize) -> f64 {
    values[host.input(Symbol::Coordinate { index, order }).unwrap()]
}

fn parameter(host: &EquationHost, name: &str) -> f64 {
    let found = host.parameters.iter().find(|one| one.name == name);
    found.unwrap().value.value
}

/// d/dt along the motion whose rates the symbols are.
fn rate(host: &EquationHost, graph: &mut Graph, of: Slot) -> Slot {
    let mut seeds = Vec::new();
    for (input, rate) in host.rates().into_iter().enumerate() {
        match rate {
            Rate::Constant(value) => seeds.push((input, graph.constant(value))),
            Rate::Input(index) => seeds.push((input, graph.input(index))),
            Rate::Value(slot) => seeds.push((input, slot)),
            Rate::Unknown(_) => {}
        }
    }
    graph.tangent(&[of], &seeds, Differentiation::Formal)[0].unwrap()
}

#[track_caller]
fn assert_near(found: f64, expected: f64, scale: f64) {
    assert!(
        (found - expected).abs() <= 1e-12 * (scale + expected.abs()),
        "{found} is not {expected}"
    );
}

/// J. B. Marion and S. T. Thornton, Classical Dynamics, chapter 7: the equations of the double pendulum.
#[test]
fn the_double_pendulum_has_its_textbook_equations() {
    let host = gallery("double-pendulum.toml");
    let [m1, m2, l1, l2, g] = ["m1", "m2", "l1", "l2", "g"].map(|name| parameter(&host, name));
    for seed in 0..20 {
        let values = anywhere(&host, seed);
        let at = |index, order| coordinate(&host, &values, index, order);
        let (a, b) = (at(0, 0), at(1, 0));
        let (da, db) = (at(0, 1), at(1, 1));
        let (dda, ddb) = (at(0, 2), at(1, 2));
        let (sine, cosine) = (a - b).sin_cos();
        let expected = [
            (m1 + m2) * l1 * l1 * dda
                + m2 * l1 * l2 * (ddb * cosine + db * db * sine)
                + (m1 + m2) * g * l1 * a.sin(),
            m2 * l2 * l2 * ddb
                + m2 * l1 * l2 * (dda * cosine - da * da * sine)
                + m2 * g * l2 * b.sin(),
        ];
        let found = host.graph.values(&host.residuals, &values);
        for (found, expected) in found.iter().zip(expected) {
            // Terms are of order 20; a few dozen roundings.
            assert_near(*found, expected, 20.0);
        }
    }
    assert_eq!(host.ports[0].kind, Measure::Rotation);
    assert!(
        (host.start()[host
            .input(Symbol::Coordinate { index: 0, order: 0 })
            .unwrap()]
            - std::f64::consts::FRAC_PI_2)
            .abs()
            < 1e-15
    );
}

/// q'·R is the rate of T + V, plus twice the dissipation function, less the power of the forces.
#[test]
fn residuals_of_a_lagrangian_balance_the_power() {
    let text = r#"
quell = 1
[parameters]
m = "2 kg"
J = "0.3 kg*m^2"
k = "40 N/m"
c = "3 N*s/m"
l = "0.4 m"
g = "9.81 m/s^2"
F0 = "5 N"
[coordinates]
x = {}
a = { kind = "rotation" }
[definitions]
px = "x + l*sin(a)"
py = "-l*cos(a)"
T = "1/2*m*(px'^2 + py'^2) + 1/2*J*a'^2"
V = "m*g*py + 1/2*k*x^2*cosh(a)"
D = "1/2*c*px'^2"
[lagrangian]
kinetic = "T"
potential = "V"
dissipation = "D"
forces = { x = "F0*cos(t*3 rad/s)", a = "-F0*l*sign(a')" }
[outputs]
energy = "T + V"
twice = "2*D"
power = "F0*cos(t*3 rad/s)*x' - F0*l*abs(a')"
"#;
    let host = read(text, &[]);
    let mut graph = host.graph.clone();
    let energy = rate(&host, &mut graph, host.outputs[0].value);
    for seed in 0..20 {
        let values = anywhere(&host, seed);
        let at = |index, order| coordinate(&host, &values, index, order);
        let residuals = graph.values(&host.residuals, &values);
        let work = residuals[0] * at(0, 1) + residuals[1] * at(1, 1);
        let found = graph.values(
            &[energy, host.outputs[1].value, host.outputs[2].value],
            &values,
        );
        assert_near(work, found[0] + found[1] - found[2], 50.0);
    }
}

/// Without a device and before the strut has moved both masses fall alike but for the lift: the first accelerations of the
/// source are z1'' = -g W2/W1 and z2'' = g, so ss'' = -g (1 + W2/W1)/cos(phi).
#[test]
fn touch_down_begins_as_published() {
    let host = gallery("touch-down.toml");
    let [w1, w2, g, phi] = ["W1", "W2", "g", "phi"].map(|name| parameter(&host, name));
    let mut values = host.start();
    let set = |values: &mut Vec<f64>, symbol, value| values[host.input(symbol).unwrap()] = value;
    set(
        &mut values,
        Symbol::Coordinate { index: 0, order: 2 },
        -g * w2 / w1,
    );
    set(&mut values, Symbol::Coordinate { index: 1, order: 2 }, g);
    for residual in host.graph.values(&host.residuals, &values) {
        // Of weights of 10⁴ N.
        assert!(residual.abs() < 1e-11, "{residual}");
    }
    let mut graph = host.graph.clone();
    let expression = Expression::parse("ss''").unwrap();
    let (stroke, dimension) = host.lower(&mut graph, &expression, &NoExtraNames).unwrap();
    assert_eq!(dimension, Dimension::ACCELERATION);
    let expected = -g * (1.0 + w2 / w1) / phi.cos();
    assert_near(graph.values(&[stroke], &values)[0], expected, 1.0);
    assert_eq!(
        values[host
            .input(Symbol::Coordinate { index: 1, order: 1 })
            .unwrap()],
        8.86 * 0.3048
    );
    // The force has its symbol, and resists compression of the upper mass.
    assert_eq!(host.ports[0].force.as_deref(), Some("Fs"));
    let slopes = graph.jacobian(&host.residuals, &[host.ports[0].force_input]);
    let slopes: Vec<f64> = slopes
        .iter()
        .map(|slope| graph.values(&[slope.unwrap()], &values)[0])
        .collect();
    assert_near(slopes[0], phi.cos(), 1.0);
    assert_near(slopes[1], -phi.cos(), 1.0);
    // The lift is derived, so no graph input of its own.
    let lift = host.parameters.iter().find(|one| one.name == "L").unwrap();
    assert_eq!(lift.input, None);
    assert_near(
        host.graph.values(&[lift.slot], &values)[0],
        lift.value.value,
        1.0,
    );
}

#[test]
fn other_hosts_of_the_gallery_have_their_equations() {
    let host = gallery("van-der-pol.toml");
    let values = anywhere(&host, 3);
    let [x, v, a] = [0, 1, 2].map(|order| coordinate(&host, &values, 0, order));
    assert_near(
        host.graph.values(&host.residuals, &values)[0],
        a - (1.0 - x * x) * v + x,
        1.0,
    );
    assert!(host.dimensionless && host.operating[0].open);
    assert_eq!(host.ports[0].kind, Measure::Number);

    let host = gallery("duffing.toml");
    let [m, c, k, k3] = ["m", "c", "k", "k3"].map(|name| parameter(&host, name));
    assert_near(k, (4.0 * std::f64::consts::PI).powi(2), 1.0);
    let values = anywhere(&host, 4);
    let [x, v, a] = [0, 1, 2].map(|order| coordinate(&host, &values, 0, order));
    let force = values[host.input(Symbol::Input { index: 0, order: 0 }).unwrap()];
    assert_near(
        host.graph.values(&host.residuals, &values)[0],
        m * a + c * v + k * x + k3 * x.powi(3) - force,
        k3,
    );
    let wave = host.inputs[0].waveform.as_ref().unwrap();
    assert_eq!(wave.breakpoints(), [0.0, 200.0]);
    assert!(wave.value(0.1)[0].abs() <= 1.5);

    let host = gallery("bouncing-ball.toml");
    for height in [0.3, -1e-3] {
        let mut values = host.nominal();
        values[host
            .input(Symbol::Coordinate { index: 0, order: 0 })
            .unwrap()] = height;
        let force = if height < 0.0 { 2e5 * 1e-3 } else { 0.0 };
        assert_near(
            host.graph.values(&host.residuals, &values)[0],
            0.2 * 9.81 - force,
            1.0,
        );
    }
    let mut graph = host.graph.clone();
    assert_eq!(graph.switches(&host.residuals).len(), 1);
}

/// However an equation is written, its inertia (or stiffness, or damping) becomes positive.
#[test]
fn residuals_have_the_sign_of_inertia() {
    let text = |x: &str, y: &str, z: &str| {
        format!(
            "quell = 1\n[parameters]\nm = \"2 kg\"\nk = \"5 N/m\"\nc = \"3 N*s/m\"\n[coordinates]\nx = {{}}\ny = {{ massless = true }}\nz = {{ massless = true }}\n[equations]\nx = \"{x}\"\ny = \"{y}\"\nz = \"{z}\"\n"
        )
    };
    let one = read(
        &text(
            "m*x'' = k*(y - x)",
            "k*(y - x) + c*y' = 0",
            "c*(z' - y') = 0",
        ),
        &[],
    );
    let other = read(
        &text(
            "k*(y - x) - m*x'' = 0",
            "k*(x - y) = c*y'",
            "0 = -c*(z' - y')",
        ),
        &[],
    );
    for seed in 0..5 {
        let values = anywhere(&one, seed);
        let found = one.graph.values(&one.residuals, &values);
        let same = other.graph.values(&other.residuals, &values);
        for ((found, same), index) in found.iter().zip(&same).zip(0..) {
            assert_near(*found, *same, 10.0);
            assert!(one.coordinates[index].massless == (index > 0));
        }
    }
    let force = Some(Dimension::FORCE);
    assert_eq!(one.residual_dimensions, [force, force, force]);
    // An inertia that vanishes at the start has the sign that it has beside it.
    let far = read(
        "quell = 1\ndimensionless = true\n[coordinates]\nx = {}\n[equations]\nx = \"x - x^2*x'' = 0\"\n",
        &[],
    );
    let mut values = anywhere(&far, 1);
    values[far
        .input(Symbol::Coordinate { index: 0, order: 2 })
        .unwrap()] = 10.0;
    assert!(far.graph.values(&far.residuals, &values)[0] > 0.0);
}

const LINEAR: &str = r#"
quell = 1
[parameters]
k = "5 N/m"
[coordinates]
x1 = { mass = "2 kg", start = "3 mm", rate = "1 m/s" }
x2 = { mass = "1 kg" }
free = {}
[inputs]
road = { kind = "velocity", signal = { harmonic = { amplitude = "0.1 m/s", frequency = "2 rad/s" } } }
table = { kind = "acceleration" }
F = { kind = "force", on = "x1 - x2" }
[linear]
springs = [{ between = ["x1", "x2"], value = "k", name = "coil" }, ["x2", "road", "7 N/m"], ["free", "x1", "2 N/m"], ["free", "table", "1 N/m"]]
dampers = [["x1", "road", "3 N*s/m"], ["free", "ground", "4 N*s/m"]]
inerters = [["x1", "x2", "0.5 kg"]]
[ports.strut]
between = ["x1", "road"]
[ports.hook]
at = "x2"
[outputs]
y = "x1'' + force(coil)/(2 kg) - 2*stroke(strut)''"
"#;

#[test]
fn a_linear_host_gives_the_equations_of_its_matrices() {
    let file = HostFile::parse(Arc::new(Source::new("host.toml", LINEAR)), ".").unwrap();
    let linear = file.assemble(&[]).unwrap().linear;
    let host = file.equations(&[]).unwrap();
    assert!(!file.is_equations());
    let names: Vec<&str> = host
        .states
        .iter()
        .map(|state| state.name.as_str())
        .collect();
    assert_eq!(
        names,
        ["road_displacement", "table_velocity", "table_displacement"]
    );
    let massless: Vec<bool> = host.coordinates.iter().map(|one| one.massless).collect();
    assert_eq!(massless, [false, false, true]);
    for seed in 0..5 {
        let values = anywhere(&host, seed);
        let at = |symbol| values[host.input(symbol).unwrap()];
        let input = |index, order| at(Symbol::Input { index, order });
        let state = |index| at(Symbol::State { index });
        // u, u', u'' of road, table and F.
        let u = [
            [state(0), input(0, 0), input(0, 1)],
            [state(2), state(1), input(1, 0)],
            [input(2, 0), input(2, 1), input(2, 2)],
        ];
        let found = host.graph.values(&host.residuals, &values);
        for (row, found) in found.iter().enumerate() {
            let mut expected = 0.0;
            for column in 0..3 {
                for (order, matrix) in [&linear.stiffness, &linear.damping, &linear.mass]
                    .iter()
                    .enumerate()
                {
                    expected += matrix[(row, column)] * coordinate(&host, &values, column, order);
                }
                for (forcing, u) in linear.forcing.iter().zip(u[column]) {
                    expected -= forcing[(row, column)] * u;
                }
            }
            assert_near(*found, expected, 20.0);
        }
        let slots: Vec<Slot> = host.states.iter().map(|one| one.rate).collect();
        let rates = host.graph.values(&slots, &values);
        assert_eq!(rates, [input(0, 0), input(1, 0), state(1)]);
        let across = host
            .graph
            .values(&[host.ports[0].across, host.ports[1].across], &values);
        assert_near(across[0], coordinate(&host, &values, 0, 0) - state(0), 1.0);
        assert_near(across[1], coordinate(&host, &values, 1, 0), 1.0);
        let y = coordinate(&host, &values, 0, 2)
            + 5.0 * (coordinate(&host, &values, 0, 0) - coordinate(&host, &values, 1, 0)) / 2.0
            - 2.0 * (coordinate(&host, &values, 0, 2) - input(0, 1));
        assert_near(
            host.graph.values(&[host.outputs[0].value], &values)[0],
            y,
            5.0,
        );
    }
    let start = host.start();
    assert_eq!(coordinate(&host, &start, 0, 0), 0.003);
    assert_eq!(coordinate(&host, &start, 0, 1), 1.0);
    assert!(host.inputs[0].waveform.is_some());
    assert!(host.ports[1].hangs && host.ports[1].grounded && !host.ports[0].grounded);
    // The same words as in equations: stroke and force of named elements, and derivatives of them.
    let mut graph = host.graph.clone();
    let lowered = |graph: &mut Graph, text: &str| {
        host.lower(graph, &Expression::parse(text).unwrap(), &NoExtraNames)
    };
    let (slot, dimension) = lowered(&mut graph, "stroke(coil)'*k").unwrap();
    assert_eq!(
        dimension.without_angle(),
        Dimension::FORCE / Dimension::TIME
    );
    let values = anywhere(&host, 1);
    let expected = 5.0 * (coordinate(&host, &values, 0, 1) - coordinate(&host, &values, 1, 1));
    assert_near(graph.values(&[slot], &values)[0], expected, 1.0);
    let error = lowered(&mut graph, "force(coll)").unwrap_err();
    assert_eq!(error.help.as_deref(), Some("did you mean `coil`?"));
}

#[test]
fn linear_hosts_without_a_meaning_in_time_are_refused() {
    let words = |text: &str| {
        HostFile::parse(Arc::new(Source::new("host.toml", text)), ".")
            .and_then(|file| file.equations(&[]))
            .unwrap_err()
            .message
    };
    let lossy = "quell = 1\n[coordinates]\nx = { mass = 1 }\n[linear]\nsprings = [{ between = [\"x\", \"ground\"], value = 1, loss = 0.1 }]\n";
    assert!(words(lossy).contains("loss factor"));
    let singular = "quell = 1\n[coordinates]\nx = {}\ny = {}\n[linear]\ninerters = [[\"x\", \"y\", 1]]\nsprings = [[\"x\", \"ground\", 1]]\n";
    assert!(words(singular).contains("singular"));
}

/// States take the one unit with which their rates are consistent; replaced parameters become primary.
#[test]
fn states_find_their_units_and_overrides_make_parameters_primary() {
    let text = r#"
quell = 1
[parameters]
tau = "0.2 s"
v = "3 m/s"
l = "v*tau"
Q0 = "4 N"
[coordinates]
x = {}
[states]
lag = "(x - lag)/tau"
load = { rate = "(Q0 - load)/tau", start = "Q0/2" }
number = { rate = "1/tau - number/tau", start = 2 }
[equations]
x = "(3 kg)*x'' + load*lag/l = 0"
"#;
    let host = read(text, &[]);
    let dimensions: Vec<Dimension> = host.states.iter().map(|one| one.dimension).collect();
    assert_eq!(
        dimensions,
        [Dimension::LENGTH, Dimension::FORCE, Dimension::NONE]
    );
    let start = host.start();
    let at = |index| start[host.input(Symbol::State { index }).unwrap()];
    assert_eq!([at(0), at(1), at(2)], [0.0, 2.0, 2.0]);
    assert_eq!(parameter(&host, "l"), 3.0 * 0.2);
    assert_eq!(host.parameters[2].input, None);
    let length = Override::new("l", Quantity::new(2.0, Dimension::LENGTH));
    let replaced = read(text, &[length]);
    assert_eq!(parameter(&replaced, "l"), 2.0);
    assert!(replaced.parameters[2].input.is_some());
}

/// A study's expressions: definitions and functions of the host, and what is wrong within them at the study's place.
#[test]
fn expressions_of_others_use_the_vocabulary() {
    let host = gallery("touch-down.toml");
    let mut graph = host.graph.clone();
    let mut lower =
        |text: &str| host.lower(&mut graph, &Expression::parse(text).unwrap(), &NoExtraNames);
    assert_eq!(lower("Fs*ss'").unwrap().1, Dimension::POWER);
    assert_eq!(lower("force(strut)").unwrap(), lower("Fs").unwrap());
    assert_eq!(lower("stroke(strut)'").unwrap(), lower("ss'").unwrap());
    let error = lower("Fs*sss").unwrap_err();
    assert_eq!((error.span.start, error.span.end), (3, 6));
    assert_eq!(error.help.as_deref(), Some("did you mean `ss`?"));
    assert!(
        lower("Fs'")
            .unwrap_err()
            .message
            .contains("the rate of the device's force")
    );
}

#[test]
fn samples_come_from_files_in_their_unit() {
    let text = r#"
quell = 1
[coordinates]
x = {}
[inputs]
road = { kind = "displacement", signal = { sampled = { file = "fixtures/road.csv", unit = "mm", interpolation = "linear" } } }
wind = { kind = "force", signal = { random = { band = ["1 Hz", "3 Hz"], spectrum = "2 N^2/Hz", seed = 7 } } }
gust = { kind = "force", signal = { random = { band = ["1 Hz", "3 Hz"], rms = "2 N", seed = 7 } } }
[equations]
x = "(2 kg)*x'' + (3 N/m)*(x - road) = wind + gust"
"#;
    let host = read(text, &[]);
    let wave = |index: usize| host.inputs[index].waveform.as_ref().unwrap();
    assert_near(wave(0).value(0.1)[0], 1.933e-3, 1.0);
    assert_eq!(wave(0).breakpoints().len(), 7);
    // 2 N²/Hz over 2 Hz is 4 N², as is an rms value of 2 N; the same seed gives the same sample.
    for t in [0.0, 0.4, 3.1] {
        assert_near(wave(1).value(t)[0], wave(2).value(t)[0], 1.0);
    }
    let source = Arc::new(Source::new("host.toml", text));
    let file = HostFile::parse(source, "folder").unwrap();
    assert_eq!(
        file.matrix_files(),
        [Path::new("folder").join("fixtures/road.csv")]
    );
}
