//! Temperatures that are constant or missing: the same number in consecutive rows despite noise, or empty cells.
//!
//! A logger that ends before the readings repeats its last value, one that pauses holds it, and one that begins late has its first value from the
//! beginning. Only these values are missing: the sensor is good in all other rows. Sensors that stop in the same row have one reason and are one
//! fault.
//!
//! Equal numbers alone prove nothing. A display with few digits is constant at night, and a chiller holds its temperature. The rows beside a range
//! show the usual share of equal neighbors. If it is large, other sensors must have moved, or the sensor must jump when it continues. Otherwise flicker of
//! the display and a regression on the other sensors decide ([`display`]).

use std::collections::BTreeMap;

use super::cells::Sensor;
use super::display;
use super::missing::{self, Extent};
use super::{DataDefect, DefectCheck, DefectKind, Then, View, median};
use crate::measure::data::DataSet;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "stuck sensor",
    made_by: "a logger that ends, pauses or begins late and repeats a value; a bus that is down; empty cells",
    shown_by: "no variance in rows in which noise is expected",
    source: "Spaan 1995, ch. 5: sensors that fail during a day",
    look,
};

/// Minimum number of rows with one number.
const ROWS: usize = 8;
/// If neighbors are often equal, a range is this many times as long as any other.
const TIMES: usize = 5;
/// This ratio for a range without flicker: rest makes ranges of twice the usual length.
const FLICKER_TIMES: f64 = 3.0;
/// This ratio for a range in which a regression on other sensors predicts a change: the longest range of a log by more than chance.
const PREDICTED_TIMES: f64 = 1.5;
/// Ratio of the length of a range in which all sensors are constant to that of any other such range.
const ALONE: usize = 8;
/// Number of pairs of neighbors on each side of a range that are examined.
const PAIRS: usize = 24;
/// Minimum number of pairs.
const FEWEST_PAIRS: usize = 5;
/// Share of equal neighbors above which a display has few digits, or a body is at rest.
const OFTEN: f64 = 0.5;
/// −ln of the probability of a range of equal numbers: 6 · 10⁻⁶, for about 10⁴ rows of a log at which one may begin.
const CHANCE: f64 = 12.0;
/// Smallest share of changes that reverse from row to row with noise; for pure noise it is two thirds.
const REVERSED: f64 = 0.25;
/// Smallest change by noise, in steps of the display.
const NOISE_STEPS: f64 = 1.5;
/// Smallest expected motion of a display, in its steps.
const STEPS: f64 = 3.0;
/// Smallest jump of a sensor that continues after a pause, in its steps.
const JUMP_STEPS: f64 = 5.0;
/// Smallest change of other sensors, K, while a sensor is constant throughout.
const FAR_K: f64 = 1.0;
/// Smallest motion of another sensor beside a range, K, for a comparison.
const LEAST_K: f64 = 0.3;
/// Step of displays with few digits and of regulated temperatures, K.
const DISPLAY_K: f64 = 0.1;

/// Kind of missing readings in a range of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Silence {
    /// A constant number.
    Held,
    /// Empty cells.
    Empty,
}

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, sensors) in view.sensors.iter().enumerate() {
        let Some(data) = view.scene.sets.get(set) else { continue };
        let moving: Vec<&Sensor> = sensors.iter().filter(|one| one.range().is_some_and(|[a, b]| b > a)).collect();
        constant_throughout(set, sensors, out);
        let mut groups: BTreeMap<([usize; 2], Silence), Vec<String>> = BTreeMap::new();
        let mut rest: Vec<Sensor> = moving.iter().map(|&one| one.clone()).collect();
        for piece in together(&moving) {
            groups.insert((piece, Silence::Held), moving.iter().map(|one| one.name.clone()).collect());
            rest.iter_mut().for_each(|sensor| sensor.forget(piece));
        }
        for sensor in &rest {
            let own = held(data, sensor, &rest).into_iter().map(|piece| (piece, Silence::Held));
            let empty = empty(data, sensor).into_iter().map(|piece| (piece, Silence::Empty));
            for key in own.chain(empty) {
                groups.entry(key).or_default().push(sensor.name.clone());
            }
        }
        for ((piece, silence), names) in groups {
            let defect = defect(view, set, (piece, silence), names, moving.len(), out);
            out.extend(defect);
        }
    }
}

