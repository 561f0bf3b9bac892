//! Oscillators with closed forms or published figures.

#![expect(
    clippy::items_after_statements,
    reason = "a system stands where it is tested"
)]

use std::f64::consts::{PI, TAU};

use quell_response::transient::{
    Absolute, Condition, Direction, Dynamics, End, Event, Method, Record, Scheme, Settings,
    simulate,
};

/// x'' + 2 ζ x' + x = a cos(w t); signals x, x', energy, x'².
struct Linear {
    zeta: f64,
    force: f64,
    frequency: f64,
}

impl Dynamics for Linear {
    fn states(&self) -> usize {
        2
    }
    fn rates(&mut self, t: f64, x: &[f64], rates: &mut [f64]) {
        rates[0] = x[1];
        rates[1] = self.force * (self.frequency * t).cos() - x[0] - 2.0 * self.zeta * x[1];
    }
    fn signals(&self) -> usize {
        4
    }
    fn watch(&mut self, _t: f64, x: &[f64], s: &mut [f64]) {
        s[0] = x[0];
        s[1] = x[1];
        s[2] = 0.5 * (x[0] * x[0] + x[1] * x[1]);
        s[3] = x[1] * x[1];
    }
    fn affine(&mut self, _t: f64, _x: &[f64], a: &mut [f64], b: &mut [f64]) -> bool {
        a.copy_from_slice(&[0.0, 1.0, -1.0, -2.0 * self.zeta]);
        b.fill(0.0);
        self.force == 0.0
    }
}

fn tight(method: Method) -> Settings {
    let mut settings = Settings::with_method(method);
    settings.relative = 1e-11;
    settings.absolute = Absolute::All(1e-13);
    settings
}

#[test]
fn free_vibration() {
    let zeta: f64 = 0.05;
    let damped = (1.0 - zeta * zeta).sqrt();
    let exact =
        |t: f64| (-zeta * t).exp() * ((damped * t).cos() + zeta / damped * (damped * t).sin());
    let mut system = Linear {
        zeta,
        force: 0.0,
        frequency: 0.0,
    };
    // Exact propagation resolves each step to 1e-13 of the largest state; the integrators are asked for 1e-11 a step.
    for (method, tolerance) in [
        (Method::Automatic, 2e-12),
        (Method::Explicit, 1e-9),
        (Method::Stiff, 1e-7),
        (Method::StiffOscillating, 1e-8),
    ] {
        let trajectory =
            simulate(&mut system, &[1.0, 0.0], (0.0, 40.0), &[], &tight(method)).unwrap();
        assert_eq!(trajectory.end(), &End::Time);
        assert_eq!(trajectory.to(), 40.0);
        for i in 0..=400 {
            let t = 0.1 * f64::from(i);
            let x = trajectory.state(t)[0];
            assert!(
                (x - exact(t)).abs() < tolerance,
                "{method:?} {t}: {x} {}",
                exact(t)
            );
        }
        let mut record = Record::new(&trajectory, &mut system);
        // Peaks of the free decay: exp(-ζ t) at t = 2π n/√(1-ζ²), n = 1 … 6.
        let peaks = record.peaks(0);
        assert_eq!(peaks.len(), 6);
        for (n, peak) in (1..).zip(&peaks) {
            let t = TAU * f64::from(n) / damped;
            assert!((peak.value - (-zeta * t).exp()).abs() < tolerance);
            assert!((peak.t - t).abs() < 1e-4);
        }
        assert_eq!(record.peak(0, 3), Some(peaks[2]));
        assert_eq!((record.peak(0, 0), record.peak(0, 7)), (None, None));
        // 2 ζ ∫ x'² dt is the energy lost.
        let lost = 2.0 * zeta * record.integral(3).value;
        let left = record.value(2, 40.0);
        assert!(
            (lost + left - 0.5).abs() < tolerance,
            "{}",
            lost + left - 0.5
        );
        // ∫ x dx = x²/2.
        let over = record.integral_over(0, 0);
        let exact_over = 0.5 * (record.value(0, 40.0).powi(2) - 1.0);
        assert!((over.value - exact_over).abs() < tolerance);
        // The last time that |x| = 0.1 by bisection of the closed form between the peaks around it.
        let settled = record.settling(0, 0.0, 0.1).unwrap();
        let mut last = 0.0;
        let mut t = 0.0;
        while t < 40.0 {
            if exact(t).abs() > 0.1 {
                last = t;
            }
            t += 1e-3;
        }
        let (mut a, mut b) = (last, last + 1e-3);
        for _ in 0..60 {
            let middle = 0.5 * (a + b);
            if exact(middle).abs() > 0.1 {
                a = middle;
            } else {
                b = middle;
            }
        }
        assert!((settled - a).abs() < 1e-6, "{settled} {a}");
        assert_eq!(record.settling(0, 0.0, 1e-9), None);
        // Decaying peaks are ranked as they come, and their logarithms lie on a line of slope -ζ.
        assert_eq!(record.ranked_peak(0, 2), Some(peaks[1]));
        assert_eq!(
            (record.ranked_peak(0, 0), record.ranked_peak(0, 7)),
            (None, None)
        );
        let rate = record.decay_rate(0).unwrap();
        assert!((rate - zeta).abs() < 1e-4, "{rate}");
        // Beyond the band of settling: the last stretch ends when it has settled, on whichever side.
        let beyond = record.departures(0, 0.0, 0.1);
        assert!(
            beyond
                .iter()
                .all(|stretch| !stretch.cut && stretch.from < stretch.to)
        );
        assert!((beyond.last().unwrap().to - settled).abs() < 1e-9);
        for stretch in &beyond[1..] {
            let n = (stretch.extreme.t * damped / (TAU / 2.0)).round();
            let size = (-zeta * n * TAU / 2.0 / damped).exp();
            assert!((stretch.extreme.value.abs() - size).abs() < 10.0 * tolerance);
        }
        let last = record.departures(0, 0.0, 1e-9);
        assert!(last.last().unwrap().cut);
        assert_eq!(record.settling(0, 0.0, 2.0), Some(0.0));
    }
}

