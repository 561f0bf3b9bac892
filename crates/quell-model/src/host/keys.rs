//! The keys of a host file: one definition for reader, schema and reference.

use quell_document::{Key, KeySet, Shape};

pub use crate::equations::keys::{
    DEFINITIONS, EQUATIONS, FUNCTIONS, HARMONIC, LAGRANGIAN, OPERATING, PULSE, RANDOM, RANGE,
    SAMPLED, SIGNAL, STATE, STATES, SWEEP,
};

const TEXTS: Shape = Shape::List(&Shape::Text);
/// `["xe", "xs", "kr"]`: end points and value in one list.
const SHORT: Shape = Shape::List(&Shape::Amount);
const MATRIX: Shape = Shape::AnyOf(&[Shape::Text, Shape::List(&Shape::List(&Shape::Amount))]);

/// A host file.
pub static HOST: KeySet = KeySet {
    title: "Host file",
    documentation: "A structure: coordinates, what shakes it, what it is made of or obeys, where devices can act and what is watched. Either `[linear]` says what it is made of, or its equations are written out: `[equations]` or `[lagrangian]` for the coordinates, `[states]` for what is of first order.",
    keys: &[
        Key::required("quell", Shape::Integer, "Version of the format: 1."),
        Key::optional("title", Shape::Text, "What the host is, for reports."),
        Key::optional(
            "dimensionless",
            Shape::Boolean,
            "`true`: every number of a host written as equations is plain, and no units are checked; `false` if left out.",
        ),
        Key::optional("parameters", Shape::Table(&PARAMETERS), "Named quantities."),
        Key::optional(
            "coordinates",
            Shape::Table(&COORDINATES),
            "The coordinates, in the order of the matrices' rows. Needed, unless there are `[states]` alone.",
        ),
        Key::optional("inputs", Shape::Table(&INPUTS), "What shakes the host."),
        Key::optional(
            "linear",
            Shape::Table(&LINEAR),
            "What a linear host is made of.",
        ),
        Key::optional(
            "states",
            Shape::Table(&STATES),
            "What is of first order, beside the coordinates: each with its rate.",
        ),
        Key::optional(
            "definitions",
            Shape::Table(&DEFINITIONS),
            "Named parts of the equations.",
        ),
        Key::optional(
            "functions",
            Shape::Table(&FUNCTIONS),
            "Parts of the equations with arguments.",
        ),
        Key::optional(
            "equations",
            Shape::Table(&EQUATIONS),
            "The equations of motion, one for each coordinate.",
        ),
        Key::optional(
            "lagrangian",
            Shape::Table(&LAGRANGIAN),
            "Energies from which the equations of motion follow, instead of `[equations]`.",
        ),
        Key::optional(
            "ports",
            Shape::MapOf(&Shape::Table(&PORT)),
            "Where devices can act, `[ports.NAME]`.",
        ),
        Key::optional(
            "outputs",
            Shape::Table(&OUTPUTS),
            "Named combinations of signals.",
        ),
        Key::optional(
            "operating",
            Shape::Table(&OPERATING),
            "Ranges of parameters in which the host works.",
        ),
    ],
    others: None,
};

/// `[parameters]`.
pub static PARAMETERS: KeySet = KeySet {
    title: "Parameters",
    documentation: "Quantities, and expressions of other parameters in any order.",
    keys: &[],
    others: Some((
        "NAME",
        Shape::Amount,
        "A quantity with its unit such as `\"60 kg\"`, a plain number, or an expression such as `\"sqrt(k/m)\"`.",
    )),
};

/// `[coordinates]`.
pub static COORDINATES: KeySet = KeySet {
    title: "Coordinates",
    documentation: "One entry for each coordinate; `{}` is a displacement without mass.",
    keys: &[],
    others: Some(("NAME", Shape::Table(&COORDINATE), "A coordinate.")),
};

/// One coordinate.
pub static COORDINATE: KeySet = KeySet {
    title: "Coordinate",
    documentation: "",
    keys: &[
        Key::optional(
            "kind",
            Shape::Choice(&["translation", "rotation", "number"]),
            "Displacement (m, the default) or angle (rad); in a host written as equations also a plain number.",
        ),
        Key::optional(
            "mass",
            Shape::Amount,
            "Of a linear host: mass on a translation, kg; left out: none.",
        ),
        Key::optional(
            "inertia",
            Shape::Amount,
            "Of a linear host: moment of inertia on a rotation, kg m²; left out: none.",
        ),
        Key::optional(
            "start",
            Shape::Amount,
            "Where a run in time begins; 0 if left out.",
        ),
        Key::optional(
            "rate",
            Shape::Amount,
            "The rate at which a run in time begins; 0 if left out.",
        ),
        Key::optional(
            "massless",
            Shape::Boolean,
            "Of a host written as equations: `true` where the coordinate's own acceleration is in no equation.",
        ),
    ],
    others: None,
};

