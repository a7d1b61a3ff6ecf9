//! The second gate: what a term gains on readings that were not used, with the selection repeated without them.
//!
//! Parts that are left out are runs, else set-ups, of each measurement; where they would take all of what shows a term with them, they are
//! stretches of rows.

use std::collections::HashMap;

use super::scene::{NO_ROW, Scene};
use super::search::{Field, Taken, Weights};

/// Parts at most.
const PARTS: usize = 6;
/// Stretches of rows.
const STRETCHES: usize = 5;
/// A part says something of a term that has this share of what shows it, and leaves that share to the others.
const SHOWN: f64 = 0.02;
const KEPT: f64 = 0.2;
/// A term that takes less than this share off what is left of unseen readings (root of the mean square) is not worth a name.
pub(super) const WORTH: f64 = 0.01;
/// Another candidate that explains this share of what one does stands for it.
const ALIKE: f64 = 0.9;
/// It is in none: known distances, readings that do not count.
const NO_PART: usize = usize::MAX;

/// Parts by runs or set-ups.
fn repeats(scene: &Scene<'_>) -> Vec<usize> {
    let observation = |place: usize| {
        let row = scene.rows.get(place)?;
        Some((row.set, scene.sets.get(row.set)?.observations.get(row.number)?))
    };
    // Whether each measurement has several runs, else several set-ups.
    let by_run: Vec<bool> = scene.sets.iter().map(|set| set.runs.len() > 1).collect();
    let mut numbers: HashMap<(usize, usize), usize> = HashMap::new();
    let of = |place: usize, numbers: &mut HashMap<(usize, usize), usize>| {
        let (set, one) = observation(place)?;
        let key = (set, if by_run.get(set).copied().unwrap_or(false) { one.run } else { one.setup });
        let count = numbers.len();
        Some(*numbers.entry(key).or_insert(count))
    };
    let parts: Vec<Option<usize>> = scene.items.iter().map(|item| of(item.row, &mut numbers)).collect();
    // Runs that follow each other go together: they share a set-up, which then has all that it needs.
    let count = numbers.len().max(1);
    let part = |number: usize| if count > PARTS { number * PARTS / count } else { number };
    parts.into_iter().map(|number| number.map_or(NO_PART, part)).collect()
}

/// Parts by stretches of each sequence of rows.
fn stretches(scene: &Scene<'_>) -> Vec<usize> {
    let mut lengths: HashMap<usize, usize> = HashMap::new();
    scene.rows.iter().for_each(|row| *lengths.entry(row.sequence).or_insert(0) += 1);
    let mut seen: HashMap<usize, usize> = HashMap::new();
    let of_rows: Vec<usize> = scene
        .rows
        .iter()
        .map(|row| {
            let place = seen.entry(row.sequence).or_insert(0);
            *place += 1;
            (*place - 1) * STRETCHES / lengths.get(&row.sequence).copied().unwrap_or(1).max(1)
        })
        .collect();
    scene.items.iter().map(|item| of_rows.get(item.row).copied().unwrap_or(NO_PART)).collect()
}

/// Squares of what is left of some readings with candidates whose amounts others gave.
pub(super) fn unseen(field: &Field<'_, '_>, train: &Weights, test: &Weights, taken: &[usize]) -> f64 {
    let mut series = field.series(test, &[], 0.0);
    series.set_values(&field.left_with(train, taken));
    series.squares()
}

/// What was gained on a part: squares without a term, and with it.
struct Part {
    without: f64,
    with: f64,
}

/// Keeps what also gains on readings that were not used. `out` gets the others with their gains, `note` the share that is done.
pub(super) fn confirmed(
    field: &mut Field<'_, '_>,
    weights: &Weights,
    judged: Vec<Taken>,
    out: &mut dyn FnMut(&Taken, Option<f64>),
    note: &mut dyn FnMut(f64),
) -> Vec<(Taken, f64)> {
    let mut gains: Vec<Option<f64>> = vec![None; judged.len()];
    for parts in [repeats, stretches] {
        let open: Vec<usize> = (0..judged.len()).filter(|&k| gains.get(k).is_some_and(Option::is_none)).collect();
        if open.is_empty() {
            break;
        }
        let parts = parts(field.scene);
        let terms: Vec<usize> = open.iter().filter_map(|&k| judged.get(k)).map(|term| term.candidate).collect();
        for (&k, found) in open.iter().zip(of_parts(field, weights, &parts, &terms, note)) {
            if let Some(gain) = gains.get_mut(k) {
                *gain = found;
            }
        }
    }
    let mut kept = Vec::new();
    for (term, gain) in judged.into_iter().zip(gains) {
        match gain {
            Some(gain) if gain > WORTH => kept.push((term, gain)),
            _ => out(&term, gain),
        }
    }
    kept
}

