//! The verdict: findings with their sizes, rivals and what they gain, and what is left.

use std::collections::HashMap;

use super::cause::{CAUSES, Candidate, Cause};
use super::scene::{NO_ROW, Scene};
use super::search::{Field, Taken, Weights};

/// Chance at which a finding is claimed where there is nothing, over all candidates.
const LIMIT: f64 = 1e-3;
/// A reading further out than this many spreads does not count.
const FAR: f64 = 6.0;
/// Rounds of taking such readings out.
const ROUNDS: usize = 3;
/// Blocks of rows where there are neither runs nor set-ups.
const BLOCKS: usize = 5;
/// 95 % of a normal distribution, in standard deviations.
const EXPANDED: f64 = 1.96;
/// A rival explains nearly as much: so much of χ² less at most.
const RIVAL: f64 = 6.0;
/// Median of the absolute values of normal noise, in standard deviations.
const MEDIAN: f64 = 0.674_489_750_196_081_7;

/// What was found.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The candidate.
    pub candidate: Candidate,
    /// Amounts of its columns with their expanded uncertainties (95 %), mm, rad, per unit of the driver.
    pub amounts: Vec<(f64, f64)>,
    /// Root of the mean square of what it does to the readings, mm or rad.
    pub rms: f64,
    /// Chance of this where there is nothing, over all candidates.
    pub chance: f64,
    /// Share of the squares of readings that were not used which it takes away; with the selection repeated without them.
    pub gain_unseen: f64,
    /// Candidates that explain it nearly as well: cause and parameter, the best first, itself first.
    pub class: Vec<(&'static Cause, String)>,
}

/// A diagnosis.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// Root of the mean square and largest of what the model leaves, mm or rad.
    pub before: [f64; 2],
    /// The same behind all findings.
    pub after: [f64; 2],
    /// Findings, the largest first.
    pub findings: Vec<Finding>,
    /// Readings that did not count: numbers of measurement and row.
    pub outliers: Vec<(usize, usize)>,
    /// Candidates that were tried.
    pub tried: usize,
    /// Correlation of neighbouring residuals.
    pub memory: f64,
}

/// Finds what the model lacks.
#[must_use]
pub fn diagnose(scene: &Scene<'_>) -> Diagnosis {
    let candidates = propose(scene);
    let mut field = Field::new(scene, candidates);
    let mut weights = weights(scene);
    let mut taken = Vec::new();
    for _ in 0..ROUNDS {
        taken = field.forward(&weights);
        if !drop_far(&field, &mut weights, &taken) {
            break;
        }
    }
    let judged = field.backward(&weights, taken, LIMIT);
    let judged = confirmed(&mut field, &weights, judged);
    verdict(&field, &weights, &judged)
}

fn propose(scene: &Scene<'_>) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    CAUSES.iter().for_each(|cause| (cause.propose)(scene, &mut candidates));
    candidates
}

fn weights(scene: &Scene<'_>) -> Weights {
    let rows = scene.rows.len();
    let series = |item: &super::scene::Item| {
        // Each value of a row is a series of its own, and so is every known distance.
        scene.rows.get(item.row).map_or(usize::MAX, |row| row.sequence * 3 + item.value)
    };
    let mut numbers: HashMap<usize, usize> = HashMap::new();
    let series = scene.items.iter().enumerate().map(|(place, item)| {
        if item.row == NO_ROW {
            return 3 * rows + place;
        }
        let count = numbers.len();
        *numbers.entry(series(item)).or_insert(count)
    });
    let series = series.collect();
    Weights { items: scene.items.iter().map(|item| 1.0 / item.sigma).collect(), series }
}

/// What is left with some candidates, in units of the weights given; 0 for readings that do not count.
fn left(field: &Field<'_, '_>, weights: &Weights, taken: &[usize]) -> Vec<f64> {
    field.series(weights, taken, 0.0).left().to_vec()
}

/// Takes readings out that are far from the others. Returns whether there were any.
fn drop_far(field: &Field<'_, '_>, weights: &mut Weights, taken: &[usize]) -> bool {
    let left = left(field, weights, taken);
    let mut sizes: Vec<f64> =
        left.iter().zip(&weights.items).filter(|(_, weight)| **weight > 0.0).map(|(left, _)| left.abs()).collect();
    if sizes.is_empty() {
        return false;
    }
    let middle = sizes.len() / 2;
    let spread = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 / MEDIAN;
    let mut any = false;
    for ((left, weight), item) in left.iter().zip(&mut weights.items).zip(&field.scene.items) {
        if *weight > 0.0 && item.row != NO_ROW && left.abs() > FAR * spread {
            *weight = 0.0;
            any = true;
        }
    }
    any
}

