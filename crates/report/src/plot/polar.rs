//! Ball-bar traces about the nominal circle, with magnified deviations.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::decimate::spans;
use super::frame::{heading, legend, text};
use super::ticks::round_step;
use super::{Picture, WIDTH, color, dash};
use crate::markup::Markup;

/// Height of the picture, and center and radius of the nominal circle.
const HEIGHT: f64 = 470.0;
const CENTER: [f64; 2] = [WIDTH / 2.0, 260.0];
const RADIUS: f64 = 130.0;
/// Number of divisions up to the edge.
const DIVISIONS: f64 = 4.0;
/// Length of a division.
const DIVISION: f64 = 15.0;
/// Number of directions that a picture can resolve.
const DIRECTIONS: usize = 720;

/// Polar chart of traces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polar {
    /// Title.
    pub title: String,
    /// Names of the directions at angle 0 and at 90°.
    pub axes: [String; 2],
    /// Unit of the deviations.
    pub unit: String,
    /// Nominal radius, mm, for the magnification.
    pub radius_mm: f64,
    /// Traces.
    pub traces: Vec<PolarTrace>,
}

/// Trace.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolarTrace {
    /// Name.
    pub label: String,
    /// Angles, rad, and deviations of the radius, µm, in order of time.
    pub points: Vec<(f64, f64)>,
}

impl Polar {
    /// Returns the size of a division.
    #[must_use]
    pub fn division(&self) -> f64 {
        let points = self.traces.iter().flat_map(|trace| &trace.points);
        let most = points.filter(|point| point.1.is_finite()).fold(0.0_f64, |most, point| most.max(point.1.abs()));
        round_step(most / DIVISIONS)
    }
}

impl Picture for Polar {
    fn title(&self) -> &str {
        &self.title
    }

    fn height(&self) -> f64 {
        HEIGHT
    }

    fn inside(&self, out: &mut Markup) {
        let division = self.division();
        let [x, y] = CENTER;
        let place = |angle: f64, deviation: f64| {
            let radius = RADIUS + (deviation / division).clamp(-DIVISIONS, DIVISIONS) * DIVISION;
            let (sin, cos) = angle.sin_cos();
            [x + radius * cos, y - radius * sin]
        };
        heading(out, &self.title);
        let reach = RADIUS + DIVISIONS * DIVISION;
        out.element("g", &[("class", &"grid"), ("stroke", &"#dde2e7"), ("fill", &"none")], |out| {
            for k in [-4, -2, 2, 4] {
                circle(out, RADIUS + f64::from(k) * DIVISION);
            }
            let cross = format!("M{:.1} {y}H{:.1}M{x} {:.1}V{:.1}", x - reach, x + reach, y - reach, y + reach);
            out.empty("path", &[("d", &cross)]);
        });
        out.element("g", &[("class", &"axis"), ("stroke", &"#59636e"), ("fill", &"none")], |out| circle(out, RADIUS));
        for (axis, at, anchor) in [(0, [x + reach + 8.0, y + 4.0], "start"), (1, [x, y - reach - 6.0], "middle")] {
            text(out, at, anchor, self.axes.get(axis).map_or("", String::as_str));
        }
        for k in [-4.0, -2.0, 0.0, 2.0, 4.0] {
            let [at, up] = place(TAU / 8.0, k * division);
            let label = format!("{}{}", if k > 0.0 { "+" } else { "" }, short(k * division));
            text(out, [at + 2.0, up + 4.0], "middle", &label.replace('-', "\u{2212}"));
        }
        for (number, trace) in self.traces.iter().enumerate() {
            let (class, fallback) = color(number);
            let path = path(&trace.points, place);
            out.element("g", &[("class", &class), ("stroke", &fallback), ("fill", &fallback)], |out| {
                out.empty(
                    "path",
                    &[("fill", &"none"), ("stroke-width", &"1.6"), ("stroke-dasharray", &dash(number)), ("d", &path)],
                );
            });
        }
        let labels: Vec<&str> = self.traces.iter().map(|trace| trace.label.as_str()).collect();
        legend(out, &labels, |out, number, [x, y]| {
            let path = format!("M{:.1} {y:.1}h16", x - 8.0);
            out.empty("path", &[("stroke-width", &"2"), ("stroke-dasharray", &dash(number)), ("d", &path)]);
        });
        let times = self.radius_mm * 1000.0 / RADIUS * DIVISION / division;
        let note = if times.is_finite() && times > 1.0 {
            format!(
                "1 division = {} {}, exaggerated {times:.0} times; bold circle: nominal",
                short(division),
                self.unit
            )
        } else {
            format!("1 division = {} {}; bold circle: nominal", short(division), self.unit)
        };
        text(out, [10.0, HEIGHT - 8.0], "start", &note);
    }
}

fn short(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) { format!("{value}") } else { format!("{value:.0e}") }
}

fn circle(out: &mut Markup, radius: f64) {
    let [x, y] = CENTER;
    out.empty("circle", &[("cx", &x), ("cy", &y), ("r", &radius)]);
}

/// Returns the path of a trace. A trace with many points is reduced to its extremes in every direction.
fn path(points: &[(f64, f64)], place: impl Fn(f64, f64) -> [f64; 2]) -> String {
    let mut out = String::new();
    let mut add = |angle: f64, deviation: f64, is_first: bool| {
        let [x, y] = place(angle, deviation);
        let _ = write!(out, "{}{x:.1} {y:.1}", if is_first { 'M' } else { 'L' });
    };
    let known = points.iter().filter(|point| point.0.is_finite() && point.1.is_finite());
    if points.len() <= 2 * DIRECTIONS {
        known.enumerate().for_each(|(k, point)| add(point.0, point.1, k == 0));
        return out;
    }
    let turned = known.map(|point| (point.0.rem_euclid(TAU) / TAU, point.1));
    let mut is_first = true;
    for (direction, span) in spans(turned, DIRECTIONS).into_iter().enumerate() {
        let Some(span) = span else {
            is_first = true;
            continue;
        };
        let angle = TAU * (direction as f64 + 0.5) / DIRECTIONS as f64;
        add(angle, span.low, is_first);
        add(angle, span.high, false);
        is_first = false;
    }
    out
}
