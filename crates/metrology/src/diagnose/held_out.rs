//! Gain of terms on parts of the readings, with the selection repeated without each part.

use std::collections::HashMap;

use super::cause::{Candidate, EffectKind};
use super::fold::NO_PART;
use super::known::Starts;
use super::search::{Field, Weights, contains_all};
use ncfix_base::numeric::{Series, in_parts};

/// A part tests a term if it contains the first share of the evidence for the term and leaves the second one to the other parts.
const SHOWN: f64 = 0.02;
const KEPT: f64 = 0.2;
/// Other candidates are equivalent to a term if they explain this share of its effect together,
const ALIKE: f64 = 0.9;
/// and each of them at least this share.
const PARTLY: f64 = 0.05;
/// Maximum number of kinds of parts (four, and one for each axis), and of parts of a kind.
const PART_KINDS: usize = 16;
const PARTS_OF_KIND: usize = 8;
/// Number of parts that are processed in parallel.
const AT_ONCE: usize = 2;

/// Result of a selection without one part.
#[derive(Clone, Debug)]
pub(super) struct HeldOutSelection {
    all: Vec<usize>,
    /// True if the search was completed.
    is_whole: bool,
}

/// Selections by the kind of parts and the number of the part; they depend only on the weights.
pub(super) type Selections = HashMap<(usize, usize), HeldOutSelection>;

/// Selections of terms that were found with all readings and without every part.
pub(super) fn settled(all: &[usize]) -> Selections {
    let parts = (0..PART_KINDS).flat_map(|kind| (0..PARTS_OF_KIND).map(move |part| (kind, part)));
    parts.map(|key| (key, HeldOutSelection { all: all.to_vec(), is_whole: true })).collect()
}

/// Sums of squares on a part, without and with a term.
struct Part {
    /// Share of the effect of the term in its readings.
    shown: f64,
    without: f64,
    with: f64,
}

/// Input of the test on parts.
struct Question<'q> {
    weights: &'q Weights,
    /// Part of each reading.
    parts: &'q [usize],
    /// Terms to test, and their effects.
    judged: &'q [usize],
    does: Vec<Does>,
    /// Indices of the terms whose gains are needed.
    places: &'q [usize],
    /// Variance of the weighted readings.
    noise: f64,
}

/// Result of a part.
struct Answer {
    /// Gains of the terms that are needed.
    gains: Vec<Option<Part>>,
    selection: Option<HeldOutSelection>,
    /// Candidates that only this search found, numbered after the existing ones.
    found: Vec<Candidate>,
}

/// Returns the gain of each term over some parts; `None` if the parts do not determine it. Parts are processed in parallel, each with its own candidates: a
/// search without one part has seen the others, so its candidates must not enter another search.
pub(super) fn of_parts(
    field: &mut Field<'_, '_>,
    weights: &Weights,
    (kind, parts): (usize, &[usize]),
    (judged, places): (&[usize], &[usize]),
    known: &mut Selections,
    note: &mut dyn FnMut(f64),
) -> Vec<Option<f64>> {
    let count = parts.iter().filter(|&&part| part != NO_PART).max().map_or(0, |most| most + 1);
    let mut everywhere = field.series(weights, &[], 0.0);
    let does = judged.iter().map(|&term| Does::new(field, weights, judged, term, &mut everywhere)).collect();
    let left = field.series(weights, judged, 0.0);
    let noise = (left.squares() / (left.count() as f64).max(1.0)).max(f64::MIN_POSITIVE);
    let question = Question { weights, parts, judged, does, places, noise };
    let mut found: Vec<Vec<Part>> = places.iter().map(|_| Vec::new()).collect();
    let before = field.candidates.len();
    let all: Vec<usize> = (0..count).filter(|_| count > 1).collect();
    for some in all.chunks(AT_ONCE) {
        note(some.first().map_or(0.0, |part| *part as f64 / count as f64));
        let of_some: Vec<(usize, Option<HeldOutSelection>)> =
            some.iter().map(|&part| (part, known.get(&(kind, part)).cloned())).collect();
        let shared: &Field<'_, '_> = field;
        let answers =
            in_parts(&of_some, &|(part, known)| question.asked_of(*part, &mut shared.beside(before), known.as_ref()));
        for (&part, answer) in some.iter().zip(answers) {
            found.iter_mut().zip(answer.gains).for_each(|(all, one)| all.extend(one));
            if let Some(mut selection) = answer.selection {
                field.adopt(&mut selection.all, before, &answer.found);
                known.insert((kind, part), selection);
            }
        }
    }
    note(1.0);
    found.iter().map(|parts| gain(parts)).collect()
}

