//! Path of the tool tip in the workpiece while the tool turns, as a control with a five-axis transformation interpolates it.
//!
//! Positions are those of [`Kinematics::on_workpiece`]. X, Y and Z of the position are interpolated along a line or an arc. The rotary axes move in proportion,
//! or the tool follows a great circle. The axes then move along curves.

use super::Kinematics;
use ncfix_base::geometry::{Arc, AxisVector, Matrix, Vector};

/// Positions at which a chord is compared with the path; a symmetrical curve crosses its chord at none of them.
const SAMPLES: [f64; 5] = [0.11, 0.29, 0.5, 0.73, 0.91];
/// Arm at which the orientation may deviate by the chord tolerance, mm.
const ORIENTATION_ARM_MM: f64 = 5.0;
/// Shortest chord, as a share of the path.
const SHORTEST_SHARE: f64 = 1e-6;
/// Maximum number of chords of one path.
const MOST_CHORDS: usize = 100_000;
/// Directions nearer to each other than this are equal, rad.
const SAME_DIRECTION_RAD: f64 = 1e-9;
/// Distance from a pole below which a great circle passes through it, rad: a correction tilts the tool by less.
const THROUGH_POLE_RAD: f64 = 1e-3;
/// Shares at which the rotary axes in proportion are compared with a great circle through the pole.
const CROSSING_SHARES: [f64; 3] = [0.25, 0.5, 0.75];
/// Growth of the next chord after one within the tolerance, and the share of a chord that exceeds it.
const GROWTH: f64 = 1.5;
const SHRINKAGE: f64 = 0.5;

/// An arc in positions fixed to the workpiece, with orthonormal columns along which its coordinates count if its plane is tilted.
pub type TipArc<'a> = Option<(&'a Arc, Option<&'a Matrix>)>;

/// Straight or circular path of the tip between two axis commands.
#[derive(Clone, Copy, Debug)]
pub struct TipPath<'k> {
    kinematics: &'k Kinematics,
    /// From the spindle gauge point to the tip, in F at the zero pose, mm.
    tool_mm: Vector,
    /// Positions fixed to the workpiece at both ends, mm and rad.
    ends: [AxisVector; 2],
    circle: Option<GreatCircle>,
}

impl<'k> TipPath<'k> {
    /// Creates the path between two axis commands with a tool. If the tool `follows_circle`, it keeps to the plane of both directions, except near a pole, where
    /// the control moves the rotary axes in proportion. It does so too on a circle through the pole, which turns only one axis.
    #[must_use]
    pub fn new(
        kinematics: &'k Kinematics,
        follows_circle: bool,
        commands: [&AxisVector; 2],
        tool_mm: &Vector,
    ) -> TipPath<'k> {
        let ends = commands.map(|command| kinematics.on_workpiece(command, tool_mm));
        let mut path = TipPath { kinematics, tool_mm: *tool_mm, ends, circle: None };
        if follows_circle && path.turns() && kinematics.rotary_axes().count() >= 2 {
            let [start, end] = commands.map(|command| kinematics.direction(command));
            path.circle = GreatCircle::between(&start, &end).filter(|circle| {
                !circle.begins_or_ends_near(kinematics, kinematics.pole_limit_rad())
                    && !path.crosses_pole(circle, commands)
            });
        }
        path
    }

    /// Returns `true` if a great circle passes through a pole, and the rotary axes in proportion keep to it.
    fn crosses_pole(&self, circle: &GreatCircle, [start, end]: [&AxisVector; 2]) -> bool {
        circle.distance_from_pole(self.kinematics).is_some_and(|distance| distance < THROUGH_POLE_RAD)
            && CROSSING_SHARES.iter().all(|&share| {
                let direction = self.kinematics.direction(&start.lerp(end, share));
                circle.off_plane(&direction) < THROUGH_POLE_RAD && circle.is_between(&direction)
            })
    }

    /// Returns the positions fixed to the workpiece at both ends, mm and rad.
    #[must_use]
    pub fn ends(&self) -> &[AxisVector; 2] {
        &self.ends
    }

    /// Returns the great circle that the tool follows; `None` if the rotary axes move in proportion.
    #[must_use]
    pub fn circle(&self) -> Option<&GreatCircle> {
        self.circle.as_ref()
    }

    /// Returns `true` if a rotary axis moves.
    #[must_use]
    pub fn turns(&self) -> bool {
        let [start, end] = &self.ends;
        self.kinematics.rotary_axes().any(|axis| start[axis] != end[axis])
    }

    /// Returns the largest turn of a rotary axis or of the tool, rad.
    #[must_use]
    pub fn turn_rad(&self) -> f64 {
        let [start, end] = &self.ends;
        let turn = self.kinematics.rotary_axes().map(|axis| (end[axis] - start[axis]).abs()).fold(0.0, f64::max);
        self.circle.map_or(turn, |circle| turn.max(circle.angle_rad()))
    }

    /// Returns the axis command of a position on the workpiece at a share (0 … 1) of the path. The rotary axes of `position` are in proportion.
    #[must_use]
    pub fn command(&self, position: &AxisVector, share: f64) -> AxisVector {
        let mut position = *position;
        if let Some(circle) = &self.circle
            && let Some(turned) = self.kinematics.orientation(&circle.at(share), &position)
        {
            for axis in self.kinematics.rotary_axes() {
                position[axis] = turned[axis];
            }
        }
        // The execution refuses a transformation on machines without X, Y or Z.
        self.kinematics.command_on_workpiece(&position, &self.tool_mm).unwrap_or(position)
    }

    /// Returns the position on the workpiece at a share of the path along a line or an arc of these positions.
    fn position(&self, arc: TipArc<'_>, share: f64) -> AxisVector {
        let [start, end] = &self.ends;
        match arc {
            Some((arc, None)) => arc.at(start, end, share),
            Some((arc, Some(basis))) => {
                let [from, to] = [start, end].map(|end| {
                    let mut flat = *end;
                    flat.set_xyz(basis.tr_mul(&end.xyz()));
                    flat
                });
                let mut out = arc.at(&from, &to, share);
                out.set_xyz(basis * out.xyz());
                out
            }
            None if share >= 1.0 => *end,
            None => start.lerp(end, share),
        }
    }

    /// Divides the path into chords that are straight in the axes. Calls `out` with the command at the end of each chord, its share of the path, and the largest
    /// distance of the tip from the path at the same parameter, mm. This distance is within the tolerance, except for a path that jumps.
    pub fn divide(&self, arc: TipArc<'_>, tolerance_mm: f64, mut out: impl FnMut(AxisVector, f64, f64)) {
        let command_at = |share: f64| self.command(&self.position(arc, share), share);
        let mut command = command_at(0.0);
        let (mut from, mut step) = (0.0, 1.0);
        for _ in 0..MOST_CHORDS {
            let to = if from + step > 1.0 - SHORTEST_SHARE { 1.0 } else { from + step };
            let end = command_at(to);
            let off_mm = self.off_mm(arc, [from, to], [&command, &end]);
            if off_mm <= tolerance_mm || step < SHORTEST_SHARE {
                out(end, to - from, off_mm);
                if to >= 1.0 {
                    return;
                }
                (from, command) = (to, end);
                step *= GROWTH;
            } else {
                step = SHRINKAGE * (to - from);
            }
        }
        out(command_at(1.0), 1.0 - from, 0.0);
    }

    /// Returns the distance of the tip from the path for a straight motion of the axes, mm, or that of the orientation at its arm if it is larger.
    fn off_mm(&self, arc: TipArc<'_>, [from, to]: [f64; 2], [start, end]: [&AxisVector; 2]) -> f64 {
        SAMPLES.into_iter().fold(0.0, |most: f64, sample| {
            let share = from + (to - from) * sample;
            let command = start.lerp(end, sample);
            let tip = self.kinematics.on_workpiece(&command, &self.tool_mm).xyz();
            let off_mm = (tip - self.position(arc, share).xyz()).norm();
            let turned = self.circle.map_or(0.0, |circle| {
                (self.kinematics.direction(&command) - circle.at(share)).norm() * ORIENTATION_ARM_MM
            });
            most.max(off_mm).max(turned)
        })
    }
}

