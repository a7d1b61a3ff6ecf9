//! Readings with a wrong factor: millimeters in a column of micrometers, micrometers in one of millimeters, inches.

use super::readings::WeighedReadings;
use super::{DataDefect, DefectCheck, DefectKind, Then, View};
use crate::measure::kind::Measurand;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "factor of units",
    made_by: "a column in another unit than its name states",
    shown_by: "readings follow the model except for a factor, and their noise differs from that of the instrument by this factor; if the model has no errors, \
               the noise alone",
    source: "parsing and units first; ISO 230-1 has micrometers",
    look,
};

/// Factors and their descriptions.
const FACTORS: [(f64, &str, &str); 4] = [
    (1e-3, "factor 0.001", "millimeters in a column of micrometers"),
    (1e3, "factor 1000", "a thousandth of its unit"),
    (1.0 / 25.4, "factor 1/25.4", "thousandths of an inch in a column of micrometers"),
    (25.4, "factor 25.4", "micrometers taken for thousandths of an inch and converted"),
];

/// Returns the unit in which readings with this factor seem to be.
fn seems(factor: f64, is_angle: bool) -> &'static str {
    match (factor < 1.0, factor.ln().abs() > INCREDIBLE) {
        (true, true) if is_angle => "in milliradians",
        (true, true) => "in millimeters",
        (false, true) if is_angle => "in nanoradians",
        (false, true) => "in nanometers",
        (true, false) => "in thousandths of an inch",
        (false, false) => "converted from thousandths of an inch",
    }
}

/// Formats a ratio as a multiple or a fraction: `1000 times`, `1/1000 of`.
fn multiple(ratio: f64) -> String {
    if ratio < 1.0 { format!("1/{:.0} of", 1.0 / ratio) } else { format!("{ratio:.0} times") }
}

/// Smallest prediction that is evidence, in units of the noise.
const SIZE: f64 = 2.0;
/// Smallest share of the squares that the prediction explains.
const SHARE: f64 = 0.3;
/// Tolerance of the gain relative to a factor, as a natural logarithm.
const NEAR: f64 = 0.3;
/// Tolerance of the noise, as a natural logarithm, if there is a prediction.
const NOISE_NEAR: f64 = 2.3;
/// Tolerance of the noise without a prediction.
const NOISE_ALONE: f64 = 0.2;
/// Smallest prediction if it and the noise together are evidence,
const SIZE_BOTH: f64 = 0.7;
/// and the tolerance of the noise in that case.
const NOISE_BOTH: f64 = 1.2;
/// Largest plausible error of a stated uncertainty, as a natural logarithm.
const INCREDIBLE: f64 = 4.6;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, data) in view.sets() {
        let (Some(readings), Some(trail)) = (WeighedReadings::new(view.scene, set), view.trails.get(set)) else {
            continue;
        };
        let matched = readings.matched(None);
        let noise = trail.noise_ratio();
        // If neighbors differ by more than their noise, the residual of the model with this factor.
        let rest = readings.left_with(None, matched.gain).sqrt();
        let near = |value: f64, factor: f64| (value / factor).ln().abs();
        // Without a stated σ the expected noise is unknown.
        let stated = noise.filter(|_| data.sigma.is_some() || data.sigma_rad.is_some());
        let reads_angles = data.observations.iter().any(crate::measure::data::Observation::is_angle);
        for (factor, what, means) in FACTORS {
            // Readings that are too small are below any assumed uncertainty.
            let is_small = stated.is_none() && factor < 1.0 && !reads_angles;
            let size = matched.size / noise.filter(|_| is_small).unwrap_or(1.0);
            let by_model = size > SIZE
                && matched.share > SHARE
                && matched.gain > 0.0
                && near(matched.gain, factor) < NEAR
                && stated.is_none_or(|noise| near(noise, factor).min(near(rest, factor)) < NOISE_NEAR);
            // If the prediction is small, gain and noise together.
            let by_both = size > SIZE_BOTH
                && matched.share > SHARE
                && matched.gain > 0.0
                && near(matched.gain, factor) < NEAR
                && stated.is_some_and(|noise| near(noise, factor) < NOISE_BOTH);
            let is_incredible = factor.ln().abs() > INCREDIBLE;
            let within = if is_incredible { 1.0 } else { NOISE_ALONE };
            // Between the rows of a plate the errors of the machine jump. Without repeats they would count as noise.
            let is_of_jumps = !is_incredible && !trail.is_repeated && data.kind.measurand == Measurand::Displacement;
            let by_noise = (is_incredible || matched.size < SIZE)
                && !is_of_jumps
                && stated.is_some_and(|noise| near(noise, factor) < within);
            // Without a stated σ: no instrument has noise of some nanometers, and no machine is that accurate.
            let by_size = is_small
                && !data.is_unit_stated
                && readings.are_tiny()
                && noise.is_some_and(|noise| noise > 0.0)
                && is_incredible;
            if !(by_model || by_noise || by_both || by_size) {
                continue;
            }
            let sigma = if data.sigma.is_some() { "sigma_um" } else { "sigma_urad" };
            let of_noise = stated.map(|noise| format!("their noise is {} `{sigma}`", multiple(noise)));
            let evidence = if by_model || by_both {
                let of_noise = of_noise.map_or_else(String::new, |text| format!("; {text}"));
                format!(
                    "the readings are {:.3e} times the prediction, which explains {:.0} % of their sum of squares{of_noise}: {means}",
                    matched.gain,
                    matched.share * 100.0
                )
            } else {
                let tiny = "all are below 0.05 µm after the set-ups, less than the errors of any machine";
                let reasons: Vec<&str> = of_noise.as_deref().into_iter().chain(by_size.then_some(tiny)).collect();
                format!("the readings seem to be {}: {}", seems(factor, reads_angles), reasons.join("; "))
            };
            out.push(DataDefect {
                kind: DefectKind::Unit,
                set,
                name: data.name.clone(),
                what: what.into(),
                rows: [0, data.observations.len().saturating_sub(1)],
                evidence,
                then: Then::Refuse,
            });
            break;
        }
    }
}
