//! `ncfix diagnose`: what the model gets wrong, and why.

use std::path::{Path, PathBuf};

use super::arguments::DiagnoseArguments;
use super::exit_code::ExitCode;
use super::extended;
use super::findings::Findings;
use super::input::is_standard_stream;
use super::machine_choice::{self, Chosen};
use super::measurement::{self, Measurement, description_of};
use super::output::Target;
use super::program::protect;
use super::progress::Progress;
use super::stop::Stop;
use super::{diagnose_faults, print, tell};
use crate::diagnose::cause::{Cause, Correctable};
use crate::diagnose::extend::extension;
use crate::diagnose::{Compared, Diagnosis, Finding, Scene, Sizes, Source, diagnose, fault, reads_angles};
use crate::diagnostic::{Code, Diagnostic};
use crate::measure::data::DataSet;
use crate::model::ErrorModel;
use crate::report::diagnosis::{self, DataFault, SCHEMA};
use crate::report::json;
use crate::units::{um_from_mm, urad_from_rad};

/// Diagnoses.
pub(super) fn run(arguments: &DiagnoseArguments) -> Result<ExitCode, Stop> {
    let goes_out = arguments.output.as_deref().is_some_and(is_standard_stream);
    if arguments.json && goes_out {
        return Err(Stop::Usage(
            "--json and the machine file cannot both go to standard output; give -o a file".into(),
        ));
    }
    let mut findings = Findings::default();
    let mut report = diagnosis::Diagnosis { schema: SCHEMA, ..Default::default() };
    let result = find(arguments, &mut findings, &mut report);
    if result.is_ok() && arguments.json {
        report.diagnostics = findings.json();
        print(&json::line(&report).map_err(Stop::Usage)?)?;
        return Ok(findings.exit_code());
    }
    findings.draw();
    result?;
    if report.readings > 0 {
        let page = report.page();
        if goes_out {
            tell(&page);
        } else {
            print(&page)?;
        }
    }
    if findings.has_errors() {
        tell(&format!("{}; nothing was written\n", findings.count()));
    }
    Ok(findings.exit_code())
}

fn find(arguments: &DiagnoseArguments, findings: &mut Findings, report: &mut diagnosis::Diagnosis) -> Result<(), Stop> {
    let first = arguments.data.first().map_or(Path::new("."), PathBuf::as_path);
    let target = arguments.output.as_deref().map(Target::new).transpose()?;
    let Some(chosen) = machine_choice::choose(&arguments.machine, first, findings)? else { return Ok(()) };
    report.machine.clone_from(&chosen.machine.name);
    if let Some(target) = &target {
        if chosen.is_demo {
            return Err(Stop::Usage("-o extends a machine file; give it with --machine".into()));
        }
        let mut inputs = chosen.files.clone();
        for path in arguments.data.iter().chain(&arguments.holdout) {
            inputs.extend([path.clone(), description_of(path)?]);
        }
        protect(target, &inputs, findings);
    }
    let mut all: Vec<Measurement> = Vec::new();
    for (number, path) in arguments.data.iter().chain(&arguments.holdout).enumerate() {
        all.extend(measurement::read_with_dead(path, number, &chosen.machine, findings)?);
    }
    if findings.has_errors() {
        return Ok(());
    }
    let used = arguments.data.len();
    let faults =
        diagnose_faults::look(&chosen.machine, &chosen.errors, &mut all, used, findings, &mut report.data_faults);
    let sets: Vec<DataSet> = all.into_iter().map(|one| one.data).collect();
    if findings.has_errors() {
        return Ok(());
    }
    let scene = |errors: &ErrorModel| Scene::new(&chosen.machine, errors, &sets);
    let (Ok(mut of_model), Ok(mut bare)) = (scene(&chosen.errors), scene(&ErrorModel::default())) else {
        let message = "the readings cannot even tell the set-ups";
        let help = "describe what is known of the set-ups, or measure more";
        findings.add(Diagnostic::nowhere(Code::NOT_TOLD, message, help), &[]);
        return Ok(());
    };
    fault::exclude(&mut of_model, &faults);
    fault::exclude(&mut bare, &faults);
    let mut progress = Progress::new();
    let found = diagnose(&of_model, &bare, used, &mut |what, share| progress.share(what, share));
    progress.clear();
    tell_all(&found, &of_model, (&sets, used), report);
    if let Some(target) = target {
        let extension = extension(&found, &of_model, used);
        for (one, &holds) in report.findings.iter_mut().zip(&extension.holds) {
            one.extends = holds;
        }
        let job = extended::Job { chosen: &chosen, scene: &of_model, used, extension };
        report.output = job
            .write(target, findings)?
            .then(|| arguments.output.clone())
            .flatten()
            .map(|path| path.display().to_string());
    }
    Ok(())
}

