//! The keys of the sections in which a host's equations are written.

use quell_document::{Key, KeySet, Shape};

/// `[states]`.
pub static STATES: KeySet = KeySet {
    title: "States",
    documentation: "One entry for each quantity of first order: the expression of its rate, or a table.",
    keys: &[],
    others: Some((
        "NAME",
        Shape::AnyOf(&[Shape::Expression, Shape::Table(&STATE)]),
        "A state, such as `\"(x - lag)/(0.1 s)\"`.",
    )),
};

/// One state.
pub static STATE: KeySet = KeySet {
    title: "State",
    documentation: "",
    keys: &[
        Key::required("rate", Shape::Expression, "Its rate of change in time."),
        Key::optional(
            "start",
            Shape::Amount,
            "Where a run in time begins; 0 if left out.",
        ),
        Key::optional(
            "unit",
            Shape::Text,
            "The unit in which it is measured, such as `\"m\"`; left out: what makes the units of its rate fit.",
        ),
    ],
    others: None,
};

/// `[definitions]`.
pub static DEFINITIONS: KeySet = KeySet {
    title: "Definitions",
    documentation: "Expressions of coordinates, their derivatives (`x'`, `x''`), states, inputs, parameters, time `t` and each other, in any order. `'` after a definition is its total derivative in time, `d(a, x)` its partial derivative, and `hold(a)` is constant for both.",
    keys: &[],
    others: Some(("NAME", Shape::Expression, "An expression.")),
};

/// `[functions]`.
pub static FUNCTIONS: KeySet = KeySet {
    title: "Functions",
    documentation: "As definitions, with arguments: `\"load(side)\" = \"W/2 + side*k*a/2*phi\"`.",
    keys: &[],
    others: Some((
        "\"NAME(ARGUMENT, …)\"",
        Shape::Expression,
        "An expression of the arguments and of whatever a definition may use.",
    )),
};

/// `[equations]`.
pub static EQUATIONS: KeySet = KeySet {
    title: "Equations",
    documentation: "One for each coordinate, under its name: the one in which its own acceleration stands (for a massless coordinate: itself or its rate). Accelerations may stand anywhere, several in one equation.",
    keys: &[],
    others: Some((
        "COORDINATE",
        Shape::Text,
        "Two sides with `=` between them, such as `\"m*x'' + c*x' + k*x = F\"`. A force without symbol that acts by virtual work is added to it, so the equation then is a balance of forces (of moments for an angle).",
    )),
};

/// `[lagrangian]`.
pub static LAGRANGIAN: KeySet = KeySet {
    title: "Lagrangian",
    documentation: "The equations of motion are d/dt(∂T/∂q') - ∂T/∂q + ∂V/∂q + ∂D/∂q' = Q.",
    keys: &[
        Key::required("kinetic", Shape::Expression, "T, the kinetic energy."),
        Key::optional(
            "potential",
            Shape::Expression,
            "V, the potential energy; 0 if left out.",
        ),
        Key::optional(
            "dissipation",
            Shape::Expression,
            "D, Rayleigh's dissipation function, half the power dissipated; 0 if left out.",
        ),
        Key::optional(
            "forces",
            Shape::MapOf(&Shape::Expression),
            "Q, generalised forces by coordinate, such as `{ x = \"F0*cos(Omega*t)\" }`.",
        ),
    ],
    others: None,
};

/// `[operating]`.
pub static OPERATING: KeySet = KeySet {
    title: "Operating range",
    documentation: "One entry for each parameter whose range matters.",
    keys: &[],
    others: Some(("PARAMETER", Shape::Table(&RANGE), "Its range.")),
};

/// One operating range.
pub static RANGE: KeySet = KeySet {
    title: "Range",
    documentation: "One of `from` and `above`, and `to`.",
    keys: &[
        Key::optional("from", Shape::Amount, "Where it begins."),
        Key::optional(
            "above",
            Shape::Amount,
            "Where it begins, this value itself left out.",
        ),
        Key::required("to", Shape::Amount, "Where it ends."),
    ],
    others: None,
};

