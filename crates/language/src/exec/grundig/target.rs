//! Target of a block: Cartesian, incremental, polar and mixed words, points, the pole.

use super::channel::Channel;
use super::gathered::{Found, Gathered};
use super::modal::Modal;
use super::modal::{Point, plus};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::rollover;
use crate::exec::core::standing::InForce;
use crate::exec::core::step::Flat;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Plane;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector};
use ncfix_base::source::Span;

/// Axes of this language.
pub(super) const AXES: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C];
/// Highest number of a point.
const MOST_POINTS: f64 = 9999.0;
/// Share of the motion below which a direction cannot reach a coordinate.
const ACROSS: f64 = 1e-9;

/// Target of a block, as programmed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    pub(super) to: AxisVector,
    pub(super) named: AxisSet,
}

/// The current position as programmed.
pub(super) fn here(modal: &Modal, standing: &InForce) -> AxisVector {
    standing.setup.programmed(&modal.position.command)
}

/// Value of an axis word, mm or rad.
fn value_of(modal: &Modal, axis: Axis, value: f64) -> f64 {
    if axis.is_rotary() { modal.frames.sign(axis) * value.to_radians() } else { value * modal.modes.scale() }
}

/// The target from the words of a block. `incremental` is G91.
pub(super) fn target(channel: &mut Channel<'_>, gathered: &mut Gathered, incremental: bool) -> Result<Target, Fault> {
    let here = here(&channel.modal, &channel.standing);
    let mut out = Target { to: here, named: AxisSet::EMPTY };
    for axis in AXES {
        let words = [
            gathered.once(axis.letter(), None)?.map(|found| (found, incremental)),
            gathered.once(axis.letter(), Some(90))?.map(|found| (found, false)),
            gathered.once(axis.letter(), Some(91))?.map(|found| (found, true)),
        ];
        let mut words = words.into_iter().flatten();
        let Some(((value, span), is_relative)) = words.next() else { continue };
        if let Some(((_, span), _)) = words.next() {
            let message = format!("{axis} is programmed twice in the block");
            return Err(fault(Code::DOUBLE_WORD, span, message, "keep one of the words"));
        }
        if channel.settings.machine.axis(axis).is_none() {
            let message = format!("the machine has no axis {axis}");
            return Err(fault(Code::NO_AXIS, span, message, "check the program, or the topology of the machine"));
        }
        let own = value_of(&channel.modal, axis, value);
        if is_relative {
            check_known(channel.settings.strict, &channel.modal, axis, span)?;
        }
        out.to[axis] = if is_relative {
            here[axis] + own
        } else {
            let from = Some(here[axis]).filter(|_| channel.modal.position.known.contains(axis));
            rollover::position(channel.settings.machine, axis, own, from, span)?
        };
        out.named.insert(axis);
    }
    polar(channel.settings.strict, &channel.modal, gathered, &here, &mut out)?;
    Ok(out)
}

/// Checks that a relative word has a known start.
pub(super) fn check_known(strict: bool, modal: &Modal, axis: Axis, span: Span) -> Result<(), Fault> {
    if !strict || modal.position.known.contains(axis) {
        return Ok(());
    }
    Err(modal.position.unknown(span, axis))
}

/// Checks both axes of the plane.
pub(super) fn check_plane_known(strict: bool, modal: &Modal, span: Span) -> Result<(), Fault> {
    let [abscissa, ordinate, _] = modal.modes.plane.axes();
    check_known(strict, modal, abscissa, span)?;
    check_known(strict, modal, ordinate, span)
}

/// `B1= L1=` from here, `B2= L2=` from the pole, or one coordinate and `B1=`.
fn polar(
    strict: bool,
    modal: &Modal,
    gathered: &mut Gathered,
    here: &AxisVector,
    out: &mut Target,
) -> Result<(), Fault> {
    for index in [1, 2] {
        let (angle, length) = (gathered.once(b'B', Some(index))?, gathered.once(b'L', Some(index))?);
        let Some((_, span)) = angle.or(length) else { continue };
        if index == 1 {
            check_plane_known(strict, modal, span)?;
        }
        let place = match (angle, length) {
            (Some((angle, _)), Some((length, _))) => {
                let base = if index == 1 { here } else { &modal.pole };
                let way = modal.direction(angle);
                plus(base, &way, length * modal.modes.scale())
            }
            (Some(angle), None) if index == 1 => mixed(modal, angle, here, out)?,
            _ => {
                let message = format!("B{index}= and L{index}= define a position only together");
                return Err(fault(Code::BAD_POLAR, span, message, "program both in the block"));
            }
        };
        let [abscissa, ordinate, _] = modal.modes.plane.axes();
        let is_taken = |axis: Axis| out.named.contains(axis);
        if length.is_some() && (is_taken(abscissa) || is_taken(ordinate)) {
            let message = "a polar position and an axis of the plane in one block";
            return Err(fault(Code::BAD_POLAR, span, message, "keep one of them"));
        }
        for axis in [abscissa, ordinate] {
            out.to[axis] = place[axis];
            out.named.insert(axis);
        }
    }
    Ok(())
}