/// Reports sensors that are constant in all rows. A multiple of the display step may be a regulated temperature; it explains nothing in either case.
fn constant_throughout(set: usize, sensors: &[Sensor], out: &mut Vec<DataDefect>) {
    for sensor in sensors {
        let Some([low, high]) = sensor.range() else { continue };
        let others = sensors.iter().filter(|other| other.name != sensor.name);
        let wide = others.filter_map(Sensor::range).map(|[low, high]| high - low).fold(0.0, f64::max);
        let is_display = (low / DISPLAY_K - (low / DISPLAY_K).round()).abs() < 1e-6;
        if low < high || sensor.said().count() < ROWS || wide <= FAR_K || is_display {
            continue;
        }
        out.push(DataDefect {
            kind: DefectKind::Sensor,
            set,
            name: sensor.name.clone(),
            what: "stuck".into(),
            rows: [0, sensor.values.len().saturating_sub(1)],
            evidence: format!("it reads {low} °C in all rows, while others change by {wide:.1} K"),
            then: Then::WithoutSensors(vec![sensor.name.clone()]),
        });
    }
}

/// One fault of sensors without readings in one range of rows; `None` if the readings around it bridge it.
fn defect(
    view: &View<'_, '_>,
    set: usize,
    (piece, silence): ([usize; 2], Silence),
    names: Vec<String>,
    moving: usize,
    before: &[DataDefect],
) -> Option<DataDefect> {
    let data = view.scene.sets.get(set)?;
    let extent = if names.len() == moving { Extent::All } else { Extent::Some };
    let then = missing::consequence(view, set, names.clone(), vec![piece], extent, before);
    if matches!(&then, Then::WithoutTemperatures(missing) if missing.uncounted.is_empty()) {
        return None;
    }
    let [first, last] = piece;
    let is_end = last + 1 == data.observations.len();
    let is_begin = first == 0;
    let one = names.len() == 1;
    let what = match (one, silence, is_begin, is_end) {
        (true, Silence::Held, ..) => "stuck",
        (true, Silence::Empty, ..) => "no readings",
        (false, _, _, true) => "log ends",
        (false, _, true, false) => "log begins late",
        (false, ..) => "log pauses",
    };
    let at = |row: usize| match missing::times(data, [row, row]) {
        Some([at_s, _]) => format!("t = {at_s} s"),
        None => format!("row {}", row + 1),
    };
    let who = match (one, extent) {
        (true, _) => "the sensor".to_owned(),
        (false, Extent::All) => format!("all {} sensors", names.len()),
        (false, Extent::Some) => format!("{} of {moving} sensors", names.len()),
    };
    let count = last - first + 1;
    let (from, to) = (at(first), at(last));
    let verb = if one { "s" } else { "" };
    let shown = match (silence, is_begin, is_end) {
        (Silence::Held, _, true) => {
            format!(
                "temperatures end at {from}: {who} hold{verb} the last value to the end, digit by digit, in {count} rows"
            )
        }
        (Silence::Held, true, false) => {
            format!(
                "temperatures begin at {to}: {who} repeat{verb} the first value up to there, digit by digit, in {count} rows"
            )
        }
        (Silence::Held, ..) => {
            format!(
                "temperatures pause from {from} to {to}: {who} hold{verb} one value, digit by digit, in {count} rows"
            )
        }
        (Silence::Empty, _, true) => {
            format!("temperatures end before {from}: {who} give{verb} no value in the last {count} rows")
        }
        (Silence::Empty, true, false) => {
            format!("temperatures begin after {to}: {who} give{verb} no value in the first {count} rows")
        }
        (Silence::Empty, ..) => {
            format!("temperatures pause from {from} to {to}: {who} give{verb} no value in {count} rows")
        }
    };
    let follows = match &then {
        Then::WithoutSensors(_) => "too little would remain without these rows, or is measured only there",
        _ => "these rows have no temperature and do not count; the others do",
    };
    Some(DataDefect {
        kind: DefectKind::Sensor,
        set,
        name: if !one && extent == Extent::All { "temperatures".into() } else { names.join(" ") },
        what: what.into(),
        rows: piece,
        evidence: format!("{shown}; {follows}"),
        then,
    })
}

