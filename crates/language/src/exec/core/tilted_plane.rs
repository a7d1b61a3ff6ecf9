//! A working plane that is tilted in the workpiece: the required tool direction, and the frame after the rotary axes have turned.
//!
//! `below` is the frame of the zero offset, `tilt` the plane in it: a point p of the plane is the point `tilt`·p of the workpiece with the rotary
//! axes at the zero of the offset.

use super::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, Matrix, ROTARY_AXES, Vector};
use ncfix_base::source::Span;
use ncfix_machine::machine::{Kinematics, Machine};

/// Position of a point of the plane in the workpiece.
fn on_workpiece(kinematics: &Kinematics, below: &Frame, tilt: &Frame, tool_mm: &Vector, point: &Vector) -> Vector {
    // The pose for which the zero offset is defined.
    let mut command = AxisVector::ZERO;
    for axis in ROTARY_AXES {
        command[axis] = below.shift(axis);
    }
    let mut position = AxisVector::ZERO;
    position.set_xyz(*point);
    command.set_xyz(below.apply(&tilt.apply(&position)).xyz() - tool_mm);
    kinematics.tip_mm(&command, tool_mm)
}

/// The normal of the plane in the workpiece.
pub(in crate::exec) fn workpiece_normal(
    kinematics: &Kinematics,
    below: &Frame,
    tilt: &Frame,
    tool_mm: &Vector,
) -> Vector {
    let at = |point: &Vector| on_workpiece(kinematics, below, tilt, tool_mm, point);
    at(&Vector::z()) - at(&Vector::zeros())
}

/// The frame that brings the tip to the points of the plane with the rotary axes at `turned`: linear axes for a turned workpiece are an affine
/// function of the point. `None` if the linear axes cannot place the tip.
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

/// The fault for a plane that is tilted while the positions of these axes are not stated; `words` begin a block that states them.
pub(in crate::exec) fn unknown_places(span: Span, axes: AxisSet, words: &str) -> Fault {
    let names: Vec<String> = axes.iter().map(|axis| axis.to_string()).collect();
    let message =
        format!("the plane is tilted, and the positions of these axes are not known yet: {}", names.join(", "));
    let places: String = axes.iter().map(|axis| format!(" {axis}…")).collect();
    let help = format!(
        "program all of them before it, after any tool change, for example in a block {words}{places}; before the first tool change --start does it too"
    );
    fault(Code::UNKNOWN_START, span, message, help)
}

/// The rotary axis that tilts the tool: the one most perpendicular to the tool at the zero pose.
pub(in crate::exec) fn tilting_axis(kinematics: &Kinematics, machine: &Machine) -> Option<Axis> {
    let along = |axis: &Axis| {
        let direction = machine.axis(*axis).map_or_else(Vector::zeros, |data| data.direction);
        direction.dot(kinematics.tool_axis()).abs()
    };
    kinematics.rotary_axes().min_by(|one, other| along(one).total_cmp(&along(other)))
}
