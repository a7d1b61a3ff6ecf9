//! Tilted working planes of Fanuc: G68.2, G68.4 and G53.1.
//!
//! The feature coordinate system is fixed to the workpiece with the rotary axes at the zero of the zero offset. After G53.1 the tool is normal to the
//! plane, and the frame brings its tip to the same points of the workpiece.

use super::channel::Channel;
use super::codes::{Group, name_of};
use super::forbidden;
use super::frames::Stand;
use super::gathered::Gathered;
use super::measure;
use super::modal::Modal;
use super::setup;
use super::step;
use super::step::Step;
use super::target;
use super::text;
use super::tilted::{Part, Plane, by_euler, by_roll_pitch_yaw, euler_of};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::tilted_plane::{tilting_axis, turned_frame, unknown_places, workpiece_normal};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, Matrix, Vector};
use ncfix_base::source::Span;
use ncfix_machine::machine::{Kinematics, Machine};
use ncfix_machine::snc::{Kind, MotionMode};
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// Sine of the angle between the tool and Z below which they are parallel.
const LEAST_TILT: f64 = 1e-9;
/// Angles nearer to each other than this are equal, rad.
const SAME_ANGLE_RAD: f64 = 1e-9;

/// `G68.2`, `G68.3`, `G68.4`
pub(super) fn tilt(channel: &mut Channel<'_>, gathered: &Gathered, code: u16, span: Span) -> Result<(), Fault> {
    let form = gathered.raw(b'P').unwrap_or(0.0);
    let mut origin = Vector::zeros();
    for (value, letter) in origin.iter_mut().zip(*b"XYZ") {
        *value = measure::length(channel, gathered, letter)?.unwrap_or(0.0);
    }
    let turn = measure::angle(channel.settings.machine, channel.language, &mut channel.warned, gathered, b'R')?;
    if turn.is_some() && form != 2.0 {
        return Err(refused(gathered.span_of(b'R'), format!("R with {} is not supported", name_of(code))));
    }
    let mut angles = [0.0; 3];
    if form != 3.0 {
        for (value, letter) in angles.iter_mut().zip(*b"IJK") {
            *value = measure::angle(channel.settings.machine, channel.language, &mut channel.warned, gathered, letter)?
                .unwrap_or(0.0);
        }
    }
    let order = gathered.raw(b'Q');
    let whole = |value: f64| if (0.0..1000.0).contains(&value) { value.round() as u32 } else { u32::MAX };
    let (place, rotation) = match (code, form) {
        (682 | 684, 0.0) => (origin, by_euler(angles)),
        (682 | 684, 1.0) => {
            let order = whole(order.unwrap_or(123.0));
            let Some(rotation) = by_roll_pitch_yaw(angles, order) else {
                let message = "Q is not an order of the axes 1, 2 and 3";
                return Err(bad_value(gathered.span_of(b'Q'), message, "write for example Q123"));
            };
            (origin, rotation)
        }
        (682, 2.0 | 3.0) => {
            let direction = Vector::from([b'I', b'J', b'K'].map(|letter| gathered.raw(letter).unwrap_or(0.0)));
            let index = whole(order.unwrap_or(0.0));
            let part = Part { form: form as u32, index, point: origin, direction, turn_rad: turn.unwrap_or_default() };
            match channel.special.tilt_parts.take(&part) {
                Plane::Incomplete => return Ok(()),
                Plane::Complete(origin, rotation) => (origin, rotation),
                Plane::Degenerate => {
                    let message = "the points or directions of G68.2 do not define a plane";
                    return Err(bad_value(
                        span,
                        message,
                        "give three points that are not collinear, or two different directions",
                    ));
                }
                Plane::Unknown => {
                    return Err(bad_value(span, "G68.2 does not have this Q", "number its blocks from Q1"));
                }
            }
        }
        _ => return Err(refused(span, format!("this form of {} is not supported", name_of(code)))),
    };
    let (origin, rotation) =
        if code == 684 { upon_tilt(&channel.modal, place, rotation, span)? } else { (place, rotation) };
    let done = channel.modal.transforms.set_tilt(origin, rotation);
    done.map_err(|within| refused(span, format!("{} within {within}", name_of(code))))
}

/// `G68.4`: relative to the active plane.
fn upon_tilt(modal: &Modal, origin: Vector, rotation: Matrix, span: Span) -> Result<(Vector, Matrix), Fault> {
    let Some(below) = modal.transforms.tilt() else {
        let message = "G68.4 without a tilted plane";
        return Err(bad_value(span, message, "begin with G68.2"));
    };
    Ok((below.linear() * origin + below.offset().xyz(), below.linear() * rotation))
}

