//! Forward search for the candidates that explain the residual, until none justifies its penalty; then backward elimination.
//!
//! A forward step takes the candidate with the largest gain after its penalty. Its significance is tested at the end, with all accepted terms. The test uses
//! the autocorrelation of the final residual, so slow noise counts with its effective sample size, and the number of all tested candidates.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use ncfix_base::numeric::{Series, in_parts};

use super::cancel::Triangle;
use super::cause::{Candidate, EffectKind, Term, common_scale, motion, targets};
use super::known::{KnownTables, Starts};
use super::price::Price;
use super::sample::{CandidateSample, SearchPart};
use super::scene::{NO_ROW, Scene, Through};
use super::score::Layout;
use super::seek::Seek;

/// Maximum number of terms.
const MOST: usize = 10;
/// Maximum number of further terms if many are kept already.
const MORE: usize = 4;
/// Maximum number of terms that are removed because others cancel them.
const REPAIRS: usize = 3;
/// Factor for a table relative to a curve: separate values at the targets can follow every wave and every polynomial.
const BY_TARGET: f64 = 0.8;
/// Factor for an unnamed term relative to a named one.
const UNNAMED: f64 = 0.9;
/// Factor for an unnamed term with few columns, which hardly fits by chance.
const UNNAMED_SIMPLE: f64 = 0.95;
const FEW: usize = 3;
/// Factor for an unnamed term over two drivers.
const UNNAMED_PAIR: f64 = 0.87;
/// Candidates are equivalent if −2 ln of the likelihood differs by less than this.
pub(super) const TIE: f64 = 8.0;
/// Periods are equal if they differ by less than this share.
const NEARLY: f64 = 0.01;
/// Same limit for unnamed waves, which are long.
const NEARLY_UNNAMED: f64 = 0.2;

/// Candidates and their effects on the readings of a scene.
#[derive(Debug)]
pub(super) struct Field<'s, 'a> {
    pub(super) scene: &'s Scene<'a>,
    pub(super) candidates: Vec<Candidate>,
    /// Candidates that are used only in groups: bows in addition to a location that has their slope.
    pub(super) bows: Range<usize>,
    pub(super) factors: HashMap<Through, Arc<Vec<f64>>>,
    pub(super) layout: Arc<Layout>,
    pub(super) tables: KnownTables,
    pub(super) starts: Starts,
    pub(super) seek: Seek,
    /// Number of tested candidates, including those of the screening.
    pub(super) tried: usize,
    /// Candidates after a regression on a sample of many readings.
    pub(super) part: Option<Box<SearchPart<'s, 'a>>>,
}

/// An accepted candidate.
#[derive(Clone, Debug)]
pub(super) struct Taken {
    /// Its number.
    pub(super) candidate: usize,
    /// p-value of its gain, times the number of candidates.
    pub(super) chance: f64,
}

/// Decides the next step of the search.
struct Step {
    number: usize,
    /// Returns the net gain of each candidate that may be taken.
    open: Vec<(f64, usize)>,
}

