//! Paths of the tip in the workpiece, for five-axis transformations.
//!
//! A line or an arc of the tip, with the tool turning on the way, is one move: the control interpolates it as [`TipPath`]. A curve
//! of other kind is already divided into chords, which are lines of the tip.

use super::fault::{Fault, fault};
use super::path::{Path, Shape, tilted_arc};
use super::sagitta;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Arc, Axis, AxisSet, AxisVector, LINEAR_AXES, Matrix, Vector};
use ncfix_machine::machine::{Control, GreatCircle, Kinematics, TipPath};
use ncfix_machine::snc::{Move, Turning};

/// Rotary commands nearer to each other than this are equal, rad.
const SAME_ANGLE_RAD: f64 = 1e-6;
/// Step of following a great circle to find the end of the rotary axes, rad.
const FOLLOW_RAD: f64 = 0.02;
/// Maximum number of such steps: half a turn has 158.
const MOST_STEPS: f64 = 200.0;

/// Calls `out` with every move of a path, in order.
///
/// # Errors
/// A fault if a direction is unreachable or the path passes a pole.
pub(in crate::exec) fn moves(
    kinematics: &Kinematics,
    turning: Turning,
    path: &Path,
    control: &Control,
    mut out: impl FnMut(Move),
) -> Result<(), Fault> {
    let needed: AxisSet = LINEAR_AXES.into_iter().take(3).chain(kinematics.rotary_axes()).collect();
    let legs = Legs { kinematics, turning, path };
    if !needed.difference(path.start_known).is_empty() {
        // The start is unknown: only the end is defined.
        out(Move { target: legs.command(&path.motion.target)?, ..path.motion });
        return Ok(());
    }
    let mut start = (path.start, legs.command(&path.start)?);
    let mut first = true;
    // `share` is the share of the path and of the time; `off_curve_mm` is the largest distance of the curve from the move.
    let mut leg =
        |end: AxisVector, arc: Option<(Arc, Option<Matrix>)>, share: f64, off_curve_mm: f64| -> Result<(), Fault> {
            let target = legs.command(&end)?;
            let is_first = std::mem::take(&mut first);
            let named = if is_first { path.motion.named } else { AxisSet::EMPTY };
            let feed = if path.motion.is_inverse_time() { path.motion.feed / share } else { path.motion.feed };
            let feed_named = is_first && path.motion.feed_named;
            let tip = legs.tip([&start.0, &end], [&start.1, &target], arc.is_some())?;
            let (arc, arc_basis) = arc.map_or((None, None), |(arc, basis)| (Some(arc), basis));
            out(Move { target, arc, arc_basis, tip, named, feed, feed_named, off_curve_mm, ..path.motion });
            start = (end, target);
            Ok(())
        };
    let tolerance_mm = control.chord_tolerance_mm;
    match &path.shape {
        Shape::Line => leg(path.motion.target, None, 1.0, 0.0),
        Shape::Chords(ends) => {
            let lengths = leg_lengths(&path.start, ends);
            for (k, (&end, length)) in ends.iter().zip(lengths).enumerate() {
                leg(end, None, length, sagitta::off_mm(&path.start, ends, k, tolerance_mm))?;
            }
            Ok(())
        }
        Shape::Arc { clockwise, center, extra_turns } => {
            match path.basis.principal_arc(*clockwise, *center, *extra_turns) {
                Some(arc) => leg(path.motion.target, Some((arc, None)), 1.0, 0.0),
                None => {
                    let arc = tilted_arc(&path.basis, *clockwise, *center, *extra_turns);
                    leg(path.motion.target, Some(arc), 1.0, 0.0)
                }
            }
        }
    }
}

/// The rotary commands at the end of a path that turns the tool to a direction; `None` if unreachable.
///
/// If the tool follows a great circle, the rotary axes follow it without a jump; otherwise they take the shortest direction.
pub(in crate::exec) fn turned_to(
    kinematics: &Kinematics,
    turning: Turning,
    path: &Path,
    direction: &Vector,
) -> Option<AxisVector> {
    let start = path.start;
    let shortest = kinematics.orientation(direction, &start)?;
    let known = kinematics.rotary_axes().all(|axis| path.start_known.contains(axis));
    if turning == Turning::Axes || !known {
        return Some(shortest);
    }
    let Some(circle) = GreatCircle::between(&kinematics.direction(&start), direction) else { return Some(shortest) };
    if circle.begins_or_ends_near(kinematics, SAME_ANGLE_RAD) {
        return Some(shortest);
    }
    // Between 1 and 158 steps.
    let count = (circle.angle_rad() / FOLLOW_RAD).ceil().clamp(1.0, 200.0) as u32;
    (1..=count).try_fold(start, |near, k| kinematics.orientation(&circle.at(f64::from(k) / f64::from(count)), &near))
}

