//! Circles in the readings of a ball-bar: runs of rows whose bar stays in one plane through the table ball.

use crate::geometry::{AxisVector, Vector};
use crate::machine::Machine;
use crate::model::{ErrorModel, Model};

use super::data::DataSet;

/// The bar may leave the plane of its circle by this share of its length: ball-bars are mounted by hand.
const OFF_PLANE: f64 = 0.03;
/// Two directions that differ by less do not tell the plane.
const TOO_NEAR: f64 = 0.05;
/// A run of less rows is no circle.
const FEWEST_ROWS: usize = 8;

/// A circle.
#[derive(Clone, Debug, PartialEq)]
pub struct Circle {
    /// Number of the set-up.
    pub setup: usize,
    /// The directions of angle 0 and of 90°; the normal of the plane is their cross product.
    pub basis: [Vector; 2],
    /// Whether it was run counterclockwise, seen against the normal.
    pub is_counterclockwise: bool,
    /// Rows and the angle of the bar in each, rad.
    pub rows: Vec<(usize, f64)>,
}

impl Circle {
    /// The main plane in which it lies: 0 for XY, 1 for YZ, 2 for ZX.
    #[must_use]
    pub fn main_plane(&self) -> Option<usize> {
        let normal = self.basis[0].cross(&self.basis[1]);
        (0..3).find(|k| normal[(k + 2) % 3].abs() > 1.0 - 1e-3)
    }

    /// The angle of angle 0 about Z from X, rad.
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
    let mut setup = 0;
    for (row, observation) in data.observations.iter().enumerate() {
        let Some(described) = data.setups.get(observation.setup) else { continue };
        let mut command = AxisVector::ZERO;
        command.set_xyz(described.centre_mm);
        let ball = model.nominal(&command, &Vector::zeros()).translation;
        let reading = &observation.reading;
        let bar = model.nominal(&reading.position, &reading.tool_mm).translation - ball;
        let Some(bar) = bar.try_normalize(1e-9) else { continue };
        let fits = observation.setup == setup && normal.is_none_or(|normal| normal.dot(&bar).abs() < OFF_PLANE);
        if !fits {
            out.extend(circle(setup, &run, normal));
            // The row in which two planes meet belongs to both.
            let last = run.last().copied().filter(|_| observation.setup == setup);
            run.clear();
            normal = None;
            run.extend(last);
            setup = observation.setup;
        }
        if normal.is_none() {
            let first = run.first().map(|(_, first)| first.cross(&bar));
            normal = first.filter(|cross| cross.norm() > TOO_NEAR).and_then(|cross| cross.try_normalize(TOO_NEAR)).map(upright);
        }
        run.push((row, bar));
    }
    out.extend(circle(setup, &run, normal));
    out
}

/// A normal with the sense of the nearest main direction, exactly that where it is near.
fn upright(normal: Vector) -> Vector {
    let main = (0..3).fold(0, |main, k| if normal[k].abs() > normal[main].abs() + 1e-9 { k } else { main });
    let normal = if normal[main] < 0.0 { -normal } else { normal };
    if normal[main] > 1.0 - OFF_PLANE * OFF_PLANE / 2.0 { Vector::ith(main, 1.0) } else { normal }
}

fn circle(setup: usize, run: &[(usize, Vector)], normal: Option<Vector>) -> Option<Circle> {
    let normal = normal.filter(|_| run.len() >= FEWEST_ROWS)?;
    // XY from X to Y, YZ from Y to Z, ZX from Z to X; other planes from the horizontal upwards.
    let main = (0..3).find(|&k| normal[k] > 1.0 - 1e-9);
    let right = match main {
        Some(k) => Vector::ith((k + 1) % 3, 1.0),
        None => normal.cross(&Vector::z()).try_normalize(1e-9)?,
    };
    let up = normal.cross(&right);
    // Planes that stand upright are drawn with Z upwards.
    let (right, up) = if main.is_none() && up.z < 0.0 { (right, -up) } else { (right, up) };
    let rows: Vec<(usize, f64)> = run.iter().map(|(row, bar)| (*row, bar.dot(&up).atan2(bar.dot(&right)))).collect();
    let turned: f64 = rows.windows(2).map(|pair| (pair[1].1 - pair[0].1).sin()).sum();
    Some(Circle { setup, basis: [right, up], is_counterclockwise: turned >= 0.0, rows })
}
