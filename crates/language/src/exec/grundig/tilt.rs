//! G7: a working plane that is tilted in the workpiece (`MillPlus`).
//!
//! The angles turn the plane about the active zero, as it stands with the rotary axes at the zero of the offset. The output has no G7: it states the
//! positions of all axes.

use super::channel::Channel;
use super::gathered::{Found, Gathered};
use super::setup;
use super::step;
use super::target;
use super::tilted::{Tilted, unturned};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::tilted_plane::workpiece_normal;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, Matrix, ROTARY_AXES, RotationOrder, Vector, about};
use ncfix_base::source::Span;
use ncfix_machine::machine::{Kinematics, Machine, PlaneOrder};
use ncfix_machine::snc::Kind;

/// The words of a block with G7.
struct Words {
    /// Rad; `None` if the block has no angle.
    angles: Option<[f64; 3]>,
    /// Parameters that receive the positions of rotary axes.
    registers: Vec<(Axis, usize, Span)>,
    /// L1=1: the rotary axes turn in this block.
    turns: bool,
}

/// `G7`
pub(super) fn plane(channel: &mut Channel<'_>, gathered: &mut Gathered, span: Span) -> Result<(), Fault> {
    let words = words(gathered)?;
    if channel.modal.contour.compensates() || channel.modal.turning.is_some() {
        let message = "G7 while a radius compensation is on";
        return Err(fault(Code::FORBIDDEN_STATE, span, message, "program G40 before it"));
    }
    let was_tilted = channel.modal.tilted.take().is_some();
    setup::refresh_setup(channel)?;
    let Some(angles) = words.angles else {
        if words.turns && !is_at_zero(channel) {
            // The block stays: the control does with the axes what it does in the program.
            channel.outlet.push_line(Kind::Verbatim(b"G7 L1=1".to_vec()));
            channel.modal.unturned = rotary_axes(channel.settings.machine);
            channel.modal.position.known = channel.modal.position.known.difference(channel.modal.unturned);
        } else {
            end_on_control(channel);
        }
        return Ok(());
    };
    if !channel.modal.unturned.is_empty() && angles != [0.0; 3] {
        return Err(unturned(channel.modal.unturned, span));
    }
    let rotation = rotation(angles, channel.settings.machine.control.grundig.plane_order, span)?;
    let (turned, is_tilted) = aligned(channel, &rotation, span)?;
    if !was_tilted || !is_tilted {
        end_on_control(channel);
    }
    store(channel, &words.registers, &turned)?;
    if words.turns {
        turn(channel, &turned)?;
    }
    if is_tilted {
        let below = channel.standing.setup.frame;
        let plane = Frame::rotation(rotation);
        channel.modal.tilted = Some(Box::new(Tilted { plane, turned, below, is_stale: false }));
        setup::refresh_setup(channel)?;
    }
    Ok(())
}

/// Writes `G7` alone: the output states the axes in their own coordinates, in which no plane of an earlier program may be in force.
fn end_on_control(channel: &mut Channel<'_>) {
    channel.outlet.push_line(Kind::Verbatim(b"G7".to_vec()));
}

/// `true` if the rotary axes are known to be at the zero of the offset, where L1=1 turns none of them.
fn is_at_zero(channel: &Channel<'_>) -> bool {
    let machine = channel.settings.machine;
    let position = &channel.modal.position;
    let frame = &channel.standing.setup.frame;
    let is_there = |axis: Axis| {
        let from_zero_rad = (position.command[axis] - frame.shift(axis)).abs();
        position.known.contains(axis) && from_zero_rad < 0.5 * machine.control.increment_rad
    };
    rotary_axes(machine).iter().all(is_there)
}

fn rotary_axes(machine: &Machine) -> AxisSet {
    ROTARY_AXES.into_iter().filter(|axis| machine.axis(*axis).is_some()).collect()
}

fn words(gathered: &mut Gathered) -> Result<Words, Fault> {
    let mut words = Words { angles: None, registers: Vec::new(), turns: false };
    for (place, axis) in ROTARY_AXES.into_iter().enumerate() {
        let letter = axis.letter();
        if let Some((degrees, _)) = gathered.once(letter, Some(5))?
            && let Some(angle) = words.angles.get_or_insert_default().get_mut(place)
        {
            *angle = degrees.to_radians();
        }
        if let Some((_, at)) = gathered.once(letter, Some(6))? {
            let message = format!("{axis}6= of G7 adds to the present angles");
            return Err(fault(Code::NOT_SUPPORTED, at, message, "write the whole angles, A5=, B5= and C5="));
        }
        if let Some((number, at)) = gathered.once(letter, Some(7))? {
            words.registers.push((axis, register((number, at))?, at));
        }
    }
    words.turns = match gathered.once(b'L', Some(1))? {
        None | Some((0.0, _)) => false,
        Some((1.0, _)) => true,
        Some((value, at)) => {
            let message = format!("L1={value} of G7 is not supported");
            return Err(fault(Code::NOT_SUPPORTED, at, message, "write L1=0, or L1=1 to turn the rotary axes"));
        }
    };
    Ok(words)
}

