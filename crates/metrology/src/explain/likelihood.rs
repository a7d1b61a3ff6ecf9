//! The likelihood of readings under a set of terms, in closed form.
//!
//! Readings are `y = U u + Φ θ + ε` with unknowns `u` of the set-ups, of which nothing is assumed, amounts `θ ~ N(0, S)` of the terms, and noise
//! `ε ~ N(0, s² Σ)`, where Σ is the stated uncertainty of the readings with the memory of the noise, and s its scale. The part that the set-ups can explain is taken from the readings and from all columns once;
//! after that everything about a set of terms follows from `G = Φᵀ Σ⁻¹ Φ`, `b = Φᵀ Σ⁻¹ y` and `yᵀ Σ⁻¹ y` (marginal likelihood: Rasmussen and Williams 2006,
//! Gaussian Processes for Machine Learning, eq. 2.43).

use std::collections::HashMap;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::assumptions::READINGS_OF_SIGMA;
use super::noise::{Memory, NoiseSeries};
use crate::diagnose::Scene;
use ncfix_base::numeric::in_parts;
use ncfix_base::numeric::sums::dot;

/// Unknowns of a set-up are dropped from its matrix where less than this share of their square is their own.
const RIDGE: f64 = 1e-10;
/// A column of which the set-ups leave less than this, in standard deviations of the readings for an amount of its prior's size, shows nothing.
const FAINT: f64 = 0.3;
/// Columns whose correlation differs from 1 by less act alike on everything that was measured.
const ALIKE: f64 = 1e-6;
/// Largest and smallest scale of the stated noise, in natural logarithms: 1/55 to 400.
const SCALES: [f64; 2] = [-4.0, 6.0];
/// Steps of the search for the scale.
const STEPS: usize = 40;

/// Readings, columns and their products, without what the set-ups can take.
#[derive(Clone, Debug)]
pub struct Likelihood {
    /// Number of readings less the unknowns of the set-ups.
    pub freedom: f64,
    /// `yᵀ Σ⁻¹ y`.
    square: f64,
    /// Products of the columns with each other, in units of their priors.
    products: DMatrix<f64>,
    /// Products of the columns with the readings.
    with_readings: DVector<f64>,
    /// Standard deviation of the prior of each column, mm or rad.
    sizes: Vec<f64>,
    /// Half the logarithm of the determinant of the noise at the scale 1.
    half_log_noise: f64,
    /// Which of the columns that were given each one is.
    pub kept: Vec<usize>,
    /// Columns that act like a kept one: theirs and its number among those that were given.
    pub alike: Vec<(usize, usize)>,
}

/// The posterior of a set of terms.
#[derive(Clone, Debug)]
pub struct Posterior {
    /// Natural logarithm of the marginal likelihood, less that of no term at the stated noise.
    pub log_evidence: f64,
    /// Scale of the noise beside what is stated.
    pub scale: f64,
    /// Amounts, mm or rad.
    pub mean: Vec<f64>,
    /// Their standard deviations.
    pub sigma: Vec<f64>,
}

