//! Readings with display steps that are large relative to the noise: no error of the machine, but more noise than the instrument has.

use crate::diagnose::scene::Scene;
use crate::measure::data::DataSet;

use super::{DataDefect, DefectCheck, DefectKind, Then, View};

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "steps of a display",
    made_by: "a display or file with few digits",
    shown_by: "all readings are multiples of a step that is large compared with their noise",
    source: "uniform noise of step/√12",
    look,
};

/// Finest step, mm; for angles a thousandth of it, rad.
const FINEST: f64 = 1e-7;
/// Smallest large step, in standard uncertainties.
const WIDE: f64 = 0.8;
/// Minimum number of readings.
const COUNT: usize = 20;

/// RMS noise from the display steps in the readings of a scene, mm or rad: the noise is not less than this.
pub(in crate::diagnose) fn least_noise(scene: &Scene<'_>, is_angle: bool) -> f64 {
    let of = |data: &DataSet| {
        let values: Vec<f64> = data.observations.iter().flat_map(|one| one.values).flatten().collect();
        display_noise(&values, is_angle)
    };
    scene.sets.iter().map(of).fold(0.0, f64::max)
}

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
        let finest = if is_angle { FINEST * 1e-3 } else { FINEST };
        let values: Vec<f64> = data.observations.iter().flat_map(|one| one.values).flatten().collect();
        let Some(step) = step(&values, finest).filter(|step| *step > WIDE * sigma) else { continue };
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

/// RMS noise from the display steps of values, mm or rad: half a step on either side is one value.
pub(super) fn display_noise(values: &[f64], is_angle: bool) -> f64 {
    step(values, if is_angle { FINEST * 1e-3 } else { FINEST }).unwrap_or(0.0) / 12.0_f64.sqrt()
}

/// The largest step that divides all values; `None` if it is not much larger than the finest.
fn step(values: &[f64], finest: f64) -> Option<f64> {
    /// Largest number of finest steps in a value.
    const MOST: f64 = 1e12;
    if values.len() < COUNT {
        return None;
    }
    let mut common = 0_u64;
    let mut kinds = std::collections::BTreeSet::new();
    for value in values {
        let steps = (value / finest).abs();
        if !(steps < MOST && (steps - steps.round()).abs() < 0.02) {
            return None;
        }
        let mut other = steps.round() as u64;
        kinds.insert(other);
        while other != 0 {
            (common, other) = (other, common % other);
        }
        if common == 1 {
            return None;
        }
    }
    // For two numbers any step is possible.
    (kinds.len() > 2).then_some(common as f64 * finest)
}
