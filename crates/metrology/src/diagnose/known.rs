//! What is asked for again and again while candidates are searched and judged: weights of rows, and regressions on the set-ups alone.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::cause::Weight;
use super::score::{Layout, Scores, SearchState};
use super::search::{Field, Weights};
use ncfix_base::numeric::{Gain, Series};

/// Numbers in tables that are kept, at most.
const ROOM: usize = 1 << 24;
/// Regressions that are kept, at most: the whole, what is used without a part, each with its memory and without.
const STARTS: usize = 4;

/// A weight, and what it is by row.
type Table = (Weight, Arc<Vec<f64>>);

/// Weights by row of candidates that were taken.
#[derive(Debug, Default)]
pub(super) struct KnownTables(Mutex<HashMap<usize, Table>>);

impl KnownTables {
    /// `None` where it is not known.
    pub(super) fn get(&self, weight: &Weight) -> Option<Arc<Vec<f64>>> {
        lock(&self.0).get(&weight.key()).map(|(_, table)| Arc::clone(table))
    }

    /// The same for another field.
    pub(super) fn copy(&self) -> KnownTables {
        KnownTables(Mutex::new(lock(&self.0).clone()))
    }

    /// Keeps one, and its weight with it: the key of one that is gone may become that of another one.
    pub(super) fn put(&self, weight: &Weight, table: Arc<Vec<f64>>) {
        let mut all = lock(&self.0);
        if (all.len() + 1) * table.len() > ROOM {
            all.clear();
        }
        all.insert(weight.key(), (weight.clone(), table));
    }
}

/// Readings and how they count, a regression on the unknowns of their set-ups, and what candidates are beside it where that was asked for.
#[derive(Debug)]
struct Start {
    weights: Weights,
    series: Series,
    state: Option<Arc<SearchState>>,
}

/// Those that were asked for last, the last one at the end.
#[derive(Debug, Default)]
pub(super) struct Starts(Mutex<Vec<Start>>);

impl Starts {
    /// The regression with this memory; `make` makes it where it is not known.
    pub(super) fn series(&self, weights: &Weights, memory: f64, make: impl FnOnce() -> Series) -> Series {
        if let Some(known) = self.with(weights, memory, |start| start.series.clone()) {
            return known;
        }
        let series = make();
        let mut all = lock(&self.0);
        if all.len() >= STARTS {
            all.remove(0);
        }
        all.push(Start { weights: weights.clone(), series: series.clone(), state: None });
        series
    }

    /// What candidates are beside a regression; `make` makes it where it is not known.
    pub(super) fn state(&self, weights: &Weights, memory: f64, make: impl FnOnce() -> SearchState) -> Arc<SearchState> {
        if let Some(known) = self.with(weights, memory, |start| start.state.clone()).flatten() {
            return known;
        }
        let state = Arc::new(make());
        self.with(weights, memory, |start| start.state = Some(Arc::clone(&state)));
        state
    }

    fn with<T>(&self, weights: &Weights, memory: f64, of: impl FnOnce(&mut Start) -> T) -> Option<T> {
        let mut all = lock(&self.0);
        let is_it = |start: &Start| start.series.memory().to_bits() == memory.to_bits() && start.weights == *weights;
        let place = all.iter().position(is_it)?;
        let mut start = all.remove(place);
        let out = of(&mut start);
        all.push(start);
        Some(out)
    }
}

impl Field<'_, '_> {
    /// The columns of the candidate of a number that was taken: what it weighs is kept.
    pub(super) fn columns_of(&self, number: usize) -> Vec<Vec<f64>> {
        let Some(one) = self.candidates.get(number) else { return Vec::new() };
        for (_, weight) in one.columns.iter().flatten() {
            if self.layout.table(weight).is_none() && self.tables.get(weight).is_none() {
                self.tables.put(weight, Arc::new(self.scene.rows.iter().map(|row| weight.of(row)).collect()));
            }
        }
        self.columns(one)
    }

    /// What each candidate would gain beside a series with the unknowns of the set-ups and some candidates; those that say nothing of their own have
    /// rank 0.
    pub(super) fn gains(&self, weights: &Weights, series: &Series) -> Vec<Gain> {
        self.gains_of(series, &mut self.scores(weights, series.memory()))
    }

    /// All candidates beside the unknowns of the set-ups.
    pub(super) fn scores(&self, weights: &Weights, memory: f64) -> [Scores; 2] {
        let start = self.series(weights, &[], memory);
        let state = self.starts.state(weights, memory, || {
            let mut scores = Scores::new(&self.layout, self.scene, &self.factors, &start);
            scores.gains(&start);
            scores.state()
        });
        let later = self.candidates.get(self.layout.count()..).unwrap_or_default();
        let layout = Arc::new(Layout::new(self.scene, later, &self.tables));
        [
            Scores::at(&self.layout, self.scene, &self.factors, SearchState::clone(&state)),
            Scores::new(&layout, self.scene, &self.factors, &start),
        ]
    }

    /// The same with the scores of a series to which columns were added since, and of candidates that came since then.
    pub(super) fn gains_of(&self, series: &Series, scores: &mut [Scores; 2]) -> Vec<Gain> {
        let mut gains: Vec<Gain> = scores.iter_mut().flat_map(|scores| scores.gains(series)).collect();
        let later = self.candidates.get(gains.len()..).unwrap_or_default();
        let layout = Arc::new(Layout::new(self.scene, later, &self.tables));
        gains.extend(Scores::new(&layout, self.scene, &self.factors, series).gains(series));
        gains
    }
}

/// What another thread left is whole: nothing is half written.
fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}
