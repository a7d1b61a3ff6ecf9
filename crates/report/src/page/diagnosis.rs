//! Page of a diagnosis: verdict, ranking, evidence of every cause, readings before and after, and rejected candidates.

mod evidence;
mod hypotheses;
mod pictures;
mod polar;

use super::parts::{MOST_ROWS, diagnostics, origin};
use super::{PageRow, columns, figure, page, pictures as side_by_side, strip, table};
use crate::component::spelled_out;
use crate::diagnosis::{CauseText as _, DiagnosisReport, PageReadings, next_sentence, p_value};
use crate::markup::Markup;
use crate::number::{grouped, significant};
use crate::plot::{Bar, Bars};
use ncfix_base::units::UnitKey;
use ncfix_metrology::diagnose::cause::Correctable;
use ncfix_metrology::diagnose::{ExplanationSummary, Gate, NextMeasurement};
use ncfix_metrology::results::diagnosis::{CauseReport, DataFault, ReadingSizes, RejectedReport};
use ncfix_metrology::results::readings::TriedCauseReport;

/// Maximum number of table rows that are named individually.
const MOST_NAMED: usize = 12;

/// Returns the page.
#[must_use]
pub fn diagnosis(report: &DiagnosisReport, shown: &PageReadings) -> String {
    let machine = if report.found.machine.is_empty() { "a machine" } else { &report.found.machine };
    page(&format!("Diagnosis of {machine}"), |out| {
        summary(out, report);
        diagnostics(out, &report.diagnostics);
        if report.found.readings > 0 {
            hypotheses::section(out, report, shown);
            levels(out, report);
            ranking(out, report);
            explanations(out, &report.found.explanations, report.found.measure_next.first());
            if !report.found.findings.is_empty() {
                out.leaf("h2", &[], "Evidence");
            }
            for (number, one) in report.found.findings.iter().enumerate() {
                evidence::section(out, report, shown, (number, one));
            }
            polar::section(out, shown);
            pictures::section(out, report, shown);
        }
        faults(out, &report.found.data_faults);
        if report.found.readings > 0 {
            rejected(out, report, shown);
        }
        let by = format!("ncfix {}, machine {machine}", shown.version);
        origin(out, &shown.inputs, &by);
    })
}

fn percent(share: f64) -> String {
    // No minus sign before a zero.
    format!("{:.1} %", (share * 1000.0).round() / 10.0 + 0.0)
}

fn summary(out: &mut Markup, report: &DiagnosisReport) {
    let is_refused = report.found.readings == 0;
    let text = if is_refused {
        "Refused: nothing was diagnosed. The diagnostics below give the reason.".to_owned()
    } else {
        report.verdict()
    };
    let class = if is_refused || report.found.expired { "banner bad" } else { "banner" };
    out.leaf("p", &[("class", &class), ("id", &"verdict")], text);
    if is_refused {
        return;
    }
    let unit = report.unit_sign();
    let sized = |value: f64| format!("{} {unit}", significant(value));
    let mut entries = vec![
        ("noise", sized(report.found.noise_um)),
        ("residual of the model, RMS", sized(report.found.before.rms_um)),
        ("residual with all findings", sized(report.found.after.rms_um)),
    ];
    if let (Some(before), Some(after)) = (report.found.before.holdout_rms_um, report.found.after.holdout_rms_um) {
        entries.push(("data held out", format!("{} → {}", significant(before), sized(after))));
    }
    entries.push(("readings used", grouped(report.found.readings as u64)));
    entries.push(("causes accepted", report.found.findings.len().to_string()));
    entries.push(("candidates tested", grouped(report.found.tried as u64)));
    strip(out, &entries);
    if let Some(path) = &report.output {
        let text = if path == "-" {
            "The extended machine file went to standard output.".into()
        } else {
            format!("Extended machine file written: {path}")
        };
        out.leaf("p", &[], text);
    }
}

/// Writes the sizes before and after, for used and held-out readings.
fn levels(out: &mut Markup, report: &DiagnosisReport) {
    out.leaf("h2", &[], "Before and after");
    let between = |ends: Option<[f64; 2]>| {
        ends.map_or("–".into(), |[low, high]| format!("{} … {}", significant(low), significant(high)))
    };
    let or_dash = |value: Option<f64>| value.map_or("–".into(), significant);
    let is_held_out = report.found.before.holdout_rms_um.is_some();
    let row = |(what, sizes): (&str, &ReadingSizes)| {
        let mut cells = vec![
            what.to_owned(),
            significant(sizes.rms_um),
            between(Some(sizes.rms_95_um)),
            significant(sizes.max_um),
            percent(sizes.efficiency),
        ];
        if is_held_out {
            cells.extend([
                or_dash(sizes.holdout_rms_um),
                between(sizes.holdout_rms_95_um),
                or_dash(sizes.holdout_max_um),
                sizes.holdout_efficiency.map_or("–".into(), percent),
            ]);
        }
        PageRow { class: "", cells }
    };
    let rows = [
        ("without a model", &report.found.without_model),
        ("model", &report.found.before),
        ("with all findings", &report.found.after),
    ];
    let heads = columns(["residual", "#RMS", "#95 %", "#max", "#efficiency"]);
    let more = columns(["#held out, RMS", "#95 %", "#max", "#efficiency"]);
    let heads: Vec<_> = heads.into_iter().chain(more.into_iter().filter(|_| is_held_out)).collect();
    let caption = format!(
        "In {}, with the unknowns of the set-ups fitted. Intervals: bootstrap of sections of rows. Efficiency: 1 − Σ|residual| / Σ|residual without a \
         model|.",
        report.unit_sign()
    );
    let rows: Vec<PageRow> = rows.into_iter().map(row).collect();
    table(out, &heads, &rows, &caption, MOST_ROWS);
}

