//! Answers to stated hypotheses: a table, and the residual with and without each over its drivers.

use super::pictures::{mean_lines, title_of};
use super::{figure, side_by_side};
use crate::diagnosis::{DiagnosisReport, PageReadings, answer_in_words, in_words, times_in_words};
use crate::markup::Markup;
use crate::page::parts::MOST_ROWS;
use crate::page::{PageRow, columns, table};
use crate::plot::{Chart, PlotSeries};
use ncfix_metrology::results::hypotheses::HypothesisReport;
use ncfix_metrology::results::readings::{DriverReadings, HypothesisReadings, Set};

/// Maximum number of drivers that are drawn for a hypothesis.
const MOST_DRIVERS: usize = 3;
/// Maximum number of other explanations that are named.
const RIVALS: usize = 4;

/// Draws the answers.
pub(super) fn section(out: &mut Markup, report: &DiagnosisReport, shown: &PageReadings) {
    if report.found.hypotheses.is_empty() {
        return;
    }
    out.leaf("h2", &[], "Hypotheses");
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".into());
    let row = |one: &HypothesisReport| {
        let amounts: Vec<String> =
            one.amounts.iter().map(|amount| format!("{}: {}", amount.term, in_words(amount))).collect();
        let rivals: Vec<&str> = one.rivals.iter().take(RIVALS).map(|rival| rival.name.as_str()).collect();
        let cells = vec![
            one.text.clone(),
            answer_in_words(one),
            amounts.join("; "),
            or_dash(one.log_evidence.map(times_in_words)),
            or_dash(one.log_evidence_beside.map(times_in_words)),
            one.beside.join(", "),
            or_dash(one.gain_unseen.map(super::percent)),
            rivals.join(", "),
            or_dash(one.extends_why.clone()),
        ];
        PageRow { class: "wrap", cells }
    };
    let rows: Vec<PageRow> = report.found.hypotheses.iter().map(row).collect();
    let heads = columns([
        "hypothesis",
        "answer",
        "amount ± 95 %",
        "alone",
        "together with findings",
        "these findings",
        "#gain on left-out readings",
        "other explanations",
        "why not corrected",
    ]);
    let caption = "Evidence: how much more probable the readings are with the hypothesis than without it, each with the noise correlation that fits it best. \
                   Causes with the effect of the hypothesis are not part of the comparison. Gain on left-out readings: by how much it reduces the residual (RMS) of readings \
                   that did not determine the amount.";
    table(out, &heads, &rows, caption, MOST_ROWS);
    side_by_side(out, |out| {
        for (number, one) in report.found.hypotheses.iter().enumerate() {
            let Some((set, part)) = strongest(shown, number) else { continue };
            let Some(own) = set.stated.get(number) else { continue };
            for driver in own.drivers.iter().take(MOST_DRIVERS) {
                figure(out, &chart(set, part, (driver, own), one), "Lines: means of both.");
            }
        }
    });
}

/// Returns the measurement and the direction in which a hypothesis changes the residual most.
fn strongest(shown: &PageReadings, number: usize) -> Option<(&Set, usize)> {
    let mut best: Option<(f64, &Set, usize)> = None;
    for set in &shown.readings.sets {
        let Some(own) = set.stated.get(number) else { continue };
        let mut sums = vec![0.0; set.parts.len()];
        for ((reading, without), with) in set.readings.iter().zip(&own.without).zip(&own.with) {
            if let Some(sum) = sums.get_mut(reading.part).filter(|_| reading.counts) {
                *sum += (without - with).powi(2);
            }
        }
        for (part, squares) in sums.into_iter().enumerate() {
            if best.is_none_or(|(most, ..)| squares > most) {
                best = Some((squares, set, part));
            }
        }
    }
    best.filter(|(most, ..)| *most > 0.0).map(|(_, set, part)| (set, part))
}

fn chart(
    set: &Set,
    part: usize,
    (driver, own): (&DriverReadings, &HypothesisReadings),
    one: &HypothesisReport,
) -> Chart {
    let points = |values: &[f64]| -> Vec<(f64, f64)> {
        let readings = set.readings.iter().zip(values).zip(&driver.values);
        readings.filter(|((one, _), _)| one.part == part && one.counts).map(|((_, value), at)| (*at, *value)).collect()
    };
    let (without, with) = (points(&own.without), points(&own.with));
    let lines: Vec<PlotSeries> = mean_lines(&without, 0).into_iter().chain(mean_lines(&with, 1)).collect();
    let series = |label: &str, points| PlotSeries { label: label.into(), points, ..PlotSeries::default() };
    Chart {
        title: title_of(set, part, driver, &one.text),
        across: driver.title.clone(),
        up: format!("residual in {}", set.unit),
        series: [series("without it", without), series("with it", with)].into_iter().chain(lines).collect(),
        is_balanced: true,
        is_clipped: true,
        is_sparing: true,
        ..Chart::default()
    }
}
