//! A sample of many readings: it shows which candidates are promising, in a fraction of the time. Their gains are then computed on all readings, so no
//! information is lost.
//!
//! A sample takes one of every few consecutive readings of a run, at varying places (additive recurrence of the golden section). An evenly spaced sample
//! would alias short waves to long ones.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::cause::Candidate;
use super::known::{KnownTables, Starts};
use super::price::Price;
use super::promising::promising;
use super::scene::{NO_ROW, Scene};
use super::score::Scores;
use super::search::{Field, Weights};
use super::seek::Seek;
use ncfix_base::numeric::{Gain, Series};

/// Number of readings from which a sample is used.
pub(super) const MANY: usize = 8000;
/// Approximate number of readings of a sample.
const PART: usize = 5000;
/// Minimum number of readings of each run.
const OF_RUN: usize = 60;
/// The sample decides about an effect whose gain exceeds its penalty by this factor. Its standard deviation is then below a fifth of the gain: the penalty of a
/// column is above 25, and that of a noncentral χ² of 75 is 2 √75.
const CERTAINLY: f64 = 3.0;
/// The golden section.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// A sample of the readings of a scene.
#[derive(Clone, Debug)]
pub(super) struct Sample<'a> {
    pub(super) scene: Scene<'a>,
    /// Its rows, as numbers among all rows.
    rows: Vec<usize>,
    /// Its readings, as numbers among all readings.
    items: Vec<usize>,
}

/// Returns the rows of a sample; `None` if there are too few readings to need one.
pub(super) fn some_rows(scene: &Scene<'_>) -> Option<Vec<usize>> {
    if scene.items.len() <= MANY {
        return None;
    }
    let times = scene.items.len() as f64 / PART as f64;
    let mut runs: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (number, row) in scene.rows.iter().enumerate() {
        runs.entry(row.sequence).or_default().push(number);
    }
    let mut out: Vec<usize> = runs.into_values().flat_map(|run| of_run(&run, times)).collect();
    out.sort_unstable();
    Some(out)
}

/// Returns one of every few rows of a run.
fn of_run(run: &[usize], times: f64) -> Vec<usize> {
    let step = times.min(run.len() as f64 / OF_RUN as f64).max(1.0);
    let groups = (run.len() as f64 / step).ceil() as usize;
    let place = |group: usize| {
        let within = if step > 1.0 { (group as f64 * GOLDEN).fract() } else { 0.0 };
        ((group as f64 + within) * step) as usize
    };
    let mut out: Vec<usize> = (0..groups).filter_map(|group| run.get(place(group))).copied().collect();
    out.dedup();
    out
}

impl<'a> Sample<'a> {
    /// Takes a sample; `None` if there are too few readings to need one.
    pub(super) fn new(scene: &Scene<'a>) -> Option<Sample<'a>> {
        let rows = some_rows(scene)?;
        let (scene, items) = scene.part(&rows);
        Some(Sample { scene, rows, items })
    }

    fn weights(&self, all: &Weights) -> Weights {
        let items = self.items.iter().map(|&item| all.items.get(item).copied().unwrap_or(0.0)).collect();
        let series = self.items.iter().map(|&item| all.series.get(item).copied().unwrap_or(0)).collect();
        Weights { items, series }
    }
}

/// Candidates of a search with a sample of its readings.
#[derive(Debug)]
pub(super) struct SearchPart<'s, 'a> {
    sample: &'s Sample<'a>,
    field: Field<'s, 'a>,
}

impl<'s, 'a> SearchPart<'s, 'a> {
    pub(super) fn new(field: &Field<'_, '_>, sample: &'s Sample<'a>) -> SearchPart<'s, 'a> {
        let picked = |all: &Arc<Vec<f64>>| {
            Arc::new(sample.items.iter().map(|&item| all.get(item).copied().unwrap_or(0.0)).collect())
        };
        let field = Field {
            scene: &sample.scene,
            candidates: field.candidates.clone(),
            bows: field.bows.clone(),
            factors: field.factors.iter().map(|(through, all)| (*through, picked(all))).collect::<HashMap<_, _>>(),
            layout: Arc::new(field.layout.part(&sample.rows, &sample.items)),
            tables: KnownTables::default(),
            starts: Starts::default(),
            seek: Seek::default(),
            tried: field.tried,
            part: None,
        };
        SearchPart { sample, field }
    }

