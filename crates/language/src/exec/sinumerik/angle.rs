//! ANG: straight contour elements by their angle to the abscissa.
//!
//! With one end coordinate, the other is computed. Without any, the end is the intersection with the next element, which has an end and an angle;
//! until then the motion is pending.

use super::address::Named;
use super::channel;
use super::channel::Channel;
use super::channel::OpenAngle;
use super::gathered::{Gathered, NamedValue};
use super::modal::Modal;
use super::modal::MotionKind;
use crate::exec::core::contour::crossing;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::position::BEGIN_ABSOLUTE;
use crate::exec::core::standing::InForce;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector};
use ncfix_base::source::Span;

/// Executes ANG, and requires it after a motion without end.
pub(super) fn angle(channel: &mut Channel<'_>, gathered: &mut Gathered, span: Span) -> Result<(), Fault> {
    let angle = gathered.named(Named::Ang).copied();
    let open = channel.open_angle.take();
    if angle.is_none() && open.is_none() {
        return Ok(());
    }
    let [abscissa, ordinate, _] = channel.modal.modes.plane.axes();
    let plane: AxisSet = [abscissa, ordinate].into_iter().collect();
    let is_straight = matches!(channel.modal.modes.motion, MotionKind::Line | MotionKind::Rapid);
    let named = gathered.named.intersection(plane);
    if let Some(open) = open {
        let angle = angle.filter(|_| is_straight && named == plane);
        let done = angle
            .map(|angle| {
                close_angle(&mut channel.modal, &channel.standing, &mut channel.outlet, gathered, &open, &angle)
            })
            .transpose();
        return match done {
            Ok(Some(())) => Ok(()),
            other => {
                end_open(&mut channel.outlet, None, AxisSet::EMPTY);
                other.map(|_| ())?;
                Err(channel::without_end(open.span))
            }
        };
    }
    let Some(angle) = angle else { return Ok(()) };
    let suppressed = gathered.suppress.is_some();
    if !is_straight || suppressed || named == plane || gathered.center.iter().any(Option::is_some) {
        let message = "ANG in a block that is not a straight move, or that gives both coordinates of its end";
        let help = "keep ANG or the second coordinate; a block with both must follow a block with ANG alone";
        return Err(bad_value(angle.span, message, help));
    }
    if let Some(axis) = plane.difference(channel.modal.position.known).iter().next().filter(|_| channel.settings.strict)
    {
        let message = format!("the end of this element depends on {axis}, whose position is not known yet");
        let help = BEGIN_ABSOLUTE;
        return Err(fault(Code::UNKNOWN_START, angle.span, message, help));
    }
    let here = channel.standing.setup.programmed(&channel.modal.position.command);
    let start = [here[abscissa], here[ordinate]];
    let angle_rad = angle.value.to_radians();
    let Some(axis) = named.iter().next() else {
        channel.open_angle = Some(OpenAngle { start, angle_rad, span });
        return Ok(());
    };
    let given = programmed_end(&channel.modal, gathered, axis, &here);
    let (sin, cos) = angle_rad.sin_cos();
    let (other, run, rise, from) =
        if axis == abscissa { (ordinate, cos, sin, start[1]) } else { (abscissa, sin, cos, start[0]) };
    let end = from + (given - here[axis]) * rise / run;
    if run.abs() < 1e-9 || !end.is_finite() {
        let message = format!("at {} degrees the line never reaches this {axis}", angle.value);
        return Err(bad_value(angle.span, message, "give the other coordinate, or correct the angle"));
    }
    set_end(&channel.modal, gathered, other, end);
    Ok(())
}

/// The element after a motion without end: both meet at the intersection.
fn close_angle(
    modal: &mut Modal,
    standing: &InForce,
    outlet: &mut MotionSink<'_>,
    gathered: &Gathered,
    open: &OpenAngle,
    angle: &NamedValue,
) -> Result<(), Fault> {
    let [abscissa, ordinate, _] = modal.modes.plane.axes();
    let plane: AxisSet = [abscissa, ordinate].into_iter().collect();
    let is_incremental = |axis: Axis| {
        gathered.as_incremental.contains(axis) || modal.modes.incremental && !gathered.as_absolute.contains(axis)
    };
    if is_incremental(abscissa) || is_incremental(ordinate) {
        let message =
            "the end of this element is incremental, and its start is the intersection with the previous element";
        return Err(bad_value(angle.span, message, "program the end in absolute coordinates"));
    }
    let here = standing.setup.programmed(&modal.position.command);
    let end = [programmed_end(modal, gathered, abscissa, &here), programmed_end(modal, gathered, ordinate, &here)];
    let Some(corner) = crossing((open.start, open.angle_rad), (end, angle.value.to_radians())) else {
        let message = "this element and the previous one have the same direction: they do not meet";
        return Err(bad_value(angle.span, message, "correct one of the angles"));
    };
    let mut place = here;
    place[abscissa] = corner[0];
    place[ordinate] = corner[1];
    modal.position.command = standing.setup.command(&place);
    modal.programmed[abscissa] = corner[0];
    modal.programmed[ordinate] = corner[1];
    modal.position.known = modal.position.known.union(plane);
    end_open(outlet, Some(modal.position.command), plane);
    Ok(())
}

fn programmed_end(modal: &Modal, gathered: &Gathered, axis: Axis, here: &AxisVector) -> f64 {
    let value = gathered.axes[axis] * modal.modes.scale();
    let is_incremental =
        gathered.as_incremental.contains(axis) || modal.modes.incremental && !gathered.as_absolute.contains(axis);
    if is_incremental { here[axis] + value } else { value }
}

fn set_end(modal: &Modal, gathered: &mut Gathered, axis: Axis, value: f64) {
    gathered.axes[axis] = value / modal.modes.scale();
    gathered.named.insert(axis);
    gathered.as_incremental.remove(axis);
    gathered.as_absolute.insert(axis);
}

fn end_open(outlet: &mut MotionSink<'_>, end: Option<AxisVector>, axes: AxisSet) {
    outlet.close(end, axes);
}
