//! Turns the gathered words of a block into a motion: targets, centers, checks.

use std::sync::Arc as Shared;

use super::address::Named;
use super::fault::{Fault, fault};
use super::gather::bad_value;
use super::gathered::{Gathered, NamedValue};
use super::modal::{Modal, MotionKind};
use super::path::{Path, Shape};
use super::resolve::chord_count;
use crate::diagnostic::Code;
use crate::geometry::{Arc, Axis, AxisSet, AxisVector, CenterFault, PlaneBasis};
use crate::machine::Control;
use crate::snc::{Move, Setup};
use crate::source::Span;

/// Largest number of extra turns of a helix.
const MAX_TURNS: f64 = 999.0;

/// What a motion needs beside the modal state.
#[derive(Clone, Copy)]
pub(super) struct MotionContext<'a> {
    pub(super) control: &'a Control,
    /// The frame and tool that hold in this block (G53 suppresses the modal frame).
    pub(super) setup: &'a Shared<Setup>,
    /// Refuse motions whose start is not known.
    pub(super) strict: bool,
    /// Where the block stands.
    pub(super) span: Span,
}

/// The motion of a block that names axes or a center, and the state behind it.
pub(super) fn motion(gathered: &Gathered, modal: &mut Modal, context: MotionContext<'_>) -> Result<Path, Fault> {
    let (start, start_known) = (modal.command, modal.known);
    let target = target(gathered, modal, context)?;
    let rapid = modal.motion == MotionKind::Rapid;
    let is_arc = matches!(modal.motion, MotionKind::Clockwise | MotionKind::CounterClockwise);
    if !rapid && modal.feed <= 0.0 && context.strict {
        return Err(fault(
            Code::MISSING_FEED,
            context.span,
            "a feed motion, and no F was programmed yet",
            "program F before it or in it",
        ));
    }
    let shape = if is_arc { arc(gathered, modal, context, &start, &target)? } else { Shape::Line };
    let of_arc = gathered.named(Named::Cr).or(gathered.named(Named::Turn));
    if !is_arc && (gathered.center.iter().any(Option::is_some) || of_arc.is_some()) {
        let span = of_arc.map_or(gathered.center_span, |value| value.span);
        return Err(fault(
            Code::BAD_ARC,
            span,
            "center, radius or turns in a block that is no arc",
            "program G2 or G3, or take the word out",
        ));
    }
    modal.known = modal.known.union(gathered.named);
    modal.command = target;
    let motion = Move {
        rapid,
        arc: None,
        target,
        named: gathered.named,
        known: modal.known,
        feed: modal.feed,
        feed_named: gathered.feed.is_some(),
        inverse_time: modal.inverse_time,
        in_machine_frame: gathered.suppress.is_some(),
    };
    let basis = PlaneBasis::behind(&context.setup.frame, modal.plane)
        .ok_or_else(|| bad_value(context.span, "the frame squeezes the working plane flat", "check SCALE"))?;
    Ok(Path { motion, start, start_known, basis, shape, setup: Shared::clone(context.setup), span: context.span })
}

/// Axis commands at the end of the block; sets the programmed values.
fn target(gathered: &Gathered, modal: &mut Modal, context: MotionContext<'_>) -> Result<AxisVector, Fault> {
    let suppressed = gathered.suppress.is_some();
    let here = context.setup.programmed(&modal.command);
    let mut programmed = here;
    for axis in gathered.named.iter() {
        let incremental = if gathered.as_incremental.contains(axis) {
            true
        } else {
            modal.incremental && !gathered.as_absolute.contains(axis)
        };
        let unit = if axis.is_rotary() { 1_f64.to_radians() } else { modal.scale() };
        let value = gathered.axes[axis] * unit;
        let span = gathered.axis_spans[axis.slot()];
        if incremental && context.strict && !modal.known.contains(axis) {
            return Err(unknown_start(span, axis));
        }
        let is_stale = modal.stale.contains(axis) && !suppressed;
        let traverses = context.control.incremental_traverses_frame_change;
        if incremental && context.strict && is_stale && traverses {
            return Err(stale_start(span, axis));
        }
        programmed[axis] = if !incremental {
            value
        } else if suppressed || is_stale || !traverses {
            here[axis] + value
        } else {
            modal.programmed[axis] + value
        };
        if !programmed[axis].is_finite() || programmed[axis].abs() > 1e9 {
            return Err(bad_value(span, format!("{axis} would move to {}", programmed[axis]), "check the value"));
        }
    }
    let mut target = modal.command;
    if context.setup.frame.is_translation() {
        // Axis by axis, so that the command of an axis that the block does not name keeps its last bit.
        for axis in gathered.named.iter() {
            let tool = if axis.slot() < 3 { context.setup.tool_mm[axis.slot()] } else { 0.0 };
            target[axis] = programmed[axis] + context.setup.frame.shift(axis) - tool;
        }
    } else {
        target = context.setup.command(&programmed);
    }
    if suppressed {
        // Behind a block without frame, the position in the frame follows from the machine position.
        let behind = modal.setup().programmed(&target);
        let is_shifted = modal.stale.is_empty() && modal.frame().is_translation();
        let moved = if is_shifted { gathered.named } else { gathered.named.union(AxisSet::XYZ) };
        for axis in moved.iter() {
            modal.programmed[axis] = behind[axis];
        }
        modal.stale = modal.stale.difference(moved);
    } else {
        for axis in gathered.named.iter() {
            modal.programmed[axis] = programmed[axis];
        }
        modal.stale = modal.stale.difference(gathered.named);
    }
    Ok(target)
}

