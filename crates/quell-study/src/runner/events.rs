//! What happens to stable bands between the points of a sweep: islands that split them are born, bands close.

use std::cmp::Ordering;

use quell_continuation::{Band, Bands, Edge};

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
                if !alike(&one.bands, &other.bands) {
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

    /// Bisects for the first change between two points, and goes on from there.
    fn locate(
        &self,
        task: &Task,
        (from, to): (&SweepPoint, &SweepPoint),
        index: usize,
        events: &mut Vec<SweepEvent>,
    ) -> Result<(), RunError> {
        let (Some((name, mut low)), Some((_, end))) = (from.first(), to.first()) else {
            return Ok(());
        };
        let width = (end - low).abs();
        let last = self.bands_at(task, to)?;
        let mut below = self.bands_at(task, from)?;
        let same = |a: &[At], b: &[At]| match (a.get(index), b.get(index)) {
            (Some(a), Some(b)) => alike(&a.bands, &b.bands),
            _ => true,
        };
        // More than a few changes between two points are no business of a sweep.
        for _ in 0..MOST {
            if same(&below, &last) {
                return Ok(());
            }
            let (mut high, mut above) = (end, None);
            while (high - low).abs() > LOCATED * width {
                let middle = 0.5 * (low + high);
                if middle == low || middle == high {
                    break;
                }
                let found = self.bands_at(task, &from.moved(middle))?;
                if same(&below, &found) {
                    (low, below) = (middle, found);
                } else {
                    (high, above) = (middle, Some(found));
                }
            }
            let Some(above) = above else {
                return Ok(());
            };
            if let (Some(one), Some(other)) = (below.get(index), above.get(index))
                && !same(&below, &above)
            {
                events.push(event(name, 0.5 * (low + high), one, other));
            }
            (low, below) = (high, above);
        }
        Ok(())
    }
}

/// Most changes that are located between two points.
const MOST: usize = 8;

/// Edges are those of one mode when their frequencies differ by less than this.
const DRIFT: f64 = 0.1;

/// Whether two sets of bands are of one kind: as many, and their ends limited by the same modes in the same way.
fn alike(a: &Bands, b: &Bands) -> bool {
    let same = |one: &Edge, other: &Edge| {
        let (first, second) = (one.eigenvalue.im, other.eigenvalue.im);
        one.limit == other.limit && (first - second).abs() <= DRIFT * first.max(second)
    };
    a.bands.len() == b.bands.len()
        && a.bands
            .iter()
            .zip(&b.bands)
            .all(|(one, other)| same(&one.lower, &other.lower) && same(&one.upper, &other.upper))
}

/// What happens between two neighbouring values.
fn event(name: &str, value: f64, one: &At, other: &At) -> SweepEvent {
    let (before, after) = (one.bands.bands.len(), other.bands.bands.len());
    let more = if after > before { other } else { one };
    let (split, band) = critical(&more.bands.bands);
    let what = match (after.cmp(&before), split) {
        (Ordering::Greater, true) => "island born",
        (Ordering::Less, true) => "island gone",
        (Ordering::Greater, false) => "band opened",
        (Ordering::Less, false) => "band closed",
        (Ordering::Equal, _) => "another limit",
    };
    let place = more
        .places
        .get(band)
        .map(|[lower, upper]| if split { upper } else { lower }.clone());
    SweepEvent {
        parameter: name.to_owned(),
        value,
        configuration: more.configuration.clone(),
        criterion: more.criterion.clone(),
        what,
        place: place.unwrap_or_default(),
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
