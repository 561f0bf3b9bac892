//! The immittance route: devices that are a positive-real function Y(s) of given order, before anybody knows the network.
//!
//! With E = 1 every coefficient of a biquadratic has a meaning of its own,
//!
//! ```text
//! Y(s) = (b s² + (c + c0) s + k)/(τ s² + s + ρ),   c0 = (√(b ρ) - √(k τ))²
//! ```
//!
//! with Y force over velocity. It is positive-real if and only if b, k, τ, ρ and c are at least zero (Chen and Smith 2009), so that
//! a search over these needs no constraint and reaches every positive-real biquadratic with E > 0. The bilinear functions are those
//! with b = τ = 0 or τ = ρ = 0.
//!
//! A bicubic is given by its poles and by where it takes up no power. With D the polynomial of the poles, all in the left half plane,
//! Y = N/D is positive-real if and only if Re Y(jω) = |P(jω)|²/|D(jω)|² for a polynomial P, and N follows from D and P by
//! comparing powers in N(s) D(-s) + N(-s) D(s) = 2 P(s) P(-s) (Brune 1931; Gewertz 1933):
//!
//! ```text
//! D(s) = (s + ρ)(s² + 2 ζ ω s + ω²),   P(s) = √c (s + ρ0)(s² + 2 ζ0 ω0 s + ω0²),   c = Y(∞)
//! ```
//!
//! Seven values at least zero, no further condition, and every positive-real bicubic without poles on the axis; those with such
//! poles are limits.
//!
//! In a system Y stands as the network of its partial continued fraction, whose elements may have values of either sign: exact,
//! with as many states as Y has poles. A pole of Y at infinity is an inerter beside the rest, a form of its own.

use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::Source;
use quell_expression::{Expression, ExpressionError, Span};
use quell_network::{Domain, Element, Layout, RationalError, RationalFunction};

use crate::amount::Amount;
use crate::study::{Bounds, Component};

/// A form of an admittance with design variables for coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// (c s + k)/(s + ρ).
    Bilinear,
    /// b s + c.
    BilinearInerter,
    /// The whole of the above.
    Biquadratic,
    /// With τ = 0: a pole at infinity.
    BiquadraticInerter,
    /// Three poles in the left half plane.
    Bicubic,
    /// Two, and one at infinity: b s besides.
    BicubicInerter,
}

/// A bicubic over its value at infinity: powers of s, the highest first and 1.
struct Cubic {
    /// a2, a1, a0 of s³ + a2 s² + a1 s + a0.
    denominator: [f64; 3],
    /// n2, n1, n0 of s³ + n2 s² + n1 s + n0.
    numerator: [f64; 3],
}

