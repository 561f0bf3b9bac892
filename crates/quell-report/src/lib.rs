//! Pictures of networks and responses, and the HTML report.
//!
//! The report is written from plain data ([`page::Page`]), which knows how things look, not where they come from;
//! [`html`] fills it from what the run of a study found.

mod html;
pub mod layout;
pub mod number;
pub mod page;
pub mod plot;
pub mod schematic;
mod study;
pub mod symbols;
mod text;

pub use study::{ended, html, motion_words, page as page_of, shown_swept, shown_unit};
