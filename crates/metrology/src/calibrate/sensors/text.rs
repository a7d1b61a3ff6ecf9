//! The selection as `[[drift]]` entries of a machine file, with its quality as comments.

use std::fmt::Write as _;

use super::select::SensorSelection;

/// The entries; directions and positions without a model have a comment.
#[must_use]
pub fn entries(selections: &[SensorSelection]) -> String {
    let mut out = String::new();
    for selection in selections {
        let letter = ["X", "Y", "Z"].get(selection.direction).copied().unwrap_or("Z");
        let place = selection.at.map_or(String::new(), |(axis, at)| format!(" at {axis} {at}"));
        let Some(model) = selection.model() else {
            let drift_um = selection.drift_um;
            // Writing into a String cannot fail.
            let _ = writeln!(out, "# {letter}{place}: no sensors predict the drift of {drift_um:.1} µm (RMS).\n");
            continue;
        };
        let _ = writeln!(
            out,
            "# {letter}{place}: efficiency {:.1} % on {} readings, {:.1} % on independent readings, residual {:.1} of {:.1} µm (RMS).",
            100.0 * model.efficiency,
            selection.rows,
            100.0 * model.independent,
            model.left_um,
            selection.drift_um
        );
        for term in model.terms.iter().filter(|term| !term.alike.is_empty()) {
            let _ = writeln!(out, "# Instead of {}: {}.", clean(&term.sensor), clean(&term.alike.join(", ")));
        }
        let _ = writeln!(out, "[[drift]]\ndirection = \"{letter}\"");
        if let Some((axis, at)) = selection.at {
            let unit = if axis.is_rotary() { "deg" } else { "mm" };
            let _ = writeln!(out, "over = \"{axis}\"\nat_{unit} = {at}");
        }
        out.push_str("sensors = [\n");
        for term in &model.terms {
            let lag = if term.lag_s > 0.0 { format!(", lag_s = {}", term.lag_s) } else { String::new() };
            let _ = writeln!(out, "    {{ name = {}, um_per_K = {:.5}{lag} }},", quoted(&term.sensor), term.um_per_k);
        }
        out.push_str("]\n\n");
    }
    out
}

/// A comment ends with its line.
fn clean(text: &str) -> String {
    text.replace(char::is_control, " ")
}

/// A string of TOML.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for character in text.chars() {
        match character {
            '"' | '\\' => out.extend(['\\', character]),
            control if control.is_control() => {
                let _ = write!(out, "\\u{:04X}", u32::from(control));
            }
            other => out.push(other),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::super::select::{SensorTerm, SubsetSize};
    use super::*;

    #[test]
    fn sensors_that_may_stand_for_another_one_are_a_comment_of_one_line() {
        let alike = vec!["nose\nof the spindle".into(), "column".into()];
        let term = SensorTerm { sensor: "bearing".into(), um_per_k: -1.5, lag_s: 0.0, alike };
        let size =
            SubsetSize { terms: vec![term], cp: None, efficiency: 0.9, independent: 0.8, left_um: 2.0, is_exact: true };
        let one =
            SensorSelection { direction: 2, at: None, rows: 90, drift_um: 10.0, sizes: vec![size], chosen: Some(0) };
        let text = entries(&[one]);
        assert!(text.contains("\n# Instead of bearing: nose of the spindle, column.\n[[drift]]\n"), "{text}");
        assert!(text.contains("    { name = \"bearing\", um_per_K = -1.50000 },\n"), "{text}");
    }
}
