//! Stored pitch error compensation of FANUC controls: a function of each axis over its own position, in increments.
//!
//! The points of an axis are a parameter 3624 apart, and point 3620 is the reference position (machine position 0). The value at point n belongs to
//! the section from point n − 1 to point n: it is the CHANGE of the correction there, in detection units times the magnification 3623. So the
//! correction at a point is the sum of the values between it and the reference position, where it is 0. 3621 is the lowest point with a value: the one
//! after the start of the travel; 3622 is the highest. (FANUC Series 0i-PB, Parameter Manual B-63980EN, parameters 3620 to 3625 and their examples:
//! −400 to 800 mm every 50 mm with reference 40 has points 33 to 56; a rotary axis every 45° with reference 60 has points 61 to 68, whose values add
//! up to 0, and point 60 has the value of point 68.)
//!
//! The form in which a control punches the values is not public. This is a list with the parameters by their numbers, for entry by hand or for the
//! loader of the machine builder.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::LazyLock;

use super::limits::{FormatLimits, Holds};
use super::plain::{inputs, sum, weigh};
use super::scan::{MOST_POINTS, Report, ScannedLine, cells, lines, shown};
use super::{Format, Written, rounded};
use crate::tables::{Lookup, Nodes, Sense, Tables, Wiring};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::Axis;
use ncfix_base::pattern::{RegexSet, patterns};
use ncfix_base::source::{Source, Span};

/// Detection unit of an axis in the increment system IS-B, mm and degrees (the usual one; parameter 1013).
const UNIT: f64 = 1e-3;
/// Largest value of a point, in units of the magnification (0i-PB, "−7 to +7").
const MOST_VALUE: i64 = 7;
/// Largest magnification (parameter 3623).
const MOST_MAGNIFICATION: i64 = 100;
/// These limits in words.
const FURTHER: &str =
    "128 values for an axis, 1024 points for all, a change of 7 x 100 detection units between two points";
/// Largest number of values of an axis, and numbers of points of all axes: 0 to 1023.
const MOST_VALUES: usize = 128;
const MOST_NUMBERS: usize = 1024;
/// Decimals of positions and corrections.
const DECIMALS: usize = 6;
/// A turn, degrees.
const TURN: f64 = 360.0;
/// Header of the parameters, and of the values.
const PARAMETER_HEAD: &str = "parameter axis value";
const VALUE_HEAD: &str = "number axis position value";
/// Parameters of an axis: reference point, lowest, highest, magnification, interval.
const PARAMETERS: [usize; 5] = [3620, 3621, 3622, 3623, 3624];
/// Parameter of the travel of a rotary axis in a turn.
const PER_TURN: usize = 3625;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "pitch",
    title: "FANUC stored pitch error compensation",
    sign: "assumed: a positive value moves the axis further in the positive direction between two points, in detection units; the sign is not known, try one value",
    holds: &[Holds::Own, Holds::Repetition],
    // The limits hold for values and numbers, which `faults` knows; the detection unit is that of IS-B.
    limits: FormatLimits { tables: 0, points: 0, value_mm: 0.0, resolution_mm: UNIT, further: FURTHER },
    round,
    faults,
    write,
    read,
    numbers: super::without_numbers,
    beside: &[],
    sum_limit: None,
    has_axis_numbers: false,
    is_mine,
};

/// The interval of points for a table with this many over a range: whole detection units.
fn interval_of(range: f64, points: usize) -> f64 {
    let steps = points.saturating_sub(1).max(1) as f64;
    rounded((range / steps / UNIT).ceil().max(1.0) * UNIT, DECIMALS)
}

/// The interval that divides a turn into at least this many steps: whole detection units.
fn interval_of_turn(steps: usize) -> f64 {
    let units = (TURN / UNIT).round() as usize;
    let count = (steps.max(2)..=MOST_POINTS).find(|count| units.is_multiple_of(*count)).unwrap_or(steps.max(2));
    rounded((units / count.max(1)) as f64 * UNIT, DECIMALS)
}

