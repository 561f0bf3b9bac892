//! The linear host: matrices, inputs, ports and outputs.
//!
//! With coordinates q (n), inputs u and devices on ports p the equations are
//!
//! ```text
//! M q'' + C q' + (K + j K_loss) q = F0 u + F1 u' + F2 u'' - Σ_p h_p f_p
//! x_p = h_p·q + g_p·u                 across-variable (relative displacement) of port p
//! f_p = D_p(s) x_p                    force of the device on port p, D_p = s Y_p its dynamic stiffness
//! ```
//!
//! so that positive `f_p · x_p'` is power into the device. Everything is SI; rotations are in rad.

use faer::Mat;
use quell_expression::Dimension;

/// What a coordinate measures, which decides the units of everything attached to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CoordinateKind {
    /// A displacement, m.
    Translation,
    /// An angle, rad.
    Rotation,
}

/// One generalised coordinate of a host.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinate {
    /// The name in the host file.
    pub name: String,
    /// Translation (m) or rotation (rad).
    pub kind: CoordinateKind,
}

/// What an input prescribes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InputKind {
    /// A force (N) or a moment (N m).
    Force,
    /// A prescribed displacement, m or rad.
    Displacement,
    /// A prescribed velocity, m/s or rad/s.
    Velocity,
    /// A prescribed acceleration, m/s² or rad/s².
    Acceleration,
}

impl InputKind {
    /// Number of integrations between the input as given and the u of the equations:
    /// 0 for forces and displacements, 1 for velocities, 2 for accelerations.
    #[must_use]
    pub const fn integrations(self) -> usize {
        match self {
            Self::Force | Self::Displacement => 0,
            Self::Velocity => 1,
            Self::Acceleration => 2,
        }
    }
}

/// One excitation of a host.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// The name in the host file.
    pub name: String,
    /// Force, or prescribed displacement, velocity, acceleration.
    pub kind: InputKind,
    /// Translation or rotation.
    pub motion: CoordinateKind,
    /// SI dimension of the input as given.
    pub dimension: Dimension,
}

/// A pair of points between which a device can act.
#[derive(Debug, Clone, PartialEq)]
pub struct Port {
    /// The name in the host file.
    pub name: String,
    /// h: coefficients of the across-variable on the coordinates, length n.
    pub coordinates: Vec<f64>,
    /// g: coefficients of the across-variable on the inputs' u, length of inputs (zero for forces).
    pub inputs: Vec<f64>,
    /// Translation (force in N, m) or rotation (moment in N m, rad).
    pub kind: CoordinateKind,
    /// True for `at = "x"`: the device's far end is in the inertial frame, so it must end in a mass.
    pub hangs: bool,
    /// True where the far side is the inertial frame, so that a mass may end a device there.
    pub grounded: bool,
}

/// A signal of the assembled system that a [`LinearForm`] adds up.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Signal {
    /// Coordinate `index`, differentiated `order` times (0, 1, 2).
    Coordinate {
        /// Index into the host's coordinates.
        index: usize,
        /// Number of time derivatives.
        order: usize,
    },
    /// The u of input `index` (its displacement or force), differentiated `order` times.
    Input {
        /// Index into the host's inputs.
        index: usize,
        /// Number of time derivatives of u.
        order: usize,
    },
    /// The device force f of port `index`.
    PortForce {
        /// Index into the host's ports.
        index: usize,
    },
    /// Relative displacement (stroke) of a named part (element or component) of the device on port `port`, differentiated `order` times.
    PartStroke {
        /// Index into the host's ports.
        port: usize,
        /// Name of the element or component in the device's layout.
        part: String,
        /// Number of time derivatives.
        order: usize,
    },
    /// Force through a named part of the device on port `port`.
    PartForce {
        /// Index into the host's ports.
        port: usize,
        /// Name of the element or component in the device's layout.
        part: String,
    },
}

/// A linear combination of signals: Σ coefficient · signal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LinearForm {
    /// The terms, each signal at most once.
    pub terms: Vec<(Signal, f64)>,
}

/// A named output of a host.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// The name in the host file.
    pub name: String,
    /// What it is.
    pub form: LinearForm,
    /// SI dimension.
    pub dimension: Dimension,
}

/// A linear structure with the places where it is excited, watched and treated.
#[derive(Debug, Clone)]
pub struct LinearHost {
    /// The name by which messages call it (the file as the user typed it, or its title).
    pub name: String,
    /// The n coordinates.
    pub coordinates: Vec<Coordinate>,
    /// M (n × n), kg; symmetric and positive semi-definite.
    pub mass: Mat<f64>,
    /// C (n × n), N s/m; gyroscopic parts are allowed.
    pub damping: Mat<f64>,
    /// K (n × n), N/m; circulatory parts are allowed.
    pub stiffness: Mat<f64>,
    /// Imaginary part of the complex stiffness (loss factors), n × n, N/m: frequency responses only, ω > 0.
    pub loss: Option<Mat<f64>>,
    /// The inputs.
    pub inputs: Vec<Input>,
    /// F0, F1, F2 (each n × inputs): forces of u, u', u''.
    pub forcing: [Mat<f64>; 3],
    /// The ports.
    pub ports: Vec<Port>,
    /// The named outputs.
    pub outputs: Vec<Output>,
}
