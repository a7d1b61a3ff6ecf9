//! A plate with holes or balls in a square grid: every hole of it, in rows to and fro; one set-up for every tool.

use super::builder::{Builder, Reach, observation};
use super::{PlanKind, Refused, Wishes, empty, kind};
use crate::geometry::Plane;
use crate::machine::{Machine, State};
use crate::measure::data::{Free, Observation, Setup};
use crate::measure::reading::Reading;
use crate::snc::{Dwell, Kind};

/// The plan.
pub(super) const PLAN: PlanKind = PlanKind {
    name: "plate",
    title: "grid of holes in a plane; several tools give several set-ups",
    wishes: &["plane", "centre", "points", "every", "clearance", "feed", "dwell", "line"],
    build,
};

fn build(machine: &Machine, wishes: &Wishes) -> Result<Builder, Refused> {
    let planes = if wishes.planes.is_empty() { vec![Plane::XY] } else { wishes.planes.clone() };
    let &[plane] = planes.as_slice() else {
        return Err(Refused("a plate lies in one plane; make a plan for each".into()));
    };
    let [abscissa, ordinate, _] = plane.axes();
    let side = wishes.points.unwrap_or(5).clamp(2, 200);
    let pitch_mm = wishes.every.unwrap_or(50.0);
    let feed = wishes.feed.unwrap_or(2000.0);
    let tools = if wishes.tools_mm.is_empty() { vec![wishes.tool_mm()] } else { wishes.tools_mm.clone() };
    let mut plan = Builder::new(machine, empty(kind("displacement")?, &[Free::Offset, Free::Rotation]));
    plan.reads = [abscissa, ordinate].iter().fold([false; 3], |mut reads, axis| {
        if let Some(read) = reads.get_mut(axis.dimension()) {
            *read = true;
        }
        reads
    });
    plan.reach = Reach::Above {
        clearance_mm: wishes.clearance_mm.unwrap_or(20.0).max(0.0),
        above_mm: 0.0,
        retract: false,
        feed,
    };
    plan.at_pose = match &wishes.line {
        Some(line) => vec![Kind::Verbatim(line.as_bytes().to_vec())],
        None => vec![Kind::Dwell(Dwell::Seconds(wishes.dwell_s.unwrap_or(3.0)))],
    };
    for (number, tool_mm) in tools.iter().enumerate() {
        let label = format!("T{}", number + 1);
        let centre_mm = wishes.centre_or_middle(machine, tool_mm);
        plan.data.setups.push(Setup {
            label: label.clone(),
            centre_mm: crate::geometry::Vector::zeros(),
            length_mm: 0.0,
        });
        plan.stop(&format!("set-up {label}: clear the way"));
        let at = |column: f64, row: f64| {
            let mut position = plan.at_tip(&centre_mm, tool_mm);
            position[abscissa] += (column - (side - 1) as f64 / 2.0) * pitch_mm;
            position[ordinate] += (row - (side - 1) as f64 / 2.0) * pitch_mm;
            let reading = Reading { position, tool_mm: *tool_mm, state: State::default() };
            observation(reading, number)
        };
        let mut holes: Vec<Observation> = Vec::new();
        for row in 0..side {
            for column in 0..side {
                // To and fro.
                let column = if row.is_multiple_of(2) { column } else { side - 1 - column };
                holes.push(at(column as f64, row as f64));
            }
        }
        // Between the holes.
        let between = (0..(side - 1) * (side - 1))
            .map(|number| at((number % (side - 1)) as f64 + 0.5, (number / (side - 1)) as f64 + 0.5));
        let between: Vec<Observation> = between.collect();
        let inside = |row: &Observation| plan.outside(&row.reading.position).is_none();
        let between: Vec<Observation> = between.into_iter().filter(inside).collect();
        plan.candidates.extend(between);
        for hole in &holes {
            plan.visit(hole, &label)?;
        }
    }
    Ok(plan)
}
