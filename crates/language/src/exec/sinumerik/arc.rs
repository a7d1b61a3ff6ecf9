//! Arcs of the working plane: all forms of their centers, and their transformation by a frame.

use super::gathered;
use std::f64::consts::TAU;

use super::address::Named;
use super::context::MotionContext;
use super::gathered::{Gathered, NamedValue};
use super::modal::{Modal, MotionKind};
use crate::exec::core::arc::{ProgrammedArc, RadiusFault, behind_frame, center_of_radius};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::grid::{Meeting, meeting, unsure};
use crate::exec::core::path::Shape;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, CenterFault, Plane};
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::machine::Control;

/// Largest number of extra turns of a helix.
const MAX_TURNS: f64 = 999.0;

/// Rejects arc words in blocks without an arc.
pub(super) fn check_words(gathered: &Gathered, kind: MotionKind) -> Result<(), Fault> {
    let is_plane_arc = matches!(kind, MotionKind::Clockwise | MotionKind::CounterClockwise);
    if gathered.addresses.is_empty() && (is_plane_arc || !gathered.center.iter().any(Option::is_some)) {
        return Ok(());
    }
    let of_plane = [Named::Cr, Named::Turn, Named::Ar].into_iter().find_map(|word| gathered.named(word));
    let has_center = gathered.center.iter().any(Option::is_some);
    if !is_plane_arc && (has_center || of_plane.is_some()) {
        let span = of_plane.map_or(gathered.center_span, |value| value.span);
        let message = "center, radius, angle or turns in a block that is not an arc in the plane";
        return Err(fault(Code::BAD_ARC, span, message, "program G2 or G3, or remove the word"));
    }
    let through = [Named::I1, Named::J1, Named::K1].into_iter().find_map(|word| gathered.named(word));
    match through {
        Some(value) if kind != MotionKind::Through => {
            let message = "an intermediate point in a block without CIP";
            Err(fault(Code::BAD_ARC, value.span, message, "program CIP, or remove the word"))
        }
        _ => Ok(()),
    }
}

/// The programmed end of an arc given by center and opening angle; `None` for other blocks.
pub(super) fn end_by_angle(
    gathered: &Gathered,
    modal: &Modal,
    context: MotionContext<'_>,
) -> Result<Option<AxisVector>, Fault> {
    let Some(&NamedValue { value, span, .. }) = gathered.named(Named::Ar) else { return Ok(None) };
    if !gathered.center.iter().any(Option::is_some) {
        return Ok(None);
    }
    let [abscissa, ordinate, _] = modal.modes.plane.axes();
    if gathered.named.contains(abscissa) || gathered.named.contains(ordinate) || gathered::is_programmed(gathered) {
        let help = "keep two of them: an arc has either center and angle, or end and angle, or end and center";
        return Err(fault(Code::BAD_ARC, span, "center, end point and opening angle in one block", help));
    }
    let angle = opening_rad(value, span)?;
    let mut end = context.setup.programmed(&modal.position.command);
    let start = [end[abscissa], end[ordinate]];
    let center = programmed_center(gathered, modal, start, |_| 0.0)?;
    let turned = if modal.modes.motion == MotionKind::Clockwise { -angle } else { angle };
    let (sine, cosine) = turned.sin_cos();
    let across = [start[0] - center[0], start[1] - center[1]];
    end[abscissa] = center[0] + across[0] * cosine - across[1] * sine;
    end[ordinate] = center[1] + across[0] * sine + across[1] * cosine;
    // Words of the applicate and of other axes are used as programmed.
    for axis in gathered.named.iter() {
        end[axis] = modal.programmed[axis];
    }
    Ok(Some(end))
}

/// The opening angle of an arc, rad.
fn opening_rad(value: f64, span: Span) -> Result<f64, Fault> {
    if value > 0.0 && value < 360.0 {
        return Ok(value.to_radians());
    }
    Err(bad_value(span, format!("AR={value} is not an angle between 0 and 360"), "a full circle needs I, J, K"))
}

/// Increments per millimeter of a Sinumerik in its delivered state (MD10200).
const DELIVERED_PER_MM: f64 = 1000.0;

