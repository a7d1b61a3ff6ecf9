//! Working plane in space: plane coordinates for contours, including planes that a frame has tilted or mirrored.

use super::{Arc, Axis, AxisVector, Frame, Matrix, Plane, Vector};

/// Two directions are equal if they differ by less than this.
const SAME_DIRECTION: f64 = 1e-12;

/// Right-handed orthonormal basis: abscissa, ordinate, normal.
///
/// With a mirroring frame the normal is reversed. So a programmed counter-clockwise arc is counter-clockwise in plane coordinates for any frame, and left
/// stays left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlaneBasis {
    /// Along the axes of the machine.
    Principal(Plane),
    /// Columns: abscissa, ordinate, normal.
    Tilted(Matrix),
}

impl PlaneBasis {
    /// Returns the plane as transformed by a frame; `None` if the frame makes it degenerate.
    #[must_use]
    pub fn behind(frame: &Frame, plane: Plane) -> Option<PlaneBasis> {
        if frame.is_translation() {
            return Some(PlaneBasis::Principal(plane));
        }
        let [abscissa, ordinate, _] = plane.axes();
        let first = frame.apply_direction(unit(abscissa)).try_normalize(SAME_DIRECTION)?;
        let second = frame.apply_direction(unit(ordinate));
        let second = (second - first * first.dot(&second)).try_normalize(SAME_DIRECTION)?;
        Some(PlaneBasis::Tilted(Matrix::from_columns(&[first, second, first.cross(&second)])))
    }

    /// Returns the plane coordinates of a position, mm.
    #[must_use]
    pub fn flat(&self, position: &AxisVector) -> [f64; 2] {
        match self {
            PlaneBasis::Principal(plane) => {
                let [abscissa, ordinate, _] = plane.axes();
                [position[abscissa], position[ordinate]]
            }
            PlaneBasis::Tilted(columns) => {
                let xyz = position.xyz();
                [columns.column(0).dot(&xyz), columns.column(1).dot(&xyz)]
            }
        }
    }

    /// Returns the distance of a position from the parallel plane through the origin, mm.
    #[must_use]
    pub fn height(&self, position: &AxisVector) -> f64 {
        match self {
            PlaneBasis::Principal(plane) => position[plane.axes()[2]],
            PlaneBasis::Tilted(columns) => columns.column(2).dot(&position.xyz()),
        }
    }

    /// Returns X Y Z of plane coordinates and height, mm.
    #[must_use]
    pub fn lift(&self, flat: [f64; 2], height: f64) -> Vector {
        match self {
            PlaneBasis::Principal(plane) => {
                let [abscissa, ordinate, applicate] = plane.axes();
                let mut xyz = Vector::zeros();
                xyz[abscissa.slot()] = flat[0];
                xyz[ordinate.slot()] = flat[1];
                xyz[applicate.slot()] = height;
                xyz
            }
            PlaneBasis::Tilted(columns) => columns * Vector::new(flat[0], flat[1], height),
        }
    }

    /// Returns a position with other plane coordinates; its height and the other axes are unchanged. Untouched axes keep every bit.
    #[must_use]
    pub fn moved(&self, position: &AxisVector, flat: [f64; 2]) -> AxisVector {
        let mut out = *position;
        match self {
            PlaneBasis::Principal(plane) => {
                let [abscissa, ordinate, _] = plane.axes();
                out[abscissa] = flat[0];
                out[ordinate] = flat[1];
            }
            PlaneBasis::Tilted(_) => out.set_xyz(self.lift(flat, self.height(position))),
        }
        out
    }

    /// Converts an arc of plane coordinates to one in a principal plane; `None` if the plane is tilted.
    #[must_use]
    pub fn principal_arc(&self, clockwise: bool, center: [f64; 2], extra_turns: u32) -> Option<Arc> {
        match self {
            PlaneBasis::Principal(plane) => Some(Arc { plane: *plane, clockwise, center_mm: center, extra_turns }),
            PlaneBasis::Tilted(columns) => {
                let normal: Vector = columns.column(2).into();
                let plane = [Plane::XY, Plane::ZX, Plane::YZ]
                    .into_iter()
                    .find(|plane| normal[plane.axes()[2].slot()].abs() > 1.0 - SAME_DIRECTION)?;
                let [abscissa, ordinate, applicate] = plane.axes();
                let turned = normal[applicate.slot()] < 0.0;
                let xyz = self.lift(center, 0.0);
                let center_mm = [xyz[abscissa.slot()], xyz[ordinate.slot()]];
                Some(Arc { plane, clockwise: clockwise != turned, center_mm, extra_turns })
            }
        }
    }
}

fn unit(axis: Axis) -> Vector {
    let mut direction = Vector::zeros();
    direction[axis.slot()] = 1.0;
    direction
}
