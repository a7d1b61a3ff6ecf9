//! Weighs a workpiece with sensors that show its weight at once: load cells, pressure, the current of a vertical axis ([`LoadSensor`]).
//!
//! Readings are linear in the weight F and its moments F pₓ, F p_y, F p_z: least squares. With a column `direction` (1 or −1: the sense in which the axis of
//! a current moves), the friction of each sensor is an unknown that changes its sign with it. The current of both senses then gives the weight alone.

use ncfix_base::csv::Table;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::numeric::least_squares::{Solution, System};
use ncfix_machine::machine::LoadSensor;

use super::{Coordinate, LEAST_SIGMAS, Measured, Weighing, outlier};

/// The column of the sense of motion.
const DIRECTION: &str = "direction";

/// A reading.
#[derive(Clone, Copy, Debug)]
struct RestReading {
    /// Index of its sensor.
    sensor: usize,
    value: f64,
    /// Sense of motion: 1, −1, or 0.
    direction: f64,
}

/// `true` if a table has readings of such sensors.
#[must_use]
pub fn has_readings(table: &Table, sensors: &[LoadSensor]) -> bool {
    sensors.iter().any(|sensor| table.column(&sensor.name).is_some())
}

/// Weighs. `known` are coordinates of the position that are not to be measured, mm. Without a weighing there is a diagnostic that is an error.
#[must_use]
pub fn weigh_at_rest(
    table: &Table,
    sensors: &[LoadSensor],
    known: [Option<f64>; 3],
) -> (Option<Weighing>, Vec<Diagnostic>) {
    let mut findings = Vec::new();
    let weighing = match read(table, sensors) {
        Ok(readings) => match fit(table, sensors, &readings, known, &mut findings) {
            Ok(weighing) => Some(weighing),
            Err(finding) => {
                findings = vec![finding];
                None
            }
        },
        Err(found) => {
            findings = found;
            None
        }
    };
    (weighing, findings)
}

fn read(table: &Table, sensors: &[LoadSensor]) -> Result<Vec<RestReading>, Vec<Diagnostic>> {
    let columns: Vec<(usize, usize)> =
        sensors.iter().enumerate().filter_map(|(index, sensor)| Some((index, table.column(&sensor.name)?))).collect();
    let direction = table.column(DIRECTION);
    let numbers: Vec<usize> = columns.iter().map(|(_, column)| *column).chain(direction).collect();
    let sign = table.decimal_sign(&numbers).map_err(|finding| vec![finding])?;
    let (mut readings, mut findings) = (Vec::new(), Vec::new());
    for row in table.rows() {
        let sense = match direction.map(|column| (column, row.number(column, sign))) {
            None => 0.0,
            Some((_, Ok(sense))) if [-1.0, 0.0, 1.0].contains(&sense) => sense,
            Some((column, Ok(sense))) => {
                let message = format!("the direction must be 1, 0 or -1, found {sense}");
                let help = "write 1 where the axis moves in its positive direction, -1 in the other, 0 at rest";
                findings.push(Diagnostic::at(Code::DATA_CELL, row.place(column), message, help));
                continue;
            }
            Some((_, Err(found))) => {
                findings.push(found);
                continue;
            }
        };
        for &(sensor, column) in columns.iter().filter(|(_, column)| !row.text(*column).is_empty()) {
            match row.number(column, sign) {
                Ok(value) => readings.push(RestReading { sensor, value, direction: sense }),
                Err(found) => findings.push(found),
            }
        }
    }
    if findings.is_empty() { Ok(readings) } else { Err(findings) }
}

