//! What measurement mode did: the corrections that were taken out of a table of readings.

use std::fmt::Write as _;

use super::correction::output_name;
use super::number::{grouped, significant};
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_base::units::{um_from_mm, urad_from_rad};

/// The result of `ncfix measured`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Axes with a column.
    pub axes: Vec<Axis>,
    /// Rows of data.
    pub rows: u64,
    /// Sum of the sizes of the corrections, mm and rad.
    pub sum: AxisVector,
    /// The largest, mm and rad.
    pub max: AxisVector,
    /// Rows in which an axis with backlash has no sense of motion yet.
    pub without_sense: u64,
    /// Name of the machine.
    pub machine: String,
    /// The written file.
    pub output: String,
}

impl Measured {
    /// Notes the correction of a row.
    pub fn note(&mut self, correction: &AxisVector) {
        self.rows += 1;
        for ((sum, max), size) in self.sum.0.iter_mut().zip(&mut self.max.0).zip(correction.0) {
            *sum += size.abs();
            *max = max.max(size.abs());
        }
    }

    /// The table for people, with a line feed behind every line.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        // Writing into a String cannot fail.
        let mut row = |name: &str, text: &str| {
            let _ = writeln!(out, "{name:<13}{text}");
        };
        row("", &format!("{:>14}{:>14}", "mean", "max"));
        for &axis in &self.axes {
            let (unit, factor) =
                if axis.is_rotary() { ("µrad", urad_from_rad(1.0)) } else { ("µm", um_from_mm(1.0)) };
            let mean = self.sum[axis] / self.rows.max(1) as f64;
            let [mean, max] = [mean, self.max[axis]].map(|size| format!("{} {unit}", significant(size * factor)));
            row(&format!("correction {axis}"), &format!("{mean:>14}{max:>14}"));
        }
        row("rows", &grouped(self.rows));
        if self.without_sense > 0 {
            let rows =
                if self.without_sense == 1 { "1 row".into() } else { format!("{} rows", grouped(self.without_sense)) };
            row("sense", &format!("unknown in {rows}: as in the middle of the backlash; give X_dir …"));
        }
        row("machine", &self.machine);
        row("written", output_name(&self.output));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_aligned() {
        let mut measured = Measured {
            axes: vec![Axis::X, Axis::C],
            machine: "demo".into(),
            output: "-".into(),
            without_sense: 1,
            ..Measured::default()
        };
        for size in [0.001, -0.003] {
            let mut correction = AxisVector::ZERO;
            correction[Axis::X] = size;
            correction[Axis::C] = size / 100.0;
            measured.note(&correction);
        }
        insta::assert_snapshot!(measured.table(), @r"
                               mean           max
        correction X        2.00 µm       3.00 µm
        correction C      20.0 µrad     30.0 µrad
        rows         2
        sense        unknown in 1 row: as in the middle of the backlash; give X_dir …
        machine      demo
        written      standard output
        ");
    }
}
