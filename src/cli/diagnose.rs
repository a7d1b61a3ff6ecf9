//! `ncfix diagnose`: what the model gets wrong, and why.

use super::arguments::DiagnoseArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::stop::Stop;
use super::{deliver, diagnose_faults, machine_choice, measurement};
use crate::diagnose::cause::{Cause, Correctable};
use crate::diagnose::{Finding, Scene, diagnose, fault};
use crate::diagnostic::{Code, Diagnostic};
use crate::measure::data::DataSet;
use crate::report::diagnosis::{self, DataFault, SCHEMA, Sizes};
use crate::report::json;
use crate::units::{um_from_mm, urad_from_rad};

/// Diagnoses.
pub(super) fn run(arguments: &DiagnoseArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let mut report = diagnosis::Diagnosis { schema: SCHEMA, ..Default::default() };
    let result = find(arguments, &mut findings, &mut report);
    let page = report.page();
    deliver(
        result,
        &findings,
        false,
        page,
        arguments.json.then(|| {
            report.diagnostics = findings.json();
            json::line(&report)
        }),
    )
}

fn find(arguments: &DiagnoseArguments, findings: &mut Findings, report: &mut diagnosis::Diagnosis) -> Result<(), Stop> {
    let first = arguments.data.first().map_or(std::path::Path::new("."), std::path::PathBuf::as_path);
    let Some(chosen) = machine_choice::choose(&arguments.machine, first, findings)? else { return Ok(()) };
    report.machine.clone_from(&chosen.machine.name);
    let mut sets: Vec<DataSet> = Vec::new();
    for (number, path) in arguments.data.iter().enumerate() {
        sets.extend(measurement::read(path, number, false, &chosen.machine, findings)?.map(|one| one.data));
    }
    if findings.has_errors() {
        return Ok(());
    }
    let (machine, errors) = (&chosen.machine, &chosen.errors);
    let faults = diagnose_faults::look(machine, errors, &mut sets, findings, &mut report.data_faults);
    if findings.has_errors() {
        return Ok(());
    }
    let mut scene = match (&faults, Scene::new(machine, errors, &sets)) {
        (Some(_), Ok(scene)) => scene,
        _ => {
            let message = "the readings cannot even tell the set-ups";
            let help = "describe what is known of the set-ups, or measure more";
            findings.add(Diagnostic::nowhere(Code::NOT_TOLD, message, help), &[]);
            return Ok(());
        }
    };
    fault::exclude(&mut scene, faults.as_deref().unwrap_or_default());
    let found = diagnose(&scene);
    let sizes = |[rms, max]: [f64; 2]| Sizes { rms_um: um_from_mm(rms), max_um: um_from_mm(max) };
    report.before = sizes(found.before);
    report.after = sizes(found.after);
    report.noise_um = um_from_mm(found.after[0]);
    report.tried = found.tried;
    report.findings = found.findings.iter().map(cause).collect();
    for (number, set) in sets.iter().enumerate() {
        let rows: Vec<usize> =
            found.outliers.iter().filter(|(set, _)| *set == number).map(|(_, row)| row + 1).collect();
        if !rows.is_empty() {
            let what = "far from all others".to_owned();
            let name = set.name.clone();
            report.data_faults.push(DataFault { kind: "outlier".into(), name, what, rows, ..Default::default() });
        }
    }
    Ok(())
}

fn cause(found: &Finding) -> diagnosis::Cause {
    let one = &found.candidate;
    let (value, u95) = match found.amounts.as_slice() {
        // A sine and a cosine: their amplitude.
        [(sine, u), (cosine, _)] if one.constant.is_some() => (sine.hypot(*cosine), *u),
        [(value, u), ..] => (*value, *u),
        [] => (0.0, 0.0),
    };
    let name = |cause: &Cause, parameter: &str| format!("{} {parameter}", cause.effect);
    let is_angle = one.parameter.as_bytes().get(1).is_some_and(|letter| b"ABC".contains(letter));
    let scale = if is_angle { urad_from_rad } else { um_from_mm };
    diagnosis::Cause {
        effect: one.cause.effect.to_string(),
        parameter: one.parameter.clone(),
        drivers: one.drivers.clone(),
        sensor: one.sensor.clone(),
        lag_s: one.constant.filter(|(_, unit)| *unit == "s").map(|(lag, _)| lag),
        period: one.constant.filter(|(_, unit)| ["mm", "deg"].contains(unit)).map(|(period, _)| period),
        value: scale(value),
        unit: if is_angle { "urad".into() } else { "um".into() },
        u95: scale(u95),
        rms_um: um_from_mm(found.rms),
        gain_holdout: found.gain_unseen,
        p: found.chance,
        class: found.class.iter().map(|(cause, parameter)| name(cause, parameter)).collect(),
        separate_by: (found.class.len() > 1).then(|| one.cause.separate_by.to_owned()),
        correctable: match one.cause.correctable {
            Correctable::Program => "program".into(),
            Correctable::Live => "live".into(),
            Correctable::No => "no".into(),
        },
        made_by: one.cause.made_by.to_owned(),
    }
}
