//! Readings of every measurement before and after, along all possible drivers.

use super::{figure, side_by_side};
use crate::diagnosis::{DiagnosisReport, PageReadings};
use crate::markup::Markup;
use crate::plot::{Chart, LevelLine, PlotSeries, Shape};
use ncfix_metrology::results::readings::{DiagnosisReading, DriverReadings, Set};

/// Maximum number of pictures of all measurements together.
const MOST: usize = 80;
/// Parts of the range of a driver over which means are taken, and minimum number of readings of a mean.
const PARTS: usize = 30;
const FEWEST: f64 = 3.0;
/// Gap without readings that interrupts a line, as a share of the range.
const GAP: f64 = 0.25;
/// Number of positions that counts as few.
const FEW: usize = 3;

/// Draws all measurements.
pub(super) fn section(out: &mut Markup, report: &DiagnosisReport, shown: &PageReadings) {
    let mut room = MOST;
    for set in &shown.readings.sets {
        let held = if set.is_held_out { ", held out" } else { "" };
        out.leaf("h2", &[], format_args!("{}: {}{held}, residual before and after", set.name, set.kind));
        let rows = DriverReadings {
            name: "row".into(),
            title: "row of the table".into(),
            is_time: false,
            values: set.readings.iter().map(|reading| reading.row as f64).collect(),
        };
        // First the drivers of the causes and time, then the rest.
        let is_named = |driver: &DriverReadings| {
            driver.is_time
                || report.found.findings.iter().any(|one| one.drivers.contains(&driver.name))
                || report.found.unexplained.with.iter().any(|one| one.driver == driver.name)
        };
        let has_time = set.drivers.iter().any(|driver| driver.is_time);
        let mut charts: [Vec<Chart>; 2] = [Vec::new(), Vec::new()];
        for (part, _) in set.parts.iter().enumerate() {
            if !has_time {
                charts[0].push(chart(report, set, part, &rows));
            }
            for driver in &set.drivers {
                let Some(driver) = driver_of(set, part, &driver.name) else { continue };
                let is_first = is_named(driver) || is_place(driver) && !is_at_few_places(set, part, driver);
                charts[usize::from(!is_first)].push(chart(report, set, part, driver));
            }
        }
        let [first, rest] = charts;
        let counts = [first.len().min(room), rest.len().min(room.saturating_sub(first.len()))];
        room -= counts[0] + counts[1];
        let more = first.len() + rest.len() - counts[0] - counts[1];
        let note = "Lines: means of both. Dashed: twice the noise on either side.";
        side_by_side(out, |out| first.iter().take(counts[0]).for_each(|chart| figure(out, chart, note)));
        if counts[1] > 0 {
            out.element("details", &[], |out| {
                out.leaf("summary", &[], format_args!("{} more pictures, along all other drivers", counts[1]));
                side_by_side(out, |out| rest.iter().take(counts[1]).for_each(|chart| figure(out, chart, "")));
            });
        }
        if more > 0 {
            out.leaf("p", &[("class", &"soft")], format_args!("{more} more pictures are not drawn."));
        }
    }
}

/// True if a driver has so few positions that a picture shows hardly more than the mean of each.
fn is_at_few_places(set: &Set, part: usize, driver: &DriverReadings) -> bool {
    let own = set.readings.iter().zip(&driver.values).filter(|(reading, _)| reading.part == part);
    let mut places: Vec<u64> = Vec::new();
    for (_, value) in own {
        let bits = value.to_bits();
        if !places.contains(&bits) {
            places.push(bits);
        }
        if places.len() > FEW {
            return false;
        }
    }
    true
}

/// True for positions of axes.
fn is_place(driver: &DriverReadings) -> bool {
    driver.name.chars().count() == 1
}

