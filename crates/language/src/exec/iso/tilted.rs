//! G68.2: the orientation of the feature coordinate system from the words of its forms (Fanuc 30i operator's manual, "tilted working plane command").
//!
//! Without P by Euler angles; with P1 by roll, pitch and yaw about the workpiece axes in the order of Q; with P2 by three points and with P3 by two
//! vectors, in several blocks numbered by Q.

use ncfix_base::geometry::{Matrix, RotationOrder, Vector, about};

/// Relative tolerance of parallel directions.
const PARALLEL: f64 = 1e-9;

/// Rotation by I about Z, then J about the new X, then K about the new Z; rad.
pub(super) fn by_euler([i, j, k]: [f64; 3]) -> Matrix {
    RotationOrder::Euler.matrix([j, k, i])
}

/// Angles I, J and K of [`by_euler`] for a rotation, rad. If the plane is not tilted, K is 0.
pub(super) fn euler_of(rotation: &Matrix) -> [f64; 3] {
    let normal: Vector = rotation.column(2).into();
    let sine = normal.x.hypot(normal.y);
    if sine < PARALLEL {
        // Rotations about Z, and after half a turn about X, in one angle.
        let turn = rotation[(1, 0)].atan2(rotation[(0, 0)]);
        return [turn, if normal.z > 0.0 { 0.0 } else { std::f64::consts::PI }, 0.0];
    }
    [normal.x.atan2(-normal.y), sine.atan2(normal.z), rotation[(2, 0)].atan2(rotation[(2, 1)])]
}

/// Rotation by angles about X, Y and Z of the workpiece, rad, in an order such as 123; `None` for an invalid order.
pub(super) fn by_roll_pitch_yaw(angles_rad: [f64; 3], order: u32) -> Option<Matrix> {
    let digits = [order / 100, order / 10 % 10, order % 10];
    let mut sorted = digits;
    sorted.sort_unstable();
    if sorted != [1, 2, 3] {
        return None;
    }
    let turns = digits.map(|digit| {
        let index = if digit == 1 { 0 } else { digit as usize - 1 };
        about(&Vector::ith(index, 1.0), angles_rad.get(index).copied().unwrap_or(0.0))
    });
    // The axes are those of the workpiece: later rotations are factors on the left.
    Some(turns[2] * turns[1] * turns[0])
}

/// Rotation from the origin, a point on +X and a point on the side of +Y; `None` if they are collinear.
pub(super) fn by_points(points: [Vector; 3]) -> Option<Matrix> {
    let abscissa = (points[1] - points[0]).try_normalize(PARALLEL)?;
    let side = (points[2] - points[0]).try_normalize(PARALLEL)?;
    by_abscissa_and_normal(&abscissa, &abscissa.cross(&side))
}

/// Rotation from the directions of +X and +Z; `None` if they are parallel. If they are not perpendicular, +Z is kept.
pub(super) fn by_vectors(abscissa: &Vector, normal: &Vector) -> Option<Matrix> {
    let normal = normal.try_normalize(PARALLEL)?;
    let abscissa = abscissa.try_normalize(PARALLEL)?;
    by_abscissa_and_normal(&(abscissa - normal * normal.dot(&abscissa)), &normal)
}

fn by_abscissa_and_normal(abscissa: &Vector, normal: &Vector) -> Option<Matrix> {
    let normal = normal.try_normalize(PARALLEL)?;
    let abscissa = abscissa.try_normalize(PARALLEL)?;
    Some(Matrix::from_columns(&[abscissa, normal.cross(&abscissa), normal]))
}

/// The blocks of P2 and P3 so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Collected {
    form: u32,
    /// Points by Q: 0 the shift, then origin, +X, +Y – or the origin of P3 at 1.
    points: [Option<Vector>; 4],
    /// Directions of P3 by Q: 1 is +X, 2 is +Z.
    directions: [Option<Vector>; 3],
    turn_rad: f64,
}

/// One block of P2 or P3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    /// P
    pub(super) form: u32,
    /// Q
    pub(super) index: u32,
    /// X Y Z, mm.
    pub(super) point: Vector,
    /// I J K
    pub(super) direction: Vector,
    /// R, rad.
    pub(super) turn_rad: f64,
}

/// Result of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Plane {
    /// More blocks must follow.
    Incomplete,
    /// Origin and directions.
    Complete(Vector, Matrix),
    /// Points on one line, parallel vectors.
    Degenerate,
    /// No such Q.
    Unknown,
}

