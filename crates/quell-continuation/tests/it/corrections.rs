//! Both ways of correcting lead to the same branches.

use quell_continuation::{
    Branch, Correction, Kind, Settings, cycle_curve, cycles_from_hopf, equilibria,
};

use crate::support::Exact;
use crate::support::models::{Feedback, Oxidation, Section};

fn by_moore_penrose(settings: &Settings) -> Settings {
    let mut s = settings.clone();
    s.correction = Correction::MoorePenrose;
    s
}

/// Special points are located by the same equations, so they agree to Newton's tolerance of 1e-10, widened by the slope of what is
/// zero there; points in between are others.
#[track_caller]
fn same<S>(a: &Branch<S>, b: &Branch<S>, parameters: impl Fn(&S) -> Vec<f64>) {
    let list = |branch: &Branch<S>| -> Vec<(String, [usize; 2])> {
        let of = branch.special.iter();
        of.map(|s| (s.label.clone(), s.unstable)).collect()
    };
    assert_eq!(list(a), list(b));
    assert_eq!(a.stop, b.stop);
    for (one, other) in a.special.iter().zip(&b.special) {
        for (p, q) in parameters(&one.solution)
            .iter()
            .zip(parameters(&other.solution))
        {
            assert!(
                (p - q).abs() < 1e-7 * (1.0 + p.abs()),
                "{} {p} {q}",
                one.label
            );
        }
    }
    let middle = |branch: &Branch<S>| parameters(&branch.points[branch.points.len() / 2].solution);
    assert_ne!(
        middle(a),
        middle(b),
        "another way of correcting gives other points"
    );
}

#[test]
fn special_points_do_not_depend_on_the_correction() {
    // Folds and Hopf points on a branch with sharp bends.
    let problem = Exact::<_, 3>(Oxidation);
    let s = Settings::new(&[(0.5, 2.0)]);
    let start = [0.001_338_78, 0.833_309, 0.118_109];
    let branch = |s: &Settings| equilibria(&problem, &start, &[2.0, 0.4], 0, s).unwrap();
    let found = branch(&s);
    assert_eq!(found.special.len(), 4);
    same(&found, &branch(&by_moore_penrose(&s)), |e| {
        e.parameters.clone()
    });
    // Cycles with a fold, where one factorisation serves several iterations.
    let problem = Exact::<_, 6>(Section);
    let rest = equilibria(
        &problem,
        &[0.0; 6],
        &[16.0, 5006.7],
        0,
        &Settings::new(&[(16.0, 19.0)]),
    )
    .unwrap();
    let s = Settings::new(&[(12.0, 18.5)]);
    let branch = |s: &Settings| cycles_from_hopf(&problem, rest.of(Kind::Hopf)[0], 0, s).unwrap();
    let found = branch(&s);
    assert_eq!(found.of(Kind::CycleFold).len(), 1);
    same(&found, &branch(&by_moore_penrose(&s)), |o| {
        vec![o.parameters[0], o.period]
    });
    // A curve of period doublings.
    let problem = Exact::<_, 3>(Feedback);
    let s = Settings::new(&[(0.5, 1.2)]);
    let rest = equilibria(&problem, &[0.0; 3], &[1.2, 1.0], 0, &s).unwrap();
    let cycles = cycles_from_hopf(&problem, rest.of(Kind::Hopf)[0], 0, &s).unwrap();
    let s = Settings::new(&[(-0.2, 1.2), (0.4, 2.0)]);
    let curve = |s: &Settings| {
        cycle_curve(&problem, cycles.of(Kind::PeriodDoubling)[0], [0, 1], s).unwrap()
    };
    let found = curve(&s);
    assert_eq!(found.of(Kind::Resonance2).len(), 2);
    same(&found, &curve(&by_moore_penrose(&s)), |o| {
        o.orbit.parameters.clone()
    });
}
