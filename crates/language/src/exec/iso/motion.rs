//! Turns the gathered words of a block into motions: targets, ways, and what the stream is told of them.

use super::arc;
use super::compensation;
use super::cycle;
use super::direction;
use super::measure;
use super::offsets;
use super::one_axis;
use super::special;
use super::tilt;
use std::sync::Arc as Shared;

use super::channel::Channel;
use super::codes::Group;
use super::gathered::Gathered;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::path::{Path, Shape};
use crate::exec::core::rollover;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, PlaneBasis};
use ncfix_base::source::Span;
use ncfix_machine::snc::{FeedUnit, Kind, Manner, Move, Setup};

/// Positions beyond this are no positions, mm or rad.
const FARTHEST: f64 = 1e9;

/// One motion to a position.
#[derive(Debug)]
pub(super) struct Step {
    pub(super) rapid: bool,
    /// Where it ends, as programmed.
    pub(super) end: AxisVector,
    /// Axes that it names.
    pub(super) named: AxisSet,
    /// Whether its block has F.
    pub(super) feed_named: bool,
    pub(super) manner: Manner,
    pub(super) span: Span,
}

impl Step {
    /// A straight motion of a block.
    pub(super) fn straight(gathered: &Gathered, rapid: bool, end: AxisVector, named: AxisSet) -> Step {
        let feed_named = gathered.has(b'F');
        Step { rapid, end, named, feed_named, manner: Manner::Path, span: gathered.span }
    }
}

/// The motion of a block with axis words or a center, by a kind in tenths.
pub(super) fn motion(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    if let Some(span) = gathered.machine_frame {
        return machine_motion(channel, gathered, code, span);
    }
    channel.direction = direction::tool_direction(channel, gathered, code)?;
    let done = way(channel, gathered, code);
    channel.direction = None;
    done
}

fn way(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    match code {
        0 | 10 => {
            let (end, named) = end(channel, gathered)?;
            special::corner_words(channel, gathered)?;
            step(channel, Step::straight(gathered, code == 0, end, named))
        }
        20 | 30 => {
            let (end, named) = end(channel, gathered)?;
            special::corner_words(channel, gathered)?;
            arc::arc(channel, gathered, code, end, named)
        }
        _ => special::special_motion(channel, gathered, code),
    }
}

/// The programmed end of a block, and the axes that it names.
pub(super) fn end(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(AxisVector, AxisSet), Fault> {
    let here = offsets::here(channel);
    let (mut end, mut named) = (here, gathered.axes);
    for axis in gathered.axes.iter() {
        let value = axis_value(channel, gathered, axis)?;
        if channel.modal.incremental {
            offsets::check_stated(channel, axis, gathered.span_of(axis.letter()))?;
            end[axis] += value;
        } else {
            end[axis] = absolute(channel, gathered, axis, value, here[axis])?;
        }
    }
    if let Some((others, values)) = one_axis::other_axes(channel, gathered, named)? {
        others.iter().for_each(|axis| end[axis] = values[axis]);
        named = named.union(others);
    }
    special::polar_end(channel, gathered, &here, &mut end, &mut named)?;
    Ok((end, named))
}

/// A straight motion to a programmed position.
pub(super) fn step(channel: &mut Channel<'_>, step: Step) -> Result<(), Fault> {
    let setup = Shared::clone(&channel.setup);
    let target = reach(channel, &setup, step.named, &step.end, step.span)?;
    send(channel, step, target, Shape::Line, setup)
}

/// `G53`: positions of the machine, for this block.
fn machine_motion(channel: &mut Channel<'_>, gathered: &Gathered, code: u16, span: Span) -> Result<(), Fault> {
    if !matches!(code, 0 | 10) {
        let message = "G53 stands with G0 or G1";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "program G0 or G1 in the block of G53"));
    }
    if channel.modal.incremental {
        // A Fanuc ignores it; a motion that somebody has programmed does not vanish.
        return Err(fault(Code::BAD_WORD_VALUE, span, "G53 under G91", "program G90 in the block"));
    }
    compensation::no_compensation(channel, span, "G53")?;
    let here = channel.modal.command;
    let mut end = here;
    for axis in gathered.axes.iter() {
        let value = axis_value(channel, gathered, axis)?;
        end[axis] = absolute(channel, gathered, axis, value, here[axis])?;
    }
    machine_step(channel, Step::straight(gathered, code == 0, end, gathered.axes))
}

