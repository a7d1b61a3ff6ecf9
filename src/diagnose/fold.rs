//! The second gate: what a term gains on readings that were not used, with the selection repeated without them.
//!
//! Parts that are left out are runs, else set-ups, of each measurement; where they would take all of what shows a term with them, they are
//! stretches of rows, and at last shorter stretches from all over.

use std::collections::HashMap;

use super::cause::{Candidate, Effect};
use super::scene::{NO_ROW, Scene, Through};
use super::search::{Field, Taken, Weights, contains_all};
use crate::geometry::Axis;
use crate::numeric::Series;

/// Parts at most.
const PARTS: usize = 6;
/// Stretches of rows.
const STRETCHES: usize = 5;
/// Rounds in which they are dealt out where whole ones do not say.
const ROUNDS: [usize; 2] = [3, 15];
/// A part says something of a term that has this share of what shows it, and leaves that share to the others.
const SHOWN: f64 = 0.02;
const KEPT: f64 = 0.2;
/// A term that takes less than this share off what is left of unseen readings (root of the mean square) is not worth a name.
const WORTH: f64 = 0.01;
/// The same of what has no name: of such there are many.
const WORTH_UNNAMED: f64 = 0.03;
/// Other candidates that explain this share of what one does stand for it.
const ALIKE: f64 = 0.9;
/// Each of them this much at least.
const PARTLY: f64 = 0.05;
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
    name.axis().filter(|axis| one.cause.effect == Effect::Periodic && !axis.is_rotary())
}

/// Parts by places along an axis, dealt out one after the other; none where places do not come again.
fn places(scene: &Scene<'_>, axis: Axis) -> Vec<usize> {
    let fine = |row: &super::row::Row| (row.position[axis] * FINE).round() as i64;
    let mut all: Vec<i64> = scene.rows.iter().map(fine).collect();
    all.sort_unstable();
    all.dedup();
    if 2 * all.len() > scene.rows.len() {
        return Vec::new();
    }
    let part = |row: &super::row::Row| all.binary_search(&fine(row)).map_or(NO_PART, |place| place % STRETCHES);
    scene.items.iter().map(|item| scene.rows.get(item.row).map_or(NO_PART, part)).collect()
}

/// Squares of what is left of some readings with candidates whose amounts others gave.
pub(super) fn unseen(field: &Field<'_, '_>, train: &Weights, test: &Weights, taken: &[usize]) -> f64 {
    let mut series = field.series(test, &[], 0.0);
    series.set_values(&field.left_with(train, taken));
    series.squares()
}

/// What was gained on a part: squares without a term, and with it.
struct Part {
    /// How much of the term its readings show.
    shown: f64,
    without: f64,
    with: f64,
}

/// What was selected without a part.
pub(super) struct Selection {
    all: Vec<usize>,
    /// Whether the search went on to its end.
    is_whole: bool,
}

/// What was selected, by the kind of parts and the number of the part: it depends on the weights only.
pub(super) type Selections = HashMap<(usize, usize), Option<Selection>>;

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
        let mut selected = |field: &mut Field<'_, '_>, part: usize, train: &Weights| {
            selected(field, train, &all, known.entry((kind, part)).or_default())
        };
        for (&k, found) in open.iter().zip(of_parts(field, weights, &parts, (&all, &open), &mut selected, note)) {
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
        let mut selected = |field: &mut Field<'_, '_>, part: usize, train: &Weights| {
            selected(field, train, &all, known.entry((kind, part)).or_default())
        };
        let found = of_parts(field, weights, &parts, (&all, &[k]), &mut selected, note);
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

/// What is selected without a part; it goes on only until all that are judged are among it.
fn selected(field: &mut Field<'_, '_>, train: &Weights, judged: &[usize], known: &mut Option<Selection>) -> Vec<usize> {
    if let Some(known) = known.as_ref().filter(|known| known.is_whole || contains_all(&known.all, judged)) {
        return known.all.clone();
    }
    let all = field.forward_until(train, &[], judged);
    *known = Some(Selection { is_whole: !contains_all(&all, judged), all: all.clone() });
    all
}

/// How much a term must take off what is left of unseen readings.
pub(super) fn worth(field: &Field<'_, '_>, number: usize) -> f64 {
    let is_unnamed = field.candidates.get(number).is_some_and(|one| one.cause.effect == Effect::Unknown);
    if is_unnamed { WORTH_UNNAMED } else { WORTH }
}

/// What is selected without a part.
type Select<'k> = &'k mut dyn FnMut(&mut Field<'_, '_>, usize, &Weights) -> Vec<usize>;

/// The gain of each term over some parts; `None` where they do not say.
fn of_parts(
    field: &mut Field<'_, '_>,
    weights: &Weights,
    parts: &[usize],
    (judged, places): (&[usize], &[usize]),
    select: Select<'_>,
    note: &mut dyn FnMut(f64),
) -> Vec<Option<f64>> {
    let count = parts.iter().filter(|&&part| part != NO_PART).max().map_or(0, |most| most + 1);
    let mut everywhere = field.series(weights, &[], 0.0);
    let of_judged: Vec<Does> =
        judged.iter().map(|&term| Does::new(field, weights, judged, term, &mut everywhere)).collect();
    let mut found: Vec<Vec<Part>> = places.iter().map(|_| Vec::new()).collect();
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
        let [mut of_train, mut of_test] = [&train, &test].map(|part| field.series(part, &[], 0.0));
        let says: Vec<Option<f64>> = places
            .iter()
            .map(|&place| of_judged.get(place).and_then(|does| does.said(&mut of_train, &mut of_test)))
            .collect();
        if says.iter().all(Option::is_none) {
            continue;
        }
        let selected = select(field, part, &train);
        // What else was selected there would not have stood: it is no part of what is judged.
        let of_each: Vec<Vec<usize>> = judged
            .iter()
            .zip(&of_judged)
            .map(|(&term, does)| {
                // What stands for itself stands for no other.
                let free = selected.iter().copied().filter(|other| *other == term || !judged.contains(other));
                stand_ins(field, &train, (term, &does.all), &free.collect::<Vec<_>>())
            })
            .collect();
        let mut all: Vec<usize> = of_each.iter().flatten().copied().collect();
        all.sort_unstable();
        all.dedup();
        let with = unseen(field, &train, &test, &all);
        for ((&place, says), found) in places.iter().zip(says).zip(&mut found) {
            let Some(shown) = says else { continue };
            let own = of_each.get(place).map_or(&[][..], Vec::as_slice);
            if own.is_empty() {
                found.push(Part { shown, without: with, with });
                continue;
            }
            let others: Vec<usize> = all.iter().copied().filter(|other| !own.contains(other)).collect();
            found.push(Part { shown, without: unseen(field, &train, &test, &others), with });
        }
    }
    note(1.0);
    found.iter().map(|parts| gain(parts)).collect()
}

