//! Branches as bytes, to the last bit.

use num_complex::Complex64;

use crate::branch::{Branch, Equilibrium, Point, Special};
use crate::curve::{CriticalEquilibrium, CriticalOrbit};
use crate::kind::{Certainty, Kind};
use crate::orbit::Orbit;
use crate::settings::Stop;

/// The layout of what is written; another one is not read.
const LAYOUT: u8 = 1;

/// A solution that can be kept; the four kinds of this crate are.
pub trait Kept: Sized {
    /// Appends it.
    #[doc(hidden)]
    fn put(&self, out: &mut Vec<u8>);
    /// Takes it from the front; none where the bytes are something else.
    #[doc(hidden)]
    fn take(from: &mut &[u8]) -> Option<Self>;
}

impl<S: Kept> Branch<S> {
    /// The branch with all its solutions and their meshes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = vec![LAYOUT];
        self.points.put(&mut out);
        self.special.put(&mut out);
        self.at.put(&mut out);
        self.stop[0].put(&mut out);
        self.stop[1].put(&mut out);
        self.approximate.put(&mut out);
        out
    }

    /// What [`to_bytes`](Self::to_bytes) wrote, to the last bit; none where the bytes are something else.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (layout, mut from) = bytes.split_first()?;
        if *layout != LAYOUT {
            return None;
        }
        let from = &mut from;
        let branch = Self {
            points: Kept::take(from)?,
            special: Kept::take(from)?,
            at: Kept::take(from)?,
            stop: [Kept::take(from)?, Kept::take(from)?],
            approximate: Kept::take(from)?,
        };
        from.is_empty().then_some(branch)
    }

    /// Whether it ended because somebody asked it to, in a direction.
    pub fn is_interrupted(&self) -> bool {
        self.stop.contains(&Stop::Interrupted)
    }
}

impl Kept for u64 {
    fn put(&self, out: &mut Vec<u8>) {
        out.extend(self.to_le_bytes());
    }
    fn take(from: &mut &[u8]) -> Option<Self> {
        let (bytes, rest) = from.split_first_chunk()?;
        *from = rest;
        Some(Self::from_le_bytes(*bytes))
    }
}

impl Kept for f64 {
    fn put(&self, out: &mut Vec<u8>) {
        self.to_bits().put(out);
    }
    fn take(from: &mut &[u8]) -> Option<Self> {
        u64::take(from).map(Self::from_bits)
    }
}

impl Kept for usize {
    fn put(&self, out: &mut Vec<u8>) {
        (*self as u64).put(out);
    }
    fn take(from: &mut &[u8]) -> Option<Self> {
        Self::try_from(u64::take(from)?).ok()
    }
}

