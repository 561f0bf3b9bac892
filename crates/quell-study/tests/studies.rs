//! The studies of the gallery against figures that are known otherwise.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a failed test ends by panic"
)]

use std::path::{Path, PathBuf};

use quell_study::results::{DesignResult, Results, TaskBody, TaskFindings};
use quell_study::{RunSettings, Silent, Study};

fn gallery(name: &str) -> Study {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../studies")
        .join(name);
    Study::read(&path).unwrap_or_else(|fault| panic!("{}", fault.render()))
}

fn run(study: &Study, seed: u64, threads: usize, tasks: &[&str]) -> Results {
    let settings = RunSettings {
        seed,
        threads: Some(threads),
        tasks: tasks.iter().map(|task| (*task).to_owned()).collect(),
    };
    quell_study::run(study, &settings, &Silent)
        .unwrap_or_else(|error| panic!("{error}"))
        .results
}

fn designs<'a>(results: &'a Results, task: &str) -> &'a [DesignResult] {
    match &results.tasks[task].body {
        TaskBody::Single(TaskFindings::Design { designs, .. }) => designs,
        other => panic!("{task} is no design without a sweep: {other:?}"),
    }
}

fn sweep_designs<'a>(results: &'a Results, task: &str) -> Vec<(&'a f64, &'a DesignResult)> {
    let TaskBody::Sweep { points } = &results.tasks[task].body else {
        panic!("{task} has no sweep");
    };
    points
        .iter()
        .map(|point| match &point.findings {
            TaskFindings::Design { designs, .. } => {
                (point.at.values().next().unwrap(), &designs[0])
            }
            _ => {
                panic!("{task} is no design")
            }
        })
        .collect()
}

fn criterion(results: &Results, task: &str, configuration: &str, criterion: &str) -> f64 {
    match &results.tasks[task].body {
        TaskBody::Single(TaskFindings::Evaluate { configurations }) => {
            configurations[configuration].criteria[criterion]
        }
        other => panic!("{task} evaluates nothing: {other:?}"),
    }
}

/// The best objective of the design whose layout has these branches in any order.
fn objective_of(designs: &[DesignResult], layout: &str, kinds: &[&str]) -> f64 {
    let parse = |text: &str| {
        let mut table = quell_network::Kinds::new(quell_network::Domain::Hydraulic);
        for kind in kinds {
            table.declare_component(kind).unwrap();
        }
        quell_network::Layout::parse(text, &table).unwrap()
    };
    // Instances are numbered as they stand, so that structure alone decides.
    let shape = |text: &str| {
        let canonical = parse(text).canonical().to_string();
        canonical
            .chars()
            .filter(|c| !c.is_ascii_digit())
            .collect::<String>()
    };
    designs
        .iter()
        .find(|design| shape(&design.devices["passage"].layout) == shape(layout))
        .unwrap_or_else(|| panic!("no design with the layout {layout}"))
        .objective
}

/// Y. Li's thesis, chapter 6 (linear model, engine on a hydraulic mount), with the rubber damping that reproduces its
/// figures; optima recomputed from many starts of global optimisers. The tolerance, 2e-4, is below what the source's
/// rounding (three digits) hides and above what the certificate of a peak leaves open (1e-4).
#[test]
fn engine_mount_reaches_every_known_optimum_from_every_seed() {
    let study = gallery("engine-mount-linear.toml");
    let kinds = ["track", "restriction"];
    for seed in 1..=5 {
        let results = run(&study, seed, 2, &[]);
        let TaskBody::Single(TaskFindings::Evaluate { configurations }) =
            &results.tasks["default"].body
        else {
            panic!("`default` evaluates");
        };
        let baseline = &configurations["default"];
        assert!(
            (baseline.criteria["Td_max"] / 3.6349 - 1.0).abs() < 1e-4,
            "{:?}",
            baseline.criteria
        );
        assert!((baseline.details["Td_max"].at_hz.unwrap() - 18.71).abs() < 0.01);
        assert_eq!(baseline.details["Td_max"].status, "certified");
        let counts = [("one", 1), ("two", 4), ("three", 12), ("four", 42)];
        for (task, count) in counts {
            assert_eq!(designs(&results, task).len(), count);
        }
        let known = [
            ("one", "track", 2.3419),
            ("two", "track1 | restriction1", 1.7865),
            ("two", "track1 + restriction1", 1.7550),
            ("two", "track1 | track2", 2.0614),
            ("three", "track1 + (track2 | restriction1)", 1.6907),
            (
                "four",
                "track1 + restriction1 + (track2 | restriction2)",
                1.6873,
            ),
            (
                "four",
                "(track1 + track2) | (track3 + restriction1)",
                1.6668,
            ),
        ];
        for (task, layout, best) in known {
            let found = objective_of(designs(&results, task), layout, &kinds);
            assert!(
                found <= best * (1.0 + 2e-4),
                "seed {seed}, {task}, {layout}: {found} above {best}"
            );
        }
        // A four-branch network that the source did not find.
        assert!(designs(&results, "four")[0].objective < 1.6668 - 1e-3);
        for (task, _) in counts {
            for design in designs(&results, task) {
                assert_eq!(
                    design.details["Td_max"].status, "certified",
                    "{:?}",
                    design.devices
                );
                assert!(design.details["Td_max"].achieved_tolerance.unwrap() <= 1e-4);
                assert!(design.feasible && design.objective.is_finite());
            }
        }
    }
}

