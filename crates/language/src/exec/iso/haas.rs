//! Hole patterns, circular pockets and turned work offsets of a Haas (mill operator's manual, 2017).

use super::channel::Channel;
use super::codes::{Group, name_of};
use super::compensation;
use super::cycle;
use super::forbidden;
use super::gathered::Gathered;
use super::measure::{self, whole};
use super::pattern::Pattern;
use super::setup;
use super::step::{self, Step};
use super::target;
use crate::exec::core::arc::behind_frame;
use crate::exec::core::contour::{ContourRequest, Side};
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Arc, Axis, AxisSet, AxisVector, Plane, Vector};
use ncfix_machine::machine::Kinematics;
use ncfix_machine::snc::Kind;
use std::sync::Arc as Shared;

/// Largest number of holes of a pattern, of circles and of passes of a pocket.
const MOST: u32 = 10_000;

/// `G70 I J L`, `G71 I J K L`, `G72 I J L`: the cycle in force at holes on a circle, an arc or a line.
pub(super) fn holes(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    let (span, name) = (gathered.code_span(Group::Action), name_of(code));
    let in_force = channel.modal.modes.motion;
    if !cycle::is_cycle(in_force, false) || gathered.code(Group::Cycle).is_some() {
        let message = format!("{name} without a drilling cycle in force");
        return Err(bad_value(span, message, "program the cycle with L0 in the block before it"));
    }
    if !gathered.axes.is_empty() {
        let message = format!("{name} with axis words");
        return Err(bad_value(span, message, "move to the center of the pattern in a block before the cycle"));
    }
    let needed = |word: Option<f64>, letter: char| {
        word.ok_or_else(|| bad_value(span, format!("{name} needs {letter}"), "write I, J, L; with G71 K too"))
    };
    let machine = channel.settings.machine;
    let size = needed(measure::length(channel, gathered, b'I')?, 'I')?;
    let first = measure::angle(machine, channel.language, &mut channel.warned, gathered, b'J')?.unwrap_or_default();
    let count = whole(needed(gathered.raw(b'L'), 'L')?, gathered.span_of(b'L'), "L")?;
    if !(1..=MOST).contains(&count) || size <= 0.0 {
        let message = format!("{name} with {count} holes and a distance of {size} mm");
        return Err(bad_value(span, message, "write I above 0 and L from 1 to 10000"));
    }
    if code == 720 {
        let message = "the first hole of G72 is at the current position";
        let help = "the manual does not state it clearly: check it on the control, or program the holes one by one";
        channel.outlet.warnings.push(fault(Code::UNUSUAL_MOTION, span, message, help));
    }
    let pattern = match code {
        720 => Pattern::Line { step_mm: [size * first.cos(), size * first.sin()], count },
        710 => {
            let step = measure::angle(machine, channel.language, &mut channel.warned, gathered, b'K')?;
            Pattern::Circle { radius_mm: size, first, step: needed(step, 'K')?, count }
        }
        _ => Pattern::Circle { radius_mm: size, first, step: std::f64::consts::TAU / f64::from(count), count },
    };
    cycle::cycle_at(channel, gathered, in_force, Some(pattern))
}

/// `G254`, `G255`: the zero offset stays at its place on the turned table, and its axes stay parallel to those of the machine. The output has positions of the
/// zero offset itself.
pub(super) fn turned_zero(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    let (span, name) = (gathered.code_span(Group::Action), name_of(code));
    forbidden::no_compensation(channel.language, &channel.modal, span, &name)?;
    if !gathered.axes.is_empty() {
        return Err(bad_value(span, format!("{name} with axis words"), "write it in its own block"));
    }
    channel.push(Kind::Keep("G255"));
    channel.modal.turned_zero = None;
    if code == 2540 {
        let machine = channel.settings.machine;
        let is_free = channel.modal.turning.is_none() && channel.modal.transforms.is_empty();
        let kinematics = Kinematics::of_head(machine, channel.modal.tool.head);
        let is_table = |axis: Axis| machine.topology.workpiece.contains(&axis);
        let offset = channel.modal.settable;
        let is_plain = offset.is_translation() && kinematics.rotary_axes().all(|axis| offset.shift(axis) == 0.0);
        if !(is_free && is_plain && kinematics.rotary_axes().all(is_table)) {
            let message =
                "G254 with a turning head, a turned zero offset, a transformation or tool center point control";
            let help = "end the transformation; the rotary axes must carry the workpiece, and their offsets must be 0";
            return Err(fault(Code::NOT_SUPPORTED, span, message, help));
        }
        let mut zero = channel.modal.position.command;
        for axis in kinematics.rotary_axes() {
            target::check_stated(channel.settings.strict, &channel.modal, axis, span)?;
        }
        AxisSet::XYZ.iter().for_each(|axis| zero[axis] = offset.shift(axis));
        let turned = kinematics.command_on_workpiece(&zero, &Vector::zeros());
        let Some(turned) = turned else {
            let message = "G254 needs X, Y and Z";
            return Err(fault(Code::NO_AXIS, span, message, "check the topology in the machine file"));
        };
        let mut shift = AxisVector::ZERO;
        AxisSet::XYZ.iter().for_each(|axis| shift[axis] = turned[axis] - zero[axis]);
        channel.modal.turned_zero = Some(shift);
    }
    setup::refresh_setup(channel);
    Ok(())
}

