//! Weight on the table: guideways and bearings deflect, and more with an eccentric load (Spaan 1995, ch. 4).

use super::{Candidate, Cause, Correctable, EffectKind, Values, Weight, column};
use crate::diagnose::row::SceneRow;
use crate::diagnose::scene::{Scene, Through};
use ncfix_model::name::{DIRECTIONS, ErrorName};

pub(super) const GUIDE: Cause = Cause {
    name: "guideway under load",
    effect: EffectKind::Load,
    made_by: "the weight of the workpiece on a guideway",
    shown_by: "level or plate with weights at several positions: a roll or pitch along the axis that increases with the weight",
    separate_by: "the same line without the weight",
    correctable: Correctable::Program,
    propose: guide,
};

pub(super) const TABLE: Cause = Cause {
    name: "table under load",
    effect: EffectKind::Load,
    made_by: "compliance of the table bearings",
    shown_by: "a tilt that increases with the weight and with its distance from the center",
    separate_by: "lines along the axis: the effect of a compliant guideway changes along it",
    correctable: Correctable::Program,
    propose: table,
};

const LOAD: &str = "load_N";
const PLACES: [&str; 3] = ["load_x_mm", "load_y_mm", "load_z_mm"];
/// Unit of the weight, N, and of its arm, mm, which keep the weights of the columns near 1.
const UNIT: [f64; 2] = [1000.0, 100.0];

fn value(values: &Values, row: &SceneRow) -> f64 {
    values.get(row.set).and_then(|own| own.get(row.number)).copied().filter(|value| value.is_finite()).unwrap_or(0.0)
}

/// The weight, and its product with each position, with the names of their columns.
fn weights(scene: &Scene<'_>) -> Vec<(String, Values, Option<Values>)> {
    let Some(load) = column(scene.sets, LOAD) else { return Vec::new() };
    let mut out = vec![(LOAD.to_owned(), load.clone(), None)];
    for name in PLACES {
        if let Some(place) = column(scene.sets, name) {
            out.push((name.to_owned(), load.clone(), Some(place)));
        }
    }
    out
}

fn moment(load: &Values, place: Option<&Values>, row: &SceneRow) -> f64 {
    value(load, row) / UNIT[0] * place.map_or(1.0, |place| value(place, row) / UNIT[1])
}

fn guide(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let all = weights(scene);
    for axis in super::linear(scene) {
        let Some([low, high]) = super::range(scene, axis) else { continue };
        let shape = |load: &Values, place: Option<&Values>, degree: i32| {
            let (load, place) = (load.clone(), place.cloned());
            Weight::new(move |row| {
                let share = (2.0 * row.position[axis] - low - high) / (high - low);
                moment(&load, place.as_ref(), row) * share.powi(degree)
            })
        };
        for (name, load, place) in &all {
            let own: Vec<Weight> = (0..=2).map(|degree| shape(load, None, degree)).collect();
            let off: Vec<Weight> =
                place.iter().flat_map(|place| (0..=2).map(|degree| shape(load, Some(place), degree))).collect();
            for component in DIRECTIONS.map(|direction| ErrorName::motion(direction, axis)) {
                let mut one = Candidate::one(&GUIDE, component, Through::Component(component), Weight::new(|_| 0.0));
                one.columns = own
                    .iter()
                    .skip(1)
                    .chain(off.iter().skip(1))
                    .map(|weight| vec![(Through::Component(component), weight.clone())])
                    .collect();
                one.drivers = vec![LOAD.to_owned(), axis.to_string()];
                if place.is_some() {
                    one.drivers.insert(1, name.clone());
                }
                let mut with_tilt = one.clone();
                let tilts = own.iter().take(1).chain(off.iter().take(1));
                with_tilt.columns.extend(tilts.map(|weight| vec![(Through::Component(component), weight.clone())]));
                out.push(one);
                out.push(with_tilt);
            }
        }
    }
}

fn table(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let axes: Vec<_> = super::linear(scene).collect();
    for (name, load, place) in weights(scene) {
        let drivers: Vec<String> = [LOAD.to_owned()].into_iter().chain(place.as_ref().map(|_| name)).collect();
        let weight = Weight::new(move |row| moment(&load, place.as_ref(), row));
        for &axis in &axes {
            for component in DIRECTIONS.map(|direction| ErrorName::location(direction, axis)) {
                let mut one = Candidate::one(&TABLE, component, Through::Component(component), weight.clone());
                one.drivers.clone_from(&drivers);
                out.push(one);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn a_guideway_gives_way_with_the_weight_its_place_and_along_the_axis() {
        let machine = bench::machine();
        // 3000 N at 50 mm, in units of 1000 N and 100 mm; X from 100 to 300 mm.
        let rows = [(100.0, ",3000,50"), (150.0, ",3000,50"), (300.0, ",3000,50")];
        let sets = [bench::along_x(&machine, ",load_N,load_x_mm", &rows)];
        let scene = bench::scene(&machine, &sets);
        let mut found = Vec::new();
        guide(&scene, &mut found);
        let one = found.iter().find(|one| one.parameter == "EBX" && one.drivers.len() == 3 && one.columns.len() == 6);
        assert_eq!(one.unwrap().drivers, ["load_N", "load_x_mm", "X"]);
        let weights: Vec<[f64; 3]> =
            one.unwrap().columns.iter().map(|column| [0, 1, 2].map(|row| column[0].1.of(&scene.rows[row]))).collect();
        // Columns: the position from −1 to 1 (−1/2 at a quarter) and its square, times the weight 3 and times its moment 3/2; last, both without the
        // position.
        let shapes = [[-1.0, -0.5, 1.0], [1.0, 0.25, 1.0]];
        let by = |factor: f64| shapes.map(|shape| shape.map(|share: f64| share * factor));
        assert_eq!(weights, [by(3.0).as_slice(), &by(1.5), &[[3.0; 3], [1.5; 3]]].concat());
    }
}