impl Likelihood {
    /// Prepares columns (one unit of each on every reading of the scene) with the sizes of their priors.
    #[must_use]
    pub fn new(
        scene: &Scene<'_>,
        columns: &[Vec<f64>],
        sizes: &[f64],
        (noise, memory): (&NoiseSeries, Memory),
    ) -> Likelihood {
        let setups = Setups::new(scene, (noise, memory));
        let whiten = |values: &[f64], factor: f64| {
            let values = values.iter().zip(&scene.items);
            let mut out: Vec<f64> = values.map(|(value, item)| factor * value / item.sigma).collect();
            let half_log = noise.whiten(memory, &mut out);
            setups.take(&mut out);
            (out, half_log)
        };
        let left: Vec<f64> = scene.items.iter().map(|item| item.left).collect();
        let (readings, half_log_noise) = whiten(&left, 1.0);
        let numbered: Vec<(&Vec<f64>, f64)> = columns.iter().zip(sizes.iter().copied()).collect();
        let white: Vec<Vec<f64>> = in_parts(&numbered, &|&(column, size): &(&Vec<f64>, f64)| whiten(column, size).0);
        let norms: Vec<f64> = white.iter().map(|column| dot(column, column).sqrt()).collect();
        let visible: Vec<usize> = (0..white.len()).filter(|&number| norms[number] >= FAINT).collect();
        // Lower triangle of the products of all visible columns.
        let rows: Vec<Vec<f64>> = in_parts(&visible, &|&number: &usize| {
            let earlier = visible.iter().take_while(|&&other| other <= number);
            earlier.map(|&other| dot(&white[number], &white[other])).collect()
        });
        // Places among the visible ones.
        let (mut places, mut alike): (Vec<usize>, Vec<(usize, usize)>) = (Vec::new(), Vec::new());
        for place in 0..visible.len() {
            let is_same = |&&other: &&usize| {
                let cosine = rows[place][other] / (rows[place][place] * rows[other][other]).sqrt();
                1.0 - cosine.abs() < ALIKE
            };
            match places.iter().find(is_same) {
                Some(&other) => alike.push((visible[place], visible[other])),
                None => places.push(place),
            }
        }
        let kept: Vec<usize> = places.iter().map(|&place| visible[place]).collect();
        let count = kept.len();
        let products = DMatrix::from_fn(count, count, |row, column| {
            let [row, column] = [row.max(column), row.min(column)].map(|k| places[k]);
            rows[row][column]
        });
        let with_readings = DVector::from_iterator(count, kept.iter().map(|&number| dot(&white[number], &readings)));
        Likelihood {
            freedom: scene.items.len() as f64 - setups.rank as f64,
            square: dot(&readings, &readings),
            products,
            with_readings,
            sizes: kept.iter().map(|&number| sizes[number]).collect(),
            half_log_noise: half_log_noise + setups.half_log,
            kept,
            alike,
        }
    }

    /// Number of columns that show something.
    #[must_use]
    pub fn count(&self) -> usize {
        self.kept.len()
    }

    /// Returns the matrix of a set at a scale of the noise, decomposed, and the products with the readings.
    fn decomposed(&self, set: &[usize], scale: f64) -> Option<(Cholesky<f64, Dyn>, DVector<f64>)> {
        let weight = 1.0 / (scale * scale);
        let of = |row: usize, column: usize| {
            weight * self.products[(set[row], set[column])] + if row == column { 1.0 } else { 0.0 }
        };
        let matrix = DMatrix::from_fn(set.len(), set.len(), of);
        let right = DVector::from_iterator(set.len(), set.iter().map(|&k| weight * self.with_readings[k]));
        Some((Cholesky::new(matrix)?, right))
    }

    /// Logarithm of the likelihood of a set at a scale of the noise, with the prior of the scale.
    fn at(&self, set: &[usize], scale: f64) -> f64 {
        let Some((root, right)) = self.decomposed(set, scale) else { return f64::NEG_INFINITY };
        let weight = 1.0 / (scale * scale);
        let log_determinant: f64 = root.l_dirty().diagonal().iter().map(|value| 2.0 * value.ln()).sum();
        let explained = right.dot(&root.solve(&right));
        // Inverse gamma for s², as if READINGS_OF_SIGMA readings had shown the stated uncertainty.
        let prior = -0.5 * READINGS_OF_SIGMA * (2.0 * scale.ln() + weight);
        prior
            - self.half_log_noise
            - self.freedom * scale.ln()
            - 0.5 * (log_determinant + weight * self.square - explained)
    }

