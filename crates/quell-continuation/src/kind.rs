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
    /// Cusp. Normal form: c of dξ/dt = c ξ³ along the null vector of unit length.
    Cusp,
    /// Bogdanov-Takens.
    BogdanovTakens,
    /// Generalised Hopf (Bautin).
    GeneralisedHopf,
    /// Zero-Hopf.
    ///
    /// Normal form: the quadratic coefficients ½⟨p₀, B(q₀, q₀)⟩, Re⟨p₁, B(q₀, q₁)⟩ and ⟨p₀, B(q₁, q̄₁)⟩ with ⟨q, q⟩ = ⟨p, q⟩ = 1 for
    /// both (Kuznetsov 2004, section 8.7).
    ZeroHopf,
    /// Hopf-Hopf.
    ///
    /// Normal form on a curve: Re p₁₁, Re p₁₂, Re p₂₁, Re p₂₂ of dξ₁/dt = ξ₁ (iω₁ + p₁₁ |ξ₁|² + p₁₂ |ξ₂|²), dξ₂/dt likewise, with ⟨q, q⟩ =
    /// ⟨p, q⟩ = 1 for both pairs (Kuznetsov 2004, section 8.8). On a branch in one parameter: the first Lyapunov coefficients of
    /// both pairs.
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
    /// Generalised period doubling: the coefficient of the period doubling vanishes.
    GeneralisedDoubling,
    /// Chenciner: the coefficient Re d of the torus vanishes.
    Chenciner,
    /// Fold of cycles and period doubling together.
    FoldDoubling,
    /// Fold of cycles and torus together.
    FoldTorus,
    /// Period doubling and torus together.
    DoublingTorus,
    /// Two tori together.
    TorusTorus,
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
            Self::GeneralisedDoubling => "GPD",
            Self::Chenciner => "CH",
            Self::FoldDoubling => "LPPD",
            Self::FoldTorus => "LPNS",
            Self::DoublingTorus => "PDNS",
            Self::TorusTorus => "NSNS",
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
