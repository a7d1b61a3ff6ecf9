//! Rows of imported readings as a whole, for all layouts: rows that are given twice, and places at which a reading is missing.

use std::collections::{BTreeMap, HashMap};

use ncfix_base::diagnostic::{Code, Diagnostic};

use crate::readings::{ImportedKind, ImportedReadings, ImportedRow, shown};
use crate::text::DecodedText;

/// Most targets whose runs are compared: more are those of a continuous measurement.
const MOST_TARGETS: usize = 2000;

/// Most places that a sentence names.
const MOST_NAMED: usize = 6;

/// Share of the steps that must be equal before a longer one counts as a gap.
const REGULAR: f64 = 0.7;

/// Least number of steps of such a sequence.
const REGULAR_STEPS: usize = 4;

/// Steps that count as equal to the usual one: targets of ISO 230-2 vary.
const EQUAL: std::ops::RangeInclusive<f64> = 0.6..=1.4;

/// Deviation from a multiple of the usual step, as a share of it, up to which a sequence is exact.
const EXACT: f64 = 0.01;

/// Share of the steps of an exact sequence that must be the usual one.
const EXACT_SHARE: f64 = 0.5;

/// Least number of steps of an exact sequence.
const EXACT_STEPS: usize = 3;

/// Length of a step, as a multiple of the usual one, above which a place is missing.
const LONG: f64 = 1.6;

/// Share of the nodes of a grid that must have a point before the others count as missing.
const FILLED: f64 = 0.6;

/// Distance below which two coordinates are one line of a grid, as a share of the span.
const SAME_LINE: f64 = 2e-3;

/// Longest part of a circle without readings, as a multiple of the usual step.
const ARC_STEPS: f64 = 2.5;

/// Longest arc of a ball-bar test that is no whole circle, degrees: those of 220° are usual.
const ARC_DEG: f64 = 225.0;

/// Lines of the first two rows that are copies: the same run, place, readings, and time, temperatures and other drivers. Rows of one error component count only if the file states run and
/// direction, because rounded readings of a target repeat. On a circle only neighbors count, because its start and its end may agree.
fn copied(readings: &ImportedReadings) -> Option<[usize; 2]> {
    type Key<'a> = (&'a str, &'a str, Option<i8>, Vec<u64>);
    let key = |row: &'_ ImportedRow| -> Vec<u64> {
        let values = row.values.iter().chain(&row.extra).map(|value| value.unwrap_or(f64::NAN));
        row.position.iter().copied().chain(values).map(f64::to_bits).collect()
    };
    let mut seen: HashMap<Key<'_>, usize> = HashMap::new();
    let mut last: Option<Key<'_>> = None;
    for row in &readings.rows {
        if readings.kind == ImportedKind::Direct && (row.run.is_empty() || row.sense.is_none()) {
            continue;
        }
        let own: Key<'_> = (&row.run, &row.label, row.sense, key(row));
        let is_neighbor = last.as_ref() == Some(&own);
        last = Some(own.clone());
        let first = seen.insert(own, row.line);
        if let Some(first) = first.filter(|_| is_neighbor || readings.kind != ImportedKind::BallBar) {
            return Some([first, row.line]);
        }
    }
    None
}

/// Checks that no row is a copy of another one. Balls that are probed again may be at the same position.
///
/// # Errors
/// The second row, with the line of the first one.
pub(crate) fn check_copies(readings: &ImportedReadings, text: &DecodedText) -> Result<(), Box<Diagnostic>> {
    let found = copied(readings).filter(|_| readings.kind != ImportedKind::Probe);
    found.map_or(Ok(()), |[first, second]| {
        let message = format!("the reading is the same as that in line {first}, to the last digit");
        let help = "remove one of them: a repetition would differ by the noise of the instrument; if it is one, give it a run of its own";
        Err(Box::new(Diagnostic::at(Code::DATA_REPEATED, text.place(second), message, help)))
    })
}

/// Sentences that name the places without a reading.
pub(crate) fn gaps(readings: &ImportedReadings) -> Vec<String> {
    match readings.kind {
        ImportedKind::Direct => missing_targets(readings),
        ImportedKind::Displacement => missing_points(readings),
        ImportedKind::BallBar | ImportedKind::Probe => Vec::new(),
    }
}

