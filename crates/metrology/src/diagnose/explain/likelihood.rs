//! The likelihood of readings under a set of terms, in closed form.
//!
//! Readings are `y = U u + Φ θ + ε` with unknowns `u` of the set-ups without a prior, amounts `θ ~ N(0, S)` of the terms, and noise `ε ~ N(0, s² Σ)`.
//! Σ is the stated uncertainty of the readings with the autocorrelation of the noise, and s its scale. The part that the set-ups can explain is
//! subtracted once from the readings and from all columns. Then `G = Φᵀ Σ⁻¹ Φ`, `b = Φᵀ Σ⁻¹ y` and `yᵀ Σ⁻¹ y` determine the likelihood of every set
//! of terms (marginal likelihood: Rasmussen and Williams 2006, Gaussian Processes for Machine Learning, eq. 2.43).

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricTridiagonal};

use super::assumptions::READINGS_OF_SIGMA;
use super::noise::{Memory, NoiseSeries};
use super::setups::Setups;
use super::tridiagonal::Tridiagonal;
use crate::diagnose::scene::Scene;
use ncfix_base::numeric::in_parts;
use ncfix_base::numeric::sums::dot;

/// A column has no visible effect if, with an amount of its prior size, less than this remains after the set-ups, in standard deviations of the
/// readings.
const FAINT: f64 = 0.3;
/// Columns with a correlation that differs from 1 by less than this have the same effect on all measured positions.
const ALIKE: f64 = 1e-6;
/// Prior sizes, as effects on the readings, are equal if their natural logarithms differ by less than this.
const AS_USUAL: f64 = 0.02;
/// Smallest and largest factor of the stated noise, as natural logarithms: 1/55 to 400.
const SCALES: [f64; 2] = [-4.0, 6.0];
/// Number of iterations of the search for the scale.
const STEPS: usize = 40;

/// Columns that are used together: a term.
#[derive(Clone, Debug, Default)]
pub struct ColumnGroup {
    /// Effect of one unit of each column on every reading of the scene.
    pub columns: Vec<Vec<f64>>,
    /// Standard deviation of the prior of each amount, mm or rad per unit.
    pub sizes: Vec<f64>,
    /// True if it belongs to the instrument: the accuracy of the machine then does not affect its size.
    pub is_of_instrument: bool,
}

impl ColumnGroup {
    /// One column.
    #[must_use]
    pub fn one(column: Vec<f64>, size: f64) -> ColumnGroup {
        ColumnGroup { columns: vec![column], sizes: vec![size], is_of_instrument: false }
    }
}

/// Readings without the part that set-ups can explain, divided by their uncertainty and decorrelated.
struct White<'w> {
    noise: &'w NoiseSeries,
    memory: Memory,
    weights: &'w [f64],
    setups: Setups,
    /// Half the logarithm of the determinant of the noise.
    half_log: f64,
    readings: Vec<f64>,
}

