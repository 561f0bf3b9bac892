//! Criteria taken again and again: at several sets of host parameters, and at values of devices within their tolerances.

use std::fmt::Write as _;
use std::sync::Arc;

use quell_document::Fault;
use quell_expression::{Dimension, Quantity};

use super::{Certified, Evaluator, EvaluatorScratch, Miss, Missed};
use crate::built::ValueScratch;
use crate::results::CriterionDetail;
use crate::situation::Situation;
use crate::study::{Criterion, Run, Statistic, Study, Tolerance, Variation};
use crate::sweep::combinations;

/// Of so many values the corners are looked at, 2^n of them.
const MOST_TOLERANCES: usize = 10;

/// So many points between the corners are looked at for a report.
const BETWEEN: usize = 32;

/// A criterion at several points.
#[derive(Debug)]
pub(super) struct Varied {
    places: Vec<Place>,
    /// Index among all values of the devices, name, relative tolerance.
    tolerances: Vec<(usize, String, f64)>,
    take: Statistic,
    /// Relative tolerance of the criterion.
    tolerance: f64,
    pub(super) dimension: Dimension,
}

/// The host at one set of parameters.
#[derive(Debug)]
struct Place {
    at: Vec<(String, Quantity)>,
    evaluator: Evaluator,
    program: usize,
}

/// Buffers of one thread.
#[derive(Debug, Default)]
pub(super) struct VariedScratch {
    inner: EvaluatorScratch,
    factors: Vec<f64>,
    out: Vec<f64>,
    numbers: Vec<f64>,
}

impl Varied {
    /// Compiles the criterion `name` of the candidate of `built` at every set of parameters.
    pub(super) fn new(
        study: &Study,
        situation: &Situation,
        outer: &Evaluator,
        (name, criterion, variation): (&str, &Criterion, &Variation),
        runs: &indexmap::IndexMap<String, Run>,
    ) -> Result<Self, Fault> {
        let mut places = Vec::new();
        for at in combinations(study, &variation.over, situation)? {
            let moved = situation.moved(study, &at)?;
            let built = Arc::new(outer.built.elsewhere(study, &moved)?);
            let evaluator =
                Evaluator::within(study, &moved, built, Some(&[name]), runs, Some(name))?;
            let program = evaluator
                .index(name)
                .ok_or_else(|| Fault::new(format!("there is no criterion `{name}`")))?;
            places.push(Place {
                at,
                evaluator,
                program,
            });
        }
        let tolerances: Vec<(usize, String, f64)> = outer
            .built
            .value_keys()
            .enumerate()
            .filter_map(|(index, keys)| {
                let found = tolerance_of(keys, &variation.tolerances)?;
                // Of `damper.k1` and `k1` the shorter, where it is one of its own.
                let name = keys.get(1).or(keys.first())?;
                Some((index, name.clone(), found.relative))
            })
            .collect();
        if tolerances.len() > MOST_TOLERANCES {
            let count = tolerances.len();
            let message = format!(
                "tolerances of {count} values have 2^{count} corners; {MOST_TOLERANCES} values are the most"
            );
            return Err(Fault::at(&study.source, variation.span, message)
                .help("name the values whose tolerances matter: `tolerances = { k = \"5 %\" }`"));
        }
        let dimension = places.first().map_or(Dimension::NONE, |place| {
            place.evaluator.dimension(place.program)
        });
        Ok(Self {
            places,
            tolerances,
            take: variation.take,
            tolerance: criterion.tolerance,
            dimension,
        })
    }

    /// Values as meant, and every corner.
    fn points(&self) -> usize {
        if self.tolerances.is_empty() {
            1
        } else {
            1 + (1 << self.tolerances.len())
        }
    }

    /// The factors of all values at a point: 0 is as meant, then the corners.
    fn corner(&self, point: usize, factors: &mut Vec<f64>) {
        self.factors(factors, |place| match point.checked_sub(1) {
            None => 0.0,
            Some(corner) if corner >> place & 1 == 1 => 1.0,
            Some(_) => -1.0,
        });
    }

    fn factors(&self, factors: &mut Vec<f64>, share: impl Fn(usize) -> f64) {
        factors.clear();
        let last = self.tolerances.last().map_or(0, |(index, ..)| index + 1);
        factors.resize(last, 1.0);
        for (place, (index, _, relative)) in self.tolerances.iter().enumerate() {
            if let Some(factor) = factors.get_mut(*index) {
                *factor = 1.0 + share(place) * relative;
            }
        }
    }

    /// For a search.
    pub(super) fn fast(&self, values: &ValueScratch, scratch: &mut VariedScratch) -> f64 {
        self.numbers(values, scratch);
        taken(self.take, &scratch.numbers)
    }

    /// The values at all points, place by place.
    fn numbers(&self, values: &ValueScratch, scratch: &mut VariedScratch) {
        scratch.numbers.clear();
        for place in &self.places {
            for point in 0..self.points() {
                self.corner(point, &mut scratch.factors);
                let value = place.fast(values, scratch);
                scratch.numbers.push(value);
            }
        }
    }

