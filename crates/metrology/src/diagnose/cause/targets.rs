//! Motion errors of a linear axis with a value of their own at each target position: tables, as measured by positioning tests of ISO 230-2.
//!
//! A curve that rises and falls from target to target follows no polynomial of low degree. It would count as noise and hide a reversal value.

use super::motion::CAUSE as MOTION;
use super::{Candidate, Cause, Weight};
use crate::diagnose::scene::{Scene, Through};
use ncfix_base::geometry::Axis;
use ncfix_model::name::{DIRECTIONS, ErrorName};

pub(in crate::diagnose) const CAUSE: Cause = Cause { name: "error of an axis by target", propose, ..MOTION };

/// Number of targets. Fewer are fitted by a polynomial, more by a search for curves (ISO 230-2 requires at least 5 per meter).
const TARGETS: std::ops::RangeInclusive<usize> = 5..=25;
/// Average number of rows at a target: repeats separate an error from noise.
const ROWS: usize = 4;
/// Largest distance between repeats of one target, as a share of the travel.
const SHARE: f64 = 1e-3;

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for axis in super::linear(scene) {
        let Some(targets) = targets(scene, axis) else { continue };
        for component in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
            let through = Through::Component(component);
            let mut one = Candidate::one(&CAUSE, component, through, Weight::new(|_| 0.0)).driven_by(&[&axis]);
            one.columns.clear();
            // The value at the first target is zero: it belongs to the zero of the axis.
            for place in 1..targets.len() {
                let own = targets.clone();
                one.columns.push(vec![(through, Weight::new(move |row| hat(&own, place, row.position[axis])))]);
                one.points.push(vec![targets[place]]);
            }
            out.push(one);
        }
    }
}

/// 1 at a target, 0 at all others, linear between them and constant beyond them.
fn hat(targets: &[f64], place: usize, at: f64) -> f64 {
    let own = targets[place];
    let beside = if at < own { place.checked_sub(1) } else { Some(place + 1) };
    match beside.and_then(|beside| targets.get(beside)) {
        Some(other) => (1.0 - (at - own) / (other - own)).max(0.0),
        None => 1.0,
    }
}

/// The target positions of an axis to which the readings return.
fn targets(scene: &Scene<'_>, axis: Axis) -> Option<Vec<f64>> {
    let [low, high] = super::range(scene, axis)?;
    let mut all: Vec<f64> = scene.rows.iter().map(|row| row.position[axis]).filter(|at| at.is_finite()).collect();
    let rows = all.len();
    all.sort_by(f64::total_cmp);
    let own: Vec<f64> = all
        .chunk_by(|one, next| next - one <= SHARE * (high - low))
        .map(|part| part.iter().sum::<f64>() / part.len() as f64)
        .collect();
    (TARGETS.contains(&own.len()) && rows >= ROWS * own.len()).then_some(own)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_linear_between_its_targets() {
        let targets = [0.0, 10.0, 40.0];
        let at =
            |place: f64, values: [f64; 2]| -> f64 { (1..3).map(|k| values[k - 1] * hat(&targets, k, place)).sum() };
        // Values 0, 3 and −2 at the targets; 1.5 and 0.5 half-way; constant beyond.
        for (place, value) in
            [(0.0, 0.0), (5.0, 1.5), (10.0, 3.0), (25.0, 0.5), (40.0, -2.0), (50.0, -2.0), (-5.0, 0.0)]
        {
            assert!((at(place, [3.0, -2.0]) - value).abs() < 1e-12, "{place}");
        }
    }
}
