//! A symmetric tridiagonal matrix: the likelihood of one set for many scales of the noise, each in a time proportional to its columns.

/// A symmetric tridiagonal matrix, and the products with the readings in its basis.
#[derive(Debug, Default)]
pub(super) struct Tridiagonal {
    pub(super) diagonal: Vec<f64>,
    pub(super) beside: Vec<f64>,
    pub(super) right: Vec<f64>,
}

impl Tridiagonal {
    /// Logarithm of the determinant of the identity plus the matrix times a weight, and the explained square; `None` if the sum is not positive
    /// definite.
    pub(super) fn at(&self, weight: f64) -> Option<(f64, f64)> {
        let (mut log, mut explained) = (0.0, 0.0);
        let (mut pivot, mut carried) = (1.0, 0.0);
        for (k, (own, right)) in self.diagonal.iter().zip(&self.right).enumerate() {
            let beside = k.checked_sub(1).and_then(|last| self.beside.get(last)).map_or(0.0, |beside| weight * beside);
            let share = beside / pivot;
            pivot = 1.0 + weight * own - share * beside;
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            carried = weight * right - share * carried;
            log += pivot.ln();
            explained += carried * carried / pivot;
        }
        Some((log, explained))
    }
}