#[test]
fn forced_vibration() {
    // At rest at the start: x = (cos w t - cos t)/(1 - w²) without damping.
    let w: f64 = 1.3;
    let exact = |t: f64| ((w * t).cos() - t.cos()) / (1.0 - w * w);
    let mut system = Linear {
        zeta: 0.0,
        force: 1.0,
        frequency: w,
    };
    let trajectory = simulate(
        &mut system,
        &[0.0, 0.0],
        (0.0, 30.0),
        &[],
        &tight(Method::Automatic),
    )
    .unwrap();
    assert_eq!(trajectory.statistics().schemes, [Scheme::Tsit45]);
    for i in 0..300 {
        let t = 0.1 * f64::from(i);
        assert!((trajectory.state(t)[0] - exact(t)).abs() < 1e-8);
    }
}

#[test]
fn windows_and_conditions() {
    // x = cos t over two periods, exactly propagated.
    let mut system = Linear {
        zeta: 0.0,
        force: 0.0,
        frequency: 0.0,
    };
    let trajectory = simulate(
        &mut system,
        &[1.0, 0.0],
        (0.0, 2.0 * TAU),
        &[],
        &Settings::default(),
    )
    .unwrap();
    let mut record = Record::new(&trajectory, &mut system);
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-11, "{a} {b}");
    assert_eq!(record.window(), (0.0, 2.0 * TAU));
    close(record.rms(0), 0.5_f64.sqrt());
    close(record.mean(0), 0.0);
    close(record.first(Condition::below(0, 0.5)).unwrap(), PI / 3.0);
    close(
        record.last(Condition::below(0, 0.5)).unwrap(),
        2.0 * TAU - PI / 3.0,
    );
    close(record.duration(Condition::above(0, 0.5)), 4.0 * PI / 3.0);
    assert_eq!(record.first(Condition::above(0, 1.5)), None);
    assert_eq!(record.first(Condition::above(0, 0.9)), Some(0.0));
    let zeros = record.crossings(0, 0.0, Direction::Falling);
    assert_eq!(zeros.len(), 2);
    close(zeros[0], PI / 2.0);
    close(zeros[1], 2.5 * PI);
    assert_eq!(record.troughs(0).len(), 2);
    assert_eq!(record.peaks(0).len(), 1);
    // A window cuts steps; its ends count for extrema.
    record.between(Some(1.0), Some(2.0));
    close(record.maximum(0).value, 1.0_f64.cos());
    assert_eq!(record.maximum(0).t, 1.0);
    close(record.minimum(0).value, 2.0_f64.cos());
    close(record.integral(0).value, 2.0_f64.sin() - 1.0_f64.sin());
    assert_eq!(record.largest(0).value, record.maximum(0).value);
    // An empty window has a value and no integral.
    record.between(Some(1.0), Some(1.0));
    close(record.maximum(0).value, 1.0_f64.cos());
    assert_eq!(record.integral(0).value, 0.0);
    close(record.mean(0), 1.0_f64.cos());
    // A signal that does not exist.
    assert!(record.value(17, 1.0).is_nan());
    assert!(record.maximum(17).value.is_nan());
}