/// One coordinate of the plane and the direction towards the target.
fn mixed(modal: &Modal, (degrees, span): Found, here: &AxisVector, out: &Target) -> Result<AxisVector, Fault> {
    let [abscissa, ordinate, _] = modal.modes.plane.axes();
    let given = match [abscissa, ordinate].map(|axis| out.named.contains(axis)) {
        [true, false] => abscissa,
        [false, true] => ordinate,
        _ => {
            let message = "B1= without L1= needs exactly one axis of the plane";
            return Err(fault(Code::BAD_POLAR, span, message, "program L1=, or one coordinate"));
        }
    };
    let way = modal.direction(degrees);
    let distance = (out.to[given] - here[given]) / way[given];
    if way[given].abs() < ACROSS || distance < 0.0 {
        let message = format!("the direction B1={degrees} does not reach this {given}");
        return Err(fault(Code::BAD_POLAR, span, message, "correct the angle or the coordinate"));
    }
    let mut place = plus(here, &way, distance);
    place[given] = out.to[given];
    Ok(place)
}

/// The points that a block names, in order.
pub(super) fn points(modal: &Modal, gathered: &mut Gathered) -> Result<Vec<Point>, Fault> {
    let mut points = Vec::new();
    for item in gathered.take_all(b'P') {
        let number = point_number((item.value, item.span))?;
        let Some(point) = modal.points.get(&number) else {
            let message = format!("point P{number} has not been stored");
            return Err(fault(Code::BAD_INDEX, item.span, message, "define it first with G78"));
        };
        points.push(*point);
    }
    Ok(points)
}

/// `G78 P1 X… Y…`: stores a point.
pub(super) fn define_point(channel: &mut Channel<'_>, gathered: &mut Gathered, span: Span) -> Result<(), Fault> {
    let found = gathered.take(b'P', None).or_else(|| gathered.take(b'P', Some(1)));
    let Some(found) = found else { return Err(bad_value(span, "G78 needs P", "write for example G78 P1 X10 Y20")) };
    let number = point_number(found)?;
    let incremental = channel.modal.modes.incremental;
    let target = target(channel, gathered, incremental)?;
    channel.modal.points.insert(number, Point { values: target.to, named: target.named });
    Ok(())
}

/// `G9`: sets the pole absolutely, by polar coordinates from zero (B2, L2), or from the old pole (B1, L1).
pub(super) fn set_pole(modal: &mut Modal, gathered: &mut Gathered, span: Span) -> Result<(), Fault> {
    let scale = modal.modes.scale();
    for (index, base) in [(1, modal.pole), (2, AxisVector::ZERO)] {
        if let (Some((angle, _)), Some((length, _))) =
            (gathered.take(b'B', Some(index)), gathered.take(b'L', Some(index)))
        {
            let way = modal.direction(angle);
            modal.pole = plus(&base, &way, length * scale);
            return Ok(());
        }
    }
    let mut is_set = false;
    for axis in modal.modes.plane.axes().into_iter().take(2) {
        if let Some((value, _)) = gathered.once(axis.letter(), None)? {
            let base = if modal.modes.incremental { modal.pole[axis] } else { 0.0 };
            modal.pole[axis] = base + value * scale;
            is_set = true;
        }
    }
    if is_set {
        Ok(())
    } else {
        Err(bad_value(span, "G9 needs the position of the pole", "write for example G9 X10 Y20"))
    }
}

fn point_number((value, span): Found) -> Result<u32, Fault> {
    if value.fract() != 0.0 || !(0.0..=MOST_POINTS).contains(&value) {
        return Err(bad_value(
            span,
            format!("P{value} is not a valid point number"),
            "write a whole number from 0 to 9999",
        ));
    }
    // Within range.
    Ok(value as u32)
}

/// Plane coordinates in the order of angles: in G18 X and −Z.
pub(super) fn flat(modal: &Modal, position: &AxisVector) -> Flat {
    match modal.modes.plane {
        Plane::XY => [position[Axis::X], position[Axis::Y]],
        Plane::ZX => [position[Axis::X], -position[Axis::Z]],
        Plane::YZ => [position[Axis::Y], position[Axis::Z]],
    }
}

/// Sets plane coordinates, the inverse of [`flat`].
pub(super) fn set_flat(modal: &Modal, position: &mut AxisVector, [first, second]: Flat) {
    match modal.modes.plane {
        Plane::XY => (position[Axis::X], position[Axis::Y]) = (first, second),
        Plane::ZX => (position[Axis::X], position[Axis::Z]) = (first, -second),
        Plane::YZ => (position[Axis::Y], position[Axis::Z]) = (first, second),
    }
}
