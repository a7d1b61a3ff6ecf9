//! Balls on a swivelling rotary table, probed at many angles with two styli and an indexed spindle.

use super::add_setup;
use crate::plant::machine::{Errors, Machine};
use crate::plant::random::Random;
use crate::plant::reading;
use crate::plant::row::{Column, Kind, Row, Sheet};

/// The sheet of all balls at some angles of A and a number of angles of C.
pub(super) fn sheet(machine: &Machine, random: &mut Random, stem: &str, tilts: &[f64], count: usize) -> Sheet {
    let columns = [Column::Time, Column::Feed, Column::Spindle];
    let mut sheet = Sheet::new(stem, Kind::Probe, 0.8e-3, &["tool"], &columns);
    sheet.balls = vec![[150.0, 10.0, 60.0], [-70.0, 120.0, 90.0], [0.0, -200.0, 150.0], [50.0, 35.0, 30.0]];
    for ball in &mut sheet.balls {
        ball.iter_mut().for_each(|k| *k += random.between(-10.0, 10.0));
    }
    let first = random.between(0.0, 25.0).round();
    let mut clock = 0.0;
    let mut number = 0;
    for (label, length) in [("S", -120.0), ("L", -220.0)] {
        let setup = add_setup(&mut sheet, label);
        for pass in [1.0, -1.0] {
            let mut angles = tilts.to_vec();
            if pass < 0.0 {
                angles.reverse();
            }
            for (step, tilt) in angles.into_iter().enumerate() {
                for target in 0..sheet.balls.len() {
                    let sense = if (step + target) % 2 == 0 { pass } else { -pass };
                    for k in 0..count {
                        let k = if sense > 0.0 { k } else { count - 1 - k };
                        number += 1;
                        clock += 15.0;
                        let mut row = Row { setup, target, t: clock, tool: [0.0, 0.0, length], ..Row::default() };
                        row.q[3] = tilt.to_radians();
                        row.q[4] = (first + 360.0 / count as f64 * k as f64).round().to_radians();
                        (row.dir[3], row.dir[4], row.dir[2]) = (pass, sense, -1.0);
                        row.feed = [100.0, 300.0][(number / 3) % 2];
                        row.spindle = ((number * 7 + number / 5) % 4) as f64 * std::f64::consts::FRAC_PI_2;
                        row.run = format!("{label}{}", if pass > 0.0 { "+" } else { "-" });
                        let at = reading::read(machine, &sheet, &row, &|_| Errors::default());
                        row.q[..3].copy_from_slice(&at);
                        sheet.rows.push(row);
                    }
                }
            }
        }
    }
    sheet
}
