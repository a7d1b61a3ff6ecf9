//! The condition of the machine: `--state` and `--load`.

use crate::diagnostics::Diagnostics;
use crate::disk::files;
use crate::disk::hash::short_hash;
use crate::error::Error;
use crate::machine::Machine;
use crate::options::ConditionFiles;
use crate::stated_zero;
use ncfix_base::csv::Table;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXIS_COUNT, Axis, Vector};
use ncfix_base::source::FileId;
use ncfix_machine::machine::condition::columns::ConditionColumn;
use ncfix_machine::machine::condition::{file, log};
use ncfix_machine::machine::{Condition, Load, ZeroPose};
use ncfix_model::{Effect, ErrorModel};

/// Reads the condition into the machine and reports the inputs of the model that it lacks; returns whether it can be used.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn apply(choice: &ConditionFiles, chosen: &mut Machine, findings: &mut Diagnostics) -> Result<bool, Error> {
    if !read(choice, chosen, findings)? {
        return Ok(false);
    }
    check_state(choice, chosen, findings);
    Ok(check(choice, chosen, &chosen.condition, findings))
}

/// Warns if the temperatures of `--state` have no effect. If nothing else was stated either, the output is the same as without it, and so is its stamp.
fn check_state(choice: &ConditionFiles, chosen: &mut Machine, findings: &mut Diagnostics) {
    if choice.files.is_empty() || !chosen.errors.sensors().is_empty() {
        return;
    }
    let needs_load = chosen.errors.effects_with_heads().any(Effect::needs_load);
    if needs_load && !chosen.condition.has_temperatures() {
        return;
    }
    let message = if needs_load {
        "the machine file has no errors that depend on temperature: the temperatures of --state have no effect"
    } else {
        "the machine file has no errors that depend on temperature or weight: --state has no effect"
    };
    let help = if needs_load {
        "add a drift or an expansion to the machine file, or remove the temperatures"
    } else {
        "add a drift or an expansion to the machine file, or remove --state"
    };
    findings.add(Diagnostic::nowhere(Code::NO_TEMPERATURES, message, help), &[]);
    if !needs_load && choice.load.is_none() && choice.zeros.is_empty() {
        chosen.state = None;
    }
}

/// Reads the condition into the machine; returns whether it is valid.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn read(choice: &ConditionFiles, chosen: &mut Machine, findings: &mut Diagnostics) -> Result<bool, Error> {
    let mut condition = Condition::default();
    let mut parts = Vec::new();
    let mut is_logged = false;
    for path in &choice.files {
        let source = files::read(path, FileId(0), files::option("state, --state"))?;
        let is_table = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
        let is_log = is_table || log::is_log(&source);
        is_logged |= is_log;
        let (read, found) = if is_log { log::load(&source) } else { file::load(&source) };
        findings.extend(found, std::slice::from_ref(&source));
        let Some(read) = read else { return Ok(false) };
        condition.lay_over(read);
        parts.push(short_hash([source.bytes()]));
        chosen.files.push(path.clone());
    }
    set_times(choice, &mut condition, is_logged)?;
    if let Some(command) = choice.zero_at {
        condition.set_zero_pose(ZeroPose { command, tool_mm: Vector::zeros(), direction: [0; AXIS_COUNT] });
    }
    if choice.time_s.is_some() || choice.zero_time_s.is_some() || choice.zero_at.is_some() {
        parts.push(format!("{:?} {:?} {:?}", choice.time_s, choice.zero_time_s, choice.zero_at));
    }
    if let Some(load) = choice.load {
        condition.clear_loads();
        condition.add_load(load);
        parts.push(format!("{load:?}"));
    }
    stated_zero::state(&choice.zeros, chosen)?;
    parts.extend(choice.zeros.iter().map(|zero| format!("{zero:?}")));
    if !parts.is_empty() {
        chosen.state = Some(short_hash(parts.iter().map(String::as_bytes)));
    }
    chosen.condition = condition;
    check_load(choice, chosen, findings);
    Ok(true)
}

/// Withdraws the warnings about temperatures and a load that the rows of a table have themselves.
pub(crate) fn withdraw_answered(table: &Table, errors: &ErrorModel, findings: &mut Diagnostics) {
    let columns = ConditionColumn::all(table);
    let has = |sensor: &&str| columns.contains(&ConditionColumn::Sensor((*sensor).to_owned()));
    if errors.sensors().iter().all(has) {
        findings.withdraw(Code::NO_TEMPERATURES);
    }
    if columns.contains(&ConditionColumn::Force) && errors.effects_with_heads().any(Effect::needs_load) {
        findings.withdraw(Code::NO_LOAD);
    }
}

