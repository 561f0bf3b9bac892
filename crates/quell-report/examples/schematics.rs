//! Draws sample networks side by side, to look at the symbols: `cargo run -p quell-report --example schematics -- FILE.html`.

use quell_report::schematic::{Orientation, Part, Schematic, Style, Terminal};
use quell_report::symbols::Symbol;

fn element(symbol: Symbol, name: &str, value: &str) -> Part {
    Part::Element {
        symbol,
        name: name.into(),
        value: Some(value.into()),
    }
}

fn track(number: usize) -> Part {
    Part::Component {
        name: format!("long{number}"),
        values: vec!["dL = 0.5402".into(), "dA = 0.5000".into()],
        inner: Box::new(Part::Series(vec![
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
        ])),
    }
}

fn narrow(number: usize) -> Part {
    Part::Component {
        name: format!("narrow{number}"),
        values: vec!["dO = 8.506".into()],
        inner: Box::new(Part::Element {
            symbol: Symbol::Restriction,
            name: "R".into(),
            value: None,
        }),
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    use Part::{Parallel, Series};
    use Symbol::{
        Box as Plain, Capacitor, Compliance, Damper, Inductor, Inertance, Inerter, Mass, Resistor,
        Restriction, Spring,
    };
    let all = [
        Spring,
        Damper,
        Inerter,
        Mass,
        Inertance,
        Restriction,
        Compliance,
        Resistor,
        Inductor,
        Capacitor,
        Plain,
    ];
    let parts = vec![
        Parallel(
            all.iter()
                .enumerate()
                .map(|(index, symbol)| element(*symbol, &format!("e{index}"), ""))
                .collect(),
        ),
        Parallel(vec![
            element(Spring, "k1", "2.0833×10⁵ N/m"),
            Series(vec![
                element(Damper, "c1", "656.25 N·s/m"),
                element(Inerter, "b1", "23.750 kg"),
            ]),
        ]),
        Series(vec![
            element(Spring, "k2", "4.8842 kN/m"),
            Parallel(vec![
                element(Spring, "k1", "31.600 N/m"),
                element(Damper, "c1", "105.00 N·s/m"),
                element(Inerter, "b1", "1.2000 kg"),
            ]),
        ]),
        Series(vec![
            element(Mass, "m1", "0.50000 kg"),
            Parallel(vec![
                element(Spring, "k1", "98.412 N/m"),
                element(Damper, "c1", "0.9127 N·s/m"),
            ]),
        ]),
        Parallel(vec![
            element(Spring, "k1", "98.4 N/m"),
            Series(vec![
                element(Damper, "c1", "1.2 N·s/m"),
                element(Mass, "m1", "0.5 kg"),
            ]),
        ]),
        Parallel(vec![
            Series(vec![track(1), track(2)]),
            Series(vec![track(3), narrow(1)]),
        ]),
        Series(vec![
            track(1),
            narrow(1),
            Parallel(vec![track(2), narrow(2)]),
        ]),
        Parallel(vec![
            element(Compliance, "C1", "3.0×10⁻¹¹ m⁵/N"),
            Series(vec![element(Compliance, "C2", "2.6×10⁻⁹ m⁵/N"), track(1)]),
        ]),
        Series(vec![
            element(Resistor, "R1", "47 Ω"),
            Parallel(vec![
                element(Inductor, "L1", "1.0 mH"),
                element(Capacitor, "C1", "0.22 µF"),
            ]),
        ]),
        Parallel(
            (0..4)
                .map(|branch| {
                    Series(
                        (0..5)
                            .map(|index| {
                                let symbol = [Spring, Damper, Inerter][(branch + index) % 3];
                                element(
                                    symbol,
                                    &format!("x{}", 5 * branch + index + 1),
                                    "123.45 N·s/m",
                                )
                            })
                            .collect(),
                    )
                })
                .collect(),
        ),
    ];
    let mut page = String::from(
        "<!doctype html><meta charset=utf-8><style>body{font-family:system-ui,sans-serif;margin:0}section{padding:16px;display:flex;flex-wrap:wrap;gap:24px;align-items:start}.dark{background:#14171a;color:#e8e8e8}.narrow svg{max-width:160px;height:auto}</style>",
    );
    let rows = Style {
        orientation: Orientation::Horizontal,
        values: true,
        expand: true,
        terminals: true,
    };
    for (class, style) in [
        ("", Style::FULL),
        ("dark", Style::ROW),
        ("", rows),
        ("dark narrow", Style::FULL),
    ] {
        page.push_str("<section class='");
        page.push_str(class);
        page.push_str("'>");
        for part in &parts {
            let tail = if style == Style::FULL {
                Terminal::Ground
            } else {
                Terminal::Point("xs".into())
            };
            let schematic = Schematic {
                part: part.clone(),
                head: Terminal::Point("xe".into()),
                tail,
            };
            page.push_str(&schematic.draw(style).svg);
        }
        page.push_str("</section>");
    }
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "schematics.html".into());
    std::fs::write(path, page)?;
    Ok(())
}
