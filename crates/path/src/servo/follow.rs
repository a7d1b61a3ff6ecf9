//! From trapezoids to moments: positions by cycles, smoothed, passed through the axis loops, compared with the path.

use super::chord::Chord;
use super::contour::{Contour, OnPath};
use super::plan::SpeedProfile;
use super::response::Response;
use super::smoothing::Smoothing;
use ncfix_base::geometry::{AXES, AXIS_COUNT, AxisVector, Vector};
use ncfix_machine::machine::{Kinematics, Servo, State};
use ncfix_model::Model;

/// Number of time constants after which a residual following error is negligible.
const TIME_CONSTANTS: f64 = 6.0;

/// Duration of a chord beyond which it is not simulated, s: its following error is constant, and it is not a cut.
const LONGEST_S: f64 = 3600.0;

/// The machine at the end of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleState {
    /// Since the start of the program, s.
    pub time_s: f64,
    /// Set-points after the smoothing.
    pub set_point: AxisVector,
    /// Positions of the axes.
    pub encoder: AxisVector,
    /// Directions of the set-points, accelerations and jerks of the axes.
    pub state: State,
    /// Vector from the spindle gauge point to the tip, mm.
    pub tool_mm: Vector,
    /// Speed of the set-points along the path, mm/min or degrees/min as the feed.
    pub feed_mm_min: f64,
    /// The current block of the set-points.
    pub block: u64,
    /// The nearest point of the path, and the distance of the tool from it.
    pub on_path: Option<OnPath>,
}

/// Data of a set-point that pass through the smoothing with its position.
#[derive(Clone, Copy, Debug, Default)]
struct Tag {
    feed_mm_min: f64,
    block: u64,
}

/// All stages after the look-ahead.
#[derive(Clone, Debug)]
pub(super) struct AxisFollower<'a> {
    cycle_s: f64,
    /// Time from the start of the next chord to the next cycle, s.
    to_next_s: f64,
    time_s: f64,
    smoothing: Smoothing,
    tags: Vec<Tag>,
    at: usize,
    /// The last two set-points, and the axis positions that belong to them.
    set_points: [AxisVector; 2],
    encoders: [AxisVector; 2],
    state: State,
    response: Response,
    contour: Contour,
    kinematics: Kinematics,
    tool_mm: Vector,
    /// The model, if it contains compliance under acceleration.
    giving_way: Option<&'a Model>,
    settling_s: f64,
    smoothing_s: f64,
    /// Exact-stop windows: largest distance of an axis from its end at which a block counts as ended.
    windows: AxisVector,
    position: AxisVector,
    has_left_out: bool,
}

