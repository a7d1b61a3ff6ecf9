//! G5, G5.1 and G5.2/G5.3 of RS274/NGC: curves of the XY plane.

use super::channel::Special;
use super::forbidden;
use super::measure;
use super::modal::Modal;
use super::special;
use super::step;
use super::target;
use ncfix_dialect::Language;
use std::sync::Arc as Shared;

use super::channel::Channel;
use super::codes::{G80, name_of};
use super::gathered::Gathered;
use super::nurbs::{Control, Nurbs, NurbsFault};
use super::step::Step;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::path::Shape;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Plane};
use ncfix_base::source::Span;
use ncfix_machine::snc::MotionMode;

/// Maximum number of control points of one curve.
const MOST_POINTS: usize = 2_000;
/// Maximum order.
const MOST_ORDER: f64 = 2_000.0;

/// `G5`, `G5.1`
pub(super) fn spline(channel: &mut Channel<'_>, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    check_curve(channel.settings.strict, channel.language, &channel.modal, gathered, code)?;
    let here = target::here(&channel.modal, &channel.standing);
    let start = [here[Axis::X], here[Axis::Y]];
    let (end, _) = step::end(channel, gathered)?;
    let target = [end[Axis::X], end[Axis::Y]];
    let pair = |channel: &mut Channel<'_>, letters: [u8; 2]| -> Result<Option<[f64; 2]>, Fault> {
        match (measure::length(channel, gathered, letters[0])?, measure::length(channel, gathered, letters[1])?) {
            (Some(first), Some(second)) => Ok(Some([first, second])),
            (None, None) => Ok(None),
            _ => {
                let [first, second] = letters.map(char::from);
                let message = format!("{} with one of {first} and {second}", name_of(code));
                Err(bad_value(gathered.span, message, "write both"))
            }
        }
    };
    let first = pair(channel, *b"IJ")?;
    let points = if code == 51 {
        let Some(first) = first else {
            return Err(bad_value(gathered.span, "G5.1 needs I and J", "write the offset of its control point"));
        };
        vec![start, plus(start, first), target]
    } else {
        let Some(second) = pair(channel, *b"PQ")? else {
            let message = "G5 needs P and Q";
            return Err(bad_value(gathered.span, message, "write the offset of its second control point"));
        };
        let first = first.unwrap_or(channel.special.curve.onwards);
        channel.special.curve.onwards = second.map(|part| -part);
        vec![start, plus(start, first), plus(target, second), target]
    };
    let curve = Nurbs::bezier(&points).map_err(|found| no_curve(found, gathered.span))?;
    along(channel, &curve, gathered)
}

/// `G5.2` and the following blocks: a control point.
pub(super) fn nurbs_point(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    check_curve(channel.settings.strict, channel.language, &channel.modal, gathered, 52)?;
    let weight = gathered.raw(b'P');
    let order = gathered.raw(b'L');
    let has = [b'X', b'Y'].map(|letter| gathered.has(letter));
    if has[0] != has[1] {
        return Err(bad_value(gathered.span, "G5.2 with one of X and Y", "write both"));
    }
    if channel.special.curve.control.is_empty() {
        let here = target::here(&channel.modal, &channel.standing);
        let weight = weight.filter(|_| !has[0]).unwrap_or(1.0);
        channel.special.curve.order = 3;
        channel.special.curve.control.push(Control { at: [here[Axis::X], here[Axis::Y]], weight });
    } else if !has[0] {
        let message = "a control point without X and Y";
        return Err(bad_value(gathered.span, message, "P without X and Y is allowed only in the first block of G5.2"));
    }
    if let Some(order) = order.filter(|order| *order > 3.0) {
        if order > MOST_ORDER || order.fract() != 0.0 {
            return Err(bad_value(gathered.span_of(b'L'), format!("L{order} is not a valid curve order"), "check L"));
        }
        // Between 4 and the limit.
        channel.special.curve.order = order as usize;
    }
    if has[0] {
        let (end, _) = step::end(channel, gathered)?;
        let Some(weight) = weight.filter(|weight| *weight > 0.0) else {
            let message = "a control point of G5.2 without a weight above 0";
            return Err(bad_value(gathered.span, message, "write P with the weight, 1 for none"));
        };
        if channel.special.curve.control.len() >= MOST_POINTS {
            let message = format!("a curve of more than {MOST_POINTS} control points");
            return Err(fault(Code::NOT_SUPPORTED, gathered.span, message, "end it with G5.3 earlier"));
        }
        channel.special.curve.control.push(Control { at: [end[Axis::X], end[Axis::Y]], weight });
    }
    Ok(())
}

