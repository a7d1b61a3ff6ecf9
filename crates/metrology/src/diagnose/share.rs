//! Shares of the findings in the explained part of the residual: the loss without each finding, and its fair share (Shapley 1953). The fair share is the mean
//! of its contributions over all orders in which the findings could be added.

use nalgebra::{DMatrix, DVector};

use super::search::{Field, Weights};

/// Maximum number of findings for which all subsets are evaluated.
const MOST: usize = 10;

/// Shares of one finding in the sum of squares of the residual of the model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VarianceShare {
    /// Increase of the residual without it.
    pub alone: f64,
    /// Its fair share.
    pub fair: f64,
}

/// Returns the shares of all findings.
pub(super) fn shares(field: &Field<'_, '_>, weights: &Weights, taken: &[usize]) -> Vec<VarianceShare> {
    let count = taken.len();
    let mut series = field.series(weights, &[], 0.0);
    let left = series.left().to_vec();
    let whole = series.squares();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut owners: Vec<usize> = Vec::new();
    for (owner, &number) in taken.iter().enumerate() {
        for column in field.columns_of(number) {
            series.set_values(&column);
            columns.push(unit(series.left()));
            owners.push(owner);
        }
    }
    if count == 0 || whole <= 0.0 {
        return vec![VarianceShare::default(); count];
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let gram = DMatrix::from_fn(columns.len(), columns.len(), |a, b| dot(&columns[a], &columns[b]));
    let right = DVector::from_iterator(columns.len(), columns.iter().map(|column| dot(column, &left)));
    // Part that the findings of a set explain.
    let explained = |is_in: &dyn Fn(usize) -> bool| {
        let own: Vec<usize> = (0..columns.len()).filter(|&k| is_in(owners[k])).collect();
        if own.is_empty() {
            return 0.0;
        }
        let small = DMatrix::from_fn(own.len(), own.len(), |a, b| gram[(own[a], own[b])]);
        let part = DVector::from_iterator(own.len(), own.iter().map(|&k| right[k]));
        // Findings with the same columns share their contribution.
        let eigen = small.symmetric_eigen();
        let most = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
        let turned = eigen.eigenvectors.transpose() * part;
        let of = |(value, part): (&f64, &f64)| if *value > 1e-9 * most { part * part / value } else { 0.0 };
        eigen.eigenvalues.iter().zip(turned.iter()).map(of).sum::<f64>() / whole
    };
    if count > MOST {
        // There are too many subsets. The fair share lies between the loss without the finding and its contribution alone.
        let every = explained(&|_| true);
        let of = |k: usize| {
            let alone = every - explained(&|owner| owner != k);
            VarianceShare { alone, fair: (alone + explained(&|owner| owner == k)) / 2.0 }
        };
        return (0..count).map(of).collect();
    }
    let all = (1_u32 << count) - 1;
    let sets: Vec<f64> = (0..=all).map(|set| explained(&|owner| set >> owner & 1 == 1)).collect();
    let at = |set: u32| sets.get(set as usize).copied().unwrap_or(0.0);
    let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
    let of = |k: usize| {
        let bit = 1_u32 << k;
        let mut fair = 0.0;
        for set in (0..=all).filter(|set| set & bit == 0) {
            let size = set.count_ones();
            let orders = factorial(size) * factorial(all.count_ones() - size - 1) / factorial(all.count_ones());
            fair += orders * (at(set | bit) - at(set));
        }
        VarianceShare { alone: at(all) - at(all & !bit), fair }
    };
    (0..count).map(of).collect()
}

fn unit(column: &[f64]) -> Vec<f64> {
    let length = column.iter().map(|value| value * value).sum::<f64>().sqrt();
    if length > 0.0 { column.iter().map(|value| value / length).collect() } else { column.to_vec() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use crate::diagnose::cause::EffectKind;
    use crate::diagnose::scene::Through;

    /// Readings of 1 µm along X in some rows. Three findings explain those of the first row; one further finding explains each other row.
    fn of(rows: usize) -> Vec<VarianceShare> {
        let machine = bench::machine();
        let sets = [bench::reads_along_x(&machine, &vec![1.0; rows])];
        let scene = bench::scene(&machine, &sets);
        let own = |at: usize| move |row: &crate::diagnose::row::SceneRow| f64::from(u8::from(row.number == at));
        let all = [0, 0].into_iter().chain(0..rows);
        let all = all.map(|at| bench::candidate(EffectKind::Unknown, Through::Tip(0), own(at))).collect();
        let field = Field::new(&scene, all);
        shares(&field, &bench::even(&scene), &(0..rows + 2).collect::<Vec<_>>())
    }

    /// Checks the shares of the first three findings. Each of the others explains all of its row.
    fn check(found: &[VarianceShare], first: [f64; 2], other: f64) {
        for (k, share) in found.iter().enumerate() {
            let [alone, fair] = if k < 3 { first } else { [other; 2] };
            assert!((share.alone - alone).abs() < 1e-9 && (share.fair - fair).abs() < 1e-9, "{k} {share:?}");
        }
    }

    #[test]
    fn those_that_say_the_same_share_it() {
        let found = of(8);
        // Without one of the three, nothing is lost; each has a third of the row.
        check(&found, [0.0, 1.0 / 24.0], 1.0 / 8.0);
    }

    #[test]
    fn of_many_the_fair_part_is_between_what_is_lost_without_it_and_what_it_says_alone() {
        let found = of(9);
        check(&found, [0.0, 1.0 / 18.0], 1.0 / 9.0);
    }

    #[test]
    fn more_findings_than_a_word_has_bits_have_their_own_shares() {
        // 72 findings: a model of five axes with a stated term is as large.
        check(&of(70), [0.0, 1.0 / 140.0], 1.0 / 70.0);
    }
}
