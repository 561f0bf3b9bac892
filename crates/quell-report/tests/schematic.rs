//! Invariants of drawings, over every layout of a small grammar and over random trees.

#![expect(clippy::panic, reason = "helpers of tests may fail loudly")]

mod wellformed;

use quell_report::schematic::{Drawing, Orientation, Part, Schematic, Style, Terminal};
use quell_report::symbols::Symbol;
use wellformed::well_formed;

const SYMBOLS: [Symbol; 11] = [
    Symbol::Spring,
    Symbol::Damper,
    Symbol::Inerter,
    Symbol::Mass,
    Symbol::Inertance,
    Symbol::Restriction,
    Symbol::Compliance,
    Symbol::Resistor,
    Symbol::Inductor,
    Symbol::Capacitor,
    Symbol::Box,
];

/// A linear congruential generator (Knuth's MMIX constants): the same trees on every machine.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end
    }
}

/// A random tree with `leaves` named parts; groups alternate as in a canonical tree.
fn tree(
    random: &mut Random,
    leaves: usize,
    series: bool,
    next: &mut usize,
    names: &mut Vec<String>,
) -> Part {
    if leaves == 1 {
        *next += 1;
        let component = random.below(5) == 0;
        let name = format!("{}{next}", if component { "part" } else { "x" });
        names.push(name.clone());
        let value = |random: &mut Random| {
            ["1.2345×10⁻⁹ m⁵/N", "656.25 N·s/m", "5 kg"][random.below(3)].to_owned()
        };
        if component {
            let inner = vec![
                Part::Element {
                    symbol: Symbol::Restriction,
                    name: "R".into(),
                    value: None,
                },
                Part::Element {
                    symbol: Symbol::Inertance,
                    name: "I".into(),
                    value: None,
                },
            ];
            return Part::Component {
                name,
                values: vec![
                    "dL = 0.5402".into(),
                    "dA = 0.5000".into(),
                    "a long one = 1.0 kg/(s·m⁴)".into(),
                ],
                inner: Box::new(if random.below(2) == 0 {
                    Part::Series(inner)
                } else {
                    Part::Parallel(inner)
                }),
            };
        }
        let symbol = SYMBOLS[random.below(SYMBOLS.len())];
        return Part::Element {
            symbol,
            name,
            value: Some(value(random)),
        };
    }
    let groups = 2 + random.below((leaves - 1).min(3));
    let mut sizes = vec![1; groups.min(leaves)];
    for _ in sizes.len()..leaves {
        let lucky = random.below(sizes.len());
        sizes[lucky] += 1;
    }
    let parts = sizes
        .into_iter()
        .map(|size| tree(random, size, !series, next, names))
        .collect();
    if series {
        Part::Series(parts)
    } else {
        Part::Parallel(parts)
    }
}

fn styles() -> Vec<Style> {
    let mut styles = vec![Style::FULL, Style::ROW];
    for orientation in [Orientation::Vertical, Orientation::Horizontal] {
        for values in [false, true] {
            for expand in [false, true] {
                styles.push(Style {
                    orientation,
                    values,
                    expand,
                    terminals: true,
                });
            }
        }
    }
    styles
}

fn check(drawing: &Drawing, names: &[String], what: &str) {
    assert!(
        drawing.width > 0.0 && drawing.height > 0.0,
        "{what}: {} by {}",
        drawing.width,
        drawing.height
    );
    well_formed(&drawing.svg).unwrap_or_else(|fault| panic!("{what}: {fault}\n{}", drawing.svg));
    well_formed(&drawing.standalone()).unwrap_or_else(|fault| panic!("{what}: {fault}"));
    assert!(
        !drawing.svg.contains("NaN") && !drawing.svg.contains("inf"),
        "{what}"
    );
    for name in names {
        let times = drawing
            .symbols
            .iter()
            .filter(|(drawn, _)| drawn == name)
            .count();
        assert_eq!(times, 1, "{what}: `{name}` is drawn {times} times");
        assert_eq!(
            drawing
                .labels
                .iter()
                .filter(|(label, _)| label == name)
                .count(),
            1,
            "{what}: label of `{name}`"
        );
    }
    for (index, (left_text, left)) in drawing.labels.iter().enumerate() {
        for (right_text, right) in &drawing.labels[index + 1..] {
            assert!(
                !left.overlaps(right),
                "{what}: labels `{left_text}` {left:?} and `{right_text}` {right:?} overlap"
            );
        }
        for (name, symbol) in &drawing.symbols {
            // The frame of an opened component holds its elements and their labels.
            let frame = drawing
                .symbols
                .iter()
                .any(|(other, room)| other != name && contains(symbol, room));
            assert!(
                frame || !left.overlaps(symbol),
                "{what}: label `{left_text}` {left:?} runs into `{name}` {symbol:?}"
            );
        }
    }
    for (index, (left_name, left)) in drawing.symbols.iter().enumerate() {
        for (right_name, right) in &drawing.symbols[index + 1..] {
            assert!(
                contains(left, right) || contains(right, left) || !left.overlaps(right),
                "{what}: `{left_name}` {left:?} and `{right_name}` {right:?} overlap"
            );
        }
    }
}

