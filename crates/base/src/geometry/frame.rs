//! A frame: the map from programmed positions to the control's machine positions.

use super::{AXES, Axis, AxisSet, AxisVector, Matrix, Plane, Vector};

/// Lengths squared and products of directions nearer than this share are the same.
const SAME_SHAPE: f64 = 1e-12;

/// `machine = linear · programmed + translation` for X Y Z, and an offset each for U V W A B C.
///
/// Sinumerik: the total of base frame, settable frame and programmable frame (TRANS, ROT, SCALE, MIRROR), right-most nearest to the
/// programmed value. U V W A B C are shifted only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    linear: Matrix,
    inverse: Matrix,
    /// Offsets of all axes; X Y Z hold the translation, mm, A B C in rad.
    offset: AxisVector,
    is_translation: bool,
}

impl Frame {
    /// The frame that changes nothing.
    #[must_use]
    pub fn identity() -> Frame {
        Frame::translation(AxisVector::ZERO)
    }

    /// A frame that only shifts, each axis by its own amount (mm, rad).
    #[must_use]
    pub fn translation(offset: AxisVector) -> Frame {
        Frame { linear: Matrix::identity(), inverse: Matrix::identity(), offset, is_translation: true }
    }

    /// A rotation about the origin; the matrix must be orthonormal.
    #[must_use]
    pub fn rotation(rotation: Matrix) -> Frame {
        Frame::linear_part(rotation, rotation.transpose())
    }

    /// A scale along X, Y and Z; `None` where a factor cannot be undone.
    #[must_use]
    pub fn scale(factors: Vector) -> Option<Frame> {
        let is_sound =
            |factor: &f64| factor.is_finite() && factor.abs() > f64::MIN_POSITIVE && (1.0 / factor).is_finite();
        let inverse = factors.map(|factor| 1.0 / factor);
        let is_good = factors.iter().all(is_sound);
        is_good.then(|| Frame::linear_part(Matrix::from_diagonal(&factors), Matrix::from_diagonal(&inverse)))
    }

    /// Mirrors those of X, Y and Z that are in the set.
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

    /// The same with other offsets.
    #[must_use]
    pub fn with_offset(self, offset: AxisVector) -> Frame {
        Frame { offset, ..self }
    }

    /// The frame that undoes this one.
    #[must_use]
    pub fn inverse(&self) -> Frame {
        let mut offset = AxisVector::ZERO - self.offset;
        offset.set_xyz(-(self.inverse * self.offset.xyz()));
        Frame { linear: self.inverse, inverse: self.linear, offset, is_translation: self.is_translation }
    }

    /// Which axes are stated where only those in `known` were: with `inward`, of programmed coordinates from machine positions, else the
    /// other way. An axis that the frame mixes with others is known where all of them are.
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

    /// The machine axes that move where the program moves those of a set.
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

    /// Whether the frame only shifts.
    #[must_use]
    pub fn is_translation(&self) -> bool {
        self.is_translation
    }

    /// The shift of every axis, mm and rad.
    #[must_use]
    pub fn offset(&self) -> &AxisVector {
        &self.offset
    }

    /// The linear part, for directions.
    #[must_use]
    pub fn linear(&self) -> &Matrix {
        &self.linear
    }

    /// The frame with this linear part and these offsets; `None` where the linear part cannot be inverted.
    #[must_use]
    pub fn new(linear: Matrix, offset: AxisVector) -> Option<Frame> {
        if linear == Matrix::identity() {
            return Some(Frame::translation(offset));
        }
        let inverse = linear.try_inverse()?;
        Some(Frame { linear, inverse, offset, is_translation: false })
    }

    /// Whether every circle stays one: turned, mirrored, or scaled alike in all directions.
    #[must_use]
    pub fn keeps_shapes(&self) -> bool {
        self.keeps_circles(Plane::XY) && self.keeps_circles(Plane::YZ)
    }

    /// Whether circles of a plane stay circles, and what is across it stays across it: turned, mirrored, or scaled alike.
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

    /// `self : inner`: first `inner`, then this one.
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

    /// Programmed to machine.
    #[must_use]
    pub fn apply(&self, programmed: &AxisVector) -> AxisVector {
        let mut out = *programmed + self.offset;
        if !self.is_translation {
            out.set_xyz(self.linear * programmed.xyz() + self.offset.xyz());
        }
        out
    }

    /// Machine to programmed.
    #[must_use]
    pub fn unapply(&self, machine: &AxisVector) -> AxisVector {
        let mut out = *machine - self.offset;
        if !self.is_translation {
            let shifted = out.xyz();
            out.set_xyz(self.inverse * shifted);
        }
        out
    }

    /// A direction, programmed to machine.
    #[must_use]
    pub fn apply_direction(&self, programmed: Vector) -> Vector {
        self.linear * programmed
    }

    /// A direction, machine to programmed.
    #[must_use]
    pub fn unapply_direction(&self, machine: Vector) -> Vector {
        self.inverse * machine
    }

    /// How far one of X, Y, Z moves in programmed coordinates for each of the machine's.
    #[must_use]
    pub fn unapply_row(&self, axis: Axis) -> [f64; 3] {
        [0, 1, 2].map(|column| self.inverse.get((axis.slot(), column)).copied().unwrap_or_default())
    }

    /// The shift of one axis, mm or rad.
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
