//! Readings by a factor: millimetres in a column of micrometres, micrometres in one of millimetres, inches.

use super::readings::WeighedReadings;
use super::{DataDefect, DefectCheck, DefectKind, Then, View};

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "factor of units",
    made_by: "a column in another unit than its name says",
    shown_by: "readings go with the model but for a factor, and their noise is as far from that of the instrument; without errors that the model knows, \
               the noise alone",
    source: "parsing and units first; ISO 230-1 has micrometres",
    look,
};

/// Factors and what they are.
const FACTORS: [(f64, &str, &str); 4] = [
    (1e-3, "factor 0.001", "millimetres in a column of micrometres"),
    (1e3, "factor 1000", "a thousandth of its unit"),
    (1.0 / 25.4, "factor 1/25.4", "thousandths of an inch in a column of micrometres"),
    (25.4, "factor 25.4", "micrometres taken for thousandths of an inch and converted"),
];
/// The prediction is at least so large, in units of the noise, to be evidence.
const SIZE: f64 = 2.0;
/// And explains so much.
const SHARE: f64 = 0.3;
/// A gain is that of a factor within this, as a logarithm.
const NEAR: f64 = 0.3;
/// The noise is, as a logarithm, where there is a prediction.
const NOISE_NEAR: f64 = 2.3;
/// And where there is none.
const NOISE_ALONE: f64 = 0.2;
/// The prediction, where it and the noise together are evidence.
const SIZE_BOTH: f64 = 0.7;
/// And the noise.
const NOISE_BOTH: f64 = 1.2;
/// No instrument is so much better or worse than is said of it.
const INCREDIBLE: f64 = 4.6;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, data) in view.sets() {
        let (Some(readings), Some(trail)) = (WeighedReadings::new(view.scene, set), view.trails.get(set)) else {
            continue;
        };
        let matched = readings.matched(None);
        let noise = trail.noise_ratio();
        // Where neighbours differ by more than their noise, what the model leaves of them by this factor.
        let rest = readings.left_with(None, matched.gain).sqrt();
        let near = |value: f64, factor: f64| (value / factor).ln().abs();
        // Without a stated σ nothing says what the noise should be.
        let stated = noise.filter(|_| data.sigma.is_some() || data.sigma_rad.is_some());
        let reads_angles = data.observations.iter().any(crate::measure::data::Observation::is_angle);
        for (factor, what, means) in FACTORS {
            // Readings that are too small lie below any uncertainty that is assumed.
            let is_small = stated.is_none() && factor < 1.0 && !reads_angles;
            let size = matched.size / noise.filter(|_| is_small).unwrap_or(1.0);
            let by_model = size > SIZE
                && matched.share > SHARE
                && matched.gain > 0.0
                && near(matched.gain, factor) < NEAR
                && stated.is_none_or(|noise| near(noise, factor).min(near(rest, factor)) < NOISE_NEAR);
            // Where the model says little, both together.
            let by_both = size > SIZE_BOTH
                && matched.share > SHARE
                && matched.gain > 0.0
                && near(matched.gain, factor) < NEAR
                && stated.is_some_and(|noise| near(noise, factor) < NOISE_BOTH);
            let is_incredible = factor.ln().abs() > INCREDIBLE;
            let within = if is_incredible { 1.0 } else { NOISE_ALONE };
            let by_noise =
                (is_incredible || matched.size < SIZE) && stated.is_some_and(|noise| near(noise, factor) < within);
            // Without a stated σ: no instrument has noise of some nanometres, and no machine is that good.
            let by_size = is_small && readings.are_tiny() && noise.is_some_and(|noise| noise > 0.0) && is_incredible;
            if !(by_model || by_noise || by_both || by_size) {
                continue;
            }
            let of_noise = stated.map_or(String::new(), |noise| {
                format!("; their noise is {noise:.2e} times the uncertainty that the description states")
            });
            let evidence = if by_model || by_both {
                format!(
                    "the readings are {:.3e} times what the model says and {:.0} % of their squares go with it{of_noise}",
                    matched.gain,
                    matched.share * 100.0
                )
            } else {
                let tiny =
                    if by_size { "; all are below 0.05 µm beside the set-ups, which no machine is" } else { "" };
                format!("the model knows too little here to tell{of_noise}{tiny}")
            };
            out.push(DataDefect {
                kind: DefectKind::Unit,
                set,
                name: data.name.clone(),
                what: what.into(),
                rows: [0, data.observations.len().saturating_sub(1)],
                evidence: format!("{evidence}: {means}"),
                then: Then::Refuse,
            });
            break;
        }
    }
}
