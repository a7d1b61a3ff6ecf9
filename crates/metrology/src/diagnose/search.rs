//! The search: which candidates explain what is left, one after the other, until nothing is gained; then those that do not stand are taken out.
//!
//! A step forward takes the candidate whose gain is largest beside its number of unknowns. Whether it stands is judged at the end, with all that were
//! taken: by the memory of what is then left, so that slow noise counts for the little that it tells, and by the number of all that
//! were tried.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use ncfix_base::numeric::{Series, in_parts};

use super::cancel::Triangle;
use super::cause::{Candidate, EffectKind, Term, motion, targets};
use super::known::{KnownTables, Starts};
use super::price::Price;
use super::sample::{CandidateSample, SearchPart};
use super::scene::{NO_ROW, Scene, Through};
use super::score::Layout;
use super::seek::Seek;

/// Terms at most.
const MOST: usize = 10;
/// Behind many that are kept.
const MORE: usize = 4;
/// How often the search goes on without such a term.
const REPAIRS: usize = 3;
/// Worth of a table beside a curve: a value of its own at each target follows every wave and every polynomial.
const BY_TARGET: f64 = 0.8;
/// Worth of what has no name beside what has one.
const UNNAMED: f64 = 0.9;
/// The same of so few columns that they fit by no chance.
const UNNAMED_SIMPLE: f64 = 0.95;
const FEW: usize = 3;
/// The same of what depends on two.
const UNNAMED_PAIR: f64 = 0.87;
/// Candidates explain the same where −2 ln of the likelihood differs by less.
pub(super) const TIE: f64 = 8.0;
/// Periods that differ by less, as a share, are one.
const NEARLY: f64 = 0.01;
/// The same of waves without a name, which are long.
const NEARLY_UNNAMED: f64 = 0.2;

/// Candidates and what they would do to the readings of a scene.
#[derive(Debug)]
pub(super) struct Field<'s, 'a> {
    pub(super) scene: &'s Scene<'a>,
    pub(super) candidates: Vec<Candidate>,
    /// Those that only groups have: bows beside a location that has their slope.
    pub(super) bows: Range<usize>,
    pub(super) factors: HashMap<Through, Arc<Vec<f64>>>,
    pub(super) layout: Arc<Layout>,
    pub(super) tables: KnownTables,
    pub(super) starts: Starts,
    pub(super) seek: Seek,
    /// How many candidates there are to choose from, those of sweeps too.
    pub(super) tried: usize,
    /// The same beside a part of the readings, where there are many.
    pub(super) part: Option<Box<SearchPart<'s, 'a>>>,
}

/// One candidate that was taken.
#[derive(Clone, Debug)]
pub(super) struct Taken {
    /// Its number.
    pub(super) candidate: usize,
    /// Chance of a gain like this where there is nothing, times the number of candidates.
    pub(super) chance: f64,
}

/// What the search takes next.
struct Step {
    number: usize,
    /// What each candidate that may be taken is worth.
    open: Vec<(f64, usize)>,
}

/// How readings count.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Weights {
    /// 1/σ, 0 for those that do not count.
    pub(super) items: Vec<f64>,
    /// Series of each.
    pub(super) series: Vec<usize>,
}

impl<'s, 'a> Field<'s, 'a> {
    pub(super) fn new(scene: &'s Scene<'a>, mut candidates: Vec<Candidate>) -> Field<'s, 'a> {
        let seek = Seek::new(scene);
        let tried = candidates.len() + seek.count();
        let named = candidates.len();
        candidates.extend(if named > 0 { motion::bows(scene) } else { Vec::new() });
        let bows = named..candidates.len();
        let of_candidates = candidates.iter().flat_map(|one| one.columns.iter().flatten()).map(|(through, _)| *through);
        let mut places: Vec<Through> = of_candidates.chain(seek.places()).collect();
        let mut seen = HashSet::new();
        places.retain(|&through| seen.insert(through));
        let of_places = in_parts(&places, &|&through: &Through| Arc::new(scene.factors(through)));
        let factors = places.into_iter().zip(of_places).collect();
        let tables = KnownTables::default();
        let layout = Arc::new(Layout::new(scene, &candidates, &tables));
        Field { scene, candidates, bows, factors, layout, tables, starts: Starts::default(), seek, tried, part: None }
    }

