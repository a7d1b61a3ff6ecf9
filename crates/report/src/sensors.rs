//! Result of a sensor selection: tables, plots in the terminal and the JSON object.

use std::fmt::Write as _;

use serde::Serialize;

use super::json::DiagnosticReport;
use super::number::significant;
use ncfix_metrology::results::sensors::{SensorChoice, SensorSubset, SensorsResult};

/// Number of rows of a plot.
const HEIGHT: usize = 8;
/// Width of a number of sensors in columns.
const STEP: usize = 4;

/// Output of `ncfix sensors`: the result, with its output file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorReport {
    /// Result.
    #[serde(flatten)]
    pub found: SensorsResult,
    /// File that was written; `null` if there is none.
    pub output: Option<String>,
    /// Name of the machine.
    pub machine: String,
    /// Diagnostics in order of occurrence.
    pub diagnostics: Vec<DiagnosticReport>,
}

impl SensorReport {
    /// Returns the page for people.
    #[must_use]
    pub fn page(&self) -> String {
        let mut out = String::new();
        for selection in &self.found.selections {
            out.push_str(&selection_page(selection));
        }
        let mut row = |name: &str, text: &str| {
            // Writing into a String cannot fail.
            let _ = writeln!(out, "{name:<13}{text}");
        };
        match &self.found.independent {
            Some(runs) => row("independent", &runs.join(", ")),
            None => row("independent", "the last third of every run, held out"),
        }
        if self.found.selections.iter().flat_map(|selection| &selection.sizes).any(|size| !size.is_exact) {
            row("search", "stopped early at numbers with a ~: there may be better sensors; use fewer with --most");
        }
        row("machine", &self.machine);
        if let Some(output) = &self.output {
            row("output", output);
        }
        out
    }
}

/// Returns the table of a direction at a place, with a plot.
fn selection_page(selection: &SensorChoice) -> String {
    let mut out = selection.direction.letter().to_owned();
    if let Some(place) = &selection.place {
        let _ = write!(out, " at {place}");
    }
    let _ = writeln!(out, ": {} readings, drift {} µm (RMS)", selection.readings, significant(selection.drift_um));
    let _ = writeln!(out, "{:>6}{:>10}{:>10}{:>14}  sensors", "number", "Cp", "data", "independent");
    for (number, size) in (1..).zip(&selection.sizes) {
        let mark = if selection.chosen == Some(size.sensors.len()) { '>' } else { ' ' };
        let cp = size.cp.map_or("–".to_owned(), significant);
        let names: Vec<String> = size
            .sensors
            .iter()
            .zip(&size.lag_s)
            .map(|(name, &lag_s)| if lag_s > 0.0 { format!("{name} ({lag_s:.0} s)") } else { name.clone() })
            .collect();
        let number = if size.is_exact { format!("{number}") } else { format!("~{number}") };
        let [data, independent] = [size.efficiency, size.independent_efficiency].map(|share| 100.0 * share);
        let _ = writeln!(out, "{mark}{number:>5}{cp:>10}{data:>8.1} %{independent:>12.1} %  {}", names.join(" "));
    }
    out.push_str(&plot(&selection.sizes));
    match (selection.chosen, selection.left_um) {
        (Some(number), Some(left)) => {
            let noun = if number == 1 { "sensor" } else { "sensors" };
            let _ = writeln!(
                out,
                "  {number} {noun}, residual {} µm (RMS) on the independent readings\n",
                significant(left)
            );
        }
        _ => out.push_str("  no sensors predict the independent readings\n\n"),
    }
    out
}

/// Returns the plot of efficiencies over the number of sensors.
fn plot(sizes: &[SensorSubset]) -> String {
    let values: Vec<[f64; 2]> = sizes.iter().map(|size| [size.efficiency, size.independent_efficiency]).collect();
    let shown = values.as_flattened().iter().map(|value| value.clamp(0.0, 1.0));
    let low = shown.fold(1.0_f64, f64::min);
    if values.len() < 2 {
        return String::new();
    }
    // Whole tenths with a margin.
    let low = ((low * 10.0).floor() / 10.0).min(0.9);
    let row_of = |value: f64| {
        let share = (value.clamp(low, 1.0) - low) / (1.0 - low);
        // Between 0 and HEIGHT − 1.
        (share * (HEIGHT - 1) as f64).round() as usize
    };
    let mut out = String::new();
    for row in (0..HEIGHT).rev() {
        let value = 100.0 * (low + (1.0 - low) * row as f64 / (HEIGHT - 1) as f64);
        let _ = write!(out, "{value:>7.0} %│");
        for [data, independent] in &values {
            let mark = match (row_of(*data) == row, row_of(*independent) == row) {
                (_, true) => "●",
                (true, false) => "○",
                (false, false) => " ",
            };
            let _ = write!(out, "{mark:>STEP$}");
        }
        out.truncate(out.trim_end().len());
        out.push('\n');
    }
    let _ = writeln!(out, "{:>9}└{}", "", "─".repeat(STEP * values.len()));
    let numbers: String = (1..=values.len()).map(|number| format!("{number:>STEP$}")).collect();
    let _ = writeln!(out, "{:>10}{numbers}   ○ data  ● independent", "");
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_metrology::results::sensors::DriftDirection;

    #[test]
    fn the_page_has_table_plot_and_choice() {
        let size = |count: usize, efficiency: f64, independent_efficiency: f64| SensorSubset {
            sensors: (0..count).map(|k| format!("T{k}")).collect(),
            um_per_k: vec![1.0; count],
            lag_s: (0..count).map(|k| if k == 1 { 600.0 } else { 0.0 }).collect(),
            cp: Some(12.345 / count as f64),
            efficiency,
            independent_efficiency,
            is_exact: count < 3,
        };
        let selection = SensorChoice {
            direction: DriftDirection::Y,
            place: Some("Z200".into()),
            readings: 1440,
            drift_um: 31.4,
            left_um: Some(2.5),
            chosen: Some(2),
            sizes: vec![size(1, 0.71, 0.65), size(2, 0.95, 0.92), size(3, 0.97, 0.80)],
        };
        let report = SensorReport {
            found: SensorsResult { selections: vec![selection], independent: None },
            machine: "mill".into(),
            ..SensorReport::default()
        };
        let page = report.page();
        let lines: Vec<&str> = page.lines().collect();
        assert_eq!(lines[0], "Y at Z200: 1440 readings, drift 31.4 µm (RMS)");
        assert_eq!(lines[3], ">    2      6.17    95.0 %        92.0 %  T0 T1 (600 s)");
        assert!(lines[4].starts_with("    ~3") && !lines[3].contains('~'));
        // 60 to 100 % in eight rows: 92, 95 and 97 % are nearest to the second row from the top.
        assert_eq!(lines[6], "     94 %│       ●   ○");
        assert_eq!(lines[7], "     89 %│");
        assert!(lines[13].starts_with("         └────────────") && lines[14].contains("1   2   3"), "{page}");
        assert!(lines[15].starts_with("  2 sensors, residual 2.50 µm (RMS)"), "{page}");
    }
}
