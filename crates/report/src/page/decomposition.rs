//! Page of a decomposition: shares by feed, tables, and the course along the path at the slowest and the fastest feed.

use super::parts::{MOST_ROWS, diagnostics, origin};
use super::{PageRow, columns, figure, page, pictures, strip, table};
use crate::component::spelled_out;
use crate::decomposition::{
    DecompositionReport, accuracy_cell, compliance_unit, delay_cell, exponent_cell, factor_cell, link_cell, loop_cells,
    slowest_cell,
};
use crate::markup::Markup;
use crate::number::{grouped, significant};
use crate::plot::{Chart, PlotSeries, Shape};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_metrology::decompose::SOURCES;
use ncfix_metrology::results::decomposition::{
    Along, ComplianceReport, DIRECTIONS, DecompositionResult, LinkReport, Loop, RunReport,
};

/// Returns the page.
#[must_use]
pub fn decomposition(report: &DecompositionReport) -> String {
    let found = &report.found;
    page(&format!("Errors at speed of {}", found.machine), |out| {
        if found.runs.is_empty() {
            out.leaf(
                "p",
                &[("class", &"banner bad"), ("id", &"verdict")],
                "Refused: the diagnostics below give the reason.",
            );
        } else {
            out.leaf("p", &[("class", &"banner"), ("id", &"verdict")], report.verdict());
            summary(out, found);
        }
        diagnostics(out, &report.diagnostics);
        if !found.runs.is_empty() {
            feeds(out, found);
            along(out, found);
            loops(out, found);
            links(out, found);
        }
        origin(out, &report.inputs, &format!("ncfix {}, machine {}", env!("CARGO_PKG_VERSION"), found.machine));
    })
}

fn summary(out: &mut Markup, found: &DecompositionResult) {
    let mut entries = vec![
        ("runs", found.runs.len().to_string()),
        ("cycle of the control", format!("{} ms", significant(found.cycle_ms))),
        ("encoder delay after set-points", delay_cell(&found.record_delay).trim().to_owned()),
    ];
    if let Some(one) = &found.reading_delay {
        entries.push(("reading delay after encoders", delay_cell(one).trim().to_owned()));
        entries.extend(found.dynamic_accuracy.map(|one| ("dynamic accuracy on this path", accuracy_cell(&one))));
        entries.push(("compliances", found.compliances.len().to_string()));
    }
    strip(out, &entries);
}

fn feed_of(run: &RunReport) -> String {
    run.feed_mm_min.map_or_else(|| run.run.clone(), |feed| grouped(feed.round() as u64))
}

/// Writes tables 1 to 4 and the pictures over the feed.
fn feeds(out: &mut Markup, found: &DecompositionResult) {
    out.leaf("h2", &[], "By feed");
    if found.is_measured() {
        let row = |run: &RunReport| {
            let mut cells = vec![feed_of(run)];
            let shares = run.share_percent.list().into_iter().zip(run.share_95_percent.list());
            cells.extend(shares.map(|(share, by)| format!("{share:.1} ± {by:.1}")));
            PageRow { class: "", cells }
        };
        let heads = columns(["F, mm/min", "#contouring", "#link", "#motion", "#thermal", "#dynamic"]);
        let rows: Vec<PageRow> = found.runs.iter().map(row).collect();
        let note = "Mean share of each source in the sum of all norms, %, over the samples in which the machine moves. Here and below, ± is half of the 95 % interval.";
        table(out, &heads, &rows, note, MOST_ROWS);
    }
    let over =
        |title: &str, up: &str, of: &dyn Fn(&RunReport, usize) -> f64, names: &[&str], logarithmic: bool| -> Chart {
            let series = names.iter().enumerate().map(|(k, name)| {
                let point = |run: &RunReport| {
                    let [x, y] = [run.feed_mm_min?, of(run, k)];
                    Some(if logarithmic { (x.log10(), y.log10()) } else { (x, y) })
                };
                let points = found.runs.iter().filter_map(point).filter(|(_, y)| y.is_finite()).collect();
                PlotSeries { label: (*name).to_owned(), points, shape: Shape::Line, ..PlotSeries::default() }
            });
            let across = if logarithmic { "log10 of F in mm/min" } else { "F, mm/min" };
            Chart {
                title: title.to_owned(),
                across: across.into(),
                up: up.to_owned(),
                series: series.collect(),
                ..Chart::default()
            }
        };
    pictures(out, |out| {
        if found.is_measured() {
            let share = |run: &RunReport, k: usize| run.share_percent.list()[k];
            figure(out, &over("Share of each source", "share, %", &share, &SOURCES, false), "");
        }
        let contouring = |run: &RunReport, k: usize| run.rms_um.contouring[k];
        figure(
            out,
            &over("RMS of contouring", "log10 of µm", &contouring, &DIRECTIONS, true),
            "A straight line is a power law.",
        );
        if found.is_measured() {
            let dynamic = |run: &RunReport, k: usize| run.rms_um.dynamic[k];
            figure(
                out,
                &over("RMS of dynamic errors", "log10 of µm", &dynamic, &DIRECTIONS, true),
                "A straight line is a power law.",
            );
        }
    });
    sizes(out, found);
    laws(out, found);
}

