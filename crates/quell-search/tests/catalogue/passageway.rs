//! Fluid networks of tracks and restrictions between two chambers: the case that sized this crate's budgets.
//!
//! Model, parameters and networks: Y. Li, doctoral thesis on passive vibration suppressors with inerters, chapter 6
//! (the floating plate blocked; rubber damping 105 N s/m). Minimise the largest displacement transmissibility up to
//! 30 Hz over the tracks' relative lengths and areas and the restrictions' relative resistances.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use super::peaks::{Peaks, Response, grid};
use num_complex::Complex64;
use quell_search::{Scale, Variable};

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Network {
    Restriction,
    Track,
    Series(Vec<Network>),
    Parallel(Vec<Network>),
}

impl Network {
    fn size(&self) -> usize {
        match self {
            Self::Track | Self::Restriction => 1,
            Self::Series(parts) | Self::Parallel(parts) => parts.iter().map(Self::size).sum(),
        }
    }

    fn tracks(&self) -> usize {
        match self {
            Self::Track => 1,
            Self::Restriction => 0,
            Self::Series(parts) | Self::Parallel(parts) => parts.iter().map(Self::tracks).sum(),
        }
    }

    fn reducible(&self) -> bool {
        match self {
            Self::Track | Self::Restriction => false,
            Self::Series(parts) | Self::Parallel(parts) => {
                parts
                    .iter()
                    .filter(|part| **part == Self::Restriction)
                    .count()
                    > 1
                    || parts.iter().any(Self::reducible)
            }
        }
    }

    pub fn text(&self) -> String {
        let join = |parts: &[Self], sign: &str| {
            let parts: Vec<String> = parts.iter().map(Self::text).collect();
            format!("({})", parts.join(sign))
        };
        match self {
            Self::Track => "I".into(),
            Self::Restriction => "O".into(),
            Self::Series(parts) => join(parts, "+"),
            Self::Parallel(parts) => join(parts, "|"),
        }
    }

    fn variables(&self, variables: &mut Vec<Variable>) {
        match self {
            Self::Track => {
                variables.push(Variable::new("length", 0.5, 1.5, Scale::Linear).unwrap());
                variables.push(Variable::new("area", 0.5, 1.5, Scale::Linear).unwrap());
            }
            Self::Restriction => {
                variables.push(Variable::new("resistance", 1e-2, 1e3, Scale::Logarithmic).unwrap())
            }
            Self::Series(parts) | Self::Parallel(parts) => {
                parts.iter().for_each(|part| part.variables(variables))
            }
        }
    }

    /// Impedance, the variables used from `next` on, and (with `gradient`) derivatives of the impedance.
    fn impedance(
        &self,
        s: Complex64,
        point: &[f64],
        next: &mut usize,
        gradient: &mut Option<&mut [Complex64]>,
    ) -> Complex64 {
        const INERTANCE: f64 = 3.8e6;
        const RESISTANCE: f64 = 1.05e8;
        match self {
            Self::Track => {
                let (length, area) = (point[*next], point[*next + 1]);
                let z = s * (INERTANCE * length / area) + RESISTANCE * length / (area * area);
                if let Some(gradient) = gradient {
                    gradient[*next] = z / length;
                    gradient[*next + 1] = -s * (INERTANCE * length / (area * area))
                        - 2.0 * RESISTANCE * length / area.powi(3);
                }
                *next += 2;
                z
            }
            Self::Restriction => {
                if let Some(gradient) = gradient {
                    gradient[*next] = Complex64::new(RESISTANCE, 0.0);
                }
                *next += 1;
                Complex64::new(point[*next - 1] * RESISTANCE, 0.0)
            }
            Self::Series(parts) => parts
                .iter()
                .map(|part| part.impedance(s, point, next, gradient))
                .sum(),
            Self::Parallel(parts) => {
                let first = *next;
                let mut admittance = Complex64::new(0.0, 0.0);
                for part in parts {
                    let from = *next;
                    let y = 1.0 / part.impedance(s, point, next, gradient);
                    if let Some(gradient) = gradient {
                        gradient[from..*next].iter_mut().for_each(|g| *g *= y * y);
                    }
                    admittance += y;
                }
                let z = 1.0 / admittance;
                if let Some(gradient) = gradient {
                    gradient[first..*next].iter_mut().for_each(|g| *g *= z * z);
                }
                z
            }
        }
    }
}

impl Response for Network {
    fn response(
        &self,
        _: usize,
        omega: f64,
        point: &[f64],
        mut gradient: Option<&mut [Complex64]>,
    ) -> Complex64 {
        let (mass, stiffness, damping, piston) = (60.0, 2.25e5, 105.0, 2.5e-3);
        let (upper, lower) = (3.0e-11, 2.6e-9);
        let s = Complex64::new(0.0, omega);
        let z = self.impedance(s, point, &mut 0, &mut gradient) + 1.0 / (lower * s);
        let compliance = 1.0 + upper * s * z;
        let inertia = mass * s * s;
        let sum = inertia + damping * s + stiffness + piston * piston * s * z / compliance;
        let td = -inertia / sum;
        if let Some(gradient) = gradient {
            let by_impedance = -td / sum * piston * piston * s / (compliance * compliance);
            gradient.iter_mut().for_each(|g| *g *= by_impedance);
        }
        td
    }
}

/// All networks of `size` passageways with at least one track and no two restrictions side by side in one group:
/// 1, 4, 12, 42 for 1 to 4.
pub fn networks(size: usize) -> Vec<Network> {
    all(size)
        .into_iter()
        .filter(|network| network.tracks() > 0 && !network.reducible())
        .collect()
}

fn all(size: usize) -> BTreeSet<Network> {
    let mut found = BTreeSet::new();
    if size == 1 {
        found.insert(Network::Track);
        found.insert(Network::Restriction);
        return found;
    }
    let smaller: Vec<Network> = (1..size).flat_map(all).collect();
    for series in [true, false] {
        let parts: Vec<&Network> = smaller
            .iter()
            .filter(|part| {
                !matches!(
                    (part, series),
                    (Network::Series(_), true) | (Network::Parallel(_), false)
                )
            })
            .collect();
        let mut chosen = Vec::new();
        multisets(&parts, 0, size, &mut chosen, &mut |chosen| {
            let chosen: Vec<Network> = chosen.iter().map(|&part| part.clone()).collect();
            found.insert(if series {
                Network::Series(chosen)
            } else {
                Network::Parallel(chosen)
            });
        });
    }
    found
}

fn multisets<'a>(
    parts: &[&'a Network],
    from: usize,
    size: usize,
    chosen: &mut Vec<&'a Network>,
    give: &mut dyn FnMut(&[&'a Network]),
) {
    if size == 0 {
        if chosen.len() > 1 {
            give(chosen);
        }
        return;
    }
    for index in from..parts.len() {
        if parts[index].size() <= size {
            chosen.push(parts[index]);
            multisets(parts, index, size - parts[index].size(), chosen, give);
            chosen.pop();
        }
    }
}

pub fn passageway(network: &Network, gradients: bool) -> Peaks<Network> {
    let mut variables = Vec::new();
    network.variables(&mut variables);
    Peaks {
        variables,
        grid: grid(2.0 * PI * 0.5, 2.0 * PI * 30.0, 120),
        response: network.clone(),
        limits: Vec::new(),
        gradients,
        refined: true,
    }
}
