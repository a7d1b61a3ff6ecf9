//! Text about an import for a person: the preview of readings, and the list of formats.

use std::fmt::Write as _;

use crate::answers::OPTIONS;
use crate::format::InstrumentFormats;
use crate::readings::ImportedReadings;

/// Rows of the table in a preview.
const PREVIEW_ROWS: usize = 6;

/// Returns what was understood, the first rows, and the sentence that a person can check.
#[must_use]
pub fn preview(readings: &ImportedReadings) -> String {
    let mut out = format!("{} readings, kind {}\n", readings.rows.len(), readings.kind.name());
    for note in &readings.notes {
        // Writing into a String cannot fail.
        let _ = writeln!(out, "  {note}");
    }
    let table = readings.table();
    for line in table.lines().take(PREVIEW_ROWS + 1) {
        let _ = writeln!(out, "    {line}");
    }
    if readings.rows.len() > PREVIEW_ROWS {
        let _ = writeln!(out, "    … {} more rows", readings.rows.len() - PREVIEW_ROWS);
    }
    let _ = writeln!(out, "check: {}", readings.sign_sentence);
    out
}

/// Returns the list of formats, each with the options that its files usually need.
#[must_use]
pub fn list(formats: &InstrumentFormats) -> String {
    let mut out = String::new();
    for format in formats.iter() {
        let needs: Vec<String> = format.needs.split_whitespace().map(|name| format!("--{name}")).collect();
        let _ = writeln!(out, "{}\n  {}\n  to be stated: {}", format.name, format.title, needs.join(" "));
    }
    out.push_str("\noptions:\n");
    for option in OPTIONS {
        let _ = writeln!(out, "  {:<24}{}", format!("--{} {}", option.name, option.example), option.meaning);
    }
    out.push_str("  --flat-reference        A height map was probed on a calibrated flat\n");
    out
}
