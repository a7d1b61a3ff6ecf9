//! Evidence of one cause, with its other explanations.

use super::pictures::{driver_of, mean_lines, means, time_of, title_of};
use super::{figure, polar, side_by_side};
use crate::component::{component_of, spelled_out};
use crate::diagnosis::{CauseText as _, DiagnosisReport, PageReadings, differing, p_value};
use crate::markup::Markup;
use crate::number::{grouped, probability, significant};
use crate::plot::{Chart, PlotSeries, Shape};
use ncfix_metrology::results::diagnosis::CauseReport;
use ncfix_metrology::results::readings::{DriverReadings, Set};

/// Maximum number of other explanations that are named.
const MOST_RIVALS: usize = 24;
/// Maximum number of drivers that are drawn.
const MOST_DRIVERS: usize = 3;
/// Maximum number of lines of a shape over two drivers.
const MOST_LINES: usize = 8;
/// Minimum share of the effect of a cause that an unnamed driver must explain to be drawn.
const GOES_WITH: f64 = 0.3;
/// Kinds of effects that change with time.
const DRIFTS: [&str; 4] = ["drift", "thermal-drift", "thermal-expansion", "thermal-squareness"];

/// Draws a cause by its number.
pub(super) fn section(
    out: &mut Markup,
    report: &DiagnosisReport,
    shown: &PageReadings,
    (number, one): (usize, &CauseReport),
) {
    out.element("h3", &[("id", &format_args!("finding-{}", number + 1))], |out| {
        out.leaf("span", &[("class", &"rank")], number + 1);
        out.text(format_args!("{}: {}", one.name(), size_in_words(one)));
    });
    words(out, report, one);
    let strongest = strongest(shown, number);
    side_by_side(out, |out| {
        shown.readings.sets.iter().for_each(|set| polar::alone(out, set, number, one));
        if let Some((set, part)) = strongest {
            let does = set.doing.get(number).map(Vec::as_slice).unwrap_or_default();
            for driver in drivers(set, part, one, does) {
                let caption = "Residual with all other findings but without this one, and its effect. Line: means of the residual.";
                figure(out, &beside(set, part, driver, does), caption);
            }
            times(out, set, part, one, does);
        }
        shape(out, one, shown);
    });
}

/// Returns the size with its interval, what the error is, and for an angle its slope: `27.8 ± 1.6 µrad (95 %), squareness X–Y, 0.028 mm/m`.
fn size_in_words(one: &CauseReport) -> String {
    let words = spelled_out(&one.parameter).map_or(String::new(), |words| format!(", {words}"));
    let is_angle = component_of(&one.parameter).is_some_and(|name| name.direction.is_rotation());
    let slope = if is_angle { format!(", {} mm/m", significant(one.value / 1e3)) } else { String::new() };
    format!("{} (95 %){}{words}{slope}", one.size(), one.over())
}

fn words(out: &mut Markup, report: &DiagnosisReport, one: &CauseReport) {
    let unit = report.unit_sign();
    let mut all: Vec<(&str, String)> = Vec::new();
    match &one.what {
        Some(what) => all.push(("description", what.clone())),
        None => all.push(("usual causes", one.made_by.clone())),
    }
    let depends = one.depends();
    if !depends.is_empty() {
        all.push(("depends on", depends));
    }
    if !one.shown_by.is_empty() && one.what.is_none() {
        all.push(("shown by", one.shown_by.clone()));
    }
    all.push((
        "effect",
        format!(
            "{} {unit} RMS of the readings, {} {unit} from its smallest to its largest within a set-up",
            significant(one.rms_um),
            significant(one.alone_um)
        ),
    ));
    if let Some(value) = one.probability {
        let of = probability(value);
        let text = format!("{}, over all explanations that were compared", of.trim_start_matches("probability "));
        all.push(("probability", text));
    }
    let tried = grouped(report.found.tried as u64);
    all.push(("significance", format!("{}, for {tried} candidates and autocorrelated noise", p_value(one.p))));
    let held_out = if report.found.before.holdout_rms_um.is_some() { "held-out data" } else { "left-out readings" };
    all.push((
        "gain",
        format!(
            "residual {:.1} % smaller (RMS) on {held_out}, which were not used to find it",
            100.0 * one.gain_holdout
        ),
    ));
    let others = one.others();
    if !others.is_empty() {
        let more = others.len().saturating_sub(MOST_RIVALS);
        let rivals: Vec<&str> = others.into_iter().take(MOST_RIVALS).collect();
        let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
        all.push(("other explanations", format!("{}{rest}", rivals.join(", "))));
    } else {
        all.push(("other explanations", "none: no other candidate explains as much".into()));
    }
    if let Some(differs) = differing(&one.by_file) {
        all.push(("by file", format!("it {differs}")));
    }
    if let Some(how) = &one.separate_by {
        all.push(("to separate them", how.clone()));
    }
    let held = match (&report.output, one.extends) {
        (Some(_), true) => "; it is in the extended machine file",
        (Some(_), false) => "; the machine file has no entry for it",
        (None, _) => "",
    };
    let done = match (&one.extends_why, one.remedy()) {
        (Some(why), "") => format!("not corrected: {why}"),
        (_, remedy) => remedy.trim_start_matches("; ").to_owned(),
    };
    all.push(("correction", format!("{done}{held}")));
    out.element("dl", &[("class", &"evidence")], |out| {
        for (what, text) in all {
            out.leaf("dt", &[], what);
            out.leaf("dd", &[], text);
        }
    });
}

