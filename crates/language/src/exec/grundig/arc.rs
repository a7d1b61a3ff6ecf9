//! Arcs and helices: center by I, J, K or polar (B3, L3), radius (R), sweep (B5), turns by the pitch.

use super::modal::Modal;
use super::step;
use super::target;
use ncfix_machine::machine::Machine;
use std::f64::consts::TAU;

use super::channel::Channel;
use super::gathered::{Found, Gathered};
use super::modal::{MotionKind, plus};
use super::target::Target;
use crate::exec::core::arc::{ProgrammedArc, behind_frame, center_of_radius, is_likely_center};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::grid::{Meeting, meeting, unsure};
use crate::exec::core::path::Shape;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, CenterFault, Plane};
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::snc::Kind;

/// Maximum number of turns of one helix.
const MOST_TURNS: f64 = 1000.0;
/// Largest disagreement between pitch, depth and sweep of a helix, turns.
const TURN_TOLERANCE: f64 = 0.01;
/// A remainder of a turn below this is zero.
const NO_REST: f64 = 1e-9;

/// A circular motion as programmed, in mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Circle {
    pub(super) clockwise: bool,
    /// Center in abscissa and ordinate of the plane.
    pub(super) center: [f64; 2],
    /// Total sweep, above 0, rad.
    pub(super) sweep_rad: f64,
}

/// The motion of a block while G2 or G3 is active.
pub(super) fn arc_words(channel: &mut Channel<'_>, gathered: &mut Gathered, target: Target) -> Result<(), Fault> {
    let Some(other) = plane_of_words(channel.modal.modes.plane, gathered, &target) else {
        return in_plane(channel, gathered, target);
    };
    let selected = channel.modal.modes.plane;
    if channel.settings.machine.control.takes_arc_plane_from_words && !channel.modal.contour.compensates() {
        channel.modal.modes.plane = other;
        let done = in_plane(channel, gathered, target);
        channel.modal.modes.plane = selected;
        return done;
    }
    in_plane(channel, gathered, target).map_err(|mut found| {
        if ![Code::BAD_ARC, Code::NO_CENTER, Code::ARC_OFF_CIRCLE].contains(&found.code) {
            return found;
        }
        found.help = format!(
            "if its two center words say that the arc lies in the plane of G{}, select this plane before it, or set control.arc_plane_from_words = true; in G{} one of them is the pitch of a helix",
            other.number(),
            selected.number()
        );
        found
    })
}

/// The plane of an arc of which two center words name another plane than the selected one, and that has no end along the axis of the third word.
fn plane_of_words(selected: Plane, gathered: &Gathered, target: &Target) -> Option<Plane> {
    let has_word = |axis: Axis| b"IJK".get(axis.slot()).is_some_and(|&letter| gathered.peek(letter, None).is_some());
    let planes = [Plane::XY, Plane::ZX, Plane::YZ].into_iter();
    let mut others = planes.filter(|&plane| plane != selected);
    others.find(|plane| {
        let [abscissa, ordinate, across] = plane.axes();
        has_word(abscissa) && has_word(ordinate) && !has_word(across) && !target.named.contains(across)
    })
}