/// Parts of the readings that are independent of each other: runs, else set-ups, else blocks.
fn folds(scene: &Scene<'_>) -> Vec<usize> {
    let of = |key: &dyn Fn(usize) -> (usize, usize)| {
        let mut numbers: HashMap<(usize, usize), usize> = HashMap::new();
        let folds: Vec<usize> = scene
            .items
            .iter()
            .map(|item| {
                if item.row == NO_ROW {
                    return usize::MAX;
                }
                let count = numbers.len();
                *numbers.entry(key(item.row)).or_insert(count)
            })
            .collect();
        (folds, numbers.len())
    };
    let row = |place: usize| scene.rows.get(place);
    let run = |place: usize| {
        row(place).map_or((0, 0), |row| {
            let one = scene.sets.get(row.set).and_then(|set| set.observations.get(row.number));
            (row.set, one.map_or(0, |one| one.run))
        })
    };
    let (by_run, runs) = of(&run);
    if (2..=20).contains(&runs) {
        return by_run;
    }
    let (by_setup, setups) = of(&|place| row(place).map_or((0, 0), |row| (row.set, row.setup)));
    if (2..=20).contains(&setups) {
        return by_setup;
    }
    let rows = scene.rows.len().max(1);
    of(&|place| (place * BLOCKS / rows, 0)).0
}

/// Squares of what is left of readings that were not used, without and with some candidates whose amounts the others gave.
fn unseen(field: &Field<'_, '_>, train: &Weights, test: &Weights, taken: &[usize]) -> [f64; 2] {
    let columns: Vec<Vec<f64>> =
        taken.iter().filter_map(|&k| field.candidates.get(k)).flat_map(|one| field.columns(one)).collect();
    let (amounts, _) = field.series(train, &[], 0.0).amounts(&columns);
    let mut series = field.series(test, &[], 0.0);
    let without = series.squares();
    let values: Vec<f64> = field
        .scene
        .items
        .iter()
        .enumerate()
        .map(|(place, item)| {
            item.left - columns.iter().zip(&amounts).map(|(column, amount)| column[place] * amount).sum::<f64>()
        })
        .collect();
    series.set_values(&values);
    [without, series.squares()]
}

/// Keeps what also gains on readings that were not used, with the selection repeated without them.
fn confirmed(field: &mut Field<'_, '_>, weights: &Weights, judged: Vec<Taken>) -> Vec<(Taken, f64)> {
    if judged.is_empty() {
        return Vec::new();
    }
    let folds = folds(field.scene);
    let count = folds.iter().filter(|&&fold| fold != usize::MAX).max().map_or(0, |most| most + 1);
    let mut gains: Vec<Vec<f64>> = vec![Vec::new(); judged.len()];
    for fold in 0..count {
        let part = |inside: bool| Weights {
            items: weights
                .items
                .iter()
                .zip(&folds)
                .map(|(weight, own)| if *own == usize::MAX || (*own == fold) == inside { *weight } else { 0.0 })
                .collect(),
            series: weights.series.clone(),
        };
        let (train, test) = (part(false), part(true));
        let selected = field.forward(&train);
        for (term, gains) in judged.iter().zip(&mut gains) {
            let number = term.candidate;
            let Some(stand_in) =
                selected.iter().copied().find(|&other| other == number || alike(field, &train, number, other))
            else {
                gains.push(0.0);
                continue;
            };
            let others: Vec<usize> = selected.iter().copied().filter(|&other| other != stand_in).collect();
            let [base, with] = unseen(field, &train, &test, &selected);
            let [_, without] = unseen(field, &train, &test, &others);
            gains.push(if base > 0.0 { (without - with) / without.max(f64::MIN_POSITIVE) } else { 0.0 });
        }
    }
    judged
        .into_iter()
        .zip(gains)
        .filter_map(|(term, gains)| {
            let count = gains.len() as f64;
            let mean = gains.iter().sum::<f64>() / count;
            let spread = (gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0)).sqrt();
            (mean > 0.0 && mean > spread / count.sqrt()).then_some((term, mean))
        })
        .collect()
}

/// Whether two candidates do nearly the same to the readings.
fn alike(field: &Field<'_, '_>, weights: &Weights, one: usize, other: usize) -> bool {
    let columns = |number: usize| field.candidates.get(number).map(|one| field.columns(one)).unwrap_or_default();
    let mut series = field.series(weights, &[], 0.0);
    let own = columns(one);
    let Some(first) = own.first() else { return false };
    series.set_values(first);
    let whole = series.squares();
    whole > 0.0 && series.gain(&columns(other)).squares > 0.9 * whole
}