impl<'w> White<'w> {
    fn new(scene: &Scene<'_>, weights: &'w [f64], (noise, memory): (&'w NoiseSeries, Memory)) -> White<'w> {
        let setups = Setups::new(scene, weights, (noise, memory));
        let left: Vec<f64> = scene.items.iter().map(|item| item.left).collect();
        let mut white = White { noise, memory, weights, setups, half_log: 0.0, readings: Vec::new() };
        let (readings, half_log) = white.of(&left, 1.0);
        (white.readings, white.half_log) = (readings, half_log + white.setups.half_log);
        white
    }

    fn of(&self, values: &[f64], factor: f64) -> (Vec<f64>, f64) {
        let mut out: Vec<f64> =
            values.iter().zip(self.weights).map(|(value, weight)| factor * value * weight).collect();
        let half_log = self.noise.whiten(self.memory, &mut out);
        self.setups.take(&mut out);
        (out, half_log)
    }

    fn group(&self, group: &ColumnGroup) -> Vec<Vec<f64>> {
        group.columns.iter().zip(&group.sizes).map(|(column, &size)| self.of(column, size).0).collect()
    }
}

/// Readings, columns and their products, without the part that set-ups can explain.
pub struct Likelihood<'w> {
    white: White<'w>,
    /// Factor of all sizes of priors, by the accuracy of the machine.
    pub factor: f64,
    /// Number of readings less the unknowns of the set-ups.
    pub freedom: f64,
    /// `yᵀ Σ⁻¹ y`.
    square: f64,
    /// White columns in units of their priors.
    columns: Vec<Vec<f64>>,
    /// Products of the columns with each other.
    products: DMatrix<f64>,
    /// Products of the columns with the readings.
    with_readings: DVector<f64>,
    /// Standard deviation of the prior of each column, mm or rad.
    sizes: Vec<f64>,
    /// Columns of instruments, whose sizes do not follow the factor.
    of_instruments: Vec<bool>,
    /// Columns of each term.
    members: Vec<Range<usize>>,
    /// Index of each term among the given groups.
    pub kept: Vec<usize>,
    /// Groups with one column that has the same effect as that of a kept group: their indices and those of the kept groups, among the given ones.
    pub alike: Vec<(usize, usize)>,
    /// Amount of each of these, as a multiple of that of the kept one.
    pub ratios: Vec<f64>,
    /// Number of given groups.
    tested: usize,
}

/// Columns of a set, the decomposition of their matrix, and their products with the readings.
type Decomposed = (Vec<usize>, Cholesky<f64, Dyn>, DVector<f64>);

/// The posterior of a set of terms.
#[derive(Clone, Debug)]
pub struct Posterior {
    /// Natural logarithm of the marginal likelihood, relative to that of the empty set.
    pub log_evidence: f64,
    /// Factor of the stated noise.
    pub scale: f64,
    /// Sum of squared residuals, in stated standard deviations.
    pub misfit: f64,
    /// Amounts of all columns, mm or rad, in the order of the terms.
    pub mean: Vec<f64>,
    /// Their standard deviations.
    pub sigma: Vec<f64>,
}

impl<'w> Likelihood<'w> {
    /// Prepares groups of columns. `weights` are 1/σ of each reading, 0 for rejected ones.
    #[must_use]
    pub fn new(
        scene: &Scene<'_>,
        weights: &'w [f64],
        groups: &[ColumnGroup],
        (noise, memory): (&'w NoiseSeries, Memory),
    ) -> Likelihood<'w> {
        let white = White::new(scene, weights, (noise, memory));
        let mut out = Likelihood {
            factor: 1.0,
            freedom: weights.iter().filter(|weight| **weight > 0.0).count() as f64 - white.setups.rank as f64,
            square: dot(&white.readings, &white.readings),
            columns: Vec::new(),
            products: DMatrix::zeros(0, 0),
            with_readings: DVector::zeros(0),
            sizes: Vec::new(),
            of_instruments: Vec::new(),
            members: Vec::new(),
            kept: Vec::new(),
            alike: Vec::new(),
            ratios: Vec::new(),
            tested: 0,
            white,
        };
        out.add(groups);
        out
    }

