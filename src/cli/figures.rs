//! `ncfix figures`: figures of the acceptance tests from measurements.

use super::arguments::FiguresArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::stop::Stop;
use super::{deliver, machine_choice, measurement};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::Machine;
use ncfix_metrology::measure::data::DataSet;
use ncfix_metrology::measure::iso230::figures::{self, Figures, Found, Path, RUNS};
use ncfix_metrology::measure::iso230::positioning::OneWay;
use ncfix_report::figures::{Figures as Report, Group, Measurement, Value};
use ncfix_report::json;

/// Prints figures.
pub(super) fn run(arguments: &FiguresArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let mut report = Report::default();
    let result = read(arguments, &mut findings, &mut report);
    let page = report.table();
    let json = arguments.json.then(|| {
        report.diagnostics = findings.json();
        json::line(&report)
    });
    deliver(result, &findings, false, page, json)
}

fn read(arguments: &FiguresArguments, findings: &mut Findings, report: &mut Report) -> Result<(), Stop> {
    let beside = arguments.data.first().map_or_else(Default::default, Clone::clone);
    let Some(chosen) = machine_choice::choose(&arguments.machine, &beside, findings)? else { return Ok(()) };
    report.machine.clone_from(&chosen.machine.name);
    let mut all = Vec::new();
    for (number, path) in arguments.data.iter().enumerate() {
        all.extend(measurement::read(path, number, false, &chosen.machine, findings)?);
    }
    if findings.has_errors() {
        return Ok(());
    }
    for one in &all {
        let of = of(&one.data, &chosen.machine);
        if of.figures.is_empty() {
            let message = format!("{}: a {} measurement has no figures of ISO 230", of.name, of.kind);
            let help = "give readings of single components (direct) or of a ball-bar";
            findings.add(Diagnostic::nowhere(Code::DATA_COLUMN, message, help), &one.sources);
        }
        report.measurements.push(of);
    }
    Ok(())
}

/// The figures of a measurement.
pub(super) fn of(data: &DataSet, machine: &Machine) -> Measurement {
    let figures = figures::figures(data, machine).iter().map(group).collect();
    Measurement { name: data.name.clone(), kind: data.kind.name, figures }
}

fn group(found: &Found) -> Group {
    let mut group = Group { setup: found.setup.clone(), of: found.of.clone(), unit: "µm", ..Group::default() };
    match &found.figures {
        Ok(figures) => fill(&mut group, figures),
        Err(reason) => group.reason = Some(reason.clone()),
    }
    group
}

fn fill(group: &mut Group, figures: &Figures) {
    let mut put = |name: &'static str, value: Option<f64>, factor: f64| {
        group.values.extend(value.map(|value| Value { name, value: value * factor }));
    };
    let um = um_from_mm(1.0);
    match figures {
        Figures::Positioning { figures, is_angle, without_drift } => {
            let factor = if *is_angle { urad_from_rad(1.0) } else { um };
            let (both, up, down) = (figures.both.as_ref(), figures.up.as_ref(), figures.down.as_ref());
            let of = |side: Option<&OneWay>, value: fn(&OneWay) -> f64| side.map(value);
            put("A", both.map(|both| both.accuracy), factor);
            put("A+", of(up, |up| up.accuracy), factor);
            put("A-", of(down, |down| down.accuracy), factor);
            put("E", both.map(|both| both.systematic), factor);
            put("E+", of(up, |up| up.systematic), factor);
            put("E-", of(down, |down| down.systematic), factor);
            put("R", both.map(|both| both.repeatability), factor);
            put("R+", of(up, |up| up.repeatability), factor);
            put("R-", of(down, |down| down.repeatability), factor);
            put("B", both.map(|both| both.reversal), factor);
            put("B mean", both.map(|both| both.mean_reversal), factor);
            put("M", both.map(|both| both.mean_systematic), factor);
            group.standard = "ISO 230-2";
            group.unit = if *is_angle { "µrad" } else { "µm" };
            let fewer =
                if figures.runs < RUNS { format!(" of the {RUNS} that the standard asks for") } else { String::new() };
            group.conditions =
                vec![format!("{} targets", figures.targets.len()), format!("{} runs{fewer}", figures.runs)];
            if *without_drift {
                group.conditions.push("without drift".into());
            }
        }
        Figures::Circle { figures, radius_mm, paths } => {
            let end = |ends: Option<[f64; 2]>, which: usize| ends.and_then(|ends| ends.get(which).copied());
            put("G(ccw)", figures.g_counter, um);
            put("G(cw)", figures.g_clock, um);
            put("G(b)", figures.g_both, um);
            put("D(b)", figures.d, um);
            put("H", figures.h, um);
            put("F(ccw) max", end(figures.f_counter, 0), um);
            put("F(ccw) min", end(figures.f_counter, 1), um);
            put("F(cw) max", end(figures.f_clock, 0), um);
            put("F(cw) min", end(figures.f_clock, 1), um);
            put("eccentricity 1", Some(figures.centre_mm[0]), um);
            put("eccentricity 2", Some(figures.centre_mm[1]), um);
            group.standard = "ISO 230-4";
            group.conditions = vec![format!("R {radius_mm:.3} mm")];
            let named = ["ccw", "cw"].into_iter().zip(paths).filter(|(_, path)| path.points > 0);
            group.conditions.extend(named.map(|(name, path)| shown(name, path)));
        }
        Figures::Sphere { sphere, radius_mm, points } => {
            put("size", Some(sphere.radius_mm - radius_mm), um);
            put("form", Some(sphere.form_mm), um);
            put("s", Some(sphere.deviation_mm), um);
            put("centre X", Some(sphere.centre_mm.x), um);
            put("centre Y", Some(sphere.centre_mm.y), um);
            put("centre Z", Some(sphere.centre_mm.z), um);
            group.standard = "least squares";
            group.conditions = vec![format!("R {radius_mm:.3} mm"), format!("{points} readings")];
        }
    }
}

fn shown(name: &str, path: &Path) -> String {
    let feed = path.feed.map_or(String::new(), |feed| format!(" F {feed:.0} mm/min"));
    let start = path.start.to_degrees();
    format!("{name} {:.0}° from {start:.1}°{feed}, {} readings", path.arc.to_degrees(), path.points)
}
