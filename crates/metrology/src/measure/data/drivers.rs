//! Additional numeric columns of a table: anything other than positions, set-ups and readings may be an influence on an error.

use ncfix_base::csv::{DecimalSign, Table};
use ncfix_machine::machine::Machine;

use super::DataSet;

/// A numeric column by name, one value per row; NaN for an empty cell.
#[derive(Clone, Debug, PartialEq)]
pub struct DataColumn {
    /// The column name: `feed_mm_min`, `T_nose_C`, `humidity`.
    pub name: String,
    /// In the order of the rows.
    pub values: Vec<f64>,
}

/// The column with the time of a row, s.
pub const TIME: &str = "t_s";
/// The column with known moves of the tool in a test of signs, µm.
pub const MOVED: &str = "moved_um";
/// The column with known turns in a test of signs of an angle, µrad.
pub const TURNED: &str = "moved_urad";
/// Columns about the feature of a workpiece that was measured: its name, its level, its nominal position relative to the zero of the workpiece.
pub const FEATURE_COLUMNS: [&str; 5] = ["feature", "level", "nominal_x_mm", "nominal_y_mm", "nominal_z_mm"];
/// Columns with a meaning of their own.
const OWN: [&str; 10] =
    ["setup", "run", TIME, MOVED, TURNED, "target", "component", "tool_x_mm", "tool_y_mm", "tool_z_mm"];

/// Reads all purely numeric columns.
pub(super) fn read(table: &Table, machine: &Machine, sign: DecimalSign, data: &DataSet) -> Vec<DataColumn> {
    let is_axis = |name: &str| {
        let letter = name.strip_suffix("_dir").unwrap_or(name);
        machine.axes.iter().flatten().any(|data| data.axis.to_string() == letter)
    };
    let has_features = table.column(FEATURE_COLUMNS[0]).is_some();
    let mut drivers = Vec::new();
    for (column, name) in table.names().iter().enumerate() {
        // Without the name of a feature, such columns are quantities like any other.
        let is_of_feature = has_features && FEATURE_COLUMNS.contains(&name.as_str());
        if is_of_feature || OWN.contains(&name.as_str()) || data.kind.columns.contains(&name.as_str()) || is_axis(name)
        {
            continue;
        }
        if data.sensors.as_ref().is_some_and(|sensors| sensors.columns.contains(name)) {
            continue;
        }
        let number = |row: ncfix_base::csv::Row<'_>| {
            if row.text(column).is_empty() { Some(f64::NAN) } else { row.number(column, sign).ok() }
        };
        let Some(values) = table.rows().map(number).collect::<Option<Vec<f64>>>() else { continue };
        if values.iter().any(|value| !value.is_nan()) {
            drivers.push(DataColumn { name: name.clone(), values });
        }
    }
    drivers
}
