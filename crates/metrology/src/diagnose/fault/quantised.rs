//! Readings with display steps that are large relative to the noise: no error of the machine, but more noise than the instrument has.

use crate::measure::display;

use super::{DataDefect, DefectCheck, DefectKind, Then, View};

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "steps of a display",
    made_by: "a display or file with few digits",
    shown_by: "all readings are multiples of a step that is large compared with their noise",
    source: "uniform noise of step/√12",
    look,
};

/// Smallest large step, in standard uncertainties.
const WIDE: f64 = 0.8;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, data) in view.sets() {
        let own = |item: &&crate::diagnose::scene::SceneReading| {
            view.scene.rows.get(item.row).is_some_and(|row| row.set == set)
        };
        let Some(first) = view.scene.items.iter().find(own) else { continue };
        // Lengths and angles in one file have different steps.
        if view.scene.items.iter().filter(own).any(|item| item.is_angle != first.is_angle) {
            continue;
        }
        let (sigma, is_angle) = (first.sigma, first.is_angle);
        let values: Vec<f64> = data.observations.iter().flat_map(|one| one.values).flatten().collect();
        let Some(step) = display::step(&values, is_angle).filter(|step| *step > WIDE * sigma) else { continue };
        let stated = if is_angle { data.sigma_rad } else { data.sigma }.is_some();
        let (micro, unit) = if is_angle { (1e6, "µrad") } else { (1e3, "µm") };
        out.push(DataDefect {
            kind: DefectKind::Quantised,
            set,
            name: data.name.clone(),
            what: "steps of the display".into(),
            rows: [0, data.observations.len().saturating_sub(1)],
            evidence: format!(
                "all {} readings are multiples of {:.4} {unit}{}",
                values.len(),
                step * micro,
                if stated {
                    format!(", which is {:.1} times their standard uncertainty", step / sigma)
                } else {
                    String::new()
                }
            ),
            then: Then::MoreNoise(step / 12.0_f64.sqrt()),
        });
    }
}
