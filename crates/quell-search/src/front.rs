//! Fronts of several objectives: which points no other beats.

/// Which of the points are efficient: no other point is at least as good in every objective and better in one.
///
/// Objectives are to be small. A point with a number that is not finite is not efficient; of equal points the first
/// counts. V. Pareto 1906; the definition is equation 2.2 of K. Miettinen, Nonlinear Multiobjective Optimization, 1999.
pub fn efficient(points: &[Vec<f64>]) -> Vec<bool> {
    let sound = |point: &[f64]| point.iter().all(|value| value.is_finite());
    points
        .iter()
        .enumerate()
        .map(|(index, point)| {
            sound(point)
                && !points.iter().enumerate().any(|(other_index, other)| {
                    other_index != index
                        && sound(other)
                        && other.len() == point.len()
                        && beats(other, point, other_index < index)
                })
        })
        .collect()
}

/// At least as good everywhere, and better somewhere or `earlier`.
fn beats(a: &[f64], b: &[f64], earlier: bool) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && (earlier || a.iter().zip(b).any(|(a, b)| a < b))
}

/// Bounds for the objectives after the first, at which the first is to be minimised: every combination of `points` equal
/// steps from the ideal value (the least that is possible) to the nadir (the largest among the optima of single
/// objectives) of each. The ideal itself is left out, since the optima of single objectives stand for it; so is, with one
/// objective after the first, the nadir.
///
/// The epsilon-constraint method of Y. Haimes, L. Lasdon and D. Wismer 1971: a minimiser of the first objective under
/// such bounds, if it is the only one, is efficient, whether the front is convex or not.
pub fn epsilon_levels(ideal: &[f64], nadir: &[f64], points: usize) -> Vec<Vec<f64>> {
    let steps = points.saturating_sub(1).max(1);
    let last = if ideal.len() == 1 { steps - 1 } else { steps };
    let mut levels: Vec<Vec<f64>> = vec![Vec::new()];
    for (&from, &to) in ideal.iter().zip(nadir) {
        // Without conflict there is nothing to trade.
        let values: Vec<f64> = if from == to {
            vec![to]
        } else {
            (1..=last)
                .map(|step| {
                    let share = step as f64 / steps as f64;
                    from * (1.0 - share) + to * share
                })
                .collect()
        };
        levels = levels
            .iter()
            .flat_map(|level| {
                values.iter().map(|value| {
                    let mut level = level.clone();
                    level.push(*value);
                    level
                })
            })
            .collect();
    }
    levels
}