    pub(super) fn is_smooth(&self) -> bool {
        self.places.iter().all(|place| place.evaluator.is_smooth())
    }

    /// As [`Evaluator::pieces`]: those of every point that comes near the largest.
    pub(super) fn pieces(
        &self,
        values: &ValueScratch,
        factor: f64,
        margin: f64,
        scratch: &mut VariedScratch,
        push: &mut super::Push<'_>,
    ) -> bool {
        if self.take != Statistic::Largest {
            return false;
        }
        self.numbers(values, scratch);
        let largest = taken(self.take, &scratch.numbers);
        if largest.is_nan() {
            return false;
        }
        let numbers = std::mem::take(&mut scratch.numbers);
        let mut numbers = numbers.into_iter();
        for place in &self.places {
            for point in 0..self.points() {
                let near = numbers
                    .next()
                    .is_some_and(|value| value >= largest - margin * largest.abs());
                if !near {
                    continue;
                }
                self.corner(point, &mut scratch.factors);
                place.evaluator.built.derivatives_times(
                    values,
                    &scratch.factors,
                    &mut scratch.inner.values,
                );
                let found =
                    place
                        .evaluator
                        .pieces(place.program, factor, margin, &mut scratch.inner, push);
                if !found {
                    return false;
                }
            }
        }
        true
    }

    /// The value with what is known about it; `index` is this criterion's among those that are taken again and again.
    pub(super) fn certified(
        &self,
        values: &ValueScratch,
        scratch: &mut VariedScratch,
        index: usize,
    ) -> (Certified, Missed) {
        let mut missed = Missed::new();
        let mut points: Vec<Point> = Vec::new();
        for (number, place) in self.places.iter().enumerate() {
            for point in 0..self.points() {
                self.corner(point, &mut scratch.factors);
                let found = place.certified(values, scratch);
                missed.extend(found.1.into_iter().map(|miss| miss.under(index, number)));
                points.push(Point {
                    value: found.0.value,
                    place: number,
                    factors: scratch.factors.clone(),
                    detail: found.0.detail,
                });
            }
        }
        let corners = points.len();
        // A criterion need not be largest at a corner; what lies between is looked at too.
        points.extend(self.between(values, scratch, &points));
        let numbers: Vec<f64> = points.iter().map(|point| point.value).collect();
        let mean = self.take == Statistic::Mean;
        let counted = if mean { corners } else { numbers.len() };
        let value = taken(self.take, numbers.get(..counted).unwrap_or_default());
        let place = points
            .iter()
            .position(|point| point.value.is_nan())
            .or_else(|| {
                let order = |a: &usize, b: &usize| numbers[*a].total_cmp(&numbers[*b]);
                match self.take {
                    Statistic::Smallest => (0..points.len()).min_by(order),
                    _ => (0..points.len()).max_by(order),
                }
            });
        let chosen = place.and_then(|place| points.get(place));
        let words = chosen.map(|point| self.words(point)).unwrap_or_default();
        let looked = corners
            + if self.tolerances.is_empty() {
                0
            } else {
                BETWEEN
            };
        let what = match self.take {
            Statistic::Largest => "largest",
            Statistic::Smallest => "smallest",
            Statistic::Mean => "mean",
            Statistic::Spread => "spread",
        };
        let mut taken = format!("{what} of {} points", if mean { corners } else { looked });
        if !mean && !words.is_empty() {
            let lead = if self.take == Statistic::Spread {
                ", largest at "
            } else {
                ", at "
            };
            taken.push_str(lead);
            taken.push_str(&words);
        }
        let outdone = self.take == Statistic::Spread && points.len() > corners;
        if outdone || place.is_some_and(|place| place >= corners) {
            taken.push_str(" (between the corners of the tolerances)");
        }
        let status = match chosen {
            Some(point) if point.value.is_nan() => {
                format!("no value at {words}: {}", point.detail.status)
            }
            Some(point) => point.detail.status.clone(),
            None => "there is nothing to take".to_owned(),
        };
        let detail = CriterionDetail {
            unit: self.dimension.unit_text(),
            at_hz: chosen.and_then(|point| point.detail.at_hz),
            at_s: chosen.and_then(|point| point.detail.at_s),
            achieved_tolerance: points
                .iter()
                .map(|point| point.detail.achieved_tolerance)
                .try_fold(0.0, |worst: f64, one| Some(worst.max(one?))),
            taken: Some(taken),
            bands: Vec::new(),
            status,
        };
        (Certified { value, detail }, missed)
    }

