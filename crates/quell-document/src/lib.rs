//! Documents a user writes: TOML in which every value knows its place in the file.
//!
//! Reading goes [`Source`] to [`Document`] to [`Table`] and [`Value`]; whatever is wrong becomes a [`Fault`], which
//! points at the place and says what to do. The keys a table may have are defined once, as a [`KeySet`]: it checks
//! documents ([`Table::check`]), and writes the editor's schema ([`json_schema`]) and the reference
//! ([`reference_markdown`]).
//!
//! ```
//! use std::sync::Arc;
//! use quell_document::{Document, Source};
//!
//! let source = Arc::new(Source::new("body.toml", "[body]\nmass = \"60 kg\"\n"));
//! let document = Document::parse(source)?;
//! let body = document.root().require("body")?.as_table()?;
//! assert_eq!(body.require("mass")?.as_str()?, "60 kg");
//! assert_eq!(body.require("width").unwrap_err().position(), Some((1, 1)));
//! # Ok::<(), quell_document::Fault>(())
//! ```
//!
//! **Invariant:** no text, however malformed, makes reading panic; nothing here opens a file or prints.

mod document;
mod fault;
mod keys;
mod reference;
mod schema;
mod source;
mod syntax;
mod table;
mod value;

pub use document::Document;
pub use fault::Fault;
pub use keys::{Key, KeySet, Shape};
pub use reference::reference_markdown;
pub use schema::json_schema;
pub use source::Source;
pub use table::Table;
pub use value::Value;