    /// Adds groups of columns, numbered after those before.
    pub fn add(&mut self, groups: &[ColumnGroup]) {
        let all: Vec<Vec<Vec<f64>>> = in_parts(groups, &|group: &ColumnGroup| self.white.group(group));
        let is_visible = |columns: &[Vec<f64>]| columns.iter().any(|column| dot(column, column).sqrt() >= FAINT);
        let before = self.columns.len();
        for ((number, group), mut columns) in (self.tested..).zip(groups).zip(all) {
            if !is_visible(&columns) {
                continue;
            }
            let is_same = |members: &Range<usize>| match (columns.as_slice(), &self.columns[members.clone()]) {
                ([one], [other]) => {
                    // Only if the priors are equal too: otherwise the one with the more typical amount is the better explanation.
                    let [own, others] = [one, other].map(|column| dot(column, column).sqrt());
                    let cosine = dot(one, other) / (own * others);
                    1.0 - cosine.abs() < ALIKE && (own / others).ln().abs() < AS_USUAL
                }
                _ => false,
            };
            if let Some(place) = self.members.iter().position(is_same) {
                // Both columns are in units of their priors.
                let other = self.members[place].start;
                let ratio = dot(&columns[0], &self.columns[other]) / dot(&columns[0], &columns[0]);
                self.alike.push((number, self.kept[place]));
                self.ratios.push(ratio * group.sizes[0] / self.sizes[other]);
                continue;
            }
            self.kept.push(number);
            let from = self.columns.len();
            self.columns.append(&mut columns);
            self.sizes.extend(&group.sizes);
            self.of_instruments.resize(self.columns.len(), group.is_of_instrument);
            self.members.push(from..self.columns.len());
        }
        self.tested += groups.len();
        // Lower triangle of the new products.
        let columns = &self.columns;
        let numbers: Vec<usize> = (before..columns.len()).collect();
        let rows: Vec<Vec<f64>> =
            in_parts(&numbers, &|&row: &usize| columns[..=row].iter().map(|other| dot(&columns[row], other)).collect());
        let known = std::mem::replace(&mut self.products, DMatrix::zeros(0, 0));
        let of = |row: usize, column: usize| {
            let (last, first) = (row.max(column), row.min(column));
            if last < before { known[(row, column)] } else { rows[last - before][first] }
        };
        self.products = DMatrix::from_fn(columns.len(), columns.len(), of);
        let with_readings = columns.iter().skip(before).map(|column| dot(column, &self.white.readings));
        let with_readings: Vec<f64> = self.with_readings.iter().copied().chain(with_readings).collect();
        self.with_readings = DVector::from_vec(with_readings);
    }

    /// Factor of the size of a column.
    fn factor_of(&self, column: usize) -> f64 {
        if self.of_instruments[column] { 1.0 } else { self.factor }
    }

    /// Number of terms with a visible effect.
    #[must_use]
    pub fn count(&self) -> usize {
        self.kept.len()
    }

    /// Columns of the terms of a set.
    fn columns_of(&self, set: &[usize]) -> Vec<usize> {
        set.iter().flat_map(|&term| self.members[term].clone()).collect()
    }

    /// Returns the columns of a set, the decomposition of its matrix at a scale of the noise, and the products with the readings.
    fn decomposed(&self, set: &[usize], scale: f64) -> Option<Decomposed> {
        let weight = 1.0 / (scale * scale);
        let own = self.columns_of(set);
        let factors: Vec<f64> = own.iter().map(|&k| self.factor_of(k)).collect();
        let of = |row: usize, column: usize| {
            weight * factors[row] * factors[column] * self.products[(own[row], own[column])]
                + if row == column { 1.0 } else { 0.0 }
        };
        let matrix = DMatrix::from_fn(own.len(), own.len(), of);
        let right =
            DVector::from_iterator(own.len(), own.iter().map(|&k| weight * self.factor_of(k) * self.with_readings[k]));
        Some((own, Cholesky::new(matrix)?, right))
    }

    /// Returns the matrix of a set in tridiagonal form, which reduces its likelihood at each scale of the noise to one pass (Golub and Van Loan,
    /// Matrix Computations, 8.3).
    fn tridiagonal(&self, set: &[usize]) -> Tridiagonal {
        let own = self.columns_of(set);
        let factors: Vec<f64> = own.iter().map(|&k| self.factor_of(k)).collect();
        let of = |row: usize, column: usize| factors[row] * factors[column] * self.products[(own[row], own[column])];
        let right = DVector::from_iterator(own.len(), own.iter().map(|&k| self.factor_of(k) * self.with_readings[k]));
        if own.is_empty() {
            return Tridiagonal::default();
        }
        let (turned, diagonal, beside) = SymmetricTridiagonal::new(DMatrix::from_fn(own.len(), own.len(), of)).unpack();
        let right = turned.tr_mul(&right);
        Tridiagonal {
            diagonal: diagonal.iter().copied().collect(),
            beside: beside.iter().copied().collect(),
            right: right.iter().copied().collect(),
        }
    }

