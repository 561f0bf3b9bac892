//! The keys of a study file: one definition for the reader, the JSON Schema and the reference.

use quell_document::{Key, KeySet, Shape};
use quell_model::host::keys::SIGNAL;

use crate::study::Statistic;

/// How predicted points of branches are corrected.
pub(crate) const CORRECTORS: &[&str] = &["pseudo-arclength", "Moore-Penrose"];
const TEXTS: Shape = Shape::List(&Shape::Text);
const CRITERIA: Shape = Shape::AnyOf(&[Shape::Text, TEXTS]);
const AMOUNTS: Shape = Shape::MapOf(&Shape::Amount);
const COUNTS: Shape = Shape::MapOf(&Shape::Integer);
const BOUNDS: Shape = Shape::AnyOf(&[Shape::List(&Shape::Amount), Shape::Table(&BOUNDS_TABLE)]);
const SWEPT: Shape = Shape::MapOf(&Shape::AnyOf(&[
    Shape::Table(&SWEEP),
    Shape::List(&Shape::Amount),
]));
const DOMAINS: Shape = Shape::Choice(&["translational", "rotational", "electrical", "hydraulic"]);
static SIGNALS: Shape = Shape::Table(&SIGNAL);
const SCALES: Shape = Shape::Choice(&["linear", "log"]);

/// The study itself.
pub const STUDY: KeySet = KeySet {
    title: "Study",
    documentation: "A study file: which structure, what may be bolted on, what hurts, what is asked.",
    keys: &[
        Key::required("quell", Shape::Integer, "Version of the file format: 1."),
        Key::required("title", Shape::Text, "What the study is about, in words."),
        Key::required(
            "host",
            Shape::Text,
            "Path of the host file, relative to this file.",
        ),
        Key::optional(
            "parameters",
            AMOUNTS,
            "Values that replace parameters of the host: `{ me = \"70 kg\" }`.",
        ),
        Key::optional(
            "elements",
            Shape::MapOf(&Shape::Table(&ELEMENT)),
            "Element names whose first letter does not tell their kind.",
        ),
        Key::optional(
            "components",
            Shape::MapOf(&Shape::Table(&COMPONENT)),
            "Named sub-networks with design variables of their own.",
        ),
        Key::optional(
            "devices",
            Shape::MapOf(&Shape::Table(&DEVICE)),
            "What may be bolted on, and at which port.",
        ),
        Key::optional(
            "runs",
            Shape::MapOf(&Shape::Table(&RUN)),
            "Computations on the assembled system that criteria read.",
        ),
        Key::optional(
            "criteria",
            Shape::MapOf(&Shape::Table(&CRITERION)),
            "Numbers taken from runs.",
        ),
        Key::required(
            "tasks",
            Shape::List(&Shape::Table(&TASK)),
            "What is asked, in order. Tasks of kind `evaluate` and `design` need `devices`, `runs` and `criteria`; others need none of them.",
        ),
        Key::optional("report", Shape::Table(&REPORT), "What the report shows."),
    ],
    others: None,
};

/// `[elements.NAME]`.
pub const ELEMENT: KeySet = KeySet {
    title: "Declared element",
    documentation: "A name that stands for an element in layouts: a linear one by its `kind`, a nonlinear one by its `force`.",
    keys: &[
        Key::optional(
            "kind",
            Shape::Choice(&["spring", "damper", "inerter", "mass"]),
            "What it is (of the mechanical kind; in other domains its analogue).",
        ),
        Key::optional(
            "force",
            Shape::Expression,
            "Force of a nonlinear element: an expression of its relative displacement `x` and its rate `v`, positive where it resists stretching, of its `parameters` and the host's. Frequency responses and modes see its slopes at the static equilibrium.",
        ),
        Key::optional(
            "parameters",
            AMOUNTS,
            "Parameters of `force` with their values; a configuration gives others as `NAME.PARAMETER`, a task searches them within `bounds`. An expression may use the host's parameters and the element's own.",
        ),
        Key::optional(
            "stores",
            Shape::Boolean,
            "The energy that the nonlinear element takes can be had back: it counts as `potential`.",
        ),
        Key::optional(
            "dissipates",
            Shape::Boolean,
            "The energy that the nonlinear element takes is lost: it counts as `dissipated`.",
        ),
        Key::optional(
            "domain",
            DOMAINS,
            "Domain of the layouts that use it; translational unless given.",
        ),
    ],
    others: None,
};

