//! Branches as bytes.

use quell_continuation::{Branch, Kept, Kind, Settings, cycle_curve, cycles_from_hopf, equilibria};

use crate::support::Exact;
use crate::support::models::Feedback;

#[track_caller]
fn comes_back<S: Kept + std::fmt::Debug>(branch: &Branch<S>) {
    let bytes = branch.to_bytes();
    let back: Branch<S> = Branch::from_bytes(&bytes).unwrap();
    assert_eq!(format!("{branch:?}"), format!("{back:?}"));
    // Bits, which the text does not tell of not-a-number.
    assert_eq!(back.to_bytes(), bytes);
    // What is cut off, longer or of another layout is not read.
    for end in (0..bytes.len()).step_by(bytes.len() / 97 + 1) {
        assert!(Branch::<S>::from_bytes(&bytes[..end]).is_none(), "{end}");
    }
    let longer = [&bytes[..], &[0]].concat();
    assert!(Branch::<S>::from_bytes(&longer).is_none());
    let other = [&[bytes[0] + 1], &bytes[1..]].concat();
    assert!(Branch::<S>::from_bytes(&other).is_none());
}

#[test]
fn branches_come_back_to_the_last_bit_and_serve_as_starts() {
    let problem = Exact::<_, 3>(Feedback);
    let mut s = Settings::new(&[(0.5, 1.2)]);
    s.at = vec![0.8];
    let rest = equilibria(&problem, &[0.0; 3], &[1.2, 1.0], 0, &s).unwrap();
    comes_back(&rest);
    let cycles = cycles_from_hopf(&problem, rest.of(Kind::Hopf)[0], 0, &s).unwrap();
    comes_back(&cycles);
    let back = Branch::from_bytes(&cycles.to_bytes()).unwrap();
    let mut s = Settings::new(&[(0.5, 0.7), (0.8, 1.2)]);
    s.maximum_points = 10;
    let curve = |from: &Branch<_>| {
        cycle_curve(&problem, from.of(Kind::PeriodDoubling)[0], [0, 1], &s).unwrap()
    };
    comes_back(&curve(&cycles));
    assert_eq!(curve(&cycles).to_bytes(), curve(&back).to_bytes());
}
