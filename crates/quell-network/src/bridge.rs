//! The five-element bridge with each of its labellings once.

use crate::Element;

/// The nodes of the bridge's edges: 0 the head, 1 the tail, 2 and 3 inside; the last edge is the bridging one.
pub(crate) const EDGES: [(usize, usize); 5] = [(0, 2), (0, 3), (2, 1), (3, 1), (2, 3)];

/// Where edges go when the inner nodes change places, when the terminals do, and when both do.
const SYMMETRIES: [[usize; 5]; 4] = [
    [0, 1, 2, 3, 4],
    [1, 0, 3, 2, 4],
    [2, 3, 0, 1, 4],
    [3, 2, 1, 0, 4],
];

/// The bridge with springs, dampers and inerters on its five edges, each labelling once up to its symmetries.
///
/// Order of the elements: head to first inner node, head to second, first to tail, second to tail, the bridging one. The
/// 243 labellings fall into (243 + 3 · 27)/4 = 81 classes under the four symmetries (Burnside's lemma).
pub(crate) fn labelled() -> impl Iterator<Item = [Element; 5]> {
    const KINDS: [Element; 3] = [Element::Spring, Element::Damper, Element::Inerter];
    (0..243_usize).filter_map(|index| {
        let mut labels = [Element::Spring; 5];
        let mut rest = index;
        for label in &mut labels {
            *label = KINDS.get(rest % 3).copied().unwrap_or(Element::Spring);
            rest /= 3;
        }
        let smallest = SYMMETRIES.iter().all(|moved| {
            let image = moved.map(|from| labels.get(from).copied().unwrap_or(Element::Spring));
            labels <= image
        });
        smallest.then_some(labels)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (243 + 27 + 27 + 27)/4 by Burnside: each reflection fixes the bridging edge and pairs the others.
    #[test]
    fn classes_are_counted_by_burnside() {
        assert_eq!(labelled().count(), 81);
    }
}
