//! `ncfix diagnose`: what the model gets wrong, and why.

use std::panic::resume_unwind;
use std::path::{Path, PathBuf};

use super::arguments::DiagnoseArguments;
use super::exit_code::ExitCode;
use super::extended;
use super::findings::Findings;
use super::input::{self, is_standard_stream, one_stream};
use super::machine_choice::{self, Chosen};
use super::measurement::{self, Measurement};
use super::output::Target;
use super::pages::Pages;
use super::progress::Progress;
use super::stop::Stop;
use super::together::Together;
use super::{calibrated_report, diagnose_faults, diagnosed_report, print, tell};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::FileId;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_metrology::diagnose::cause::Correctable;
use ncfix_metrology::diagnose::extend::extension;
use ncfix_metrology::diagnose::{
    Compared, Diagnosis, FAR_OUT, Finding, Part, Rejected, Scene, Size, Sizes, Source, diagnose, fault, freedom_of,
    reads_angles, shape,
};
use ncfix_metrology::measure::data::DataSet;
use ncfix_model::ErrorModel;
use ncfix_report::diagnosis::readings::Shown;
use ncfix_report::diagnosis::{self, DataFault, SCHEMA};
use ncfix_report::{json, page};

/// Readings beyond the unknowns of set-ups that say anything.
const LEAST: usize = 3;

/// Diagnoses.
pub(super) fn run(arguments: &DiagnoseArguments) -> Result<ExitCode, Stop> {
    let goes_out = arguments.output.as_deref().is_some_and(is_standard_stream);
    one_stream(arguments.json, goes_out)?;
    let mut findings = Findings::default();
    let mut report = diagnosis::Diagnosis { schema: SCHEMA, unit: "um", ..Default::default() };
    let mut shown = Shown { version: env!("CARGO_PKG_VERSION"), ..Shown::default() };
    let page = Pages::new(&arguments.page, arguments.output.as_deref(), arguments.json)?;
    let mut files = Together::default();
    let mut result = find(arguments, (page.as_ref(), &mut files), &mut findings, &mut report, &mut shown);
    if let (Some(page), Ok(())) = (page.filter(|_| !shown.inputs.is_empty()), &result) {
        report.diagnostics = findings.json();
        result = page.add(&page::diagnosis::diagnosis(&report, &shown), &mut files);
        if result.is_ok() {
            report.report = arguments.page.report.as_ref().map(|path| path.display().to_string());
        }
    }
    result = result.and_then(|()| Ok(files.publish()?));
    if result.is_ok() && arguments.json {
        report.diagnostics = findings.json();
        if report.readings == 0 {
            report.forget_sizes();
        }
        print(&json::line(&report).map_err(Stop::Usage)?)?;
        return Ok(findings.exit_code());
    }
    findings.draw();
    result?;
    if report.readings > 0 {
        let text = report.page();
        if goes_out || arguments.page.report.as_deref().is_some_and(is_standard_stream) {
            tell(&text);
        } else {
            print(&text)?;
        }
    }
    if findings.has_errors() {
        let what = if report.report.is_some() { "only the page" } else { "nothing" };
        tell(&format!("{}; {what} was written\n", findings.count()));
    }
    Ok(findings.exit_code())
}