fn contains(
    outer: &quell_report::schematic::Rectangle,
    inner: &quell_report::schematic::Rectangle,
) -> bool {
    outer.left <= inner.left
        && outer.top <= inner.top
        && outer.right >= inner.right
        && outer.bottom >= inner.bottom
}

#[test]
fn random_trees_are_drawn_once_and_clear_of_each_other() {
    let mut random = Random(11);
    for leaves in 1..=20 {
        for round in 0..12 {
            let mut names = Vec::new();
            let part = tree(&mut random, leaves, round % 2 == 0, &mut 0, &mut names);
            assert_eq!(names.len(), leaves);
            for style in styles() {
                let tail = if round % 3 == 0 {
                    Terminal::Ground
                } else {
                    Terminal::Point("xs_left".into())
                };
                let schematic = Schematic {
                    part: part.clone(),
                    head: Terminal::Point("hub".into()),
                    tail,
                };
                check(
                    &schematic.draw(style),
                    &names,
                    &format!("{leaves} leaves, round {round}, {style:?}"),
                );
            }
        }
    }
}

#[test]
fn a_device_that_ends_in_masses_has_no_second_terminal() {
    let mass = |name: &str| Part::Element {
        symbol: Symbol::Mass,
        name: name.into(),
        value: None,
    };
    let spring = Part::Element {
        symbol: Symbol::Spring,
        name: "k1".into(),
        value: None,
    };
    // Written first in its group, the mass is still drawn last.
    let part = Part::Series(vec![mass("m1"), spring.clone()]);
    let schematic = Schematic {
        part,
        head: Terminal::Point("x".into()),
        tail: Terminal::Point("unseen".into()),
    };
    let drawing = schematic.draw(Style::FULL);
    assert!(!drawing.svg.contains("unseen"));
    let place = |name: &str| {
        drawing
            .symbols
            .iter()
            .find(|(drawn, _)| drawn == name)
            .map(|(_, room)| room.top)
            .unwrap()
    };
    assert!(place("m1") > place("k1"));
    // Beside a spring that reaches the far side, the terminal is there.
    let part = Part::Parallel(vec![mass("m1"), spring]);
    let schematic = Schematic {
        part,
        head: Terminal::Point("x".into()),
        tail: Terminal::Point("seen".into()),
    };
    assert!(schematic.draw(Style::FULL).svg.contains("seen"));
}

#[test]
fn names_and_values_are_escaped() {
    let part = Part::Element {
        symbol: Symbol::Box,
        name: "<k&\"1>".into(),
        value: Some("<script>".into()),
    };
    let schematic = Schematic {
        part,
        head: Terminal::Open,
        tail: Terminal::Open,
    };
    let drawing = schematic.draw(Style::FULL);
    well_formed(&drawing.svg).unwrap();
    assert!(!drawing.svg.contains("<script>") && drawing.svg.contains("&lt;script&gt;"));
}

#[test]
fn empty_groups_do_no_harm() {
    for part in [Part::Series(Vec::new()), Part::Parallel(Vec::new())] {
        let schematic = Schematic {
            part,
            head: Terminal::Open,
            tail: Terminal::Ground,
        };
        for style in styles() {
            check(&schematic.draw(style), &[], "empty");
        }
    }
}