/// `[components.NAME]`.
pub const COMPONENT: KeySet = KeySet {
    title: "Component",
    documentation: "A named sub-network whose element values are expressions of design variables. Instances in a layout are NAME1, NAME2 …, their variables NAME1.VARIABLE.",
    keys: &[
        Key::optional(
            "domain",
            DOMAINS,
            "Domain of its layout; translational unless given.",
        ),
        Key::required("layout", Shape::Text, "Its elements: `R + I`."),
        Key::required(
            "values",
            AMOUNTS,
            "Value of each element: an expression of the variables and the host's parameters.",
        ),
        Key::optional(
            "variables",
            Shape::MapOf(&BOUNDS),
            "Design variables (plain numbers or with units) with their bounds.",
        ),
    ],
    others: None,
};

/// Bounds written as a table.
pub const BOUNDS_TABLE: KeySet = KeySet {
    title: "Bounds",
    documentation: "The range of a design variable; `[lower, upper]` is the short form.",
    keys: &[
        Key::required("bounds", Shape::List(&Shape::Amount), "`[lower, upper]`."),
        Key::optional(
            "scale",
            SCALES,
            "Scale of the search; unless given, log where both bounds are positive and a decade or more apart.",
        ),
    ],
    others: None,
};

/// `[devices.NAME]`.
pub const DEVICE: KeySet = KeySet {
    title: "Device",
    documentation: "A place for a device. Without `layout` the whole device is what a task designs; with it, a slot in it.",
    keys: &[
        Key::required("port", Shape::Text, "A port of the host."),
        Key::optional(
            "domain",
            DOMAINS,
            "Domain of its layouts: the port's own unless given; hydraulic needs `piston`.",
        ),
        Key::optional(
            "piston",
            Shape::Amount,
            "Piston area between hydraulic layouts and the port.",
        ),
        Key::optional(
            "layout",
            Shape::Text,
            "A fixed layout around slots: `C1 | (C2 + network)`.",
        ),
        Key::optional(
            "slots",
            TEXTS,
            "Names of the slots in `layout`; `network` unless given.",
        ),
        Key::optional(
            "values",
            AMOUNTS,
            "Values of the elements in `layout`; an element that is not named here takes the host's parameter of its name.",
        ),
    ],
    others: None,
};

/// `[runs.NAME]`.
pub const RUN: KeySet = KeySet {
    title: "Run",
    documentation: "One computation: the response to a harmonic input over frequency, the free modes, or motion in time. Of equations the first two are about the static equilibrium near the host's `start` values.",
    keys: &[
        Key::required(
            "kind",
            Shape::Choice(&["frequency", "modes", "transient"]),
            "Which computation.",
        ),
        Key::optional("input", Shape::Text, "frequency: the input of the host."),
        Key::optional(
            "band",
            Shape::List(&Shape::Amount),
            "frequency: `[\"0 Hz\", \"30 Hz\"]`; left out, all frequencies (norms only).",
        ),
        Key::optional(
            "spectrum",
            Shape::Amount,
            "frequency: one-sided spectrum of the input per Hz, a value or an expression of `f` (and the host's parameters): `\"1e-4 m^2/Hz*(1 Hz/f)^2\"`.",
        ),
        Key::optional(
            "modes",
            Shape::Choice(&["all", "oscillatory"]),
            "modes: which of them count; all unless given. Rigid-body modes never count.",
        ),
        Key::optional(
            "duration",
            Shape::Amount,
            "transient: how long it lasts at most, each phase by itself.",
        ),
        Key::optional(
            "end",
            Shape::Table(&END),
            "transient: the event that ends it, in the last phase. A run that does not reach it gives no numbers.",
        ),
        Key::optional(
            "continue",
            Shape::Amount,
            "transient: how long it goes on beyond its end event, for `beyond(…)` in criteria.",
        ),
        Key::optional(
            "start",
            Shape::AnyOf(&[Shape::Choice(&["stated", "equilibrium"]), AMOUNTS]),
            "transient: where it starts: as the host says (unless given), in static equilibrium, or as the host says but for the coordinates, rates and states given: `{ x = \"1 mm\", \"x'\" = \"2 m/s\" }`.",
        ),
        Key::optional(
            "inputs",
            Shape::MapOf(&SIGNALS),
            "transient: what inputs of the host are in this run, in place of the `signal` that the host gives them: `{ F = { pulse = { amplitude = \"5 N\", duration = \"1 ms\" } } }`. An input that is not named here keeps the host's; one without any is zero.",
        ),
        Key::optional(
            "phases",
            Shape::List(&Shape::Table(&PHASE)),
            "transient: phases, one after the other; states carry over. One free phase unless given.",
        ),
        Key::optional(
            "tolerance",
            Shape::Number,
            "transient: relative tolerance of the integration; 1e-8 unless given. What is piecewise linear is propagated exactly.",
        ),
        Key::optional(
            "most_steps",
            Shape::Integer,
            "transient: most steps of the integration, 100000 unless given. A run that would need more gives no numbers: one device with a mode a million times as fast as the others must not hold up a search.",
        ),
        Key::optional(
            "method",
            Shape::Choice(&["automatic", "explicit", "stiff", "stiff oscillating"]),
            "transient: how it is integrated; automatic unless given.",
        ),
    ],
    others: None,
};