/// Ranges of rows in which all sensors hold their values at once.
fn together(sensors: &[&Sensor]) -> Vec<[usize; 2]> {
    let rows = sensors.iter().map(|sensor| sensor.values.len()).min().unwrap_or(0);
    if sensors.len() < 2 {
        return Vec::new();
    }
    let is_known = |row: usize| sensors.iter().all(|sensor| sensor.values[row].is_finite());
    let is_equal = |row: usize| sensors.iter().all(|one| one.values[row].to_bits() == one.values[row - 1].to_bits());
    let pieces = pieces(rows, &is_known, &is_equal);
    let steps: Vec<f64> = sensors.iter().map(|one| step(one, &own_pieces(one))).collect();
    let is_held = |piece: &[usize; 2]| {
        let is_no_chance = length(*piece) >= ROWS
            && often(&pieces, *piece).is_some_and(|often| often <= OFTEN && is_no_chance(*piece, often));
        let is_alone = || piece[0] > 0 && length(*piece) >= ALONE * longest_other(&pieces, *piece);
        is_no_chance && (is_sudden(sensors, &steps, *piece) || is_alone())
    };
    pieces.iter().copied().filter(is_held).collect()
}

/// Ranges of rows in which a sensor holds its value.
fn held(data: &DataSet, sensor: &Sensor, sensors: &[Sensor]) -> Vec<[usize; 2]> {
    let pieces = own_pieces(sensor);
    let step = step(sensor, &pieces);
    let is_held = |piece: &[usize; 2]| {
        if length(*piece) < ROWS {
            return false;
        }
        let is_no_chance = often(&pieces, *piece).is_some_and(|often| often <= OFTEN && is_no_chance(*piece, often));
        if is_no_chance && is_sudden(&[sensor], &[step], *piece) {
            return true;
        }
        let other = longest_other(&pieces, *piece) as f64;
        let is_longer = |times: f64| length(*piece) as f64 >= times * other;
        let is_seen_later =
            || jumps_after(sensor, &pieces, *piece, step) || should_have_moved(sensor, sensors, *piece) > STEPS * step;
        // A body may be at rest when the log begins.
        let is_inside = piece[0] > 0;
        is_longer(TIMES as f64) && is_seen_later()
            || is_inside && is_longer(FLICKER_TIMES) && display::stops_flickering(sensor, sensors, *piece)
            || is_inside
                && is_longer(PREDICTED_TIMES)
                && display::leaves_the_others(data, sensor, sensors, *piece, step)
    };
    pieces.iter().copied().filter(is_held).collect()
}

/// Ranges of equal numbers of a sensor.
fn own_pieces(sensor: &Sensor) -> Vec<[usize; 2]> {
    let values = &sensor.values;
    let is_equal = |row: usize| values[row].to_bits() == values[row - 1].to_bits();
    pieces(values.len(), &|row| values[row].is_finite(), &is_equal)
}

/// Ranges of empty cells that are longer than the usual ones of a table with empty cells.
fn empty(data: &DataSet, sensor: &Sensor) -> Vec<[usize; 2]> {
    let Some(driver) = data.drivers.iter().find(|driver| driver.name == sensor.name) else { return Vec::new() };
    let pieces = pieces(driver.values.len(), &|row| driver.values[row].is_nan(), &|_| true);
    let is_long =
        |piece: &[usize; 2]| length(*piece) >= ROWS && length(*piece) >= TIMES * longest_other(&pieces, *piece);
    pieces.iter().copied().filter(is_long).collect()
}

