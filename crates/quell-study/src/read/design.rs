//! Tasks of kind `design` as typed.

use indexmap::IndexMap;
use quell_document::{Fault, Table, Value};
use quell_expression::{ComparisonOperator, Expression, Node, Span};

use super::candidates::candidates;
use super::{amounts_of, devices, objectives, unknown};
use crate::amount::Amount;
use crate::study::{Bounds, Constraint, DesignTask, Sense, Study};

pub(super) fn design(table: &Table<'_>, study: &Study) -> Result<DesignTask, Fault> {
    let source = &study.source;
    let (first, further, place) = objectives::objectives(table, study)?;
    let constraints = match table.get("subject_to") {
        Some(value) => value
            .as_array()
            .map_err(|fault| fault.help("write `subject_to = [\"CRITERION <= VALUE\"]`"))?
            .iter()
            .map(|value| constraint(value, study))
            .collect::<Result<_, _>>()?,
        None => Vec::new(),
    };
    let references = match table.get("references") {
        Some(value) => references(&value)?,
        None => Vec::new(),
    };
    let starts = match table.get("starts") {
        Some(value) => {
            let starts = value.as_count()?;
            if starts == 0 || starts > 10_000 {
                return Err(value.fault("the number of starts lies between 1 and 10000"));
            }
            Some(starts)
        }
        None => None,
    };
    let agree = objectives::agree(table, starts)?;
    let front_points = objectives::front_points(table, further.len())?;
    let feasibility = match table.get("feasibility") {
        Some(value) => {
            let tolerance = value.as_f64()?;
            if !(0.0..1.0).contains(&tolerance) {
                return Err(
                    value.fault("the feasibility tolerance is relative and lies between 0 and 1")
                );
            }
            tolerance
        }
        None => 1e-6,
    };
    let bounds: IndexMap<String, Bounds> = match table.get("bounds") {
        Some(value) => value
            .as_table()?
            .entries()
            .map(|(name, _, value)| Ok((name.to_owned(), devices::bounds(&value, source)?)))
            .collect::<Result<_, Fault>>()?,
        None => IndexMap::new(),
    };
    let fixed = amounts_of(table.get("fixed"), source)?;
    if let Some((name, bounds)) = bounds.iter().find(|(name, _)| fixed.contains_key(*name)) {
        return Err(Fault::at(
            source,
            bounds.span,
            format!("`{name}` has bounds here and a value under `fixed`"),
        )
        .help("keep one of the two"));
    }
    Ok(DesignTask {
        objective: first.criterion,
        sense: first.sense,
        further,
        front_points,
        constraints,
        references,
        candidates: candidates(table, study)?,
        fixed,
        bounds,
        starts,
        agree,
        feasibility,
        simplify: simplify(table, study)?,
        place,
    })
}

/// Whether the best design is made smaller.
fn simplify(table: &Table<'_>, study: &Study) -> Result<bool, Fault> {
    let Some(value) = table.get("simplify") else {
        return Ok(false);
    };
    let wanted = value.as_bool()?;
    let slots = table
        .get("candidates")
        .and_then(|value| Some(value.as_table().ok()?.entries().count()));
    if wanted && slots.is_some_and(|slots| slots != 1) {
        return Err(Fault::at(
            &study.source,
            value.span(),
            "several slots are designed at once, and one at a time can be made smaller",
        )
        .help("leave `simplify` out, or design one slot in this task"));
    }
    Ok(wanted)
}

fn references(value: &Value<'_>) -> Result<Vec<(String, Span)>, Fault> {
    let mut found: Vec<(String, Span)> = Vec::new();
    for value in value.as_array()? {
        let name = value.as_str()?;
        if found.iter().any(|(known, _)| known == name) {
            return Err(value
                .fault(format!("the reference `{name}` is given twice"))
                .help("keep one of the two"));
        }
        found.push((name.to_owned(), value.span()));
    }
    Ok(found)
}

fn constraint(value: &Value<'_>, study: &Study) -> Result<Constraint, Fault> {
    let expression = value.expression()?;
    let Node::Comparison {
        operator,
        left,
        right,
    } = &expression.node
    else {
        return Err(value
            .fault(format!("`{}` is no constraint", expression.excerpt()))
            .help("write `CRITERION <= VALUE` or `CRITERION >= VALUE`"));
    };
    let sense = match operator {
        ComparisonOperator::Less | ComparisonOperator::LessOrEqual => Sense::Minimise,
        ComparisonOperator::Greater | ComparisonOperator::GreaterOrEqual => Sense::Maximise,
        ComparisonOperator::Equal | ComparisonOperator::NotEqual => {
            return Err(value
                .fault("a constraint is an inequality")
                .help("write `CRITERION <= VALUE` or `CRITERION >= VALUE`"));
        }
    };
    let criterion = |side: &Expression| match &side.node {
        Node::Name(name) if study.criteria.contains_key(name) => Some(name.clone()),
        _ => None,
    };
    let flipped = match sense {
        Sense::Minimise => Sense::Maximise,
        Sense::Maximise => Sense::Minimise,
    };
    let (criterion, sense, bound) = match (criterion(left), criterion(right)) {
        (Some(first), Some(second)) => {
            return Err(Fault::at(
                &study.source,
                right.span,
                format!("a bound is a value, but `{second}` is a criterion"),
            )
            .help(format!(
                "define a criterion for their difference, `{first} - {second}` written out, and bound it by 0"
            )));
        }
        (Some(name), None) => (name, sense, right.as_ref()),
        (None, Some(name)) => (name, flipped, left.as_ref()),
        (None, None) => {
            let Node::Name(name) = &left.node else {
                return Err(Fault::at(
                    &study.source,
                    expression.span,
                    "neither side of this constraint is a criterion",
                )
                .help("write `CRITERION <= VALUE` or `CRITERION >= VALUE`; an expression of criteria becomes a criterion under `[criteria]`"));
            };
            let fault = Fault::at(
                &study.source,
                left.span,
                format!("there is no criterion `{name}`"),
            );
            return Err(unknown(
                fault,
                name,
                "criterion",
                study.criteria.keys().map(String::as_str),
            ));
        }
    };
    Ok(Constraint {
        criterion,
        sense,
        bound: Amount::from_expression(bound.clone(), &study.source),
        swept: None,
    })
}
