//! An error that depends on the position of one axis, but only beyond a position of another: a guide with a joint, a bed on a fourth foot, a cover
//! that drags.
//!
//! The threshold lies between two neighboring measured positions. Its exact position is unknown, so the error rises linearly from one of them to the
//! other.

use super::{Candidate, Cause, Correctable, EffectKind, Weight};
use crate::diagnose::scene::{Scene, Through};
use ncfix_base::geometry::Axis;
use ncfix_model::name::{DIRECTIONS, ErrorName};

pub(super) const CAUSE: Cause = Cause {
    name: "cross-coupled error beyond a threshold",
    effect: EffectKind::Cross,
    made_by: "a joint of a guideway, a machine foot that carries only beyond a position, friction of a cover",
    shown_by: "a grid of lines: the lines beyond one position differ from all lines before it",
    separate_by: "lines in smaller steps around the threshold",
    correctable: Correctable::Program,
    propose,
};

/// Number of positions of a grid of lines along one axis. More positions form a path, whose shapes are searched in other ways.
const POSITIONS: std::ops::RangeInclusive<usize> = 4..=25;
/// Smallest number of positions of the axis on which the error depends.
const ACROSS: usize = 3;
/// Largest distance between repeats of one position, as a share of the travel.
const SHARE: f64 = 1e-3;
/// Average number of rows at each pair of positions.
const ROWS: usize = 2;

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let grids: Vec<(Axis, Vec<f64>)> =
        super::linear(scene).filter_map(|axis| Some((axis, positions(scene, axis)?))).collect();
    for (beyond, steps) in grids.iter().filter(|(_, steps)| POSITIONS.contains(&steps.len())) {
        for (across, places) in grids.iter().filter(|(axis, places)| axis != beyond && places.len() >= ACROSS) {
            if scene.rows.len() < ROWS * steps.len() * places.len() {
                continue;
            }
            let middle = f64::midpoint(places[0], places[places.len() - 1]);
            for pair in steps.windows(2) {
                let ends = [pair[0], pair[1]];
                for axis in [*beyond, *across] {
                    push(out, (axis, *beyond, ends), (*across, middle));
                }
            }
        }
    }
}

/// Adds displacements of an axis that grow along `across` beyond a threshold: linearly from the middle, with the square from zero, and with the
/// square from the middle.
fn push(out: &mut Vec<Candidate>, (axis, beyond, ends): (Axis, Axis, [f64; 2]), (across, middle): (Axis, f64)) {
    let laws: [(f64, i32); 3] = [(middle, 1), (0.0, 2), (middle, 2)];
    for name in DIRECTIONS.into_iter().filter(|direction| !direction.is_rotation()) {
        let name = ErrorName::motion(name, axis);
        for (from, power) in laws {
            for is_above in [true, false] {
                let weight = Weight::new(move |row| {
                    let share = ((row.position[beyond] - ends[0]) / (ends[1] - ends[0])).clamp(0.0, 1.0);
                    let share = if is_above { share } else { 1.0 - share };
                    share * (row.position[across] - from).powi(power)
                });
                let mut one =
                    Candidate::one(&CAUSE, name, Through::Component(name), weight).driven_by(&[&beyond, &across]);
                one.threshold = Some((beyond, ends));
                out.push(one);
            }
        }
    }
}

/// Positions of an axis to which the readings return.
fn positions(scene: &Scene<'_>, axis: Axis) -> Option<Vec<f64>> {
    let [low, high] = super::range(scene, axis)?;
    let mut all: Vec<f64> = scene.rows.iter().map(|row| row.position[axis]).filter(|at| at.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    let own: Vec<f64> = all
        .chunk_by(|one, next| next - one <= SHARE * (high - low))
        .map(|part| part.iter().sum::<f64>() / part.len() as f64)
        .collect();
    (own.len() <= *POSITIONS.end()).then_some(own)
}
