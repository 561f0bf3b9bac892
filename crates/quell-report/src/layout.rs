//! From a layout of the network algebra to the parts that are drawn.

use quell_network::{Domain, Element, Kind, Layout, Tree};

use crate::schematic::Part;
use crate::symbols::Symbol;

/// What a drawing of a layout shows besides the names.
#[derive(Debug, Clone, Default)]
pub struct Annotations {
    /// Shown values with their units by name, in order: `k1` for an element, `tube1.dL` for a component's variable.
    pub values: Vec<(String, String)>,
    /// What each kind of component consists of.
    pub components: Vec<(String, Layout)>,
    /// What a place that another layout fills stands for.
    pub placeholders: Vec<(String, Layout)>,
}

impl Annotations {
    fn value(&self, name: &str) -> Option<String> {
        self.values
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, value)| value.clone())
    }

    /// Lines such as `dL = 0.5402` for the variables of one instance.
    fn variables(&self, instance: &str) -> Vec<String> {
        self.values
            .iter()
            .filter_map(|(name, value)| {
                let variable = name.strip_prefix(instance)?.strip_prefix('.')?;
                Some(format!("{variable} = {value}"))
            })
            .collect()
    }
}

/// Groups and components nested deeper than this are drawn as a box: a component that contains itself must not recurse for ever.
const DEEPEST: usize = 64;

impl Part {
    /// The drawing of a layout, annotated with values, its components opened.
    pub fn from_layout(layout: &Layout, annotations: &Annotations) -> Self {
        tree(layout.tree(), layout.domain(), annotations, 0)
    }
}

fn tree(
    node: &Tree<quell_network::Branch>,
    domain: Domain,
    annotations: &Annotations,
    depth: usize,
) -> Part {
    let children = |children: &[Tree<quell_network::Branch>]| {
        children
            .iter()
            .map(|child| tree(child, domain, annotations, depth + 1))
            .collect::<Vec<_>>()
    };
    match node {
        Tree::Series(parts) => Part::Series(children(parts)),
        Tree::Parallel(parts) => Part::Parallel(children(parts)),
        Tree::Leaf(branch) => {
            let find = |known: &[(String, Layout)], name: &str| {
                known
                    .iter()
                    .find(|(known, _)| known == name && depth < DEEPEST)
                    .map(|(_, layout)| layout.clone())
            };
            match &branch.kind {
                Kind::Element(element) => Part::Element {
                    symbol: Symbol::of(domain, *element),
                    name: branch.name.clone(),
                    value: annotations.value(&branch.name),
                },
                // Its law is the study's own, so it has no symbol of the field.
                Kind::Custom(_) => Part::Element {
                    symbol: Symbol::Box,
                    name: branch.name.clone(),
                    value: None,
                },
                Kind::Component(kind) => Part::Component {
                    name: branch.name.clone(),
                    values: annotations.variables(&branch.name),
                    inner: Box::new(match find(&annotations.components, kind) {
                        // Values inside a component follow from its variables, so only names are shown there.
                        Some(layout) => tree(
                            layout.tree(),
                            layout.domain(),
                            &Annotations {
                                values: Vec::new(),
                                ..annotations.clone()
                            },
                            depth + 1,
                        ),
                        None => Part::Element {
                            symbol: Symbol::Box,
                            name: String::new(),
                            value: None,
                        },
                    }),
                },
                Kind::Placeholder => match find(&annotations.placeholders, &branch.name) {
                    Some(layout) => tree(layout.tree(), layout.domain(), annotations, depth + 1),
                    None => Part::Element {
                        symbol: Symbol::Box,
                        name: branch.name.clone(),
                        value: annotations.value(&branch.name),
                    },
                },
            }
        }
    }
}

impl Symbol {
    /// The symbol of an element in the domain that it is written in.
    pub fn of(domain: Domain, element: Element) -> Self {
        match (domain, element) {
            (Domain::Hydraulic, Element::Spring) => Self::Compliance,
            (Domain::Hydraulic, Element::Damper) => Self::Restriction,
            (Domain::Hydraulic, Element::Inerter) => Self::Inertance,
            (Domain::Electrical, Element::Spring) => Self::Inductor,
            (Domain::Electrical, Element::Damper) => Self::Resistor,
            (Domain::Electrical, Element::Inerter) => Self::Capacitor,
            (_, Element::Spring) => Self::Spring,
            (_, Element::Damper) => Self::Damper,
            (_, Element::Inerter) => Self::Inerter,
            (_, Element::Mass) => Self::Mass,
        }
    }
}
