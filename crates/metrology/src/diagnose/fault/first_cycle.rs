//! The first cycle: a machine that has not settled yet reads differently from all later cycles (ISO 230-2 requires a warm-up by cycles that do not
//! count).

use super::cells::Sensor;
use super::sharp::{CHANCE, EACH};
use super::step::{ChangePoint, change, evidence};
use super::trail::Trail;
use super::{DataDefect, DefectCheck, DefectKind, Then, View, spread};
use crate::measure::data::DataSet;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "first cycle",
    made_by: "contact surfaces and lubrication that settle, a machine that was not moved before",
    shown_by: "the first run is shifted relative to all later runs at these positions, or there is a step soon after the start",
    source: "ISO 230-2: warm-up before the measurement",
    look,
};

/// A step within this share of the rows separates the first cycle from the others.
const EARLY: f64 = 0.15;
/// Minimum number of later runs that show the usual differences.
const RUNS: usize = 4;
/// Minimum number of readings of a run.
const COUNT: usize = 5;
/// Largest share of the difference in later runs.
const NEXT: f64 = 0.4;
/// Largest change of a constant temperature, K, and smallest change by switching, K: heaters reach this within minutes, bearings and motors hardly
/// ever.
const STILL_K: f64 = 2.0;
const SWITCHED_K: f64 = 30.0;
/// Smallest difference, in units of the noise.
const SIZE: f64 = 1.5;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, data) in view.sets() {
        let Some(trail) = view.trails.get(set).filter(|trail| trail.is_repeated && trail.has_sense) else { continue };
        let found = first_run(trail, data).or_else(|| {
            let change = change(trail, data).filter(|change| is_early(trail, change))?;
            let sensors = view.sensors.get(set)?;
            if sensors.iter().any(|sensor: &Sensor| is_switched(&sensor.values, change.row)) {
                return None;
            }
            Some((change.row.checked_sub(1)?, evidence(&change)))
        });
        let Some((last, evidence)) = found else { continue };
        out.push(DataDefect {
            kind: DefectKind::FirstCycle,
            set,
            name: data.observations.first().and_then(|one| data.runs.get(one.run)).cloned().unwrap_or_default(),
            what: "first cycle".into(),
            rows: [0, last],
            evidence,
            then: Then::WithoutRows,
        });
    }
}

/// True if a temperature was constant until a row and has changed within an equal number of rows after it: something was switched on and may cause a
/// step.
fn is_switched(values: &[f64], row: usize) -> bool {
    let known = |values: &[f64]| -> Vec<f64> { values.iter().copied().filter(|value| value.is_finite()).collect() };
    let before = known(values.get(..row).unwrap_or_default());
    let after = known(values.get(row..(2 * row).min(values.len())).unwrap_or_default());
    let [low, high] =
        before.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &value| [low.min(value), high.max(value)]);
    let reached = super::median(after);
    high - low < STILL_K && (reached - high > SWITCHED_K || low - reached > SWITCHED_K)
}

/// True if a step separates the first cycle from the others.
pub(super) fn is_early(trail: &Trail, change: &ChangePoint) -> bool {
    trail.blocks.first().is_some_and(|block| block[0] == change.block[0])
        && ((change.row - change.block[0]) as f64) < EARLY * trail.rows as f64
        && 2 * (change.row - change.block[0]) < change.block[1] - change.row
}

/// Rows of each run of consecutive rows.
fn runs(data: &DataSet) -> Vec<[usize; 2]> {
    let mut runs: Vec<(usize, [usize; 2])> = Vec::new();
    for (row, one) in data.observations.iter().enumerate() {
        match runs.last_mut() {
            Some((run, rows)) if *run == one.run => rows[1] = row,
            _ => runs.push((one.run, [row, row])),
        }
    }
    runs.into_iter().map(|(_, rows)| rows).collect()
}

/// Last row of a first run that differs from all later runs of its block.
fn first_run(trail: &Trail, data: &DataSet) -> Option<(usize, String)> {
    let runs = runs(data);
    let first = *runs.first()?;
    let block = *trail.blocks.first().filter(|block| block[0] <= first[1])?;
    let next: Vec<[usize; 2]> = runs.iter().copied().skip(1).filter(|rows| rows[1] <= block[1]).collect();
    if next.len() < RUNS {
        return None;
    }
    let (mut score, mut whole, mut count) = (0.0, 0.0, 0.0_f64);
    let mut later = vec![0.0; next.len()];
    for channel in &trail.channels {
        let mean = |rows: [usize; 2]| {
            let range = channel.range(rows[0], rows[1]);
            channel.mean(range.start, range.end).filter(|(_, count)| *count >= COUNT)
        };
        let Some((own, readings)) = mean(first) else { continue };
        let others: Vec<f64> = next.iter().filter_map(|rows| mean(*rows)).map(|(mean, _)| mean).collect();
        if others.len() < next.len() {
            continue;
        }
        // The common value of the runs is their median.
        let middle = super::median(others.clone());
        let all = runs.iter().skip(1).filter_map(|rows| mean(*rows)).map(|(mean, _)| mean);
        let usual = spread(all.map(|other| other - middle)).max(channel.noise / (readings as f64).sqrt());
        score += ((own - middle) / usual).powi(2) - EACH;
        let size = (own - middle) / channel.noise;
        whole += size * size;
        later.iter_mut().zip(&others).for_each(|(sum, other)| *sum += size * (other - middle) / channel.noise);
        count += 1.0;
    }
    let size = (whole / count.max(1.0)).sqrt();
    let is_alone = later.iter().all(|other| *other < NEXT * whole);
    (count > 0.0 && score > CHANCE && size > SIZE && is_alone).then(|| {
        let most = later.iter().fold(0.0_f64, |most, other| most.max(*other)) / whole.max(f64::MIN_POSITIVE);
        let evidence = format!(
            "it differs from the {} later runs at the same positions by {size:.1} times the noise; these differ by at most {:.0} % of that",
            next.len(),
            most * 100.0
        );
        (first[1], evidence)
    })
}
