//! Checks of a table of targets against itself: columns that are exchanged, and deviations that are not those of the positions.

use super::facts::{StatedFacts, TargetReading};
use crate::answers::MeasuredComponent;
use crate::grid::GridTable;
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::shown;
use crate::rows;
use crate::unit::ReadingUnit;

/// Checks that the columns of targets and of actual positions are not exchanged: targets are round numbers, actual positions are not.
///
/// # Errors
/// If the actual positions are the round ones, and no option names the columns.
pub(super) fn check_order(inquiry: &Inquiry<'_>, table: &GridTable, columns: [usize; 2]) -> Result<(), ImportStop> {
    let mut pairs = Vec::new();
    for row in &table.rows {
        let [target, actual] = columns;
        pairs.extend(table.value(row, target)?.zip(table.value(row, actual)?));
    }
    if inquiry.answers().columns.is_empty() && rows::is_exchanged(&pairs) {
        let message = "the actual positions are round and the targets are not: the columns may be exchanged";
        let help = "correct the headings, or confirm them with --columns, such as target,actual";
        return Err(inquiry.refused(message, help, table.heading_line));
    }
    Ok(())
}

/// Largest difference of a position and its target, as a share of the span of the targets: a short stage deviates by some percent of its travel.
pub(super) const NEAR: f64 = 0.05;

/// Readings of one run, direction and component.
type Run<'a> = ((&'a str, Option<i8>, Option<MeasuredComponent>), Vec<&'a TargetReading>);

/// The readings by run; `None` for more runs than an instrument makes.
fn runs(found: &[TargetReading]) -> Option<Vec<Run<'_>>> {
    /// Most runs that are compared.
    const MOST: usize = 1000;
    let mut runs: Vec<Run<'_>> = Vec::new();
    for reading in found {
        let key = (reading.run.as_str(), reading.sense, reading.component);
        let count = runs.len();
        match runs.iter_mut().find(|(own, _)| *own == key) {
            Some((_, readings)) => readings.push(reading),
            None if count < MOST => runs.push((key, vec![reading])),
            None => return None,
        }
    }
    Some(runs)
}

/// Name of a run in a sentence: `1+`.
fn name_of((name, sense, _): &(&str, Option<i8>, Option<MeasuredComponent>)) -> String {
    format!("{name}{}", sense.map_or("", |sense| if sense < 0 { "-" } else { "+" }))
}

/// Advice for a run that is not valid.
const INVALID: &str = "check the headings; name the columns with --columns, and write - for a run that is not valid";

/// Checks that no run is a copy of the targets beside runs of positions that were measured. The readings are actual minus target positions.
///
/// # Errors
/// If one is: no reading of it deviates, and most readings of the others do.
pub(super) fn check_copies(inquiry: &Inquiry<'_>, found: &[TargetReading]) -> Result<(), ImportStop> {
    /// Largest deviation of a copy, as a share of the target: the rounding of a difference.
    const SAME: f64 = 1e-12;
    let is_same = |own: &TargetReading| own.value.abs() <= SAME * own.target.abs();
    for (index, (key, readings)) in runs(found).iter().flatten().enumerate() {
        if readings.len() < 4 || !readings.iter().all(|own| is_same(own)) {
            continue;
        }
        let all = runs(found).unwrap_or_default();
        let others = || all.iter().enumerate().filter(|(k, _)| *k != index).flat_map(|(_, (_, own))| own);
        if 2 * others().filter(|own| !is_same(own)).count() > others().count() {
            let message = format!("the readings of run {} are the targets themselves", name_of(key));
            return Err(inquiry.refused(message, INVALID, readings.first().map_or(0, |own| own.line)));
        }
    }
    Ok(())
}

/// Checks that no run is a column of positions beside runs of deviations: its readings spread far more than those of all others, or they follow the targets.
///
/// # Errors
/// If one does.
pub(super) fn check_runs(inquiry: &Inquiry<'_>, found: &[TargetReading], unit: ReadingUnit) -> Result<(), ImportStop> {
    /// Spread of a run that is far, as a multiple of the largest one of the others.
    const FAR: f64 = 8.0;
    /// Smallest spread that is far, µm or µrad: below it the digits of a file decide.
    const LEAST: f64 = 20.0;
    let Some(runs) = runs(found) else { return Ok(()) };
    let span = |readings: &[&TargetReading], of: fn(&TargetReading) -> f64| {
        let ends = readings.iter().fold((f64::MAX, f64::MIN), |(low, high), own| (low.min(of(own)), high.max(of(own))));
        ends.1 - ends.0
    };
    let near = |readings: &[&TargetReading]| NEAR * span(readings, |own| own.target);
    let is_off = |readings: &[&TargetReading], own: &TargetReading| (own.value - own.target).abs() > near(readings);
    let follows =
        |readings: &[&TargetReading]| near(readings) > 0.0 && !readings.iter().any(|own| is_off(readings, own));
    let long: Vec<&Run<'_>> = runs.iter().filter(|(_, own)| own.len() > 3).collect();
    let following = long.iter().filter(|(_, own)| follows(own)).count();
    if let Some((key, readings)) = long.iter().find(|(_, own)| !follows(own)).filter(|_| 2 * following > long.len()) {
        // Positions: the exception is the run that has something else.
        let first = readings.iter().find(|own| is_off(readings, own));
        let (value, target, line) = first.map_or((0.0, 0.0, 0), |own| (own.value, own.target, own.line));
        let message = format!(
            "the readings of most runs are positions near the targets, but run {} has {} at the target {}",
            name_of(key),
            shown(value),
            shown(target)
        );
        return Err(inquiry.refused(message, INVALID, line));
    }
    for (index, (key, readings)) in long.iter().enumerate() {
        let others = long.iter().enumerate().filter(|(k, ((.., other), _))| *k != index && *other == key.2);
        let most = others
            .map(|(_, (_, own))| span(own, |own| own.value))
            .fold(None, |most: Option<f64>, own| Some(most.map_or(own, |most| most.max(own))));
        let is_position = follows(readings);
        let own = span(readings, |own| own.value);
        let is_far = most.is_some_and(|most| own > FAR * most && unit.fine(own) > LEAST);
        if is_position || is_far {
            let why = if is_position { "follow the targets" } else { "spread far more than those of the other runs" };
            let message = format!("the readings of run {} {why}: its column may be that of the targets", name_of(key));
            return Err(inquiry.refused(message, INVALID, readings.first().map_or(0, |own| own.line)));
        }
    }
    Ok(())
}

/// Checks that a deviation is the difference of target and actual position, and learns its sign from that.
pub(super) fn agree(
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
