//! A plate with 7 × 7 holes in several placements, with two tools, reached from all four sides.

use super::{add_setup, to_point};
use crate::plant::random::Random;
use crate::plant::row::{Column, Kind, Row, Sheet};

const SIDE: usize = 7;
const PITCH: f64 = 50.0;

/// A placement: set-up, angle in degrees, height and centre.
pub(super) struct Placement {
    pub(super) setup: usize,
    pub(super) degrees: f64,
    pub(super) centre: [f64; 3],
    pub(super) tool: [f64; 3],
}

/// Visits all holes in rows to and fro; the last approach is along `senses` in X and Y.
pub(super) fn visit(sheet: &mut Sheet, place: &Placement, senses: [f64; 2], run: &str, clock: &mut f64) {
    let (s, c) = place.degrees.to_radians().sin_cos();
    for row_number in 0..SIDE {
        for column in 0..SIDE {
            let column = if row_number % 2 == 0 { column } else { SIDE - 1 - column };
            let [u, w] = [column, row_number].map(|k| (k as f64 - 3.0) * PITCH);
            let mut row = Row { setup: place.setup, tool: place.tool, t: *clock, ..Row::default() };
            let [x, y] = [c * u - s * w, s * u + c * w].map(|k| (k * 1e3).round() / 1e3);
            to_point(&mut row, [place.centre[0] + x, place.centre[1] + y, place.centre[2]]);
            row.dir = [senses[0], senses[1], -1.0, 0.0, 0.0];
            run.clone_into(&mut row.run);
            sheet.rows.push(row);
            *clock += 5.0;
        }
    }
}

/// The sheet of some placements: angle in degrees and height of each.
pub(super) fn sheet(random: &mut Random, stem: &str, placements: &[(f64, f64)]) -> Sheet {
    let mut sheet = Sheet::new(stem, Kind::Displacement, 0.7e-3, &["offset", "rotation"], &[Column::Time]);
    let mut clock = 0.0;
    for (number, &(degrees, height)) in placements.iter().enumerate() {
        let x = 350.0 + random.between(-60.0, 60.0).round();
        for (name, tool) in [("a", [0.0, 0.0, -100.0]), ("b", [60.0, -40.0, -160.0])] {
            let setup = add_setup(&mut sheet, &format!("P{}{name}", number + 1));
            let place = Placement { setup, degrees, centre: [x, 250.0, height], tool };
            for (run, senses) in [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].into_iter().enumerate() {
                visit(&mut sheet, &place, senses, &format!("{}{name}{}", number + 1, run + 1), &mut clock);
            }
            clock += 600.0;
        }
    }
    sheet
}
