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
}

impl Form {
    /// The forms of an order that study files name.
    pub(crate) fn of(order: &str) -> &'static [Self] {
        match order {
            "bilinear" => &[Self::Bilinear, Self::BilinearInerter],
            _ => &[Self::Biquadratic, Self::BiquadraticInerter],
        }
    }

    /// The names of the orders in study files.
    pub(crate) const ORDERS: [&'static str; 2] = ["bilinear", "biquadratic"];

    /// What instances are called in layouts: `biquadratic1`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bilinear => "bilinear",
            Self::BilinearInerter => "bilinear_b",
            Self::Biquadratic => "biquadratic",
            Self::BiquadraticInerter => "biquadratic_b",
        }
    }

    /// Names of the coefficients that are design variables.
    pub(crate) const fn variables(self) -> &'static [&'static str] {
        match self {
            Self::Bilinear => &["c", "k", "rho"],
            Self::BilinearInerter => &["b", "c"],
            Self::Biquadratic => &["b", "c", "k", "tau", "rho"],
            Self::BiquadraticInerter => &["b", "c", "k", "rho"],
        }
    }

    const fn layout(self) -> &'static str {
        match self {
            Self::Bilinear => "c1 | k1 + c2",
            Self::BilinearInerter => "c1 | b1",
            Self::Biquadratic => "c1 | k1 + c2 + (b1 | c3)",
            Self::BiquadraticInerter => "c1 | b1 | k1 + c2",
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
        };
        RationalFunction::new(numerator, denominator)
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
                let known = [("b", b), ("c", c), ("k", k), ("tau", tau), ("rho", rho)];
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
