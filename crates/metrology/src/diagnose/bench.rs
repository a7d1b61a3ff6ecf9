//! Fixtures for unit tests of the diagnosis: tables of a machine without errors, and candidates.

use super::cause::{BUILT_IN, Candidate, EffectKind, Weight};
use super::row::SceneRow;
use super::scene::{Scene, Through};
use super::search::Weights;
pub(crate) use crate::calibrate::bench::{machine, table, turning};
use crate::measure::data::DataSet;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

/// Displacements at some positions of X, all zero, with additional columns.
pub(super) fn along_x(machine: &Machine, more: &str, rows: &[(f64, &str)]) -> DataSet {
    let mut text = format!("X,Y,Z,dx_um,dy_um,dz_um{more}\n");
    for (x, cells) in rows {
        text += &format!("{x},0,0,0,0,0{cells}\n");
    }
    table(machine, &text, "[measurement]\nkind = \"displacement\"\nsigma_um = 1\n")
}

/// Readings along X at steps of a tenth of a millimeter, µm.
pub(crate) fn reads_along_x(machine: &Machine, um: &[f64]) -> DataSet {
    let mut text = "X,Y,Z,dx_um\n".to_owned();
    for (place, um) in um.iter().enumerate() {
        text += &format!("{}.{},0,0,{um}\n", place / 10, place % 10);
    }
    table(machine, &text, "[measurement]\nkind = \"displacement\"\nsigma_um = 1\n")
}

/// Linearizes the readings about a model without errors.
pub(crate) fn scene<'a>(machine: &'a Machine, sets: &'a [DataSet]) -> Scene<'a> {
    Scene::new(machine, &ErrorModel::default(), sets).unwrap()
}

/// Returns a candidate with one column.
pub(super) fn candidate(
    effect: EffectKind,
    through: Through,
    weight: impl Fn(&SceneRow) -> f64 + Send + Sync + 'static,
) -> Candidate {
    let cause = BUILT_IN.iter().find(|cause| cause.effect == effect).unwrap();
    Candidate::one(cause, "X", through, Weight::new(weight))
}

/// Returns weights that are equal for all readings.
pub(super) fn even(scene: &Scene<'_>) -> Weights {
    Weights { items: vec![1.0; scene.items.len()], series: vec![0; scene.items.len()] }
}
