//! The mechanical network that a layout becomes, ready to be evaluated.

use num_complex::Complex64;

use crate::kind::{Branch, Kind};
use crate::program::Program;
use crate::{Domain, Element, Layout, Tree};

/// An element of a network, with the way from the value in its own domain to the mechanical one.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkElement {
    /// The name: `k1`, or `pipe1.I` within a component.
    pub name: String,
    /// What it is in the mechanical network.
    pub element: Element,
    /// The domain in which its value is given.
    pub domain: Domain,
    /// Its letter in that domain.
    pub letter: char,
    /// The factor f in mechanical = f · own, or mechanical = f / own where [`NetworkElement::inverse`].
    pub factor: f64,
    /// Whether the mechanical value is the factor over the own value.
    pub inverse: bool,
}

impl NetworkElement {
    /// An element given in its domain; `piston_area` Ap (m²) is read by the hydraulic domain only.
    fn new(name: String, element: Element, domain: Domain, piston_area: f64) -> Self {
        let factor = if domain == Domain::Hydraulic {
            piston_area * piston_area
        } else {
            1.0
        };
        let letter = domain.letter(element).unwrap_or('m');
        Self {
            name,
            element,
            domain,
            letter,
            factor,
            inverse: domain.inverts(element),
        }
    }

    /// The mechanical value (SI) of a value in the element's own domain (SI).
    #[must_use]
    #[inline]
    pub fn own_to_mechanical(&self, own: f64) -> f64 {
        if self.inverse {
            self.factor / own
        } else {
            self.factor * own
        }
    }

    /// The value in the element's own domain (SI) of a mechanical value (SI).
    #[must_use]
    #[inline]
    pub fn mechanical_to_own(&self, mechanical: f64) -> f64 {
        if self.inverse {
            self.factor / mechanical
        } else {
            mechanical / self.factor
        }
    }

    /// Derivative of the mechanical value with respect to the own value.
    #[must_use]
    #[inline]
    pub fn derivative(&self, own: f64) -> f64 {
        if self.inverse {
            -self.factor / (own * own)
        } else {
            self.factor
        }
    }
}

/// Why a layout is no network.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NetworkError {
    /// A placeholder was left.
    #[error("`{0}` still stands for a layout that is to be chosen")]
    Placeholder(String),
    /// An element with a law of its own, which has no dynamic stiffness.
    #[error(
        "`{0}` is nonlinear: it has no dynamic stiffness, so that the device can be simulated in time but has no \
         frequency response, no admittance and no modes of its own"
    )]
    Nonlinear(String),
    /// An element with a law of its own in a layout that is not mechanical.
    #[error(
        "`{branch}` is a law between force and motion, but its layout is {domain}; write the layout in the letters \
         k, c, b, m"
    )]
    NotMechanical {
        /// The branch.
        branch: String,
        /// The layout's domain.
        domain: Domain,
    },
    /// A branch is a component whose definition was not given.
    #[error("the component `{component}` of branch `{branch}` is not defined")]
    UnknownComponent {
        /// The branch.
        branch: String,
        /// The component's name.
        component: String,
    },
    /// A hydraulic layout without a piston area.
    #[error("a hydraulic layout acts through a piston, and its area is missing")]
    NoPiston,
    /// The piston area is not positive and finite.
    #[error("the piston area must be positive and finite")]
    PistonArea,
    /// A component's layout is in another domain than the layout that uses it.
    #[error(
        "the component `{component}` is {inner} but the layout that uses it is {outer}; write both in one domain"
    )]
    Domain {
        /// The component's name.
        component: String,
        /// Its domain.
        inner: Domain,
        /// The domain of the layout.
        outer: Domain,
    },
    /// A component's layout holds a component itself.
    #[error(
        "the component `{component}` holds `{branch}`, which is no element; components cannot be nested"
    )]
    Nested {
        /// The component.
        component: String,
        /// The branch in its layout.
        branch: String,
    },
    /// A component with a mass inside.
    #[error("the component `{component}` holds the mass `{branch}`; a mass can only end a device")]
    MassInComponent {
        /// The component.
        component: String,
        /// The mass.
        branch: String,
    },
}

/// A group or element of the network; children precede their parents.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shape {
    Element(usize),
    Series(Vec<usize>),
    Parallel(Vec<usize>),
}

