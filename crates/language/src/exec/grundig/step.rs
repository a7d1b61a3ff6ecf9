//! Straight motions, and their path to the motion sink.

use super::channel::Channel;
use super::modal::Modal;
use super::modal::MotionKind;
use super::setup;
use super::target;
use super::target::Target;
use super::tilted;
use super::tool::place;
use crate::exec::core::contour::ContourRequest;
use crate::exec::core::contour::Shown;
use crate::exec::core::fault::Fault;
use crate::exec::core::fault::bad_value;
use crate::exec::core::fault::fault;
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::options::RapidOrder;
use crate::exec::core::path::Path;
use crate::exec::core::path::Shape;
use crate::exec::core::settings::RunSettings;
use crate::exec::core::standing::InForce;
use crate::exec::core::tool::{ToolSize, ToolTable};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;
use ncfix_base::geometry::AxisSet;
use ncfix_base::geometry::AxisVector;
use ncfix_base::geometry::PlaneBasis;
use ncfix_base::source::Span;
use ncfix_machine::snc::Kind;
use ncfix_machine::snc::MotionMode;
use ncfix_machine::snc::Move;
use ncfix_machine::snc::RotaryDirection;
use std::sync::Arc as Shared;
/// Distance below which there is no motion, mm or rad.
pub(super) const STILL: f64 = 1e-9;

/// Positioning logic: travel below this, mm or rad, is moved with the other axes. A correction adds some micrometers to every axis of an already
/// ordered move.
pub(super) const ALONG: f64 = 0.2;

/// A rapid step that is shorter belongs to the motion beside it, mm: corrected levels of two holes differ by it.
const SAME_LEVEL_MM: f64 = 0.02;

/// A straight motion in the active motion mode.
pub(super) fn straight(channel: &mut Channel<'_>, target: Target) -> Result<(), Fault> {
    match channel.modal.modes.motion {
        MotionKind::Rapid => rapid(channel, target),
        _ => feed_line(channel, &target.to, target.named, channel.modal.modes.feed),
    }
}

/// A rapid motion; with positioning logic the tool axis moves first when it retracts, and last otherwise.
pub(super) fn rapid(channel: &mut Channel<'_>, target: Target) -> Result<(), Fault> {
    let Target { to, named } = target;
    let [.., applicate] = channel.modal.modes.plane.axes();
    let others = named.difference([applicate].into_iter().collect());
    let here = target::here(&channel.modal, &channel.standing);
    let is_moving = |axis: Axis| (to[axis] - here[axis]).abs() > ALONG;
    let is_split = may_split(channel.settings.strict, channel.settings.rapid_order, &channel.modal, named)
        && named.contains(applicate)
        && is_moving(applicate)
        && others.iter().any(is_moving);
    if !is_split {
        return rapid_line(channel, &to, named);
    }
    let tool: AxisSet = [applicate].into_iter().collect();
    let away = (to[applicate] > here[applicate]) != channel.modal.tool_reversed;
    let mut between = if away { here } else { to };
    between[applicate] = if away { to[applicate] } else { here[applicate] };
    let (first, second) = if away { (tool, others) } else { (others, tool) };
    rapid_line(channel, &between, first)?;
    rapid_line(channel, &to, second)
}

/// One straight rapid line.
pub(super) fn rapid_line(channel: &mut Channel<'_>, to: &AxisVector, named: AxisSet) -> Result<(), Fault> {
    elementary(channel, to, named, true, channel.modal.modes.feed, |_| Ok(Shape::Line))
}

/// One straight feed line.
pub(super) fn feed_line(channel: &mut Channel<'_>, to: &AxisVector, named: AxisSet, feed: f64) -> Result<(), Fault> {
    check_feed(channel, feed, channel.outlet.origin.span)?;
    elementary(channel, to, named, false, feed, |_| Ok(Shape::Line))
}

/// One elementary motion. `shape` receives its ends in base coordinates, and the working plane after the frame.
pub(super) fn elementary(
    channel: &mut Channel<'_>,
    to: &AxisVector,
    named: AxisSet,
    rapid: bool,
    feed: f64,
    shape: impl FnOnce([&AxisVector; 2]) -> Result<Shape, Fault>,
) -> Result<(), Fault> {
    let span = channel.outlet.origin.span;
    if !channel.modal.unturned.is_empty() {
        tilted::position_again(&mut channel.modal.unturned, named, rapid, span)?;
    }
    let start = channel.modal.position.command;
    let target = reach(&channel.modal, &channel.standing, to, named);
    if let Some(axis) = AXES_OF_MOTION.into_iter().find(|&axis| target[axis].is_nan() || target[axis].abs() > 1e9) {
        return Err(bad_value(span, format!("{axis} would move to {}", target[axis]), "check the values"));
    }
    if let Some(tilted) = channel.modal.tilted.as_deref().filter(|_| channel.settings.strict) {
        tilted.check(channel.settings.machine, &target, named, span)?;
    }
    let basis = PlaneBasis::behind(&channel.standing.setup.frame, channel.modal.modes.plane)
        .ok_or_else(|| bad_value(span, "the frame collapses the working plane", "check G73"))?;
    let start_known = setup::shown_axes(&channel.standing, channel.modal.position.known, false);
    // The next motion begins at the end of the block, even if its path is faulty.
    let found = shape([&start, &target]);
    channel.modal.position.command = target;
    channel.modal.position.known = channel.modal.position.known.union(named);
    let shape = found?;
    let (moving, stated) = (
        setup::shown_axes(&channel.standing, named, true),
        setup::shown_axes(&channel.standing, channel.modal.position.known, false),
    );
    // A rotated axis moves two output axes: the position of the other one affects the end of both.
    if let Some(axis) = moving.difference(stated).iter().next().filter(|_| channel.settings.strict) {
        let message = format!("the target of {axis} depends on an axis whose position is not known yet");
        let help = "name all axes of the rotation in a block before it; --start does so until the first tool change";
        return Err(fault(Code::UNKNOWN_START, span, message, help));
    }
    let is_level = rapid && AXES_OF_MOTION.into_iter().all(|axis| (target[axis] - start[axis]).abs() < SAME_LEVEL_MM);
    let is_leveled = std::mem::replace(&mut channel.block.is_leveled, is_level && !channel.block.has_moved);
    if std::mem::replace(&mut channel.block.has_moved, true) && !is_level && !is_leveled {
        channel.outlet.begin_line();
    }
    setup::show_setup(&mut channel.standing, &mut channel.outlet);
    let motion = Move {
        rapid,
        arc: None,
        target,
        named: moving,
        known: stated,
        feed,
        feed_named: std::mem::take(&mut channel.block.feed_named),
        unit: channel.modal.modes.feed_unit,
        ways: [RotaryDirection::Plain; 3],
        in_machine_frame: false,
        motion_mode: MotionMode::Path,
        off_curve_mm: 0.0,
        tip: None,
        arc_basis: None,
    };
    let path = Path { motion, start, start_known, basis, shape, setup: Shared::clone(&channel.standing.setup), span };
    put(channel, path);
    Ok(())
}

