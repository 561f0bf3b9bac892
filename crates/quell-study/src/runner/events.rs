//! What happens to stable bands between the points of a sweep: islands that split them are born, bands close.

use quell_continuation::{Band, Bands};

use super::{RunError, Runner};
use crate::built::ValueScratch;
use crate::configuration;
use crate::evaluator::Evaluator;
use crate::results::SweepEvent;
use crate::situation;
use crate::study::{Task, TaskKind};
use crate::sweep::SweepPoint;

/// An event is located to this part of the interval between two points.
const LOCATED: f64 = 1e-7;

/// The bands of a configuration at a point of a sweep.
struct At {
    configuration: String,
    criterion: String,
    bands: Bands,
    /// Where each band begins and ends, in words.
    places: Vec<[String; 2]>,
}

impl Runner<'_> {
    /// What happens between the points of a sweep of one axis.
    pub(super) fn events(
        &self,
        task: &Task,
        points: &[SweepPoint],
    ) -> Result<Vec<SweepEvent>, RunError> {
        let mut criteria = self.study.criteria.values();
        let bands = criteria.any(|criterion| criterion.band.is_some());
        let mut events = Vec::new();
        if !bands || task.sweep.len() != 1 || !matches!(task.kind, TaskKind::Evaluate(_)) {
            return Ok(events);
        }
        let mut all = Vec::new();
        for point in points {
            all.push(self.bands_at(task, point)?);
        }
        for (pair, found) in points.windows(2).zip(all.windows(2)) {
            let ([from, to], [before, after]) = (pair, found) else {
                continue;
            };
            for (index, (one, other)) in before.iter().zip(after).enumerate() {
                if one.bands.bands.len() != other.bands.bands.len() {
                    self.locate(task, (from, to), index, &mut events)?;
                }
            }
        }
        Ok(events)
    }

    /// The bands of every configuration at a point of a sweep.
    fn bands_at(&self, task: &Task, point: &SweepPoint) -> Result<Vec<At>, RunError> {
        let TaskKind::Evaluate(configurations) = &task.kind else {
            return Ok(Vec::new());
        };
        let criteria = self.study.criteria.iter();
        let names: Vec<&str> = criteria
            .filter(|(_, criterion)| criterion.band.is_some())
            .map(|(name, _)| name.as_str())
            .collect();
        let situation =
            situation::build(&self.study.host, &self.study.overrides, &point.parameters())?;
        let mut found = Vec::new();
        for (name, spec) in point.configurations(configurations).iter() {
            let built = configuration::built(self.study, &situation, spec)?;
            let mut values = ValueScratch::default();
            built.values(&[], &mut values);
            let evaluator = Evaluator::new(
                self.study,
                &situation,
                std::sync::Arc::new(built),
                Some(&names),
                &spec.runs,
            )?;
            for (criterion, plan, own) in evaluator.named_bands(&values) {
                let bands = own.bands.bands.iter();
                let places = bands
                    .map(|band| [&band.lower, &band.upper].map(|edge| plan.place(edge.p, edge.q)))
                    .collect();
                found.push(At {
                    configuration: name.clone(),
                    criterion: criterion.to_owned(),
                    bands: own.bands,
                    places,
                });
            }
        }
        Ok(found)
    }

    /// Bisects between two points where the number of bands changes, and again beyond where it changes more than once.
    fn locate(
        &self,
        task: &Task,
        (from, to): (&SweepPoint, &SweepPoint),
        index: usize,
        events: &mut Vec<SweepEvent>,
    ) -> Result<(), RunError> {
        let (Some((name, mut low)), Some((_, mut high))) = (from.first(), to.first()) else {
            return Ok(());
        };
        let width = (high - low).abs();
        let count = |found: &[At]| found.get(index).map_or(0, |at| at.bands.bands.len());
        let (mut below, mut above) = (self.bands_at(task, from)?, self.bands_at(task, to)?);
        while (high - low).abs() > LOCATED * width {
            let middle = 0.5 * (low + high);
            if middle == low || middle == high {
                break;
            }
            let found = self.bands_at(task, &from.moved(middle))?;
            if count(&found) == count(&below) {
                (low, below) = (middle, found);
            } else {
                // The first change is located here; a second one lies beyond it.
                if count(&found) != count(&above) {
                    let beyond = from.moved(high);
                    self.locate(task, (&from.moved(middle), &beyond), index, events)?;
                }
                (high, above) = (middle, found);
            }
        }
        let (Some(one), Some(other)) = (below.get(index), above.get(index)) else {
            return Ok(());
        };
        let grows = other.bands.bands.len() > one.bands.bands.len();
        let more = if grows { other } else { one };
        let (split, band) = critical(&more.bands.bands);
        let what = match (split, grows) {
            (true, true) => "island born",
            (true, false) => "island gone",
            (false, true) => "band opened",
            (false, false) => "band closed",
        };
        let place = more
            .places
            .get(band)
            .map(|[lower, upper]| if split { upper } else { lower }.clone());
        let event = SweepEvent {
            parameter: name.to_owned(),
            value: 0.5 * (low + high),
            configuration: more.configuration.clone(),
            criterion: more.criterion.clone(),
            what,
            place: place.unwrap_or_default(),
        };
        let place = events
            .iter()
            .position(|known| known.value > event.value)
            .unwrap_or(events.len());
        events.insert(place, event);
        Ok(())
    }
}

/// The narrowest gap between bands, or the narrowest band if that is narrower: whether it is a gap, and which band it is or follows.
fn critical(bands: &[Band]) -> (bool, usize) {
    let gaps = bands
        .iter()
        .zip(bands.iter().skip(1))
        .enumerate()
        .map(|(index, (one, next))| (next.lower.p - one.upper.p, true, index));
    let widths = bands
        .iter()
        .enumerate()
        .map(|(index, band)| (band.width(), false, index));
    gaps.chain(widths)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or((false, 0), |(_, split, index)| (split, index))
}
