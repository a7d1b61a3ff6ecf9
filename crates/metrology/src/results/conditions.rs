//! Temperatures, loads and drifts in measurements, compared with the needs of the machine's errors.

use super::measurement::Measurement;
use crate::calibrate::{Parameter, reversals};
use crate::measure::data::DataSet;
use ncfix_base::csv::Table;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_machine::machine::Condition;
use ncfix_machine::machine::condition::columns::ConditionColumn;
use ncfix_model::{Effect, ErrorModel};

/// Reports missing sensors and loads: an error if a fitted parameter needs them and no table has them, otherwise a note that an effect is in its
/// reference state.
pub(super) fn check(
    (errors, base): (&ErrorModel, &Condition),
    all: &[Measurement],
    parameters: &[Parameter],
    findings: &mut Vec<Diagnostic>,
) {
    let columns: Vec<Vec<ConditionColumn>> = all
        .iter()
        .map(|one| Table::read(&one.sources[0]).0.map(|table| ConditionColumn::all(&table)).unwrap_or_default())
        .collect();
    let has_sensor = |columns: &[ConditionColumn], sensor: &str| {
        base.trace(sensor).is_some()
            || columns.iter().any(|column| matches!(column, ConditionColumn::Sensor(name) if name == sensor))
    };
    let mut wanted: Vec<&str> = Vec::new();
    for parameter in parameters {
        let Parameter::Effect(parameter) = parameter else { continue };
        let Some(effect) = parameter.effect(errors) else { continue };
        // A parameter of one sensor contains its name.
        let sensors = effect.sensors();
        let last = parameter.name().split('.').nth(2).unwrap_or_default();
        let own = sensors.iter().copied().filter(|sensor| last.split('~').next() == Some(*sensor));
        let own: Vec<&str> = own.collect();
        wanted.extend(if own.is_empty() { sensors } else { own });
        if effect.needs_load()
            && base.loads().is_empty()
            && !columns.iter().any(|columns| columns.contains(&ConditionColumn::Force))
        {
            let message = format!("{} depends on the weight of workpieces, but no table has load_N", parameter.name());
            let help = "add load_N and the position of the load, load_x_mm load_y_mm load_z_mm, to the tables";
            findings.push(Diagnostic::nowhere(Code::NOT_TOLD, message, help));
            return;
        }
    }
    wanted.sort_unstable();
    wanted.dedup();
    let missing: Vec<&str> =
        wanted.into_iter().filter(|sensor| !columns.iter().any(|columns| has_sensor(columns, sensor))).collect();
    if !missing.is_empty() {
        let names = missing.join(", ");
        let message = format!("no table has the temperature of {names}, which the fitted parameters need");
        let help =
            "add a column with the name of the sensor and the ending _C, or correct the name in the machine file";
        findings.push(Diagnostic::nowhere(Code::MISSING_SENSOR, message, help));
        return;
    }
    let known = errors.sensors();
    let needs_load = errors.effects().any(Effect::needs_load);
    for (one, columns) in all.iter().zip(&columns) {
        let missing: Vec<&str> = known.iter().copied().filter(|sensor| !has_sensor(columns, sensor)).collect();
        let name = &one.data.name;
        if !missing.is_empty() {
            let message =
                format!("{name}: no temperature of {}: the reference temperatures are assumed", missing.join(", "));
            let unknown = columns.iter().find_map(|column| match column {
                ConditionColumn::Sensor(sensor) if !known.contains(&sensor.as_str()) => Some(sensor),
                _ => None,
            });
            let help = match unknown {
                Some(sensor) => format!(
                    "add columns with the name of the sensor and the ending _C; no effect uses the column {sensor}_C"
                ),
                None => "add columns with the name of the sensor and the ending _C".to_owned(),
            };
            findings.push(Diagnostic::nowhere(Code::NO_TEMPERATURES, message, help));
        }
        if needs_load && base.loads().is_empty() && !columns.contains(&ConditionColumn::Force) {
            let message = format!("{name}: no workpiece weight is given: the table is assumed empty");
            let help = "add a column load_N, 0 for no load";
            findings.push(Diagnostic::nowhere(Code::NO_LOAD, message, help));
        }
    }
}

/// Reports readings with an unknown drift whose component has backlash in the machine file or among the parameters: they are not separable.
pub(super) fn check_reversals<'a>(
    errors: &ErrorModel,
    parameters: impl Iterator<Item = &'a Parameter>,
    data: &[DataSet],
) -> Vec<Diagnostic> {
    let help = "backlash is not separable from a drift: remove \"drift\" from free, or the backlash from the model";
    let told = |message| Diagnostic::nowhere(Code::DRIFT_NOT_TOLD, message, help);
    reversals(errors, parameters, data).into_iter().map(told).collect()
}
