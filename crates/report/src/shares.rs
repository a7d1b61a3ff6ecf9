//! What `ncfix machine show --at` prints: what each source of error does at one pose.

use std::fmt::Write as _;

use serde::Serialize;

use super::json::Finding;
use ncfix_model::shares::{AxisUnit, AxisValue, Deviation, ErrorShares};

/// Errors at a pose, and findings about the files that say them.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Shares {
    /// What was found.
    #[serde(flatten)]
    pub found: ErrorShares,
    /// Findings about the files.
    pub diagnostics: Vec<Finding>,
}

impl Shares {
    /// The table for people.
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

/// Two decimals, without a minus before nothing.
fn fixed(value: f64) -> String {
    let text = format!("{value:.2}");
    if text == "-0.00" { "0.00".into() } else { text }
}

/// Up to so many decimals, trailing zeros dropped.
fn plain(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.to_owned() }
}