impl Form {
    /// The forms of an order that study files name.
    pub(crate) fn of(order: &str) -> &'static [Self] {
        match order {
            "bilinear" => &[Self::Bilinear, Self::BilinearInerter],
            "bicubic" => &[Self::Bicubic, Self::BicubicInerter],
            _ => &[Self::Biquadratic, Self::BiquadraticInerter],
        }
    }

    /// The names of the orders in study files.
    pub(crate) const ORDERS: [&'static str; 3] = ["bilinear", "biquadratic", "bicubic"];

    /// What instances are called in layouts: `biquadratic1`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bilinear => "bilinear",
            Self::BilinearInerter => "bilinear_b",
            Self::Biquadratic => "biquadratic",
            Self::BiquadraticInerter => "biquadratic_b",
            Self::Bicubic => "bicubic",
            Self::BicubicInerter => "bicubic_b",
        }
    }

    /// Names of the coefficients that are design variables.
    pub(crate) const fn variables(self) -> &'static [&'static str] {
        match self {
            Self::Bilinear => &["c", "k", "rho"],
            Self::BilinearInerter => &["b", "c"],
            Self::Biquadratic => &["b", "c", "k", "tau", "rho"],
            Self::BiquadraticInerter => &["b", "c", "k", "rho"],
            Self::Bicubic => &["c", "rho", "omega", "zeta", "rho0", "omega0", "zeta0"],
            Self::BicubicInerter => &["b", "c", "omega", "zeta", "omega0", "zeta0"],
        }
    }

    const fn layout(self) -> &'static str {
        match self {
            Self::Bilinear => "c1 | k1 + c2",
            Self::BilinearInerter => "c1 | b1",
            Self::Biquadratic => "c1 | k1 + c2 + (b1 | c3)",
            Self::BiquadraticInerter => "c1 | b1 | k1 + c2",
            Self::Bicubic => "c1 | k1 + c2 + (b1 | c3 | k2 + c4)",
            Self::BicubicInerter => "c1 | b2 | k1 + c2 + (b1 | c3)",
        }
    }

    /// The elements of the layout in terms of the variables.
    ///
    /// `radian` is the unit by which an inertance times a rate differs from a damping: 1 rad of a rotational device.
    fn values(self, radian: &str) -> Vec<(&'static str, String)> {
        let own = |text: &str| text.to_owned();
        match self {
            Self::Bilinear => vec![
                ("c1", own("c")),
                ("k1", own("k - c*rho")),
                ("c2", own("(k - c*rho)/rho")),
            ],
            Self::BilinearInerter => vec![("c1", own("c")), ("b1", own("b"))],
            Self::BiquadraticInerter => vec![
                ("c1", own("c")),
                ("b1", own("b")),
                ("k1", own("k - c*rho")),
                ("c2", own("(k - c*rho)/rho")),
            ],
            Self::Bicubic => {
                // Y/c = 1 + R/D, D/R = s/r2 + z + G/R, R/G = r2 s/g1 + y + w/G.
                let [a2, a1, a0] = [
                    "rho + 2*zeta*omega",
                    "omega^2 + 2*zeta*omega*rho",
                    "rho*omega^2",
                ];
                let [q2, q1, q0] = [
                    "rho0 + 2*zeta0*omega0",
                    "omega0^2 + 2*zeta0*omega0*rho0",
                    "rho0*omega0^2",
                ];
                let n0 = format!("(({q0})^2/({a0}))");
                let fourth = format!("(({q2})^2 - 2*({q1}))");
                let second = format!("(2*({q0})*({q2}) - ({q1})^2)");
                let n2 = format!(
                    "(({n0}*({a2}) + ({a1})*({a1} + {fourth}) - {second})/(({a1})*({a2}) - {a0}))"
                );
                let r2 = format!("({n2} - ({a2}))");
                let r1 = format!("({n2}*({a2}) - 2*({a1}) - {fourth})");
                let r0 = format!("({n0} - {a0})");
                let z = format!("(({a2} - {r1}/{r2})/{r2})");
                let g1 = format!("({a1} - {r0}/{r2} - {z}*{r1})");
                let g0 = format!("({a0} - {z}*{r0})");
                let y = format!("(({r1} - {r2}*{g0}/{g1})/{g1})");
                let w = format!("({r0} - {y}*{g0})");
                vec![
                    ("c1", own("c")),
                    ("k1", format!("c*{r2}")),
                    ("c2", format!("c/{z}")),
                    ("b1", format!("c*{r2}/{g1}*{radian}")),
                    ("c3", format!("c*{y}")),
                    ("k2", format!("c*{w}/{g1}")),
                    ("c4", format!("c*{w}/{g0}")),
                ]
            }
            Self::BicubicInerter => {
                // Y/c = b s/c + 1 + R/D, D/R = s/r1 + z + g/R.
                let [a1, a0] = ["2*zeta*omega", "omega^2"];
                let [q1, q0] = ["2*zeta0*omega0", "omega0^2"];
                let n0 = format!("(({q0})^2/{a0})");
                let n1 = format!("(({a0} + {n0} + ({q1})^2 - 2*{q0})/({a1}))");
                let r1 = format!("({n1} - {a1})");
                let r0 = format!("({n0} - {a0})");
                let z = format!("(({a1} - {r0}/{r1})/{r1})");
                let g = format!("({a0} - {z}*{r0})");
                vec![
                    ("c1", own("c")),
                    ("b2", own("b")),
                    ("k1", format!("c*{r1}")),
                    ("c2", format!("c/{z}")),
                    ("b1", format!("c*{r1}/{g}*{radian}")),
                    ("c3", format!("c*{r0}/{g}")),
                ]
            }
            Self::Biquadratic => {
                // Y = b/τ + (p s + q)/(τ s² + s + ρ), and (τ s² + s + ρ)/(p s + q) = τ s/p + r + g/(p s + q).
                let inertance = format!("(b/{radian})");
                let damping = format!("((sqrt({inertance}*rho) - sqrt(k*tau))^2 + c)");
                let p = format!("({damping} - {inertance}/tau)");
                let q = format!("(k - {inertance}*rho/tau)");
                let r = format!("((1 - {q}*tau/{p})/{p})");
                let g = format!("(rho - {q}*{r})");
                vec![
                    ("c1", format!("{inertance}/tau")),
                    ("k1", format!("{p}/tau")),
                    ("c2", format!("1/{r}")),
                    ("b1", format!("{p}/{g}*{radian}")),
                    ("c3", format!("{q}/{g}")),
                ]
            }
        }
    }

    /// The form as a component of a study; its variables have no range of their own.
    ///
    /// # Errors
    /// None that can occur: every text above reads.
    pub(crate) fn component(
        self,
        domain: Domain,
        source: &Arc<Source>,
        span: Span,
    ) -> Result<Component, ExpressionError> {
        let amount = |text: &str| -> Result<Amount, ExpressionError> {
            let expression = Expression::parse(text)?.map(&|_| span, &str::to_owned);
            Ok(Amount::from_expression(expression, source))
        };
        let kinds = quell_network::Kinds::new(domain);
        let layout = Layout::parse(self.layout(), &kinds)
            .map_err(|error| ExpressionError::new(span, error.message))?;
        let radian = match domain {
            Domain::Rotational => "(1 rad)",
            _ => "1",
        };
        let mut variables = IndexMap::new();
        for name in self.variables() {
            // The dimension is what counts here: a task gives the range. Numbers differ, lest a difference of them vanish
            // where the expressions are tried.
            let (nominal, unit) = match *name {
                "b" => (1, domain.unit(Element::Inerter)),
                "c" => (3, domain.unit(Element::Damper)),
                "k" => (5, domain.unit(Element::Spring)),
                "tau" => (7, "s"),
                "zeta" => (1, ""),
                "zeta0" => (2, ""),
                "omega" => (3, "1/s"),
                "rho0" => (5, "1/s"),
                "omega0" => (13, "1/s"),
                _ => (11, "1/s"),
            };
            let bounds = Bounds {
                lower: amount(&format!("{nominal} {unit}"))?,
                upper: amount(&format!("{nominal} {unit}"))?,
                scale: None,
                span,
            };
            variables.insert((*name).to_owned(), bounds);
        }
        Ok(Component {
            domain,
            layout,
            values: self
                .values(radian)
                .into_iter()
                .map(|(name, text)| Ok((name.to_owned(), amount(&text)?)))
                .collect::<Result<_, ExpressionError>>()?,
            variables,
        })
    }

    /// Y(s) of values of the variables by name, SI.
    ///
    /// # Errors
    /// Values that are not finite.
    pub(crate) fn function(
        self,
        value: impl Fn(&str) -> f64,
    ) -> Result<RationalFunction, RationalError> {
        let of = |name: &str| {
            if self.variables().contains(&name) {
                value(name)
            } else {
                0.0
            }
        };
        let (b, c, k, tau, rho) = (of("b"), of("c"), of("k"), of("tau"), of("rho"));
        let least = ((b * rho).sqrt() - (k * tau).sqrt()).powi(2);
        // Powers of s, the lowest first.
        let (numerator, denominator) = match self {
            Self::Bilinear => (vec![k, c], vec![rho, 1.0]),
            Self::BilinearInerter => (vec![c, b], vec![1.0]),
            Self::Biquadratic => (vec![k, c + least, b], vec![rho, 1.0, tau]),
            Self::BiquadraticInerter => (vec![k, c + least, b], vec![rho, 1.0]),
            Self::Bicubic => {
                let cubic = Cubic::of(of);
                let [a2, a1, a0] = cubic.denominator;
                let [n2, n1, n0] = cubic.numerator.map(|entry| c * entry);
                (vec![n0, n1, n2, c], vec![a0, a1, a2, 1.0])
            }
            Self::BicubicInerter => {
                let (a1, a0) = (2.0 * of("zeta") * of("omega"), of("omega").powi(2));
                let (q1, q0) = (2.0 * of("zeta0") * of("omega0"), of("omega0").powi(2));
                let n0 = q0 * q0 / a0;
                let n1 = (a0 + n0 + q1 * q1 - 2.0 * q0) / a1;
                let numerator = vec![c * n0, c * n1 + b * a0, c + b * a1, b];
                (numerator, vec![a0, a1, 1.0])
            }
        };
        RationalFunction::new(numerator, denominator)
    }
}

