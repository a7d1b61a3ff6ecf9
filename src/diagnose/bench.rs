//! Scenes for tests of this room: a machine without errors and tables as people write them.

use super::cause::{CAUSES, Candidate, Effect, Weight};
use super::row::Row;
use super::scene::{Scene, Through};
use super::search::Weights;
use crate::machine::Machine;
use crate::measure::data::{DataSet, load};
use crate::model::{ErrorModel, file};
use crate::source::{FileId, Source};

fn source(name: &str, text: &str) -> Source {
    Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap()
}

/// Three axes of which each moves the tool along a direction of F.
pub(super) fn machine() -> Machine {
    let mut text = "[machine]\nname = \"bench\"\ntopology = \"wFXYZSt\"\n".to_owned();
    for (letter, direction) in [("X", "[1, 0, 0]"), ("Y", "[0, 1, 0]"), ("Z", "[0, 0, 1]")] {
        text += &format!("[axis.{letter}]\ndirection = {direction}\ntravel_mm = [-1000, 1000]\n");
    }
    file::load(&source("bench.toml", &text)).0.unwrap().0
}

/// A table with its description.
pub(super) fn table(machine: &Machine, rows: &str, description: &str) -> DataSet {
    let (data, findings) = load("t", &source("t.csv", rows), &source("t.toml", description), machine);
    data.unwrap_or_else(|| panic!("{findings:#?}"))
}

/// Displacements at some positions of X, which are all zero, with more columns of each row.
pub(super) fn along_x(machine: &Machine, more: &str, rows: &[(f64, &str)]) -> DataSet {
    let mut text = format!("X,Y,Z,dx_um,dy_um,dz_um{more}\n");
    for (x, cells) in rows {
        text += &format!("{x},0,0,0,0,0{cells}\n");
    }
    table(machine, &text, "[measurement]\nkind = \"displacement\"\nsigma_um = 1\n")
}

/// Readings along X at every millimetre, µm.
pub(super) fn reads_along_x(machine: &Machine, um: &[f64]) -> DataSet {
    let mut text = "X,Y,Z,dx_um\n".to_owned();
    for (x, um) in um.iter().enumerate() {
        text += &format!("{x},0,0,{um}\n");
    }
    table(machine, &text, "[measurement]\nkind = \"displacement\"\nsigma_um = 1\n")
}

/// Held against a model without errors.
pub(super) fn scene<'a>(machine: &'a Machine, sets: &'a [DataSet]) -> Scene<'a> {
    Scene::new(machine, &ErrorModel::default(), sets).unwrap()
}

/// A candidate with one column.
pub(super) fn candidate(
    effect: Effect,
    through: Through,
    weight: impl Fn(&Row) -> f64 + Send + Sync + 'static,
) -> Candidate {
    let cause = CAUSES.iter().find(|cause| cause.effect == effect).unwrap();
    Candidate::one(cause, "X", through, Weight::new(weight))
}

/// One reading counts as another.
pub(super) fn even(scene: &Scene<'_>) -> Weights {
    Weights { items: vec![1.0; scene.items.len()], series: vec![0; scene.items.len()] }
}