fn length(piece: [usize; 2]) -> usize {
    piece[1] - piece[0] + 1
}

/// Ranges of known rows that are equal to the rows before them: first and last row.
fn pieces(rows: usize, is_known: &dyn Fn(usize) -> bool, is_equal: &dyn Fn(usize) -> bool) -> Vec<[usize; 2]> {
    let mut pieces: Vec<[usize; 2]> = Vec::new();
    for row in (0..rows).filter(|&row| is_known(row)) {
        match pieces.last_mut() {
            Some(piece) if piece[1] + 1 == row && is_equal(row) => piece[1] = row,
            _ => pieces.push([row, row]),
        }
    }
    pieces
}

/// Number of rows of the longest other range; 1 without any.
fn longest_other(pieces: &[[usize; 2]], piece: [usize; 2]) -> usize {
    pieces.iter().filter(|other| **other != piece).map(|other| length(*other)).max().unwrap_or(1)
}

/// Share of equal neighbors beside a range, on the side with more of them. `None` if there are too few pairs on both sides.
fn often(pieces: &[[usize; 2]], [first, last]: [usize; 2]) -> Option<f64> {
    let share = |rows: std::ops::Range<usize>| {
        let inside = |piece: &[usize; 2]| (piece[1] + 1).min(rows.end).saturating_sub(piece[0].max(rows.start));
        let known: usize = pieces.iter().map(inside).sum();
        let count = pieces.iter().filter(|piece| inside(piece) > 0).count();
        let pairs = known.saturating_sub(1);
        // One more pair of each kind: none among a few pairs does not mean that there never is one.
        (pairs >= FEWEST_PAIRS).then(|| (known - count + 1) as f64 / (pairs + 2) as f64)
    };
    let sides = [share(first.saturating_sub(PAIRS + 1)..first), share(last + 1..last + PAIRS + 2)];
    sides.into_iter().flatten().reduce(f64::max)
}

/// True if a range of this length is not a coincidence, given the share of equal neighbors.
fn is_no_chance(piece: [usize; 2], often: f64) -> bool {
    (length(piece) - 1) as f64 * -often.ln() > CHANCE
}

/// True if sensors become constant from one row to the next, and not because a body comes to rest: before, they have noise, or move by many steps of
/// their display. At the beginning of a log the rows after the range must have noise: a body without noise, as in a simulated log, may have been at
/// rest.
fn is_sudden(sensors: &[&Sensor], steps: &[f64], [first, last]: [usize; 2]) -> bool {
    let (mut reversed, mut pairs) = (0_usize, 0_usize);
    let mut is_fast = false;
    for (sensor, step) in sensors.iter().zip(steps) {
        let rows = if first > 0 { first.saturating_sub(PAIRS)..first + 1 } else { last..last + 1 + PAIRS };
        let beside = sensor.values.get(rows.start..rows.end.min(sensor.values.len())).unwrap_or_default();
        let mut beside: Vec<f64> = beside.iter().copied().filter(|value| value.is_finite()).collect();
        beside.dedup();
        let changes: Vec<f64> = beside.windows(2).map(|two| two[1] - two[0]).collect();
        let latest = if first > 0 { changes.len().saturating_sub(FEWEST_PAIRS) } else { 0 };
        let nearest = changes.get(latest..(latest + FEWEST_PAIRS).min(changes.len())).unwrap_or_default();
        let usual = median(nearest.iter().map(|by| by.abs()).collect());
        is_fast |= nearest.len() == FEWEST_PAIRS && usual > STEPS * step;
        // A display that alternates between two values shows no noise.
        if usual > NOISE_STEPS * step {
            pairs += changes.len().saturating_sub(1);
            reversed += changes.windows(2).filter(|two| two[0] * two[1] < 0.0).count();
        }
    }
    let has_noise = pairs >= FEWEST_PAIRS && reversed as f64 > REVERSED * pairs as f64;
    has_noise || first > 0 && is_fast
}

