//! Height maps: probe logs of LinuxCNC and Grbl, files of bCNC, point lists, meshes of Klipper and Marlin.
//!
//! A map is the shape of the plate plus the straightness of the machine. Only a calibrated flat reveals the machine, so a map is read only if
//! `--flat-reference` states that. Where the axis had to go higher to reach the flat, the tool is too low: the displacement is the mean height minus the height.

use std::collections::BTreeMap;

use ncfix_base::csv::DecimalSign;
use ncfix_base::geometry::Axis;

use super::InstrumentFormat;
use super::nominal_actual::position_unit;
use crate::grid;
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::{ImportedKind, ImportedReadings, ImportedRow, shown};
use crate::text::DecodedText;
use crate::unit::ReadingUnit;

/// Probe logs and point lists.
pub(super) const POINTS: InstrumentFormat = InstrumentFormat {
    name: "height-points",
    title: "probed points of a flat: LinuxCNC probe log, Grbl [PRB:] lines, bCNC .probe, x y z lists",
    needs: "flat-reference at unit tool",
    recognize: |text| points(text).map_or(0, |found| found.1),
    read: |inquiry| {
        let Some((found, _, unit)) = points(inquiry.text) else {
            let message = "the file has no points x y z in every line";
            return Err(inquiry.refused(message, "`ncfix import --list` lists the formats", 0));
        };
        check_grid(inquiry.text).map_err(|(message, line)| inquiry.refused(message, "export the map again", line))?;
        // A log is written while the machine probes; a map with its grid was saved afterwards.
        let is_log = !has_grid(&numbers(inquiry.text).unwrap_or_default());
        let found = flat(inquiry, found, unit)?;
        Ok(ImportedReadings { is_in_order: is_log, ..found })
    },
};

/// Mesh of Klipper.
pub(super) const KLIPPER: InstrumentFormat = InstrumentFormat {
    name: "klipper-mesh",
    title: "bed mesh in the configuration of Klipper",
    needs: "flat-reference at tool",
    recognize: |text| u8::from(klipper_points(text).map_or(true, |found| !found.is_empty())) * 3,
    read: |inquiry| {
        let found = klipper_points(inquiry.text)
            .map_err(|(message, line)| inquiry.refused(message, "copy the whole section of the mesh", line))?;
        // Klipper works in mm only.
        flat(inquiry, found, Some((ReadingUnit::Length("mm", 1.0), 0)))
    },
};

/// Grid of Marlin.
pub(super) const MARLIN: InstrumentFormat = InstrumentFormat {
    name: "marlin-mesh",
    title: "bed mesh of Marlin: printed bilinear grid, or M421 lines; spacing by --columns",
    needs: "flat-reference columns at tool",
    recognize: |text| u8::from(marlin_points(text).len() >= 4) * 3,
    read: |inquiry| {
        let spacing: Vec<f64> =
            inquiry.answer("columns", |own| &own.columns).iter().filter_map(|text| text.parse().ok()).collect();
        let [x, y, dx, dy] = <[f64; 4]>::try_from(spacing).unwrap_or_else(|_| {
            let advice = "the position of index 0 and the spacing in mm: x,y,dx,dy";
            inquiry.ask("columns", "the mesh has indices, not positions", advice);
            // The other questions do not depend on the spacing, and nothing is written before all are answered.
            [0.0, 0.0, 1.0, 1.0]
        });
        check_marlin(inquiry.text).map_err(|(message, line)| inquiry.refused(message, "copy the whole grid", line))?;
        let found = marlin_points(inquiry.text);
        let found = found.into_iter().map(|([i, j, z], number)| ([x + dx * i, y + dy * j, z], number)).collect();
        // Marlin prints its meshes in mm.
        flat(inquiry, found, Some((ReadingUnit::Length("mm", 1.0), 0)))
    },
};

/// Point and its line.
pub(super) type Probed = ([f64; 3], usize);

/// Points of a log with certainty, and the unit with its line if the log states it.
type ProbedLog = (Vec<Probed>, u8, Option<(ReadingUnit, usize)>);

/// Points of a log with certainty and unit.
fn points(text: &DecodedText) -> Option<ProbedLog> {
    let grbl: Vec<Probed> = text.lines().filter_map(|(number, line, _)| Some((grbl_point(line)?, number))).collect();
    if grbl.len() >= 3 {
        return Some((grbl, 3, None));
    }
    let rows = numbers(text)?;
    let is_grid = has_grid(&rows);
    let start = if is_grid { 3 } else { 0 };
    let width = rows.get(start)?.0.len();
    if rows.len() < start + 3 || ![3, 9].contains(&width) || rows[start..].iter().any(|(row, _)| row.len() != width) {
        return None;
    }
    let found = rows[start..].iter().map(|(row, number)| ([row[0], row[1], row[2]], *number)).collect();
    Some((found, if is_grid || width == 9 { 3 } else { 1 }, None))
}

