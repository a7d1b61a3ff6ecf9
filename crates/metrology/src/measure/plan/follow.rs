//! Paths on which the tip follows a point of the workpiece while a rotary axis turns, as in the tests of ISO 10791-6.
//!
//! The control interpolates the axes, so between two programmed poses the tip leaves the point: by R(1 − cos(c/2)) for the radius R and the chord c. With
//! 0.5° these are 10 µm at 1 m, far below the range of a sensor nest or a ball-bar.

use std::f64::consts::{PI, TAU};

use super::builder::{Builder, Extra};
use super::{PlanRefused, Wishes};
use ncfix_base::geometry::{Axis, AxisVector, ROTARY_AXES, Vector};
use ncfix_machine::machine::Machine;

/// Angle of a straight piece, rad.
const CHORD: f64 = PI / 360.0;
/// Angle between rows, rad.
const EVERY: f64 = PI / 18.0;
/// Room at an end of the travel of a rotary axis, rad (0.02°): a corrected program turns slightly beyond the planned angles, by less than 350 µrad.
const ROOM: f64 = PI / 9000.0;
/// Largest angle of a tilting axis without a stated one, rad.
const TILT: f64 = PI / 3.0;

/// A rotary axis with its first and last angle, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TurnedAxis {
    pub(super) axis: Axis,
    pub(super) range: [f64; 2],
}

/// The rotary axes that a plan turns, one after the other: the stated one, or all.
pub(super) fn turns(machine: &Machine, wishes: &Wishes) -> Result<Vec<TurnedAxis>, PlanRefused> {
    if let Some(axis) = wishes.axis
        && (!axis.is_rotary() || machine.axis(axis).is_none())
    {
        return Err(PlanRefused(format!("{axis} is no rotary axis of {}", machine.name)));
    }
    if wishes.range.is_some() && wishes.axis.is_none() {
        return Err(PlanRefused("--range needs --axis, the axis that turns".into()));
    }
    let all = ROTARY_AXES.into_iter().filter(|axis| wishes.axis.is_none_or(|own| own == *axis));
    let tilt = wishes.tilt.unwrap_or(TILT).abs();
    let turn = |axis: Axis| {
        let data = machine.axis(axis)?;
        let [low, high] = data.travel.unwrap_or([-TAU, TAU]);
        let room = if data.modulo { 0.0 } else { ROOM };
        // An axis without end stops a row before the full turn: at 360° its position is 0 again, and the way there would be ambiguous.
        let most = if data.modulo {
            [0.0, TAU - every(wishes)]
        } else if high - low >= TAU - 1e-9 {
            [0.0, TAU]
        } else {
            [-tilt, tilt]
        };
        Some(TurnedAxis { axis, range: wishes.range.unwrap_or([most[0].max(low + room), most[1].min(high - room)]) })
    };
    let turns: Vec<TurnedAxis> = all.filter_map(turn).collect();
    if turns.is_empty() {
        return Err(PlanRefused(format!("{} has no rotary axis", machine.name)));
    }
    let wraps = |turn: &&TurnedAxis| {
        let is_endless = machine.axis(turn.axis).is_some_and(|data| data.modulo);
        is_endless && (turn.range[0] < 0.0 || turn.range[1] >= TAU)
    };
    if let Some(turn) = turns.iter().find(wraps) {
        return Err(PlanRefused(format!("{} is a modulo axis: give --range within 0 to 359 degrees", turn.axis)));
    }
    match turns.iter().find(|turn| turn.range[1] - turn.range[0] <= CHORD) {
        Some(turn) => Err(PlanRefused(format!("the range of {} is empty; give --range FROM,TO", turn.axis))),
        None => Ok(turns),
    }
}

/// Angle between rows, rad.
pub(super) fn every(wishes: &Wishes) -> f64 {
    wishes.every.unwrap_or(EVERY).clamp(1e-4, PI)
}

/// The pose with the tip at a point of the workpiece, one rotary axis at an angle and the others at zero.
pub(super) fn pose(
    plan: &Builder,
    place_mm: &Vector,
    (axis, angle): (Axis, f64),
    tool_mm: &Vector,
) -> Result<AxisVector, PlanRefused> {
    let mut rotary = AxisVector::ZERO;
    rotary[axis] = angle;
    let placed = plan.kinematics.placed(place_mm, &rotary, tool_mm);
    placed.ok_or_else(|| PlanRefused(format!("the linear axes of {} cannot place the tool", plan.machine.name)))
}

/// The motion of a plan along a turn.
pub(super) struct Following {
    /// Point of the workpiece.
    pub(super) place_mm: Vector,
    /// Tool.
    pub(super) tool_mm: Vector,
    /// Index of the set-up.
    pub(super) setup: usize,
    /// Feed.
    pub(super) feed: f64,
    /// Time at a row, s; none if the readings are taken in motion.
    pub(super) dwell_s: Option<f64>,
}

impl Following {
    /// Turns an axis forward and back, with rows at equal angles.
    pub(super) fn run(&self, plan: &mut Builder, turn: TurnedAxis, wishes: &Wishes) -> Result<(), PlanRefused> {
        let every = every(wishes);
        let chord = wishes.chord.unwrap_or(CHORD).clamp(1e-4, 0.2).min(every);
        let [low, high] = turn.range;
        let rows = ((high - low) / every).round().max(1.0);
        let pieces = (every / chord).ceil().max(1.0);
        let runs = wishes.runs.unwrap_or(1).clamp(1, 1000);
        for run in 1..=runs {
            for (from, to, sign) in [(low, high, '+'), (high, low, '-')] {
                for row in 0..=rows as u32 {
                    let at = |share: f64| from + (to - from) * share / rows;
                    for piece in 1..=pieces as u32 {
                        // The first row is where the axis already is.
                        let share = f64::from(row) - 1.0 + f64::from(piece) / pieces;
                        if share >= 0.0 || piece == pieces as u32 {
                            let here = pose(plan, &self.place_mm, (turn.axis, at(share.max(0.0))), &self.tool_mm)?;
                            plan.go(&here, Some(self.feed))?;
                        }
                    }
                    let Some(here) = plan.last() else { continue };
                    let label = format!("{run}{}{sign}", turn.axis);
                    let extra = Extra { run: label, feed: Some(self.feed), ..Extra::default() };
                    plan.row(&here, self.tool_mm, self.setup, extra)?;
                    if let Some(seconds) = self.dwell_s {
                        plan.dwell(seconds);
                    }
                }
            }
        }
        Ok(())
    }
}