#[test]
fn the_first_peak_of_the_default_mount_is_where_the_source_has_it() {
    // First peak 2.309 at 8.06 Hz: the band is cut below the second one.
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies/engine-mount-linear.toml");
    let text = std::fs::read_to_string(&path)
        .unwrap()
        .replace("\"30 Hz\"", "\"12 Hz\"");
    let source = quell_document::Source::new("engine-mount-linear.toml", text);
    let study = Study::parse(source, path.parent().unwrap())
        .unwrap_or_else(|fault| panic!("{}", fault.render()));
    let results = run(&study, 1, 1, &["default"]);
    let TaskBody::Single(TaskFindings::Evaluate { configurations }) =
        &results.tasks["default"].body
    else {
        panic!("`default` evaluates");
    };
    let baseline = &configurations["default"];
    assert!((baseline.criteria["Td_max"] - 2.309).abs() < 1e-3);
    assert!((baseline.details["Td_max"].at_hz.unwrap() - 8.06).abs() < 0.01);
}

#[test]
fn designs_do_not_depend_on_the_number_of_threads() {
    let study = gallery("engine-mount-linear.toml");
    let one = run(&study, 7, 1, &["two", "three"]);
    let three = run(&study, 7, 3, &["two", "three"]);
    for task in ["two", "three"] {
        for (a, b) in designs(&one, task).iter().zip(designs(&three, task)) {
            assert_eq!(a.devices, b.devices);
            assert_eq!(a.objective.to_bits(), b.objective.to_bits());
            assert_eq!(a.evaluations, b.evaluations);
            assert_eq!(a.starts_agreeing, b.starts_agreeing);
        }
    }
}

/// Tuning f = ωa/ωn and damping ratio of an absorber designed on the 1000 kg, 4e5 N/m oscillator with mass ratio .05.
fn tuning(design: &DesignResult) -> (f64, f64) {
    let values = &design.devices["absorber"].values;
    let (m, k, mass) = (1000.0_f64, 4e5_f64, 50.0_f64);
    let omega = (values["k1"] / mass).sqrt();
    (omega / (k / m).sqrt(), values["c1"] / (2.0 * mass * omega))
}

#[test]
fn tuned_mass_damper_has_the_exact_h_infinity_optimum() {
    let results = run(&gallery("tuned-mass-damper.toml"), 3, 2, &["rule", "peak"]);
    // Den Hartog (1956) by his rule, and Nishihara and Asami (2002), exact; both as printed to six digits.
    assert!((criterion(&results, "rule", "den_hartog", "amplification") - 6.40844).abs() < 1e-5);
    let best = &designs(&results, "peak")[0];
    assert!(
        (best.objective - 6.40792).abs() < 1e-5,
        "{}",
        best.objective
    );
    let (f, zeta) = tuning(best);
    // At a minimax of two peaks the values are known to about the tolerance of the peak over the slope of the peaks.
    assert!((f - 0.952_372).abs() < 2e-5, "{f}");
    assert!((zeta - 0.133_938).abs() < 2e-4, "{zeta}");
    assert!(best.improvement["den_hartog"] > 5e-5);
    assert!(best.starts_agreeing * 2 > best.starts);
}

