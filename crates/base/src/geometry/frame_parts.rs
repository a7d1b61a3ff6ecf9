//! Frame in components as stored by a control: translation, fine translation, rotation, scale and mirror.

use super::{AxisVector, Frame, Matrix, RotationOrder};

/// Components of a frame: `p' = TR + FI + RT · SC · MI · p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameParts {
    /// TR: coarse translation, mm and rad.
    pub translation: AxisVector,
    /// FI: fine translation, mm and rad.
    pub fine: AxisVector,
    /// RT: angles about X, Y and Z, rad, in the rotation order of the control.
    pub rotation: [f64; 3],
    /// SC: factors of X, Y and Z.
    pub scale: [f64; 3],
    /// MI: true for the mirrored axes among X, Y and Z.
    pub mirror: [bool; 3],
}

/// Numerical noise: angles and factors closer than this to 0 or 1 are rounded to these.
const NOISE: f64 = 1e-14;
/// Maximum deviation of the columns of a linear part from a right angle, as a share of their lengths.
const SKEW_LIMIT: f64 = 1e-9;

impl Default for FrameParts {
    fn default() -> Self {
        FrameParts {
            translation: AxisVector::ZERO,
            fine: AxisVector::ZERO,
            rotation: [0.0; 3],
            scale: [1.0; 3],
            mirror: [false; 3],
        }
    }
}

impl From<AxisVector> for FrameParts {
    fn from(translation: AxisVector) -> Self {
        FrameParts { translation, ..FrameParts::default() }
    }
}

impl FrameParts {
    /// True if it changes nothing.
    #[must_use]
    pub fn is_identity(&self) -> bool {
        *self == FrameParts::default()
    }

    /// Returns the shift of every axis, coarse and fine, mm and rad.
    #[must_use]
    pub fn shift(&self) -> AxisVector {
        self.translation + self.fine
    }

    /// Returns the linear part, `RT · SC · MI`.
    #[must_use]
    pub fn linear(&self, order: RotationOrder) -> Matrix {
        let mut linear = order.matrix(self.rotation);
        for column in 0..3 {
            let sign = if self.mirror[column] { -1.0 } else { 1.0 };
            let factor = sign * self.scale[column];
            linear.column_mut(column).scale_mut(factor);
        }
        linear
    }

    /// Returns the frame; `None` if a factor is 0.
    #[must_use]
    pub fn frame(&self, order: RotationOrder) -> Option<Frame> {
        Frame::new(self.linear(order), self.shift())
    }

    /// Returns `self : inner` in components; `None` if the chain has no such components, for example a rotation inside different factors.
    #[must_use]
    pub fn chain(&self, inner: &FrameParts, order: RotationOrder) -> Option<FrameParts> {
        let outer = self.linear(order);
        let through = |shift: &AxisVector| {
            let mut out = *shift;
            out.set_xyz(outer * shift.xyz());
            out
        };
        let translation = self.translation + through(&inner.translation);
        let fine = self.fine + through(&inner.fine);
        let mirror = [0, 1, 2].map(|slot| self.mirror[slot] != inner.mirror[slot]);
        let (rotation, scale) = taken_apart(&(outer * inner.linear(order)), mirror, order)?;
        Some(FrameParts { translation, fine, rotation, scale, mirror })
    }

    /// Returns the components of a frame, with its whole shift as coarse; of several solutions the one with the fewest mirrors. `None` if the frame is skew.
    #[must_use]
    pub fn of(frame: &Frame, order: RotationOrder) -> Option<FrameParts> {
        let translation = *frame.offset();
        let linear = frame.linear();
        let mirrored = linear.determinant() < 0.0;
        let ways = if mirrored {
            vec![[true, false, false], [false, true, false], [false, false, true], [true, true, true]]
        } else {
            vec![[false; 3]]
        };
        let turned = |angles: &[f64; 3]| angles.iter().map(|angle| angle.abs()).sum::<f64>();
        let parts = ways.into_iter().filter_map(|mirror| {
            let (rotation, scale) = taken_apart(linear, mirror, order)?;
            Some(FrameParts { translation, fine: AxisVector::ZERO, rotation, scale, mirror })
        });
        parts.min_by(|a, b| turned(&a.rotation).total_cmp(&turned(&b.rotation)))
    }

