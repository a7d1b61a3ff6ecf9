//! One motion: from its target to the motion sink.

use super::channel::Channel;
use super::channel::Warned;
use super::compensation;
use super::direction;
use super::forbidden;
use super::gathered::Gathered;
use super::modal::Modal;
use super::offsets;
use super::one_axis;
use super::special;
use super::target;
use crate::exec::core::fault::Fault;
use crate::exec::core::fault::bad_value;
use crate::exec::core::fault::fault;
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::path::Path;
use crate::exec::core::path::Shape;
use crate::exec::core::settings::RunSettings;
use crate::exec::core::standing::known_behind;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;
use ncfix_base::geometry::AxisSet;
use ncfix_base::geometry::AxisVector;
use ncfix_base::geometry::Frame;
use ncfix_base::geometry::PlaneBasis;
use ncfix_base::source::Span;
use ncfix_machine::snc::FeedUnit;
use ncfix_machine::snc::Kind;
use ncfix_machine::snc::MotionMode;
use ncfix_machine::snc::Move;
use ncfix_machine::snc::Setup;
use std::sync::Arc as Shared;
/// Largest accepted position, mm or rad.
pub(super) const FARTHEST: f64 = 1e9;

/// One motion to a position.
#[derive(Debug)]
pub(super) struct Step {
    pub(super) rapid: bool,
    /// Its programmed end.
    pub(super) end: AxisVector,
    /// Named axes.
    pub(super) named: AxisSet,
    /// `true` if its block has F.
    pub(super) feed_named: bool,
    pub(super) motion_mode: MotionMode,
    pub(super) span: Span,
}

impl Step {
    /// A straight motion of a block.
    pub(super) fn straight(gathered: &Gathered, rapid: bool, end: AxisVector, named: AxisSet) -> Step {
        let feed_named = gathered.has(b'F');
        Step { rapid, end, named, feed_named, motion_mode: MotionMode::Path, span: gathered.span }
    }
}

