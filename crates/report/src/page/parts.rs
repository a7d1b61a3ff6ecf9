//! Parts that pages share: diagnostics of the files, and the input files of a result.

use super::{PageRow, columns, table};
use crate::inputs::InputFile;
use crate::json::DiagnosticReport;
use crate::markup::Markup;

/// Maximum number of rows of a table: more are not read, and a page must not grow without bound.
pub(super) const MOST_ROWS: usize = 500;

/// Writes the diagnostics of the files, with advice.
pub(super) fn diagnostics(out: &mut Markup, all: &[DiagnosticReport]) {
    if all.is_empty() {
        return;
    }
    out.leaf("h2", &[], "Findings");
    out.element("ul", &[("class", &"findings")], |out| {
        for finding in all.iter().take(MOST_ROWS) {
            out.element("li", &[("class", &finding.severity)], |out| {
                out.element("p", &[], |out| {
                    out.leaf("b", &[], format_args!("{} {}:", finding.severity, finding.code));
                    out.text(&finding.message);
                });
                out.element("p", &[("class", &"soft")], |out| {
                    if let (Some(file), Some(line)) = (&finding.file, finding.line) {
                        let column = finding.column.map_or(String::new(), |column| format!(":{column}"));
                        out.leaf("code", &[], format_args!("{file}:{line}{column}"));
                        out.text(" – ");
                    }
                    out.text(&finding.help);
                });
            });
        }
    });
    if all.len() > MOST_ROWS {
        out.leaf("p", &[("class", &"soft")], format_args!("{} more diagnostics are not shown.", all.len() - MOST_ROWS));
    }
}

/// Writes the input files of the result; `by` names what produced it.
pub(super) fn origin(out: &mut Markup, inputs: &[InputFile], by: &str) {
    const NOTE: &str = "Hash: first 12 digits of the SHA-256 of the length of the file (8 bytes, the lowest first) and its bytes, as in the head of a \
                        machine file.";
    out.leaf("h2", &[], "Sources");
    let rows: Vec<PageRow> = inputs
        .iter()
        .map(|input| PageRow { class: "", cells: vec![input.file.clone(), input.role.into(), input.hash.clone()] })
        .collect();
    table(out, &columns(["file", "what", "hash"]), &rows, NOTE, MOST_ROWS);
    out.leaf("p", &[("class", &"soft")], by);
}
