//! Arcs of the working plane: G2 and G3 with I J K or R.

use super::direction;
use super::measure;
use super::modal::Modal;
use super::step;
use super::target;
use crate::exec::core::standing::InForce;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use std::sync::Arc as Shared;

use super::channel::Channel;
use super::gathered::Gathered;
use super::step::Step;
use crate::exec::core::arc::{ProgrammedArc, behind_frame, center_of_radius, is_likely_center};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::grid::{Meeting, closes_in_linuxcnc, is_one_place, meeting, unsure};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Arc, AxisSet, AxisVector, CenterFault};
use ncfix_base::source::Span;
use ncfix_base::units::MM_PER_INCH;
use std::f64::consts::TAU;

/// Maximum number of turns of a helix.
const MAX_TURNS: f64 = 999.0;
/// Largest difference of start and end radius in LinuxCNC without the relative limit, mm: 2√2 hundredths in mm, thousandths in inch.
const SPIRAL_MM: f64 = 0.02 * std::f64::consts::SQRT_2;
const SPIRAL_INCH_MM: f64 = 0.002 * std::f64::consts::SQRT_2 * MM_PER_INCH;
/// Relative limit of this difference, and its cap as a multiple of the length above.
const SPIRAL_SHARE: f64 = 0.001;
const SPIRAL_MOST: f64 = 100.0;
/// Difference of the radii, mm, below which they are equal.
const SAME_RADIUS_MM: f64 = 1e-6;
/// Angle between start and end, rad, below which they are in one direction from the center.
const SAME_ANGLE_RAD: f64 = 1e-9;
/// Largest disagreement between lead, depth and sweep of a helix, turns.
const TURN_TOLERANCE: f64 = 0.01;
/// Largest excess of half the chord over a radius in LinuxCNC, mm.
const RADIUS_MM: f64 = 0.00005 * MM_PER_INCH;