/// `end` of a run in time.
pub const END: KeySet = KeySet {
    title: "End event",
    documentation: "A signal going through zero.",
    keys: &[
        Key::required(
            "event",
            Shape::Expression,
            "The signal: any expression of the host's coordinates, definitions, forces, `t` and parts of devices.",
        ),
        Key::optional("rising", Shape::Boolean, "Only upwards."),
        Key::optional("falling", Shape::Boolean, "Only downwards."),
        Key::optional(
            "armed",
            Shape::Text,
            "It counts only after this comparison has once been true: `\"x' > 0\"`.",
        ),
    ],
    others: None,
};

/// A phase of a run in time.
pub const PHASE: KeySet = KeySet {
    title: "Phase",
    documentation: "A stretch of a run in time; `{}` is free motion until the end.",
    keys: &[
        Key::optional(
            "hold",
            Shape::Expression,
            "What does not move in it: a combination of coordinates. Where it is the across-variable of a port, the port's devices rest and `reaction(…)` is the whole force there; elsewhere the reaction acts by virtual work.",
        ),
        Key::optional(
            "until",
            Shape::Text,
            "The comparison that ends it: `\"reaction(x) > F0\"`.",
        ),
    ],
    others: None,
};

/// `[criteria.NAME]`.
pub const CRITERION: KeySet = KeySet {
    title: "Criterion",
    documentation: "One number taken from a run, or from other criteria. Over frequency: `max(abs(y))`, `abs(y, 12 Hz)`, `h2(y)`, `rms(y)`, `variance(y)`; of modes: `min(damping_ratio)`, `min(decay_rate)`, `min(frequency)` and their `max`. y is linear in coordinates, inputs and outputs (`xe - xs`, `xe''`, `force(PORT)`, `stroke(track1)`); where the host is written as equations or a device holds a nonlinear element, any expression, taken linear about the static equilibrium with inputs at rest. Of motion in time, s and b being any expressions of signals: `max(s)`, `min(s)` (of `beyond(s)`: after the end event), `peak(s, n)`, `trough(s, n)`, `largest(s, n)` (the n-th largest peak over the whole run), `span(s, LEVEL)` (from the first to the last time above it), `crossing(s, n)` (the time of the n-th rise through zero), `initial(s)`, `final(s)`, `at(s, TIME)`, `mean(s)`, `rms(s)`, `integral(s)` over time, `integral(s, b)` over b, `settling(s, BAND)`, `settling(s, TARGET, BAND)`, `decay_rate(s)` (of the peaks of s); `span` and `settling` may end with a factor, `span(s, LEVEL, 1.1)`: swings that do not reach so many times the level do not count; of a device or element `potential(NAME)`, `kinetic(NAME)`, `stored(NAME)`, `dissipated(NAME)`; `energy_error`.",
    keys: &[
        Key::optional(
            "kind",
            Shape::Choice(&["stable band"]),
            "`stable band`: the intervals of a parameter in which the equilibrium is stable for every value of an operating parameter. It has no `run`. Edges are located as extrema of bifurcation curves.",
        ),
        Key::optional(
            "of",
            Shape::Text,
            "stable band: the parameter whose intervals are sought: a value in the layouts, or a parameter of the host; it is no design variable. It may be the operating parameter itself, with `over` left out.",
        ),
        Key::optional(
            "range",
            Shape::List(&Shape::Amount),
            "stable band: `[lower, upper]` of `of`; of a parameter of the host that of `[operating]` unless given. Ends of the range are limits too.",
        ),
        Key::optional(
            "start",
            Shape::MapOf(&Shape::Amount),
            "stable band: which equilibrium: the one that Newton's method finds from these values of coordinates and states at the lower end of `over`; the host's `start` unless given. It is followed over the range; where it ends, `of` is outside of the band.",
        ),
        Key::optional(
            "run",
            Shape::Text,
            "Name of the run. Left out, `value` is an expression of other criteria: their weighted sum, the worse of two runs.",
        ),
        Key::required(
            "value",
            Shape::Expression,
            "The number; of a stable band `width`, `lower` or `upper`, of the widest where there are several. Without `run`: `\"max(slip/1.25e-2, force/1.4e-2)\"`, of names of criteria and the host's parameters.",
        ),
        Key::optional(
            "unit",
            Shape::Text,
            "Unit in which people read it; results.json is SI in any case.",
        ),
        Key::optional(
            "tolerance",
            Shape::Number,
            "Relative tolerance of the value; 1e-4 unless given.",
        ),
        Key::optional(
            "over",
            Shape::AnyOf(&[Shape::Text, SWEPT]),
            "stable band: the operating parameter for every value of which the equilibrium must be stable: its name, with the range of `[operating]` of the host, or `{ V = [\"5 m/s\", \"80 m/s\"] }`. Else: values of host parameters at which the criterion is taken: `{ ms = [\"200 kg\", \"350 kg\"] }`; several give every combination. A device is the same at all of them. `take` says which number of these counts.",
        ),
        Key::optional(
            "tolerances",
            Shape::AnyOf(&[Shape::Amount, AMOUNTS]),
            "How far values of devices may be from what they are meant to be, relative and both ways: `\"10 %\"` for all, or by name as in `bounds`: `{ k = \"5 %\", c = \"20 %\" }`. The criterion is taken at the values as meant and at every corner of their tolerances (2^n for n values; 10 at most); a report also looks at 32 points between.",
        ),
        Key::optional(
            "take",
            Shape::Choice(&Statistic::NAMES),
            "With `over` or `tolerances`: the `largest` of the numbers (unless given), the `smallest`, their `mean`, or their `spread`, largest less smallest.",
        ),
    ],
    others: None,
};

