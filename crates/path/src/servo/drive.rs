//! A machine that executes moves one after the other.

use super::chord::{Cutter, ServoMove};
use super::follow::{AxisFollower, CycleState};
use super::plan::LookAhead;
use super::smoothing::Smoothing;
use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::{Kinematics, Machine, Servo};
use ncfix_model::Model;

/// A machine and its position. Moves are executed some blocks later, after the look-ahead.
#[derive(Clone, Debug)]
pub struct Drive<'a> {
    cutter: Cutter,
    plan: LookAhead,
    follow: AxisFollower<'a>,
    /// End of the moves so far; `None` before the first.
    standing: Option<AxisVector>,
    tool_mm: Vector,
}

impl<'a> Drive<'a> {
    /// A machine at rest at an unknown position. `model` gives the compliance under acceleration; its other errors have no effect here.
    #[must_use]
    pub fn new(machine: &Machine, servo: &Servo, model: &'a Model) -> Drive<'a> {
        let kinematics = Kinematics::new(machine);
        let cycles = Smoothing::cycles(servo.smoothing_s, servo.cycle_s);
        // A single cycle still interpolates linearly between set-points: a triangle of two cycles.
        let kernel_s = 2.0 * cycles as f64 * servo.cycle_s;
        Drive {
            plan: LookAhead::new(servo, kernel_s),
            follow: AxisFollower::new(servo, cycles, kinematics.clone(), model),
            cutter: Cutter::new(kinematics, servo),
            standing: None,
            tool_mm: Vector::zeros(),
        }
    }

    /// Executes a move. The first move only sets the start position.
    pub fn go(&mut self, motion: &ServoMove, see: &mut dyn FnMut(&CycleState)) {
        let Some(standing) = self.standing else {
            self.jump(&motion.target, see);
            return;
        };
        let Drive { cutter, plan, follow, tool_mm, .. } = self;
        let mut pass = |chord: &_, profile: &_| follow.pass(chord, profile, see);
        cutter.cut(&standing, motion, tool_mm, &mut |chord| plan.push(chord, &mut pass));
        self.standing = Some(motion.target);
    }

    /// Stops at the end of the last move and waits until the axes have arrived.
    pub fn stop(&mut self, see: &mut dyn FnMut(&CycleState)) {
        if !self.plan.is_empty() {
            self.pass_all(see);
            self.follow.arrive(see);
        }
    }

    /// Executes all moves of the look-ahead, with a stop at the end.
    fn pass_all(&mut self, see: &mut dyn FnMut(&CycleState)) {
        let follow = &mut self.follow;
        self.plan.stop(&mut |chord, profile| follow.pass(chord, profile, see));
    }

    /// Stops and dwells, s.
    pub fn wait(&mut self, duration_s: f64, see: &mut dyn FnMut(&CycleState)) {
        self.stop(see);
        self.follow.wait(duration_s, see);
    }

    /// Sets a new position; the transition is unknown and takes no time.
    pub fn jump(&mut self, position: &AxisVector, see: &mut dyn FnMut(&CycleState)) {
        self.stop(see);
        self.follow.jump(position);
        self.standing = Some(*position);
    }

    /// Sets the tool vector from the spindle gauge point to the tip, mm.
    pub fn change_tool(&mut self, tool_mm: &Vector, see: &mut dyn FnMut(&CycleState)) {
        if *tool_mm != self.tool_mm {
            self.stop(see);
            self.tool_mm = *tool_mm;
            self.follow.change_tool(tool_mm);
        }
    }

    /// Stops and waits until the axes have come to rest.
    pub fn finish(&mut self, see: &mut dyn FnMut(&CycleState)) {
        self.pass_all(see);
        self.follow.settle(see);
    }

    /// Program time so far, without moves in the look-ahead, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.follow.time_s()
    }

    /// `true` if a chord took more than an hour and was therefore not simulated.
    #[must_use]
    pub fn has_left_out(&self) -> bool {
        self.follow.has_left_out()
    }

    /// End of the moves so far.
    #[must_use]
    pub fn standing(&self) -> Option<&AxisVector> {
        self.standing.as_ref()
    }

    /// The kinematic chain of the machine without errors.
    #[must_use]
    pub fn kinematics(&self) -> &Kinematics {
        self.cutter.kinematics()
    }
}
