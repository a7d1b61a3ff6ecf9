//! Splines: `ASPLINE`, `BSPLINE`, `CSPLINE`. Their blocks are held until a motion of another kind ends them, and then become chords.
//!
//! A spline through points has one piece per block. The curve of a B-spline passes only through the ends of its control polygon. It is divided
//! evenly, so that elements between blocks keep their approximate place.

use super::address::Named;
use super::channel::Channel;
use super::channel::without_end;
use super::contour_words;
use super::curve::End;
use super::gathered::Gathered;
use super::modal::{Modal, MotionKind};
use super::splines::HeldBlock;
use super::splines::MOST_HELD;
use super::splines::Node;
use super::splines::Splines;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::path::{Path, Shape};
use crate::exec::core::position::BEGIN_ABSOLUTE;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{
    Arc, AxisVector, BSpline, Bezier, CurveFault, Plane, SplineEnd, akima_slopes, cubic_slopes, weighted,
};
use ncfix_base::source::Span;
use ncfix_machine::snc::{Element, Kind};

/// Maximum number of chords of one spline.
const MOST_CHORDS: usize = 1_000_000;
/// Points nearer to each other than this are one, mm.
const SAME_POINT_MM: f64 = 1e-9;
/// Parameter step for the direction of a path.
const STEP: f64 = 1e-6;

/// The spline data of a block; `None` for other motions.
pub(super) fn node(gathered: &Gathered, modal: &Modal) -> Result<Option<Node>, Fault> {
    if !matches!(modal.modes.motion, MotionKind::Akima | MotionKind::BSpline | MotionKind::Cubic) {
        return Ok(None);
    }
    let positive = |address: Named, what: &str| match gathered.named(address) {
        None => Ok(None),
        Some(value) if value.value > 0.0 && value.value.is_finite() => Ok(Some(value.value)),
        Some(value) => Err(bad_value(value.span, format!("{what} must be above 0"), "correct the value")),
    };
    let degree = match gathered.named(Named::Sd) {
        None => None,
        Some(value) if value.value == 2.0 => Some(2),
        Some(value) if value.value == 3.0 => Some(3),
        Some(value) => return Err(bad_value(value.span, "SD must be 2 or 3", "correct the degree of the B-spline")),
    };
    Ok(Some(Node {
        kind: modal.modes.motion,
        length: positive(Named::Pl, "PL")?,
        weight: positive(Named::Pw, "PW")?.unwrap_or(1.0),
        degree,
        ends: modal.spline_ends,
    }))
}

/// The error for a curve that cannot be divided into chords.
pub(super) fn curve_fault(found: CurveFault, span: Span) -> Fault {
    match found {
        CurveFault::Nowhere => bad_value(span, "the curve goes through infinity", "check denominator and weights"),
        CurveFault::TooManyChords => {
            let message = "the curve needs too many chords";
            fault(Code::BAD_WORD_VALUE, span, message, "check its values, or raise control.chord_tolerance_mm")
        }
    }
}

/// Emits a motion, through the splines if required.
#[inline]
pub(super) fn push_path(channel: &mut Channel<'_>, path: Path, node: Option<Node>) -> Result<(), Fault> {
    if let Some(node) = node {
        let element = channel.outlet.element(Kind::Empty);
        return spline(channel, path, element, node);
    }
    let ended = if channel.splines.is_holding() { end_spline(channel, Some(&path)) } else { Ok(()) };
    note_direction(&channel.modal, &mut channel.splines, &path);
    match contour_words::wish(channel, &path) {
        None => channel.outlet.pass_plain(&path),
        Some(wish) => {
            let element = channel.outlet.element(Kind::Empty);
            contour_words::pass_path(channel, path, element, wish);
        }
    }
    ended
}

/// Takes a block of a spline.
fn spline(channel: &mut Channel<'_>, path: Path, element: Element, node: Node) -> Result<(), Fault> {
    let unknown = path.motion.named.difference(path.start_known).iter().next();
    if let Some(axis) = unknown.filter(|_| channel.settings.strict) {
        let message = format!("the position of {axis} is not known yet");
        let help = BEGIN_ABSOLUTE;
        return Err(fault(Code::UNKNOWN_START, path.span, message, help));
    }
    let other = channel.splines.held.iter().find_map(|held| match held {
        HeldBlock::Path(_, _, first, _) => Some(first.kind != node.kind),
        HeldBlock::Element(_) => None,
    });
    let found = if other == Some(true) { end_spline(channel, Some(&path)) } else { Ok(()) };
    if channel.splines.held.len() >= MOST_HELD {
        let too_long = channel.splines.hold(element);
        channel.outlet.warnings.extend(too_long);
        return found;
    }
    // The contour request of the block stays valid until the spline is complete.
    let wish = contour_words::wish(channel, &path);
    channel.splines.held.push(HeldBlock::Path(Box::new(path), element, node, wish.map(Box::new)));
    found
}