impl Kept for bool {
    fn put(&self, out: &mut Vec<u8>) {
        out.push(u8::from(*self));
    }
    fn take(from: &mut &[u8]) -> Option<Self> {
        let (byte, rest) = from.split_first()?;
        *from = rest;
        match byte {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }
}

impl<T: Kept> Kept for Vec<T> {
    fn put(&self, out: &mut Vec<u8>) {
        self.len().put(out);
        for one in self {
            one.put(out);
        }
    }
    fn take(from: &mut &[u8]) -> Option<Self> {
        let count = usize::take(from)?;
        // Every element is a byte at least, so a false count asks for no more room than there is.
        if count > from.len() {
            return None;
        }
        (0..count).map(|_| T::take(from)).collect()
    }
}

impl<T: Kept> Kept for Option<T> {
    fn put(&self, out: &mut Vec<u8>) {
        self.is_some().put(out);
        if let Some(own) = self {
            own.put(out);
        }
    }
    fn take(from: &mut &[u8]) -> Option<Self> {
        if bool::take(from)? {
            T::take(from).map(Some)
        } else {
            Some(None)
        }
    }
}

impl Kept for String {
    fn put(&self, out: &mut Vec<u8>) {
        self.len().put(out);
        out.extend(self.as_bytes());
    }
    fn take(from: &mut &[u8]) -> Option<Self> {
        let length = usize::take(from)?;
        let (bytes, rest) = from.split_at_checked(length)?;
        *from = rest;
        Self::from_utf8(bytes.to_vec()).ok()
    }
}

impl Kept for Complex64 {
    fn put(&self, out: &mut Vec<u8>) {
        self.re.put(out);
        self.im.put(out);
    }
    fn take(from: &mut &[u8]) -> Option<Self> {
        Some(Self::new(f64::take(from)?, f64::take(from)?))
    }
}

/// Kinds in the order of their numbers; monitors come after.
const KINDS: [Kind; 23] = [
    Kind::Fold,
    Kind::Hopf,
    Kind::BranchPoint,
    Kind::CycleFold,
    Kind::PeriodDoubling,
    Kind::Torus,
    Kind::CycleBranchPoint,
    Kind::Cusp,
    Kind::BogdanovTakens,
    Kind::GeneralisedHopf,
    Kind::ZeroHopf,
    Kind::HopfHopf,
    Kind::Resonance1,
    Kind::Resonance2,
    Kind::Resonance3,
    Kind::Resonance4,
    Kind::CycleCusp,
    Kind::GeneralisedDoubling,
    Kind::Chenciner,
    Kind::FoldDoubling,
    Kind::FoldTorus,
    Kind::DoublingTorus,
    Kind::TorusTorus,
];

/// Writes a variant by its place in a list, one with an index by what comes after the list.
fn put_variant<T: PartialEq>(list: &[T], own: &T, index: Option<usize>, out: &mut Vec<u8>) {
    let place = || list.iter().position(|one| one == own);
    index
        .map(|index| list.len() + index)
        .or_else(place)
        .unwrap_or(usize::MAX)
        .put(out);
}

/// What [`put_variant`] wrote.
fn take_variant<T: Copy>(
    list: &[T],
    indexed: impl FnOnce(usize) -> T,
    from: &mut &[u8],
) -> Option<T> {
    let number = usize::take(from).filter(|number| *number != usize::MAX)?;
    let known = list.get(number).copied();
    Some(known.unwrap_or_else(|| indexed(number - list.len())))
}

impl Kept for Kind {
    fn put(&self, out: &mut Vec<u8>) {
        let index = match self {
            Self::Monitor(index) => Some(*index),
            _ => None,
        };
        put_variant(&KINDS, self, index, out);
    }
    fn take(from: &mut &[u8]) -> Option<Self> {
        take_variant(&KINDS, Self::Monitor, from)
    }
}

impl Kept for Certainty {
    fn put(&self, out: &mut Vec<u8>) {
        (*self == Self::Located).put(out);
    }
    fn take(from: &mut &[u8]) -> Option<Self> {
        Some(if bool::take(from)? {
            Self::Located
        } else {
            Self::Unresolved
        })
    }
}

/// Stops in the order of their numbers; bounds come after.
const STOPS: [Stop; 12] = [
    Stop::Points,
    Stop::NoConvergence,
    Stop::NotFinite,
    Stop::Singular,
    Stop::PeriodBound,
    Stop::DegenerateFamily,
    Stop::Vanished,
    Stop::Closed,
    Stop::EndOfKind,
    Stop::Monitor,
    Stop::Interrupted,
    Stop::NotAsked,
];

impl Kept for Stop {
    fn put(&self, out: &mut Vec<u8>) {
        let index = match self {
            Self::Bound(index) => Some(*index),
            _ => None,
        };
        put_variant(&STOPS, self, index, out);
    }
    fn take(from: &mut &[u8]) -> Option<Self> {
        take_variant(&STOPS, Self::Bound, from)
    }
}

/// Writes and reads a structure field by field.
macro_rules! fields {
    ($name:ident $(<$s:ident>)?, $($field:ident),+) => {
        impl $(<$s: Kept>)? Kept for $name $(<$s>)? {
            fn put(&self, out: &mut Vec<u8>) {
                // Named, so that a new field does not compile until it is kept too.
                let Self { $($field),+ } = self;
                $($field.put(out);)+
            }
            fn take(from: &mut &[u8]) -> Option<Self> {
                Some(Self { $($field: Kept::take(from)?),+ })
            }
        }
    };
}

fields!(Equilibrium, state, parameters);
fields!(
    Orbit, mesh, degree, dimension, states, period, periods, winding, parameters
);
fields!(CriticalEquilibrium, equilibrium, omega);
fields!(CriticalOrbit, orbit, angle);
fields!(Point<S>, solution, spectrum, unstable, spectrum_error);

impl<S: Kept> Kept for Special<S> {
    fn put(&self, out: &mut Vec<u8>) {
        let Self {
            label,
            kind,
            certainty,
            solution,
            tangent,
            omega,
            second_omega,
            normal_form,
            unstable: [before, behind],
            spectrum,
            error,
            after,
        } = self;
        label.put(out);
        kind.put(out);
        certainty.put(out);
        solution.put(out);
        tangent.put(out);
        omega.put(out);
        second_omega.put(out);
        normal_form.put(out);
        before.put(out);
        behind.put(out);
        spectrum.put(out);
        error.put(out);
        after.put(out);
    }
    fn take(from: &mut &[u8]) -> Option<Self> {
        Some(Self {
            label: Kept::take(from)?,
            kind: Kept::take(from)?,
            certainty: Kept::take(from)?,
            solution: Kept::take(from)?,
            tangent: Kept::take(from)?,
            omega: Kept::take(from)?,
            second_omega: Kept::take(from)?,
            normal_form: Kept::take(from)?,
            unstable: [Kept::take(from)?, Kept::take(from)?],
            spectrum: Kept::take(from)?,
            error: Kept::take(from)?,
            after: Kept::take(from)?,
        })
    }
}
