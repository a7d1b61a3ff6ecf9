//! Tables of readings at targets: laser interferometers, rotary calibrators, levels, autocollimators, straightedges (ISO 230-1, 230-2).
//!
//! Long tables have one reading in each row, wide tables one target in each row and a column for each run and direction. A table may also have the
//! targets in its first row. The description of `direct` readings is the deviation of the moving body: of an axis under the table it has the opposite sign
//! of what an instrument between tool and table reads.

use ncfix_base::geometry::Axis;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::{Branch, Machine};

use super::InstrumentFormat;
use crate::answers::{MeasuredComponent, component};
use crate::grid::{self, GridCell, GridLine, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::{ImportedKind, ImportedReadings, ImportedRow, shown};
use crate::rows;
use crate::text::DecodedText;
use crate::unit::ReadingUnit;
use crate::words::{self, ColumnRole};

/// The format.
pub(super) const FORMAT: InstrumentFormat = InstrumentFormat {
    name: "targets",
    title: "table of ISO 230-2: laser, rotary calibrator, level, autocollimator, straightedge; long or wide",
    needs: "axis component at sign unit tool material",
    recognize,
    read,
};

/// One reading before its sign and unit are known.
pub(super) struct TargetReading {
    /// Label of the repetition.
    pub(super) run: String,
    /// Target, in the unit of the file.
    pub(super) target: f64,
    /// Direction of approach.
    pub(super) sense: Option<i8>,
    /// Reading, in the unit of the file.
    pub(super) value: f64,
    /// Component, if its heading names it.
    pub(super) component: Option<MeasuredComponent>,
    /// Unit in its own heading.
    pub(super) unit: Option<ReadingUnit>,
    /// Line.
    pub(super) line: usize,
}

/// Facts that the file itself states.
#[derive(Default)]
pub(super) struct StatedFacts {
    /// Axis and its line.
    pub(super) axis: Option<(Axis, usize)>,
    /// Sign and its line.
    pub(super) sign: Option<(f64, usize)>,
    /// Unit of the readings and its line.
    pub(super) unit: Option<(ReadingUnit, usize)>,
    /// Unit of the targets and its line.
    pub(super) target_unit: Option<(ReadingUnit, usize)>,
    /// Line with a word for another quantity than positioning.
    pub(super) other_quantity: Option<usize>,
}

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

/// Words of quantities other than positioning.
const OTHER: &[&str] = &[
    "straight",
    "gerad",
    "rectitude",
    "rettilin",
    "rectitud",
    "pitch",
    "yaw",
    "roll",
    "angle",
    "angular",
    "winkel",
    "nick",
    "gier",
    "roll",
    "level",
    "neigung",
    "inclin",
    "flatness",
    "squareness",
];

/// Reads the facts in the lines around a table.
pub(super) fn stated(text: &DecodedText, table: &GridTable) -> StatedFacts {
    let mut facts = StatedFacts::default();
    for &number in table.before.iter().chain([&table.heading_line]).filter(|number| **number > 0) {
        let line = text.line(number).to_lowercase();
        if OTHER.iter().any(|word| line.contains(word)) {
            facts.other_quantity.get_or_insert(number);
        }
        let Some((key, value)) = line.split_once([':', '=', ';', '\t', ',']) else { continue };
        let value = value.trim_matches([' ', ';', ',', '\t', '"']);
        let is_key = |words: &[&str]| words.contains(&key.trim().trim_start_matches(['#', '/']).trim());
        if is_key(&["axis", "achse", "axe", "asse", "eje"])
            && let Some(axis) = words::axis(value)
        {
            facts.axis.get_or_insert((axis, number));
        }
    }
    facts
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
    subtract_targets(inquiry, facts, &mut found);
    Ok(found)
}

/// Subtracts the targets from readings that are the positions reached: these follow the targets much more closely than any deviation could.
fn subtract_targets(inquiry: &mut Inquiry<'_>, facts: &mut StatedFacts, found: &mut [TargetReading]) {
    /// Largest difference of a position and its target, as a share of the span of the targets.
    const NEAR: f64 = 0.01;
    let span = found.iter().fold([f64::MAX, f64::MIN], |[low, high], own| [low.min(own.target), high.max(own.target)]);
    let near = NEAR * (span[1] - span[0]);
    if found.len() < 4 || near <= 0.0 || found.iter().any(|own| (own.value - own.target).abs() > near) {
        return;
    }
    found.iter_mut().for_each(|own| own.value -= own.target);
    note_difference(inquiry, facts, found.first().map_or(0, |own| own.line));
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
    let mut unknown = Vec::new();
    for (index, heading) in headings.iter().enumerate() {
        match words::role(&heading.words) {
            ColumnRole::Unknown => match (component(&heading.words), words::axis(&heading.words)) {
                (Ok(found), _) => components.push((index, found)),
                (_, Some(axis)) => {
                    facts.axis.get_or_insert((axis, line));
                    columns.push((index, ColumnRole::Target));
                }
                _ => unknown.push(heading),
            },
            ColumnRole::Skip => {}
            role => columns.push((index, role)),
        }
    }
    inquiry.unread(&unknown, line)?;
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
        for (index, run, sense) in series {
            let mut own = Vec::new();
            for row in &table.rows {
                let Some(value) = table.value(row, index)? else { continue };
                own.push((table.needed(row, target)?, value, row.number));
            }
            found.extend(series_of(run, sense, own));
        }
        subtract_targets(inquiry, facts, &mut found);
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

/// Checks that the columns of targets and of actual positions are not exchanged: targets are round numbers, actual positions are not.
///
/// # Errors
/// If the actual positions are the round ones, and no option names the columns.
fn check_order(inquiry: &Inquiry<'_>, table: &GridTable, columns: [usize; 2]) -> Result<(), ImportStop> {
    let mut pairs = Vec::new();
    for row in &table.rows {
        let [target, actual] = columns;
        pairs.extend(table.value(row, target)?.zip(table.value(row, actual)?));
    }
    if inquiry.answers.columns.is_empty() && rows::is_exchanged(&pairs) {
        let message = "the actual positions are round and the targets are not: the columns may be exchanged";
        let help = "correct the headings, or confirm them with --columns, such as target,actual";
        return Err(inquiry.refused(message, help, table.heading_line));
    }
    Ok(())
}

/// Checks that no run is a column of positions: its readings spread far more than those of all others, or they follow the targets.
///
/// # Errors
/// If one does.
fn check_runs(inquiry: &Inquiry<'_>, found: &[TargetReading], unit: ReadingUnit) -> Result<(), ImportStop> {
    /// Spread of a run as a multiple of the largest one of the others, and difference from the targets as a share of their span.
    const FAR: (f64, f64) = (8.0, 0.01);
    /// Smallest spread that is far, µm or µrad: below it the digits of a file decide.
    const LEAST: f64 = 20.0;
    type Run<'a> = ((&'a str, Option<i8>, Option<MeasuredComponent>), Vec<&'a TargetReading>);
    let mut runs: Vec<Run<'_>> = Vec::new();
    for reading in found {
        let key = (reading.run.as_str(), reading.sense, reading.component);
        let count = runs.len();
        match runs.iter_mut().find(|(own, _)| *own == key) {
            Some((_, readings)) => readings.push(reading),
            None if count < 1000 => runs.push((key, vec![reading])),
            None => return Ok(()),
        }
    }
    let span = |readings: &[&TargetReading], of: fn(&TargetReading) -> f64| {
        let ends = readings.iter().fold((f64::MAX, f64::MIN), |(low, high), own| (low.min(of(own)), high.max(of(own))));
        ends.1 - ends.0
    };
    for (index, ((name, sense, component), readings)) in runs.iter().enumerate().filter(|(_, (_, own))| own.len() > 3) {
        let others = runs
            .iter()
            .enumerate()
            .filter(|(k, ((.., other), own))| *k != index && other == component && own.len() > 3);
        let most = others
            .map(|(_, (_, own))| span(own, |own| own.value))
            .fold(None, |most: Option<f64>, own| Some(most.map_or(own, |most| most.max(own))));
        let targets = span(readings, |own| own.target);
        let near = FAR.1 * targets;
        let is_position = near > 0.0 && readings.iter().all(|own| (own.value - own.target).abs() <= near);
        let own = span(readings, |own| own.value);
        let is_far = most.is_some_and(|most| own > FAR.0 * most && unit.fine(own) > LEAST);
        if is_position || is_far {
            let sign = sense.map_or("", |sense| if sense < 0 { "-" } else { "+" });
            let why = if is_position { "follow the targets" } else { "spread far more than those of the other runs" };
            let message = format!("the readings of run {name}{sign} {why}: its column may be that of the targets");
            let help = "check the headings; name the columns with --columns, and write - for a run that is not valid";
            return Err(inquiry.refused(message, help, readings.first().map_or(0, |own| own.line)));
        }
    }
    Ok(())
}

/// Asks for everything else that a table of readings leaves open if it cannot be read on: all questions come in one round.
fn rest(inquiry: &mut Inquiry<'_>, facts: &StatedFacts) -> ImportStop {
    let component = inquiry.answers.component;
    let axis = component.map(|one| one.axis).or(inquiry.answers.axis).or(facts.axis.map(|(axis, _)| axis));
    let is_angle = component.is_some_and(MeasuredComponent::is_angle);
    if axis.is_none() {
        inquiry.ask("axis", "the file does not state the axis that moved", "its letter, such as X");
    }
    if let (None, Some(line)) = (component, facts.other_quantity) {
        let sentence =
            format!("line {line} mentions a straightness or an angle, and the file does not name its component");
        inquiry.ask("component", sentence, "the error, such as EXX for positioning or EYX for a straightness");
    }
    if inquiry.answers.sign.is_none() && facts.sign.is_none() {
        inquiry.ask(
            "sign",
            "the file does not state the sign of its readings",
            "+ if a positive reading means too far in the positive direction, else -",
        );
    }
    if inquiry.answers.unit.is_none() && facts.unit.is_none() {
        let choices = format!("one of {}", ReadingUnit::choices(is_angle));
        inquiry.ask("unit", "the file does not state the unit of its readings", choices);
    }
    match axis {
        Some(axis) => _ = inquiry.other_positions(&[axis]),
        None if inquiry.answers.at.is_empty() => {
            let sentence = "the file does not state the positions of the axes that did not move";
            inquiry.ask("at", sentence, "all of them, in machine coordinates, such as Y200,Z100");
        }
        None => {}
    }
    if !is_angle {
        inquiry.tool();
        // A contradiction is reported when the readings can be read.
        _ = inquiry.material("the scale of the axis");
    }
    ImportStop::Asks
}

/// Checks that a deviation is the difference of target and actual position, and learns its sign from that.
fn agree(
    inquiry: &Inquiry<'_>,
    facts: &mut StatedFacts,
    (target, actual, value): (f64, f64, f64),
    line: usize,
) -> Result<(), ImportStop> {
    let one = facts.target_unit.map_or(1.0, |(unit, _)| unit.inner(1.0));
    let unit = facts.unit.map_or(one, |(unit, _)| unit.inner(1.0));
    let (difference, value) = ((actual - target) * one, value * unit);
    // A position is printed with three or four decimals, so a tenth of a micrometer is below its last digit.
    let slack = 6e-4_f64.max(0.02 * difference.abs());
    let is_same = (difference - value).abs() <= slack;
    let is_opposite = (difference + value).abs() <= slack;
    match (is_same, is_opposite, facts.sign) {
        (true, true, _) => Ok(()),
        (true, false, None | Some((1.0.., _))) => {
            facts.sign.get_or_insert((1.0, line));
            Ok(())
        }
        (false, true, None) => {
            facts.sign = Some((-1.0, line));
            Ok(())
        }
        (false, true, Some((sign, _))) if sign < 0.0 => Ok(()),
        _ => {
            let message = format!(
                "the deviation {} is not the difference of actual and target position, {}",
                shown(value),
                shown(difference)
            );
            Err(inquiry.refused(message, "check the columns and their units, or name them with --columns", line))
        }
    }
}

/// Sense of the moving body for readings of the tool relative to the workpiece.
///
/// # Errors
/// If the axis is not parallel to the direction in F.
fn body_sense(inquiry: &Inquiry<'_>, machine: &Machine, component: MeasuredComponent) -> Result<f64, ImportStop> {
    let Some(axis) = machine.axis(component.axis) else {
        let message = format!("the machine has no axis {}", char::from(component.axis.letter()));
        return Err(inquiry.refused(message, "check --axis and --machine", 0));
    };
    let is_on_table = machine.topology.branch(component.axis) == Some(Branch::Workpiece);
    if !component.is_positioning() {
        return Ok(if is_on_table { -1.0 } else { 1.0 });
    }
    let share = axis.direction[component.direction % 3];
    if share.abs() < 0.999 {
        let message = format!(
            "{} is not parallel to an axis of F, so its positioning error is no single component",
            char::from(component.axis.letter())
        );
        return Err(inquiry.refused(message, "enter the readings as a displacement", 0));
    }
    Ok(share.signum())
}

/// Turns readings into those of one error component at a time.
pub(super) fn direct(
    inquiry: &mut Inquiry<'_>,
    found: Vec<TargetReading>,
    facts: StatedFacts,
) -> Result<ImportedReadings, ImportStop> {
    let named = found.iter().find_map(|reading| reading.component);
    let component = match (inquiry.answers.component, named, inquiry.answers.axis, facts.axis) {
        (Some(component), None, axis, stated) => {
            if axis.is_some_and(|axis| axis != component.axis) {
                return Err(inquiry.refused(
                    format!("--axis and --component {component} name different axes"),
                    "give one of them",
                    0,
                ));
            }
            if let Some((_, line)) = stated.filter(|(axis, _)| *axis != component.axis) {
                let message = format!("--component {component} contradicts the file, which names another axis");
                return Err(inquiry.refused(message, "correct the option, or the file", line));
            }
            inquiry.note(format!("measured error: --component {component}"), 0);
            component
        }
        (said, Some(component), axis, _) => {
            let is_other = |own: MeasuredComponent| said.is_some_and(|said| said != own);
            if found.iter().filter_map(|reading| reading.component).any(is_other)
                || axis.is_some_and(|axis| axis != component.axis)
            {
                let option = if said.is_some() { "component" } else { "axis" };
                let message = format!("--{option} contradicts the headings, which name {component}");
                return Err(inquiry.refused(message, format!("remove --{option}, or correct the headings"), 0));
            }
            inquiry.note("measured errors: named by the headings", 0);
            component
        }
        (None, None, said, stated) => {
            let Some(axis) = said.or(stated.map(|(axis, _)| axis)) else {
                return Err(rest(inquiry, &facts));
            };
            match stated {
                Some((stated, line)) if stated != axis => {
                    let message = format!("--axis {} contradicts the file", char::from(axis.letter()));
                    return Err(inquiry.refused(message, "correct the option, or the file", line));
                }
                Some((_, line)) if said.is_none() => inquiry.note(format!("axis: {}", char::from(axis.letter())), line),
                _ => inquiry.note(format!("axis: --axis {}", char::from(axis.letter())), 0),
            }
            if let Some(line) = facts.other_quantity {
                let sentence = format!(
                    "line {line} mentions a straightness or an angle, and the file does not name its component"
                );
                inquiry.ask(
                    "component",
                    sentence,
                    format!(
                        "the error, such as E{0}{0} for positioning or EY{0} for a straightness",
                        char::from(axis.letter())
                    ),
                );
            } else {
                inquiry.note(
                    format!(
                        "measured error: positioning of {} (use --component for others)",
                        char::from(axis.letter())
                    ),
                    0,
                );
            }
            MeasuredComponent::positioning(axis)
        }
    };
    let machine = inquiry.machine;
    body_sense(inquiry, machine, component)?;
    let axis = component.axis;
    let target_unit = match facts.target_unit {
        Some((unit, line)) if unit.is_angle() != axis.is_rotary() => {
            let message = format!(
                "the targets are in {}, which is no unit of the positions of {}",
                unit.sign(),
                char::from(axis.letter())
            );
            return Err(inquiry.refused(message, "check --axis and the columns", line));
        }
        Some((unit, line)) => {
            inquiry.note(format!("unit of the targets: {}", unit.sign()), line);
            unit
        }
        None if axis.is_rotary() => ReadingUnit::Angle("deg", std::f64::consts::PI / 180.0),
        None => ReadingUnit::Length("mm", 1.0),
    };
    if facts.target_unit.is_none() {
        inquiry.note(
            format!("unit of the targets: {} is assumed; all targets are within the travel", target_unit.sign()),
            0,
        );
    }
    let largest = found.iter().map(|reading| reading.value.abs()).fold(0.0, f64::max);
    let unit = inquiry.unit(facts.unit, component.is_angle(), largest)?;
    check_runs(inquiry, &found, unit)?;
    if facts.target_unit.is_none() && unit == ReadingUnit::Length("inch", 25.4) {
        let sentence = "the readings are in inches, and the file does not state the unit of the targets";
        inquiry.ask("columns", sentence, "the meaning of each column with the unit, such as target [inch],1+,1-");
    }
    let letter = char::from(axis.letter());
    let question = if component.is_positioning() {
        format!(
            "the file does not state the sign of its readings: is {letter} too far in the positive direction where a reading is positive?"
        )
    } else if component.is_angle() {
        format!(
            "the file does not state the sign of its readings: is the tool turned about +{} (right-hand rule), seen from the workpiece, where a reading is positive?",
            ['X', 'Y', 'Z'][component.direction % 3]
        )
    } else {
        format!(
            "the file does not state the sign of its readings: is the tool too far in +{}, seen from the workpiece, where a reading is positive?",
            component.letter()
        )
    };
    let sign = inquiry.sign(facts.sign, &question)?;
    let tool = if component.is_angle()
        && found.iter().all(|reading| reading.component.is_none_or(MeasuredComponent::is_angle))
    {
        ncfix_base::geometry::Vector::zeros()
    } else {
        inquiry.tool()
    };
    let is_length = component.is_positioning() && !component.is_angle();
    let stretch = if is_length { inquiry.material("the scale of the axis")?.stretch() } else { 0.0 };
    let position =
        |target: f64| if axis.is_rotary() { target_unit.inner(target).to_degrees() } else { target_unit.inner(target) };
    let zero = inquiry.given(axis).unwrap_or(0.0);
    if inquiry.given(axis).is_some() {
        inquiry.note(format!("target 0 of the file is {letter} {zero} of the machine (--at)"), 0);
    } else {
        inquiry.note("targets are machine coordinates", 0);
    }
    let span = found
        .iter()
        .map(|reading| position(reading.target))
        .fold([f64::MAX, f64::MIN], |[low, high], at| [low.min(at), high.max(at)]);
    if found.len() > 2 && span[1] - span[0] < 1.0 {
        let message = format!("the targets span only {}: the columns may be swapped", shown(span[1] - span[0]));
        return Err(inquiry.refused(
            message,
            "name the columns with --columns",
            facts.target_unit.map_or(0, |(_, line)| line),
        ));
    }
    let columns: Vec<&'static str> = match found
        .iter()
        .map(|reading| reading.component.unwrap_or(component).is_angle())
        .fold((false, false), |(lengths, angles), is_angle| (lengths || !is_angle, angles || is_angle))
    {
        (true, true) => vec!["value_um", "value_urad"],
        (false, true) => vec!["value_urad"],
        _ => vec!["value_um"],
    };
    let mut out = ImportedReadings::new(ImportedKind::Direct, vec![axis], columns);
    out.fixed = inquiry.other_positions(&[axis]);
    out.tool_mm = [tool[0], tool[1], tool[2]];
    out.sigma = inquiry.answers.sigma;
    if found.iter().all(|reading| reading.sense.is_none()) {
        let note = "direction of approach: from the order of the rows; an end target that is read twice is the turn";
        inquiry.note(note, 0);
    }
    let mut worst: Option<(f64, f64, MeasuredComponent)> = None;
    for reading in found {
        let own = reading.component.unwrap_or(component);
        if own.axis != axis {
            return Err(inquiry.refused(
                format!("{own} and {component} are errors of different axes"),
                "import them from a file for each axis",
                reading.line,
            ));
        }
        let is_angle = own.is_angle();
        // A table with lengths and angles has each column in its own unit.
        let Some(own_unit) = reading.unit.or((unit.is_angle() == is_angle).then_some(unit)) else {
            let message = format!("the heading of {own} states no unit, and {} is none of it", unit.sign());
            return Err(inquiry.refused(message, "write the units into the headings, such as EBX [arcsec]", 0));
        };
        if own_unit.is_angle() != is_angle {
            let message = format!("{} is not a unit of {own}", own_unit.sign());
            return Err(inquiry.refused(message, "correct the heading", 0));
        }
        let at = position(reading.target);
        let mut fine = sign * own_unit.fine(reading.value);
        if own.is_positioning() && !is_angle {
            fine -= um_from_mm(stretch * at);
        }
        if worst.is_none_or(|(most, _, _): (f64, _, _)| fine.abs() > most.abs()) {
            worst = Some((fine, at + zero, own));
        }
        let value = Some(fine * body_sense(inquiry, machine, own)?);
        let values = if out.value_columns.len() == 1 {
            vec![value]
        } else if is_angle {
            vec![None, value]
        } else {
            vec![value, None]
        };
        out.rows.push(ImportedRow {
            run: reading.run,
            position: vec![at + zero],
            sense: reading.sense,
            label: own.to_string(),
            values,
            line: reading.line,
        });
    }
    if let Some((fine, at, own)) = worst {
        out.sign_sentence = sentence(fine, at, own);
    }
    Ok(out)
}

/// Describes a reading so that a person can check its sign.
fn sentence(fine: f64, at: f64, component: MeasuredComponent) -> String {
    let place = format!("at {} {} ", char::from(component.axis.letter()), shown(at));
    let size = format!("{:.1}", fine.abs());
    let mark = if fine < 0.0 { '-' } else { '+' };
    if component.is_positioning() {
        let unit = if component.is_angle() {
            format!("{size} µrad ({:.1}\")", fine.abs() / urad_from_rad(std::f64::consts::PI / 648_000.0))
        } else {
            format!("{size} µm")
        };
        let how = if fine < 0.0 { "less" } else { "more" };
        return format!("{place}the true position is {unit} {how} than commanded ({mark})");
    }
    let letter = ['X', 'Y', 'Z'][component.direction % 3];
    if component.is_angle() {
        format!(
            "{place}the tool is turned by {size} µrad about {mark}{letter} (right-hand rule), seen from the workpiece"
        )
    } else {
        format!("{place}the tool is {size} µm too far in {mark}{letter}, seen from the workpiece")
    }
}
