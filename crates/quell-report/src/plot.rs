//! Plots of responses and sweeps: the one module that knows the plotting crate.

use std::fmt::Write as _;

use kuva::backend::svg::SvgBackend;
use kuva::plot::{BandPlot, LegendPosition, LinePlot, LineStyle, ScatterPlot};
use kuva::render::annotations::{ReferenceLine, TextAnnotation};
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot as Layer;
use kuva::render::render::render_multiple;
use kuva::render::theme::Theme;

use crate::number::{compact, unit};
use crate::text::escape;

/// A picture of curves over one axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plot {
    /// The caption under the picture.
    pub caption: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The curves, drawn in order.
    pub series: Vec<Series>,
    /// Horizontal lines, such as a constraint's bound: text and height.
    pub limits: Vec<(String, f64)>,
    /// Shaded areas under the curves.
    pub areas: Vec<Area>,
}

/// A shaded area.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Area {
    /// What it stands for in the legend; areas of one name have one entry.
    pub name: String,
    /// Its place in the palette, from 1; 0 for none.
    pub hue: usize,
    /// Loops of its boundary: the outer one counter-clockwise, those of holes clockwise.
    pub loops: Vec<Vec<(f64, f64)>>,
    /// A text in it, and where.
    pub mark: Option<Mark>,
}

/// An axis.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Axis {
    /// What it shows.
    pub label: String,
    /// The unit; empty if there is none.
    pub unit: String,
    /// Logarithmic; what is not positive is left out then.
    pub logarithmic: bool,
}

/// A curve.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// What it stands for, which decides its colour and dashes.
    pub role: Role,
    /// Points in order; a point that is not finite breaks the curve.
    pub points: Vec<(f64, f64)>,
    /// The point to be marked.
    pub peak: Option<(f64, f64)>,
    /// Mark every point (for sweeps).
    pub markers: bool,
    /// By point, whether it is unstable: what is unstable is dashed. Empty where nothing is.
    pub unstable: Vec<bool>,
    /// Points with a name.
    pub marks: Vec<Mark>,
    /// Its place in the palette, from 1; 0 for ink. Unless given, the next one.
    pub hue: Option<usize>,
    /// Dashes, as of SVG.
    pub dashes: Option<&'static str>,
    /// Another series has its entry in the legend.
    pub unlisted: bool,
}

/// A point with a name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mark {
    /// Where it is.
    pub at: (f64, f64),
    /// Its name.
    pub text: String,
}

/// What a curve stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Role {
    /// Without any device or with the present one: grey, dashed.
    Baseline,
    /// Another reference: dark grey, dotted or dash-dotted.
    Reference,
    /// A design: coloured, solid.
    #[default]
    Design,
}

/// Colours distinguishable with any colour vision (M. Okabe and K. Ito, 2008), as custom properties with the value for light paper.
const DESIGNS: [&str; 6] = [
    "var(--design-1, #0072b2)",
    "var(--design-2, #d55e00)",
    "var(--design-3, #009e73)",
    "var(--design-4, #b0578d)",
    "var(--design-5, #c98a00)",
    "var(--design-6, #3d9bd1)",
];
const REFERENCE: &str = "var(--reference, #3c4248)";
const REFERENCE_DASHES: [&str; 3] = ["2 3", "9 3 2 3", "12 4"];
const BASELINE: &str = "var(--baseline, #7a828a)";
const BASELINE_DASHES: &str = "7 4";
/// Dashes of what is unstable.
const UNSTABLE_DASHES: &str = "5 4";
const INK: &str = "var(--ink, #1b1f23)";
const GRID: &str = "var(--grid, #e3e6e9)";
pub(crate) const LIMIT: &str = "var(--alarm, #b3261e)";

/// More points than this are thinned to the extremes of each interval, which no screen can tell apart.
const MOST_POINTS: usize = 900;

/// How a curve is stroked, for the plot and its legend.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Stroke {
    pub(crate) colour: &'static str,
    pub(crate) dashes: Option<&'static str>,
}

impl Plot {
    /// The stroke of every series, in order.
    pub(crate) fn strokes(&self) -> Vec<Stroke> {
        let (mut references, mut designs) = (0, 0);
        self.series
            .iter()
            .map(|series| match series.role {
                Role::Baseline => Stroke {
                    colour: BASELINE,
                    dashes: Some(BASELINE_DASHES),
                },
                Role::Reference => {
                    references += 1;
                    Stroke {
                        colour: REFERENCE,
                        dashes: REFERENCE_DASHES
                            .get((references - 1) % REFERENCE_DASHES.len())
                            .copied(),
                    }
                }
                Role::Design => {
                    let place = series.hue.unwrap_or_else(|| {
                        designs += 1;
                        designs
                    });
                    Stroke {
                        colour: colour(place),
                        dashes: series.dashes,
                    }
                }
            })
            .collect()
    }

