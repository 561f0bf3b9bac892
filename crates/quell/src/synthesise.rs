//! `quell synthesise`: from an admittance in s to networks with values.

use std::fmt::Write as _;

use quell_expression::{BinaryOperator, Expression, ExpressionError, Node, Span};
use quell_network::{
    Form, Matching, POSITIVE_REAL_TOLERANCE, RationalFunction, Realisation, SynthesisError,
    bott_duffin, brune, canonical, reduced_bott_duffin,
};

use crate::arguments::SynthesisOptions;
use crate::shortlist::WIDTH;
use crate::table::Table;
use crate::terminal::{self, Exit};

/// Largest power of s: beyond it coefficients say little about roots.
const MOST_POWER: f64 = 20.0;

pub(crate) fn synthesise(options: &SynthesisOptions) -> Result<(), Exit> {
    let asked = Expression::parse(&options.function)
        .and_then(|expression| rational(&expression))
        .map_err(|error| Exit::Asked(pointed(&options.function, &error)))?;
    if asked.is_zero() {
        return Err(Exit::Asked(
            "the function is zero, so that there is nothing to build".to_owned(),
        ));
    }
    let admittance = if options.impedance {
        asked.reciprocal()
    } else {
        asked
    };
    let admittance = admittance.in_lowest_terms(1e-12);
    let mut text = format!("Y(s) = {admittance}   (force over velocity, N s/m)\n");
    let verdict = admittance.positive_real(POSITIVE_REAL_TOLERANCE);
    let _ = writeln!(text, "{verdict}");
    let target = if verdict.is_positive_real() {
        admittance
    } else if options.nearest {
        let nearest = admittance
            .nearest_positive_real(POSITIVE_REAL_TOLERANCE)
            .map_err(|error| Exit::Asked(format!("{text}{error}")))?;
        let _ = writeln!(
            text,
            "\nnearest positive-real function: Y(s) = {}\nat most {:.6e} from it at any frequency; none is nearer than {:.6e}",
            nearest.function, nearest.distance, nearest.bound
        );
        nearest.function
    } else {
        text.push_str(
            "no passive device has this admittance; --nearest gives the nearest that one has\n",
        );
        return terminal::print(&text);
    };
    text.push('\n');
    text.push_str(&networks(&target, usize::from(options.most)));
    terminal::print(&text)
}

/// A table of what each method yields, with the values under each network.
fn networks(target: &RationalFunction, most: usize) -> String {
    let heading = ["elements", "method", "residual", "network"];
    let mut table = Table::new(heading.map(str::to_owned).to_vec(), 2);
    let smallest = Matching {
        most_elements: most,
        ..Matching::default()
    };
    let mut rows: Vec<Realisation> = Vec::new();
    let mut without: Vec<String> = Vec::new();
    let mut add = |method: &str, found: Result<Vec<Realisation>, SynthesisError>| match found {
        Ok(found) => rows.extend(found),
        Err(SynthesisError::NotTwoKinds) => {}
        Err(error) => without.push(format!("{method}: {error}")),
    };
    add(
        "matching",
        smallest.smallest(target).map(|found| found.realisations),
    );
    for form in Form::ALL {
        add(
            &form.to_string(),
            canonical(target, form).map(|one| vec![one]),
        );
    }
    add("Brune", brune(target).map(|one| vec![one]));
    add("Bott-Duffin", bott_duffin(target).map(|one| vec![one]));
    add(
        "reduced Bott-Duffin",
        reduced_bott_duffin(target).map(|one| vec![one]),
    );
    rows.sort_by_key(|row| {
        let elements = row.structure.elements();
        (elements.levers, elements.total())
    });
    let mut listed: Vec<(String, Vec<(String, f64)>)> = Vec::new();
    for row in rows {
        let network = row.structure.to_string();
        let values = row.structure.values();
        // Two methods may end in one network.
        if listed
            .iter()
            .any(|(name, known)| *name == network && same(known, &values))
        {
            continue;
        }
        let words: Vec<String> = values
            .iter()
            .map(|(name, value)| worded(name, *value))
            .collect();
        table.row(
            vec![
                row.structure.elements().to_string(),
                row.method.to_string(),
                format!("{:.1e}", row.residual),
                network.clone(),
            ],
            vec![words.join(", ")],
        );
        listed.push((network, values));
    }
    let mut text = String::new();
    if !listed.is_empty() {
        text.push_str(&table.text(2, WIDTH));
    }
    for reason in without {
        let _ = writeln!(text, "{reason}");
    }
    text
}

fn same(one: &[(String, f64)], other: &[(String, f64)]) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs().max(b.abs());
    one.len() == other.len()
        && one
            .iter()
            .zip(other)
            .all(|(a, b)| a.0 == b.0 && near(a.1, b.1))
}