/// What a term does to the readings, with the amounts found beside the others.
struct Does {
    all: Vec<f64>,
    /// Squares of it beside the set-ups.
    whole: f64,
    /// What each of several columns does, and its squares.
    columns: Vec<(Vec<f64>, f64)>,
}

impl Does {
    fn new(field: &Field<'_, '_>, weights: &Weights, judged: &[usize], term: usize, series: &mut Series) -> Does {
        let mut columns = Vec::new();
        let mut own = 0..0;
        for &number in judged {
            let of = field.columns_of(number);
            if number == term {
                own = columns.len()..columns.len() + of.len();
            }
            columns.extend(of);
        }
        let (amounts, _) = field.series(weights, &[], 0.0).amounts(&columns);
        let mut all = vec![0.0; field.scene.items.len()];
        let mut parts = Vec::new();
        for (mut column, amount) in columns.into_iter().zip(amounts).skip(own.start).take(own.len()) {
            column.iter_mut().for_each(|value| *value *= amount);
            all.iter_mut().zip(&column).for_each(|(sum, value)| *sum += value);
            let squares = shown(series, &column);
            parts.push((column, squares));
        }
        let whole = shown(series, &all);
        Does { all, whole, columns: if own.len() > 1 { parts } else { Vec::new() } }
    }

    /// How much of it some readings show, where they show enough and others all of it that these show.
    fn said(&self, train: &mut Series, test: &mut Series) -> Option<f64> {
        let least = SHOWN * self.whole;
        let own = shown(test, &self.all);
        let is_said = own > least
            && shown(train, &self.all) > KEPT * self.whole
            && self
                .columns
                .iter()
                .all(|(column, squares)| shown(test, column) <= least || shown(train, column) > KEPT * squares);
        is_said.then_some(own)
    }
}

/// How much of something readings show beside their set-ups.
fn shown(series: &mut Series, does: &[f64]) -> f64 {
    series.set_values(does);
    series.squares()
}

/// Which of those that were selected stand for a term: itself, one that does nearly the same, or several that do it together.
fn stand_ins(
    field: &Field<'_, '_>,
    weights: &Weights,
    (term, does): (usize, &[f64]),
    selected: &[usize],
) -> Vec<usize> {
    if selected.contains(&term) {
        return vec![term];
    }
    let columns = |number: usize| field.columns_of(number);
    let mut series = field.series(weights, &[], 0.0);
    series.set_values(does);
    let whole = series.squares();
    let mut out = Vec::new();
    let mut open = selected.to_vec();
    while whole > 0.0 && !open.is_empty() {
        let gains = open.iter().map(|&other| (series.gain(&columns(other)).squares, other));
        let Some((gain, best)) = gains.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        if gain < PARTLY * whole {
            break;
        }
        out.push(best);
        open.retain(|&other| other != best);
        columns(best).iter().for_each(|column| {
            series.take(column);
        });
        if series.squares() < (1.0 - ALIKE) * whole {
            return out;
        }
    }
    Vec::new()
}

/// The gain over parts, by which what is left becomes smaller (root of the mean square); 0 where the parts do not agree on it.
fn gain(parts: &[Part]) -> Option<f64> {
    if parts.len() < 2 {
        return None;
    }
    let count = parts.len() as f64;
    let sum = |of: fn(&Part) -> f64| parts.iter().map(of).sum::<f64>();
    let (without, with) = (sum(|part| part.without), sum(|part| part.with));
    // Parts that show more of it gain more: what differs from that is chance.
    let ratio = (without - with) / sum(|part| part.shown).max(f64::MIN_POSITIVE);
    let off = |part: &Part| (part.without - part.with - ratio * part.shown).powi(2);
    let spread = (parts.iter().map(off).sum::<f64>() * count / (count - 1.0)).sqrt();
    let is_sure = without - with > spread * if parts.len() < 4 { 0.5 } else { 1.0 };
    Some(if is_sure && without > 0.0 { 1.0 - (with / without).sqrt() } else { 0.0 })
}

/// Readings that count, of rows.
pub(super) fn counts(scene: &Scene<'_>, weights: &Weights) -> Vec<usize> {
    let counts = |place: &usize| {
        weights.items.get(*place).is_some_and(|weight| *weight > 0.0)
            && scene.items.get(*place).is_some_and(|item| item.row != NO_ROW)
    };
    (0..scene.items.len()).filter(counts).collect()
}
