//! Mounts of a ball-bar that bend: a telescoping bar presses on its balls with a spring.
//!
//! Posts and magnetic cups are stiff along their axis and yield across it. Horizontal parts of the force then change the distance of the balls, vertical ones
//! do not. The readings are those of equal scales of both horizontal axes, which would be a rare coincidence, and which a program must not correct.

use super::{Candidate, Cause, Correctable, EffectKind, Weight, linear};
use crate::diagnose::row::SceneRow;
use crate::diagnose::scene::{Scene, Through};
use crate::measure::kind::Measurand;

pub(super) const CAUSE: Cause = Cause {
    name: "mounts of a ball-bar that bend",
    effect: EffectKind::Setup,
    made_by: "the spring of the bar, and a post or a cup that yields sideways",
    shown_by: "ball-bar: equal scales of both horizontal axes, and none of the vertical one",
    separate_by: "a laser along one of the axes; circles of another radius: the bend stays the same, a scale error grows with the radius",
    correctable: Correctable::No,
    propose,
};

/// Smallest range of the vertical share of the force over the readings.
const RANGE: f64 = 0.5;

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    // Without a spindle axis along one of the machine axes, nothing states which direction is that of the posts.
    let spindle = scene.machine.spindle.axis;
    let Some(upright) = linear(scene).find(|axis| spindle[axis.dimension()].abs() > 1.0 - 1e-6) else { return };
    let is_bar: Vec<bool> = scene.sets.iter().map(|set| set.kind.measurand == Measurand::BallDistance).collect();
    let centers: Vec<Vec<([f64; 3], f64)>> = scene
        .sets
        .iter()
        .map(|set| set.setups.iter().map(|setup| (setup.centre_mm.into(), setup.length_mm)).collect())
        .collect();
    let sideways = move |row: &SceneRow| {
        let center = centers.get(row.set).and_then(|own| own.get(row.setup));
        let (true, Some((center, length))) = (is_bar.get(row.set) == Some(&true), center) else { return 0.0 };
        let place = row.position[upright] + row.tool_mm[upright.dimension()] - center[upright.dimension()];
        1.0 - (place / length).powi(2)
    };
    let of_bars =
        |row: &&SceneRow| scene.sets.get(row.set).is_some_and(|set| set.kind.measurand == Measurand::BallDistance);
    let (low, high) = scene
        .rows
        .iter()
        .filter(of_bars)
        .map(&sideways)
        .fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
    if high - low <= RANGE {
        return;
    }
    let one = Candidate::one(&CAUSE, "mounts", Through::Reading(false), Weight::new(sideways));
    out.push(one.driven_by(&[&upright]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn mounts_bend_in_horizontal_circles_and_at_the_sides_of_vertical_ones() {
        let machine = bench::machine();
        let found = |rows: &str| {
            let text = format!("X,Y,Z,dr_um\n{rows}");
            let description =
                "[measurement]\nkind = \"ballbar\"\nsigma_um = 1\n[setup.A]\ncentre_mm = [0, 0, 0]\nlength_mm = 100\n";
            let sets = [bench::table(&machine, &text, description)];
            let scene = bench::scene(&machine, &sets);
            let mut out = Vec::new();
            propose(&scene, &mut out);
            out.first().map(|one| scene.rows.iter().map(|row| one.columns[0][0].1.of(row)).collect::<Vec<f64>>())
        };
        let flat = "100,0,0,0\n0,100,0,0\n-100,0,0,0\n";
        // In one horizontal plane it is the length of the bar.
        assert_eq!(found(flat), None);
        // 60 and 80 mm of 100: a share of 0.6² sideways.
        let both = found(&format!("{flat}60,0,80,0\n0,0,100,0\n")).unwrap();
        let expected = [1.0, 1.0, 1.0, 0.36, 0.0];
        assert!(both.iter().zip(expected).all(|(own, expected)| (own - expected).abs() < 1e-12), "{both:?}");
    }
}
