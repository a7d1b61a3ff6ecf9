//! Page about compensation tables: their residual over the volume, and the contribution of each.

use super::parts::{MOST_ROWS, diagnostics, origin};
use super::{PageRow, columns, figure, page, pictures, strip, table};
use crate::inputs::InputFile;
use crate::markup::Markup;
use crate::number::{grouped, micrometers, significant};
use crate::plot::{Chart, Histogram, PlotSeries};
use crate::tables::TablesReport;
use ncfix_tables::results::result::TablesCheck;

/// Returns the page; `charts` are the pictures of the tables.
#[must_use]
pub fn tables(report: &TablesReport, charts: &[Chart], inputs: &[InputFile]) -> String {
    let machine = if report.found.machine.is_empty() { "a control" } else { &report.found.machine };
    page(&format!("Compensation tables of {machine}"), |out| {
        let mut entries = vec![
            ("format", report.found.format.clone()),
            ("tables", grouped(report.found.tables as u64)),
            ("values", grouped(report.found.entries as u64)),
        ];
        if !report.found.scheme.is_empty() {
            entries.push(("scheme", report.found.scheme.clone()));
        }
        if let Some(check) = &report.found.check {
            let [before, after] = [check.before.rms_um, check.tables.rms_um].map(micrometers);
            let (class, what) =
                if check.tables.rms_um > check.before.rms_um { ("banner bad", "grows") } else { ("banner", "goes") };
            let text = format!("With the tables the error over the volume {what} from {before} to {after} RMS.");
            out.leaf("p", &[("class", &class)], text);
        }
        strip(out, &entries);
        if !report.found.ranges.is_empty() {
            out.leaf("p", &[], format_args!("For a part of the travel: {}", report.found.ranges.join(", ")));
        }
        diagnostics(out, &report.diagnostics);
        if let Some(check) = &report.found.check {
            left(out, check);
        }
        fewer(out, report);
        differences(out, report);
        if !charts.is_empty() {
            out.leaf("h2", &[], "Values that the tables add");
            pictures(out, |out| charts.iter().for_each(|chart| figure(out, chart, "")));
        }
        listed(out, report);
        tried(out, report);
        origin(out, inputs, &format!("ncfix {}, machine {machine}", env!("CARGO_PKG_VERSION")));
    })
}

fn left(out: &mut Markup, check: &TablesCheck) {
    out.leaf("h2", &[], "Residual over the volume");
    let kinds = [("without", check.before), ("with the tables", check.tables), ("corrected exactly", check.exact)];
    let rows: Vec<PageRow> = kinds
        .iter()
        .map(|(name, one)| {
            let sizes = [one.mean_um, one.rms_um, one.max_um, one.tilt_rms_urad, one.tilt_max_urad].map(significant);
            PageRow { class: "", cells: std::iter::once((*name).to_owned()).chain(sizes).collect() }
        })
        .collect();
    let [x, y, z] = check.tool_mm;
    let senses = check.senses.join(" ");
    let senses = if senses.is_empty() { senses } else { format!(", {senses} moving in both directions") };
    let note = format!(
        "{} poses{senses}; tool {x} {y} {z} mm from the gauge point to the tip; with the tables the residual is largest at {}.",
        grouped(check.poses as u64),
        check.worst
    );
    let titles = columns([
        "",
        "#tip, mean µm",
        "#tip, RMS µm",
        "#tip, largest µm",
        "#tool axis, RMS µrad",
        "#tool axis, largest µrad",
    ]);
    table(out, &titles, &rows, &note, MOST_ROWS);
    pictures(out, |out| {
        let names = ["Tip errors without tables", "Tip errors with the tables"];
        for (title, values) in names.iter().zip(&check.tips_um) {
            let across = "distance of the tip from its position, µm".to_owned();
            let histogram =
                Histogram { title: (*title).to_owned(), across, values: values.clone(), counted: "poses", sigma: None };
            figure(out, &histogram, "");
        }
    });
}