/// A straight motion to a position of the machine.
pub(super) fn machine_step(channel: &mut Channel<'_>, step: Step) -> Result<(), Fault> {
    // Positions of the axes: what the tool takes off is added before, so that the place of the tip stays known.
    let tool_mm = channel.setup.tool_mm;
    let mut shift = AxisVector::ZERO;
    shift.set_xyz(tool_mm);
    let frame = Frame::translation(shift);
    let bare = Shared::new(Setup { frame, tool_mm, plane: channel.modal.plane, transform: None, assumed: false });
    one_axis::settle_axes(channel, step.named);
    channel.push(Kind::Keep("G53"));
    channel.push(Kind::Setup(Shared::clone(&bare)));
    channel.setup_changed = true;
    let full = channel.setup.frame;
    channel.modal.known = known_behind(channel.modal.known, &full, &bare.frame);
    let target = reach(channel, &bare, step.named, &step.end, step.span);
    let sent = target.and_then(|target| send(channel, step, target, Shape::Line, Shared::clone(&bare)));
    channel.modal.known = known_behind(channel.modal.known, &bare.frame, &full);
    sent
}

/// Axis commands of programmed positions of the named axes.
pub(super) fn reach(
    channel: &Channel<'_>,
    setup: &Setup,
    named: AxisSet,
    end: &AxisVector,
    span: Span,
) -> Result<AxisVector, Fault> {
    let mut target = channel.modal.command;
    if setup.frame.is_translation() {
        // Axis by axis, so that the command of an axis that the block does not name keeps its last bit.
        for axis in named.iter() {
            let tool = if axis.slot() < 3 { setup.tool_mm[axis.slot()] } else { 0.0 };
            target[axis] = end[axis] + setup.frame.shift(axis) - tool;
        }
    } else {
        target = setup.command(end);
    }
    match named.iter().find(|&axis| !target[axis].is_finite() || target[axis].abs() > FARTHEST) {
        Some(axis) => Err(bad_value(span, format!("{axis} would move to {}", target[axis]), "check the value")),
        None => Ok(target),
    }
}

/// Puts a motion into the stream.
pub(super) fn send(
    channel: &mut Channel<'_>,
    step: Step,
    target: AxisVector,
    shape: Shape,
    setup: Shared<Setup>,
) -> Result<(), Fault> {
    let in_machine_frame = !Shared::ptr_eq(&setup, &channel.setup);
    if !in_machine_frame {
        offsets::check_offset(channel, step.span);
        if std::mem::take(&mut channel.setup_changed) {
            channel.push(Kind::Setup(Shared::clone(&channel.shown)));
        }
    }
    check_feed(channel, &step);
    if channel.modal.transforms.tilt().is_some() && !in_machine_frame {
        tilt::check_tilt(channel, step.named, step.span)?;
    }
    let basis = PlaneBasis::behind(&setup.frame, channel.modal.plane)
        .ok_or_else(|| bad_value(step.span, "the frame squeezes the working plane flat", "check its factors"))?;
    let (start, start_known) = (channel.modal.command, channel.modal.known);
    channel.modal.known = start_known.union(step.named);
    channel.modal.command = target;
    let (mut named, mut known, mut begun) = (step.named, channel.modal.known, start_known);
    if !in_machine_frame && !Shared::ptr_eq(&channel.setup, &channel.shown) && !setup.frame.is_translation() {
        let inner = &channel.shown.frame;
        named = inner.inverse().mixed_with(setup.frame.mixed_with(named));
        known = known_behind(known, &setup.frame, inner);
        begun = known_behind(begun, &setup.frame, inner);
        // A turned axis moves two of the output: where the other one stands decides where both end.
        if let Some(axis) = named.difference(known).iter().next().filter(|_| channel.strict) {
            return Err(unknown_mixed(step.span, axis));
        }
    }
    // What the spindle drives has no feed of its own.
    let is_driven = matches!(step.manner, Manner::Thread(thread) if thread.code.is_spindle_driven());
    let motion = Move {
        rapid: step.rapid,
        arc: None,
        target,
        named,
        known,
        feed: if is_driven { 0.0 } else { channel.modal.feed },
        feed_named: step.feed_named && !is_driven,
        unit: if is_driven { FeedUnit::PerMinute } else { channel.modal.feed_mode },
        ways: Default::default(),
        in_machine_frame,
        manner: step.manner,
        off_curve_mm: 0.0,
    };
    let mut path = Path { motion, start, start_known: begun, basis, shape, setup, span: step.span };
    if let Some((direction, span)) = channel.direction {
        direction::orient(channel, &mut path, direction, span)?;
    }
    channel.has_moved = true;
    compensation::pass(channel, path);
    Ok(())
}

