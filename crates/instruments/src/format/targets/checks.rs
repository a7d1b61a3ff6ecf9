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
pub(super) fn check_runs(inquiry: &Inquiry<'_>, found: &[TargetReading], unit: ReadingUnit) -> Result<(), ImportStop> {
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
