//! The sensors of a nest (CapBall, R-test): from their readings to the displacement of the tool along F's directions.
//!
//! Three sensors look at a ball along directions of their own. The response is a matrix from readings to displacements along F. It is stated, or fitted
//! to a star: known moves of the tool about the ball with the readings of all sensors (Andolfatto et al. 2011, 4.2: three linear stages). With a higher
//! degree, powers of each reading are added. What is not linear is named if it exceeds 0.5 % of the range, the limit of the paper.

use ncfix_base::csv::Table;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Matrix, Vector};
use ncfix_base::numeric::least_squares::System;
use ncfix_base::units::mm_from_um;
use ncfix_machine::machine::file::Section;

/// Largest departure from the fit, as a share of the range.
const LARGEST_DEPARTURE: f64 = 0.005;
/// Range outside the star in which a response is used, as a share of the range.
const BEYOND_STAR: f64 = 0.1;
/// Smallest volume of the directions of three sensors; 1 if they are square.
const LEAST_VOLUME: f64 = 0.05;
/// Numbers in a row of a star: three displacements, three readings.
const STAR_ROW: usize = 6;

/// The response of three sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorNest {
    /// The columns of their readings.
    pub columns: [String; 3],
    /// Displacement along F where all readings are 0, mm.
    constant_mm: Vector,
    /// Displacement along F per reading, per square of it, per cube of it, mm.
    powers: Vec<Matrix>,
    /// Lowest and highest reading of the star.
    ranges: Option<[[f64; 2]; 3]>,
}

impl SensorNest {
    /// The displacement of the tool from the ball along F's directions, mm.
    #[must_use]
    pub fn displacement_mm(&self, readings: &[f64; 3]) -> Vector {
        let readings = Vector::from(*readings);
        let mut power = Vector::repeat(1.0);
        let mut out = self.constant_mm;
        for matrix in &self.powers {
            power.component_mul_assign(&readings);
            out += matrix * power;
        }
        out
    }

    /// A sensor whose reading is outside the range of the star: its index, and this range.
    #[must_use]
    pub fn beyond(&self, readings: &[f64; 3]) -> Option<(usize, [f64; 2])> {
        let ranges = self.ranges?;
        ranges.into_iter().zip(readings).enumerate().find_map(|(index, (range, reading))| {
            let room = (range[1] - range[0]) * BEYOND_STAR;
            (!(range[0] - room..=range[1] + room).contains(reading)).then_some((index, range))
        })
    }

    /// The diagnostic of such a reading: message and help.
    #[must_use]
    pub fn beyond_text(&self, readings: &[f64; 3]) -> Option<(String, &'static str)> {
        let (index, [low, high]) = self.beyond(readings)?;
        let [name, reading] = [self.columns.get(index)?.clone(), readings.get(index)?.to_string()];
        let help =
            "calibrate the sensors over the whole range with a larger star, or keep the ball nearer to the middle";
        Some((format!("{name} reads {reading}, but the star of [sensors] has {low} to {high}"), help))
    }

    /// Reports columns that the table lacks.
    pub fn missing(&self, table: &Table, findings: &mut Vec<Diagnostic>) {
        for name in self.columns.iter().filter(|name| table.column(name).is_none()) {
            let help = "columns in [sensors] of the description names the columns of the three sensors";
            let message = format!("there is no column {name}");
            findings.push(Diagnostic::at(Code::DATA_COLUMN, table.header_place(None), message, help));
        }
    }
}

/// Reads the section `[sensors]` of a description.
pub fn read(mut section: Section<'_>, findings: &mut Vec<Diagnostic>) -> Option<SensorNest> {
    let columns = section.required("columns", "[\"s1_V\", \"s2_V\", \"s3_V\"]", Section::texts);
    let columns: Option<[String; 3]> = columns.and_then(|names| {
        let is_clear =
            names.iter().enumerate().all(|(k, name)| !name.is_empty() && !names.iter().take(k).any(|one| one == name));
        let three = names.try_into().ok().filter(|_| is_clear);
        if three.is_none() {
            let place = section.place_of("columns");
            section.report(
                Code::BAD_VALUE,
                place,
                "columns must be three different names",
                "name the column of each sensor",
            );
        }
        three
    });
    let matrix = section.rows("matrix_um");
    let star = section.rows("star");
    let zero = section.vector("zero");
    let degree = section.number_where("degree", "1, 2 or 3", |degree| [1.0, 2.0, 3.0].contains(&degree));
    let made = columns.and_then(|columns| match (matrix, star) {
        (Some(matrix), None) => stated(&mut section, columns, &matrix, zero.unwrap_or_default()),
        (None, Some(star)) if zero.is_none() => fitted(&mut section, columns, &star, degree.unwrap_or(1.0) as usize),
        _ => {
            let place = section.place_of("columns");
            let help = "give matrix_um, the displacements along X, Y, Z per unit of each sensor, or star, known moves with the readings";
            section.report(Code::BAD_VALUE, place, "[sensors] needs either matrix_um or star", help);
            None
        }
    });
    section.finish(findings);
    made
}

fn stated(section: &mut Section<'_>, columns: [String; 3], rows: &[Vec<f64>], zero: Vector) -> Option<SensorNest> {
    let is_square = rows.len() == 3 && rows.iter().all(|row| row.len() == 3);
    let at = |row: usize, column: usize| rows.get(row).and_then(|row| row.get(column)).copied().unwrap_or(0.0);
    let matrix = Matrix::from_fn(|row, column| mm_from_um(at(row, column)));
    if !is_square || volume(&matrix) < LEAST_VOLUME {
        let help = "write three rows X, Y, Z with the µm per unit of each sensor; the sensors must not be in one plane";
        let place = section.place_of("matrix_um");
        section.report(Code::BAD_VALUE, place, "matrix_um does not give three directions", help);
        return None;
    }
    Some(SensorNest { columns, constant_mm: -(matrix * zero), powers: vec![matrix], ranges: None })
}