fn stale_start(span: Span, axis: Axis) -> Fault {
    fault(
        Code::UNKNOWN_START,
        span,
        format!("an incremental {axis} directly behind a change of the frame that is more than a shift"),
        "begin with an absolute position of this axis in the new frame, or set control.incremental_traverses_frame_change = false if          the control moves by the increment alone",
    )
}

fn unknown_start(span: Span, axis: Axis) -> Fault {
    fault(
        Code::UNKNOWN_START,
        span,
        format!("the program has not stated where {axis} is"),
        "begin with an absolute position of this axis, or give --start",
    )
}

fn arc(
    gathered: &Gathered,
    modal: &Modal,
    context: MotionContext<'_>,
    start: &AxisVector,
    target: &AxisVector,
) -> Result<Shape, Fault> {
    let [abscissa, ordinate, applicate] = modal.plane.axes();
    if context.strict {
        let plane: AxisSet = [abscissa, ordinate].into_iter().collect();
        if let Some(axis) = plane.difference(modal.known).iter().next() {
            return Err(unknown_start(context.span, axis));
        }
    }
    let clockwise = modal.motion == MotionKind::Clockwise;
    let turns = match gathered.named(Named::Turn) {
        None => 0,
        Some(&NamedValue { value: turns, .. }) if turns.fract() == 0.0 && (0.0..=MAX_TURNS).contains(&turns) => {
            turns as u32
        }
        Some(&NamedValue { value: turns, span, .. }) => {
            return Err(bad_value(
                span,
                format!("TURN={turns} is no number of turns"),
                "write a whole number from 0 to 999",
            ));
        }
    };
    let has_center = gathered.center.iter().any(Option::is_some);
    // Where the frame only shifts, arcs are worked out in base coordinates, to the last bit; else as programmed.
    let (frame, is_shifted) = (&context.setup.frame, context.setup.frame.is_translation());
    let (from, to) = if is_shifted {
        (*start, *target)
    } else {
        (context.setup.programmed(start), context.setup.programmed(target))
    };
    let (s, e) = ([from[abscissa], from[ordinate]], [to[abscissa], to[ordinate]]);
    let tolerance = |radius: f64| context.control.arc_tolerance_mm.max(context.control.arc_tolerance_ratio * radius);
    let radius = gathered.named(Named::Cr).map(|value| (value.value, value.span));
    let center = match (radius, has_center) {
        (Some((_, span)), true) => {
            return Err(fault(Code::BAD_ARC, span, "center and radius in one block", "keep either I J K or CR"));
        }
        (None, false) => {
            return Err(fault(Code::NO_CENTER, context.span, "an arc without center and radius", "add I, J, K or CR="));
        }
        (Some((radius, span)), false) => center_of_radius(radius * modal.scale(), span, s, e, clockwise, &tolerance)?,
        (None, true) => {
            if gathered.center[applicate.slot()].is_some_and(|(value, _)| value != 0.0) {
                let letter = char::from(b"IJK"[applicate.slot()]);
                let message = format!("{letter} lies outside the working plane G{}", modal.plane.number());
                return Err(fault(
                    Code::BAD_ARC,
                    gathered.center_span,
                    message,
                    "select the plane of the arc, or correct the center word",
                ));
            }
            let mut center = [s[0], s[1]];
            for (place, axis) in center.iter_mut().zip([abscissa, ordinate]) {
                match gathered.center[axis.slot()] {
                    None => {}
                    Some((value, false)) => *place += value * modal.scale(),
                    Some((value, true)) => {
                        let offset = frame.shift(axis) - context.setup.tool_mm[axis.slot()];
                        *place = value * modal.scale() + if is_shifted { offset } else { 0.0 };
                    }
                }
            }
            center
        }
    };
    let arc = Arc::through(modal.plane, clockwise, &from, &to, center, turns, tolerance).map_err(|found| match found {
        CenterFault::OffCircle { start_radius_mm, end_radius_mm, off_bisector_mm } => fault(
            Code::ARC_OFF_CIRCLE,
            context.span,
            format!(
                "start radius {start_radius_mm:.4} mm, end radius {end_radius_mm:.4} mm, the center {off_bisector_mm:.4} mm off the \
                 perpendicular bisector of the chord"
            ),
            "correct the center or the end point; the limit is control.arc_tolerance_mm",
        ),
        CenterFault::ZeroRadius => {
            fault(Code::BAD_ARC, context.span, "the center of the arc is its start", "correct I, J, K")
        }
        CenterFault::NotFinite => bad_value(context.span, "the arc is not finite", "check the values"),
    })?;
    Ok(shape_behind_frame(&arc, [&from, &to], target, context))
}

