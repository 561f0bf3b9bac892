//! Events, switches, grazing, endings.

#![expect(
    clippy::items_after_statements,
    reason = "a system stands where it is tested"
)]

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use quell_response::transient::{
    Condition, Direction, Dynamics, End, Event, Method, Record, Settings, TransientError, simulate,
    simulate_with,
};

/// x'' = -x from x = 1, so x = cos t; signals x - 1 + level, x', x.
struct Cosine {
    level: f64,
    exact: bool,
}

impl Dynamics for Cosine {
    fn states(&self) -> usize {
        2
    }
    fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
        rates[0] = x[1];
        rates[1] = -x[0];
    }
    fn signals(&self) -> usize {
        3
    }
    fn watch(&mut self, _t: f64, x: &[f64], s: &mut [f64]) {
        s[0] = x[0] - 1.0 + self.level;
        s[1] = x[1];
        s[2] = x[0];
    }
    fn affine(&mut self, _t: f64, _x: &[f64], a: &mut [f64], b: &mut [f64]) -> bool {
        a.copy_from_slice(&[0.0, 1.0, -1.0, 0.0]);
        b.fill(0.0);
        self.exact
    }
}

const START: [f64; 2] = [0.0, 1.0];

#[test]
fn zero_at_the_start_is_no_event() {
    // x' = 0 at t = 0 and falls: neither direction fires there; the next zeros are π (rising) and 2π (falling).
    let mut system = Cosine {
        level: 0.0,
        exact: true,
    };
    let events = [
        Event::on(1, Direction::Rising),
        Event::on(1, Direction::Falling),
        Event::on(1, Direction::Either),
    ];
    let trajectory = simulate(
        &mut system,
        &[1.0, 0.0],
        (0.0, 7.0),
        &events,
        &Settings::default(),
    )
    .unwrap();
    let times = |event| trajectory.times_of(event).collect::<Vec<_>>();
    let close = |found: &[f64], expected: &[f64]| {
        assert_eq!(found.len(), expected.len());
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-11, "{a} {b}");
        }
    };
    close(&times(0), &[PI]);
    close(&times(1), &[TAU]);
    close(&times(2), &[PI, TAU]);
    // A rounding error instead of zero makes no difference.
    let trajectory = simulate(
        &mut system,
        &[1.0, 1e-17],
        (0.0, 7.0),
        &events,
        &Settings::default(),
    )
    .unwrap();
    close(&trajectory.times_of(1).collect::<Vec<_>>(), &[TAU]);
}

#[test]
fn arming_direction_and_order() {
    let mut system = Cosine {
        level: 0.0,
        exact: true,
    };
    // x = sin t here. Falling through 0.5 only after x < -0.5 has been true: in the second period.
    let events = [
        Event::on(2, Direction::Falling).at(0.5),
        Event::on(2, Direction::Falling)
            .at(0.5)
            .armed(Condition::below(2, -0.5)),
        // Two at the same time, the later in the list the ending one.
        Event::on(2, Direction::Falling)
            .at(0.5)
            .armed(Condition::below(2, -0.5))
            .ending(),
        Event::on(2, Direction::Falling)
            .at(0.5)
            .armed(Condition::below(2, -0.9)),
    ];
    let trajectory = simulate(
        &mut system,
        &START,
        (0.0, 100.0),
        &events,
        &Settings::default(),
    )
    .unwrap();
    let first = PI - PI / 6.0;
    let found: Vec<(usize, f64)> = trajectory
        .occurrences()
        .iter()
        .map(|o| (o.event, o.t))
        .collect();
    let expected = [
        (0, first),
        (0, first + TAU),
        (1, first + TAU),
        (2, first + TAU),
        (3, first + TAU),
    ];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!(found.0, expected.0);
        assert!((found.1 - expected.1).abs() < 1e-11);
    }
    assert_eq!(trajectory.end(), &End::Event { event: 2 });
    assert_eq!(trajectory.last(), trajectory.to());
    assert!(!trajectory.ends_grazing());
    assert!(
        trajectory
            .occurrences()
            .iter()
            .all(|occurrence| occurrence.depth > 0.1)
    );
}

