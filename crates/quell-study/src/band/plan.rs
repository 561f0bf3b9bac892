//! A stable band of a candidate, compiled.

use std::sync::Arc;

use num_complex::Complex64;
use quell_continuation::{
    Band, BandSettings, Bands, Edge, Limit, Linearisation, ParameterSpan, Peak, eigenvalue_near,
    stable_bands,
};
use quell_document::Fault;
use quell_expression::{Dimension, nearest};
use quell_model::EquationHost;
use quell_model::system::{Owner, System};
use quell_response::{OperatingError, OperatingPoint};

use super::ask::{BandSpec, BandValue};
use super::checks::{self, Tests};
use super::record::BandResult;
use super::rest::AtRest;
use crate::built::{Built, ValueScratch};
use crate::continuation::{Entry, ParameterRange};
use crate::situation::Situation;
use crate::study::Study;
use crate::transient::{Source, ValuePlaces, Watching, begun, sources};

/// How near an end of a range that is left out is approached, relative to the range.
const OPEN: f64 = 1e-6;

/// Relative step of differences by design variables.
const NUDGE: f64 = 1e-5;

/// The bands of a candidate at values of its design variables.
#[derive(Debug, Clone, Default)]
pub(crate) struct FoundBands {
    pub(crate) bands: Bands,
    /// What was tested beside the linear equations, for each band.
    pub(super) tests: Vec<Tests>,
    /// Why no linear equations hold about the equilibrium, where that was looked at.
    refused: Option<String>,
    /// Values of devices at which they hold.
    mechanical: Vec<f64>,
    laws: Vec<f64>,
}

impl FoundBands {
    /// Whether they hold at these values of devices.
    pub(crate) fn is_at(&self, values: &ValueScratch) -> bool {
        let same = |a: &[f64], b: &[f64]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
        };
        same(&self.mechanical, &values.mechanical) && same(&self.laws, &values.laws)
    }

    /// Islands of instability within the widest band that are not born.
    pub(crate) fn unborn(&self) -> impl Iterator<Item = Peak> + '_ {
        let widest = self.bands.widest().copied();
        self.bands.peaks.iter().copied().filter(move |peak| {
            peak.eigenvalue.re < 0.0
                && widest.is_some_and(|band| peak.p > band.lower.p && peak.p < band.upper.p)
        })
    }

    /// The number that a criterion is; zero width where there is no band, and no ends.
    pub(crate) fn value(&self, value: BandValue) -> f64 {
        if self.refused.is_some() {
            return f64::NAN;
        }
        match (self.bands.widest(), value) {
            (Some(band), BandValue::Width) => band.width(),
            (Some(band), BandValue::Lower) => band.lower.p,
            (Some(band), BandValue::Upper) => band.upper.p,
            (None, BandValue::Width) => 0.0,
            (None, _) => f64::NAN,
        }
    }
}

/// A free parameter of a band.
#[derive(Debug)]
pub(super) struct Free {
    pub(super) name: String,
    pub(super) unit: String,
    dimension: Dimension,
    pub(super) entry: Entry,
    pub(super) span: ParameterSpan,
    /// Whether the lower end is left out.
    open: bool,
}

/// A stable band, ready for values of design variables.
#[derive(Debug)]
pub(crate) struct BandPlan {
    spec: BandSpec,
    pub(super) system: System,
    pub(super) sources: Vec<Source>,
    pub(super) p: Free,
    pub(super) q: Option<Free>,
    settings: BandSettings,
}