/// `[[tasks]]`.
pub const TASK: KeySet = KeySet {
    title: "Task",
    documentation: "What is asked: `evaluate` given configurations; `design`: the best values of candidate layouts, ranked; `branch`: equilibria or cycles followed in one parameter, with their special points; `curve`: special points followed in two; `diagram`: every branch in one parameter that can be found; `region`: a rectangle of two parameters divided by what is stable in its parts; `simulate`: motions let go from several starts, as a check on a diagram or region.",
    keys: &[
        Key::required("name", Shape::Text, "Unique name of the task."),
        Key::required(
            "kind",
            Shape::Choice(&[
                "evaluate", "design", "branch", "curve", "diagram", "region", "simulate",
            ]),
            "What is asked.",
        ),
        Key::optional(
            "configuration",
            Shape::AnyOf(&[Shape::MapOf(&Shape::Anything), Shape::Text]),
            "branch, curve, diagram, region, simulate: a layout for each slot and the values, `{ damper = \"k1 | c1\", k1 = \"…\", c1 = \"…\" }`, or the name of a configuration of an `evaluate` task above. Unless given, that of the task at which it starts, or no device.",
        ),
        Key::optional(
            "parameter",
            Shape::Text,
            "branch, diagram, simulate: what is followed, or has the values `at`: a parameter of the host, or a value of the configuration (of an element `c1`, of a component `track1.dL`, of a nonlinear element `gas.n`).",
        ),
        Key::optional(
            "parameters",
            TEXTS,
            "curve, region, simulate: the two parameters; of a region the first one runs along the abscissa.",
        ),
        Key::optional(
            "ranges",
            Shape::MapOf(&Shape::List(&Shape::Amount)),
            "branch, curve, diagram, region, simulate: `[lower, upper]` by parameter; unless given that of the task at which it starts, or of `[operating]` of the host.",
        ),
        Key::optional(
            "start",
            Shape::AnyOf(&[Shape::Text, Shape::Table(&START), TEXTS]),
            "branch: `\"equilibrium\"` near the host's `start` values (unless given); `\"TASK:LABEL\"`, a special point that a task above finds (`\"TASK:C1:NS1\"` where several branches have the label): cycles at a Hopf point, doubled cycles at a period doubling, the branch that crosses at a branch point, else the solution there; or `{ run = \"NAME\" }`, the cycle on which a run in time ends. curve: `\"TASK:LABEL\"`, an LP, H, LPC, PD or NS of a branch, or an HH (its torus curves) or GH (its folds of cycles) of a curve; or a list of such points, `[\"TASK:H1\", \"TASK:H2\"]`, of one configuration, whose curves are then drawn in one plane.",
        ),
        Key::optional(
            "at",
            Shape::List(&Shape::AnyOf(&[Shape::Amount, Shape::List(&Shape::Amount)])),
            "branch, curve, diagram: values of the first parameter at which solutions are wanted exactly. simulate: values at which motions are let go: of one parameter, or pairs of two, `[[\"29 m/s\", \"3.6e4 N*m*s/rad\"]]`; unless given, those of the configuration.",
        ),
        Key::optional(
            "measures",
            Shape::MapOf(&Shape::AnyOf(&[Shape::Expression, Shape::Table(&MEASURE)])),
            "branch, curve, diagram, region, simulate: numbers taken from every solution, by name: arithmetic over `max(s)`, `min(s)`, `mean(s)`, `rms(s)`, `amplitude(s)` (half of the swing) of any signal s: over the period of a cycle, at an equilibrium its value; of a motion over stretches of it.",
        ),
        Key::optional(
            "oscillations",
            Shape::MapOf(&Shape::Expression),
            "branch, curve, diagram, region, simulate: names of oscillations, each with a number as in `measures`; all of one dimension. A cycle has the name of the largest: `{ torsion = \"max(abs(p))\", bending = \"max(abs(d))\" }`.",
        ),
        Key::optional(
            "of",
            Shape::Text,
            "simulate: a `branch`, `diagram` or `region` above. Its configuration, parameters, measures and names of oscillations are those of the motions, and where they end is compared with what it says is stable.",
        ),
        Key::optional(
            "duration",
            Shape::Amount,
            "simulate: for how long a motion is watched at most; unless given ten times as long as the slowest oscillating mode at rest takes to grow or decay by e, but 200 to 4000 turns of the least damped one (or periods of what forces the host). A motion that has settled is watched no longer.",
        ),
        Key::optional(
            "cycles",
            Shape::Boolean,
            "branch: follow the cycles born at Hopf points too; false unless given.",
        ),
        Key::optional(
            "depth",
            Shape::Integer,
            "diagram: how often a branch may be followed from a point of another; 2 unless given.",
        ),
        Key::optional(
            "search",
            Shape::MapOf(&Shape::List(&Shape::Amount)),
            "diagram: where equilibria are sought, `[lower, upper]` by coordinate, rate or state of the host; unless given within 1 (SI) of the one near the host's `start` values, and at its rates.",
        ),
        Key::optional(
            "corrector",
            Shape::Choice(CORRECTORS),
            "branch, curve, diagram: how predicted points are brought onto the branch: across the tangent before (`\"pseudo-arclength\"`, unless given), or the shortest way (`\"Moore-Penrose\"`), which takes sharper bends and more time. Special points are the same.",
        ),
        Key::optional(
            "points",
            Shape::Integer,
            "branch, curve, diagram, region: most points in each direction; 400 unless given.",
        ),
        Key::optional(
            "mesh_tolerance",
            Shape::Number,
            "branch, curve, diagram, region: estimated error that the mesh of a cycle holds, relative to the cycle's size; 1e-8 unless given.",
        ),
        Key::optional(
            "longest_period",
            Shape::Amount,
            "branch, curve, diagram, region: a branch of cycles ends beyond this period.",
        ),
        Key::optional(
            "period",
            Shape::Amount,
            "branch, curve, simulate: the period of what forces the host, an expression of its parameters, `\"2*pi/Omega\"`; needed where `t` is in the equations.",
        ),
        Key::optional(
            "configurations",
            Shape::MapOf(&Shape::MapOf(&Shape::Anything)),
            "evaluate: by name, a layout for each slot (`network = \"track1\"`) and a value for each variable or element; a device that is not named is left off. `\"runs.RUN.KEY\"` gives a key of a run another value in this configuration.",
        ),
        Key::optional(
            "minimise",
            CRITERIA,
            "design: the criterion to make small. Of several, or with `maximise` beside it, the front is sought: the designs of which none can be made better in one objective without becoming worse in another.",
        ),
        Key::optional(
            "maximise",
            CRITERIA,
            "design: the criterion to make large, or several.",
        ),
        Key::optional(
            "subject_to",
            TEXTS,
            "design: constraints `CRITERION <= VALUE` or `CRITERION >= VALUE`.",
        ),
        Key::optional(
            "references",
            TEXTS,
            "design: names of configurations, or layouts to be designed under the same bounds, against which improvements are given.",
        ),
        Key::optional(
            "candidates",
            Shape::MapOf(&Shape::AnyOf(&[
                TEXTS,
                Shape::Table(&BUDGET),
                Shape::Table(&IMMITTANCE),
            ])),
            "design: for each slot (or device without `layout`) a list of layouts (`\"k1 | c1\"`, or by name `\"catalogue: TVMD\"`), a budget of which all layouts are tried, or the order of a function `{ immittance = \"biquadratic\" }`.",
        ),
        Key::optional("fixed", AMOUNTS, "design: values that are given."),
        Key::optional(
            "bounds",
            Shape::MapOf(&BOUNDS),
            "design: range of each value that is searched, by the element's name (`k1`), by its kind (`k`), or by variable (`track.dL`, `track1.dL`). A missing bound is an error.",
        ),
        Key::optional(
            "starts",
            Shape::AnyOf(&[Shape::Integer, Shape::List(&AMOUNTS)]),
            "design: independent starts for each layout; chosen from the number of variables unless given. simulate: where motions begin: so many pushes from the equilibrium along its least damped modes, from small ones to such that the equations are far from linear (4 unless given); or a list of values, `[{ p = \"3 deg\" }, { \"d'\" = \"0.1 rad/s\" }]`, in which what is not named is at rest.",
        ),
        Key::optional(
            "agree",
            Shape::Integer,
            "design: starts are added, `starts` at a time, until so many of them agree on the best feasible objective within 1e-4, or there are `most_starts`. The result says which.",
        ),
        Key::optional(
            "most_starts",
            Shape::Integer,
            "design: with `agree`, the most starts for each layout; ten times `starts` unless given.",
        ),
        Key::optional(
            "front_points",
            Shape::Integer,
            "design, with several objectives: points of the front for each layout, ends included; 11 unless given. With three objectives or more, points along each axis of a grid.",
        ),
        Key::optional(
            "feasibility",
            Shape::Number,
            "design: relative tolerance within which a constraint holds; 1e-6 unless given.",
        ),
        Key::optional(
            "simplify",
            Shape::Boolean,
            "design: make the best design smaller: without each of its elements in turn (taken out, or made rigid), searched again, down to one element. Elements under `fixed` stay.",
        ),
        Key::optional(
            "sweep",
            SWEPT,
            "Repeat the task at values of host parameters, or of the bound of one of the task's constraints, called by its criterion: `{ F_max = { from = \"5 kN\", to = \"8 kN\", points = 7 } }`; several give every combination.",
        ),
    ],
    others: None,
};

