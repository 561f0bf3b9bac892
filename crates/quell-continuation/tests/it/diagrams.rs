//! Automatic diagrams.

use crate::support::models::*;
use crate::support::{Exact, Field, Real};
use quell_continuation::{
    DiagramSettings, Kind, Settings, Stop, diagram, equilibria, equilibria_across,
};

#[test]
fn lorenz_without_a_start() {
    let problem = Exact::<_, 3>(Lorenz);
    let mut branch = Settings::new(&[(0.0, 30.0)]);
    branch.period_bound = 5.0;
    let s = DiagramSettings {
        branch,
        states: vec![(-10.0, 10.0), (-10.0, 10.0), (-5.0, 30.0)],
        starts: 12,
        depth: 2,
    };
    let d = diagram(&problem, &[0.0], 0, &s).unwrap();
    let count = |kind: Kind| {
        d.equilibria
            .iter()
            .map(|m| m.branch.of(kind).len())
            .sum::<usize>()
    };
    let summary: Vec<_> = d
        .equilibria
        .iter()
        .map(|m| {
            (
                m.name.clone(),
                m.parent.clone(),
                m.branch.stop,
                m.branch
                    .special
                    .iter()
                    .map(|s| s.label.clone())
                    .collect::<Vec<_>>(),
            )
        })
        .collect();
    // The origin, and of the two branches from its pitchfork one: x, y -> -x, -y changes nothing.
    assert!(d.mirrored);
    assert_eq!(count(Kind::Hopf), 1, "{summary:?}");
    assert_eq!(d.equilibria.len(), 2, "{summary:?}");
    let parent = Some(("E1".to_owned(), "BP1".to_owned()));
    assert_eq!(d.equilibria[1].parent, parent, "{summary:?}");
    assert_eq!(d.cycles.len(), 1);
    assert!(d.failed.is_empty(), "{:?}", d.failed);
}

#[test]
fn mirror_images_are_counted_once() {
    let problem = Exact::<_, 3>(Electronic);
    let s = DiagramSettings {
        branch: Settings {
            period_bound: 20.0,
            ..Settings::new(&[(-0.9, -0.3)])
        },
        states: vec![(-1.0, 1.0); 3],
        starts: 10,
        depth: 2,
    };
    let d = diagram(&problem, &[-0.9], 0, &s).unwrap();
    assert!(d.mirrored);
    let names: Vec<_> = d.equilibria.iter().map(|m| (&m.name, &m.parent)).collect();
    assert_eq!(d.equilibria.len(), 2, "{names:?}");
    // The other branch is one half of what leaves the pitchfork, which is no fold.
    let [rest, bent] = &d.equilibria[..] else {
        unreachable!("there are two");
    };
    let pitchfork = rest.branch.of(Kind::BranchPoint)[0];
    assert!((pitchfork.solution.parameters[0] + 0.5).abs() < 1e-6);
    assert_eq!(
        bent.parent,
        Some((rest.name.clone(), pitchfork.label.clone()))
    );
    assert!(bent.branch.of(Kind::Fold).is_empty());
    assert!(
        d.cycles
            .iter()
            .any(|c| !c.branch.of(Kind::CycleFold).is_empty())
    );
}

/// x'' = p (x - c) - (x - c)³ + x' (½ - (x - c)²): rest at c ± √p loses its stability at p = ½ on either side, to cycles that are mirror
/// images of each other about c.
struct TwoWells(f64);
impl Field for TwoWells {
    const N: usize = 2;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let from = x[0] - R::from(self.0);
        out[0] = x[1];
        out[1] = p[0] * from - from.cube() + x[1] * (R::from(0.5) - from.square());
    }
}

#[test]
fn of_mirrored_cycles_one_is_followed() {
    let found = |centre: f64| {
        let problem = Exact::<_, 2>(TwoWells(centre));
        let s = DiagramSettings {
            branch: Settings {
                period_bound: 30.0,
                ..Settings::new(&[(-0.3, 0.8)])
            },
            states: vec![(-2.0, 2.0), (0.0, 0.0)],
            starts: 10,
            depth: 1,
        };
        diagram(&problem, &[0.0], 0, &s).unwrap()
    };
    for (centre, mirrored, cycles) in [(0.0, true, 1), (0.125, false, 2)] {
        let d = found(centre);
        assert_eq!(d.mirrored, mirrored);
        let hopf: Vec<f64> = d
            .equilibria
            .iter()
            .flat_map(|m| m.branch.of(Kind::Hopf))
            .map(|h| h.solution.parameters[0])
            .collect();
        assert!(hopf.iter().all(|p| (p - 0.5).abs() < 1e-6), "{hopf:?}");
        assert_eq!((hopf.len(), d.cycles.len()), (cycles, cycles));
    }
}

