//! Residual over step as a picture: both axes logarithmic with units, limit and answer as lines.

use std::fmt::Write as _;

use super::markup::Markup;
use super::plot::{Picture, WIDTH};
use super::steps::{StepReport, decimal, rounded_down};

/// Height of the picture and its margins, in the units of its width.
const HEIGHT: f64 = 380.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 44.0;
const BOTTOM: f64 = 56.0;
/// Distance of the baseline of a text below its middle.
const HALF_LETTER: f64 = 5.0;

/// Picture of a result. If there is nothing to draw, it says so.
#[derive(Clone, Copy, Debug)]
pub struct Residual<'a>(pub &'a StepReport);

impl Picture for Residual<'_> {
    fn title(&self) -> &'static str {
        "Residual over step"
    }

    fn height(&self) -> f64 {
        HEIGHT
    }

    fn inside(&self, out: &mut Markup) {
        let Residual(report) = self;
        text(out, [LEFT, TOP - 18.0], "start", &format!("{}, {}", self.title(), report.machine));
        let Some((across, up)) = report.scales() else {
            text(out, [WIDTH / 2.0, HEIGHT / 2.0], "middle", "no residual at any step");
            return;
        };
        let x = |step: f64| LEFT + across.share(step) * (WIDTH - LEFT - RIGHT);
        let y = |um: f64| HEIGHT - BOTTOM - up.share(um) * (HEIGHT - TOP - BOTTOM);
        let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
        let mut grid = String::new();
        for step in across.marks() {
            // Writing into a String cannot fail.
            let _ = write!(grid, "M{:.1} {TOP}V{bottom}", x(step));
            text(out, [x(step), bottom + 20.0], "middle", &decimal(step));
        }
        for um in up.decades() {
            let _ = write!(grid, "M{LEFT} {:.1}H{right}", y(um));
            text(out, [LEFT - 8.0, y(um) + HALF_LETTER], "end", &decimal(um));
        }
        path(out, &grid, ["grid", "#dde2e7", "none"]);
        path(out, &format!("M{LEFT} {TOP}V{bottom}H{right}"), ["axis", "#59636e", "none"]);
        text(out, [f64::midpoint(LEFT, right), HEIGHT - 12.0], "middle", "step in mm");
        let place = format!("translate(20 {:.1}) rotate(-90)", f64::midpoint(TOP, bottom));
        out.leaf("text", &[("transform", &place), ("text-anchor", &"middle")], "residual in µm");
        let limit = report.residual_limit_um;
        let mut levels = format!("M{LEFT} {:.1}H{right}", y(limit));
        text(out, [LEFT + 6.0, y(limit) - 5.0], "start", &format!("limit {} µm", decimal(limit)));
        if let Some(step) = report.largest_step_mm {
            let _ = write!(levels, "M{:.1} {:.1}V{bottom}", x(step), y(limit));
            text(out, [x(step) - 6.0, bottom - 8.0], "end", &format!("{} mm", rounded_down(step)));
        }
        path(out, &levels, ["axis", "#59636e", "6 4"]);
        let all = report.steps.iter().filter(|row| row.largest_um > 0.0);
        let line: String = all.map(|row| format!("L{:.1} {:.1}", x(row.step_mm), y(row.largest_um))).collect();
        out.element("g", &[("class", &"s0"), ("stroke", &"#0072b2"), ("fill", &"#0072b2")], |out| {
            let line = line.replacen('L', "M", 1);
            let attributes = [("style", "fill:none"), ("stroke-width", "2"), ("d", line.as_str())];
            let [a, b, c] = &attributes;
            out.empty("path", &[(a.0, &a.1), (b.0, &b.1), (c.0, &c.1)]);
            for row in report.steps.iter().filter(|row| row.residual_um > 0.0) {
                let [x, y] = [x(row.step_mm), y(row.residual_um)].map(|value| format!("{value:.1}"));
                out.empty("circle", &[("cx", &x), ("cy", &y), ("r", &3)]);
            }
        });
    }
}

fn path(out: &mut Markup, d: &str, [class, color, dashes]: [&str; 3]) {
    out.empty(
        "path",
        &[("class", &class), ("stroke", &color), ("stroke-dasharray", &dashes), ("fill", &"none"), ("d", &d)],
    );
}

fn text(out: &mut Markup, [x, y]: [f64; 2], anchor: &str, text: &str) {
    out.leaf("text", &[("x", &format_args!("{x:.1}")), ("y", &format_args!("{y:.1}")), ("text-anchor", &anchor)], text);
}