impl Collected {
    /// Takes a block.
    pub(super) fn take(&mut self, part: &Part) -> Plane {
        if self.form != part.form {
            *self = Collected { form: part.form, ..Collected::default() };
        }
        let index = part.index as usize;
        match (part.form, part.index) {
            (2, 0..=3) => {
                if let Some(place) = self.points.get_mut(index) {
                    *place = Some(part.point);
                }
                if part.index == 0 {
                    self.turn_rad = part.turn_rad;
                }
            }
            (3, 1 | 2) => {
                if let Some(place) = self.directions.get_mut(index) {
                    *place = Some(part.direction);
                }
                if part.index == 1 {
                    self.points[1] = Some(part.point);
                }
            }
            _ => return Plane::Unknown,
        }
        let found = match (part.form, self.points, self.directions) {
            (2, [shift, Some(origin), Some(abscissa), Some(side)], _) => by_points([origin, abscissa, side])
                .map(|rotation| (origin + rotation * shift.unwrap_or_else(Vector::zeros), rotation)),
            (3, [_, Some(origin), ..], [_, Some(abscissa), Some(normal)]) => {
                by_vectors(&abscissa, &normal).map(|rotation| (origin, rotation))
            }
            _ => return Plane::Incomplete,
        };
        let turn = about(&Vector::z(), self.turn_rad);
        *self = Collected::default();
        found.map_or(Plane::Degenerate, |(origin, rotation)| Plane::Complete(origin, rotation * turn))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn near(found: Vector, wanted: [f64; 3]) {
        assert!((found - Vector::from(wanted)).norm() < 1e-12, "{found:?} {wanted:?}");
    }

    #[test]
    fn euler_angles_are_those_of_the_reference() {
        // I90 J30 K0: the new X is the old Y, the new Y leans back over -X by 30 degrees.
        let rotation = by_euler([90_f64.to_radians(), 30_f64.to_radians(), 0.0]);
        near(rotation * Vector::x(), [0.0, 1.0, 0.0]);
        near(rotation * Vector::y(), [-(0.75_f64.sqrt()), 0.0, 0.5]);
        near(rotation * Vector::z(), [0.5, 0.0, 0.75_f64.sqrt()]);
    }

    #[test]
    fn euler_angles_read_back() {
        for angles in [[0.3, 0.7, -1.1], [-2.5, 1.9, 3.0], [1.2, 0.0, 0.0], [0.4, std::f64::consts::PI, 0.0]] {
            let rotation = by_euler(angles);
            assert!((by_euler(euler_of(&rotation)) - rotation).norm() < 1e-12, "{angles:?}");
        }
    }

    #[test]
    fn roll_pitch_yaw_turns_about_the_axes_of_the_workpiece() {
        let quarter = std::f64::consts::FRAC_PI_2;
        // About X first: Y goes to Z; then about Z, which leaves Z.
        let rotation = by_roll_pitch_yaw([quarter, 0.0, quarter], 123).unwrap();
        near(rotation * Vector::y(), [0.0, 0.0, 1.0]);
        near(rotation * Vector::x(), [0.0, 1.0, 0.0]);
        // About Z first: Y goes to -X, which X leaves.
        let other = by_roll_pitch_yaw([quarter, 0.0, quarter], 321).unwrap();
        near(other * Vector::y(), [-1.0, 0.0, 0.0]);
        for order in [0, 112, 124, 12, 1234, 1233] {
            assert_eq!(by_roll_pitch_yaw([0.0; 3], order), None, "{order}");
        }
    }

    fn part(form: u32, index: u32, point: [f64; 3], direction: [f64; 3]) -> Part {
        Part { form, index, point: point.into(), direction: direction.into(), turn_rad: 0.0 }
    }

    #[test]
    fn three_points_and_two_vectors_come_in_blocks() {
        let mut collected = Collected::default();
        let none = [0.0; 3];
        assert_eq!(collected.take(&part(2, 0, [1.0, 2.0, 0.0], none)), Plane::Incomplete);
        assert_eq!(collected.take(&part(2, 1, [10.0, 0.0, 0.0], none)), Plane::Incomplete);
        assert_eq!(collected.take(&part(2, 2, [10.0, 5.0, 0.0], none)), Plane::Incomplete);
        let Plane::Complete(origin, rotation) = collected.take(&part(2, 3, [10.0, 1.0, 7.0], none)) else {
            panic!("three points make a plane");
        };
        // +X along Y, +Y up, +Z along X; the shift in these.
        near(rotation * Vector::x(), [0.0, 1.0, 0.0]);
        near(rotation * Vector::y(), [0.0, 0.0, 1.0]);
        near(rotation * Vector::z(), [1.0, 0.0, 0.0]);
        near(origin, [10.0, 1.0, 2.0]);
        assert_eq!(collected.take(&part(3, 1, [1.0, 2.0, 3.0], [2.0, 0.0, 0.0])), Plane::Incomplete);
        let Plane::Complete(origin, rotation) = collected.take(&part(3, 2, none, [0.0, -4.0, 0.0])) else {
            panic!("two vectors make a plane");
        };
        near(origin, [1.0, 2.0, 3.0]);
        near(rotation * Vector::y(), [0.0, 0.0, 1.0]);
        assert_eq!(collected.take(&part(3, 3, none, none)), Plane::Unknown);
    }

    #[test]
    fn what_makes_no_plane_is_told() {
        let mut collected = Collected::default();
        for index in 1..3 {
            collected.take(&part(2, index, [f64::from(index), 0.0, 0.0], [0.0; 3]));
        }
        assert_eq!(collected.take(&part(2, 3, [9.0, 0.0, 0.0], [0.0; 3])), Plane::Degenerate);
        assert!(by_vectors(&Vector::x(), &-Vector::x()).is_none());
    }
}
