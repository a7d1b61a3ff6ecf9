//! What an instrument reads of the plant, exactly; and what is left of readings when the unknowns of the set-ups have had their best.

use super::machine::{Errors, Machine};
use super::row::{Kind, Row, Sheet};
use super::vector::{V3, add, along, cross, norm, rotation, scale, sub, transposed, turn};

/// The errors at a row.
pub(crate) type ErrorsAt<'a> = &'a dyn Fn(&Row) -> Errors;

/// The stylus in the tool frame: it turns with the spindle.
fn stylus(sheet: &Sheet, row: &Row) -> V3 {
    turn(&rotation([0.0, 0.0, row.spindle]), sheet.setups[row.setup].stylus)
}

/// The reading without noise, mm or rad; of a probing the commands X Y Z.
pub(crate) fn read(machine: &Machine, sheet: &Sheet, row: &Row, errors_at: ErrorsAt<'_>) -> V3 {
    let setup = &sheet.setups[row.setup];
    let errors = errors_at(row);
    let out = match sheet.kind {
        Kind::Displacement => {
            let seen = machine.see(row, &errors);
            let place = add(turn(&rotation(setup.turn), seen.nominal.t), setup.offset);
            turn(&seen.to_f, sub(seen.actual.t, place))
        }
        Kind::Ballbar => {
            let ball = add(table_ball(machine, sheet, row), setup.off_centre);
            let bar = sub(machine.see(row, &errors).actual.t, ball);
            [norm(bar) - setup.length - setup.off_length, 0.0, 0.0]
        }
        Kind::Direct => {
            let seen = machine.see(row, &errors);
            let [direction, axis] = row.component;
            let sense = if machine.table.contains(&axis) { -1.0 } else { 1.0 };
            let all = if direction < 3 {
                turn(&seen.to_f, sub(seen.actual.t, seen.nominal.t))
            } else {
                let by =
                    super::vector::small_turn(&super::vector::product(&transposed(&seen.nominal.r), &seen.actual.r));
                turn(&seen.to_f, turn(&seen.nominal.r, by))
            };
            [sense * all[direction % 3] + setup.zero[direction][axis], 0.0, 0.0]
        }
        Kind::Probe => return probe(machine, sheet, row, errors_at),
    };
    add(out, errors.reading)
}

/// The commands at which the tip really is in the ball.
fn probe(machine: &Machine, sheet: &Sheet, row: &Row, errors_at: ErrorsAt<'_>) -> V3 {
    let mut here = row.clone();
    for _ in 0..6 {
        let mut errors = errors_at(&here);
        errors.tool = add(errors.tool, stylus(sheet, row));
        let seen = machine.see(&here, &errors);
        let off = turn(&seen.to_f, sub(seen.actual.t, sheet.balls[row.target]));
        (0..3).for_each(|k| here.q[k] -= off[k]);
    }
    [here.q[0], here.q[1], here.q[2]]
}

/// The table ball of a ball-bar in the workpiece frame, where the description has it: across the plane of its circle it then moves nothing,
/// as for whoever knows no better.
fn table_ball(machine: &Machine, sheet: &Sheet, row: &Row) -> V3 {
    let setup = &sheet.setups[row.setup];
    let mut at = Row::default();
    at.q[..3].copy_from_slice(&setup.centre);
    machine.pose(&at, None).t
}

/// How a reading changes with each unknown of the set-ups that is free: number of the unknown, and the change.
fn by_unknowns(machine: &Machine, sheet: &Sheet, row: &Row) -> Vec<(usize, V3)> {
    let has = |word: &str| sheet.free.contains(&word);
    let mut out = Vec::new();
    let to_f = machine.to_f(row);
    match sheet.kind {
        Kind::Displacement => {
            let point = machine.pose(row, None).t;
            for k in 0..3 {
                if has("offset") {
                    out.push((6 * row.setup + k, turn(&to_f, along(k, 1.0))));
                }
                if has("rotation") {
                    out.push((6 * row.setup + 3 + k, turn(&to_f, cross(along(k, 1.0), point))));
                }
            }
        }
        Kind::Ballbar => {
            let bar = sub(machine.pose(row, None).t, table_ball(machine, sheet, row));
            let direction = scale(bar, 1.0 / norm(bar));
            if has("centre") {
                out.extend((0..3).map(|k| (4 * row.setup + k, [direction[k], 0.0, 0.0])));
            }
            if has("length") {
                out.push((4 * row.setup + 3, [1.0, 0.0, 0.0]));
            }
        }
        Kind::Direct => {
            if has("offset") {
                out.push((30 * row.setup + 5 * row.component[0] + row.component[1], [1.0, 0.0, 0.0]));
            }
        }
        Kind::Probe => {
            for k in 0..3 {
                out.push((3 * row.target + k, turn(&to_f, along(k, 1.0))));
                if has("tool") {
                    let by = turn(&rotation([0.0, 0.0, row.spindle]), along(k, 1.0));
                    out.push((3 * (sheet.balls.len() + row.setup) + k, by));
                }
            }
        }
    }
    out
}

/// What is left of values at all rows when the free unknowns of the set-ups have taken what they can (least squares); values that are not
/// read are 0.
pub(crate) fn left(machine: &Machine, sheet: &Sheet, values: &[V3]) -> Vec<V3> {
    let count = 1 + 30 * sheet.setups.len() + 3 * sheet.balls.len();
    let mask = |v: V3| [0, 1, 2].map(|k| if sheet.reads[k] { v[k] } else { 0.0 });
    let columns: Vec<Vec<(usize, V3)>> = sheet
        .rows
        .iter()
        .map(|row| by_unknowns(machine, sheet, row).into_iter().map(|(k, v)| (k, mask(v))).collect())
        .collect();
    let mut normal = vec![vec![0.0; count]; count];
    let mut right = vec![0.0; count];
    for (row, value) in columns.iter().zip(values) {
        for &(i, a) in row {
            right[i] += super::vector::dot(a, mask(*value));
            for &(j, b) in row {
                normal[i][j] += super::vector::dot(a, b);
            }
        }
    }
    let solution = solve(normal, right);
    columns
        .iter()
        .zip(values)
        .map(|(row, value)| row.iter().fold(mask(*value), |rest, &(k, v)| sub(rest, scale(v, solution[k]))))
        .collect()
}

/// Solves a symmetric semi-definite system; unknowns that the others already say are 0.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    let diagonal: Vec<f64> = (0..n).map(|k| a[k][k]).collect();
    // Across its plane a ball-bar says nothing but the noise of the arithmetic.
    let least = 1e-12 * diagonal.iter().fold(0.0, |most: f64, value| most.max(*value));
    let mut used = vec![false; n];
    for k in 0..n {
        if a[k][k] <= 1e-9 * diagonal[k] || diagonal[k] <= least {
            continue;
        }
        used[k] = true;
        let pivot = a[k].clone();
        let from = b[k];
        for i in (0..n).filter(|&i| i != k) {
            let factor = a[i][k] / pivot[k];
            if factor != 0.0 {
                a[i].iter_mut().zip(&pivot).for_each(|(x, p)| *x -= factor * p);
                b[i] -= factor * from;
            }
        }
    }
    (0..n).map(|k| if used[k] { b[k] / a[k][k] } else { 0.0 }).collect()
}
