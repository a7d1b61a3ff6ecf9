//! Converts paths of the tip in the workpiece to axis moves, for five-axis transformations.
//!
//! The tip follows the programmed path in the workpiece while the tool turns; the axes then move along curves. These are divided into pieces that are
//! linear in the axes. They are so short that the tip stays within the chord tolerance of the path at the same parameter.

use super::fault::{Fault, fault};
use super::path::{Path, Shape};
use super::sagitta;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Arc, AxisSet, AxisVector, LINEAR_AXES, Plane, Vector};
use ncfix_machine::machine::{Control, Kinematics};
use ncfix_machine::snc::{Move, Turning};

/// Positions at which a piece is compared with the path; a symmetrical curve crosses its chord at none of them.
const SAMPLES: [f64; 5] = [0.11, 0.29, 0.5, 0.73, 0.91];
/// Share of the tolerance used for divided paths, so that the same piece is not divided again in a further execution.
const PIECE_SHARE: f64 = 0.7;
/// Arm at which the orientation may deviate by the chord tolerance, mm.
const ORIENTATION_ARM_MM: f64 = 5.0;
/// Directions nearer to each other than this are equal, rad.
const SAME_DIRECTION_RAD: f64 = 1e-9;
/// Distance from a pole below which a great circle passes through it, rad.
const THROUGH_POLE_RAD: f64 = 1e-6;
/// Rotary commands nearer to each other than this are equal, rad.
const SAME_ANGLE_RAD: f64 = 1e-6;
/// Shortest piece, as a share of the path.
const SHORTEST_SHARE: f64 = 1e-6;
/// Maximum number of pieces of one path.
const MOST_PIECES: usize = 100_000;
/// Step of following a great circle to find the end of the rotary axes, rad.
const FOLLOW_RAD: f64 = 0.02;

