//! A machine that is driven move by move.

use super::chord::{Cutter, ServoMove};
use super::follow::{AxisFollower, Moment};
use super::plan::LookAhead;
use super::smoothing::Smoothing;
use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::{Kinematics, Machine, Servo};
use ncfix_model::Model;

/// A machine and where it stands. What it is told it does some blocks later, when it has looked ahead.
#[derive(Clone, Debug)]
pub struct Drive<'a> {
    cutter: Cutter,
    plan: LookAhead,
    follow: AxisFollower<'a>,
    /// Where the moves so far end; `None` before the first.
    standing: Option<AxisVector>,
    tool_mm: Vector,
}

impl<'a> Drive<'a> {
    /// A machine at rest somewhere. `model` says what gives way under acceleration; its other errors do not count here.
    #[must_use]
    pub fn new(machine: &Machine, servo: &Servo, model: &'a Model) -> Drive<'a> {
        let kinematics = Kinematics::new(machine);
        let cycles = Smoothing::cycles(servo.smoothing_s, servo.cycle_s);
        // A single cycle still goes straight from one set-point to the next: a triangle of two cycles.
        let kernel_s = 2.0 * cycles as f64 * servo.cycle_s;
        Drive {
            plan: LookAhead::new(servo, kernel_s),
            follow: AxisFollower::new(servo, cycles, kinematics.clone(), model),
            cutter: Cutter::new(kinematics, servo),
            standing: None,
            tool_mm: Vector::zeros(),
        }
    }

    /// Makes a move. The first one only says where the machine stands.
    pub fn go(&mut self, motion: &ServoMove, see: &mut dyn FnMut(&Moment)) {
        let Some(standing) = self.standing else {
            self.jump(&motion.target, see);
            return;
        };
        let Drive { cutter, plan, follow, tool_mm, .. } = self;
        let mut pass = |chord: &_, profile: &_| follow.pass(chord, profile, see);
        cutter.cut(&standing, motion, tool_mm, &mut |chord| plan.push(chord, &mut pass));
        self.standing = Some(motion.target);
    }

    /// Comes to a stop at the end of the last move, and waits until the axes are there.
    pub fn stop(&mut self, see: &mut dyn FnMut(&Moment)) {
        if !self.plan.is_empty() {
            self.pass_all(see);
            self.follow.arrive(see);
        }
    }

    /// Passes what waits in the look-ahead, to a stop at its end.
    fn pass_all(&mut self, see: &mut dyn FnMut(&Moment)) {
        let follow = &mut self.follow;
        self.plan.stop(&mut |chord, profile| follow.pass(chord, profile, see));
    }

    /// Stops and stands for a time, s.
    pub fn wait(&mut self, duration_s: f64, see: &mut dyn FnMut(&Moment)) {
        self.stop(see);
        self.follow.wait(duration_s, see);
    }

    /// The machine stands elsewhere; how it got there is not known and takes no time.
    pub fn jump(&mut self, position: &AxisVector, see: &mut dyn FnMut(&Moment)) {
        self.stop(see);
        self.follow.jump(position);
        self.standing = Some(*position);
    }

    /// From here on another tool is in the spindle, mm from its gauge point to the tip.
    pub fn change_tool(&mut self, tool_mm: &Vector, see: &mut dyn FnMut(&Moment)) {
        if *tool_mm != self.tool_mm {
            self.stop(see);
            self.tool_mm = *tool_mm;
            self.follow.change_tool(tool_mm);
        }
    }

    /// Stops and waits until the axes have come to rest.
    pub fn finish(&mut self, see: &mut dyn FnMut(&Moment)) {
        self.pass_all(see);
        self.follow.settle(see);
    }

    /// Time of the program so far, without what waits in the look-ahead, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.follow.time_s()
    }

    /// Whether a move was so slow, an hour for a chord, that it was not followed.
    #[must_use]
    pub fn has_left_out(&self) -> bool {
        self.follow.has_left_out()
    }

    /// Where the moves so far end.
    #[must_use]
    pub fn standing(&self) -> Option<&AxisVector> {
        self.standing.as_ref()
    }

    /// The chain of the machine without errors.
    #[must_use]
    pub fn kinematics(&self) -> &Kinematics {
        self.cutter.kinematics()
    }
}