    /// Without candidates: what set-ups take is all that is asked of it.
    pub(super) fn bare(scene: &'s Scene<'a>) -> Field<'s, 'a> {
        Field {
            scene,
            candidates: Vec::new(),
            bows: 0..0,
            factors: HashMap::new(),
            layout: Arc::default(),
            tables: KnownTables::default(),
            starts: Starts::default(),
            seek: Seek::default(),
            tried: 0,
            part: None,
        }
    }

    /// Adds what is sought by what is left.
    fn seek(&mut self, series: &Series, weights: &Weights) {
        let left = series.unwhitened(series.left());
        let noise = series.squares() / (series.count() as f64).max(1.0);
        let price = noise * ((series.count() as f64).ln() + 2.0 * (self.tried as f64).ln());
        let found = self.seek.propose(self.scene, &self.factors, &left, &weights.items, price);
        self.candidates.extend(found);
    }

    /// Whether a candidate is one that was taken, with a time constant or a period that is nearly the same: a lag between two that are tried is one
    /// effect, not two, and two waves that beat are none.
    fn is_again(&self, number: usize, taken: &[usize]) -> bool {
        let Some(one) = self.candidates.get(number) else { return false };
        let is_near = |other: &Candidate| match (one.constant, other.constant) {
            _ if one.sensor.is_some() => true,
            // Growth at once and heat that follows come together.
            _ if one.cause.effect == EffectKind::SpindleSpeed => one.constant.is_some() == other.constant.is_some(),
            // A bow has all of its component but the slope, which a location has.
            _ if one.cause.effect == EffectKind::Motion && other.term == Term::None => true,
            (Some((own, unit)), Some((known, of))) if one.columns.len() > 1 => {
                let nearly = if one.cause.effect == EffectKind::Unknown { NEARLY_UNNAMED } else { NEARLY };
                unit == of && (own / known - 1.0).abs() < nearly
            }
            _ => false,
        };
        taken.iter().filter_map(|&other| self.candidates.get(other)).any(|other| {
            let is_one_effect = one.sensor.is_some() && other.cause.effect == one.cause.effect;
            (is_one_effect || other.cause.name == one.cause.name)
                && other.parameter == one.parameter
                && other.sensor == one.sensor
                && is_near(other)
        })
    }

    /// The columns of a candidate.
    pub(super) fn columns(&self, candidate: &Candidate) -> Vec<Vec<f64>> {
        let sum = |parts: &Vec<(Through, super::cause::Weight)>| {
            let mut column = vec![0.0; self.scene.items.len()];
            for (through, weight) in parts {
                let Some(factors) = self.factors.get(through) else { continue };
                if let Some(table) = self.layout.table(weight).cloned().or_else(|| self.tables.get(weight)) {
                    for ((value, factor), item) in column.iter_mut().zip(factors.iter()).zip(&self.scene.items) {
                        *value += factor * table.get(item.row).copied().unwrap_or(0.0);
                    }
                    continue;
                }
                let mut at = (NO_ROW, 0.0);
                for ((value, factor), item) in column.iter_mut().zip(factors.iter()).zip(&self.scene.items) {
                    if *factor != 0.0 {
                        if item.row != at.0 {
                            at = (item.row, self.scene.rows.get(item.row).map_or(0.0, |row| weight.of(row)));
                        }
                        *value += factor * at.1;
                    }
                }
            }
            column
        };
        candidate.columns.iter().map(sum).collect()
    }

    /// A regression with the unknowns of the set-ups and some candidates in it.
    pub(super) fn series(&self, weights: &Weights, taken: &[usize], memory: f64) -> Series {
        let mut series = self.starts.series(weights, memory, || {
            let mut series = Series::new(&weights.series, &weights.items, memory);
            for column in self.unknowns() {
                series.take(&column);
            }
            let values: Vec<f64> = self.scene.items.iter().map(|item| item.left).collect();
            series.set_values(&values);
            series
        });
        for &number in taken {
            for column in self.columns_of(number) {
                series.take(&column);
            }
        }
        series
    }