impl Question<'_> {
    fn asked_of(&self, part: usize, field: &mut Field<'_, '_>, known: Option<&HeldOutSelection>) -> Answer {
        let before = field.candidates.len();
        let of = |inside: bool| Weights {
            items: self
                .weights
                .items
                .iter()
                .zip(self.parts)
                .map(|(weight, own)| if *own == NO_PART || (*own == part) == inside { *weight } else { 0.0 })
                .collect(),
            series: self.weights.series.clone(),
        };
        let (train, test) = (of(false), of(true));
        let [mut of_train, mut of_test] = [&train, &test].map(|part| field.series(part, &[], 0.0));
        // The readings before a change say nothing about an error that has changed: only what a change leaves is evidence for another term.
        let changes: Vec<usize> = self.judged.iter().copied().filter(|&term| field.is_a_change(term)).collect();
        let mut beside = (!changes.is_empty()).then(|| [&train, &test].map(|part| field.series(part, &changes, 0.0)));
        let says: Vec<Option<f64>> = self
            .places
            .iter()
            .map(|&place| {
                let (does, term) = (self.does.get(place)?, *self.judged.get(place)?);
                let own = does.said(&mut of_train, &mut of_test)?;
                match &mut beside {
                    Some([train, test]) if !changes.contains(&term) => does.said(train, test).map(|_| own),
                    _ => Some(own),
                }
            })
            .collect();
        if says.iter().all(Option::is_none) {
            return Answer { gains: Vec::new(), selection: None, found: Vec::new() };
        }
        let squares: Vec<f64> = self.does.iter().map(|does| does.whole / self.noise).collect();
        let selection = selected(field, &train, (self.judged, &squares), known);
        // Other selected terms would not have been significant: they are not part of the test.
        let of_each: Vec<Vec<usize>> = self
            .judged
            .iter()
            .zip(&self.does)
            .map(|(&term, does)| {
                // A term that is its own equivalent is not an equivalent of another term.
                let is_free = |other: &usize| *other == term || !self.judged.contains(other);
                let free: Vec<usize> = selection.all.iter().copied().filter(is_free).collect();
                stand_ins(field, &train, (term, &does.all), &free)
            })
            .collect();
        let mut all: Vec<usize> = of_each.iter().flatten().copied().collect();
        all.sort_unstable();
        all.dedup();
        // An effect of a set-up that only this part contains is unknown to the other readings, as its offset is: it is fitted to the part. The same is
        // true of a change, and of the error that has changed.
        let is_local = |(&term, does): (&usize, &Does)| {
            let is_own = field.is_of_a_setup(term) || changes.contains(&term);
            let is_absent = if is_own {
                does.is_absent(&mut of_train)
            } else {
                beside.as_mut().is_some_and(|[train, _]| does.is_absent(train)) && !does.is_absent(&mut of_train)
            };
            is_absent.then_some(term)
        };
        let local: Vec<usize> = self.judged.iter().zip(&self.does).filter_map(is_local).collect();
        let with = unseen_beside(field, [&train, &test], &all, &local);
        let gain = |(&place, shown): (&usize, Option<f64>)| {
            let shown = shown?;
            let own = of_each.get(place).map_or(&[][..], Vec::as_slice);
            let others: Vec<usize> = all.iter().copied().filter(|other| !own.contains(other)).collect();
            let without = if own.is_empty() { with } else { unseen_beside(field, [&train, &test], &others, &local) };
            Some(Part { shown, without, with })
        };
        let gains = self.places.iter().zip(says).map(gain).collect();
        let found = field.candidates.get(before..).unwrap_or_default().to_vec();
        Answer { gains, selection: Some(selection), found }
    }
}

/// Selects terms without a part. The search ends as soon as it contains all terms to test; `squares` are those of their effects, in units of the noise.
fn selected(
    field: &mut Field<'_, '_>,
    train: &Weights,
    (judged, squares): (&[usize], &[f64]),
    known: Option<&HeldOutSelection>,
) -> HeldOutSelection {
    if let Some(known) = known.filter(|known| known.is_whole || contains_all(&known.all, judged)) {
        return known.clone();
    }
    // A sample suffices if it selects all of them, or would surely show the others. Their gains are computed on all readings.
    let count = field.scene.items.len();
    let of_sample = field.part.as_mut().and_then(|part| {
        let all = part.selected(&field.candidates, train, judged)?;
        let decides = |(term, squares): (&usize, &f64)| {
            let columns = field.candidates.get(*term).map_or(0, |one| one.columns.len());
            all.contains(term) || part.shows(*squares, columns, count)
        };
        judged.iter().zip(squares).all(decides).then_some(all)
    });
    if let Some(all) = of_sample {
        return HeldOutSelection { is_whole: !contains_all(&all, judged), all };
    }
    let all = field.forward_until(train, &[], judged);
    HeldOutSelection { is_whole: !contains_all(&all, judged), all }
}