/// Everything that was found, in the units of reports.
fn tell_all(
    found: &Diagnosis,
    scene: &Scene<'_>,
    (sets, used): (&[DataSet], usize),
    report: &mut diagnosis::Diagnosis,
) {
    let micro = if reads_angles(scene) { urad_from_rad(1.0) } else { um_from_mm(1.0) };
    let level = |of: fn(&Compared) -> Sizes| {
        let held_out = found.held_out.as_ref().map(of);
        let own = of(&found.used);
        diagnosis::Sizes {
            rms_um: micro * own.rms,
            rms_95_um: own.interval.map(|end| micro * end),
            max_um: micro * own.max,
            efficiency: own.efficiency,
            holdout_rms_um: held_out.map(|sizes| micro * sizes.rms),
            holdout_rms_95_um: held_out.map(|sizes| sizes.interval.map(|end| micro * end)),
            holdout_max_um: held_out.map(|sizes| micro * sizes.max),
            holdout_efficiency: held_out.map(|sizes| sizes.efficiency),
        }
    };
    report.without_model = level(|compared| compared.measured);
    report.before = level(|compared| compared.before);
    report.after = level(|compared| compared.after);
    report.readings = found.used.readings;
    report.gain = found.used.gain.0;
    report.holdout_gain = found.held_out.as_ref().map(|held_out| held_out.gain.0);
    report.holdout_gain_95 = found.held_out.as_ref().map(|held_out| held_out.gain.1);
    report.expired = found.held_out.as_ref().map_or(found.used.is_expired, |held_out| held_out.is_expired);
    report.noise_um = micro * found.left.noise;
    report.noise_from = match found.left.source {
        Source::Repeats => "repeats",
        Source::Instrument => "instrument",
        Source::Differences => "neighbours",
    };
    report.unexplained = diagnosis::Unexplained {
        rms_um: micro * found.left.unexplained,
        structure: found.left.has_structure,
        p: found.left.chance,
        with: found
            .left
            .places
            .iter()
            .map(|(driver, rms)| diagnosis::With { driver: driver.clone(), rms_um: micro * rms })
            .collect(),
    };
    report.tried = found.tried;
    report.findings = found.findings.iter().map(|one| cause(one, micro)).collect();
    report.not_confirmed =
        found.not_confirmed.iter().map(|one| format!("{} {}", one.cause.effect, one.parameter)).collect();
    for (number, set) in sets.iter().enumerate().take(used) {
        let rows: Vec<usize> =
            found.outliers.iter().filter(|(set, _)| *set == number).map(|(_, row)| row + 1).collect();
        if !rows.is_empty() {
            let what = "far from all others".to_owned();
            let name = set.name.clone();
            report.data_faults.push(DataFault { kind: "outlier".into(), name, what, rows, ..Default::default() });
        }
    }
}

fn cause(found: &Finding, micro: f64) -> diagnosis::Cause {
    let one = &found.candidate;
    let name = |cause: &Cause, parameter: &str| format!("{} {parameter}", cause.effect).trim_end().to_owned();
    diagnosis::Cause {
        effect: one.cause.effect.to_string(),
        parameter: one.parameter.clone(),
        drivers: one.drivers.clone(),
        sensor: one.sensor.clone(),
        lag_s: one.sensor.is_some().then(|| one.constant.filter(|(_, unit)| *unit == "s").map_or(0.0, |(lag, _)| lag)),
        period: one.constant.filter(|(_, unit)| ["mm", "deg"].contains(unit)).map(|(period, _)| period),
        value: found.size.value,
        unit: found.size.unit.into(),
        u95: found.size.u95,
        rms_um: micro * found.rms,
        gain_holdout: found.gain_unseen,
        share: found.share.fair,
        share_alone: found.share.alone,
        p: found.chance,
        class: found.class.iter().map(|(cause, parameter)| name(cause, parameter)).collect(),
        separate_by: found.separate_by.clone(),
        correctable: match one.cause.correctable {
            Correctable::Program => "program".into(),
            Correctable::Live => "live".into(),
            Correctable::No => "no".into(),
        },
        extends: false,
        made_by: one.cause.made_by.to_owned(),
    }
}

/// The machine file that is extended.
pub(super) fn file_of(chosen: &Chosen) -> Option<&Path> {
    chosen.files.last().map(PathBuf::as_path)
}
