//! Elements, and the domains in which engineers write them.

use std::fmt;

use quell_expression::Dimension;

/// A two-terminal element, named by its mechanical kind whatever the domain it is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Element {
    /// Force proportional to relative displacement, D(s) = k.
    Spring,
    /// Force proportional to relative velocity, D(s) = c s.
    Damper,
    /// Force proportional to relative acceleration, D(s) = b s² (Smith 2002).
    Inerter,
    /// An inerter with one terminal in the inertial frame, D(s) = m s².
    Mass,
}

impl Element {
    /// The power q of s in the element's dynamic stiffness, value · s^q: 0, 1 or 2.
    #[must_use]
    pub const fn power(self) -> usize {
        match self {
            Self::Spring => 0,
            Self::Damper => 1,
            Self::Inerter | Self::Mass => 2,
        }
    }

    /// The element with the reciprocal admittance (spring and inerter change places), none for a mass.
    #[must_use]
    pub const fn dual(self) -> Option<Self> {
        match self {
            Self::Spring => Some(Self::Inerter),
            Self::Damper => Some(Self::Damper),
            Self::Inerter => Some(Self::Spring),
            Self::Mass => None,
        }
    }
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Spring => "spring",
            Self::Damper => "damper",
            Self::Inerter => "inerter",
            Self::Mass => "mass",
        })
    }
}

/// The physical domain in which a layout is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Domain {
    /// Forces and displacements; `k` N/m, `c` N s/m, `b` kg, `m` kg.
    Translational,
    /// Moments and angles; `k` N m/rad, `c` N m s/rad, `b` kg m², `m` kg m².
    Rotational,
    /// Currents and voltages; `R` ohm, `L` H, `C` F. Force-current analogy: series stays series.
    Electrical,
    /// Flows and pressure differences; `R` kg/(s m⁴), `I` kg/m⁴, `C` m⁵/N. Through a piston, hydraulic series
    /// becomes mechanical parallel.
    Hydraulic,
}

impl Domain {
    /// Every domain.
    pub const ALL: [Self; 4] = [
        Self::Translational,
        Self::Rotational,
        Self::Electrical,
        Self::Hydraulic,
    ];

