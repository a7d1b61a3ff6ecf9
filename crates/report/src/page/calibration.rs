//! Page of a calibration: the result, its quality, and the residual of every reading.

mod pictures;

use super::parts::{MOST_ROWS, diagnostics, origin};
use super::{PageRow, columns, figure, page, pictures as side_by_side, strip, table};
use crate::calibration::{CalibrationReport, cells};
use crate::component::spelled_out;
use crate::markup::Markup;
use crate::number::{grouped, significant};
use crate::plot::{Bar, Bars};
use ncfix_base::diagnostic::Severity;
use ncfix_base::units::Unit;
use ncfix_metrology::results::calibration::{CalibrationResult, Data, EstimateReport};

/// Returns the page.
#[must_use]
pub fn calibration(report: &CalibrationReport) -> String {
    let found = &report.found;
    let machine = if found.machine.is_empty() { "a machine" } else { &found.machine };
    page(&format!("Calibration of {machine}"), |out| {
        let is_refused = report.diagnostics.iter().any(|finding| finding.severity == Severity::Error);
        summary(out, report, is_refused);
        diagnostics(out, &report.diagnostics);
        if !found.data.is_empty() {
            results(out, &found.data);
        }
        estimates(out, found);
        for (number, one) in found.data.iter().enumerate() {
            let held = if one.is_held_out { ", held out" } else { "" };
            out.leaf("h2", &[("id", &format_args!("data-{number}"))], format_args!("{}: {}{held}", one.name, one.kind));
            pictures::draw(out, one);
        }
        weighted_down(out, found);
        let by = format!("ncfix {}, model {}, machine {}", report.version, found.model, found.machine);
        origin(out, &report.inputs, &by);
    })
}

fn summary(out: &mut Markup, report: &CalibrationReport, is_refused: bool) {
    let found = &report.found;
    let banner = if is_refused {
        "Refused: no machine file was written. The diagnostics below give the reason.".to_owned()
    } else {
        match report.output.as_deref() {
            Some("-") => "The machine file went to standard output.".to_owned(),
            Some(output) => format!("Machine file written: {output}"),
            None => "No machine file was written.".to_owned(),
        }
    };
    let class = if is_refused { "banner bad" } else { "banner" };
    out.leaf("p", &[("class", &class)], banner);
    let readings = |is_held_out: bool| -> usize {
        found.data.iter().filter(|one| one.is_held_out == is_held_out).map(|one| one.readings).sum()
    };
    let count = |count: usize| grouped(count as u64);
    let mut entries = vec![("model", found.model.clone())];
    if !found.parameters.is_empty() {
        entries.push(("parameters", count(found.parameters.len())));
        entries.push(("unknowns of set-ups", count(found.unknowns.len())));
    }
    if !found.data.is_empty() {
        entries.push(("readings used", count(readings(false))));
        entries.push(("readings held out", count(readings(true))));
    }
    if let Some(condition) = found.condition {
        entries.push(("degrees of freedom", count(found.degrees_of_freedom)));
        entries.push(("condition", significant(condition)));
        entries.push(("iterations", count(found.rounds)));
    }
    for (unit, of) in
        [(Unit::Um, ["efficiency, used", "efficiency, held out"]), (Unit::Urad, ["angles, used", "angles, held out"])]
    {
        for (is_held_out, what) in [false, true].into_iter().zip(of) {
            if let Some(efficiency) = found.efficiency(is_held_out, unit) {
                entries.push((what, percent(efficiency)));
            }
        }
    }
    strip(out, &entries);
}

fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

/// Writes measured RMS and maximum, residual, σ and efficiency, as in Tables 3.2 – 3.4 of Spaan.
fn results(out: &mut Markup, data: &[Data]) {
    out.leaf("h2", &[], "Results by measurement");
    let mut rows = Vec::new();
    for one in data {
        let sizes = [one.measured_rms, one.measured_max, one.left_rms, one.left_max].map(significant);
        let mut cells = vec![one.name.clone(), if one.is_held_out { "held out" } else { "used" }.into()];
        cells.push(grouped(one.readings as u64));
        cells.extend(sizes);
        let dash = || "–".to_owned();
        cells.push(dash());
        cells.push(one.sigma.map_or_else(dash, significant));
        cells.extend([percent(one.efficiency), one.unit.to_string()]);
        if let [only] = one.parts.as_slice() {
            cells[7] = only.left_sigma.map_or_else(dash, significant);
        }
        rows.push(PageRow { class: "whole", cells });
        for part in one.parts.iter().filter(|_| one.parts.len() > 1) {
            let sizes = [part.measured_rms, part.measured_max, part.left_rms, part.left_max].map(significant);
            let mut cells = vec![part.name.clone(), dash(), grouped(part.readings as u64)];
            cells.extend(sizes);
            cells.push(part.left_sigma.map_or_else(dash, significant));
            cells.extend([dash(), percent(part.efficiency), part.unit.to_string()]);
            rows.push(PageRow { class: "part", cells });
        }
    }
    let heads = columns([
        "measurement",
        "use",
        "#readings",
        "#measured, RMS",
        "#max",
        "#residual, RMS",
        "#max",
        "#σ residual",
        "#σ reading",
        "#efficiency",
        "unit",
    ]);
    let caption = "Measured: residual of a machine without errors. Residual: that of this model. Both with the unknowns of the set-ups \
                   fitted. σ residual: standard deviation about its mean. σ reading: standard uncertainty of a reading, described or \
                   estimated. Efficiency: 1 − Σ|residual| / Σ|measured|.";
    table(out, &heads, &rows, caption, MOST_ROWS);
}