/// Moves along an arc; G2 and G3 in tenths.
pub(super) fn arc(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    code: u16,
    end: AxisVector,
    named: AxisSet,
) -> Result<(), Fault> {
    let setup = Shared::clone(&channel.standing.setup);
    let [abscissa, ordinate, applicate] = channel.modal.modes.plane.axes();
    if channel.settings.strict {
        let plane: AxisSet = [abscissa, ordinate].into_iter().collect();
        if let Some(axis) = plane.difference(channel.modal.position.known).iter().next() {
            return Err(channel.modal.position.unknown(gathered.span, axis));
        }
    }
    let (clockwise, span) = (code == 20, gathered.span);
    let end = if channel.is_rs274() {
        end
    } else {
        closed_on_grid(channel.settings.machine, &channel.modal, &channel.standing, end, span)?
    };
    let target = step::reach(&channel.modal, &setup, named, &end, gathered.span)?;
    let turns = turns(channel.language, gathered)?;
    // If the frame is a pure shift, arcs are computed in base coordinates, exact to the last bit; otherwise as programmed.
    let is_shifted = setup.frame.is_translation();
    let (from, to) = if is_shifted {
        (channel.modal.position.command, target)
    } else {
        (target::here(&channel.modal, &channel.standing), end)
    };
    let (s, e) = ([from[abscissa], from[ordinate]], [to[abscissa], to[ordinate]]);
    let center_letters = [abscissa, ordinate].map(|axis| b"IJK"[axis.slot()]);
    let across = b"IJK"[applicate.slot()];
    let has_center = gathered.has_any(&center_letters);
    let radius = measure::length(channel, gathered, b'R')?;
    let has_across = !direction::has_directions(&channel.modal);
    if channel.is_rs274() && has_across && channel.settings.strict && gathered.raw_quietly(across) == Some(0.0) {
        let message = format!("{}0 has no effect on this arc", char::from(across));
        let help = "remove it: Grbl and Mach ignore it, and LinuxCNC stops with an error";
        channel.outlet.warnings.push(fault(Code::UNUSUAL_MOTION, gathered.span_of(across), message, help));
    }
    let is_across = gathered.raw(across).is_some_and(|value| has_across && value != 0.0);
    let lead = if is_across { measure::length(channel, gathered, across)? } else { None };
    if lead.is_some() && channel.is_rs274() {
        return Err(outside_plane(channel, gathered, across));
    }
    if radius.is_some() && has_center && channel.is_rs274() {
        let message = "the center of this arc is given in two ways";
        return Err(fault(Code::BAD_ARC, gathered.span_of(b'R'), message, "keep either R or I, J, K"));
    }
    let tolerance = arc_tolerance(channel.settings.machine, channel.language, &channel.modal);
    let center = if let Some(radius) = radius {
        // On a Fanuc R has priority over the center words.
        gathered.use_up(&center_letters);
        if !channel.is_rs274() && is_one_place(s, e) {
            let message = "an arc with R whose end is its start does not move";
            channel.outlet.warnings.push(fault(Code::LEFT_OUT, span, message, "a full circle needs I, J, K"));
            let step = Step::straight(gathered, false, end, named);
            return step::step(channel, step);
        }
        let slack = channel.is_rs274();
        let reach = |radius: f64| if slack { RADIUS_MM } else { tolerance(radius) };
        center_of_radius(radius, s, e, clockwise, &reach).map_err(|found| {
            let help = "correct R or the end point; a full circle needs I, J, K";
            fault(Code::RADIUS_TOO_SMALL, gathered.span_of(b'R'), found.message("R"), help)
        })
    } else if has_center {
        center(channel, gathered, s, is_shifted)
    } else if channel.is_rs274() || channel.settings.machine.control.iso.is_haas() {
        Err(fault(Code::NO_CENTER, span, "an arc without center and radius", "add I, J, K or R"))
    } else {
        // Parameter 3403, bit 5 (CIR): with 0 a straight line, with 1 alarm PS0022.
        let message = "an arc without center and radius is a straight move on a Fanuc";
        let help = "add I, J, K or R if an arc was intended (parameter 3403, bit 5: straight move or alarm PS0022)";
        channel.outlet.warnings.push(fault(Code::UNUSUAL_MOTION, span, message, help));
        return step::step(channel, Step::straight(gathered, false, end, named));
    };
    let (mut target, mut to) = (target, to);
    let mut warnings = Vec::new();
    if let Ok(center) = &center
        && channel.is_rs274()
        && closes_in_linuxcnc(s, e, *center)
    {
        let (here, mut end) = (target::here(&channel.modal, &channel.standing), end);
        (end[abscissa], end[ordinate]) = (here[abscissa], here[ordinate]);
        target = step::reach(&channel.modal, &setup, named, &end, span)?;
        to = if is_shifted { target } else { end };
    }
    let center_mm = center.as_ref().copied().unwrap_or(s);
    let arc = center.and_then(|center| {
        let plane = channel.modal.modes.plane;
        let help = match channel.language {
            Language::Rs274 => "correct the center or the end point",
            _ => "correct the center or the end point; the limit is control.arc_tolerance_mm",
        };
        let allowed_mm = |radius: f64| tolerance(radius);
        // Parameter 3410 of a Fanuc: 0 for no check.
        let is_checked = channel.language == Language::Rs274 || channel.settings.machine.control.iso.checks_arc_radii;
        let tolerance = |radius: f64| if is_checked { tolerance(radius) } else { f64::INFINITY };
        // Radius compensation and corners are computed for circles.
        let has_corner = channel.block.corner.is_some() || channel.outlet.is_holding();
        let is_compensated = channel.modal.contour.compensates() || has_corner;
        let arc = ProgrammedArc { plane, clockwise, from: &from, to: &to, center_mm: center, extra_turns: turns };
        let arc = arc.checked(channel.language, &channel.settings.machine.control, is_compensated, tolerance);
        if channel.language != Language::Rs274
            && let Ok(arc) = &arc
        {
            check_turn(arc, &from, &to, span)?;
            warnings.extend(spiral(arc, [&from, &to], allowed_mm, span));
        }
        arc.map_err(|found| match found {
            CenterFault::OffCircle { start_radius_mm, end_radius_mm, off_bisector_mm } => fault(
                Code::ARC_OFF_CIRCLE,
                span,
                format!(
                    "start radius {start_radius_mm:.4} mm, end radius {end_radius_mm:.4} mm: the nearest \
                         center of a circle through both points is {off_bisector_mm:.4} mm away"
                ),
                likely_center(channel, s, e, center_mm).unwrap_or(help),
            ),
            CenterFault::ZeroRadius => {
                fault(Code::BAD_ARC, span, "the center of the arc is its start", "correct I, J, K")
            }
            CenterFault::NotFinite => bad_value(span, "the arc is not finite", "check the values"),
        })
    });
    channel.outlet.warnings.append(&mut warnings);
    // The next motion begins at the end of the block, so that one error is not repeated in every following arc.
    let arc = arc.inspect_err(|_| {
        channel.modal.position.command = target;
        channel.modal.position.known = channel.modal.position.known.union(named);
    })?;
    if let Some(lead) = lead {
        let depth = to[applicate] - from[applicate];
        if !fits_lead(&arc, [&from, &to], depth, lead) {
            return Err(outside_plane(channel, gathered, across));
        }
        let message = format!("{} is the lead of this helix, which follows from its end", char::from(across));
        let help = "remove the word: Fanuc controls have none for the lead of a helix";
        channel.outlet.warnings.push(fault(Code::UNUSUAL_MOTION, gathered.span_of(across), message, help));
    }
    if !setup.frame.keeps_circles(channel.modal.modes.plane) {
        let message = "an arc under a scaling that differs between the axes of its plane";
        let help = "scale both axes equally: otherwise the path on a control is neither a circle nor an ellipse";
        return Err(fault(Code::NOT_SUPPORTED, span, message, help));
    }
    let shape = behind_frame(&arc, [&from, &to], &target, &setup, channel.settings.machine.control.chord_tolerance_mm);
    let step = Step::straight(gathered, false, end, named);
    step::send(channel, step, target, shape, setup)
}