/// Distributes the motion of the rotary axes over chords in proportion to their number.
pub(in crate::exec) fn spread_rotaries(
    kinematics: &Kinematics,
    start: &AxisVector,
    target: &AxisVector,
    ends: &mut [AxisVector],
) {
    let count = ends.len() as f64;
    for (k, end) in ends.iter_mut().enumerate() {
        let share = (k + 1) as f64 / count;
        for axis in kinematics.rotary_axes() {
            end[axis] = start[axis] + (target[axis] - start[axis]) * share;
        }
    }
}

/// Lengths of chords as shares of their sum; equal shares if nothing moves.
fn leg_lengths(start: &AxisVector, ends: &[AxisVector]) -> Vec<f64> {
    let starts = std::iter::once(start).chain(ends);
    let lengths: Vec<f64> = starts.zip(ends).map(|(from, to)| (to.xyz() - from.xyz()).norm()).collect();
    let sum: f64 = lengths.iter().sum();
    let is_long = sum > 0.0 && lengths.iter().all(|length| *length > 0.0);
    lengths.iter().map(|length| if is_long { length / sum } else { 1.0 / ends.len() as f64 }).collect()
}

/// The parts of a path of the tip.
struct Legs<'a> {
    kinematics: &'a Kinematics,
    turning: Turning,
    path: &'a Path,
}

impl Legs<'_> {
    fn through_pole(&self, message: &str) -> Fault {
        let help = "move around it, end a block at it, or program ORIAXES";
        fault(Code::THROUGH_POLE, self.path.span, message, help)
    }

    /// The axis command of a position in the workpiece.
    fn command(&self, position: &AxisVector) -> Result<AxisVector, Fault> {
        let command = self.kinematics.command_on_workpiece(position, &self.path.setup.tool_mm);
        command.ok_or_else(|| {
            fault(Code::NO_AXIS, self.path.span, "the machine cannot place the tip", "check the topology")
        })
    }

    /// The turning of a move between two positions in the workpiece with these axis commands; `None` if the axes move in proportion.
    fn tip(
        &self,
        [start, end]: [&AxisVector; 2],
        commands: [&AxisVector; 2],
        is_arc: bool,
    ) -> Result<Option<Turning>, Fault> {
        let turns = self.kinematics.rotary_axes().any(|axis| start[axis] != end[axis]);
        if !turns {
            return Ok(is_arc.then_some(Turning::Axes));
        }
        if self.turning == Turning::Axes || self.kinematics.rotary_axes().count() < 2 {
            return Ok(Some(Turning::Axes));
        }
        let directions = [start, end].map(|position| self.kinematics.direction(position));
        let path = TipPath::new(self.kinematics, true, commands, &self.path.setup.tool_mm);
        let Some(circle) = path.circle() else {
            let is_opposite = GreatCircle::between(&directions[0], &directions[1]).is_none()
                && directions[0].dot(&directions[1]) < 0.0;
            if is_opposite {
                return Err(self
                    .through_pole("the tool turns to the opposite direction, but the plane of rotation is not given"));
            }
            // Near and through the pole the control moves the rotary axes in proportion.
            return Ok(Some(Turning::Axes));
        };
        if let Some(distance) = circle.distance_from_pole(self.kinematics)
            && distance < self.kinematics.pole_limit_rad()
        {
            let message =
                format!("the tool passes the pole of the transformation at {:.4} degrees", distance.to_degrees());
            return Err(self.through_pole(&message));
        }
        self.follow(&path, circle, [start, end])?;
        Ok(Some(Turning::Vector))
    }

    /// Follows a great circle without a jump of the rotary axes; a fault if they do not arrive at the programmed angles.
    fn follow(&self, path: &TipPath<'_>, circle: &GreatCircle, [start, end]: [&AxisVector; 2]) -> Result<(), Fault> {
        // The clamp keeps it between 1 and the limit.
        let count = (circle.angle_rad() / FOLLOW_RAD).ceil().clamp(1.0, MOST_STEPS) as u32;
        let is_near = |one: &AxisVector, other: &AxisVector| {
            self.kinematics.rotary_axes().all(|axis| (one[axis] - other[axis]).abs() <= SAME_ANGLE_RAD)
        };
        let mut near = *start;
        for k in 1..=count {
            let share = f64::from(k) / f64::from(count);
            let Some(turned) = self.kinematics.orientation(&circle.at(share), &near) else {
                let message = "along the path the rotary axes cannot orient the tool within their travel";
                let help = "check the directions at both ends, and the travel of the rotary axes";
                return Err(fault(Code::NO_ORIENTATION, self.path.span, message, help));
            };
            near = turned;
            if k < count && !is_near(&near, &path.command(&start.lerp(end, share), share)) {
                let message = "a rotary axis would have to jump where the tool passes the pole of the transformation";
                return Err(self.through_pole(message));
            }
        }
        let off = |axis: &Axis| (near[*axis] - end[*axis]).abs() > SAME_ANGLE_RAD;
        match self.kinematics.rotary_axes().find(off) {
            None => Ok(()),
            Some(axis) => Err(self.through_pole(&format!(
                "along a great circle the tool arrives with {axis} at {:.4} degrees instead of {:.4}",
                near[axis].to_degrees(),
                end[axis].to_degrees()
            ))),
        }
    }
}
