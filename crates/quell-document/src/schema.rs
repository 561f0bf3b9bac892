//! The JSON schema of a document, for editors.

use serde_json::{Map, Value, json};

use crate::keys::{KeySet, Shape, Tables};

/// The JSON schema (draft 2020-12) of a document whose root table has these keys.
///
/// Each nested table definition stands once under `$defs`; tables without free names refuse further properties.
pub fn json_schema(root: &KeySet) -> Value {
    let tables = Tables::under(root);
    let mut schema = Map::new();
    schema.insert(
        "$schema".to_owned(),
        json!("https://json-schema.org/draft/2020-12/schema"),
    );
    schema.append(&mut object(root, &tables));
    if !tables.nested.is_empty() {
        let definitions: Map<String, Value> = tables
            .nested
            .iter()
            .map(|named| {
                (
                    named.anchor.clone(),
                    Value::Object(object(named.keys, &tables)),
                )
            })
            .collect();
        schema.insert("$defs".to_owned(), Value::Object(definitions));
    }
    Value::Object(schema)
}

fn object(keys: &KeySet, tables: &Tables) -> Map<String, Value> {
    let mut schema = Map::new();
    schema.insert("title".to_owned(), json!(keys.title));
    if !keys.documentation.is_empty() {
        schema.insert("description".to_owned(), json!(keys.documentation));
    }
    schema.insert("type".to_owned(), json!("object"));
    let properties: Map<String, Value> = keys
        .keys
        .iter()
        .map(|key| {
            (
                key.name.to_owned(),
                described(&key.shape, key.documentation, tables),
            )
        })
        .collect();
    schema.insert("properties".to_owned(), Value::Object(properties));
    let required: Vec<&str> = keys
        .keys
        .iter()
        .filter(|key| key.required)
        .map(|key| key.name)
        .collect();
    if !required.is_empty() {
        schema.insert("required".to_owned(), json!(required));
    }
    let others = match &keys.others {
        Some((_, shape, documentation)) => described(shape, documentation, tables),
        None => json!(false),
    };
    schema.insert("additionalProperties".to_owned(), others);
    schema
}

fn described(shape: &Shape, documentation: &str, tables: &Tables) -> Value {
    let mut schema = of_shape(shape, tables);
    if !documentation.is_empty() {
        schema.insert("description".to_owned(), json!(documentation));
    }
    Value::Object(schema)
}

fn of_shape(shape: &Shape, tables: &Tables) -> Map<String, Value> {
    let (name, value) = match shape {
        Shape::Text => ("type", json!("string")),
        Shape::Number => ("type", json!("number")),
        Shape::Integer => ("type", json!("integer")),
        Shape::Boolean => ("type", json!("boolean")),
        Shape::Amount | Shape::Expression => ("type", json!(["number", "string"])),
        Shape::Choice(texts) => ("enum", json!(texts)),
        Shape::Table(keys) => (
            "$ref",
            tables
                .anchor(keys)
                .map_or_else(|| json!("#"), |anchor| json!(format!("#/$defs/{anchor}"))),
        ),
        Shape::List(inner) => {
            return Map::from_iter([
                ("type".to_owned(), json!("array")),
                ("items".to_owned(), Value::Object(of_shape(inner, tables))),
            ]);
        }
        Shape::MapOf(inner) => {
            return Map::from_iter([
                ("type".to_owned(), json!("object")),
                (
                    "additionalProperties".to_owned(),
                    Value::Object(of_shape(inner, tables)),
                ),
            ]);
        }
        Shape::AnyOf(shapes) => (
            "anyOf",
            shapes
                .iter()
                .map(|shape| Value::Object(of_shape(shape, tables)))
                .collect(),
        ),
        Shape::Anything => return Map::new(),
    };
    Map::from_iter([(name.to_owned(), value)])
}
