//! Interval of the errors of a run, from the uncertainty of its machine.

use crate::machine::Machine;
use ncfix_base::units::mm_from_um;
use ncfix_model::Model;
use ncfix_model::uncertainty::{unknown_of, variations};
use ncfix_path::path::{self, ErrorPlace};
use ncfix_report::prediction::PredictionReport;

/// The interval of the errors at these places of a run; `None` on a machine without errors, whose programs stay as they are.
pub(crate) fn of_run(chosen: &Machine, model: &Model, places: &[ErrorPlace]) -> Option<PredictionReport> {
    if model.is_empty() || places.is_empty() {
        return None;
    }
    let Some(uncertainty) = &chosen.machine.uncertainty else { return Some(PredictionReport::of(None, Vec::new())) };
    // Each variation touches its zero offsets anew.
    let mut other = chosen.clone();
    let varied: Vec<Model> = variations(&chosen.machine, &chosen.errors, uncertainty)
        .into_iter()
        .map(|errors| {
            other.errors = errors;
            other.model()
        })
        .collect();
    let unexplained_mm = mm_from_um(uncertainty.unexplained_um.unwrap_or(0.0));
    let found = path::predict(places, model, &varied, unexplained_mm);
    Some(PredictionReport::of(found.as_ref(), unknown_of(&chosen.errors, uncertainty)))
}
