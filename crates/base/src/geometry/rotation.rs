//! Rotations in space as matrices: about a line, by three angles, by the inclination of a plane.

use std::f64::consts::FRAC_PI_2;

use super::{Axis, Matrix, Vector};

/// Numerical noise of sine and cosine at right angles: values closer than this to 0, 1 or −1 are rounded to these.
const NOISE: f64 = 1e-15;

/// Order of rotation of up to three angles about X, Y and Z (Sinumerik MD10600).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RotationOrder {
    /// About Z, then about the new Y, then about the new X: `Rz · Ry · Rx`.
    #[default]
    Rpy,
    /// About Z by the Z angle, then about the new X by the X angle, then about the new Z by the Y angle: `Rz(z) · Rx(x) · Rz(y)`.
    Euler,
}

impl RotationOrder {
    /// Returns the rotation by angles about X, Y, Z, rad.
    #[must_use]
    pub fn matrix(self, angles_rad: [f64; 3]) -> Matrix {
        let [x, y, z] = angles_rad;
        let (about_x, about_z) = (about(&Vector::x(), x), about(&Vector::z(), z));
        match self {
            RotationOrder::Rpy => about_z * about(&Vector::y(), y) * about_x,
            RotationOrder::Euler => about_z * about_x * about(&Vector::z(), y),
        }
    }

    /// Returns angles about X, Y, Z, rad, that give a rotation. If several do, the Y angle of RPY is within ±90°, and an undetermined angle is 0.
    #[must_use]
    pub fn angles_rad(self, rotation: &Matrix) -> [f64; 3] {
        let at = |row: usize, column: usize| rotation[(row, column)];
        match self {
            RotationOrder::Rpy => {
                let across = at(0, 0).hypot(at(1, 0));
                let y = (-at(2, 0)).atan2(across);
                if across < SINGULAR {
                    // X and Z rotate about the same line.
                    return [0.0, y, (-at(0, 1)).atan2(at(1, 1))];
                }
                [at(2, 1).atan2(at(2, 2)), y, at(1, 0).atan2(at(0, 0))]
            }
            RotationOrder::Euler => {
                let across = at(2, 0).hypot(at(2, 1));
                let x = across.atan2(at(2, 2));
                if across < SINGULAR {
                    return [x, 0.0, at(1, 0).atan2(at(0, 0))];
                }
                [x, at(2, 0).atan2(at(2, 1)), at(0, 2).atan2(-at(1, 2))]
            }
        }
    }
}

/// Limit below which the outer axes of three rotations are parallel.
const SINGULAR: f64 = 1e-12;

/// Returns the rotation about a unit vector by the right-hand rule: Rodrigues' formula. Right angles are exact.
#[must_use]
pub fn about(axis: &Vector, angle_rad: f64) -> Matrix {
    let (sine, cosine) = angle_rad.sin_cos();
    let (sine, cosine) = (without_noise(sine), without_noise(cosine));
    Matrix::identity() * cosine + axis.cross_matrix() * sine + axis * axis.transpose() * (1.0 - cosine)
}

/// Returns the rotation to a plane that is defined by the inclination of its lines in two planes perpendicular to it: by `first_rad` about `first` and by
/// `second_rad` about `second`, which follows it in the order X Y Z X.
///
/// For X and Y: the new X lies in the old Z X plane, rotated about Y; the line of the new plane in the old Y Z plane is rotated about X (Sinumerik ROTS).
/// `None` if there are two angles and one of them is not below a right angle.
#[must_use]
pub fn by_solid_angles(first: Axis, first_rad: f64, second_rad: f64) -> Option<Matrix> {
    let base = first.dimension();
    let unit = |k: usize| Vector::ith((base + k) % 3, 1.0);
    // A single angle rotates about its axis by any amount.
    if second_rad == 0.0 {
        return Some(about(&unit(0), first_rad));
    }
    if first_rad == 0.0 {
        return Some(about(&unit(1), second_rad));
    }
    if first_rad.abs().max(second_rad.abs()) >= FRAC_PI_2 {
        return None;
    }
    let abscissa = about(&unit(1), second_rad) * unit(0);
    let line = about(&unit(0), first_rad) * unit(1);
    let normal = abscissa.cross(&line).try_normalize(SINGULAR)?;
    let ordinate = normal.cross(&abscissa);
    let mut out = Matrix::identity();
    for (k, column) in [abscissa, ordinate, normal].iter().enumerate() {
        out.set_column((base + k) % 3, column);
    }
    Some(out)
}

fn without_noise(value: f64) -> f64 {
    if value.abs() < NOISE {
        0.0
    } else if (value.abs() - 1.0).abs() < NOISE {
        value.signum()
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_are_exact() {
        let turned = about(&Vector::z(), 90_f64.to_radians()) * Vector::x();
        assert_eq!(turned, Vector::y());
        assert_eq!(about(&Vector::x(), 180_f64.to_radians()) * Vector::y(), -Vector::y());
    }

    #[test]
    fn angles_of_a_rotation_give_it_back() {
        for order in [RotationOrder::Rpy, RotationOrder::Euler] {
            for angles in [[0.3, 0.4, -2.0], [0.0; 3], [1.0, std::f64::consts::FRAC_PI_2, 0.2], [0.0, 0.0, 3.0]] {
                let rotation = order.matrix(angles);
                let again = order.matrix(order.angles_rad(&rotation));
                assert!((rotation - again).norm() < 1e-12, "{order:?} {angles:?}");
            }
        }
    }

    #[test]
    fn a_plane_by_solid_angles_contains_both_lines() {
        for first in [Axis::X, Axis::Y, Axis::Z] {
            let k = first.dimension();
            let rotation = by_solid_angles(first, 0.3, 0.5).unwrap();
            assert!((rotation * rotation.transpose() - Matrix::identity()).norm() < 1e-14);
            assert!((rotation.determinant() - 1.0).abs() < 1e-14);
            let normal = rotation * Vector::ith((k + 2) % 3, 1.0);
            // The line perpendicular to the first axis at 0.3 rad from the second, the one perpendicular to the second at 0.5 rad.
            let line = Vector::ith((k + 1) % 3, 0.3_f64.cos()) + Vector::ith((k + 2) % 3, 0.3_f64.sin());
            assert!(normal.dot(&line).abs() < 1e-14, "{first}");
            let abscissa = rotation * Vector::ith(k, 1.0);
            let expected = Vector::ith(k, 0.5_f64.cos()) - Vector::ith((k + 2) % 3, 0.5_f64.sin());
            assert!((abscissa - expected).norm() < 1e-14, "{first}");
        }
        // A single angle is a rotation about its axis.
        assert!((by_solid_angles(Axis::X, 0.3, 0.0).unwrap() - about(&Vector::x(), 0.3)).norm() < 1e-14);
    }
}