/// Step of a display, K: the smallest change between two ranges.
fn step(sensor: &Sensor, pieces: &[[usize; 2]]) -> f64 {
    let value = |piece: &[usize; 2]| sensor.values[piece[0]];
    pieces.windows(2).map(|two| (value(&two[1]) - value(&two[0])).abs()).fold(f64::INFINITY, f64::min)
}

/// True if a sensor continues after a range with a larger jump than anywhere else, because its temperature changed meanwhile.
fn jumps_after(sensor: &Sensor, pieces: &[[usize; 2]], piece: [usize; 2], step: f64) -> bool {
    let value = |piece: &[usize; 2]| sensor.values[piece[0]];
    let change = |two: &[[usize; 2]]| (value(&two[1]) - value(&two[0])).abs();
    let own = pieces.windows(2).find(|two| two[0] == piece && two[1][0] == piece[1] + 1).map(change);
    let others = pieces.windows(2).filter(|two| two[0] != piece).map(change).fold(0.0, f64::max);
    own.is_some_and(|own| own > JUMP_STEPS * step && own > 2.0 * others)
}

/// Expected motion of a sensor over a range, K: its share in the motion of another sensor before and after the range, times the motion of that sensor
/// meanwhile. The smallest value of all other sensors counts; 0 if none can be compared.
fn should_have_moved(sensor: &Sensor, sensors: &[Sensor], piece: [usize; 2]) -> f64 {
    let long = length(piece);
    let end = sensor.values.len();
    let before = piece[0].saturating_sub(long)..piece[0];
    let after = piece[1] + 1..(piece[1] + 1 + long).min(end);
    let of_other = |other: &Sensor| {
        let meanwhile = moved(other, piece[0]..piece[1] + 1)?;
        let share = |rows: std::ops::Range<usize>| {
            let [own, other] = [moved(sensor, rows.clone())?, moved(other, rows)?];
            (other > LEAST_K).then_some(own / other)
        };
        // A body that comes to rest moves only before it.
        Some(share(before.clone())?.min(share(after.clone())?) * meanwhile)
    };
    sensors.iter().filter(|other| other.name != sensor.name).filter_map(of_other).reduce(f64::min).unwrap_or(0.0)
}

/// Motion of a sensor from the first quarter of a range of rows to the last, K.
fn moved(sensor: &Sensor, rows: std::ops::Range<usize>) -> Option<f64> {
    let share = rows.len() / 4;
    let of = |rows: std::ops::Range<usize>| sensor.median_of(rows);
    if share == 0 {
        return None;
    }
    Some((of(rows.end - share..rows.end)? - of(rows.start..rows.start + share)?).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    /// Tests a display with few digits that shows each number three times, and one of them 16 times, together with another sensor.
    fn found(other: impl Fn(usize) -> f64) -> Vec<String> {
        let machine = bench::machine();
        let sets = [bench::reads_along_x(&machine, &[0.0; 46])];
        let scene = bench::scene(&machine, &sets);
        let few = |row: usize| match row {
            0..15 => 20.0 + 0.1 * (row / 3) as f64,
            15..31 => 20.5,
            _ => 20.6 + 0.1 * ((row - 31) / 3) as f64,
        };
        let sensor = |name: &str, values: Vec<f64>| Sensor { name: name.into(), values };
        let sensors =
            vec![sensor("T_few_C", (0..46).map(few).collect()), sensor("T_other_C", (0..46).map(other).collect())];
        let view = View::new(&scene, vec![sensors]);
        let mut out = Vec::new();
        look(&view, &mut out);
        out.into_iter().map(|fault| fault.name).collect()
    }

    #[test]
    fn a_display_of_few_digits_is_stuck_only_while_others_move() {
        // Within the 16 rows the other sensor alternates by a tenth, or moves by 2 K from the first quarter to the last.
        assert_eq!(found(|row| 21.0 + 0.1 * (row % 2) as f64), [""; 0]);
        assert_eq!(found(|row| 21.0 + 2.0 * row as f64 / 12.0), ["T_few_C"]);
    }
}
