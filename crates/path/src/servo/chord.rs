//! Cuts moves into straight pieces in axis space, with the limits of the axes along each.
//!
//! The size of a piece is its length in axis space, rotary axes at an arm of 100 mm; all speeds here are size per time. The feed of a program refers
//! to the linear axes, under a five-axis transformation to the tip in the workpiece. If only rotary axes move, it is in degrees per minute.

use std::f64::consts::TAU;

use ncfix_base::geometry::{AXES, AXIS_COUNT, Arc, AxisVector, Matrix, Vector};
use ncfix_machine::machine::{Kinematics, Servo};

/// Radians of a rotary axis count as mm at this arm.
const ARM_MM: f64 = 100.0;
/// Largest distance of a chord from its arc or tip path, mm: well below the contouring accuracy of axes.
const SAG_MM: f64 = 5e-5;
/// Largest turn of rotary axes in one chord, rad, before the path of the tip is checked.
const LONGEST_TURN: f64 = 0.2;
/// Moves shorter than this take no time, mm.
const SHORTEST_MM: f64 = 1e-7;
/// Shorter paths have no feed, mm.
const NO_WAY_MM: f64 = 1e-9;
/// Maximum number of chords of one move: an invalid number must not exhaust memory and time.
const MOST_CHORDS: f64 = 1e6;
/// Lowest speed, mm/s: a feed of 0 would never end.
const SLOWEST: f64 = 1e-4;

/// A move to be executed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoMove {
    /// Axis commands at its end.
    pub target: AxisVector,
    /// The circle of an arc; `None` for a straight move of all axes.
    pub circle: Option<SpaceCircle>,
    /// Feed, time or rapid.
    pub pace: MoveSpeed,
    /// `true` if the feed refers to the tip in the workpiece.
    pub is_tip_feed: bool,
    /// Identifier of the block in the results.
    pub block: u64,
}

/// A circle in the space of X, Y and Z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceCircle {
    /// A point on its axis, mm.
    pub center: Vector,
    /// Unit vector: the move turns about it by the right-hand rule.
    pub normal: Vector,
    /// Full turns beyond the arc itself.
    pub extra_turns: u32,
}

/// The speed of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoveSpeed {
    /// As fast as the axes allow.
    Rapid,
    /// The feed, mm/s or degrees per second.
    Feed(f64),
    /// The time of the move, s.
    Time(f64),
}

/// A straight piece of axis space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    pub(super) start: AxisVector,
    /// Change of each axis per mm of size.
    pub(super) slope: AxisVector,
    /// Four times the distance of the arc's middle from its chord, mm.
    pub(super) bulge_mm: Vector,
    /// The tip in the workpiece at both ends, mm.
    pub(super) tips: [Vector; 2],
    pub(super) block: u64,
    pub(super) is_rapid: bool,
    pub(super) size: f64,
    /// Highest speed and acceleration, in size.
    pub(super) speed: f64,
    pub(super) acceleration: f64,
    /// mm (degrees) of feed per mm of size.
    pub(super) feed_share: f64,
}

impl Chord {
    /// The position at a distance along the chord: on the arc, within its parabolic approximation.
    pub(super) fn at(&self, way: f64) -> AxisVector {
        let mut position = self.start;
        for (value, slope) in position.0.iter_mut().zip(self.slope.0) {
            *value += slope * way;
        }
        let share = way / self.size;
        position.set_xyz(position.xyz() + self.bulge_mm * (share * (1.0 - share)));
        position
    }
}

impl SpaceCircle {
    /// The circle of an arc in the flat stream; `basis` are the columns along which its coordinates count, if its plane is tilted.
    #[must_use]
    pub fn of_arc(arc: &Arc, basis: Option<&Matrix>, start: &AxisVector) -> SpaceCircle {
        if let Some(basis) = basis {
            let mut flat = *start;
            flat.set_xyz(basis.tr_mul(&start.xyz()));
            let flat = SpaceCircle::of_arc(arc, None, &flat);
            return SpaceCircle { center: basis * flat.center, normal: basis * flat.normal, ..flat };
        }
        let [abscissa, ordinate, across] = arc.plane.axes();
        let mut center = start.xyz();
        center[abscissa.slot()] = arc.center_mm[0];
        center[ordinate.slot()] = arc.center_mm[1];
        let mut normal = Vector::zeros();
        normal[across.slot()] = if arc.clockwise { -1.0 } else { 1.0 };
        SpaceCircle { center, normal, extra_turns: arc.extra_turns }
    }
}