/// Numbers of every line that is no comment; `None` if a line has anything else.
fn numbers(text: &DecodedText) -> Option<Vec<(Vec<f64>, usize)>> {
    text.lines()
        .filter(|(_, line, _)| !line.trim().is_empty() && !line.trim_start().starts_with(['#', '(', ';']))
        .map(|(number, line, _)| {
            (
                line.split_whitespace()
                    .map(|cell| grid::number(cell, DecimalSign::Point))
                    .collect::<Option<Vec<f64>>>(),
                number,
            )
        })
        .map(|(cells, number)| Some((cells?, number)))
        .collect()
}

/// True for rows that begin with the grid of bCNC: from, to and count of x and y, then the depth range and feed. A count is a whole number of 2 or more, and
/// most heights are not.
fn has_grid(rows: &[(Vec<f64>, usize)]) -> bool {
    let is_count = |row: &[f64]| row.len() == 3 && row[2].fract() == 0.0 && row[2] >= 2.0;
    let heights = rows.iter().skip(3).filter_map(|(row, _)| row.get(2));
    let is_height = |z: &&f64| !is_count(&[0.0, 0.0, **z]);
    let count = heights.clone().filter(is_height).count();
    rows.len() > 6 && rows[..2].iter().all(|(row, _)| is_count(row)) && 2 * count > rows.len() - 3
}

/// Checks the grid of bCNC against its points.
///
/// # Errors
/// A sentence with the line of the contradiction.
fn check_grid(text: &DecodedText) -> Result<(), (String, usize)> {
    let rows = numbers(text).unwrap_or_default();
    if !has_grid(&rows) {
        return Ok(());
    }
    for ((row, line), name) in rows.iter().zip(["x", "y"]) {
        if row[0] >= row[1] {
            return Err((format!("the grid in {name} goes from {} to {}: it may be mirrored", row[0], row[1]), *line));
        }
    }
    let (points, count) = (rows.len() - 3, rows[0].0[2] * rows[1].0[2]);
    if points as f64 != count {
        return Err((format!("the map has {points} points, and its grid {count}"), rows[0].1));
    }
    for (row, line) in &rows[3..] {
        for (k, name) in ["x", "y"].iter().enumerate() {
            let ([low, high], value) = ([rows[k].0[0], rows[k].0[1]], row[k]);
            let slack = 1e-3 * (high - low);
            if value < low - slack || value > high + slack {
                return Err((format!("{name} {value} is not in the grid from {low} to {high}"), *line));
            }
        }
    }
    Ok(())
}

/// Point of a line `[PRB:x,y,z:1]`; a failed probing has `:0`.
fn grbl_point(line: &str) -> Option<[f64; 3]> {
    let (_, rest) = line.split_once("[PRB:")?;
    let (numbers, rest) = rest.split_once(':')?;
    if !rest.starts_with('1') {
        return None;
    }
    let values: Vec<f64> =
        numbers.split(',').map(|cell| grid::number(cell, DecimalSign::Point)).collect::<Option<_>>()?;
    Some([*values.first()?, *values.get(1)?, *values.get(2)?])
}

/// Indices and height of a line `M421 I0 J0 Z0.1234`.
fn marlin_value(line: &str) -> Option<[f64; 3]> {
    let (_, rest) = line.split_once("M421 ")?;
    let word = |letter: char| {
        rest.split_whitespace().find_map(|word| grid::number(word.strip_prefix(letter)?, DecimalSign::Point))
    };
    Some([word('I')?, word('J')?, word('Z')?])
}