/// The motion of a block in the plane in force while G2 or G3 is active.
fn in_plane(channel: &mut Channel<'_>, gathered: &mut Gathered, target: Target) -> Result<(), Fault> {
    let clockwise = channel.modal.modes.motion == MotionKind::Clockwise;
    let [abscissa, ordinate, applicate] = channel.modal.modes.plane.axes();
    let plane: AxisSet = [abscissa, ordinate].into_iter().collect();
    let letter = |axis: Axis| b"IJK".get(axis.slot()).copied().unwrap_or_default();
    let words = [gathered.once(letter(abscissa), None)?, gathered.once(letter(ordinate), None)?];
    let pitch = gathered.once(letter(applicate), None)?;
    let polar = [gathered.once(b'B', Some(3))?, gathered.once(b'L', Some(3))?];
    let (radius, sweep) = (gathered.once(b'R', None)?, gathered.once(b'B', Some(5))?);
    let has_center = words.iter().chain(&polar).any(Option::is_some);
    let is_idle = !has_center && radius.is_none() && sweep.is_none() && target.named.is_empty();
    if is_idle {
        if channel.block.feed_named {
            channel.outlet.push(Kind::Feed(channel.modal.modes.feed));
        }
        return Ok(());
    }
    target::check_plane_known(channel.settings.strict, &channel.modal, gathered.span)?;
    let here = target::here(&channel.modal, &channel.standing);
    let start = [here[abscissa], here[ordinate]];
    // Without words for the end, this is the start.
    let mut end = [target.to[abscissa], target.to[ordinate]];
    let has_end = !target.named.intersection(plane).is_empty();
    let mut target = target;
    if has_end {
        end = closed_on_grid(channel.settings.machine, start, end, gathered.span)?;
        (target.to[abscissa], target.to[ordinate]) = (end[0], end[1]);
    }
    if let Some((radius, span)) = radius {
        if let Some((_, span)) = sweep.or(pitch).filter(|_| true).or(if has_center { Some((0.0, span)) } else { None })
        {
            let message = "R together with a center, a sweep or a pitch";
            return Err(fault(Code::BAD_ARC, span, message, "keep one definition of the arc"));
        }
        let center = center_by_radius(channel.settings.machine, &channel.modal, radius, span, start, end, clockwise)?;
        let sweep_rad = sweep_between(start, end, center, clockwise);
        return circular(channel, Circle { clockwise, center, sweep_rad }, target.to, target.named.union(plane));
    }
    let center = center(channel, words, polar, start, gathered.span)?;
    let depth = (target.to[applicate] - here[applicate]).abs();
    let turns = match pitch {
        None => None,
        Some((pitch, span)) => {
            let pitch = pitch.abs() * channel.modal.modes.scale();
            if pitch < 1e-6 || depth < 1e-9 {
                let letter = char::from(letter(applicate));
                let message = format!("the pitch {letter} needs a value and the end of {applicate}");
                return Err(fault(Code::BAD_ARC, span, message, "program the depth of the helix in the block"));
            }
            Some((depth / pitch, span))
        }
    };
    let sweep_rad = match (sweep, turns) {
        (Some((degrees, span)), _) => {
            if has_end {
                let message = "center, end point and sweep B5= in one block";
                return Err(fault(Code::BAD_ARC, span, message, "keep the end point or the sweep"));
            }
            if !(degrees > 0.0 && degrees <= MOST_TURNS * 360.0) {
                return Err(bad_value(span, format!("B5={degrees} is not a valid sweep"), "write an angle above 0"));
            }
            if let Some((turns, span)) = turns
                && (turns - degrees / 360.0).abs() > TURN_TOLERANCE
            {
                let message = format!("pitch and depth make {turns:.3} turns, B5= {:.3}", degrees / 360.0);
                return Err(fault(Code::BAD_ARC, span, message, "correct one of them"));
            }
            degrees.to_radians()
        }
        (None, None) if has_end => sweep_between(start, end, center, clockwise),
        (None, None) => TAU,
        (None, Some((turns, span))) if !has_end => {
            if turns > MOST_TURNS {
                return Err(bad_value(span, "a helix of more than 1000 turns", "check the pitch"));
            }
            turns * TAU
        }
        (None, Some((turns, span))) => {
            let part = sweep_between(start, end, center, clockwise) / TAU;
            let whole = (turns - part).round().max(0.0);
            if (turns - part - whole).abs() > TURN_TOLERANCE || whole > MOST_TURNS {
                let message = format!("pitch and depth make {turns:.3} turns, which do not end at the end point");
                return Err(fault(Code::BAD_ARC, span, message, "correct the pitch, the depth or the end point"));
            }
            (part + whole) * TAU
        }
    };
    let mut to = target.to;
    if !has_end {
        let turns = sweep_rad / TAU;
        if (turns - turns.round()).abs() > NO_REST {
            end = turned(start, center, if clockwise { -sweep_rad } else { sweep_rad });
        }
        to[abscissa] = end[0];
        to[ordinate] = end[1];
    }
    circular(channel, Circle { clockwise, center, sweep_rad }, to, target.named.union(plane))
}

/// The end of an arc; if it equals the start within the increment of the control, it is the start.
fn closed_on_grid(machine: &Machine, start: [f64; 2], end: [f64; 2], span: Span) -> Result<[f64; 2], Fault> {
    match meeting(start, end, 1.0 / machine.control.grid[0]) {
        Meeting::Apart => Ok(end),
        Meeting::Same => Ok(start),
        Meeting::Unsure => Err(unsure(span, start, end, "the resolution is control.increment_mm")),
    }
}

