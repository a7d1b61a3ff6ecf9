//! A tilted plane in force, and the motions that it permits.

use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::tilted_plane::turned_frame;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, ROTARY_AXES, Vector};
use ncfix_base::source::Span;
use ncfix_machine::machine::{Kinematics, Machine};
use std::f64::consts::TAU;

/// A tilted plane.
#[derive(Clone, Debug)]
pub(super) struct Tilted {
    /// From the plane to the workpiece.
    pub(super) plane: Frame,
    /// Rotary axes that align the tool with its normal, rad; the linear axes have no meaning.
    pub(super) turned: AxisVector,
    /// Zero offset and shift for which the angles were programmed.
    pub(super) below: Frame,
    /// `true` if the zero offset or shift has changed since.
    pub(super) is_stale: bool,
}

impl Tilted {
    /// The frame of the plane above a zero offset and shift; `None` if the linear axes cannot place the tip.
    pub(super) fn frame(&mut self, kinematics: &Kinematics, below: &Frame, tool_mm: &Vector) -> Option<Frame> {
        self.is_stale = *below != self.below;
        turned_frame(kinematics, below, &self.plane, &self.turned, tool_mm)
    }

    /// Rejects a motion of linear axes for which the plane has no meaning.
    pub(super) fn check(
        &self,
        machine: &Machine,
        target: &AxisVector,
        named: AxisSet,
        span: Span,
    ) -> Result<(), Fault> {
        if named.iter().all(Axis::is_rotary) {
            return Ok(());
        }
        if self.is_stale {
            let message = "the zero offset or shift has changed since G7";
            return Err(fault(Code::BAD_SWIVEL, span, message, "program G7 again after it"));
        }
        // The program may state the angles with the digits of the control.
        let most_rad = machine.control.increment_rad;
        let is_off = |axis: &Axis| {
            let off = target[*axis] - self.turned[*axis];
            machine.axis(*axis).is_some() && (off - (off / TAU).round() * TAU).abs() > most_rad
        };
        let Some(axis) = ROTARY_AXES.into_iter().find(is_off) else { return Ok(()) };
        let message = format!(
            "a motion in the tilted plane of G7 with {axis} at {:.4} degrees; the tool is normal to the plane at {:.4}",
            target[axis].to_degrees(),
            self.turned[axis].to_degrees()
        );
        let help = "turn the rotary axes first, with L1=1 in the block of G7 or to the angles of its A7=, B7=, C7=";
        Err(fault(Code::BAD_SWIVEL, span, message, help))
    }
}