impl<'s, 'a> Field<'s, 'a> {
    /// True for an effect of one set-up of an instrument.
    fn is_of_a_setup(&self, number: usize) -> bool {
        self.candidates.get(number).is_some_and(|one| one.cause.effect == EffectKind::Setup)
    }

    /// True for a change of the machine between measurements.
    fn is_a_change(&self, number: usize) -> bool {
        self.candidates.get(number).is_some_and(|one| one.cause.effect == EffectKind::Earlier)
    }

    /// Copies the candidates for a separate search, with the first ones only.
    pub(super) fn beside(&self, first: usize) -> Field<'s, 'a> {
        Field {
            scene: self.scene,
            candidates: self.candidates.iter().take(first).cloned().collect(),
            bows: self.bows.clone(),
            factors: self.factors.clone(),
            layout: self.layout.clone(),
            tables: self.tables.copy(),
            starts: Starts::default(),
            seek: self.seek.clone(),
            tried: self.tried,
            part: self.part.as_ref().map(|part| Box::new(part.beside())),
        }
    }

    /// Adds the selected candidates of another search: those after the existing ones get new numbers.
    fn adopt(&mut self, selected: &mut [usize], first: usize, found: &[Candidate]) {
        for number in selected.iter_mut().filter(|number| **number >= first) {
            let Some(one) = found.get(*number - first) else { continue };
            *number = self.candidates.len();
            self.candidates.push(one.clone());
        }
    }
}

/// Sum of squares of the residual of some readings, with candidates whose amounts come from a fit of other readings.
pub(super) fn unseen(field: &Field<'_, '_>, train: &Weights, test: &Weights, taken: &[usize]) -> f64 {
    unseen_beside(field, [train, test], taken, &[])
}

/// Same sum, where the amounts of some other candidates are fitted to the tested readings together with their set-up unknowns.
fn unseen_beside(field: &Field<'_, '_>, [train, test]: [&Weights; 2], taken: &[usize], local: &[usize]) -> f64 {
    let mut series = field.series(test, local, 0.0);
    series.set_values(&field.left_with(train, taken));
    series.squares()
}

/// Effect of a term on the readings, with the amounts fitted together with the others.
struct Does {
    all: Vec<f64>,
    /// Sum of its squares after the set-up unknowns.
    whole: f64,
    /// Effects of several columns, and the sums of their squares.
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

    /// True if some readings do not show the effect.
    fn is_absent(&self, series: &mut Series) -> bool {
        shown(series, &self.all) <= SHOWN * self.whole
    }

    /// Returns the share of the effect in some readings, if it is large enough there and in the other readings.
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

/// Returns the part of an effect that some readings show after their set-up unknowns.
fn shown(series: &mut Series, does: &[f64]) -> f64 {
    series.set_values(does);
    series.squares()
}

/// Returns the selected terms that are equivalent to a term: itself, one with nearly the same effect, or several together.
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

/// Returns the relative reduction of the RMS over the parts; 0 if it is not significant over the parts.
fn gain(parts: &[Part]) -> Option<f64> {
    if parts.len() < 2 {
        return None;
    }
    let count = parts.len() as f64;
    let sum = |of: fn(&Part) -> f64| parts.iter().map(of).sum::<f64>();
    let (without, with) = (sum(|part| part.without), sum(|part| part.with));
    // Parts with more of the effect gain more: deviations from proportionality are random.
    let ratio = (without - with) / sum(|part| part.shown).max(f64::MIN_POSITIVE);
    let off = |part: &Part| (part.without - part.with - ratio * part.shown).powi(2);
    let spread = (parts.iter().map(off).sum::<f64>() * count / (count - 1.0)).sqrt();
    let is_sure = without - with > spread * if parts.len() < 4 { 0.5 } else { 1.0 };
    Some(if is_sure && without > 0.0 { 1.0 - (with / without).sqrt() } else { 0.0 })
}
