//! Active zero offsets and shifts.

use ncfix_base::geometry::Axis;
use ncfix_base::geometry::AxisSet;
use ncfix_base::geometry::AxisVector;
use ncfix_base::geometry::Frame;
use ncfix_base::geometry::FrameParts;
use ncfix_base::geometry::Matrix;
use ncfix_base::geometry::Plane;
use ncfix_base::geometry::Vector;
use ncfix_machine::machine::Control;
use ncfix_machine::machine::GrundigControl;
use ncfix_machine::machine::Machine;
use std::collections::BTreeMap;
/// The pallet offset in the table of zero offsets.
pub(super) const PALLET: &str = "G52";

/// The active frames and their tables.
#[derive(Clone, Debug)]
pub(super) struct Frames {
    /// Zero offsets by name: `G52`, `G54`, `G54 I3`.
    pub(super) table: BTreeMap<String, FrameParts>,
    /// The settable offset; `None` for G53.
    pub(super) settable: Option<String>,
    /// `true` if G52 is active.
    pub(super) pallet: bool,
    /// Shift of G92 and G93, mm and rad.
    pub(super) shift: AxisVector,
    /// Rotation of G92 and G93.
    pub(super) angle_rad: f64,
    /// The plane about whose tool axis they rotate.
    pub(super) turned_in: Plane,
    /// Axes that G73 mirrors, including rotary axes.
    pub(super) mirrored: AxisSet,
    /// Factor of G73.
    pub(super) factor: f64,
    /// Axes of the scale factor.
    pub(super) scaled: AxisSet,
    /// `true` if an active offset has no value.
    pub(super) assumed: bool,
}

impl Frames {
    pub(super) fn new(machine: &Machine) -> Frames {
        Frames {
            table: machine.zero_offsets.clone(),
            settable: machine.control.initial_zero_offset.clone().filter(|name| name != PALLET && name != "G53"),
            pallet: false,
            shift: AxisVector::ZERO,
            angle_rad: 0.0,
            turned_in: Plane::XY,
            mirrored: AxisSet::EMPTY,
            factor: 1.0,
            scaled: AxisSet::EMPTY,
            assumed: false,
        }
    }

    /// The frame of the output: the stored offsets.
    pub(super) fn shown(&self, control: &Control) -> Option<Frame> {
        let order = control.rotation_order;
        let stored = |name: &str| self.table.get(name).map_or(Some(Frame::identity()), |parts| parts.frame(order));
        let pallet = if self.pallet { stored(PALLET)? } else { Frame::identity() };
        let settable = self.settable.as_deref().map_or(Some(Frame::identity()), stored)?;
        Some(pallet.compose(&settable))
    }

    /// The frame of the program without stored offsets.
    pub(super) fn programmed(&self, settings: &GrundigControl) -> Option<Frame> {
        let turned = Frame::translation(self.shift).compose(&Frame::rotation(self.rotation()));
        let factors = [Axis::X, Axis::Y, Axis::Z].map(|axis| {
            let sign = if self.mirrored.contains(axis) { -1.0 } else { 1.0 };
            sign * if self.scaled.contains(axis) { self.factor } else { 1.0 }
        });
        if factors == [1.0; 3] {
            return Some(turned);
        }
        let scale = Frame::scale(Vector::from(factors))?;
        Some(if settings.mirror_outside { scale.compose(&turned) } else { turned.compose(&scale) })
    }

    /// The rotation of G92 and G93.
    pub(super) fn rotation(&self) -> Matrix {
        turned_about(self.turned_in, self.angle_rad)
    }

    /// Sign of a rotary word.
    pub(super) fn sign(&self, axis: Axis) -> f64 {
        if axis.is_rotary() && self.mirrored.contains(axis) { -1.0 } else { 1.0 }
    }

    /// Cancels G92 and G93.
    pub(super) fn cancel_programmed(&mut self) {
        self.shift = AxisVector::ZERO;
        self.angle_rad = 0.0;
    }
}

/// A rotation about the tool axis of a plane; quarter turns are exact.
pub(super) fn turned_about(plane: Plane, angle_rad: f64) -> Matrix {
    if angle_rad == 0.0 {
        return Matrix::identity();
    }
    let quarters = angle_rad / std::f64::consts::FRAC_PI_2;
    let (sine, cosine) = if (quarters - quarters.round()).abs() < 1e-14 {
        match quarters.round().rem_euclid(4.0) as u8 {
            0 => (0.0, 1.0),
            1 => (1.0, 0.0),
            2 => (0.0, -1.0),
            _ => (-1.0, 0.0),
        }
    } else {
        angle_rad.sin_cos()
    };
    let [first, second, third] = plane.axes().map(Axis::slot);
    let mut out = Matrix::identity();
    out[(first, first)] = cosine;
    out[(second, second)] = cosine;
    out[(first, second)] = -sine;
    out[(second, first)] = sine;
    out[(third, third)] = 1.0;
    out
}
