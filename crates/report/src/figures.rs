//! Figures of the acceptance tests: the table for people and the object for programs.

use std::fmt::Write as _;

use serde::Serialize;

use super::correction::push_row;
use super::json::Finding;
use super::number::significant;

/// The result of `ncfix figures`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Measurements, in the order in which they were given.
    pub measurements: Vec<Measurement>,
    /// Name of the machine.
    pub machine: String,
    /// Findings in the order in which they were met.
    pub diagnostics: Vec<Finding>,
}

/// The figures of a measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Measurement {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// Its figures.
    pub figures: Vec<Group>,
}

/// Figures that belong together: of a component, of circles in a plane, of a sphere.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Group {
    /// Label of the set-up.
    pub setup: String,
    /// What they are of: `EXX`, `XY`, `sphere`.
    pub of: String,
    /// Where they are defined: `ISO 230-2`, `ISO 230-4`, `least squares`.
    pub standard: &'static str,
    /// The unit of all: `µm` or `µrad`.
    pub unit: &'static str,
    /// The figures in the order of the standard.
    pub values: Vec<Value>,
    /// Under which conditions: runs, radius, feed, start.
    pub conditions: Vec<String>,
    /// Why there are none; `null` where there are.
    pub reason: Option<String>,
}

/// A figure.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Value {
    /// `A`, `R+`, `G(ccw)` …
    pub name: &'static str,
    /// Its value.
    pub value: f64,
}

impl Figures {
    /// The table for people, with a line feed behind every line.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = lines(&self.measurements);
        push_row(&mut out, "machine", &self.machine);
        out
    }
}

/// The lines of all measurements that have figures, an empty one behind each.
#[must_use]
pub fn lines(measurements: &[Measurement]) -> String {
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
            let _ = writeln!(out, " ({}, {}; {conditions})", group.standard, group.unit);
            for values in group.values.chunks(6) {
                let cells = values.iter().map(|value| format!("{} {}", value.name, significant(value.value)));
                let _ = writeln!(out, "    {}", cells.collect::<Vec<_>>().join("   "));
            }
        }
        out.push('\n');
    }
    out
}