impl BandPlan {
    /// Compiles it.
    ///
    /// # Errors
    /// Names, ranges or a start that do not fit host and devices.
    pub(crate) fn new(
        study: &Study,
        situation: &Situation,
        built: &Built,
        spec: &BandSpec,
    ) -> Result<Self, Fault> {
        let host = situation.equations()?;
        let host = begun(study, situation, &host, &spec.start)?;
        let devices = built.system_devices(study, &host)?;
        let watching = Watching::new(&host, &devices);
        let system = watching
            .system()
            .map_err(|error| Fault::at(&study.source, spec.span, error.to_string()))?;
        let first_elements = built.first_elements();
        let places = ValuePlaces {
            elements: &first_elements,
            law: &|device, name| built.law_place(device, name),
        };
        let sources = sources(&system, watching.devices(), &places);
        let reader = Reader {
            study,
            situation,
            built,
            host: &host,
            system: &system,
        };
        let p = reader.free(&spec.of, spec.of_span, spec.range.as_ref(), "range")?;
        let q = match &spec.over {
            Some(over) => Some(reader.free(&over.name, over.span, over.range.as_ref(), "over")?),
            None => None,
        };
        Ok(Self {
            spec: spec.clone(),
            system,
            sources,
            p,
            q,
            settings: BandSettings::default(),
        })
    }

    /// Whether it is the same computation as another criterion asks for.
    pub(crate) fn serves(&self, spec: &BandSpec) -> bool {
        let range = |range: Option<&ParameterRange>| range.map(|range| range.span);
        let own = &self.spec;
        // The texts of ranges stand in the study, each at one place.
        let starts = own.start.iter().zip(&spec.start);
        own.of == spec.of
            && range(own.range.as_ref()) == range(spec.range.as_ref())
            && own.over.as_ref().map(|over| &over.name) == spec.over.as_ref().map(|over| &over.name)
            && own
                .over
                .as_ref()
                .and_then(|over| range(over.range.as_ref()))
                == spec
                    .over
                    .as_ref()
                    .and_then(|over| range(over.range.as_ref()))
            && own.start.len() == spec.start.len()
            && starts
                .into_iter()
                .all(|((a, x), (b, y))| a == b && x.span() == y.span())
    }

    /// The dimension of the band's parameter.
    pub(crate) const fn dimension(&self) -> Dimension {
        self.p.dimension
    }

    /// The bands of the linear equations.
    pub(crate) fn find(&self, built: &Built, values: &ValueScratch) -> FoundBands {
        self.sought(built, values, &self.settings)
    }

    fn sought(&self, built: &Built, values: &ValueScratch, settings: &BandSettings) -> FoundBands {
        let mut rest = self.at_rest(built, values);
        let q = self.q.as_ref().map(|free| free.span);
        FoundBands {
            bands: stable_bands(&mut rest, self.p.span, q, settings),
            tests: Vec::new(),
            refused: None,
            mechanical: values.mechanical.clone(),
            laws: values.laws.clone(),
        }
    }

    /// The bands on grids twice as fine; with `cycles` those in which cycles were sought as well.
    pub(crate) fn tested(&self, built: &Built, values: &ValueScratch, cycles: bool) -> FoundBands {
        let finer = BandSettings {
            columns: 2 * self.settings.columns,
            rows: 2 * self.settings.rows,
            ..self.settings
        };
        let mut found = self.sought(built, values, &finer);
        found.refused = self.refused(built, values, &found);
        if found.refused.is_some() {
            return found;
        }
        if cycles {
            checks::test(self, built, values, &mut found);
        }
        found
    }

    /// Why no linear equations hold about the equilibrium in the middle of the widest band: a kink, a jump, time.
    fn refused(&self, built: &Built, values: &ValueScratch, found: &FoundBands) -> Option<String> {
        let middle = |span: &ParameterSpan| span.value(0.5);
        let p = found.bands.widest().map_or_else(
            || middle(&self.p.span),
            |band| 0.5 * (band.lower.p + band.upper.p),
        );
        let q = self.q.as_ref().map_or(0.0, |free| middle(&free.span));
        let mut rest = self.at_rest(built, values);
        rest.set(p, q);
        match OperatingPoint::find(&mut rest.prepared) {
            Ok(_) | Err(OperatingError::NoEquilibrium { .. } | OperatingError::Linear(_)) => None,
            Err(why) => Some(why.to_string()),
        }
    }

