//! The second gate: what a term gains on readings that were not used, with the selection repeated without them.
//!
//! Parts that are left out are runs, else set-ups, of each measurement; where they would take all of what shows a term with them, they are
//! stretches of rows, and at last shorter stretches from all over.

use std::collections::HashMap;

use super::cause::{Candidate, EffectKind};
use super::held_out::{Selections, of_parts};
use super::scene::{NO_ROW, Scene, Through};
use super::search::{Field, Taken, Weights};
use ncfix_base::geometry::Axis;

/// Parts at most.
const PARTS: usize = 6;
/// Stretches of rows.
const STRETCHES: usize = 5;
/// Rounds in which they are dealt out where whole ones do not say.
const ROUNDS: [usize; 2] = [3, 15];
/// A term that takes less than this share off what is left of unseen readings (root of the mean square) is not worth a name.
const WORTH: f64 = 0.01;
/// The same of what has no name: of such there are many.
const WORTH_UNNAMED: f64 = 0.03;
/// Places that differ by less than one part in so many, mm, are one.
const FINE: f64 = 1e3;
/// It is in none: known distances, readings that do not count.
pub(super) const NO_PART: usize = usize::MAX;

/// Parts by runs or set-ups of the readings that count.
pub(super) fn repeats(scene: &Scene<'_>, weights: &Weights) -> Vec<usize> {
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
    // What is held out has no part in it.
    let counted = scene.items.iter().zip(&weights.items).map(|(item, weight)| (*weight > 0.0).then_some(item.row));
    let parts: Vec<Option<usize>> = counted.map(|row| of(row?, &mut numbers)).collect();
    // Runs that follow each other go together: they share a set-up, which then has all that it needs.
    let count = numbers.len().max(1);
    let part = |number: usize| if count > PARTS { number * PARTS / count } else { number };
    parts.into_iter().map(|number| number.map_or(NO_PART, part)).collect()
}

/// Parts by stretches of each sequence of rows, dealt out in so many rounds: a part of several shows more than what happens in one place.
pub(super) fn stretches(scene: &Scene<'_>, rounds: usize) -> Vec<usize> {
    let mut lengths: HashMap<usize, usize> = HashMap::new();
    scene.rows.iter().for_each(|row| *lengths.entry(row.sequence).or_insert(0) += 1);
    let mut seen: HashMap<usize, usize> = HashMap::new();
    let of_rows: Vec<usize> = scene
        .rows
        .iter()
        .map(|row| {
            let place = seen.entry(row.sequence).or_insert(0);
            *place += 1;
            (*place - 1) * STRETCHES * rounds / lengths.get(&row.sequence).copied().unwrap_or(1).max(1) % STRETCHES
        })
        .collect();
    scene.items.iter().map(|item| of_rows.get(item.row).copied().unwrap_or(NO_PART)).collect()
}

/// The linear axis along which a candidate is a wave.
fn wave_axis(one: &Candidate) -> Option<Axis> {
    let (Through::Component(name), _) = one.columns.first()?.first()? else { return None };
    name.axis().filter(|axis| one.cause.effect == EffectKind::Periodic && !axis.is_rotary())
}

/// Parts by places along an axis, dealt out one after the other; none where places do not come again.
fn places(scene: &Scene<'_>, axis: Axis) -> Vec<usize> {
    let fine = |row: &super::row::SceneRow| (row.position[axis] * FINE).round() as i64;
    let mut all: Vec<i64> = scene.rows.iter().map(fine).collect();
    all.sort_unstable();
    all.dedup();
    if 2 * all.len() > scene.rows.len() {
        return Vec::new();
    }
    let part = |row: &super::row::SceneRow| all.binary_search(&fine(row)).map_or(NO_PART, |place| place % STRETCHES);
    scene.items.iter().map(|item| scene.rows.get(item.row).map_or(NO_PART, part)).collect()
}

