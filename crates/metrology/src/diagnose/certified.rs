//! Contribution of certificates to the amounts of findings: the amounts that a fit finds in the changes of the readings by one standard uncertainty.

use super::search::{Field, Weights};
use crate::measure::certificate::changes;

/// Changes of the amounts of all columns by one standard uncertainty of each certificate.
pub(super) fn moves(field: &Field<'_, '_>, weights: &Weights, columns: &[Vec<f64>], memory: f64) -> Vec<Vec<f64>> {
    let scene = field.scene;
    let of = |sets: Vec<Vec<[f64; 3]>>| {
        let shift = |item: &super::scene::SceneReading| {
            let row = scene.rows.get(item.row)?;
            sets.get(row.set)?.get(row.number)?.get(item.value).copied()
        };
        let values: Vec<f64> = scene.items.iter().map(|item| shift(item).unwrap_or(0.0)).collect();
        let mut series = field.series(weights, &[], memory);
        series.set_values(&values);
        series.amounts(columns).0
    };
    changes(scene.machine, scene.sets).into_iter().map(of).collect()
}