/// `G12`, `G13`: full circles about the position of the tool, from the radius I in steps of Q to K, at the depth Z. Half circles lead to the first circle, from
/// one to the next, and back to the center; the control has its own ways there.
pub(super) fn circular_pocket(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    let (span, name, clockwise) = (gathered.code_span(Group::Action), name_of(code), code == 120);
    forbidden::no_compensation(channel.language, &channel.modal, span, &name)?;
    if channel.modal.modes.plane != Plane::XY {
        return Err(bad_value(span, format!("{name} outside the XY plane"), "select G17"));
    }
    if channel.modal.turning.is_some() || !channel.standing.setup.frame.keeps_circles(Plane::XY) {
        let message = format!("{name} under tool center point control or unequal scaling");
        return Err(fault(Code::NOT_SUPPORTED, span, message, "end it first"));
    }
    let here = target::here(&channel.modal, &channel.standing);
    let strict = channel.settings.strict;
    for axis in AxisSet::XYZ.iter() {
        let is_relative = axis != Axis::Z || channel.modal.modes.incremental;
        if is_relative {
            target::check_stated(strict, &channel.modal, axis, span)?;
        }
        if axis != Axis::Z && gathered.axes.contains(axis) {
            let message = format!("{name} with {axis}");
            return Err(bad_value(
                gathered.span_of(axis.letter()),
                message,
                "move to the center in the block before it",
            ));
        }
    }
    let Some(number) = channel.modal.d else {
        let message = format!("{name} without D: the control would use the D of an earlier program");
        return Err(fault(Code::BAD_COMPENSATION, span, message, "write the number of the offset, for example D1"));
    };
    let radius = compensation::radius_of(&channel.settings, &channel.written, &mut channel.outlet, number, span)?;
    let mut shown = channel.modal.contour;
    shown.side = Side::Left;
    let wish = ContourRequest::of(shown, radius, span, channel.outlet.file());
    channel.outlet.name_register(&wish, || format!("D{number}"));
    let first = measure::length(channel, gathered, b'I')?;
    let (last, step) = (measure::length(channel, gathered, b'K')?, measure::length(channel, gathered, b'Q')?);
    let circles =
        circles(first, last, step, radius).map_err(|message| bad_value(span, format!("{name}: {message}"), HELP))?;
    let repeats = gathered.raw(b'L').map(|value| whole(value, gathered.span_of(b'L'), "L")).transpose()?.unwrap_or(1);
    let incremental = channel.modal.modes.incremental;
    if !(1..=MOST).contains(&repeats) || repeats > 1 && !incremental {
        let message = format!("{name} with L{repeats}");
        return Err(bad_value(gathered.span_of(b'L'), message, "write L from 1 to 10000 under G91"));
    }
    let depth = if gathered.has(b'Z') { Some(target::axis_value(channel, gathered, Axis::Z)?) } else { None };
    let message =
        format!("{name}: half circles lead to the first circle, from one circle to the next, and back to the center");
    let help = "the control has its own ways between the circles: check that the material allows half circles, or program G2 and G3";
    channel.outlet.warnings.push(fault(Code::UNUSUAL_MOTION, span, message, help));
    let mut is_first = true;
    for pass in 1..=repeats {
        if let Some(depth) = depth {
            let mut end = target::here(&channel.modal, &channel.standing);
            end[Axis::Z] = if incremental { here[Axis::Z] + f64::from(pass) * depth } else { depth };
            begin(channel, &mut is_first);
            let named = [Axis::Z].into_iter().collect();
            step::step(channel, Step::straight(gathered, false, end, named))?;
        }
        let (center, mut at) = ([here[Axis::X], here[Axis::Y]], 0.0_f64);
        for &circle in circles.iter().chain(&[0.0]) {
            // From one side of the center to the other, with the center between the two ends.
            let side = if at > 0.0 { -1.0 } else { 1.0 };
            let to: f64 = side * circle;
            begin(channel, &mut is_first);
            arc(channel, gathered, [center[0] + to, center[1]], [center[0] + at.midpoint(to), center[1]], clockwise)?;
            if circle > 0.0 {
                begin(channel, &mut is_first);
                arc(channel, gathered, [center[0] + to, center[1]], center, clockwise)?;
            }
            at = to;
        }
    }
    Ok(())
}

