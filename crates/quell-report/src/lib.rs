//! Pictures of networks and responses, and the HTML report.
//!
//! The report is written from plain data ([`page::Page`]): the crate knows how things look, not where they come from.

mod html;
pub mod layout;
pub mod number;
pub mod page;
pub mod plot;
pub mod schematic;
pub mod symbols;
mod text;