/// Indices and heights of a mesh of Marlin: M421 lines, or the first printed bilinear grid, whose rows begin with their index. Later grids are subdivided.
fn marlin_points(text: &DecodedText) -> Vec<Probed> {
    let commands: Vec<Probed> =
        text.lines().filter_map(|(number, line, _)| Some((marlin_value(line)?, number))).collect();
    if !commands.is_empty() {
        return commands;
    }
    let mut found = Vec::new();
    let mut next_row = None;
    for (number, line, _) in text.lines() {
        let body = line.trim().trim_start_matches("Recv:").trim();
        if body.starts_with("Bilinear Leveling Grid") {
            next_row = Some(0.0);
            continue;
        }
        let Some(row) = next_row else { continue };
        let cells: Vec<&str> = body.split_whitespace().collect();
        let values: Vec<Option<f64>> = cells.iter().map(|cell| grid::number(cell, DecimalSign::Point)).collect();
        // The line of the column indices has no sign or decimals.
        if row == 0.0 && !cells.is_empty() && cells.iter().all(|cell| cell.bytes().all(|byte| byte.is_ascii_digit())) {
            continue;
        }
        if values.first().copied().flatten() != Some(row) || values.len() < 3 {
            break;
        }
        let heights = values.iter().skip(1).enumerate();
        found.extend(heights.filter_map(|(i, z)| Some(([i as f64, row, (*z)?], number))));
        next_row = Some(row + 1.0);
    }
    found
}

/// Checks that every row of a printed grid has a value for each of its columns.
///
/// # Errors
/// A sentence with the line of the contradiction.
fn check_marlin(text: &DecodedText) -> Result<(), (String, usize)> {
    let found = marlin_points(text);
    let columns = |number: usize| text.line(number).trim().trim_start_matches("Recv:").split_whitespace().count();
    let Some((_, first)) = found.first().filter(|(_, line)| marlin_value(text.line(*line)).is_none()) else {
        return Ok(());
    };
    // The line above the first row has the indices of the columns, and no index of a row.
    let wanted = columns(first - 1) + 1;
    let wrong = found.iter().map(|(_, line)| *line).find(|line| columns(*line) != wanted);
    wrong.map_or(Ok(()), |line| {
        Err((format!("the row has {} values, and the grid {} columns", columns(line) - 1, wanted - 1), line))
    })
}

/// Points of the first mesh in a configuration of Klipper: rows from min_y, values from min_x.
fn klipper_points(text: &DecodedText) -> Result<Vec<Probed>, (String, usize)> {
    let mut rows: Vec<(Vec<f64>, usize)> = Vec::new();
    let (mut keys, mut lines_of) = (BTreeMap::new(), BTreeMap::new());
    let (mut is_mesh, mut is_points) = (false, false);
    for (number, line, _) in text.lines() {
        // Klipper writes the part that it saves after this mark; a section that was copied may lack it.
        let body = line.strip_prefix("#*#").unwrap_or(line).trim();
        if body.starts_with('[') {
            if is_mesh && !rows.is_empty() {
                break;
            }
            is_mesh = body.starts_with("[bed_mesh");
            // The settings of the mesh are a section of the same name without points.
            (keys, lines_of, is_points) = (BTreeMap::new(), BTreeMap::new(), false);
            continue;
        }
        if !is_mesh || body.starts_with(['#', ';']) {
            continue;
        }
        if let Some((key, value)) = body.split_once(['=', ':']) {
            is_points = key.trim() == "points";
            if let Some(value) = grid::number(value, DecimalSign::Point) {
                let key = key.trim().to_owned();
                if keys.insert(key.clone(), value).is_some_and(|old| old != value) {
                    return Err((format!("{key} is stated twice, with different values"), number));
                }
                lines_of.insert(key, number);
            }
        } else if is_points && !body.is_empty() {
            let cells: Option<Vec<f64>> =
                body.trim_end_matches(',').split(',').map(|cell| grid::number(cell, DecimalSign::Point)).collect();
            rows.push((cells.ok_or_else(|| ("a value of the mesh is not a number".to_owned(), number))?, number));
        }
    }
    if rows.is_empty() {
        return Ok(Vec::new());
    }
    let key = |name: &str| keys.get(name).copied().ok_or_else(|| (format!("the mesh has no {name}"), rows[0].1));
    let (columns, lines) = (key("x_count")?, key("y_count")?);
    let [low_x, high_x, low_y, high_y] = [key("min_x")?, key("max_x")?, key("min_y")?, key("max_y")?];
    for (name, low, high) in [("x", low_x, high_x), ("y", low_y, high_y)] {
        if low >= high {
            let message = format!("min_{name} is {low} and max_{name} is {high}: the mesh may be mirrored");
            return Err((message, lines_of.get(&format!("min_{name}")).copied().unwrap_or_default()));
        }
    }
    if let Some((row, number)) = rows.iter().find(|(row, _)| row.len() as f64 != columns) {
        return Err((format!("the row of the mesh has {} values, x_count is {columns}", row.len()), *number));
    }
    if rows.len() as f64 != lines || columns < 2.0 || lines < 2.0 {
        return Err((format!("the mesh has {} rows, y_count is {lines}", rows.len()), rows[0].1));
    }
    let at = |low: f64, high: f64, index: usize, count: f64| low + (high - low) * index as f64 / (count - 1.0);
    let point = |(j, (row, number)): (usize, &(Vec<f64>, usize))| {
        let number = *number;
        row.iter()
            .enumerate()
            .map(move |(i, z)| ([at(low_x, high_x, i, columns), at(low_y, high_y, j, lines), *z], number))
            .collect::<Vec<_>>()
    };
    Ok(rows.iter().enumerate().flat_map(point).collect())
}