/// Keeps what also gains on readings that were not used. `known` is what was selected before with the same weights; `out` gets the
/// others with their gains, `note` the share that is done.
pub(super) fn confirmed(
    field: &mut Field<'_, '_>,
    weights: &Weights,
    judged: Vec<Taken>,
    known: &mut Selections,
    out: &mut dyn FnMut(&Taken, Option<f64>),
    note: &mut dyn FnMut(f64),
) -> Vec<(Taken, f64)> {
    let mut gains: Vec<Option<f64>> = vec![None; judged.len()];
    type Parts = fn(&Scene<'_>, &Weights) -> Vec<usize>;
    let kinds: [Parts; 4] = [
        repeats,
        |scene, _| stretches(scene, 1),
        |scene, _| stretches(scene, ROUNDS[0]),
        |scene, _| stretches(scene, ROUNDS[1]),
    ];
    for (kind, parts) in kinds.iter().enumerate() {
        let open: Vec<usize> = (0..judged.len()).filter(|&k| gains.get(k).is_some_and(Option::is_none)).collect();
        if open.is_empty() {
            break;
        }
        let parts = parts(field.scene, weights);
        let all: Vec<usize> = judged.iter().map(|term| term.candidate).collect();
        for (&k, found) in open.iter().zip(of_parts(field, weights, (kind, &parts), (&all, &open), known, note)) {
            if let Some(gain) = gains.get_mut(k) {
                *gain = found;
            }
        }
    }
    // Runs at the same places say again whatever wave goes through these: a wave must say places that were left out.
    for k in 0..judged.len() {
        let axis = judged.get(k).and_then(|term| field.candidates.get(term.candidate)).and_then(wave_axis);
        let (Some(axis), Some(gain)) = (axis, gains.get(k).copied().flatten()) else { continue };
        let parts = places(field.scene, axis);
        if gain <= WORTH || parts.is_empty() {
            continue;
        }
        let kind = kinds.len() + axis.slot();
        let all: Vec<usize> = judged.iter().map(|term| term.candidate).collect();
        let found = of_parts(field, weights, (kind, &parts), (&all, &[k]), known, note);
        if let (Some(Some(at_places)), Some(own)) = (found.first(), gains.get_mut(k)) {
            *own = Some(gain.min(*at_places));
        }
    }
    let mut kept = Vec::new();
    for (term, gain) in judged.into_iter().zip(gains) {
        match gain {
            Some(gain) if gain > worth(field, term.candidate) => kept.push((term, gain)),
            _ => out(&term, gain),
        }
    }
    kept
}

/// How much a term must take off what is left of unseen readings.
pub(super) fn worth(field: &Field<'_, '_>, number: usize) -> f64 {
    let is_unnamed = field.candidates.get(number).is_some_and(|one| one.cause.effect == EffectKind::Unknown);
    if is_unnamed { WORTH_UNNAMED } else { WORTH }
}

/// Readings that count, of rows.
pub(super) fn counts(scene: &Scene<'_>, weights: &Weights) -> Vec<usize> {
    let counts = |place: &usize| {
        weights.items.get(*place).is_some_and(|weight| *weight > 0.0)
            && scene.items.get(*place).is_some_and(|item| item.row != NO_ROW)
    };
    (0..scene.items.len()).filter(counts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn places_that_come_again_are_dealt_out_along_the_axis() {
        let machine = bench::machine();
        let there_and_back = || (0..8).chain((0..8).rev()).enumerate();
        let cells: Vec<(f64, String)> = there_and_back().map(|(t, x)| (f64::from(x), format!(",{t}"))).collect();
        let cells: Vec<(f64, &str)> = cells.iter().map(|(x, t)| (*x, t.as_str())).collect();
        let sets = [bench::along_x(&machine, ",t_s", &cells)];
        let found = places(&bench::scene(&machine, &sets), Axis::X);
        let of_rows: Vec<usize> = found.iter().step_by(3).copied().collect();
        assert_eq!(of_rows, there_and_back().map(|(_, x)| x as usize % STRETCHES).collect::<Vec<_>>());
        // Where each was visited once nothing comes again.
        let sets = [bench::along_x(&machine, ",t_s", &cells[..8])];
        assert_eq!(places(&bench::scene(&machine, &sets), Axis::X), [0; 0]);
    }
}
