//! A tilted plane in force, and the motions that it permits.

use crate::exec::core::fault::{Fault, bad_value, fault};
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

/// Takes the axes of a motion after `G7 L1=1`: X, Y and Z may move again as soon as the program has positioned the rotary axes, or at rapid with them.
pub(super) fn position_again(open: &mut AxisSet, named: AxisSet, rapid: bool, span: Span) -> Result<(), Fault> {
    let before = *open;
    *open = before.difference(named);
    let moves_others = !named.intersection(AxisSet::XYZ).is_empty();
    if moves_others && (!open.is_empty() || !rapid) { Err(unturned(before, span)) } else { Ok(()) }
}

/// The fault for a block that depends on the rotary axes after `G7 L1=1`.
pub(super) fn unturned(axes: AxisSet, span: Span) -> Fault {
    let shown: Vec<String> = axes.iter().map(|axis| axis.to_string()).collect();
    let message = format!(
        "a G7 with L1=1 and without angles precedes this block, and no source states if {} then turned to zero",
        shown.join(" and ")
    );
    let help = "position them at rapid before it, or write G7 alone if they stay, G7 A5=0 B5=0 C5=0 L1=1 if they turn";
    bad_value(span, message, help)
}