/// Where a branch starts, as a table.
pub const START: KeySet = KeySet {
    title: "Start of a branch",
    documentation: "The cycle on which a run in time ends.",
    keys: &[Key::required(
        "run",
        Shape::Text,
        "Name of a run of kind `transient` without phases and end event.",
    )],
    others: None,
};

/// A measure, as a table.
pub const MEASURE: KeySet = KeySet {
    title: "Measure",
    documentation: "A number taken from every solution of a branch; the value alone is the short form.",
    keys: &[
        Key::required("value", Shape::Expression, "The number: `max(abs(x))`."),
        Key::optional(
            "unit",
            Shape::Text,
            "Unit in which people read it; results.json is SI in any case.",
        ),
    ],
    others: None,
};

/// A budget of elements or components.
pub const BUDGET: KeySet = KeySet {
    title: "Budget",
    documentation: "All series-parallel layouts with these numbers of elements, or of branches over components, each once.",
    keys: &[
        Key::optional("springs", Shape::Integer, "Number of springs."),
        Key::optional("dampers", Shape::Integer, "Number of dampers."),
        Key::optional("inerters", Shape::Integer, "Number of inerters."),
        Key::optional(
            "masses",
            Shape::Integer,
            "Number of masses, at the far end.",
        ),
        Key::optional("components", TEXTS, "Kinds of branch: components."),
        Key::optional(
            "branches",
            Shape::AnyOf(&[Shape::Integer, Shape::List(&Shape::Integer)]),
            "With `components`: number of branches, or a list of numbers.",
        ),
        Key::optional(
            "at_least",
            COUNTS,
            "With `components`: at least so many of a kind.",
        ),
        Key::optional(
            "at_most",
            COUNTS,
            "With `components`: at most so many of a kind.",
        ),
        Key::optional(
            "reducible",
            Shape::Boolean,
            "Also layouts with two like single elements side by side in one group; false unless given.",
        ),
    ],
    others: None,
};

