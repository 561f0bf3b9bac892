//! Frequency responses, norms and modes of hosts written as equations: the same structure as a linear host, and closed forms.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing)]

use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

use quell_document::Source;
use quell_study::{Evaluated, Findings, PointOutcome, RunSettings, Silent, Study, run};

/// A folder for the files of one test.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("linearised")
        .join(test);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// What the first task of a study finds on a host given as text, in which it is called `host.toml`.
fn outcome(test: &str, host: &str, study: &str) -> PointOutcome {
    let folder = folder(test);
    std::fs::write(folder.join("host.toml"), host).unwrap();
    let text = format!("quell = 1\ntitle = \"{test}\"\nhost = \"host.toml\"\n{study}");
    let study = Study::parse(Source::new("study.toml", text), &folder)
        .unwrap_or_else(|fault| panic!("{}", fault.render()));
    let mut outcome = run(&study, &RunSettings::default(), &Silent)
        .unwrap_or_else(|error| panic!("{}", error.fault().render()));
    outcome.tasks.remove(0).points.remove(0)
}

/// The configurations of the only task.
fn evaluated(test: &str, host: &str, study: &str) -> Vec<Evaluated> {
    match outcome(test, host, study).findings {
        Findings::Evaluate(found) => found,
        _ => panic!("{test} evaluates"),
    }
}

fn near(value: f64, expected: f64, relative: f64) {
    assert!(
        (value - expected).abs() <= relative * expected.abs(),
        "{value}, expected {expected}"
    );
}

fn gallery(host: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../studies/hosts")
        .join(host);
    std::fs::read_to_string(path).unwrap()
}

/// Runs one study on a host of the gallery and on the same written as equations: certified peaks, norms and modes agree
/// to 1e-9 (the certificate refines a peak to rounding, the quadrature of norms goes to 1e-10).
fn same(test: &str, linear: &str, equations: &str, study: &str) -> Vec<Evaluated> {
    let expected = evaluated(&format!("{test}-linear"), &gallery(linear), study);
    let found = evaluated(test, equations, study);
    for (found, expected) in found.iter().zip(&expected) {
        assert!(!found.criteria.is_empty());
        for (name, value) in &found.criteria {
            near(*value, expected.criteria[name], 1e-9);
            assert_eq!(
                found.details[name].status, expected.details[name].status,
                "{name}"
            );
            assert_eq!(found.details[name].unit, expected.details[name].unit);
        }
    }
    found
}

const OSCILLATOR: &str = r#"
quell = 1
[parameters]
m = "1000 kg"
k = "4e5 N/m"
zeta = 0
c = "2*zeta*sqrt(k*m)"
mu = 0.05
[coordinates]
x = {}
[inputs]
F = { kind = "force" }
[equations]
x = "m*x'' + c*x' + k*x = F"
[ports.hook]
at = "x"
[outputs]
spring_force = "k*x"
"#;

const ABSORBER: &str = r#"
[devices.absorber]
port = "hook"
[runs.force]
kind = "frequency"
input = "F"
band = ["0.3 Hz", "30 Hz"]
[runs.white]
kind = "frequency"
input = "F"
[runs.coloured]
kind = "frequency"
input = "F"
spectrum = "4 N^2/Hz/(1 + (f/(4 Hz))^2)"
[runs.free]
kind = "modes"
[criteria]
amplification = { run = "force", value = "max(abs(spring_force))", tolerance = 1e-6 }
at_rest = { run = "force", value = "abs(spring_force, 0.001 Hz)" }
variance = { run = "white", value = "h2(spring_force)^2" }
shaken = { run = "coloured", value = "rms(x'')" }
device = { run = "force", value = "max(abs(force(hook)))" }
stretch = { run = "force", value = "max(abs(stroke(k1)))" }
damping = { run = "free", value = "min(damping_ratio)" }
decay = { run = "free", value = "max(decay_rate)" }
slow = { run = "free", value = "min(frequency)" }
fast = { run = "free", value = "max(frequency)" }
"#;