/// `[inputs]`.
pub static INPUTS: KeySet = KeySet {
    title: "Inputs",
    documentation: "One entry for each excitation.",
    keys: &[],
    others: Some(("NAME", Shape::Table(&INPUT), "An input.")),
};

/// One input.
pub static INPUT: KeySet = KeySet {
    title: "Input",
    documentation: "",
    keys: &[
        Key::required(
            "kind",
            Shape::Choice(&[
                "displacement",
                "velocity",
                "acceleration",
                "force",
                "number",
            ]),
            "A prescribed motion, or a force; in a host written as equations also a plain number. An input's name stands for it as it is given.",
        ),
        Key::optional(
            "motion",
            Shape::Choice(&["translation", "rotation"]),
            "Whether a prescribed motion is a displacement (the default) or an angle; of a force, whether it is a force or a moment.",
        ),
        Key::optional(
            "on",
            Shape::AnyOf(&[Shape::Expression, Shape::MapOf(&Shape::Amount)]),
            "Of a linear host: what a force acts on: a coordinate, an expression of coordinates such as `\"x + 0.4 m*theta\"`, or coefficients `{ x1 = 1, x2 = -0.5 }`. Equations say it themselves.",
        ),
        Key::optional(
            "unit",
            Shape::Text,
            "The unit in which a `number` is given, where it has one.",
        ),
        Key::optional(
            "signal",
            Shape::Table(&SIGNAL),
            "What it is in a run in time; left out: zero, unless the run says otherwise.",
        ),
    ],
    others: None,
};

/// `[linear]`.
pub static LINEAR: KeySet = KeySet {
    title: "Linear structure",
    documentation: "Elements and matrices add up. An end point is a coordinate, an input that is a motion (its displacement is meant), `ground`, or an expression of these such as `x + 0.4 m*theta`.",
    keys: &[
        Key::optional(
            "springs",
            Shape::List(&Shape::AnyOf(&[SHORT, Shape::Table(&SPRING)])),
            "Springs: `[\"x1\", \"x2\", \"k\"]`, or tables. N/m; between angles N m/rad.",
        ),
        Key::optional(
            "dampers",
            Shape::List(&Shape::AnyOf(&[SHORT, Shape::Table(&CONNECTION)])),
            "Dampers, N s/m; between angles N m s/rad.",
        ),
        Key::optional(
            "inerters",
            Shape::List(&Shape::AnyOf(&[SHORT, Shape::Table(&CONNECTION)])),
            "Inerters, kg; between angles kg m².",
        ),
        Key::optional(
            "masses",
            Shape::List(&Shape::AnyOf(&[SHORT, Shape::Table(&POINT_MASS)])),
            "Masses on points beside those of the coordinates: `[\"x + 0.4 m*theta\", \"m\"]`, or tables. kg; on angles kg m².",
        ),
        Key::optional(
            "matrices",
            Shape::Table(&MATRICES),
            "Mass, damping and stiffness matrices.",
        ),
        Key::optional(
            "base",
            Shape::Table(&BASE),
            "The coordinates are relative to a moving base: masses feel -M ι u''. `ground` then is the base.",
        ),
        Key::optional(
            "supports",
            TEXTS,
            "Coordinates whose motion is prescribed: each becomes an input of its name, a displacement unless `[inputs]` says otherwise.",
        ),
        Key::optional(
            "damping",
            Shape::Table(&DAMPING),
            "Damping of the host as a whole.",
        ),
    ],
    others: None,
};

/// A spring as a table.
pub static SPRING: KeySet = KeySet {
    title: "Spring",
    documentation: "",
    keys: &[
        Key::required("between", TEXTS, "The two end points."),
        Key::required("value", Shape::Amount, "Stiffness."),
        Key::optional(
            "name",
            Shape::Text,
            "By which outputs ask for `force(name)` and `stroke(name)`.",
        ),
        Key::optional(
            "loss",
            Shape::Amount,
            "Loss factor η: the stiffness is k (1 + jη), in frequency responses only.",
        ),
    ],
    others: None,
};

