//! Growth of a program by its correction.

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::number::grouped;
use ncfix_base::source::Source;
use ncfix_path::emit;
use ncfix_report::correction::CorrectionReport;

/// Notes the growth in the report; the diagnostic if it exceeds the largest one.
pub(super) fn check(source: &Source, largest: Option<f64>, report: &mut CorrectionReport) -> Option<Diagnostic> {
    let lines = emit::lines_with_words(source.bytes());
    report.growth = emit::growth(lines, report.blocks_out);
    let largest = largest.filter(|largest| report.growth > *largest)?;
    let message = format!(
        "the output would have {} blocks, {:.1} times the {} blocks of the original; --max-growth allows {largest}x",
        grouped(report.blocks_out),
        report.growth,
        grouped(lines),
    );
    let help = "nothing was written; allow more, or a larger --tolerance; loops, subprograms and milling cycles are written as moves";
    Some(Diagnostic::nowhere(Code::GROWS_TOO_MUCH, message, help))
}