#[test]
fn tuned_mass_damper() {
    let study = format!(
        "{ABSORBER}{}",
        r#"
[[tasks]]
name = "rule"
kind = "evaluate"
[tasks.configurations.den_hartog]
absorber = "(k1 | c1) + m1"
m1 = "mu*m"
k1 = "mu*k/(1 + mu)^2"
c1 = "2*sqrt(3*mu/(8*(1 + mu)))*mu*sqrt(k*m)/(1 + mu)"
"#
    );
    let found = same("tuned-mass-damper", "oscillator.toml", OSCILLATOR, &study);
    // J. P. Den Hartog, Mechanical Vibrations (1956): at the fixed points √(1 + 2/μ); the peaks lie a little above.
    let fixed = (1.0_f64 + 2.0 / 0.05).sqrt();
    near(found[0].criteria["amplification"], fixed, 0.01);
    assert_eq!(found[0].details["amplification"].status, "certified");
}

/// A design on equations: the optimum of O. Nishihara and T. Asami (2002), peak 6.40792 for μ = 0.05, five digits of which
/// are published.
#[test]
fn absorber_designed_on_equations() {
    let study = r#"
[devices.absorber]
port = "hook"
[runs.force]
kind = "frequency"
input = "F"
band = ["0.3 Hz", "30 Hz"]
[criteria]
amplification = { run = "force", value = "max(abs(spring_force))", tolerance = 1e-6 }
[[tasks]]
name = "peak"
kind = "design"
minimise = "amplification"
candidates.absorber = ["(k1 | c1) + m1"]
fixed = { m1 = "mu*m" }
bounds = { k1 = ["1e3 N/m", "1e5 N/m"], c1 = ["1e1 N*s/m", "1e4 N*s/m"] }
"#;
    let found = outcome("absorber-designed", OSCILLATOR, study);
    let Findings::Design(design) = &found.findings else {
        panic!("a design");
    };
    let best = &design.designs[0];
    near(best.configuration.criteria["amplification"], 6.407_92, 2e-6);
    // The response is drawn as that of a linear host is.
    let plot = &found.plots[0];
    assert_eq!(plot.quantity, "|spring_force / F|");
    let series = &plot.series[0];
    near(series.peak.unwrap().1, 6.407_92, 2e-6);
    assert!(series.points.len() > 400);
}

/// The road is a velocity: its displacement is a first-order state, on which no output depends by itself, and which stays where
/// it is while the weight settles.
#[test]
fn quarter_car() {
    let host = r#"
quell = 1
[parameters]
ms = "250 kg"
mu = "35 kg"
kt = "150 kN/m"
K = "60 kN/m"
V = "25 m/s"
kappa = "5e-7 m"
g = "9.81 m/s^2"
[coordinates]
zs = {}
zu = {}
[states]
zr = "road"
[inputs]
road = { kind = "velocity" }
[equations]
zs = "ms*zs'' + ms*g + K*(zs - zu) = 0"
zu = "mu*zu'' + mu*g - K*(zs - zu) + kt*(zu - zr) = 0"
[ports.strut]
between = ["zs", "zu"]
[outputs]
acceleration = "zs''"
tyre_load = "kt*(zu - zr)"
travel = "zs - zu"
"#;
    let study = r#"
[devices.suspension]
port = "strut"
[runs.road]
kind = "frequency"
input = "road"
[runs.band]
kind = "frequency"
input = "road"
band = ["0 Hz", "30 Hz"]
[criteria]
comfort = { run = "road", value = "2*pi*sqrt(V*kappa)*h2(acceleration)", unit = "m/s^2" }
grip = { run = "road", value = "2*pi*sqrt(V*kappa)*h2(tyre_load)", unit = "N" }
travel = { run = "road", value = "h2(travel)" }
peak = { run = "band", value = "max(abs(travel))", tolerance = 1e-6 }
share = { run = "band", value = "h2(acceleration)" }
[[tasks]]
name = "struts"
kind = "evaluate"
[tasks.configurations]
damper = { suspension = "c1", c1 = "2000 N*s/m" }
series = { suspension = "k1 | b1 + c1", c1 = "2000 N*s/m", b1 = "200 kg", k1 = "1e4 N/m" }
"#;
    same("quarter-car", "quarter-car.toml", host, study);
}

