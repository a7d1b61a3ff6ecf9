//! A frame: the map from programmed positions to the control's machine positions.

use super::{Axis, AxisVector, Matrix, Plane, Vector};

/// Lengths squared and products of directions nearer than this share are the same.
const SAME_SHAPE: f64 = 1e-12;

/// `machine = linear · programmed + translation` for X Y Z, and an offset each for U V W A B C.
///
/// Sinumerik: the total of settable frame and programmable frame (TRANS, ATRANS), right-most nearest to the
/// programmed value.
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
        Frame {
            linear: self.linear * inner.linear,
            inverse: inner.inverse * self.inverse,
            offset,
            is_translation: self.is_translation && inner.is_translation,
        }
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
