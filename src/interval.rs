//! Interval of the errors of a run, from the uncertainty of its machine.

use crate::datum;
use crate::head::HeadInUse;
use crate::machine::Machine;
use ncfix_base::units::mm_from_um;
use ncfix_machine::machine::Uncertainty;
use ncfix_model::Model;
use ncfix_model::uncertainty::{unknown_of, variations};
use ncfix_path::path::{self, ErrorPlace, Spread};
use ncfix_report::prediction::PredictionReport;

/// The interval of the errors of a run, with its errors on the model before and after, and some of their places; `None` on a machine without errors, whose programs stay as they are.
pub(crate) fn of_run(
    heads: &[HeadInUse<'_>],
    model: &Model,
    whole: [&Spread; 2],
    places: &[ErrorPlace],
) -> Option<PredictionReport> {
    let [first, others @ ..] = heads else { return None };
    if !model.has_errors() || places.is_empty() {
        return None;
    }
    let chosen = &*first.chosen;
    let Some(uncertainty) = &chosen.machine.uncertainty else { return Some(PredictionReport::of(None, Vec::new())) };
    let varied = match others {
        [] => of_causes(chosen, uncertainty),
        _ => {
            let mut by_head: Vec<Vec<Model>> = heads.iter().map(|one| varied(&one.chosen, uncertainty)).collect();
            // Each cause varies all heads; the parameters of a head alone would be a cause of their own.
            if by_head.iter().any(|models| models.len() != by_head[0].len()) {
                return Some(PredictionReport::of(None, unknown_of(&chosen.errors, uncertainty)));
            }
            let count = by_head[0].len();
            let most = heads.iter().map(|one| usize::from(one.head)).max().unwrap_or(0);
            let of_cause = |_| {
                let mut models: Vec<Model> = by_head.iter_mut().filter_map(Vec::pop).collect();
                let place_of = |head: usize| heads.iter().position(|one| usize::from(one.head) == head).unwrap_or(0);
                let others = (1..=most).map(|head| models[place_of(head)].clone()).collect();
                models.swap_remove(place_of(0)).with_heads(others)
            };
            (0..count).map(of_cause).collect()
        }
    };
    let unexplained_mm = mm_from_um(uncertainty.unexplained_um.unwrap_or(0.0));
    let mut found = path::predict(places, whole, model, &varied, unexplained_mm);
    // Nothing says how probable a length is: the interval contains those of all.
    let lengths = if others.is_empty() { datum::of_other_lengths(chosen) } else { Vec::new() };
    for other in lengths {
        let (touched, causes) = (other.model(), of_causes(&other, uncertainty));
        let wide = path::predict_from(places, whole, [model, &touched], &causes, unexplained_mm);
        found = match (found, wide) {
            (Some(own), Some(wide)) => Some(own.including(&wide)),
            (own, None) => own,
            (None, wide) => wide,
        };
    }
    Some(PredictionReport::of(found.as_ref(), unknown_of(&chosen.errors, uncertainty)))
}

/// The models after one standard deviation of each cause, with that of a touch from an unknown side.
fn of_causes(chosen: &Machine, uncertainty: &Uncertainty) -> Vec<Model> {
    let mut models = varied(chosen, uncertainty);
    models.extend(datum::of_unknown_sides(chosen));
    models
}

/// The models after one standard deviation of each cause. Each touches its zero offsets anew.
fn varied(chosen: &Machine, uncertainty: &Uncertainty) -> Vec<Model> {
    let mut other = chosen.clone();
    let models = variations(&chosen.machine, &chosen.errors, uncertainty).into_iter().map(|errors| {
        other.errors = errors;
        other.model()
    });
    models.collect()
}