/// A circle, or a helix or spiral about it, between two points.
struct Turn {
    circle: SpaceCircle,
    /// Unit vectors in the plane: to the start, and a quarter turn further.
    base: [Vector; 2],
    radii: [f64; 2],
    /// Heights of both ends along the normal from the center, mm.
    heights: [f64; 2],
    sweep: f64,
}

impl Turn {
    fn new(circle: SpaceCircle, start: &Vector, end: &Vector) -> Option<Turn> {
        let split = |point: &Vector| {
            let from = point - circle.center;
            let height = from.dot(&circle.normal);
            (from - circle.normal * height, height)
        };
        let ((first, low), (last, high)) = (split(start), split(end));
        let radius = first.norm();
        if radius < SHORTEST_MM {
            return None;
        }
        let base = [first / radius, circle.normal.cross(&first) / radius];
        let angle = last.dot(&base[1]).atan2(last.dot(&base[0])).rem_euclid(TAU);
        let is_full = (last - first).norm() < SHORTEST_MM;
        let part = if is_full { TAU } else { angle };
        let sweep = part + TAU * f64::from(circle.extra_turns);
        Some(Turn { circle, base, radii: [radius, last.norm()], heights: [low, high], sweep })
    }

    fn at(&self, share: f64) -> Vector {
        let (sine, cosine) = (self.sweep * share).sin_cos();
        let [radius, height] = [self.radii, self.heights].map(|ends| ends[0] + (ends[1] - ends[0]) * share);
        let out = (self.base[0] * cosine + self.base[1] * sine) * radius;
        self.circle.center + out + self.circle.normal * height
    }

    /// The number of chords that stay within the sag.
    fn chords(&self) -> f64 {
        let radius = self.radii[0].max(self.radii[1]);
        self.sweep / (8.0 * SAG_MM / radius).sqrt().min(LONGEST_TURN)
    }
}

/// The path of a move.
struct ChordPath {
    start: AxisVector,
    end: AxisVector,
    turn: Option<Turn>,
}

impl ChordPath {
    fn at(&self, share: f64) -> AxisVector {
        if share >= 1.0 {
            return self.end;
        }
        let mut position = self.start.lerp(&self.end, share);
        if let Some(turn) = self.turn.as_ref().filter(|_| share > 0.0) {
            position.set_xyz(turn.at(share));
        }
        position
    }
}

/// Limits of the axes, and the kinematics that move the tip.
#[derive(Clone, Debug)]
pub(super) struct Cutter {
    kinematics: Kinematics,
    speeds: AxisVector,
    accelerations: AxisVector,
}

impl Cutter {
    pub(super) fn new(kinematics: Kinematics, servo: &Servo) -> Cutter {
        let of = |value: fn(&ncfix_machine::machine::AxisServo) -> f64| {
            AxisVector(servo.axes.map(|axis| axis.map_or(f64::INFINITY, |axis| value(&axis))))
        };
        Cutter { kinematics, speeds: of(|axis| axis.max_speed), accelerations: of(|axis| axis.max_acceleration) }
    }

    pub(super) fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Passes on the chords of a move, in order.
    pub(super) fn cut(&self, start: &AxisVector, motion: &ServoMove, tool_mm: &Vector, see: &mut dyn FnMut(&Chord)) {
        let turn = motion.circle.and_then(|circle| Turn::new(circle, &start.xyz(), &motion.target.xyz()));
        let way = ChordPath { start: *start, end: motion.target, turn };
        let count = self.count(&way, tool_mm);
        let mut from = *start;
        let mut tip = self.kinematics.tip_mm(&from, tool_mm);
        for number in 1..=count {
            let to = way.at(number as f64 / count as f64);
            let next = self.kinematics.tip_mm(&to, tool_mm);
            if let Some(mut chord) = self.chord(&from, &to, [tip, next], motion, count) {
                if way.turn.is_some() {
                    let middle = way.at((number as f64 - 0.5) / count as f64);
                    chord.bulge_mm = 4.0 * (middle.xyz() - from.lerp(&to, 0.5).xyz());
                }
                see(&chord);
                (from, tip) = (to, next);
            }
        }
    }