const HELP: &str = "I and K are radii of the pocket, above the radius of the tool; Q is the step between them";

/// Radii of the tool center, mm, in their order.
fn circles(first: Option<f64>, last: Option<f64>, step: Option<f64>, radius: f64) -> Result<Vec<f64>, String> {
    let Some(first) = first else { return Err("I, the radius of the first circle, is missing".to_owned()) };
    if first <= radius {
        return Err(format!("I {first} is not above the radius {radius} of the tool"));
    }
    let mut out = vec![first - radius];
    match (last, step) {
        (None, None) => {}
        (Some(last), Some(step)) if last > first && step > 0.0 && (last - first) / step <= f64::from(MOST) => {
            let mut next = first + step;
            while next < last - 1e-9 {
                out.push(next - radius);
                next += step;
            }
            out.push(last - radius);
        }
        _ => return Err("K must be above I, and needs Q, the step of the radius".to_owned()),
    }
    Ok(out)
}

/// Begins the next line of the output, but for the first one.
fn begin(channel: &mut Channel<'_>, is_first: &mut bool) {
    if !std::mem::take(is_first) {
        channel.outlet.begin_line();
    }
}

/// An arc of the XY plane with feed; a full circle if it ends at the tool.
fn arc(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    end: [f64; 2],
    center: [f64; 2],
    clockwise: bool,
) -> Result<(), Fault> {
    let setup = Shared::clone(&channel.standing.setup);
    let named: AxisSet = [Axis::X, Axis::Y].into_iter().collect();
    let from = target::here(&channel.modal, &channel.standing);
    let is_full = from[Axis::X] == end[0] && from[Axis::Y] == end[1];
    let mut to = from;
    (to[Axis::X], to[Axis::Y]) = (end[0], end[1]);
    let base = channel.modal.position.command;
    let target = if is_full { base } else { step::reach(&channel.modal, &setup, named, &to, gathered.span)? };
    // If the frame is a pure shift, the center is given in base coordinates.
    let is_shifted = setup.frame.is_translation();
    let center_mm = if is_shifted {
        [base[Axis::X] + (center[0] - from[Axis::X]), base[Axis::Y] + (center[1] - from[Axis::Y])]
    } else {
        center
    };
    let shape = Arc { plane: Plane::XY, clockwise, center_mm, extra_turns: 0 };
    let ends = if is_shifted { [&base, &target] } else { [&from, &to] };
    let shape = behind_frame(&shape, ends, &target, &setup, channel.settings.machine.control.chord_tolerance_mm);
    let step = Step { feed_named: false, ..Step::straight(gathered, false, to, named) };
    step::send(channel, step, target, shape, setup)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_go_from_i_to_k_in_steps_of_q() {
        assert_eq!(circles(Some(8.0), Some(20.0), Some(4.0), 3.0).unwrap(), [5.0, 9.0, 13.0, 17.0]);
        assert_eq!(circles(Some(10.0), None, None, 3.0).unwrap(), [7.0]);
        // A step beyond K ends at K.
        assert_eq!(circles(Some(8.0), Some(9.0), Some(4.0), 3.0).unwrap(), [5.0, 6.0]);
        assert!(circles(Some(3.0), None, None, 3.0).is_err());
        assert!(circles(Some(8.0), Some(7.0), Some(1.0), 3.0).is_err());
        assert!(circles(Some(8.0), Some(9.0), None, 3.0).is_err());
        assert!(circles(Some(8.0), Some(9.0), Some(1e-9), 3.0).is_err());
    }
}
