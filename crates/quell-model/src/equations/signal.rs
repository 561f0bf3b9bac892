//! `signal`: what an input is in a run in time.

use std::path::{Path, PathBuf};

use quell_document::{Fault, Table, Value};
use quell_expression::{Dimension, Expression, Node};

use super::amounts::Amounts;
use super::driven::HarmonicLaw;
use super::keys;
use super::random::Random;
use super::samples::Samples;
use super::series;
use super::waveform::{Harmonic, Pulse, PulseShape, Sweep, Waveform};

/// Number of sines of a random signal unless the file says otherwise.
const HARMONICS: usize = 200;
/// More would make every evaluation of a model a wait.
const MOST_HARMONICS: usize = 100_000;

/// Reads `signal` of an input of the given dimension; files are looked for in `folder`.
pub(crate) fn waveform(
    value: &Value<'_>,
    dimension: Dimension,
    amounts: Amounts<'_>,
    folder: &Path,
) -> Result<Waveform, Fault> {
    read(&value.as_table()?, dimension, amounts, folder)
}

/// Reads the table of a signal.
pub(crate) fn read(
    table: &Table<'_>,
    dimension: Dimension,
    amounts: Amounts<'_>,
    folder: &Path,
) -> Result<Waveform, Fault> {
    table.check(&keys::SIGNAL)?;
    let given: Vec<_> = table.entries().collect();
    let [(kind, _, value)] = &given[..] else {
        return Err(table
            .fault("expected one of `harmonic`, `pulse`, `random` and `sampled`")
            .help("for example `signal = { harmonic = { amplitude = \"2 mm\", frequency = \"3 Hz\" } }`"));
    };
    let table = value.as_table()?;
    let reader = Reader { dimension, amounts };
    Ok(match *kind {
        "harmonic" => Waveform::Harmonic(reader.harmonic(&table)?),
        "pulse" => Waveform::Pulse(reader.pulse(&table)?),
        "random" => Waveform::Random(reader.random(&table)?),
        _ => Waveform::Sampled(reader.sampled(&table, folder)?),
    })
}

/// A harmonic signal without sweep as it was typed.
pub(crate) fn harmonic_law(value: &Value<'_>) -> Result<Option<HarmonicLaw>, Fault> {
    let Some(value) = value.as_table()?.get("harmonic") else {
        return Ok(None);
    };
    let table = value.as_table()?;
    if table.get("sweep").is_some() {
        return Ok(None);
    }
    let typed = |value: Value<'_>| -> Result<Expression, Fault> {
        if value.is_text() {
            return value.expression();
        }
        Ok(Expression {
            node: Node::Number(value.as_f64()?),
            span: value.span(),
        })
    };
    Ok(Some(HarmonicLaw {
        amplitude: typed(table.require("amplitude")?)?,
        frequency: typed(table.require("frequency")?)?,
        phase: table.get("phase").map(typed).transpose()?,
    }))
}

/// The file that a signal names, if it names one.
pub(crate) fn file(signal: &Value<'_>, folder: &Path) -> Option<PathBuf> {
    file_of(&signal.as_table().ok()?, folder)
}

/// The file that the table of a signal names, if it names one.
pub(crate) fn file_of(signal: &Table<'_>, folder: &Path) -> Option<PathBuf> {
    let sampled = signal.get("sampled")?.as_table().ok()?;
    Some(folder.join(sampled.get("file")?.as_str().ok()?))
}

struct Reader<'a> {
    dimension: Dimension,
    amounts: Amounts<'a>,
}