    /// Logarithm of the likelihood of a set at a scale of the noise, with the prior of the scale.
    fn at(&self, set: &Tridiagonal, scale: f64) -> f64 {
        let weight = 1.0 / (scale * scale);
        let Some((log_determinant, explained)) = set.at(weight) else { return f64::NEG_INFINITY };
        // Inverse gamma for s², as if READINGS_OF_SIGMA readings had shown the stated uncertainty.
        let prior = -0.5 * READINGS_OF_SIGMA * (2.0 * scale.ln() + weight);
        prior
            - self.white.half_log
            - self.freedom * scale.ln()
            - 0.5 * (log_determinant + weight * self.square - explained)
    }

    /// Returns the most likely scale of the noise for a set, and the logarithm of its likelihood there. Golden-section search, as there is one
    /// maximum.
    #[must_use]
    pub fn evidence(&self, set: &[usize]) -> (f64, f64) {
        let set = &self.tridiagonal(set);
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        let [mut low, mut high] = SCALES;
        let mut inner = [high - ratio * (high - low), low + ratio * (high - low)];
        let mut values = inner.map(|log| self.at(set, log.exp()));
        for _ in 0..STEPS {
            if values[0] > values[1] {
                high = inner[1];
                inner = [high - ratio * (high - low), inner[0]];
                values = [self.at(set, inner[0].exp()), values[0]];
            } else {
                low = inner[0];
                inner = [inner[1], low + ratio * (high - low)];
                values = [values[1], self.at(set, inner[1].exp())];
            }
        }
        let scale = (0.5 * (low + high)).exp();
        (scale, self.at(set, scale))
    }

    /// Returns the increase of the logarithm of the likelihood with each term in addition to a set, at a scale of the noise; minus infinity for terms
    /// of the set.
    #[must_use]
    pub fn gains(&self, set: &[usize], scale: f64) -> Vec<f64> {
        let count = self.count();
        let Some((own, root, right)) = self.decomposed(set, scale) else { return vec![f64::NEG_INFINITY; count] };
        let weight = 1.0 / (scale * scale);
        let amounts = root.solve(&right);
        let gain = |term: usize| {
            if set.contains(&term) {
                return f64::NEG_INFINITY;
            }
            let new: Vec<usize> = self.members[term].clone().collect();
            let of = |one: usize, other: usize| {
                weight * self.factor_of(one) * self.factor_of(other) * self.products[(one, other)]
            };
            let with = DMatrix::from_fn(own.len(), new.len(), |row, column| of(own[row], new[column]));
            let among = DMatrix::from_fn(new.len(), new.len(), |row, column| of(new[row], new[column]));
            let with_readings = DVector::from_iterator(
                new.len(),
                new.iter().map(|&k| weight * self.factor_of(k) * self.with_readings[k]),
            );
            gain_of(&root, &amounts, &with, among, with_readings)
        };
        let all: Vec<usize> = (0..count).collect();
        in_parts(&all, &|&term: &usize| gain(term))
    }

