//! Runs in time: the host with its devices let loose, until an event or a time, and what criteria read from that.

mod beginning;
mod excitation;
mod history;
mod ledger;
mod observation;
mod observe;
mod plan;

pub(crate) use beginning::{beginning, begun};
pub(crate) use excitation::excitations;
pub(crate) use history::History;
pub(crate) use observation::{COMPUTED_BUT, Observation};
pub(crate) use observe::observe;
pub(crate) use plan::{
    Simulated, Source, TransientPlan, ValuePlaces, Watching, parameters, sources,
};
