//! Equal scales of all linear axes: a machine that is warmer or colder than the bar, or than the temperature at which its scales were set.
//!
//! Three scales that happen to be equal would be a rare coincidence; one temperature makes them equal. Without this cause, circles that are all too large by
//! the same share would show a lag of all axes or a wrong bar for certain, because single scales need two more unknowns. The search itself uses single scales:
//! this cause is only a rival of causes of another nature.

use super::{Candidate, Cause, Correctable, EffectKind, Weight, body_sense, own};
use crate::diagnose::scene::{Scene, Through};
use crate::measure::kind::Measurand;
use ncfix_base::geometry::Axis;

pub(in crate::diagnose) const CAUSE: Cause = Cause {
    name: "equal scales of all axes",
    effect: EffectKind::Motion,
    made_by: "a machine at another temperature than the bar or its scales",
    shown_by: "ball-bar of calibrated length: all circles too large or too small by the same share, at every feed",
    separate_by: "circles at two feeds separate it from lags; a laser separates it from the length of the bar",
    correctable: Correctable::Program,
    propose,
};

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let is_bar = scene.sets.iter().any(|set| set.kind.measurand == Measurand::BallDistance);
    let axes: Vec<Axis> = super::linear(scene).filter(|&axis| super::range(scene, axis).is_some()).collect();
    let Some(&first) = axes.first().filter(|_| is_bar && axes.len() > 1) else { return };
    let letters: String = axes.iter().map(ToString::to_string).collect();
    let mut one = Candidate::one(&CAUSE, letters, Through::Component(own(first)), Weight::new(|_| 0.0));
    let part = |&axis: &Axis| {
        let sense = body_sense(scene, axis);
        (Through::Component(own(axis)), Weight::new(move |row| sense * row.position[axis]))
    };
    one.columns = vec![axes.iter().map(part).collect()];
    let drivers: Vec<&dyn std::fmt::Display> = axes.iter().map(|axis| axis as &dyn std::fmt::Display).collect();
    out.push(one.driven_by(&drivers));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn a_warm_machine_makes_all_circles_of_a_known_bar_too_large() {
        let machine = bench::machine();
        let mut text = "X,Y,Z,dr_um\n".to_owned();
        for k in 0..8 {
            let (sin, cos) = (f64::from(k) * 45.0_f64.to_radians()).sin_cos();
            text += &format!("{},{},0,0\n", 100.0 * cos, 100.0 * sin);
        }
        let with = |free: &str| {
            let description = format!(
                "[measurement]\nkind = \"ballbar\"\nfree = [{free}]\nsigma_um = 1\n[setup.A]\ncentre_mm = [0, 0, 0]\nlength_mm = 100\n"
            );
            bench::table(&machine, &text, &description)
        };
        let sets = [with("\"centre\"")];
        let scene = bench::scene(&machine, &sets);
        let mut found = Vec::new();
        propose(&scene, &mut found);
        assert_eq!(found[0].parameter, "XY");
        // 20 µm/m on a radius of 100 mm: 2 µm along the bar, everywhere.
        let deviations: Vec<f64> = (0..8)
            .map(|row| {
                let parts = found[0].columns[0]
                    .iter()
                    .map(|(through, weight)| scene.factors(*through)[row] * weight.of(&scene.rows[row]) * 20e-6);
                parts.sum::<f64>() * 1e3
            })
            .collect();
        assert!(deviations.iter().all(|um| (um - 2.0).abs() < 1e-3), "{deviations:?}");
    }
}
