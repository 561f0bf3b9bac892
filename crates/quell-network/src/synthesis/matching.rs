//! The smallest network: equations of enumerated networks solved.

use super::monomials::{Monomials, is_nonnegative};
use super::{Method, Realisation, Structure, SynthesisError, Target, brune};
use crate::{
    Budget, Domain, Element, Enumeration, Equivalence, Kinds, Layout, Network, RationalFunction,
    Tree, bridge,
};

/// How to look for the smallest network.
///
/// Networks are tried by number of elements: the irreducible series-parallel layouts of springs, dampers and inerters, and
/// with five elements the bridges. Those that behave otherwise than the target at zero or infinity, or are of lower
/// degree, are left out at once. For the others the equations N(v) q - s D(v) p = 0 in the values v (dynamic stiffness N/D,
/// target p/q) are solved by Levenberg and Marquardt's method in log v from several starts, so that values are positive;
/// a solution is analysed back. It speaks of admittance and impedance alike.
///
/// Where Foster's preamble alone ends in a series-parallel network, as it does for every regular biquadratic with at most five
/// elements (J. Z. Jiang and M. C. Smith, 2011), that stands in for what the starts have missed.
///
/// A network that is found is certain; that there is no smaller one is computed, not proven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Matching {
    /// Largest number of elements.
    pub most_elements: usize,
    /// Whether bridges count.
    pub bridges: bool,
    /// Starts of each solution.
    pub starts: usize,
}

impl Default for Matching {
    /// Six elements, with bridges, 24 starts.
    fn default() -> Self {
        Self {
            most_elements: 6,
            bridges: true,
            starts: 24,
        }
    }
}

/// The smallest networks found.
#[derive(Debug, Clone, PartialEq)]
pub struct Smallest {
    /// All that were found with the least number of elements, in the order of enumeration, bridges last.
    pub realisations: Vec<Realisation>,
    /// How many networks had their equations tried.
    pub tried: usize,
}

impl Matching {
    /// All networks with the least number of elements.
    ///
    /// # Errors
    /// Not positive-real or zero; [`SynthesisError::NotFound`] where none is found up to the largest number of elements.
    pub fn smallest(&self, function: &RationalFunction) -> Result<Smallest, SynthesisError> {
        let target = Target::new(function)?;
        let mut found = Smallest {
            realisations: Vec::new(),
            tried: 0,
        };
        if !is_nonnegative(&target.unit) {
            return Err(SynthesisError::NotFound(self.most_elements));
        }
        let preamble = brune(function)
            .ok()
            .filter(|one| one.method == Method::Preamble && one.structure.is_series_parallel());
        for elements in target.unit.degree().max(1)..=self.most_elements {
            for layout in layouts(elements) {
                self.try_layout(function, &target, &layout, &mut found);
            }
            let as_small = |one: &&Realisation| one.structure.elements().total() == elements;
            if let Some(one) = preamble.as_ref().filter(as_small)
                && found.realisations.is_empty()
            {
                found.realisations.push(one.clone());
            }
            if self.bridges && elements == bridge::EDGES.len() {
                for labels in bridge::labelled() {
                    self.try_bridge(function, &target, labels, &mut found);
                }
            }
            if !found.realisations.is_empty() {
                return Ok(found);
            }
        }
        Err(SynthesisError::NotFound(self.most_elements))
    }

    /// The given layout with values that make it the target, if there are any.
    ///
    /// # Errors
    /// Not positive-real, zero, or [`SynthesisError::NotFound`].
    pub fn fit(
        &self,
        function: &RationalFunction,
        layout: &Layout,
    ) -> Result<Realisation, SynthesisError> {
        let target = Target::new(function)?;
        let mut found = Smallest {
            realisations: Vec::new(),
            tried: 0,
        };
        self.try_layout(function, &target, layout, &mut found);
        found
            .realisations
            .pop()
            .ok_or_else(|| SynthesisError::NotFound(layout.branches().count()))
    }

    fn try_layout(
        &self,
        function: &RationalFunction,
        target: &Target,
        layout: &Layout,
        found: &mut Smallest,
    ) {
        let Some((tree, elements)) = numbered(layout) else {
            return;
        };
        let monomials = Monomials::of_tree(&tree, &elements);
        if !monomials.suits(&target.unit) {
            return;
        }
        found.tried += 1;
        let Some(values) = monomials.solve(&target.unit, self.starts) else {
            return;
        };
        let structure = with_values(&tree, &elements, &values);
        if let Ok(realisation) = target.accept(function, &structure, Method::Matching) {
            found.realisations.push(realisation);
        }
    }

    fn try_bridge(
        &self,
        function: &RationalFunction,
        target: &Target,
        labels: [Element; 5],
        found: &mut Smallest,
    ) {
        let monomials = Monomials::of_graph(&bridge::EDGES, &labels);
        if !monomials.suits(&target.unit) {
            return;
        }
        found.tried += 1;
        let Some(values) = monomials.solve(&target.unit, self.starts) else {
            return;
        };
        let edges = bridge::EDGES
            .into_iter()
            .zip(labels.into_iter().zip(values))
            .map(|((from, to), (element, value))| (from, to, Structure::Element(element, value)))
            .collect();
        if let Ok(realisation) = target.accept(function, &Structure::Graph(edges), Method::Matching)
        {
            found.realisations.push(realisation);
        }
    }
}

/// The irreducible layouts of springs, dampers and inerters with so many elements.
fn layouts(elements: usize) -> impl Iterator<Item = Layout> {
    let budgets = ["k", "c", "b"].map(Budget::any);
    let all = Enumeration::new(
        &Kinds::new(Domain::Translational),
        &budgets,
        Some(elements),
        Equivalence::Irreducible,
    )
    .ok();
    let count = all.as_ref().map_or(0, Enumeration::count);
    (0..count).filter_map(move |index| all.as_ref()?.nth(index))
}

/// The mechanical tree of a layout with its elements; none where it is no network of elements, or too large.
pub(crate) fn numbered(layout: &Layout) -> Option<(Tree<usize>, Vec<Element>)> {
    let network = Network::from_layout(layout, Some(1.0)).ok()?;
    let elements: Vec<Element> = network
        .elements()
        .iter()
        .map(|element| element.element)
        .collect();
    (elements.len() <= 32).then(|| (network.tree(), elements))
}

fn with_values(tree: &Tree<usize>, elements: &[Element], values: &[f64]) -> Structure {
    let all = |children: &[Tree<usize>]| {
        children
            .iter()
            .map(|child| with_values(child, elements, values))
            .collect()
    };
    match tree {
        Tree::Leaf(element) => Structure::Element(
            elements.get(*element).copied().unwrap_or(Element::Damper),
            values.get(*element).copied().unwrap_or(f64::NAN),
        ),
        Tree::Series(children) => Structure::Series(all(children)),
        Tree::Parallel(children) => Structure::Parallel(all(children)),
    }
}