/// Records the final direction of a motion that is not a spline.
pub(super) fn note_direction(modal: &Modal, splines: &mut Splines, path: &Path) {
    if modal.spline_ends[0] == End::Tangent {
        splines.before = direction(path, [1.0 - STEP, 1.0]);
    }
}

/// Emits the held spline as moves; `next` is the motion after it.
pub(super) fn end_spline(channel: &mut Channel<'_>, next: Option<&Path>) -> Result<(), Fault> {
    let mut held = std::mem::take(&mut channel.splines.held);
    let tolerance_mm = channel.settings.machine.control.chord_tolerance_mm;
    let behind = next.and_then(|path| direction(path, [0.0, STEP]));
    let before = channel.splines.before;
    let mut blocks: Vec<(&mut Path, Node)> = held
        .iter_mut()
        .filter_map(|held| match held {
            HeldBlock::Path(path, _, node, _) => Some((&mut **path, *node)),
            HeldBlock::Element(_) => None,
        })
        .collect();
    match blocks.first().map(|(_, node)| node.kind) {
        Some(MotionKind::BSpline) => along_b_spline(&mut blocks, tolerance_mm)?,
        Some(_) => through_points(&mut blocks, [before, behind], tolerance_mm)?,
        None => {}
    }
    for held in held {
        match held {
            HeldBlock::Element(element) => channel.outlet.pass(element),
            HeldBlock::Path(path, element, _, wish) => {
                note_direction(&channel.modal, &mut channel.splines, &path);
                let wish = wish.map(|wish| *wish);
                let wish = if wish.is_none() && channel.outlet.is_holding() {
                    contour_words::wish(channel, &path)
                } else {
                    wish
                };
                match wish {
                    None => channel.outlet.resolve(&path, element),
                    Some(wish) => contour_words::pass_path(channel, *path, element, wish),
                }
            }
        }
    }
    Ok(())
}