    pub(super) fn unknowns(&self) -> Vec<Vec<f64>> {
        let mut columns = vec![vec![0.0; self.scene.items.len()]; self.scene.unknowns];
        for (place, item) in self.scene.items.iter().enumerate() {
            for &(unknown, factor) in &item.by_unknown {
                if let Some(value) = columns.get_mut(unknown).and_then(|column| column.get_mut(place)) {
                    *value += factor;
                }
            }
        }
        columns
    }

    /// Readings less what candidates do whose amounts some of them give.
    pub(super) fn left_with(&self, train: &Weights, taken: &[usize]) -> Vec<f64> {
        let columns: Vec<Vec<f64>> = taken.iter().flat_map(|&number| self.columns_of(number)).collect();
        let (amounts, _) = self.series(train, &[], 0.0).amounts(&columns);
        let mut values: Vec<f64> = self.scene.items.iter().map(|item| item.left).collect();
        for (column, amount) in columns.iter().zip(&amounts) {
            values.iter_mut().zip(column).for_each(|(value, part)| *value -= part * amount);
        }
        values
    }

    /// Takes candidates one after the other behind those that are `kept`; where many errors act at once, several of them together first.
    pub(super) fn forward(&mut self, weights: &Weights, kept: &[usize]) -> Vec<usize> {
        self.forward_until(weights, kept, &[])
    }

    /// The same until some are among them, where these are any: what comes behind is of no interest then.
    pub(super) fn forward_until(&mut self, weights: &Weights, kept: &[usize], enough: &[usize]) -> Vec<usize> {
        let taken = self.sound_steps(weights, kept, enough);
        let mut taken = if kept.is_empty() { self.together(weights, taken) } else { taken };
        self.polish(weights, &mut taken, kept.len());
        taken
    }

    /// The same one after the other, without those that nearly cancel others: far larger than all there is, they are where was not measured what nobody
    /// knows.
    pub(super) fn sound_steps(&mut self, weights: &Weights, kept: &[usize], enough: &[usize]) -> Vec<usize> {
        let mut never = Vec::new();
        let (mut taken, mut cancelled) = self.steps(weights, kept, (&never, enough));
        while let Some(out) = cancelled.filter(|_| never.len() < REPAIRS) {
            taken.retain(|&number| number != out);
            never.push(out);
            (taken, cancelled) = self.steps(weights, &taken, (&never, enough));
        }
        // Which one goes at last does not matter: what it did is left.
        taken.retain(|&number| cancelled != Some(number));
        taken
    }

    /// Also one that others nearly cancel.
    fn steps(
        &mut self,
        weights: &Weights,
        kept: &[usize],
        (never, enough): (&[usize], &[usize]),
    ) -> (Vec<usize>, Option<usize>) {
        let mut taken = kept.to_vec();
        let mut series = self.series(weights, &[], 0.0);
        let mut triangle = Triangle::new(&series);
        for &number in kept {
            let columns = self.columns_of(number);
            triangle.take(&mut series, number, &columns);
        }
        let count = series.count() as f64;
        let mut look = CandidateSample::new(self, weights, kept);
        while taken.len() < MOST.max(kept.len() + MORE) {
            let freedom = count - series.rank() as f64;
            let is_enough = !enough.is_empty() && contains_all(&taken, enough);
            if freedom < 2.0 || series.squares() <= 0.0 || is_enough {
                break;
            }
            let known = self.candidates.len();
            self.seek(&series, weights);
            let Some(Step { number, open }) = self.choose((&series, &mut look), &taken, never) else {
                self.candidates.truncate(known);
                break;
            };
            // Of what was sought only one that was taken stays, and of others what is better than they are.
            let sought = (number >= known).then(|| self.candidates.swap_remove(number));
            self.candidates.truncate(known);
            let number = if let Some(one) = sought {
                self.candidates.push(one);
                known
            } else {
                number
            };
            let number = match self.best_sensor(number, &open, &series).or_else(|| self.refined(number, &series)) {
                Some(refined) => {
                    self.candidates.truncate(known);
                    self.candidates.push(refined);
                    known
                }
                None => number,
            };
            let columns = self.columns_of(number);
            triangle.take(&mut series, number, &columns);
            look.take(self, number);
            taken.push(number);
        }
        look.end(self);
        let cancelled = triangle.cancelled(kept);
        (taken, cancelled)
    }