/// `signal`.
pub static SIGNAL: KeySet = KeySet {
    title: "Signal",
    documentation: "One of these. Amounts may be expressions of parameters; they are in the unit of the input.",
    keys: &[
        Key::optional("harmonic", Shape::Table(&HARMONIC), "A sine."),
        Key::optional("pulse", Shape::Table(&PULSE), "A single pulse."),
        Key::optional(
            "random",
            Shape::Table(&RANDOM),
            "A stationary random signal, the same for the same seed.",
        ),
        Key::optional("sampled", Shape::Table(&SAMPLED), "Values from a file."),
    ],
    others: None,
};

/// `harmonic`.
pub static HARMONIC: KeySet = KeySet {
    title: "Harmonic signal",
    documentation: "amplitude · sin(2π frequency t + phase), or a sweep, whose frequency rises or falls with time and then stays.",
    keys: &[
        Key::required("amplitude", Shape::Amount, "The peak, not the rms value."),
        Key::required(
            "frequency",
            Shape::Amount,
            "With its unit, such as `\"3 Hz\"`; in a dimensionless host the angular frequency.",
        ),
        Key::optional(
            "phase",
            Shape::Amount,
            "In rad, or with its unit; 0 if left out.",
        ),
        Key::optional("sweep", Shape::Table(&SWEEP), "Where the frequency goes."),
    ],
    others: None,
};

/// `sweep` of a harmonic signal.
pub static SWEEP: KeySet = KeySet {
    title: "Sweep of a signal",
    documentation: "From `frequency` at t = 0.",
    keys: &[
        Key::required("to", Shape::Amount, "The last frequency."),
        Key::required("time", Shape::Amount, "When it is reached, s."),
        Key::optional(
            "scale",
            Shape::Choice(&["linear", "log"]),
            "Whether the frequency grows by the same number each second (the default), or by the same factor.",
        ),
    ],
    others: None,
};

/// `pulse`.
pub static PULSE: KeySet = KeySet {
    title: "Pulse",
    documentation: "Zero before and after.",
    keys: &[
        Key::optional(
            "shape",
            Shape::Choice(&["half-sine", "rectangular", "triangular"]),
            "`half-sine` if left out.",
        ),
        Key::required("amplitude", Shape::Amount, "The peak."),
        Key::required("duration", Shape::Amount, "How long it lasts, s."),
        Key::optional("at", Shape::Amount, "When it begins, s; 0 if left out."),
    ],
    others: None,
};

/// `random`.
pub static RANDOM: KeySet = KeySet {
    title: "Random signal",
    documentation: "A sum of sines with random phases, evenly spaced in frequency over the band. It repeats itself after 2·harmonics/(width of the band in Hz).",
    keys: &[
        Key::required(
            "band",
            Shape::List(&Shape::Amount),
            "The frequencies between which it lies, such as `[\"0.5 Hz\", \"20 Hz\"]`.",
        ),
        Key::optional(
            "spectrum",
            Shape::AnyOf(&[Shape::Amount, Shape::List(&Shape::List(&Shape::Amount))]),
            "One-sided spectral density such as `\"1e-4 m^2/Hz\"`, the same over the whole band; or pairs `[[\"1 Hz\", \"1e-4 m^2/Hz\"], …]` with straight lines between them on logarithmic axes. This or `rms`.",
        ),
        Key::optional(
            "rms",
            Shape::Amount,
            "Root mean square, all frequencies of the band taking the same part.",
        ),
        Key::optional(
            "seed",
            Shape::Integer,
            "Another seed is another sample of the same process; 1 if left out.",
        ),
        Key::optional(
            "harmonics",
            Shape::Integer,
            "Number of sines; 200 if left out.",
        ),
    ],
    others: None,
};

/// `sampled`.
pub static SAMPLED: KeySet = KeySet {
    title: "Sampled signal",
    documentation: "Before the first sample and after the last it has their values.",
    keys: &[
        Key::required(
            "file",
            Shape::Text,
            "A file of two columns, time in s and value, relative to this file: `.csv`, with or without a line of titles.",
        ),
        Key::optional(
            "unit",
            Shape::Text,
            "Unit of the values in the file, such as `\"mm\"`; SI if left out.",
        ),
        Key::optional(
            "interpolation",
            Shape::Choice(&["cubic", "linear"]),
            "Cubic spline (the default), or straight lines.",
        ),
    ],
    others: None,
};