/// Selects the requested times, which must be in the log.
fn set_times(choice: &ConditionFiles, condition: &mut Condition, is_logged: bool) -> Result<(), Error> {
    let wanted = [("--time", choice.time_s), ("--zero-time", choice.zero_time_s)];
    for (option, time_s) in wanted.into_iter().filter_map(|(option, time_s)| Some((option, time_s?))) {
        if !is_logged {
            return Err(Error::usage(format!("{option} needs a log (CSV with t_s) in --state")));
        }
        let [first, last] = condition.time_range_s().unwrap_or_default();
        if !(first..=last).contains(&time_s) {
            let sentence = format!("{option} {time_s} is outside the log, which runs from {first} to {last} s");
            return Err(Error::usage(sentence));
        }
    }
    if let Some(time_s) = choice.time_s {
        condition.set_time(time_s);
    }
    if let Some(zero_s) = choice.zero_time_s {
        if zero_s > condition.time_s() {
            let now_s = condition.time_s();
            return Err(Error::usage(format!("--zero-time {zero_s} is after the time of the state, {now_s} s")));
        }
        condition.set_zero_at(zero_s);
    }
    Ok(())
}

/// Reports the inputs of the model that the condition lacks; returns whether the condition can be used.
fn check(choice: &ConditionFiles, chosen: &Machine, condition: &Condition, findings: &mut Diagnostics) -> bool {
    let sensors = chosen.errors.sensors();
    let drifting: Vec<&str> =
        chosen.errors.effects_with_heads().filter(|effect| effect.drifts()).flat_map(Effect::sensors).collect();
    let lacks = |condition: &Condition, wanted: &[&str]| -> Vec<String> {
        let missing = wanted.iter().filter(|sensor| condition.temperature_c(sensor, 0.0).is_none());
        missing.map(|&sensor| sensor.to_owned()).collect()
    };
    if !sensors.is_empty() && !condition.has_temperatures() && condition.zero().is_none() {
        let message = format!(
            "no temperatures are given: for the sensors of the error model, the reference temperatures are assumed ({})",
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
                format!("the state has no temperature of {}, which the error model needs", missing.join(", "));
            let help = "add it to --state (and to its [zero]), or correct its name in the machine file";
            findings.add(Diagnostic::nowhere(Code::MISSING_SENSOR, message, help), &[]);
            return false;
        }
    }
    let needs_load = chosen.errors.effects_with_heads().any(Effect::needs_load);
    if needs_load && condition.loads().is_empty() && choice.files.is_empty() {
        let message = "no workpiece weight is given: the table is assumed empty";
        let help = "give --load with the weight in N, 0 for no load, or --state with [[load]]";
        findings.add(Diagnostic::nowhere(Code::NO_LOAD, message, help), &[]);
    }
    true
}

/// Warns if `--load` has no effect, or if a rotary axis turns a load that is off its center.
fn check_load(choice: &ConditionFiles, chosen: &Machine, findings: &mut Diagnostics) {
    let needs_load = chosen.errors.effects_with_heads().any(Effect::needs_load);
    if !needs_load && choice.load.is_some() {
        let message = "the machine file has no data for the weight of workpieces: --load has no effect";
        let help = "add [[load]] to the machine file, or remove --load";
        findings.add(Diagnostic::nowhere(Code::NO_LOAD, message, help), &[]);
    }
    if needs_load && let Some(axis) = turning(&chosen.machine, chosen.condition.loads()) {
        let message =
            format!("{axis} turns a load that is off its center; its position at {axis} = 0 is used throughout");
        let help = format!(
            "give its position, along the axes of the machine, for the position of {axis} in which most is machined"
        );
        findings.add(Diagnostic::nowhere(Code::LOAD_TURNS, message, help), &[]);
    }
}

/// The first rotary axis under the table that moves the center of a load.
fn turning(machine: &ncfix_machine::machine::Machine, loads: &[Load]) -> Option<Axis> {
    // A smaller offset has no effect that can be corrected.
    const CENTERED_MM: f64 = 1.0;
    let is_off = |direction: &Vector| {
        loads.iter().any(|load| load.force_n > 0.0 && load.position_mm.cross(direction).norm() > CENTERED_MM)
    };
    let rotary = machine.topology.workpiece.iter().filter(|axis| axis.is_rotary());
    rotary.copied().find(|&axis| machine.axis(axis).is_some_and(|data| is_off(&data.direction)))
}
