//! Cross-validation: the gain of a term on readings that were not used. Where the comparison of explanations does not decide about a term, the selection is
//! repeated without these readings.
//!
//! Parts that are left out are runs of each measurement, otherwise set-ups. If a part contains all evidence for a term, blocks of rows are left out instead,
//! and finally short blocks distributed over all data.

use std::collections::HashMap;

use super::cause::{Candidate, EffectKind};
use super::contest;
use super::held_out::{Selections, of_parts, settled};
use super::scene::{NO_ROW, Scene, Through};
use super::search::{Field, Taken, Weights};
use ncfix_base::geometry::Axis;

/// Maximum number of parts.
const PARTS: usize = 6;
/// Number of blocks of rows.
const STRETCHES: usize = 5;
/// Rounds in which shorter blocks are distributed, if larger ones do not decide.
const ROUNDS: [usize; 2] = [3, 15];
/// Minimum relative reduction of the RMS of left-out readings.
const WORTH: f64 = 0.01;
/// Same limit for unnamed terms, of which there are many candidates.
const WORTH_UNNAMED: f64 = 0.03;
/// Places are equal if they agree to one part in this number, mm.
const FINE: f64 = 1e3;
/// Belongs to no part: known distances and excluded readings.
pub(super) const NO_PART: usize = usize::MAX;

/// At most `most` parts by runs or set-ups of the included readings.
pub(super) fn repeats(scene: &Scene<'_>, weights: &Weights, most: usize) -> Vec<usize> {
    // Sequences that were read in turn share a drift, so none of them is unseen without the others.
    let mut firsts: HashMap<usize, usize> = HashMap::new();
    for (place, row) in scene.rows.iter().enumerate() {
        firsts.entry(row.series).or_insert(place);
    }
    let observation = |place: usize| {
        let row = scene.rows.get(*firsts.get(&scene.rows.get(place)?.series)?)?;
        Some((row.set, scene.sets.get(row.set)?.observations.get(row.number)?))
    };
    // True for each measurement with several runs; the others are split by set-ups.
    let by_run: Vec<bool> = scene.sets.iter().map(|set| set.runs.len() > 1).collect();
    let mut numbers: HashMap<(usize, usize), usize> = HashMap::new();
    let of = |place: usize, numbers: &mut HashMap<(usize, usize), usize>| {
        let (set, one) = observation(place)?;
        let key = (set, if by_run.get(set).copied().unwrap_or(false) { one.run } else { one.setup });
        let count = numbers.len();
        Some(*numbers.entry(key).or_insert(count))
    };
    // Held-out readings belong to no part.
    let counted = scene.items.iter().zip(&weights.items).map(|(item, weight)| (*weight > 0.0).then_some(item.row));
    let parts: Vec<Option<usize>> = counted.map(|row| of(row?, &mut numbers)).collect();
    // Consecutive runs form one part: they share a set-up, which one of them must keep determined.
    let count = numbers.len().max(1);
    let part = |number: usize| if count > most { number * most / count } else { number };
    parts.into_iter().map(|number| number.map_or(NO_PART, part)).collect()
}

/// Parts by blocks of each series of rows, distributed in rounds: a part of several blocks covers more than one place.
pub(super) fn stretches(scene: &Scene<'_>, rounds: usize) -> Vec<usize> {
    let mut lengths: HashMap<usize, usize> = HashMap::new();
    scene.rows.iter().for_each(|row| *lengths.entry(row.series).or_insert(0) += 1);
    let mut seen: HashMap<usize, usize> = HashMap::new();
    let of_rows: Vec<usize> = scene
        .rows
        .iter()
        .map(|row| {
            let place = seen.entry(row.series).or_insert(0);
            *place += 1;
            (*place - 1) * STRETCHES * rounds / lengths.get(&row.series).copied().unwrap_or(1).max(1) % STRETCHES
        })
        .collect();
    scene.items.iter().map(|item| of_rows.get(item.row).copied().unwrap_or(NO_PART)).collect()
}

/// Returns the linear axis along which a candidate is a wave.
fn wave_axis(one: &Candidate) -> Option<Axis> {
    let (Through::Component(name), _) = one.columns.first()?.first()? else { return None };
    name.axis().filter(|axis| one.cause.effect == EffectKind::Periodic && !axis.is_rotary())
}

/// Parts by places along an axis, assigned in turn; no parts if no place repeats.
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

/// Keeps the terms that also improve left-out readings. `known` holds earlier selections with the same weights; `out` receives the others with their gains,
/// `note` the progress.
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
        |scene, weights| repeats(scene, weights, PARTS),
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
        let is_compared = |&k: &usize| {
            let one = all.get(k).and_then(|&number| field.candidates.get(number));
            one.is_some_and(|one| contest::decides(one.cause.effect))
        };
        let (compared, others): (Vec<usize>, Vec<usize>) = open.into_iter().partition(is_compared);
        let of_all = &mut settled(&all);
        for (open, known) in [(compared, of_all), (others, &mut *known)] {
            if open.is_empty() {
                continue;
            }
            for (&k, found) in open.iter().zip(of_parts(field, weights, (kind, &parts), (&all, &open), known, note)) {
                if let Some(gain) = gains.get_mut(k) {
                    *gain = found;
                }
            }
        }
    }
    // Runs at the same places confirm any wave through these places. So a wave must predict places that were left out.
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

/// Returns the minimum relative reduction of the residual of left-out readings by a term.
pub(super) fn worth(field: &Field<'_, '_>, number: usize) -> f64 {
    let is_unnamed = field.candidates.get(number).is_some_and(|one| one.cause.effect == EffectKind::Unknown);
    if is_unnamed { WORTH_UNNAMED } else { WORTH }
}

/// Returns the included readings that belong to rows.
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
        // If each place was visited once, no place repeats.
        let sets = [bench::along_x(&machine, ",t_s", &cells[..8])];
        assert_eq!(places(&bench::scene(&machine, &sets), Axis::X), [0; 0]);
    }
}
