//! Host structures: what the engineer's machine, building or vehicle is before anything is bolted on.
#![forbid(unsafe_code)]

pub mod linear;
pub mod matrix;
