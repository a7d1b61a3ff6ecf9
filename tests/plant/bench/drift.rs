//! Temperatures: a day of spindle speeds at fixed places, and plate and laser on a machine that is cold, warm and hot.

use super::plate::{Placement, visit};
use super::{add_setup, to_point};
use crate::plant::climate::{Climate, STEP_S};
use crate::plant::random::Random;
use crate::plant::row::{Column, Kind, Row, Sheet};

/// Drift at one or three heights over 6 to 10 hours, every minute or less.
pub(super) fn sheet(random: &mut Random, stem: &str, places: usize, sensors: usize, fineness: f64) -> Sheet {
    let hours = random.between(6.0, 10.0);
    let columns = [Column::Time, Column::Speed];
    let mut sheet = Sheet::new(stem, Kind::Displacement, 0.3e-3, &["offset"], &columns);
    sheet.wander = [0.7, 20.0];
    let climate = Climate::spindle_day(hours, sensors, random);
    let setup = add_setup(&mut sheet, "A");
    let every = 60.0 / fineness;
    let count = (hours * 3600.0 / every) as usize;
    for k in 0..count {
        for (place, &z) in [120.0, 20.0, 320.0].iter().enumerate().take(places) {
            let t = k as f64 * every + 4.0 * place as f64;
            let mut row = Row { setup, t, tool: [0.0, 0.0, -150.0], run: "1".into(), ..Row::default() };
            to_point(&mut row, [350.0, 250.0, z]);
            row.dir[2] = -1.0;
            row.rpm = climate.rpm[(t / STEP_S) as usize];
            sheet.rows.push(row);
        }
    }
    sheet.climate = Some(climate);
    sheet
}

/// Some runs of 2.5 to 4 hours at one place, every minute, in one set-up. `kind` 0: on days that begin at rest, each with a clock of its own; 1 and 2:
/// in the course of one day, with pauses in which the spindle goes on, and a clock that begins again (1) or not (2).
pub(super) fn runs(
    random: &mut Random,
    stem: &str,
    (count, kind): (usize, u64),
    sensors: usize,
    fineness: f64,
) -> Sheet {
    let columns = [Column::Time, Column::Speed];
    let mut sheet = Sheet::new(stem, Kind::Displacement, 0.3e-3, &["offset"], &columns);
    sheet.wander = [0.7, 20.0];
    let setup = add_setup(&mut sheet, "A");
    let every = 60.0 / fineness;
    let parts: Vec<[f64; 2]> =
        (0..count).map(|_| [random.between(2.5, 4.0), random.between(0.4, 1.2)].map(|hours| hours * 3600.0)).collect();
    let whole: f64 = parts.iter().map(|[long, pause]| (long + pause) / 3600.0).sum();
    let mut climate: Option<Climate> = (kind > 0).then(|| Climate::spindle_day(whole, sensors, random));
    let mut clock = 0.0;
    for (run, [long, pause]) in parts.into_iter().enumerate() {
        let from = match (&mut climate, kind) {
            (Some(all), 0) => all.append(Climate::spindle_day(long / 3600.0, sensors, random)),
            (Some(_), _) => clock,
            (none, _) => {
                *none = Some(Climate::spindle_day(long / 3600.0, sensors, random));
                0.0
            }
        };
        for k in 0..(long / every) as usize {
            let t = from + k as f64 * every;
            let began = if kind < 2 { from } else { 0.0 };
            let run = format!("{}", run + 1);
            let mut row = Row { setup, t, began, zeroed: Some(from), tool: [0.0, 0.0, -150.0], run, ..Row::default() };
            to_point(&mut row, [350.0, 250.0, 120.0]);
            row.dir[2] = -1.0;
            row.rpm = climate.as_ref().map_or(0.0, |all| all.rpm[(t / STEP_S) as usize]);
            sheet.rows.push(row);
        }
        clock = from + long + pause;
    }
    sheet.climate = climate;
    sheet
}

/// Sensors of a machine that is measured hot and cold; the last warms up as its axis runs.
const SENSORS: [&str; 8] = ["T_X", "T_Y", "T_Z", "T_front", "T_back", "T_plate", "T_air", "T_screw_X"];
/// Hours at each level.
const HOURS: f64 = 2.5;

/// Temperatures that stay at one level for some hours, and then at the next.
fn levels(random: &mut Random, count: usize) -> Climate {
    let steps = (HOURS * 3600.0 / STEP_S) as usize;
    let mut out = Climate::level_day(0.0, &SENSORS, &[0.0; 8], 0.0, random);
    out.truth = vec![Vec::new(); SENSORS.len()];
    for level in 0..count {
        let base = [17.5, 30.0, 24.0][level] + random.between(-1.0, 1.0);
        let own: Vec<f64> = SENSORS.iter().map(|_| base + random.between(-2.5, 2.5)).collect();
        let mut part = Climate::level_day(HOURS, &SENSORS, &own, 0.25, random);
        let tau = random.between(1200.0, 2400.0);
        for (k, value) in part.truth[7].iter_mut().enumerate() {
            *value += 6.0 * (1.0 - (-(k as f64) * STEP_S / tau).exp());
        }
        for (all, new) in out.truth.iter_mut().zip(part.truth) {
            all.extend(new.into_iter().take(steps));
        }
    }
    out.rpm = vec![0.0; out.truth[0].len()];
    out
}

/// A plate in two placements and a laser along each axis, at several levels of temperature.
pub(super) fn hot_and_cold(random: &mut Random, prefix: &str, count: usize) -> Vec<Sheet> {
    let free = ["offset", "rotation"];
    let mut plate = Sheet::new(&format!("{prefix}plate"), Kind::Displacement, 0.7e-3, &free, &[Column::Time]);
    let mut laser = Sheet::new(&format!("{prefix}laser"), Kind::Direct, 0.3e-3, &["offset"], &[Column::Time]);
    plate.climate = Some(levels(random, count));
    laser.climate = Some(levels(random, count));
    for level in 0..count {
        let mut clock = HOURS * 3600.0 * level as f64 + 60.0;
        for (degrees, name) in [(0.0, "a"), (90.0, "b")] {
            let setup = add_setup(&mut plate, &format!("L{}{name}", level + 1));
            let place = Placement { setup, degrees, centre: [350.0, 250.0, 60.0], tool: [0.0, 0.0, -100.0] };
            for (run, senses) in [[1.0, 1.0], [-1.0, -1.0]].into_iter().enumerate() {
                visit(&mut plate, &place, senses, &format!("{}{name}{}", level + 1, run + 1), &mut clock);
                clock += 900.0;
            }
        }
        let mut clock = HOURS * 3600.0 * level as f64 + 60.0;
        let setup = add_setup(&mut laser, &format!("L{}", level + 1));
        for run in 0..4 {
            for axis in 0..3 {
                for sense in [1.0, -1.0] {
                    for k in 0..11 {
                        let k = if sense > 0.0 { k } else { 10 - k };
                        let mut row = Row { setup, t: clock, tool: [0.0, 0.0, -100.0], ..Row::default() };
                        row.q = [350.0, 250.0, 250.0, 0.0, 0.0];
                        row.q[axis] = 20.0 + [66.0, 46.0, 46.0][axis] * f64::from(k);
                        row.dir[axis] = sense;
                        row.component = [axis, axis];
                        row.run = format!("{}{}{}", level + 1, ["X", "Y", "Z"][axis], run + 1);
                        laser.rows.push(row);
                        clock += 20.0;
                    }
                }
            }
        }
    }
    vec![plate, laser]
}