fn worded(name: &str, value: f64) -> String {
    let unit = match name.chars().next() {
        Some('k') => "\u{a0}N/m",
        Some('c') => "\u{a0}N·s/m",
        Some('b') => "\u{a0}kg",
        _ => "",
    };
    let number = if value != 0.0 && !(1e-4..1e7).contains(&value.abs()) {
        format!("{value:.5e}")
    } else {
        let digits = 5 - value.abs().max(1e-4).log10().floor() as i32;
        let text = format!("{value:.*}", usize::try_from(digits).unwrap_or(0));
        match text.split_once('.') {
            Some(_) => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
            None => text,
        }
    };
    format!("{name}\u{a0}=\u{a0}{number}{unit}")
}

/// A rational function of s from an expression of numbers and `s`.
fn rational(expression: &Expression) -> Result<RationalFunction, ExpressionError> {
    let refused = |message: &str, help: &str| {
        Err(ExpressionError::new(expression.span, message).with_help(help))
    };
    match &expression.node {
        Node::Number(value) => polynomial(expression.span, vec![*value]),
        Node::Name(name) if name == "s" => polynomial(expression.span, vec![0.0, 1.0]),
        Node::Name(name) => refused(
            &format!("`{name}` has no value here"),
            "a function is written with numbers and `s`, as in `(s^2 + s + 1)/(s^2 + s + 4)`",
        ),
        Node::Negate(inner) => Ok(rational(inner)?.times(-1.0)),
        Node::Binary {
            operator: BinaryOperator::Power,
            left,
            right,
        } => match right.node {
            Node::Number(power) if power.fract() == 0.0 && (0.0..=MOST_POWER).contains(&power) => {
                let base = rational(left)?;
                let mut result = RationalFunction::constant(1.0);
                for _ in 0..power as usize {
                    result = multiplied(expression.span, &result, &base)?;
                }
                Ok(result)
            }
            _ => Err(ExpressionError::new(
                right.span,
                "a power here is a whole number from 0 to 20",
            )),
        },
        Node::Binary {
            operator,
            left,
            right,
        } => {
            let (a, b) = (rational(left)?, rational(right)?);
            match operator {
                BinaryOperator::Add => Ok(a.plus(&b, 1.0)),
                BinaryOperator::Subtract => Ok(a.plus(&b, -1.0)),
                BinaryOperator::Multiply => multiplied(expression.span, &a, &b),
                _ if b.is_zero() => Err(ExpressionError::new(right.span, "this is zero")),
                _ => multiplied(expression.span, &a, &b.reciprocal()),
            }
        }
        // `4 s^2` reads as so many square seconds; here s is the variable.
        Node::Quantity { value, unit } => match power_of_s(&unit.text) {
            Some(power) => {
                let mut coefficients = vec![0.0; power];
                coefficients.push(*value);
                polynomial(expression.span, coefficients)
            }
            None => refused(
                "coefficients are plain SI numbers",
                "leave the unit out: forces in N, velocities in m/s, s in 1/s",
            ),
        },
        _ => refused(
            "this is no rational function of `s`",
            "`+`, `-`, `*`, `/`, `^` and brackets make one",
        ),
    }
}

/// n of `s^n`, written as a unit.
fn power_of_s(text: &str) -> Option<usize> {
    match text.strip_prefix('s')? {
        "" => Some(1),
        "²" => Some(2),
        "³" => Some(3),
        rest => rest
            .strip_prefix('^')?
            .trim()
            .parse()
            .ok()
            .filter(|power| *power <= MOST_POWER as usize),
    }
}

fn polynomial(span: Span, coefficients: Vec<f64>) -> Result<RationalFunction, ExpressionError> {
    RationalFunction::new(coefficients, vec![1.0])
        .map_err(|error| ExpressionError::new(span, error.to_string()))
}

fn multiplied(
    span: Span,
    a: &RationalFunction,
    b: &RationalFunction,
) -> Result<RationalFunction, ExpressionError> {
    let product = a.product(b);
    // Coefficients may overflow.
    RationalFunction::new(product.numerator, product.denominator)
        .map_err(|error| ExpressionError::new(span, error.to_string()))
}

/// The function with what is wrong underlined.
fn pointed(text: &str, error: &ExpressionError) -> String {
    let columns = |bytes: usize| text.get(..bytes).map_or(0, |before| before.chars().count());
    let (from, to) = (columns(error.span.start), columns(error.span.end));
    let mut message = format!(
        "{}\n  {text}\n  {}{}",
        error.message,
        " ".repeat(from),
        "^".repeat(to.saturating_sub(from).max(1))
    );
    if let Some(help) = &error.help {
        let _ = write!(message, "\n{help}");
    }
    message
}
