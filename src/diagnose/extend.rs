//! What findings add to the machine file: parameters of the geometry, which are fitted again all together on the full kinematics, and entries
//! for what is no parameter, each with its size and evidence beside it as a comment.

use std::collections::HashMap;
use std::fmt::Write as _;

use crate::geometry::{AXES, Axis, AxisVector};
use crate::model::ParameterName;
use crate::model::name::{ErrorKind, ErrorName};
use crate::units::{um_from_mm, urad_from_rad};

use super::cause::{Candidate, Effect, Term};
use super::row::Row;
use super::scene::{Scene, Through};
use super::size::weights_at;
use super::verdict::{Diagnosis, Finding};

/// A line that says what a diagnosis added begins with this.
pub const HEAD: &str = "# diagnosed:";
/// A chance below this is not said more exactly.
const LEAST_CHANCE: f64 = 1e-12;
/// Points of a table along an axis.
const POINTS: usize = 9;
/// Parts in a million: µm/(m K).
const MILLION: f64 = 1e6;

/// What is added.
#[derive(Clone, Debug, Default)]
pub struct Extension {
    /// Entries behind the text of the machine file.
    pub entries: String,
    /// Parameters, their amounts in mm, rad per power, and what is said beside them.
    pub parameters: Vec<(ParameterName, f64, String)>,
    /// For every finding of the diagnosis: whether the machine file can hold it.
    pub holds: Vec<bool>,
}

/// What the findings of a diagnosis add. The first measurements of the scene were `used`.
#[must_use]
pub fn extension(found: &Diagnosis, scene: &Scene<'_>, used: usize) -> Extension {
    let mut out = Extension::default();
    let mut drifts: HashMap<String, Vec<(String, String)>> = HashMap::new();
    for one in &found.findings {
        let holds = parameters(one, &mut out.parameters)
            || entry(one, scene, used, &mut out.entries)
            || drift(one, &mut drifts);
        out.holds.push(holds);
    }
    let mut directions: Vec<_> = drifts.into_iter().collect();
    directions.sort();
    for (direction, terms) in directions {
        out.entries.push('\n');
        let sensors: Vec<String> = terms
            .into_iter()
            .map(|(sensor, evidence)| {
                let _ = writeln!(out.entries, "{evidence}");
                sensor
            })
            .collect();
        let _ = writeln!(out.entries, "[[drift]]\ndirection = \"{direction}\"\nsensors = [{}]", sensors.join(", "));
    }
    out
}

/// What is said beside an entry.
fn evidence(one: &Finding) -> String {
    let rivals: Vec<String> =
        one.class.iter().skip(1).take(3).map(|(cause, parameter)| format!("{} {parameter}", cause.effect)).collect();
    let mut out = format!(
        "{HEAD} {} {} {:.4} ± {:.2} {} (95 %); {:.0} % less is left of unseen readings; chance {}",
        one.candidate.cause.effect,
        one.candidate.parameter,
        one.size.value,
        one.size.u95,
        one.size.unit,
        100.0 * one.gain_unseen,
        if one.chance < LEAST_CHANCE { "next to none".to_owned() } else { format!("{:.0e}", one.chance) }
    );
    if !rivals.is_empty() {
        let _ = write!(out, "; not told from {}", rivals.join(", "));
    }
    out.replace(char::is_control, " ")
}

fn parameters(one: &Finding, out: &mut Vec<(ParameterName, f64, String)>) -> bool {
    let Term::Parameters(names) = &one.candidate.term else { return false };
    let line = evidence(one);
    for (name, &amount) in names.iter().zip(&one.amounts.values) {
        // What depends on the others is 0 and stays so.
        if amount != 0.0 {
            out.push((*name, amount, line.clone()));
        }
    }
    true
}

/// The component through which all columns act, where there is one.
fn component(candidate: &Candidate) -> Option<ErrorName> {
    let mut all = candidate.columns.iter().flatten().map(|(through, _)| *through);
    let Through::Component(name) = all.next()? else { return None };
    (candidate.columns.iter().all(|parts| parts.len() == 1) && all.all(|own| own == Through::Component(name)))
        .then_some(name)
}

/// The ends of the positions that were used.
fn travel(scene: &Scene<'_>, used: usize) -> Option<(Row, [AxisVector; 2])> {
    let mut rows = scene.rows.iter().filter(|row| row.set < used);
    let first = rows.next()?.clone();
    let mut ends = [first.position, first.position];
    for row in rows {
        for axis in AXES {
            ends[0][axis] = ends[0][axis].min(row.position[axis]);
            ends[1][axis] = ends[1][axis].max(row.position[axis]);
        }
    }
    Some((first, ends))
}