/// The gain of each term over some parts; `None` where they do not say.
fn of_parts(
    field: &mut Field<'_, '_>,
    weights: &Weights,
    parts: &[usize],
    terms: &[usize],
    note: &mut dyn FnMut(f64),
) -> Vec<Option<f64>> {
    let count = parts.iter().filter(|&&part| part != NO_PART).max().map_or(0, |most| most + 1);
    let whole: Vec<f64> = terms.iter().map(|&term| shown(field, weights, term)).collect();
    let mut found: Vec<Vec<Part>> = terms.iter().map(|_| Vec::new()).collect();
    for part in (0..count).filter(|_| count > 1) {
        note(part as f64 / count as f64);
        let of = |inside: bool| Weights {
            items: weights
                .items
                .iter()
                .zip(parts)
                .map(|(weight, own)| if *own == NO_PART || (*own == part) == inside { *weight } else { 0.0 })
                .collect(),
            series: weights.series.clone(),
        };
        let (train, test) = (of(false), of(true));
        let says: Vec<bool> = terms
            .iter()
            .zip(&whole)
            .map(|(&term, whole)| {
                shown(field, &test, term) > SHOWN * whole && shown(field, &train, term) > KEPT * whole
            })
            .collect();
        if !says.contains(&true) {
            continue;
        }
        let selected = field.forward(&train, &[]);
        let with = unseen(field, &train, &test, &selected);
        for ((&term, _), found) in terms.iter().zip(&says).zip(&mut found).filter(|((_, says), _)| **says) {
            let stand_in = selected.iter().copied().find(|&other| other == term || alike(field, &train, term, other));
            let Some(stand_in) = stand_in else {
                found.push(Part { without: with, with });
                continue;
            };
            let others: Vec<usize> = selected.iter().copied().filter(|&other| other != stand_in).collect();
            found.push(Part { without: unseen(field, &train, &test, &others), with });
        }
    }
    note(1.0);
    found.iter().map(|parts| gain(parts)).collect()
}

/// How much of a term some readings show beside their set-ups.
fn shown(field: &Field<'_, '_>, weights: &Weights, term: usize) -> f64 {
    let columns = field.candidates.get(term).map(|one| field.columns(one)).unwrap_or_default();
    let mut series = field.series(weights, &[], 0.0);
    let mut of = |column: &Vec<f64>| {
        series.set_values(column);
        series.squares()
    };
    // The one that is shown least may be the one that matters least: the first is the name.
    columns.first().map_or(0.0, &mut of)
}

/// The gain over parts, by which what is left becomes smaller (root of the mean square); 0 where the parts do not agree on it.
fn gain(parts: &[Part]) -> Option<f64> {
    if parts.len() < 2 {
        return None;
    }
    let count = parts.len() as f64;
    let sum = |of: fn(&Part) -> f64| parts.iter().map(of).sum::<f64>();
    let (without, with) = (sum(|part| part.without), sum(|part| part.with));
    let mean = (without - with) / count;
    let spread = parts.iter().map(|part| (part.without - part.with - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let is_sure = mean > (spread / count).sqrt() * if parts.len() < 4 { 0.5 } else { 1.0 };
    Some(if is_sure && without > 0.0 { 1.0 - (with / without).sqrt() } else { 0.0 })
}

/// Whether two candidates do nearly the same to the readings.
fn alike(field: &Field<'_, '_>, weights: &Weights, one: usize, other: usize) -> bool {
    let columns = |number: usize| field.candidates.get(number).map(|one| field.columns(one)).unwrap_or_default();
    let mut series = field.series(weights, &[], 0.0);
    let own = columns(one);
    let Some(first) = own.first() else { return false };
    series.set_values(first);
    let whole = series.squares();
    whole > 0.0 && series.gain(&columns(other)).squares > ALIKE * whole
}

/// Readings that count, of rows.
pub(super) fn counts(scene: &Scene<'_>, weights: &Weights) -> Vec<usize> {
    let counts = |place: &usize| {
        weights.items.get(*place).is_some_and(|weight| *weight > 0.0)
            && scene.items.get(*place).is_some_and(|item| item.row != NO_ROW)
    };
    (0..scene.items.len()).filter(counts).collect()
}
