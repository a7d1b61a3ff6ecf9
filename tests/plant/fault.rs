//! Faults of the data: what goes wrong between the machine and the file.

use super::bench::Bench;
use super::random::Random;
use super::row::{Kind, Sheet};
use super::vector::V3;

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FaultKind {
    /// mm in the column of µm.
    Millimetres,
    /// µm in the column, a thousand times too large.
    Thousandfold,
    /// Thousandths of an inch.
    Inches,
    /// dx and dy exchanged.
    Swapped,
    /// One of dx dy dz, or one component, with the wrong sign.
    Reversed,
    /// A sensor that stays.
    Stuck,
    /// A sensor that reads −180 °C.
    Dead,
    /// Two sensors plugged the other way round from some row on.
    Exchanged,
    /// A sensor that reads some kelvin too much from some row on.
    Offset,
    /// A sensor in degrees Fahrenheit.
    Fahrenheit,
    /// Pulses of a few minutes.
    Pulses,
    /// The first run before the machine has settled.
    FirstCycle,
    /// A step of all that follows.
    Step,
    /// An active table takes the known errors out already.
    Compensated,
    /// Steps of the display.
    Quantised,
}

/// All kinds.
pub(crate) const FAULTS: [FaultKind; 15] = [
    FaultKind::Millimetres,
    FaultKind::Thousandfold,
    FaultKind::Inches,
    FaultKind::Swapped,
    FaultKind::Reversed,
    FaultKind::Stuck,
    FaultKind::Dead,
    FaultKind::Exchanged,
    FaultKind::Offset,
    FaultKind::Fahrenheit,
    FaultKind::Pulses,
    FaultKind::FirstCycle,
    FaultKind::Step,
    FaultKind::Compensated,
    FaultKind::Quantised,
];

/// A fault that is there.
#[derive(Clone, Debug)]
pub(crate) struct Fault {
    /// Row of the catalogue; 0 for factors of units.
    pub(crate) row: u8,
    /// unit, axes, sensor, pulse, first-cycle, step, compensated, quantised.
    pub(crate) kind: &'static str,
    /// Sensor or column.
    pub(crate) name: String,
    pub(crate) what: &'static str,
    /// Stem of the pair of files.
    pub(crate) file: String,
    /// First and last row of the table, from 0, behind the header.
    pub(crate) rows: [usize; 2],
    /// Why these data cannot show it, where they cannot.
    pub(crate) unseen: Option<&'static str>,
}

/// What a pair of files will say: readings in µm (µrad; commands in mm of a probing), and temperatures by sensor.
#[derive(Clone, Debug)]
pub(crate) struct Values {
    pub(crate) readings: Vec<V3>,
    pub(crate) sensors: Vec<Vec<Option<f64>>>,
}

/// The kinds that a row of the catalogue stands for.
pub(crate) fn kinds_of(row: u8) -> &'static [FaultKind] {
    match row {
        60 => &[FaultKind::Stuck, FaultKind::Dead],
        61 => &[FaultKind::Offset, FaultKind::Fahrenheit],
        62 => &[FaultKind::Swapped, FaultKind::Reversed, FaultKind::Exchanged],
        63 => &[FaultKind::Pulses],
        64 => &[FaultKind::FirstCycle],
        65 => &[FaultKind::Step],
        66 => &[FaultKind::Compensated],
        67 => &[FaultKind::Quantised],
        _ => &[],
    }
}

/// Whether a bench can have a fault.
pub(crate) fn is_possible(kind: FaultKind, bench: Bench) -> bool {
    use FaultKind as F;
    let has_sensors = matches!(bench, Bench::Drift | Bench::HotCold);
    match kind {
        F::Millimetres | F::Thousandfold | F::Inches => bench != Bench::FiveAxis,
        F::Swapped => matches!(bench, Bench::Plate | Bench::Drift),
        F::Reversed => matches!(bench, Bench::Plate | Bench::Laser | Bench::Drift),
        F::Stuck | F::Dead | F::Exchanged | F::Offset | F::Fahrenheit => has_sensors,
        F::Pulses => matches!(bench, Bench::Drift | Bench::Laser | Bench::Plate),
        F::FirstCycle => matches!(bench, Bench::Drift | Bench::Laser),
        F::Step => matches!(bench, Bench::Drift | Bench::DriftRuns | Bench::Laser),
        F::Compensated => matches!(bench, Bench::Plate | Bench::Laser),
        F::Quantised => !matches!(bench, Bench::FiveAxis | Bench::Load | Bench::HotCold),
    }
}