/// A function of given order.
pub const IMMITTANCE: KeySet = KeySet {
    title: "Immittance",
    documentation: "The device as a function Y(s), force over velocity, of given order: (b s² + (c + c0) s + k)/(tau s² + s + rho) with c0 = (√(b rho) - √(k tau))², all coefficients at least zero, reaches every positive-real biquadratic; bilinear is (c s + k)/(s + rho) and b s + c. A function with a pole at infinity (tau = 0) is a candidate of its own. `bounds` gives ranges of `b`, `c`, `k`, `tau` (a time) and `rho` (a rate). A bicubic is given by its poles, -`rho` and those of frequency `omega` and damping ratio `zeta`, by the zeros of its real part, `rho0`, `omega0` and `zeta0` likewise, and by `c`, its value at infinity; with a pole there, `b` s besides, it has neither `rho` nor `rho0`. What is found is synthesised.",
    keys: &[Key::required(
        "immittance",
        Shape::Choice(&crate::immittance::Form::ORDERS),
        "The order.",
    )],
    others: None,
};

/// A range of a swept parameter.
pub const SWEEP: KeySet = KeySet {
    title: "Sweep",
    documentation: "Values of a swept parameter: a range, or `values`.",
    keys: &[
        Key::optional("from", Shape::Amount, "First value."),
        Key::optional("to", Shape::Amount, "Last value."),
        Key::optional("points", Shape::Integer, "Number of values, at least 2."),
        Key::optional("scale", SCALES, "Spacing; linear unless given."),
        Key::optional(
            "values",
            Shape::List(&Shape::Amount),
            "The values one by one, instead of a range.",
        ),
    ],
    others: None,
};

/// `[report]`.
pub const REPORT: KeySet = KeySet {
    title: "Report",
    documentation: "What the report shows beyond its defaults.",
    keys: &[
        Key::optional(
            "shortlist",
            Shape::Integer,
            "How many designs are printed and drawn large; 5 unless given.",
        ),
        Key::optional("note", Shape::Text, "Words above the results."),
    ],
    others: None,
};
