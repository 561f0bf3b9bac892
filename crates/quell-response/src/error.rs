//! What can go wrong, in the words of the person who described the system.

use thiserror::Error;

/// Why a response could not be computed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ResponseError {
    /// An array of the host has a wrong shape.
    #[error("{what} of host `{host}` has {found} entries where {expected} are needed")]
    Shape {
        /// The host.
        host: String,
        /// What has the wrong shape.
        what: String,
        /// The number expected.
        expected: usize,
        /// The number found.
        found: usize,
    },
    /// A device was given to a port that the host does not have.
    #[error("host `{host}` has no port number {port}; it has {ports}")]
    UnknownPort {
        /// The host.
        host: String,
        /// The number given.
        port: usize,
        /// How many ports there are.
        ports: usize,
    },
    /// An input, coordinate, port or derivative outside of the host.
    #[error("host `{host}` has no {what} number {index}; it has {count}")]
    UnknownIndex {
        /// The host.
        host: String,
        /// Input, coordinate, port.
        what: &'static str,
        /// The number given.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A signal names a part that no device on the port has.
    #[error("no device on port `{port}` has a part called `{part}`; {help}")]
    UnknownPart {
        /// The port.
        port: String,
        /// The name of the part.
        part: String,
        /// What there is instead.
        help: String,
    },
    /// Several devices on one port have a part of this name.
    #[error(
        "more than one device on port `{port}` has a part called `{part}`; give the parts different names"
    )]
    AmbiguousPart {
        /// The port.
        port: String,
        /// The name of the part.
        part: String,
    },
    /// A signal is differentiated too often.
    #[error("the {order}th time derivative of {what} was asked for; at most the {most}nd exists")]
    DerivativeOrder {
        /// The signal.
        what: String,
        /// The order asked for.
        order: usize,
        /// The highest order that exists.
        most: usize,
    },
    /// The slice of element values has a wrong length.
    #[error("{found} element values were given where the devices have {expected} elements")]
    ValueCount {
        /// The number of elements.
        expected: usize,
        /// The number of values.
        found: usize,
    },
    /// An element value is negative, infinite or not a number.
    #[error(
        "element `{element}` has the value `{value}`; element values must be finite and not negative"
    )]
    ElementValue {
        /// The element.
        element: String,
        /// Its value.
        value: f64,
    },
    /// An array or a frequency holds an infinity or something that is not a number.
    #[error("{what} holds a value that is not finite")]
    NotFinite {
        /// Where it is.
        what: String,
    },
    /// The mass matrix is not symmetric.
    #[error(
        "the mass matrix of host `{host}` is not symmetric: entries ({row}, {column}) are `{upper}` and `{lower}`; kinetic energy needs a symmetric matrix"
    )]
    UnsymmetricMass {
        /// The host.
        host: String,
        /// Coordinate of the row.
        row: String,
        /// Coordinate of the column.
        column: String,
        /// The entry.
        upper: f64,
        /// Its mirror image.
        lower: f64,
    },
    /// A coordinate without mass, damper or spring.
    #[error(
        "nothing holds coordinate `{coordinate}`: it has no mass, and neither a damper nor a spring acts on it; give it a mass or attach it"
    )]
    Floating {
        /// The coordinate.
        coordinate: String,
    },
    /// A massless, undamped coordinate that damping couples in one direction only.
    #[error(
        "coordinate `{coordinate}` has neither mass nor damping of its own, but the damping matrix couples it to others unsymmetrically, so its motion is not determined; give it a mass or a damper"
    )]
    UnsymmetricDamping {
        /// The coordinate.
        coordinate: String,
    },
    /// A matrix that must be invertible is singular at these values.
    #[error(
        "{what} is singular at these element values; a value may be zero or far out of scale with the others"
    )]
    Singular {
        /// Which matrix.
        what: &'static str,
    },
    /// The stamped system is singular at a frequency: an undamped resonance.
    #[error("the response at {hz} Hz is infinite: an undamped mode lies on this frequency")]
    SingularAt {
        /// The frequency, Hz.
        hz: f64,
    },
    /// The band of frequencies is empty or negative.
    #[error(
        "the band from {from} rad/s to {to} rad/s is empty; its upper edge must be positive and above the lower one, which must not be negative"
    )]
    Band {
        /// Lower edge, rad/s.
        from: f64,
        /// Upper edge, rad/s.
        to: f64,
    },
    /// A setting outside of its range.
    #[error("setting `{name}` is `{value}`; it must be {range}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// An input given as a velocity or an acceleration makes an output drift.
    #[error(
        "output of host `{host}` drifts: input `{input}` is a velocity or an acceleration and the output has a pole at zero frequency (residue `{residue}`); watch a relative motion or a derivative instead"
    )]
    PoleAtZero {
        /// The host.
        host: String,
        /// The input.
        input: String,
        /// Size of what does not vanish at zero frequency.
        residue: f64,
    },
    /// A pole in the right half plane.
    #[error(
        "the system is unstable: an eigenvalue is {real} + {imaginary}j rad/s; a variance does not exist"
    )]
    Unstable {
        /// Real part, rad/s.
        real: f64,
        /// Imaginary part, rad/s.
        imaginary: f64,
    },
    /// A pole on the imaginary axis that the output sees.
    #[error(
        "the system has an undamped mode at {hz} Hz that the output sees, so its variance is infinite; add damping or leave the frequency out of the band"
    )]
    Undamped {
        /// Frequency, Hz.
        hz: f64,
    },
    /// The transfer function does not vanish at infinite frequency.
    #[error(
        "the response to white noise over all frequencies has no finite variance: the transfer function tends to `{limit}`{growing} at high frequency; give a band or a spectrum, or watch another output"
    )]
    NotStrictlyProper {
        /// Its limit (or the leading coefficient).
        limit: f64,
        /// Says that it grows, where it does.
        growing: &'static str,
    },
    /// A complex stiffness is only defined for harmonic motion.
    #[error(
        "host `{host}` has loss factors (complex stiffness), which are only defined for harmonic motion; {task} needs viscous damping instead"
    )]
    LossFactors {
        /// The host.
        host: String,
        /// What was asked for.
        task: &'static str,
    },
    /// An eigenvalue solver gave up.
    #[error("the eigenvalues of a {size} by {size} matrix could not be computed")]
    Eigenvalues {
        /// Size of the matrix.
        size: usize,
    },
    /// A spectrum is negative or not finite.
    #[error(
        "the spectrum is `{value}` at {hz} Hz; a spectral density must be finite and not negative"
    )]
    Spectrum {
        /// Frequency, Hz.
        hz: f64,
        /// Value of the spectrum.
        value: f64,
    },
}