/// `true` if a word across the plane is the lead of a helix that ends where the block says.
fn fits_lead(arc: &Arc, [from, to]: [&AxisVector; 2], depth: f64, lead: f64) -> bool {
    let turns = arc.sweep_rad(from, to).abs() / TAU;
    (depth.abs() / lead.abs() - turns).abs() <= TURN_TOLERANCE
}

/// The fault of a center word across the plane of its arc.
fn outside_plane(channel: &Channel<'_>, gathered: &Gathered, across: u8) -> Fault {
    let (letter, plane) = (char::from(across), channel.modal.modes.plane.number());
    let message = format!("{letter} lies outside the working plane G{plane}");
    let help = format!(
        "select the plane of the arc; if {letter} is the lead of a helix, remove it, and write one block for each turn with its own end across the plane"
    );
    fault(Code::BAD_ARC, gathered.span_of(across), message, help)
}

/// The warning of an arc whose radii differ by more than usual.
fn spiral(arc: &Arc, [from, to]: [&AxisVector; 2], allowed_mm: impl Fn(f64) -> f64, span: Span) -> Option<Fault> {
    let (start, end) = (arc.radius_mm(from), arc.radius_mm(to));
    ((start - end).abs() > allowed_mm(start.max(end))).then(|| {
        let message = format!("a spiral from radius {start:.4} mm to radius {end:.4} mm");
        let help = "the control does not compare the radii (control.arc_radius_check = false); correct the center if a circle was intended";
        fault(Code::UNUSUAL_MOTION, span, message, help)
    })
}

