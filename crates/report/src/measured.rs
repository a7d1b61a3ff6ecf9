//! Result of measurement mode: the corrections that were removed from a table of readings.

use std::fmt::Write as _;

use super::correction::output_name;
use super::number::{counted, grouped, significant};
use ncfix_metrology::results::corrected::{CorrectedReadings, CorrectionSize};

/// Returns the table for people about readings that were written to `output`, with a line feed after every line.
#[must_use]
pub fn table(found: &CorrectedReadings, output: &str) -> String {
    let mut out = String::new();
    // Writing into a String cannot fail.
    let mut row = |name: &str, text: &str| {
        let _ = writeln!(out, "{name:<13}{text}");
    };
    row("", &format!("{:>14}{:>14}", "mean", "max"));
    for one in &found.axes {
        let (unit, sizes) = match one.size {
            CorrectionSize::Length { mean_um, max_um } => ("µm", [mean_um, max_um]),
            CorrectionSize::Angle { mean_urad, max_urad } => ("µrad", [mean_urad, max_urad]),
        };
        let [mean, max] = sizes.map(|size| format!("{} {unit}", significant(size)));
        row(&format!("correction {}", one.axis), &format!("{mean:>14}{max:>14}"));
    }
    row("rows", &grouped(found.rows));
    if found.without_sense > 0 {
        let rows = counted(found.without_sense, "row");
        row("sense", &format!("unknown in {rows}: the middle of the backlash is assumed; give X_dir …"));
    }
    row("machine", &found.machine);
    row("written", output_name(output));
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_metrology::results::corrected::AxisCorrection;

    #[test]
    fn the_table_is_aligned() {
        let axis = |axis: &str, size| AxisCorrection { axis: axis.to_owned(), size };
        let found = CorrectedReadings {
            axes: vec![
                axis("X", CorrectionSize::Length { mean_um: 2.0, max_um: 3.0 }),
                axis("C", CorrectionSize::Angle { mean_urad: 20.0, max_urad: 30.0 }),
            ],
            rows: 2,
            without_sense: 1,
            machine: "demo".into(),
        };
        insta::assert_snapshot!(table(&found, "-"), @r"
                               mean           max
        correction X        2.00 µm       3.00 µm
        correction C      20.0 µrad     30.0 µrad
        rows         2
        sense        unknown in 1 row: the middle of the backlash is assumed; give X_dir …
        machine      demo
        written      standard output
        ");
    }
}