fn register((number, span): Found) -> Result<usize, Fault> {
    if number.fract() != 0.0 || !(0.0..=9999.0).contains(&number) {
        let message = format!("{number} is not the number of a parameter");
        return Err(bad_value(span, message, "A7=, B7= and C7= of G7 name E parameters: B7=254 is E254"));
    }
    // A whole number within range.
    Ok(number as usize)
}

/// The rotation of the plane.
fn rotation(angles: [f64; 3], order: Option<PlaneOrder>, span: Span) -> Result<Matrix, Fault> {
    let count = angles.iter().filter(|angle| **angle != 0.0).count();
    match order {
        Some(PlaneOrder::Turned) => {
            Ok(about(&Vector::x(), angles[0]) * about(&Vector::y(), angles[1]) * about(&Vector::z(), angles[2]))
        }
        Some(PlaneOrder::Fixed) => Ok(RotationOrder::Rpy.matrix(angles)),
        // The order has no effect.
        None if count < 2 => Ok(RotationOrder::Rpy.matrix(angles)),
        None => {
            let message = "G7 with several angles: the order in which they turn the plane is not known";
            let help = "set control.grundig_plane_order = \"turned\" if B5 and C5 turn about the axes that the angles before have turned, or \"fixed\" if about the axes of the workpiece";
            Err(bad_value(span, message, help))
        }
    }
}

/// The rotary axes that align the tool with the normal of the plane, on the grid of the control, and `true` if the plane is tilted.
fn aligned(channel: &mut Channel<'_>, rotation: &Matrix, span: Span) -> Result<(AxisVector, bool), Fault> {
    let machine = channel.settings.machine;
    let kinematics = Kinematics::of_head(machine, channel.modal.tool.head);
    let below = channel.standing.setup.frame;
    let mut near = channel.modal.position.command;
    if *rotation == Matrix::identity() {
        // The plane of the zero offset: the axes are at its zero.
        kinematics.rotary_axes().for_each(|axis| near[axis] = below.shift(axis));
        return Ok((near, false));
    }
    for axis in kinematics.rotary_axes().filter(|axis| !channel.modal.position.known.contains(*axis)) {
        near[axis] = below.shift(axis);
    }
    let normal = workpiece_normal(&kinematics, &below, &Frame::rotation(*rotation), &channel.standing.setup.tool_mm);
    let found = kinematics.orientations(&normal, &near);
    let Some(mut turned) = found[0].or(found[1]) else {
        let message = "the rotary axes cannot align the tool with the plane of G7";
        return Err(fault(Code::BAD_SWIVEL, span, message, "check its angles and the travel of the rotary axes"));
    };
    let step_rad = machine.control.increment_rad;
    for axis in kinematics.rotary_axes() {
        let own = turned[axis] - below.shift(axis);
        let on_grid = (own / step_rad).round() * step_rad;
        if (on_grid - own).abs() > 1e-12 {
            turned[axis] = below.shift(axis) + on_grid;
        }
    }
    if let ([Some(one), Some(other)], true) = (found, channel.settings.strict)
        && kinematics.rotary_axes().any(|axis| (one[axis] - other[axis]).abs() > step_rad)
    {
        let shown = |place: &AxisVector| {
            let words: Vec<String> =
                kinematics.rotary_axes().map(|axis| format!("{axis}{:.3}", place[axis].to_degrees())).collect();
            words.join(" ")
        };
        let message = format!("G7 has two solutions; the output has {}, not {}", shown(&one), shown(&other));
        let help = "both cut the same workpiece; compare the position of the rotary axes with that of the control";
        channel.outlet.warnings.push(fault(Code::UNUSUAL_MOTION, span, message, help));
    }
    Ok((turned, true))
}

/// Puts the positions of rotary axes into parameters, in degrees of the program.
fn store(channel: &mut Channel<'_>, registers: &[(Axis, usize, Span)], turned: &AxisVector) -> Result<(), Fault> {
    for &(axis, number, span) in registers {
        if channel.settings.machine.axis(axis).is_none() {
            let message = format!("{axis}7= of G7, and the machine has no axis {axis}");
            return Err(fault(Code::NO_AXIS, span, message, "check the program, or the topology of the machine"));
        }
        let own = (turned[axis] - channel.standing.setup.frame.shift(axis)).to_degrees();
        channel.parameters.set(number, (own * 1e9).round() / 1e9, span)?;
    }
    Ok(())
}

/// Turns the rotary axes at rapid; the linear axes stay.
fn turn(channel: &mut Channel<'_>, turned: &AxisVector) -> Result<(), Fault> {
    let mut to = target::here(&channel.modal, &channel.standing);
    let mut named = AxisSet::EMPTY;
    for axis in rotary_axes(channel.settings.machine).iter() {
        to[axis] = turned[axis] - channel.standing.setup.frame.shift(axis);
        named.insert(axis);
    }
    step::rapid_line(channel, &to, named)
}
