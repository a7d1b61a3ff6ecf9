//! Residual over step as a drawing (SVG): both axes logarithmic with units, the limit and the answer as lines.

use std::fmt::Write as _;

use super::markup::escaped;
use super::steps::{StepReport, decimal, rounded_down};

/// Size of the drawing and its margins, in its own units.
const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 440.0;
const LEFT: f64 = 80.0;
const RIGHT: f64 = 24.0;
const TOP: f64 = 44.0;
const BOTTOM: f64 = 60.0;
/// How high a line of text stands above its middle.
const HALF_LETTER: f64 = 4.0;

/// The drawing of a result. Where there is nothing to draw it says so.
#[must_use]
pub fn steps(report: &StepReport) -> String {
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"sans-serif\" font-size=\"12\" fill=\"#222\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
    );
    let title = format!("Residual over step, {}", report.machine);
    text(&mut out, LEFT, TOP - 20.0, "start", &title);
    match report.scales() {
        None => text(&mut out, WIDTH / 2.0, HEIGHT / 2.0, "middle", "no residual at any step"),
        Some((across, up)) => {
            let x = |step: f64| LEFT + across.share(step) * (WIDTH - LEFT - RIGHT);
            let y = |um: f64| HEIGHT - BOTTOM - up.share(um) * (HEIGHT - TOP - BOTTOM);
            let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
            for step in across.marks() {
                line(&mut out, [x(step), TOP, x(step), bottom], "#ddd", "");
                text(&mut out, x(step), bottom + 18.0, "middle", &decimal(step));
            }
            for um in up.decades() {
                line(&mut out, [LEFT, y(um), right, y(um)], "#ddd", "");
                text(&mut out, LEFT - 8.0, y(um) + HALF_LETTER, "end", &decimal(um));
            }
            line(&mut out, [LEFT, bottom, right, bottom], "#222", "");
            line(&mut out, [LEFT, TOP, LEFT, bottom], "#222", "");
            text(&mut out, f64::midpoint(LEFT, right), HEIGHT - 14.0, "middle", "step in mm");
            let middle = f64::midpoint(TOP, bottom);
            let _ = writeln!(
                out,
                "<text transform=\"translate(22 {middle}) rotate(-90)\" text-anchor=\"middle\">residual in µm</text>"
            );
            let limit = report.residual_limit_um;
            line(&mut out, [LEFT, y(limit), right, y(limit)], "#c0392b", " stroke-dasharray=\"6 4\"");
            text(&mut out, LEFT + 6.0, y(limit) - 5.0, "start", &format!("limit {} µm", decimal(limit)));
            if let Some(step) = report.largest_step_mm {
                line(&mut out, [x(step), y(limit), x(step), bottom], "#c0392b", " stroke-dasharray=\"6 4\"");
                text(&mut out, x(step) - 6.0, bottom - 8.0, "end", &format!("{} mm", rounded_down(step)));
            }
            let points: Vec<String> = report
                .steps
                .iter()
                .filter(|row| row.largest_um > 0.0)
                .map(|row| format!("{:.1},{:.1}", x(row.step_mm), y(row.largest_um)))
                .collect();
            let _ = writeln!(
                out,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"#1f5fa8\" stroke-width=\"2\"/>",
                points.join(" ")
            );
            for row in report.steps.iter().filter(|row| row.residual_um > 0.0) {
                let (x, y) = (x(row.step_mm), y(row.residual_um));
                let _ = writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"#1f5fa8\"/>");
            }
        }
    }
    out.push_str("</svg>\n");
    out
}

fn line(out: &mut String, [x1, y1, x2, y2]: [f64; 4], color: &str, more: &str) {
    // Writing into a String cannot fail.
    let _ = writeln!(out, "<path d=\"M{x1:.1} {y1:.1} L{x2:.1} {y2:.1}\" stroke=\"{color}\" fill=\"none\"{more}/>");
}

fn text(out: &mut String, x: f64, y: f64, anchor: &str, text: &str) {
    let _ = writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>", escaped(text));
}
