//! What temperatures do: drift behind sensors, expansion of scales and screws, squareness by gradients, and a door that was opened.

use super::square;
use crate::plant::bench::Bench;
use crate::plant::climate::interpolated;
use crate::plant::effect::{Effect, Law, Place, Stage, location, motion};
use crate::plant::machine::LETTERS;
use crate::plant::random::Random;
use crate::plant::row::Row;

/// What follows a sensor slowly, less 20 °C or what it was when the instrument was set to zero, on the day of a row.
pub(crate) fn follower(stage: &Stage<'_>, sensor: &str, lag_s: f64) -> Option<impl Fn(&Row) -> f64 + 'static> {
    let days: Option<Vec<Vec<f64>>> = stage
        .sheets
        .iter()
        .map(|sheet| {
            let climate = sheet.climate.as_ref()?;
            Some(climate.lagged(climate.sensor(sensor)?, lag_s))
        })
        .collect();
    days.map(|days| {
        move |row: &Row| {
            let at = |t| interpolated(&days[row.day], t);
            at(row.t) - row.zeroed.map_or(20.0, at)
        }
    })
}

/// The column of a sensor.
pub(crate) fn column(sensor: &str) -> String {
    format!("{sensor}_C")
}

/// The effect of a row of the catalogue.
pub(super) fn effect(row: u8, stage: &Stage<'_>, random: &mut Random) -> Option<Effect> {
    let direction = random.below(3);
    let name = LETTERS[direction];
    Some(match row {
        38 => {
            let (sensor, lag) = (random.pick(&["T_spindle", "T_head", "T_motor"]), random.between(300.0, 1800.0));
            // Some sensors are where it grows.
            let lag = if stage.bench == Bench::DriftRuns && random.unit() < 0.35 { 0.0 } else { lag };
            Effect::new(row, "thermal-drift", name, &[&column(sensor)], Law::Linear(1e3), "um/K")
                .acts(Place::Tip(direction), follower(stage, sensor, lag)?)
                .follows(sensor, lag)
        }
        39 => {
            let (fast, slow) = (random.between(60.0, 600.0), random.between(1500.0, 4000.0));
            let (head, column_of) = (follower(stage, "T_spindle", fast)?, follower(stage, "T_column_front", slow)?);
            let ratio = -random.between(1.0, 2.5);
            let drivers = [column("T_spindle"), column("T_column_front")];
            let drivers = [drivers[0].as_str(), drivers[1].as_str()];
            Effect::new(row, "thermal-drift", name, &drivers, Law::Linear(1e3), "um/K")
                .acts(Place::Tip(direction), move |row| head(row) + ratio * column_of(row))
                .follows("T_spindle", fast)
        }
        43 => {
            let lag = random.between(3600.0, 10_000.0);
            Effect::new(row, "thermal-drift", name, &["T_ambient_C"], Law::Linear(1e3), "um/K")
                .acts(Place::Tip(direction), follower(stage, "T_ambient", lag)?)
                .alias("drift", name)
                .follows("T_ambient", lag)
        }
        44 => {
            let last = stage.sheets[0].rows.last().map_or(0.0, |row| row.t);
            let (from, tau) = (last * random.between(0.25, 0.7), random.between(900.0, 3000.0));
            Effect::new(row, "drift", name, &["t_s"], Law::Linear(1e3), "um")
                .acts(Place::Tip(direction), move |row| {
                    let since = row.t - from;
                    if row.day == 0 && since >= 0.0 { (-since / tau).exp() } else { 0.0 }
                })
                .only_here()
        }
        40 | 41 => {
            let axis = if row == 41 { 0 } else { direction };
            let sensor = if row == 41 { "T_screw_X" } else { ["T_X", "T_Y", "T_Z"][axis] };
            let fixed = [0.0, 120.0, 30.0][random.below(3)];
            let sense = stage.machine.direction[axis][axis];
            let warm = follower(stage, sensor, 0.0)?;
            let drivers = [column(sensor)];
            let drivers = [drivers[0].as_str(), LETTERS[axis]];
            Effect::new(row, "thermal-expansion", &motion(axis, axis), &drivers, Law::Linear(1e6), "um/(m K)")
                .acts(Place::Motion(axis, axis), move |row| sense * warm(row) * (row.q[axis] - fixed))
                .follows(sensor, 0.0)
        }
        42 => {
            let (turn, of) = square(stage, 0, 1);
            let (front, back) = (follower(stage, "T_front", 0.0)?, follower(stage, "T_back", 0.0)?);
            let unit = "urad/K";
            Effect::new(
                row,
                "thermal-squareness",
                &location(turn, of),
                &["T_front_C", "T_back_C"],
                Law::Linear(1e6),
                unit,
            )
            .acts(Place::Location(turn, of), move |row| front(row) - back(row))
            .alias("thermal-squareness", &location(turn, 1 - of))
            .follows("T_front", 0.0)
        }
        _ => return None,
    })
}