/// The center of an arc of a given radius: up to half a turn, for a negative radius more.
fn center_by_radius(
    machine: &Machine,
    modal: &Modal,
    radius: f64,
    span: Span,
    start: [f64; 2],
    end: [f64; 2],
    clockwise: bool,
) -> Result<[f64; 2], Fault> {
    let control = &machine.control;
    let tolerance = |radius: f64| control.arc_tolerance_mm.max(control.arc_tolerance_ratio * radius);
    center_of_radius(radius * modal.modes.scale(), start, end, clockwise, &tolerance).map_err(|found| {
        let help = "correct R or the end point; a full circle needs its center";
        fault(Code::RADIUS_TOO_SMALL, span, found.message("R"), help)
    })
}

/// The center by words of the axes: absolute, or from the start in G91, or pointing to the start if the control reads them so; or by B3 and L3 from the pole.
fn center(
    channel: &Channel<'_>,
    words: [Option<Found>; 2],
    polar: [Option<Found>; 2],
    start: [f64; 2],
    span: Span,
) -> Result<[f64; 2], Fault> {
    let modal = &channel.modal;
    let scale = modal.modes.scale();
    let [abscissa, ordinate, _] = modal.modes.plane.axes();
    if let [Some((angle, span)), Some((length, _))] = polar {
        if words.iter().any(Option::is_some) {
            let message = "the center of this arc is given in two ways";
            return Err(fault(Code::BAD_ARC, span, message, "keep I, J, K or B3= and L3="));
        }
        let center = plus(&modal.pole, &modal.direction(angle), length * scale);
        return Ok([center[abscissa], center[ordinate]]);
    }
    if let Some((_, span)) = polar.into_iter().flatten().next() {
        let message = "B3= and L3= define a center only together";
        return Err(fault(Code::BAD_POLAR, span, message, "program both in the block"));
    }
    if words.iter().all(Option::is_none) {
        let message = "an arc without center and radius";
        return Err(fault(Code::NO_CENTER, span, message, "add the center with I, J, K, or R"));
    }
    let is_reversed = channel.settings.machine.control.has_arc_words_from_center;
    let mut center = start;
    for ((place, word), axis) in center.iter_mut().zip(words).zip([abscissa, ordinate]) {
        match word {
            Some((value, _)) if is_reversed => *place -= value * scale,
            Some((value, _)) if modal.modes.incremental => *place += value * scale,
            Some((value, _)) => *place = value * scale,
            None if modal.modes.incremental || is_reversed => {}
            None => {
                let message = format!("the center of this arc has no coordinate along {axis}");
                let help = "program both: absolute centers are not relative to the start";
                return Err(fault(Code::NO_CENTER, span, message, help));
            }
        }
    }
    Ok(center)
}

/// A circular motion, one move per turn; other axes have their share of each.
pub(super) fn circular(channel: &mut Channel<'_>, circle: Circle, to: AxisVector, named: AxisSet) -> Result<(), Fault> {
    let span = channel.outlet.origin.span;
    step::check_feed(channel, channel.modal.modes.feed, span)?;
    let turns = circle.sweep_rad / TAU;
    let mut whole = turns.floor();
    if turns - whole > 1.0 - NO_REST {
        whole += 1.0;
    }
    let has_rest = turns - whole > NO_REST;
    let from = target::here(&channel.modal, &channel.standing);
    let [abscissa, ordinate, _] = channel.modal.modes.plane.axes();
    // Between 0 and the maximum number of turns.
    for turn in 1..=whole as u32 {
        let mut end = from.lerp(&to, f64::from(turn) / turns);
        end[abscissa] = from[abscissa];
        end[ordinate] = from[ordinate];
        if !has_rest && f64::from(turn) >= whole {
            end = to;
        }
        one_arc(channel, circle, &end, named)?;
    }
    if has_rest { one_arc(channel, circle, &to, named) } else { Ok(()) }
}