    /// Points within the tolerances that outdo all corners by more than the criterion's tolerance.
    fn between(
        &self,
        values: &ValueScratch,
        scratch: &mut VariedScratch,
        corners: &[Point],
    ) -> Vec<Point> {
        let numbers: Vec<f64> = corners.iter().map(|point| point.value).collect();
        let [mut least, mut most] =
            [Statistic::Smallest, Statistic::Largest].map(|take| taken(take, &numbers));
        let mut found = Vec::new();
        if self.tolerances.is_empty() || self.take == Statistic::Mean || least.is_nan() {
            return found;
        }
        let ratio = plastic(self.tolerances.len());
        for (number, place) in self.places.iter().enumerate() {
            for point in 1..=BETWEEN {
                self.factors(&mut scratch.factors, |variable| {
                    // The additive recurrence of M. Roberts (2018): evenly spread in any number of dimensions.
                    let step = ratio.powi(-i32::try_from(variable + 1).unwrap_or(i32::MAX));
                    2.0 * (0.5 + step * point as f64).fract() - 1.0
                });
                let value = place.fast(values, scratch);
                let margin = self.tolerance * value.abs();
                let outdoes = match self.take {
                    Statistic::Largest => value > most + margin,
                    Statistic::Smallest => value < least - margin,
                    Statistic::Spread => value > most + margin || value < least - margin,
                    Statistic::Mean => false,
                };
                if !outdoes && !value.is_nan() {
                    continue;
                }
                let (certified, _) = place.certified(values, scratch);
                (least, most) = (least.min(value), most.max(value));
                found.push(Point {
                    value: certified.value,
                    place: number,
                    factors: scratch.factors.clone(),
                    detail: certified.detail,
                });
            }
        }
        found
    }

    /// `m = 300 kg, k1 +10 %`.
    fn words(&self, point: &Point) -> String {
        let mut parts: Vec<String> = Vec::new();
        if let Some(place) = self.places.get(point.place) {
            for (name, quantity) in &place.at {
                let unit = quantity.dimension.unit_text();
                let value = rounded(quantity.value);
                parts.push(format!("{name} = {value} {unit}").trim_end().to_owned());
            }
        }
        for (index, name, _) in &self.tolerances {
            let factor = point.factors.get(*index).copied().unwrap_or(1.0);
            let percent = 100.0 * (factor - 1.0);
            if percent != 0.0 {
                let mut part = name.clone();
                // Writing to a string cannot fail.
                let _ = write!(part, " {percent:+.3} %");
                parts.push(part.replace(".000 %", " %"));
            }
        }
        if parts.is_empty() && !self.tolerances.is_empty() {
            return "the values as meant".to_owned();
        }
        parts.join(", ")
    }

    pub(super) fn add_frequencies(&mut self, place: usize, miss: &Miss) -> Result<(), Fault> {
        match self.places.get_mut(place) {
            Some(place) => place.evaluator.add_frequencies(std::slice::from_ref(miss)),
            None => Ok(()),
        }
    }
}

/// A criterion at a point.
struct Point {
    value: f64,
    place: usize,
    factors: Vec<f64>,
    detail: CriterionDetail,
}

impl Place {
    fn fast(&self, values: &ValueScratch, scratch: &mut VariedScratch) -> f64 {
        let built = &self.evaluator.built;
        built.values_times(values, &scratch.factors, &mut scratch.inner.values);
        scratch.out.clear();
        scratch.out.resize(self.evaluator.programs.len(), f64::NAN);
        self.evaluator.fast(&mut scratch.inner, &mut scratch.out);
        scratch.out.get(self.program).copied().unwrap_or(f64::NAN)
    }

    fn certified(&self, values: &ValueScratch, scratch: &mut VariedScratch) -> (Certified, Missed) {
        let built = &self.evaluator.built;
        built.values_times(values, &scratch.factors, &mut scratch.inner.values);
        let (mut all, missed) = self.evaluator.certified(&mut scratch.inner);
        // It is last: what it is made of stands before it.
        all.truncate(self.program + 1);
        let found = all.pop().unwrap_or_else(|| Certified {
            value: f64::NAN,
            detail: CriterionDetail::absent("there is no such criterion"),
        });
        (found, missed)
    }
}

/// The tolerance that holds for a value: the most particular name first, then what is said of all.
fn tolerance_of<'a>(keys: &[String], tolerances: &'a [Tolerance]) -> Option<&'a Tolerance> {
    // What has no name is no value.
    keys.first()?;
    keys.iter()
        .find_map(|key| {
            tolerances
                .iter()
                .find(|tolerance| tolerance.name.as_ref() == Some(key))
        })
        .or_else(|| tolerances.iter().find(|tolerance| tolerance.name.is_none()))
}

/// NaN where any number is: the worst of several is unknown as soon as one is.
fn taken(take: Statistic, numbers: &[f64]) -> f64 {
    if numbers.is_empty() || numbers.iter().any(|value| value.is_nan()) {
        return f64::NAN;
    }
    let largest = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let smallest = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    match take {
        Statistic::Largest => largest,
        Statistic::Smallest => smallest,
        Statistic::Mean => numbers.iter().sum::<f64>() / numbers.len() as f64,
        Statistic::Spread => largest - smallest,
    }
}

/// To six digits, for people.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// The root above 1 of x^(n+1) = x + 1.
fn plastic(dimension: usize) -> f64 {
    let exponent = 1.0 / (dimension as f64 + 1.0);
    let mut x = 1.5_f64;
    for _ in 0..64 {
        x = (1.0 + x).powf(exponent);
    }
    x
}
