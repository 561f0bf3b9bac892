//! What is known of a run at one set of parameters.

use quell_document::Fault;
use quell_expression::{Dimension, Quantity, Scope, Tape, TapeBuilder};

use crate::criteria::RunKind;
use crate::situation::Situation;
use crate::study::{Run, Study};
use crate::transient::excitations;

/// One-sided spectrum per Hz as a function of f.
#[derive(Debug, Clone)]
pub(crate) struct SpectrumTape {
    tape: Tape,
}

impl SpectrumTape {
    /// S at ω (rad/s), in the input's unit² per Hz.
    pub(super) fn value(&self, omega: f64) -> f64 {
        let mut out = [f64::NAN];
        self.tape.evaluate(&[omega], &mut Vec::new(), &mut out);
        // In the study `f` is a quantity in rad/s like every frequency, and a spectrum "per Hz" is per 2π rad/s, so the
        // expression gives the density over ω; per Hz it is 2π times as large.
        out[0] * std::f64::consts::TAU
    }
}

/// What is known of a run at one set of parameters.
pub(crate) struct Prepared {
    pub(super) input: usize,
    pub(super) band: Option<(f64, f64)>,
    pub(super) spectrum: Option<(SpectrumTape, Dimension)>,
    pub(super) oscillatory: bool,
    pub(super) kind: RunKind,
}

pub(crate) fn prepare(study: &Study, situation: &Situation, run: &Run) -> Result<Prepared, Fault> {
    match run {
        Run::Transient(run) => {
            // A run that no criterion reads is looked at all the same.
            excitations(study, situation, run)?;
            Ok(Prepared {
                input: usize::MAX,
                band: None,
                spectrum: None,
                oscillatory: false,
                kind: RunKind::Transient,
            })
        }
        Run::Modes { oscillatory, .. } => Ok(Prepared {
            input: usize::MAX,
            band: None,
            spectrum: None,
            oscillatory: *oscillatory,
            kind: RunKind::Modes,
        }),
        Run::Frequency(run) => {
            let index = situation
                .host
                .inputs
                .iter()
                .position(|known| known.name == run.input)
                .ok_or_else(|| {
                    Fault::at(
                        &study.source,
                        run.input_span,
                        format!("there is no input `{}`", run.input),
                    )
                })?;
            let band = match &run.band {
                Some((lower, upper)) => Some(band_of(situation, lower, upper)?),
                None => None,
            };
            let spectrum = match &run.spectrum {
                Some(amount) => Some(spectrum_of(situation, amount, index)?),
                None => None,
            };
            let kind = RunKind::Frequency {
                band: band.is_some(),
                spectrum: spectrum.as_ref().map(|(_, dimension)| *dimension),
            };
            Ok(Prepared {
                input: index,
                band,
                spectrum,
                oscillatory: false,
                kind,
            })
        }
    }
}

/// The least and the largest upper frequency of a band, rad/s.
const SLOWEST: f64 = 1e-9 * std::f64::consts::TAU;
const FASTEST: f64 = 1e12 * std::f64::consts::TAU;

/// The least width of a band over its upper frequency.
const NARROWEST: f64 = 1e-8;

/// Lower and upper frequency, rad/s.
fn band_of(
    situation: &Situation,
    lower: &crate::amount::Amount,
    upper: &crate::amount::Amount,
) -> Result<(f64, f64), Fault> {
    let low = lower.value(&situation.parameters, Dimension::ANGULAR_FREQUENCY)?;
    let high = upper.value(&situation.parameters, Dimension::ANGULAR_FREQUENCY)?;
    if low < 0.0 {
        return Err(lower.fault("a band begins at 0 Hz or above"));
    }
    if high <= low {
        return Err(upper
            .fault("the band is empty: its upper frequency is not above the lower one")
            .help("write `band = [\"0 Hz\", \"30 Hz\"]`"));
    }
    // Outside these a grid of frequencies has no sense, and numbers near the smallest cannot be told apart.
    if !(SLOWEST..=FASTEST).contains(&high) {
        return Err(upper
            .fault("a band ends between 1e-9 Hz and 1e12 Hz")
            .help("are the units the ones that are meant?"));
    }
    if high - low < NARROWEST * high {
        return Err(upper
            .fault("the band is narrower than a millionth of a percent of its frequency")
            .help("`abs(y, 12 Hz)` gives the magnitude at one frequency"));
    }
    Ok((low, high))
}

/// Host parameters and the frequency `f`.
struct WithFrequency<'a> {
    omega: f64,
    outer: &'a dyn Scope,
}

impl Scope for WithFrequency<'_> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        if name == "f" {
            Some(Quantity::new(self.omega, Dimension::ANGULAR_FREQUENCY))
        } else {
            self.outer.quantity(name)
        }
    }

    fn names(&self) -> Vec<&str> {
        let mut names = self.outer.names();
        names.push("f");
        names
    }
}

/// The spectrum with the dimension of S·Hz (the input squared).
fn spectrum_of(
    situation: &Situation,
    amount: &crate::amount::Amount,
    input: usize,
) -> Result<(SpectrumTape, Dimension), Fault> {
    let sample = WithFrequency {
        omega: 1.0,
        outer: &situation.parameters,
    };
    let quantity = amount.quantity(&sample)?;
    let own = situation
        .host
        .inputs
        .get(input)
        .map_or(Dimension::NONE, |input| input.dimension);
    let expected = own * own / Dimension::ANGULAR_FREQUENCY;
    if quantity.dimension.without_angle() != expected.without_angle() {
        return Err(amount
            .fault(format!(
                "a spectrum of this input is in {}/Hz, found {}",
                (own * own).unit_text(),
                quantity.dimension
            ))
            .help("spectra are one-sided: the variance is the integral of S over f > 0"));
    }
    if quantity.value < 0.0 {
        return Err(amount.fault("a spectrum is not negative"));
    }
    let mut builder = TapeBuilder::new(&["f".to_owned()]);
    builder
        .add(amount.expression(), &situation.parameters)
        .map_err(|error| amount.fault(error.to_string()))?;
    Ok((
        SpectrumTape {
            tape: builder.build(),
        },
        own * own * Dimension::TIME,
    ))
}