#[test]
fn continuation() {
    let mut system = Cosine {
        level: 0.0,
        exact: true,
    };
    let settings = Settings {
        continuation: PI,
        ..Settings::default()
    };
    let events = [
        Event::on(2, Direction::Falling).ending(),
        Event::on(2, Direction::Rising),
    ];
    for exact in [true, false] {
        system.exact = exact;
        let trajectory = simulate(&mut system, &START, (0.0, 100.0), &events, &settings).unwrap();
        assert!((trajectory.to() - PI).abs() < 1e-7);
        assert!((trajectory.last() - TAU).abs() < 1e-7);
        let mut record = Record::new(&trajectory, &mut system);
        assert!(record.minimum(2).value > -1e-7);
        record.between(None, Some(f64::INFINITY));
        assert!((record.minimum(2).value + 1.0).abs() < 1e-7);
    }
}

#[test]
fn grazing() {
    // g = sin t - 1 + level has its maximum `level` at π/2 (and in every period).
    for exact in [true, false] {
        for level in [0.0, 1e-9, -1e-9, 1e-3, -1e-3] {
            let mut system = Cosine { level, exact };
            let settings = Settings {
                relative: 1e-12,
                ..Settings::default()
            };
            let event = Event::on(0, Direction::Either);
            let trajectory =
                simulate(&mut system, &START, (0.0, 6.0), &[event], &settings).unwrap();
            let grazings = trajectory.grazings();
            let times: Vec<f64> = trajectory.times_of(0).collect();
            if level.abs() > 1e-4 {
                assert!(grazings.is_empty(), "{exact} {level}: {grazings:?}");
                assert_eq!(times.len(), if level > 0.0 { 2 } else { 0 });
                continue;
            }
            assert_eq!(grazings.len(), 1, "{exact} {level}");
            assert!((grazings[0].t - PI / 2.0).abs() < 1e-4);
            // The largest |g| is 2.
            assert!(
                (grazings[0].margin - level.abs() / 2.0).abs() < 1e-10,
                "{grazings:?}"
            );
            if level > 0.0 {
                // sin t = 1 - level at π/2 ± √(2 level).
                assert_eq!(times.len(), 2);
                let half = (2.0 * level).sqrt();
                assert!((times[1] - times[0] - 2.0 * half).abs() < 0.02 * half);
                assert!(grazings[0].crossed && trajectory.occurrences()[0].grazing);
                assert!((trajectory.occurrences()[0].depth / (level / 2.0) - 1.0).abs() < 0.05);
            } else if level < 0.0 {
                assert!(times.is_empty() && !grazings[0].crossed);
            }
        }
    }
}

#[test]
fn an_end_that_grazes_says_so() {
    let mut system = Cosine {
        level: 1e-9,
        exact: true,
    };
    let event = Event::on(0, Direction::Rising).ending();
    let trajectory = simulate(
        &mut system,
        &START,
        (0.0, 6.0),
        &[event],
        &Settings::default(),
    )
    .unwrap();
    assert_eq!(trajectory.end(), &End::Event { event: 0 });
    assert!(trajectory.ends_grazing());
}

/// A ball on a ground that is a stiff spring: x'' = -g, with - k x/m while x < 0. Signals x, x'.
struct Ball {
    stiffness: f64,
    exact: bool,
}

impl Dynamics for Ball {
    fn states(&self) -> usize {
        2
    }
    fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
        rates[0] = x[1];
        rates[1] = -9.81 - self.stiffness * x[0].min(0.0);
    }
    fn signals(&self) -> usize {
        2
    }
    fn watch(&mut self, _t: f64, x: &[f64], s: &mut [f64]) {
        s.copy_from_slice(x);
    }
    fn switches(&self) -> usize {
        1
    }
    fn switch_values(&mut self, _t: f64, x: &[f64], values: &mut [f64]) {
        values[0] = x[0];
    }
    fn affine(&mut self, _t: f64, x: &[f64], a: &mut [f64], b: &mut [f64]) -> bool {
        let k = if x[0] < 0.0 { self.stiffness } else { 0.0 };
        a.copy_from_slice(&[0.0, 1.0, -k, 0.0]);
        b.copy_from_slice(&[0.0, -9.81]);
        self.exact
    }
}