impl Reader<'_> {
    fn frequency(&self, value: &Value<'_>) -> Result<f64, Fault> {
        let frequency = self.amounts.read(value, Dimension::ANGULAR_FREQUENCY)?;
        if frequency < 0.0 {
            return Err(value.fault("a frequency must not be negative"));
        }
        Ok(frequency)
    }

    fn harmonic(&self, table: &Table<'_>) -> Result<Harmonic, Fault> {
        table.check(&keys::HARMONIC)?;
        let from = table.require("frequency")?;
        let frequency = self.frequency(&from)?;
        let sweep = table
            .get("sweep")
            .map(|value| self.sweep(&value.as_table()?, &from, frequency))
            .transpose()?;
        Ok(Harmonic {
            amplitude: self
                .amounts
                .read(&table.require("amplitude")?, self.dimension)?,
            frequency,
            phase: table
                .get("phase")
                .map_or(Ok(0.0), |value| self.amounts.read(&value, Dimension::ANGLE))?,
            sweep,
        })
    }

    fn sweep(&self, table: &Table<'_>, from: &Value<'_>, first: f64) -> Result<Sweep, Fault> {
        table.check(&keys::SWEEP)?;
        let to = table.require("to")?;
        let last = self.frequency(&to)?;
        let logarithmic = match table.get("scale") {
            Some(value) => value.one_of(&["linear", "log"])? == "log",
            None => false,
        };
        for (value, frequency) in [(from, first), (&to, last)] {
            if logarithmic && frequency == 0.0 {
                return Err(value
                    .fault("a logarithmic sweep neither begins nor ends at zero")
                    .help("give a positive frequency, or `scale = \"linear\"`"));
            }
        }
        let time = table.require("time")?;
        Ok(Sweep {
            to: last,
            time: self
                .amounts
                .positive(&time, Dimension::TIME, "the time of a sweep")?,
            logarithmic,
        })
    }

    fn pulse(&self, table: &Table<'_>) -> Result<Pulse, Fault> {
        table.check(&keys::PULSE)?;
        let shape = match table.get("shape") {
            Some(value) => match value.one_of(&["half-sine", "rectangular", "triangular"])? {
                "rectangular" => PulseShape::Rectangular,
                "triangular" => PulseShape::Triangular,
                _ => PulseShape::HalfSine,
            },
            None => PulseShape::HalfSine,
        };
        Ok(Pulse {
            shape,
            amplitude: self
                .amounts
                .read(&table.require("amplitude")?, self.dimension)?,
            duration: self.amounts.positive(
                &table.require("duration")?,
                Dimension::TIME,
                "the duration of a pulse",
            )?,
            at: table
                .get("at")
                .map_or(Ok(0.0), |value| self.amounts.read(&value, Dimension::TIME))?,
        })
    }

    fn random(&self, table: &Table<'_>) -> Result<Random, Fault> {
        table.check(&keys::RANDOM)?;
        let band = table.require("band")?;
        let ends = band.as_array()?;
        let [from, to] = &ends[..] else {
            return Err(band.fault(format!("a band has two ends, found {}", ends.len())));
        };
        let band_ends = [self.frequency(from)?, self.frequency(to)?];
        if band_ends[0] >= band_ends[1] {
            return Err(band.fault("the band must rise from its first frequency to its second"));
        }
        let count = match table.get("harmonics") {
            Some(value) => {
                let count = value.as_count()?;
                if count == 0 || count > MOST_HARMONICS {
                    return Err(value.fault(format!(
                        "expected 1 to {MOST_HARMONICS} harmonics, found {count}"
                    )));
                }
                count
            }
            None => HARMONICS,
        };
        let seed = match table.get("seed") {
            Some(value) => value.as_count()? as u64,
            None => 1,
        };
        let spectrum = match (table.get("spectrum"), table.get("rms")) {
            (Some(value), None) => self.spectrum(&value, band_ends)?,
            (None, Some(value)) => {
                let rms = self.amounts.read(&value, self.dimension)?;
                Spectrum::Flat(rms * rms / (band_ends[1] - band_ends[0]))
            }
            _ => {
                return Err(table
                    .fault("a random signal needs one of `spectrum` and `rms`")
                    .help("for example `rms = \"2 mm\"`"));
            }
        };
        Ok(Random::new(
            |omega| spectrum.at(omega),
            band_ends,
            count,
            seed,
        ))
    }

    fn spectrum(&self, value: &Value<'_>, band: [f64; 2]) -> Result<Spectrum, Fault> {
        if !value.is_array() {
            return Ok(Spectrum::Flat(self.density(value)?));
        }
        let mut points: Vec<(f64, f64)> = Vec::new();
        let list = value.as_array()?;
        for entry in &list {
            let pair = entry.as_array()?;
            let [frequency, density] = &pair[..] else {
                return Err(entry.fault(format!(
                    "expected a frequency and a density, found {} entries",
                    pair.len()
                )));
            };
            let omega = self.frequency(frequency)?;
            if omega == 0.0 {
                return Err(frequency
                    .fault("the axes are logarithmic, so the first frequency must be positive"));
            }
            if points.last().is_some_and(|(before, _)| *before >= omega) {
                return Err(frequency.fault("the frequencies must rise"));
            }
            let level = self.density(density)?;
            if level == 0.0 {
                return Err(
                    density.fault("the axes are logarithmic, so a density must be positive")
                );
            }
            points.push((omega, level));
        }
        match (points.first(), points.last()) {
            // Ends that were typed twice may differ by a rounding.
            (Some((first, _)), Some((last, _)))
                if *first <= band[0] * (1.0 + 1e-12) && *last >= band[1] * (1.0 - 1e-12) =>
            {
                Ok(Spectrum::Points(points))
            }
            _ => Err(value.fault("the spectrum does not reach from end to end of the band")),
        }
    }

    /// A one-sided spectral density, unit² s/rad, that must say per what it is meant.
    fn density(&self, value: &Value<'_>) -> Result<f64, Fault> {
        let square = self.dimension * self.dimension;
        let wanted = self
            .amounts
            .dimension(square / Dimension::ANGULAR_FREQUENCY);
        let unit = self.dimension.unit_text();
        let example = if unit.is_empty() {
            "1/Hz".to_owned()
        } else if unit.contains(['/', '*']) {
            format!("({unit})^2/Hz")
        } else {
            format!("{unit}^2/Hz")
        };
        if value.is_number() && !self.amounts.dimensionless && value.as_f64()? != 0.0 {
            return Err(value
                .fault("a plain number is ambiguous for a spectral density")
                .help(format!("write its unit, such as `2 {example}`")));
        }
        let quantity = value.quantity(self.amounts.parameters, None)?;
        let plain_zero = value.is_number() && quantity.value == 0.0;
        if quantity.dimension != wanted && !plain_zero {
            return Err(value
                .fault(format!(
                    "expected a spectral density in `{example}`, found one in {}",
                    quantity.dimension
                ))
                .help(format!("write its unit, such as `2 {example}`")));
        }
        if quantity.value < 0.0 {
            return Err(value.fault("a spectral density must not be negative"));
        }
        Ok(quantity.value)
    }

    fn sampled(&self, table: &Table<'_>, folder: &Path) -> Result<Samples, Fault> {
        table.check(&keys::SAMPLED)?;
        let factor = match table.get("unit") {
            Some(value) => {
                let unit = self.amounts.unit(&value)?;
                if !self.dimension.accepts(&unit.dimension) {
                    return Err(value.fault(format!(
                        "the input is in {}, but `{}` is {}",
                        self.dimension, unit.text, unit.dimension
                    )));
                }
                unit.factor
            }
            None => 1.0,
        };
        let file = table.require("file")?;
        let (times, mut values) =
            series::read(&folder.join(file.as_str()?)).map_err(|complaint| Fault {
                help: complaint.help,
                ..file.fault(complaint.message)
            })?;
        for value in &mut values {
            *value *= factor;
        }
        let linear = match table.get("interpolation") {
            Some(value) => value.one_of(&["cubic", "linear"])? == "linear",
            None => false,
        };
        let samples = if linear {
            Samples::linear(times, &values)
        } else {
            Samples::cubic(times, &values)
        };
        samples.ok_or_else(|| {
            file.fault("the file needs at least two samples, whose times rise from one to the next")
        })
    }
}