/// An entry of its own: what depends on places and senses alone, and the growth of a scale.
fn entry(one: &Finding, scene: &Scene<'_>, used: usize, out: &mut String) -> bool {
    let candidate = &one.candidate;
    let Some(name) = component(candidate) else { return false };
    let Some(axis) = name.axis().filter(|_| name.kind == ErrorKind::Motion) else { return false };
    let Some(body) = (match candidate.cause.effect {
        Effect::Periodic => periodic(one, axis, name),
        Effect::ThermalExpansion => return expansion(one, axis, scene, out),
        _ => placed(one, axis, name, scene, used),
    }) else {
        return false;
    };
    let _ = write!(out, "\n{}\n[[motion]]\ncomponent = \"{name}\"\n{body}", evidence(one));
    true
}

fn unit_of(name: ErrorName) -> (f64, &'static str) {
    if name.direction.is_rotation() { (urad_from_rad(1.0), "urad") } else { (um_from_mm(1.0), "um") }
}

fn periodic(one: &Finding, axis: Axis, name: ErrorName) -> Option<String> {
    let ([sine, cosine], Some((period, _))) = (one.amounts.values.as_slice(), one.candidate.constant) else {
        return None;
    };
    let (factor, unit) = unit_of(name);
    let key = if axis.is_rotary() { "period_deg" } else { "period_mm" };
    Some(format!(
        "kind = \"periodic\"\n{key} = {period}\namplitude_{unit} = {:.6}\nphase_deg = {:.4}\n",
        factor * sine.hypot(*cosine),
        cosine.atan2(*sine).to_degrees()
    ))
}

/// Tables over one or two axes, and play that changes along the axis.
fn placed(one: &Finding, axis: Axis, name: ErrorName, scene: &Scene<'_>, used: usize) -> Option<String> {
    let candidate = &one.candidate;
    let (row, [low, high]) = travel(scene, used)?;
    let own_sense = format!("{axis}_dir");
    let has_sense = candidate.drivers.contains(&own_sense);
    let mut others = Vec::new();
    for driver in candidate.drivers.iter().filter(|driver| **driver != own_sense && **driver != axis.to_string()) {
        others.push(AXES.into_iter().find(|axis| axis.to_string() == *driver)?);
    }
    if !candidate.drivers.contains(&axis.to_string()) && !has_sense || candidate.sensor.is_some() {
        return None;
    }
    let (factor, unit) = unit_of(name);
    let at = |set: &[(Axis, f64)], sense: i8| {
        let mut row = row.clone();
        row.sense[axis.slot()] = sense;
        set.iter().for_each(|&(axis, value)| row.position[axis] = value);
        let weights = weights_at(candidate, &row);
        factor * weights.iter().zip(&one.amounts.values).map(|(weight, amount)| weight * amount).sum::<f64>()
    };
    let nodes = |axis: Axis, count: usize| -> Vec<f64> {
        (0..count).map(|k| low[axis] + (high[axis] - low[axis]) * k as f64 / (count - 1) as f64).collect()
    };
    let shown = |axis: Axis, nodes: &[f64]| {
        let of = |value: &f64| format!("{:.6}", if axis.is_rotary() { value.to_degrees() } else { *value });
        nodes.iter().map(of).collect::<Vec<_>>().join(", ")
    };
    let key = |axis: Axis| if axis.is_rotary() { "positions_deg" } else { "positions_mm" };
    let list = |values: Vec<f64>| values.iter().map(|value| format!("{value:.6}")).collect::<Vec<_>>().join(", ");
    if high[axis] <= low[axis] {
        return None;
    }
    let own = nodes(axis, POINTS);
    let positions = format!("{} = [{}]\n", key(axis), shown(axis, &own));
    match others.as_slice() {
        [] if has_sense => {
            // What turns over with the sense is play: the whole of it.
            let is_odd = own.iter().all(|&place| {
                let [up, down] = [1, -1].map(|sense| at(&[(axis, place)], sense));
                (up + down).abs() <= 1e-9 * up.abs().max(down.abs())
            });
            let values = own.iter().map(|&place| 2.0 * at(&[(axis, place)], 1)).collect();
            is_odd.then(|| format!("kind = \"backlash\"\n{positions}values_{unit} = [{}]\n", list(values)))
        }
        [] => {
            let values = own.iter().map(|&place| at(&[(axis, place)], 0)).collect();
            Some(format!("kind = \"table\"\n{positions}values_{unit} = [{}]\n", list(values)))
        }
        [other] if !has_sense && high[*other] > low[*other] => {
            let across = nodes(*other, POINTS);
            let line = |&place: &f64| {
                let values = across.iter().map(|&with| at(&[(axis, place), (*other, with)], 0)).collect();
                format!("[{}]", list(values))
            };
            let rows: Vec<String> = own.iter().map(line).collect();
            Some(format!(
                "kind = \"grid\"\n{positions}with = \"{other}\"\nwith_{} = [{}]\nvalues_{unit} = [{}]\n",
                key(*other),
                shown(*other, &across),
                rows.join(", ")
            ))
        }
        _ => None,
    }
}

