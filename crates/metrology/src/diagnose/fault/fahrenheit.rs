//! A sensor in degrees Fahrenheit in a column of degrees Celsius.

use super::cells::Sensor;
use super::{DataDefect, DefectCheck, DefectKind, Then, View};

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "degrees Fahrenheit",
    made_by: "a logger that is set to another unit",
    shown_by: "a sensor far above all others throughout, that is amidst them when its readings are converted",
    source: "cross-sensor regression",
    look,
};

/// °C of °F.
pub(super) fn celsius(fahrenheit: f64) -> f64 {
    (fahrenheit - 32.0) / 1.8
}

/// It is so much above every other sensor in the middle and at its coldest, K.
const ABOVE_K: f64 = 25.0;
/// And is so near to the others when it is converted, K.
const NEAR_K: f64 = 8.0;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, sensors) in view.sensors.iter().enumerate() {
        let suspects: Vec<&Sensor> = sensors.iter().filter(|one| is_above(one, sensors)).collect();
        for sensor in suspects {
            let Some([low, high]) = sensor.range() else { continue };
            let lows: Vec<f64> = sensors
                .iter()
                .filter(|one| one.name != sensor.name)
                .filter_map(Sensor::range)
                .map(|[low, _]| low)
                .collect();
            let rest = super::median(lows);
            let [from, to] = [low, high].map(celsius);
            out.push(DataDefect {
                kind: DefectKind::Sensor,
                set,
                name: sensor.name.clone(),
                what: "degrees Fahrenheit".into(),
                rows: [0, sensor.values.len().saturating_sub(1)],
                evidence: format!(
                    "{low:.1} to {high:.1} are no °C where the coldest of the others is {rest:.1} °C; as °F they are {from:.1} to {to:.1} °C"
                ),
                then: Then::InFahrenheit(sensor.name.clone()),
            });
        }
    }
}

fn is_above(sensor: &Sensor, sensors: &[Sensor]) -> bool {
    let Some([low, _]) = sensor.range() else { return false };
    let others = sensors.iter().filter(|one| one.name != sensor.name);
    // Where most are in °F, the few that are not are no fault.
    let lows: Vec<f64> = others.filter_map(Sensor::range).map(|[low, _]| low).collect();
    let rest = super::median(lows.clone());
    !lows.is_empty() && low - rest > ABOVE_K && (celsius(low) - rest).abs() < NEAR_K
}
