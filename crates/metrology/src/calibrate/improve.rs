//! Selects further poses that improve the identifiability of a plan.
//!
//! The computation uses an error-free machine: with errors, exact dependences hold only to 1e-4, and the unknowns would seem identifiable.

use nalgebra::{DMatrix, DVector};

use crate::measure::data::{DataSet, Observation};
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

use super::design::Design;
use super::effect::Parameter;

/// Number of candidates that are fully evaluated in every iteration of [`improve`].
const SHORT_LIST: usize = 8;

/// Relative squared singular value that counts as zero: positions on whole increments make exact dependences look like weak ones of 1e-7 to 1e-6. An
/// unknown that is 100 000 times less certain than the rest is not measurable.
const LOST: f64 = 1e-10;

/// Weight of a reading of 1 rad, mm.
const MM_PER_RAD: f64 = 1000.0;

/// The candidates for the first measurement that raise the smallest singular value of all measurements most, selected one by one: indices into
/// `candidates`.
#[must_use]
pub fn improve(
    machine: &Machine,
    start: &ErrorModel,
    parameters: &[impl Clone + Into<Parameter>],
    data: &[DataSet],
    candidates: &[Observation],
    count: usize,
) -> Vec<usize> {
    let design = Design::new(machine, data, parameters);
    let width = design.columns.len();
    let mut normal = DMatrix::<f64>::zeros(width, width);
    for row in factors(&design, start) {
        let row = DVector::from_vec(row);
        normal.ger(1.0, &row, &row, 1.0);
    }
    let mut sets: Vec<(usize, Vec<DVector<f64>>)> = Vec::new();
    // Without readings all measurements still have their columns.
    let bare = |set: &DataSet| DataSet { observations: Vec::new(), lengths: Vec::new(), ..set.clone() };
    let mut single: Vec<DataSet> = data.iter().map(bare).collect();
    for (number, candidate) in candidates.iter().enumerate() {
        if let Some(first) = single.first_mut() {
            first.observations = vec![*candidate];
        }
        let design = Design::new(machine, &single, parameters);
        sets.push((number, factors(&design, start).into_iter().map(DVector::from_vec).collect()));
    }
    // One scale for all iterations: that of all possible readings.
    let mut scale = DVector::from_fn(width, |column, _| normal[(column, column)]);
    for row in sets.iter().flat_map(|(_, rows)| rows) {
        for (sum, factor) in scale.iter_mut().zip(row.iter()) {
            *sum += factor * factor;
        }
    }
    // Unknowns without any effect stay unidentifiable for every selection.
    let felt: Vec<usize> = (0..width).filter(|&column| scale[column] > 0.0).collect();
    let scale: Vec<f64> = felt.iter().map(|&column| 1.0 / scale[column].sqrt()).collect();
    let scaled = |row: &DVector<f64>| DVector::from_fn(felt.len(), |place, _| row[felt[place]] * scale[place]);
    normal = DMatrix::from_fn(felt.len(), felt.len(), |row, column| {
        normal[(felt[row], felt[column])] * scale[row] * scale[column]
    });
    for row in sets.iter_mut().flat_map(|(_, rows)| rows) {
        *row = scaled(row);
    }
    let mut chosen = Vec::new();
    for _ in 0..count.min(candidates.len()) {
        let weak = weakest(&normal);
        let mut ranked: Vec<(f64, usize)> = sets
            .iter()
            .enumerate()
            .map(|(place, (_, rows))| {
                let gain = rows.iter().flat_map(|row| weak.iter().map(|direction| direction.dot(row).powi(2)));
                (gain.sum::<f64>(), place)
            })
            .collect();
        ranked.sort_by(|one, other| other.0.total_cmp(&one.0).then(one.1.cmp(&other.1)));
        let with = |place: usize| {
            let mut next = normal.clone();
            for row in sets.get(place).map(|(_, rows)| rows.as_slice()).unwrap_or_default() {
                next.ger(1.0, row, row, 1.0);
            }
            next
        };
        let best = ranked
            .iter()
            .take(SHORT_LIST)
            .map(|&(_, place)| {
                let next = with(place);
                let (lost, least) = worth(&next);
                (lost, least, place, next)
            })
            .min_by(|one, other| one.0.cmp(&other.0).then(other.1.total_cmp(&one.1)));
        let Some((_, _, place, next)) = best else { break };
        normal = next;
        chosen.push(sets.remove(place).0);
    }
    chosen
}

/// The number of unidentifiable directions, and the squared smallest singular value of the others.
fn worth(normal: &DMatrix<f64>) -> (usize, f64) {
    let values = normal.symmetric_eigenvalues();
    let limit = values.max() * LOST;
    let lost = values.iter().filter(|&&value| value <= limit).count();
    let least = values.iter().copied().filter(|&value| value > limit).fold(f64::INFINITY, f64::min);
    (lost, least)
}

/// The unidentifiable directions, or the least certain one.
fn weakest(normal: &DMatrix<f64>) -> Vec<DVector<f64>> {
    let system = normal.clone().symmetric_eigen();
    let limit = (system.eigenvalues.max() * LOST).max(system.eigenvalues.min());
    let columns = system.eigenvalues.iter().zip(system.eigenvectors.column_iter());
    columns.filter(|&(&value, _)| value <= limit).map(|(_, column)| column.into_owned()).collect()
}

fn factors(design: &Design<'_>, start: &ErrorModel) -> Vec<Vec<f64>> {
    let values = vec![0.0; design.columns.len()];
    let mut rows = Vec::new();
    design.walk_exact(start, &values, |line, row| {
        // 1 µrad has the weight of 1 µm.
        let weight = if line.is_angle { MM_PER_RAD } else { 1.0 };
        rows.push(row.iter().map(|factor| factor * weight).collect());
    });
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::bench;
    use ncfix_model::ParameterName;

    #[test]
    fn the_weakest_direction_is_the_one_told_worst_or_all_that_are_lost() {
        let of = |squares: &[f64]| {
            let found = weakest(&DMatrix::from_diagonal(&DVector::from_row_slice(squares)));
            found.iter().map(|direction| direction.iter().map(|value| value.abs()).collect()).collect::<Vec<Vec<f64>>>()
        };
        assert_eq!(of(&[4.0, 1.0, 9.0]), [[0.0, 1.0, 0.0]]);
        let mut lost = of(&[0.0, 2.0, 1e-11]);
        lost.sort_by(|one, other| other[0].total_cmp(&one[0]));
        assert_eq!(lost, [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    }

    #[test]
    fn what_has_been_measured_counts_in_units_of_what_could_be() {
        let machine = bench::machine();
        // The slope of X is determined by one reading at 500 mm, and possibly another one; that of Y by three at 10 mm, and possibly a fourth.
        let rows = "X,Y,Z,component,value_um,run\n500,0,0,EXX,0,1\n0,10,0,EYY,0,1\n0,10,0,EYY,0,2\n0,10,0,EYY,0,3\n";
        let data = bench::table(&machine, rows, "[measurement]\nkind = \"direct\"\n");
        let candidates = [data.observations[1], data.observations[0]];
        let names: Vec<ParameterName> = ["EXX1", "EYY1"].map(|name| name.parse().unwrap()).to_vec();
        // X has 1/2 of its possible information, Y has 3/4.
        assert_eq!(improve(&machine, &ErrorModel::default(), &names, &[data], &candidates, 1), [1]);
    }
}
