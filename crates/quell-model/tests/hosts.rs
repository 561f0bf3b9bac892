//! Host files against matrices written by hand, and equivalences between ways of saying the same.

mod common;

use common::{assert_close, build, column, rows};
use faer::Mat;
use faer::linalg::solvers::Solve;
use quell_expression::{Dimension, Expression, Quantity};
use quell_model::{
    CoordinateKind, DevicePart, HostFile, InputKind, LinearHost, Override, Signal, SignalNames,
    linear_form,
};

const QUARTER_CAR: &str = r#"
quell = 1
title = "Quarter car"

[parameters]
ms = "250 kg"
mu = "35 kg"
ks = "15000 N/m"
cs = "2*zeta*sqrt(ks*ms)"
zeta = "0.2"
kt = "150 kN/m"

[coordinates]
zs = { mass = "ms" }
zu = { mass = "mu" }

[inputs]
zr = { kind = "displacement" }
Fd = { kind = "force", on = { zs = 1, zu = -1 } }

[linear]
springs = [["zs", "zu", "ks"], { between = ["zu", "zr"], value = "kt", name = "tyre" }]
dampers = [["zs", "zu", "cs"]]

[ports.strut]
between = ["zs", "zu"]

[ports.body]
at = "zs"

[outputs]
comfort = "zs''"
travel = "zs - zu"
grip = "force(tyre)/(ms + mu)"
doubled = "2*travel' - stroke(strut)'"
strut_force = "force(strut)"
"#;