/// Sentences that name the arcs of a circle without readings. `angles_deg` are those of a run in the order of its motion.
pub(crate) fn missing_arcs(run: &str, angles_deg: &[f64], stated_deg: Option<[f64; 2]>) -> Vec<String> {
    let name = if run.is_empty() { "the circle".to_owned() } else { format!("run {run}") };
    let mut steps: Vec<f64> =
        angles_deg.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0).collect();
    if steps.len() < REGULAR_STEPS {
        return Vec::new();
    }
    steps.sort_by(f64::total_cmp);
    let usual = steps[steps.len() / 2];
    // Times and coarse circles vary by more than the targets of a laser.
    let least = ARC_STEPS * usual;
    let mut found = Vec::new();
    let mut say =
        |from: f64, to: f64| found.push(format!("{name} has no reading between {}° and {}°", degree(from), degree(to)));
    for pair in angles_deg.windows(2) {
        // A step across 360° is a short one.
        if (least..360.0 - least).contains(&(pair[1] - pair[0]).abs()) {
            say(pair[0], pair[1]);
        }
    }
    let (low, high) = angles_deg.iter().fold((f64::MAX, f64::MIN), |(low, high), deg| (low.min(*deg), high.max(*deg)));
    let [from, to] = stated_deg.map_or([low, low + 360.0], |[one, other]| [one.min(other), one.max(other)]);
    if low - from > least {
        say(from, low);
    }
    if to - high > least && (stated_deg.is_some() || high - low > ARC_DEG) {
        say(high, to);
    }
    found
}

fn degree(value: f64) -> String {
    shown((value * 10.0).round() / 10.0)
}

/// True if the second values of pairs are round numbers and the first ones are not, so that nominal and actual values are exchanged.
pub(crate) fn is_exchanged(pairs: &[(f64, f64)]) -> bool {
    /// Fewest pairs that differ, their share that must be in the wrong order, and the decimals by which they differ.
    const EVIDENCE: (usize, f64, usize) = (4, 0.8, 2);
    let differ = || pairs.iter().filter(|(first, second)| first != second);
    let count = differ().count();
    let wrong = differ().filter(|(first, second)| decimals(*first) >= decimals(*second) + EVIDENCE.2).count();
    count >= EVIDENCE.0 && wrong as f64 >= EVIDENCE.1 * count as f64
}

/// Number of decimals that a number needs, at most six.
fn decimals(value: f64) -> usize {
    shown(value).split_once('.').map_or(0, |(_, digits)| digits.len())
}

/// Names places, at most six of them.
fn listed(places: &[String]) -> String {
    let more = places.len().saturating_sub(MOST_NAMED);
    let dots = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{dots}", places.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>().join(", "))
}

/// Places between the values of a regular sequence that it lacks. Its steps are alike, or exact multiples of the usual one.
fn between(values: &[f64]) -> Vec<f64> {
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.len() < EXACT_STEPS {
        return Vec::new();
    }
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    if usual <= 0.0 {
        return Vec::new();
    }
    let share = |is_equal: &dyn Fn(f64) -> bool| {
        steps.iter().filter(|step| is_equal(**step / usual)).count() as f64 / steps.len() as f64
    };
    let is_alike = steps.len() >= REGULAR_STEPS && share(&|step| EQUAL.contains(&step)) >= REGULAR;
    let is_exact = share(&|step| (step - step.round()).abs() <= EXACT && step > 0.5) == 1.0
        && share(&|step| (step - 1.0).abs() <= EXACT) >= EXACT_SHARE;
    if !is_alike && !is_exact {
        return Vec::new();
    }
    let mut found = Vec::new();
    for (step, start) in steps.iter().zip(values).filter(|(step, _)| **step > LONG * usual) {
        let parts = (step / usual).round().max(2.0);
        found.extend((1..parts.min(1e3) as u32).map(|k| start + step * f64::from(k) / parts));
    }
    found
}

/// Targets that a run lacks and others have, and targets that the regular sequence of all lacks.
fn missing_targets(readings: &ImportedReadings) -> Vec<String> {
    let letter = readings.axes.first().map_or('X', |axis| char::from(axis.letter()));
    let mut all: Vec<f64> = readings.rows.iter().filter_map(|row| row.position.first().copied()).collect();
    all.sort_by(f64::total_cmp);
    let span = all.last().zip(all.first()).map_or(0.0, |(high, low)| high - low);
    all.dedup_by(|one, other| (*one - *other).abs() <= 1e-6 * span);
    let mut found = Vec::new();
    let places: Vec<String> = between(&all).into_iter().map(|at| format!("{letter} {}", degree(at))).collect();
    if !places.is_empty() {
        found.push(format!("no run has a reading at {}", listed(&places)));
    }
    if all.len() > MOST_TARGETS {
        return found;
    }
    let mut series: BTreeMap<(&str, &str, Option<i8>), Vec<f64>> = BTreeMap::new();
    for row in readings.rows.iter().filter(|row| row.values.iter().any(Option::is_some)) {
        series.entry((&row.run, &row.label, row.sense)).or_default().extend(row.position.first());
    }
    let has = |own: &[f64], target: f64| own.iter().any(|at| (at - target).abs() <= 1e-6 * span);
    let common = |target: f64| 2 * series.values().filter(|own| has(own, target)).count() > series.len();
    let expected: Vec<f64> = all.iter().copied().filter(|target| common(*target)).collect();
    let mut lacking = Vec::new();
    for ((run, _, sense), own) in &series {
        let sign = sense.map_or("", |sense| if sense < 0 { "-" } else { "+" });
        let absent = expected.iter().filter(|target| !has(own, **target));
        lacking.extend(absent.map(|target| format!("{letter} {} in run {run}{sign}", shown(*target))));
    }
    if !lacking.is_empty() {
        found.push(format!("no reading at {}", listed(&lacking)));
    }
    found
}

