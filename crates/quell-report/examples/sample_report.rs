//! Writes a report with invented data, to look at: `cargo run -p quell-report --example sample_report -- FILE.html`.

use quell_network::{Domain, Kinds, Layout};
use quell_report::layout::Annotations;
use quell_report::page::{
    BoundRow, Bounds, Configuration, CriterionColumn, CriterionRow, CriterionValue, Design,
    DesignValue, Device, Fact, Page, Parameter, Problem, Quantity, ReferenceRow, Side, SweepPoint,
    TaskKind, TaskSection,
};
use quell_report::plot::{Axis, Plot, Role, Series};
use quell_report::schematic::Terminal;

type Failure = Box<dyn std::error::Error>;

const DIMENSIONLESS: Bounds = Bounds {
    lower: 0.5,
    upper: 1.5,
    logarithmic: false,
};
const WIDE: Bounds = Bounds {
    lower: 1e-3,
    upper: 1e3,
    logarithmic: true,
};

/// A cheap source of invented numbers in (0, 1).
struct Invented(u64);

impl Invented {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

fn kinds() -> Result<Kinds, Failure> {
    let mut kinds = Kinds::new(Domain::Hydraulic);
    kinds.declare_component("tube")?;
    kinds.declare_component("throttle")?;
    Ok(kinds)
}

fn hydraulic(text: &str, invented: &mut Invented) -> Result<Device, Failure> {
    let layout = Layout::parse(text, &kinds()?)?;
    let mut values = Vec::new();
    for branch in layout.branches() {
        let variables: &[(&str, Bounds)] = if branch.name.starts_with("tube") {
            &[("dL", DIMENSIONLESS), ("dA", DIMENSIONLESS)]
        } else {
            &[("dO", WIDE)]
        };
        for (variable, bounds) in variables {
            let share = invented.next() * 1.3;
            let (value, active) = if share > 1.0 {
                (bounds.upper, Some(Side::Upper))
            } else if bounds.logarithmic {
                (
                    (share * bounds.upper.ln() + (1.0 - share) * bounds.lower.ln()).exp(),
                    None,
                )
            } else {
                (bounds.lower + share * (bounds.upper - bounds.lower), None)
            };
            values.push(DesignValue {
                name: format!("{}.{variable}", branch.name),
                value: Quantity::new(value, ""),
                bounds: Some(*bounds),
                active,
            });
        }
    }
    let own = Kinds::new(Domain::Hydraulic);
    Ok(device(
        "passage",
        &layout,
        values,
        vec![
            ("tube".into(), Layout::parse("R + I", &own)?),
            ("throttle".into(), Layout::parse("R", &own)?),
        ],
    ))
}

fn device(
    name: &str,
    layout: &Layout,
    values: Vec<DesignValue>,
    components: Vec<(String, Layout)>,
) -> Device {
    let known = Annotations {
        components,
        ..Annotations::default()
    };
    Device::drawn(
        name,
        layout,
        values,
        &known,
        Terminal::Point("upper".into()),
        Terminal::Point("lower".into()),
    )
}

fn mechanical(
    text: &str,
    values: &[(&str, f64, &str)],
    head: &str,
    tail: Terminal,
) -> Result<Device, Failure> {
    let layout = Layout::parse(text, &Kinds::new(Domain::Translational))?;
    let values = values
        .iter()
        .map(|(name, value, unit)| DesignValue {
            name: (*name).into(),
            value: Quantity::new(*value, *unit),
            bounds: Some(Bounds {
                lower: 1e-2 * value,
                upper: 50.0 * value,
                logarithmic: true,
            }),
            active: None,
        })
        .collect();
    let mut device = device("absorber", &layout, values, Vec::new());
    device.schematic.head = Terminal::Point(head.into());
    device.schematic.tail = tail;
    Ok(device)
}

/// An invented magnitude with two resonances.
fn curve(name: &str, role: Role, peaks: [(f64, f64, f64); 2]) -> Series {
    let points: Vec<(f64, f64)> = (1..=1500)
        .map(|step| {
            let f = 30.0 * f64::from(step) / 1500.0;
            let sum: f64 = peaks
                .iter()
                .map(|(at, height, width)| height / (1.0 + ((f - at) / width).powi(2)))
                .sum();
            (
                f,
                sum + 0.9 * (f / 14.0).powi(2).min(1.0) * (1.0 - (-f / 6.0).exp()),
            )
        })
        .collect();
    let peak = points
        .iter()
        .copied()
        .max_by(|left, right| left.1.total_cmp(&right.1));
    Series {
        name: name.into(),
        role,
        points,
        peak,
        markers: false,
        ..Series::default()
    }
}

/// Frequency, height and width of two peaks.
type Peaks = [(f64, f64, f64); 2];

fn response(designs: &[(&str, Peaks)]) -> Plot {
    let mut series = vec![
        curve(
            "default",
            Role::Baseline,
            [(8.06, 1.4, 1.3), (18.71, 2.7, 1.4)],
        ),
        curve(
            "tuned default",
            Role::Reference,
            [(7.4, 1.1, 1.6), (15.9, 1.5, 2.2)],
        ),
    ];
    series.extend(
        designs
            .iter()
            .map(|(name, peaks)| curve(name, Role::Design, *peaks)),
    );
    Plot {
        caption: "Magnitude of Td over the band, continuous maximum marked.".into(),
        x: Axis {
            label: "Frequency".into(),
            unit: "Hz".into(),
            logarithmic: false,
        },
        y: Axis {
            label: "|Td|".into(),
            unit: String::new(),
            logarithmic: false,
        },
        series,
        limits: Vec::new(),
        areas: Vec::new(),
    }
}

fn design(rank: usize, devices: Vec<Device>, objective: f64, invented: &mut Invented) -> Design {
    Design {
        rank,
        devices,
        objective: Quantity::new(objective, ""),
        criteria: vec![CriterionValue {
            value: objective,
            note: format!("at {:.2} Hz", 10.0 + 8.0 * invented.next()),
            violated: false,
        }],
        improvements: vec![
            100.0 * (1.0 - objective / 3.6349),
            100.0 * (1.0 - objective / 2.3419),
        ],
        starts: 8,
        starts_agreeing: 2 + (invented.next() * 7.0) as usize,
        evaluations: 40_000 + (invented.next() * 90_000.0) as u64,
        feasible: true,
        violation: 0.0,
        certificate: "certified within 2.1×10⁻⁷".into(),
        ..Design::default()
    }
}

fn design_task(
    name: &str,
    layouts: &[String],
    best: f64,
    invented: &mut Invented,
) -> Result<TaskSection, Failure> {
    let mut designs = Vec::new();
    for (index, text) in layouts.iter().enumerate() {
        let objective = best * (1.0 + 0.012 * index as f64 + 0.004 * invented.next());
        designs.push(design(
            index + 1,
            vec![hydraulic(text, invented)?],
            objective,
            invented,
        ));
    }
    let winner = designs.first().map_or(String::new(), |design| {
        design
            .devices
            .iter()
            .map(|device| device.layout.clone())
            .collect()
    });
    Ok(TaskSection {
        name: name.into(),
        kind: TaskKind::Design,
        words: vec![format!(
            "Minimise Td_max over {} candidate layouts of the device `passage` with at least one tube, reducible layouts left out.",
            layouts.len()
        )],
        criteria: vec![CriterionColumn {
            name: "Td_max".into(),
            unit: String::new(),
            role: "minimised".into(),
        }],
        references: vec![
            ReferenceRow {
                name: "default".into(),
                words: "one tube as built".into(),
                criteria: vec![CriterionValue {
                    value: 3.6349,
                    note: "at 18.71 Hz".into(),
                    violated: false,
                }],
                infeasible: false,
            },
            ReferenceRow {
                name: "tuned default".into(),
                words: "the same layout, designed under the same bounds".into(),
                criteria: vec![CriterionValue {
                    value: 2.3419,
                    note: "at 15.92 Hz".into(),
                    violated: false,
                }],
                infeasible: false,
            },
        ],
        designs,
        plots: vec![response(&[(&winner, [(7.2, 0.7, 2.4), (15.2, 0.75, 3.1)])])],
        ..TaskSection::default()
    })
}

/// Forty-two invented four-branch layouts.
fn many() -> Vec<String> {
    let shapes = [
        "A + B + (C | D)",
        "(A + B) | (C + D)",
        "A | (B + (C | D))",
        "A + (B | C | D)",
        "A | B + C + D",
        "(A | B) + (C | D)",
        "A | B | C + D",
    ];
    let labels = [
        ["tube", "tube", "tube", "throttle"],
        ["tube", "throttle", "tube", "throttle"],
        ["throttle", "tube", "tube", "tube"],
        ["tube", "tube", "throttle", "tube"],
        ["tube"; 4],
        ["throttle", "tube", "throttle", "tube"],
    ];
    let mut texts = Vec::new();
    for kinds in labels {
        for shape in shapes {
            let mut counts = std::collections::BTreeMap::new();
            let mut text = shape.to_owned();
            for (letter, kind) in ["A", "B", "C", "D"].iter().zip(kinds) {
                let count = counts
                    .entry(kind)
                    .and_modify(|count| *count += 1)
                    .or_insert(1);
                text = text.replace(letter, &format!("{kind}{count}"));
            }
            texts.push(text);
        }
    }
    texts
}

fn sweep_task(invented: &mut Invented) -> Result<TaskSection, Failure> {
    let mut sweep = Vec::new();
    for step in 0..7 {
        let stiffness = 1e5 * 4f64.powf(f64::from(step) / 6.0);
        sweep.push(SweepPoint {
            at: vec![Parameter {
                name: "kr".into(),
                value: Quantity::new(stiffness / 1e3, "kN/m"),
            }],
            designs: ["tube1 + throttle1", "tube1 | throttle1"]
                .iter()
                .enumerate()
                .map(|(index, text)| {
                    Ok(design(
                        index + 1,
                        vec![hydraulic(text, invented)?],
                        1.2 + 0.15 * f64::from(step) + 0.03 * index as f64,
                        invented,
                    ))
                })
                .collect::<Result<_, Failure>>()?,
            configurations: Vec::new(),
        });
    }
    Ok(TaskSection {
        sweep,
        designs: Vec::new(),
        plots: Vec::new(),
        ..design_task("two, softer and stiffer", &[], 1.0, invented)?
    })
}

fn absorber_task(invented: &mut Invented) -> Result<TaskSection, Failure> {
    let values = [
        ("k1", 2154.3, "N/m"),
        ("c1", 45.21, "N*s/m"),
        ("m1", 5.0, "kg"),
        ("b1", 1.25, "kg"),
        ("k2", 8.9e5, "N/m"),
    ];
    let texts = [
        "m1 + (k1 | c1 + b1)",
        "m1 + (k1 | c1)",
        "k2 + (k1 | c1 | b1) + m1",
    ];
    let mut designs = Vec::new();
    for (index, text) in texts.iter().enumerate() {
        let used: Vec<_> = values
            .iter()
            .copied()
            .filter(|(name, _, _)| text.contains(name))
            .collect();
        let mut devices = vec![mechanical(text, &used, "x1", Terminal::Ground)?];
        if index == 0 {
            let mut second = mechanical("k1 | c1", &values[..2], "x1", Terminal::Ground)?;
            second.name = "strut".into();
            if let Some(value) = second.values.first_mut() {
                value.active = Some(Side::Lower);
                value.value.value /= 100.0;
            }
            devices.push(second);
        }
        let mut design = design(index + 1, devices, 6.40792 + index as f64 * 0.3, invented);
        design.criteria.push(CriterionValue {
            value: 0.01421 * (1.0 + index as f64),
            note: String::new(),
            violated: index == 2,
        });
        design.feasible = index != 2;
        design.violation = if index == 2 { 4.1 } else { 0.0 };
        designs.push(design);
    }
    let mut task = design_task("absorber <b>& friends</b>", &[], 1.0, invented)?;
    task.criteria.push(CriterionColumn {
        name: "stroke".into(),
        unit: "m".into(),
        role: "≤ 0.03 m".into(),
    });
    for reference in &mut task.references {
        reference.criteria.push(CriterionValue {
            value: 0.0213,
            ..CriterionValue::default()
        });
    }
    task.designs = designs;
    let mut plot = response(&[("m1 + (k1 | c1 + b1)", [(9.0, 0.9, 1.5), (13.0, 0.9, 1.4)])]);
    plot.y.logarithmic = true;
    plot.x.logarithmic = true;
    plot.limits = vec![("allowed".into(), 2.5)];
    task.plots = vec![plot];
    Ok(task)
}

fn main() -> Result<(), Failure> {
    let mut invented = Invented(7);
    let default = Configuration {
        energy: Vec::new(),
        name: "default".into(),
        devices: vec![hydraulic("tube1", &mut invented)?],
        criteria: vec![CriterionValue {
            value: 3.6349,
            note: "at 18.71 Hz, within 3×10⁻⁸".into(),
            violated: false,
        }],
    };
    let evaluate = TaskSection {
        name: "default".into(),
        kind: TaskKind::Evaluate,
        words: vec!["The present configuration, evaluated.".into()],
        criteria: vec![CriterionColumn {
            name: "Td_max".into(),
            unit: String::new(),
            role: String::new(),
        }],
        configurations: vec![default],
        plots: vec![response(&[])],
        ..TaskSection::default()
    };
    let two: Vec<String> = [
        "tube1 + throttle1",
        "tube1 | throttle1",
        "tube1 | tube2",
        "tube1 + tube2",
    ]
    .map(String::from)
    .to_vec();
    let page = Page {
        comparisons: Vec::new(),
        title: "Which fluid passageways for this isolator?".into(),
        subtitle: "A mass on a fluid-filled isolator above a shaking base: what should the passageway between its two chambers look like?".into(),
        facts: vec![
            Fact::new("Study", "studies/fluid-isolator.toml"),
            Fact::new("Study hash", "b3:9f2c41d07a6e"),
            Fact::new("Quell", "0.1.0"),
            Fact::new("Seed", "1"),
            Fact::new("Threads", "2"),
            Fact::new("Time", "4.2 s"),
            Fact::new("Evaluations", "2 713 440"),
        ],
        problem: Problem {
            paragraphs: vec!["The base moves by xs between 0 and 30 Hz. The relative motion of the mass, Td = xe − xs for a unit motion of the base, is to stay small over the whole band.".into()],
            facts: vec![
                Fact::new("Host", "Mass on a fluid-filled isolator (hosts/fluid-isolator.toml)"),
                Fact::new("Excitation", "xs, a prescribed displacement"),
                Fact::new("Band", "0 Hz to 30 Hz"),
                Fact::new("Device", "passage at port isolator, hydraulic, piston area 2.5×10⁻³ m²: C1 | (C2 + network)"),
            ],
            criteria: vec![
                CriterionRow { name: "Td_max".into(), meaning: "max(abs(Td)) over run road".into(), unit: String::new() },
                CriterionRow { name: "stroke".into(), meaning: "max(abs(stroke(tube1)))".into(), unit: "m".into() },
            ],
            parameters: vec![
                Parameter { name: "me".into(), value: Quantity::new(60.0, "kg") },
                Parameter { name: "kr".into(), value: Quantity::new(2.25e5, "N/m") },
                Parameter { name: "C1".into(), value: Quantity::new(3e-11, "m^5/N") },
                Parameter { name: "R0".into(), value: Quantity::new(1.05e8, "kg/(s*m^4)") },
            ],
            bounds: vec![
                BoundRow { variable: "tube.dL".into(), bounds: DIMENSIONLESS, unit: String::new() },
                BoundRow { variable: "tube.dA".into(), bounds: DIMENSIONLESS, unit: String::new() },
                BoundRow { variable: "throttle.dO".into(), bounds: WIDE, unit: String::new() },
            ],
            constraints: vec![],
        },
        tasks: vec![
            evaluate,
            design_task("one", &["tube1".to_owned()], 2.3419, &mut invented)?,
            design_task("two", &two, 1.7550, &mut invented)?,
            design_task("four", &many(), 1.6650, &mut invented)?,
            sweep_task(&mut invented)?,
            absorber_task(&mut invented)?,
        ],
    };
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "report.html".into());
    std::fs::write(path, page.html())?;
    Ok(())
}