fn sizes(left: &[f64], weights: &Weights, scene: &Scene<'_>) -> [f64; 2] {
    let mut sum = 0.0;
    let (mut most, mut count) = (0.0_f64, 0.0_f64);
    for ((left, weight), item) in left.iter().zip(&weights.items).zip(&scene.items) {
        if *weight > 0.0 && item.row != NO_ROW {
            let size = left / weight;
            sum += size * size;
            most = most.max(size.abs());
            count += 1.0;
        }
    }
    [(sum / count.max(1.0)).sqrt(), most]
}

fn verdict(field: &Field<'_, '_>, weights: &Weights, judged: &[(Taken, f64)]) -> Diagnosis {
    let scene = field.scene;
    let taken: Vec<usize> = judged.iter().map(|(term, _)| term.candidate).collect();
    let memory = field.memory(weights, &taken);
    let columns: Vec<Vec<Vec<f64>>> =
        taken.iter().filter_map(|&number| field.candidates.get(number)).map(|one| field.columns(one)).collect();
    let flat: Vec<Vec<f64>> = columns.iter().flatten().cloned().collect();
    let series = field.series(weights, &[], memory);
    let (amounts, covariance) = series.amounts(&flat);
    let whole = field.series(weights, &taken, memory);
    let freedom = (whole.count() - whole.rank().min(whole.count())).max(1) as f64;
    let noise = whole.squares() / freedom;
    let mut findings = Vec::new();
    let mut place = 0;
    for ((term, gain), own) in judged.iter().zip(&columns) {
        let range = place..place + own.len();
        place += own.len();
        let amounts: Vec<(f64, f64)> =
            range.clone().map(|k| (amounts[k], EXPANDED * (covariance[(k, k)] * noise).sqrt())).collect();
        let others: Vec<usize> = taken.iter().copied().filter(|&other| other != term.candidate).collect();
        findings.push(Finding {
            candidate: field.candidates[term.candidate].clone(),
            rms: effect(own, &amounts, weights, scene),
            amounts,
            chance: term.chance,
            gain_unseen: *gain,
            class: class(field, weights, term.candidate, &others, memory, noise),
        });
    }
    findings.sort_by(|a, b| b.rms.total_cmp(&a.rms));
    let outliers = scene
        .items
        .iter()
        .zip(&weights.items)
        .filter(|(item, weight)| **weight == 0.0 && item.row != NO_ROW && item.sigma.is_finite())
        .filter_map(|(item, _)| scene.rows.get(item.row).map(|row| (row.set, row.number)))
        .collect();
    Diagnosis {
        before: sizes(&left(field, weights, &[]), weights, scene),
        after: sizes(&left(field, weights, &taken), weights, scene),
        findings,
        outliers,
        tried: field.tried,
        memory,
    }
}

/// Root of the mean square of what a finding does to the readings.
fn effect(columns: &[Vec<f64>], amounts: &[(f64, f64)], weights: &Weights, scene: &Scene<'_>) -> f64 {
    let counts = |place: usize| weights.items[place] > 0.0 && scene.items[place].row != NO_ROW;
    let places: Vec<usize> = (0..scene.items.len()).filter(|&place| counts(place)).collect();
    let at =
        |place: usize| columns.iter().zip(amounts).map(|(column, (amount, _))| column[place] * amount).sum::<f64>();
    (places.iter().map(|&place| at(place).powi(2)).sum::<f64>() / places.len().max(1) as f64).sqrt()
}

/// Who explains nearly as much in the place of one.
fn class(
    field: &Field<'_, '_>,
    weights: &Weights,
    number: usize,
    others: &[usize],
    memory: f64,
    noise: f64,
) -> Vec<(&'static Cause, String)> {
    let series = field.series(weights, others, memory);
    let gains = field.gains(&series);
    let own = gains.get(number).map_or(0.0, |gain| gain.squares);
    let mut rivals: Vec<(f64, usize)> = gains
        .iter()
        .enumerate()
        .filter(|(place, gain)| *place != number && (own - gain.squares) / noise < RIVAL)
        .map(|(place, gain)| (gain.squares, place))
        .collect();
    rivals.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut class: Vec<(&'static Cause, String)> = Vec::new();
    for place in std::iter::once(number).chain(rivals.into_iter().map(|(_, place)| place)) {
        if let Some(one) = field.candidates.get(place) {
            let entry = (one.cause, one.parameter.clone());
            if !class.iter().any(|(cause, parameter)| std::ptr::eq(*cause, entry.0) && *parameter == entry.1) {
                class.push(entry);
            }
        }
    }
    class
}