/// The direction of a path between two of its shares; `None` if it does not move.
fn direction(path: &Path, [from, to]: [f64; 2]) -> Option<AxisVector> {
    let (start, end) = (path.start, path.motion.target);
    let way = match &path.shape {
        Shape::Line => end - start,
        Shape::Arc { clockwise, center, extra_turns } => {
            let arc = Arc { plane: Plane::XY, clockwise: *clockwise, center_mm: *center, extra_turns: *extra_turns };
            let flat = |position: &AxisVector| {
                let [x, y] = path.basis.flat(position);
                AxisVector([x, y, path.basis.height(position), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
            };
            let [a, b] = [from, to].map(|share| {
                let at = arc.at(&flat(&start), &flat(&end), share).xyz();
                let mut out = start.lerp(&end, share);
                out.set_xyz(path.basis.lift([at.x, at.y], at.z));
                out
            });
            b - a
        }
        Shape::Chords(ends) if to >= 1.0 => {
            let last_but_one = ends.iter().rev().nth(1).unwrap_or(&start);
            end - *last_but_one
        }
        Shape::Chords(ends) => *ends.first()? - start,
    };
    let length = way.xyz().norm();
    (length > 0.0).then(|| AxisVector(way.0.map(|part| part / length)))
}

/// Assigns curves to the blocks of an Akima or cubic spline.
fn through_points(
    blocks: &mut [(&mut Path, Node)],
    neighbors: [Option<AxisVector>; 2],
    tolerance_mm: f64,
) -> Result<(), Fault> {
    let (mut chords, mut lengths, mut curved) = (Vec::new(), Vec::new(), Vec::new());
    for (place, (path, node)) in blocks.iter().enumerate() {
        let way = path.motion.target - path.start;
        let linear_mm = AxisVector(way.0.map(|part| part * part)).0[..6].iter().sum::<f64>().sqrt();
        let rotary = way.0[6..].iter().map(|part| part.to_degrees().powi(2)).sum::<f64>().sqrt();
        let length = if linear_mm > SAME_POINT_MM { linear_mm } else { rotary };
        if length > SAME_POINT_MM {
            let step = node.length.unwrap_or(length);
            chords.push(AxisVector(way.0.map(|part| part / step)));
            lengths.push(step);
            curved.push(place);
        }
    }
    let (Some((_, first)), Some((_, last))) = (blocks.first(), blocks.last()) else { return Ok(()) };
    let speed = |chord: Option<&AxisVector>| chord.map_or(1.0, |chord| chord.xyz().norm());
    let end = |end: End, neighbor: Option<AxisVector>, speed: f64| match (end, neighbor) {
        (End::Tangent, Some(unit)) => SplineEnd::Tangent(AxisVector(unit.0.map(|part| part * speed))),
        (End::Automatic, _) => SplineEnd::Automatic,
        _ => SplineEnd::Natural,
    };
    let ends = [
        end(first.ends[0], neighbors[0], speed(chords.first())),
        end(last.ends[1], neighbors[1], speed(chords.last())),
    ];
    let slopes = match first.kind {
        MotionKind::Akima => akima_slopes(&chords, &lengths, ends),
        _ => cubic_slopes(&chords, &lengths, ends),
    };
    let mut budget = MOST_CHORDS;
    for ((slopes, length), place) in slopes.windows(2).zip(lengths).zip(curved) {
        let (Some((path, _)), [from, to]) = (blocks.get_mut(place), slopes) else { continue };
        let derivatives = [from, to].map(|slope| AxisVector(slope.0.map(|part| part * length)));
        let curve = Bezier::hermite([&path.start, &path.motion.target], [&derivatives[0], &derivatives[1]]);
        let mut points = Vec::new();
        if let Some(curve) = curve {
            let cut = curve.chords(tolerance_mm, &mut budget, &mut |point| points.push(point));
            cut.map_err(|found| curve_fault(found, path.span))?;
        }
        points.push(path.motion.target);
        path.shape = Shape::Chords(points);
    }
    Ok(())
}

/// Assigns each block of a B-spline its share of the curve.
fn along_b_spline(blocks: &mut [(&mut Path, Node)], tolerance_mm: f64) -> Result<(), Fault> {
    let (Some((first, _)), Some((last, _))) = (blocks.first(), blocks.last()) else { return Ok(()) };
    let (start, target) = (first.start, last.motion.target);
    let mut steps = blocks.iter().map(|(path, node)| (node.length.unwrap_or(1.0), path.span));
    let step = steps.next().map_or(1.0, |(step, _)| step);
    if let Some((_, span)) = steps.find(|(other, _)| *other != step) {
        let message = "a B-spline with unequal knot intervals (PL)";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "give all blocks the same PL, or none"));
    }
    let degree = blocks.iter().find_map(|(_, node)| node.degree).unwrap_or(3);
    let control = blocks.iter().map(|(path, node)| weighted(&path.motion.target, node.weight));
    let Some(spline) = BSpline::new(degree, std::iter::once(weighted(&start, 1.0)).chain(control).collect()) else {
        return Ok(());
    };
    let share = spline.pieces() as f64 / blocks.len() as f64;
    let count = blocks.len();
    let mut budget = MOST_CHORDS;
    let mut here = start;
    for (k, (path, _)) in blocks.iter_mut().enumerate() {
        let (mut from, to) = (k as f64 * share, (k + 1) as f64 * share);
        let mut points = Vec::new();
        while from < to {
            // Up to the next knot; a tiny remainder belongs to the part before it.
            let knot = (from + STEP).floor() + 1.0;
            let until = if knot > to - STEP { to } else { knot };
            if let Some(curve) = spline.part(from, until) {
                let cut = curve.chords(tolerance_mm, &mut budget, &mut |point| points.push(point));
                cut.map_err(|found| curve_fault(found, path.span))?;
                points.push(curve.at(1.0));
            }
            from = until;
        }
        if k + 1 == count {
            points.pop();
            points.push(target);
        }
        path.start = here;
        here = points.last().copied().unwrap_or(here);
        path.motion.target = here;
        path.shape = Shape::Chords(points);
    }
    Ok(())
}

/// Emits what is held back.
pub(super) fn finish(channel: &mut Channel<'_>) {
    let ended = end_spline(channel, None);
    channel.outlet.warnings.extend(ended.err());
    channel.outlet.warnings.extend(channel.open_angle.take().map(|open| without_end(open.span())));
    channel.outlet.finish();
}
