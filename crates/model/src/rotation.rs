//! Rotations by a rotation vector, applied to a vector without forming a matrix.
//!
//! Rodrigues: R v = v + (sin θ/θ) ω×v + ((1 − cos θ)/θ²) ω×(ω×v) with θ = |ω|; exact for every angle.

use ncfix_base::geometry::{Matrix, Vector};

/// Squared angle (rad²) below which the series is exact to the last bit: the first omitted term is θ⁶/5040, relative to 1.
const SERIES_LIMIT: f64 = 1e-5;

/// Rotation, prepared for application.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rotation {
    vector: Vector,
    /// sin θ/θ.
    sine: f64,
    /// (1 − cos θ)/θ².
    cosine: f64,
}

impl Rotation {
    /// Returns the exponential of a rotation vector, rad.
    #[inline(always)]
    pub(super) fn from_vector(vector: Vector) -> Rotation {
        let square = vector.norm_squared();
        if square < SERIES_LIMIT {
            // Factors, not quotients: a division costs as much as everything else together.
            let sine = 1.0 - square * (1.0 / 6.0) * (1.0 - square * (1.0 / 20.0));
            let cosine = 0.5 - square * (1.0 / 24.0) * (1.0 - square * (1.0 / 30.0));
            Rotation { vector, sine, cosine }
        } else {
            let angle = square.sqrt();
            let (sine, cosine) = angle.sin_cos();
            Rotation { vector, sine: sine / angle, cosine: (1.0 - cosine) / square }
        }
    }

    /// Returns the rotation vector from which it was made, rad.
    pub(super) fn vector(&self) -> &Vector {
        &self.vector
    }

    /// Returns the rotation by `angle_rad` about a unit vector.
    #[inline]
    pub(super) fn about(axis: Vector, angle_rad: f64) -> Rotation {
        let (sine, cosine) = angle_rad.sin_cos();
        Rotation { vector: axis, sine, cosine: 1.0 - cosine }
    }

    /// Returns the inverse rotation.
    #[inline]
    pub(super) fn inverse(mut self) -> Rotation {
        self.sine = -self.sine;
        self
    }

    /// Returns the matrix I + sine ω× + cosine (ω ωᵀ − |ω|² I), which is cheaper for more than two vectors.
    pub(super) fn matrix(&self) -> Matrix {
        let [x, y, z] = [self.vector.x, self.vector.y, self.vector.z];
        let [a, b, c] = [x * self.sine, y * self.sine, z * self.sine];
        let [p, q, r] = [x * self.cosine, y * self.cosine, z * self.cosine];
        Matrix::new(
            1.0 - (q * y + r * z),
            p * y - c,
            p * z + b,
            p * y + c,
            1.0 - (p * x + r * z),
            q * z - a,
            p * z - b,
            q * z + a,
            1.0 - (p * x + q * y),
        )
    }

    /// Returns the rotated vector.
    #[inline(always)]
    pub(super) fn apply(&self, vector: &Vector) -> Vector {
        let once = self.vector.cross(vector);
        let twice = self.vector.cross(&once);
        vector + once * self.sine + twice * self.cosine
    }
}

/// Returns the rotation vector of a rotation matrix with an angle below 90°, rad: the inverse of the exponential.
pub(super) fn vector_of(rotation: &Matrix) -> Vector {
    let twice_sine = Vector::new(
        rotation[(2, 1)] - rotation[(1, 2)],
        rotation[(0, 2)] - rotation[(2, 0)],
        rotation[(1, 0)] - rotation[(0, 1)],
    );
    let sine = 0.5 * twice_sine.norm();
    let stretch = if sine < 1e-4 { 1.0 + sine * sine / 6.0 } else { sine.min(1.0).asin() / sine };
    twice_sine * (0.5 * stretch)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_agrees_with_a_turn_about_an_axis_on_both_sides_of_the_series_limit() {
        let axis = Vector::new(2.0, -1.0, 2.0) / 3.0;
        let vector = Vector::new(3.0, 500.0, -7.0);
        for angle in [1e-9, 1e-4, 3.1e-3, 3.2e-3, 0.4, 2.0] {
            let difference =
                Rotation::from_vector(axis * angle).apply(&vector) - Rotation::about(axis, angle).apply(&vector);
            assert!(difference.norm() < 2e-13, "{angle}: {}", difference.norm());
        }
    }

    #[test]
    fn the_inverse_undoes_and_the_logarithm_reads_back() {
        for angle in [0.0, 1e-7, 5e-5, 2e-4, 0.3] {
            let vector = Vector::new(0.6, 0.0, -0.8) * angle;
            let rotation = Rotation::from_vector(vector);
            let columns = [Vector::x(), Vector::y(), Vector::z()].map(|column| rotation.apply(&column));
            assert!((rotation.matrix() - Matrix::from_columns(&columns)).norm() < 1e-15);
            assert!((vector_of(&rotation.matrix()) - vector).norm() < 1e-15);
            let there_and_back = rotation.inverse().apply(&rotation.apply(&Vector::new(1.0, 2.0, 3.0)));
            assert!((there_and_back - Vector::new(1.0, 2.0, 3.0)).norm() < 1e-14);
        }
    }

    #[test]
    fn no_rotation_changes_no_bit() {
        let vector = Vector::new(0.1, -0.2, 1e9);
        assert_eq!(Rotation::from_vector(Vector::zeros()).apply(&vector), vector);
    }
}