    /// Continues with another search.
    pub(super) fn beside(&self) -> SearchPart<'s, 'a> {
        SearchPart { sample: self.sample, field: self.field.beside(self.field.candidates.len()) }
    }

    /// Adds the new candidates instead of the removed ones.
    fn follow(&mut self, candidates: &[Candidate]) {
        let known = self.field.layout.count();
        self.field.candidates.truncate(known);
        self.field.candidates.extend_from_slice(candidates.get(known..).unwrap_or_default());
    }

    /// Selects terms on the sample alone; `None` if it selects a refined one, which holds only for its rows.
    pub(super) fn selected(
        &mut self,
        candidates: &[Candidate],
        weights: &Weights,
        enough: &[usize],
    ) -> Option<Vec<usize>> {
        self.follow(candidates);
        let weights = self.sample.weights(weights);
        let all = self.field.forward_until(&weights, &[], enough);
        all.iter().all(|&number| number < candidates.len()).then_some(all)
    }

    /// True if the sample shows an effect with certainty: its sum of squares in all `count` readings, in units of the noise, and its columns.
    pub(super) fn shows(&self, squares: f64, columns: usize, count: usize) -> bool {
        let own = self.field.scene.items.len() as f64;
        squares * own / (count as f64).max(1.0) > CERTAINLY * Price::new(own, self.field.tried).of(columns)
    }

    /// State of the candidates after a regression on the sample; `whole` is the regression on all readings.
    fn promising(&self, own: &Series, scores: &mut [Scores; 2], whole: &Series) -> Vec<bool> {
        let count = whole.count() as f64;
        // The noise is that of all readings.
        let noise = (whole.squares() / count.max(1.0)).max(f64::MIN_POSITIVE);
        let mut gains = self.field.gains_of(own, scores);
        gains.iter_mut().for_each(|gain| gain.squares /= noise);
        promising(&gains, count / (own.count() as f64).max(1.0), Price::new(count, self.field.tried).of(1))
    }

    fn take(&self, number: usize, series: &mut Series) {
        self.field.columns_of(number).iter().for_each(|column| {
            series.take(column);
        });
    }
}

/// State of the candidates after the terms of a search. If there are many readings, only the candidates that are promising in a sample are up to date.
pub(super) struct CandidateSample<'s, 'a> {
    part: Option<(Box<SearchPart<'s, 'a>>, Series, [Scores; 2])>,
    whole: [Scores; 2],
}

impl<'s, 'a> CandidateSample<'s, 'a> {
    /// Starts after some terms. Takes the sample of the search, which [`CandidateSample::end`] returns.
    pub(super) fn new(field: &mut Field<'s, 'a>, weights: &Weights, kept: &[usize]) -> CandidateSample<'s, 'a> {
        let whole = field.scores(weights, 0.0);
        let part = field.part.take().map(|mut part| {
            part.follow(&field.candidates);
            let weights = part.sample.weights(weights);
            let mut series = part.field.series(&weights, &[], 0.0);
            kept.iter().for_each(|&number| part.take(number, &mut series));
            let scores = part.field.scores(&weights, 0.0);
            (part, series, scores)
        });
        CandidateSample { part, whole }
    }

    /// Returns the gain of each candidate in addition to the terms, including candidates that were added since.
    pub(super) fn gains(&mut self, field: &Field<'_, '_>, series: &Series) -> Vec<Gain> {
        let Some((part, own, scores)) = &mut self.part else { return field.gains_of(series, &mut self.whole) };
        part.follow(&field.candidates);
        let is_in = part.promising(own, scores, series);
        field.gains_of_some(series, &mut self.whole, &is_in)
    }

    /// Returns these gains after one more term, which the series already has.
    pub(super) fn gains_behind(&self, field: &Field<'_, '_>, series: &Series, first: usize) -> Vec<Gain> {
        let mut whole = self.whole.clone();
        let Some((part, own, scores)) = &self.part else { return field.gains_of(series, &mut whole) };
        let mut own = own.clone();
        part.take(first, &mut own);
        let is_in = part.promising(&own, &mut scores.clone(), series);
        field.gains_of_some(series, &mut whole, &is_in)
    }