/// Emits a motion, through the contour stage if required.
pub(super) fn put(channel: &mut Channel<'_>, path: Path) {
    let (mut contour, corner, soft) =
        (channel.modal.contour, channel.block.corner.take(), channel.block.soft.take().map(|(soft, _)| soft));
    let is_free = corner.is_none() && soft.is_none() && !channel.block.is_open;
    if is_free && contour.is_plain() && !channel.outlet.is_holding() {
        channel.outlet.pass_plain(&path);
        return;
    }
    if channel.outlet.keeps_wear && contour.compensates() {
        contour.shown = Shown::of(&path.basis, &channel.standing.shown.frame, channel.modal.modes.plane);
    }
    let wish = ContourRequest::of(
        contour,
        radius_mm(&channel.settings, &channel.modal, &channel.tools),
        path.span,
        channel.outlet.origin.file,
    );
    let wish = ContourRequest { corner, soft, ..wish };
    if channel.settings.strict {
        channel.outlet.check_stated(&path, &wish, channel.modal.modes.plane);
    }
    let tool = channel.modal.tool.active;
    channel.outlet.name_register(&wish, || tool.map_or_else(|| "the tool".to_owned(), |tool| format!("T{tool}")));
    let element = channel.outlet.element(Kind::Empty);
    if channel.block.is_open {
        channel.outlet.open(path, element, wish);
    } else {
        channel.outlet.pass_path(path, element, wish);
    }
}

/// Axis commands of programmed positions; if the frame is a pure shift, axes that are not named keep their last bit.
pub(super) fn reach(modal: &Modal, standing: &InForce, to: &AxisVector, named: AxisSet) -> AxisVector {
    let frame = &standing.setup.frame;
    if !frame.is_translation() {
        return standing.setup.command(to);
    }
    let mut target = modal.position.command;
    for axis in named.iter() {
        let tool = if axis.slot() < 3 { standing.setup.tool_mm[axis.slot()] } else { 0.0 };
        target[axis] = to[axis] + frame.shift(axis) - tool;
    }
    target
}

/// An error at the block.
pub(super) fn block_fault(outlet: &MotionSink<'_>, code: Code, message: impl Into<String>, help: &str) -> Fault {
    let span: Span = outlet.origin.span;
    fault(code, span, message, help)
}

/// Axes whose positions are checked.
pub(super) const AXES_OF_MOTION: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C];

/// `true` if the position of these axes is stated, or may be assumed.
pub(super) fn has_place(strict: bool, rapid_order: RapidOrder, modal: &Modal, axes: AxisSet) -> bool {
    let may_assume = !strict && rapid_order != RapidOrder::Stated;
    may_assume || axes.difference(modal.position.known).is_empty()
}

/// `true` if a rapid move of these axes may be split. If its start is unknown, the control itself orders the motions of the block.
pub(super) fn may_split(strict: bool, rapid_order: RapidOrder, modal: &Modal, axes: AxisSet) -> bool {
    // Under G141 the tool is not along an axis of the coordinates.
    modal.positioning_logic
        && modal.turning.is_none()
        && rapid_order != RapidOrder::None
        && has_place(strict, rapid_order, modal, axes)
}

/// Checks that a feed motion has a feed.
pub(super) fn check_feed(channel: &mut Channel<'_>, feed: f64, span: Span) -> Result<(), Fault> {
    if feed > 0.0 {
        return Ok(());
    }
    let (message, help) = channel.modal.modes.no_feed();
    if channel.settings.strict {
        return Err(fault(Code::MISSING_FEED, span, message, help));
    }
    if !std::mem::replace(&mut channel.feed_warned, true) {
        channel.outlet.warnings.push(fault(Code::FEED_ASSUMED, span, message, help));
    }
    Ok(())
}

/// The radius for G41 and G42, mm.
pub(super) fn radius_mm(settings: &RunSettings<'_>, modal: &Modal, tools: &ToolTable<ToolSize>) -> f64 {
    let wear_mm = || {
        let (number, edge) = place(modal.tool.active?);
        Some(tools.size(settings.machine, number, edge)?.radius_wear_mm)
    };
    settings.radius.of(modal.whole_radius_mm(), wear_mm().unwrap_or(0.0))
}
