//! A working plane that is tilted in the workpiece: where the tool must point, and the frame that follows when the rotary axes turn.
//!
//! `below` is the frame of the zero offset, `tilt` the plane in it: a point p of the plane is the point `tilt`·p of the workpiece while the
//! rotary axes stand at the zero of the offset.

use super::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, Matrix, ROTARY_AXES, Vector};
use ncfix_base::source::Span;
use ncfix_machine::machine::{Kinematics, Machine};

/// Where a point of the plane is in the workpiece.
fn on_workpiece(kinematics: &Kinematics, below: &Frame, tilt: &Frame, tool_mm: &Vector, point: &Vector) -> Vector {
    // The pose at which the zero offset holds.
    let mut command = AxisVector::ZERO;
    for axis in ROTARY_AXES {
        command[axis] = below.shift(axis);
    }
    let mut position = AxisVector::ZERO;
    position.set_xyz(*point);
    command.set_xyz(below.apply(&tilt.apply(&position)).xyz() - tool_mm);
    kinematics.tip_mm(&command, tool_mm)
}

/// The direction across the plane in the workpiece.
pub(in crate::exec) fn workpiece_normal(
    kinematics: &Kinematics,
    below: &Frame,
    tilt: &Frame,
    tool_mm: &Vector,
) -> Vector {
    let at = |point: &Vector| on_workpiece(kinematics, below, tilt, tool_mm, point);
    at(&Vector::z()) - at(&Vector::zeros())
}

/// The frame that brings the tip to the points of the plane while the rotary axes stand as in `turned`: linear axes for a turned
/// workpiece are an affine function of the point. `None` where the linear axes cannot place the tip.
pub(in crate::exec) fn turned_frame(
    kinematics: &Kinematics,
    below: &Frame,
    tilt: &Frame,
    turned: &AxisVector,
    tool_mm: &Vector,
) -> Option<Frame> {
    let place = |point: &Vector| {
        let tip = on_workpiece(kinematics, below, tilt, tool_mm, point);
        kinematics.placed(&tip, turned, tool_mm).map(|command| command.xyz())
    };
    let zero = place(&Vector::zeros())?;
    let [x, y, z] = [Vector::x(), Vector::y(), Vector::z()].map(|unit| place(&unit));
    let linear = Matrix::from_columns(&[x? - zero, y? - zero, z? - zero]);
    let mut offset = *below.offset();
    offset.set_xyz(zero + tool_mm);
    Frame::new(linear, offset)
}

/// The finding about a plane that is tilted while the program has not stated where these axes are; `words` begin a block that does so.
pub(in crate::exec) fn unknown_places(span: Span, axes: AxisSet, words: &str) -> Fault {
    let names: Vec<String> = axes.iter().map(|axis| axis.to_string()).collect();
    let message =
        format!("the plane is tilted, and the program has not stated where these axes are: {}", names.join(", "));
    let places: String = axes.iter().map(|axis| format!(" {axis}…")).collect();
    let help = format!(
        "state all of them before it, and behind a tool change before it, for example in a block {words}{places}; before the first tool change --start does it too"
    );
    fault(Code::UNKNOWN_START, span, message, help)
}

/// The rotary axis that tilts the tool: the one most across it at the zero pose.
pub(in crate::exec) fn tilting_axis(kinematics: &Kinematics, machine: &Machine) -> Option<Axis> {
    let along = |axis: &Axis| {
        let direction = machine.axis(*axis).map_or_else(Vector::zeros, |data| data.direction);
        direction.dot(&machine.spindle.axis).abs()
    };
    kinematics.rotary_axes().min_by(|one, other| along(one).total_cmp(&along(other)))
}
