//! Bounded global minimisation of non-smooth black boxes.
//!
//! A [`Problem`] has a handful of bounded variables, an objective and inequality constraints. [`search`] minimises it
//! from several independent [`start`]s and reports how many of them agree, which bounds are active and what it cost.
//! Objectives that are maxima of smooth pieces (the highest of several resonance peaks, say) may offer their
//! near-active [`Pieces`] with gradients; the local step is then a minimax sequential quadratic programme that ends
//! with a certificate.
//!
//! The crate knows no physics. It never reads a clock, a file or a global random number generator: the same problem,
//! settings and key give the same bits on any number of threads.

mod derivative_free;
mod error;
mod evaluation;
mod minimax;
mod outcome;
mod problem;
mod quadratic;
mod sample;
mod search;
mod settings;
mod variable;

pub use error::SearchError;
pub use outcome::{Outcome, StartResult, StartStatus, Status};
pub use problem::{Pieces, Problem};
pub use search::{collect, polish, search, start};
pub use settings::Settings;
pub use variable::{Scale, Side, Variable};
