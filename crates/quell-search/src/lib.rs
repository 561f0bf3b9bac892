//! Bounded global minimisation of non-smooth black boxes.
//!
//! A [`Problem`] has a handful of bounded variables, an objective and inequality constraints. [`search`] minimises it
//! from several independent [`start`]s and reports how many of them agree, which bounds are active and what it cost.
//! Objectives that are maxima of smooth pieces (the highest of several resonance peaks, say) may offer their
//! near-active [`Pieces`] with gradients; the local step is then a minimax sequential quadratic programme that ends
//! with a certificate.
//!
//! ```
//! use quell_search::{Pieces, Problem, Scale, Settings, Status, Variable, search};
//!
//! /// The larger of (x - 1)^2 + 1 and x^2 + 1, whose least value 1.25 lies at the kink x = 0.5.
//! struct Kink([Variable; 1]);
//!
//! impl Problem for Kink {
//!     type Scratch = ();
//!     fn scratch(&self) {}
//!     fn variables(&self) -> &[Variable] {
//!         &self.0
//!     }
//!     fn evaluate(&self, x: &[f64], _constraints: &mut [f64], _scratch: &mut ()) -> f64 {
//!         ((x[0] - 1.0).powi(2) + 1.0).max(x[0].powi(2) + 1.0)
//!     }
//!     fn pieces(&self, x: &[f64], _margin: f64, pieces: &mut Pieces, _scratch: &mut ()) -> bool {
//!         pieces.push_objective((x[0] - 1.0).powi(2) + 1.0)[0] = 2.0 * (x[0] - 1.0);
//!         pieces.push_objective(x[0].powi(2) + 1.0)[0] = 2.0 * x[0];
//!         true
//!     }
//! }
//!
//! # fn main() -> Result<(), quell_search::SearchError> {
//! let problem = Kink([Variable::new("x", -3.0, 4.0, Scale::Linear)?]);
//! let outcome = search(&problem, &Settings::for_dimension(1), 0);
//! assert!((outcome.objective - 1.25).abs() < 1e-9);
//! assert_eq!(outcome.status, Status::Agreed);
//! # Ok(())
//! # }
//! ```
//!
//! The crate knows no physics. It never reads a clock, a file or a global random number generator: the same problem,
//! settings and key give the same bits on any number of threads.

mod derivative_free;
mod error;
mod evaluation;
mod exact;
mod front;
mod minimax;
mod outcome;
mod problem;
mod quadratic;
mod sample;
mod search;
mod settings;
mod variable;

pub use error::SearchError;
pub use front::{efficient, epsilon_levels};
pub use outcome::{Outcome, StartResult, StartStatus, Status};
pub use problem::{Pieces, Problem};
pub use search::{collect, polish, search, start};
pub use settings::Settings;
pub use variable::{Scale, Side, Variable};