/// Compares two points of the plane at the resolution of the control.
pub(super) fn on_control(a: [f64; 2], b: [f64; 2], control: &Control) -> Meeting {
    match control.increments_per_mm {
        Some(count) => meeting(a, b, count),
        // Not given in the file: the resolution of the output and that of the delivered control must agree.
        None => match (meeting(a, b, 1.0 / control.grid[0]), meeting(a, b, DELIVERED_PER_MM)) {
            (one, other) if one == other => one,
            _ => Meeting::Unsure,
        },
    }
}

/// The end of an arc in base coordinates; if it equals the start at the resolution of the control, it is the start. An arc given `by_angle` turns by
/// that angle.
pub(super) fn closed_on_grid(
    plane: Plane,
    context: MotionContext<'_>,
    start: &AxisVector,
    target: &AxisVector,
    by_angle: bool,
) -> Result<AxisVector, Fault> {
    let [abscissa, ordinate, _] = plane.axes();
    let (from, to) = (context.setup.programmed(start), context.setup.programmed(target));
    let (s, e) = ([from[abscissa], from[ordinate]], [to[abscissa], to[ordinate]]);
    match on_control(s, e, context.control) {
        Meeting::Apart => Ok(*target),
        Meeting::Same if !by_angle => {
            if context.setup.frame.is_translation() {
                let mut closed = *target;
                (closed[abscissa], closed[ordinate]) = (start[abscissa], start[ordinate]);
                return Ok(closed);
            }
            let mut closed = to;
            (closed[abscissa], closed[ordinate]) = (s[0], s[1]);
            Ok(context.setup.command(&closed))
        }
        _ => Err(unsure(context.span, s, e, "state MD10200 as control.increments_per_mm in the machine file")),
    }
}

fn two_centers(span: Span) -> Fault {
    let message = "the center of this arc is given in two ways";
    fault(Code::BAD_ARC, span, message, "keep one of I J K, CR=, AR= and a polar end point")
}

/// Center by I, J, K; `base` is added to absolute words.
fn programmed_center(
    gathered: &Gathered,
    modal: &Modal,
    start: [f64; 2],
    base: impl Fn(Axis) -> f64,
) -> Result<[f64; 2], Fault> {
    let [abscissa, ordinate, applicate] = modal.modes.plane.axes();
    if gathered.center[applicate.slot()].is_some_and(|(value, _)| value != 0.0) {
        let letter = char::from(b"IJK"[applicate.slot()]);
        let message = format!("{letter} lies outside the working plane G{}", modal.modes.plane.number());
        let help = "select the plane of the arc, or correct the center word";
        return Err(fault(Code::BAD_ARC, gathered.center_span, message, help));
    }
    let mut center = start;
    for (place, axis) in center.iter_mut().zip([abscissa, ordinate]) {
        match gathered.center[axis.slot()] {
            None => {}
            Some((value, false)) => *place += value * modal.modes.scale(),
            Some((value, true)) => *place = value * modal.modes.scale() + base(axis),
        }
    }
    Ok(center)
}

