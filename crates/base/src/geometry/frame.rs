//! Frame: the map from programmed positions to the machine positions of the control.

use super::{AXES, Axis, AxisSet, AxisVector, Matrix, Plane, Vector};

/// Relative tolerance for squared lengths and for products of directions.
const SAME_SHAPE: f64 = 1e-12;

/// `machine = linear · programmed + translation` for X Y Z, and one offset each for U V W A B C.
///
/// Sinumerik: the total of base frame, settable frame and programmable frame (TRANS, ROT, SCALE, MIRROR); the right-most one is applied first to the
/// programmed value. U V W A B C are only shifted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    linear: Matrix,
    inverse: Matrix,
    /// Offsets of all axes; X Y Z hold the translation, mm, A B C in rad.
    offset: AxisVector,
    is_translation: bool,
}

impl Frame {
    /// Returns the identity.
    #[must_use]
    pub fn identity() -> Frame {
        Frame::translation(AxisVector::ZERO)
    }

    /// Returns a frame that only shifts, each axis by its own amount (mm, rad).
    #[must_use]
    pub fn translation(offset: AxisVector) -> Frame {
        Frame { linear: Matrix::identity(), inverse: Matrix::identity(), offset, is_translation: true }
    }

    /// Returns a rotation about the origin; the matrix must be orthonormal.
    #[must_use]
    pub fn rotation(rotation: Matrix) -> Frame {
        Frame::linear_part(rotation, rotation.transpose())
    }

    /// Returns a scale along X, Y and Z; `None` if a factor cannot be inverted.
    #[must_use]
    pub fn scale(factors: Vector) -> Option<Frame> {
        let is_sound =
            |factor: &f64| factor.is_finite() && factor.abs() > f64::MIN_POSITIVE && (1.0 / factor).is_finite();
        let inverse = factors.map(|factor| 1.0 / factor);
        let is_good = factors.iter().all(is_sound);
        is_good.then(|| Frame::linear_part(Matrix::from_diagonal(&factors), Matrix::from_diagonal(&inverse)))
    }

    /// Mirrors the axes of the set among X, Y and Z.
    #[must_use]
    pub fn mirror(axes: AxisSet) -> Frame {
        let signs =
            Vector::from_iterator(AXES.into_iter().take(3).map(|axis| if axes.contains(axis) { -1.0 } else { 1.0 }));
        Frame::linear_part(Matrix::from_diagonal(&signs), Matrix::from_diagonal(&signs))
    }

    fn linear_part(linear: Matrix, inverse: Matrix) -> Frame {
        let is_translation = linear == Matrix::identity();
        Frame { linear, inverse, offset: AxisVector::ZERO, is_translation }
    }

    /// Returns this frame with other offsets.
    #[must_use]
    pub fn with_offset(self, offset: AxisVector) -> Frame {
        Frame { offset, ..self }
    }

    /// Returns the inverse frame.
    #[must_use]
    pub fn inverse(&self) -> Frame {
        let mut offset = AxisVector::ZERO - self.offset;
        offset.set_xyz(-(self.inverse * self.offset.xyz()));
        Frame { linear: self.inverse, inverse: self.linear, offset, is_translation: self.is_translation }
    }

    /// Returns the axes whose positions are known, given those in `known`: with `inward`, programmed coordinates from machine positions, else vice versa. An
    /// axis that the frame mixes with others is known if all of them are.
    #[must_use]
    pub fn known_across(&self, known: AxisSet, inward: bool) -> AxisSet {
        if self.is_translation {
            return known;
        }
        let mixing = if inward { &self.inverse } else { &self.linear };
        let mut out = known;
        for (row, axis) in AXES.into_iter().take(3).enumerate() {
            let size = mixing.row(row).norm();
            let is_known = AXES
                .into_iter()
                .take(3)
                .enumerate()
                .all(|(column, other)| known.contains(other) || mixing[(row, column)].abs() <= SAME_SHAPE * size);
            if is_known {
                out.insert(axis);
            } else {
                out.remove(axis);
            }
        }
        out
    }

    /// Returns the machine axes that move if the program moves the axes of a set.
    #[must_use]
    pub fn mixed_with(&self, programmed: AxisSet) -> AxisSet {
        if self.is_translation {
            return programmed;
        }
        let mut out = programmed.difference(AxisSet::XYZ);
        for (row, axis) in AXES.into_iter().take(3).enumerate() {
            let size = self.linear.row(row).norm();
            let moves = |other: Axis| self.linear[(row, other.slot())].abs() > SAME_SHAPE * size;
            if programmed.intersection(AxisSet::XYZ).iter().any(moves) {
                out.insert(axis);
            }
        }
        out
    }