fn sizes(out: &mut Markup, found: &DecompositionResult) {
    for (title, is_max) in [("Largest", true), ("RMS", false)] {
        let mut rows = Vec::new();
        for run in &found.runs {
            let [all, by] =
                if is_max { [run.max_um, run.max_95_um] } else { [run.rms_um, run.rms_95_um] }.map(|of| of.list());
            let measured = if found.is_measured() { SOURCES.len() } else { 1 };
            for ((name, of), by) in SOURCES.iter().zip(all).zip(by).take(measured) {
                let mut cells = vec![feed_of(run), (*name).to_owned()];
                cells.extend(
                    of.into_iter().zip(by).map(|(of, by)| format!("{} ± {}", significant(of), significant(by))),
                );
                rows.push(PageRow { class: "", cells });
            }
        }
        out.leaf("h3", &[], format_args!("{title} along the directions of the machine"));
        table(out, &columns(["F, mm/min", "source", "#X, µm", "#Y, µm", "#Z, µm"]), &rows, "", MOST_ROWS);
    }
    let row = |run: &RunReport| {
        let [max, rms] = run.contouring_error_um;
        let cells = vec![
            feed_of(run),
            significant(max),
            significant(rms),
            significant(run.path_in_workpiece_mm),
            format!("{:.2}", run.moving_s),
        ];
        PageRow { class: "", cells }
    };
    out.leaf("h3", &[], "Contouring error");
    let heads = columns(["F, mm/min", "#largest, µm", "#RMS, µm", "#path in the workpiece, mm", "#time, s"]);
    let note = "Distance of the tool by the encoders from its path by the set-points, in the workpiece: a lag along the path has no effect. If the tool stays at a ball, the path in the workpiece is short; then use the difference of the axes.";
    table(out, &heads, &found.runs.iter().map(row).collect::<Vec<_>>(), note, MOST_ROWS);
}

fn laws(out: &mut Markup, found: &DecompositionResult) {
    if found.power_laws.is_empty() {
        return;
    }
    out.leaf("h3", &[], "Power laws");
    let rows: Vec<PageRow> = found
        .power_laws
        .iter()
        .map(|law| PageRow {
            class: "",
            cells: vec![
                format!("{} {}", law.source.words(), law.direction),
                factor_cell(law),
                exponent_cell(law),
                format!("{:.3}", law.explained),
                slowest_cell(law),
            ],
        })
        .collect();
    let note = "RMS = κ Fᴺ through the logarithms. The programmed feed is not always reached, and the noise is part of the slowest run: N depends on the path as well as on the machine.";
    table(
        out,
        &columns(["RMS of", "#κ, µm (95 % interval)", "#N", "#R²", "#N without the slowest"]),
        &rows,
        note,
        MOST_ROWS,
    );
}

/// Draws the slowest and the fastest run.
fn along(out: &mut Markup, found: &DecompositionResult) {
    let mut shown: Vec<&RunReport> = found.runs.first().into_iter().chain(found.runs.last()).collect();
    shown.dedup_by(|a, b| a == b);
    for run in shown {
        out.leaf("h2", &[], format_args!("Along the path at {} mm/min", feed_of(run)));
        pictures(out, |out| {
            for (k, direction) in DIRECTIONS.iter().enumerate() {
                let series = |label: &str, of: &dyn Fn(&Along) -> f64| PlotSeries {
                    label: label.to_owned(),
                    points: run.along.iter().map(|one| (one.t_s, of(one))).collect(),
                    shape: Shape::Line,
                    ..PlotSeries::default()
                };
                let mut all = vec![series("contouring", &|one| one.parts_um[0][k])];
                if found.is_measured() {
                    all.push(series("quasi-static", &|one| (1..4).map(|source| one.parts_um[source][k]).sum()));
                    all.push(series("dynamic", &|one| one.parts_um[4][k]));
                }
                let chart = Chart {
                    title: format!("{direction}: sources over time"),
                    across: "time, s".into(),
                    up: "µm".into(),
                    series: all,
                    ..Chart::default()
                };
                figure(out, &chart, "");
            }
            for chart in accelerations(run) {
                figure(out, &chart, "From the encoders, averaged as for compliances.");
            }
            if !found.compliances.is_empty() {
                for (k, direction) in DIRECTIONS.iter().enumerate() {
                    let series = |label: &str, of: &dyn Fn(&Along) -> f64| PlotSeries {
                        label: label.to_owned(),
                        points: run.along.iter().map(|one| (one.t_s, of(one))).collect(),
                        shape: Shape::Line,
                        ..PlotSeries::default()
                    };
                    let chart = Chart {
                        title: format!("{direction}: dynamic part and its explanation"),
                        across: "time, s".into(),
                        up: "µm".into(),
                        series: vec![
                            series("dynamic", &|one| one.parts_um[4][k]),
                            series("by the compliances", &|one| one.explained_um[k]),
                        ],
                        ..Chart::default()
                    };
                    figure(out, &chart, "");
                }
            }
        });
    }
    if found.compliances.is_empty() {
        return;
    }
    out.leaf("h2", &[], "Compliance");
    let row = |one: &ComplianceReport| PageRow {
        class: "",
        cells: vec![
            one.component.clone(),
            format!("{} of {}", one.of.words(), one.axis),
            format!("{:.4}", one.value),
            format!("{:.4}", one.uncertainty_95),
            compliance_unit(one),
            format!("{:.1} %", 100.0 * one.gain),
        ],
    };
    let heads = columns(["component", "with the", "#value", "#±", "unit", "#gain"]);
    let note = "Gain: reduction of the RMS at feeds to which it was not fitted.";
    table(out, &heads, &found.compliances.iter().map(row).collect::<Vec<_>>(), note, MOST_ROWS);
    let held = |run: &RunReport| {
        let [before, after] = run.held_out_um?.map(significant);
        Some(PageRow { class: "", cells: vec![feed_of(run), before, after] })
    };
    let heads = columns(["F, mm/min", "#dynamic part, RMS µm", "#residual with the compliances of other feeds"]);
    table(out, &heads, &found.runs.iter().filter_map(held).collect::<Vec<_>>(), "", MOST_ROWS);
}

