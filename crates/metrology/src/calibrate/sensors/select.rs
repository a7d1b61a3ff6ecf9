//! The sensors of one direction at one position: the best of each number, and the selected number.

use ncfix_base::geometry::Axis;

use super::data::SensorRun;
use super::products::{Bank, LaggedSensor, RowPart, RunRows, ShrunkFit, pieces};
use super::shrinkage::Shrinkage;
use super::subset::Subset;

/// Maximum number of multiplications of a search: some seconds.
const WORK: u64 = 8_000_000_000;
/// Number of time constants tried.
const LAGS: usize = 14;
/// The shortest of them, s.
const SHORTEST_S: f64 = 30.0;
/// Minimum length of a run relative to the longest time constant: below, time constant and coefficient are not distinguishable.
const RUNS_PER_LAG: f64 = 3.0;
/// Number of alternations between search and lags.
const ROUNDS: usize = 4;
/// Number of time blocks of the independent rows.
const BLOCKS: usize = 10;
/// Minimum number of readings for each offset and sensor.
const ROWS_PER_UNKNOWN: usize = 3;
/// Largest ratio of residuals at which a sensor may replace another.
const ALIKE: f64 = 1.01;

/// Options of the selection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectionOptions {
    /// The largest number of sensors.
    pub most: usize,
    /// `true` to search time constants.
    pub lags: bool,
    /// Protection against sensors that read wrong.
    pub shrinkage: Shrinkage,
}

/// One sensor of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorTerm {
    /// Its name.
    pub sensor: String,
    /// Its coefficient.
    pub um_per_k: f64,
    /// Its time constant.
    pub lag_s: f64,
    /// Alternative sensors with hardly larger residuals: the actual cause is not identifiable.
    pub alike: Vec<String>,
}

/// The best model with one number of sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct SubsetSize {
    /// Its sensors, with coefficients of all data.
    pub terms: Vec<SensorTerm>,
    /// Mallows' Cp of these coefficients, with their effective number; `None` if all sensors together leave no degree of freedom.
    pub cp: Option<f64>,
    /// Efficiency on the data.
    pub efficiency: f64,
    /// Efficiency on the independent rows, with coefficients from the other rows.
    pub independent: f64,
    /// Root mean square residual on the independent rows, µm.
    pub left_um: f64,
    /// `true` if no other sensors of this number (with these lags) fit the data better.
    pub is_exact: bool,
}

/// Result for one direction and position.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorSelection {
    /// 0 to 2 for X, Y, Z.
    pub direction: usize,
    /// The position, mm or degrees.
    pub at: Option<(Axis, f64)>,
    /// Number of readings.
    pub rows: usize,
    /// Root mean square of the drift on the independent rows, µm.
    pub drift_um: f64,
    /// By number of sensors, from 1.
    pub sizes: Vec<SubsetSize>,
    /// Index of the selected one in `sizes`; `None` if none predicts the independent rows.
    pub chosen: Option<usize>,
}

impl SensorSelection {
    /// The chosen model.
    #[must_use]
    pub fn model(&self) -> Option<&SubsetSize> {
        self.sizes.get(self.chosen?)
    }
}

/// Selects sensors for a direction and position; `None` with too few readings. Without independent runs the last third of every run is held out.
#[must_use]
pub fn select(
    runs: &[SensorRun],
    independent: &[SensorRun],
    direction: usize,
    at: Option<(Axis, f64)>,
    options: &SelectionOptions,
) -> Option<SensorSelection> {
    let data = pieces(runs, direction, at);
    let others = pieces(independent, direction, at);
    let is_held_back = others.is_empty();
    let (learned, held, held_part) = if is_held_back {
        (RowPart::Early, data.as_slice(), RowPart::Late)
    } else {
        (RowPart::All, data.as_slice(), RowPart::All)
    };
    let held = if is_held_back { held } else { others.as_slice() };
    let sensors = common_sensors(data.iter().chain(held).map(|piece| piece.run));
    let candidates = candidates(&data, sensors.len(), options.lags);
    let bank = Bank::new(&data, &sensors, &candidates, learned);
    let most = options.most.min((bank.rows / ROWS_PER_UNKNOWN).saturating_sub(bank.offsets));
    if most == 0 || sensors.is_empty() {
        return None;
    }
    let found = if options.lags { with_lags(&bank, sensors.len(), most) } else { bank.products.best(most, WORK) };
    let noise = full_mean_square(&bank, found.last());
    let all = (learned != RowPart::All).then(|| Bank::new(&data, &sensors, &candidates, RowPart::All));
    let mut sizes = Vec::new();
    let mut rests = Vec::new();
    for subset in &found {
        let Some(ShrunkFit { um_per_k: learned_um_per_k, squares, effective }) =
            bank.fit(&subset.members, options.shrinkage)
        else {
            continue;
        };
        let terms: Vec<LaggedSensor> =
            subset.members.iter().filter_map(|&member| bank.candidates.get(member).copied()).collect();
        let um_per_k = match &all {
            Some(all) => {
                let members: Option<Vec<usize>> = terms.iter().map(|&term| all.place(term)).collect();
                let Some(fit) = members.and_then(|members| all.fit(&members, options.shrinkage)) else { continue };
                fit.um_per_k
            }
            None => learned_um_per_k.clone(),
        };
        let lags = terms.iter().filter(|(_, lag_s)| *lag_s > 0.0).count();
        let p = effective + (lags + bank.offsets) as f64;
        let cp = noise.map(|noise| squares / noise + 2.0 * p - bank.rows as f64);
        let [measured, left] = rest(&data, learned, true, &sensors, &terms, &learned_um_per_k);
        let [held_measured, held_left] = rest(held, held_part, false, &sensors, &terms, &learned_um_per_k);
        sizes.push(SubsetSize {
            terms: named(&bank, &sensors, subset, &um_per_k),
            cp,
            efficiency: efficiency(&measured, &left),
            independent: efficiency(&held_measured, &held_left),
            left_um: root_mean_square(&held_left),
            is_exact: subset.is_exact,
        });
        rests.push(held_left);
    }
    let drift = rest(held, held_part, false, &sensors, &[], &[]);
    let chosen = choose(&sizes, &rests);
    Some(SensorSelection { direction, at, rows: bank.rows, drift_um: root_mean_square(&drift[0]), sizes, chosen })
}