/// One arc of up to one turn.
pub(super) fn one_arc(channel: &mut Channel<'_>, circle: Circle, to: &AxisVector, named: AxisSet) -> Result<(), Fault> {
    let (machine, setup, plane) =
        (channel.settings.machine, std::sync::Arc::clone(&channel.standing.setup), channel.modal.modes.plane);
    let control = &machine.control;
    let [abscissa, ordinate, _] = plane.axes();
    let span = channel.outlet.origin.span;
    let programmed = target::here(&channel.modal, &channel.standing);
    let to = *to;
    let (is_incremental, is_reversed) = (channel.modal.modes.incremental, control.has_arc_words_from_center);
    let is_compensated = channel.modal.contour.compensates();
    step::elementary(channel, &to, named, false, channel.modal.modes.feed, |[start, target]| {
        // If the frame is a pure shift, arcs are computed in base coordinates, exact to the last bit.
        let is_shifted = setup.frame.is_translation();
        let (from, end) = if is_shifted { (*start, *target) } else { (programmed, to) };
        let mut center = circle.center;
        if is_shifted {
            for (place, axis) in center.iter_mut().zip([abscissa, ordinate]) {
                *place += setup.frame.shift(axis) - setup.tool_mm[axis.slot()];
            }
        }
        let tolerance = |radius: f64| control.arc_tolerance_mm.max(control.arc_tolerance_ratio * radius);
        let clockwise = circle.clockwise;
        let arc = ProgrammedArc { plane, clockwise, from: &from, to: &end, center_mm: center, extra_turns: 0 };
        let arc = arc.checked(Language::Grundig, control, is_compensated, tolerance).map_err(|found| {
            let point = |at: &AxisVector| [at[abscissa], at[ordinate]];
            let (first, last) = (point(&programmed), point(&to));
            let word = |k: usize| if is_incremental { circle.center[k] - first[k] } else { circle.center[k] };
            let other = [first[0] - word(0), first[1] - word(1)];
            center_fault(found, span, !is_reversed && is_likely_center(first, last, other))
        })?;
        Ok::<Shape, Fault>(behind_frame(&arc, [&from, &end], target, &setup, control.chord_tolerance_mm))
    })
}

/// `fits_from_center`: the arc is possible if its words point from the center to the start.
fn center_fault(found: CenterFault, span: Span, fits_from_center: bool) -> Fault {
    let help = if fits_from_center {
        "the center fits if I, J and K point from the center to the start; set control.arc_words_from_center = true if the control reads them so, else correct the post-processor"
    } else {
        "correct the center (absolute in G90) or the end point; the limit is control.arc_tolerance_mm"
    };
    match found {
        CenterFault::OffCircle { start_radius_mm, end_radius_mm, off_bisector_mm } => fault(
            Code::ARC_OFF_CIRCLE,
            span,
            format!(
                "start radius {start_radius_mm:.4} mm, end radius {end_radius_mm:.4} mm: the nearest center of a circle through \
                 both points is {off_bisector_mm:.4} mm away"
            ),
            help,
        ),
        CenterFault::ZeroRadius => fault(
            Code::BAD_ARC,
            span,
            "the center of the arc is its start",
            "correct I, J, K: they are absolute in G90",
        ),
        CenterFault::NotFinite => bad_value(span, "the arc is not finite", "check the values"),
    }
}

/// The angle from one point to another about a center in the direction of the arc, above 0 and at most a turn.
pub(super) fn sweep_between(start: [f64; 2], end: [f64; 2], center: [f64; 2], clockwise: bool) -> f64 {
    let angle = |point: [f64; 2]| (point[1] - center[1]).atan2(point[0] - center[0]);
    if (start[0] - end[0]).hypot(start[1] - end[1]) < NO_REST {
        return TAU;
    }
    let turned = if clockwise { angle(start) - angle(end) } else { angle(end) - angle(start) };
    let sweep = turned.rem_euclid(TAU);
    if sweep > 0.0 { sweep } else { TAU }
}

/// A point rotated about a center.
pub(super) fn turned(point: [f64; 2], center: [f64; 2], angle_rad: f64) -> [f64; 2] {
    let (sine, cosine) = angle_rad.sin_cos();
    let across = [point[0] - center[0], point[1] - center[1]];
    [center[0] + across[0] * cosine - across[1] * sine, center[1] + across[0] * sine + across[1] * cosine]
}