#[test]
fn energy_is_conserved() {
    // Exact propagation over 1000 periods: 6e3 radians times rounding.
    let mut system = Linear {
        zeta: 0.0,
        force: 0.0,
        frequency: 0.0,
    };
    let trajectory = simulate(
        &mut system,
        &[1.0, 0.0],
        (0.0, 1000.0 * TAU),
        &[],
        &Settings::default(),
    )
    .unwrap();
    let x = trajectory.end_state();
    assert!((x[0] - 1.0).abs() < 1e-11 && x[1].abs() < 1e-10, "{x:?}");

    // A pendulum of large amplitude: its period is 4 K(sin θ/2) = 8.349842… for θ = 2 (arithmetic-geometric mean).
    struct Pendulum;
    impl Dynamics for Pendulum {
        fn states(&self) -> usize {
            2
        }
        fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
            rates[0] = x[1];
            rates[1] = -x[0].sin();
        }
        fn signals(&self) -> usize {
            2
        }
        fn watch(&mut self, _t: f64, x: &[f64], s: &mut [f64]) {
            s[0] = 0.5 * x[1] * x[1] - x[0].cos();
            s[1] = x[1];
        }
    }
    let (mut a, mut b) = (1.0_f64, 1.0_f64.cos());
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    let period = TAU / a;
    let event = Event::on(1, Direction::Falling)
        .armed(Condition::above(1, 0.0))
        .ending();
    let trajectory = simulate(
        &mut Pendulum,
        &[2.0, 0.0],
        (0.0, 100.0),
        &[event],
        &tight(Method::Automatic),
    )
    .unwrap();
    assert!(
        (trajectory.to() - period).abs() < 1e-9,
        "{} {period}",
        trajectory.to()
    );
    let mut system = Pendulum;
    let mut record = Record::new(&trajectory, &mut system);
    let (low, high) = (record.minimum(0).value, record.maximum(0).value);
    assert!(high - low < 1e-8, "{}", high - low);
}

/// x'' - mu (1 - x²) x' + x = 0; signals x, x'.
struct VanDerPol(f64);

impl Dynamics for VanDerPol {
    fn states(&self) -> usize {
        2
    }
    fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
        rates[0] = x[1];
        rates[1] = self.0 * (1.0 - x[0] * x[0]) * x[1] - x[0];
    }
    fn jacobian(&mut self, _t: f64, x: &[f64], jacobian: &mut [f64]) {
        jacobian.copy_from_slice(&[
            0.0,
            1.0,
            -2.0 * self.0 * x[0] * x[1] - 1.0,
            self.0 * (1.0 - x[0] * x[0]),
        ]);
    }
    fn signals(&self) -> usize {
        2
    }
    fn watch(&mut self, _t: f64, x: &[f64], s: &mut [f64]) {
        s.copy_from_slice(x);
    }
}

#[test]
fn van_der_pol() {
    for (mu, period) in [
        (1.0, 6.663_286_859_3),
        (5.0, 11.612_230_667_7),
        (10.0, 19.078_369_566_9),
    ] {
        let peak = Event::on(1, Direction::Falling);
        let trajectory = simulate(
            &mut VanDerPol(mu),
            &[2.0, 0.0],
            (0.0, 20.0 * period),
            &[peak],
            &tight(Method::Automatic),
        )
        .unwrap();
        let times: Vec<f64> = trajectory.times_of(0).collect();
        // Eight periods after the transient has died out; a relative 1e-11 a step leaves 3e-10 at the strongest relaxation.
        let found = (times[18] - times[10]) / 8.0;
        assert!(
            (found / period - 1.0).abs() < 5e-10,
            "{mu}: {found} {period}"
        );
        if mu == 1.0 {
            let mut system = VanDerPol(mu);
            let mut record = Record::new(&trajectory, &mut system);
            record.between(Some(times[10]), Some(times[18]));
            let amplitude = record.maximum(0).value;
            assert!((amplitude - 2.008_619_860_9).abs() < 1e-9, "{amplitude}");
        }
    }
}