/// A damper or an inerter as a table.
pub static CONNECTION: KeySet = KeySet {
    title: "Damper or inerter",
    documentation: "",
    keys: &[
        Key::required("between", TEXTS, "The two end points."),
        Key::required("value", Shape::Amount, "Damping or inertance."),
        Key::optional(
            "name",
            Shape::Text,
            "By which outputs ask for `force(name)` and `stroke(name)`.",
        ),
    ],
    others: None,
};

/// A mass on a point as a table.
pub static POINT_MASS: KeySet = KeySet {
    title: "Mass",
    documentation: "",
    keys: &[
        Key::required("at", Shape::Expression, "The point."),
        Key::required("value", Shape::Amount, "Mass."),
        Key::optional(
            "name",
            Shape::Text,
            "By which outputs ask for `force(name)` and `stroke(name)`.",
        ),
    ],
    others: None,
};

/// `matrices`.
pub static MATRICES: KeySet = KeySet {
    title: "Matrices",
    documentation: "Each is a file (`.mtx`, `.npy`, `.npz:NAME`, `.csv`, in SI, relative to this file) or a list of rows.",
    keys: &[
        Key::optional(
            "M",
            MATRIX,
            "Mass matrix: symmetric, without negative eigenvalues.",
        ),
        Key::optional("C", MATRIX, "Damping matrix; gyroscopic parts are allowed."),
        Key::optional(
            "K",
            MATRIX,
            "Stiffness matrix; circulatory parts are allowed.",
        ),
    ],
    others: None,
};

/// `base`.
pub static BASE: KeySet = KeySet {
    title: "Moving base",
    documentation: "",
    keys: &[
        Key::required(
            "influence",
            Shape::List(&Shape::Amount),
            "ι: motion of each coordinate with the base, for a unit of the input.",
        ),
        Key::required("input", Shape::Text, "The input that moves the base."),
    ],
    others: None,
};

/// `damping`.
pub static DAMPING: KeySet = KeySet {
    title: "Damping",
    documentation: "One of these; it adds to dampers and to C, and acts on the motion relative to what prescribed motions impose slowly.",
    keys: &[
        Key::optional(
            "modal",
            Shape::AnyOf(&[Shape::Amount, Shape::List(&Shape::Amount)]),
            "Damping ratio of all vibrating modes of M and K, or one for each, lowest frequency first. Rigid-body modes stay undamped.",
        ),
        Key::optional("rayleigh", Shape::Table(&RAYLEIGH), "C = α M + β K."),
        Key::optional(
            "loss",
            Shape::Amount,
            "Loss factor η of all stiffness that states none of its own: K (1 + jη), in frequency responses only.",
        ),
    ],
    others: None,
};

/// `rayleigh`.
pub static RAYLEIGH: KeySet = KeySet {
    title: "Rayleigh damping",
    documentation: "",
    keys: &[
        Key::optional(
            "alpha",
            Shape::Amount,
            "α, 1/s, such as `\"0.3 s^-1\"` or a plain number; left out: 0.",
        ),
        Key::optional("beta", Shape::Amount, "β, s; left out: 0."),
    ],
    others: None,
};

/// `[ports.NAME]`.
pub static PORT: KeySet = KeySet {
    title: "Port",
    documentation: "One of `between`, `across` and `at`.",
    keys: &[
        Key::optional(
            "between",
            TEXTS,
            "Two end points [a, b]: the device is stretched by a - b.",
        ),
        Key::optional(
            "across",
            Shape::Expression,
            "The relative displacement itself, such as `\"x1 - 0.4 m*theta - xs\"`.",
        ),
        Key::optional(
            "at",
            Shape::Expression,
            "The one point on which a device hangs that ends in a mass.",
        ),
        Key::optional(
            "force",
            Shape::Text,
            "In a host written as equations: the symbol by which they name the force of the device, positive where it resists stretching. Left out, the force acts by virtual work: its work on the relative displacement goes to the coordinates.",
        ),
    ],
    others: None,
};

/// `[outputs]`.
pub static OUTPUTS: KeySet = KeySet {
    title: "Outputs",
    documentation: "Of a linear host sums of signals, each times a constant; otherwise any expression.",
    keys: &[],
    others: Some((
        "NAME",
        Shape::Expression,
        "For example `\"xe - xs\"`, `\"xe''\"`, `\"force(port)\"` or `\"stroke(port)\"`.",
    )),
};
