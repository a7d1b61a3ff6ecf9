//! Motions other than lines and arcs: cycles, threads, probing, splines; and plane words that are not coordinates.

use super::channel::Channel;
use super::codes::{Group, name_of};
use super::gathered::Gathered;
use super::measure;
use super::modal::Modal;
use super::polar::{self};
use super::target;
use crate::exec::core::contour::{Corner, Transition};
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, AxisVector};
use ncfix_base::source::Span;

/// `G7`, `G8`: diameters and radii of a lathe.
pub(super) fn lathe(gathered: &Gathered) -> Result<(), Fault> {
    let Some(code) = gathered.code(Group::Lathe) else { return Ok(()) };
    let message = format!("{} is for lathes, and is not supported", name_of(code));
    let help = "program X without it: positions are those of the axis";
    Err(fault(Code::NOT_SUPPORTED, gathered.code_span(Group::Lathe), message, help))
}

/// Replaces plane words by polar words: changes the programmed end and the named axes.
pub(super) fn polar_end(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    here: &AxisVector,
    end: &mut AxisVector,
    named: &mut AxisSet,
) -> Result<(), Fault> {
    if channel.special.polar.is_some() {
        return polar_axes(channel, gathered, here, end, named);
    }
    if gathered.has(b'a') {
        return angle_word(channel, gathered, here, end, named);
    }
    if !gathered.has_any(b"@^") {
        return Ok(());
    }
    let [abscissa, ordinate, _] = ncfix_base::geometry::Plane::XY.axes();
    let plane: AxisSet = [abscissa, ordinate].into_iter().collect();
    let (radius, angle) = (
        measure::length(channel, gathered, b'@')?,
        measure::angle(channel.settings.machine, channel.language, &mut channel.warned, gathered, b'^')?,
    );
    let span = gathered.span_of(if radius.is_some() { b'@' } else { b'^' });
    if !named.intersection(plane).is_empty() {
        return Err(bad_value(span, "X or Y together with polar coordinates", "write X and Y, or @ and ^"));
    }
    let incremental = channel.modal.modes.incremental;
    if incremental || radius.is_none() || angle.is_none() {
        check_plane_stated(channel.settings.strict, &channel.modal, plane, span)?;
    }
    let Some([x, y]) = polar::rs274([here[abscissa], here[ordinate]], radius, angle, incremental) else {
        let message = "polar words at the origin, where the direction is undefined";
        return Err(bad_value(span, message, "give both @ and ^ with G90"));
    };
    end[abscissa] = x;
    end[ordinate] = y;
    *named = named.union(plane);
    Ok(())
}

/// The words of the plane under G16: radius and angle.
fn polar_axes(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    here: &AxisVector,
    end: &mut AxisVector,
    named: &mut AxisSet,
) -> Result<(), Fault> {
    let [abscissa, ordinate, _] = channel.modal.modes.plane.axes();
    let plane: AxisSet = [abscissa, ordinate].into_iter().collect();
    if named.intersection(plane).is_empty() {
        return Ok(());
    }
    let incremental = channel.modal.modes.incremental;
    let radius = measure::length(channel, gathered, abscissa.letter())?;
    let angle =
        measure::angle(channel.settings.machine, channel.language, &mut channel.warned, gathered, ordinate.letter())?;
    if incremental || radius.is_none() || angle.is_none() {
        check_plane_stated(channel.settings.strict, &channel.modal, plane, gathered.span)?;
    }
    if let Some(polar) = &mut channel.special.polar {
        let [first, second] = polar.target([here[abscissa], here[ordinate]], radius, angle, incremental);
        end[abscissa] = first;
        end[ordinate] = second;
    }
    *named = named.union(plane);
    Ok(())
}

/// `,A`: the direction of the line instead of the second coordinate of its end.
fn angle_word(
    channel: &mut Channel<'_>,
    gathered: &Gathered,
    here: &AxisVector,
    end: &mut AxisVector,
    named: &mut AxisSet,
) -> Result<(), Fault> {
    let span = gathered.span_of(b'a');
    let [abscissa, ordinate, _] = channel.modal.modes.plane.axes();
    let plane: AxisSet = [abscissa, ordinate].into_iter().collect();
    let angle = measure::angle(channel.settings.machine, channel.language, &mut channel.warned, gathered, b'a')?
        .unwrap_or_default();
    let mut given = named.intersection(plane).iter();
    let (Some(axis), None) = (given.next(), given.next()) else {
        let message = ",A needs exactly one coordinate of the plane in its block";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "give one coordinate of the end, or both without ,A"));
    };
    check_plane_stated(channel.settings.strict, &channel.modal, plane, span)?;
    let (sin, cos) = angle.sin_cos();
    let (other, run, rise) = if axis == abscissa { (ordinate, cos, sin) } else { (abscissa, sin, cos) };
    let found = here[other] + (end[axis] - here[axis]) * rise / run;
    if run.abs() < 1e-9 || !found.is_finite() {
        let message = format!("at {} degrees the line never reaches this {axis}", angle.to_degrees());
        return Err(bad_value(span, message, "give the other coordinate, or correct the angle"));
    }
    end[other] = found;
    named.insert(other);
    Ok(())
}

/// Rejects motions that depend on plane axes at positions the program has not stated.
pub(super) fn check_plane_stated(strict: bool, modal: &Modal, plane: AxisSet, span: Span) -> Result<(), Fault> {
    plane.iter().try_for_each(|axis| target::check_stated(strict, modal, axis, span))
}

/// The request of `,C` and `,R` for the end of the next motion.
pub(super) fn corner_words(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    if !gathered.has_any(b"cr") {
        return Ok(());
    }
    let (chamfer, radius) = (measure::length(channel, gathered, b'c')?, measure::length(channel, gathered, b'r')?);
    let span = gathered.span_of(if chamfer.is_some() { b'c' } else { b'r' });
    let (size, round) = match (chamfer, radius) {
        (Some(size), None) => (size, false),
        (None, Some(size)) => (size, true),
        _ => return Err(bad_value(span, ",C and ,R in one block", "write one of them")),
    };
    if !(0.0..=1e6).contains(&size) {
        return Err(bad_value(span, format!("{size} is not a valid corner size"), "write a value above 0"));
    }
    if size == 0.0 {
        return Ok(());
    }
    let frame = &channel.standing.setup.frame;
    if !frame.is_translation() && !frame.keeps_circles(channel.modal.modes.plane) {
        let message = ",C or ,R under unequal scaling";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "scale both axes of the plane equally"));
    }
    let [abscissa, ..] = channel.modal.modes.plane.axes();
    let size = size * frame.linear().column(abscissa.slot()).norm();
    let transition = if round { Transition::Round(size) } else { Transition::ChamferSetback(size) };
    channel.block.corner = Some(Corner { transition, feed: 0.0, is_modal: false });
    Ok(())
}