/// Turns points on a flat into displacements at their mean height. The heights are the readings: if they were positions too, an error of Z that depends on Z
/// would explain any map.
pub(super) fn flat(
    inquiry: &mut Inquiry<'_>,
    found: Vec<Probed>,
    unit: Option<(ReadingUnit, usize)>,
) -> Result<ImportedReadings, ImportStop> {
    if !inquiry.answer("flat-reference", |own| own.is_flat_reference) {
        let sentence = "a height map is the shape of the plate plus the straightness of the machine: was it probed on a calibrated flat?";
        inquiry.ask(
            "flat-reference",
            sentence,
            "only for a calibrated flat; other plates do not reveal errors of the machine",
        );
    }
    let largest = found.iter().map(|(point, _)| point[0].abs().max(point[1].abs())).fold(0.0, f64::max);
    let unit = match unit {
        Some((unit, 0)) => {
            if inquiry.answer("unit", |own| own.unit).is_some_and(|said| said != unit) {
                let message = format!("--unit contradicts the layout, which is always in {}", unit.sign());
                return Err(inquiry.refused(message, "remove --unit", 0));
            }
            unit
        }
        unit => position_unit(inquiry, unit, largest)?,
    };
    let axes = vec![Axis::X, Axis::Y, Axis::Z];
    let zero = inquiry.zero(&axes, "the zero of the map");
    let tool = inquiry.tool();
    let mut out = ImportedReadings::new(ImportedKind::Displacement, axes.clone(), vec!["dz_um"]);
    out.free = vec!["offset", "rotation"];
    // A map is saved row by row, however it was probed.
    out.is_in_order = false;
    out.fixed = inquiry.other_positions(&axes);
    out.tool_mm = [tool[0], tool[1], tool[2]];
    out.sigma = inquiry.answer("sigma", |own| own.sigma);
    let mean = found.iter().map(|(point, _)| unit.inner(point[2])).sum::<f64>() / found.len().max(1) as f64;
    let level = plane(inquiry, mean, zero[2]);
    let mut worst = (0.0_f64, [0.0; 2]);
    for (point, line) in found {
        let place = point.map(|value| unit.inner(value));
        let fine = (mean - place[2]) * 1000.0;
        if fine.abs() > worst.0.abs() {
            worst = (fine, [place[0] + zero[0], place[1] + zero[1]]);
        }
        let position = vec![place[0] + zero[0], place[1] + zero[1], level];
        out.rows.push(ImportedRow { position, values: vec![Some(fine)], line, ..ImportedRow::default() });
    }
    inquiry.note("height and tilt of the flat are unknowns of the fit; its own flatness is not corrected", 0);
    let mark = if worst.0 < 0.0 { '-' } else { '+' };
    out.sign_sentence = format!(
        "at X {} Y {} the tool is {:.1} µm too far in {mark}Z, seen from the flat",
        shown(worst.1[0]),
        shown(worst.1[1]),
        worst.0.abs()
    );
    Ok(out)
}

/// Z of the rows of a map: the mean height. Where the travel of a printer ends at its bed, a lower bed would be outside of it. The heights are deviations and
/// no commanded positions, so the nominal plane takes its place.
fn plane(inquiry: &mut Inquiry<'_>, mean: f64, zero: f64) -> f64 {
    /// Largest height of a bed above or below its nominal plane, mm.
    const BED: f64 = 5.0;
    let travel = inquiry.machine.axis(Axis::Z).and_then(|axis| axis.travel);
    let is_within = |z: f64| travel.is_none_or(|[low, high]| (low..=high).contains(&z));
    if !is_within(mean + zero) && is_within(zero) && mean.abs() <= BED {
        let note = format!(
            "Z of every row is that of the nominal plane, {}: the mean height, {} mm, is outside of the travel, and the heights are the readings",
            shown(zero),
            shown(mean)
        );
        inquiry.note(note, 0);
        return zero;
    }
    inquiry.note("Z of every row is the mean height, as the heights are the readings", 0);
    mean + zero
}