/// The sensors common to all runs, sorted by name.
fn common_sensors<'a>(mut runs: impl Iterator<Item = &'a SensorRun>) -> Vec<String> {
    let Some(first) = runs.next() else { return Vec::new() };
    let mut sensors: Vec<String> = first.condition.sensors().map(str::to_owned).collect();
    for run in runs {
        sensors.retain(|sensor| run.condition.trace(sensor).is_some());
    }
    sensors
}

/// All sensors without a lag, or with all lags.
fn candidates(data: &[RunRows<'_>], sensors: usize, lags: bool) -> Vec<LaggedSensor> {
    let duration_s =
        data.iter().filter_map(|piece| Some(piece.times_s.last()? - piece.times_s.first()?)).fold(0.0_f64, f64::max);
    let longest_s = duration_s / RUNS_PER_LAG;
    let mut grid = vec![0.0];
    if lags && longest_s > SHORTEST_S {
        let ratio = (longest_s / SHORTEST_S).powf(1.0 / (LAGS - 1) as f64);
        // Whole seconds, the available precision.
        grid.extend((0..LAGS).map(|step| (SHORTEST_S * ratio.powf(step as f64)).round()));
    }
    (0..sensors).flat_map(|sensor| grid.iter().map(move |&lag_s| (sensor, lag_s))).collect()
}

/// For each number of sensors, alternates search and lags. Lags of selected sensors minimize the residual (profile, one after the other); lags of the
/// others are those with the largest improvement.
fn with_lags(bank: &Bank, sensors: usize, most: usize) -> Vec<Subset> {
    let of_sensor: Vec<Vec<usize>> = (0..sensors)
        .map(|sensor| {
            (0..bank.candidates.len()).filter(|&k| bank.candidates.get(k).is_some_and(|c| c.0 == sensor)).collect()
        })
        .collect();
    let mut out = Vec::new();
    for size in 1..=most {
        let mut current: Vec<usize> = of_sensor.iter().filter_map(|own| own.first().copied()).collect();
        let mut best: Option<Subset> = None;
        for _ in 0..ROUNDS {
            let Some(found) = bank.products.of(&current).best_of(size, WORK) else { break };
            let mut members: Vec<usize> = found.members.iter().filter_map(|&k| current.get(k).copied()).collect();
            refine(bank, &of_sensor, &mut members);
            let squares = bank.products.squares(&members);
            for own in &mut current {
                let Some(choices) = bank.candidates.get(*own).and_then(|candidate| of_sensor.get(candidate.0)) else {
                    continue;
                };
                if let Some(&member) = members.iter().find(|member| choices.contains(member)) {
                    *own = member;
                } else if let Some(choice) =
                    least(choices, |choice| bank.products.squares(&[members.as_slice(), &[choice]].concat()))
                {
                    *own = choice;
                }
            }
            if best.as_ref().is_some_and(|best| squares >= best.squares * (1.0 - 1e-6)) {
                break;
            }
            best = Some(Subset { members, squares, is_exact: found.is_exact });
        }
        out.extend(best);
    }
    out
}

/// Optimizes the lag of one sensor after the other until none changes.
fn refine(bank: &Bank, of_sensor: &[Vec<usize>], members: &mut [usize]) {
    for _ in 0..ROUNDS {
        let before = members.to_vec();
        for place in 0..members.len() {
            let own = before.get(place).and_then(|&member| bank.candidates.get(member));
            let Some(choices) = own.and_then(|candidate| of_sensor.get(candidate.0)) else { continue };
            let mut tried = members.to_vec();
            let best = least(choices, |choice| {
                if let Some(member) = tried.get_mut(place) {
                    *member = choice;
                }
                bank.products.squares(&tried)
            });
            if let (Some(member), Some(best)) = (members.get_mut(place), best) {
                *member = best;
            }
        }
        if before == members {
            break;
        }
    }
}

fn least(choices: &[usize], mut value: impl FnMut(usize) -> f64) -> Option<usize> {
    let values = choices.iter().map(|&choice| (value(choice), choice));
    values.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, choice)| choice)
}