    /// The number of chords of a path.
    fn count(&self, way: &ChordPath, tool_mm: &Vector) -> usize {
        let most_turn = self.kinematics.rotary_axes().map(|axis| (way.end[axis] - way.start[axis]).abs());
        let most_turn = most_turn.fold(0.0, f64::max);
        let of_circle = way.turn.as_ref().map_or(1.0, Turn::chords);
        let mut count = of_circle.max(most_turn / LONGEST_TURN).ceil().clamp(1.0, MOST_CHORDS);
        if most_turn > 0.0 {
            let tip = |share: f64| self.kinematics.tip_mm(&way.at(share), tool_mm);
            let piece = 1.0 / count;
            let sag = (tip(0.5 * piece) - tip(0.0).lerp(&tip(piece), 0.5)).norm();
            count = (count * (sag / SAG_MM).sqrt().max(1.0)).ceil().min(MOST_CHORDS);
        }
        count as usize
    }

    fn chord(
        &self,
        from: &AxisVector,
        to: &AxisVector,
        tips: [Vector; 2],
        motion: &ServoMove,
        count: usize,
    ) -> Option<Chord> {
        let steps = *to - *from;
        let mut squares = [0.0; 2];
        for axis in AXES {
            let is_rotary = usize::from(axis.is_rotary());
            squares[is_rotary] += steps[axis] * steps[axis];
        }
        let [linear, rotary] = squares.map(f64::sqrt);
        let size = linear.hypot(rotary * ARM_MM);
        if size < SHORTEST_MM {
            return None;
        }
        let slope = AxisVector(steps.0.map(|step| step / size));
        let allowed = |limits: &AxisVector| {
            (0..AXIS_COUNT).map(|slot| limits.0[slot] / slope.0[slot].abs()).fold(f64::INFINITY, f64::min)
        };
        let way = if motion.is_tip_feed { (tips[1] - tips[0]).norm() } else { linear };
        let way = if way > NO_WAY_MM { way } else { rotary.to_degrees() };
        let feed_share = way / size;
        let wanted = match motion.pace {
            MoveSpeed::Rapid => f64::INFINITY,
            MoveSpeed::Feed(feed) if feed > 0.0 => feed / feed_share,
            MoveSpeed::Time(time_s) if time_s > 0.0 => size * count as f64 / time_s,
            MoveSpeed::Feed(_) | MoveSpeed::Time(_) => f64::INFINITY,
        };
        Some(Chord {
            start: *from,
            slope,
            bulge_mm: Vector::zeros(),
            tips,
            block: motion.block,
            is_rapid: motion.pace == MoveSpeed::Rapid,
            size,
            speed: wanted.min(allowed(&self.speeds)).max(SLOWEST),
            acceleration: allowed(&self.accelerations),
            feed_share,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::Plane;

    #[test]
    fn a_turn_goes_the_way_of_the_arc_of_the_flat_stream() {
        // G2 and G3, quarter, full circle, helix and turns: the same points as geometry::Arc, in every plane.
        for plane in [Plane::XY, Plane::ZX, Plane::YZ] {
            let [abscissa, ordinate, across] = plane.axes();
            for (clockwise, extra_turns, end) in
                [(true, 0, [0.0, 10.0]), (false, 0, [0.0, 10.0]), (false, 2, [10.0, 0.0]), (true, 1, [-10.0, 0.0])]
            {
                let mut start = AxisVector::ZERO;
                start[abscissa] = 10.0;
                let mut target = AxisVector::ZERO;
                (target[abscissa], target[ordinate], target[across]) = (end[0], end[1], 3.0);
                let arc = Arc { plane, clockwise, center_mm: [0.0, 0.0], extra_turns };
                let turn = Turn::new(SpaceCircle::of_arc(&arc, None, &start), &start.xyz(), &target.xyz()).unwrap();
                for share in [0.25, 0.5, 0.9] {
                    let expected = arc.at(&start, &target, share).xyz();
                    assert!((turn.at(share) - expected).norm() < 1e-9, "{plane:?} {clockwise} {share}");
                }
            }
        }
    }
}
