//! A host with devices as one system of first-order equations, compiled.

mod structure;