#[test]
fn tuned_mass_damper_has_the_exact_h2_optimum() {
    let results = run(
        &gallery("tuned-mass-damper.toml"),
        3,
        2,
        &["rule", "white noise"],
    );
    let best = &designs(&results, "white noise")[0];
    // Iwata (1982), Asami and others (1991): f = √(1 + μ/2)/(1 + μ), ζ² = μ(1 + 3μ/4)/(4(1 + μ)(1 + μ/2)).
    let mu = 0.05_f64;
    let f_exact = (1.0 + mu / 2.0).sqrt() / (1.0 + mu);
    let zeta_exact = (mu * (1.0 + 0.75 * mu) / (4.0 * (1.0 + mu) * (1.0 + mu / 2.0))).sqrt();
    let (f, zeta) = tuning(best);
    // A smooth optimum: values are known to the root of the objective's tolerance.
    assert!((f - f_exact).abs() < 1e-4, "{f} {f_exact}");
    assert!((zeta - zeta_exact).abs() < 1e-3, "{zeta} {zeta_exact}");
    let closed_form = criterion(&results, "rule", "asami", "variance");
    assert!(
        (best.objective / closed_form - 1.0).abs() < 1e-7,
        "{} {closed_form}",
        best.objective
    );
}

#[test]
fn damped_host_has_optima_that_agree_with_another_optimiser() {
    let results = run(&gallery("tuned-mass-damper.toml"), 3, 2, &["damped host"]);
    let found = sweep_designs(&results, "damped host");
    // For ζ = .01 a bounded CMA-ES on a refined grid of the transfer function gives 5.783765.
    let (at, design) = found[0];
    assert_eq!(*at, 0.01);
    assert!(
        (design.objective - 5.783_765).abs() < 2e-6,
        "{}",
        design.objective
    );
    // More damping of the host leaves a smaller peak.
    assert!(
        found
            .windows(2)
            .all(|pair| pair[1].1.objective < pair[0].1.objective)
    );
}

/// J1 of the quarter car of the gallery with a damper c (N s/m) beside the static spring: 2π√(Vκ)‖s T(z_r → z_s)‖₂ with
/// T from ms zs'' + Z (zs - zu) = 0, mu zu'' + Z (zu - zs) + kt (zu - zr) = 0, Z = K + c s, by Simpson's rule over
/// ω = 40 tan θ (which makes the integrand smooth and periodic-like; doubling the points changes it by less than 1e-9).
fn comfort_of_damper(c: f64) -> f64 {
    let (ms, mu, kt, k) = (250.0, 35.0, 150e3, 60e3);
    let square = |omega: f64| {
        let s = num_complex::Complex64::new(0.0, omega);
        let z = k + c * s;
        let determinant = (ms * s * s + z) * (mu * s * s + z + kt) - z * z;
        (s * z * kt / determinant).norm_sqr()
    };
    let n = 40_000;
    let step = std::f64::consts::FRAC_PI_2 / f64::from(n);
    let integrand = |index: i32| {
        let theta = step * f64::from(index);
        // At θ = π/2 the integrand vanishes, as |s T|² falls with ω⁻⁴.
        if index == n {
            0.0
        } else {
            square(40.0 * theta.tan()) * 40.0 / theta.cos().powi(2)
        }
    };
    let sum: f64 = (0..=n)
        .map(|index| {
            let weight = if index == 0 || index == n {
                1.0
            } else if index % 2 == 1 {
                4.0
            } else {
                2.0
            };
            weight * integrand(index)
        })
        .sum();
    let norm_squared = sum * step / 3.0 / std::f64::consts::PI;
    2.0 * std::f64::consts::PI * (25.0 * 5e-7 * norm_squared).sqrt()
}

#[test]
fn suspension_struts_improve_on_the_damper() {
    let results = run(&gallery("quarter-car.toml"), 2, 2, &["comfort"]);
    let found = designs(&results, "comfort");
    assert_eq!(found.len(), 8);
    let damper = found
        .iter()
        .find(|design| design.devices["suspension"].layout == "c1")
        .unwrap();
    // The damper alone, once more by hand: the integral over the two equations of motion, at the damping found and beside it.
    let c = damper.devices["suspension"].values["c1"];
    let by_hand = comfort_of_damper(c);
    assert!(
        (damper.objective / by_hand - 1.0).abs() < 1e-7,
        "{} {by_hand}",
        damper.objective
    );
    assert!(comfort_of_damper(1.01 * c) > by_hand && comfort_of_damper(0.99 * c) > by_hand);
    let best_with_inerter = &found[0];
    assert!(best_with_inerter.objective < damper.objective);
    assert!(found.iter().all(|design| design.feasible));
    // A network that contains the damper alone as a limit cannot be worse than it, bounds apart.
    let parallel = found
        .iter()
        .find(|design| design.devices["suspension"].layout == "b1 | c1")
        .unwrap();
    assert!(parallel.objective <= damper.objective * (1.0 + 1e-6));
}