/// Moves the points to multiples of the interval from the reference position, and rounds the corrections to sums of values.
fn round(tables: &mut Tables) {
    weigh(tables);
    let mut all = Vec::new();
    for axis in inputs(tables) {
        let group: Vec<&Lookup> = tables.lookups.iter().filter(|one| one.input == axis).collect();
        let fits = |one: &&Lookup| {
            one.factor.is_none()
                && one.output == axis
                && one.sense == Sense::Both
                && one.values.len() == one.nodes.count()
                && one.values.len() <= MOST_POINTS
                && one.values.iter().all(|value| value.is_finite())
        };
        let turns: Vec<bool> = group.iter().map(|one| one.modulo).collect();
        if !group.iter().all(fits) || turns.windows(2).any(|pair| pair[0] != pair[1]) {
            // Not supported by the format: kept for the check to report it.
            all.extend(group.into_iter().cloned());
            continue;
        }
        let range = group
            .iter()
            .map(|one| one.nodes.range())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |most, one| [most[0].min(one[0]), most[1].max(one[1])]);
        let points = group.iter().map(|one| one.values.len()).max().unwrap_or(2);
        let modulo = turns.first() == Some(&true);
        let own = match &group[..] {
            [one] => even_interval(one),
            _ => None,
        };
        let (interval, low, high) = if modulo {
            let divides = |interval: &f64| ((TURN / interval) - (TURN / interval).round()).abs() < 1e-9;
            let interval = own.filter(divides).unwrap_or_else(|| interval_of_turn(points.saturating_sub(1)));
            (interval, 0.0, TURN)
        } else {
            let interval = own.unwrap_or_else(|| interval_of(range[1] - range[0], points));
            // The reference position lies inside, with a section on either side of it.
            let low = (range[0] / interval + 1e-6).floor().min(-1.0) * interval;
            (interval, low, (range[1] / interval - 1e-6).ceil().max(1.0) * interval)
        };
        let count = ((high - low) / interval).round();
        if !(1.0..=MOST_POINTS as f64).contains(&count) {
            all.extend(group.into_iter().cloned());
            continue;
        }
        let nodes = Nodes::Even { start: rounded(low, DECIMALS), step: interval, end: rounded(high, DECIMALS) };
        let positions: Vec<f64> = (0..=count as usize).map(|index| nodes.position(index)).collect();
        let Some(exact) = sum(&group, &positions, 9).into_iter().next() else { continue };
        let zero: f64 = group.iter().map(|one| one.value(0.0)).sum();
        let mut corrections: Vec<f64> = exact.values.iter().map(|value| value - zero).collect();
        if modulo && let Some(last) = corrections.last_mut() {
            // The values of a turn add up to 0.
            *last = 0.0;
        }
        let values = match quantized(&corrections, &positions) {
            Some((magnification, sums)) => {
                sums.into_iter().map(|sum| rounded((sum * magnification) as f64 * UNIT, DECIMALS)).collect()
            }
            None => corrections.into_iter().map(|value| rounded(value, DECIMALS)).collect(),
        };
        all.push(Lookup { modulo, ..Lookup::added(axis, axis, nodes, values) });
    }
    if tables.lookups.iter().all(|one| one.factor.is_none()) {
        tables.lookups = all;
    }
}

/// The interval of a table whose points the control can have as they are.
fn even_interval(one: &Lookup) -> Option<f64> {
    let Nodes::Even { start, step, end } = one.nodes else { return None };
    let is_whole = |value: f64| (value - value.round()).abs() < 1e-6;
    let units = step / UNIT;
    (units >= 1.0 && is_whole(units) && is_whole(start / step) && is_whole(end / step))
        .then(|| rounded(units.round() * UNIT, DECIMALS))
}

/// The smallest magnification with which every value fits, and the corrections as sums of values. The sums are rounded, not the values: so the error
/// of rounding does not grow along the axis.
fn quantized(corrections: &[f64], positions: &[f64]) -> Option<(i64, Vec<i64>)> {
    let zero = positions.iter().position(|position| position.abs() < UNIT / 2.0)?;
    (1..=MOST_MAGNIFICATION).find_map(|magnification| {
        let unit = UNIT * magnification as f64;
        let mut sums: Vec<i64> = Vec::new();
        for correction in corrections {
            let whole = (correction / unit).round();
            // No plausible correction is longer than a meter.
            sums.push(if whole.abs() < 1e6 { whole as i64 } else { return None });
        }
        *sums.get_mut(zero)? = 0;
        sums.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= MOST_VALUE).then_some((magnification, sums))
    })
}

/// The parameters and values of an axis.
struct PitchTable {
    axis: Axis,
    interval: f64,
    magnification: i64,
    /// Position of the first point, in intervals from the reference position.
    first: i64,
    /// Value of each section.
    values: Vec<i64>,
    modulo: bool,
}

