//! Errors that repeat with a pitch, fixed in position: ball screw, scale, rotary encoder (ISO 230-2).

use std::f64::consts::TAU;

use super::{Candidate, Cause, Correctable, EffectKind, Weight};
use crate::diagnose::scene::{Scene, Through};
use ncfix_base::geometry::Axis;
use ncfix_model::name::{DIRECTIONS, ErrorName};

pub(in crate::diagnose) const CAUSE: Cause = Cause {
    name: "periodic error",
    effect: EffectKind::Periodic,
    made_by: "pitch of the screw, interpolation of the scale, an eccentric encoder",
    shown_by: "fine steps along the axis; ball-bar: ripples that remain at their positions at another feed",
    separate_by: "another feed: a vibration moves along the path, an error that is periodic in position does not",
    correctable: Correctable::Program,
    propose,
};

/// Number of harmonics of a revolution.
const HARMONICS: u8 = 6;

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    for axis in super::axes(scene) {
        // Harmonics of a revolution. Periods of linear axes are searched ([`crate::diagnose::sweep`]).
        for harmonic in (1..=HARMONICS).filter(|_| axis.is_rotary()) {
            let waves = waves(axis, TAU / f64::from(harmonic));
            for name in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
                out.push(with(name, axis, TAU / f64::from(harmonic), &waves));
            }
        }
    }
}

/// Sine and cosine of a position with this period, mm or rad.
fn waves(axis: Axis, period: f64) -> [Weight; 2] {
    [
        Weight::new(move |row| (TAU * row.position[axis] / period).sin()),
        Weight::new(move |row| (TAU * row.position[axis] / period).cos()),
    ]
}

/// A sine and a cosine with this period, mm or rad.
pub(in crate::diagnose) fn candidate(name: ErrorName, axis: Axis, period: f64) -> Candidate {
    with(name, axis, period, &waves(axis, period))
}

fn with(name: ErrorName, axis: Axis, period: f64, [sine, cosine]: &[Weight; 2]) -> Candidate {
    let through = Through::Component(name);
    let mut one = Candidate::one(&CAUSE, name, through, sine.clone()).driven_by(&[&axis]);
    one.columns.push(vec![(through, cosine.clone())]);
    one.constant = Some(if axis.is_rotary() { (period.to_degrees(), "deg") } else { (period, "mm") });
    one
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn a_table_repeats_with_its_turn_and_parts_of_it() {
        let machine = bench::turning();
        let rows = "X,Y,Z,C,dx_um,dy_um,dz_um\n0,0,0,0,0,0,0\n0,0,0,90,0,0,0\n0,0,0,15,0,0,0\n";
        let sets = [bench::table(&machine, rows, "[measurement]\nkind = \"displacement\"\nsigma_um = 1\n")];
        let scene = bench::scene(&machine, &sets);
        let mut found = Vec::new();
        propose(&scene, &mut found);
        let own: Vec<&Candidate> = found.iter().filter(|one| one.parameter == "EZC").collect();
        let degrees: Vec<f64> = own.iter().map(|one| (one.constant.unwrap().0 * 1e9).round() / 1e9).collect();
        assert_eq!(degrees, [360.0, 180.0, 120.0, 90.0, 72.0, 60.0]);
        // At a quarter of a revolution, and of a sixth of it, sines are 1 and cosines 0.
        for (one, row) in [(own[0], 1), (own[5], 2)] {
            let of = |column: usize| one.columns[column][0].1.of(&scene.rows[row]).abs();
            assert!((of(0) - 1.0).abs() < 1e-12 && of(1) < 1e-12, "{one:?}");
        }
    }
}