/// The three measures of Smith and Wang (2004).
#[derive(Clone, Copy, PartialEq)]
enum Measure {
    /// Ride comfort, m/s².
    J1,
    /// Tyre load, N.
    J3,
    /// Yielding under loads, m/N.
    J5,
}

const SPRUNG: f64 = 250.0;
const UNSPRUNG: f64 = 35.0;
const TYRE: f64 = 150e3;

/// A measure of the quarter car with a static stiffness and a strut beside it, over the two equations of motion.
fn of_strut(
    measure: Measure,
    stiffness: f64,
    layout: &str,
    values: &indexmap::IndexMap<String, f64>,
) -> f64 {
    let of = |name: &str| values.get(name).copied().unwrap_or(f64::NAN);
    let (k, c, b) = (of("k1"), of("c1"), of("b1"));
    let series = |all: &[num_complex::Complex64]| -> num_complex::Complex64 {
        1.0 / all
            .iter()
            .map(|one| 1.0 / one)
            .sum::<num_complex::Complex64>()
    };
    let square = |omega: f64| {
        let s = num_complex::Complex64::new(0.0, omega);
        let (spring, damper, inerter) = (num_complex::Complex64::from(k), c * s, b * s * s);
        let strut = match layout {
            "c1" => damper,
            "k1 + c1" => series(&[spring, damper]),
            "b1 | c1" => inerter + damper,
            "b1 + c1" => series(&[inerter, damper]),
            "k1 + (b1 | c1)" => series(&[spring, inerter + damper]),
            "k1 + b1 + c1" => series(&[spring, inerter, damper]),
            "c1 + (k1 | b1)" => series(&[damper, spring + inerter]),
            "b1 + (k1 | c1)" => series(&[inerter, spring + damper]),
            other => panic!("no strut {other}"),
        };
        let z = stiffness + strut;
        let (body, wheel) = (SPRUNG * s * s + z, UNSPRUNG * s * s + z + TYRE);
        let determinant = body * wheel - z * z;
        match measure {
            Measure::J1 => s * z * TYRE / determinant,
            // kt (zu - zr)/s, with zu/zr - 1 over the common denominator, where nothing cancels.
            Measure::J3 => {
                TYRE * s * (-(SPRUNG + UNSPRUNG) * z - UNSPRUNG * SPRUNG * s * s) / determinant
            }
            Measure::J5 => wheel / determinant,
        }
        .norm_sqr()
    };
    if measure == Measure::J5 {
        // Of 20,000 frequencies to 100 Hz the largest, then thirds between its neighbours.
        let step = std::f64::consts::TAU * 100.0 / 20_000.0;
        let at = (1..=20_000)
            .map(|index| step * f64::from(index))
            .max_by(|one, other| square(*one).total_cmp(&square(*other)))
            .unwrap();
        let (mut low, mut high) = (at - step, at + step);
        for _ in 0..60 {
            let (one, other) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if square(one) < square(other) {
                low = one;
            } else {
                high = other;
            }
        }
        // At rest it yields by both springs in series.
        let at_rest = 1.0 / stiffness + 1.0 / TYRE;
        return square(0.5 * (low + high)).sqrt().max(at_rest);
    }
    // Simpson's rule over ω = 40 tan θ, as above. At θ = 0 the integrand vanishes; at the other end, where dω/dθ = 40/cos² θ, what
    // falls with a/ω leaves a²/40: the tyre load with a = kt, the body's speed where an inerter alone leads from the wheel to it.
    let n = 20_000;
    let step = std::f64::consts::FRAC_PI_2 / f64::from(n);
    let inner: f64 = (1..n)
        .map(|index| {
            let theta = step * f64::from(index);
            let weight = if index % 2 == 1 { 4.0 } else { 2.0 };
            weight * square(40.0 * theta.tan()) * 40.0 / theta.cos().powi(2)
        })
        .sum();
    let falls = match measure {
        Measure::J3 => TYRE,
        _ if layout == "b1 | c1" => b * TYRE / (SPRUNG * UNSPRUNG + b * (SPRUNG + UNSPRUNG)),
        _ => 0.0,
    };
    let norm_squared = (inner + falls * falls / 40.0) * step / 3.0 / std::f64::consts::PI;
    2.0 * std::f64::consts::PI * (25.0 * 5e-7 * norm_squared).sqrt()
}