impl PitchTable {
    /// The table of a rounded lookup; the reason if the control cannot hold it.
    fn of(one: &Lookup) -> Result<PitchTable, String> {
        let axis = one.input;
        let points = || format!("the points of {axis} are not multiples of an interval from the machine position 0");
        let Nodes::Even { start, step, .. } = one.nodes else { return Err(points()) };
        let first = (start / step).round();
        if step <= 0.0
            || !first.is_finite()
            || (first * step - start).abs() > UNIT / 2.0
            || first.abs() > MOST_POINTS as f64
        {
            return Err(points());
        }
        if one.values.len() > MOST_VALUES + 1 {
            let count = one.values.len() - 1;
            return Err(format!("{axis} needs {count} values, but the control allows {MOST_VALUES} for an axis"));
        }
        let positions: Vec<f64> = (0..one.values.len()).map(|index| one.nodes.position(index)).collect();
        let Some((magnification, sums)) = quantized(&one.values, &positions) else {
            return Err(format!(
                "{axis} needs a change of more than {MOST_VALUE} x {MOST_MAGNIFICATION} detection units between two points"
            ));
        };
        let values = sums.windows(2).map(|pair| pair[1] - pair[0]).collect();
        Ok(PitchTable { axis, interval: step, magnification, first: first as i64, values, modulo: one.modulo })
    }

    /// Number of numbers that it takes.
    fn numbers(&self) -> usize {
        self.values.len() + 1
    }
}

fn faults(tables: &Tables, _: &Wiring) -> Vec<String> {
    let mut faults = Vec::new();
    let mut numbers = 0;
    for (index, one) in tables.lookups.iter().enumerate() {
        if one.input != one.output || one.factor.is_some() || one.sense != Sense::Both {
            continue;
        }
        if tables.lookups.iter().take(index).any(|other| other.input == one.input) {
            faults.push(format!("{} has a second table", one.input));
        }
        match PitchTable::of(one) {
            Ok(table) => numbers += table.numbers(),
            Err(why) => faults.push(why),
        }
    }
    if numbers > MOST_NUMBERS {
        faults.push(format!("{numbers} points are needed, but the control has {MOST_NUMBERS}"));
    }
    faults
}

fn write(tables: &Tables, _: &Wiring, notes: &[String]) -> Vec<Written> {
    let mut text = String::new();
    for note in notes {
        let _ = writeln!(text, "# {note}");
    }
    let _ = writeln!(text, "# detection unit {UNIT} mm or degrees (IS-B): with another one, convert the values");
    let _ = writeln!(text, "# position is that of the end of the section; the reference position is 0");
    let _ = writeln!(text, "{}", PARAMETER_HEAD.replace(' ', ","));
    let mut values = String::new();
    let mut number = 1;
    for table in tables.lookups.iter().filter_map(|one| PitchTable::of(one).ok()) {
        let count = table.values.len();
        // Number of the point at which the first section begins. A turn begins at the reference position.
        let reference = number + table.first.unsigned_abs() as usize;
        let lowest = if table.modulo { reference } else { number + 1 };
        let parameters = [reference, lowest, number + count].map(|one| one.to_string());
        let [reference, lowest, highest] = parameters;
        let rest = [table.magnification.to_string(), rounded(table.interval, DECIMALS).to_string()];
        for (parameter, value) in PARAMETERS.iter().zip([reference, lowest, highest].into_iter().chain(rest)) {
            let _ = writeln!(text, "{parameter},{},{value}", table.axis);
        }
        if table.modulo {
            let _ = writeln!(text, "{PER_TURN},{},{TURN}", table.axis);
            // The point of the reference position has the value of the last one.
            let last = table.values.last().copied().unwrap_or_default();
            let _ = writeln!(values, "{number},{},0,{last}", table.axis);
        }
        for (index, value) in table.values.iter().enumerate() {
            let at = rounded((table.first + index as i64 + 1) as f64 * table.interval, DECIMALS);
            let _ = writeln!(values, "{},{},{at},{value}", number + index + 1, table.axis);
        }
        number += table.numbers();
    }
    let _ = write!(text, "{}\n{values}", VALUE_HEAD.replace(' ', ","));
    vec![Written { suffix: String::new(), text }]
}