#[test]
fn bouncing_ball() {
    let (g, k, height) = (9.81_f64, 1e6_f64, 1.0_f64);
    let w = k.sqrt();
    let fall = (2.0 * height / g).sqrt();
    let speed = (2.0 * g * height).sqrt();
    // In contact x = (g/w²)(cos wt - 1) - (v/w) sin wt, so x = 0 again at tan(wt/2) = -v w/g.
    let contact = 2.0 * (PI - (speed * w / g).atan()) / w;
    // The elastic bounce repeats with the period 2 fall + contact.
    for (exact, tolerance) in [(true, 1e-11), (false, 1e-7)] {
        let mut ball = Ball {
            stiffness: k,
            exact,
        };
        let events = [
            Event::on(0, Direction::Falling),
            Event::on(0, Direction::Rising),
        ];
        let settings = Settings {
            relative: 1e-10,
            ..Settings::default()
        };
        let trajectory =
            simulate(&mut ball, &[height, 0.0], (0.0, 5.0), &events, &settings).unwrap();
        let downs: Vec<f64> = trajectory.times_of(0).collect();
        let ups: Vec<f64> = trajectory.times_of(1).collect();
        assert_eq!((downs.len(), ups.len()), (6, 6));
        for (n, (down, up)) in (0..).zip(downs.iter().zip(&ups)) {
            let expected = fall + f64::from(n) * (2.0 * fall + contact);
            assert!(
                (down - expected).abs() < tolerance,
                "{exact} {n}: {down} {expected}"
            );
            assert!((up - expected - contact).abs() < tolerance);
        }
        let mut record = Record::new(&trajectory, &mut ball);
        // Deepest: m g h' = k x²/2 with h' = height + |x|.
        let deepest = -(g / k) * (1.0 + (1.0 + 2.0 * height * k / g).sqrt());
        let found = record.minimum(0).value;
        assert!((found - deepest).abs() < 1e-9, "{found} {deepest}");
        assert_eq!(record.peaks(0).len(), 5);
        for peak in record.peaks(0) {
            assert!(
                (peak.value - height).abs() < 10.0 * tolerance,
                "{exact} {peak:?}"
            );
        }
    }
}

/// x' = v, v' = -sign(v) μ + a: dry friction with a jump, from a sliding start. Exact until it stops.
struct Jump {
    exact: bool,
}

impl Dynamics for Jump {
    fn states(&self) -> usize {
        2
    }
    fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
        // A push of 3 up to x = 1, a pull of -5 beyond: passed through, not slid along.
        rates[0] = x[1];
        rates[1] = if x[0] < 1.0 { 3.0 } else { -5.0 };
    }
    fn switches(&self) -> usize {
        1
    }
    fn switch_values(&mut self, _t: f64, x: &[f64], values: &mut [f64]) {
        values[0] = x[0] - 1.0;
    }
    fn affine(&mut self, _t: f64, x: &[f64], a: &mut [f64], b: &mut [f64]) -> bool {
        a.copy_from_slice(&[0.0, 1.0, 0.0, 0.0]);
        b.copy_from_slice(&[0.0, if x[0] < 1.0 { 3.0 } else { -5.0 }]);
        self.exact
    }
}