#[test]
fn engine_mount() {
    let host = gallery("engine-on-mount.toml")
        .replace("mass = \"me\"", "")
        .replace("[linear]", "[equations]")
        .replace(
            "springs = [[\"xe\", \"xs\", \"kr\"]]",
            "xe = \"me*xe'' + cr*(xe' - xs') + kr*(xe - xs) = 0\"",
        )
        .replace("dampers = [[\"xe\", \"xs\", \"cr\"]]", "");
    let study = r#"
[components.track]
domain = "hydraulic"
layout = "R + I"
values = { I = "I0*dL/dA", R = "R0*dL/dA^2" }
variables = { dL = [0.5, 1.5], dA = [0.5, 1.5] }
[devices.passage]
port = "mount"
domain = "hydraulic"
piston = "Ap"
layout = "C1 | (C2 + network)"
[runs.road]
kind = "frequency"
input = "xs"
band = ["0 Hz", "30 Hz"]
[runs.free]
kind = "modes"
modes = "oscillatory"
[criteria]
Td_max = { run = "road", value = "max(abs(Td))", tolerance = 1e-6 }
force = { run = "road", value = "max(abs(force(mount)))" }
damping = { run = "free", value = "min(damping_ratio)" }
[[tasks]]
name = "default"
kind = "evaluate"
[tasks.configurations]
default = { network = "track1", "track1.dL" = 1, "track1.dA" = 1 }
"#;
    same("engine-mount", "engine-on-mount.toml", &host, study);
}

/// ω² = (2 ± √2) g/l hanging; standing on end both eigenvalues' squares are positive, with the same numbers.
#[test]
fn double_pendulum() {
    let study = |angle: &str| {
        format!(
            r#"
parameters = {{ angle = "{angle}" }}
[devices]
[runs.free]
kind = "modes"
[criteria]
slow = {{ run = "free", value = "min(frequency)" }}
fast = {{ run = "free", value = "max(frequency)" }}
growth = {{ run = "free", value = "-min(decay_rate)" }}
[[tasks]]
name = "modes"
kind = "evaluate"
[tasks.configurations]
alone = {{}}
"#
        )
    };
    let host = gallery("double-pendulum.toml");
    let omega = [2.0 - 2.0_f64.sqrt(), 2.0 + 2.0_f64.sqrt()].map(|w| (w * 9.81).sqrt());
    for (angle, growth) in [("3 deg", 0.0), ("178 deg", omega[1])] {
        let found = evaluated(&format!("double-pendulum-{angle}"), &host, &study(angle));
        let criteria = &found[0].criteria;
        near(criteria["slow"], omega[0], 1e-12);
        near(criteria["fast"], omega[1], 1e-12);
        // Without damping the real parts are rounding.
        assert!((criteria["growth"] - growth).abs() < 1e-12 * omega[1]);
    }
}

const PENDULUM: &str = r#"
quell = 1
[parameters]
m = "2 kg"
l = "0.5 m"
g = "9.81 m/s^2"
k = "8 N*m/rad"            # less than m g l: upright is unstable
c = "0.1 N*m*s/rad"
angle = "0 deg"
[coordinates]
a = { kind = "rotation", start = "angle" }
[inputs]
M = { kind = "force", motion = "rotation" }
[equations]
a = "m*l^2*a'' + c*a' + k*a - m*g*l*sin(a) = M"
[ports.p]
between = ["a", "ground"]
"#;