    /// The candidate that is taken next beside some; `None` where none is worth it.
    fn choose(
        &self,
        (series, look): (&Series, &mut CandidateSample<'_, '_>),
        taken: &[usize],
        never: &[usize],
    ) -> Option<Step> {
        let squares = series.squares();
        let gains = look.gains(self, series);
        let price = Price::new(series.count() as f64, self.tried);
        let mut open: Vec<(f64, usize)> = gains
            .iter()
            .enumerate()
            .filter(|(number, gain)| {
                gain.rank > 0
                    && !self.bows.contains(number)
                    && !taken.contains(number)
                    && !never.contains(number)
                    && !self.is_again(*number, taken)
            })
            .map(|(number, gain)| {
                let is_whole = self.candidates.get(number).is_some_and(|one| one.cause.name == targets::CAUSE.name);
                let worth = if is_whole { price.worth_whole(squares, gain) } else { price.worth(squares, gain) };
                (worth * self.belief(number), number)
            })
            .collect();
        // The least far-fetched of those that explain as much, but none that no machine has.
        let (worth, number) = loop {
            let (worth, number) = self.best_of(&open)?;
            if !self.is_absurd(number, series) {
                break (worth, number);
            }
            open.retain(|(_, other)| *other != number);
        };
        let named = self.is_unnamed(number).then(|| self.named_instead((series, look), &open, price, worth));
        Some(Step { number: named.flatten().unwrap_or(number), open })
    }

    /// The least far-fetched of those whose worth is as much as that of the best.
    fn best_of(&self, open: &[(f64, usize)]) -> Option<(f64, usize)> {
        let most = open.iter().map(|(worth, _)| *worth).fold(f64::NEG_INFINITY, f64::max);
        open.iter().copied().filter(|(worth, _)| *worth > 0.0 && *worth > most - TIE).min_by(|a, b| {
            let far = |number: usize| self.candidates.get(number).map_or(u32::MAX, Candidate::far_fetched);
            far(a.1).cmp(&far(b.1)).then(b.0.total_cmp(&a.0)).then(a.1.cmp(&b.1))
        })
    }

    fn is_unnamed(&self, number: usize) -> bool {
        self.candidates.get(number).is_none_or(|one| one.cause.effect == EffectKind::Unknown)
    }

    /// The first of two causes with names that together explain what one without explains.
    fn named_instead(
        &self,
        (series, look): (&Series, &CandidateSample<'_, '_>),
        open: &[(f64, usize)],
        price: Price,
        worth: f64,
    ) -> Option<usize> {
        let named = open.iter().filter(|(_, number)| !self.is_unnamed(*number));
        let &(own, first) = named.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let mut beside = series.clone();
        self.candidates.get(first).map(|one| self.columns(one))?.iter().for_each(|column| {
            beside.take(column);
        });
        let gains = look.gains_behind(self, &beside, first);
        let others = gains.iter().enumerate().filter(|(number, _)| *number != first && !self.is_unnamed(*number));
        let others = others.filter(|(number, gain)| gain.rank > 0 && !self.is_again(*number, &[first]));
        let next = others.map(|(_, gain)| price.worth(beside.squares(), gain)).fold(0.0, f64::max);
        (own + next > worth).then_some(first)
    }

    /// What has no name must explain more than what has one.
    fn belief(&self, number: usize) -> f64 {
        match self.candidates.get(number) {
            Some(one) if one.cause.effect == EffectKind::Unknown && one.columns.len() <= FEW => UNNAMED_SIMPLE,
            Some(one) if one.cause.effect == EffectKind::Unknown && one.drivers.len() > 1 => UNNAMED_PAIR,
            Some(one) if one.cause.effect == EffectKind::Unknown => UNNAMED,
            Some(one) if one.cause.name == targets::CAUSE.name => BY_TARGET,
            _ => 1.0,
        }
    }
}

/// Whether all of some are among others.
pub(super) fn contains_all(all: &[usize], some: &[usize]) -> bool {
    some.iter().all(|one| all.contains(one))
}