/// Weights of the readings.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Weights {
    /// 1/σ, 0 for excluded readings.
    pub(super) items: Vec<f64>,
    /// Series of each reading.
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

    /// A search without candidates: only the set-up unknowns are needed.
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

    /// Adds the candidates that the screening of the residual finds.
    fn seek(&mut self, series: &Series, weights: &Weights) {
        let left = series.unwhitened(series.left());
        let noise = series.squares() / (series.count() as f64).max(1.0);
        let price = noise * ((series.count() as f64).ln() + 2.0 * (self.tried as f64).ln());
        let found = self.seek.propose(self.scene, &self.factors, &left, &weights.items, price);
        self.candidates.extend(found);
    }

    /// True if a candidate equals an accepted one except for a nearly equal time constant or period: a lag between two tested values is a single effect, and
    /// so are two waves that beat.
    fn is_again(&self, number: usize, taken: &[usize]) -> bool {
        let Some(one) = self.candidates.get(number) else { return false };
        let is_near = |other: &Candidate| match (one.constant, other.constant) {
            _ if one.sensor.is_some() => true,
            // An immediate displacement and a thermal one may occur together.
            _ if one.cause.effect == EffectKind::SpindleSpeed => one.constant.is_some() == other.constant.is_some(),
            // A bow has the same component without the slope, which a location has.
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

    /// Returns the columns of a candidate.
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
            self.scene.add_along(&mut column, parts);
            column
        };
        candidate.columns.iter().map(sum).collect()
    }

    /// Returns a regression on the set-up unknowns and some candidates.
    pub(super) fn series(&self, weights: &Weights, taken: &[usize], memory: f64) -> Series {
        let mut series = self.starts.series(weights, memory, || {
            let mut series = Series::new(&weights.series, &weights.items, memory);
            self.each_unknown(|column| {
                series.take(column);
            });
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

    /// Calls `out` with the column of each set-up unknown.
    pub(super) fn each_unknown(&self, mut out: impl FnMut(&[f64])) {
        let mut factors: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.scene.unknowns];
        for (place, item) in self.scene.items.iter().enumerate() {
            for &(unknown, factor) in &item.by_unknown {
                factors.get_mut(unknown).into_iter().for_each(|own| own.push((place, factor)));
            }
        }
        let mut column = vec![0.0; self.scene.items.len()];
        for own in factors {
            own.iter().for_each(|&(place, factor)| column[place] += factor);
            out(&column);
            own.iter().for_each(|&(place, _)| column[place] = 0.0);
        }
    }

    /// Returns the readings minus the effects of some candidates, with amounts from a fit of these and others.
    pub(super) fn left_with(&self, train: &Weights, taken: &[usize]) -> Vec<f64> {
        let columns: Vec<Vec<f64>> = taken.iter().flat_map(|&number| self.columns_of(number)).collect();
        let (amounts, _) = self.series(train, &[], 0.0).amounts(&columns);
        let mut values: Vec<f64> = self.scene.items.iter().map(|item| item.left).collect();
        for (column, amount) in columns.iter().zip(&amounts) {
            values.iter_mut().zip(column).for_each(|(value, part)| *value -= part * amount);
        }
        values
    }

    /// Adds candidates one by one to those in `kept`; if many errors act at once, several of them together first.
    pub(super) fn forward(&mut self, weights: &Weights, kept: &[usize]) -> Vec<usize> {
        self.forward_until(weights, kept, &[])
    }

    /// Searches until one of some candidates is accepted, if any are given: later terms are not needed then.
    pub(super) fn forward_until(&mut self, weights: &Weights, kept: &[usize], enough: &[usize]) -> Vec<usize> {
        let taken = self.sound_steps(weights, kept, enough);
        let mut taken = if kept.is_empty() { self.together(weights, taken) } else { taken };
        self.polish(weights, &mut taken, kept.len());
        taken
    }

    /// Searches one by one, without terms that nearly cancel others: such terms are far larger than the residual, and arbitrary where nothing was measured.
    pub(super) fn sound_steps(&mut self, weights: &Weights, kept: &[usize], enough: &[usize]) -> Vec<usize> {
        let mut never = Vec::new();
        let (mut taken, mut cancelled) = self.steps(weights, kept, (&never, enough));
        while let Some(out) = cancelled.filter(|_| never.len() < REPAIRS) {
            taken.retain(|&number| number != out);
            never.push(out);
            (taken, cancelled) = self.steps(weights, &taken, (&never, enough));
        }
        // After the last repair, the term is removed without a further search: its effect stays in the residual.
        taken.retain(|&number| cancelled != Some(number));
        taken
    }

    /// Searches one by one, including terms that nearly cancel others.
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
            // Of the screened candidates, only an accepted one stays; of the others, those that are better.
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

    /// Returns the candidate to take next in addition to some; `None` if none justifies its penalty.
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
                    && !self.is_sum(*number)
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
        // The simplest of the equivalent candidates, without implausible ones.
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

    /// True for equal scales, which are the sum of single ones: the search has those. They are only a rival of causes of another nature.
    pub(super) fn is_sum(&self, number: usize) -> bool {
        self.candidates.get(number).is_some_and(|one| one.cause.name == common_scale::CAUSE.name)
    }

    /// Returns the simplest of the candidates that are equivalent to the best.
    fn best_of(&self, open: &[(f64, usize)]) -> Option<(f64, usize)> {
        let most = open.iter().map(|(worth, _)| *worth).fold(f64::NEG_INFINITY, f64::max);
        open.iter().copied().filter(|(worth, _)| *worth > 0.0 && *worth > most - TIE).min_by(|a, b| {
            let far = |number: usize| self.candidates.get(number).map_or(u32::MAX, Candidate::plausibility_rank);
            far(a.1).cmp(&far(b.1)).then(b.0.total_cmp(&a.0)).then(a.1.cmp(&b.1))
        })
    }

    fn is_unnamed(&self, number: usize) -> bool {
        self.candidates.get(number).is_none_or(|one| one.cause.effect == EffectKind::Unknown)
    }

    /// Returns the first of two named causes that together explain as much as an unnamed one.
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

    /// An unnamed term must explain more than a named one.
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

/// True if some numbers are a subset of others.
pub(super) fn contains_all(all: &[usize], some: &[usize]) -> bool {
    some.iter().all(|one| all.contains(one))
}
