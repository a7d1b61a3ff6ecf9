//! Readings of a strain gauge along an axis, from a table.
//!
//! Columns: the letter of the axis (mm, deg), `strain_um_m` (µm/m), and optionally `run` (readings of one run share an offset; default one run) and
//! `t_s` (s; allows a linear drift of the strain in a run).

use std::collections::HashMap;

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_machine::machine::StrainGauge;

use ncfix_base::csv::{DecimalSign, Row, Table};

/// The column of the readings.
const STRAIN: &str = "strain_um_m";

/// A reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrainReading {
    /// Command of the axis, mm or rad.
    pub position: f64,
    /// Strain, µm/m.
    pub strain_um_m: f64,
    /// Index of its run, from 0.
    pub run: usize,
    /// Time, s.
    pub time_s: Option<f64>,
    /// Place of the strain in its file.
    pub place: Place,
}

/// The readings in a table.
///
/// # Errors
/// Diagnostics for missing columns, cells that are not numbers, and positions outside the range of the gauge.
pub fn read(table: &Table, gauge: &StrainGauge) -> Result<Vec<StrainReading>, Vec<Diagnostic>> {
    let mut findings = Vec::new();
    let axis = gauge.axis.to_string();
    let unit = if gauge.axis.is_rotary() { "deg" } else { "mm" };
    let position = column(table, &axis, &format!("axis positions ({unit})"), &mut findings);
    let strain = column(table, STRAIN, "readings of the strain gauge (µm/m)", &mut findings);
    let (Some(position), Some(strain)) = (position, strain) else { return Err(findings) };
    let (run, time) = (table.column("run"), table.column("t_s"));
    let numbers: Vec<usize> = [Some(position), Some(strain), time].into_iter().flatten().collect();
    let sign = table.decimal_sign(&numbers).map_err(|finding| vec![finding])?;
    let columns = Columns { position, strain, time, sign };
    let mut runs: HashMap<&[u8], usize> = HashMap::new();
    let mut readings = Vec::new();
    for row in table.rows() {
        match columns.read(&row, gauge) {
            Ok(mut reading) => {
                let next = runs.len();
                reading.run = *runs.entry(run.map_or(&[], |column| row.text(column))).or_insert(next);
                readings.push(reading);
            }
            Err(finding) => findings.push(finding),
        }
    }
    if findings.is_empty() { Ok(readings) } else { Err(findings) }
}

fn column(table: &Table, name: &str, what: &str, findings: &mut Vec<Diagnostic>) -> Option<usize> {
    let column = table.column(name);
    if column.is_none() {
        let help = format!("rename the column with the {what} to `{name}`");
        let message = format!("there is no column {name}");
        findings.push(Diagnostic::at(Code::DATA_COLUMN, table.header_place(None), message, help));
    }
    column
}

struct Columns {
    position: usize,
    strain: usize,
    time: Option<usize>,
    sign: DecimalSign,
}

impl Columns {
    fn read(&self, row: &Row<'_>, gauge: &StrainGauge) -> Result<StrainReading, Diagnostic> {
        let shown = row.number(self.position, self.sign)?;
        let is_rotary = gauge.axis.is_rotary();
        let position = if is_rotary { shown.to_radians() } else { shown };
        if gauge.signal(&gauge.force, position).is_none() {
            let ends = [gauge.positions.first(), gauge.positions.last()].map(|end| end.copied().unwrap_or_default());
            let [low, high] = if is_rotary { ends.map(f64::to_degrees) } else { ends };
            let message = format!("{} {shown} is outside {low} … {high}, the range that [strain] covers", gauge.axis);
            let help = "remove the row, or add the position to [strain] in the machine file";
            return Err(Diagnostic::at(Code::LOAD_NOT_TOLD, row.place(self.position), message, help));
        }
        let strain_um_m = row.number(self.strain, self.sign)?;
        let time_s = self.time.map(|column| row.number(column, self.sign)).transpose()?;
        Ok(StrainReading { position, strain_um_m, run: 0, time_s, place: row.place(self.strain) })
    }
}
