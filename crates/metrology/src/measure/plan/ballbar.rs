//! Circles with a ball-bar (ISO 230-4): in both directions, with feed-in and overlap before and after the evaluated arc.
//!
//! A full circle in the plane perpendicular to the spindle; in the others the tool is in the way, so the default is an arc of 220° on its side.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::builder::{Builder, Extra, PlanReach};
use super::{PlanKind, PlanRefused, RowSpacing, Wishes, along_spindle, empty, kind, sphere, turned_bar};
use crate::measure::data::{Free, Setup};
use ncfix_base::geometry::{Arc, AxisVector, Plane, Vector};
use ncfix_machine::machine::Machine;

/// The plan.
pub(super) const PLAN: PlanKind = PlanKind {
    name: "ballbar",
    title: "circles in XY, YZ, ZX about a ball on the table, in both directions (ISO 230-4); variants radial, tangential, axial or rotary (all three): the table turns (ISO 10791-6)",
    wishes: &[
        "center", "radius", "feed", "plane", "every", "sweep", "overlap", "dwell", "variant", "axis", "range", "tilt",
        "ball", "chord", "runs",
    ],
    spacing: RowSpacing::Angle,
    has_setups: false,
    build,
};

/// Waiting distance of the ball outside its circle, mm.
const FEED_IN_MM: f64 = 1.5;
/// Waiting time there, s.
const DWELL_S: f64 = 2.0;
/// Largest sweep of a block: its end then determines the arc unambiguously.
const MOST_SWEEP: f64 = TAU / 3.0;

/// A circle.
struct Circle {
    plane: Plane,
    centre: AxisVector,
    radius_mm: f64,
    tool_mm: Vector,
}

impl Circle {
    fn at(&self, angle: f64, radius_mm: f64) -> AxisVector {
        let [abscissa, ordinate, _] = self.plane.axes();
        let (sin, cos) = angle.sin_cos();
        let mut out = self.centre;
        out[abscissa] += radius_mm * cos;
        out[ordinate] += radius_mm * sin;
        out
    }

    /// Sweeps an arc from the current position.
    fn sweep(&self, plan: &mut Builder, from: f64, by: f64, feed: f64) -> Result<(), PlanRefused> {
        let [abscissa, ordinate, _] = self.plane.axes();
        let pieces = (by.abs() / MOST_SWEEP).ceil().max(1.0);
        let center_mm = [self.centre[abscissa], self.centre[ordinate]];
        let arc = Arc { plane: self.plane, clockwise: by < 0.0, center_mm, extra_turns: 0 };
        for piece in 1..=pieces as u32 {
            plan.arc(&self.at(from + by * f64::from(piece) / pieces, self.radius_mm), arc, feed)?;
        }
        Ok(())
    }

    /// Rows along an arc, each with the directions of the motion to it.
    fn rows(&self, plan: &mut Builder, [from, by, every]: [f64; 3], feed: f64, run: &str) -> Result<(), PlanRefused> {
        // A full circle does not repeat its start.
        let count = (by.abs() / every).floor() as u32;
        let count = if by.abs() > TAU - 1e-9 { count.max(1) - 1 } else { count };
        let mut before = self.at(from - every * by.signum(), self.radius_mm);
        for number in 0..=count {
            let here = self.at(from + by.signum() * every * f64::from(number), self.radius_mm);
            plan.note_motion(&before, &here);
            let extra = Extra { run: run.to_owned(), feed: Some(feed), ..Extra::default() };
            plan.row(&here, self.tool_mm, 0, extra)?;
            before = here;
        }
        Ok(())
    }
}

/// Options of circles, and of bars on a turning table: the other kind does not have them.
const OF_CIRCLES: [&str; 4] = ["center", "plane", "sweep", "overlap"];
const OF_TURNS: [&str; 6] = ["axis", "range", "tilt", "ball", "chord", "runs"];