#[test]
fn quarter_car_against_its_textbook_matrices() {
    let host = build(QUARTER_CAR);
    let c = 2.0 * 0.2 * (15_000.0_f64 * 250.0).sqrt();
    assert_close(&host.mass, &[&[250.0, 0.0], &[0.0, 35.0]]);
    assert_close(&host.damping, &[&[c, -c], &[-c, c]]);
    assert_close(&host.stiffness, &[&[15e3, -15e3], &[-15e3, 165e3]]);
    assert_close(&host.forcing[0], &[&[0.0, 1.0], &[150e3, -1.0]]);
    assert_close(&host.forcing[1], &[&[0.0, 0.0], &[0.0, 0.0]]);
    assert!(host.loss.is_none());
    let (index, strut) = host.port("strut").unwrap();
    assert_eq!((index, &strut.coordinates[..]), (0, &[1.0, -1.0][..]));
    assert!(!strut.hangs && !strut.grounded);
    let (_, body) = host.port("body").unwrap();
    assert!(body.hangs && body.grounded);
    let names: Vec<&str> = host
        .outputs
        .iter()
        .map(|output| output.name.as_str())
        .collect();
    assert_eq!(
        names,
        ["comfort", "travel", "grip", "doubled", "strut_force"]
    );
    let form = |name: &str| host.output(name).unwrap().1.form.terms.clone();
    let q = |index, order| Signal::Coordinate { index, order };
    assert_eq!(form("comfort"), [(q(0, 2), 1.0)]);
    assert_eq!(form("doubled"), [(q(0, 1), 1.0), (q(1, 1), -1.0)]);
    let grip = form("grip");
    assert_eq!(grip[0].0, q(1, 0));
    assert!((grip[0].1 - 150e3 / 285.0).abs() < 1e-12);
    assert_eq!(grip[1].0, Signal::Input { index: 0, order: 0 });
    assert_eq!(form("strut_force"), [(Signal::PortForce { index: 0 }, 1.0)]);
    assert_eq!(
        host.output("grip").unwrap().1.dimension,
        Dimension::ACCELERATION
    );
    insta::assert_snapshot!(host.describe().join("\n"), @r"
    2 coordinates: zs (m), zu (m)
    2 inputs: zr (displacement, m), Fd (force, N)
    2 ports: strut (m), body (m)
    5 outputs: comfort (m/s^2), travel (m), grip (m/s^2), doubled (m/s), strut_force (N)
    ");
}

#[test]
fn levers_turn_displacements_into_angles() {
    // A bar on two springs at -a and +b of its centre; energy k/2 (x - a θ)² + K/2 (x + b θ)².
    let host = build(
        r#"
quell = 1
[parameters]
a = "0.4 m"
k = "100 N/m"
[coordinates]
x = { mass = "10 kg" }
theta = { kind = "rotation", inertia = "2 kg*m^2" }
e = { kind = "rotation" }
[inputs]
M = { kind = "force", motion = "rotation", on = "theta" }
F = { kind = "force", on = "x + 0.5 m*theta" }
road = { kind = "velocity" }
[linear]
springs = [["x - a*theta", "ground", "k"], ["x + 0.6 m*theta", "road", "200 N/m"], ["theta", "e", "7 N*m/rad"]]
inerters = [["x", "x + 0.5 m*theta", "4 kg"]]
masses = [["x - a*theta", "1 kg"]]
[ports.twist]
between = ["e", "ground"]
[ports.tip]
across = "x + 0.6 m*theta - road"
[outputs]
tip = "x + 0.6 m*theta"
v = "road"
"#,
    );
    let (a, b) = (0.4, 0.6);
    assert_close(
        &host.stiffness,
        &[
            &[300.0, -100.0 * a + 200.0 * b, 0.0],
            &[
                -100.0 * a + 200.0 * b,
                100.0 * a * a + 200.0 * b * b + 7.0,
                -7.0,
            ],
            &[0.0, -7.0, 7.0],
        ],
    );
    assert_close(
        &host.mass,
        &[
            &[11.0, -0.4, 0.0],
            &[-0.4, 2.0 + 0.16 + 4.0 * 0.25, 0.0],
            &[0.0, 0.0, 0.0],
        ],
    );
    assert_close(
        &host.forcing[0],
        &[&[0.0, 1.0, 200.0], &[1.0, 0.5, 120.0], &[0.0, 0.0, 0.0]],
    );
    assert_eq!(host.ports[0].kind, CoordinateKind::Rotation);
    assert!(host.ports[0].grounded);
    assert_eq!(host.ports[1].inputs, [0.0, 0.0, -1.0]);
    assert_eq!(host.output("tip").unwrap().1.dimension, Dimension::LENGTH);
    // An input given as a velocity is u'.
    assert_eq!(
        host.output("v").unwrap().1.form.terms,
        [(Signal::Input { index: 2, order: 1 }, 1.0)]
    );
    assert_eq!(host.inputs[2].kind, InputKind::Velocity);
}

/// Response of all coordinates, absolute, to a unit displacement of the ground at s = jω, ω² = `-square`, by real
/// arithmetic on undamped hosts; damped ones are compared through their matrices.
fn undamped_response(host: &LinearHost, square: f64) -> Vec<f64> {
    let dynamic = Mat::from_fn(host.mass.nrows(), host.mass.nrows(), |row, column| {
        host.stiffness[(row, column)] + square * host.mass[(row, column)]
    });
    let force = Mat::from_fn(host.mass.nrows(), 1, |row, _| {
        host.forcing[0][(row, 0)] + square * host.forcing[2][(row, 0)]
    });
    column(&dynamic.partial_piv_lu().solve(&force))
}

const STOREYS: &str = r#"
[parameters]
m = "2 kg"
k = "50 N/m"
"#;

#[test]
fn influence_and_supports_describe_the_same_chain() {
    for damping in [
        "",
        "damping = { modal = [0.02, 0.05] }",
        "damping = { rayleigh = { alpha = \"0.3 s^-1\", beta = \"2 ms\" } }",
    ] {
        let relative = build(&format!(
            r#"quell = 1
{STOREYS}
[coordinates]
x1 = {{ mass = "m" }}
x2 = {{ mass = "3 kg" }}
[inputs]
ag = {{ kind = "acceleration" }}
[linear]
springs = [["x1", "ground", "k"], ["x1", "x2", "2*k"]]
base = {{ influence = [1, 1], input = "ag" }}
{damping}
[outputs]
a2 = "x2'' + ag"
"#
        ));
        let absolute = build(&format!(
            r#"quell = 1
{STOREYS}
[coordinates]
x0 = {{}}
x1 = {{ mass = "m" }}
x2 = {{ mass = "3 kg" }}
[inputs]
x0 = {{ kind = "acceleration" }}
[linear]
matrices = {{ K = [["k", "-k", 0], ["-k", "3*k", "-2*k"], [0, "-2*k", "2*k"]] }}
supports = ["x0"]
{damping}
"#
        ));
        let size = 2;
        assert_eq!(absolute.inputs[0].kind, InputKind::Acceleration);
        for ((a, b), what) in [
            (&relative.mass, &absolute.mass),
            (&relative.damping, &absolute.damping),
            (&relative.stiffness, &absolute.stiffness),
        ]
        .into_iter()
        .zip(["mass", "damping", "stiffness"])
        {
            assert_close(a, &rows(b).iter().map(Vec::as_slice).collect::<Vec<_>>());
            assert!(a.nrows() == size, "{what}");
        }
        for square in [-4.0, -30.0, 7.0] {
            let moving = undamped_response(&relative, square);
            let fixed = undamped_response(&absolute, square);
            for (moving, fixed) in moving.iter().zip(&fixed) {
                // Well-conditioned 2 x 2 solves; 1e-12 is a thousand roundings.
                assert!((moving + 1.0 - fixed).abs() < 1e-12 * fixed.abs().max(1.0));
            }
        }
        // Damping forces: C (q_relative' ) = C (q' - ι u'), so F1 is C ι.
        for row in 0..size {
            let drag: f64 = (0..size)
                .map(|column| absolute.damping[(row, column)])
                .sum();
            assert!(
                (absolute.forcing[1][(row, 0)] - drag).abs()
                    < 1e-12 * absolute.damping.norm_max().max(1.0)
            );
            assert_eq!(relative.forcing[1][(row, 0)], 0.0);
        }
    }
}

#[test]
fn devices_on_a_moving_base() {
    let host = build(
        r#"
quell = 1
[coordinates]
x = { mass = 1 }
[inputs]
ag = { kind = "acceleration" }
[linear]
springs = [["x", "ground", 4]]
masses = [{ at = "x", value = 0.5, name = "lump" }]
base = { influence = [1], input = "ag" }
[ports.a]
at = "x"
[ports.b]
between = ["x", "ground"]
[outputs]
F = "force(lump)"
"#,
    );
    assert_close(&host.mass, &[&[1.5]]);
    assert_close(&host.forcing[2], &[&[-1.5]]);
    assert_eq!(
        (host.ports[0].inputs[0], host.ports[0].grounded),
        (1.0, true)
    );
    assert_eq!(
        (host.ports[1].inputs[0], host.ports[1].grounded),
        (0.0, false)
    );
    assert_eq!(
        host.outputs[0].form.terms,
        [
            (Signal::Coordinate { index: 0, order: 2 }, 0.5),
            (Signal::Input { index: 0, order: 2 }, 0.5)
        ]
    );
}

#[test]
fn modal_damping_gives_the_ratios_it_was_asked_for() {
    let host = build(
        r#"
quell = 1
[coordinates]
x1 = { mass = 2 }
x2 = { mass = 1 }
x3 = { mass = 3 }
[linear]
matrices = { K = [[10, -10, 0], [-10, 30, -20], [0, -20, 20]] }
damping = { modal = "2 %" }
"#,
    );
    // With one ratio for all modes C M⁻¹ C = 4 ζ² K, since both sides are Σ M φ (2ζω)² φᵀ M.
    let inverse = Mat::from_fn(3, 3, |row, column| {
        if row == column {
            1.0 / host.mass[(row, row)]
        } else {
            0.0
        }
    });
    let square = &host.damping * &inverse * &host.damping;
    let expected = Mat::from_fn(3, 3, |row, column| {
        4.0 * 0.02 * 0.02 * host.stiffness[(row, column)]
    });
    assert_close(
        &square,
        &rows(&expected)
            .iter()
            .map(Vec::as_slice)
            .collect::<Vec<_>>(),
    );
}

#[test]
fn loss_factors_are_the_imaginary_stiffness() {
    let host = build(
        r#"
quell = 1
[coordinates]
x1 = { mass = 2 }
x2 = { mass = 1 }
[linear]
springs = [["x1", "ground", 100], { between = ["x1", "x2"], value = 10, loss = 0.2, name = "rubber" }]
damping = { loss = 0.01 }
[outputs]
shear = "stroke(rubber)"
"#,
    );
    assert_close(&host.stiffness, &[&[110.0, -10.0], &[-10.0, 10.0]]);
    assert_close(host.loss.as_ref().unwrap(), &[&[3.0, -2.0], &[-2.0, 2.0]]);
}

#[test]
fn matrices_and_elements_add_up_and_files_are_found() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let text = r#"
quell = 1
[coordinates]
a = {}
b = { mass = 1 }
c = {}
[inputs]
F = { kind = "force", on = "c" }
[linear]
matrices = { M = "matrices/several.npz:M", K = "matrices/symmetric_coordinate.mtx", C = "matrices/skew_array.mtx" }
springs = [["a", "ground", 0.5]]
"#;
    let source = std::sync::Arc::new(quell_document::Source::new("frame.toml", text));
    let file = HostFile::parse(source, &folder).unwrap();
    let host = file.build(&[]).unwrap();
    assert_close(
        &host.mass,
        &[&[4.0, -1.0, 0.0], &[-1.0, 6.0, -2.25], &[0.0, -2.25, 6.0]],
    );
    assert_close(
        &host.stiffness,
        &[&[4.5, -1.0, 0.0], &[-1.0, 5.0, -2.25], &[0.0, -2.25, 6.0]],
    );
    assert_close(
        &host.damping,
        &[&[0.0, -1.5, 0.0], &[1.5, 0.0, 2.0], &[0.0, -2.0, 0.0]],
    );
    assert_eq!(file.matrix_files().len(), 3);
    assert!(file.matrix_files().iter().all(|path| path.exists()));
}

