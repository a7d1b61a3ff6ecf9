//! The position loop of an axis: x′ = K (s − x) + f s′ with the velocity gain K and the feed-forward f, after a dead time.
//!
//! Set-points are linear within a cycle, s′ = g. The following error e = s − x obeys e′ = (1 − f) g − K e, so that over a time t
//!
//! ```text
//! e(t) = E + (e(0) − E) exp(−K t),     E = (1 − f) g / K
//! ```
//!
//! This is exact. The loop is linear: a dead time can be applied after it, and a fraction of a cycle uses the same formula.

use ncfix_base::geometry::{AXIS_COUNT, AxisVector};
use ncfix_machine::machine::{AxisServo, Servo};

/// The loops of all axes.
#[derive(Clone, Debug)]
pub(super) struct Response {
    loops: [Option<Loop>; AXIS_COUNT],
    cycle_s: f64,
}

impl Response {
    pub(super) fn new(servo: &Servo) -> Response {
        let loops = servo.axes.map(|axis| axis.map(|axis| Loop::new(&axis, servo.cycle_s)));
        Response { loops, cycle_s: servo.cycle_s }
    }

    /// Resets the loops as if the axes had rested here.
    pub(super) fn reset(&mut self, position: &AxisVector) {
        for (axis, value) in self.loops.iter_mut().zip(position.0) {
            if let Some(axis) = axis {
                axis.error = 0.0;
                axis.late.fill(value);
            }
        }
    }

    /// Axis positions at the end of a cycle in which the set-points moved from one position to another.
    pub(super) fn next(&mut self, from: &AxisVector, to: &AxisVector) -> AxisVector {
        let mut out = *to;
        for (slot, axis) in self.loops.iter_mut().enumerate() {
            if let Some(axis) = axis {
                out.0[slot] = axis.next(from.0[slot], to.0[slot], self.cycle_s);
            }
        }
        out
    }
}

/// One axis.
#[derive(Clone, Debug)]
struct Loop {
    /// (1 − f)/K, s.
    lag_s: f64,
    /// Residual share of an error after a cycle, and after the fraction of a cycle that the dead time leaves.
    decay: f64,
    decay_part: f64,
    /// That fraction, s.
    part_s: f64,
    error: f64,
    /// Positions delayed by the whole cycles of the dead time.
    late: Vec<f64>,
    at: usize,
}

impl Loop {
    fn new(axis: &AxisServo, cycle_s: f64) -> Loop {
        let gain = axis.velocity_gain_per_s;
        let whole = (axis.delay_s / cycle_s + 1e-9).floor();
        let part_s = cycle_s - (axis.delay_s - whole * cycle_s).max(0.0);
        Loop {
            lag_s: (1.0 - axis.feed_forward) / gain,
            decay: (-gain * cycle_s).exp(),
            decay_part: (-gain * part_s).exp(),
            part_s,
            error: 0.0,
            late: vec![0.0; whole as usize],
            at: 0,
        }
    }

    fn next(&mut self, from: f64, to: f64, cycle_s: f64) -> f64 {
        let slope = (to - from) / cycle_s;
        let steady = slope * self.lag_s;
        let inside = steady + (self.error - steady) * self.decay_part;
        let position = from + slope * self.part_s - inside;
        self.error = steady + (self.error - steady) * self.decay;
        let count = self.late.len();
        let Some(late) = self.late.get_mut(self.at) else { return position };
        self.at = (self.at + 1) % count;
        std::mem::replace(late, position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steady_lag(axis: &AxisServo, speed: f64) -> f64 {
        let mut one = Loop::new(axis, 0.003);
        let mut at = 0.0;
        let mut position = 0.0;
        for _ in 0..2000 {
            let to = at + speed * 0.003;
            position = one.next(at, to, 0.003);
            at = to;
        }
        at - position
    }

    #[test]
    fn at_constant_speed_the_lag_is_that_of_gain_and_dead_time() {
        let axis = AxisServo {
            velocity_gain_per_s: 50.0,
            feed_forward: 0.0,
            delay_s: 0.0,
            max_acceleration: 5e3,
            max_speed: 500.0,
        };
        // v/K.
        assert!((steady_lag(&axis, 100.0) - 2.0).abs() < 1e-9);
        // v (1 − f)/K + v d, with a dead time of a cycle and two thirds.
        let late = AxisServo { feed_forward: 0.98, delay_s: 0.005, ..axis };
        assert!((steady_lag(&late, 100.0) - (0.04 + 0.5)).abs() < 1e-9);
        assert!((late.lag_s() - 0.0054).abs() < 1e-15);
    }
}