/// `G53.1`: turns the rotary axes until the tool is normal to the plane.
pub(super) fn tool_on_plane(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let span = gathered.code_span(Group::Action);
    let choice = gathered.raw(b'P');
    let Some(tilt) = channel.modal.transforms.tilt().copied() else {
        return Err(bad_value(span, "G53.1 without a tilted plane", "program G68.2 before it"));
    };
    if channel.modal.contour.compensates() || channel.modal.turning.is_some() {
        return Err(refused(span, "G53.1 under radius compensation or tool center point control".to_owned()));
    }
    let kinematics = Kinematics::of_head(channel.settings.machine, channel.modal.tool.head);
    if kinematics.rotary_axes().next().is_none() {
        return Ok(());
    }
    let unstated =
        |axis: &Axis| channel.settings.machine.axis(*axis).is_some() && !channel.modal.position.known.contains(*axis);
    let unknown: AxisSet = kinematics.rotary_axes().filter(unstated).collect();
    let below = channel.modal.below_transforms();
    let tool_mm = channel.standing.setup.tool_mm;
    let normal = workpiece_normal(&kinematics, &below, &tilt, &tool_mm);
    let near = channel.modal.position.command;
    let machine = channel.settings.machine;
    let depends = || depends_on_place(&kinematics, machine, &normal, choice, &near, unknown);
    if channel.settings.strict && !unknown.is_empty() && depends() {
        // The plane is activated nevertheless, so that the following blocks are not rejected for its absence.
        channel.outlet.warnings.push(unknown_places(span, unknown, "G90 G53 G0"));
        channel.modal.position.known = channel.modal.position.known.union(unknown);
    }
    let turned = match (kinematics.orientations(&normal, &near), choice) {
        ([None, None], _) => {
            let message = "the rotary axes cannot align the tool with this plane";
            let help = "check the angles of the plane and the travel of the rotary axes";
            return Err(fault(Code::BAD_SWIVEL, span, message, help));
        }
        (solutions, None | Some(0.0 | 1.0 | 2.0)) => chosen(&kinematics, machine, solutions, choice).unwrap_or(near),
        _ => return Err(bad_value(gathered.span_of(b'P'), "P of G53.1 is not 0, 1 or 2", "correct P")),
    };
    end_kept(channel);
    channel.modal.transforms.leave_stand();
    setup::refresh_setup(channel);
    let mut turned = turned;
    let least_rad = channel.settings.machine.control.increment_rad;
    let is_known = unknown.is_empty() || !channel.settings.strict;
    if is_known && kinematics.rotary_axes().all(|axis| (turned[axis] - near[axis]).abs() < least_rad) {
        // The axes are there already, within an increment.
        kinematics.rotary_axes().for_each(|axis| turned[axis] = near[axis]);
        channel.empty();
    } else {
        on_grid(channel, &kinematics, &mut turned);
        turn(channel, &kinematics, &turned, span)?;
    }
    let total = turned_frame(&kinematics, &below, &tilt, &turned, &tool_mm)
        .ok_or_else(|| refused(span, "the linear axes of this machine cannot position the tool tip".to_owned()))?;
    let is_kept = channel.settings.keeps_tilt && is_tilted(&total) && below == channel.modal.settable;
    if is_kept && channel.settings.strict {
        keep(channel, &tilt, choice);
    }
    let frame = below.inverse().compose(&total);
    channel.modal.transforms.stand_on_tilt(Stand { frame, below, tool_mm, is_kept });
    setup::refresh_setup(channel);
    Ok(())
}

/// The solution that P chooses: 1 the larger angle of the axis that tilts the tool, 2 the smaller one, otherwise the shorter way.
fn chosen(
    kinematics: &Kinematics,
    machine: &Machine,
    solutions: [Option<AxisVector>; 2],
    choice: Option<f64>,
) -> Option<AxisVector> {
    match (solutions, choice) {
        ([Some(one), Some(other)], Some(sign @ (1.0 | 2.0))) => {
            let axis = tilting_axis(kinematics, machine);
            let is_first = axis.is_none_or(|axis| (one[axis] > other[axis]) == (sign == 1.0));
            Some(if is_first { one } else { other })
        }
        ([one, other], _) => one.or(other),
    }
}

