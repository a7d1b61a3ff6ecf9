//! The speed along the path: a limit at every corner, and a trapezoid over every chord between.
//!
//! A step dv of the velocity of an axis, smoothed by a triangular kernel of the length T, causes a deviation of dv T/12 and an acceleration of 2
//! dv/T. Braking before the corner and accelerating after it with a add a T²/96, half of a/2 times the variance T²/24 of the kernel. If corners
//! follow each other faster than T/2, as in a circle of short chords, their steps add up to the acceleration a = dv/t with the time t between
//! corners, and the deviation is a T²/48. Each corner is passed at the highest speed that satisfies both on every axis. In curves the axes count
//! together, so that a circle has one speed all around.
//!
//! Between corners the speed changes with the acceleration limit along the chord. The look-ahead is bounded: the path after its end is unknown, so
//! the speed always allows a stop there, as in a control.

use std::collections::VecDeque;

use super::chord::Chord;
use ncfix_base::geometry::{AXES, AXIS_COUNT, AxisVector};
use ncfix_machine::machine::Servo;

/// Minimum number of chords in the look-ahead.
const LOOK_AHEAD: usize = 512;
/// Minimum share of a tolerance for the velocity step, besides the ramps.
const LEAST_ROOM: f64 = 0.1;
/// Steps of a direction below this are rounding noise.
const SAME_DIRECTION: f64 = 1e-12;

/// The speed over a chord: acceleration, constant speed, deceleration. Speeds are in size per time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpeedProfile {
    size: f64,
    entry: f64,
    peak: f64,
    exit: f64,
    acceleration: f64,
}

impl SpeedProfile {
    /// The fastest profile within the highest speed, the acceleration and the speeds at both ends.
    pub(super) fn new(size: f64, [entry, exit]: [f64; 2], speed: f64, acceleration: f64) -> SpeedProfile {
        let reach = 2.0 * acceleration * size;
        // Planned speeds are reachable except for rounding.
        let exit = exit.min((entry * entry + reach).sqrt()).max((entry * entry - reach).max(0.0).sqrt());
        let peak = speed.min((0.5 * (reach + entry * entry + exit * exit)).sqrt()).max(entry).max(exit);
        SpeedProfile { size, entry, peak, exit, acceleration }
    }

    /// Durations of the three phases, s.
    fn times(&self) -> [f64; 3] {
        let up = (self.peak - self.entry) / self.acceleration;
        let down = (self.peak - self.exit) / self.acceleration;
        let ways = 0.5 * (up * (self.entry + self.peak) + down * (self.exit + self.peak));
        [up, (self.size - ways).max(0.0) / self.peak, down]
    }

    pub(super) fn duration_s(&self) -> f64 {
        self.times().iter().sum()
    }

    /// Distance and speed at a time.
    pub(super) fn at(&self, time_s: f64) -> [f64; 2] {
        let [up, cruise, down] = self.times();
        if time_s < up {
            let speed = self.entry + self.acceleration * time_s;
            return [0.5 * time_s * (self.entry + speed), speed];
        }
        if time_s < up + cruise {
            return [0.5 * up * (self.entry + self.peak) + (time_s - up) * self.peak, self.peak];
        }
        let left = (up + cruise + down - time_s).max(0.0);
        let speed = self.exit + self.acceleration * left;
        [self.size - 0.5 * left * (self.exit + speed), speed]
    }

    /// Speed at a distance.
    pub(super) fn speed_at(&self, way: f64) -> f64 {
        let reach = 2.0 * self.acceleration;
        let up = self.entry * self.entry + reach * way;
        let down = self.exit * self.exit + reach * (self.size - way);
        up.min(down).max(0.0).sqrt().min(self.peak)
    }

    pub(super) fn exit(&self) -> f64 {
        self.exit
    }
}

/// Speed limits at corners.
#[derive(Clone, Copy, Debug)]
struct Corners {
    /// Length of the kernel, s.
    kernel_s: f64,
    tolerances: AxisVector,
    accelerations: AxisVector,
}

impl Corners {
    fn speed(&self, before: &Chord, after: &Chord) -> f64 {
        let length = before.size.midpoint(after.size);
        let mut speed = before.speed.min(after.speed);
        // Deviation by the ramps on both sides, for a unit step.
        let ramp = before.acceleration.max(after.acceleration) * self.kernel_s * self.kernel_s / 96.0;
        let mut squares = 0.0;
        for slot in 0..AXIS_COUNT {
            let step = (after.slope.0[slot] - before.slope.0[slot]).abs();
            if step > SAME_DIRECTION {
                let (tolerance, acceleration) = (self.tolerances.0[slot], self.accelerations.0[slot]);
                let room = (tolerance - step * ramp).max(LEAST_ROOM * tolerance);
                let alone = (12.0 * room / self.kernel_s).min(0.5 * acceleration * self.kernel_s) / step;
                let among = acceleration.min(48.0 * tolerance / (self.kernel_s * self.kernel_s));
                speed = speed.min(alone);
                squares += (step / among).powi(2);
            }
        }
        if squares > 0.0 {
            speed = speed.min((length / squares.sqrt()).sqrt());
        }
        speed
    }
}