/// Upright under a torsional spring that is too weak: λ² m l² + c λ + k - m g l = 0 has a positive root. Responses are those
/// of the linear equations and say so, norms are refused. Fallen over to k a = m g l sin a it is stable.
#[test]
fn inverted_pendulum() {
    let study = r#"
[devices.d]
port = "p"
[runs.free]
kind = "modes"
[runs.shaken]
kind = "frequency"
input = "M"
band = ["0 Hz", "5 Hz"]
[runs.white]
kind = "frequency"
input = "M"
[criteria]
growth = { run = "free", value = "-min(decay_rate)" }
peak = { run = "shaken", value = "max(abs(a))" }
height = { run = "shaken", value = "abs(l*cos(a), 1 Hz)" }
norm = { run = "white", value = "h2(a)" }
[[tasks]]
name = "modes"
kind = "evaluate"
[tasks.configurations]
alone = {}
"#;
    let (inertia, c, k, weight) = (0.5_f64, 0.1, 8.0, 9.81);
    let found = evaluated("inverted-pendulum", PENDULUM, study).remove(0);
    let growth = (-c + (c * c + 4.0 * inertia * (weight - k)).sqrt()) / (2.0 * inertia);
    near(found.criteria["growth"], growth, 1e-12);
    assert_eq!(found.details["growth"].status, "computed");
    // The largest response is the static one, over the band's lower end.
    near(found.criteria["peak"], 1.0 / (weight - k), 1e-6);
    let status = &found.details["peak"].status;
    assert!(
        status.starts_with("certified, but the equilibrium is unstable"),
        "{status}"
    );
    // The height of the bob is level there: its gradient vanishes.
    assert!(found.criteria["height"].abs() < 1e-15);
    assert!(found.criteria["norm"].is_nan());
    let status = &found.details["norm"].status;
    assert!(status.contains("unstable"), "{status}");

    let study = format!("parameters = {{ angle = \"60 deg\" }}\n{study}");
    let found = evaluated("fallen-pendulum", PENDULUM, &study).remove(0);
    let mut a = 1.0_f64;
    for _ in 0..50 {
        a -= (k * a - weight * a.sin()) / (k - weight * a.cos());
    }
    let stiffness = k - weight * a.cos();
    // White moment of unit two-sided density: the variance of a is 1/(2 c stiffness).
    near(
        found.criteria["norm"],
        (1.0 / (2.0 * c * stiffness)).sqrt(),
        1e-9,
    );
    near(found.criteria["growth"], -c / (2.0 * inertia), 1e-9);
    let omega = TAU;
    let response = (stiffness - inertia * omega * omega)
        .hypot(c * omega)
        .recip();
    near(found.criteria["height"], 0.5 * a.sin() * response, 1e-9);
}