#[test]
fn stiffness_is_noticed() {
    // At the start already.
    let event = Event::on(0, Direction::Falling).ending();
    let trajectory = simulate(
        &mut VanDerPol(1000.0),
        &[2.0, 0.0],
        (0.0, 2000.0),
        &[event],
        &Settings::default(),
    )
    .unwrap();
    assert_eq!(trajectory.statistics().schemes, [Scheme::Bdf]);
    // Three codes of SciPy give 807.08434 to 807.08474.
    assert!(
        (trajectory.to() - 807.0845).abs() < 4e-4,
        "{}",
        trajectory.to()
    );
    // On the way: from near the unstable equilibrium.
    let trajectory = simulate(
        &mut VanDerPol(100.0),
        &[1e-3, 0.0],
        (0.0, 300.0),
        &[],
        &Settings::default(),
    )
    .unwrap();
    assert_eq!(
        trajectory.statistics().schemes,
        [Scheme::Tsit45, Scheme::Bdf]
    );
    assert!(
        trajectory.statistics().steps < 8000,
        "{:?}",
        trajectory.statistics()
    );
}

#[test]
fn robertson() {
    struct Robertson;
    impl Dynamics for Robertson {
        fn states(&self) -> usize {
            3
        }
        fn rates(&mut self, _t: f64, y: &[f64], rates: &mut [f64]) {
            rates[0] = -0.04 * y[0] + 1e4 * y[1] * y[2];
            rates[2] = 3e7 * y[1] * y[1];
            rates[1] = -rates[0] - rates[2];
        }
    }
    // The Jacobian is the provided one, by differences.
    let settings = Settings {
        absolute: Absolute::Each(vec![1e-12, 1e-16, 1e-12]),
        ..Settings::default()
    };
    let trajectory =
        simulate(&mut Robertson, &[1.0, 0.0, 0.0], (0.0, 1e5), &[], &settings).unwrap();
    // Nothing is stiff before y_2 has grown.
    assert_eq!(trajectory.statistics().schemes.last(), Some(&Scheme::Bdf));
    let y = trajectory.end_state();
    // Reference to seven digits: 0.01786592 (LSODA, Radau and BDF of SciPy alike).
    assert!((y[0] - 0.017_865_92).abs() < 5e-8, "{y:?}");
    assert!((y[0] + y[1] + y[2] - 1.0).abs() < 1e-9);
}

#[test]
fn stiff_and_exact() {
    // x' = -1e6 (x - y), y' = -y: the ladder climbs over six decades; the slow part is resolved with few steps.
    struct Fast;
    impl Dynamics for Fast {
        fn states(&self) -> usize {
            2
        }
        fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
            rates[0] = -1e6 * (x[0] - x[1]);
            rates[1] = -x[1];
        }
        fn affine(&mut self, _t: f64, _x: &[f64], a: &mut [f64], b: &mut [f64]) -> bool {
            a.copy_from_slice(&[-1e6, 1e6, 0.0, -1.0]);
            b.fill(0.0);
            true
        }
    }
    let trajectory = simulate(
        &mut Fast,
        &[0.0, 1.0],
        (0.0, 5.0),
        &[],
        &Settings::default(),
    )
    .unwrap();
    let exact = |t: f64| ((-t).exp() - (-1e6 * t).exp()) / (1.0 - 1e-6);
    for t in [1e-8, 1e-7, 1e-6, 1e-5, 1e-3, 0.1, 1.0, 5.0] {
        let x = trajectory.state(t)[0];
        assert!((x - exact(t)).abs() < 1e-10, "{t}: {x} {}", exact(t));
    }
    assert!(
        trajectory.statistics().steps < 60,
        "{:?}",
        trajectory.statistics()
    );
}

#[test]
fn constant_force() {
    // Free fall: the matrix is nilpotent, ‖A‖ says nothing of the scale; x = v t - g t²/2.
    struct Fall;
    impl Dynamics for Fall {
        fn states(&self) -> usize {
            2
        }
        fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
            rates[0] = x[1];
            rates[1] = -9.81;
        }
        fn signals(&self) -> usize {
            1
        }
        fn watch(&mut self, _t: f64, x: &[f64], s: &mut [f64]) {
            s[0] = x[0];
        }
        fn affine(&mut self, _t: f64, _x: &[f64], a: &mut [f64], b: &mut [f64]) -> bool {
            a.copy_from_slice(&[0.0, 1.0, 0.0, 0.0]);
            b.copy_from_slice(&[0.0, -9.81]);
            true
        }
    }
    let event = Event::on(0, Direction::Falling).ending();
    let trajectory = simulate(
        &mut Fall,
        &[0.0, 3.0],
        (0.0, 100.0),
        &[event],
        &Settings::default(),
    )
    .unwrap();
    assert!((trajectory.to() - 6.0 / 9.81).abs() < 1e-13);
    let mut system = Fall;
    let mut record = Record::new(&trajectory, &mut system);
    assert!((record.maximum(0).value - 4.5 / 9.81).abs() < 1e-14);
}