fn estimates(out: &mut Markup, found: &CalibrationResult) {
    let heads = columns(["name", "#value", "#± 1σ", "unit", "#start", "#effect µm", "#variance inflation"]);
    let row = |one: &EstimateReport| {
        let [value, sigma, effect, inflation] = cells(one);
        let told = |text: String, number: f64| if number.is_finite() { text } else { "not identifiable".into() };
        let start = if one.effect_um.is_some() { significant(one.start + 0.0) } else { String::new() };
        let cells = vec![
            one.name.clone(),
            value,
            told(sigma, one.sigma),
            one.unit.clone(),
            start,
            effect,
            told(inflation, one.sigma),
        ];
        PageRow { class: "", cells }
    };
    if !found.parameters.is_empty() {
        out.leaf("h2", &[], "Parameters");
        let caption = "Effect: displacement of the tip by the parameter, RMS over the readings. Variance inflation: factor by which the variance \
                       increases because the other parameters are unknown too; 1 for a parameter that is separable from all others.";
        let named = |one: &EstimateReport| {
            let mut row = row(one);
            row.cells.push(spelled_out(&one.name).unwrap_or_else(|| "–".into()));
            row
        };
        let rows: Vec<PageRow> = found.parameters.iter().map(named).collect();
        let what = columns(["meaning"]);
        table(out, &[&heads[..], &what].concat(), &rows, caption, MOST_ROWS);
        side_by_side(out, |out| {
            let share = |one: &EstimateReport| if one.value == 0.0 { 0.0 } else { (one.sigma / one.value).abs() };
            let effect = |one: &EstimateReport| one.effect_um.unwrap_or(f64::NAN);
            let effects = found.parameters.iter().map(|one| Bar {
                label: one.name.clone(),
                value: effect(one),
                error: effect(one) * share(one),
            });
            let picture = Bars {
                title: "Effect of each parameter on the tip".into(),
                across: "RMS over the readings, ± 1σ, in µm".into(),
                bars: effects.collect(),
                is_logarithmic: false,
            };
            figure(out, &picture, "");
            // A slope that follows from a curve has none.
            let inflated = found.parameters.iter().filter(|one| one.inflation.is_finite());
            let inflations = inflated.map(|one| Bar { label: one.name.clone(), value: one.inflation, error: 0.0 });
            let picture = Bars {
                title: "Variance inflation".into(),
                across: "factor on the variance, logarithmic".into(),
                bars: inflations.collect(),
                is_logarithmic: true,
            };
            figure(out, &picture, "");
        });
    }
    if !found.unknowns.is_empty() {
        out.leaf("h2", &[], "Unknowns of the set-ups");
        let rows: Vec<PageRow> = found
            .unknowns
            .iter()
            .map(|one| {
                let mut row = row(one);
                row.cells.drain(4..6);
                row
            })
            .collect();
        let heads = columns(["name", "#value", "#± 1σ", "unit", "#variance inflation"]);
        table(out, &heads, &rows, "", MOST_ROWS);
    }
}

fn weighted_down(out: &mut Markup, found: &CalibrationResult) {
    if found.weighted_down.is_empty() {
        return;
    }
    out.leaf("h2", &[], "Rows that do not fit the model");
    let rows: Vec<PageRow> = found
        .weighted_down
        .iter()
        .map(|row| {
            let place = format!("{}:{}", row.file, row.line);
            let cells =
                vec![place, significant(row.residual), row.unit.to_string(), format!("{:.0} %", row.weight * 100.0)];
            PageRow { class: "", cells }
        })
        .collect();
    table(
        out,
        &columns(["row", "#residual", "unit", "#weight"]),
        &rows,
        "Rows with a reduced weight in the fit. They stay in the file.",
        MOST_ROWS,
    );
}