#[test]
fn studies_replace_parameters() {
    let file = common::file(QUARTER_CAR);
    let heavy = Override::new("ms", Quantity::new(400.0, Dimension::MASS));
    let host = file.build(std::slice::from_ref(&heavy)).unwrap();
    assert_eq!(host.mass[(0, 0)], 400.0);
    let c = 2.0 * 0.2 * (15_000.0_f64 * 400.0).sqrt();
    assert!((host.damping[(0, 0)] - c).abs() < 1e-9);
    let parameters = file.parameters(&[heavy]).unwrap();
    assert_eq!(
        parameters[0],
        ("ms".to_owned(), Quantity::new(400.0, Dimension::MASS))
    );
    assert_eq!(parameters.len(), 6);
    // A plain number is SI.
    let plain = Override::new("ms", Quantity::number(300.0));
    assert_eq!(file.build(&[plain]).unwrap().mass[(0, 0)], 300.0);
    let unknown = Override::new("mss", Quantity::number(1.0));
    let fault = file.build(&[unknown]).unwrap_err();
    assert_eq!(fault.message, "the host has no parameter `mss`");
    assert_eq!(fault.help.as_deref(), Some("did you mean `ms`?"));
    let wrong = Override::new("ms", Quantity::new(1.0, Dimension::LENGTH));
    assert_eq!(
        file.build(&[wrong]).unwrap_err().message,
        "`ms` is in `kg` in the host, but this is in `m`"
    );
}