/// Ranks the causes by their individual effect, as ball-bar tests rank them by circularity.
fn ranking(out: &mut Markup, report: &DiagnosisReport) {
    if report.found.findings.is_empty() {
        return;
    }
    out.leaf("h2", &[], "Ranking");
    let mut order: Vec<usize> = (0..report.found.findings.len()).collect();
    let alone = |k: &usize| report.found.findings.get(*k).map_or(0.0, |one| one.alone_um);
    order.sort_by(|a, b| alone(b).total_cmp(&alone(a)));
    let ranked = || order.iter().filter_map(|&k| Some((k, report.found.findings.get(k)?)));
    let row = |(k, one): (usize, &CauseReport)| PageRow {
        class: "",
        cells: vec![
            (k + 1).to_string(),
            format!(
                "{}{}",
                one.full_name(),
                spelled_out(&one.parameter).map_or(String::new(), |words| format!(" ({words})"))
            ),
            one.size(),
            significant(one.alone_um),
            percent(one.alone_share),
            significant(one.rms_um),
            percent(one.share),
            percent(one.share_alone),
            percent(one.gain_holdout),
            match one.correctable {
                Correctable::Program => "a program",
                Correctable::Live => "live readings",
                _ => "nothing",
            }
            .to_owned(),
        ],
    };
    let mut rows: Vec<PageRow> = ranked().map(row).collect();
    let sum = |of: fn(&CauseReport) -> f64| report.found.findings.iter().map(of).sum::<f64>();
    let shares = sum(|one| one.share);
    let cells = |what: &str, alone: [String; 2], share: f64| {
        let mut cells = vec![String::new(), what.to_owned(), "–".to_owned()];
        cells.extend(alone);
        let dash = || "–".to_owned();
        cells.extend([dash(), percent(share), dash(), dash(), dash()]);
        cells
    };
    let all = [significant(sum(|one| one.alone_um)), percent(sum(|one| one.alone_share))];
    rows.push(PageRow { class: "whole", cells: cells("all findings", all, shares) });
    rows.push(PageRow {
        class: "",
        cells: cells("noise and unexplained part", ["–".to_owned(), "–".to_owned()], 1.0 - shares),
    });
    let alone_title = if report.found.unit == UnitKey::Urad { "#alone, µrad" } else { "#alone, µm" };
    let heads = columns([
        "#no.",
        "cause",
        "#size ± 95 %",
        alone_title,
        "#share of the sum",
        "#RMS",
        "#fair share",
        "#increase without it",
        "#gain on left-out readings",
        "removed by",
    ]);
    let caption = "Alone: independent contribution, the largest minus the smallest effect of the cause by itself on the readings of a set-up (of a circle: its \
                   circularity). Fair share: its part of the squared residual of the model (Shapley). If it differs from the increase without it, several findings \
                   explain the same part. Gain on left-out readings: reduction of the residual (RMS) of readings that were not used to find it.";
    table(out, &heads, &rows, caption, MOST_ROWS);
    let label = |k: usize, one: &CauseReport| format!("{} {}", k + 1, one.full_name());
    side_by_side(out, |out| {
        let picture = Bars {
            title: "Independent contribution".into(),
            across: format!("largest minus smallest effect of each alone, in {}", report.unit_sign()),
            bars: ranked().map(|(k, one)| Bar { label: label(k, one), value: one.alone_um, error: 0.0 }).collect(),
            is_logarithmic: false,
        };
        figure(out, &picture, "");
        let left = Bar { label: "noise, unexplained".into(), value: 100.0 * (1.0 - shares), error: 0.0 };
        let shares = ranked().map(|(k, one)| Bar { label: label(k, one), value: 100.0 * one.share, error: 0.0 });
        let picture = Bars {
            title: "Fair share of the residual of the model".into(),
            across: "% of the sum of squares".into(),
            bars: shares.chain([left]).collect(),
            is_logarithmic: false,
        };
        figure(out, &picture, "");
    });
}

