//! Names of special points.

use std::fmt;

/// The kind of a special point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// Fold of equilibria (limit point).
    Fold,
    /// Hopf point.
    Hopf,
    /// Branch point of equilibria.
    BranchPoint,
    /// Fold of cycles.
    ///
    /// Normal form: |b| of dξ/dt = b ξ², dτ/dt = 1 - σ ξ along x = x₀(τ) + ξ v(τ) + …, where v' = A v + σ f has period T, is
    /// free of the flow (∫⟨v, f⟩ = 0) and the mean of |v|² over a period is one. Units: 1/s for each unit of the states.
    CycleFold,
    /// Period doubling.
    ///
    /// Normal form: c of dξ/dt = c ξ³, dτ/dt = 1 + a ξ² along x = x₀(τ) + ξ v(τ) + …, where v' = A v, v(T) = -v(0) and the
    /// mean of |v|² is one. Negative: the doubled cycles are born stable.
    PeriodDoubling,
    /// Torus (Neimark-Sacker).
    ///
    /// Normal form: Re d and Im d of dξ/dt = d ξ |ξ|², dτ/dt = 1 + a |ξ|² along x = x₀(τ) + ξ v(τ) + ξ̄ v̄(τ) + …, where v' = A v,
    /// v(T) = exp(iθ) v(0) and the mean of |v|² is one. Re d negative: the torus is born stable.
    Torus,
    /// Branch point of cycles: a multiplier passes +1 without a fold.
    CycleBranchPoint,
    /// Cusp.
    Cusp,
    /// Bogdanov-Takens.
    BogdanovTakens,
    /// Generalised Hopf (Bautin).
    GeneralisedHopf,
    /// Zero-Hopf.
    ZeroHopf,
    /// Hopf-Hopf.
    HopfHopf,
    /// Strong resonance 1:1.
    Resonance1,
    /// Strong resonance 1:2.
    Resonance2,
    /// Strong resonance 1:3.
    Resonance3,
    /// Strong resonance 1:4.
    Resonance4,
    /// Cusp of cycles.
    CycleCusp,
    /// Zero of the monitor of this index.
    Monitor(usize),
}

impl Kind {
    /// The code used in files and labels.
    pub fn code(self) -> &'static str {
        match self {
            Self::Fold => "LP",
            Self::Hopf => "H",
            Self::BranchPoint => "BP",
            Self::CycleFold => "LPC",
            Self::PeriodDoubling => "PD",
            Self::Torus => "NS",
            Self::CycleBranchPoint => "BPC",
            Self::Cusp => "CP",
            Self::BogdanovTakens => "BT",
            Self::GeneralisedHopf => "GH",
            Self::ZeroHopf => "ZH",
            Self::HopfHopf => "HH",
            Self::Resonance1 => "R1",
            Self::Resonance2 => "R2",
            Self::Resonance3 => "R3",
            Self::Resonance4 => "R4",
            Self::CycleCusp => "CPC",
            Self::Monitor(_) => "UZ",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.code())
    }
}

/// How sure a special point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Certainty {
    /// Located to tolerance.
    Located,
    /// An eigenvalue comes to the axis, or is matched ambiguously, in a step too short to divide.
    Unresolved,
}