/// The name of a sensor by its column.
fn sensor_of(candidate: &Candidate) -> Option<&str> {
    let column = candidate.sensor.as_deref()?;
    Some(column.strip_suffix("_C").unwrap_or(column))
}

fn lag_of(candidate: &Candidate) -> String {
    match candidate.constant {
        Some((lag, "s")) => format!(", lag_s = {lag}"),
        _ => String::new(),
    }
}

fn expansion(one: &Finding, axis: Axis, scene: &Scene<'_>, out: &mut String) -> bool {
    let (Some(sensor), [amount], Some(data)) =
        (sensor_of(&one.candidate), one.amounts.values.as_slice(), scene.machine.axis(axis))
    else {
        return false;
    };
    let share = data.direction[axis.dimension()];
    if share == 0.0 || axis.is_rotary() {
        return false;
    }
    let _ = write!(
        out,
        "\n{}\n[[expansion]]\naxis = \"{axis}\"\nfixed_mm = 0\nscale = {{ sensors = [\"{sensor}\"], um_per_m_K = {:.6}{} }}\n",
        evidence(one),
        MILLION * amount / share,
        lag_of(&one.candidate)
    );
    true
}

fn drift(one: &Finding, drifts: &mut HashMap<String, Vec<(String, String)>>) -> bool {
    let (Effect::ThermalDrift, Some(sensor), [amount]) =
        (one.candidate.cause.effect, sensor_of(&one.candidate), one.amounts.values.as_slice())
    else {
        return false;
    };
    let mut all = one.candidate.columns.iter().flatten();
    let (Some((Through::Tip(direction), _)), None) = (all.next(), all.next()) else { return false };
    if one.candidate.drivers.len() != 1 {
        return false;
    }
    let term = format!("{{ name = \"{sensor}\", um_per_K = {:.6}{} }}", um_from_mm(*amount), lag_of(&one.candidate));
    let letter = ["X", "Y", "Z"].get(*direction).copied().unwrap_or("Z");
    drifts.entry(letter.to_owned()).or_default().push((term, evidence(one)));
    true
}

/// A text with what is said beside parameters: above their lines where these are found, else in front of all.
#[must_use]
pub fn noted(text: &str, parameters: &[(ParameterName, f64, String)]) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut told: Vec<&str> = Vec::new();
    for (name, _, note) in parameters {
        if told.contains(&note.as_str()) {
            continue;
        }
        told.push(note);
        let component = name.component.to_string();
        let is_own = |line: &String| {
            let line = line.trim_start();
            if name.component.kind == ErrorKind::Location {
                line.strip_prefix(&component).is_some_and(|rest| rest.trim_start().starts_with('='))
            } else {
                line.strip_prefix("component").is_some_and(|rest| {
                    rest.trim_start().strip_prefix('=').is_some_and(|rest| rest.contains(&format!("\"{component}\"")))
                })
            }
        };
        let is_entry = |line: &String| line.trim_start().starts_with("[[motion]]");
        let found: Vec<usize> = (0..lines.len()).filter(|&k| lines.get(k).is_some_and(is_own)).collect();
        // The last one is the one that was added; above its head.
        let place = found.last().map(|&line| {
            if name.component.kind == ErrorKind::Location {
                return line;
            }
            (0..=line).rev().find(|&k| lines.get(k).is_some_and(is_entry)).unwrap_or(line)
        });
        lines.insert(place.unwrap_or(0), note.clone());
    }
    let mut out = lines.join("\n");
    out.push('\n');
    out
}