fn check_feed(channel: &mut Channel<'_>, step: &Step) {
    if step.rapid || channel.modal.feed > 0.0 && (step.feed_named || channel.modal.feed_mode != FeedUnit::InverseTime) {
        return;
    }
    if matches!(step.manner, Manner::Thread(thread) if thread.code.is_spindle_driven()) {
        return;
    }
    let (message, help) = match channel.modal.feed_mode {
        FeedUnit::InverseTime => ("a feed motion in G93 without F", "program F in each block with G93"),
        _ => ("a feed motion, and no F was programmed yet", "program F before it or in it"),
    };
    if channel.strict {
        channel.outlet.warnings.push(fault(Code::MISSING_FEED, step.span, message, help));
    } else if !std::mem::replace(&mut channel.feed_warned, true) {
        channel.outlet.warnings.push(fault(Code::FEED_ASSUMED, step.span, message, help));
    }
}

/// The value of an axis word, mm or rad.
pub(super) fn axis_value(channel: &mut Channel<'_>, gathered: &Gathered, axis: Axis) -> Result<f64, Fault> {
    let value = if axis.is_rotary() {
        measure::angle(channel, gathered, axis.letter())?
    } else {
        measure::length(channel, gathered, axis.letter())?
    };
    Ok(value.unwrap_or_default())
}

/// The position that an absolute word means, with its turns.
pub(super) fn absolute(
    channel: &Channel<'_>,
    gathered: &Gathered,
    axis: Axis,
    value: f64,
    here: f64,
) -> Result<f64, Fault> {
    let here = Some(here).filter(|_| channel.modal.known.contains(axis));
    rollover::position(channel.machine, axis, value, here, gathered.span_of(axis.letter()))
}

/// Refuses axes that the machine lacks.
pub(super) fn check_axes(channel: &Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    if gathered.code(Group::Action) == Some(40) && !channel.is_rs274() {
        // The time of a dwell is no position.
        return Ok(());
    }
    match gathered.axes.difference(channel.axes).iter().next() {
        None => Ok(()),
        Some(axis) => {
            let message = format!("the machine has no axis {axis}");
            let help = "choose the right --machine, or add the axis to its file";
            Err(fault(Code::NO_AXIS, gathered.span_of(axis.letter()), message, help))
        }
    }
}

/// The kind of motion of a block that names a code of motion or has words for the one in force.
pub(super) fn motion_of(channel: &Channel<'_>, gathered: &Gathered) -> Option<u16> {
    if let Some(code) = cycle::code_of_motion(channel, gathered) {
        return Some(code);
    }
    let is_arc = matches!(channel.modal.motion, 20 | 30) || direction::has_directions(channel);
    let moves = !gathered.axes.is_empty() || gathered.has_any(b"@^") || is_arc && gathered.has_any(b"IJKR");
    moves.then_some(channel.modal.motion)
}

/// Which axes of a new frame are stated, where those in `known` of an old one are.
pub(super) fn known_behind(known: AxisSet, old: &Frame, new: &Frame) -> AxisSet {
    new.known_across(old.known_across(known, false), true)
}

fn unknown_mixed(span: Span, axis: Axis) -> Fault {
    let message = format!("where {axis} goes depends on an axis that the program has not stated yet");
    fault(Code::UNKNOWN_START, span, message, "begin with a block that names all axes of the rotation, or give --start")
}

pub(super) fn unknown_start(span: Span, axis: Axis) -> Fault {
    fault(
        Code::UNKNOWN_START,
        span,
        format!("the program has not stated where {axis} is"),
        "begin with an absolute position of this axis, or give --start",
    )
}