    /// Returns the inverse frame; `None` if it has no such components.
    #[must_use]
    pub fn inverse(&self, order: RotationOrder) -> Option<FrameParts> {
        let frame = self.frame(order)?;
        let zero = frame.unapply(&AxisVector::ZERO);
        let (rotation, scale) = taken_apart(frame.inverse().linear(), self.mirror, order)?;
        Some(FrameParts { translation: zero, fine: AxisVector::ZERO, rotation, scale, mirror: self.mirror })
    }
}

/// Returns angles about X, Y, Z and factors of a linear part with given mirrors.
fn taken_apart(linear: &Matrix, mirror: [bool; 3], order: RotationOrder) -> Option<([f64; 3], [f64; 3])> {
    let scale: [f64; 3] = [0, 1, 2].map(|column| {
        let length = linear.column(column).norm();
        if (length - 1.0).abs() < NOISE { 1.0 } else { length }
    });
    if scale.iter().any(|factor| *factor <= 0.0 || !factor.is_finite()) {
        return None;
    }
    let mut rotation = *linear;
    for column in 0..3 {
        let sign = if mirror[column] { -1.0 } else { 1.0 };
        let factor = sign / scale[column];
        rotation.column_mut(column).scale_mut(factor);
    }
    let is_rotation =
        (rotation.transpose() * rotation - Matrix::identity()).abs().max() < SKEW_LIMIT && rotation.determinant() > 0.0;
    if !is_rotation {
        return None;
    }
    let clean = |value: f64| if value.abs() < NOISE { 0.0 } else { value };
    Some((order.angles_rad(&rotation).map(clean), scale))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;

    const RPY: RotationOrder = RotationOrder::Rpy;

    fn rotated(x: f64, y: f64, z: f64) -> FrameParts {
        FrameParts { rotation: [x.to_radians(), y.to_radians(), z.to_radians()], ..FrameParts::default() }
    }

    fn apply(parts: &FrameParts, x: f64, y: f64, z: f64) -> Vector {
        let point = AxisVector([x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        parts.frame(RPY).unwrap().apply(&point).xyz()
    }

    #[test]
    fn rotation_is_about_x_then_y_then_z() {
        // Y10 rotated by 30 degrees about X, then by 90 degrees about Z.
        let found = apply(&rotated(30.0, 0.0, 90.0), 0.0, 10.0, 0.0);
        assert!((found - Vector::new(-8.660_254_037_844_387, 0.0, 5.0)).norm() < 1e-12, "{found}");
        assert_eq!(apply(&rotated(0.0, 0.0, 90.0), 10.0, 0.0, 0.0), Vector::new(0.0, 10.0, 0.0));
    }

    #[test]
    fn chains_taken_apart_are_the_chains() {
        let shift = FrameParts::from(AxisVector([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5]));
        let mirror = FrameParts { mirror: [true, false, false], ..FrameParts::default() };
        let scale = FrameParts { scale: [2.0; 3], ..FrameParts::default() };
        let all = [shift, rotated(10.0, -20.0, 30.0), mirror, scale, rotated(0.0, 90.0, 15.0)];
        for a in &all {
            for b in &all {
                let chain = a.chain(b, RPY).unwrap();
                let product = a.frame(RPY).unwrap().compose(&b.frame(RPY).unwrap());
                assert!((chain.linear(RPY) - product.linear()).norm() < 1e-12);
                assert!((chain.shift() - *product.offset()).0.iter().all(|value| value.abs() < 1e-12));
                let again = FrameParts::of(&product, RPY).unwrap();
                assert!((again.linear(RPY) - product.linear()).norm() < 1e-12);
                let whole = chain.inverse(RPY).unwrap().chain(&chain, RPY).unwrap();
                assert!((whole.linear(RPY) - Matrix::identity()).norm() < 1e-12);
                assert!(whole.shift().0.iter().all(|value| value.abs() < 1e-12));
            }
        }
        let uneven = FrameParts { scale: [2.0, 1.0, 1.0], ..FrameParts::default() };
        assert_eq!(uneven.chain(&rotated(0.0, 0.0, 30.0), RPY), None);
        assert!(rotated(0.0, 0.0, 30.0).chain(&uneven, RPY).is_some());
        assert_eq!(FrameParts { scale: [0.0, 1.0, 1.0], ..FrameParts::default() }.frame(RPY), None);
    }
}