    /// ∂Re λ/∂(design variable) at (p, q), of the eigenvalue next to `near`: central differences, good to some 1e-6.
    pub(crate) fn growth_slopes(
        &self,
        built: &Built,
        values: &ValueScratch,
        (p, q): (f64, f64),
        near: Complex64,
    ) -> Vec<f64> {
        let n = self.system.states().len();
        let mut matrix = vec![0.0; n * n];
        let mut growth = |values: &ValueScratch| {
            let mut rest = self.at_rest(built, values);
            rest.matrix(p, q, &mut matrix)
                .then(|| eigenvalue_near(n, &matrix, near))
                .flatten()
                .map_or(f64::NAN, |value| value.re)
        };
        (0..built.variables.len())
            .map(|variable| {
                let Some(value) = built.value_of(values, variable) else {
                    return 0.0;
                };
                let range = built.variables.get(variable);
                let width = range.map_or(1.0, |range| range.upper - range.lower);
                let step = if value == 0.0 {
                    NUDGE * width
                } else {
                    NUDGE * value.abs()
                };
                let above = growth(&built.nudged(values, variable, step));
                let below = growth(&built.nudged(values, variable, -step));
                (above - below) / (2.0 * step)
            })
            .collect()
    }

    /// The gradient of a number of the widest band by design variables: of an edge dp/dθ = -(∂Re λ/∂θ)/(∂Re λ/∂p) at its critical
    /// point. None where there is no band or an edge where the equilibrium ends.
    pub(crate) fn slopes(
        &self,
        built: &Built,
        values: &ValueScratch,
        found: &FoundBands,
        value: BandValue,
    ) -> Option<Vec<f64>> {
        let band = found.bands.widest()?;
        let edge = |edge: &Edge| -> Option<Vec<f64>> {
            match edge.limit {
                Limit::Range => Some(vec![0.0; built.variables.len()]),
                Limit::NoEquilibrium => None,
                _ => {
                    let at = (edge.p, edge.q.unwrap_or(0.0));
                    let by = self.growth_slopes(built, values, at, edge.eigenvalue);
                    Some(by.into_iter().map(|slope| -slope / edge.slope).collect())
                }
            }
        };
        match value {
            BandValue::Lower => edge(&band.lower),
            BandValue::Upper => edge(&band.upper),
            BandValue::Width => {
                let (lower, upper) = (edge(&band.lower)?, edge(&band.upper)?);
                Some(upper.iter().zip(&lower).map(|(a, b)| a - b).collect())
            }
        }
    }

    pub(super) fn at_rest<'a>(&'a self, built: &'a Built, values: &ValueScratch) -> AtRest<'a> {
        let parameters =
            crate::transient::parameters(&self.sources, &values.mechanical, &values.laws);
        let span = self
            .q
            .as_ref()
            .map_or((0.0, 0.0), |free| (free.span.from, free.span.to));
        AtRest::new(
            built,
            self.system.prepare(&parameters),
            &self.sources,
            (&self.p.entry, self.q.as_ref().map(|free| &free.entry)),
            span,
            values,
        )
    }

    /// The bands for a record.
    pub(crate) fn results(&self, found: &FoundBands) -> Vec<BandResult> {
        if found.refused.is_some() {
            return Vec::new();
        }
        let bands = found.bands.bands.iter().enumerate();
        bands
            .map(|(index, band)| BandResult {
                lower: band.lower.p,
                upper: band.upper.p,
                lower_at: band.lower.q.filter(|_| self.q.is_some()),
                upper_at: band.upper.q.filter(|_| self.q.is_some()),
                limited_by: [(&band.lower, "lower"), (&band.upper, "upper")].map(|(edge, side)| {
                    let cycles = found.tests.get(index).and_then(|tests| tests.cut(side));
                    cycles.map_or_else(|| self.words(edge, side), str::to_owned)
                }),
                near: self.near(found, band),
                checks: self.checks(found, index),
            })
            .collect()
    }