fn fit(
    table: &Table,
    sensors: &[LoadSensor],
    readings: &[RestReading],
    known: [Option<f64>; 3],
    findings: &mut Vec<Diagnostic>,
) -> Result<Weighing, Diagnostic> {
    let refused =
        |message: &str, help: &str| Diagnostic::at(Code::LOAD_NOT_TOLD, table.header_place(None), message, help);
    let used: Vec<usize> = (0..sensors.len()).filter(|k| readings.iter().any(|one| one.sensor == *k)).collect();
    let stated = used.iter().filter(|&&k| sensors[k].sigma.is_some()).count();
    if stated < used.len() && used.len() > 1 {
        let message = "readings of several load sensors without their uncertainties cannot be compared";
        return Err(refused(message, "give sigma in each [[load_sensor]]"));
    }
    let has_sigma = stated > 0;
    let rubs = |k: usize| {
        let of = |sense: f64| readings.iter().any(|one| one.sensor == k && one.direction == sense);
        of(1.0) || of(-1.0)
    };
    let friction: Vec<usize> = used.iter().copied().filter(|&k| rubs(k)).collect();
    let mut moments: Vec<usize> =
        (0..3).filter(|&i| known[i].is_none() && used.iter().any(|&k| sensors[k].per_n_mm[i] != 0.0)).collect();
    let mut position_mm = known.map(|value| value.map_or(Coordinate::Assumed, Coordinate::Known));
    let (solution, width) = loop {
        let width = 1 + moments.len() + friction.len();
        let mut system = System::new(width);
        for one in readings {
            let sensor = &sensors[one.sensor];
            let of_known: f64 = (0..3).map(|i| known[i].unwrap_or(0.0) * sensor.per_n_mm[i]).sum();
            let mut factors = vec![sensor.per_n + of_known];
            factors.extend(moments.iter().map(|&i| sensor.per_n_mm[i]));
            factors.extend(friction.iter().map(|&k| if k == one.sensor { one.direction } else { 0.0 }));
            system.add(&factors, one.value - sensor.empty, sensor.sigma.map_or(1.0, f64::recip));
        }
        let solution = system.solve();
        let is_complete = solution.as_ref().is_some_and(|solution| solution.rank == width);
        match (is_complete, solution, moments.pop()) {
            (true, Some(solution), last) => {
                moments.extend(last);
                break (solution, width);
            }
            (_, _, None) => {
                let message = "these readings do not determine the weight: the friction explains them as well";
                return Err(refused(message, "read the current in both directions of the axis, or give more sensors"));
            }
            (_, _, Some(i)) => {
                let letter = ['X', 'Y', 'Z'][i];
                let message = format!(
                    "the readings do not determine the position of the load along {letter}; {letter} 0 is assumed"
                );
                let help = format!(
                    "state the coordinate in mm if you know it, for example --known {letter}25, or give more sensors"
                );
                findings.push(Diagnostic::at(Code::LOAD_ASSUMED, table.header_place(None), message, help));
            }
        }
    };
    let freedom = readings.len().saturating_sub(width);
    let scale = scale(&solution, freedom, has_sigma).ok_or_else(|| {
        refused(
            "there are as many unknowns as readings, so the uncertainty of the load is not known",
            "repeat the readings, or give sigma in [[load_sensor]]",
        )
    })?;
    if has_sigma && scale > 1.0 {
        let message = format!("the readings scatter {scale:.1} times as much as sigma of the sensors allows");
        let help = "the scatter is used; check [[load_sensor]] and the readings";
        findings.push(Diagnostic::at(Code::LOAD_ASSUMED, table.header_place(None), message, help));
    }
    let covariance = |a: usize, b: usize| solution.cofactors[(a, b)] * scale * scale;
    let force = Measured { value: solution.unknowns[0], sigma: covariance(0, 0).max(0.0).sqrt() };
    if force.value < -LEAST_SIGMAS * force.sigma {
        let message = format!("the weight is negative: {:.0} N", force.value);
        return Err(refused(
            &message,
            "check the signs in [[load_sensor]], and the readings of the empty table (empty)",
        ));
    }
    let is_seen = force.value > LEAST_SIGMAS * force.sigma;
    if !is_seen {
        let message = format!(
            "the load is not significant: {:.0} N with a standard uncertainty of {:.0} N",
            force.value, force.sigma
        );
        let help = "the position is assumed to be the center of the table";
        findings.push(Diagnostic::at(Code::LOAD_ASSUMED, table.header_place(None), message, help));
    }
    for (column, &i) in moments.iter().enumerate().map(|(index, i)| (index + 1, i)).filter(|_| is_seen) {
        // p = M/F, so dp = (dM − p dF)/F.
        let value = solution.unknowns[column] / force.value;
        let variance =
            covariance(column, column) - 2.0 * value * covariance(0, column) + value * value * covariance(0, 0);
        let sigma = variance.max(0.0).sqrt() / force.value;
        position_mm[i] = Coordinate::Measured(Measured { value, sigma });
    }
    // Readings of several sensors have no common unit.
    Ok(Weighing {
        force_n: force,
        position_mm,
        noise_um_m: f64::NAN,
        freedom,
        used: readings.len(),
        left_out: Vec::new(),
    })
}

/// Factor of the stated uncertainties, or the uncertainty of a reading without stated ones; `None` if it is not known.
fn scale(solution: &Solution, freedom: usize, has_sigma: bool) -> Option<f64> {
    let found = (solution.squares / freedom.max(1) as f64).sqrt();
    if !has_sigma {
        return (freedom > 0).then_some(found);
    }
    let is_larger = freedom > 0 && found * found > outlier::highest_ratio(freedom);
    Some(if is_larger { found } else { 1.0 })
}