/// Lines of a grid in one coordinate, from low to high.
fn grid_lines(rows: &[ImportedRow], k: usize) -> Vec<f64> {
    let mut all: Vec<f64> = rows.iter().filter_map(|row| row.position.get(k).copied()).collect();
    all.sort_by(f64::total_cmp);
    let span = all.last().zip(all.first()).map_or(0.0, |(high, low)| high - low);
    let mut lines: Vec<f64> = Vec::new();
    for value in all {
        if lines.last().is_none_or(|last| value - last > SAME_LINE * span) {
            lines.push(value);
        }
    }
    lines
}

/// Nodes without a point, of a grid over the two axes that move most.
fn missing_points(readings: &ImportedReadings) -> Vec<String> {
    let moved: Vec<usize> = (0..readings.axes.len()).filter(|k| grid_lines(&readings.rows, *k).len() > 1).collect();
    let [first, second] = moved[..] else { return Vec::new() };
    let [columns, rows] = [first, second].map(|k| grid_lines(&readings.rows, k));
    let nodes = columns.len() * rows.len();
    if columns.len().min(rows.len()) < 2 || nodes > 16 * readings.rows.len() {
        return Vec::new();
    }
    let [name, other] = [first, second].map(|k| char::from(readings.axes[k].letter()));
    // Nearest line of a grid.
    let near = |lines: &[f64], value: f64| lines.iter().rposition(|line| *line <= value).unwrap_or(0);
    let filled: std::collections::BTreeSet<(usize, usize)> = readings
        .rows
        .iter()
        .filter(|row| row.values.iter().any(Option::is_some))
        .map(|row| (near(&columns, row.position[first]), near(&rows, row.position[second])))
        .collect();
    if (filled.len() as f64) < FILLED * nodes as f64 {
        return Vec::new();
    }
    let mut found = Vec::new();
    for (letter, lines) in [(name, &columns), (other, &rows)] {
        let absent: Vec<String> = between(lines).into_iter().map(|at| format!("{letter} {}", degree(at))).collect();
        if !absent.is_empty() {
            found.push(format!("the grid has no point at {}", listed(&absent)));
        }
    }
    if filled.len() == nodes {
        return found;
    }
    let all = rows.iter().enumerate().flat_map(|(j, y)| columns.iter().enumerate().map(move |(i, x)| (i, j, x, y)));
    let absent = all.filter(|(i, j, ..)| !filled.contains(&(*i, *j)));
    let places: Vec<String> =
        absent.map(|(_, _, x, y)| format!("{name} {} {other} {}", shown(*x), shown(*y))).collect();
    found.push(format!("the grid has no reading at {}", listed(&places)));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_regular_sequence_names_its_gaps() {
        assert_eq!(between(&[0.0, 50.0, 100.0, 150.0, 400.0, 450.0, 500.0, 550.0]), [200.0, 250.0, 300.0, 350.0]);
        assert_eq!(between(&[0.0, 120.0, 180.0, 240.0]), [60.0]);
        // Targets with a random part, a sequence without a usual step, and a short one.
        assert!(between(&[0.0, 48.0, 103.0, 151.0, 197.0, 252.0]).is_empty());
        assert!(between(&[0.0, 1.0, 2.0, 10.0, 30.0, 60.0, 61.0]).is_empty());
        assert!(between(&[0.0, 50.0, 200.0]).is_empty());
    }

    #[test]
    fn round_actual_values_are_exchanged_ones() {
        let right = [(0.0, 0.0312), (80.0, 80.0373), (160.0, 160.0426), (240.0, 240.0475), (0.0, -0.0117)];
        let wrong = right.map(|(nominal, actual)| (actual, nominal));
        assert!(is_exchanged(&wrong) && !is_exchanged(&right) && !is_exchanged(&wrong[..3]));
        // Inches, and calibrated positions of an artifact.
        let inch = [(3.14961, 3.15107), (6.29921, 6.30089), (9.44882, 9.45069), (2.3622, 2.36163)];
        assert!(!is_exchanged(&inch) && !is_exchanged(&inch.map(|(nominal, actual)| (actual, nominal))));
    }

    #[test]
    fn a_circle_names_its_arcs() {
        let all: Vec<f64> = (0..=360).map(f64::from).collect();
        let without: Vec<f64> = all.iter().copied().filter(|deg| !(100.5..149.5).contains(deg)).collect();
        assert!(missing_arcs("1", &all, None).is_empty() && missing_arcs("1", &all[..200], None).is_empty());
        assert_eq!(missing_arcs("1", &without, None), ["run 1 has no reading between 100° and 150°"]);
        assert_eq!(missing_arcs("", &all[..300], None), ["the circle has no reading between 299° and 360°"]);
        assert_eq!(
            missing_arcs("", &all[..200], Some([0.0, 220.0])),
            ["the circle has no reading between 199° and 220°"]
        );
    }
}
