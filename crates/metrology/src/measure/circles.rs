//! Circles in the readings of a ball-bar: runs of rows whose bar stays in one plane through the table ball.

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, AxisVector, Vector};
use ncfix_machine::machine::Machine;
use ncfix_model::{ErrorModel, Model};

use super::data::DataSet;
use super::kind::Measurand;

/// Permitted distance of the bar from the plane of its circle, as a share of its length: ball-bars are mounted by hand.
const OFF_PLANE: f64 = 0.03;
/// Sine below which two directions do not determine a plane.
const TOO_NEAR: f64 = 0.05;
/// Angle between bars above which rows are not consecutive on a circle, rad.
const JUMP: f64 = 1.1;
/// Angle of backward motion at which the direction of a circle changes, rad: measured positions are not exact.
const BACK: f64 = 0.1;
/// Step of an axis below which it does not move between two rows, mm or rad.
const STILL: f64 = 1e-6;
/// Minimum number of rows of a circle.
const FEWEST_ROWS: usize = 8;

/// A circle.
#[derive(Clone, Debug, PartialEq)]
pub struct Circle {
    /// Index of the set-up.
    pub setup: usize,
    /// The directions of angle 0 and of 90°; the normal of the plane is their cross product.
    pub basis: [Vector; 2],
    /// `true` if run counterclockwise, as seen against the normal.
    pub is_counterclockwise: bool,
    /// Rows and the angle of the bar in each, rad.
    pub rows: Vec<(usize, f64)>,
}

impl Circle {
    /// The main plane of the circle: 0 for XY, 1 for YZ, 2 for ZX.
    #[must_use]
    pub fn main_plane(&self) -> Option<usize> {
        let normal = self.basis[0].cross(&self.basis[1]);
        (0..3).find(|k| normal[(k + 2) % 3].abs() > 1.0 - 1e-3)
    }

    /// The azimuth of angle 0 about Z from X, rad.
    #[must_use]
    pub fn azimuth(&self) -> f64 {
        self.basis[0].y.atan2(self.basis[0].x)
    }
}

/// The circles of a measurement with a ball-bar, in the order of its rows. Directions are those of the workpiece frame.
#[must_use]
pub fn circles(machine: &Machine, data: &DataSet) -> Vec<Circle> {
    let model = Model::new(machine, &ErrorModel::default());
    let mut out = Vec::new();
    let mut run: Vec<(usize, Vector)> = Vec::new();
    let mut normal: Option<Vector> = None;
    let (mut setup, mut number) = (0, 0);
    for (row, observation) in data.observations.iter().enumerate() {
        let Some(described) = data.setups.get(observation.setup) else { continue };
        let mut command = AxisVector::ZERO;
        command.set_xyz(described.centre_mm);
        let ball = model.nominal(&command, &Vector::zeros()).translation;
        let reading = &observation.reading;
        let bar = model.nominal(&reading.position, &reading.tool_mm).translation - ball;
        let Some(bar) = bar.try_normalize(1e-9) else { continue };
        let follows = observation.setup == setup
            && observation.run == number
            && run.last().is_none_or(|(_, last)| last.dot(&bar) > JUMP.cos());
        let fits = follows && normal.is_none_or(|normal| normal.dot(&bar).abs() < OFF_PLANE);
        if !fits {
            out.extend(circles_of(setup, &run, normal));
            // The row at which two planes meet belongs to both.
            let last = run.last().copied().filter(|_| follows);
            run.clear();
            normal = None;
            run.extend(last);
            (setup, number) = (observation.setup, observation.run);
        }
        if normal.is_none() {
            let first = run.first().map(|(_, first)| first.cross(&bar));
            normal = first
                .filter(|cross| cross.norm() > TOO_NEAR)
                .and_then(|cross| cross.try_normalize(TOO_NEAR))
                .map(upright);
        }
        run.push((row, bar));
    }
    out.extend(circles_of(setup, &run, normal));
    out
}

/// A normal oriented along the nearest main direction, and equal to it if close.
fn upright(normal: Vector) -> Vector {
    let main = (0..3).fold(0, |main, k| if normal[k].abs() > normal[main].abs() + 1e-9 { k } else { main });
    let normal = if normal[main] < 0.0 { -normal } else { normal };
    if normal[main] > 1.0 - OFF_PLANE * OFF_PLANE / 2.0 { Vector::ith(main, 1.0) } else { normal }
}

/// The circles of a run in one plane, one for each direction.
fn circles_of(setup: usize, run: &[(usize, Vector)], normal: Option<Vector>) -> Vec<Circle> {
    let Some(normal) = normal else { return Vec::new() };
    // XY from X to Y, YZ from Y to Z, ZX from Z to X; other planes from the horizontal upwards.
    let main = (0..3).find(|&k| normal[k] > 1.0 - 1e-9);
    let right = match main {
        Some(k) => Some(Vector::ith((k + 1) % 3, 1.0)),
        None => normal.cross(&Vector::z()).try_normalize(1e-9),
    };
    let Some(right) = right else { return Vec::new() };
    let up = normal.cross(&right);
    let up = if main.is_none() && up.z < 0.0 { -up } else { up };
    let angle = |bar: &Vector| bar.dot(&up).atan2(bar.dot(&right));
    let rows: Vec<(usize, f64)> = run.iter().map(|(row, bar)| (*row, angle(bar))).collect();
    let pieces = by_sense(&rows).into_iter().filter(|(rows, _)| rows.len() >= FEWEST_ROWS);
    pieces
        .map(|(rows, is_counterclockwise)| Circle {
            setup,
            basis: [right, up],
            is_counterclockwise,
            rows: rows.to_vec(),
        })
        .collect()
}