/// Puts a fault into the first sheet of a kind that can have it. `size` is in µm or µrad. `Compensated` is no matter of the values.
pub(crate) fn apply(
    kind: FaultKind,
    sheets: &[Sheet],
    values: &mut [Values],
    ratio: f64,
    random: &mut Random,
) -> Vec<Fault> {
    use FaultKind as F;
    let number = sheets.iter().position(|sheet| sheet.climate.is_some() || sheet.kind != Kind::Probe).unwrap_or(0);
    let (sheet, values) = (&sheets[number], &mut values[number]);
    let count = sheet.rows.len();
    let size = ratio * sheet.sigma * if sheet.angles { 1e6 } else { 1e3 };
    let fault = |row, kind, name: &str, what, rows| Fault {
        row,
        kind,
        name: name.to_owned(),
        what,
        file: sheet.stem.clone(),
        rows,
        unseen: None,
    };
    let unseen = |unseen: Option<&'static str>, fault: Fault| Fault { unseen, ..fault };
    let all = [0, count - 1];
    let times = |values: &mut Values, factor: f64| values.readings.iter_mut().flatten().for_each(|v| *v *= factor);
    let shift = |value: &mut V3, by: f64| (0..3).filter(|&k| sheet.reads[k]).for_each(|k| value[k] += by);
    let from = random.between(0.2, 0.5) * count as f64;
    let part = [from as usize, (from + random.between(0.15, 0.4) * count as f64) as usize];
    let sensor = random.below(values.sensors.len().max(1));
    let column = sheet.climate.as_ref().map_or(String::new(), |climate| format!("{}_C", climate.names[sensor]));
    match kind {
        F::Millimetres => {
            times(values, 1e-3);
            vec![fault(0, "unit", "", "factor 0.001", all)]
        }
        F::Thousandfold => {
            times(values, 1e3);
            vec![fault(0, "unit", "", "factor 1000", all)]
        }
        F::Inches => {
            times(values, 1.0 / 25.4);
            vec![fault(0, "unit", "", "factor 1/25.4", all)]
        }
        F::Swapped => {
            values.readings.iter_mut().for_each(|value| value.swap(0, 1));
            vec![unseen(without_errors(sheet), fault(62, "axes", "dx_um dy_um", "swapped", all))]
        }
        F::Reversed => {
            let axis = random.below(2);
            for (row, value) in sheet.rows.iter().zip(&mut values.readings) {
                if sheet.kind == Kind::Displacement {
                    value[axis] = -value[axis];
                } else if row.component == [axis, axis] {
                    value[0] = -value[0];
                }
            }
            let name = if sheet.kind == Kind::Displacement { ["dx_um", "dy_um"] } else { ["EXX", "EYY"] }[axis];
            vec![unseen(without_errors(sheet), fault(62, "axes", name, "reversed", all))]
        }
        F::Stuck => {
            let stays = values.sensors[sensor][part[0]];
            values.sensors[sensor][part[0]..=part[1]].iter_mut().for_each(|value| *value = stays);
            vec![fault(60, "sensor", &column, "stuck", part)]
        }
        F::Dead => {
            values.sensors[sensor][part[0]..=part[1]].iter_mut().for_each(|value| *value = Some(-180.0));
            vec![fault(60, "sensor", &column, "dead", part)]
        }
        F::Exchanged => {
            let apart = |other: usize| {
                let near = part[0]..(part[0] + 8).min(count);
                let of = |k: usize| Some(values.sensors[sensor][k]? - values.sensors[other][k]?);
                near.clone().filter_map(of).sum::<f64>().abs() / near.len() as f64
            };
            let other = (sensor + 1 + random.below(values.sensors.len() - 1)) % values.sensors.len();
            let noise = sheet.climate.as_ref().map_or(0.0, |climate| climate.noise);
            let alike = (apart(other) < 3.0 * noise)
                .then_some("two sensors that read the same, but for their noise, may as well be exchanged");
            for k in part[0]..count {
                let kept = values.sensors[sensor][k];
                values.sensors[sensor][k] = values.sensors[other][k];
                values.sensors[other][k] = kept;
            }
            let names =
                sheet.climate.as_ref().map_or(String::new(), |climate| format!("{column} {}_C", climate.names[other]));
            vec![unseen(alike, fault(62, "sensor", &names, "exchanged", [part[0], count - 1]))]
        }
        F::Offset => {
            let by = random.between(3.0, 6.0) * random.sign();
            values.sensors[sensor][part[0]..].iter_mut().flatten().for_each(|value| *value += by);
            vec![fault(61, "sensor", &column, "offset", [part[0], count - 1])]
        }
        F::Fahrenheit => {
            values.sensors[sensor].iter_mut().flatten().for_each(|value| *value = 32.0 + 1.8 * *value);
            vec![fault(61, "sensor", &column, "degrees Fahrenheit", all)]
        }
        F::Pulses => (0..3)
            .map(|number| {
                let first = (count as f64 * (0.15 + 0.27 * f64::from(number) + random.between(0.0, 0.1))) as usize;
                let begins = sheet.rows[first].t;
                let long = random.between(120.0, 300.0);
                let until = |k: &usize| sheet.rows[*k].t <= begins + long;
                let rows: Vec<usize> = (first..count).take_while(until).collect();
                rows.iter().for_each(|&k| shift(&mut values.readings[k], size));
                let rows = [first, first + rows.len() - 1];
                unseen(at_an_end(sheet, rows, 10.0), fault(63, "pulse", "", "pulse", rows))
            })
            .collect(),
        F::FirstCycle => {
            // Until the first run ends; a day of drift has only one, of which it is the first half hour.
            let run = &sheet.rows[0].run;
            let long = if sheet.climate.is_some() { 1800.0 } else { f64::MAX };
            let is_first = |k: &usize| sheet.rows[*k].run == *run && sheet.rows[*k].t < long;
            let last = (0..count).take_while(is_first).count() - 1;
            (0..=last).for_each(|k| shift(&mut values.readings[k], size * (1.0 - 0.5 * k as f64 / count as f64)));
            vec![fault(64, "first-cycle", run, "first cycle", [0, last])]
        }
        F::Step => {
            (part[0]..count).for_each(|k| shift(&mut values.readings[k], size));
            vec![unseen(at_an_end(sheet, [part[0]; 2], 330.0), fault(65, "step", "", "step", [part[0], count - 1]))]
        }
        F::Compensated => vec![fault(66, "compensated", "", "known errors already removed", all)],
        F::Quantised => {
            let step = (size * 1e3).round().max(1.0) / 1e3;
            values.readings.iter_mut().flatten().for_each(|value| *value = (*value / step).round() * step);
            vec![fault(67, "quantised", "", "steps of the display", all)]
        }
    }
}