    /// Returns the scale of the noise at which a set is most likely, and the logarithm of its likelihood there. Golden section: there is one maximum.
    #[must_use]
    pub fn evidence(&self, set: &[usize]) -> (f64, f64) {
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

    /// Returns by how much the logarithm of the likelihood grows with each column beside a set at a scale of the noise; minus infinity for its own columns.
    #[must_use]
    pub fn gains(&self, set: &[usize], scale: f64) -> Vec<f64> {
        let count = self.count();
        let Some((root, right)) = self.decomposed(set, scale) else { return vec![f64::NEG_INFINITY; count] };
        let weight = 1.0 / (scale * scale);
        let amounts = root.solve(&right);
        let gain = |column: usize| {
            if set.contains(&column) {
                return f64::NEG_INFINITY;
            }
            let with = DVector::from_iterator(set.len(), set.iter().map(|&k| weight * self.products[(k, column)]));
            let own = 1.0 + weight * self.products[(column, column)] - with.dot(&root.solve(&with));
            let rest = weight * self.with_readings[column] - with.dot(&amounts);
            0.5 * (rest * rest / own - own.ln())
        };
        let all: Vec<usize> = (0..count).collect();
        in_parts(&all, &|&column: &usize| gain(column))
    }

    /// Returns the posterior of a set.
    #[must_use]
    pub fn posterior(&self, set: &[usize]) -> Posterior {
        let (scale, log_likelihood) = self.evidence(set);
        let log_evidence = log_likelihood - self.evidence(&[]).1;
        let nothing = Posterior { log_evidence, scale, mean: Vec::new(), sigma: Vec::new() };
        let Some((root, right)) = self.decomposed(set, scale) else { return nothing };
        let amounts = root.solve(&right);
        let covariance = root.inverse();
        let sizes = set.iter().map(|&k| self.sizes[k]);
        Posterior {
            mean: sizes.clone().zip(amounts.iter()).map(|(size, amount)| size * amount).collect(),
            sigma: sizes.enumerate().map(|(k, size)| size * covariance[(k, k)].sqrt()).collect(),
            ..nothing
        }
    }
}

/// A reading with its derivatives by the unknowns of its group.
type SetupRow = (usize, Vec<(usize, f64)>);

/// Unknowns of the set-ups by groups that share readings: each group touches its own readings only.
struct Setups {
    groups: Vec<Group>,
    /// Unknowns that readings show.
    rank: usize,
    /// Half the logarithm of the determinant of their matrices: what the noise leaves of them counts when memories are compared.
    half_log: f64,
}

/// Unknowns that occur in the same readings.
struct Group {
    /// Readings with the derivatives by its unknowns, divided by their uncertainty.
    rows: Vec<SetupRow>,
    count: usize,
    root: Cholesky<f64, Dyn>,
}

impl Setups {
    fn new(scene: &Scene<'_>, (noise, memory): (&NoiseSeries, Memory)) -> Setups {
        // Union of unknowns that occur in one reading.
        let mut parent: Vec<usize> = (0..scene.unknowns).collect();
        fn top(parent: &mut [usize], mut k: usize) -> usize {
            while parent[k] != k {
                parent[k] = parent[parent[k]];
                k = parent[k];
            }
            k
        }
        for item in &scene.items {
            for pair in item.by_unknown.windows(2) {
                let [a, b] = [pair[0].0, pair[1].0].map(|k| top(&mut parent, k));
                parent[a.max(b)] = a.min(b);
            }
        }
        // Noise with memory mixes the readings of a series.
        let is_mixed = memory.ratio > 0.0;
        for series in noise.series().filter(|_| is_mixed) {
            let mut first = None;
            for unknown in series.flat_map(|place| &scene.items[place].by_unknown).map(|&(unknown, _)| unknown) {
                let [a, b] = [*first.get_or_insert(unknown), unknown].map(|k| top(&mut parent, k));
                parent[a.max(b)] = a.min(b);
            }
        }
        let mut members: HashMap<usize, Vec<usize>> = HashMap::new();
        for k in 0..scene.unknowns {
            let group = top(&mut parent, k);
            members.entry(group).or_default().push(k);
        }
        let mut first: Vec<usize> = members.keys().copied().collect();
        first.sort_unstable();
        let number: HashMap<usize, (usize, usize)> = first
            .iter()
            .enumerate()
            .flat_map(|(group, head)| {
                members[head].iter().enumerate().map(move |(place, &unknown)| (unknown, (group, place)))
            })
            .collect();
        let mut touched: Vec<Vec<usize>> = vec![Vec::new(); first.len()];
        let mut dense: Vec<Vec<(usize, f64)>> = vec![Vec::new(); scene.unknowns];
        for (place, item) in scene.items.iter().enumerate() {
            for &(unknown, factor) in &item.by_unknown {
                dense[unknown].push((place, factor / item.sigma));
            }
            if let Some(&(unknown, _)) = item.by_unknown.first() {
                touched[number[&unknown].0].push(place);
            }
        }
        for series in noise.series().filter(|_| is_mixed) {
            let places: Vec<usize> = series.collect();
            let of = places.iter().find_map(|&place| scene.items[place].by_unknown.first());
            if let Some((unknown, _)) = of {
                touched[number[unknown].0].extend(places);
            }
        }
        for places in &mut touched {
            places.sort_unstable();
            places.dedup();
        }
        let mut rows: Vec<Vec<SetupRow>> =
            touched.iter().map(|places| places.iter().map(|&place| (place, Vec::new())).collect()).collect();
        let mut values = vec![0.0; scene.items.len()];
        for (unknown, own) in dense.iter().enumerate() {
            let (group, number) = number[&unknown];
            own.iter().for_each(|&(place, factor)| values[place] = factor);
            noise.whiten(memory, &mut values);
            for (place, row) in &mut rows[group] {
                if values[*place] != 0.0 {
                    row.push((number, values[*place]));
                }
                values[*place] = 0.0;
            }
        }
        let (mut rank, mut half_log) = (0, 0.0);
        let groups = rows.into_iter().zip(&first).filter_map(|(rows, head)| {
            let count = members[head].len();
            let mut matrix = DMatrix::zeros(count, count);
            for (_, own) in &rows {
                for &(row, left) in own {
                    for &(column, right) in own {
                        matrix[(row, column)] += left * right;
                    }
                }
            }
            rank += (0..count).filter(|&k| matrix[(k, k)] > 0.0).count();
            for k in 0..count {
                matrix[(k, k)] = if matrix[(k, k)] > 0.0 { matrix[(k, k)] * (1.0 + RIDGE) } else { 1.0 };
            }
            let root = Cholesky::new(matrix)?;
            half_log += root.l_dirty().diagonal().iter().map(|value| value.ln()).sum::<f64>();
            Some(Group { rows, count, root })
        });
        let groups = groups.collect();
        Setups { groups, rank, half_log }
    }