#[test]
fn jump_of_the_rates() {
    // From x = 0, v = 0: t1 = √(2/3), v1 = √6; beyond, up and down again in 2 v1/5; then the mirror image of the start.
    let t1 = (2.0_f64 / 3.0).sqrt();
    let v1 = 6.0_f64.sqrt();
    let back = t1 + 2.0 * v1 / 5.0;
    for exact in [true, false] {
        let mut system = Jump { exact };
        let trajectory = simulate(
            &mut system,
            &[0.0, 0.0],
            (0.0, 2.0),
            &[],
            &Settings::default(),
        )
        .unwrap();
        assert_eq!(
            trajectory.statistics().restarts,
            2,
            "{exact} {:?} {:?}",
            trajectory.end(),
            trajectory.step_times().take(9).collect::<Vec<_>>()
        );
        for i in 0..=200 {
            let t = 0.01 * f64::from(i);
            let x = if t < t1 {
                1.5 * t * t
            } else if t < back {
                1.0 + v1 * (t - t1) - 2.5 * (t - t1).powi(2)
            } else {
                1.0 - v1 * (t - back) + 1.5 * (t - back).powi(2)
            };
            let found = trajectory.state(t)[0];
            // The rates are polynomials: nothing but the location of the jumps is approximate.
            assert!((found - x).abs() < 1e-11, "{exact} {t}: {found} {x}");
        }
    }
}

#[test]
fn sliding_is_chattering() {
    // x' = -sign(x): nothing goes through x = 0.
    struct Sign(bool);
    impl Dynamics for Sign {
        fn states(&self) -> usize {
            1
        }
        fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
            rates[0] = if x[0] > 0.0 { -1.0 } else { 1.0 };
        }
        fn switches(&self) -> usize {
            1
        }
        fn switch_values(&mut self, _t: f64, x: &[f64], values: &mut [f64]) {
            values[0] = x[0];
        }
        fn affine(&mut self, _t: f64, x: &[f64], a: &mut [f64], b: &mut [f64]) -> bool {
            a[0] = 0.0;
            b[0] = if x[0] > 0.0 { -1.0 } else { 1.0 };
            self.0
        }
    }
    for exact in [true, false] {
        let trajectory = simulate(
            &mut Sign(exact),
            &[0.5],
            (0.0, 2.0),
            &[],
            &Settings::default(),
        )
        .unwrap();
        assert_eq!(
            trajectory.end(),
            &End::Chattering { switch: 0 },
            "{exact} {:?}",
            trajectory.step_times().take(9).collect::<Vec<_>>()
        );
        assert!((trajectory.to() - 0.5).abs() < 1e-6, "{}", trajectory.to());
        assert!(!trajectory.end().is_regular());
    }
}

#[test]
fn endings_are_values() {
    // x' = x² blows up at t = 1.
    struct Blow;
    impl Dynamics for Blow {
        fn states(&self) -> usize {
            1
        }
        fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
            rates[0] = x[0] * x[0];
        }
    }
    let trajectory = simulate(&mut Blow, &[1.0], (0.0, 2.0), &[], &Settings::default()).unwrap();
    assert_eq!(trajectory.end(), &End::Diverged);
    assert!((trajectory.to() - 1.0).abs() < 1e-3, "{}", trajectory.to());
    // Rates that stop being numbers.
    struct Root;
    impl Dynamics for Root {
        fn states(&self) -> usize {
            1
        }
        fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
            rates[0] = -1.0 - x[0].sqrt();
        }
    }
    for method in [Method::Explicit, Method::Stiff, Method::StiffOscillating] {
        let trajectory = simulate(
            &mut Root,
            &[1.0],
            (0.0, 2.0),
            &[],
            &Settings::with_method(method),
        )
        .unwrap();
        assert!(
            matches!(trajectory.end(), End::Diverged | End::Failed { .. }),
            "{method:?} {:?}",
            trajectory.end()
        );
    }
    // An exact one that grows.
    struct Grow;
    impl Dynamics for Grow {
        fn states(&self) -> usize {
            1
        }
        fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
            rates[0] = x[0];
        }
        fn affine(&mut self, _t: f64, _x: &[f64], a: &mut [f64], b: &mut [f64]) -> bool {
            a[0] = 1.0;
            b[0] = 0.0;
            true
        }
    }
    let trajectory = simulate(&mut Grow, &[1.0], (0.0, 1e4), &[], &Settings::default()).unwrap();
    assert_eq!(trajectory.end(), &End::Diverged);
    // Steps and cancelling.
    let mut system = Cosine {
        level: 0.0,
        exact: false,
    };
    let settings = Settings {
        step_limit: 10,
        ..Settings::default()
    };
    let trajectory = simulate(&mut system, &START, (0.0, 100.0), &[], &settings).unwrap();
    assert_eq!(
        (trajectory.end(), trajectory.statistics().steps),
        (&End::StepLimit, 10)
    );
    let mut seen = Vec::new();
    let trajectory = simulate_with(
        &mut system,
        &START,
        (0.0, 100.0),
        &[],
        &Settings::default(),
        &mut |progress| {
            seen.push(progress.fraction);
            if progress.fraction > 0.1 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        },
    )
    .unwrap();
    assert_eq!(trajectory.end(), &End::Cancelled);
    assert!(seen.windows(2).all(|pair| pair[0] < pair[1]) && trajectory.to() < 20.0);
}

