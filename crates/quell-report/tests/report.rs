//! The page and its plots as a reader's browser gets them.

#![expect(clippy::unwrap_used, reason = "helpers of tests may fail loudly")]

mod wellformed;

use quell_network::{Domain, Kinds, Layout};
use quell_report::layout::Annotations;
use quell_report::page::{
    Bounds, Configuration, CriterionColumn, CriterionValue, Design, DesignValue, Device, Fact,
    Page, Parameter, Problem, Quantity, ReferenceRow, Side, SweepPoint, TaskKind, TaskSection,
};
use quell_report::plot::{Axis, Plot, Role, Series};
use quell_report::schematic::{Part, Schematic, Style, Terminal};
use wellformed::well_formed;

const NASTY: &str = "<script>alert(\"x\" & 'y')</script>";

fn kinds() -> Kinds {
    let mut kinds = Kinds::new(Domain::Hydraulic);
    kinds.declare_component("tube").unwrap();
    kinds
}

fn device(text: &str) -> Device {
    let layout = Layout::parse(text, &kinds()).unwrap();
    let annotations = Annotations {
        values: vec![
            ("tube1.dL".into(), "0.5402".into()),
            ("R1".into(), "8.506".into()),
        ],
        components: vec![(
            "tube".into(),
            Layout::parse("R + I", &Kinds::new(Domain::Hydraulic)).unwrap(),
        )],
        placeholders: Vec::new(),
    };
    Device {
        name: "passage".into(),
        layout: layout.to_string(),
        schematic: Schematic {
            part: Part::from_layout(&layout, &annotations),
            head: Terminal::Point(NASTY.into()),
            tail: Terminal::Ground,
        },
        values: vec![
            DesignValue {
                name: "tube1.dL".into(),
                value: Quantity::new(0.5, ""),
                bounds: Some(Bounds {
                    lower: 0.5,
                    upper: 1.5,
                    logarithmic: false,
                }),
                active: Some(Side::Lower),
            },
            DesignValue {
                name: "R1".into(),
                value: Quantity::new(f64::NAN, NASTY),
                bounds: Some(Bounds {
                    lower: 0.0,
                    upper: 0.0,
                    logarithmic: true,
                }),
                active: None,
            },
        ],
    }
}

fn design(rank: usize) -> Design {
    Design {
        rank,
        devices: vec![device("tube1 + (tube2 | R1)")],
        objective: Quantity::new(1.755 + rank as f64, "m"),
        criteria: vec![CriterionValue {
            value: 1.755,
            note: NASTY.into(),
            violated: rank == 2,
        }],
        improvements: vec![51.7],
        starts: 8,
        starts_agreeing: 7,
        evaluations: 123_456,
        feasible: rank != 2,
        violation: if rank == 2 { 3.2 } else { 0.0 },
        certificate: NASTY.into(),
        remarks: vec![NASTY.into()],
    }
}

fn plot() -> Plot {
    Plot {
        caption: NASTY.into(),
        x: Axis {
            label: "Frequency".into(),
            unit: "Hz".into(),
            logarithmic: false,
        },
        y: Axis {
            label: format!("$|T_d|$ {NASTY}"),
            unit: "m/s^2".into(),
            logarithmic: false,
        },
        series: vec![
            Series {
                name: NASTY.into(),
                role: Role::Baseline,
                points: (0..5000)
                    .map(|index| (f64::from(index), f64::from(index % 97)))
                    .collect(),
                peak: Some((96.0, 96.0)),
                markers: false,
                ..Series::default()
            },
            Series {
                name: "broken".into(),
                role: Role::Design,
                points: vec![
                    (1.0, 2.0),
                    (2.0, f64::NAN),
                    (3.0, f64::INFINITY),
                    (4.0, 1.0),
                ],
                peak: Some((f64::NAN, 1.0)),
                markers: true,
                ..Series::default()
            },
        ],
        limits: vec![("allowed".into(), 50.0), ("none".into(), f64::NAN)],
        areas: Vec::new(),
    }
}

fn page(designs: usize) -> Page {
    let task = TaskSection {
        name: NASTY.into(),
        kind: TaskKind::Design,
        words: vec![format!("minimise `a` {NASTY}")],
        status: Some(NASTY.into()),
        criteria: vec![CriterionColumn {
            name: NASTY.into(),
            unit: "m".into(),
            role: "minimised".into(),
        }],
        references: vec![ReferenceRow {
            name: NASTY.into(),
            words: NASTY.into(),
            criteria: vec![CriterionValue::default()],
            infeasible: true,
        }],
        designs: (1..=designs).map(design).collect(),
        plots: vec![plot()],
        ..TaskSection::default()
    };
    let configuration = |name: &str| Configuration {
        energy: Vec::new(),
        name: name.into(),
        devices: vec![device("tube1")],
        criteria: vec![CriterionValue::default()],
    };
    let sweep = (1..=3)
        .map(|step| SweepPoint {
            at: vec![Parameter {
                name: "kr".into(),
                value: Quantity::new(f64::from(step), NASTY),
            }],
            designs: vec![design(1), design(2)],
            configurations: vec![configuration("a"), configuration(NASTY)],
        })
        .collect();
    Page {
        comparisons: Vec::new(),
        title: NASTY.into(),
        subtitle: NASTY.into(),
        facts: vec![Fact::new(NASTY, NASTY)],
        problem: Problem {
            paragraphs: vec![NASTY.into()],
            constraints: vec![NASTY.into()],
            ..Problem::default()
        },
        tasks: vec![
            task.clone(),
            TaskSection {
                sweep,
                designs: Vec::new(),
                ..task
            },
            TaskSection {
                configurations: vec![configuration("default")],
                ..TaskSection::default()
            },
            TaskSection {
                kind: TaskKind::Design,
                front: vec![design(1), design(2)],
                plots: vec![plot()],
                ..TaskSection::default()
            },
            TaskSection {
                name: "nothing came of it".into(),
                kind: TaskKind::Design,
                ..TaskSection::default()
            },
        ],
    }
}

