//! Converts the gathered words of a block into a motion: targets and shapes.

use super::context::MotionContext;
use std::sync::Arc as Shared;

use super::gathered::Gathered;
use super::modal::{Modal, MotionKind};
use super::{arc, polar, polynomial, positioning, rotary, spatial, thread};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::grid::{Meeting, on_grid};
use crate::exec::core::path::{Path, Shape};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, PlaneBasis};
use ncfix_base::source::Span;
use ncfix_machine::snc::{MotionMode, Move, RotaryDirection};

/// The motion of a block that names axes or a center, and the state after it.
pub(super) fn motion(gathered: &Gathered, modal: &mut Modal, context: MotionContext<'_>) -> Result<Path, Fault> {
    let (start, start_known) = (modal.position.command, modal.position.known);
    let mut ways = gathered.ways;
    let (mut target, mut named) = target(gathered, modal, context, &mut ways)?;
    if modal.unknown_edge.is_some() {
        let [.., applicate] = modal.tool_length_plane.unwrap_or(modal.modes.plane).axes();
        let is_mixed = !context.setup.frame.is_translation() || context.setup.transform.is_some();
        let needs_length = named.contains(applicate) || is_mixed && !named.intersection(AxisSet::XYZ).is_empty();
        if needs_length || modal.contour.compensates() {
            modal.check_length(context.span)?;
        }
    }
    let is_positioning = positioning::is_positioning(gathered, context.span)?;
    // A positioning axis is not a path motion, in any motion mode.
    let thread = if is_positioning { None } else { thread::thread(gathered, modal, context.span)? };
    let kind = match modal.modes.motion {
        _ if is_positioning => MotionKind::Rapid,
        _ if thread.is_some() => MotionKind::Line,
        kind => kind,
    };
    let rapid = kind == MotionKind::Rapid;
    rotary::check_either(&ways, rapid, context)?;
    let is_driven = thread.is_some_and(|thread| thread.code.is_spindle_driven());
    if !rapid && !is_driven && modal.modes.feed <= 0.0 && context.strict {
        let (message, help) = modal.modes.no_feed();
        return Err(fault(Code::MISSING_FEED, context.span, message, help));
    }
    if thread.is_none() {
        arc::check_words(gathered, kind)?;
    }
    let mut basis = PlaneBasis::behind(&context.setup.frame, modal.modes.plane)
        .ok_or_else(|| bad_value(context.span, "the frame collapses the working plane", "check SCALE"))?;
    let shape = match kind {
        MotionKind::Rapid | MotionKind::Line | MotionKind::Thread(_) => Shape::Line,
        MotionKind::Akima | MotionKind::BSpline | MotionKind::Cubic => Shape::Line,
        MotionKind::Polynomial => polynomial::shape(gathered, modal, context, &start, &target)?,
        MotionKind::Clockwise | MotionKind::CounterClockwise => {
            let by_angle = arc::end_by_angle(gathered, modal, context)?;
            if let Some(end) = by_angle {
                let plane = modal.modes.plane.axes().into_iter().take(2).collect();
                named = named.union(plane);
                target = reach(modal, context, named, &end);
            }
            let closed = arc::closed_on_grid(modal.modes.plane, context, &start, &target, by_angle.is_some());
            target = closed.inspect_err(|_| modal.position.command = target)?;
            // The next motion begins at the end of the block, so that one error is not repeated in every following arc.
            arc::arc(gathered, modal, context, &start, &target).inspect_err(|_| {
                modal.position.command = target;
                modal.position.known = modal.position.known.union(named);
            })?
        }
        MotionKind::Through | MotionKind::Tangent => {
            let circle = spatial::circle(gathered, modal, context, &start, &target)?;
            match circle {
                None => Shape::Line,
                Some(circle) => {
                    let shape;
                    (shape, basis) = circle.shape(basis, modal.modes.plane, [&start, &target], context);
                    shape
                }
            }
        }
    };
    spatial::note_tangent(&mut modal.tangent, &start, &target, &shape, &basis);
    if matches!(modal.modes.motion, MotionKind::Akima | MotionKind::BSpline | MotionKind::Cubic) {
        // The path of the spline is not known yet.
        modal.tangent = None;
    }
    modal.position.known = modal.position.known.union(named);
    modal.position.command = target;
    let motion = Move {
        rapid,
        arc: None,
        target,
        named,
        known: modal.position.known,
        feed: modal.modes.feed,
        feed_named: gathered.feed.is_some(),
        unit: modal.modes.feed_unit,
        ways,
        in_machine_frame: gathered.suppress.is_some(),
        motion_mode: match thread {
            _ if is_positioning => MotionMode::Positioning,
            Some(thread) => MotionMode::Thread(thread),
            None => MotionMode::Path,
        },
        off_curve_mm: 0.0,
        tip: None,
        arc_basis: None,
    };
    Ok(Path { motion, start, start_known, basis, shape, setup: Shared::clone(context.setup), span: context.span })
}