    /// The plot as a file of its own, with its legend under the axes.
    pub fn standalone(&self, width: f64, height: f64) -> String {
        self.render(width, height, true, "plot")
            .replacen("<svg ", r#"<svg xmlns="http://www.w3.org/2000/svg" "#, 1)
            .replace(
                "font-family=\"inherit\"",
                "font-family=\"system-ui, 'Segoe UI', Helvetica, Arial, sans-serif\"",
            )
    }

    /// The plot as an `<svg>` element without a legend; `id` is unique on the page.
    pub(crate) fn inline(&self, width: f64, height: f64, id: &str) -> String {
        self.render(width, height, false, id)
    }

    fn visible(&self, (x, y): (f64, f64)) -> bool {
        x.is_finite()
            && y.is_finite()
            && (!self.x.logarithmic || x > 0.0)
            && (!self.y.logarithmic || y > 0.0)
    }

    /// A series' visible points as unbroken pieces, and whether each is unstable.
    fn pieces(&self, series: &Series) -> Vec<(Vec<(f64, f64)>, bool)> {
        if !series.unstable.is_empty() {
            return self.runs(series);
        }
        series
            .points
            .split(|point| !self.visible(*point))
            .filter(|piece| !piece.is_empty())
            .map(|piece| (thin(piece), false))
            .collect()
    }

    /// Runs of steps that are stable, and of those that are not: a step with one unstable end is.
    fn runs(&self, series: &Series) -> Vec<(Vec<(f64, f64)>, bool)> {
        let mut runs: Vec<(Vec<(f64, f64)>, bool)> = Vec::new();
        let flagged = series.points.iter().zip(&series.unstable);
        let mut before: Option<((f64, f64), bool)> = None;
        for (point, unstable) in flagged {
            if !self.visible(*point) {
                before = None;
                continue;
            }
            if let Some((last, last_unstable)) = before {
                let dashed = last_unstable || *unstable;
                match runs.last_mut() {
                    Some((run, known)) if *known == dashed && run.last() == Some(&last) => {
                        run.push(*point);
                    }
                    _ => runs.push((vec![last, *point], dashed)),
                }
            }
            before = Some((*point, *unstable));
        }
        runs
    }

    fn render(&self, width: f64, height: f64, legend: bool, id: &str) -> String {
        let mut layers: Vec<Layer> = Vec::new();
        let mut listed: Vec<&str> = Vec::new();
        for area in self.areas.iter().filter(|area| area.hue > 0) {
            let outline = outline(&area.loops);
            let (x, y): (Vec<f64>, Vec<f64>) = outline.into_iter().unzip();
            // The plotting crate shades down to a second curve: here that is the first point alone.
            let back: Vec<f64> = y.iter().take(1).copied().collect();
            let mut band = BandPlot::new(x, back, y)
                .with_color(colour(area.hue))
                .with_opacity(SHADE);
            if legend && !listed.contains(&area.name.as_str()) {
                listed.push(&area.name);
                band = band.with_legend(plain(&area.name));
            }
            layers.push(band.into());
        }
        let mut drawn: Vec<_> = self.series.iter().zip(self.strokes()).collect();
        if !legend {
            // Designs go over references, and the first of them over the others; a legend in the picture keeps their order.
            let designs = drawn
                .iter()
                .position(|(series, _)| series.role == Role::Design);
            if let Some(designs) = designs.and_then(|first| drawn.get_mut(first..)) {
                designs.reverse();
            }
        }
        for (series, stroke) in &drawn {
            for (index, (piece, unstable)) in self.pieces(series).into_iter().enumerate() {
                if series.markers {
                    layers.push(
                        ScatterPlot::new()
                            .with_data(piece.clone())
                            .with_color(stroke.colour)
                            .with_size(3.2)
                            .into(),
                    );
                }
                let mut line = LinePlot::new()
                    .with_data(piece)
                    .with_color(stroke.colour)
                    .with_stroke_width(match series.role {
                        Role::Design => 2.0,
                        _ => 1.5,
                    });
                if let Some(dashes) = stroke.dashes.or(unstable.then_some(UNSTABLE_DASHES)) {
                    line = line.with_line_style(LineStyle::Custom(dashes.to_owned()));
                }
                if legend && index == 0 && !series.unlisted {
                    line = line.with_legend(plain(&series.name));
                }
                layers.push(line.into());
            }
        }
        for (series, stroke) in drawn {
            let marked = series.marks.iter().map(|mark| mark.at);
            let marked: Vec<(f64, f64)> = marked.filter(|at| self.visible(*at)).collect();
            if !marked.is_empty() {
                layers.push(
                    ScatterPlot::new()
                        .with_data(marked)
                        .with_color(stroke.colour)
                        .with_size(3.6)
                        .into(),
                );
            }
            if let Some(peak) = series.peak.filter(|peak| self.visible(*peak)) {
                layers.push(
                    ScatterPlot::new()
                        .with_data(vec![peak])
                        .with_color(stroke.colour)
                        .with_size(4.0)
                        .into(),
                );
            }
        }
        let shown: Vec<(f64, f64)> = self
            .series
            .iter()
            .flat_map(|series| series.points.iter().copied().chain(series.peak))
            .chain(
                self.areas
                    .iter()
                    .flat_map(|area| area.loops.iter().flatten().copied()),
            )
            .filter(|point| self.visible(*point))
            .collect();
        if shown.is_empty() {
            return empty(width, height);
        }
        let layout = self.layout(&layers, &shown, width, height, legend);
        let svg = SvgBackend::new().render_scene(&render_multiple(layers, layout));
        fit(&svg, width, height, id, &self.caption)
    }

    fn layout(
        &self,
        layers: &[Layer],
        shown: &[(f64, f64)],
        width: f64,
        height: f64,
        legend: bool,
    ) -> Layout {
        let theme = Theme {
            background: "none".into(),
            axis_color: INK.into(),
            grid_color: GRID.into(),
            tick_color: INK.into(),
            text_color: INK.into(),
            legend_bg: "none".into(),
            legend_border: "none".into(),
            ..Theme::light()
        };
        let mut layout = Layout::auto_from_plots(layers)
            .with_width(width)
            .with_height(height)
            .with_theme(theme)
            .with_font_family("inherit")
            .with_x_label(plain(&titled(&self.x)))
            .with_y_label(plain(&titled(&self.y)))
            .with_label_size(13)
            .with_tick_size(12)
            .with_body_size(12)
            .with_axis_line_width(1.0)
            .with_tick_width(1.0)
            .with_grid_line_width(0.8)
            .with_tick_format(TickFormat::Custom(std::sync::Arc::new(|value| {
                compact(value, 4)
            })));
        if legend {
            layout = layout
                .with_legend_position(LegendPosition::OutsideBottomColumns)
                .with_legend_box(false);
        }
        let (left, right) = range(shown.iter().map(|point| point.0));
        let (low, high) = range(
            shown
                .iter()
                .map(|point| point.1)
                .chain(self.limits.iter().map(|limit| limit.1)),
        );
        if self.x.logarithmic {
            layout = layout.with_log_x();
        }
        if left < right {
            // A sweep that starts just beside zero is shown from zero.
            let start = if !self.x.logarithmic && left > 0.0 && left < 0.05 * right {
                0.0
            } else {
                left
            };
            // Marks at the ends are not to be cut in half.
            let spare = if self.series.iter().any(|series| series.markers) {
                0.02
            } else {
                0.0
            };
            layout = if self.x.logarithmic {
                let factor = (right / left).powf(spare);
                layout
                    .with_x_axis_min(left / factor)
                    .with_x_axis_max(right * factor)
            } else {
                let room = spare * (right - start);
                layout
                    .with_x_axis_min(start - room)
                    .with_x_axis_max(right + room)
            };
        }
        if self.y.logarithmic {
            layout = layout.with_log_y();
            if low < high {
                let room = if self.areas.is_empty() { 1.15 } else { 1.0 };
                layout = layout
                    .with_y_axis_min(low / room)
                    .with_y_axis_max(high * room);
            }
        } else if !self.areas.is_empty() {
            layout = layout.with_y_axis_min(low).with_y_axis_max(high);
        } else {
            // A response that comes near zero is shown from zero, so that heights can be compared by eye.
            let near_zero = low >= 0.0 && low < 0.4 * high;
            let spread = if high > low {
                high - low
            } else {
                high.abs().max(1.0)
            };
            // What lies on the axis with a name is to be seen.
            let named = self.series.iter().any(|series| !series.marks.is_empty());
            let bottom = if near_zero && !named {
                0.0
            } else {
                low - 0.06 * spread
            };
            layout = layout
                .with_y_axis_min(bottom)
                .with_y_axis_max(high + 0.06 * spread);
        }
        let named = self.areas.iter().filter_map(|area| area.mark.as_ref());
        for mark in named.chain(self.series.iter().flat_map(|series| &series.marks)) {
            if self.visible(mark.at) {
                layout = layout.with_annotation(
                    TextAnnotation::new(plain(&mark.text), mark.at.0, mark.at.1)
                        .with_color(INK)
                        .with_font_size(11),
                );
            }
        }
        for (text, value) in &self.limits {
            if value.is_finite() && (!self.y.logarithmic || *value > 0.0) {
                let line = ReferenceLine::horizontal(*value).with_color(LIMIT);
                // On a page the legend says what the line is, clear of the curves.
                layout = layout.with_reference_line(if legend {
                    line.with_label(plain(text))
                } else {
                    line
                });
            }
        }
        layout
    }
}

/// The colour of a place in the palette.
pub(crate) fn colour(hue: usize) -> &'static str {
    let place = hue.checked_sub(1);
    place
        .and_then(|place| DESIGNS.get(place % DESIGNS.len()).copied())
        .unwrap_or(INK)
}

