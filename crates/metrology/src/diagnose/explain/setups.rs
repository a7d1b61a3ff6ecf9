//! Unknowns of the set-ups: the part of readings that they can explain is subtracted from readings and columns.

use std::collections::HashMap;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::noise::{Memory, NoiseSeries};
use crate::diagnose::scene::Scene;

/// Relative increase of the diagonal of the matrix of the set-ups, which keeps it positive definite if unknowns are collinear.
const RIDGE: f64 = 1e-10;

/// Index of a reading, and its derivatives with respect to the unknowns of its group.
type SetupRow = (usize, Vec<(usize, f64)>);

/// Unknowns of the set-ups in groups: each group affects only its own readings.
pub(super) struct Setups {
    groups: Vec<Together>,
    /// Number of unknowns that readings show.
    pub(super) rank: usize,
    /// Half the logarithm of the determinant of their matrices, which matters in comparisons of autocorrelations.
    pub(super) half_log: f64,
}

/// Unknowns that occur in the same readings.
struct Together {
    /// Readings with the derivatives with respect to its unknowns, divided by their uncertainty.
    rows: Vec<SetupRow>,
    count: usize,
    root: Cholesky<f64, Dyn>,
}

impl Setups {
    pub(super) fn new(scene: &Scene<'_>, weights: &[f64], (noise, memory): (&NoiseSeries, Memory)) -> Setups {
        // Joins unknowns that occur in the same reading.
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
        // Decorrelation mixes the readings of a series.
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
        for (place, (item, weight)) in
            scene.items.iter().zip(weights).enumerate().filter(|(_, (_, weight))| **weight > 0.0)
        {
            for &(unknown, factor) in &item.by_unknown {
                dense[unknown].push((place, factor * weight));
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
            noise.whiten_some(memory, noise.series_with(own.iter().map(|&(place, _)| place)), &mut values);
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
            Some(Together { rows, count, root })
        });
        let groups = groups.collect();
        Setups { groups, rank, half_log }
    }

    /// Subtracts the part that set-ups can explain from whitened values.
    pub(super) fn take(&self, values: &mut [f64]) {
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
