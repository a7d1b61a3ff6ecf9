//! A sensor that is stuck: the very same number in row after row, while it else changes from row to row or while the others go on.

use super::cells::Sensor;
use super::{DataDefect, DefectCheck, DefectKind, Then, View};

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "stuck sensor",
    made_by: "a logger that repeats its last value, a bus that is down",
    shown_by: "no variance at all in rows in which noise should be",
    source: "Spaan 1995, ch. 6: sensors that fail during a day",
    look,
};

/// Rows of the same number at least.
const ROWS: usize = 8;
/// Times as long as any other piece of equal numbers.
const TIMES: usize = 5;
/// Rows are spared where they are less than this part of all: else the sensor is.
const SPARED: usize = 3;
/// Others go this far, K, while a sensor says one number throughout.
const FAR_K: f64 = 1.0;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, sensors) in view.sensors.iter().enumerate() {
        for sensor in sensors {
            let pieces = pieces(sensor);
            let Some(longest) = pieces.iter().max_by_key(|piece| piece[1] - piece[0]).copied() else { continue };
            let length = |piece: [usize; 2]| piece[1] - piece[0] + 1;
            let next = pieces.iter().filter(|piece| **piece != longest).map(|piece| length(*piece)).max().unwrap_or(1);
            let all = sensor.said().count();
            let others = sensors.iter().filter(|other| other.name != sensor.name);
            let moved = |other: &Sensor| {
                let range = |rows: std::ops::Range<usize>| other.median_of(rows);
                let (from, to) = (longest[0], longest[1] + 1);
                let share = (length(longest) / 4).max(1);
                Some((range(to - share..to)? - range(from..from + share)?).abs())
            };
            let far = others.clone().filter_map(moved).fold(0.0, f64::max);
            let wide = others.filter_map(Sensor::range).map(|[low, high]| high - low).fold(0.0, f64::max);
            let is_whole = length(longest) == all && all >= ROWS && wide > FAR_K;
            let is_piece = length(longest) < all && length(longest) >= ROWS.max(TIMES * next);
            // A display of few digits stays for long where nothing goes on.
            if !(is_whole || is_piece && (next <= 2 || far > FAR_K)) {
                continue;
            }
            let evidence = if is_whole {
                format!("it reads {} °C in all rows, while others change by {wide:.1} K", sensor.values[longest[0]])
            } else {
                format!(
                    "it reads {} °C in {} rows one after the other, else never more than {next} times; others change by up to {far:.1} K meanwhile",
                    sensor.values[longest[0]],
                    length(longest),
                )
            };
            let of_run = if is_whole { None } else { rest_of_run(view, set, longest) };
            let spared: usize = out.iter().filter(|one| one.set == set).map(|one| one.rows[1] - one.rows[0] + 1).sum();
            let rows = of_run.filter(|&rows| SPARED * (spared + length(rows)) < sensor.values.len());
            out.push(DataDefect {
                kind: DefectKind::Sensor,
                set,
                name: sensor.name.clone(),
                what: "stuck".into(),
                rows: rows.unwrap_or(longest),
                evidence,
                then: rows.map_or(Then::WithoutSensors(vec![sensor.name.clone()]), |_| Then::WithoutRows),
            });
        }
    }
}

/// From where a sensor is stuck to the end of the run: what follows it slowly is not known there either. `None` where that is not within one run, or
/// there is no other run.
fn rest_of_run(view: &View<'_, '_>, set: usize, [first, last]: [usize; 2]) -> Option<[usize; 2]> {
    let rows = &view.scene.sets.get(set)?.observations;
    let run = rows.get(first)?.run;
    let own = rows.get(first..)?.iter().take_while(|one| one.run == run).count();
    (last < first + own && rows.iter().any(|one| one.run != run)).then(|| [first, first + own - 1])
}

/// Pieces of equal numbers: first and last row.
fn pieces(sensor: &Sensor) -> Vec<[usize; 2]> {
    let mut pieces: Vec<[usize; 2]> = Vec::new();
    for (row, value) in sensor.values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        match pieces.last_mut() {
            Some(piece) if piece[1] + 1 == row && sensor.values[piece[0]].to_bits() == value.to_bits() => {
                piece[1] = row
            }
            _ => pieces.push([row, row]),
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    /// A display of few digits that shows each number three times, and one of them 16 times; beside another sensor.
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
        // Within the 16 rows the other one goes up and down by a tenth, and from the first quarter of them to the last by 2 K.
        assert_eq!(found(|row| 21.0 + 0.1 * (row % 2) as f64), [""; 0]);
        assert_eq!(found(|row| 21.0 + 2.0 * row as f64 / 12.0), ["T_few_C"]);
    }
}