    /// Returns for groups outside the terms the best result over some sets: the given score of the set plus the increase of the logarithm of the
    /// likelihood with the group in addition to it. All sets are subsets of the first one.
    #[must_use]
    pub fn best_with_others(
        &self,
        sets: &[(Vec<usize>, f64)],
        scale: f64,
        groups: &[usize],
        of: &(dyn Fn(usize) -> ColumnGroup + Sync),
    ) -> Vec<f64> {
        let weight = 1.0 / (scale * scale);
        let whole = sets.first().map_or_else(Vec::new, |(set, _)| self.columns_of(set));
        let prepared: Vec<_> = sets
            .iter()
            .filter_map(|(set, score)| {
                let (own, root, right) = self.decomposed(set, scale)?;
                let amounts = root.solve(&right);
                let places: Vec<usize> =
                    own.iter().filter_map(|column| whole.iter().position(|other| other == column)).collect();
                Some((places, root, amounts, *score))
            })
            .collect();
        in_parts(groups, &|&number: &usize| {
            let group = of(number);
            let factor = if group.is_of_instrument { 1.0 } else { self.factor };
            let new = self.white.group(&group);
            if new.iter().all(|column| dot(column, column).sqrt() < FAINT) {
                return f64::NEG_INFINITY;
            }
            let with = DMatrix::from_fn(whole.len(), new.len(), |row, column| {
                weight * factor * self.factor_of(whole[row]) * dot(&self.columns[whole[row]], &new[column])
            });
            let among = DMatrix::from_fn(new.len(), new.len(), |row, column| {
                weight * factor * factor * dot(&new[row], &new[column])
            });
            let with_readings = DVector::from_iterator(
                new.len(),
                new.iter().map(|column| weight * factor * dot(column, &self.white.readings)),
            );
            let one = |(places, root, amounts, score): &(Vec<usize>, Cholesky<f64, Dyn>, DVector<f64>, f64)| {
                let with = with.select_rows(places);
                score + gain_of(root, amounts, &with, among.clone(), with_readings.clone())
            };
            prepared.iter().map(one).fold(f64::NEG_INFINITY, f64::max)
        })
    }

    /// Returns the posterior of a set.
    #[must_use]
    pub fn posterior(&self, set: &[usize]) -> Posterior {
        let (scale, log_likelihood) = self.evidence(set);
        let log_evidence = log_likelihood - self.evidence(&[]).1;
        let nothing = Posterior { log_evidence, scale, misfit: self.square, mean: Vec::new(), sigma: Vec::new() };
        let Some((own, root, right)) = self.decomposed(set, scale) else { return nothing };
        // In units of the given priors.
        let factors = DVector::from_iterator(own.len(), own.iter().map(|&k| self.factor_of(k)));
        let amounts = root.solve(&right).component_mul(&factors);
        let inverse = root.inverse();
        let with: f64 = own.iter().zip(amounts.iter()).map(|(&k, amount)| amount * self.with_readings[k]).sum();
        let among: f64 = own
            .iter()
            .zip(amounts.iter())
            .flat_map(|(&k, one)| own.iter().zip(amounts.iter()).map(move |(&l, other)| (k, l, one * other)))
            .map(|(k, l, product)| product * self.products[(k, l)])
            .sum();
        let sizes = own.iter().map(|&k| self.sizes[k]);
        Posterior {
            misfit: self.square - 2.0 * with + among,
            mean: sizes.clone().zip(amounts.iter()).map(|(size, amount)| size * amount).collect(),
            sigma: sizes.enumerate().map(|(k, size)| size * factors[k] * inverse[(k, k)].sqrt()).collect(),
            ..nothing
        }
    }

