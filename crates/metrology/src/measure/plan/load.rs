//! Effect of a weight on the table: level or plate readings without it, with every weight at every position, and without it again.
//!
//! `level`: angles of an axis along its travel, back and forth (Spaan 1995, ch. 4: levels on the moving table under weights). `plate`: a grid of
//! holes. The instrument stays in one set-up, so that the readings contain the whole effect of the weight.

use super::builder::{Builder, Extra};
use super::plate::PlannedPlate;
use super::{PlanKind, PlanRefused, RowSpacing, Wishes, empty, kind};
use crate::measure::data::{Free, Setup, number_of};
use ncfix_base::geometry::{Axis, Vector};
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorName;
use ncfix_model::name::{Carrier, ErrorKind};

/// The plan.
pub(super) const PLAN: PlanKind = PlanKind {
    name: "load",
    title: "weights on the table at several positions: variants level (an axis), plate (grid of holes)",
    wishes: &[
        "force",
        "place",
        "variant",
        "axis",
        "component",
        "range",
        "points",
        "runs",
        "center",
        "plane",
        "every",
        "clearance",
        "feed",
        "dwell",
        "line",
    ],
    spacing: RowSpacing::Length,
    has_setups: false,
    build,
};

/// A weight, N, and its position, mm.
type Load = (f64, Vector);

fn build(machine: &Machine, wishes: &Wishes) -> Result<Builder, PlanRefused> {
    if wishes.forces_n.is_empty() {
        return Err(PlanRefused("the weights are missing; give --force N for each, for example --force 2000".into()));
    }
    let places = if wishes.places_mm.is_empty() { vec![Vector::zeros()] } else { wishes.places_mm.clone() };
    let none: Load = (0.0, Vector::zeros());
    let weights = places.iter().flat_map(|place| wishes.forces_n.iter().map(|force| (*force, *place)));
    let loads: Vec<Load> = std::iter::once(none).chain(weights).chain([none]).collect();
    let mut plan = match wishes.variant.as_deref() {
        None | Some("level") => level(machine, wishes, &loads)?,
        Some("plate") => plate(machine, wishes, &loads)?,
        Some(other) => {
            return Err(PlanRefused(format!("unknown readings '{other}'; the variants are level, plate")));
        }
    };
    plan.is_geometric = false;
    if wishes.places_mm.is_empty() {
        plan.notes.push("the weights are assumed at 0,0,0; give --place X,Y,Z for each place".into());
    }
    Ok(plan)
}

/// Stops for placing the weight of a round. Returns its label.
fn put(plan: &mut Builder, number: usize, (force_n, place_mm): Load) -> Result<String, PlanRefused> {
    plan.retract()?;
    plan.load = Some((force_n, place_mm));
    let [x, y, z] = [place_mm.x, place_mm.y, place_mm.z];
    let text = if force_n > 0.0 {
        format!("put {force_n} N on the table at {x} {y} {z}")
    } else {
        "no weight on the table".into()
    };
    plan.stop(&text);
    Ok(format!("L{number}"))
}

fn plate(machine: &Machine, wishes: &Wishes, loads: &[Load]) -> Result<Builder, PlanRefused> {
    let tool_mm = wishes.tool_mm();
    let centre_mm = wishes.centre_or_middle(machine, &tool_mm);
    let mut grid = PlannedPlate::new(machine, wishes)?;
    let setup = grid.mount("A", &centre_mm, &tool_mm);
    for (number, load) in loads.iter().enumerate() {
        let run = put(&mut grid.plan, number, *load)?;
        grid.visit(setup, &centre_mm, &tool_mm, &run)?;
    }
    Ok(grid.plan)
}

fn level(machine: &Machine, wishes: &Wishes, loads: &[Load]) -> Result<Builder, PlanRefused> {
    let axis = wishes.axis.unwrap_or(Axis::X);
    let data = machine.axis(axis).ok_or_else(|| PlanRefused(format!("{} has no axis {axis}", machine.name)))?;
    let components = if wishes.components.is_empty() { vec![roll(axis)?] } else { wishes.components.clone() };
    if let Some(other) = components
        .iter()
        .find(|component| component.kind != ErrorKind::Motion || component.carrier != Carrier::Axis(axis))
    {
        return Err(PlanRefused(format!(
            "{other} is not a motion error of {axis}; give for example EA{axis} or EB{axis}"
        )));
    }
    let margin = if axis.is_rotary() { 0.0 } else { wishes.margin_mm() };
    let [low, high] = wishes
        .range
        .or_else(|| data.travel.map(|[low, high]| [low + margin, high - margin]))
        .filter(|[low, high]| high > low)
        .ok_or_else(|| PlanRefused(format!("{axis} has no range of travel; give --range FROM,TO")))?;
    let count = wishes.points.unwrap_or(8).clamp(2, 10_000);
    let tool_mm = wishes.tool_mm();
    let feed = wishes.feed.unwrap_or(1000.0);
    let dwell_s = wishes.dwell_s.unwrap_or(4.0);
    let mut set = empty(kind("direct")?, &[Free::Offset]);
    set.setups.push(Setup { label: "A".into(), ..Setup::default() });
    let numbers: Vec<usize> =
        components.iter().map(|component| number_of(&mut set.targets, &component.to_string())).collect();
    let mut plan = Builder::new(machine, wishes, set);
    let centre_mm = wishes.centre_or_middle(machine, &tool_mm);
    let mut pose = plan.at_tip(&centre_mm, &tool_mm);
    for (number, load) in loads.iter().enumerate() {
        let name = put(&mut plan, number, *load)?;
        pose[axis] = low;
        plan.approach(&pose, feed)?;
        for run in 1..=wishes.runs.unwrap_or(1).clamp(1, 1000) {
            for is_back in [false, true] {
                let label = format!("{name}.{run}{}", if is_back { "-" } else { "+" });
                for place in 0..count {
                    let place = if is_back { count - 1 - place } else { place };
                    pose[axis] = low + (high - low) * place as f64 / (count - 1) as f64;
                    plan.go(&pose, Some(feed))?;
                    let Some(here) = plan.last() else { continue };
                    for (component, target) in components.iter().zip(&numbers) {
                        let extra = Extra { run: label.clone(), feed: Some(feed), ..Extra::default() };
                        plan.row(&here, tool_mm, 0, extra)?;
                        plan.of_last(Some(*target), Some(*component));
                    }
                    plan.dwell(dwell_s);
                }
            }
        }
    }
    Ok(plan)
}

/// The roll of an axis, which a level across a horizontal axis reads.
fn roll(axis: Axis) -> Result<ErrorName, PlanRefused> {
    let letter = ["A", "B", "C"].get(axis.dimension()).copied().unwrap_or("A");
    format!("E{letter}{axis}").parse().map_err(|_| PlanRefused(format!("there is no roll of {axis}")))
}