/// The shorter arc between two directions on the unit sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GreatCircle {
    start: Vector,
    /// Perpendicular to the start.
    across: Vector,
    angle_rad: f64,
}

impl GreatCircle {
    /// Creates the arc between two unit vectors; `None` if both are equal or opposite.
    #[must_use]
    pub fn between(start: &Vector, end: &Vector) -> Option<GreatCircle> {
        let cosine = start.dot(end);
        let rest = end - start * cosine;
        let sine = rest.norm();
        (sine > SAME_DIRECTION_RAD).then(|| GreatCircle {
            start: *start,
            across: rest / sine,
            angle_rad: sine.atan2(cosine),
        })
    }

    /// Returns the angle between both directions, rad.
    #[must_use]
    pub fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// Returns the direction at a share (0 … 1) of the arc.
    #[must_use]
    pub fn at(&self, share: f64) -> Vector {
        let (sine, cosine) = (self.angle_rad * share).sin_cos();
        self.start * cosine + self.across * sine
    }

    /// Returns the angle between a direction and the plane of the arc, rad.
    #[must_use]
    pub fn off_plane(&self, direction: &Vector) -> f64 {
        self.start.cross(&self.across).dot(direction).abs().min(1.0).asin()
    }

    /// Returns `true` if a direction, projected onto the plane, is within the arc.
    #[must_use]
    pub fn is_between(&self, direction: &Vector) -> bool {
        (0.0..=self.angle_rad).contains(&self.across.dot(direction).atan2(self.start.dot(direction)))
    }

    /// Returns `true` if one of its ends is nearer than `limit_rad` to the direction at which a rotary axis has no effect.
    #[must_use]
    pub fn begins_or_ends_near(&self, kinematics: &Kinematics, limit_rad: f64) -> bool {
        kinematics.pole().is_some_and(|pole| {
            [0.0, 1.0].into_iter().any(|share| pole.cross(&self.at(share)).norm() < limit_rad.sin())
        })
    }

    /// Returns the smallest angle between the inner part of the arc and a pole, rad, if it passes one.
    #[must_use]
    pub fn distance_from_pole(&self, kinematics: &Kinematics) -> Option<f64> {
        let pole = kinematics.pole()?;
        let (along, across) = (pole.dot(&self.start), pole.dot(&self.across));
        // The nearest points of the whole circle to the pole and to its opposite.
        let nearest = across.atan2(along).rem_euclid(std::f64::consts::PI);
        (nearest < self.angle_rad)
            .then(|| pole.cross(&(self.start * nearest.cos() + self.across * nearest.sin())).norm().min(1.0).asin())
    }
}
