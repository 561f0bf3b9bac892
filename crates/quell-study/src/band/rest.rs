//! A system at rest as a matrix of two parameters.

use quell_continuation::{Linearisation, equilibrium_beside};
use quell_model::system::{EquilibriumStatus, Prepared};

use crate::built::{Built, ValueScratch};
use crate::continuation::Entry;
use crate::transient::{Source, parameters};

/// Largest part of q's range that the equilibrium is followed in one step, and the smallest.
const STRIDE: f64 = 1.0 / 32.0;
const SHORTEST: f64 = 1e-7;

/// Host and devices about the equilibrium that is followed from the lower end of q's range.
pub(super) struct AtRest<'a> {
    built: &'a Built,
    pub(super) prepared: Prepared<'a>,
    sources: &'a [Source],
    p: &'a Entry,
    q: Option<&'a Entry>,
    /// Range of q.
    span: (f64, f64),
    values: ValueScratch,
    base: Vec<f64>,
    all: Vec<f64>,
    start: Vec<f64>,
    /// p at which `known` holds.
    at: f64,
    /// Equilibria by q.
    known: Vec<(f64, Vec<f64>)>,
    rates: Vec<f64>,
}

impl<'a> AtRest<'a> {
    pub(super) fn new(
        built: &'a Built,
        mut prepared: Prepared<'a>,
        sources: &'a [Source],
        (p, q): (&'a Entry, Option<&'a Entry>),
        span: (f64, f64),
        values: &ValueScratch,
    ) -> Self {
        for input in 0..prepared.system().inputs() {
            prepared.set_waveform(input, None);
        }
        let own = prepared.start(0.0);
        let n = own.len();
        Self {
            built,
            prepared,
            sources,
            p,
            q,
            span,
            values: values.clone(),
            base: Vec::new(),
            all: Vec::new(),
            start: own,
            at: f64::NAN,
            known: Vec::new(),
            rates: vec![0.0; n],
        }
    }

    /// Sets both parameters.
    pub(super) fn set(&mut self, p: f64, q: f64) {
        if self.at.to_bits() != p.to_bits() {
            self.at = p;
            self.known.clear();
            if !self.p.places.is_empty() {
                self.built.place(&self.p.places, p, &mut self.values);
            }
            self.base = parameters(self.sources, &self.values.mechanical, &self.values.laws);
            if let Some(entry) = self.p.host.and_then(|index| self.base.get_mut(index)) {
                *entry = p;
            }
        }
        match self.q {
            Some(entry) if !entry.places.is_empty() => {
                let mut values = self.values.clone();
                self.built.place(&entry.places, q, &mut values);
                self.all = parameters(self.sources, &values.mechanical, &values.laws);
                if let Some(entry) = self.p.host.and_then(|index| self.all.get_mut(index)) {
                    *entry = p;
                }
            }
            _ => {
                self.all.clear();
                self.all.extend_from_slice(&self.base);
            }
        }
        let host = self.q.and_then(|entry| entry.host);
        if let Some(entry) = host.and_then(|index| self.all.get_mut(index)) {
            *entry = q;
        }
        self.prepared.set_parameters(&self.all);
    }

    /// Whether the state at which runs begin is at rest here, exactly: then nothing need be followed.
    fn rests(&mut self) -> bool {
        self.prepared.rates(0.0, &self.start, &mut self.rates);
        self.rates.iter().all(|rate| *rate == 0.0)
    }

    /// The equilibrium at (p, q), followed from the lower end of q's range.
    pub(super) fn equilibrium(&mut self, p: f64, q: f64) -> Option<Vec<f64>> {
        if self.rests() {
            return Some(self.start.clone());
        }
        if self.known.is_empty() {
            let low = self.span.0;
            self.set(p, low);
            let found = self.prepared.equilibrium(0.0, &self.start);
            if found.status == EquilibriumStatus::NotFound {
                return None;
            }
            self.known.push((low, found.state));
        }
        let nearest = self
            .known
            .iter()
            .min_by(|a, b| (a.0 - q).abs().total_cmp(&(b.0 - q).abs()));
        let (mut from, mut x) = nearest.cloned()?;
        let width = (self.span.1 - self.span.0).abs().max(f64::MIN_POSITIVE);
        let mut stride = STRIDE * width;
        while from != q {
            let step = (q - from).clamp(-stride, stride);
            let to = if (q - from).abs() <= stride {
                q
            } else {
                from + step
            };
            self.set(p, to);
            let prepared = &mut self.prepared;
            let next = equilibrium_beside(&x, |x, rates, jacobian| {
                prepared.jacobian(0.0, x, rates, jacobian);
            });
            let Some(next) = next else {
                stride = 0.25 * step.abs();
                if stride < SHORTEST * width {
                    return None;
                }
                continue;
            };
            x = next;
            from = to;
            stride = (2.0 * stride).min(STRIDE * width);
            // Neighbours that differences ask for are not worth keeping.
            let apart = |(at, _): &(f64, Vec<f64>)| (at - to).abs() > 1e-3 * width;
            if self.known.iter().all(apart) {
                self.known.push((to, x.clone()));
            }
        }
        self.set(p, q);
        Some(x)
    }
}

impl Linearisation for AtRest<'_> {
    fn states(&self) -> usize {
        self.start.len()
    }

    fn matrix(&mut self, p: f64, q: f64, out: &mut [f64]) -> bool {
        self.set(p, q);
        let Some(x) = self.equilibrium(p, q) else {
            return false;
        };
        self.prepared.state_matrix(0.0, &x, out);
        out.iter().all(|entry| entry.is_finite())
    }
}
