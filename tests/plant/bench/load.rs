//! Level and straightedge along X and Y with weights at several places of the table.

use super::add_setup;
use crate::plant::random::Random;
use crate::plant::row::{Column, Kind, Row, Sheet};

/// Angles and lengths with loads; held out are another weight and other places.
pub(super) fn sheets(random: &mut Random, prefix: &str, is_held: bool) -> Vec<Sheet> {
    let weights: &[f64] = if is_held { &[0.0, 2200.0, 4000.0] } else { &[0.0, 1500.0, 3000.0, 4800.0] };
    let places: &[[f64; 2]] = if is_held {
        &[[60.0, -90.0], [-120.0, 110.0]]
    } else {
        &[[0.0, -150.0], [0.0, 0.0], [0.0, 150.0], [200.0, 0.0]]
    };
    let mut out = Vec::new();
    for (name, sigma, directions) in [("levels", 0.5e-6, [3, 4, 5]), ("lines", 0.4e-3, [0, 1, 2])] {
        let mut sheet =
            Sheet::new(&format!("{prefix}{name}"), Kind::Direct, sigma, &["offset"], &[Column::Time, Column::Load]);
        sheet.angles = directions[0] > 2;
        let setup = add_setup(&mut sheet, "A");
        // What is held out was measured later in the day.
        let mut clock = if is_held { 9000.0 } else { 0.0 };
        let mut number = 0;
        let shift = random.between(-10.0, 10.0);
        for &load in weights {
            for &[x, y] in if load == 0.0 { &places[..1] } else { places } {
                number += 1;
                for axis in 0..2 {
                    for sense in [1.0, -1.0] {
                        for k in 0..11 {
                            let k = if sense > 0.0 { k } else { 10 - k };
                            for direction in directions.into_iter().filter(|&d| d % 3 != axis || d > 2) {
                                let mut row = Row { setup, load, t: clock, ..Row::default() };
                                row.load_at = if load == 0.0 { [0.0; 3] } else { [x, y, 0.0] };
                                row.q = [350.0, 250.0, 200.0, 0.0, 0.0];
                                row.q[axis] = 20.0 + shift + [66.0, 46.0][axis] * f64::from(k);
                                row.tool = [0.0, 0.0, -100.0];
                                row.dir[axis] = sense;
                                row.component = [direction, axis];
                                row.run = format!("{number}{}", ["X", "Y"][axis]);
                                sheet.rows.push(row);
                            }
                            clock += 8.0;
                        }
                    }
                }
                clock += 900.0;
            }
        }
        out.push(sheet);
    }
    out
}
