//! A dead temperature sensor: −180 °C of an open circuit, exactly 0 of a logger without a signal, any value that no machine has.

use super::missing::{self, Extent};
use super::{DataDefect, DefectCheck, DefectKind, Then, View};
use ncfix_machine::machine::condition::file::READABLE_C;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "dead sensor",
    made_by: "an open circuit, a disconnected plug, a logger without a signal",
    shown_by: "temperatures that no machine has, or exactly 0 °C while all others are warm",
    source: "Spaan 1995, ch. 5: sensors that fail during a day",
    look,
};

/// Plausible temperatures, °C.
const POSSIBLE_C: std::ops::RangeInclusive<f64> = READABLE_C[0]..=READABLE_C[1];
/// If the others are warmer than this, °C, 0 means that there is no signal.
const WARM_C: f64 = 5.0;
/// Number of exact zeros that are not a coincidence.
const ZEROS: usize = 3;
/// Maximum number of ranges of rows that are reported separately.
const MOST_PIECES: usize = 3;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, sensors) in view.sensors.iter().enumerate() {
        for sensor in sensors {
            let others = super::median(
                sensors.iter().filter(|other| other.name != sensor.name).flat_map(super::Sensor::said).collect(),
            );
            let own = super::median(sensor.said().filter(|value| *value != 0.0).collect());
            let zeros = sensor.said().filter(|value| *value == 0.0).count();
            let no_signal = zeros >= ZEROS && own.max(others) > WARM_C;
            let is_dead =
                |value: f64| value.is_finite() && (!POSSIBLE_C.contains(&value) || (no_signal && value == 0.0));
            let rows: Vec<usize> = (0..sensor.values.len()).filter(|&row| is_dead(sensor.values[row])).collect();
            // Ranges of rows; a few good rows between them do not count as recovery.
            let pieces: Vec<[usize; 2]> = rows
                .chunk_by(|one, next| next - one <= ZEROS)
                .filter_map(|piece| Some([*piece.first()?, *piece.last()?]))
                .collect();
            // A loose contact is one fault, not one for each interruption.
            let defects: Vec<Vec<[usize; 2]>> = if pieces.len() > MOST_PIECES {
                vec![pieces]
            } else {
                pieces.into_iter().map(|piece| vec![piece]).collect()
            };
            for pieces in defects {
                let (Some(&[first, _]), Some(&[_, last])) = (pieces.first(), pieces.last()) else { continue };
                let inside = |row: &&usize| pieces.iter().any(|[from, to]| (*from..=*to).contains(*row));
                let count = rows.iter().filter(inside).count();
                let usual = if own == 0.0 || !POSSIBLE_C.contains(&own) { others } else { own };
                let times = if pieces.len() > 1 { format!(" {} times,", pieces.len()) } else { String::new() };
                let name = sensor.name.clone();
                let then = match view.scene.sets.get(set) {
                    // If a sensor is dead in most rows, its few plausible rows are not trusted.
                    Some(data) if 2 * rows.len() < data.observations.len() => {
                        missing::consequence(view, set, vec![name.clone()], pieces, Extent::Some, out)
                    }
                    _ => Then::WithoutSensors(vec![name.clone()]),
                };
                out.push(DataDefect {
                    kind: DefectKind::Sensor,
                    set,
                    name,
                    what: "dead".into(),
                    rows: [first, last],
                    evidence: format!(
                        "it reads {} °C{times} in {count} rows; in the other rows it reads about {usual:.1} °C, as the other sensors do",
                        sensor.values[first],
                    ),
                    then,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Sensor;
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn exactly_nothing_in_a_warm_shop_is_no_temperature() {
        let machine = bench::machine();
        let sets = [bench::reads_along_x(&machine, &[0.0; 20])];
        let scene = bench::scene(&machine, &sets);
        let found = |shop: f64| {
            let own = |row: usize| if (7..10).contains(&row) { 0.0 } else { shop + 0.1 * row as f64 };
            let sensor = |name: &str, values: Vec<f64>| Sensor { name: name.into(), values };
            let sensors = vec![
                sensor("T_nose_C", (0..20).map(own).collect()),
                sensor("T_other_C", (0..20).map(|row| shop + 0.1 * f64::from(row)).collect()),
            ];
            let view = View::new(&scene, vec![sensors]);
            let mut out = Vec::new();
            look(&view, &mut out);
            out.into_iter().map(|fault| (fault.name, fault.rows)).collect::<Vec<_>>()
        };
        assert_eq!(found(20.0), [("T_nose_C".to_owned(), [7, 9])]);
        // In the cold, 0 °C may be a temperature.
        assert_eq!(found(-1.0), []);
    }
}