/// Returns the measurement and the direction in which a cause has its largest effect.
fn strongest(shown: &PageReadings, number: usize) -> Option<(&Set, usize)> {
    let mut best: Option<(f64, &Set, usize)> = None;
    for set in shown.readings.sets.iter().filter(|set| !set.is_held_out) {
        let Some(does) = set.doing.get(number) else { continue };
        let mut sums = vec![[0.0; 2]; set.parts.len()];
        for (reading, does) in set.readings.iter().zip(does).filter(|(reading, _)| reading.counts) {
            if let Some(sum) = sums.get_mut(reading.part) {
                *sum = [sum[0] + does * does, sum[1] + 1.0];
            }
        }
        for (part, [squares, count]) in sums.into_iter().enumerate() {
            let mean = if count > 0.0 { squares / count } else { 0.0 };
            if best.is_none_or(|(most, ..)| mean > most) {
                best = Some((mean, set, part));
            }
        }
    }
    best.filter(|(most, ..)| *most > 0.0).map(|(_, set, part)| (set, part))
}

/// Returns the drivers of a cause; if it names none, those that explain its effect.
fn drivers<'a>(set: &'a Set, part: usize, one: &CauseReport, does: &[f64]) -> Vec<&'a DriverReadings> {
    let mut named: Vec<&DriverReadings> = one.drivers.iter().filter_map(|name| driver_of(set, part, name)).collect();
    // A direction of motion alone does not describe well where it acts.
    if named.iter().all(|driver| driver.name.ends_with("_dir")) {
        let place = |driver: &&DriverReadings| !driver.name.starts_with("T_") && !driver.name.ends_with("_dir");
        let others = set.drivers.iter().filter(place).filter_map(|driver| driver_of(set, part, &driver.name));
        let mut others: Vec<(f64, &DriverReadings)> = others
            .map(|driver| (goes_with(set, part, driver, does), driver))
            .filter(|(share, _)| *share > GOES_WITH)
            .collect();
        others.sort_by(|a, b| b.0.total_cmp(&a.0));
        named.extend(others.into_iter().take(MOST_DRIVERS - 1).map(|(_, driver)| driver));
    }
    // For circles, the picture of the cause alone shows the effect of directions.
    named.retain(|driver| set.circles.is_empty() || !driver.name.ends_with("_dir"));
    named.truncate(MOST_DRIVERS);
    named
}

/// Returns the share of the variance of a cause's effect that means along a driver explain.
fn goes_with(set: &Set, part: usize, driver: &DriverReadings, does: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> = points(set, part, driver, |k| does.get(k).copied().unwrap_or(0.0)).collect();
    let count = points.len() as f64;
    let mean = points.iter().map(|point| point.1).sum::<f64>() / count.max(1.0);
    let total: f64 = points.iter().map(|point| (point.1 - mean).powi(2)).sum();
    let between: f64 = means(&points).iter().map(|line| line.2 * (line.1 - mean).powi(2)).sum();
    if total > 0.0 { between / total } else { 0.0 }
}

/// Returns the values of the valid readings over a driver.
fn points<'a>(
    set: &'a Set,
    part: usize,
    driver: &'a DriverReadings,
    of: impl Fn(usize) -> f64 + 'a,
) -> impl Iterator<Item = (f64, f64)> + 'a {
    let own = set.readings.iter().enumerate().filter(move |(_, reading)| reading.part == part && reading.counts);
    own.map(move |(k, _)| (driver.values.get(k).copied().unwrap_or(f64::NAN), of(k)))
}

fn beside(set: &Set, part: usize, driver: &DriverReadings, does: &[f64]) -> Chart {
    let effect = |k: usize| does.get(k).copied().unwrap_or(0.0);
    let left: Vec<(f64, f64)> =
        points(set, part, driver, |k| set.readings.get(k).map_or(f64::NAN, |one| one.after + effect(k))).collect();
    let lines = mean_lines(&left, 0);
    Chart {
        title: title_of(set, part, driver, "Evidence"),
        across: driver.title.clone(),
        up: format!("in {}", set.unit),
        series: [
            PlotSeries { label: "residual without it".into(), points: left, ..PlotSeries::default() },
            PlotSeries {
                label: "its effect".into(),
                points: points(set, part, driver, effect).collect(),
                ..PlotSeries::default()
            },
        ]
        .into_iter()
        .chain(lines)
        .collect(),
        is_balanced: true,
        is_sparing: true,
        ..Chart::default()
    }
}

