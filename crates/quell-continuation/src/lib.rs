//! Branches of equilibria and periodic orbits of ẋ = f(t, x, p), their special points and the curves of those.
//!
//! A [`Problem`] offers f with exact derivatives; the crate knows nothing else about it.
#![allow(
    clippy::needless_range_loop, // index arithmetic mirrors the formulas
    clippy::type_complexity,     // tuples that never leave their module
    clippy::neg_cmp_op_on_partial_ord, // NaN must fail these tests
    clippy::cast_possible_wrap,  // degrees are at most seven
    clippy::needless_pass_by_value, // traces are handed over
)]

mod band;
mod branch;
mod curve;
mod dense;
mod diagram;
mod equilibrium;
mod kind;
mod monitor;
mod orbit;
mod path;
mod problem;
mod settings;

pub use band::{
    Band, BandSettings, Bands, Edge, Limit, Linearisation, ParameterSpan, Peak, eigenpairs,
    eigenvalue_near, first_lyapunov, stable_bands,
};
pub use branch::{Branch, Equilibrium, Point, Special};
pub use curve::{
    CriticalEquilibrium, CriticalOrbit, cycle_curve, fold_curve, fold_from_generalised_hopf,
    hopf_curve, torus_from_hopf_hopf,
};
pub use dense::solve_linear;
pub use diagram::{Diagram, DiagramSettings, Member, diagram};
pub use equilibrium::{equilibria, equilibria_across};
pub use kind::{Certainty, Kind};
pub use monitor::{Monitor, View};
pub use orbit::{
    Orbit, Samples, cycles_across, cycles_doubled, cycles_from_hopf, cycles_from_orbit,
    cycles_from_pair, cycles_from_samples,
};
pub use problem::{Closure, Problem};
pub use settings::{ContinuationError, Directions, Interrupt, MeshSettings, Settings, Stop};