#[test]
fn a_vertical_family_ends_as_degenerate() {
    let problem = Exact::<_, 2>(VanDerPol);
    let s = DiagramSettings {
        branch: Settings::new(&[(-0.5, 0.5)]),
        states: vec![(-3.0, 3.0); 2],
        starts: 6,
        depth: 2,
    };
    let d = diagram(&problem, &[0.0], 0, &s).unwrap();
    assert_eq!((d.equilibria.len(), d.cycles.len()), (1, 1));
    assert_eq!(d.cycles[0].branch.stop[1], Stop::DegenerateFamily);
    assert!(d.cycles[0].branch.special.is_empty());
}

/// x' = x (x - 0.004 p) (x + 0.007) exp(-(x / 0.02)²): three equilibria near rest, and nothing that leads to them from afar.
struct Close;
impl Field for Close {
    const N: usize = 1;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let x = x[0];
        let far = x * R::from(50.0);
        out[0] = R::from(1e4)
            * x
            * (x - R::from(0.004) * p[0])
            * (x + R::from(0.007))
            * (-(far * far)).exp();
    }
}

#[test]
fn equilibria_much_closer_together_than_the_box_is_wide() {
    let problem = Exact::<_, 1>(Close);
    let mut branch = Settings::new(&[(0.5, 1.5)]);
    branch.state_scale = 1e-3;
    let s = DiagramSettings {
        branch,
        states: vec![(-1.0, 1.0)],
        starts: 24,
        depth: 1,
    };
    let d = diagram(&problem, &[1.0], 0, &s).unwrap();
    let mut found: Vec<f64> = d
        .equilibria
        .iter()
        .map(|m| m.branch.points[0].solution.state[0])
        .collect();
    found.sort_by(f64::total_cmp);
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(
        (found[0] + 0.007).abs() < 1e-9 && found[1].abs() < 1e-9,
        "{found:?}"
    );
}

/// x' = p x - x³ followed from x = ½, through the pitchfork at p = 0: the other branch crosses there, and p has no effect on x = 0, so
/// that the turn of the parameter is no fold.
struct Pitchfork;
impl Field for Pitchfork {
    const N: usize = 1;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        out[0] = p[0] * x[0] - x[0].cube();
    }
}

#[test]
fn the_turn_of_a_pitchfork_is_a_branch_point() {
    let problem = Exact::<_, 1>(Pitchfork);
    let settings = Settings::new(&[(-1.0, 1.0)]);
    let found = equilibria(&problem, &[0.5], &[0.25], 0, &settings).unwrap();
    let kinds: Vec<Kind> = found.special.iter().map(|one| one.kind).collect();
    assert_eq!(kinds, [Kind::BranchPoint]);
    assert!(found.special[0].solution.parameters[0].abs() < 1e-6);
    // Both halves, and the straight branch across.
    let ends: Vec<f64> = [found.points.first(), found.points.last()]
        .iter()
        .map(|point| point.unwrap().solution.state[0])
        .collect();
    assert!(ends[0] * ends[1] < 0.0, "{ends:?}");
    let across = equilibria_across(&problem, &found.special[0], 0, 1.0, &settings).unwrap();
    let far = &across.points.last().unwrap().solution;
    assert!(far.state[0].abs() < 1e-6, "{far:?}");
}

/// The Hopf point of Lorenz-84 on the branch of positive v (AUTO-07p), which no start of its other branch leads to.
#[test]
fn s7_the_branch_with_positive_v() {
    let problem = Exact::<_, 4>(Lorenz84);
    let settings = DiagramSettings {
        branch: Settings::new(&[(0.0, 3.0)]),
        states: vec![(-3.0, 3.0); 4],
        starts: 24,
        depth: 0,
    };
    let found = diagram(&problem, &[3.0, 0.04], 0, &settings).unwrap();
    let hopf: Vec<f64> = found
        .equilibria
        .iter()
        .flat_map(|member| member.branch.of(Kind::Hopf))
        .filter(|one| one.solution.state[3] > 0.0)
        .map(|one| one.solution.parameters[0])
        .collect();
    assert!(
        hopf.iter()
            .any(|value| (value / 2.964_590_10 - 1.0).abs() < 1e-8),
        "{hopf:?}"
    );
}