impl Cubic {
    /// From the poles and the zeros of the real part.
    fn of(value: impl Fn(&str) -> f64) -> Self {
        let factors = |rho: f64, omega: f64, zeta: f64| {
            [
                rho + 2.0 * zeta * omega,
                omega * omega + 2.0 * zeta * omega * rho,
                rho * omega * omega,
            ]
        };
        let [a2, a1, a0] = factors(value("rho"), value("omega"), value("zeta"));
        let [q2, q1, q0] = factors(value("rho0"), value("omega0"), value("zeta0"));
        // Powers s⁰, s⁴ and s² of N(s) D(-s) + N(-s) D(s) = 2 P(s) P(-s).
        let n0 = q0 * q0 / a0;
        let fourth = q2 * q2 - 2.0 * q1;
        let second = 2.0 * q0 * q2 - q1 * q1;
        let n2 = (n0 * a2 + a1 * (a1 + fourth) - second) / (a1 * a2 - a0);
        let n1 = n2 * a2 - a1 - fourth;
        Self {
            denominator: [a2, a1, a0],
            numerator: [n2, n1, n0],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex64;
    use quell_network::{POSITIVE_REAL_TOLERANCE, expand};

    /// The network that stands in a system has the admittance that is synthesised, and that is positive-real.
    #[test]
    fn networks_with_signed_values_are_the_function() {
        let forms = [
            Form::Bilinear,
            Form::BilinearInerter,
            Form::Biquadratic,
            Form::BiquadraticInerter,
            Form::Bicubic,
            Form::BicubicInerter,
        ];
        let source = Arc::new(Source::new("study", String::new()));
        // Values over which signs of the elements change.
        for (b, c, k, tau, rho) in [
            (13.3, 5e3, 1.2e5, 1e-4, 25.0),
            (50.0, 1.0, 4e5, 0.02, 300.0),
            (0.1, 800.0, 3e3, 0.5, 0.01),
            (2.0, 0.0, 7e4, 1e-2, 90.0),
        ] {
            for (form, domain) in forms.into_iter().flat_map(|form| {
                [Domain::Rotational, Domain::Translational].map(|domain| (form, domain))
            }) {
                let component = form.component(domain, &source, Span::default()).unwrap();
                // Some of everything above for the coefficients of bicubics.
                let known = [
                    ("b", b),
                    ("c", c + 1.0),
                    ("k", k),
                    ("tau", tau),
                    ("rho", rho),
                    ("omega", 30.0 + b),
                    ("zeta", 10.0 * tau + 0.01),
                    ("rho0", 0.3 * rho + 2.0),
                    ("omega0", f64::sqrt(k / 10.0)),
                    ("zeta0", 1.0 / (1.0 + b)),
                ];
                let value = |name: &str| known.iter().find(|(one, _)| *one == name).unwrap().1;
                let function = form.function(value).unwrap();
                let verdict = function.positive_real(POSITIVE_REAL_TOLERANCE);
                assert!(verdict.is_positive_real(), "{form:?}: {verdict}");
                let instance = quell_network::Component {
                    name: form.name().to_owned(),
                    layout: component.layout.clone(),
                    variables: component
                        .variables
                        .iter()
                        .map(|(name, bounds)| {
                            let nominal =
                                bounds.lower.quantity(&quell_expression::NoNames).unwrap();
                            quell_network::ComponentVariable {
                                name: name.clone(),
                                dimension: nominal.dimension,
                                sample: nominal.value,
                            }
                        })
                        .collect(),
                    values: component
                        .values
                        .iter()
                        .map(|(name, amount)| (name.clone(), amount.expression().clone()))
                        .collect(),
                };
                let mut kinds = quell_network::Kinds::new(domain);
                kinds.declare_component(form.name()).unwrap();
                let layout = Layout::parse(&format!("{}1", form.name()), &kinds).unwrap();
                let expansion =
                    expand(&layout, &[instance], None, &quell_expression::NoNames).unwrap();
                let values: Vec<f64> = expansion
                    .variables()
                    .iter()
                    .map(|variable| value(variable.name.split('.').nth(1).unwrap()))
                    .collect();
                let mut elements = vec![0.0; expansion.network().elements().len()];
                let mut workspace = quell_network::ExpansionWorkspace::default();
                expansion.values(&values, &mut workspace, &mut elements);
                let admittance = expansion.network().admittance(&elements);
                for omega in [0.3, 20.0, 90.0, 4e3] {
                    let s = Complex64::new(0.0, omega);
                    let network = admittance.evaluate(s);
                    let wanted = function.evaluate(s);
                    assert!(
                        (network - wanted).norm() <= 1e-9 * wanted.norm(),
                        "{form:?} at {omega}: {network}, {wanted}"
                    );
                }
            }
        }
    }
}
