//! Harmonic inputs written out, so that their amplitude and frequency are parameters like any other.

use quell_expression::{Differentiation, Expression, ExpressionError, Function, Graph, Slot};

use super::host::{EquationHost, Symbol};
use super::names::NoExtraNames;
use super::waveform::Waveform;

/// Amplitude, frequency and phase of a harmonic input as they were typed, of parameters alone.
#[derive(Debug, Clone, PartialEq)]
pub struct HarmonicLaw {
    /// a.
    pub amplitude: Expression,
    /// ω.
    pub frequency: Expression,
    /// φ; none for zero.
    pub phase: Option<Expression>,
}

/// A host whose harmonic inputs are written out.
#[derive(Debug, Clone)]
pub struct Driven {
    /// The host, in whose equations a sin(ωt + φ) stands in the place of each harmonic input, with its derivatives.
    pub host: EquationHost,
    /// ω of each of them, in the graph of the host.
    pub frequencies: Vec<Slot>,
    /// Inputs that are something else in time: pulses, samples, sweeps.
    pub others: Vec<String>,
}

impl EquationHost {
    /// The same host with its harmonic inputs written out: u = a sin(ωt + φ), u' and u'' by exact differentiation.
    ///
    /// # Errors
    /// An amplitude, frequency or phase that cannot be lowered.
    pub fn driven(&self) -> Result<Driven, ExpressionError> {
        let mut host = self.clone();
        let mut graph = std::mem::take(&mut host.graph);
        let mut with: Vec<(usize, Slot)> = Vec::new();
        let mut frequencies = Vec::new();
        let mut others = Vec::new();
        let time_input = self.input(Symbol::Time).unwrap_or(usize::MAX);
        for (index, input) in self.inputs.iter().enumerate() {
            let harmonic = match &input.waveform {
                None => continue,
                Some(Waveform::Harmonic(harmonic)) if harmonic.sweep.is_none() => harmonic,
                Some(_) => {
                    others.push(input.name.clone());
                    continue;
                }
            };
            let slot = |typed: Option<&Expression>, value: f64, graph: &mut Graph| match typed {
                Some(typed) if !typed.names().is_empty() => self
                    .lower(graph, typed, &NoExtraNames)
                    .map(|(slot, _)| slot),
                _ => Ok(graph.constant(value)),
            };
            let law = input.harmonic.as_ref();
            let amplitude = slot(
                law.map(|law| &law.amplitude),
                harmonic.amplitude,
                &mut graph,
            )?;
            let frequency = slot(
                law.map(|law| &law.frequency),
                harmonic.frequency,
                &mut graph,
            )?;
            let typed = law.and_then(|law| law.phase.as_ref());
            let phase = slot(typed, harmonic.phase, &mut graph)?;
            let time = graph.input(time_input);
            let turned = graph.multiply(frequency, time);
            let angle = graph.add(turned, phase);
            let sine = graph.unary(Function::Sin, angle);
            let mut motion = graph.multiply(amplitude, sine);
            let one = graph.constant(1.0);
            for order in 0..3 {
                if let Some(input) = self.input(Symbol::Input { index, order }) {
                    with.push((input, motion));
                }
                let slope = graph.tangent(&[motion], &[(time_input, one)], Differentiation::Exact);
                motion = match slope.first().copied().flatten() {
                    Some(slope) => slope,
                    None => graph.constant(0.0),
                };
            }
            if !frequencies.contains(&frequency) {
                frequencies.push(frequency);
            }
        }
        let mut replace = |slots: &mut [&mut Slot]| {
            let roots: Vec<Slot> = slots.iter().map(|slot| **slot).collect();
            let found = graph.substitute(&roots, &with);
            for (slot, found) in slots.iter_mut().zip(found) {
                **slot = found;
            }
        };
        let mut all: Vec<&mut Slot> = host.residuals.iter_mut().collect();
        all.extend(host.states.iter_mut().map(|state| &mut state.rate));
        all.extend(host.ports.iter_mut().map(|port| &mut port.across));
        all.extend(host.outputs.iter_mut().map(|output| &mut output.value));
        for element in &mut host.elements {
            all.push(&mut element.stroke);
            all.extend(element.force.as_mut());
        }
        let definitions = host.vocabulary.definitions.iter_mut();
        all.extend(definitions.map(|(_, slot, _)| slot));
        replace(&mut all);
        host.graph = graph;
        Ok(Driven {
            host,
            frequencies,
            others,
        })
    }
}
