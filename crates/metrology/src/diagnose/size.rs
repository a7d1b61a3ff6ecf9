//! Size of a finding in the usual form: a reversal value, an amplitude, a slope or the range over the measured travel.

use super::cause::{Candidate, EffectKind, Term, body_sense, setup};
use super::row::SceneRow;
use super::scene::{Scene, Through};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::units::{um_from_mm, urad_from_rad};

/// Half width of an interval of 95 % of a normal distribution, in standard deviations.
pub(crate) const EXPANDED: f64 = 1.96;
/// mm/s² in m/s², and s in ms.
const THOUSAND: f64 = 1e3;
/// Parts per million: µm/m, µrad.
const MILLION: f64 = 1e6;

/// A size with its unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Size {
    /// Its value.
    pub value: f64,
    /// Its expanded uncertainty (95 %).
    pub u95: f64,
    /// Its unit: `um`, `urad`, `um/m`, `ms` …
    pub unit: &'static str,
}

/// Amounts of the columns of a candidate, and their covariance.
#[derive(Clone, Debug, Default)]
pub struct Amounts {
    /// Amounts in mm or rad, per unit of the driver.
    pub values: Vec<f64>,
    /// Covariance by rows.
    pub covariance: Vec<Vec<f64>>,
}

impl Amounts {
    /// Returns the value and standard deviation of a linear form of the amounts.
    pub(super) fn form(&self, factors: &[f64]) -> (f64, f64) {
        let value = self.values.iter().zip(factors).map(|(value, factor)| value * factor).sum();
        let mut variance = 0.0;
        for (row, one) in self.covariance.iter().zip(factors) {
            variance += row.iter().zip(factors).map(|(entry, other)| entry * one * other).sum::<f64>();
        }
        (value, variance.max(0.0).sqrt())
    }

    /// The same amounts with larger uncertainties.
    pub(super) fn widened(mut self, times: f64) -> Amounts {
        self.covariance.iter_mut().flatten().for_each(|entry| *entry *= times * times);
        self
    }

    /// Expanded uncertainty of one amount.
    #[must_use]
    pub fn u95(&self, column: usize) -> f64 {
        EXPANDED * self.covariance.get(column).and_then(|row| row.get(column)).copied().unwrap_or(0.0).max(0.0).sqrt()
    }
}

/// Returns the weights of the columns of a candidate at a row.
pub(super) fn weights_at(candidate: &Candidate, row: &SceneRow) -> Vec<f64> {
    candidate.columns.iter().map(|parts| parts.first().map_or(0.0, |(_, weight)| weight.of(row))).collect()
}

/// True if its deviation is an angle.
pub(crate) fn is_angle(candidate: &Candidate) -> bool {
    match candidate.columns.first().and_then(|parts| parts.first()) {
        Some((Through::Component(name), _)) => name.direction.is_rotation(),
        Some((Through::Reading(is_angle), _)) => *is_angle,
        _ => false,
    }
}

