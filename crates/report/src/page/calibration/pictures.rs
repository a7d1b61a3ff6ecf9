//! Pictures of one measurement.

use std::collections::BTreeMap;

use crate::compared::{DOES_NOT_FIT, ReadingPoint};
use crate::markup::Markup;
use crate::page::{figure, pictures};
use crate::plot::{Chart, Histogram, LevelLine, PlotSeries, Polar, PolarTrace};
use ncfix_metrology::results::calibration::Data;

/// Maximum number of distinguishable series in a picture; the others share the last one.
const MOST_SERIES: usize = 8;
/// Maximum number of circle pictures per measurement.
const MOST_POLAR: usize = 24;

/// Draws the residuals over the rows and over each axis, their histogram, and the circles.
pub(super) fn draw(out: &mut Markup, data: &Data) {
    if data.shown.points.is_empty() {
        return;
    }
    pictures(out, |out| {
        let up = format!("residual in {}", data.unit);
        let levels = levels(data);
        let rows = |_: usize, point: &ReadingPoint| point.row as f64;
        let by_setup = |title: String, across: String, place: &dyn Fn(usize, &ReadingPoint) -> f64| Chart {
            title,
            across,
            up: up.clone(),
            series: series(data, |point| point.setup, &data.shown.setups, place),
            levels: levels.clone(),
            is_balanced: true,
            is_clipped: true,
            is_sparing: false,
        };
        figure(out, &by_setup("Residual over the rows, by set-up".into(), "row of the table".into(), &rows), "");
        let names: Vec<String> = data.parts.iter().map(|part| part.name.clone()).collect();
        if names.len() > 1 {
            let chart = Chart {
                title: "Residual over the rows, by direction".into(),
                across: "row of the table".into(),
                up: up.clone(),
                series: series(data, |point| point.part, &names, &rows),
                levels: levels.clone(),
                is_balanced: true,
                is_clipped: true,
                is_sparing: false,
            };
            figure(out, &chart, "");
        }
        for (axis, positions) in &data.shown.axes {
            let place = |number: usize, _: &ReadingPoint| positions.get(number).copied().unwrap_or(f64::NAN);
            let letter = axis.split(' ').next().unwrap_or_default();
            figure(out, &by_setup(format!("Residual over {letter}"), axis.clone(), &place), "");
        }
        let sigma =
            data.sigma.map_or(String::new(), |_| "The curve is the normal distribution with σ of a reading.".into());
        let histogram = Histogram {
            title: "Distribution of the residual".into(),
            across: format!("residual in {}", data.unit),
            counted: "readings",
            values: data.shown.points.iter().map(|point| point.left).collect(),
            sigma: data.sigma,
        };
        figure(out, &histogram, sigma);
        circles(out, data);
    });
}

/// Returns lines at twice the uncertainty of a reading, on either side.
fn levels(data: &Data) -> Vec<LevelLine> {
    let Some(sigma) = data.sigma.filter(|sigma| sigma.is_finite() && *sigma > 0.0) else { return Vec::new() };
    [(2.0, "+2σ"), (-2.0, "−2σ")].map(|(times, label)| LevelLine { value: times * sigma, label: label.into() }).to_vec()
}

/// Returns the readings by set-up or direction (without a name if there is only one), then the outliers.
fn series(
    data: &Data,
    group: impl Fn(&ReadingPoint) -> usize,
    labels: &[String],
    place: &dyn Fn(usize, &ReadingPoint) -> f64,
) -> Vec<PlotSeries> {
    let count = labels.len().clamp(1, MOST_SERIES);
    let mut out: Vec<PlotSeries> = (0..count)
        .map(|k| {
            let own = labels.get(k).cloned().unwrap_or_default();
            let label = match labels.len() {
                0 | 1 => String::new(),
                more if more > count && k + 1 == count => format!("{} others", more + 1 - count),
                _ if own.is_empty() => "(no label)".into(),
                _ => own,
            };
            PlotSeries { label, ..PlotSeries::default() }
        })
        .collect();
    if data.shown.points.iter().any(|point| point.weight < DOES_NOT_FIT) {
        let label = format!("weight below {:.0} %", DOES_NOT_FIT * 100.0);
        out.push(PlotSeries { label, ..PlotSeries::default() });
    }
    for (number, point) in data.shown.points.iter().enumerate() {
        let which = if point.weight < DOES_NOT_FIT { count } else { group(point).min(count - 1) };
        if let Some(series) = out.get_mut(which) {
            series.points.push((place(number, point), point.left));
        }
    }
    out
}

/// Draws every plane of every set-up: measured and residual, in both directions.
fn circles(out: &mut Markup, data: &Data) {
    let mut planes: BTreeMap<(usize, &str), Polar> = BTreeMap::new();
    for circle in &data.shown.circles {
        let label = data.shown.setups.get(circle.setup).map_or("", String::as_str);
        let picture = planes.entry((circle.setup, &circle.plane)).or_insert_with(|| Polar {
            title: format!("Ball-bar {}{}{label}", circle.plane, if label.is_empty() { "" } else { ", set-up " }),
            axes: circle.axes.clone(),
            unit: data.unit.sign().into(),
            radius_mm: circle.radius_mm,
            traces: Vec::new(),
        });
        let sense = if circle.is_counterclockwise { "ccw" } else { "cw" };
        let trace = |name: &str, of: fn(&ReadingPoint) -> f64| PolarTrace {
            label: format!("{name} {sense}"),
            points: circle
                .angles
                .iter()
                .filter_map(|&(number, angle)| Some((angle, of(data.shown.points.get(number)?))))
                .collect(),
        };
        picture.traces.extend([trace("measured", |point| point.measured), trace("residual", |point| point.left)]);
    }
    let more = planes.len().saturating_sub(MOST_POLAR);
    for picture in planes.values().take(MOST_POLAR) {
        figure(out, picture, "Unknown center and length are removed.");
    }
    if more > 0 {
        out.leaf("p", &[("class", &"soft")], format_args!("{more} more circles are not drawn."));
    }
}