#[test]
fn criteria_may_name_devices_and_their_parts() {
    let file = common::file(QUARTER_CAR);
    let host = file.assemble(&[]).unwrap();
    let part = |device: &str, port, part: &str| DevicePart {
        device: device.to_owned(),
        port,
        part: part.to_owned(),
    };
    let parts = [
        part("damper", 0, "k1"),
        part("damper", 0, "track1.I"),
        part("absorber", 1, "k1"),
    ];
    let devices = [("damper".to_owned(), 0), ("absorber".to_owned(), 1)];
    let names = SignalNames {
        devices: &devices,
        parts: &parts,
        ..host.names()
    };
    let read = |text: &str| linear_form(&host.linear, &Expression::parse(text).unwrap(), &names);
    let (form, dimension) = read("stroke(track1.I)'").unwrap();
    assert_eq!(
        form.terms,
        [(
            Signal::PartStroke {
                port: 0,
                part: "track1.I".to_owned(),
                order: 1
            },
            1.0
        )]
    );
    assert_eq!(dimension, Dimension::VELOCITY);
    assert_eq!(
        read("force(absorber.k1) + force(damper)").unwrap().0.terms,
        [
            (
                Signal::PartForce {
                    port: 1,
                    part: "k1".to_owned()
                },
                1.0
            ),
            (Signal::PortForce { index: 0 }, 1.0)
        ]
    );
    let message = |text: &str| {
        let error = read(text).unwrap_err();
        match error.help {
            Some(help) => format!("{text}: {} [{help}]", error.message),
            None => format!("{text}: {}", error.message),
        }
    };
    let texts = [
        "force(k1)",
        "stroke(track1.R)",
        "force(zs + zu)",
        "zs*zu",
        "abs(zs)",
        "zs^2",
        "1/zs",
        "zs - 1 mm",
        "zs + zu'",
        "zs'''",
        "force(strut)'",
        "ks'",
        "2 + 3",
        "zz",
        "zs < zu",
        "zs/0",
    ];
    insta::assert_snapshot!(texts.map(message).join("\n"));
}

#[test]
fn keys_serve_schema_and_reference() {
    let schema = quell_document::json_schema(&quell_model::host::keys::HOST);
    assert_eq!(schema["required"], serde_json::json!(["quell"]));
    let reference = quell_document::reference_markdown(&quell_model::host::keys::HOST);
    for key in [
        "influence",
        "rayleigh",
        "between",
        "inertia",
        "kinetic",
        "massless",
        "half-sine",
        "operating",
    ] {
        assert!(reference.contains(key), "{key}");
    }
}

#[test]
fn parameters_of_other_domains_keep_their_units() {
    let file = common::file(
        r#"
quell = 1
[parameters]
Ap = "2.5e-3 m^2"
C1 = "3.0e-11 m^5/N"
R0 = "1.05e8 kg/(s*m^4)"
[coordinates]
x = { mass = "60 kg" }
[inputs]
xs = { kind = "displacement" }
[linear]
springs = [["x", "xs", "2.25e5 N/m"], ["x", "ground", "Ap^2/C1"]]
dampers = [["x", "xs", "Ap^2*R0"]]
[ports.p]
between = ["x", "xs"]
"#,
    );
    let host = file.assemble(&[]).unwrap();
    assert_close(&host.linear.damping, &[&[656.25]]);
    assert_close(&host.linear.stiffness, &[&[2.25e5 + 6.25e-6 / 3.0e-11]]);
    assert_close(&host.linear.forcing[1], &[&[656.25]]);
    assert_eq!(host.linear.ports[0].inputs, [-1.0]);
    assert_eq!(host.parameters[1].1.value, 3.0e-11);
}
