//! Shapes as candidates: columns that are functions of drivers.

use std::sync::Arc;

use super::{Empirical, Form};
use crate::diagnose::cause::{Candidate, UNNAMED, Weight};
use crate::diagnose::row::{NOWHERE, SceneRow};
use crate::diagnose::scene::Through;
use ncfix_base::geometry::Axis;

impl Empirical {
    /// A form as a candidate. Its knots and edges are at values of used rows, so that each amount is determined.
    pub(super) fn candidate(&self, place: Through, form: Form, in_use: &[bool]) -> Candidate {
        let levels: Levels<'_> = &|driver| self.drivers.get(driver).map(|one| one.levels(in_use)).unwrap_or_default();
        let (columns, used): (Vec<(Column, Vec<f64>)>, Vec<usize>) = match form {
            Form::Smooth(a, knots) => (self.hats(a, knots, levels), vec![a]),
            Form::Step(a, edge) => (vec![(self.beyond(a, edge, 1.0), vec![edge])], vec![a]),
            Form::Sense(a, b, knots) => {
                let sense: Column = self.value(a);
                (times(&[(sense, Vec::new())], &self.hats(b, knots, levels)), vec![b, a])
            }
            Form::Beyond(a, b, knots, edge, side) => {
                let edge = between(&levels(a), edge);
                (times(&[(self.beyond(a, edge, side), vec![edge])], &self.hats(b, knots, levels)), vec![a, b])
            }
            Form::Product(a, b) => {
                let [one, other] = [a, b].map(|k| vec![(self.centred(k), Vec::new())]);
                let mut all = times(&one, &other);
                all.extend(one.into_iter().chain(other));
                (all, vec![a, b])
            }
            Form::Bump(a, b, at, wide) => {
                let (one, other) = (self.value(a), self.value(b));
                let bump: Column = Arc::new(move |of| {
                    let far = (one(of) - at[0]).powi(2) + (other(of) - at[1]).powi(2);
                    (-far / (2.0 * wide * wide)).exp()
                });
                (vec![(bump, at.to_vec())], vec![a, b])
            }
            Form::Wave(a, b, edge, side, period) => {
                let value = self.value(b);
                let wave = |of: fn(f64) -> f64| -> Column {
                    let value = Arc::clone(&value);
                    Arc::new(move |at| of(std::f64::consts::TAU * value(at) / period))
                };
                let waves = [(wave(f64::sin), Vec::new()), (wave(f64::cos), Vec::new())];
                (times(&[(self.beyond(a, edge, side), vec![edge])], &waves), vec![a, b])
            }
            Form::Surface(a, b, knots) => {
                (times(&self.hats(a, knots, levels), &self.hats(b, knots, levels)), vec![a, b])
            }
        };
        let mut one = Candidate::one(&UNNAMED, "", place, Weight::new(|_| 0.0));
        one.columns = columns.iter().map(|(column, _)| vec![(place, self.weight(column.clone()))]).collect();
        if let Form::Wave(.., period) = form {
            one.constant = Some((period, "mm"));
        }
        one.points = columns.into_iter().map(|(_, at)| at).collect();
        let mut used = used;
        used.sort_unstable();
        let own = used.into_iter().filter_map(|k| self.drivers.get(k));
        one.along = own.map(|driver| (driver.name.clone(), Arc::clone(&driver.values))).collect();
        one.drivers = one.along.iter().map(|(name, _)| name.clone()).collect();
        one.drivers.dedup();
        one.parameter = match place {
            Through::Tip(direction) => ["X", "Y", "Z"].get(direction).copied().unwrap_or("").to_owned(),
            Through::Component(name) => name.to_string(),
            _ => String::new(),
        };
        one
    }

    fn weight(&self, column: Column) -> Weight {
        let first = Arc::clone(&self.index);
        let drivers: Vec<Arc<Vec<f64>>> = self.drivers.iter().map(|driver| Arc::clone(&driver.values)).collect();
        let axes: Vec<_> = self.drivers.iter().map(|one| (one.axis, one.is_sense, [one.low, one.high])).collect();
        Weight::new(move |row| {
            if row.number == NOWHERE {
                return column(&|driver| axes.get(driver).map_or(f64::NAN, |one| value_at(one, row)));
            }
            let place = first.get(row.set).map_or(usize::MAX, |first| first + row.number);
            column(&|driver| drivers.get(driver).and_then(|values| values.get(place)).copied().unwrap_or(0.0))
        })
    }

    fn value(&self, a: usize) -> Column {
        let is_known = a < self.drivers.len();
        Arc::new(move |of| if is_known { of(a) } else { 0.0 })
    }