/// A chord in the look-ahead.
#[derive(Clone, Copy, Debug)]
struct Ahead {
    chord: Chord,
    /// Speed limit at its start by the corner there.
    corner: f64,
    /// Speed limit at its start by all that follows.
    entry: f64,
}

/// The look-ahead.
#[derive(Clone, Debug)]
pub(super) struct LookAhead {
    corners: Corners,
    ahead: VecDeque<Ahead>,
    /// Speed at the start of the first chord.
    entry: f64,
}

impl LookAhead {
    /// `kernel_s` is the effective smoothing length.
    pub(super) fn new(servo: &Servo, kernel_s: f64) -> LookAhead {
        let tolerances =
            AXES.map(|axis| if axis.is_rotary() { servo.corner_tolerance_rad } else { servo.corner_tolerance_mm });
        let accelerations = servo.axes.map(|axis| axis.map_or(f64::INFINITY, |axis| axis.max_acceleration));
        let corners =
            Corners { kernel_s, tolerances: AxisVector(tolerances), accelerations: AxisVector(accelerations) };
        LookAhead { corners, ahead: VecDeque::with_capacity(2 * LOOK_AHEAD), entry: 0.0 }
    }

    /// Adds the next chord, and passes on the chords that are no longer affected by it.
    pub(super) fn push(&mut self, chord: &Chord, see: &mut dyn FnMut(&Chord, &SpeedProfile)) {
        let before = self.ahead.back().filter(|before| before.chord.is_rapid == chord.is_rapid);
        let corner = before.map_or(0.0, |before| self.corners.speed(&before.chord, chord));
        self.ahead.push_back(Ahead { chord: *chord, corner, entry: 0.0 });
        if self.ahead.len() >= 2 * LOOK_AHEAD {
            self.release(LOOK_AHEAD, see);
        }
    }

    /// Plans a stop after the last chord, and passes all chords on.
    pub(super) fn stop(&mut self, see: &mut dyn FnMut(&Chord, &SpeedProfile)) {
        self.release(self.ahead.len(), see);
        self.entry = 0.0;
    }

    /// `true` if no chord is pending.
    pub(super) fn is_empty(&self) -> bool {
        self.ahead.is_empty()
    }

    fn release(&mut self, count: usize, see: &mut dyn FnMut(&Chord, &SpeedProfile)) {
        let mut exit = 0.0;
        for ahead in self.ahead.iter_mut().rev() {
            let reach = 2.0 * ahead.chord.acceleration * ahead.chord.size;
            ahead.entry = ahead.corner.min((exit * exit + reach).sqrt());
            exit = ahead.entry;
        }
        for _ in 0..count {
            let Some(Ahead { chord, .. }) = self.ahead.pop_front() else { return };
            let exit = self.ahead.front().map_or(0.0, |next| next.entry);
            let profile = SpeedProfile::new(chord.size, [self.entry, exit], chord.speed, chord.acceleration);
            self.entry = profile.exit();
            see(&chord, &profile);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trapezoids_and_triangles_take_the_time_of_their_formulas() {
        // 100 mm at 100 mm/s and 1000 mm/s²: 0.1 s up, 90 mm in 0.9 s, 0.1 s down.
        let long = SpeedProfile::new(100.0, [0.0, 0.0], 100.0, 1000.0);
        assert!((long.duration_s() - 1.1).abs() < 1e-12);
        assert!((long.at(0.1)[0] - 5.0).abs() < 1e-12 && (long.at(0.6)[0] - 55.0).abs() < 1e-12);
        // 1 mm: never faster than √(a s) = 31.6 mm/s, 2 √(s/a) = 63.2 ms.
        let short = SpeedProfile::new(1.0, [0.0, 0.0], 100.0, 1000.0);
        assert!((short.duration_s() - 2.0 * 0.001_f64.sqrt()).abs() < 1e-12);
        assert!((short.speed_at(0.5) - 1000_f64.sqrt()).abs() < 1e-9);
        assert!((short.at(short.duration_s())[0] - 1.0).abs() < 1e-12);
    }
}