/// A one-sided spectral density over angular frequency.
enum Spectrum {
    Flat(f64),
    /// Straight lines on logarithmic axes through (ω, S), ω rising.
    Points(Vec<(f64, f64)>),
}

impl Spectrum {
    fn at(&self, omega: f64) -> f64 {
        match self {
            Self::Flat(level) => *level,
            Self::Points(points) => {
                let next = points
                    .partition_point(|(known, _)| *known < omega)
                    .clamp(1, points.len().saturating_sub(1).max(1));
                match (points.get(next - 1), points.get(next)) {
                    (Some((w0, s0)), Some((w1, s1))) => {
                        let part = (omega / w0).ln() / (w1 / w0).ln();
                        s0 * (s1 / s0).powf(part)
                    }
                    (Some((_, level)), None) => *level,
                    _ => 0.0,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Spectrum;

    /// S = 2/ω³ is a straight line on logarithmic axes.
    #[test]
    fn spectra_are_straight_on_logarithmic_axes() {
        let law = |omega: f64| 2.0 / omega.powi(3);
        let spectrum = Spectrum::Points([1.0, 4.0, 10.0].map(|omega| (omega, law(omega))).into());
        for omega in [1.0, 2.5, 4.0, 7.0, 10.0] {
            assert!((spectrum.at(omega) / law(omega) - 1.0).abs() < 1e-13);
        }
        assert_eq!(Spectrum::Points(vec![(1.0, 3.0)]).at(1.0), 3.0);
    }
}