/// The best damper beside a static stiffness K (Scheibe and Smith 2009), with M = ms + mu:
/// ‖s T(zr → zs)‖² = (M K² + kt c²)/(2 c ms²),
/// ‖T(zr → kt (zu - zr))/s‖² = (kt M² c² + M³ K² - 2 K kt ms mu M + kt² ms² mu)/(2 c ms²); each is least where its two terms
/// in c and 1/c are equal. None for J5.
fn best_damper(measure: Measure, stiffness: f64) -> Option<f64> {
    let total = SPRUNG + UNSPRUNG;
    let (with, without) = match measure {
        Measure::J1 => (TYRE, total * stiffness * stiffness),
        Measure::J3 => (
            TYRE * total * total,
            total.powi(3) * stiffness * stiffness
                - 2.0 * stiffness * TYRE * SPRUNG * UNSPRUNG * total
                + TYRE * TYRE * SPRUNG * SPRUNG * UNSPRUNG,
        ),
        Measure::J5 => return None,
    };
    let norm_squared = (with * without).sqrt() / (SPRUNG * SPRUNG);
    Some(2.0 * std::f64::consts::PI * (25.0 * 5e-7 * norm_squared).sqrt())
}

/// The eight struts of Smith and Wang (2004) over the static stiffness: each value once more by hand, the ranks those of the values by
/// hand, no change of a value by 1 % any better, and the damper's closed form.
fn eight_struts(measure: Measure, task: &str) {
    let results = run(&gallery("quarter-car.toml"), 1, 2, &[task]);
    let TaskBody::Sweep { points } = &results.tasks[task].body else {
        panic!("{task} has no sweep");
    };
    assert_eq!(points.len(), 4);
    for point in points {
        let stiffness = point.at["K"];
        let TaskFindings::Design { designs, .. } = &point.findings else {
            panic!("{task} is no design");
        };
        assert_eq!(designs.len(), 8);
        let mut last = 0.0;
        for design in designs {
            let strut = &design.devices["suspension"];
            let by_hand = of_strut(measure, stiffness, &strut.layout, &strut.values);
            assert!(
                // A peak is certified within 1e-4 from above; a norm is the same integral.
                (design.objective / by_hand - 1.0).abs()
                    < if measure == Measure::J5 { 1e-4 } else { 1e-7 },
                "{}: {} {by_hand}",
                strut.layout,
                design.objective
            );
            assert!(by_hand >= last * (1.0 - 1e-4), "ranks");
            last = by_hand;
            for (name, value) in &strut.values {
                for factor in [0.99, 1.01] {
                    let at_bound = design
                        .active_bounds
                        .iter()
                        .any(|one| one.starts_with(name.as_str()));
                    let mut changed = strut.values.clone();
                    changed.insert(name.clone(), factor * value);
                    let other = of_strut(measure, stiffness, &strut.layout, &changed);
                    // Starts agree within 1e-4 of the best.
                    assert!(
                        at_bound || other >= by_hand * (1.0 - 1e-4),
                        "{} at {stiffness}: {name}",
                        strut.layout
                    );
                }
            }
            if strut.layout == "c1"
                && let Some(closed) = best_damper(measure, stiffness)
            {
                assert!(
                    (design.objective / closed - 1.0).abs() < 1e-4,
                    "{} {closed}",
                    design.objective
                );
            }
        }
    }
}

#[test]
fn eight_struts_for_ride_comfort() {
    eight_struts(Measure::J1, "J1");
}

#[test]
fn eight_struts_for_tyre_load() {
    eight_struts(Measure::J3, "J3");
}

#[test]
fn eight_struts_for_loads_on_the_body() {
    eight_struts(Measure::J5, "J5");
}

#[test]
fn every_study_of_the_gallery_is_sound() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path
            .extension()
            .is_some_and(|extension| extension == "toml")
        {
            let study = Study::read(&path).unwrap_or_else(|fault| panic!("{}", fault.render()));
            quell_study::check(&study).unwrap_or_else(|fault| panic!("{}", fault.render()));
            seen += 1;
        }
    }
    assert!(seen >= 3);
}