fn find(
    arguments: &DiagnoseArguments,
    (page, files): (Option<&Pages>, &mut Together),
    findings: &mut Findings,
    report: &mut diagnosis::Diagnosis,
    shown: &mut Shown,
) -> Result<(), Stop> {
    let first = arguments.data.first().map_or(Path::new("."), PathBuf::as_path);
    let target = arguments.output.as_deref().map(Target::new).transpose()?;
    let Some(chosen) = machine_choice::choose(&arguments.machine, first, findings)? else { return Ok(()) };
    report.machine.clone_from(&chosen.machine.name);
    if target.is_some() && chosen.is_demo {
        return Err(Stop::Usage("-o extends a machine file; give it with --machine".into()));
    }
    let tables = arguments.data.iter().chain(&arguments.holdout);
    measurement::protect_inputs(
        target.iter().chain(page.and_then(Pages::target)),
        chosen.files.clone(),
        tables,
        findings,
    )?;
    if findings.has_errors() {
        return Ok(());
    }
    for path in &chosen.files {
        shown.inputs.push(calibrated_report::machine_input(&input::read(path, FileId(0), "")?));
    }
    let mut all: Vec<Measurement> = Vec::new();
    for (number, path) in arguments.data.iter().chain(&arguments.holdout).enumerate() {
        let read = measurement::read_with_dead(path, number, (&chosen.machine, &chosen.errors), findings)?;
        if let Some(one) = &read {
            shown.inputs.extend(calibrated_report::inputs(one, number >= arguments.data.len()));
        }
        all.extend(read);
    }
    measurement::check_copies(&all, findings);
    if !findings.has_errors() {
        measurement::check_near_copies(&all, findings);
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
    let (of_model, bare) = std::thread::scope(|scope| {
        let of_model = scope.spawn(|| scene(&chosen.errors));
        let bare = scene(&ErrorModel::default());
        (of_model.join().unwrap_or_else(|fault| resume_unwind(fault)), bare)
    });
    let (Ok(mut of_model), Ok(mut bare)) = (of_model, bare) else {
        let message = "the readings cannot even tell the set-ups";
        let help =
            "check the columns of positions and their units, describe what is known of the set-ups, or measure more";
        findings.add(Diagnostic::nowhere(Code::NOT_TOLD, message, help), &[]);
        return Ok(());
    };
    fault::exclude(&mut of_model, &faults);
    fault::exclude(&mut bare, &faults);
    let [readings, unknowns] = freedom_of(&of_model, used);
    if readings < unknowns + LEAST {
        let message = format!(
            "{readings} readings that count and {unknowns} unknowns of the set-ups: nothing is left to be told"
        );
        let help = "measure more, or describe what is known of the set-ups (take it out of free)";
        findings.add(Diagnostic::nowhere(Code::NOT_TOLD, message, help), &[]);
        return Ok(());
    }
    let mut progress = Progress::new();
    let found = diagnose(&of_model, &bare, used, &mut |what, share| progress.share(what, share));
    progress.clear();
    tell_all(&found, &of_model, (&sets, used), report);
    let extension = extension(&found, &of_model, used);
    let refused: Vec<Option<String>> = extension.iter().map(|changes| changes.as_ref().err().cloned()).collect();
    let job = extended::Job { chosen: &chosen, scene: &of_model, used, found: &found, extension };
    let mut aside = Findings::default();
    let made = job.make(if target.is_some() { findings } else { &mut aside });
    // The built-in machine has no file.
    let made = if target.is_some() { Some(made?) } else { made.ok() };
    can_be_done(made.as_ref().map_or(&refused, |made| &made.why_not), report);
    if page.is_some() {
        diagnosed_report::fill(&found, &of_model, used, shown);
    }
    if let (Some(target), Some(made)) = (target, made) {
        report.findings.iter_mut().zip(&made.why_not).for_each(|(one, why_not)| one.extends = why_not.is_none());
        let is_written = made.write(target, files, findings)?;
        report.output = arguments.output.as_ref().filter(|_| is_written).map(|path| path.display().to_string());
    }
    Ok(())
}

/// What can be done about findings, whether or not a file is written: what the file has as a table needs no name, and what it cannot have is not to be
/// corrected.
fn can_be_done(why_not: &[Option<String>], report: &mut diagnosis::Diagnosis) {
    for (told, why_not) in report.findings.iter_mut().zip(why_not) {
        told.extends_why.clone_from(why_not);
        if why_not.is_some() {
            told.correctable = "no".into();
        } else if told.correctable == "no" {
            told.correctable = "program".into();
        }
    }
}

/// Everything that was found, in the units of reports.
fn tell_all(
    found: &Diagnosis,
    scene: &Scene<'_>,
    (sets, used): (&[DataSet], usize),
    report: &mut diagnosis::Diagnosis,
) {
    let of_angles = reads_angles(scene);
    let micro = if of_angles { urad_from_rad(1.0) } else { um_from_mm(1.0) };
    report.unit = if of_angles { "urad" } else { "um" };
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
    report.noise_stated_um = found.left.stated.map(|stated| micro * stated);
    report.noise_from = match found.left.source {
        Source::Repeats => "repeats",
        Source::Instrument => "instrument",
        Source::Differences => "neighbours",
        Source::Rest => "rest",
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
    let alone: f64 = found.findings.iter().map(|one| one.alone).sum();
    report.findings = found.findings.iter().map(|one| cause(one, scene, used, (micro, alone))).collect();
    report.rejected = found.rejected.iter().map(|one| rejected(one, scene)).collect();
    report.not_confirmed =
        found.not_confirmed.iter().map(|one| format!("{} {}", one.cause.effect, one.parameter)).collect();
    for (number, set) in sets.iter().enumerate().take(used) {
        let rows: Vec<usize> =
            found.outliers.iter().filter(|(set, _)| *set == number).map(|(_, row)| row + 1).collect();
        if !rows.is_empty() {
            let times = FAR_OUT;
            report.data_faults.push(DataFault {
                kind: "outlier".into(),
                name: set.name.clone(),
                what: "far from all others".to_owned(),
                evidence: format!(
                    "readings of {} rows are more than {times} times the spread of what is left of this file away from all causes",
                    rows.len()
                ),
                excluded: "these readings".into(),
                file: set.name.clone(),
                rows,
            });
        }
    }
}

fn cause(found: &Finding, scene: &Scene<'_>, used: usize, (micro, alone): (f64, f64)) -> diagnosis::Cause {
    let one = &found.candidate;
    // Causes of the same effect have one name.
    let mut class: Vec<String> = Vec::new();
    for (cause, parameter) in &found.class {
        let name = format!("{} {parameter}", cause.effect).trim_end().to_owned();
        if !class.contains(&name) {
            class.push(name);
        }
    }
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
        alone_um: micro * found.alone,
        alone_share: if alone > 0.0 { found.alone / alone } else { 0.0 },
        gain_holdout: found.gain_unseen,
        share: found.share.fair,
        share_alone: found.share.alone,
        p: found.chance,
        by_file: by_file(&found.by_file, &found.size, scene),
        separate_by: found.separate_by.clone().filter(|_| class.len() > 1),
        class,
        correctable: match one.cause.correctable {
            Correctable::Program => "program".into(),
            Correctable::Live => "live".into(),
            Correctable::No => "no".into(),
        },
        extends: false,
        extends_why: None,
        made_by: one.cause.made_by.to_owned(),
        shown_by: one.cause.shown_by.to_owned(),
        what: shape::sentence(found, scene, used),
        // Where columns stand for places the value alone says little.
        shape: if one.points.is_empty() { Vec::new() } else { shape::shape(found, scene, used) }
            .into_iter()
            .map(|(at, value_um)| diagnosis::Place { at, value_um })
            .collect(),
    }
}

fn by_file(parts: &[Part], size: &Size, scene: &Scene<'_>) -> Vec<diagnosis::InFile> {
    let of = |part: &Part| diagnosis::InFile {
        file: scene.sets.get(part.set).map_or_else(String::new, |set| set.name.clone()),
        value: part.share * size.value,
        unit: size.unit.into(),
        u95: (part.u95 * size.value).abs(),
    };
    parts.iter().map(of).collect()
}

fn rejected(found: &Rejected, scene: &Scene<'_>) -> diagnosis::Rejected {
    diagnosis::Rejected {
        effect: found.candidate.cause.effect.to_string(),
        parameter: found.candidate.parameter.clone(),
        drivers: found.candidate.drivers.clone(),
        why: found.gate.name(),
        p: found.chance,
        gain: found.gain,
        by_file: by_file(&found.by_file, &found.size, scene),
    }
}

/// The machine file that is extended.
pub(super) fn file_of(chosen: &Chosen) -> Option<&Path> {
    chosen.files.last().map(PathBuf::as_path)
}