/// A weight on a gas spring: F (v0 - A x)^n = p A v0^n holds it at the volume v = v0 (p A/W)^(1/n), where dF/dx = n W A/v.
/// The orifice's force has no slope at rest, whatever its coefficient; its kink is one of curvature.
#[test]
fn gas_spring_under_a_weight() {
    let host = r#"
quell = 1
[parameters]
m = "100 kg"
g = "9.81 m/s^2"
c = "50 N*s/m"
[coordinates]
z = {}
[inputs]
zr = { kind = "displacement" }
[equations]
z = "m*z'' + c*(z' - zr') - m*g = 0"    # positive down
[ports.leg]
between = ["z", "zr"]
"#;
    let study = r#"
[elements.gas]
force = "p*A*(v0/(v0 - A*x))^n"
parameters = { p = "2e5 Pa", A = "2e-3 m^2", v0 = "4e-4 m^3", n = 1.3 }
stores = true
[elements.orifice]
force = "d*v*abs(v)"
parameters = { d = "1000 N*s^2/m^2" }
dissipates = true
[devices.leg]
port = "leg"
[runs.road]
kind = "frequency"
input = "zr"
band = ["0.1 Hz", "10 Hz"]
[runs.free]
kind = "modes"
[criteria]
natural = { run = "free", value = "min(frequency)" }
damping = { run = "free", value = "min(damping_ratio)" }
peak = { run = "road", value = "max(abs(z))", tolerance = 1e-8 }
load = { run = "road", value = "abs(force(leg), 0.5 Hz)" }
[[tasks]]
name = "leg"
kind = "evaluate"
[tasks.configurations]
alone = { leg = "gas" }
with_oil = { leg = "gas | orifice" }
"#;
    let (m, c) = (100.0_f64, 50.0_f64);
    let weight = m * 9.81;
    let volume = 4e-4 * (2e5 * 2e-3 / weight).powf(1.0 / 1.3);
    let stiffness = 1.3 * weight * 2e-3 / volume;
    let omega = (stiffness / m).sqrt();
    let zeta = c / (2.0 * m * omega);
    // Base excitation: the peak of √((1 + (2ζr)²)/((1 - r²)² + (2ζr)²)) is at r² = (√(1 + 8ζ²) - 1)/(4ζ²).
    let r = (((1.0 + 8.0 * zeta * zeta).sqrt() - 1.0) / (4.0 * zeta * zeta)).sqrt();
    let over = |r: f64| 1.0_f64.hypot(2.0 * zeta * r) / (1.0 - r * r).hypot(2.0 * zeta * r);
    let r_load = PI / omega;
    // k (z - zr) over zr: r²/((1 - r²) + 2iζr).
    let load = stiffness * r_load * r_load / (1.0 - r_load * r_load).hypot(2.0 * zeta * r_load);
    for found in evaluated("gas-spring", host, study) {
        near(found.criteria["natural"], omega, 1e-10);
        near(found.criteria["damping"], zeta, 1e-10);
        near(found.criteria["peak"], over(r), 1e-9);
        near(found.criteria["load"], load, 1e-9);
    }
}

/// Two masses on one spring, free: the distance has a variance, the place has none. ‖d/F‖² = 1/(2 c k) (μ/m1)², μ the reduced
/// mass, k and c between them.
#[test]
fn free_body() {
    let host = r#"
quell = 1
[parameters]
m1 = "2 kg"
m2 = "3 kg"
k = "50 N/m"
c = "0.7 N*s/m"
[coordinates]
x1 = {}
x2 = {}
[inputs]
F = { kind = "force" }
[equations]
x1 = "m1*x1'' + c*(x1' - x2') + k*(x1 - x2) = F"
x2 = "m2*x2'' - c*(x1' - x2') - k*(x1 - x2) = 0"
[ports.p]
between = ["x1", "x2"]
"#;
    let study = r#"
[devices.d]
port = "p"
[runs.free]
kind = "modes"
[runs.white]
kind = "frequency"
input = "F"
[runs.band]
kind = "frequency"
input = "F"
band = ["0.001 Hz", "0.002 Hz"]
[criteria]
natural = { run = "free", value = "min(frequency)" }
distance = { run = "white", value = "h2(x1 - x2)" }
place = { run = "white", value = "h2(x1)" }
in_band = { run = "band", value = "h2(x1)" }
[[tasks]]
name = "free"
kind = "evaluate"
[tasks.configurations]
alone = {}
"#;
    let found = evaluated("free-body", host, study).remove(0);
    let reduced = 2.0 * 3.0 / 5.0;
    near(
        found.criteria["natural"],
        (50.0_f64 / reduced).sqrt(),
        1e-12,
    );
    near(
        found.criteria["distance"],
        (1.0_f64 / (2.0 * 0.7 * 50.0)).sqrt() * reduced / 2.0,
        1e-9,
    );
    // Far below the spring's frequency all moves as one: |x1/F| = 1/((m1 + m2) ω²), up to (ω/ω0)², 6e-6 there.
    let omega = 0.001 * TAU;
    let square = (1.0 - 0.125) / (3.0 * PI * 25.0 * omega.powi(3));
    near(found.criteria["in_band"], square.sqrt(), 1e-5);
    let status = &found.details["place"].status;
    assert!(found.criteria["place"].is_nan() && status.contains("undamped mode at 0 Hz"));
}

