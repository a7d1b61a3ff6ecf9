//! Points and lines over an axis, with error bars and levels.

use std::fmt::Write as _;

use super::decimate::spans;
use super::frame::{PlotFrame, legend, text};
use super::ticks::Scale;
use super::{Picture, WIDTH, color, dash};
use crate::markup::Markup;

/// Maximum number of points in a picture that are drawn individually.
const MOST_POINTS: usize = 3000;
/// Maximum number of individual points on a page with many pictures.
const SPARING: usize = 2000;
/// Multiple of the quartile distance beyond the quartiles from which points are outliers.
const FAR: f64 = 5.0;
/// Number of points below which none is an outlier.
const FEW: usize = 20;
/// Half the size of a marker.
const HALF: f64 = 2.2;

/// Chart of values over an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Title of the horizontal axis, with its unit.
    pub across: String,
    /// Title of the vertical axis, with its unit.
    pub up: String,
    /// Series.
    pub series: Vec<PlotSeries>,
    /// Horizontal lines across the whole picture.
    pub levels: Vec<LevelLine>,
    /// True if 0 is in the middle of the vertical axis.
    pub is_balanced: bool,
    /// True if outliers are drawn at the edge, so that one wrong value does not hide the others.
    pub is_clipped: bool,
    /// True if it is one of many on its page: markers are dots, and columns replace them earlier.
    pub is_sparing: bool,
}

/// Series of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlotSeries {
    /// Name; without one it is not in the legend.
    pub label: String,
    /// Horizontal and vertical values; points that are not numbers are omitted.
    pub points: Vec<(f64, f64)>,
    /// Half the length of the error bar of each point; may be empty.
    pub errors: Vec<f64>,
    /// Shape.
    pub shape: Shape,
    /// Number of the series whose color it shares: a line through its points, which stands out from them.
    pub like: Option<usize>,
}

/// Shape in which points are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// A marker for each.
    #[default]
    Markers,
    /// A line from each to the next.
    Line,
}

/// Horizontal line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelLine {
    /// Height.
    pub value: f64,
    /// Name.
    pub label: String,
}

impl Chart {
    /// Returns the frame that contains all points, error bars and lines.
    fn frame(&self) -> PlotFrame {
        let points = || self.series.iter().flat_map(|series| &series.points);
        let across = Scale::around(points().map(|point| point.0), 8);
        let fence = if self.is_clipped { self.fence() } else { None };
        let is_near = |value: &f64| fence.is_none_or(|[low, high]| (low..=high).contains(value));
        let ups = points().map(|point| point.1).filter(is_near).chain(self.levels.iter().map(|level| level.value));
        let bars = self.series.iter().flat_map(|series| {
            let ends = |(point, error): (&(f64, f64), &f64)| [point.1 - error, point.1 + error];
            series.points.iter().zip(&series.errors).flat_map(ends)
        });
        let ups = ups.chain(bars);
        let up = if self.is_balanced { Scale::balanced(ups, 6) } else { Scale::around(ups, 6) };
        PlotFrame::new(across, up, self.height())
    }

    /// Returns the range outside which points are outliers.
    fn fence(&self) -> Option<[f64; 2]> {
        let all = self.series.iter().flat_map(|series| &series.points).map(|point| point.1);
        let mut sorted: Vec<f64> = all.filter(|value| value.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let [first, third] = [1, 3].map(|k| sorted.get(sorted.len() * k / 4).copied().unwrap_or(0.0));
        let far = FAR * (third - first);
        (sorted.len() >= FEW && far > 0.0).then_some([first - far, third + far])
    }

    /// Returns the paths of a series: filled or stroked shapes, thin lines, and dots.
    fn paths(&self, number: usize, series: &PlotSeries, frame: &PlotFrame, is_dense: bool) -> [String; 3] {
        let [mut shapes, mut lines, mut dots] = [String::new(), String::new(), String::new()];
        let points = || series.points.iter().copied().filter(|point| point.0.is_finite() && point.1.is_finite());
        if is_dense {
            let placed = points().map(|point| (frame.across.share(point.0), point.1));
            let columns = frame.columns();
            let [left, right] = frame.across.ends().map(|end| frame.x(end));
            for (column, span) in spans(placed, columns).into_iter().enumerate() {
                let Some(span) = span else { continue };
                let x = left + (right - left) * (column as f64 + 0.5) / columns as f64;
                let (low, high) = (frame.y(span.low) + 0.6, frame.y(span.high) - 0.6);
                let _ = write!(lines, "M{x:.1} {high:.1}V{low:.1}");
            }
            return [shapes, lines, dots];
        }
        match series.shape {
            Shape::Markers => points().for_each(|(x, y)| {
                let [at, up] = [frame.x(x), frame.y(y)];
                match frame.beyond(y) {
                    // A triangle that points towards the value.
                    beyond if beyond > 0.0 => shapes.push_str(&format!("M{at:.1} {:.1}l5 9h-10z", up - 6.0)),
                    beyond if beyond < 0.0 => shapes.push_str(&format!("M{at:.1} {:.1}l5-9h-10z", up + 6.0)),
                    _ if self.is_sparing => {
                        let _ = write!(dots, "M{at:.1} {up:.1}h0");
                    }
                    _ => shapes.push_str(&marker(number, at, up)),
                }
            }),
            Shape::Line => {
                for (k, (x, y)) in points().enumerate() {
                    let _ = write!(lines, "{}{:.1} {:.1}", if k == 0 { 'M' } else { 'L' }, frame.x(x), frame.y(y));
                }
            }
        }
        for (&(x, y), &error) in series.points.iter().zip(&series.errors) {
            if x.is_finite() && y.is_finite() && error.is_finite() && error > 0.0 {
                let (x, low, high) = (frame.x(x), frame.y(y - error), frame.y(y + error));
                let left = x - 3.0;
                let _ = write!(lines, "M{left:.1} {low:.1}h6M{left:.1} {high:.1}h6M{x:.1} {low:.1}V{high:.1}");
            }
        }
        [shapes, lines, dots]
    }
}

impl Picture for Chart {
    fn title(&self) -> &str {
        &self.title
    }

