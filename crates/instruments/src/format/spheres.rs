//! Touches of a probe on balls: the center of each ball from four or more touches, with its uncertainty.
//!
//! Each row has the label of a ball and the axis positions at one touch. The rows of one ball at one pose of the rotary axes give a sphere by least squares
//! (algebraic, then two steps of Gauss-Newton). The result is a measurement of `probe`: the axis positions at which the tip would coincide with the ball.

use ncfix_base::geometry::{Axis, Vector};

use super::nominal_actual::position_unit;
use super::{InstrumentFormat, axis_columns, centres};
use crate::grid::{self, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::{ImportedKind, ImportedReadings, ImportedRow, shown};
use crate::text::DecodedText;
use crate::words::{self, ColumnRole};

/// The format.
pub(super) const FORMAT: InstrumentFormat = InstrumentFormat {
    name: "ball-touches",
    title: "touches of a probe on balls: ball, x, y, z and rotary axes, four or more rows for each ball",
    needs: "at unit tool",
    recognize,
    read,
};

/// Fewest touches of a ball: four determine it, the fifth shows their scatter.
const FEWEST: usize = 4;

/// Columns of the label, of X Y Z, and of the rotary axes.
type Columns = (usize, [usize; 3], Vec<(usize, Axis)>);

/// Columns of the label, of X Y Z, and of the rotary axes.
fn columns(table: &GridTable) -> Option<Columns> {
    let label = table.headings.iter().position(|heading| words::role(&heading.words) == ColumnRole::Name)?;
    let axes = axis_columns(table);
    let of = |wanted: Axis| axes.iter().find(|(_, axis)| *axis == wanted).map(|(index, _)| *index);
    let linear = [of(Axis::X)?, of(Axis::Y)?, of(Axis::Z)?];
    Some((label, linear, axes.into_iter().filter(|(_, axis)| axis.is_rotary()).collect()))
}

fn recognize(text: &DecodedText) -> u8 {
    let Ok(table) = grid::table(text) else { return 0 };
    let Some((label, ..)) = columns(&table) else { return 0 };
    let names: Vec<&str> =
        table.rows.iter().filter_map(|row| row.cells.get(label)).map(|cell| cell.text.as_str()).collect();
    let repeats = names.windows(2).filter(|pair| pair.first() == pair.last()).count();
    // Balls repeat in neighboring rows; points and holes have one row each.
    // One row for each ball and pose is the center of the ball.
    let has_touches = centres::has_touches(&table);
    if names.len() >= FEWEST && 2 * repeats > names.len() && has_touches { 3 } else { 0 }
}

fn read(inquiry: &mut Inquiry<'_>) -> Result<ImportedReadings, ImportStop> {
    let table = grid::table(inquiry.text)?;
    let line = table.heading_line;
    let Some((label, linear, rotary)) = columns(&table) else {
        return Err(inquiry.refused(
            "the table has no columns for the ball and for X, Y and Z",
            "name them in the headings: ball;X;Y;Z",
            line,
        ));
    };
    let used = |index: usize| index == label || linear.contains(&index) || rotary.iter().any(|(own, _)| *own == index);
    let unread: Vec<usize> = (0..table.headings.len()).filter(|index| !used(*index)).collect();
    inquiry.unread(&table, &table.headings, &unread)?;
    let mut balls: Vec<(String, Vec<f64>, Vec<Vector>, usize)> = Vec::new();
    for row in &table.rows {
        let name = row.cells.get(label).map(|cell| cell.text.clone()).unwrap_or_default();
        let mut pose = Vec::new();
        for (column, _) in &rotary {
            pose.push(table.needed(row, *column)?);
        }
        let touch =
            Vector::new(table.needed(row, linear[0])?, table.needed(row, linear[1])?, table.needed(row, linear[2])?);
        match balls.last_mut().filter(|(own, at, ..)| *own == name && *at == pose) {
            Some((_, _, touches, _)) => touches.push(touch),
            None => balls.push((name, pose, vec![touch], row.number)),
        }
    }
    let size =
        |(_, _, touches, _): &(_, _, Vec<Vector>, _)| touches.iter().map(|touch| touch.amax()).fold(0.0, f64::max);
    let largest = balls.iter().map(size).fold(0.0, f64::max);
    let stated = inquiry.one_unit(linear.iter().map(|column| table.headings.get(*column)?.unit), line)?;
    let unit = position_unit(inquiry, stated, largest)?;
    let mut axes = vec![Axis::X, Axis::Y, Axis::Z];
    axes.extend(rotary.iter().map(|(_, axis)| *axis));
    let tool = inquiry.tool();
    let mut out = ImportedReadings::new(ImportedKind::Probe, axes.clone(), Vec::new());
    out.fixed = inquiry.other_positions(&axes);
    out.tool_mm = [tool[0], tool[1], tool[2]];
    out.free = Vec::new();
    inquiry.note("the measuring point counts as known; free = [\"tool\"] makes the stylus an unknown", 0);
    let zero = Vector::from_fn(|k, _| inquiry.given(axes.get(k).copied().unwrap_or(Axis::X)).unwrap_or(0.0));
    let (mut squares, mut freedom) = (0.0, 0usize);
    let mut first: Option<f64> = None;
    for (name, pose, touches, line) in &balls {
        let touches: Vec<Vector> = touches.iter().map(|touch| touch.map(|value| unit.inner(value))).collect();
        if touches.len() < FEWEST {
            let message = format!("ball {name} has {} touches here, a center needs {FEWEST}", touches.len());
            let help = "keep the touches of one ball in neighboring rows; a list of centers needs --as ball-centres";
            return Err(inquiry.refused(message, help, *line));
        }
        let Some((center, radius)) = sphere(&touches) else {
            return Err(inquiry.refused(
                format!("the touches of ball {name} lie in one plane"),
                "touch the ball from its side and from above",
                *line,
            ));
        };
        let start = *first.get_or_insert(radius);
        if (radius - start).abs() > 0.05 * start {
            let message = format!("ball {name} has the radius {} mm, the first one {}", shown(radius), shown(start));
            return Err(inquiry.refused(
                message,
                "balls of one file have one size: check the labels and the unit",
                *line,
            ));
        }
        squares += touches.iter().map(|touch| ((touch - center).norm() - radius).powi(2)).sum::<f64>();
        freedom += touches.len() - FEWEST;
        let mut position: Vec<f64> = (0..3).map(|k| center[k] + zero[k]).collect();
        position.extend(pose);
        out.rows.push(ImportedRow { label: name.clone(), position, line: *line, ..ImportedRow::default() });
    }
    if freedom > 0 {
        let sigma_um = (squares / freedom as f64).sqrt() * 1000.0;
        inquiry.note(format!("{} balls; a touch scatters by {sigma_um:.2} µm about its sphere", balls.len()), 0);
        out.sigma = inquiry
            .answer("sigma", |own| own.sigma)
            .or(Some((sigma_um * 10.0).round() / 10.0).filter(|sigma| *sigma > 0.0));
    } else {
        inquiry.note("four touches of each ball: their scatter is not known", 0);
        out.sigma = inquiry.answer("sigma", |own| own.sigma);
    }
    if zero.norm() == 0.0 {
        inquiry.note("positions are machine coordinates", 0);
    }
    out.sign_sentence = format!(
        "the first ball is at X {} Y {} Z {}",
        shown(out.rows[0].position[0]),
        shown(out.rows[0].position[1]),
        shown(out.rows[0].position[2])
    );
    Ok(out)
}

/// Center and radius of a sphere through touches; `None` if they do not determine one.
fn sphere(touches: &[Vector]) -> Option<(Vector, f64)> {
    let count = touches.len() as f64;
    let mean = touches.iter().fold(Vector::zeros(), |sum, touch| sum + touch) / count;
    let size = touches.iter().map(|touch| (touch - mean).norm()).fold(0.0, f64::max);
    // |t|² = 2 t·c + d, relative to the mean, is linear in the center.
    let mut normal = [[0.0; 4]; 4];
    let mut right = [0.0; 4];
    for touch in touches {
        let t = (touch - mean) / size.max(f64::MIN_POSITIVE);
        let row = [2.0 * t[0], 2.0 * t[1], 2.0 * t[2], 1.0];
        let value = t.norm_squared();
        for i in 0..4 {
            right[i] += row[i] * value;
            for j in 0..4 {
                normal[i][j] += row[i] * row[j];
            }
        }
    }
    let [x, y, z, _] = solve(normal, right)?;
    let mut center = Vector::new(x, y, z) * size + mean;
    let mut radius = touches.iter().map(|touch| (touch - center).norm()).sum::<f64>() / count;
    for _ in 0..4 {
        let mut normal = [[0.0; 4]; 4];
        let mut right = [0.0; 4];
        for touch in touches {
            let distance = (touch - center).norm();
            let along = (center - touch) / distance.max(f64::MIN_POSITIVE);
            let row = [along[0], along[1], along[2], -1.0];
            for i in 0..4 {
                right[i] -= row[i] * (distance - radius);
                for j in 0..4 {
                    normal[i][j] += row[i] * row[j];
                }
            }
        }
        let step = solve(normal, right)?;
        center += Vector::new(step[0], step[1], step[2]);
        radius += step[3];
    }
    (center.iter().all(|value| value.is_finite()) && radius.is_finite() && radius < 1e3 * size)
        .then_some((center, radius))
}

/// Solves four equations; `None` if they are singular.
fn solve(rows: [[f64; 4]; 4], right: [f64; 4]) -> Option<[f64; 4]> {
    /// Ratio of the singular values below which touches lie in a plane and determine no center.
    const SINGULAR: f64 = 1e-9;
    let values = nalgebra::Matrix4::from_fn(|i, j| rows[i][j]).svd(true, true);
    let [least, most] = [values.singular_values.min(), values.singular_values.max()];
    let is_regular = least > SINGULAR * most;
    let solved = values.solve(&nalgebra::Vector4::from(right), 0.0).ok().filter(|_| is_regular)?;
    Some(solved.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_touches_give_the_center() {
        let (center, radius) = (Vector::new(120.5, -40.25, 63.125), 12.7);
        let directions = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
        let touches: Vec<Vector> = directions.iter().map(|d| center + Vector::from(*d) * radius).collect();
        let (found, size) = sphere(&touches).unwrap();
        assert!((found - center).norm() < 1e-9 && (size - radius).abs() < 1e-9, "{found} {size}");
        assert_eq!(sphere(&touches[..4]).map(|(center, _)| center[2].is_finite()), None);
    }
}
