//! Output of `ncfix machine show --at`: the contribution of each error source at one pose.

use std::fmt::Write as _;

use serde::Serialize;

use super::json::DiagnosticReport;
use ncfix_model::shares::{AxisUnit, AxisValue, Deviation, ErrorShares};

/// Errors at a pose, with the diagnostics of the files from which they come.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Shares {
    /// Result.
    #[serde(flatten)]
    pub found: ErrorShares,
    /// Diagnostics of the files.
    pub diagnostics: Vec<DiagnosticReport>,
}

impl Shares {
    /// Returns the table for people.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        // Writing into a String cannot fail.
        let mut line = |text: String| {
            let _ = writeln!(out, "{}", text.trim_end());
        };
        let listed = |values: &[AxisValue], digits: usize| -> String {
            let parts = values.iter().map(|AxisValue { axis, unit, value }| {
                let unit = match unit {
                    AxisUnit::Micrometer => " µm",
                    AxisUnit::Microradian => " µrad",
                    AxisUnit::Degree => "°",
                    AxisUnit::Millimeter => "",
                };
                format!("{axis} {}{unit}", plain(*value, digits))
            });
            parts.collect::<Vec<_>>().join(", ")
        };
        let [x, y, z] = self.found.tool_mm.map(|part| plain(part, 4));
        line(format!("at          {}; tool {x} {y} {z} mm", listed(&self.found.at, 4)));
        line(String::new());
        line(format!(
            "{:<26}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}",
            "", "dX", "dY", "dZ", "distance", "rot. X", "rot. Y", "rot. Z"
        ));
        line(format!(
            "{:<26}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}",
            "source", "µm", "µm", "µm", "µm", "µrad", "µrad", "µrad"
        ));
        let row = |name: &str, deviation: &Deviation| {
            let [x, y, z] = deviation.position_um;
            let [a, b, c] = deviation.rotation_urad;
            let numbers = [x, y, z, deviation.distance_um(), a, b, c].map(|value| format!("{:>9}", fixed(value)));
            format!("{name:<26}{}", numbers.concat())
        };
        for share in &self.found.sources {
            line(row(share.source, &share.deviation));
            for (label, deviation) in &share.components {
                line(row(&format!("  {label}"), deviation));
            }
        }
        line(row("sum", &self.found.sum));
        line(String::new());
        if self.found.correction.is_empty() {
            line("correction  none was found".into());
        } else {
            line(format!("correction  {}", listed(&self.found.correction, 2)));
        }
        out
    }
}

/// Formats two decimals, without a minus sign before zero.
fn fixed(value: f64) -> String {
    let text = format!("{value:.2}");
    if text == "-0.00" { "0.00".into() } else { text }
}

/// Formats a value with up to `digits` decimals, without trailing zeros.
fn plain(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.to_owned() }
}