/// `true` if the angles of a plane depend on the places of axes from which they turn: the control takes the shorter of two ways, and the nearest turn.
fn depends_on_place(
    kinematics: &Kinematics,
    machine: &Machine,
    normal: &Vector,
    choice: Option<f64>,
    near: &AxisVector,
    unknown: AxisSet,
) -> bool {
    let is_chosen = matches!(choice, Some(1.0 | 2.0));
    if !is_chosen && kinematics.orientations(normal, near).iter().all(Option::is_some) {
        return true;
    }
    // From both ends of the travel and from between them; of a modulo axis from places that no turn equals.
    let found = [0.0, 0.3, 1.0].map(|share| {
        let mut from = *near;
        for axis in unknown.iter() {
            let [low, high] = machine.axis(axis).and_then(|data| data.travel).unwrap_or([0.0, 0.7 * TAU]);
            from[axis] = low + share * (high - low);
        }
        chosen(kinematics, machine, kinematics.orientations(normal, &from), choice)
    });
    let is_modulo = |axis: Axis| machine.axis(axis).is_some_and(|data| data.modulo);
    let differ = |one: &AxisVector, other: &AxisVector| {
        kinematics.rotary_axes().any(|axis| {
            let apart = one[axis] - other[axis];
            let apart = if is_modulo(axis) { (0.5 * apart).sin() } else { apart };
            apart.abs() > SAME_ANGLE_RAD
        })
    };
    let [Some(one), Some(second), Some(third)] = found else { return true };
    differ(&one, &second) || differ(&one, &third)
}

/// `true` if the tool is not along Z in a frame: arcs of the plane are then no arcs of the axes.
fn is_tilted(frame: &Frame) -> bool {
    frame.apply_direction(Vector::z()).cross(&Vector::z()).norm() > LEAST_TILT
}

/// Writes a plane for the control, and aligns the tool there: the rotary axes are at their positions already.
fn keep(channel: &mut Channel<'_>, tilt: &Frame, choice: Option<f64>) {
    let machine = channel.settings.machine;
    let mut plane = "G68.2".to_owned();
    for (letter, place) in b"XYZ".iter().zip(tilt.offset().xyz().iter()) {
        text::append_length(machine, channel.language, &mut plane, *letter, *place);
    }
    for (letter, angle) in b"IJK".iter().zip(euler_of(tilt.linear())) {
        text::append(channel.language, &mut plane, *letter, angle.to_degrees());
    }
    let mut aligned = "G53.1".to_owned();
    if let Some(choice) = choice {
        // Writing to a string cannot fail.
        let _ = write!(aligned, " P{choice:.0}");
    }
    for words in [plane, aligned] {
        channel.outlet.push_line(Kind::Verbatim(words.into_bytes()));
    }
}

/// Ends a plane that the control tilts.
pub(super) fn end_kept(channel: &mut Channel<'_>) {
    if channel.settings.strict && channel.modal.transforms.kept_stand().is_some() {
        channel.push(Kind::Keep("G69"));
    }
}

/// Handles a change of the tool length while the tool is normal to the plane. The length acts along the tool, which is along Z of the plane: the tip
/// of the new length goes to the same points of the plane, and the rotary axes stay (B-63944EN, tilted working plane command: G43 comes after G53.1).
pub(super) fn stand_anew(channel: &mut Channel<'_>, span: Span) -> Result<(), Fault> {
    let tool_mm = channel.standing.setup.tool_mm;
    let Some(tilt) = channel.modal.transforms.tilt().copied() else { return Ok(()) };
    let stand = channel.modal.transforms.stand().filter(|stand| stand.tool_mm != tool_mm);
    let Some(is_kept) = stand.map(|stand| stand.is_kept) else { return Ok(()) };
    let kinematics = Kinematics::of_head(channel.settings.machine, channel.modal.tool.head);
    let below = channel.modal.below_transforms();
    let total = turned_frame(&kinematics, &below, &tilt, &channel.modal.position.command, &tool_mm)
        .ok_or_else(|| refused(span, "the linear axes of this machine cannot position the tool tip".to_owned()))?;
    let frame = below.inverse().compose(&total);
    channel.modal.transforms.stand_on_tilt(Stand { frame, below, tool_mm, is_kept });
    setup::refresh_setup(channel);
    Ok(())
}

/// Rounds the positions of the rotary axes to those that the control can command: the plane is that of the axes as they stand.
fn on_grid(channel: &Channel<'_>, kinematics: &Kinematics, turned: &mut AxisVector) {
    let grid_rad = channel.settings.machine.control.grid[1];
    for axis in kinematics.rotary_axes() {
        let shift = channel.standing.setup.frame.shift(axis);
        turned[axis] = shift + ((turned[axis] - shift) / grid_rad).round() * grid_rad;
    }
}

/// Turns the rotary axes at rapid; the linear axes stay.
fn turn(channel: &mut Channel<'_>, kinematics: &Kinematics, turned: &AxisVector, span: Span) -> Result<(), Fault> {
    let mut end = target::here(&channel.modal, &channel.standing);
    let frame = channel.standing.setup.frame;
    let mut named = AxisSet::EMPTY;
    for axis in kinematics.rotary_axes() {
        end[axis] = turned[axis] - frame.shift(axis);
        named.insert(axis);
    }
    step::step(channel, Step { rapid: true, end, named, feed_named: false, motion_mode: MotionMode::Path, span })
}

fn refused(span: Span, message: String) -> Fault {
    forbidden::refused_with(span, &message, "program the plane another way, or its motions in machine coordinates")
}