/// The shape of an arc in the working plane.
pub(super) fn arc(
    gathered: &Gathered,
    modal: &Modal,
    context: MotionContext<'_>,
    start: &AxisVector,
    target: &AxisVector,
) -> Result<Shape, Fault> {
    let [abscissa, ordinate, _] = modal.modes.plane.axes();
    if context.strict {
        let plane: AxisSet = [abscissa, ordinate].into_iter().collect();
        if let Some(axis) = plane.difference(modal.position.known).iter().next() {
            return Err(modal.unknown_start(context.span, axis));
        }
    }
    let clockwise = modal.modes.motion == MotionKind::Clockwise;
    let turns = match gathered.named(Named::Turn) {
        None => 0,
        Some(&NamedValue { value: turns, .. }) if turns.fract() == 0.0 && (0.0..=MAX_TURNS).contains(&turns) => {
            turns as u32
        }
        Some(&NamedValue { value: turns, span, .. }) => {
            return Err(bad_value(
                span,
                format!("TURN={turns} is not a valid number of turns"),
                "write a whole number from 0 to 999",
            ));
        }
    };
    let has_center = gathered.center.iter().any(Option::is_some);
    // If the frame is a pure shift, arcs are computed in base coordinates, exact to the last bit; otherwise as programmed.
    let (frame, is_shifted) = (&context.setup.frame, context.setup.frame.is_translation());
    let (from, to) = if is_shifted {
        (*start, *target)
    } else {
        (context.setup.programmed(start), context.setup.programmed(target))
    };
    let (s, e) = ([from[abscissa], from[ordinate]], [to[abscissa], to[ordinate]]);
    let tolerance = |radius: f64| context.control.arc_tolerance_mm.max(context.control.arc_tolerance_ratio * radius);
    let radius = gathered.named(Named::Cr).map(|value| (value.value, value.span));
    let opening = gathered.named(Named::Ar);
    let center = match (radius, has_center) {
        _ if gathered::is_programmed(gathered) => {
            if let Some(other) = radius.map(|(_, span)| span).or(opening.map(|value| value.span)) {
                return Err(two_centers(other));
            }
            if has_center {
                return Err(two_centers(gathered.center_span));
            }
            let pole = modal.polar.pole(modal.modes.plane, context.span)?;
            let base =
                |axis: Axis| if is_shifted { frame.shift(axis) - context.setup.tool_mm[axis.slot()] } else { 0.0 };
            [pole[0] + base(abscissa), pole[1] + base(ordinate)]
        }
        (Some((_, span)), true) => return Err(two_centers(span)),
        (Some((_, span)), false) if opening.is_some() => return Err(two_centers(span)),
        (None, false) => match opening {
            Some(&NamedValue { value, span, .. }) => center_of_angle(opening_rad(value, span)?, span, s, e, clockwise)?,
            None => {
                let help = "add I, J, K, CR= or AR=";
                return Err(fault(Code::NO_CENTER, context.span, "an arc without center and radius", help));
            }
        },
        (Some((radius, span)), false) => center_of_radius(radius * modal.modes.scale(), s, e, clockwise, &tolerance)
            .map_err(|found| radius_fault(&found, span))?,
        (None, true) => {
            let base =
                |axis: Axis| if is_shifted { frame.shift(axis) - context.setup.tool_mm[axis.slot()] } else { 0.0 };
            programmed_center(gathered, modal, s, base)?
        }
    };
    let plane = modal.modes.plane;
    let arc = ProgrammedArc { plane, clockwise, from: &from, to: &to, center_mm: center, extra_turns: turns };
    let is_compensated = modal.contour.compensates();
    let arc = arc.checked(Language::Sinumerik, context.control, is_compensated, tolerance).map_err(|found| match found {
        CenterFault::OffCircle { start_radius_mm, end_radius_mm, off_bisector_mm } => fault(
            Code::ARC_OFF_CIRCLE,
            context.span,
            format!(
                "start radius {start_radius_mm:.4} mm, end radius {end_radius_mm:.4} mm: the nearest center of a circle through \
                 both points is {off_bisector_mm:.4} mm away"
            ),
            "correct the center or the end point; the limit is control.arc_tolerance_mm",
        ),
        CenterFault::ZeroRadius => {
            fault(Code::BAD_ARC, context.span, "the center of the arc is its start", "correct I, J, K")
        }
        CenterFault::NotFinite => bad_value(context.span, "the arc is not finite", "check the values"),
    })?;
    Ok(behind_frame(&arc, [&from, &to], target, context.setup, context.control.chord_tolerance_mm))
}

fn radius_fault(found: &RadiusFault, span: Span) -> Fault {
    fault(Code::RADIUS_TOO_SMALL, span, found.message("CR"), "correct CR or the end point; a full circle needs I, J, K")
}

/// Center of an arc with an opening angle.
fn center_of_angle(angle: f64, span: Span, s: [f64; 2], e: [f64; 2], clockwise: bool) -> Result<[f64; 2], Fault> {
    let chord = [e[0] - s[0], e[1] - s[1]];
    if chord[0].hypot(chord[1]) == 0.0 {
        let help = "program another end point, or give the center with I, J, K";
        return Err(fault(Code::BAD_ARC, span, "start and end of an arc with AR coincide", help));
    }
    // Half the chord divided by the tangent of half the angle: below a half turn the center lies left of the chord of a counter-clockwise arc.
    let height = if angle == TAU / 2.0 { 0.0 } else { 0.5 / (angle / 2.0).tan() };
    let side = if clockwise { -height } else { height };
    Ok([s[0].midpoint(e[0]) - side * chord[1], s[1].midpoint(e[1]) + side * chord[0]])
}