/// A day at one place has no errors that are known and differ by axis.
fn without_errors(sheet: &Sheet) -> Option<&'static str> {
    sheet
        .climate
        .as_ref()
        .map(|_| "what a machine file says of a day at one place is nothing, or the same with either sign")
}

/// Whether rows are so near to the ends of their set-up or line, s, that its free zero takes up what is shifted.
fn at_an_end(sheet: &Sheet, [first, last]: [usize; 2], margin_s: f64) -> Option<&'static str> {
    /// Longer is a pause, behind which nothing is as it was.
    const PAUSE_S: f64 = 300.0;
    /// Rows of one piece on each side that show where a shift begins and ends.
    const ROWS: usize = 12;
    let rows = &sheet.rows;
    let goes_on = |k: usize| {
        let [one, next] = [&rows[k], &rows[k + 1]];
        one.setup == next.setup && one.component[1] == next.component[1] && next.t - one.t < PAUSE_S
    };
    let begin = (0..first).rev().find(|&k| !goes_on(k)).map_or(0, |k| k + 1);
    let end = (first..rows.len() - 1).find(|&k| !goes_on(k)).unwrap_or(rows.len() - 1);
    let is_far = first >= begin + ROWS
        && last + ROWS <= end
        && rows[first].t - rows[begin].t >= margin_s
        && rows[end].t - rows[last].t >= margin_s;
    (!is_far).then_some(
        "the free zero of a set-up takes up what is shifted up to its end: a pulse is a step is nothing there",
    )
}