fn chart(report: &DiagnosisReport, set: &Set, part: usize, driver: &DriverReadings) -> Chart {
    let points = |of: fn(&DiagnosisReading) -> f64, counts: bool| -> Vec<(f64, f64)> {
        let own = set.readings.iter().enumerate().filter(|(_, one)| one.part == part && one.counts == counts);
        own.map(|(k, one)| (driver.values.get(k).copied().unwrap_or(f64::NAN), of(one))).collect()
    };
    let (before, after) = (points(|one| one.before, true), points(|one| one.after, true));
    let without = points(|one| one.before, false);
    let series = |label: &str, points| PlotSeries { label: label.into(), points, ..PlotSeries::default() };
    let mut lines = Vec::new();
    let mut all = if report.found.findings.is_empty() {
        lines.extend(mean_lines(&after, 0));
        vec![series("", after)]
    } else {
        lines.extend(mean_lines(&before, 0));
        lines.extend(mean_lines(&after, 1));
        vec![series("before", before), series("after", after)]
    };
    if !without.is_empty() {
        all.push(series("left out", without));
    }
    all.extend(lines);
    let is_of_unit = report.found.unit.unit() == set.unit;
    let noise = if is_of_unit && report.found.noise_um > 0.0 { report.found.noise_um } else { f64::NAN };
    let levels =
        [(2.0, "+2σ"), (-2.0, "−2σ")].map(|(times, label)| LevelLine { value: times * noise, label: label.into() });
    Chart {
        title: title_of(set, part, driver, ""),
        across: driver.title.clone(),
        up: format!("residual in {}", set.unit),
        series: all,
        levels: levels.into_iter().filter(|level| level.value.is_finite()).collect(),
        is_balanced: true,
        is_clipped: true,
        is_sparing: true,
    }
}

/// Returns a title with the quantities that are drawn, and the direction if there are several.
pub(super) fn title_of(set: &Set, part: usize, driver: &DriverReadings, what: &str) -> String {
    let name = set.parts.get(part).map_or("", String::as_str);
    let of = if set.parts.len() > 1 { format!("{name} ") } else { String::new() };
    let over = match driver.name.as_str() {
        "t_s" => "time",
        "row" => "the rows",
        name if name.ends_with("_dir") => driver.title.as_str(),
        name => name,
    };
    match what {
        "" => format!("Residual {of}over {over}"),
        what => format!("{what}: {of}over {over}"),
    }
}

/// Returns a driver by its name if it varies in a direction.
pub(super) fn driver_of<'a>(set: &'a Set, part: usize, name: &str) -> Option<&'a DriverReadings> {
    varying(set, part, set.drivers.iter().find(|driver| driver.name == name)?)
}

/// The time of the readings of a part; `None` where it is not known or always the same.
pub(super) fn time_of(set: &Set, part: usize) -> Option<&DriverReadings> {
    varying(set, part, set.drivers.iter().find(|driver| driver.is_time)?)
}

fn varying<'a>(set: &'a Set, part: usize, driver: &'a DriverReadings) -> Option<&'a DriverReadings> {
    let own = set.readings.iter().zip(&driver.values).filter(|(reading, _)| reading.part == part);
    let mut values = own.map(|(_, value)| *value).filter(|value| value.is_finite());
    let first = values.next()?;
    values.any(|value| (value - first).abs() > 1e-9 * first.abs()).then_some(driver)
}

/// Returns lines through means, interrupted where there are no readings.
pub(super) fn mean_lines(points: &[(f64, f64)], like: usize) -> Vec<PlotSeries> {
    let means = means(points);
    let (first, last) = (means.first().map_or(0.0, |mean| mean.0), means.last().map_or(0.0, |mean| mean.0));
    let pieces = means.chunk_by(|one, next| next.0 - one.0 <= GAP * (last - first));
    let line = |piece: &[(f64, f64, f64)]| PlotSeries {
        points: piece.iter().map(|(at, mean, _)| (*at, *mean)).collect(),
        shape: Shape::Line,
        like: Some(like),
        ..PlotSeries::default()
    };
    pieces.map(line).collect()
}

/// Returns means over parts of the range: position, mean, number.
pub(super) fn means(points: &[(f64, f64)]) -> Vec<(f64, f64, f64)> {
    let known = || points.iter().filter(|point| point.0.is_finite() && point.1.is_finite());
    let low = known().map(|point| point.0).fold(f64::INFINITY, f64::min);
    let high = known().map(|point| point.0).fold(f64::NEG_INFINITY, f64::max);
    let mut sums = vec![[0.0; 3]; PARTS];
    for (at, value) in known() {
        let share = if high > low { (at - low) / (high - low) } else { 0.0 };
        // Small and not negative.
        let part = ((share * PARTS as f64) as usize).min(PARTS - 1);
        if let Some(sum) = sums.get_mut(part) {
            *sum = [sum[0] + at, sum[1] + value, sum[2] + 1.0];
        }
    }
    let own = sums.into_iter().filter(|sum| sum[2] >= FEWEST);
    own.map(|[at, value, count]| (at / count, value / count, count)).collect()
}
