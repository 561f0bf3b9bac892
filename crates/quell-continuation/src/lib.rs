//! Branches of equilibria and periodic orbits of ẋ = f(t, x, p), their special points and the curves of those.
//!
//! A [`Problem`] offers f with exact derivatives (a [`Closure`] with differences); the crate knows nothing else about it.
//!
//! - [`equilibria`] follows f = 0 in a parameter, with folds, Hopf and branch points; [`equilibria_across`] switches.
//! - [`cycles_from_hopf`], [`cycles_from_samples`] and [`cycles_from_orbit`] follow periodic orbits of autonomous and forced problems, those that
//!   go round an angle and subharmonics among them, by collocation on meshes that adapt; [`cycles_doubled`] and [`cycles_across`] switch.
//! - [`fold_curve`], [`hopf_curve`] and [`cycle_curve`] follow their special points in two parameters, [`torus_from_hopf_hopf`] and
//!   [`fold_from_generalised_hopf`] the curves of cycles that leave points of codimension two.
//! - [`diagram`] finds starts and follows what branches off; [`region`] divides a rectangle of two parameters by what is stable in its
//!   parts, and finds the curves by itself.
//!
//! Every branch says why it ended ([`Stop`]), every special point how sure it is ([`Certainty`]) and how far off it may be; [`Kind`] states
//! how coefficients of normal forms are scaled.
//!
//! ```
//! use quell_continuation::{Closure, Kind, Settings, cycles_from_hopf, equilibria};
//!
//! // x'' - (mu - x²) x' + x = 0: rest loses its stability at mu = 0.
//! let problem = Closure::new(2, 1, |_t, x: &[f64], p: &[f64], out: &mut [f64]| {
//!     out[0] = x[1];
//!     out[1] = (p[0] - x[0] * x[0]) * x[1] - x[0];
//! });
//! let settings = Settings::new(&[(-0.5, 1.0)]);
//! let rest = equilibria(&problem, &[0.0, 0.0], &[-0.5], 0, &settings)?;
//! let hopf = rest.of(Kind::Hopf)[0];
//! assert!(hopf.solution.parameters[0].abs() < 1e-6);
//! let cycles = cycles_from_hopf(&problem, hopf, 0, &settings)?;
//! // The amplitude at mu = 1 is that of van der Pol's oscillator with damping one.
//! let last = &cycles.points[cycles.points.len() - 1].solution;
//! assert!((last.range(0).1 - 2.00862).abs() < 1e-4);
//! # Ok::<(), quell_continuation::ContinuationError>(())
//! ```
#![allow(
    clippy::needless_range_loop, // index arithmetic mirrors the formulas
    clippy::type_complexity,     // tuples that never leave their module
    clippy::neg_cmp_op_on_partial_ord, // NaN must fail these tests
    clippy::cast_possible_wrap,  // degrees are at most seven
    clippy::needless_pass_by_value, // traces are handed over
)]

mod band;
mod branch;
mod bytes;
mod curve;
mod dense;
mod diagram;
mod equilibrium;
mod kind;
mod monitor;
mod orbit;
mod path;
mod problem;
mod region;
mod settings;

pub use band::{
    Band, BandSettings, Bands, Edge, Limit, Linearisation, ParameterSpan, Peak, eigenpairs,
    eigenvalue_near, first_lyapunov, stable_bands,
};
pub use branch::{Branch, Equilibrium, Point, Special};
pub use bytes::Kept;
pub use curve::{
    CriticalEquilibrium, CriticalOrbit, cycle_curve, fold_curve, fold_from_generalised_hopf,
    hopf_curve, torus_from_hopf_hopf,
};
pub use diagram::{Diagram, DiagramSettings, Keeper, Member, diagram, diagram_kept};
pub use equilibrium::{equilibria, equilibria_across, equilibrium_beside};
pub use kind::{Certainty, Kind};
pub use monitor::{Monitor, View};
pub use orbit::{
    Orbit, Samples, cycles_across, cycles_doubled, cycles_from_hopf, cycles_from_orbit,
    cycles_from_pair, cycles_from_samples,
};
pub use problem::{Closure, Problem};
pub use region::{
    Attractor, CurveSolutions, Region, RegionCell, RegionCurve, RegionSettings, region,
};
pub use settings::{
    ContinuationError, Correction, Directions, Interrupt, MeshSettings, Settings, Stop,
};
