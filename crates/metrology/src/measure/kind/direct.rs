//! Direct measurement of one component at a time: laser interferometer, level, autocollimator, straightedge.
//!
//! `component` names the measured component, `value_um` or `value_urad` its value: the deviation of the body that the axis moves, at the point of
//! measurement given by the tool vector. A displacement thus contains the angular errors with their Abbe arms (Spaan 1995, ch. 3). `offset` frees the
//! zero of the instrument for every set-up and component, and `slope` its alignment in a straightness: the angle between the optics or the straightedge and
//! the axis is not an error of the machine. A location error (`EC0Y`) is read itself ([`super::location`]). `drift` adds a drift that is linear in time within every back-and-forth cycle, each with
//! its own zero, if there is no reversal error (see [`crate::measure::iso230::drift`]).

use std::collections::HashMap;

use super::{Equation, Instrument, Measurand, Seen, Unknown, at, location, needed, no_ties, optional, zeros};
use crate::measure::data::{DataSet, Free, Observation, number_of, text};
use crate::measure::iso230::drift;
use crate::measure::iso230::positioning::ApproachReading;
use ncfix_base::csv::{DecimalSign, Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::Axis;
use ncfix_base::units::{mm_from_um, rad_from_urad, um_from_mm, urad_from_rad};
use ncfix_machine::machine::Branch;
use ncfix_model::ErrorName;

/// The kind.
pub(super) const KIND: Instrument = Instrument {
    name: "direct",
    title: "one error component at a time",
    measurand: Measurand::Component,
    free: &[Free::Offset, Free::Drift, Free::Slope],
    read,
    check,
    unknowns,
    start: zeros,
    equations,
    ties: no_ties,
    temperature: None,
    columns: &["component", "value_um", "value_urad"],
};

fn read(data: &mut DataSet, row: &Row<'_>, sign: DecimalSign, observation: &mut Observation) -> Result<(), Diagnostic> {
    let column = needed(row, "component")?;
    let name = text(row, column);
    let Ok(component) = name.parse::<ErrorName>() else {
        let help = "write a motion error such as EXX, EYX or EAX, or a location error such as EC0Y";
        return Err(Diagnostic::at(
            Code::DATA_CELL,
            row.place(column),
            format!("'{name}' is not an error component"),
            help,
        ));
    };
    observation.component = Some(component);
    observation.target = Some(number_of(&mut data.targets, &name));
    if data.is_plan {
        observation.values[0] = Some(0.0);
        return Ok(());
    }
    let is_rotation = component.direction.is_rotation();
    let (own, other) = if is_rotation { ("value_urad", "value_um") } else { ("value_um", "value_urad") };
    let column = needed(row, own)?;
    if row.column(other).is_some_and(|column| !row.text(column).is_empty()) {
        let message = format!("{name} has no {other}");
        return Err(Diagnostic::at(Code::DATA_CELL, row.place(column), message, format!("write it in {own}")));
    }
    let value = optional(row, Some(column), sign)?;
    observation.values[0] = value.map(if is_rotation { rad_from_urad } else { mm_from_um });
    Ok(())
}

fn unknowns(data: &DataSet) -> Vec<Unknown> {
    let zeros = (0..zeros_of_setups(data)).map(|which| Unknown::Offset(which, 0));
    let levels = data.cycles.iter().enumerate().filter(|(_, cycle)| cycle.level.is_some());
    let drifts = (0..data.cycles.len()).map(Unknown::Drift);
    let slopes = slopes(data).into_iter().map(Unknown::Slope);
    zeros.chain(drifts).chain(levels.map(|(number, _)| Unknown::Level(number))).chain(slopes).collect()
}

/// Set-ups and components with a free alignment, counted as the zeros are: the straightnesses, because only a displacement across an axis increases along it
/// by an angle.
fn slopes(data: &DataSet) -> Vec<usize> {
    if !data.free.contains(&Free::Slope) {
        return Vec::new();
    }
    let count = data.targets.len();
    let is_straightness = |place: &usize| data.targets[place % count].parse::<ErrorName>().is_ok_and(is_straightness);
    (0..data.setups.len() * count).filter(is_straightness).collect()
}

/// True for a displacement of a linear axis across its direction.
pub(crate) fn is_straightness(name: ErrorName) -> bool {
    let is_across = |axis: Axis| !axis.is_rotary() && axis.dimension() != name.direction.index() % 3;
    !name.direction.is_rotation() && name.axis().is_some_and(is_across)
}

fn zeros_of_setups(data: &DataSet) -> usize {
    if data.free.contains(&Free::Offset) { data.setups.len() * data.targets.len() } else { 0 }
}

/// Checks readings with a drift for a reversal error, which cannot be separated from it.
fn check(data: &DataSet, _: &Table, findings: &mut Vec<Diagnostic>) {
    if data.is_plan || data.cycles.is_empty() {
        return;
    }
    let mut groups: HashMap<(usize, usize), (Place, Vec<ApproachReading>)> = HashMap::new();
    for row in &data.observations {
        let (Some((number, time)), Some(deviation)) = (row.cycle, row.values[0]) else { continue };
        let (Some(cycle), Some(axis)) = (data.cycles.get(number), row.component.and_then(|name| name.axis())) else {
            continue;
        };
        let (_, own) = groups.entry((cycle.setup, cycle.target)).or_insert_with(|| (row.place, Vec::new()));
        let sense = row.reading.state.direction(axis);
        if sense == 0 {
            continue;
        }
        let target = row.reading.position[axis];
        own.push(ApproachReading { target, deviation, is_up: sense > 0, cycle: cycle.number - 1, time });
    }
    let mut groups: Vec<_> = groups.into_iter().collect();
    groups.sort_by_key(|(key, _)| *key);
    for ((_, target), (place, own)) in groups {
        let name = data.targets.get(target).map_or("", String::as_str);
        let message = match drift::significant_reversal(&own) {
            Ok(None) => continue,
            Ok(Some((value, sigma))) => {
                let is_rotation = name.parse::<ErrorName>().is_ok_and(|name| name.direction.is_rotation());
                let (unit, factor) = if is_rotation { ("µrad", urad_from_rad(1.0)) } else { ("µm", um_from_mm(1.0)) };
                let [value, sigma] = [value * factor, sigma * factor];
                format!(
                    "the two directions of {name} differ by a reversal value of {value:.2} ± {sigma:.2} {unit}, which is not a drift"
                )
            }
            Err(fault) => format!("{name}: {fault}"),
        };
        let help = "remove \"drift\" from free; measure fast, or with the machine warm, if the axis has backlash";
        findings.push(Diagnostic::at(Code::DRIFT_NOT_TOLD, place, message, help));
    }
}

fn equations(data: &DataSet, observation: &Observation, seen: &Seen<'_>, values: &[f64], out: &mut Vec<Equation>) {
    let (Some(read), Some(component)) = (observation.values[0], observation.component) else { return };
    if component.is_location() {
        let by_location = location::parts(seen.machine, component);
        let is_angle = component.direction.is_rotation();
        let (predicted, by_path) = location::angle(&data.ranges, &observation.reading, seen, component)
            .or_else(|| location::average_line(&data.ranges, &observation.reading, seen, component))
            .unwrap_or_else(|| {
                let parts = by_location.iter().flatten();
                (parts.map(|(name, factor)| factor * seen.model.location(*name)).sum(), Vec::new())
            });
        out.push(Equation { residual: read - predicted, by_location, by_path, is_angle, ..Equation::default() });
        return;
    }
    // The moving body: relative to the tool on the workpiece side.
    let on_table = component.axis().and_then(|axis| seen.machine.topology.branch(axis)) == Some(Branch::Workpiece);
    let sense = if on_table { -1.0 } else { 1.0 };
    let k = component.direction.index() % 3;
    let mut equation = Equation::default();
    let direction = seen.direction(k) * sense;
    let mut predicted = if component.direction.is_rotation() {
        equation.by_turn = direction;
        equation.is_angle = true;
        seen.turn()[k] * sense
    } else {
        equation.by_tip = direction;
        seen.displacement()[k] * sense
    };
    if data.free.contains(&Free::Offset) {
        let place = observation.setup * data.targets.len() + observation.target.unwrap_or(0);
        predicted += at(values, place);
        equation.by_unknown.push((place, 1.0));
    }
    if let Some((number, time)) = observation.cycle {
        let place = zeros_of_setups(data) + number;
        predicted += at(values, place) * time;
        equation.by_unknown.push((place, time));
        if let Some(level) = data.cycles.get(number).and_then(|cycle| cycle.level) {
            let place = zeros_of_setups(data) + data.cycles.len() + level;
            predicted += at(values, place);
            equation.by_unknown.push((place, 1.0));
        }
    }
    let own = observation.setup * data.targets.len() + observation.target.unwrap_or(0);
    let slopes = slopes(data);
    if let (Some(number), Some(axis)) = (slopes.iter().position(|place| *place == own), component.axis()) {
        let levels = data.cycles.iter().filter(|cycle| cycle.level.is_some()).count();
        let place = zeros_of_setups(data) + data.cycles.len() + levels + number;
        let way = observation.reading.position[axis];
        predicted += at(values, place) * way;
        equation.by_unknown.push((place, way));
    }
    equation.residual = read - predicted;
    out.push(equation);
}