/// Draws the residuals with fewer tables, or over the nodes of a grid.
fn fewer(out: &mut Markup, report: &TablesReport) {
    if report.found.fewer.len() < 2 {
        return;
    }
    let what = if report.found.grid.is_some() { "number of nodes along each axis" } else { "number of tables" };
    let points = report.found.fewer.iter().map(|one| (one.count as f64, one.rms_um)).collect();
    let chart = Chart {
        title: format!("Residual over the {what}"),
        across: what.to_owned(),
        up: "tip error, RMS µm".to_owned(),
        series: vec![PlotSeries { points, ..PlotSeries::default() }],
        ..Chart::default()
    };
    pictures(out, |out| figure(out, &chart, ""));
}

fn differences(out: &mut Markup, report: &TablesReport) {
    if report.found.difference.is_empty() {
        return;
    }
    out.leaf("h2", &[], "Difference of the two sets of values");
    let rows: Vec<PageRow> = report
        .found
        .difference
        .iter()
        .map(|one| {
            let [rms, max] = [one.rms, one.max].map(significant);
            PageRow { class: "", cells: vec![one.axis.clone(), rms, max, one.unit.unit().sign().to_owned()] }
        })
        .collect();
    table(out, &columns(["axis", "#RMS", "#largest", "unit"]), &rows, "", MOST_ROWS);
}

fn listed(out: &mut Markup, report: &TablesReport) {
    if report.found.rows.is_empty() {
        return;
    }
    out.leaf("h2", &[], "Tables");
    let rows: Vec<PageRow> = report
        .found
        .rows
        .iter()
        .map(|row| {
            let [low, high] = row.range;
            let times = row.times.map_or("–".into(), |times| times.to_string());
            let more = [(row.modulo, "repeats"), (!row.enabled, "off")];
            let more: Vec<&str> = more.into_iter().filter(|(is_so, _)| *is_so).map(|(_, what)| what).collect();
            let cells = vec![
                row.number.to_string(),
                row.output.clone(),
                row.input.clone(),
                row.points.to_string(),
                format!("{} … {}", rounded(low), rounded(high)),
                format!("{:.6}", row.largest),
                if "ABC".contains(row.output.as_str()) { "deg" } else { "mm" }.to_owned(),
                times,
                row.sense.word().to_owned(),
                if more.is_empty() { "–".into() } else { more.join(", ") },
            ];
            PageRow { class: "", cells }
        })
        .collect();
    let titles =
        ["#no.", "corrects", "over", "#points", "#range", "#largest", "unit", "#times table", "direction", "remark"];
    table(
        out,
        &columns(titles),
        &rows,
        "Positions in mm or degrees; the unit is that of the largest value.",
        MOST_ROWS,
    );
}

/// Formats a position to a tenth of a micrometer, without zeros at the end.
fn rounded(position: f64) -> String {
    let text = format!("{position:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn tried(out: &mut Markup, report: &TablesReport) {
    if report.found.tried.is_empty() {
        return;
    }
    out.leaf("h2", &[], "Tested sets");
    let number = |value: Option<f64>| value.map_or(String::new(), significant);
    let rows: Vec<PageRow> = report
        .found
        .tried
        .iter()
        .map(|one| {
            let tables = one.tables.map_or(String::new(), |tables| tables.to_string());
            let why = one.reason.clone().unwrap_or_default();
            let [rms, tilt] = [one.rms_um, one.tilt_rms_urad].map(number);
            PageRow { class: "wrap", cells: vec![one.scheme.clone(), one.points.to_string(), tables, rms, tilt, why] }
        })
        .collect();
    let aim = report.found.aim.as_ref().map_or(String::new(), |aim| format!("Target: {aim}."));
    let titles = ["scheme", "#points", "#tables", "#residual, RMS µm", "#tilt, RMS µrad", "why not"];
    table(out, &columns(titles), &rows, &aim, MOST_ROWS);
}
