//! Lists of displacements: R-test, grid plates, indicators: axis positions with dx, dy, dz in each row.
//!
//! A displacement is that of the tool relative to the workpiece, along the axes of F. A file of an instrument may state the opposite, so the sign is asked.

use ncfix_base::geometry::Axis;

use super::{InstrumentFormat, axis_columns};
use crate::grid::{self, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::{ImportedKind, ImportedReadings, ImportedRow, shown};
use crate::signs::SignMeaning;
use crate::text::DecodedText;
use crate::words::{self, ColumnRole};

/// The format.
pub(super) const FORMAT: InstrumentFormat = InstrumentFormat {
    name: "displacements",
    title: "list of poses with dx, dy, dz: R-test, grid plate, indicators",
    needs: "at sign unit tool",
    recognize: |text: &DecodedText| u8::from(grid::table(text).is_ok_and(|table| columns(&table).is_some())) * 3,
    read,
};

/// Columns of the axes, and of dx, dy, dz.
type Columns = (Vec<(usize, Axis)>, Vec<(usize, usize)>);

/// The axis whose direction of approach a column states: `X_dir`, `dir X`, `direction of X`, `Richtung X`.
fn approach(words: &str) -> Option<Axis> {
    let mut parts = words.split([' ', '_', '.']).filter(|part| !part.is_empty() && *part != "of");
    let (first, last) = (parts.next()?, parts.next()?);
    let is_direction =
        |word: &str| matches!(word, "dir" | "direction" | "approach" | "sense" | "richtung" | "sens" | "senso");
    let letter = match (is_direction(first), is_direction(last), parts.next()) {
        (true, false, None) => last,
        (false, true, None) => first,
        _ => return None,
    };
    match letter.as_bytes() {
        [letter] => Axis::from_letter(letter.to_ascii_uppercase()),
        _ => None,
    }
}

/// Columns of the axes, and of dx, dy, dz.
fn columns(table: &GridTable) -> Option<Columns> {
    let axes = axis_columns(table);
    let reading = |words: &str| match words {
        "dx" | "delta x" | "error x" | "dev x" | "abw x" | "x error" => Some(0),
        "dy" | "delta y" | "error y" | "dev y" | "abw y" | "y error" => Some(1),
        "dz" | "delta z" | "error z" | "dev z" | "abw z" | "z error" => Some(2),
        _ => None,
    };
    let values: Vec<(usize, usize)> = table
        .headings
        .iter()
        .enumerate()
        .filter_map(|(index, heading)| Some((index, reading(&heading.words)?)))
        .collect();
    let is_once = (0..3).all(|k| values.iter().filter(|(_, own)| *own == k).count() <= 1)
        && axes.iter().all(|(_, axis)| axes.iter().filter(|(_, own)| own == axis).count() == 1);
    (!axes.is_empty() && !values.is_empty() && is_once).then_some((axes, values))
}

fn read(inquiry: &mut Inquiry<'_>) -> Result<ImportedReadings, ImportStop> {
    let table = grid::table(inquiry.text)?;
    let line = table.heading_line;
    let Some((axes, mut values)) = columns(&table) else {
        return Err(inquiry.refused(
            "the table has no columns of axes and displacements",
            "name them in the headings: X;Y;Z;dx;dy;dz",
            line,
        ));
    };
    values.sort_by_key(|(_, k)| *k);
    if let Some((_, axis)) = axes.iter().find(|(_, axis)| inquiry.machine.axis(*axis).is_none()) {
        return Err(inquiry.refused(
            format!("the machine has no axis {}", char::from(axis.letter())),
            "check --machine and the headings",
            line,
        ));
    }
    let run = table.headings.iter().position(|heading| words::role(&heading.words) == ColumnRole::Run);
    let mut approaches: Vec<(usize, Axis)> = Vec::new();
    for (index, heading) in table.headings.iter().enumerate() {
        let Some(axis) = approach(&heading.words).filter(|axis| axes.iter().any(|(_, own)| own == axis)) else {
            continue;
        };
        if approaches.iter().any(|(_, own)| *own == axis) {
            let message = format!("two columns state the direction of approach of {}", char::from(axis.letter()));
            return Err(inquiry.refused(message, "remove one of them", line));
        }
        approaches.push((index, axis));
    }
    let used = |index: usize| {
        approaches.iter().any(|(own, _)| *own == index)
            || axes.iter().any(|(own, _)| *own == index)
            || values.iter().any(|(own, _)| *own == index)
            || run == Some(index)
    };
    let unread: Vec<usize> = (0..table.headings.len()).filter(|index| !used(*index)).collect();
    inquiry.unread(&table, &table.headings, &unread)?;
    let mut largest = 0.0_f64;
    for row in &table.rows {
        for (column, _) in &values {
            largest = largest.max(table.value(row, *column)?.unwrap_or(0.0).abs());
        }
    }
    let stated = inquiry.one_unit(values.iter().map(|(column, _)| table.headings.get(*column)?.unit), line)?;
    let unit = inquiry.unit(stated, false, largest)?;
    let sign = inquiry.sign(None, "the file does not state the sign of its readings: is the tool displaced in the positive direction, seen from the workpiece, where a reading is positive?", SignMeaning::Direction)?;
    let moved: Vec<Axis> = axes.iter().map(|(_, axis)| *axis).collect();
    let tool = inquiry.tool();
    let names = ["dx_um", "dy_um", "dz_um"];
    let mut out = ImportedReadings::new(
        ImportedKind::Displacement,
        moved.clone(),
        values.iter().filter_map(|(_, k)| names.get(*k).copied()).collect(),
    );
    out.fixed = inquiry.other_positions(&moved);
    out.tool_mm = [tool[0], tool[1], tool[2]];
    out.sigma = inquiry.answer("sigma", |own| own.sigma);
    out.extra = approaches.iter().map(|(_, axis)| format!("{}_dir", char::from(axis.letter()))).collect();
    if !out.extra.is_empty() {
        inquiry.note(format!("directions of approach: {}", out.extra.join(", ")), line);
    }
    inquiry.note("positions are machine coordinates", 0);
    let has_unit = |(column, axis): &(usize, Axis)| {
        axis.is_rotary() || table.headings.get(*column).is_some_and(|heading| heading.unit.is_some())
    };
    if !axes.iter().all(has_unit) {
        inquiry.note("the headings of positions state no unit: mm is assumed", line);
    }
    let mut worst: Option<(f64, usize, Vec<f64>)> = None;
    for row in &table.rows {
        let mut position = Vec::new();
        for (column, axis) in &axes {
            let own = table
                .headings
                .get(*column)
                .and_then(|heading| heading.unit)
                .filter(|unit| unit.is_angle() == axis.is_rotary());
            let value = table.needed(row, *column)?;
            position.push(own.map_or(value, |unit| {
                if axis.is_rotary() { unit.inner(value).to_degrees() } else { unit.inner(value) }
            }));
        }
        let mut readings = Vec::new();
        for (column, k) in &values {
            let value = table.value(row, *column)?.map(|value| sign * unit.fine(value));
            if let Some(value) = value.filter(|value| worst.as_ref().is_none_or(|(most, ..)| value.abs() > most.abs()))
            {
                worst = Some((value, *k, position.clone()));
            }
            readings.push(value);
        }
        let mut directions = Vec::new();
        for (column, axis) in &approaches {
            let text = row.cells.get(*column).map_or("", |cell| cell.text.trim());
            let sense = words::sense(text);
            if sense.is_none() && !text.is_empty() && text != "0" {
                let message = format!("'{text}' is not a direction of approach of {}", char::from(axis.letter()));
                return Err(inquiry.refused(
                    message,
                    "write + or -, or leave the cell empty if it is not known",
                    row.number,
                ));
            }
            directions.push(sense.map(f64::from));
        }
        let label = run.and_then(|index| row.cells.get(index)).map_or_else(String::new, |cell| cell.text.clone());
        out.rows.push(ImportedRow {
            run: label,
            position,
            values: readings,
            extra: directions,
            line: row.number,
            ..ImportedRow::default()
        });
    }
    if let Some((value, k, position)) = worst {
        let place: Vec<String> = moved
            .iter()
            .zip(position)
            .map(|(axis, value)| format!("{} {}", char::from(axis.letter()), shown(value)))
            .collect();
        let mark = if value < 0.0 { '-' } else { '+' };
        out.sign_sentence = format!(
            "at {} the tool is {:.1} µm too far in {mark}{}, seen from the workpiece",
            place.join(" "),
            value.abs(),
            ['X', 'Y', 'Z'][k]
        );
    }
    Ok(out)
}