/// Where no linear equations hold there is no number, and the status says why.
#[test]
fn why_there_is_no_linear_system() {
    let study = r#"
[devices.d]
port = "p"
[runs.free]
kind = "modes"
[criteria]
natural = { run = "free", value = "min(frequency)" }
[[tasks]]
name = "free"
kind = "evaluate"
[tasks.configurations]
alone = {}
"#;
    let host = |equation: &str| {
        format!(
            r#"
quell = 1
[parameters]
m = "2 kg"
k = "50 N/m"
g = "9.81 m/s^2"
N = "3 N"
T = "1 s"
[coordinates]
x = {{}}
[equations]
x = "{equation}"
[ports.p]
between = ["x", "ground"]
"#
        )
    };
    for (index, (equation, reason)) in [
        (
            "m*x'' + k*x + N*sign(x') = 0",
            "the equations jump at the static equilibrium, where `x'`",
        ),
        (
            "m*x'' + k*max(x, 0) + k*x/4 = 0",
            "the equations have a kink at the static equilibrium, where `x`",
        ),
        (
            "m*x'' + k*x*(1 + sin(t/T)/2) = 0",
            "the equations contain the time `t`",
        ),
        (
            "m*x'' + k*x = N*sin(t/T)",
            "the equations contain the time `t`",
        ),
        (
            "m*x'' + k*x'/(1 1/s) = m*g",
            "no static equilibrium was found",
        ),
        (
            "m*x'' + N*sqrt(abs(x)/(1 m))*sign(x) = 0",
            "the static equilibrium",
        ),
    ]
    .into_iter()
    .enumerate()
    {
        let found = evaluated(&format!("none-{index}"), &host(equation), study).remove(0);
        let status = &found.details["natural"].status;
        assert!(found.criteria["natural"].is_nan(), "{equation}");
        assert!(status.contains(reason), "{equation}: {status}");
    }
}

/// The gear at rest: the gas spring carries (W1 - L)/cos φ at the volume where it is that strong, and its slope there is
/// n F A/v. With M = diag(W1, W2)/g and K = k [1, -1; -1, 1] + diag(0, kt) the two frequencies follow from a quadratic.
#[test]
fn landing_gear_at_rest() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies/touch-down-at-rest.toml");
    let study = Study::read(&path).unwrap_or_else(|fault| panic!("{}", fault.render()));
    let outcome = run(&study, &RunSettings::default(), &Silent).unwrap();
    // lbf, ft, s, as in the source: frequencies are the same.
    let (w1, w2, g, kt) = (2411.0_f64, 131.0, 32.18, 18500.0);
    let (pressure, area, volume, n) = (6264.0_f64, 0.05761, 0.03545, 1.12_f64);
    for (point, lift) in outcome.tasks[0].points.iter().zip([0.0, 1000.0, 2000.0]) {
        let Findings::Evaluate(found) = &point.findings else {
            panic!("evaluates");
        };
        let force = (w1 - lift) / 12.0_f64.to_radians().cos();
        let held = volume * (pressure * area / force).powf(1.0 / n);
        for (found, k) in
            found
                .iter()
                .zip([n * force * area / held, n * force * area / held, 7128.0])
        {
            let (m1, m2) = (w1 / g, w2 / g);
            let sum = k / m1 + (k + kt) / m2;
            let product = k * kt / (m1 * m2);
            let root = (sum * sum - 4.0 * product).sqrt();
            let criteria = &found.criteria;
            // 2 product/(sum + root) is the lower square without cancellation.
            let (slow, fast) = (2.0 * product / (sum + root), 0.5 * (sum + root));
            if found.name == "gas_and_oil" {
                near(criteria["heave"], slow.sqrt(), 1e-9);
                near(criteria["hop"], fast.sqrt(), 1e-9);
                assert!(criteria["damping"].abs() < 1e-12);
            } else {
                // |λ1|² |λ2|² is the determinant with or without a damper.
                let squares = (criteria["heave"] * criteria["hop"]).powi(2);
                near(squares, product, 1e-9);
                assert!(criteria["damping"] > 1e-3);
            }
        }
    }
}