fn is_mine(_: &str, bytes: &[u8]) -> bool {
    static MARK: LazyLock<RegexSet> = LazyLock::new(|| patterns(["(?-i)parameter,axis,value"]));
    MARK.is_match(bytes)
}

/// Parameters and values of an axis, as in the file.
#[derive(Default)]
struct PitchEntries {
    parameters: BTreeMap<usize, f64>,
    /// Value and stated position by number.
    values: BTreeMap<usize, (f64, f64)>,
    span: Span,
}

fn read(source: &Source, wiring: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
    let mut report = Report::new(source);
    let mut axes: BTreeMap<Axis, PitchEntries> = BTreeMap::new();
    let mut in_values = false;
    for line in lines(source) {
        let text = line.before('#').trim();
        if text.is_empty() || cells(text).eq(cells(PARAMETER_HEAD)) {
            continue;
        }
        if cells(text).eq(cells(VALUE_HEAD)) {
            in_values = true;
        } else {
            row(&line, text, in_values, wiring, &mut axes, &mut report);
        }
        if report.is_hopeless() {
            break;
        }
    }
    if axes.is_empty() && !report.has_fault() {
        let help = "write rows of parameter,axis,value, then rows of number,axis,position,value";
        report.empty("the file has no pitch error compensation", help);
    }
    let mut found = Vec::new();
    for (axis, raw) in &axes {
        found.extend(lookup(*axis, raw, &mut report));
    }
    if let Some(one) = found.iter().find(|one| tables.lookups.iter().any(|other| other.input == one.input)) {
        report.empty(&format!("{} has a table already", one.input), "an axis has one stored pitch error compensation");
    }
    let mut ranges: Vec<(usize, usize, Axis)> = axes.iter().filter_map(|(axis, raw)| raw.range(*axis)).collect();
    ranges.sort_unstable();
    for pair in ranges.windows(2).filter(|pair| pair[0].1 >= pair[1].0) {
        let message = format!("{} and {} use the same numbers of points", pair[0].2, pair[1].2);
        report.empty(&message, "give each axis its own numbers: 3621 of one above 3622 of the other");
    }
    if !report.has_fault() {
        tables.lookups.extend(found);
    }
    report.findings
}

impl PitchEntries {
    /// Its numbers of points, as far as they are known.
    fn range(&self, axis: Axis) -> Option<(usize, usize, Axis)> {
        let [low, high] = [self.values.keys().next()?, self.values.keys().next_back()?];
        Some((*low, *high, axis))
    }
}

/// A row of the file.
fn row(
    line: &ScannedLine<'_>,
    text: &str,
    in_values: bool,
    wiring: &Wiring,
    axes: &mut BTreeMap<Axis, PitchEntries>,
    report: &mut Report<'_>,
) {
    let head = if in_values { VALUE_HEAD } else { PARAMETER_HEAD };
    let parts: Vec<&str> = cells(text).take(6).collect();
    if parts.len() != cells(head).count() {
        let message = format!("'{}' is not a row of {}", shown(text), head.replace(' ', ","));
        report.fault(line, text, message, "write a cell for each name, with a decimal point");
        return;
    }
    let number = parts[0].parse::<usize>().ok();
    let is_known = |number: &usize| {
        if in_values { *number < MOST_NUMBERS } else { PARAMETERS.contains(number) || *number == PER_TURN }
    };
    let Some(number) = number.filter(is_known) else {
        let help = "parameters are 3620 to 3625, numbers of points 0 to 1023";
        report.fault(line, parts[0], format!("'{}' is no number of this list", shown(parts[0])), help);
        return;
    };
    let Some(axis) = wiring.axis(parts[1]) else {
        let help = "write the letter of an axis, or name it with --axis-name";
        report.fault(line, parts[1], format!("no axis has the name {}", shown(parts[1])), help);
        return;
    };
    let numbers: Option<Vec<f64>> = parts[2..].iter().map(|part| report.number(line, part)).collect();
    let Some(numbers) = numbers else { return };
    let raw = axes.entry(axis).or_insert_with(|| PitchEntries { span: line.span(text), ..PitchEntries::default() });
    let is_twice = match numbers[..] {
        [position, value] => raw.values.insert(number, (position, value)).is_some(),
        [value] => raw.parameters.insert(number, value).is_some(),
        _ => false,
    };
    if is_twice {
        report.fault(line, text, format!("{number} of {axis} is given twice"), super::TWICE);
    }
}

