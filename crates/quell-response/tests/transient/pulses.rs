//! Inputs that jump: no step goes over an edge, and none is lost.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

use std::f64::consts::TAU;
use std::sync::Arc;

use quell_document::Source;
use quell_model::HostFile;
use quell_model::system::{Phase, Prepared, System};
use quell_response::transient::{Dynamics, End, Method, Scheme, Settings, Trajectory, simulate};

const FREQUENCY: f64 = 2.0;

/// m x'' + k x = F with m = 2 kg at 2 Hz.
fn oscillator(signal: &str) -> System {
    let text = format!(
        r#"
quell = 1
[parameters]
m = "2 kg"
k = "m*(2 Hz)^2"
[coordinates]
x = {{}}
[inputs]
F = {{ kind = "force", signal = {signal} }}
[equations]
x = "m*x'' + k*x = F"
"#
    );
    let file = HostFile::parse(Arc::new(Source::new("oscillator.toml", text)), ".").unwrap();
    System::new(&file.equations(&[]).unwrap(), &[], &[], Phase::Free).unwrap()
}

fn rectangle(duration: f64) -> System {
    oscillator(&format!(
        "{{ pulse = {{ shape = \"rectangular\", amplitude = \"3 N\", at = \"1.3 s\", duration = \"{duration} s\" }} }}"
    ))
}

/// A rectangle between two times: the response to a step at the first, less that to one at the second.
fn expected(t: f64, first: f64, last: f64) -> f64 {
    let omega = TAU * FREQUENCY;
    let step = |since: f64| {
        if since > 0.0 {
            1.0 - (omega * since).cos()
        } else {
            0.0
        }
    };
    3.0 / (2.0 * omega * omega) * (step(t - first) - step(t - last))
}

/// The same without saying where its input jumps; it may still listen to where a piece ends.
struct Silent<'s> {
    prepared: Prepared<'s>,
    listens: bool,
}

impl Dynamics for Silent<'_> {
    fn states(&self) -> usize {
        Dynamics::states(&self.prepared)
    }
    fn rates(&mut self, t: f64, x: &[f64], rates: &mut [f64]) {
        Dynamics::rates(&mut self.prepared, t, x, rates);
    }
    fn jacobian(&mut self, t: f64, x: &[f64], jacobian: &mut [f64]) {
        Dynamics::jacobian(&mut self.prepared, t, x, jacobian);
    }
    fn within(&mut self, piece: Option<(f64, f64)>) {
        if self.listens {
            Dynamics::within(&mut self.prepared, piece);
        }
    }
}

fn settings(method: Method) -> Settings {
    let mut settings = Settings::with_method(method);
    settings.relative = 1e-10;
    settings
}

fn motion(dynamics: &mut dyn Dynamics, settings: &Settings) -> Trajectory {
    let run = simulate(dynamics, &[0.0; 2], (0.0, 10.0), &[], settings).unwrap();
    assert_eq!(*run.end(), End::Time);
    run
}

/// Ten seconds with a millisecond's pulse and with a second's, by every method. Twenty periods at a relative tolerance of 1e-10
/// a step leave less than 1e-7 of the amplitude, with the implicit methods of order 3 and 5 a little more for their many steps.
/// Left to itself the integrator takes matrix exponentials, since the force is constant from edge to edge: exact to rounding.
#[test]
fn a_rectangle_is_neither_lost_nor_smeared() {
    for duration in [1e-3, 1.0] {
        let system = rectangle(duration);
        let amplitude = (0..1000)
            .map(|i| expected(0.01 * f64::from(i), 1.3, 1.3 + duration).abs())
            .fold(0.0, f64::max);
        for (method, tolerance) in [
            (Method::Automatic, 1e-11),
            (Method::Explicit, 1e-7),
            (Method::StiffOscillating, 1e-6),
            (Method::Stiff, 1e-5),
        ] {
            let mut prepared = system.prepare(&system.defaults());
            assert_eq!(prepared.breakpoints(), [1.3, 1.3 + duration]);
            let run = motion(&mut prepared, &settings(method));
            assert_eq!(run.statistics().restarts, 2);
            if method == Method::Automatic {
                assert_eq!(run.statistics().schemes, [Scheme::Exact]);
            }
            let mut worst = 0.0_f64;
            for i in 0..=2000 {
                let t = 0.005 * f64::from(i);
                let error = run.state(t)[0] - expected(t, 1.3, 1.3 + duration);
                worst = worst.max(error.abs() / amplitude);
            }
            println!(
                "{duration} s, {method:?}: {worst:e} in {} steps",
                run.statistics().steps
            );
            assert!(worst < tolerance, "{duration} s, {method:?}: {worst:e}");
            // A polynomial that covers both sides of an edge would be off right beside it.
            for edge in [1.3, 1.3 + duration] {
                for t in [edge - 1e-6, edge + 1e-6] {
                    let error = run.state(t)[0] - expected(t, 1.3, 1.3 + duration);
                    assert!(error.abs() < tolerance * amplitude);
                }
            }
        }
    }
}