#[test]
fn wrong_arguments_are_errors() {
    let mut system = Cosine {
        level: 0.0,
        exact: true,
    };
    let settings = Settings::default();
    let error = |start: &[f64], span, events: &[Event], settings: &Settings| {
        simulate(
            &mut Cosine {
                level: 0.0,
                exact: true,
            },
            start,
            span,
            events,
            settings,
        )
        .unwrap_err()
    };
    assert_eq!(
        simulate(&mut system, &[1.0], (0.0, 1.0), &[], &settings)
            .unwrap_err()
            .to_string(),
        "1 start values were given for a system of 2 states"
    );
    assert!(matches!(
        error(&[1.0, f64::NAN], (0.0, 1.0), &[], &settings),
        TransientError::StartValue { state: 1, .. }
    ));
    assert!(matches!(
        error(&START, (1.0, 1.0), &[], &settings),
        TransientError::Span { .. }
    ));
    let event = Event::on(3, Direction::Either);
    assert_eq!(
        error(&START, (0.0, 1.0), &[event], &settings).to_string(),
        "event 0 reads signal 3, but the system has 3 signals"
    );
    let mut settings = settings;
    settings.relative = 0.0;
    assert_eq!(
        error(&START, (0.0, 1.0), &[], &settings).to_string(),
        "setting `relative` is `0`; it must be positive"
    );
}

#[test]
fn runs_are_deterministic_and_phases_join() {
    let mut system = Cosine {
        level: 0.0,
        exact: false,
    };
    let run = |system: &mut Cosine| {
        simulate(
            system,
            &START,
            (0.0, 10.0),
            &[Event::on(2, Direction::Either)],
            &Settings::default(),
        )
        .unwrap()
    };
    assert_eq!(run(&mut system), run(&mut system));

    // sin t in two phases: to its first zero, and on from there.
    let mut first_system = Cosine {
        level: 0.0,
        exact: true,
    };
    let mut second_system = Cosine {
        level: 0.0,
        exact: true,
    };
    let first = simulate(
        &mut first_system,
        &START,
        (0.0, 10.0),
        &[Event::on(2, Direction::Falling).ending()],
        &Settings::default(),
    )
    .unwrap();
    let second = simulate(
        &mut second_system,
        &first.end_state(),
        (first.to(), 10.0),
        &[],
        &Settings::default(),
    )
    .unwrap();
    let mut record = Record::new(&first, &mut first_system).then(&second, &mut second_system);
    assert_eq!(record.window(), (0.0, 10.0));
    assert!((record.integral(2).value - (1.0 - 10.0_f64.cos())).abs() < 1e-11);
    assert_eq!(record.peaks(2).len(), 2);
    assert_eq!(record.crossings(2, 0.0, Direction::Either).len(), 3);
    assert!((record.value(2, 4.0) - 4.0_f64.sin()).abs() < 1e-12);
}
