//! Columns of a ball-bar table: one row for each reading with run and direction, or a column for each circle.

use crate::grid::{GridHeading, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::row_fact::{ColumnValues, RowFact, row_fact};
use crate::unit::ReadingUnit;
use crate::words::{self, CircleHeading, ColumnRole};

/// Columns by their meaning.
pub(super) struct CircleColumns {
    /// Angle.
    pub(super) angle: Option<usize>,
    /// Factor from the unit of the angle to degrees.
    pub(super) deg: f64,
    /// Time.
    pub(super) time: Option<usize>,
    /// Number of the run.
    pub(super) run: Option<usize>,
    /// Direction.
    pub(super) sense: Option<usize>,
    /// Readings, one column or one for each circle.
    pub(super) readings: Vec<(usize, CircleHeading)>,
    /// True if the readings are radii.
    pub(super) is_radius: bool,
    /// Unit of the readings in their heading.
    pub(super) unit: Option<ReadingUnit>,
    /// Facts in columns that have one value in all rows.
    pub(super) constants: Vec<ColumnFact>,
}

/// Columns of readings with what their headings say: deviations, else radii, else one for each circle.
pub(super) fn readings(headings: &[GridHeading]) -> Vec<(usize, CircleHeading)> {
    let roles = || headings.iter().map(|heading| words::role(&heading.words)).enumerate();
    let one = |wanted: ColumnRole| {
        let heading = CircleHeading { run: None, turn: None, is_radius: wanted == ColumnRole::Radius };
        roles().find(|(_, role)| *role == wanted).map(|(column, _)| (column, heading))
    };
    let circles = headings.iter().enumerate().filter_map(|(column, own)| Some((column, words::circle(&own.words)?)));
    let circles: Vec<(usize, CircleHeading)> = circles.collect();
    if circles.is_empty() {
        one(ColumnRole::Deviation).or_else(|| one(ColumnRole::Radius)).into_iter().collect()
    } else {
        circles.into_iter().chain(one(ColumnRole::Deviation)).collect()
    }
}

/// Finds the columns.
///
/// # Errors
/// If the table has no angles or times, no readings, or readings of two kinds.
pub(super) fn find(inquiry: &mut Inquiry<'_>, table: &GridTable) -> Result<CircleColumns, ImportStop> {
    let line = table.heading_line;
    let headings = inquiry.headings(table)?;
    let roles: Vec<ColumnRole> = headings.iter().map(|heading| words::role(&heading.words)).collect();
    let of = |wanted: ColumnRole| roles.iter().position(|role| *role == wanted);
    let (angle, time) = (of(ColumnRole::Angle), of(ColumnRole::Time));
    let (run, sense) = (of(ColumnRole::Run), of(ColumnRole::Sense));
    let readings = readings(&headings);
    let help = "export angle and deviation of each reading, or name the columns with --columns, such as angle,ccw,cw";
    if angle.or(time).is_none() {
        return Err(inquiry.refused("the table has no column of angles or times", help, line));
    }
    let Some((_, first)) = readings.first() else {
        return Err(inquiry.refused("the table has no column of deviations or radii", help, line));
    };
    let is_radius = first.is_radius;
    let unit_of = |column: usize| headings.get(column).and_then(|heading| heading.unit);
    let unit = readings.first().and_then(|(column, _)| unit_of(*column));
    for (column, heading) in &readings {
        if heading.is_radius != is_radius || unit_of(*column) != unit {
            let message = "the columns of the circles are not of one kind and unit";
            return Err(inquiry.refused(message, "export them alike, or name the columns with --columns", line));
        }
    }
    let is_wide = readings.len() > 1;
    if is_wide && (run.is_some() || sense.is_some()) {
        let message = "the table has a column for each circle, and a column of runs or directions";
        return Err(inquiry.refused(
            message,
            "name the columns with --columns; write - for one that is not read",
            line,
        ));
    }
    if is_wide && readings.iter().enumerate().any(|(k, (_, one))| readings[..k].iter().any(|(_, other)| one == other)) {
        let message = "two columns have the same run and direction";
        return Err(inquiry.refused(message, "give each circle a number, such as ccw1,cw1,ccw2,cw2", line));
    }
    let deg = match angle.and_then(unit_of) {
        Some(unit @ ReadingUnit::Angle(..)) => unit.inner(1.0).to_degrees(),
        Some(unit) => {
            let message = format!("the angles are in {}, which is no unit of an angle", unit.sign());
            return Err(inquiry.refused(message, "correct the heading, or name the columns with --columns", line));
        }
        None => 1.0,
    };
    let is_read = |column: usize| {
        [angle, time, run, sense].contains(&Some(column)) || readings.iter().any(|(own, _)| *own == column)
    };
    let is_open = |column: usize| !is_read(column) && roles.get(column) != Some(&ColumnRole::Skip);
    let open: Vec<usize> = (0..headings.len()).filter(|column| is_open(*column)).collect();
    let mut constants = Vec::new();
    let mut unread = Vec::new();
    for column in open {
        match constant(table, column, headings.get(column), roles.get(column)) {
            Some(found) => constants.push(found),
            None => unread.push(column),
        }
    }
    inquiry.unread(table, &headings, &unread)?;
    Ok(CircleColumns { angle, deg, time, run, sense, readings, is_radius, unit, constants })
}

/// Fact of the circle in a column that has one value in all rows.
#[derive(Clone, Debug)]
pub(super) struct ColumnFact {
    /// Which fact.
    pub(super) fact: RowFact,
    /// Its value, in lower case.
    pub(super) text: String,
    /// Unit in the heading.
    pub(super) unit: Option<ReadingUnit>,
    /// Heading, as written.
    pub(super) written: String,
    /// First line with the value.
    pub(super) line: usize,
}

/// Fact that a column which is no reading states for the whole table.
fn constant(
    table: &GridTable,
    column: usize,
    heading: Option<&GridHeading>,
    role: Option<&ColumnRole>,
) -> Option<ColumnFact> {
    let heading = heading?;
    // A nominal radius is exactly one number, a measured one is not.
    let is_radius = role == Some(&ColumnRole::Radius);
    let fact = if is_radius { RowFact::Bar } else { row_fact(&heading.words)? };
    let values = ColumnValues::of(table, column);
    let (text, line) = values.only(table).filter(|_| !is_radius || values.distinct.len() == 1)?;
    matches!(fact, RowFact::Plane | RowFact::Bar | RowFact::Feed).then(|| ColumnFact {
        fact,
        text: text.to_owned(),
        unit: heading.unit,
        written: heading.written.clone(),
        line,
    })
}