#[test]
fn user_text_is_escaped_everywhere() {
    let html = page(9).html();
    assert!(!html.contains("<script"), "a script got through");
    assert!(html.contains("&lt;script&gt;"));
}

#[test]
fn the_page_is_well_formed_apart_from_void_elements() {
    let html = page(9).html();
    let body = html
        .split_once("</head>")
        .unwrap()
        .1
        .trim_end_matches("</html>");
    well_formed(&body.replace("<br>", "")).unwrap();
}

#[test]
fn the_page_loads_nothing() {
    let html = page(9).html();
    for loader in [
        "http:", "https:", "src=", "@import", "<link", "<script", "url(//", "xlink",
    ] {
        assert!(!html.contains(loader), "`{loader}` is in the page");
    }
    // What `url()` remains refers into the page itself.
    assert!(
        html.match_indices("url(")
            .all(|(place, _)| html[place..].starts_with("url(#"))
    );
}

#[test]
fn identifiers_are_unique_and_references_resolve() {
    let html = page(9).html();
    let ids: Vec<&str> = html
        .split(" id=\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .collect();
    let unique: std::collections::HashSet<_> = ids.iter().collect();
    assert_eq!(ids.len(), unique.len(), "an id occurs twice");
    for reference in html
        .split("url(#")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
    {
        assert!(unique.contains(&reference), "`{reference}` is nowhere");
    }
    for reference in html
        .split("href=\"#")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
    {
        assert!(unique.contains(&reference), "`{reference}` is nowhere");
    }
}

#[test]
fn a_long_shortlist_is_folded_and_light() {
    let html = page(42).html();
    assert!(html.contains("Ranks 7 to 42"));
    assert!(html.len() < 1_000_000, "{} bytes", html.len());
}

#[test]
fn plots_keep_dashes_and_scale() {
    for svg in [
        plot().standalone(800.0, 400.0),
        Plot::default().standalone(800.0, 400.0),
    ] {
        well_formed(&svg).unwrap();
        assert!(svg.contains("viewBox=\"0 0 "));
        assert!(!svg.contains("NaN"));
    }
    let svg = plot().standalone(800.0, 400.0);
    assert!(svg.contains("stroke-dasharray=\"7 4\""));
    // 5000 points are thinned, extremes kept.
    assert!(svg.len() < 60_000, "{} bytes", svg.len());
}

#[test]
fn logarithmic_axes_leave_out_what_they_cannot_show() {
    let mut plot = plot();
    plot.x.logarithmic = true;
    plot.y.logarithmic = true;
    let svg = plot.standalone(800.0, 400.0);
    well_formed(&svg).unwrap();
    assert!(!svg.contains("NaN") && !svg.contains("inf\""));
    // One point alone, and a curve without height.
    for points in [
        vec![(1.0, 1.0)],
        vec![(1.0, 1.0), (2.0, 1.0)],
        vec![(0.0, 0.0), (1.0, 0.0)],
    ] {
        plot.series = vec![Series {
            points,
            ..Series::default()
        }];
        plot.limits.clear();
        for logarithmic in [false, true] {
            plot.x.logarithmic = logarithmic;
            plot.y.logarithmic = logarithmic;
            let svg = plot.standalone(800.0, 400.0);
            well_formed(&svg).unwrap();
            assert!(!svg.contains("NaN"), "{svg}");
        }
    }
}

#[test]
fn every_domain_has_its_symbols() {
    for (domain, text, words) in [
        (
            Domain::Translational,
            "k1 | c1 + b1",
            ["spring k1", "damper c1", "inerter b1"],
        ),
        (
            Domain::Rotational,
            "k1 | c1 + b1",
            ["spring k1", "damper c1", "inerter b1"],
        ),
        (
            Domain::Electrical,
            "R1 | L1 + C1",
            ["resistor R1", "inductor L1", "capacitor C1"],
        ),
        (
            Domain::Hydraulic,
            "R1 | I1 + C1",
            ["restriction R1", "inertance I1", "compliance C1"],
        ),
    ] {
        let layout = Layout::parse(text, &Kinds::new(domain)).unwrap();
        let part = Part::from_layout(&layout, &Annotations::default());
        let drawing = Schematic {
            part,
            head: Terminal::Open,
            tail: Terminal::Open,
        }
        .draw(Style::FULL);
        for word in words {
            assert!(drawing.svg.contains(word), "{word} in {}", drawing.svg);
        }
        assert_eq!(drawing.symbols.len(), 3);
    }
}

#[test]
fn a_component_of_itself_ends() {
    let layout = Layout::parse("tube1 + R1", &kinds()).unwrap();
    let annotations = Annotations {
        components: vec![("tube".into(), layout.clone())],
        ..Annotations::default()
    };
    let drawing = Schematic {
        part: Part::from_layout(&layout, &annotations),
        head: Terminal::Open,
        tail: Terminal::Open,
    }
    .draw(Style::FULL);
    well_formed(&drawing.svg).unwrap();
}