/// Two runs with inputs of their own on one host, and a configuration with another: responses of an oscillator without
/// damping to a rectangle, x = F/k (1 - cos ωs) and its difference, and to a sine below resonance.
#[test]
fn runs_with_inputs_of_their_own() {
    let host = r#"
quell = 1
[parameters]
m = "2 kg"
k = "m*(2 Hz)^2"
F0 = "3 N"
[coordinates]
x = {}
[inputs]
F = { kind = "force", signal = { harmonic = { amplitude = "1000 N", frequency = "1 Hz" } } }
G = { kind = "force" }
[equations]
x = "m*x'' + k*x = F + G"
[ports.p]
between = ["x", "ground"]
"#;
    let study = r#"
[devices.d]
port = "p"
[runs.kick]
kind = "transient"
duration = "10 s"
tolerance = 1e-10
inputs = { F = { pulse = { shape = "rectangular", amplitude = "F0", at = "1.3 s", duration = "1 ms" } } }
[runs.sine]
kind = "transient"
duration = "1.2 s"
tolerance = 1e-10
[runs.sine.inputs]
F.pulse = { amplitude = 0, duration = "1 s" }
G.harmonic = { amplitude = "F0/2", frequency = "0.8 Hz" }
[criteria]
before = { run = "kick", value = "at(x, 1.299 s)" }
largest = { run = "kick", value = "max(x)" }
later = { run = "kick", value = "at(x, 7.77 s)" }
forced = { run = "sine", value = "final(x)" }
[[tasks]]
name = "runs"
kind = "evaluate"
[tasks.configurations]
stated = {}
longer = { "runs.kick.inputs.F" = { pulse = { shape = "rectangular", amplitude = "2*F0", at = "1.3 s", duration = "0.1 s" } } }
both = { "runs.kick.inputs" = { G = { pulse = { shape = "rectangular", amplitude = "F0", at = "1.3 s", duration = "1 ms" } } } }
"#;
    let omega = 2.0 * TAU;
    let k = 2.0 * omega * omega;
    let kick = |force: f64, duration: f64, t: f64| {
        force / k * ((omega * (t - 1.3 - duration)).cos() - (omega * (t - 1.3)).cos())
    };
    let amplitude = |force: f64, duration: f64| 2.0 * force / k * (0.5 * omega * duration).sin();
    // Tolerances: 1e-10 a step over twenty periods.
    for (found, (force, duration)) in
        evaluated("own-inputs", host, study)
            .iter()
            .zip([(3.0, 1e-3), (6.0, 0.1), (6.0, 1e-3)])
    {
        let criteria = &found.criteria;
        assert_eq!(criteria["before"], 0.0);
        near(criteria["largest"], amplitude(force, duration), 1e-7);
        let error = criteria["later"] - kick(force, duration, 7.77);
        assert!(error.abs() < 1e-7 * amplitude(force, duration), "{error:e}");
        let forced = 0.8 * TAU;
        let (t, r) = (1.2, forced / omega);
        let exact = 1.5 / k / (1.0 - r * r) * ((forced * t).sin() - r * (omega * t).sin());
        near(criteria["forced"], exact, 1e-7);
    }
}