    /// What ends a band, in words.
    fn words(&self, edge: &Edge, side: &str) -> String {
        let omega = edge.eigenvalue.im;
        let at = match (&self.q, edge.q) {
            (Some(free), Some(q)) => {
                format!(" at {} = {:.6} {}", free.name, q, free.unit)
            }
            _ => String::new(),
        };
        let end = |q: &Free| {
            let upper = edge
                .q
                .is_some_and(|at| at > 0.5 * (q.span.from + q.span.to));
            format!(
                ", at the {} end of the range of `{}`",
                if upper { "upper" } else { "lower" },
                q.name
            )
        };
        let at_end = self.q.as_ref().map(end).unwrap_or_default();
        match edge.limit {
            Limit::Range => format!("the {side} end of the range of `{}`", self.p.name),
            Limit::Hopf => format!("a Hopf point of {omega:.5} rad/s{at}"),
            Limit::HopfAtEnd => format!("a Hopf point of {omega:.5} rad/s{at_end}"),
            Limit::Fold => format!("a fold or branch point of equilibria{at}"),
            Limit::FoldAtEnd => format!("a fold or branch point of equilibria{at_end}"),
            Limit::NoEquilibrium => format!("the end of the equilibrium{at}"),
        }
    }

    /// Islands of instability within a band that a small change gives birth to.
    fn near(&self, found: &FoundBands, band: &Band) -> Vec<String> {
        let peaks = found.bands.peaks.iter();
        peaks
            .filter(|peak| peak.p > band.lower.p && peak.p < band.upper.p)
            .map(|peak| {
                let at = self.q.as_ref().map_or_else(String::new, |free| {
                    format!(", {} = {:.6} {}", free.name, peak.q, free.unit)
                });
                format!(
                    "an island of instability of {:.5} rad/s is not yet born at {} = {:.6} {}{at}: it would split the band (growth rate there {:.3e} 1/s)",
                    peak.eigenvalue.im, self.p.name, peak.p, self.p.unit, peak.eigenvalue.re
                )
            })
            .collect()
    }

    /// What was tested, in words.
    fn checks(&self, found: &FoundBands, index: usize) -> Vec<String> {
        let mut checks = Vec::new();
        let over = match &self.q {
            Some(free) => format!(
                " over all of `{}` at {} values of `{}`, {} points in all, with slopes between them",
                free.name, found.bands.columns, self.p.name, found.bands.samples
            ),
            None => format!(
                " at {} values of `{}`, with slopes between them",
                found.bands.columns, self.p.name
            ),
        };
        checks.push(format!("eigenvalues of the equilibrium{over}"));
        if let Some(free) = self.q.as_ref().filter(|free| free.open) {
            checks.push(format!(
                "the lower end of `{}`, which is left out, approached to {:.1e} {}",
                free.name, free.span.from, free.unit
            ));
        }
        match found.tests.get(index) {
            Some(tests) => checks.extend(tests.words.iter().cloned()),
            None => checks.push("cycles were not sought".to_owned()),
        }
        for (from, to) in &found.bands.unresolved {
            checks.push(format!(
                "not resolved between {from:.6} and {to:.6} {}",
                self.p.unit
            ));
        }
        checks
    }

    /// What is known about its numbers, in words.
    pub(crate) fn status(&self, found: &FoundBands) -> String {
        let name = &self.p.name;
        if let Some(why) = &found.refused {
            return why.clone();
        }
        match found.bands.widest() {
            None => format!(
                "there is no value of `{name}` in its range at which the equilibrium is stable throughout"
            ),
            Some(_) if !found.bands.unresolved.is_empty() => {
                "computed, but not everywhere resolved: see `checks`".to_owned()
            }
            Some(_) => "computed".to_owned(),
        }
    }

    /// Where something lies, in words.
    pub(crate) fn place(&self, p: f64, q: Option<f64>) -> String {
        let own = format!("{} = {p:.6} {}", self.p.name, self.p.unit);
        match (&self.q, q) {
            (Some(free), Some(q)) => format!("{own}, {} = {q:.6} {}", free.name, free.unit),
            _ => own,
        }
    }

