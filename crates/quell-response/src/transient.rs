//! Motion in time: simulation with events, exact where the system is piecewise affine, and what is read from a run.
//!
//! A system is anything that implements [`Dynamics`]: rates x' = f(t, x), their Jacobian, signals to observe, switches where
//! the rates have a kink or jump. [`simulate`] carries it from a start until an [`Event`] or a time, and returns a
//! [`Trajectory`]: dense in time, with everything that happened on the way. A [`Record`] reads signals from one or several
//! trajectories (phases of one run): extrema, peaks, integrals, settling times.
//!
//! ```
//! use quell_response::transient::*;
//!
//! // x'' = -x, released from x = 1; its signals are x and x'.
//! struct Oscillator;
//! impl Dynamics for Oscillator {
//!     fn states(&self) -> usize { 2 }
//!     fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) { rates.copy_from_slice(&[x[1], -x[0]]); }
//!     fn signals(&self) -> usize { 2 }
//!     fn watch(&mut self, _t: f64, x: &[f64], signals: &mut [f64]) { signals.copy_from_slice(x); }
//! }
//!
//! // Until x' falls through zero after having been positive: a full period.
//! let event = Event::on(1, Direction::Falling).armed(Condition::above(1, 0.0)).ending();
//! let mut oscillator = Oscillator;
//! let trajectory = simulate(&mut oscillator, &[1.0, 0.0], (0.0, 100.0), &[event], &Settings::default())?;
//! assert_eq!(trajectory.end(), &End::Event { event: 0 });
//! assert!((trajectory.to() - std::f64::consts::TAU).abs() < 1e-6);
//! let mut record = Record::new(&trajectory, &mut oscillator);
//! assert!((record.minimum(0).value + 1.0).abs() < 1e-7);
//! # Ok::<(), TransientError>(())
//! ```

mod chebyshev;
mod dynamics;
mod error;
mod event;
mod exponential;
mod integrator;
mod library;
mod monitor;
mod propagation;
mod record;
mod run;
mod search;
mod simulation;
mod trajectory;

pub use dynamics::Dynamics;
pub use error::TransientError;
pub use event::{Condition, Direction, Event, Grazing, Occurrence};
pub use exponential::matrix_exponential;
pub use integrator::{Method, Scheme};

pub use record::{Excursion, Extremum, Integral, Record};
pub use simulation::{Absolute, Progress, Settings, simulate, simulate_with};
pub use trajectory::{End, Statistics, Trajectory};