    fn height(&self) -> f64 {
        300.0
    }

    fn inside(&self, out: &mut Markup) {
        let frame = self.frame();
        frame.draw(out, &self.title, &self.across, &self.up);
        for level in &self.levels {
            let y = frame.y(level.value);
            let [left, right] = frame.across.ends().map(|end| frame.x(end));
            let path = format!("M{left:.1} {y:.1}H{right:.1}");
            out.empty(
                "path",
                &[
                    ("class", &"axis"),
                    ("stroke", &"#59636e"),
                    ("stroke-dasharray", &"5 4"),
                    ("fill", &"none"),
                    ("d", &path),
                ],
            );
            frame.beside(out, level.value, &level.label);
        }
        let count: usize = self.series.iter().map(|series| series.points.len()).sum();
        let most = if self.is_sparing { SPARING } else { MOST_POINTS };
        for (number, series) in self.series.iter().enumerate() {
            // A line of few points stays a line, even with many points of other series.
            let is_line = series.shape == Shape::Line && series.points.len() <= MOST_POINTS;
            let is_dense = count > most && !is_line;
            let [shapes, lines, dots] = self.paths(number, series, &frame, is_dense);
            let (class, fallback) = color(series.like.unwrap_or(number));
            if series.like.is_some() && !lines.is_empty() {
                let halo: &str = "halo";
                let attributes: crate::markup::Attributes<'_> = &[
                    ("class", &halo),
                    ("stroke", &"#fff"),
                    ("stroke-width", &"5.5"),
                    ("stroke-linejoin", &"round"),
                    ("fill", &"none"),
                    ("d", &lines),
                ];
                out.empty("path", attributes);
            }
            out.element("g", &[("class", &class), ("fill", &fallback), ("stroke", &fallback)], |out| {
                if !shapes.is_empty() {
                    out.empty("path", &[("stroke", &"none"), ("fill-opacity", &"0.75"), ("d", &shapes)]);
                }
                if !dots.is_empty() {
                    // A dot is a line without length: only its caps are visible.
                    let cap = if number.is_multiple_of(2) { "round" } else { "square" };
                    out.empty(
                        "path",
                        &[
                            ("fill", &"none"),
                            ("stroke-width", &"3.6"),
                            ("stroke-opacity", &"0.7"),
                            ("stroke-linecap", &cap),
                            ("d", &dots),
                        ],
                    );
                }
                if !lines.is_empty() {
                    let dash = if is_line && series.like.is_none() { dash(number) } else { "none" };
                    let [width, opacity] = match series.like {
                        Some(_) => ["2.6", "1"],
                        None if is_dense => ["1.25", "0.6"],
                        None => ["1.4", "1"],
                    };
                    out.empty(
                        "path",
                        &[
                            ("fill", &"none"),
                            ("stroke-width", &width),
                            ("stroke-opacity", &opacity),
                            ("stroke-dasharray", &dash),
                            ("d", &lines),
                        ],
                    );
                }
            });
        }
        let all = self.series.iter().flat_map(|series| &series.points);
        let beyond = all.filter(|point| point.1.is_finite() && frame.beyond(point.1) != 0.0).count();
        if beyond > 0 {
            text(out, [WIDTH - 16.0, 18.0], "end", &format!("{beyond} outside the picture"));
        }
        let labels: Vec<&str> = self.series.iter().map(|series| series.label.as_str()).collect();
        legend(out, &labels, |out, number, [x, y]| match self.series.get(number).map(|series| series.shape) {
            Some(Shape::Line) => {
                let path = format!("M{:.1} {y:.1}h16", x - 8.0);
                out.empty("path", &[("stroke-width", &"2"), ("stroke-dasharray", &dash(number)), ("d", &path)]);
            }
            _ => out.empty("path", &[("stroke", &"none"), ("d", &marker(number, x, y))]),
        });
    }
}

/// Returns a marker as part of a path: circle, square, triangle, diamond, vertical and horizontal bar.
fn marker(number: usize, x: f64, y: f64) -> String {
    let (s, d) = (HALF, 2.0 * HALF);
    match number % 6 {
        0 => format!("M{:.1} {y:.1}a{s} {s} 0 1 0 {d} 0a{s} {s} 0 1 0 -{d} 0", x - s),
        1 => format!("M{:.1} {:.1}h{d}v{d}h-{d}z", x - s, y - s),
        2 => format!("M{x:.1} {:.1}l3 5h-6z", y - 3.0),
        3 => format!("M{x:.1} {:.1}l3 3l-3 3l-3-3z", y - 3.0),
        4 => format!("M{:.1} {:.1}h2v6h-2z", x - 1.0, y - 3.0),
        _ => format!("M{:.1} {:.1}h6v2h-6z", x - 3.0, y - 1.0),
    }
}
