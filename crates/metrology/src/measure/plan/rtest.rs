//! R-test: a ball in the spindle stays at a point of the table while one rotary axis after the other turns forward and back; a nest of sensors reads its
//! displacement (ISO 10791-6, tests with three linear displacement sensors).
//!
//! With a variant, the axes turn [together]. Otherwise each axis is a set-up of its own, because the nest is set to zero before each.

use super::builder::Builder;
use super::follow::{Following, pose, turns};
use super::{PlanKind, PlanRefused, RowSpacing, Wishes, empty, kind, probe, together};
use crate::measure::data::{Free, Setup};
use ncfix_machine::machine::Machine;

/// The plan.
pub(super) const PLAN: PlanKind = PlanKind {
    name: "rtest",
    title: "ball at a point of the table while rotary axes turn, read in X, Y and Z (ISO 10791-6); variants together (all rotary axes at once), corner (two legs at several feeds)",
    wishes: &[
        "variant", "axis", "range", "tilt", "ball", "radius", "every", "chord", "points", "runs", "feed", "dwell",
    ],
    spacing: RowSpacing::Angle,
    has_setups: false,
    build,
};

fn build(machine: &Machine, wishes: &Wishes) -> Result<Builder, PlanRefused> {
    if let Some(variant) = &wishes.variant {
        return together::build(machine, wishes, variant);
    }
    if wishes.points.is_some() {
        return Err(PlanRefused("--points is the number of blocks of --variant corner".into()));
    }
    let tool_mm = wishes.tool_mm();
    let turns = turns(machine, wishes)?;
    let place_mm = probe::balls(machine, wishes, 1)?.first().copied().unwrap_or_default();
    let feed = wishes.feed.unwrap_or(1000.0);
    let mut plan = Builder::new(machine, wishes, empty(kind("displacement")?, &[Free::Offset]));
    for (setup, turn) in turns.into_iter().enumerate() {
        plan.data.setups.push(Setup { label: turn.axis.to_string(), ..Setup::default() });
        plan.stop("remove the nest of sensors: the axes go to their first position");
        let first = pose(&plan, &place_mm, (turn.axis, turn.range[0]), &tool_mm)?;
        plan.approach(&first, feed)?;
        plan.stop("mount the nest at the ball and set it to zero");
        let dwell_s = Some(wishes.dwell_s.unwrap_or(2.0));
        Following { place_mm, tool_mm, setup, feed, dwell_s }.run(&mut plan, turn, wishes)?;
    }
    plan.stop("remove the nest of sensors");
    if wishes.balls_mm.is_empty() {
        let [x, y, z] = [place_mm.x, place_mm.y, place_mm.z];
        plan.notes.push(format!("the ball is assumed at {x:.0},{y:.0},{z:.0}; give --ball X,Y,Z"));
    }
    Ok(plan)
}
