//! Readings along a path: the angle between the mean lines of two motions (ISO 230-1) is a sum over positions of both axes, and the axis average line of a
//! rotary axis (ISO 230-7) is a mean over its positions.
//!
//! An error that changes along an axis acts on such a reading by its values at all these positions, with the derivatives that a calibration uses
//! ([`crate::measure::kind::Equation::by_path`]). Such readings are few, so their parts of the columns are added to those of the other readings.

use std::collections::HashMap;

use super::cause::Weight;
use super::row::{NOWHERE, SceneRow};
use super::scene::{Scene, Through};
use crate::measure::kind::{PathDerivative, by_component as of_component};
use ncfix_model::{ErrorModel, Model};

/// Paths of the readings of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct ReadingPaths(Vec<ReadingPath>);

/// A path, and its readings.
#[derive(Clone, Debug)]
struct ReadingPath {
    items: Vec<usize>,
    places: Vec<PathPlace>,
}

/// A position of a path.
#[derive(Clone, Debug)]
struct PathPlace {
    row: SceneRow,
    derivative: PathDerivative,
}

impl ReadingPaths {
    /// Adds a reading. Repeats share a path.
    pub(super) fn add(&mut self, item: usize, row: &SceneRow, by_path: &[PathDerivative]) {
        let is_same = |path: &&mut ReadingPath| {
            let same = |(own, other): (&PathPlace, &PathDerivative)| own.derivative == *other && own.row.set == row.set;
            path.places.len() == by_path.len() && path.places.iter().zip(by_path).all(same)
        };
        if let Some(path) = self.0.iter_mut().find(is_same) {
            path.items.push(item);
        } else if !by_path.is_empty() {
            let place = |&derivative: &PathDerivative| {
                let row = SceneRow { number: NOWHERE, position: derivative.reading.position, ..row.clone() };
                PathPlace { row, derivative }
            };
            self.0.push(ReadingPath { items: vec![item], places: by_path.iter().map(place).collect() });
        }
    }

    /// The paths of some readings, in ascending order, which are numbered anew.
    pub(super) fn part(&self, items: &[usize]) -> ReadingPaths {
        let number = |item: &usize| items.binary_search(item).ok();
        let part = |path: &ReadingPath| {
            let items: Vec<usize> = path.items.iter().filter_map(number).collect();
            (!items.is_empty()).then(|| ReadingPath { items, places: path.places.clone() })
        };
        ReadingPaths(self.0.iter().filter_map(part).collect())
    }
}

/// Parts of columns that act along paths: by weight and point, the readings with their values.
pub(super) type PathParts = HashMap<(usize, usize), Vec<(usize, f64)>>;

impl Scene<'_> {
    /// The effect of one unit of a deviation at each position of each path. That of a location is in the factors of the readings.
    fn along(&self, through: Through) -> Vec<Vec<f64>> {
        if matches!(through, Through::Component(name) if name.is_location())
            || matches!(through, Through::Reading(_) | Through::Value(_))
        {
            return Vec::new();
        }
        let model = Model::new(self.machine, &ErrorModel::default());
        let of = |place: &PathPlace| {
            let PathDerivative { reading, by_tip, by_component } = &place.derivative;
            let itself = match through {
                Through::Component(name) => of_component(by_component, name),
                _ => 0.0,
            };
            itself + by_tip.dot(&self.unit_at(&model, through, (&reading.position, &reading.tool_mm)).0)
        };
        self.paths.0.iter().map(|path| path.places.iter().map(of).collect()).collect()
    }

    /// The values of a weight on the readings along paths, with the effects of one unit; without values of zero.
    fn sums_along(&self, effects: &[Vec<f64>], weight: &Weight) -> Vec<(usize, f64)> {
        let mut out = Vec::new();
        for (path, effects) in self.paths.0.iter().zip(effects) {
            let parts = path.places.iter().zip(effects).filter(|(_, effect)| **effect != 0.0);
            let value: f64 = parts.map(|(place, effect)| effect * weight.of(&place.row)).sum();
            if value != 0.0 {
                out.extend(path.items.iter().map(|&item| (item, value)));
            }
        }
        out
    }

    /// Adds the effects along paths to a column.
    pub(super) fn add_along(&self, column: &mut [f64], parts: &[(Through, Weight)]) {
        if self.paths.0.is_empty() {
            return;
        }
        for (through, weight) in parts {
            for (item, value) in self.sums_along(&self.along(*through), weight) {
                column.get_mut(item).into_iter().for_each(|own| *own += value);
            }
        }
    }

    /// The parts along paths of pairs of weight and point.
    pub(super) fn path_parts(&self, pairs: &[(usize, usize)], places: &[Through], weights: &[&Weight]) -> PathParts {
        if self.paths.0.is_empty() {
            return PathParts::new();
        }
        let effects: Vec<Vec<Vec<f64>>> = places.iter().map(|&through| self.along(through)).collect();
        let part = |&(weight, place): &(usize, usize)| {
            let values = self.sums_along(effects.get(place)?, weights.get(weight)?);
            (!values.is_empty()).then_some(((weight, place), values))
        };
        pairs.iter().filter_map(part).collect()
    }
}