    /// True if the frame only shifts.
    #[must_use]
    pub fn is_translation(&self) -> bool {
        self.is_translation
    }

    /// Returns the shift of every axis, mm and rad.
    #[must_use]
    pub fn offset(&self) -> &AxisVector {
        &self.offset
    }

    /// Returns the linear part, for directions.
    #[must_use]
    pub fn linear(&self) -> &Matrix {
        &self.linear
    }

    /// Creates the frame with this linear part and these offsets; `None` if the linear part cannot be inverted.
    #[must_use]
    pub fn new(linear: Matrix, offset: AxisVector) -> Option<Frame> {
        if linear == Matrix::identity() {
            return Some(Frame::translation(offset));
        }
        let inverse = linear.try_inverse()?;
        Some(Frame { linear, inverse, offset, is_translation: false })
    }

    /// True if every circle stays a circle: rotated, mirrored, or scaled equally in all directions.
    #[must_use]
    pub fn keeps_shapes(&self) -> bool {
        self.keeps_circles(Plane::XY) && self.keeps_circles(Plane::YZ)
    }

    /// True if circles of a plane stay circles, and its normal stays perpendicular to it: rotated, mirrored, or scaled equally.
    #[must_use]
    pub fn keeps_circles(&self, plane: Plane) -> bool {
        if self.is_translation {
            return true;
        }
        let columns = plane.axes().map(|axis| self.linear.column(axis.slot()).into_owned());
        let [first, second, across] = columns;
        let size = first.norm_squared();
        let off = [first.dot(&second), first.dot(&across), second.dot(&across), second.norm_squared() - size];
        off.iter().all(|value| value.abs() <= SAME_SHAPE * size.max(across.norm_squared()))
    }

    /// Returns `self : inner`: first `inner`, then this frame.
    #[must_use]
    pub fn compose(&self, inner: &Frame) -> Frame {
        let mut offset = self.offset + inner.offset;
        offset.set_xyz(self.linear * inner.offset.xyz() + self.offset.xyz());
        if self.is_translation && inner.is_translation {
            return Frame { offset, ..*self };
        }
        let (linear, inverse) = (self.linear * inner.linear, inner.inverse * self.inverse);
        Frame { linear, inverse, offset, is_translation: linear == Matrix::identity() }
    }

    /// Maps a programmed position to the machine position.
    #[must_use]
    pub fn apply(&self, programmed: &AxisVector) -> AxisVector {
        let mut out = *programmed + self.offset;
        if !self.is_translation {
            out.set_xyz(self.linear * programmed.xyz() + self.offset.xyz());
        }
        out
    }

    /// Maps a machine position to the programmed position.
    #[must_use]
    pub fn unapply(&self, machine: &AxisVector) -> AxisVector {
        let mut out = *machine - self.offset;
        if !self.is_translation {
            let shifted = out.xyz();
            out.set_xyz(self.inverse * shifted);
        }
        out
    }

    /// Maps a programmed direction to the machine direction.
    #[must_use]
    pub fn apply_direction(&self, programmed: Vector) -> Vector {
        self.linear * programmed
    }

    /// Maps a machine direction to the programmed direction.
    #[must_use]
    pub fn unapply_direction(&self, machine: Vector) -> Vector {
        self.inverse * machine
    }

    /// Returns the derivatives of one of X, Y, Z in programmed coordinates by those of the machine.
    #[must_use]
    pub fn unapply_row(&self, axis: Axis) -> [f64; 3] {
        [0, 1, 2].map(|column| self.inverse.get((axis.slot(), column)).copied().unwrap_or_default())
    }

    /// Returns the shift of one axis, mm or rad.
    #[must_use]
    pub fn shift(&self, axis: Axis) -> f64 {
        self.offset[axis]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unapply_undoes_apply_and_compose_chains() {
        let a = Frame::translation(AxisVector([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0]));
        let b = Frame::translation(AxisVector([10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25]));
        let p = AxisVector([4.0, 5.0, 6.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let total = a.compose(&b);
        assert_eq!(total.apply(&p), a.apply(&b.apply(&p)));
        assert_eq!(total.unapply(&total.apply(&p)), p);
        assert_eq!(total.apply(&p).0, [15.0, 7.0, 9.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.25]);
    }
}
