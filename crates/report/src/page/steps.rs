//! Page about steps: permitted length of the pieces of a move, and the resulting residual.

use super::parts::{MOST_ROWS, diagnostics, origin};
use super::{PageRow, columns, figure, page, pictures, strip, table};
use crate::inputs::InputFile;
use crate::number::micrometers;
use crate::residual::Residual;
use crate::steps::{StepReport, three_digits};

/// Returns the page with its input files.
#[must_use]
pub fn steps(report: &StepReport, inputs: &[InputFile]) -> String {
    page(&format!("Steps on {}", report.machine), |out| {
        let entries = report.entries();
        out.leaf("p", &[("class", &"banner")], format_args!("Largest step: {}", report.answer_text()));
        strip(out, &entries);
        diagnostics(out, &report.diagnostics);
        pictures(out, |out| {
            let caption = "Dots: the largest residual of pieces of that length; line: of pieces up to that length.";
            figure(out, &Residual(report), caption);
        });
        let rows: Vec<PageRow> = report
            .steps
            .iter()
            .map(|row| {
                let class = if row.largest_um > report.residual_limit_um { "bad" } else { "" };
                let [residual, largest] = [row.residual_um, row.largest_um].map(micrometers);
                PageRow { class, cells: vec![format!("{} mm", three_digits(row.step_mm)), residual, largest] }
            })
            .collect();
        let titles = columns(["#step", "#residual", "#including all smaller steps"]);
        table(out, &titles, &rows, "The residual is the distance of the tool tip from the straight line.", MOST_ROWS);
        origin(out, inputs, &format!("ncfix {}, machine {}", env!("CARGO_PKG_VERSION"), report.machine));
    })
}
