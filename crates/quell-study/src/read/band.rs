//! Criteria of kind `stable band` as typed.

use indexmap::IndexMap;
use quell_document::{Fault, Table, Value};
use quell_expression::{Node, nearest};

use crate::amount::Amount;
use crate::band::{BandSpec, BandValue, Over};
use crate::continuation::ParameterRange;

/// The keys that only a stable band has.
const KEYS: [&str; 3] = ["of", "range", "start"];

/// Whether all criteria are stable bands or made of them, so that no run is needed.
pub(super) fn alone(root: &Table<'_>) -> bool {
    let criteria = root.get("criteria").and_then(|value| value.as_table().ok());
    criteria.is_some_and(|criteria| {
        let entries: Vec<_> = criteria
            .entries()
            .filter_map(|(_, _, value)| value.as_table().ok())
            .collect();
        entries.iter().any(|entry| entry.get("kind").is_some())
            && entries.iter().all(|entry| entry.get("run").is_none())
    })
}

/// Reads what makes a criterion a stable band; none where it is another.
///
/// # Errors
/// Keys that do not belong together, a value that it does not have.
pub(super) fn read(entry: &Table<'_>, value: &Value<'_>) -> Result<Option<BandSpec>, Fault> {
    let source = entry.source();
    let Some(kind) = entry.get("kind") else {
        for key in KEYS {
            if let Some(span) = entry.key_span(key) {
                return Err(Fault::at(
                    source,
                    span,
                    format!("`{key}` is a key of criteria of kind `stable band`"),
                )
                .help("add `kind = \"stable band\"`"));
            }
        }
        return Ok(None);
    };
    kind.one_of(&["stable band"])?;
    if let Some(span) = entry.key_span("run") {
        return Err(
            Fault::at(source, span, "a stable band is not read from a run")
                .help("remove `run`: the equilibrium of the host with its devices is looked at"),
        );
    }
    let of = entry.get("of").ok_or_else(|| {
        entry
            .fault("the band does not say of which parameter it is")
            .help("add `of = \"c1\"`, a value in the layouts, or a parameter of the host")
    })?;
    let range = entry
        .get("range")
        .map(|value| pair(&value, entry))
        .transpose()?;
    let over = entry
        .get("over")
        .map(|value| over(&value, entry))
        .transpose()?;
    let of_span = of.span();
    let of = of.as_str()?.to_owned();
    if over.as_ref().is_some_and(|over| over.name == of) {
        return Err(Fault::at(
            source,
            of_span,
            format!("`{of}` cannot be both the band's own parameter and what it is over"),
        )
        .help("leave `over` out for the values of an operating parameter itself"));
    }
    let start = match entry.get("start") {
        Some(value) => value
            .as_table()?
            .entries()
            .map(|(name, _, value)| Ok((name.to_owned(), Amount::read(&value, source)?)))
            .collect::<Result<_, Fault>>()?,
        None => IndexMap::new(),
    };
    Ok(Some(BandSpec {
        of,
        of_span,
        range,
        over,
        value: number(value)?,
        start,
        span: value.span(),
    }))
}

/// Which number of the band.
fn number(value: &Value<'_>) -> Result<BandValue, Fault> {
    let names = BandValue::ALL.iter().map(|(name, _)| *name);
    let expression = value.expression()?;
    let Node::Name(name) = &expression.node else {
        return Err(value
            .fault(format!(
                "`{}` is no number of a stable band",
                expression.excerpt()
            ))
            .help(
                "it has `width`, `lower` and `upper`; a criterion of criteria may reckon with them",
            ));
    };
    let known = BandValue::ALL.iter().find(|(known, _)| known == name);
    known.map(|(_, value)| *value).ok_or_else(|| {
        let fault = value.fault(format!("`{name}` is no number of a stable band"));
        match nearest(name, names) {
            Some(near) => fault.help(format!("did you mean `{near}`?")),
            None => fault.help("it has `width`, `lower` and `upper`"),
        }
    })
}

/// `"V"`, or `{ V = ["5 m/s", "80 m/s"] }`.
fn over(value: &Value<'_>, entry: &Table<'_>) -> Result<Over, Fault> {
    if value.is_text() {
        return Ok(Over {
            name: value.as_str()?.to_owned(),
            span: value.span(),
            range: None,
        });
    }
    let table = value.as_table()?;
    let mut entries = table.entries();
    match (entries.next(), entries.next()) {
        (Some((name, span, range)), None) => Ok(Over {
            name: name.to_owned(),
            span,
            range: Some(pair(&range, entry)?),
        }),
        _ => Err(value.fault("a band is over one operating parameter").help(
            "write `over = \"V\"`, or with a range `over = { V = [\"5 m/s\", \"80 m/s\"] }`",
        )),
    }
}

/// Lower and upper end.
fn pair(value: &Value<'_>, entry: &Table<'_>) -> Result<ParameterRange, Fault> {
    const EXAMPLE: &str = "write `[lower, upper]`";
    let ends = value.as_array().map_err(|fault| fault.help(EXAMPLE))?;
    let [from, to] = ends.as_slice() else {
        return Err(value
            .fault("a range has a lower and an upper end")
            .help(EXAMPLE));
    };
    Ok(ParameterRange {
        from: Amount::read(from, entry.source())?,
        to: Amount::read(to, entry.source())?,
        span: value.span(),
    })
}
