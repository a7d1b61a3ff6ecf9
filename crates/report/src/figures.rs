//! Results of the acceptance tests: table for people and the JSON object.

use std::fmt::Write as _;

use serde::Serialize;

use super::correction::push_row;
use super::json::DiagnosticReport;
use super::number::significant;
use ncfix_metrology::results::features::FeatureDeviation;
use ncfix_metrology::results::figures::MeasurementFigures;

/// Output of `ncfix iso230`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FiguresReport {
    /// Measurements, in the order in which they were given.
    pub measurements: Vec<MeasurementFigures>,
    /// Name of the machine.
    pub machine: String,
    /// Diagnostics in order of occurrence.
    pub diagnostics: Vec<DiagnosticReport>,
}

impl FiguresReport {
    /// Returns the table for people, with a line feed after every line.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = lines(&self.measurements);
        for one in self.measurements.iter().filter(|one| one.figures.is_empty()) {
            push_row(
                &mut out,
                "no figures",
                &format!("{}: ncfix calculates none for its kind, {}", one.name, one.kind),
            );
        }
        push_row(&mut out, "machine", &self.machine);
        out
    }
}

/// Returns the lines of all measurements that have figures, with an empty line after each.
#[must_use]
pub fn lines(measurements: &[MeasurementFigures]) -> String {
    let mut out = String::new();
    for one in measurements.iter().filter(|one| !one.figures.is_empty()) {
        // Writing into a String cannot fail.
        let _ = writeln!(out, "{}", one.name);
        for group in &one.figures {
            let setup = if group.setup.is_empty() { String::new() } else { format!(", set-up {}", group.setup) };
            let _ = write!(out, "  {}{setup}", group.of);
            if let Some(reason) = &group.reason {
                let _ = writeln!(out, ": {reason}");
                continue;
            }
            let conditions = group.conditions.join(", ");
            let _ = writeln!(out, " ({}, {}; {conditions})", group.standard.name(), group.unit);
            for values in group.values.chunks(6) {
                let cells = values.iter().map(|value| format!("{} {}", value.name, significant(value.value)));
                let _ = writeln!(out, "    {}", cells.collect::<Vec<_>>().join("   "));
            }
        }
        out.extend(one.features.iter().map(feature));
        out.push('\n');
    }
    out
}

/// The line of a feature: its deviations, and what the errors of the machine file leave of them.
fn feature(one: &FeatureDeviation) -> String {
    let cells = |values: &[Option<f64>; 3]| {
        let read = ["dx", "dy", "dz"].iter().zip(values).filter_map(|(name, value)| Some((name, (*value)?)));
        read.map(|(name, value)| format!("{name} {}", significant(value))).collect::<Vec<_>>().join("   ")
    };
    let left = if one.left == one.deviation { String::new() } else { format!("   left {}", cells(&one.left)) };
    format!("    {}   {}{left}\n", one.feature, cells(&one.deviation))
}
