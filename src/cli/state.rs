//! The condition of the machine: `--state` and `--load`.

use super::arguments::StateChoice;
use super::findings::Findings;
use super::input;
use super::machine_choice::{Chosen, short_hash};
use super::stop::Stop;
use crate::diagnostic::{Code, Diagnostic};
use crate::geometry::{Axis, Vector};
use crate::machine::condition::{file, log};
use crate::machine::{Condition, Load, Machine};
use crate::model::Effect;
use crate::source::{FileId, Source};

/// Reads the condition into the machine; whether it can be used.
///
/// # Errors
/// Where the file cannot be read.
pub(super) fn apply(choice: &StateChoice, chosen: &mut Chosen, findings: &mut Findings) -> Result<bool, Stop> {
    let mut condition = Condition::default();
    let mut parts = vec![chosen.hash.clone()];
    if let Some(path) = &choice.state {
        let source = input::read(path, FileId(0))?;
        let (read, found) = load(&source);
        findings.extend(found, std::slice::from_ref(&source));
        let Some(read) = read else { return Ok(false) };
        condition = read;
        if let Some(time_s) = choice.time {
            condition.set_time(time_s);
        }
        if let Some(time_s) = choice.zero_time {
            condition.set_zero_at(time_s);
        }
        parts.push(short_hash([source.bytes()]));
        parts.push(format!("{:?} {:?}", choice.time, choice.zero_time));
        chosen.files.push(path.clone());
    }
    if let Some(load) = choice.load {
        condition.clear_loads();
        condition.add_load(load);
        parts.push(format!("{load:?}"));
    }
    if parts.len() > 1 {
        // The same machine in another condition is corrected in another way.
        chosen.hash = short_hash(parts.iter().map(String::as_bytes));
    }
    let is_sound = check(choice, chosen, &condition, findings);
    chosen.condition = condition;
    Ok(is_sound)
}

fn load(source: &Source) -> (Option<Condition>, Vec<Diagnostic>) {
    if log::is_log(source) { log::load(source) } else { file::load(source) }
}

/// Says what the model needs and the condition lacks; whether the condition can be used.
fn check(choice: &StateChoice, chosen: &Chosen, condition: &Condition, findings: &mut Findings) -> bool {
    let sensors = chosen.errors.sensors();
    let drifting: Vec<&str> =
        chosen.errors.effects().filter(|effect| effect.drifts()).flat_map(Effect::sensors).collect();
    let lacks = |condition: &Condition, wanted: &[&str]| -> Vec<String> {
        let missing = wanted.iter().filter(|sensor| condition.temperature_c(sensor, 0.0).is_none());
        missing.map(|&sensor| sensor.to_owned()).collect()
    };
    if !sensors.is_empty() && !condition.has_temperatures() {
        let message = format!(
            "no temperatures are given: the {} sensors of the error model count as at their reference temperatures ({})",
            sensors.len(),
            sensors.join(", ")
        );
        let help = "give --state with the temperatures of these sensors";
        findings.add(Diagnostic::nowhere(Code::NO_TEMPERATURES, message, help), &[]);
    } else if !sensors.is_empty() {
        let mut missing = lacks(condition, &sensors);
        if let Some(zero) = condition.zero() {
            missing.extend(lacks(zero, &drifting));
        }
        missing.sort_unstable();
        missing.dedup();
        if !missing.is_empty() {
            let message =
                format!("the state has no temperature of {}, and the error model needs it", missing.join(", "));
            let help = "add it to --state (and to its [zero]), or correct its name in the machine file";
            findings.add(Diagnostic::nowhere(Code::MISSING_SENSOR, message, help), &[]);
            return false;
        }
    }
    let needs_load = chosen.errors.effects().any(Effect::needs_load);
    if needs_load && condition.loads().is_empty() && choice.state.is_none() {
        let message = "no workpiece weight is given: the table is taken as empty";
        let help = "give --load with the weight in N, 0 for none, or --state with [[load]]";
        findings.add(Diagnostic::nowhere(Code::NO_LOAD, message, help), &[]);
    }
    if needs_load && let Some(axis) = turning(&chosen.machine, condition.loads()) {
        let message = format!(
            "{axis} turns a load that is off its center; the load counts where it stands with {axis} at 0 throughout"
        );
        let help = format!(
            "give the place in the position of {axis} in which most is machined, along the axes of the machine"
        );
        findings.add(Diagnostic::nowhere(Code::LOAD_TURNS, message, help), &[]);
    }
    true
}

/// The first rotary axis under the table that moves the center of a load.
fn turning(machine: &Machine, loads: &[Load]) -> Option<Axis> {
    // What is nearer changes no error that can be corrected.
    const CENTERED_MM: f64 = 1.0;
    let is_off = |direction: &Vector| {
        loads.iter().any(|load| load.force_n > 0.0 && load.position_mm.cross(direction).norm() > CENTERED_MM)
    };
    let rotary = machine.topology.workpiece.iter().filter(|axis| axis.is_rotary());
    rotary.copied().find(|&axis| machine.axis(axis).is_some_and(|data| is_off(&data.direction)))
}
