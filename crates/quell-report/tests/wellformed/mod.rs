//! A small check that markup is well formed: elements nest and close, attributes are quoted, entities are known.

/// Says what is wrong with XML text, if anything.
pub(crate) fn well_formed(text: &str) -> Result<(), String> {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = text;
    let mut roots = 0;
    while let Some(start) = rest.find('<') {
        entities(&rest[..start])?;
        if open.is_empty() && !rest[..start].trim().is_empty() {
            return Err(format!("text outside the root: {}", &rest[..start]));
        }
        rest = &rest[start + 1..];
        if let Some(comment) = rest.strip_prefix("!--") {
            rest = &comment[comment.find("-->").ok_or("a comment stays open")? + 3..];
            continue;
        }
        let end = tag_end(rest).ok_or("a tag stays open")?;
        let tag = &rest[..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            match open.pop() {
                Some(expected) if expected == name.trim() => {}
                other => return Err(format!("`</{name}>` closes {other:?}")),
            }
            continue;
        }
        let name = tag.split([' ', '/']).next().unwrap_or_default();
        if name.is_empty() {
            return Err(format!("`<{tag}>` has no name"));
        }
        attributes(tag[name.len()..].trim_end_matches('/'), tag)?;
        if open.is_empty() {
            roots += 1;
        }
        if !tag.ends_with('/') {
            open.push(name);
        }
    }
    entities(rest)?;
    if !open.is_empty() || roots != 1 {
        return Err(format!("{roots} roots, still open: {open:?}"));
    }
    Ok(())
}

/// The closing bracket of a tag, quoted ones skipped.
fn tag_end(text: &str) -> Option<usize> {
    let mut quote = None;
    text.char_indices().find_map(|(index, character)| {
        match (quote, character) {
            (None, '>') => return Some(index),
            (None, '"' | '\'') => quote = Some(character),
            (Some(open), close) if open == close => quote = None,
            _ => {}
        }
        None
    })
}

fn attributes(mut text: &str, tag: &str) -> Result<(), String> {
    let mut seen = Vec::new();
    loop {
        text = text.trim_start();
        if text.is_empty() {
            return Ok(());
        }
        let (name, value) = text
            .split_once("=\"")
            .ok_or_else(|| format!("`<{tag}>`: attribute without a quoted value"))?;
        if seen.contains(&name) || name.contains([' ', '<', '"']) {
            return Err(format!("`<{tag}>`: attribute `{name}`"));
        }
        seen.push(name);
        let (value, after) = value
            .split_once('"')
            .ok_or_else(|| format!("`<{tag}>`: `{name}` stays open"))?;
        if value.contains('<') {
            return Err(format!("`<{tag}>`: `<` in `{name}`"));
        }
        entities(value)?;
        text = after;
    }
}

fn entities(text: &str) -> Result<(), String> {
    for piece in text.split('&').skip(1) {
        let name = piece.split(';').next().unwrap_or_default();
        let known = ["amp", "lt", "gt", "quot", "apos"].contains(&name)
            || name
                .strip_prefix('#')
                .is_some_and(|number| number.bytes().all(|byte| byte.is_ascii_digit()));
        if !known {
            return Err(format!("unknown entity `&{name}`"));
        }
    }
    Ok(())
}