/// Draws effects that change with time over time, with the corresponding temperature.
fn times(out: &mut Markup, set: &Set, part: usize, one: &CauseReport, does: &[f64]) {
    if !(DRIFTS.contains(&one.effect.as_str()) || one.sensor.is_some()) {
        return;
    }
    let rows = DriverReadings {
        name: "row".into(),
        title: "row of the table".into(),
        is_time: false,
        values: set.readings.iter().map(|reading| reading.row as f64).collect(),
    };
    let time = time_of(set, part).unwrap_or(&rows);
    let before: Vec<(f64, f64)> =
        points(set, part, time, |k| set.readings.get(k).map_or(f64::NAN, |one| one.before)).collect();
    let after: Vec<(f64, f64)> =
        points(set, part, time, |k| set.readings.get(k).map_or(f64::NAN, |one| one.after)).collect();
    let series = |label: &str, points| PlotSeries { label: label.into(), points, ..PlotSeries::default() };
    let effect = points(set, part, time, |k| does.get(k).copied().unwrap_or(0.0)).collect();
    let chart = Chart {
        title: title_of(set, part, time, "Drift"),
        across: time.title.clone(),
        up: format!("in {}", set.unit),
        series: vec![series("before", before), series("with all findings", after), series("its effect", effect)],
        is_balanced: true,
        is_clipped: true,
        is_sparing: true,
        ..Chart::default()
    };
    figure(out, &chart, "");
    if let Some(sensor) = one.sensor.as_deref().and_then(|name| driver_of(set, part, name)) {
        let points = points(set, part, time, |k| sensor.values.get(k).copied().unwrap_or(f64::NAN)).collect();
        let chart = Chart {
            title: format!("{} over {}", sensor.name, time.title.split(' ').next().unwrap_or_default()),
            across: time.title.clone(),
            up: sensor.title.clone(),
            series: vec![PlotSeries { points, ..PlotSeries::default() }],
            is_sparing: true,
            ..Chart::default()
        };
        let lag = one.lag_s.filter(|lag| *lag > 0.0);
        figure(
            out,
            &chart,
            lag.map_or(String::new(), |lag| format!("It is followed with a time constant of {} s.", significant(lag))),
        );
    }
}

/// Draws the shape of a cause; over two drivers, one line for each position of one of them.
fn shape(out: &mut Markup, one: &CauseReport, shown: &PageReadings) {
    let with_unit = |name: &String| {
        let mut all = shown.readings.sets.iter().flat_map(|set| &set.drivers);
        // Time has its own unit in pictures of readings.
        let known = all.find(|driver| driver.name == *name).filter(|driver| !driver.is_time);
        known.map_or(name.clone(), |driver| driver.title.clone())
    };
    let along = |k: usize| -> Vec<f64> {
        let mut values: Vec<f64> = one.shape.iter().filter_map(|place| place.at.get(k).copied()).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let up = format!("in {}", one.shape_unit.unit());
    let chart = |title: String, across: &String, series| Chart {
        title,
        across: with_unit(across),
        up: up.clone(),
        series,
        is_sparing: true,
        ..Chart::default()
    };
    match one.drivers.as_slice() {
        _ if one.shape.is_empty() => {}
        [driver] => {
            let points = one.shape.iter().filter_map(|place| Some((*place.at.first()?, place.value_um))).collect();
            let series = vec![PlotSeries { points, shape: Shape::Line, ..PlotSeries::default() }];
            figure(
                out,
                &chart(format!("Shape over {driver}"), driver, series),
                "The deviation at the point of the chain where it acts.",
            );
        }
        [first, second] => {
            // Lines over the driver with more positions, one for each position of the other.
            let (lines, other, own) = if along(0).len() > along(1).len() {
                (along(1), (1, second), (0, first))
            } else {
                (along(0), (0, first), (1, second))
            };
            let count = lines.len();
            let step = |k: usize| if count > MOST_LINES { k * (count - 1) / (MOST_LINES - 1) } else { k };
            let series = (0..count.min(MOST_LINES)).filter_map(|k| lines.get(step(k))).map(|line| {
                let on = one
                    .shape
                    .iter()
                    .filter(|place| place.at.get(other.0).is_some_and(|at| at.to_bits() == line.to_bits()));
                let points = on.filter_map(|place| Some((*place.at.get(own.0)?, place.value_um))).collect();
                PlotSeries {
                    label: format!("{} {}", other.1, significant(*line)),
                    points,
                    shape: Shape::Line,
                    ..PlotSeries::default()
                }
            });
            let series = series.collect();
            let title = format!("Shape over {}, by {}", own.1, other.1);
            figure(out, &chart(title, own.1, series), "The deviation at the point of the chain where it acts.");
        }
        _ => {}
    }
}