/// The help if another reading of the center words fits: a center of positions, or of distances without sign.
fn likely_center(channel: &Channel<'_>, start: [f64; 2], end: [f64; 2], center: [f64; 2]) -> Option<&'static str> {
    let fits = |center: [f64; 2]| is_likely_center(start, end, center);
    let words = [center[0] - start[0], center[1] - start[1]];
    if channel.modal.has_absolute_centers() || reads_from_center(channel) {
        return None;
    }
    if fits(words) {
        return Some(
            "I, J and K fit as the position of the center: this control counts them from the start of the arc; set the post-processor to it",
        );
    }
    let mirrored = [[-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
    let turned = |[a, b]: [f64; 2]| [start[0] + a * words[0], start[1] + b * words[1]];
    if !channel.is_rs274() && fits(turned([-1.0, -1.0])) {
        return Some(
            "the center fits if I, J and K point from the center to the start; set control.arc_words_from_center = true if the control reads them so, else correct the post-processor",
        );
    }
    mirrored.into_iter().map(turned).any(fits).then_some(
        "the center fits with another sign of I, J or K: they are signed distances from the start of the arc; correct the program",
    )
}

/// Rejects an arc whose end is beside its start along the radius: whether it turns by nothing or by a whole turn is not specified.
fn check_turn(arc: &Arc, from: &AxisVector, to: &AxisVector, span: Span) -> Result<(), Fault> {
    let sweep = arc.sweep_rad(from, to).abs();
    let radii = (arc.radius_mm(from) - arc.radius_mm(to)).abs();
    if radii < SAME_RADIUS_MM || sweep > SAME_ANGLE_RAD && sweep < TAU - SAME_ANGLE_RAD {
        return Ok(());
    }
    let message = "the end of this arc is on the line from its center through its start: a full turn or none";
    Err(fault(Code::BAD_ARC, span, message, "program the start as the end of a full circle, or correct the end point"))
}

/// The end of an arc of a Fanuc; if it equals the start within the increment, it is the start.
fn closed_on_grid(
    machine: &Machine,
    modal: &Modal,
    standing: &InForce,
    mut end: AxisVector,
    span: Span,
) -> Result<AxisVector, Fault> {
    let here = target::here(modal, standing);
    let [abscissa, ordinate, _] = modal.modes.plane.axes();
    let (start, to) = ([here[abscissa], here[ordinate]], [end[abscissa], end[ordinate]]);
    match meeting(start, to, measure::increments_per_length(machine, modal) / modal.modes.scale()) {
        Meeting::Apart => {}
        Meeting::Same => (end[abscissa], end[ordinate]) = (start[0], start[1]),
        Meeting::Unsure => return Err(unsure(span, start, to, "the resolution is that of control.increment_system")),
    }
    Ok(end)
}

/// `true` if I, J, K point from the center to the start; RS274/NGC has codes for what they are.
fn reads_from_center(channel: &Channel<'_>) -> bool {
    !channel.is_rs274() && channel.settings.machine.control.has_arc_words_from_center
}

/// Center by I, J, K, in base coordinates if the frame is a pure shift.
fn center(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    start: [f64; 2],
    is_shifted: bool,
) -> Result<[f64; 2], Fault> {
    let [abscissa, ordinate, _] = channel.modal.modes.plane.axes();
    let is_reversed = reads_from_center(channel);
    let mut center = start;
    for (place, axis) in center.iter_mut().zip([abscissa, ordinate]) {
        let letter = b"IJK"[axis.slot()];
        let value = measure::length(channel, gathered, letter)?;
        if channel.modal.has_absolute_centers() {
            let Some(value) = value else {
                let message = format!("{} is missing while G90.1 is in force", char::from(letter));
                return Err(fault(Code::NO_CENTER, gathered.span, message, "give both coordinates of the center"));
            };
            let shift = channel.standing.setup.frame.shift(axis) - channel.standing.setup.tool_mm[axis.slot()];
            *place = value + if is_shifted { shift } else { 0.0 };
        } else if is_reversed {
            *place -= value.unwrap_or_default();
        } else {
            *place += value.unwrap_or_default();
        }
    }
    Ok(center)
}

/// Full turns beyond the arc itself: P minus one (RS274/NGC).
fn turns(language: Language, gathered: &Gathered) -> Result<u32, Fault> {
    if language != Language::Rs274 {
        return Ok(0);
    }
    match gathered.raw(b'P').map(|turns| (turns, turns.round())) {
        None => Ok(0),
        Some((turns, whole)) if (turns - whole).abs() <= 1e-3 && (1.0..=MAX_TURNS).contains(&whole) => {
            Ok(whole as u32 - 1)
        }
        Some((turns, _)) => {
            let message = format!("P{turns} is not a valid number of turns");
            Err(bad_value(gathered.span_of(b'P'), message, "write a whole number from 1 to 999"))
        }
    }
}

/// Largest distance of an arc's end from its circle, as a function of the radius.
fn arc_tolerance(machine: &Machine, language: Language, modal: &Modal) -> impl Fn(f64) -> f64 + use<> {
    let control = &machine.control;
    let (length, share, most) = if language == Language::Rs274 {
        let length = if modal.modes.inch { SPIRAL_INCH_MM } else { SPIRAL_MM };
        (length, SPIRAL_SHARE, length * SPIRAL_MOST)
    } else {
        (control.arc_tolerance_mm, control.arc_tolerance_ratio, f64::INFINITY)
    };
    move |radius: f64| (share * radius).max(length).min(most)
}