/// How much of its colour an area has.
pub(crate) const SHADE: f64 = 0.3;

/// One outline: holes hang on the outer loop by seams of no width, and run the other way round.
fn outline(loops: &[Vec<(f64, f64)>]) -> Vec<(f64, f64)> {
    let mut all = Vec::new();
    let Some((outer, holes)) = loops.split_first() else {
        return all;
    };
    all.extend(outer.iter().copied().chain(outer.first().copied()));
    for hole in holes {
        all.extend(hole.iter().copied().chain(hole.first().copied()));
        all.extend(outer.first().copied());
    }
    all
}

fn titled(axis: &Axis) -> String {
    if axis.unit.is_empty() {
        axis.label.clone()
    } else {
        format!("{} ({})", axis.label, unit(&axis.unit))
    }
}

/// The plotting crate reads dollars as mathematics.
fn plain(text: &str) -> String {
    text.replace('$', "\\$")
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        })
}

/// Keeps the first, lowest, highest and last point of each interval where there are too many.
fn thin(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    if points.len() <= MOST_POINTS {
        return points.to_vec();
    }
    let mut kept = Vec::with_capacity(MOST_POINTS);
    for chunk in points.chunks(points.len().div_ceil(MOST_POINTS / 3)) {
        let mut lowest = 0;
        let mut highest = 0;
        for (index, point) in chunk.iter().enumerate() {
            if chunk.get(lowest).is_some_and(|known| point.1 < known.1) {
                lowest = index;
            }
            if chunk.get(highest).is_some_and(|known| point.1 > known.1) {
                highest = index;
            }
        }
        let mut indices = [0, lowest.min(highest), lowest.max(highest)].to_vec();
        indices.dedup();
        kept.extend(
            indices
                .into_iter()
                .filter_map(|index| chunk.get(index).copied()),
        );
    }
    kept.extend(points.last().copied());
    kept
}

