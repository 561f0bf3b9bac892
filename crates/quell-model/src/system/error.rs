//! Why a host with devices is no system.

/// Why a host with devices is no system of first-order equations.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SystemError {
    /// The host has no such port.
    #[error("the host `{host}` has no port number {port}")]
    UnknownPort {
        /// The host.
        host: String,
        /// The index asked for.
        port: usize,
    },
    /// A nonlinear element without a force law.
    #[error("no force law is given for the element `{element}` of the device `{device}`")]
    NoLaw {
        /// The device.
        device: String,
        /// The element.
        element: String,
    },
    /// A device that ends in a mass on a port whose far side moves.
    #[error(
        "the device `{device}` ends in a mass, whose far side is the inertial frame, but the port `{port}` is between two points that move"
    )]
    MassBetween {
        /// The device.
        device: String,
        /// The port.
        port: String,
    },
    /// A hanging device without mass.
    #[error(
        "the device `{device}` hangs on the port `{port}`, so that its layout must end in a mass"
    )]
    NoMass {
        /// The device.
        device: String,
        /// The port.
        port: String,
    },
    /// A displacement that no element holds.
    #[error(
        "nothing holds {what}: it needs a spring, a damper or inertia that does not follow its motion"
    )]
    Floating {
        /// What moves freely.
        what: String,
    },
    /// Equations that do not determine what they should.
    #[error("the equations do not determine {what} where the run begins")]
    Undetermined {
        /// The unknown.
        what: String,
    },
    /// An equation of a massless coordinate holds a rate or acceleration that it must not.
    #[error(
        "the equation of {what} holds {other}, although {what} has neither inertia nor damping of its own to go with it"
    )]
    Order {
        /// Where.
        what: String,
        /// The quantity.
        other: String,
    },
    /// A massless coordinate at a nonlinear port.
    #[error(
        "the massless coordinate `{coordinate}` and the device on port `{port}` share a motion without states, and the port's across-variable does not have constant coefficients in it; give the coordinate a small mass"
    )]
    MasslessPort {
        /// The coordinate.
        coordinate: String,
        /// The port.
        port: String,
    },
    /// Something asked for that the minimal state does not determine.
    #[error("{what} is not determined by the state, because nothing depends on it")]
    NotAState {
        /// The quantity.
        what: String,
    },
    /// Rates of states that depend on each other.
    #[error("the rate of the state `{0}` depends on itself")]
    RateCycle(String),
    /// Forces that follow from themselves.
    #[error(
        "{what} follows from itself: the across-variable of a port moves with a first-order state whose rate depends on forces or accelerations"
    )]
    Circular {
        /// What does.
        what: String,
    },
    /// A held expression with a massless coordinate in it.
    #[error(
        "what is held depends on the massless coordinate `{0}`, whose acceleration is not determined; hold coordinates that have mass"
    )]
    HoldMassless(String),
    /// A held expression that does not depend on any coordinate.
    #[error("what is held does not depend on any coordinate of the host")]
    HoldNothing,
    /// A reaction where nothing is held.
    #[error("there is no reaction, because nothing is held in this phase")]
    NoReaction,
}
