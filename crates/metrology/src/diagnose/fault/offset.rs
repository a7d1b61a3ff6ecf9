//! A sensor that reads some kelvin more or less from one row on: it came off and was fixed elsewhere, or its amplifier changed.

use super::cells::TableClock;
use super::{DataDefect, DefectCheck, DefectKind, Then, View, spread};
use crate::measure::data::DataSet;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "offset of a sensor",
    made_by: "a sensor that came off, an amplifier or plug that was exchanged",
    shown_by: "a jump between two rows that stays, much steeper than before and behind it, while no other sensor jumps",
    source: "cross-sensor regression",
    look,
};

/// Jumps below this are none, K.
const LEAST_K: f64 = 1.0;
/// In units of what else is there of jumps.
const TIMES: f64 = 12.0;
/// And of the next largest one.
const LARGEST: f64 = 2.5;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, sensors) in view.sensors.iter().enumerate() {
        let Some(data) = view.scene.sets.get(set) else { continue };
        let clock = TableClock::new(data);
        let jumps: Vec<Vec<f64>> = sensors
            .iter()
            .map(|sensor| {
                let values = &sensor.values;
                (0..values.len()).map(|row| clock.jump(values, values, row).unwrap_or(0.0)).collect()
            })
            .collect();
        for (number, (sensor, own)) in sensors.iter().zip(&jumps).enumerate() {
            let Some((row, jump)) = largest(own) else { continue };
            // Where a run begins the machine may have become another one, if no other sensor says that it has not.
            let is_begin = row > 0 && run_of(data, row) != run_of(data, row - 1);
            if is_begin && sensors.len() == 1 {
                continue;
            }
            let usual = spread(own.iter().copied());
            let next = own
                .iter()
                .enumerate()
                .filter(|(other, _)| other.abs_diff(row) > 2)
                .fold(0.0_f64, |most, (_, jump)| most.max(jump.abs()));
            let together = jumps.iter().enumerate().filter(|(other, _)| *other != number);
            let with = together
                .flat_map(|(_, other)| other.get(row.saturating_sub(1)..(row + 2).min(other.len())).unwrap_or_default())
                .fold(0.0_f64, |most, jump| most.max(jump.abs()));
            if jump.abs() < LEAST_K || jump.abs() < TIMES * usual || jump.abs() < LARGEST * next.max(with) {
                continue;
            }
            out.push(DataDefect {
                kind: DefectKind::Sensor,
                set,
                name: sensor.name.clone(),
                what: "offset".into(),
                rows: [row, sensor.values.len().saturating_sub(1)],
                evidence: format!(
                    "it jumps by {jump:+.1} K between two rows and stays; its next largest jump is {next:.1} K, no other sensor jumps by more than {with:.1} K there"
                ),
                then: Then::WithoutSensors(vec![sensor.name.clone()]),
            });
        }
    }
}

fn run_of(data: &DataSet, row: usize) -> Option<usize> {
    data.observations.get(row).map(|one| one.run)
}

fn largest(jumps: &[f64]) -> Option<(usize, f64)> {
    jumps.iter().copied().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
}