/// Axis commands at the end of the block and the named axes; sets the programmed values.
fn target(
    gathered: &Gathered,
    modal: &mut Modal,
    context: MotionContext<'_>,
    ways: &mut [RotaryDirection; 3],
) -> Result<(AxisVector, AxisSet), Fault> {
    let suppressed = context.is_suppressed;
    let here = context.setup.programmed(&modal.position.command);
    let mut programmed = here;
    for axis in gathered.named.iter() {
        let incremental = if gathered.as_incremental.contains(axis) {
            true
        } else {
            modal.modes.incremental && !gathered.as_absolute.contains(axis)
        };
        let unit = if axis.is_rotary() { 1_f64.to_radians() } else { modal.modes.scale() };
        let value = gathered.axes[axis] * unit;
        // The control rounds values on input, and adds rounded increments.
        let per_mm = context.control.increments_per_mm.filter(|_| !axis.is_rotary());
        let value = per_mm.map_or(value, |per_mm| on_grid(value, per_mm));
        let span = gathered.axis_spans[axis.slot()];
        if incremental && context.strict && !modal.position.known.contains(axis) {
            return Err(modal.unknown_start(span, axis));
        }
        let is_stale = modal.stale.contains(axis) && !suppressed;
        let traverses = context.control.incremental_traverses_frame_change;
        if incremental && context.strict && is_stale && traverses {
            return Err(stale_start(span, axis));
        }
        programmed[axis] = if !incremental {
            rotary::position(axis, value, here[axis], (gathered, modal.position.known.contains(axis)), context, ways)?
        } else if suppressed || is_stale || !traverses {
            here[axis] + value
        } else {
            modal.programmed[axis] + value
        };
        let is_still = || arc::on_control([programmed[axis], 0.0], [here[axis], 0.0], context.control) == Meeting::Same;
        if modal.contour.compensates() && !axis.is_rotary() && is_still() {
            // Not a motion for the control: a tiny element would distort the compensated contour.
            programmed[axis] = here[axis];
        }
        if !programmed[axis].is_finite() || programmed[axis].abs() > 1e9 {
            return Err(bad_value(span, format!("{axis} would move to {}", programmed[axis]), "check the value"));
        }
    }
    let mut named = gathered.named;
    if let Some(end) = polar::end(gathered, modal, context)? {
        for (axis, value) in modal.modes.plane.axes().into_iter().zip(end) {
            programmed[axis] = value;
            named.insert(axis);
        }
    }
    Ok((reach(modal, context, named, &programmed), named))
}

/// Axis commands of programmed positions of the named axes; sets the programmed values.
fn reach(modal: &mut Modal, context: MotionContext<'_>, named: AxisSet, programmed: &AxisVector) -> AxisVector {
    let mut target = modal.position.command;
    if context.setup.frame.is_translation() {
        // Axis by axis, so that the command of an unnamed axis keeps its last bit.
        for axis in named.iter() {
            let tool = if axis.slot() < 3 { context.setup.tool_mm[axis.slot()] } else { 0.0 };
            target[axis] = programmed[axis] + context.setup.frame.shift(axis) - tool;
        }
    } else {
        target = context.setup.command(programmed);
    }
    if context.is_suppressed {
        // After a block without frame, the position in the frame follows from the machine position.
        let behind = modal.setup().programmed(&target);
        let is_shifted = modal.stale.is_empty() && modal.frame().is_translation();
        let moved = if is_shifted { named } else { named.union(AxisSet::XYZ) };
        for axis in moved.iter() {
            modal.programmed[axis] = behind[axis];
        }
        // Unnamed axes stay undetermined.
        modal.stale = modal.stale.difference(named);
    } else {
        for axis in named.iter() {
            modal.programmed[axis] = programmed[axis];
        }
        modal.stale = modal.stale.difference(named);
    }
    target
}

fn stale_start(span: Span, axis: Axis) -> Fault {
    fault(
        Code::UNKNOWN_START,
        span,
        format!("an incremental {axis} directly after a frame change that is more than a shift"),
        "begin with an absolute position of this axis, or see control.incremental_traverses_frame_change",
    )
}