/// Accelerations of the axes that move, linear and rotary, with the block transitions.
fn accelerations(run: &RunReport) -> Vec<Chart> {
    let mut charts = Vec::new();
    for (is_rotary, unit) in [(false, "m/s²"), (true, "rad/s²")] {
        let moves = |axis: &Axis| run.along.iter().any(|one| one.acceleration[*axis] != 0.0);
        let axes = AXES.into_iter().filter(|axis| axis.is_rotary() == is_rotary).filter(moves);
        let mut series: Vec<PlotSeries> = axes
            .map(|axis| PlotSeries {
                label: axis.to_string(),
                points: run.along.iter().map(|one| (one.t_s, one.acceleration[axis])).collect(),
                shape: Shape::Line,
                ..PlotSeries::default()
            })
            .collect();
        if series.is_empty() {
            continue;
        }
        series.extend(transitions(run, &series));
        charts.push(Chart {
            title: format!("Accelerations of {} axes", if is_rotary { "rotary" } else { "linear" }),
            across: "time, s".into(),
            up: unit.into(),
            series,
            ..Chart::default()
        });
    }
    charts
}

/// A line with a tooth at each block transition within the motion, over the height of the others.
fn transitions(run: &RunReport, others: &[PlotSeries]) -> Option<PlotSeries> {
    let end_s = run.along.last()?.t_s;
    let [low, high] = others
        .iter()
        .flat_map(|series| &series.points)
        .fold([0.0_f64, 0.0_f64], |[low, high], (_, value)| [low.min(*value), high.max(*value)]);
    let within = run.transitions_s.iter().copied().filter(|t_s| (0.0..=end_s).contains(t_s));
    let mut points = vec![(0.0, low)];
    points.extend(within.flat_map(|t_s| [(t_s, low), (t_s, high), (t_s, low)]));
    points.push((end_s, low));
    let label = "block transition".to_owned();
    (points.len() > 2).then(|| PlotSeries { label, points, shape: Shape::Line, ..PlotSeries::default() })
}

fn loops(out: &mut Markup, found: &DecompositionResult) {
    out.leaf("h2", &[], "Servo loops");
    let row = |one: &Loop| {
        let [gain, forward, lag] = loop_cells(one);
        let rms = format!("{} ± {} {}", significant(one.rms), significant(one.rms_95), one.unit.unit().sign());
        let cells = vec![one.axis.clone(), gain, forward, lag, rms];
        PageRow { class: "", cells }
    };
    let heads = columns(["axis", "#velocity gain, 1/s", "#feed-forward", "#lag, ms", "#residual, RMS"]);
    let note =
        "One delay of the recorder for all axes and runs, and the loop of each axis, fitted to the encoders together.";
    table(out, &heads, &found.servo.iter().map(row).collect::<Vec<_>>(), note, MOST_ROWS);
}

fn links(out: &mut Markup, found: &DecompositionResult) {
    if found.links.is_empty() {
        return;
    }
    out.leaf("h2", &[], "Link errors");
    let row = |one: &LinkReport| {
        let words = spelled_out(&one.parameter).unwrap_or_else(|| "–".into());
        PageRow { class: "", cells: vec![one.parameter.clone(), words, link_cell(one)] }
    };
    let note = "Fitted to the slowest run together with smooth motion errors, beyond those of the machine file. The interval includes the possible contribution of motion errors. A link with a wider interval than the usual size of such an error is not determined by this path.";
    table(
        out,
        &columns(["parameter", "description", "#value"]),
        &found.links.iter().map(row).collect::<Vec<_>>(),
        note,
        MOST_ROWS,
    );
}