    /// The relative error of the ends of the widest band.
    pub(crate) fn tolerance(found: &FoundBands) -> Option<f64> {
        let band = found.bands.widest()?;
        Some(band.lower.error.max(band.upper.error))
    }
}

/// What free parameters are looked up in.
struct Reader<'a> {
    study: &'a Study,
    situation: &'a Situation,
    built: &'a Built,
    host: &'a Arc<EquationHost>,
    system: &'a System,
}

impl Reader<'_> {
    fn free(
        &self,
        name: &str,
        span: quell_expression::Span,
        range: Option<&ParameterRange>,
        key: &str,
    ) -> Result<Free, Fault> {
        let fault = |message: String| Fault::at(&self.study.source, span, message);
        let places = self.built.places_of(name);
        let own = self.host.parameters.iter().find(|known| known.name == name);
        // A value of a device goes before a parameter of the host that has its name.
        let own = own.filter(|_| places.is_empty());
        if self.built.searches(&places) {
            return Err(fault(format!(
                "`{name}` is the band's own parameter, and the task searches it too"
            ))
            .help(format!(
                "take `{name}` out of `bounds`: its range is that of the criterion"
            )));
        }
        if places.is_empty() && own.is_none() {
            let names = self.built.value_names();
            let known = self.host.parameters.iter().map(|known| known.name.as_str());
            let all: Vec<&str> = known.chain(names.iter().map(String::as_str)).collect();
            let fault = fault(format!(
                "neither the host nor a device has a parameter `{name}`"
            ));
            return Err(match nearest(name, all.iter().copied()) {
                Some(near) => fault.help(format!("did you mean `{near}`?")),
                None => fault.help("name a parameter of the host, or a value in the layouts"),
            });
        }
        if let Some(derived) = own.filter(|own| own.input.is_none()) {
            return Err(fault(format!(
                "`{name}` follows from other parameters ({} here), so it cannot be free",
                derived.value.value
            ))
            .help("name one of those that it follows from"));
        }
        let dimension = match own {
            Some(own) => own.value.dimension,
            None => self.built.dimension_of(name).unwrap_or(Dimension::NONE),
        };
        let host = own.and_then(|_| {
            self.system
                .parameters()
                .iter()
                .position(|known| known.owner == Owner::Host && known.name == name)
        });
        let operating = self
            .host
            .operating
            .iter()
            .find(|known| known.parameter == name);
        let (from, to, open) = match (range, operating) {
            (Some(typed), _) => {
                let from = typed.from.value(&self.situation.parameters, dimension)?;
                let to = typed.to.value(&self.situation.parameters, dimension)?;
                if from >= to {
                    return Err(Fault::at(
                        &self.study.source,
                        typed.span,
                        format!(
                            "the range of `{name}` does not rise from its first value to its second"
                        ),
                    )
                    .help("write `[lower, upper]`"));
                }
                (from, to, false)
            }
            (None, Some(known)) => (known.from, known.to, known.open),
            (None, None) => {
                let unit = dimension.unit_text();
                let help = if key == "range" {
                    format!("add `range = [\"… {unit}\", \"… {unit}\"]` to the criterion")
                } else {
                    format!(
                        "write `over = {{ {name} = [\"… {unit}\", \"… {unit}\"] }}`, or give `{name}` a range under `[operating]` of the host"
                    )
                };
                return Err(
                    fault(format!("nothing says over which range `{name}` goes")).help(help),
                );
            }
        };
        let logarithmic = from > 0.0 && to >= 10.0 * from;
        let inset = if open { OPEN * (to - from) } else { 0.0 };
        Ok(Free {
            name: name.to_owned(),
            unit: dimension.unit_text(),
            dimension,
            entry: Entry { host, places },
            span: ParameterSpan {
                from: from + inset,
                to,
                logarithmic,
            },
            open,
        })
    }
}