/// Mean square residual of all sensors, with the lags of the largest model.
fn full_mean_square(bank: &Bank, largest: Option<&Subset>) -> Option<f64> {
    let taken: Vec<usize> = largest.map_or(Vec::new(), |subset| subset.members.clone());
    let mut seen: Vec<usize> = taken.iter().filter_map(|&k| Some(bank.candidates.get(k)?.0)).collect();
    let mut full = taken;
    for (k, &(sensor, _)) in bank.candidates.iter().enumerate() {
        if !seen.contains(&sensor) {
            seen.push(sensor);
            full.push(k);
        }
    }
    let lags = full.iter().filter(|&&k| bank.candidates.get(k).is_some_and(|candidate| candidate.1 > 0.0)).count();
    let freedom =
        bank.rows.checked_sub(bank.products.of(&full).rank() + lags + bank.offsets).filter(|&freedom| freedom > 0)?;
    let squares = bank.products.squares(&full);
    (squares > 0.0).then(|| squares / freedom as f64)
}

/// Measured, and measured minus simulated, row by row, µm; with the fitted offset, or relative to the first reading.
fn rest(
    pieces: &[RunRows<'_>],
    part: RowPart,
    is_free: bool,
    sensors: &[String],
    terms: &[LaggedSensor],
    um_per_k: &[f64],
) -> [Vec<f64>; 2] {
    let [mut measured, mut left] = [Vec::new(), Vec::new()];
    for piece in pieces {
        let mut own = piece.drift_um.clone();
        measured.extend(piece.part(&own, part));
        for (&(sensor, lag_s), um_per_k) in terms.iter().zip(um_per_k) {
            let rise = sensors.get(sensor).map(|name| piece.rise_k(name, lag_s)).unwrap_or_default();
            own.iter_mut().zip(rise).for_each(|(own, rise)| *own -= um_per_k * rise);
        }
        let own = piece.part(&own, part);
        let mean = if is_free { own.iter().sum::<f64>() / own.len().max(1) as f64 } else { 0.0 };
        left.extend(own.iter().map(|own| own - mean));
    }
    [measured, left]
}

fn efficiency(measured: &[f64], left: &[f64]) -> f64 {
    let sum = |values: &[f64]| values.iter().map(|value| value.abs()).sum::<f64>();
    let whole = sum(measured);
    if whole > 0.0 { 1.0 - sum(left) / whole } else { 0.0 }
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn named(bank: &Bank, sensors: &[String], subset: &Subset, um_per_k: &[f64]) -> Vec<SensorTerm> {
    let name = |sensor: usize| sensors.get(sensor).cloned().unwrap_or_default();
    let mut out = Vec::new();
    for ((place, &member), &um_per_k) in subset.members.iter().enumerate().zip(um_per_k) {
        let Some(&(sensor, lag_s)) = bank.candidates.get(member) else { continue };
        let mut alike: Vec<String> = Vec::new();
        for (other, &(candidate, _)) in bank.candidates.iter().enumerate() {
            let is_taken = subset.members.iter().any(|&k| bank.candidates.get(k).is_some_and(|c| c.0 == candidate));
            if is_taken || alike.contains(&name(candidate)) {
                continue;
            }
            let mut swapped = subset.members.clone();
            if let Some(slot) = swapped.get_mut(place) {
                *slot = other;
            }
            if bank.products.squares(&swapped) <= ALIKE * subset.squares {
                alike.push(name(candidate));
            }
        }
        out.push(SensorTerm { sensor: name(sensor), um_per_k, lag_s, alike });
    }
    out
}

/// The smallest size whose residual is within one standard error of the minimum, if any predicts the data.
fn choose(sizes: &[SubsetSize], rests: &[Vec<f64>]) -> Option<usize> {
    let best = (0..sizes.len()).max_by(|&a, &b| sizes[a].independent.total_cmp(&sizes[b].independent))?;
    if sizes.get(best)?.independent <= 0.0 {
        return None;
    }
    let least = rests.get(best)?;
    let length = least.len().div_ceil(BLOCKS).max(1);
    let is_as_good = |rest: &[f64]| {
        let more: Vec<f64> = rest
            .chunks(length)
            .zip(least.chunks(length))
            .map(|(own, best)| {
                own.iter().zip(best).map(|(own, best)| own.abs() - best.abs()).sum::<f64>() / own.len() as f64
            })
            .collect();
        let count = more.len() as f64;
        let mean = more.iter().sum::<f64>() / count;
        let spread = more.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
        mean <= (spread / count).sqrt()
    };
    (0..=best).find(|&size| {
        size == best
            || (sizes.get(size).is_some_and(|size| size.independent > 0.0)
                && rests.get(size).is_some_and(|rest| is_as_good(rest)))
    })
}
