//! Laser, straightedge and level along single axes, at rest (ISO 230-2) or while they move.

use super::add_setup;
use crate::plant::random::Random;
use crate::plant::row::{Column, Kind, Row, Sheet};
use crate::plant::vector::V3;

/// What the linear axes travel here, mm.
const RANGE: [[f64; 2]; 3] = [[10.0, 690.0], [10.0, 490.0], [0.0, 500.0]];

/// Targets over a range, with random parts of a step as ISO 230-2 wants.
fn targets(random: &mut Random, axis: usize, count: usize) -> Vec<f64> {
    let [low, high] = RANGE[axis];
    let step = (high - low) / (count - 1) as f64;
    (0..count)
        .map(|k| (low + step * (k as f64 + random.between(-0.3, 0.3))).clamp(low, high))
        .map(|q| (q * 1e3).round() / 1e3)
        .collect()
}

/// Where a line lies, and with which tool.
#[derive(Clone, Copy)]
struct Line {
    axis: usize,
    at: V3,
    tool: V3,
    setup: usize,
}

/// Runs along a line: forth and back.
fn line(sheet: &mut Sheet, line: Line, at: &[f64], directions: &[usize], runs: usize, clock: &mut f64) {
    for run in 0..runs {
        for sense in [1.0, -1.0] {
            let mut places = at.to_vec();
            if sense < 0.0 {
                places.reverse();
            }
            for q in places {
                *clock += 6.0;
                for &direction in directions {
                    let mut row = Row { setup: line.setup, t: *clock, tool: line.tool, ..Row::default() };
                    row.q[..3].copy_from_slice(&line.at);
                    row.q[line.axis] = q;
                    row.dir[line.axis] = sense;
                    row.component = [direction, line.axis];
                    let name = ["X", "Y", "Z"][line.axis];
                    row.run = format!("{name}{}{}{}", line.setup, run + 1, if sense > 0.0 { "+" } else { "-" });
                    sheet.rows.push(row);
                }
            }
            *clock += 20.0;
        }
    }
}

/// Lengths and angles of all three axes on lines of some numbers.
pub(super) fn at_rest(random: &mut Random, prefix: &str, lines: &[usize], runs: usize) -> Vec<Sheet> {
    let lie: [(V3, V3); 3] = [
        ([300.0, 180.0, 220.0], [30.0, 0.0, -140.0]),
        ([350.0, 250.0, 250.0], [0.0, 0.0, -100.0]),
        ([180.0, 120.0, 400.0], [0.0, 60.0, -180.0]),
    ];
    let count = 15;
    let targets = [0, 1, 2].map(|axis| targets(random, axis, count));
    let mut out = Vec::new();
    for (name, sigma, directions) in [("lengths", 0.3e-3, [0, 1, 2]), ("angles", 0.4e-6, [3, 4, 5])] {
        let mut sheet = Sheet::new(&format!("{prefix}{name}"), Kind::Direct, sigma, &["offset"], &[Column::Time]);
        sheet.angles = directions[0] > 2;
        // What is held out was measured later in the day.
        let mut clock = if prefix.is_empty() { 0.0 } else { 7000.0 };
        for &number in lines {
            let setup = add_setup(&mut sheet, ["C", "A", "B"][number]);
            for (axis, targets) in targets.iter().enumerate() {
                let (at, tool) = lie[number];
                let runs_on = Line { axis, at, tool, setup };
                line(&mut sheet, runs_on, targets, &directions, runs, &mut clock);
            }
        }
        if !sheet.angles {
            // Fine steps over a few turns of a screw.
            let setup = add_setup(&mut sheet, "F");
            for axis in 0..3 {
                let (at, tool) = lie[lines[0]];
                let first = random.between(150.0, 300.0);
                let fine: Vec<f64> = (0..100).map(|k| ((first + 0.47 * f64::from(k)) * 1e3).round() / 1e3).collect();
                line(&mut sheet, Line { axis, at, tool, setup }, &fine, &[axis], 1, &mut clock);
            }
        }
        out.push(sheet);
    }
    out
}

/// Positioning read while the axes move, at feeds in mm/min.
pub(super) fn moving(random: &mut Random, stem: &str, feeds: &[f64], fineness: f64) -> Sheet {
    let columns = [Column::Time, Column::Feed];
    let mut sheet = Sheet::new(stem, Kind::Direct, 0.4e-3, &["offset"], &columns);
    let setup = add_setup(&mut sheet, "A");
    let mut clock = 0.0;
    for axis in 0..3 {
        let [low, high] = RANGE[axis];
        let count = (40.0 * fineness) as usize;
        for run in 0..2 {
            for &feed in feeds {
                for sense in [1.0, -1.0] {
                    let begins = clock;
                    let shift = random.between(0.0, 1.0);
                    for k in 0..count {
                        let way = (high - low) * (k as f64 + shift) / count as f64;
                        let mut row = Row { setup, feed, t: begins + way / feed * 60.0, ..Row::default() };
                        row.q = [350.0, 250.0, 250.0, 0.0, 0.0];
                        row.q[axis] = if sense > 0.0 { low + way } else { high - way };
                        row.tool = [0.0, 0.0, -100.0];
                        row.dir[axis] = sense;
                        row.v[axis] = sense * feed / 60.0;
                        row.component = [axis, axis];
                        row.run =
                            format!("{}{feed}{run}{}", ["X", "Y", "Z"][axis], if sense > 0.0 { "+" } else { "-" });
                        clock = row.t;
                        sheet.rows.push(row);
                    }
                    clock += 15.0;
                }
            }
        }
    }
    sheet
}