/// A named part of a network: an element, or an instance of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Part {
    pub(crate) shape: usize,
}

/// A mechanical network ready to evaluate: its elements are numbered, values are a slice in that order.
///
/// Values are mechanical (N/m, N s/m, kg; or their rotational kin): map own values of other domains through
/// [`NetworkElement::own_to_mechanical`]. A slice that is too short reads as not-a-number.
#[derive(Debug, Clone)]
pub struct Network {
    pub(crate) elements: Vec<NetworkElement>,
    pub(crate) shapes: Vec<Shape>,
    pub(crate) parts: Vec<(String, Part)>,
    pub(crate) program: Program,
}

impl Network {
    /// The mechanical network of a layout of elements; `piston_area` Ap (m²) is needed by hydraulic layouts.
    ///
    /// Elements are numbered from left to right. Hydraulic series becomes mechanical parallel and the other way round.
    ///
    /// # Errors
    /// A placeholder or component in the layout ([`crate::expand`] takes components), a missing or impossible area.
    pub fn from_layout(layout: &Layout, piston_area: Option<f64>) -> Result<Self, NetworkError> {
        Self::with_components(layout, piston_area, |_| None)
    }

    /// The mechanical network of a layout whose components are looked up by name.
    pub(crate) fn with_components<'a>(
        layout: &Layout,
        piston_area: Option<f64>,
        component: impl Fn(&str) -> Option<&'a Layout>,
    ) -> Result<Self, NetworkError> {
        let area = match (layout.domain(), piston_area) {
            (_, Some(area)) if !(area.is_finite() && area > 0.0) => {
                return Err(NetworkError::PistonArea);
            }
            (Domain::Hydraulic, None) => return Err(NetworkError::NoPiston),
            (_, area) => area.unwrap_or(1.0),
        };
        let mut builder = Builder {
            domain: layout.domain(),
            area,
            elements: Vec::new(),
            shapes: Vec::new(),
            parts: Vec::new(),
        };
        builder.add(layout.tree(), &component)?;
        let Builder {
            elements,
            shapes,
            parts,
            ..
        } = builder;
        let program = Program::compile(&elements, &shapes);
        Ok(Self {
            elements,
            shapes,
            parts,
            program,
        })
    }

    /// The elements in the order of values.
    #[must_use]
    pub fn elements(&self) -> &[NetworkElement] {
        &self.elements
    }

    /// Place in the order of values of a named element.
    #[must_use]
    pub fn element_index(&self, name: &str) -> Option<usize> {
        self.elements
            .iter()
            .position(|element| element.name == name)
    }

    /// The part (element or instance of a component) of a name.
    #[must_use]
    pub fn part(&self, name: &str) -> Option<Part> {
        self.parts
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, part)| *part)
    }

    /// Every named part.
    pub fn parts(&self) -> impl Iterator<Item = (&str, Part)> {
        self.parts.iter().map(|(name, part)| (name.as_str(), *part))
    }

    /// The mechanical tree with the elements' numbers as leaves, component instances dissolved (normal form).
    #[must_use]
    pub fn tree(&self) -> Tree<usize> {
        let nested = self.subtree(self.root());
        nested.clone().flattened().unwrap_or(nested)
    }

    fn subtree(&self, shape: usize) -> Tree<usize> {
        match self.shapes.get(shape) {
            Some(Shape::Series(children)) => {
                Tree::Series(children.iter().map(|child| self.subtree(*child)).collect())
            }
            Some(Shape::Parallel(children)) => {
                Tree::Parallel(children.iter().map(|child| self.subtree(*child)).collect())
            }
            Some(Shape::Element(element)) => Tree::Leaf(*element),
            None => Tree::Leaf(shape),
        }
    }

    pub(crate) fn root(&self) -> usize {
        self.shapes.len().saturating_sub(1)
    }

    /// D(jω) = jω Y(jω), force over relative displacement (N/m), at angular frequency ω (rad/s).
    ///
    /// At a pole the result is +∞ (real part); at ω = 0 it is the static stiffness.
    #[must_use]
    pub fn dynamic_stiffness(&self, omega: f64, values: &[f64]) -> Complex64 {
        let (numerator, denominator) = self.ratio(omega, values);
        quotient(numerator, denominator)
    }

    /// N and D with dynamic stiffness N/D, up to a common factor; no division inside.
    ///
    /// Parallel: (N1 D2 + N2 D1, D1 D2); series: (N1 N2, N1 D2 + N2 D1). So zeros, poles (D = 0) and ω = 0 are ordinary
    /// values; N and D are never both zero. Elements' |D| may lie within 1e±50 in networks of any size.
    #[must_use]
    pub fn ratio(&self, omega: f64, values: &[f64]) -> (Complex64, Complex64) {
        self.program.ratio(omega, values)
    }
}