/// Returns the size of a candidate with these amounts, over the rows of the measurements used.
pub(super) fn size(candidate: &Candidate, amounts: &Amounts, scene: &Scene<'_>, used: usize) -> Size {
    let is_angle = is_angle(candidate);
    let (micro, unit) = if is_angle { (urad_from_rad(1.0), "urad") } else { (um_from_mm(1.0), "um") };
    let first: Vec<f64> = (0..amounts.values.len()).map(|k| f64::from(u8::from(k == 0))).collect();
    let plain = |factor: f64, unit| {
        let (value, sigma) = amounts.form(&first);
        Size { value: factor * value, u95: EXPANDED * factor.abs() * sigma, unit }
    };
    let rows = || scene.rows.iter().filter(|row| row.set < used);
    let of = |factors: &[f64], factor: f64, unit| {
        let (value, sigma) = amounts.form(factors);
        Size { value: factor * value, u95: EXPANDED * factor.abs() * sigma, unit }
    };
    let range = || range(candidate, amounts, &mut rows());
    let single = amounts.values.len() == 1;
    let is_bow = candidate.term == Term::None;
    if let Some((count, unit @ "chords")) = candidate.constant {
        return Size { value: count, u95: 0.5, unit };
    }
    if matches!(candidate.constant, Some((_, "lobes"))) {
        // Uses the plane with the largest number.
        let of = |first: usize| amplitude(amounts, first, micro, unit);
        let all = (0..amounts.values.len()).step_by(2).map(of);
        return all.max_by(|a, b| a.value.total_cmp(&b.value)).unwrap_or_default();
    }
    match candidate.cause.effect {
        EffectKind::Periodic => amplitude(amounts, 0, micro, unit),
        EffectKind::Dynamic if candidate.constant.is_some() => amplitude(amounts, 0, micro, unit),
        // Step from one octant to the next.
        EffectKind::Dynamic if candidate.parameter.is_empty() => {
            let step = plain(micro, unit);
            Size { value: step.value.abs(), ..step }
        }
        EffectKind::Dynamic if candidate.drivers.iter().any(|driver| driver == "feed_mm_min") => {
            plain(MILLION, "um/(m/s2)")
        }
        EffectKind::Location | EffectKind::Earlier => plain(micro, unit),
        EffectKind::Backlash | EffectKind::LateralPlay => {
            // Full reversal value at the place where it is largest.
            let at = peak(candidate, amounts, &mut rows().filter(|row| sense_of(candidate, row) > 0.0));
            of(&at.unwrap_or(first.clone()), 2.0 * micro, unit)
        }
        EffectKind::Motion if single && !is_bow && !is_rotary(candidate) && !is_angle => plain(MILLION, "um/m"),
        EffectKind::Motion if single && is_rotary(candidate) => {
            plain(micro, if is_angle { "urad/rad" } else { "um/rad" })
        }
        EffectKind::Cross if candidate.threshold.is_some() => of(&range(), micro, unit),
        EffectKind::Cross => {
            let [low, high] = corners(candidate, scene, used);
            of(&mixed(candidate, &low, &high), micro, unit)
        }
        EffectKind::Following if candidate.parameter.len() > 1 => {
            // The shrinkage of circles is proportional to the square of the lag.
            let (value, sigma) = amounts.form(&first);
            let lag = value.abs().sqrt();
            let u95 = if lag > 0.0 { EXPANDED * sigma / (2.0 * lag) } else { EXPANDED * sigma.sqrt() };
            Size { value: THOUSAND * lag, u95: THOUSAND * u95, unit: "ms" }
        }
        EffectKind::Delay if candidate.drivers.iter().any(|driver| driver == "t_s") => plain(MILLION, "ppm"),
        EffectKind::ServoMismatch | EffectKind::Following | EffectKind::Delay => plain(THOUSAND, "ms"),
        EffectKind::Probe if candidate.drivers.iter().any(|driver| driver == "feed_mm_min") => plain(THOUSAND, "ms"),
        EffectKind::ThermalDrift => plain(micro, "um/K"),
        // Slope along the axis. Errors are those of the moving body, and a table moves against its coordinate.
        EffectKind::ThermalExpansion => plain(MILLION * sense_along(candidate, scene), "um/(m K)"),
        EffectKind::ThermalSquareness => plain(MILLION, "urad/K"),
        EffectKind::Setup if candidate.cause.name == setup::SCALE.name => {
            plain(MILLION, if candidate.sensor.is_some() { "um/(m K)" } else { "um/m" })
        }
        // Largest value of all set-ups.
        EffectKind::Setup if setup::is_alignment(candidate) => {
            let size = |k: &usize| amounts.values.get(*k).copied().unwrap_or(0.0).abs();
            let most = (0..amounts.values.len()).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0);
            let factors: Vec<f64> = (0..amounts.values.len()).map(|k| f64::from(u8::from(k == most))).collect();
            of(&factors, MILLION, "urad")
        }
        EffectKind::ReversalSpike => plain(micro * sense_along(candidate, scene), unit),
        EffectKind::Motion | EffectKind::Drift => of(&range(), micro, unit),
        _ => of(&peak(candidate, amounts, &mut rows()).unwrap_or(first.clone()), micro, unit),
    }
}

/// Returns 1 if the body that an axis moves moves with its coordinate, −1 if it moves against it.
pub(super) fn sense_along(candidate: &Candidate, scene: &Scene<'_>) -> f64 {
    component_axis(candidate).map_or(1.0, |axis| body_sense(scene, axis))
}