fn build(machine: &Machine, wishes: &Wishes) -> Result<Builder, PlanRefused> {
    let (others, why) = match wishes.variant {
        Some(_) => (&OF_CIRCLES[..], "is for circles, without --variant"),
        None => (&OF_TURNS[..], "is for a turning table, with --variant"),
    };
    if let Some((name, _)) = wishes.given().into_iter().find(|(name, is_given)| *is_given && others.contains(name)) {
        return Err(PlanRefused(format!("--{name} {why}")));
    }
    if let Some(plan) = turned_bar::build(machine, wishes) {
        return plan;
    }
    let tool_mm = wishes.tool_mm();
    let centre_mm = wishes.centre_or_middle(machine, &tool_mm);
    let radius_mm = wishes.radius_mm.unwrap_or(100.0);
    let feed = wishes.feed.unwrap_or(1000.0);
    let every = wishes.every.unwrap_or(2_f64.to_radians()).max(1e-4);
    let mut data = empty(kind("ballbar")?, &[Free::Centre, Free::Length]);
    data.setups.push(Setup { label: "A".into(), centre_mm, length_mm: radius_mm, ..Setup::default() });
    let mut plan = Builder::new(machine, wishes, data);
    let chord = 1_f64.to_radians();
    plan.reach = PlanReach::Sphere { chord, feed };
    let planes = if wishes.planes.is_empty() { vec![Plane::XY, Plane::YZ, Plane::ZX] } else { wishes.planes.clone() };
    let centre = plan.at_tip(&centre_mm, &tool_mm);
    let centre = plan.on_increments(&centre);
    let (which, sign) = along_spindle(machine);
    let mut is_first = true;
    let is_one = planes.len() == 1;
    for plane in planes {
        let [abscissa, _, applicate] = plane.axes();
        let is_across = applicate.dimension() == which;
        let sweep = wishes.sweep.unwrap_or(if is_across { TAU } else { 220_f64.to_radians() }).clamp(1e-3, TAU);
        let overlap = wishes.overlap.unwrap_or(if sweep > TAU - 1e-9 { TAU / 2.0 } else { 20_f64.to_radians() });
        let overlap = overlap.clamp(0.0, TAU);
        // The middle of a partial circle is on the side of the spindle.
        let middle = if abscissa.dimension() == which { 0.0 } else { FRAC_PI_2 };
        let middle = if sign < 0.0 && !is_across { middle + TAU / 2.0 } else { middle };
        let start = if sweep > TAU - 1e-9 { 0.0 } else { middle - sweep / 2.0 };
        let circle = Circle { plane, centre, radius_mm, tool_mm };
        for (sense, from, name) in [(1.0, start, "ccw"), (-1.0, start + sweep, "cw")] {
            let run = format!("{}-{name}", ["XY", "ZX", "YZ"].get(usize::from(plane.number()) - 17).unwrap_or(&""));
            let before = from - sense * overlap;
            let outside = circle.at(before, radius_mm + FEED_IN_MM);
            if is_first {
                plan.stop("remove the ball-bar: the axes go to their first position");
                plan.approach(&outside, feed)?;
                plan.stop("mount the ball-bar");
                is_first = false;
            } else {
                plan.on_sphere(&centre_mm, &tool_mm, &outside, chord, feed)?;
            }
            plan.comment(&run);
            // The machine is at rest before the feed-in.
            plan.dwell(wishes.dwell_s.unwrap_or(DWELL_S));
            plan.go(&circle.at(before, radius_mm), Some(feed))?;
            if overlap > 0.0 {
                circle.sweep(&mut plan, before, sense * overlap, feed)?;
            }
            circle.rows(&mut plan, [from, sense * sweep, every], feed, &run)?;
            circle.sweep(&mut plan, from, sense * sweep, feed)?;
            let end = from + sense * sweep;
            if overlap > 0.0 {
                circle.sweep(&mut plan, end, sense * overlap, feed)?;
            }
            plan.go(&circle.at(end + sense * overlap, radius_mm + FEED_IN_MM), Some(feed))?;
        }
    }
    plan.stop("remove the ball-bar");
    plan.candidates = sphere::candidates(&plan, 0, radius_mm, &tool_mm);
    if !is_one {
        plan.notes.push("the ball-bar must reach all planes of the plan in one mounting".into());
    }
    Ok(plan)
}
