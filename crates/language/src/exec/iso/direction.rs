//! Tool directions of G43.5: I J K at the end of a block become positions of the rotary axes.

use super::modal::Modal;
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::settings::RunSettings;
use ncfix_machine::machine::Machine;
use std::f64::consts::TAU;

use super::codes::Group;
use super::gathered::Gathered;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::path::Path;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::Span;
use ncfix_machine::machine::Kinematics;

/// Angles nearer to each other than this are equal, rad.
const SAME_ANGLE_RAD: f64 = 1e-9;
/// The code, in tenths.
const BY_DIRECTION: u16 = 435;
const LETTERS: &[u8; 3] = b"IJK";

/// `true` if blocks give the tool direction.
pub(super) fn has_directions(modal: &Modal) -> bool {
    modal.turning.is_some() && modal.codes.is(Group::Length, BY_DIRECTION)
}

/// The tool direction at the end of a motion of the code `motion`, in tenths; missing components are zero.
pub(super) fn tool_direction(
    machine: &Machine,
    modal: &Modal,
    gathered: &Gathered,
    motion: u16,
) -> Result<Option<(Vector, Span)>, Fault> {
    if !has_directions(modal) {
        return Ok(None);
    }
    if let Some(axis) = gathered.axes.iter().find(|axis| axis.is_rotary()) {
        let message = format!("a position of {axis} under G43.5");
        let help = "give the direction of the tool with I, J, K, or program G43.4";
        return Err(fault(Code::BAD_WORD_VALUE, gathered.span_of(axis.letter()), message, help));
    }
    if let Some(q) = gathered.raw(b'Q').filter(|&q| q != 0.0) {
        let message = format!("Q{q}: a tool inclined from its direction towards the motion is not supported");
        let help = "give I, J, K of the actual tool direction, without Q";
        return Err(fault(Code::NOT_SUPPORTED, gathered.span_of(b'Q'), message, help));
    }
    let Some(&first) = LETTERS.iter().find(|&&letter| gathered.has(letter)) else { return Ok(None) };
    let span = gathered.span_of(first);
    match motion {
        0 | 10 => {}
        20 | 30 if gathered.has(b'R') => {}
        20 | 30 => {
            let message = "under G43.5 I, J, K are the tool direction, so this arc has no center";
            return Err(fault(Code::NO_CENTER, span, message, "give the radius with R"));
        }
        _ => {
            let message = "a tool direction for this kind of motion";
            return Err(fault(Code::NOT_SUPPORTED, span, message, "use G0, G1, G2 or G3 under G43.5"));
        }
    }
    let on_table = machine.topology.workpiece.iter().any(|axis| axis.is_rotary());
    if on_table && gathered.code(super::codes::Group::Length) == Some(BY_DIRECTION) {
        let message = "a tool direction in the block of G43.5, on a machine with a rotary axis in its table";
        return Err(fault(Code::BAD_WORD_VALUE, span, message, "give it in a later block"));
    }
    // The letters are vector components here, not lengths.
    let values = LETTERS.map(|letter| gathered.raw(letter).unwrap_or_default());
    Ok(Some((Vector::from(values), span)))
}

/// Adds the direction of a block to its motion.
pub(super) fn orient(
    settings: &RunSettings<'_>,
    modal: &mut Modal,
    outlet: &mut MotionSink<'_>,
    path: &mut Path,
    direction: Vector,
    span: Span,
) -> Result<(), Fault> {
    let Some(kinematics) = outlet.kinematics.as_deref() else { return Ok(()) };
    let direction = path.setup.frame.apply_direction(direction);
    let Some(direction) = direction.try_normalize(1e-9).filter(|unit| unit.iter().all(|part| part.is_finite())) else {
        return Err(bad_value(span, "a tool direction of length zero", "give I, J or K a value other than 0"));
    };
    // Two axis positions give the same direction; the selected one depends on the current position.
    if let Some(axis) = kinematics.rotary_axes().find(|&axis| !path.start_known.contains(axis) && settings.strict) {
        return Err(modal.position.unknown(span, axis));
    }
    let mut axes: Vec<Axis> = kinematics.rotary_axes().collect();
    let in_table = |axis: &Axis| settings.machine.topology.workpiece.contains(axis);
    if !axes.iter().all(in_table) {
        axes.reverse();
    }
    let Some(found) = choice(kinematics, &axes, &direction, &path.start) else {
        let [i, j, k] = [direction.x, direction.y, direction.z];
        let message = format!("the rotary axes cannot orient the tool along {i:.6} {j:.6} {k:.6} of the machine");
        let help = "check the direction, the travel of the rotary axes, and the kinematics in the machine file";
        return Err(fault(Code::NO_ORIENTATION, span, message, help));
    };
    for axis in axes {
        path.motion.target[axis] = found[axis];
        path.motion.named.insert(axis);
        path.motion.known.insert(axis);
        modal.position.command[axis] = found[axis];
        modal.position.known.insert(axis);
    }
    Ok(())
}

/// Selects from the two solutions for a direction: the one that turns the first axis least, then the next. If both turn equally, the one nearer to
/// zero (Fanuc, tool center point control type 2 without motion ranges: master before slave, table before head).
fn choice(kinematics: &Kinematics, axes: &[Axis], direction: &Vector, start: &AxisVector) -> Option<AxisVector> {
    let [first, second] = kinematics.orientations(direction, start);
    let (Some(one), Some(other)) = (first, second) else { return first.or(second) };
    let way = |end: &AxisVector, axis: Axis| (end[axis] - start[axis]).abs();
    let from_zero = |end: &AxisVector, axis: Axis| (end[axis] - (end[axis] / TAU).round() * TAU).abs();
    let ways = axes.iter().map(|&axis| way(&one, axis) - way(&other, axis));
    let places = axes.iter().map(|&axis| from_zero(&one, axis) - from_zero(&other, axis));
    let decisive = ways.chain(places).find(|difference| difference.abs() > SAME_ANGLE_RAD);
    Some(if decisive.is_some_and(|difference| difference > 0.0) { other } else { one })
}
