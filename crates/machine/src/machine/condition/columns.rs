//! The columns of tables that say how the machine was: temperatures and the workpiece on the table.
//!
//! | column | meaning |
//! | --- | --- |
//! | `t_s` | time |
//! | `T_head_C` | temperature of the sensor `T_head`, as the machine file calls it: the name of the column without `_C` |
//! | `load_N`, `load_x_mm`, `load_y_mm`, `load_z_mm` | weight on the table and its place, from this row on |

use ncfix_base::csv::{DecimalSign, Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Vector;

use super::Load;
use super::file::PLAUSIBLE_C;

/// What a column holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Time, s.
    Time,
    /// Temperature of a sensor, °C.
    Sensor(String),
    /// Weight, N.
    Force,
    /// x, y or z of the place of the load, mm.
    LoadPlace(usize),
    /// Something else.
    Other,
}

impl Column {
    /// What a column of this name holds.
    #[must_use]
    pub fn of(name: &str) -> Column {
        match name {
            "t_s" => Column::Time,
            "load_N" => Column::Force,
            "load_x_mm" => Column::LoadPlace(0),
            "load_y_mm" => Column::LoadPlace(1),
            "load_z_mm" => Column::LoadPlace(2),
            other => match other.strip_suffix("_C") {
                Some(sensor) if !sensor.is_empty() => Column::Sensor(sensor.to_owned()),
                _ => Column::Other,
            },
        }
    }

    /// All columns of a table.
    #[must_use]
    pub fn all(table: &Table) -> Vec<Column> {
        table.names().iter().map(|name| Column::of(name)).collect()
    }
}

/// No load in the center of the table.
pub const NO_LOAD: Load = Load { force_n: 0.0, position_mm: Vector::new(0.0, 0.0, 0.0) };

/// Says where a table has the place of a load but not its weight.
pub fn check_load(table: &Table, columns: &[Column], findings: &mut Vec<Diagnostic>) {
    if !columns.contains(&Column::Force) && columns.iter().any(|column| matches!(column, Column::LoadPlace(_))) {
        let help = "add a column load_N with the weight, or remove the place";
        let message = "the table has the place of a load but not load_N";
        findings.push(Diagnostic::at(Code::DATA_COLUMN, table.header_place(None), message, help));
    }
}

/// What becomes of a temperature that no machine has, as a sensor that is dead gives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OfDead {
    /// It is refused.
    Refused,
    /// It says nothing, like an empty cell; who reads the table says that it is there.
    Empty,
}

/// Reads a cell of a temperature or of a load; a load changes what `load` was. `None` where the column holds something else or the cell
/// is empty.
///
/// # Errors
/// A finding where the cell is no number, or none that a machine may have.
pub fn read_cell(
    row: &Row<'_>,
    index: usize,
    column: &Column,
    sign: DecimalSign,
    load: &mut Load,
    of_dead: OfDead,
) -> Result<Option<f64>, Diagnostic> {
    if matches!(column, Column::Time | Column::Other) || row.text(index).is_empty() {
        return Ok(None);
    }
    let value = row.number(index, sign)?;
    let fault = |message: String, help: &str| Err(Diagnostic::at(Code::DATA_CELL, row.place(index), message, help));
    let [low, high] = PLAUSIBLE_C;
    match column {
        Column::Sensor(_) if !(low..=high).contains(&value) && of_dead == OfDead::Empty => return Ok(None),
        Column::Sensor(_) if !(low..=high).contains(&value) => {
            let help = "leave the cell empty where a sensor has no reading; temperatures are -30 to 150 °C";
            return fault(format!("{value} °C is no temperature of a machine"), help);
        }
        Column::Force if value < 0.0 => {
            return fault(format!("{value} N is no weight"), "write the weight in N, 0 for an empty table");
        }
        Column::Force => load.force_n = value,
        Column::LoadPlace(axis) => load.position_mm[*axis] = value,
        _ => {}
    }
    Ok(Some(value))
}