impl<'a> AxisFollower<'a> {
    pub(super) fn new(servo: &Servo, cycles: usize, kinematics: Kinematics, model: &'a Model) -> AxisFollower<'a> {
        let loops = || servo.axes.iter().flatten();
        let late_s = loops().map(ncfix_machine::machine::AxisServo::lag_s).fold(0.0, f64::max);
        let slow_s = loops().map(|axis| 1.0 / axis.velocity_gain_per_s).fold(0.0, f64::max);
        let smoothing_s = cycles as f64 * servo.cycle_s;
        let back_s = late_s + TIME_CONSTANTS * slow_s + smoothing_s + 2.0 * servo.cycle_s;
        AxisFollower {
            cycle_s: servo.cycle_s,
            to_next_s: 0.0,
            time_s: 0.0,
            smoothing: Smoothing::new(cycles),
            // The delay is the cycles of a box minus one, plus one for the second difference.
            tags: vec![Tag::default(); cycles],
            at: 0,
            set_points: [AxisVector::ZERO; 2],
            encoders: [AxisVector::ZERO; 2],
            state: State::default(),
            response: Response::new(servo),
            contour: Contour::new(back_s + smoothing_s),
            kinematics,
            tool_mm: Vector::zeros(),
            giving_way: gives_way(model).then_some(model),
            settling_s: back_s + smoothing_s,
            smoothing_s: servo.smoothing_s,
            windows: servo.exact_stop(),
            position: AxisVector::ZERO,
            has_left_out: false,
        }
    }

    /// `true` if a chord was too slow to be simulated.
    pub(super) fn has_left_out(&self) -> bool {
        self.has_left_out
    }

    /// Sets the position as if the machine had rested there.
    pub(super) fn jump(&mut self, position: &AxisVector) {
        self.smoothing.reset(position);
        self.response.reset(position);
        self.set_points = [*position; 2];
        self.encoders = [*position; 2];
        (self.state.acceleration, self.state.jerk) = (AxisVector::ZERO, AxisVector::ZERO);
        self.contour.clear();
        self.position = *position;
    }

    /// Sets a new tool, and with it a new tip path.
    pub(super) fn change_tool(&mut self, tool_mm: &Vector) {
        if *tool_mm != self.tool_mm {
            self.tool_mm = *tool_mm;
            self.contour.clear();
        }
    }

    /// Time since the start, s.
    pub(super) fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Executes a chord.
    pub(super) fn pass(&mut self, chord: &Chord, profile: &SpeedProfile, see: &mut dyn FnMut(&CycleState)) {
        let duration_s = profile.duration_s();
        if duration_s.is_nan() || duration_s > LONGEST_S {
            self.has_left_out = true;
            self.time_s += duration_s;
            self.jump(&chord.at(chord.size));
            return;
        }
        self.contour.pass(chord, profile, self.time_s + duration_s);
        while self.to_next_s <= duration_s {
            let [way, speed] = profile.at(self.to_next_s);
            let tag = Tag { feed_mm_min: speed * chord.feed_share * 60.0, block: chord.block };
            self.cycle(&chord.at(way), tag, self.time_s + self.to_next_s, see);
            self.to_next_s += self.cycle_s;
        }
        self.to_next_s -= duration_s;
        self.time_s += duration_s;
        self.position = chord.at(chord.size);
    }

    /// Dwells for a time.
    pub(super) fn wait(&mut self, duration_s: f64, see: &mut dyn FnMut(&CycleState)) {
        // A longer dwell brings no new state.
        let seen_s = duration_s.min(self.settling_s);
        let tag = Tag { feed_mm_min: 0.0, block: self.tags[self.at].block };
        let position = self.position;
        while self.to_next_s <= seen_s {
            self.cycle(&position, tag, self.time_s + self.to_next_s, see);
            self.to_next_s += self.cycle_s;
        }
        self.to_next_s -= seen_s;
        self.time_s += duration_s;
    }

    /// Waits until the set-points reach the end and the axes are within the exact-stop windows.
    pub(super) fn arrive(&mut self, see: &mut dyn FnMut(&CycleState)) {
        self.wait(self.smoothing_s, see);
        let mut left_s = self.settling_s;
        while left_s > 0.0 && !self.has_arrived() {
            self.wait(self.cycle_s, see);
            left_s -= self.cycle_s;
        }
    }

    fn has_arrived(&self) -> bool {
        let off = self.position.0.iter().zip(self.encoders[1].0).map(|(end, encoder)| (end - encoder).abs());
        off.zip(self.windows.0).all(|(off, window)| off <= window)
    }

    /// Continues until the axes have come to rest; this does not count as program time.
    pub(super) fn settle(&mut self, see: &mut dyn FnMut(&CycleState)) {
        let time_s = self.time_s;
        self.wait(self.settling_s, see);
        self.time_s = time_s;
    }

    fn cycle(&mut self, position: &AxisVector, tag: Tag, now_s: f64, see: &mut dyn FnMut(&CycleState)) {
        let next = self.smoothing.next(position);
        let Tag { feed_mm_min, block } = std::mem::replace(&mut self.tags[self.at], tag);
        self.at = (self.at + 1) % self.tags.len();
        let [before, set_point] = self.set_points;
        let [encoder_before, encoder] = self.encoders;
        let ahead = self.response.next(&set_point, &next);
        // The direction is that of the set-points, as their last digits do not fluctuate.
        self.state.note_motion(&before, &set_point);
        self.note_rates(&encoder_before, &encoder, &ahead);
        (self.set_points, self.encoders) = ([set_point, next], [encoder, ahead]);
        let tip = self.kinematics.tip_mm(&encoder, &self.tool_mm) + self.deflection_mm(&encoder);
        let on_path = self.contour.nearest(&tip, now_s);
        see(&CycleState {
            time_s: now_s,
            set_point,
            encoder,
            state: self.state,
            tool_mm: self.tool_mm,
            feed_mm_min,
            block,
            on_path,
        });
    }

    /// Computes accelerations and jerks of the axes at a position between two others.
    fn note_rates(&mut self, before: &AxisVector, now: &AxisVector, next: &AxisVector) {
        let square = self.cycle_s * self.cycle_s;
        for slot in 0..AXIS_COUNT {
            let acceleration = (next.0[slot] - 2.0 * now.0[slot] + before.0[slot]) / square;
            self.state.jerk.0[slot] = (acceleration - self.state.acceleration.0[slot]) / self.cycle_s;
            self.state.acceleration.0[slot] = acceleration;
        }
    }

    /// Elastic deflection of the tip in the workpiece, mm.
    fn deflection_mm(&self, command: &AxisVector) -> Vector {
        let Some(model) = self.giving_way else { return Vector::zeros() };
        let still = State { acceleration: AxisVector::ZERO, jerk: AxisVector::ZERO, ..self.state };
        model.tip_error_mm(command, command, &self.tool_mm, &self.state)
            - model.tip_error_mm(command, command, &self.tool_mm, &still)
    }
}

/// `true` if an acceleration or jerk of any axis changes the pose.
fn gives_way(model: &Model) -> bool {
    let still = model.volumetric_error(&AxisVector::ZERO, &Vector::zeros(), &State::default());
    AXES.into_iter().any(|axis| {
        let mut state = State::default();
        state.acceleration[axis] = 1.0;
        state.jerk[axis] = 1.0;
        model.volumetric_error(&AxisVector::ZERO, &Vector::zeros(), &state) != still
    })
}