fn amplitude(amounts: &Amounts, first: usize, micro: f64, unit: &'static str) -> Size {
    let [sine, cosine] = [first, first + 1].map(|k| amounts.values.get(k).copied().unwrap_or(0.0));
    let value = sine.hypot(cosine);
    let along = if value > 0.0 { [sine / value, cosine / value] } else { [1.0, 0.0] };
    let (_, sigma) = amounts.form(&[vec![0.0; first], along.to_vec()].concat());
    Size { value: micro * value, u95: EXPANDED * micro * sigma, unit }
}

fn component_axis(candidate: &Candidate) -> Option<Axis> {
    match candidate.columns.first().and_then(|parts| parts.first()) {
        Some((Through::Component(name), _)) => name.axis(),
        _ => None,
    }
}

fn is_rotary(candidate: &Candidate) -> bool {
    component_axis(candidate).is_some_and(Axis::is_rotary)
}

fn sense_of(candidate: &Candidate, row: &SceneRow) -> f64 {
    component_axis(candidate).map_or(1.0, |axis| row.sense_of(axis))
}

/// Returns the weights at the largest deviation.
fn peak(candidate: &Candidate, amounts: &Amounts, rows: &mut dyn Iterator<Item = &SceneRow>) -> Option<Vec<f64>> {
    let of = |row: &SceneRow| weights_at(candidate, row);
    let all = rows.map(of).map(|weights| (amounts.form(&weights).0.abs(), weights));
    all.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, weights)| weights)
}

/// Returns the weights at the highest deviation minus those at the lowest.
fn range(candidate: &Candidate, amounts: &Amounts, rows: &mut dyn Iterator<Item = &SceneRow>) -> Vec<f64> {
    let zero = vec![0.0; amounts.values.len()];
    let mut ends: Option<[(f64, Vec<f64>); 2]> = None;
    for row in rows {
        let weights = weights_at(candidate, row);
        let value = amounts.values.iter().zip(&weights).map(|(a, b)| a * b).sum::<f64>();
        match &mut ends {
            None => ends = Some([(value, weights.clone()), (value, weights)]),
            Some([low, high]) => {
                if value < low.0 {
                    *low = (value, weights);
                } else if value > high.0 {
                    *high = (value, weights);
                }
            }
        }
    }
    ends.map_or(zero, |[low, high]| high.1.iter().zip(&low.1).map(|(high, low)| high - low).collect())
}

/// Returns the rows at the ends of the measured range.
fn corners(candidate: &Candidate, scene: &Scene<'_>, used: usize) -> [Option<SceneRow>; 2] {
    let _ = candidate;
    let mut rows = scene.rows.iter().filter(|row| row.set < used);
    let Some(first) = rows.next() else { return [None, None] };
    let (mut low, mut high) = (first.clone(), first.clone());
    for row in rows {
        for axis in AXES {
            low.position[axis] = low.position[axis].min(row.position[axis]);
            high.position[axis] = high.position[axis].max(row.position[axis]);
        }
    }
    [Some(low), Some(high)]
}

/// Interaction of two axes between the ends of their ranges: a quarter of the difference of the differences.
fn mixed(candidate: &Candidate, low: &Option<SceneRow>, high: &Option<SceneRow>) -> Vec<f64> {
    let axis_of = |name: &String| AXES.into_iter().find(|axis| axis.to_string() == *name);
    let axes: Vec<Axis> = candidate.drivers.iter().filter_map(axis_of).take(2).collect();
    let (Some(low), Some(high), [one, other]) = (low, high, axes.as_slice()) else {
        return vec![1.0; candidate.columns.len()];
    };
    let at = |one_high: bool, other_high: bool| {
        let mut row = low.clone();
        row.position[*one] = if one_high { high } else { low }.position[*one];
        row.position[*other] = if other_high { high } else { low }.position[*other];
        weights_at(candidate, &row)
    };
    let [a, b, c, d] = [at(true, true), at(true, false), at(false, true), at(false, false)];
    (0..candidate.columns.len()).map(|k| (a[k] - b[k] - c[k] + d[k]) / 4.0).collect()
}