/// N/D, +∞ where D is zero and N is not.
pub(crate) fn quotient(numerator: Complex64, denominator: Complex64) -> Complex64 {
    if denominator == Complex64::ZERO && numerator != Complex64::ZERO && !numerator.is_nan() {
        return Complex64::new(f64::INFINITY, 0.0);
    }
    numerator / denominator
}

struct Builder {
    domain: Domain,
    area: f64,
    elements: Vec<NetworkElement>,
    shapes: Vec<Shape>,
    parts: Vec<(String, Part)>,
}

impl Builder {
    fn push(&mut self, shape: Shape) -> usize {
        self.shapes.push(shape);
        self.shapes.len() - 1
    }

    fn group(&mut self, series: bool, children: Vec<usize>) -> usize {
        self.push(if series == self.domain.swaps_groups() {
            Shape::Parallel(children)
        } else {
            Shape::Series(children)
        })
    }

    fn element(&mut self, name: String, element: Element) -> usize {
        let number = self.elements.len();
        self.elements.push(NetworkElement::new(
            name.clone(),
            element,
            self.domain,
            self.area,
        ));
        let shape = self.push(Shape::Element(number));
        self.parts.push((name, Part { shape }));
        shape
    }

    fn add<'a>(
        &mut self,
        tree: &Tree<Branch>,
        component: &impl Fn(&str) -> Option<&'a Layout>,
    ) -> Result<usize, NetworkError> {
        match tree {
            Tree::Leaf(branch) => match &branch.kind {
                Kind::Element(element) => Ok(self.element(branch.name.clone(), *element)),
                Kind::Placeholder => Err(NetworkError::Placeholder(branch.name.clone())),
                Kind::Custom(_) => Err(NetworkError::Nonlinear(branch.name.clone())),
                Kind::Component(name) => {
                    let inner = component(name).ok_or_else(|| NetworkError::UnknownComponent {
                        branch: branch.name.clone(),
                        component: name.clone(),
                    })?;
                    if inner.domain() != self.domain {
                        return Err(NetworkError::Domain {
                            component: name.clone(),
                            inner: inner.domain(),
                            outer: self.domain,
                        });
                    }
                    let shape = self.add_component(name, &branch.name, inner.tree())?;
                    self.parts.push((branch.name.clone(), Part { shape }));
                    Ok(shape)
                }
            },
            Tree::Series(children) | Tree::Parallel(children) => {
                let shapes = children
                    .iter()
                    .map(|child| self.add(child, component))
                    .collect::<Result<_, _>>()?;
                Ok(self.group(matches!(tree, Tree::Series(_)), shapes))
            }
        }
    }

    fn add_component(
        &mut self,
        component: &str,
        instance: &str,
        tree: &Tree<Branch>,
    ) -> Result<usize, NetworkError> {
        match tree {
            Tree::Leaf(branch) => match branch.kind {
                Kind::Element(Element::Mass) => Err(NetworkError::MassInComponent {
                    component: component.to_owned(),
                    branch: branch.name.clone(),
                }),
                Kind::Element(element) => {
                    Ok(self.element(format!("{instance}.{}", branch.name), element))
                }
                Kind::Custom(_) => Err(NetworkError::Nonlinear(format!(
                    "{instance}.{}",
                    branch.name
                ))),
                Kind::Component(_) | Kind::Placeholder => Err(NetworkError::Nested {
                    component: component.to_owned(),
                    branch: branch.name.clone(),
                }),
            },
            Tree::Series(children) | Tree::Parallel(children) => {
                let shapes = children
                    .iter()
                    .map(|child| self.add_component(component, instance, child))
                    .collect::<Result<_, _>>()?;
                Ok(self.group(matches!(tree, Tree::Series(_)), shapes))
            }
        }
    }
}