/// Calls `out` with every axis move of a path, in order.
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
    if !needed.difference(path.start_known).is_empty() {
        // The start is unknown: only the end is defined.
        let leg = Leg { kinematics, path, start: path.start, end: path.motion.target, arc: None, great_circle: None };
        let target = leg.command_at(1.0, &path.motion.target)?;
        out(Move { target, ..path.motion });
        return Ok(());
    }
    let mut first = true;
    // `share` is the share of the path and of the time; `off_curve_mm` is the largest distance of the tip from the path.
    let mut out = |target: AxisVector, share: f64, off_curve_mm: f64| {
        let is_first = std::mem::take(&mut first);
        let named = if is_first { path.motion.named } else { AxisSet::EMPTY };
        let feed = if path.motion.is_inverse_time() { path.motion.feed / share } else { path.motion.feed };
        let feed_named = is_first && path.motion.feed_named;
        out(Move { target, named, feed, feed_named, off_curve_mm, ..path.motion });
    };
    let tolerance_mm = control.chord_tolerance_mm;
    match &path.shape {
        Shape::Chords(ends) => {
            let mut start = path.start;
            let lengths = leg_lengths(&path.start, ends);
            for (k, (&end, length)) in ends.iter().zip(lengths).enumerate() {
                let chord_mm = sagitta::off_mm(&path.start, ends, k, tolerance_mm);
                let mut out =
                    |target: AxisVector, share: f64, off_mm: f64| out(target, share * length, chord_mm + off_mm);
                Leg::new(kinematics, path, [start, end], None, turning, control)?.divide(tolerance_mm, &mut out)?;
                start = end;
            }
            Ok(())
        }
        Shape::Line => Leg::new(kinematics, path, [path.start, path.motion.target], None, turning, control)?
            .divide(tolerance_mm, &mut out),
        Shape::Arc { clockwise, center, extra_turns } => {
            let arc = Arc { plane: Plane::XY, clockwise: *clockwise, center_mm: *center, extra_turns: *extra_turns };
            Leg::new(kinematics, path, [path.start, path.motion.target], Some(arc), turning, control)?
                .divide(tolerance_mm, &mut out)
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
    let count = (circle.angle / FOLLOW_RAD).ceil().clamp(1.0, 200.0) as u32;
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

/// A straight or circular path of the tip.
struct Leg<'a> {
    kinematics: &'a Kinematics,
    path: &'a Path,
    start: AxisVector,
    end: AxisVector,
    /// In plane coordinates of the path's basis.
    arc: Option<Arc>,
    great_circle: Option<GreatCircle>,
}

impl<'a> Leg<'a> {
    fn new(
        kinematics: &'a Kinematics,
        path: &'a Path,
        [start, end]: [AxisVector; 2],
        arc: Option<Arc>,
        turning: Turning,
        control: &Control,
    ) -> Result<Leg<'a>, Fault> {
        let mut leg = Leg { kinematics, path, start, end, arc, great_circle: None };
        if turning == Turning::Axes || kinematics.rotary_axes().count() < 2 {
            return Ok(leg);
        }
        let directions = [kinematics.direction(&start), kinematics.direction(&end)];
        let Some(circle) = GreatCircle::between(&directions[0], &directions[1]) else {
            if directions[0].dot(&directions[1]) < 0.0 {
                return Err(leg
                    .through_pole("the tool turns to the opposite direction, but the plane of rotation is not given"));
            }
            return Ok(leg);
        };
        // Near the pole the control moves the rotary axes in proportion.
        if circle.begins_or_ends_near(kinematics, control.pole_limit_rad) {
            return Ok(leg);
        }
        if let Some(distance) = circle.distance_from_pole(kinematics)
            && (THROUGH_POLE_RAD..control.pole_limit_rad).contains(&distance)
        {
            let message =
                format!("the tool passes the pole of the transformation at {:.4} degrees", distance.to_degrees());
            return Err(leg.through_pole(&message));
        }
        leg.great_circle = Some(circle);
        Ok(leg)
    }

    fn through_pole(&self, message: &str) -> Fault {
        let help = "move around it, end a block at it, or program ORIAXES";
        fault(Code::THROUGH_POLE, self.path.span, message, help)
    }

    /// The position in the workpiece at a share of the path; its rotary axes are in proportion.
    fn position_at(&self, share: f64) -> AxisVector {
        if share >= 1.0 {
            return self.end;
        }
        let mut position = self.start.lerp(&self.end, share);
        if let Some(arc) = &self.arc {
            let basis = &self.path.basis;
            let flat = |position: &AxisVector| {
                let [x, y] = basis.flat(position);
                AxisVector([x, y, basis.height(position), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
            };
            let at = arc.at(&flat(&self.start), &flat(&self.end), share).xyz();
            position.set_xyz(basis.lift([at.x, at.y], at.z));
        }
        position
    }

    /// The axis command at a share of the path, with rotary axes as near as possible to `near`.
    fn command_at(&self, share: f64, near: &AxisVector) -> Result<AxisVector, Fault> {
        let mut position = self.position_at(share);
        if let Some(circle) = &self.great_circle {
            let Some(turned) = self.kinematics.orientation(&circle.at(share), near) else {
                let message = "along the path the rotary axes cannot orient the tool within their travel";
                let help = "check the directions at both ends, and the travel of the rotary axes";
                return Err(fault(Code::NO_ORIENTATION, self.path.span, message, help));
            };
            for axis in self.kinematics.rotary_axes() {
                position[axis] = turned[axis];
            }
        }
        let command = self.kinematics.command_on_workpiece(&position, &self.path.setup.tool_mm);
        command.ok_or_else(|| {
            fault(Code::NO_AXIS, self.path.span, "the machine cannot place the tip", "check the topology")
        })
    }

    /// Calls `out` with the end of every piece, its share of the path, and the distance of the tip from the path, mm.
    fn divide(&self, tolerance_mm: f64, out: &mut impl FnMut(AxisVector, f64, f64)) -> Result<(), Fault> {
        let mut command = self.command_at(0.0, &self.start)?;
        if self.is_straight_in_axes() {
            out(self.command_at(1.0, &command)?, 1.0, 0.0);
            return Ok(());
        }
        let (mut from, mut step, mut allowed) = (0.0, 1.0, tolerance_mm);
        for _ in 0..MOST_PIECES {
            let to = if from + step > 1.0 - SHORTEST_SHARE { 1.0 } else { from + step };
            let end = self.command_at(to, &command)?;
            if let Some(off_mm) = self.off_mm([from, to], [&command, &end], allowed) {
                if to >= 1.0 {
                    return self.check_end(&end).map(|()| out(end, to - from, off_mm));
                }
                out(end, to - from, off_mm);
                (from, command) = (to, end);
                step *= 1.5;
            } else {
                allowed = PIECE_SHARE * tolerance_mm;
                step = 0.5 * (to - from);
                if step < SHORTEST_SHARE {
                    break;
                }
            }
        }
        Err(self.through_pole("a rotary axis would have to jump where the tool passes the pole of the transformation"))
    }

    /// `true` if a line stays a line because the rotary axes are at rest.
    fn is_straight_in_axes(&self) -> bool {
        self.arc.is_none() && self.kinematics.rotary_axes().all(|axis| self.start[axis] == self.end[axis])
    }

    /// Distance of the tip from the path for a straight axis motion between two commands, mm; `None` if tip or tool deviate too far.
    fn off_mm(&self, [from, to]: [f64; 2], [start, end]: [&AxisVector; 2], tolerance_mm: f64) -> Option<f64> {
        let tool_mm = &self.path.setup.tool_mm;
        SAMPLES.into_iter().try_fold(0.0, |most: f64, sample| {
            let share = from + (to - from) * sample;
            let command = start.lerp(end, sample);
            let wanted = self.position_at(share);
            let off = self.kinematics.on_workpiece(&command, tool_mm).xyz() - wanted.xyz();
            let turned = self.great_circle.as_ref().map_or(0.0, |circle| {
                (self.kinematics.direction(&command) - circle.at(share)).norm() * ORIENTATION_ARM_MM
            });
            let off_mm = off.norm();
            (off_mm <= tolerance_mm && turned <= tolerance_mm).then_some(most.max(off_mm))
        })
    }

    /// Checks that the great circle leads to the programmed angles.
    fn check_end(&self, end: &AxisVector) -> Result<(), Fault> {
        let off = |axis: &ncfix_base::geometry::Axis| (end[*axis] - self.end[*axis]).abs() > SAME_ANGLE_RAD;
        match self.kinematics.rotary_axes().find(off) {
            None => Ok(()),
            Some(axis) => Err(self.through_pole(&format!(
                "along a great circle the tool arrives with {axis} at {:.4} degrees instead of {:.4}",
                end[axis].to_degrees(),
                self.end[axis].to_degrees()
            ))),
        }
    }
}

/// Directions between two directions in their common plane.
struct GreatCircle {
    start: Vector,
    /// Perpendicular to the start.
    across: Vector,
    angle: f64,
}

impl GreatCircle {
    /// `None` if both are equal or opposite.
    fn between(start: &Vector, end: &Vector) -> Option<GreatCircle> {
        let cosine = start.dot(end);
        let rest = end - start * cosine;
        let sine = rest.norm();
        (sine > SAME_DIRECTION_RAD).then(|| GreatCircle {
            start: *start,
            across: rest / sine,
            angle: sine.atan2(cosine),
        })
    }

    fn at(&self, share: f64) -> Vector {
        let (sine, cosine) = (self.angle * share).sin_cos();
        self.start * cosine + self.across * sine
    }

    fn begins_or_ends_near(&self, kinematics: &Kinematics, limit_rad: f64) -> bool {
        kinematics.pole().is_some_and(|pole| {
            [0.0, 1.0].into_iter().any(|share| pole.cross(&self.at(share)).norm() < limit_rad.sin())
        })
    }

    /// The smallest angle between the inner part of the path and a pole, if it passes one.
    fn distance_from_pole(&self, kinematics: &Kinematics) -> Option<f64> {
        let pole = kinematics.pole()?;
        let (along, across) = (pole.dot(&self.start), pole.dot(&self.across));
        // The nearest points of the whole circle to the pole and to its opposite.
        let nearest = across.atan2(along).rem_euclid(std::f64::consts::PI);
        (nearest < self.angle)
            .then(|| pole.cross(&(self.start * nearest.cos() + self.across * nearest.sin())).norm().min(1.0).asin())
    }
}
