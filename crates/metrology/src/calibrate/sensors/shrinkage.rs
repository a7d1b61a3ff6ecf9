//! Protection of the coefficients against sensors that read wrong.

use nalgebra::{DMatrix, DVector};

use super::subset::Products;

/// Coefficients that are smaller than those of least squares, so that a sensor that reads wrong has less effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shrinkage {
    /// Ridge for this reading error of every sensor, K; 0 for none.
    ReadingError(f64),
    /// Regression on this number of principal components of the temperature rises.
    Components(usize),
}

/// Coefficients of a regression on the first principal components of the temperature rises, µm/K. All rises are in kelvin, so that a component is a
/// distribution of temperatures, and those with a small variance are left out. The second value is the number of components that are used.
pub(super) fn of_components(part: &Products, lengths: &DVector<f64>, count: usize) -> (DVector<f64>, usize) {
    let gram = DMatrix::from_fn(lengths.len(), lengths.len(), |i, j| part.columns[(i, j)] * lengths[i] * lengths[j]);
    let moments = part.values.component_mul(lengths);
    let parts = gram.symmetric_eigen();
    let mut order: Vec<usize> = (0..lengths.len()).collect();
    order.sort_by(|&a, &b| parts.eigenvalues[b].total_cmp(&parts.eigenvalues[a]));
    let (mut out, mut used) = (DVector::zeros(lengths.len()), 0);
    for &at in order.iter().take(count).filter(|&&at| parts.eigenvalues[at] > 0.0) {
        let direction = parts.eigenvectors.column(at);
        out.axpy(direction.dot(&moments) / parts.eigenvalues[at], &direction, 1.0);
        used += 1;
    }
    (out, used)
}
