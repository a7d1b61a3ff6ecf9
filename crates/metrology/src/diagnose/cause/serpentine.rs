//! Backlash on a part whose holes were made in a serpentine order, but are listed in another one.
//!
//! A CMM report is sorted by the names of the features, and its rows do not show the motions of the machine. Holes that were made row by row, forward and
//! backward in turn, are shifted by the backlash in every second row. This looks like a straightness with a bend at each row. The sign of the backlash is
//! not known, because the direction in the first row is not.

use super::{Candidate, Cause, Correctable, EffectKind, Weight, own};
use crate::diagnose::row::SceneRow;
use crate::diagnose::scene::{Scene, Through};
use crate::measure::kind::Measurand;
use ncfix_base::geometry::Axis;

pub(in crate::diagnose) const CAUSE: Cause = Cause {
    name: "backlash in serpentine order",
    effect: EffectKind::Backlash,
    made_by: "backlash of nut, preload or gear, if the rows of the part were made forward and backward in turn",
    shown_by: "plate or part: every second row is shifted along itself",
    separate_by: "rows in the order in which the machine made them; the same holes made in one direction only",
    correctable: Correctable::No,
    propose,
};

/// Smallest and largest number of rows of holes.
const LINES: std::ops::RangeInclusive<usize> = 3..=100;
/// The rows are listed in this order if the directions of this share of the holes, less those of the others, agree with it.
const IN_ORDER: f64 = 0.4;
/// Positions that differ by less belong to one row of holes, mm.
const ONE_LINE_MM: f64 = 0.5;

fn propose(scene: &Scene<'_>, out: &mut Vec<Candidate>) {
    let is_plate =
        |row: &SceneRow| scene.sets.get(row.set).is_some_and(|set| set.kind.measurand == Measurand::Displacement);
    let axes: Vec<Axis> = super::linear(scene).filter(|&axis| super::range(scene, axis).is_some()).collect();
    for &axis in &axes {
        for &across in axes.iter().filter(|&&across| across != axis) {
            let rows: Vec<&SceneRow> = scene.rows.iter().filter(|row| is_plate(row)).collect();
            let Some(lines) = lines(&rows, axis, across) else { continue };
            let side = move |row: &SceneRow| {
                let line = lines.partition_point(|line| *line < row.position[across] - ONE_LINE_MM);
                if line % 2 == 0 { 1.0 } else { -1.0 }
            };
            // The order of the rows is this one already, except at the ends of the rows.
            let along: f64 = rows.iter().map(|row| row.sense_of(axis) * side(row)).sum();
            if along.abs() > IN_ORDER * rows.len() as f64 {
                continue;
            }
            let is_of_set =
                scene.sets.iter().map(|set| set.kind.measurand == Measurand::Displacement).collect::<Vec<bool>>();
            let weight =
                Weight::new(move |row| if is_of_set.get(row.set).copied().unwrap_or(false) { side(row) } else { 0.0 });
            let one = Candidate::one(&CAUSE, own(axis), Through::Component(own(axis)), weight);
            out.push(one.driven_by(&[&format!("{axis}_dir"), &across]).written(|_| {
                Err("the order in which the machine made the rows is not known, so the sign of the backlash is not either; list the readings in this order".into())
            }));
        }
    }
}

/// Positions of the rows of holes along one axis, ascending; `None` if the holes are not in rows of several holes.
fn lines(rows: &[&SceneRow], axis: Axis, across: Axis) -> Option<Vec<f64>> {
    let mut all: Vec<f64> = rows.iter().map(|row| row.position[across]).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|next, last| (*next - *last).abs() < ONE_LINE_MM);
    let is_row = |line: &f64| {
        let own = rows.iter().filter(|row| (row.position[across] - line).abs() < ONE_LINE_MM);
        super::spread(own.map(|row| row.position[axis])).is_some_and(|[low, high]| high - low > ONE_LINE_MM)
    };
    (LINES.contains(&all.len()) && all.iter().all(is_row)).then_some(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn every_second_row_of_holes_is_on_the_other_side() {
        let machine = bench::machine();
        let of = |order: [f64; 6]| {
            let mut text = "X,Y,Z,dx_um,dy_um\n".to_owned();
            for (k, x) in order.iter().enumerate() {
                text += &format!("{x},{},0,0,0\n", 50 * (k / 2));
            }
            let sets = [bench::table(&machine, &text, "[measurement]\nkind = \"displacement\"\nsigma_um = 1\n")];
            let scene = bench::scene(&machine, &sets);
            let mut found = Vec::new();
            propose(&scene, &mut found);
            let along = found.into_iter().find(|one| one.parameter == "EXX");
            along.map(|one| scene.rows.iter().map(|row| one.columns[0][0].1.of(row)).collect::<Vec<f64>>())
        };
        // A report that is sorted by place.
        assert_eq!(of([0.0, 80.0, 0.0, 80.0, 0.0, 80.0]), Some(vec![1.0, 1.0, -1.0, -1.0, 1.0, 1.0]));
        // Two holes at one place are no row.
        assert_eq!(of([0.0, 80.0, 40.0, 40.3, 0.0, 80.0]), None);
    }
}