/// A programmed arc behind the frame: an arc where circles stay circles, else chords of the ellipse.
fn shape_behind_frame(
    arc: &Arc,
    programmed: [&AxisVector; 2],
    target: &AxisVector,
    context: MotionContext<'_>,
) -> Shape {
    let (clockwise, extra_turns) = (arc.clockwise, arc.extra_turns);
    let frame = &context.setup.frame;
    if frame.is_translation() {
        return Shape::Arc { clockwise, center: arc.center_mm, extra_turns };
    }
    let [abscissa, ordinate, _] = arc.plane.axes();
    if let Some(basis) = PlaneBasis::behind(frame, arc.plane).filter(|_| frame.keeps_circles(arc.plane)) {
        let mut center = *programmed[0];
        center[abscissa] = arc.center_mm[0];
        center[ordinate] = arc.center_mm[1];
        return Shape::Arc { clockwise, center: basis.flat(&context.setup.command(&center)), extra_turns };
    }
    // No direction grows by more than the norm of the matrix.
    let radius_mm = arc.radius_mm(programmed[0]) * frame.linear().norm();
    let sweep_rad = arc.sweep_rad(programmed[0], programmed[1]);
    let count = chord_count(radius_mm, sweep_rad, context.control.chord_tolerance_mm);
    let mut ends: Vec<AxisVector> = (1..count)
        .map(|k| arc.at(programmed[0], programmed[1], f64::from(k) / f64::from(count)))
        .map(|position| context.setup.command(&position))
        .collect();
    ends.push(*target);
    Shape::Chords(ends)
}

/// Center of an arc of a signed radius: above 0 at most half a turn, below 0 more than that.
fn center_of_radius(
    radius: f64,
    span: Span,
    s: [f64; 2],
    e: [f64; 2],
    clockwise: bool,
    tolerance: &impl Fn(f64) -> f64,
) -> Result<[f64; 2], Fault> {
    let chord = [e[0] - s[0], e[1] - s[1]];
    let length = chord[0].hypot(chord[1]);
    let help = "correct CR or the end point; a full circle needs I, J, K";
    if length == 0.0 || radius == 0.0 {
        return Err(fault(Code::RADIUS_TOO_SMALL, span, "start and end of an arc with CR coincide, or CR is 0", help));
    }
    let half = length / 2.0;
    if half - radius.abs() > tolerance(radius.abs()) {
        let message = format!("the radius is {:.4} mm, half the chord {half:.4} mm", radius.abs());
        return Err(fault(Code::RADIUS_TOO_SMALL, span, message, help));
    }
    let height = (radius * radius - half * half).max(0.0).sqrt();
    // The center of the short clockwise arc lies to the right of the chord.
    let side = if clockwise == (radius > 0.0) { 1.0 } else { -1.0 };
    let right = [chord[1] / length, -chord[0] / length];
    Ok([s[0].midpoint(e[0]) + side * height * right[0], s[1].midpoint(e[1]) + side * height * right[1]])
}
