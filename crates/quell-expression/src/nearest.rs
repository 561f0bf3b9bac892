//! The nearest valid name to a mistyped one.

/// The candidate nearest to `name` by edits (insert, delete, replace, swap neighbours; case counts half), if it is near
/// enough to be what was meant: at most a third of the name's length, and at least one edit, is forgiven.
///
/// ```
/// assert_eq!(quell_expression::nearest("dampres", ["springs", "dampers"]), Some("dampers"));
/// assert_eq!(quell_expression::nearest("xyz", ["springs", "dampers"]), None);
/// ```
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let typed: Vec<char> = name.chars().take(LONGEST).collect();
    let allowed = 2 * (typed.len() / 3).max(1);
    candidates
        .into_iter()
        .filter(|candidate| *candidate != name)
        .map(|candidate| (distance(&typed, candidate), candidate))
        .filter(|(edits, candidate)| {
            // A name of one or two letters is not "near" another that shares none of them.
            *edits <= allowed && *edits < 2 * candidate.chars().count().max(typed.len())
        })
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, candidate)| candidate)
}

/// Names are compared in so many characters: enough for any name, and no work for an attacker's megabyte.
const LONGEST: usize = 64;

/// Twice the restricted Damerau-Levenshtein distance, a change of case counting one.
fn distance(typed: &[char], candidate: &str) -> usize {
    let other: Vec<char> = candidate.chars().take(LONGEST).collect();
    let width = other.len() + 1;
    let mut before: Vec<usize> = vec![0; width];
    let mut above: Vec<usize> = (0..width).map(|column| 2 * column).collect();
    for (row, &a) in typed.iter().enumerate() {
        let mut current = vec![2 * (row + 1); width];
        for (column, &b) in other.iter().enumerate() {
            let replace = if a == b {
                0
            } else if a.to_lowercase().eq(b.to_lowercase()) {
                1
            } else {
                2
            };
            let mut best = (above[column] + replace)
                .min(above[column + 1] + 2)
                .min(current[column] + 2);
            if row > 0 && column > 0 && a == other[column - 1] && b == typed[row - 1] {
                best = best.min(before[column - 1] + 2);
            }
            current[column + 1] = best;
        }
        before = above;
        above = current;
    }
    above.last().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_swaps_omissions_and_wrong_case() {
        assert_eq!(nearest("inetrer", ["spring", "inerter"]), Some("inerter"));
        assert_eq!(nearest("bnd", ["band", "input"]), Some("band"));
        assert_eq!(nearest("td", ["Td", "Te"]), Some("Td"));
    }

    #[test]
    fn gives_nothing_for_the_unlike() {
        assert_eq!(nearest("frequency", ["modes", "kind"]), None);
        assert_eq!(nearest("q", ["x", "y"]), None);
    }
}