/// Volume of the unit vectors along the columns.
fn volume(matrix: &Matrix) -> f64 {
    let sizes: f64 = matrix.column_iter().map(|column| column.norm()).product();
    if sizes > 0.0 { matrix.determinant().abs() / sizes } else { 0.0 }
}

fn fitted(section: &mut Section<'_>, columns: [String; 3], star: &[Vec<f64>], degree: usize) -> Option<SensorNest> {
    let place = section.place_of("star");
    let help = "each row is three displacements of the tool along X, Y, Z in µm and the three readings there; move along each direction on both sides";
    let rows: Vec<[f64; STAR_ROW]> = star.iter().filter_map(|row| row.as_slice().try_into().ok()).collect();
    let width = 1 + 3 * degree;
    if rows.len() < star.len() || rows.len() <= width {
        let message = format!("a star of degree {degree} needs more than {width} rows of {STAR_ROW} numbers");
        section.report(Code::BAD_VALUE, place, message, help);
        return None;
    }
    let span = |column: usize| {
        let values = rows.iter().map(|row| row[column]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
    };
    let ranges = [3, 4, 5].map(span);
    // Readings in shares of their range, so that powers are of one size.
    let size = ranges.map(|[low, high]| low.abs().max(high.abs()));
    let mut constant_mm = Vector::zeros();
    let mut powers = vec![Matrix::zeros(); degree];
    for direction in 0..3 {
        let mut system = System::new(width);
        for row in &rows {
            let mut factors = vec![1.0];
            for power in 1..=degree as i32 {
                factors.extend((0..3).map(|k| (row[3 + k] / size[k]).powi(power)));
            }
            system.add(&factors, mm_from_um(row[direction]), 1.0);
        }
        let solution = system.solve().filter(|solution| solution.rank == width);
        let Some(solution) = solution else {
            section.report(Code::BAD_VALUE, place, "the star does not determine the directions of the sensors", help);
            return None;
        };
        let value = |index: usize| solution.unknowns.get(index).copied().unwrap_or(0.0);
        constant_mm[direction] = value(0);
        for (power, matrix) in powers.iter_mut().enumerate() {
            for k in 0..3 {
                matrix[(direction, k)] = value(1 + 3 * power + k) / size[k].powi(power as i32 + 1);
            }
        }
    }
    let nest = SensorNest { columns, constant_mm, powers, ranges: Some(ranges) };
    if nest.powers.first().is_none_or(|matrix| volume(matrix) < LEAST_VOLUME) {
        section.report(Code::BAD_VALUE, place, "the sensors do not give three directions", help);
        return None;
    }
    let departures = if degree == 1 { of_sensors(&rows, &ranges) } else { of_moves(&rows, &nest, span) };
    for (name, share) in departures.into_iter().filter(|(_, share)| *share > LARGEST_DEPARTURE) {
        let name = match name {
            Departure::Sensor(k) => nest.columns.get(k).cloned().unwrap_or_default(),
            Departure::Move(letter) => format!("the displacement along {letter}"),
        };
        let message = format!("{name} departs from its fitted response by {:.1} % of its range", share * 100.0);
        let help = match degree {
            1 => "write degree = 3 in [sensors] if the star has enough rows, or use a smaller range",
            _ => "use a smaller range, or repeat the star",
        };
        section.report(Code::SENSOR_LINEARITY, place, message, help);
    }
    Some(nest)
}

/// A quantity that departs from its fit.
#[derive(Clone, Copy, Debug)]
enum Departure {
    Sensor(usize),
    Move(char),
}

/// Departure of each sensor from a straight line over the displacements, as a share of its range.
fn of_sensors(rows: &[[f64; STAR_ROW]], ranges: &[[f64; 2]; 3]) -> Vec<(Departure, f64)> {
    let departure = |k: usize| {
        let mut system = System::new(4);
        for row in rows {
            system.add(&[1.0, row[0], row[1], row[2]], row[3 + k], 1.0);
        }
        let values = system.solve()?.unknowns;
        let fit = |row: &[f64; STAR_ROW]| {
            let value = |index: usize| values.get(index).copied().unwrap_or(0.0);
            value(0) + (0..3).map(|j| value(1 + j) * row[j]).sum::<f64>()
        };
        let most = rows.iter().map(|row| (row[3 + k] - fit(row)).abs()).fold(0.0, f64::max);
        let [low, high] = ranges.get(k).copied()?;
        Some((Departure::Sensor(k), if high > low { most / (high - low) } else { 0.0 }))
    };
    (0..3).filter_map(departure).collect()
}

/// Departure of the displacements from the response, as a share of their range.
fn of_moves(rows: &[[f64; STAR_ROW]], nest: &SensorNest, span: impl Fn(usize) -> [f64; 2]) -> Vec<(Departure, f64)> {
    let departure = |(k, letter): (usize, char)| {
        let off = |row: &[f64; STAR_ROW]| {
            let found = nest.displacement_mm(&[row[3], row[4], row[5]]);
            (found[k] - mm_from_um(row[k])).abs()
        };
        let [low, high] = span(k);
        let most = rows.iter().map(off).fold(0.0, f64::max);
        (Departure::Move(letter), most / mm_from_um(high - low).max(f64::MIN_POSITIVE))
    };
    ['X', 'Y', 'Z'].into_iter().enumerate().map(departure).collect()
}