    /// Records that a candidate was taken.
    pub(super) fn take(&mut self, field: &Field<'_, '_>, number: usize) {
        if let Some((part, series, _)) = &mut self.part {
            part.follow(&field.candidates);
            part.take(number, series);
        }
    }

    /// Ends the search.
    pub(super) fn end(self, field: &mut Field<'s, 'a>) {
        field.part = self.part.map(|(part, ..)| part);
    }
}

impl<'a> Scene<'a> {
    /// Restricts a scene to some of its rows. Also returns the numbers of these readings; known distances stay.
    fn part(&self, rows: &[usize]) -> (Scene<'a>, Vec<usize>) {
        let mut numbers = vec![NO_ROW; self.rows.len()];
        rows.iter().enumerate().for_each(|(number, &row)| numbers[row] = number);
        let number = |row: usize| numbers.get(row).copied().unwrap_or(NO_ROW);
        let is_in = |item: &usize| self.items[*item].row == NO_ROW || number(self.items[*item].row) != NO_ROW;
        let places: Vec<usize> = (0..self.items.len()).filter(is_in).collect();
        let mut items = Vec::with_capacity(places.len());
        for &place in &places {
            let mut item = self.items[place].clone();
            item.row = number(item.row);
            items.push(item);
        }
        let scene = Scene {
            machine: self.machine,
            errors: self.errors.clone(),
            sets: self.sets,
            rows: rows.iter().map(|&row| self.rows[row].clone()).collect(),
            items,
            unknowns: self.unknowns,
            paths: self.paths.part(&places),
        };
        (scene, places)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use crate::diagnose::cause::EffectKind;
    use crate::diagnose::scene::Through;

    #[test]
    fn rows_of_a_part_are_from_all_over_and_not_evenly_spaced() {
        let run: Vec<usize> = (0..1200).collect();
        let some = of_run(&run, 4.0);
        // One of every four consecutive readings.
        assert_eq!(some.iter().map(|row| row / 4).collect::<Vec<usize>>(), (0..300).collect::<Vec<usize>>());
        for within in 0..4 {
            let count = some.iter().filter(|row| *row % 4 == within).count();
            assert!((70..=80).contains(&count), "{within}: {count}");
        }
        // A short run contributes more of its readings, or all.
        assert_eq!(of_run(&run[..120], 4.0).len(), OF_RUN);
        assert_eq!(of_run(&run[..50], 4.0), run[..50]);
    }

    #[test]
    fn beside_a_part_of_many_readings_gains_are_those_of_all_where_a_candidate_is_promising() {
        const ROWS: usize = 9000;
        let machine = bench::machine();
        // The readings contain two of these waves: the first is an accepted term, the second is still to be found, and the third is absent.
        let turns = |count: f64, row: usize| (std::f64::consts::TAU * count * row as f64 / ROWS as f64).cos();
        let um: Vec<f64> = (0..ROWS).map(|row| 5.0 * turns(3.0, row) + 2.0 * turns(7.0, row)).collect();
        let sets = [bench::reads_along_x(&machine, &um)];
        let scene = bench::scene(&machine, &sets);
        let of =
            |count: f64| bench::candidate(EffectKind::Unknown, Through::Tip(0), move |row| turns(count, row.number));
        let mut field = Field::new(&scene, [3.0, 7.0, 11.0].map(of).to_vec());
        let sample = Sample::new(&scene).unwrap();
        field.part = Some(Box::new(SearchPart::new(&field, &sample)));
        let weights = bench::even(&scene);
        let series = field.series(&weights, &[0], 0.0);
        let gains = CandidateSample::new(&mut field, &weights, &[0]).gains(&field, &series);
        // 2 µm of a cosine: N/2 of their square.
        let expected = 2e-3_f64.powi(2) * ROWS as f64 / 2.0;
        assert!((gains[1].squares / expected - 1.0).abs() < 1e-6 && gains[1].rank == 1, "{:?}", gains[1]);
        assert!(gains[0].squares < 1e-9 * expected && gains[2].squares < 1e-9 * expected, "{gains:?}");
    }
}