/// Lists the explanations that were compared, the most probable first.
fn explanations(out: &mut Markup, all: &[ExplanationSummary], next: Option<&NextMeasurement>) {
    if all.is_empty() {
        return;
    }
    out.leaf("h2", &[], "Explanations");
    let row = |one: &ExplanationSummary| {
        let terms = if one.terms.is_empty() { "no cause".to_owned() } else { one.joined(", ") };
        PageRow { class: "wrap", cells: vec![percent(one.probability), terms] }
    };
    let rows: Vec<PageRow> = all.iter().map(row).collect();
    let caption = "Sets of causes by their probability. The likelihood is that of all readings. The probability of a cause is the sum over the sets that contain it.";
    table(out, &columns(["#probability", "causes"]), &rows, caption, MOST_ROWS);
    if let Some(next) = next {
        out.leaf("p", &[], format!("To separate them: {}.", next_sentence(next)));
    }
}

fn faults(out: &mut Markup, all: &[DataFault]) {
    if all.is_empty() {
        return;
    }
    out.leaf("h2", &[], "Faults of the data");
    let named = |is_range: bool, rows: &[usize]| match rows {
        // Outliers are listed row by row.
        [first, last] if is_range => format!("{first} to {last}"),
        rows => {
            let more = rows.len().saturating_sub(MOST_NAMED);
            let named: Vec<String> = rows.iter().take(MOST_NAMED).map(ToString::to_string).collect();
            format!("{}{}", named.join(", "), if more > 0 { format!(" and {more} more") } else { String::new() })
        }
    };
    let row = |one: &DataFault| {
        let excluded = if one.excluded.is_empty() { "these readings".to_owned() } else { one.excluded.clone() };
        let name = one.name.clone();
        let cells = vec![
            one.kind.to_string(),
            name,
            one.what.clone(),
            named(one.is_range, &one.rows),
            one.evidence.clone(),
            excluded,
        ];
        PageRow { class: "wrap", cells }
    };
    let rows: Vec<PageRow> = all.iter().map(row).collect();
    let heads = columns(["kind", "of", "what", "rows", "evidence", "excluded"]);
    table(out, &heads, &rows, "Rows are counted from 1, without the header of the table.", MOST_ROWS);
}

fn rejected(out: &mut Markup, report: &DiagnosisReport, shown: &PageReadings) {
    out.leaf("h2", &[], "Rejected candidates");
    let gate = |one: &RejectedReport| match one.why {
        Gate::Chance => "not significant for the number of candidates that were tested",
        Gate::HeldOut => "it does not improve the prediction of held-out data",
        _ if one.gain.is_none() => "the left-out readings cannot show whether it improves their prediction",
        _ => "it does not improve the prediction of left-out readings",
    };
    if report.found.rejected.is_empty() {
        let text = "None: no further candidate explains enough for its number of unknowns.";
        out.leaf("p", &[], text);
    } else {
        let row = |one: &RejectedReport| PageRow {
            class: "wrap",
            cells: vec![
                format!("{} {}", one.effect, one.parameter).trim_end().to_owned(),
                one.drivers.join(", "),
                gate(one).to_owned(),
                p_value(one.p),
                one.gain.map_or("–".into(), percent),
            ],
        };
        let rows: Vec<PageRow> = report.found.rejected.iter().map(row).collect();
        let heads = columns(["candidate", "depends on", "why not", "#significance", "#gain on left-out readings"]);
        let caption = "Candidates that the search found and a test rejected. Significance: p-value of such a gain without any effect, times the number of candidates.";
        table(out, &heads, &rows, caption, MOST_ROWS);
    }
    out.element("details", &[], |out| {
        out.leaf("summary", &[], format_args!("All causes of the catalog, and the share that each could still explain"));
        let row = |one: &TriedCauseReport| {
            let (best, share) = match &one.best {
                Some((parameter, share)) => (parameter.clone(), percent(*share)),
                None => ("–".into(), "–".into()),
            };
            let cells =
                vec![one.cause.clone(), one.effect.clone(), one.shown_by.clone(), one.candidates.to_string(), best, share];
            PageRow { class: "wrap", cells }
        };
        let rows: Vec<PageRow> = shown.readings.causes.iter().map(row).collect();
        let listed: usize = shown.readings.causes.iter().map(|one| one.candidates).sum();
        let caption = format!(
            "Shares are those of the squared residual with all findings, before the acceptance tests. In addition to these {} candidates, {} periods, chords and shapes without a name \
             were searched in the residual.",
            grouped(listed as u64),
            grouped(report.found.tried.saturating_sub(listed) as u64)
        );
        let heads = columns(["cause", "effect", "evidence", "#candidates", "best", "#would explain"]);
        table(out, &heads, &rows, &caption, MOST_ROWS);
    });
}