    /// Returns the number of columns of a term.
    #[must_use]
    pub fn width(&self, term: usize) -> usize {
        self.members.get(term).map_or(0, Range::len)
    }
}

/// Increase of the logarithm of the likelihood with columns in addition to a set: `with` are their products with its columns, `among` those with each
/// other.
fn gain_of(
    root: &Cholesky<f64, Dyn>,
    amounts: &DVector<f64>,
    with: &DMatrix<f64>,
    among: DMatrix<f64>,
    with_readings: DVector<f64>,
) -> f64 {
    let mut own = among - with.transpose() * root.solve(with);
    (0..own.nrows()).for_each(|k| own[(k, k)] += 1.0);
    let rest = with_readings - with.transpose() * amounts;
    let Some(own) = Cholesky::new(own) else { return f64::NEG_INFINITY };
    let half_log: f64 = own.l_dirty().diagonal().iter().map(|value| value.ln()).sum();
    0.5 * rest.dot(&own.solve(&rest)) - half_log
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::diagnose::bench;

    fn at(likelihood: &Likelihood<'_>, set: &[usize], scale: f64) -> f64 {
        likelihood.at(&likelihood.tridiagonal(set), scale)
    }

    /// Logarithm of the density of a normal distribution with a covariance, without its constant.
    fn density(covariance: DMatrix<f64>, values: &DVector<f64>) -> f64 {
        let root = Cholesky::new(covariance).unwrap();
        let log_determinant: f64 = root.l_dirty().diagonal().iter().map(|value| 2.0 * value.ln()).sum();
        -0.5 * (log_determinant + values.dot(&root.solve(values)))
    }

    #[test]
    fn the_evidence_is_that_of_the_whole_covariance() {
        let machine = bench::machine();
        // An offset of the set-up is free.
        let rows = "component,X,Y,Z,value_um\nEXX,0,0,0,0.3\nEXX,100,0,0,4.1\nEXX,200,0,0,7.7\nEXX,300,0,0,13.0\nEXX,400,0,0,15.2\n";
        let toml = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.8\n";
        let sets = [bench::table(&machine, rows, toml)];
        let scene = bench::scene(&machine, &sets);
        let count = scene.items.len();
        let [line, bow] = [|x: f64| x - 2.0, |x: f64| (x - 2.0).powi(2)]
            .map(|shape: fn(f64) -> f64| (0..count).map(|k| shape(k as f64)).collect::<Vec<f64>>());
        let sizes = [6e-3, 2e-3];
        let weights = vec![1.0 / 0.8e-3; count];
        let noise = NoiseSeries::new(&scene, &weights);
        let white = (&noise, Memory::default());
        let groups = [ColumnGroup::one(line.clone(), sizes[0]), ColumnGroup::one(bow.clone(), sizes[1])];
        let mut likelihood = Likelihood::new(&scene, &weights, &groups, white);
        assert_eq!((likelihood.kept.as_slice(), likelihood.freedom), ([0, 1].as_slice(), 4.0));
        let readings = DVector::from_iterator(count, scene.items.iter().map(|item| item.left));
        let covariance = |columns: &[(&[f64], f64)], scale: f64| {
            DMatrix::from_fn(count, count, |row, column| {
                let noise = if row == column { (scale * 0.8e-3_f64).powi(2) } else { 0.0 };
                // The offset is unknown: 1 mm is a thousand times the noise.
                let offset = 1.0_f64.powi(2);
                noise + offset + columns.iter().map(|(one, size)| size * size * one[row] * one[column]).sum::<f64>()
            })
        };
        for scale in [0.5, 1.0, 3.0] {
            let none = density(covariance(&[], scale), &readings);
            for (set, columns) in [
                (vec![0], vec![(line.as_slice(), sizes[0])]),
                (vec![1], vec![(bow.as_slice(), sizes[1])]),
                (vec![0, 1], vec![(line.as_slice(), sizes[0]), (bow.as_slice(), sizes[1])]),
            ] {
                let expected = density(covariance(&columns, scale), &readings) - none;
                let own = at(&likelihood, &set, scale) - at(&likelihood, &[], scale);
                assert!((own - expected).abs() < 1e-3 * expected.abs().max(1.0), "{set:?} {scale}: {own} {expected}");
            }
            let gain = likelihood.gains(&[0], scale)[1];
            let both = at(&likelihood, &[0, 1], scale) - at(&likelihood, &[0], scale);
            assert!((gain - both).abs() < 1e-9 * both.abs().max(1.0), "{gain} {both}");
            let outside = likelihood
                .best_with_others(&[(vec![0], 0.0), (vec![], -1e9)], scale, &[1], &|number| groups[number].clone())[0];
            assert!((outside - gain).abs() < 1e-9 * gain.abs().max(1.0), "{outside} {gain}");
            // Both as one term.
            let together = ColumnGroup {
                columns: vec![line.clone(), bow.clone()],
                sizes: sizes.to_vec(),
                is_of_instrument: false,
            };
            let one = Likelihood::new(&scene, &weights, std::slice::from_ref(&together), white);
            let (at_once, own) = (
                at(&one, &[0], scale) - at(&one, &[], scale),
                at(&likelihood, &[0, 1], scale) - at(&likelihood, &[], scale),
            );
            assert!((at_once - own).abs() < 1e-9 * own.abs().max(1.0), "{at_once} {own}");
            assert!((one.gains(&[], scale)[0] - own).abs() < 1e-9 * own.abs().max(1.0));
            // A more accurate machine: all sizes are smaller, except those of an instrument.
            likelihood.factor = 0.4;
            let smaller = [0.4 * sizes[0], 0.4 * sizes[1]];
            let both = [(line.as_slice(), smaller[0]), (bow.as_slice(), smaller[1])];
            let expected = density(covariance(&both, scale), &readings) - none;
            let own = at(&likelihood, &[0, 1], scale) - at(&likelihood, &[], scale);
            assert!((own - expected).abs() < 1e-3 * expected.abs().max(1.0), "{own} {expected}");
            let gain = likelihood.gains(&[0], scale)[1];
            let both = own - (at(&likelihood, &[0], scale) - at(&likelihood, &[], scale));
            assert!((gain - both).abs() < 1e-9 * both.abs().max(1.0), "{gain} {both}");
            let bow_of_instrument = ColumnGroup { is_of_instrument: true, ..groups[1].clone() };
            let mixed = [groups[0].clone(), bow_of_instrument];
            let mut of_both = Likelihood::new(&scene, &weights, &mixed, white);
            of_both.factor = 0.4;
            let columns = [(line.as_slice(), smaller[0]), (bow.as_slice(), sizes[1])];
            let expected = density(covariance(&columns, scale), &readings) - none;
            let own = at(&of_both, &[0, 1], scale) - at(&of_both, &[], scale);
            assert!((own - expected).abs() < 1e-3 * expected.abs().max(1.0), "{own} {expected}");
            let outside = of_both.best_with_others(&[(vec![0], 0.0)], scale, &[1], &|number| mixed[number].clone())[0];
            let gain = at(&of_both, &[0, 1], scale) - at(&of_both, &[0], scale);
            assert!((outside - gain).abs() < 1e-9 * gain.abs().max(1.0), "{outside} {gain}");
            likelihood.factor = 1.0;
        }
    }

    #[test]
    fn a_column_that_a_set_up_takes_shows_nothing_and_twins_are_named() {
        let machine = bench::machine();
        let rows = "component,X,Y,Z,value_um\nEXX,0,0,0,0\nEXX,100,0,0,0\nEXX,200,0,0,0\n";
        let toml = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 1\n";
        let sets = [bench::table(&machine, rows, toml)];
        let scene = bench::scene(&machine, &sets);
        let columns = [vec![1.0; 3], vec![0.0, 1.0, 2.0], vec![5.0, 3.0, 1.0]];
        let weights = [1e3; 3];
        let noise = NoiseSeries::new(&scene, &weights);
        let [a, b, c] = columns;
        // Half of the typical size for twice the column.
        let groups = [ColumnGroup::one(a, 10e-3), ColumnGroup::one(b, 10e-3), ColumnGroup::one(c, 5e-3)];
        let likelihood = Likelihood::new(&scene, &weights, &groups, (&noise, Memory::default()));
        // The third column is −2 times the second one plus a constant.
        assert_eq!((likelihood.kept.as_slice(), likelihood.alike.as_slice()), ([1].as_slice(), [(2, 1)].as_slice()));
    }
}