/// The table of an axis.
fn lookup(axis: Axis, raw: &PitchEntries, report: &mut Report<'_>) -> Option<Lookup> {
    let lacking: Vec<String> =
        PARAMETERS.iter().filter(|one| !raw.parameters.contains_key(one)).map(ToString::to_string).collect();
    if !lacking.is_empty() {
        let message = format!("{axis} has no parameter {}", lacking.join(", "));
        report.fault_at(raw.span, message, "write parameters 3620 to 3624 of each axis, as they are in the control");
        return None;
    }
    let of = |number: usize| raw.parameters.get(&number).copied().unwrap_or_default();
    let [reference, lowest, highest, magnification, interval] = PARAMETERS.map(of);
    let is_number = |value: f64| value.fract() == 0.0 && (0.0..MOST_NUMBERS as f64).contains(&value);
    let is_factor = magnification.fract() == 0.0 && (1.0..=MOST_MAGNIFICATION as f64).contains(&magnification);
    let is_interval = (UNIT..1e5).contains(&interval);
    let is_order = lowest <= reference && reference < highest;
    if ![reference, lowest, highest].into_iter().all(is_number) || !is_factor || !is_interval || !is_order {
        let message = format!(
            "{axis} has points {lowest} to {highest} with the reference {reference}, magnification {magnification}, interval {interval}"
        );
        let help = "3621 is at most 3620, and 3620 is below 3622; the magnification is 1 to 100, the interval above 0";
        report.fault_at(raw.span, message, help);
        return None;
    }
    let per_turn = raw.parameters.get(&PER_TURN).copied();
    let modulo = per_turn.is_some_and(|turn| turn != 0.0);
    if modulo && (!axis.is_rotary() || per_turn != Some(TURN) || (highest - reference) * interval != TURN) {
        let message = format!("3625 of {axis} does not fit: {} intervals of {interval}", highest - reference);
        report.fault_at(raw.span, message, "a turn is 360, from the reference point to 3622; only a rotary axis turns");
        return None;
    }
    let [reference, lowest, highest] = [reference, lowest, highest].map(|one| one as usize);
    // The section of a point begins at the point below. A turn begins at the reference position.
    let begin = if modulo { reference as i64 } else { lowest as i64 - 1 };
    let mut sums = vec![0_i64];
    for number in begin + 1..=highest as i64 {
        let found = usize::try_from(number).ok().and_then(|number| raw.values.get(&number));
        let Some(&(position, value)) = found else {
            report.fault_at(raw.span, format!("point {number} of {axis} has no value"), super::KEEPS);
            return None;
        };
        let expected = (number - reference as i64) as f64 * interval;
        if (position - expected).abs() > UNIT {
            let message = format!("point {number} of {axis} lies at {expected}, not at {position}");
            report.fault_at(raw.span, message, "correct the parameters, or the position");
            return None;
        }
        if value.fract() != 0.0 || value.abs() > 128.0 {
            let message = format!("the value {value} of point {number} of {axis} is not a whole number of -128 to 127");
            report.fault_at(raw.span, message, "write the value as the control shows it");
            return None;
        }
        sums.push(sums.last().copied().unwrap_or_default() + value as i64);
    }
    let surplus = raw.values.range(..lowest).chain(raw.values.range(highest + 1..)).count();
    if surplus > 0 {
        let message = format!("{surplus} values of {axis} are outside 3621 to 3622 and are not used");
        report.unused_at(raw.span, message, "the control ignores them too");
    }
    let zero = usize::try_from(reference as i64 - begin).ok().and_then(|index| sums.get(index)).copied().unwrap_or(0);
    if modulo && sums.last() != Some(&0) {
        let message = format!("the values of a turn of {axis} add up to {}", sums.last().copied().unwrap_or_default());
        report.fault_at(raw.span, message, "the sum must be 0, or each turn adds to the position");
        return None;
    }
    let unit = UNIT * magnification;
    let values = sums.into_iter().map(|sum| rounded((sum - zero) as f64 * unit, DECIMALS)).collect();
    let at = |number: i64| rounded((number - reference as i64) as f64 * interval, DECIMALS);
    let nodes = Nodes::Even { start: at(begin), step: rounded(interval, DECIMALS), end: at(highest as i64) };
    Some(Lookup { modulo, ..Lookup::added(axis, axis, nodes, values) })
}
