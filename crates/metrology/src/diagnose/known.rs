//! Cache for results that the search and the tests need repeatedly: weights of rows, and regressions on the set-ups alone.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::cause::Weight;
use super::score::{Layout, Scores, SearchState};
use super::search::{Field, Weights};
use ncfix_base::numeric::{Gain, Series};

/// Maximum number of cached numbers in tables.
const ROOM: usize = 1 << 24;
/// Maximum number of cached regressions: all readings and each part, with and without autocorrelation.
const STARTS: usize = 4;

/// A weight, and its values by row.
type Table = (Weight, Arc<Vec<f64>>);

/// Weights by row of the accepted candidates.
#[derive(Debug, Default)]
pub(super) struct KnownTables(Mutex<HashMap<usize, Table>>);

impl KnownTables {
    /// Returns the values; `None` if they are not cached.
    pub(super) fn get(&self, weight: &Weight) -> Option<Arc<Vec<f64>>> {
        lock(&self.0).get(&weight.key()).map(|(_, table)| Arc::clone(table))
    }

    /// Copies the cache for another search.
    pub(super) fn copy(&self) -> KnownTables {
        KnownTables(Mutex::new(lock(&self.0).clone()))
    }

    /// Stores the values and keeps the weight alive: the key of a dropped weight could be used again.
    pub(super) fn put(&self, weight: &Weight, table: Arc<Vec<f64>>) {
        let mut all = lock(&self.0);
        if (all.len() + 1) * table.len() > ROOM {
            all.clear();
        }
        all.insert(weight.key(), (weight.clone(), table));
    }
}

/// Readings with their weights, the regression on their set-up unknowns, and the scores of the candidates if they were needed.
#[derive(Debug)]
struct Start {
    weights: Weights,
    series: Series,
    state: Option<Arc<SearchState>>,
}

/// Entries in the order of their last use.
#[derive(Debug, Default)]
pub(super) struct Starts(Mutex<Vec<Start>>);

impl Starts {
    /// Returns the regression with this autocorrelation; `make` computes it if it is not cached.
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

    /// Returns the scores of the candidates after a regression; `make` computes them if they are not cached.
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
    /// Returns the columns of an accepted candidate, and caches its weights.
    pub(super) fn columns_of(&self, number: usize) -> Vec<Vec<f64>> {
        let Some(one) = self.candidates.get(number) else { return Vec::new() };
        for (_, weight) in one.columns.iter().flatten() {
            if self.layout.table(weight).is_none() && self.tables.get(weight).is_none() {
                self.tables.put(weight, Arc::new(self.scene.rows.iter().map(|row| weight.of(row)).collect()));
            }
        }
        self.columns(one)
    }

    /// Returns the gain of each candidate after the set-up unknowns and some candidates. Dependent candidates have rank 0.
    pub(super) fn gains(&self, weights: &Weights, series: &Series) -> Vec<Gain> {
        self.gains_of(series, &mut self.scores(weights, series.memory()))
    }

    /// Returns all candidates after the set-up unknowns.
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

    /// Returns these gains from the scores of a series to which columns were added since, including candidates that were added since.
    pub(super) fn gains_of(&self, series: &Series, scores: &mut [Scores; 2]) -> Vec<Gain> {
        let mut gains: Vec<Gain> = scores.iter_mut().flat_map(|scores| scores.gains(series)).collect();
        let later = self.candidates.get(gains.len()..).unwrap_or_default();
        let layout = Arc::new(Layout::new(self.scene, later, &self.tables));
        gains.extend(Scores::new(&layout, self.scene, &self.factors, series).gains(series));
        gains
    }
}

/// After a panic of another thread the cache is complete: no entry is stored in part.
fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}