/// The programmed end of a block, and the named axes.
pub(super) fn end(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(AxisVector, AxisSet), Fault> {
    let here = target::here(&channel.modal, &channel.standing);
    let (mut end, mut named) = (here, gathered.axes);
    for axis in gathered.axes.iter() {
        let value = target::axis_value(channel, gathered, axis)?;
        if channel.modal.modes.incremental {
            let is_known = channel.modal.position.known.contains(axis);
            if value == 0.0 && !is_known && !channel.is_rs274() && channel.modal.turning.is_none() {
                // No motion, wherever the axis is.
                named.remove(axis);
                continue;
            }
            target::check_stated(channel.settings.strict, &channel.modal, axis, gathered.span_of(axis.letter()))?;
            end[axis] += value;
        } else {
            end[axis] = target::absolute(channel.settings.machine, &channel.modal, gathered, axis, value, here[axis])?;
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
    if channel.modal.length_ended && step.named.contains(Axis::Z) {
        let message = "Z moves after a G28, which ends the tool length compensation of a Haas: the height without it is not certain";
        let help = "program G43 H again, or G49, after the G28; or move Z with G53";
        return Err(fault(Code::NOT_SUPPORTED, step.span, message, help));
    }
    let setup = Shared::clone(&channel.standing.setup);
    let target = reach(&channel.modal, &setup, step.named, &step.end, step.span)?;
    send(channel, step, target, Shape::Line, setup)
}

/// A straight motion to a machine position.
pub(super) fn machine_step(channel: &mut Channel<'_>, step: Step) -> Result<(), Fault> {
    // Axis positions: the tool vector is added first, so that the tip position stays known.
    let tool_mm = channel.standing.setup.tool_mm;
    let mut shift = AxisVector::ZERO;
    shift.set_xyz(tool_mm);
    let frame = Frame::translation(shift);
    let bare = Shared::new(Setup { frame, tool_mm, plane: channel.modal.modes.plane, ..Setup::default() });
    one_axis::settle_axes(&mut channel.special, step.named);
    channel.push(Kind::Keep("G53"));
    channel.push(Kind::Setup(Shared::clone(&bare)));
    channel.standing.changed = true;
    let full = channel.standing.setup.frame;
    channel.modal.position.known = known_behind(channel.modal.position.known, &full, &bare.frame);
    let target = reach(&channel.modal, &bare, step.named, &step.end, step.span);
    let sent = target.and_then(|target| send(channel, step, target, Shape::Line, Shared::clone(&bare)));
    channel.modal.position.known = known_behind(channel.modal.position.known, &bare.frame, &full);
    sent
}

/// Axis commands of programmed positions of the named axes.
pub(super) fn reach(
    modal: &Modal,
    setup: &Setup,
    named: AxisSet,
    end: &AxisVector,
    span: Span,
) -> Result<AxisVector, Fault> {
    let mut target = modal.position.command;
    if setup.frame.is_translation() {
        // Axis by axis, so that the command of an unnamed axis keeps its last bit.
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

/// Emits a motion.
pub(super) fn send(
    channel: &mut Channel<'_>,
    step: Step,
    target: AxisVector,
    shape: Shape,
    setup: Shared<Setup>,
) -> Result<(), Fault> {
    let rotary = step.named.difference(AxisSet::XYZ).iter().find(|axis| axis.is_rotary());
    if let Some(axis) = rotary.filter(|_| channel.modal.turned_zero.is_some()) {
        let message = format!("{axis} turns while G254 is in force");
        return Err(fault(Code::FORBIDDEN_STATE, step.span, message, "program G255 before it, and G254 after it"));
    }
    let in_machine_frame = !Shared::ptr_eq(&setup, &channel.standing.setup);
    if !in_machine_frame {
        offsets::check_offset(&channel.settings, &channel.modal, &mut channel.warned, &mut channel.outlet, step.span);
        if std::mem::take(&mut channel.standing.changed) {
            channel.push(Kind::Setup(Shared::clone(&channel.standing.shown)));
        }
    }
    check_feed(&channel.settings, &channel.modal, &mut channel.warned, &mut channel.outlet, &step);
    if channel.modal.transforms.tilt().is_some() && !in_machine_frame {
        forbidden::check_tilt(&channel.settings, &channel.modal, &channel.standing, step.named, step.span)?;
    }
    let basis = PlaneBasis::behind(&setup.frame, channel.modal.modes.plane)
        .ok_or_else(|| bad_value(step.span, "the frame collapses the working plane", "check its factors"))?;
    let (start, start_known) = (channel.modal.position.command, channel.modal.position.known);
    channel.modal.position.known = start_known.union(step.named);
    channel.modal.position.command = target;
    let (mut named, mut known, mut begun) = (step.named, channel.modal.position.known, start_known);
    if !in_machine_frame
        && !Shared::ptr_eq(&channel.standing.setup, &channel.standing.shown)
        && !setup.frame.is_translation()
    {
        let inner = &channel.standing.shown.frame;
        named = inner.inverse().mixed_with(setup.frame.mixed_with(named));
        known = known_behind(known, &setup.frame, inner);
        begun = known_behind(begun, &setup.frame, inner);
        // A rotated axis moves two output axes: the position of the other one affects the end of both.
        if let Some(axis) = named.difference(known).iter().next().filter(|_| channel.settings.strict) {
            return Err(unknown_mixed(step.span, axis));
        }
    }
    // A spindle-driven motion has no feed.
    let is_driven = matches!(step.motion_mode, MotionMode::Thread(thread) if thread.code.is_spindle_driven());
    let motion = Move {
        rapid: step.rapid,
        arc: None,
        target,
        named,
        known,
        feed: if is_driven { 0.0 } else { channel.modal.modes.feed },
        feed_named: step.feed_named && !is_driven,
        unit: if is_driven { FeedUnit::PerMinute } else { channel.modal.modes.feed_unit },
        ways: Default::default(),
        in_machine_frame,
        motion_mode: step.motion_mode,
        off_curve_mm: 0.0,
        tip: None,
        arc_basis: None,
    };
    let mut path = Path { motion, start, start_known: begun, basis, shape, setup, span: step.span };
    if let Some((direction, span)) = channel.block.direction {
        direction::orient(&channel.settings, &mut channel.modal, &mut channel.outlet, &mut path, direction, span)?;
    }
    channel.block.has_moved = true;
    compensation::pass(channel, path);
    Ok(())
}

/// Remedy for a program without any F.
const FIRST_FEED: &str = "program F before it or in it; if the control starts with a feed, state it in control.startup_code, for example \"F300\"";

pub(super) fn check_feed(
    settings: &RunSettings<'_>,
    modal: &Modal,
    warned: &mut Warned,
    outlet: &mut MotionSink<'_>,
    step: &Step,
) {
    if step.rapid || modal.modes.feed > 0.0 && (step.feed_named || modal.modes.feed_unit != FeedUnit::InverseTime) {
        return;
    }
    if matches!(step.motion_mode, MotionMode::Thread(thread) if thread.code.is_spindle_driven()) {
        return;
    }
    let (message, help) = match modal.modes.feed_unit {
        FeedUnit::InverseTime => ("a feed move in G93 without F", "program F in each block with G93"),
        _ if modal.modes.never_had_feed() => (modal.modes.no_feed().0, FIRST_FEED),
        _ => modal.modes.no_feed(),
    };
    if settings.strict {
        outlet.warnings.push(fault(Code::MISSING_FEED, step.span, message, help));
    } else if !std::mem::replace(&mut warned.feed, true) {
        outlet.warnings.push(fault(Code::FEED_ASSUMED, step.span, message, help));
    }
}

pub(super) fn unknown_mixed(span: Span, axis: Axis) -> Fault {
    let message = format!("the target of {axis} depends on an axis whose position is not known yet");
    fault(
        Code::UNKNOWN_START,
        span,
        message,
        "name all axes of the rotation in a block before it; --start does so until the first tool change",
    )
}