/// `G5.3`: the curve is complete.
pub(super) fn nurbs_end(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let curve = std::mem::take(&mut channel.special.curve);
    channel.special.curve.onwards = curve.onwards;
    let is_open = std::mem::replace(&mut channel.modal.modes.motion, G80) == 52;
    if !is_open || curve.control.is_empty() {
        return Err(bad_value(gathered.span, "G5.3 without G5.2", "begin the curve with G5.2"));
    }
    let curve = Nurbs::new(curve.control, curve.order).map_err(|found| no_curve(found, gathered.span))?;
    along(channel, &curve, gathered)
}

/// Drops a curve that another motion mode interrupts.
pub(super) fn drop_curve(special: &mut Special, code: u16) {
    if code != 52 {
        special.curve.control.clear();
    }
}

/// Moves along a curve.
fn along(channel: &mut Channel<'_>, curve: &Nurbs, gathered: &Gathered) -> Result<(), Fault> {
    let here = target::here(&channel.modal, &channel.standing);
    let setup = Shared::clone(&channel.standing.setup);
    let pieces = curve
        .pieces(channel.settings.machine.control.chord_tolerance_mm)
        .map_err(|found| no_curve(found, gathered.span))?;
    let named: AxisSet = [Axis::X, Axis::Y].into_iter().collect();
    let mut ends: Vec<AxisVector> = Vec::with_capacity(pieces.len());
    for [x, y] in pieces {
        let mut place = here;
        place[Axis::X] = x;
        place[Axis::Y] = y;
        ends.push(step::reach(&channel.modal, &setup, named, &place, gathered.span)?);
    }
    let target = ends.last().copied().unwrap_or(channel.modal.position.command);
    let (feed_named, span) = (gathered.has(b'F'), gathered.span);
    let step = Step { rapid: false, end: here, named, feed_named, motion_mode: MotionMode::Path, span };
    step::send(channel, step, target, Shape::Chords(ends), setup)
}

fn check_curve(strict: bool, language: Language, modal: &Modal, gathered: &Gathered, code: u16) -> Result<(), Fault> {
    let (name, span) = (name_of(code), gathered.span);
    forbidden::no_compensation(language, modal, span, &name)?;
    if modal.modes.plane != Plane::XY {
        let message = format!("{name} outside the XY plane");
        return Err(fault(Code::NOT_SUPPORTED, span, message, "select G17"));
    }
    let plane: AxisSet = [Axis::X, Axis::Y].into_iter().collect();
    if let Some(axis) = gathered.axes.difference(plane).iter().next() {
        let message = format!("{name} moves X and Y only");
        return Err(bad_value(gathered.span_of(axis.letter()), message, "move the axis in its own block"));
    }
    special::check_plane_stated(strict, modal, plane, span)
}

fn plus(place: [f64; 2], way: [f64; 2]) -> [f64; 2] {
    [place[0] + way[0], place[1] + way[1]]
}

fn no_curve(found: NurbsFault, span: Span) -> Fault {
    let message = match found {
        NurbsFault::TooFew => "the curve has fewer control points than its order (L)",
        NurbsFault::TooMany => "the curve has too many control points",
        NurbsFault::BadValue => "a control point has a weight that is not above 0, or a value that is not a number",
        NurbsFault::TooFine => "the curve needs too many straight pieces",
    };
    bad_value(span, message, "check its points and weights, and control.chord_tolerance_mm")
}
