//! Ball-bar with rotary axes (ISO 10791-6): both balls turn with the table, and the bar points along the radius of the axis, along its tangent, or along
//! the axis. The reading is the error of the distance along the bar.

use super::builder::Builder;
use super::follow::{Following, TurnedAxis, pose, turns};
use super::{PlanRefused, Wishes, empty, kind, probe};
use crate::measure::data::{Free, Setup};
use ncfix_base::geometry::Vector;
use ncfix_machine::machine::Machine;

/// The directions of the bar by their names.
const DIRECTIONS: [&str; 3] = ["radial", "tangential", "axial"];
/// Distance from the axis below which there is no radius, mm.
const ON_AXIS_MM: f64 = 1.0;

/// The plan, if a variant asks for it.
pub(super) fn build(machine: &Machine, wishes: &Wishes) -> Option<Result<Builder, PlanRefused>> {
    let word = wishes.variant.as_deref()?;
    let wanted: Vec<&str> = DIRECTIONS.into_iter().filter(|name| word == "rotary" || word == *name).collect();
    if wanted.is_empty() {
        return Some(Err(PlanRefused(format!(
            "unknown circles '{word}'; the variants are rotary, {}",
            DIRECTIONS.join(", ")
        ))));
    }
    Some(turned(machine, wishes, &wanted))
}

/// Unit vectors along the radius, the tangent and the axis at a place, in the workpiece frame with all axes at zero.
fn directions(machine: &Machine, turn: TurnedAxis, place_mm: &Vector) -> Option<[Vector; 3]> {
    let data = machine.axis(turn.axis)?;
    let axis = data.direction.try_normalize(f64::EPSILON)?;
    let off = place_mm - data.point_mm;
    let across = off - axis * off.dot(&axis);
    let aside = Vector::ith((axis.iamax() + 1) % 3, 1.0);
    let radial = if across.norm() > ON_AXIS_MM { across } else { aside - axis * aside.dot(&axis) };
    let radial = radial.try_normalize(f64::EPSILON)?;
    // The bar along the axis points to the side of the spindle.
    let side = axis.dot(&machine.spindle.axis);
    let up = if side < 0.0 { -axis } else { axis };
    Some([radial, axis.cross(&radial), up])
}

fn turned(machine: &Machine, wishes: &Wishes, wanted: &[&str]) -> Result<Builder, PlanRefused> {
    let tool_mm = wishes.tool_mm();
    let turns = turns(machine, wishes)?;
    let ball_mm = probe::balls(machine, &Wishes { radius_mm: None, ..wishes.clone() }, 1)?;
    let ball_mm = ball_mm.first().copied().unwrap_or_default();
    let length_mm = wishes.radius_mm.unwrap_or(100.0);
    let feed = wishes.feed.unwrap_or(1000.0);
    let mut plan = Builder::new(machine, wishes, empty(kind("ballbar")?, &[Free::Length]));
    for turn in turns {
        let unknown = || PlanRefused(format!("the direction of {} is not known", turn.axis));
        let directions = directions(machine, turn, &ball_mm).ok_or_else(unknown)?;
        for (name, direction) in DIRECTIONS.into_iter().zip(directions).filter(|(name, _)| wanted.contains(name)) {
            let setup = plan.data.setups.len();
            let label = format!("{}-{name}", turn.axis);
            plan.data.setups.push(Setup { label: label.clone(), centre_mm: ball_mm, length_mm, ..Setup::default() });
            let place_mm = ball_mm + direction * length_mm;
            plan.stop("remove the ball-bar: the axes go to their first position");
            let first = pose(&plan, &place_mm, (turn.axis, turn.range[0]), &tool_mm)?;
            plan.approach(&first, feed)?;
            plan.comment(&label);
            plan.stop("mount the ball-bar");
            Following { place_mm, tool_mm, setup, feed, dwell_s: wishes.dwell_s }.run(&mut plan, turn, wishes)?;
        }
    }
    plan.stop("remove the ball-bar");
    if wishes.balls_mm.is_empty() {
        let [x, y, z] = [ball_mm.x, ball_mm.y, ball_mm.z];
        plan.notes.push(format!("the ball of the table is assumed at {x:.0},{y:.0},{z:.0}; give --ball X,Y,Z"));
    }
    Ok(plan)
}