    /// Takes what the set-ups can take from whitened values.
    fn take(&self, values: &mut [f64]) {
        for group in &self.groups {
            let mut right = DVector::zeros(group.count);
            for (place, own) in &group.rows {
                for &(k, factor) in own {
                    right[k] += factor * values[*place];
                }
            }
            let amounts = group.root.solve(&right);
            for (place, own) in &group.rows {
                values[*place] -= own.iter().map(|&(k, factor)| factor * amounts[k]).sum::<f64>();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    /// Logarithm of the density of a normal distribution with a covariance, but for its constant.
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
        let noise = NoiseSeries::new(&scene);
        let white = (&noise, Memory::default());
        let likelihood = Likelihood::new(&scene, &[line.clone(), bow.clone()], &sizes, white);
        assert_eq!((likelihood.kept.as_slice(), likelihood.freedom), ([0, 1].as_slice(), 4.0));
        let readings = DVector::from_iterator(count, scene.items.iter().map(|item| item.left));
        let covariance = |columns: &[(&[f64], f64)], scale: f64| {
            DMatrix::from_fn(count, count, |row, column| {
                let noise = if row == column { (scale * 0.8e-3_f64).powi(2) } else { 0.0 };
                // Nothing is known of the offset: 1 mm is a thousand times the noise.
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
                let own = likelihood.at(&set, scale) - likelihood.at(&[], scale);
                assert!((own - expected).abs() < 1e-3 * expected.abs().max(1.0), "{set:?} {scale}: {own} {expected}");
            }
            let gain = likelihood.gains(&[0], scale)[1];
            let both = likelihood.at(&[0, 1], scale) - likelihood.at(&[0], scale);
            assert!((gain - both).abs() < 1e-9 * both.abs().max(1.0), "{gain} {both}");
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
        let noise = NoiseSeries::new(&scene);
        let likelihood = Likelihood::new(&scene, &columns, &[10e-3; 3], (&noise, Memory::default()));
        // The third one is the second one times −2 and a constant.
        assert_eq!((likelihood.kept.as_slice(), likelihood.alike.as_slice()), ([1].as_slice(), [(2, 1)].as_slice()));
    }
}