    /// The letters of the domain's elements in the order in which canonical layouts list them.
    #[must_use]
    pub const fn letters(self) -> &'static [(char, Element)] {
        match self {
            Self::Translational | Self::Rotational => &[
                ('k', Element::Spring),
                ('c', Element::Damper),
                ('b', Element::Inerter),
                ('m', Element::Mass),
            ],
            Self::Electrical => &[
                ('R', Element::Damper),
                ('L', Element::Spring),
                ('C', Element::Inerter),
            ],
            Self::Hydraulic => &[
                ('R', Element::Damper),
                ('I', Element::Inerter),
                ('C', Element::Spring),
            ],
        }
    }

    /// The letter of an element in this domain; none for a mass outside mechanics.
    #[must_use]
    pub fn letter(self, element: Element) -> Option<char> {
        self.letters()
            .iter()
            .find(|(_, known)| *known == element)
            .map(|(letter, _)| *letter)
    }

    /// The element that a letter stands for in this domain.
    #[must_use]
    pub fn element(self, letter: char) -> Option<Element> {
        self.letters()
            .iter()
            .find(|(known, _)| *known == letter)
            .map(|(_, element)| *element)
    }

    /// What an engineer of this domain calls the element.
    #[must_use]
    pub const fn element_name(self, element: Element) -> &'static str {
        match (self, element) {
            (Self::Electrical, Element::Spring) => "inductor",
            (Self::Electrical, Element::Damper) => "resistor",
            (Self::Electrical, Element::Inerter) => "capacitor",
            (Self::Hydraulic, Element::Spring) => "compliance",
            (Self::Hydraulic, Element::Damper) => "resistance",
            (Self::Hydraulic, Element::Inerter) => "inertance",
            (_, Element::Spring) => "spring",
            (_, Element::Damper) => "damper",
            (_, Element::Inerter) => "inerter",
            (_, Element::Mass) => "mass",
        }
    }

    /// SI dimension of the element's value in this domain.
    #[must_use]
    pub const fn dimension(self, element: Element) -> Dimension {
        match (self, element) {
            (Self::Translational, Element::Spring) => Dimension::STIFFNESS,
            (Self::Translational, Element::Damper) => Dimension::DAMPING,
            (Self::Translational, Element::Inerter | Element::Mass) => Dimension::MASS,
            (Self::Rotational, Element::Spring) => Dimension::ROTATIONAL_STIFFNESS,
            (Self::Rotational, Element::Damper) => Dimension::ROTATIONAL_DAMPING,
            (Self::Rotational, Element::Inerter | Element::Mass) => Dimension::ROTATIONAL_INERTIA,
            (Self::Electrical, Element::Spring) => Dimension::with_current(1, 2, -2, -2),
            (Self::Electrical, Element::Damper) => Dimension::with_current(1, 2, -3, -2),
            (Self::Electrical, Element::Inerter | Element::Mass) => {
                Dimension::with_current(-1, -2, 4, 2)
            }
            (Self::Hydraulic, Element::Spring) => Dimension::new(-1, 4, 2, 0),
            (Self::Hydraulic, Element::Damper) => Dimension::new(1, -4, -1, 0),
            (Self::Hydraulic, Element::Inerter | Element::Mass) => Dimension::new(1, -4, 0, 0),
        }
    }

    /// SI unit of the element's value as text: `N/m`, `N*m*s/rad`, `H`, `kg/(s*m^4)` …
    #[must_use]
    pub const fn unit(self, element: Element) -> &'static str {
        match (self, element) {
            (Self::Translational, Element::Spring) => "N/m",
            (Self::Translational, Element::Damper) => "N*s/m",
            (Self::Translational, Element::Inerter | Element::Mass) => "kg",
            (Self::Rotational, Element::Spring) => "N*m/rad",
            (Self::Rotational, Element::Damper) => "N*m*s/rad",
            (Self::Rotational, Element::Inerter | Element::Mass) => "kg*m^2",
            (Self::Electrical, Element::Spring) => "H",
            (Self::Electrical, Element::Damper) => "ohm",
            (Self::Electrical, Element::Inerter | Element::Mass) => "F",
            (Self::Hydraulic, Element::Spring) => "m^5/N",
            (Self::Hydraulic, Element::Damper) => "kg/(s*m^4)",
            (Self::Hydraulic, Element::Inerter | Element::Mass) => "kg/m^4",
        }
    }

    /// Whether a series group of this domain is a parallel group of the mechanical network.
    #[must_use]
    pub const fn swaps_groups(self) -> bool {
        matches!(self, Self::Hydraulic)
    }

    /// Whether the mechanical value is the factor over (rather than times) the value in this domain.
    ///
    /// mechanical = factor · own, or factor / own: electrical L gives k = 1/L and R gives c = 1/R (force-current
    /// analogy, Firestone 1933), hydraulic C gives k = Ap²/C.
    #[must_use]
    pub const fn inverts(self, element: Element) -> bool {
        matches!(
            (self, element),
            (Self::Electrical, Element::Spring | Element::Damper)
                | (Self::Hydraulic, Element::Spring)
        )
    }

    /// Whether like elements of this domain add up in a series group (rather than in a parallel one).
    #[must_use]
    pub const fn adds_in_series(self, element: Element) -> bool {
        self.inverts(element) != self.swaps_groups()
    }
}

impl fmt::Display for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Translational => "translational",
            Self::Rotational => "rotational",
            Self::Electrical => "electrical",
            Self::Hydraulic => "hydraulic",
        })
    }
}

#[cfg(test)]
mod tests {
    use quell_expression::Unit;

    use super::*;

    #[test]
    fn units_have_their_dimensions() {
        for domain in Domain::ALL {
            for (letter, element) in domain.letters() {
                let unit = Unit::parse(domain.unit(*element)).unwrap();
                assert_eq!(
                    unit.dimension,
                    domain.dimension(*element),
                    "{domain} {letter}"
                );
                assert_eq!(unit.factor, 1.0);
                assert_eq!(domain.element(*letter), Some(*element));
                assert_eq!(domain.letter(*element), Some(*letter));
            }
        }
    }
}
