//! Writes one plot as an SVG file of its own: `cargo run -p quell-report --example plots -- FILE.svg`.

use quell_report::plot::{Axis, Plot, Role, Series};

fn main() -> std::io::Result<()> {
    let resonance = |name: &str, role, natural: f64, damping: f64| {
        let magnitude = |f: f64| {
            let ratio = f / natural;
            1.0 / ((1.0 - ratio * ratio).powi(2) + (2.0 * damping * ratio).powi(2)).sqrt()
        };
        let at = natural * (1.0 - 2.0 * damping * damping).sqrt();
        Series {
            name: name.into(),
            role,
            points: (1..=2000)
                .map(|step| f64::from(step) * 0.015)
                .map(|f| (f, magnitude(f)))
                .collect(),
            peak: Some((at, magnitude(at))),
            markers: false,
            ..Series::default()
        }
    };
    let plot = Plot {
        caption: "Displacement of an oscillator over its static one".into(),
        x: Axis {
            label: "Frequency".into(),
            unit: "Hz".into(),
            logarithmic: false,
        },
        y: Axis {
            label: "|x k/F|".into(),
            unit: String::new(),
            logarithmic: true,
        },
        series: vec![
            resonance("undamped as built, $5", Role::Baseline, 9.0, 0.02),
            resonance("rule of thumb", Role::Reference, 8.0, 0.08),
            resonance("k1 | c1", Role::Design, 7.0, 0.15),
            resonance("k1 | c1 + b1", Role::Design, 6.0, 0.25),
        ],
        limits: vec![("allowed".into(), 5.0)],
        areas: Vec::new(),
    };
    let path = std::env::args().nth(1).unwrap_or_else(|| "plot.svg".into());
    std::fs::write(path, plot.standalone(760.0, 420.0))
}