fn empty(width: f64, height: f64) -> String {
    format!(
        r#"<svg viewBox="0 0 {width:.0} {height:.0}" role="img"><text x="50%" y="50%" text-anchor="middle" fill="currentColor" font-size="13">nothing to show: no point is finite</text></svg>"#
    )
}

/// Makes the plotting crate's file an element of a page: a view box, ids of its own, a title.
fn fit(svg: &str, width: f64, height: f64, id: &str, title: &str) -> String {
    let Some((head, body)) = svg.split_once('>') else {
        return svg.to_owned();
    };
    let attribute = |name: &str| {
        let start = head.find(&format!(" {name}=\""))? + name.len() + 3;
        head.get(start..)?.split('"').next()?.parse::<f64>().ok()
    };
    let (width, height) = (
        attribute("width").unwrap_or(width),
        attribute("height").unwrap_or(height),
    );
    let mut fitted = String::with_capacity(svg.len() + 200);
    let _ = write!(
        fitted,
        r#"<svg viewBox="0 0 {:.0} {height:.0}" role="img" font-family="inherit" fill="{INK}"><title>{}</title>"#,
        // Half of the last tick's label lies beyond the axes.
        width + 14.0,
        escape(title)
    );
    let body = match (body.find("<!--"), body.find("-->")) {
        (Some(start), Some(end)) if start < end => format!(
            "{}{}",
            body.get(..start).unwrap_or_default(),
            body.get(end + 3..).unwrap_or_default()
        ),
        _ => body.to_owned(),
    };
    fitted.push_str(
        &body
            .replace("id=\"", &format!("id=\"{id}-"))
            .replace("url(#", &format!("url(#{id}-")),
    );
    fitted
}
