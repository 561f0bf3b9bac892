//! One definition of keys: the check, the schema and the reference.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::sync::Arc;

use quell_document::{
    Document, Fault, Key, KeySet, Shape, Source, json_schema, reference_markdown,
};
use serde_json::json;

static BODY: KeySet = KeySet {
    title: "A body",
    documentation: "A rigid body.",
    keys: &[
        Key::required("mass", Shape::Amount, "Its mass."),
        Key::optional(
            "kind",
            Shape::Choice(&["translation", "rotation"]),
            "How it moves | turns.",
        ),
        Key::optional(
            "parts",
            Shape::List(&Shape::Table(&BODY)),
            "Bodies fixed to it.",
        ),
    ],
    others: None,
};

static ROOT: KeySet = KeySet {
    title: "A model",
    documentation: "What a file holds.",
    keys: &[
        Key::required("title", Shape::Text, "What it is called."),
        Key::required("version", Shape::Integer, ""),
        Key::optional("parameters", Shape::MapOf(&Shape::Amount), "Named values."),
        Key::optional(
            "force",
            Shape::AnyOf(&[Shape::Expression, Shape::Boolean]),
            "Its force.",
        ),
        Key::optional("bodies", Shape::MapOf(&Shape::Table(&BODY)), "The bodies."),
        Key::optional("inside", Shape::Table(&ROOT), "A model in it."),
    ],
    others: Some(("NAME", Shape::Anything, "A remark.")),
};

fn check(text: &str, keys: &KeySet) -> Result<(), Fault> {
    let document = Document::parse(Arc::new(Source::new("case.toml", text))).unwrap();
    document.root().check(keys)
}

#[test]
fn unknown_keys_are_refused_with_the_nearest() {
    let fault = check("mass = 1\nknid = 2\n", &BODY).unwrap_err();
    assert_eq!(fault.message, "unknown key `knid` at the top of the file");
    assert_eq!(fault.help.as_deref(), Some("did you mean `kind`?"));
    assert_eq!(fault.position(), Some((2, 1)));
    let fault = check("mass = 1\nviscosity = 2\n", &BODY).unwrap_err();
    assert_eq!(
        fault.help.as_deref(),
        Some("valid keys are `mass`, `kind` and `parts`")
    );
    assert!(check("mass = 1\nparts = []\n", &BODY).is_ok());
}

#[test]
fn a_table_inside_is_named() {
    let text = "[bodies.\"left one\"]\nmas = 1\n";
    let document = Document::parse(Arc::new(Source::new("case.toml", text))).unwrap();
    let bodies = document
        .root()
        .require("bodies")
        .unwrap()
        .as_table()
        .unwrap();
    let body = bodies.require("left one").unwrap().as_table().unwrap();
    let fault = body.check(&BODY).unwrap_err();
    assert_eq!(fault.message, "unknown key `mas` in `bodies.\"left one\"`");
    let fault = body.require("mass").unwrap_err();
    assert_eq!(fault.message, "`mass` is missing in `bodies.\"left one\"`");
    assert_eq!(fault.position(), Some((1, 1)));
}

#[test]
fn missing_keys_are_named() {
    let fault = check("", &BODY).unwrap_err();
    assert_eq!(fault.message, "`mass` is missing at the top of the file");
    assert_eq!(fault.help.as_deref(), Some("`mass`: Its mass."));
    let fault = check("force = true\n", &ROOT).unwrap_err();
    assert_eq!(
        fault.message,
        "`title` and `version` are missing at the top of the file"
    );
    assert!(
        check("title = 'x'\nversion = 1\nanything = 3\n", &ROOT).is_ok(),
        "free names"
    );
}

#[test]
fn the_schema() {
    assert_eq!(
        json_schema(&ROOT),
        json!({
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": "A model",
            "description": "What a file holds.",
            "type": "object",
            "properties": {
                "title": { "type": "string", "description": "What it is called." },
                "version": { "type": "integer" },
                "parameters": {
                    "type": "object",
                    "additionalProperties": { "type": ["number", "string"] },
                    "description": "Named values."
                },
                "force": {
                    "anyOf": [{ "type": ["number", "string"] }, { "type": "boolean" }],
                    "description": "Its force."
                },
                "bodies": {
                    "type": "object",
                    "additionalProperties": { "$ref": "#/$defs/a-body" },
                    "description": "The bodies."
                },
                "inside": { "$ref": "#", "description": "A model in it." }
            },
            "required": ["title", "version"],
            "additionalProperties": { "description": "A remark." },
            "$defs": {
                "a-body": {
                    "title": "A body",
                    "description": "A rigid body.",
                    "type": "object",
                    "properties": {
                        "mass": { "type": ["number", "string"], "description": "Its mass." },
                        "kind": { "enum": ["translation", "rotation"], "description": "How it moves | turns." },
                        "parts": {
                            "type": "array",
                            "items": { "$ref": "#/$defs/a-body" },
                            "description": "Bodies fixed to it."
                        }
                    },
                    "required": ["mass"],
                    "additionalProperties": false
                }
            }
        })
    );
}

#[test]
fn the_reference() {
    assert_eq!(
        reference_markdown(&ROOT),
        "\
# A model

What a file holds.

| Key | Value | Required | Meaning |
|---|---|---|---|
| `title` | text | yes | What it is called. |
| `version` | integer | yes |  |
| `parameters` | table of names, each: amount |  | Named values. |
| `force` | expression, or `true` or `false` |  | Its force. |
| `bodies` | table of names, each: [table: A body](#a-body) |  | The bodies. |
| `inside` | table: A model |  | A model in it. |
| *NAME* | anything |  | A remark. |

## A body

A rigid body.

| Key | Value | Required | Meaning |
|---|---|---|---|
| `mass` | amount | yes | Its mass. |
| `kind` | `\"translation\"` or `\"rotation\"` |  | How it moves \\| turns. |
| `parts` | list of: [table: A body](#a-body) |  | Bodies fixed to it. |
"
    );
}

#[test]
fn different_tables_of_one_title_keep_apart() {
    static FIRST: KeySet = KeySet {
        title: "Run",
        documentation: "",
        keys: &[Key::optional("a", Shape::Text, "")],
        others: None,
    };
    static SECOND: KeySet = KeySet {
        title: "Run",
        documentation: "",
        keys: &[Key::optional("b", Shape::Text, "")],
        others: None,
    };
    static BOTH: KeySet = KeySet {
        title: "Both",
        documentation: "",
        keys: &[Key::optional(
            "runs",
            Shape::AnyOf(&[Shape::Table(&FIRST), Shape::Table(&SECOND)]),
            "",
        )],
        others: None,
    };
    let schema = json_schema(&BOTH);
    assert_eq!(
        schema["properties"]["runs"]["anyOf"],
        json!([{ "$ref": "#/$defs/run" }, { "$ref": "#/$defs/run-1" }])
    );
    assert_eq!(
        schema["$defs"]["run-1"]["properties"]["b"]["type"],
        "string"
    );
}