/// Who is not told feels its way to the edges, in no fewer steps, if it gets over them at all; from rest it misses a short pulse
/// altogether.
#[test]
fn restarts_cost_no_steps() {
    let system = rectangle(1.0);
    let mut settings = settings(Method::Explicit);
    let silent = |system| Silent {
        prepared: system,
        listens: false,
    };
    // At 1e-10 the integrator gives up at the edge.
    let span = (0.0, 10.0);
    let mut lost = silent(system.prepare(&system.defaults()));
    let lost = simulate(&mut lost, &[0.0; 2], span, &[], &settings).unwrap();
    assert!(matches!(lost.end(), End::Failed { .. }), "{:?}", lost.end());

    settings.relative = 1e-5;
    let told = motion(&mut system.prepare(&system.defaults()), &settings);
    let untold = motion(&mut silent(system.prepare(&system.defaults())), &settings);
    let costs = |run: &Trajectory| (run.statistics().steps, run.statistics().evaluations);
    let (told, untold) = (costs(&told), costs(&untold));
    println!("{told:?} {untold:?}");
    assert!(
        told.0 <= untold.0 && told.1 <= untold.1,
        "{told:?} {untold:?}"
    );

    let short = rectangle(1e-3);
    let missed = motion(&mut silent(short.prepare(&short.defaults())), &settings);
    assert_eq!(missed.state(5.0)[0], 0.0);
}

/// Times in the settings do the same, to the last bit, for dynamics that do not say where they jump.
#[test]
fn restarts_in_the_settings() {
    let system = rectangle(1e-3);
    let mut settings = settings(Method::Explicit);
    let told = motion(&mut system.prepare(&system.defaults()), &settings);
    settings.restarts = vec![1.3 + 1e-3, 1.3, 20.0];
    let mut listening = Silent {
        prepared: system.prepare(&system.defaults()),
        listens: true,
    };
    let run = motion(&mut listening, &settings);
    assert_eq!(run.statistics(), told.statistics());
    for i in 0..=100 {
        let t = 0.1 * f64::from(i);
        assert_eq!(run.state(t), told.state(t));
    }
}

/// A triangle is the second integral of three steps: ∫∫ of the step response, (s - sin ωs/ω) each.
#[test]
fn corners_of_a_triangle() {
    let system = oscillator(
        "{ pulse = { shape = \"triangular\", amplitude = \"3 N\", at = \"1.3 s\", duration = \"0.4 s\" } }",
    );
    let mut prepared = system.prepare(&system.defaults());
    let run = motion(&mut prepared, &settings(Method::Automatic));
    assert_eq!(run.statistics().restarts, 3);
    let omega = TAU * FREQUENCY;
    let ramp = |since: f64| {
        if since > 0.0 {
            since - (omega * since).sin() / omega
        } else {
            0.0
        }
    };
    let slope = 3.0 / 0.2 / (2.0 * omega * omega);
    for i in 0..=1000 {
        let t = 0.01 * f64::from(i);
        let exact = slope * (ramp(t - 1.3) - 2.0 * ramp(t - 1.5) + ramp(t - 1.7));
        assert!((run.state(t)[0] - exact).abs() < 1e-8 * slope, "{t}");
    }
}