/// Parts of a run with one direction, `true` for counterclockwise; neighbors share the row of the reversal.
fn by_sense(rows: &[(usize, f64)]) -> Vec<(&[(usize, f64)], bool)> {
    let mut out = Vec::new();
    let (mut first, mut extreme, mut sense) = (0, 0, 0.0_f64);
    // The angle covered, and its extreme.
    let (mut turned, mut furthest) = (0.0_f64, 0.0_f64);
    for (k, pair) in rows.windows(2).enumerate() {
        let step = pair[1].1 - pair[0].1;
        turned += step.sin().atan2(step.cos());
        if sense == 0.0 && turned.abs() > BACK / 2.0 {
            sense = turned.signum();
        }
        if sense == 0.0 || (turned - furthest) * sense >= 0.0 {
            (extreme, furthest) = (k + 1, turned);
        } else if (furthest - turned) * sense > BACK {
            out.extend(rows.get(first..=extreme).map(|rows| (rows, sense > 0.0)));
            (first, extreme, furthest, sense) = (extreme, k + 1, turned, -sense);
        }
    }
    out.extend(rows.get(first..).map(|rows| (rows, sense >= 0.0)));
    out
}

/// Share of the rows of a circle whose stated directions must oppose the order of the rows for a contradiction: measured positions jitter at the reversals.
const MOST: f64 = 0.5;

/// Warns of circles whose rows go against the name of their run (`ccw`, `cw`), or against their columns `X_dir` …: figures follow the rows, backlash the
/// columns, so that each would silently contradict the other.
pub(super) fn contradictions(machine: &Machine, data: &DataSet, findings: &mut Vec<Diagnostic>) {
    if data.kind.measurand != Measurand::BallDistance || data.is_plan {
        return;
    }
    let mut told: Vec<usize> = Vec::new();
    for circle in circles(machine, data) {
        let Some(first) = circle.rows.first().and_then(|(row, _)| data.observations.get(*row)) else { continue };
        let Some(plane) = circle.main_plane().and_then(|plane| ["XY", "YZ", "ZX"].get(plane)) else { continue };
        let label = data.runs.get(first.run).map_or("", String::as_str);
        let help = "put the rows into the order of the motion, or correct what states the direction";
        let way = if circle.is_counterclockwise { "counterclockwise" } else { "clockwise" };
        let message = if named(label).is_some_and(|is_counter| is_counter != circle.is_counterclockwise) {
            format!("the rows of the run '{label}' go {way} in the plane {plane}, against the name of the run")
        } else if opposes(data, &circle) {
            format!("the rows go {way} in the plane {plane}, against the columns with the directions of the axes")
        } else {
            continue;
        };
        if !told.contains(&first.run) {
            told.push(first.run);
            findings.push(Diagnostic::at(Code::FAULTY_DATA, first.place, message, help));
        }
    }
}

/// The direction in the name of a run, `true` for counterclockwise; `None` without one, or with both.
fn named(label: &str) -> Option<bool> {
    let label = label.to_lowercase();
    let words = || label.split(|c: char| !c.is_alphabetic());
    let has = |word: &str| words().any(|own| own == word);
    (has("ccw") != has("cw")).then(|| has("ccw"))
}

/// `true` if most stated directions of the axes oppose the order of the rows.
fn opposes(data: &DataSet, circle: &Circle) -> bool {
    if !data.has_senses || !data.is_in_order {
        return false;
    }
    let (mut known, mut against) = (0.0, 0.0);
    for pair in circle.rows.windows(2) {
        let [Some(from), Some(to)] = [pair[0].0, pair[1].0].map(|row| data.observations.get(row)) else { continue };
        for axis in AXES {
            let stated = f64::from(to.reading.state.direction(axis));
            let step = to.reading.position[axis] - from.reading.position[axis];
            if stated != 0.0 && step.abs() > STILL {
                known += 1.0;
                against += f64::from(u8::from(stated * step < 0.0));
            }
        }
    }
    against > MOST * known
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_runs_may_have_a_direction() {
        for (label, expected) in [
            ("2-cw", Some(false)),
            ("ccw", Some(true)),
            ("CCW2", Some(true)),
            ("1", None),
            ("cw ccw", None),
            ("cwt", None),
        ] {
            assert_eq!(named(label), expected, "{label}");
        }
    }

    fn rows(degrees: &[f64]) -> Vec<(usize, f64)> {
        degrees
            .iter()
            .map(|degrees| degrees.to_radians().sin_cos())
            .map(|(sin, cos)| sin.atan2(cos))
            .enumerate()
            .collect()
    }

    #[test]
    fn a_circle_ends_where_its_sense_changes() {
        // There and back across 180°, with some jitter at the turning point.
        let all = rows(&[90.0, 130.0, 170.0, 210.0, 250.0, 249.5, 250.2, 210.0, 170.0, 130.0, 90.0]);
        let found = by_sense(&all);
        let shown: Vec<(usize, usize, bool)> =
            found.iter().map(|(rows, sense)| (rows[0].0, rows.last().unwrap().0, *sense)).collect();
        assert_eq!(shown, [(0, 6, true), (6, 10, false)]);
        assert_eq!(by_sense(&rows(&[0.0, -40.0, -80.0])).iter().map(|one| one.1).collect::<Vec<_>>(), [false]);
        assert!(by_sense(&[]).iter().all(|one| one.0.is_empty()));
    }

    #[test]
    fn normals_of_main_planes_are_exact() {
        assert_eq!(upright(Vector::new(0.01, 0.0, -1.0).normalize()), Vector::z());
        assert_eq!(upright(Vector::new(-1.0, 0.005, 0.0).normalize()), Vector::x());
        let slanted = Vector::new(-1.0, 1.0, 0.0).normalize();
        assert_eq!(upright(slanted), -slanted);
    }
}