    fn centred(&self, a: usize) -> Column {
        let Some(driver) = self.drivers.get(a) else { return Arc::new(|_| 0.0) };
        let (value, low, high) = (self.value(a), driver.low, driver.high);
        Arc::new(move |of| (value(of) - f64::midpoint(low, high)) / (high - low))
    }

    fn beyond(&self, a: usize, edge: f64, side: f64) -> Column {
        let value = self.value(a);
        Arc::new(move |of| {
            let value = value(of);
            if value.is_nan() { value } else { f64::from(u8::from(side * (value - edge) > 0.0)) }
        })
    }

    /// Piecewise linear functions, 1 at one knot and 0 at all others, constant beyond the last ones.
    fn hats(&self, a: usize, knots: usize, levels: Levels<'_>) -> Vec<(Column, Vec<f64>)> {
        let knots = spread(&levels(a), knots);
        let [Some(&low), Some(&high)] = [knots.first(), knots.last()] else { return Vec::new() };
        let hat = |knot: usize| {
            let at = knots.get(knot).copied()?;
            let before = knot.checked_sub(1).and_then(|k| knots.get(k)).copied();
            let behind = knots.get(knot + 1).copied();
            let value = self.value(a);
            let hat: Column = Arc::new(move |of| {
                let value = value(of).clamp(low, high);
                match if value < at { before } else { behind } {
                    // An unknown value stays unknown.
                    _ if value.is_nan() => value,
                    Some(next) => (1.0 - (value - at) / (next - at)).max(0.0),
                    None => 1.0,
                }
            });
            Some((hat, vec![at]))
        };
        (0..knots.len()).filter_map(hat).collect()
    }
}

/// Distinct values of a driver, in ascending order.
type Levels<'l> = &'l dyn Fn(usize) -> Vec<f64>;

/// At most `count` of the values, as evenly spaced as possible.
fn spread(levels: &[f64], count: usize) -> Vec<f64> {
    let [Some(&low), Some(&high)] = [levels.first(), levels.last()] else { return Vec::new() };
    if levels.len() <= count {
        return levels.to_vec();
    }
    let nearest = |place: usize| {
        let wanted = low + (high - low) * place as f64 / (count.max(2) - 1) as f64;
        let above = levels.partition_point(|level| *level < wanted);
        let near = [above.checked_sub(1), Some(above)].into_iter().flatten().filter_map(|k| levels.get(k)).copied();
        near.min_by(|a, b| (a - wanted).abs().total_cmp(&(b - wanted).abs()))
    };
    let mut knots: Vec<f64> = (0..count).filter_map(nearest).collect();
    knots.dedup();
    knots
}

/// The middle of the two values around an edge.
fn between(levels: &[f64], edge: f64) -> f64 {
    let above = levels.partition_point(|level| *level <= edge);
    match [above.checked_sub(1).and_then(|k| levels.get(k)), levels.get(above)] {
        [Some(below), Some(above)] => f64::midpoint(*below, *above),
        _ => edge,
    }
}

/// A function of the values of the drivers, which are given by index.
type Column = Arc<dyn Fn(&dyn Fn(usize) -> f64) -> f64 + Send + Sync>;

/// The value of a driver at a position without measurement: known only for axes and directions.
fn value_at((axis, is_sense, [low, high]): &(Option<Axis>, bool, [f64; 2]), row: &SceneRow) -> f64 {
    let Some(axis) = *axis else { return f64::NAN };
    let value = if *is_sense { row.sense_of(axis) } else { row.position[axis] };
    if axis.is_rotary() && !(*low..=*high).contains(&value) { value.rem_euclid(std::f64::consts::TAU) } else { value }
}

fn times(ones: &[(Column, Vec<f64>)], others: &[(Column, Vec<f64>)]) -> Vec<(Column, Vec<f64>)> {
    let mut out = Vec::new();
    for (one, at) in ones {
        for (other, and) in others {
            let (one, other) = (Arc::clone(one), Arc::clone(other));
            // Most hat functions are 0 at most positions.
            let product: Column = Arc::new(move |of| {
                let one = one(of);
                if one == 0.0 { 0.0 } else { one * other(of) }
            });
            out.push((product, at.iter().chain(and).copied().collect()));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knots_are_values_that_there_are_as_evenly_as_these_allow() {
        let levels: Vec<f64> = (0..=10).map(f64::from).collect();
        assert_eq!(spread(&levels, 3), [0.0, 5.0, 10.0]);
        assert_eq!(spread(&levels, 6), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        // A short list is used completely; with nothing between two clusters, one knot is enough for each cluster.
        assert_eq!(spread(&[1.0, 4.0], 3), [1.0, 4.0]);
        assert_eq!(spread(&[0.0, 0.1, 0.2, 10.0], 3), [0.0, 0.2, 10.0]);
        assert_eq!(spread(&[], 3), [0.0; 0]);
    }
}
