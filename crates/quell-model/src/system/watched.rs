//! What can be watched of a system.

use quell_expression::Slot;

/// A quantity of a host with devices.
///
/// Powers are such that, with massive and massless coordinates alike,
///
/// ```text
/// d(Kinetic)/dt = HostPower - Σ_ports PortPower + ReactionPower
/// Σ_elements ElementPower = DevicePower = F x'     for each device
/// ```
///
/// PortPower and the sum of DevicePower on that port are equal where the port's force acts by virtual work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Time, s.
    Time,
    /// A coordinate of the host, differentiated `order` times (0, 1, 2).
    Coordinate {
        /// Index in the host.
        index: usize,
        /// Number of derivatives.
        order: usize,
    },
    /// A first-order state of the host, or its rate.
    State {
        /// Index in the host.
        index: usize,
        /// Whether its rate is meant.
        rate: bool,
    },
    /// An input of the host, differentiated `order` times.
    Input {
        /// Index in the host.
        index: usize,
        /// Number of derivatives.
        order: usize,
    },
    /// Force on a port: of its devices, or the reaction while the port is held.
    PortForce {
        /// Index of the port.
        port: usize,
    },
    /// The across-variable of a port, differentiated `order` times (0, 1, 2).
    PortStroke {
        /// Index of the port.
        port: usize,
        /// Number of derivatives.
        order: usize,
    },
    /// Force of a device at its head.
    DeviceForce {
        /// Index of the device.
        device: usize,
    },
    /// Force through an element.
    ElementForce {
        /// Index of the device.
        device: usize,
        /// Index of the element in it.
        element: usize,
    },
    /// Relative displacement of an element, or its rate.
    ElementStroke {
        /// Index of the device.
        device: usize,
        /// Index of the element in it.
        element: usize,
        /// Number of derivatives, 0 or 1.
        order: usize,
    },
    /// The force of the constraint that holds.
    Reaction,
    /// ½ q'ᵀ M q' of the host's coordinates, M = ∂R/∂q''.
    Kinetic,
    /// F x' of an element: what it takes.
    ElementPower {
        /// Index of the device.
        device: usize,
        /// Index of the element in it.
        element: usize,
    },
    /// F x' of a device: what it receives.
    DevicePower {
        /// Index of the device.
        device: usize,
    },
    /// Σ q_i' ∂R_i/∂F F: what the host gives to a port.
    PortPower {
        /// Index of the port.
        port: usize,
    },
    /// F x' of a port: what is received there.
    PortReceived {
        /// Index of the port.
        port: usize,
    },
    /// What all other forces of the host give, inputs included, with ½ q'ᵀ M' q'.
    HostPower,
    /// The part of [`Self::HostPower`] that is absent when all inputs are zero.
    InputPower,
    /// What the constraint gives; zero but for rounding while it holds.
    ReactionPower,
}

/// A signal of a system.
#[derive(Debug, Clone, PartialEq)]
pub enum Watched {
    /// A quantity.
    Quantity(Quantity),
    /// An expression in the graph of the host: an output, or one lowered into it.
    Host(Slot),
}

impl From<Quantity> for Watched {
    fn from(quantity: Quantity) -> Self {
        Self::Quantity(quantity)
    }
}

/// What a phase of a run holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Phase {
    /// Nothing: all moves freely.
    #[default]
    Free,
    /// The across-variable of a port stays as it is. The force of its devices is taken off the host, and what holds it is
    /// the port's force instead: the reaction λ takes the place of F.
    HoldPort(usize),
    /// An expression E(q, t) in the host's graph keeps its rate (which is to be zero); λ ∂E/∂q is added to the residuals.
    Hold(Slot),
}
