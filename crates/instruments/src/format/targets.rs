//! Tables of readings at targets: laser interferometers, rotary calibrators, levels, autocollimators, straightedges (ISO 230-1, 230-2).
//!
//! Long tables have one reading in each row, wide tables one target in each row and a column for each run and direction. A table may also have the
//! targets in its first row. The description of `direct` readings is the deviation of the moving body: of an axis under the table it has the opposite sign
//! of what an instrument between tool and table reads.

mod axes;
mod checks;
mod direct;
mod facts;

use ncfix_base::geometry::Axis;

use super::InstrumentFormat;
use crate::answers::{MeasuredComponent, component};
use crate::grid::{self, GridCell, GridLine, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::ImportedReadings;
use crate::text::DecodedText;
use crate::unit::ReadingUnit;
use crate::words::{self, ColumnRole};
use checks::{NEAR, agree, check_copies, check_order};
pub(super) use direct::direct;
use direct::rest;
use facts::stated;
pub(super) use facts::{StatedFacts, TargetReading};

/// The format.
pub(super) const FORMAT: InstrumentFormat = InstrumentFormat {
    name: "targets",
    title: "table of ISO 230-2: laser, rotary calibrator, level, autocollimator, straightedge; long or wide",
    needs: "axis component reference at sign unit tool material",
    recognize,
    read,
};

/// True for a table of features: nominal and actual value, and in each row what they are.
fn has_features(table: &GridTable, roles: &[ColumnRole]) -> bool {
    let is_described = |words: &str| words::is_unit(words) || words::is_kind(words);
    roles.contains(&ColumnRole::Target)
        && roles.contains(&ColumnRole::Actual)
        && (table.headings.iter().any(|heading| is_described(&heading.words)) || roles.contains(&ColumnRole::Name))
}

fn recognize(text: &DecodedText) -> u8 {
    let Ok(table) = grid::table(text) else { return 0 };
    let roles: Vec<ColumnRole> = table.headings.iter().map(|heading| words::role(&heading.words)).collect();
    let has = |wanted: fn(&ColumnRole) -> bool| roles.iter().any(wanted);
    let reads = |role: &ColumnRole| {
        matches!(role, ColumnRole::Deviation | ColumnRole::Correction | ColumnRole::Actual | ColumnRole::Series(..))
    };
    let has_component = table.headings.iter().any(|heading| component(&heading.words).is_ok());
    let has_target = has(|role| *role == ColumnRole::Target)
        || table.headings.iter().any(|heading| words::axis(&heading.words).is_some());
    if has_features(&table, &roles) {
        return 0;
    }
    u8::from((has_target && (has(reads) || has_component)) || targets_in_row(&table).is_some()) * 2
}

fn read(inquiry: &mut Inquiry<'_>) -> Result<ImportedReadings, ImportStop> {
    let table = grid::table(inquiry.text)?;
    let mut facts = stated(inquiry.text, &table);
    facts.unit = inquiry.stated_units()?.first().copied();
    let readings = collect(inquiry, &table, &mut facts)?;
    direct(inquiry, readings, facts)
}

/// Targets of a table that has them in its first row, with the series in the rows below.
fn targets_in_row(table: &GridTable) -> Option<Vec<f64>> {
    let (first, rest) = table.rows.split_first()?;
    let is_head = |cell: &GridCell| words::role(&grid::heading_of(&cell.text).words) == ColumnRole::Target;
    let is_series = |row: &GridLine| {
        row.cells.first().is_some_and(|cell| matches!(words::role(&cell.text.to_lowercase()), ColumnRole::Series(..)))
    };
    let (head, targets) = first.cells.split_first()?;
    let targets: Option<Vec<f64>> = targets.iter().map(|cell| grid::number(&cell.text, table.decimal)).collect();
    targets.filter(|targets| is_head(head) && targets.len() >= 2 && rest.iter().any(is_series))
}

/// The readings of one series, as target, value and line, in the order of the motion: a series in the negative direction begins at the last target.
fn series_of(run: u32, sense: i8, mut own: Vec<(f64, f64, usize)>) -> impl Iterator<Item = TargetReading> {
    if sense < 0 {
        own.reverse();
    }
    own.into_iter().map(move |(target, value, line)| TargetReading {
        run: run.to_string(),
        target,
        sense: (sense != 0).then_some(sense),
        value,
        component: None,
        unit: None,
        line,
    })
}

/// Collects the readings of a table with the targets in its first row.
fn collect_rows(
    inquiry: &mut Inquiry<'_>,
    table: &GridTable,
    targets: &[f64],
    facts: &mut StatedFacts,
) -> Result<Vec<TargetReading>, ImportStop> {
    let Some((first, rest)) = table.rows.split_first() else { return Ok(Vec::new()) };
    let unit = first.cells.first().and_then(|cell| grid::heading_of(&cell.text).unit);
    facts.target_unit = unit.map(|unit| (unit, first.number));
    let mut found = Vec::new();
    let mut unread = Vec::new();
    for row in rest {
        let label = row.cells.first().map_or("", |cell| cell.text.as_str());
        let ColumnRole::Series(run, sense) = words::role(&label.to_lowercase()) else {
            unread.push(label.to_owned());
            continue;
        };
        if sense == 0 && rest.len() > 1 {
            let sentence = format!(
                "the row '{label}' does not state its direction of approach; write the direction into the file"
            );
            return Err(inquiry.refused(
                sentence,
                "begin the rows with run and direction, such as 1+ and 1-",
                row.number,
            ));
        }
        let mut own = Vec::new();
        for (index, target) in targets.iter().enumerate() {
            own.extend(table.value(row, index + 1)?.map(|value| (*target, value, row.number)));
        }
        found.extend(series_of(run, sense, own));
    }
    if !unread.is_empty() {
        inquiry.note(format!("rows that are not read: {}", unread.join(", ")), 0);
    }
    subtract_targets(inquiry, facts, &mut found)?;
    Ok(found)
}

/// Subtracts the targets from readings that are the positions reached: all of them follow the targets, as no deviations do.
///
/// # Errors
/// If the column of a run is a copy of the targets.
fn subtract_targets(
    inquiry: &mut Inquiry<'_>,
    facts: &mut StatedFacts,
    found: &mut [TargetReading],
) -> Result<(), ImportStop> {
    let span = found.iter().fold([f64::MAX, f64::MIN], |[low, high], own| [low.min(own.target), high.max(own.target)]);
    let near = NEAR * (span[1] - span[0]);
    // Positions have the unit of their targets.
    let is_other = facts.unit.zip(facts.target_unit).is_some_and(|((unit, _), (target, _))| unit != target);
    if found.len() < 4 || near <= 0.0 || is_other || found.iter().any(|own| (own.value - own.target).abs() > near) {
        return Ok(());
    }
    found.iter_mut().for_each(|own| own.value -= own.target);
    check_copies(inquiry, found)?;
    note_difference(inquiry, facts, found.first().map_or(0, |own| own.line));
    Ok(())
}

/// Notes sign and unit of readings that are actual minus target positions.
fn note_difference(inquiry: &mut Inquiry<'_>, facts: &mut StatedFacts, line: usize) {
    facts.sign = Some((1.0, line));
    facts.unit = facts.unit.or(facts.target_unit);
    let unit = facts.unit.map_or("mm", |(unit, _)| unit.sign());
    inquiry.note(format!("the readings are actual minus target positions, {unit}"), line);
    facts.unit = facts.unit.or(Some((ReadingUnit::Length("mm", 1.0), line)));
}

/// Collects the readings of a table.
fn collect(
    inquiry: &mut Inquiry<'_>,
    table: &GridTable,
    facts: &mut StatedFacts,
) -> Result<Vec<TargetReading>, ImportStop> {
    if let Some(targets) = targets_in_row(table) {
        return collect_rows(inquiry, table, &targets, facts);
    }
    let headings = inquiry.headings(table)?;
    let line = table.heading_line;
    let mut columns: Vec<(usize, ColumnRole)> = Vec::new();
    let mut components: Vec<(usize, MeasuredComponent)> = Vec::new();
    let mut positions: Vec<(usize, Axis)> = Vec::new();
    let mut skipped = Vec::new();
    for (index, heading) in headings.iter().enumerate() {
        match words::role(&heading.words) {
            ColumnRole::Unknown => match (component(&heading.words), words::axis(&heading.words)) {
                (Ok(found), _) => components.push((index, found)),
                (_, Some(axis)) => positions.push((index, axis)),
                _ => {}
            },
            ColumnRole::Skip => skipped.push(index),
            role => columns.push((index, role)),
        }
    }
    if let Some(column) = axes::named(inquiry, table, &headings, facts)? {
        skipped.push(column);
    }
    let has_target = columns.iter().any(|(_, role)| *role == ColumnRole::Target);
    if let Some(moved) = axes::moved(inquiry, table, (&headings, &positions), has_target, facts)? {
        columns.push((moved, ColumnRole::Target));
    }
    if !table.skipped.is_empty() {
        let lines: Vec<String> = table.skipped.iter().take(20).map(ToString::to_string).collect();
        inquiry.note(format!("lines that are not readings: {}", lines.join(", ")), 0);
    }
    inquiry.note(format!("separator: {}; decimal sign: {:?}", table.separator.name(), table.decimal).to_lowercase(), 0);
    let of = |wanted: ColumnRole| columns.iter().find(|(_, role)| *role == wanted).map(|(index, _)| *index);
    let Some(target) = of(ColumnRole::Target) else {
        inquiry.ask(
            "columns",
            "no heading names the column of the target positions",
            "the meaning of each column, such as target,1+,1-,2+,2-",
        );
        return Err(rest(inquiry, facts));
    };
    facts.target_unit = headings.get(target).and_then(|heading| heading.unit).map(|unit| (unit, line));
    let series: Vec<(usize, u32, i8)> = columns
        .iter()
        .filter_map(
            |(index, role)| if let ColumnRole::Series(run, sense) = role { Some((*index, *run, *sense)) } else { None },
        )
        .collect();
    let is_read = |index: usize| {
        // A run and a direction are not read beside columns that state their own.
        let is_role = |role: &ColumnRole| match role {
            ColumnRole::Series(..) => true,
            ColumnRole::Deviation | ColumnRole::Actual | ColumnRole::Correction => series.is_empty(),
            ColumnRole::Run | ColumnRole::Sense => series.is_empty() && of(*role) == Some(index),
            ColumnRole::Target => index == target,
            _ => false,
        };
        columns.iter().any(|(own, role)| *own == index && is_role(role))
            || components.iter().any(|(own, _)| *own == index)
            || positions.iter().any(|(own, _)| *own == index)
            || skipped.contains(&index)
    };
    let unread: Vec<usize> = (0..headings.len()).filter(|index| !is_read(*index)).collect();
    inquiry.unread(table, &headings, &unread)?;
    let unit_of = |index: usize| headings.get(index).and_then(|heading| heading.unit).map(|unit| (unit, line));
    let mut found = Vec::new();
    if !series.is_empty() {
        if series.len() > 1 && series.iter().any(|(_, _, sense)| *sense == 0) {
            inquiry.ask(
                "columns",
                "the headings do not state which runs go in the positive and which in the negative direction",
                "the meaning of each column, such as target,1+,1-,2+,2-",
            );
        }
        let units = series.iter().map(|(index, _, _)| headings.get(*index)?.unit);
        facts.unit = inquiry.one_unit(units, line)?.or(facts.unit);
        inquiry.check_signs(table, &series.iter().map(|(index, ..)| *index).collect::<Vec<_>>())?;
        for (index, run, sense) in series {
            let mut own = Vec::new();
            for row in &table.rows {
                let Some(value) = table.value(row, index)? else { continue };
                own.push((table.needed(row, target)?, value, row.number));
            }
            found.extend(series_of(run, sense, own));
        }
        subtract_targets(inquiry, facts, &mut found)?;
        return Ok(found);
    }
    for role in [ColumnRole::Deviation, ColumnRole::Actual, ColumnRole::Correction] {
        if columns.iter().filter(|(_, own)| *own == role).count() > 1 {
            let message = "several columns have readings of the same kind, and none states its run and direction";
            return Err(inquiry.refused(message, "name them with --columns, such as target,1+,1-", line));
        }
    }
    let (run, sense) = (of(ColumnRole::Run), of(ColumnRole::Sense));
    let deviation = of(ColumnRole::Deviation).or(of(ColumnRole::Correction));
    let actual = of(ColumnRole::Actual);
    let (deviation, actual) = match actual {
        Some(column) if deviation.is_none() && components.is_empty() && is_of_deviations(table, [target, column]) => {
            let written = headings.get(column).map_or("", |heading| heading.written.as_str());
            inquiry.note(format!("'{written}' has another unit than the targets, and small values: deviations"), line);
            (actual, None)
        }
        _ => (deviation, actual),
    };
    if of(ColumnRole::Deviation).is_none() && of(ColumnRole::Correction).is_some() {
        facts.sign = Some((-1.0, line));
    }
    let value_columns: Vec<(usize, Option<MeasuredComponent>)> = if components.is_empty() {
        deviation.or(actual).map(|index| (index, None)).into_iter().collect()
    } else {
        components.iter().map(|(index, own)| (*index, Some(*own))).collect()
    };
    if value_columns.is_empty() {
        inquiry.ask(
            "columns",
            "no heading names the column of the deviations",
            "the meaning of each column, such as target,run,dir,dev",
        );
        return Err(rest(inquiry, facts));
    }
    inquiry.check_signs(table, &value_columns.iter().map(|(index, _)| *index).collect::<Vec<_>>())?;
    facts.unit = value_columns.iter().find_map(|(index, _)| unit_of(*index)).or(facts.unit);
    let is_difference = components.is_empty() && deviation.is_none();
    if let Some(actual) = actual {
        let pair = [target, actual].into_iter();
        inquiry.one_unit(pair.map(|column| headings.get(column)?.unit), line)?;
        check_order(inquiry, table, [target, actual])?;
    }
    if is_difference {
        note_difference(inquiry, facts, line);
    }
    for row in &table.rows {
        let at = table.needed(row, target)?;
        let own_sense = match sense
            .and_then(|index| row.cells.get(index))
            .filter(|cell| !cell.text.is_empty() && cell.text != "0")
        {
            Some(cell) => Some(words::sense(&cell.text).ok_or_else(|| {
                inquiry.refused(format!("'{}' is not a direction of approach", cell.text), "write + or -", row.number)
            })?),
            None => None,
        };
        let label = run.and_then(|index| row.cells.get(index)).map_or_else(String::new, |cell| cell.text.clone());
        for (index, own) in &value_columns {
            let Some(mut value) = table.value(row, *index)? else { continue };
            if is_difference {
                value -= at;
            } else if let (Some(actual), true) = (actual, own.is_none())
                && let Some(reached) = table.value(row, actual)?
            {
                agree(inquiry, facts, (at, reached, value), row.number)?;
            }
            found.push(TargetReading {
                run: label.clone(),
                target: at,
                sense: own_sense,
                value,
                component: *own,
                unit: own.and(unit_of(*index)).map(|(unit, _)| unit),
                line: row.number,
            });
        }
    }
    Ok(found)
}

/// True if a column with the name of measured positions has deviations: another unit than the targets, and no value that is as large as a way between two
/// targets.
fn is_of_deviations(table: &GridTable, [target, column]: [usize; 2]) -> bool {
    /// Largest deviation, mm: that of a crude router, and far less than a usual way between targets.
    const LARGEST_MM: f64 = 1.0;
    let length = |column: usize| match table.headings.get(column)?.unit? {
        ReadingUnit::Length(_, mm) => Some(mm),
        ReadingUnit::Angle(..) => None,
    };
    let (Some(of_target), Some(own)) = (length(target), length(column)) else { return false };
    let values = |column: usize, mm: f64| -> Vec<f64> {
        table.rows.iter().filter_map(|row| Some(mm * table.value(row, column).ok()??)).collect()
    };
    let ends = |values: &[f64]| {
        values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &mm| [low.min(mm), high.max(mm)])
    };
    let ([low, high], readings) = (ends(&values(target, of_target)), values(column, own));
    own != of_target && high - low > 10.0 * LARGEST_MM && readings.iter().all(|mm| mm.abs() < LARGEST_MM)
}
