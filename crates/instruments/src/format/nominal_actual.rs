//! Features with nominal and actual positions: reports of coordinate measuring machines, and points of a laser tracker with their set-points.
//!
//! Layouts: DMIS output (`F(name)=FEAT/…` and `FA(name)=FEAT/…`), a row for each feature (`name, nom x, nom y, act x, act y`), a row for each coordinate
//! (`name, axis, nominal, actual, deviation` in the order of the headings). A workpiece machined here shows the displacement of the tool; a calibrated artifact
//! probed here shows the opposite. Offset and rotation of the report remain unknowns of the fit.

mod feature;
mod report;

use ncfix_base::geometry::Axis;

use super::InstrumentFormat;
use crate::answers::ReadingMaterial;
use crate::grid::{self, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::{ImportedKind, ImportedReadings, ImportedRow, shown};
use crate::row_fact::{RowFact, row_fact};
use crate::rows;
use crate::signs::SignMeaning;
use crate::text::DecodedText;
use crate::unit::ReadingUnit;
use crate::words::{self, ColumnRole};
use feature::{ACTUAL, Feature, NOMINAL, StatedFeatures, coordinate};
use report::{dmis, dmis_lines, report};

/// The question for the sign: where the features come from.
const ORIGIN: &str = "the file does not state the origin of the features: were they machined on this machine (+), or is it a calibrated artifact that was probed here (-)?";
/// Place whose machine position is asked for, and the body whose temperature is.
const ZERO: &str = "the zero of the nominal positions";
const MATERIAL: &str = "the workpiece or artifact";

/// The format.
pub(super) const FORMAT: InstrumentFormat = InstrumentFormat {
    name: "nominal-actual",
    title: "features with nominal and actual position: coordinate measuring machine (table, DMIS output), tracker points with set-points",
    needs: "at sign unit tool material",
    recognize,
    read,
};

/// Part of a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Nominal,
    Actual,
    Deviation,
}

fn recognize(text: &DecodedText) -> u8 {
    if dmis_lines(text).next().is_some() || text.lines().any(|(_, line, _)| line.trim_start().starts_with("DIM ")) {
        return 3;
    }
    let Ok(table) = grid::table(text) else { return 0 };
    let parts = parts(&table);
    let has = |wanted: Part| parts.iter().any(|(_, part, axis)| *part == wanted && axis.is_some());
    if has(Part::Nominal) && has(Part::Actual) {
        return 3;
    }
    let in_rows = |wanted: Part| parts.iter().any(|(_, part, axis)| *part == wanted && axis.is_none());
    if in_rows(Part::Nominal) && in_rows(Part::Actual) && axis_column(&table).is_some() { 3 } else { 0 }
}

const DEVIATION: &[&str] = &["dev", "deviation", "err", "error", "abw", "abweichung", "écart", "diff"];

/// Columns with the part of a feature that they have, and the coordinate of headings such as `nom_x`.
fn parts(table: &GridTable) -> Vec<(usize, Part, Option<usize>)> {
    let mut found = Vec::new();
    for (index, heading) in table.headings.iter().enumerate() {
        let words: Vec<&str> =
            heading.words.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
        let part_of = |word: &str| match word {
            _ if NOMINAL.contains(&word) => Some(Part::Nominal),
            _ if ACTUAL.contains(&word) => Some(Part::Actual),
            _ if DEVIATION.contains(&word) => Some(Part::Deviation),
            _ => None,
        };
        let coordinate = words.iter().find_map(|word| ["x", "y", "z"].iter().position(|own| own == word));
        let part = words.iter().find_map(|word| part_of(word));
        if let (Some(part), true) = (part, words.len() <= 3 && (coordinate.is_some() || words.len() == 1)) {
            found.push((index, part, coordinate));
        }
    }
    found
}

/// Column whose cells are names of coordinates.
fn axis_column(table: &GridTable) -> Option<usize> {
    (0..table.width()).find(|&column| {
        let cells = table.rows.iter().filter_map(|row| row.cells.get(column));
        let count = cells.filter(|cell| coordinate(&cell.text).is_some()).count();
        count >= 2 && 2 * count >= table.rows.len()
    })
}

/// Column with the name of the feature: of those with names, the first one that several coordinates share. Without one, the column before the coordinates.
fn name_column(table: &GridTable, labels: usize) -> Option<usize> {
    let cell =
        |row: &grid::GridLine, column: usize| row.cells.get(column).map_or_else(String::new, |cell| cell.text.clone());
    let is_shared = |column: &usize| {
        table.rows.windows(2).any(|pair| {
            cell(&pair[0], *column) == cell(&pair[1], *column)
                && coordinate(&cell(&pair[0], labels)) != coordinate(&cell(&pair[1], labels))
        })
    };
    let is_name = |column: &usize| {
        table.headings.get(*column).is_some_and(|heading| words::role(&heading.words) == ColumnRole::Name)
    };
    let named = (0..table.width()).filter(|column| *column != labels && is_name(column));
    named.into_iter().find(is_shared).or_else(|| (0..labels).next_back())
}

/// Unit in a column of its own, the same in all rows of coordinates; `labels` is the column with their names.
fn row_unit(
    inquiry: &Inquiry<'_>,
    table: &GridTable,
    labels: Option<usize>,
) -> Result<Option<(ReadingUnit, usize)>, ImportStop> {
    let Some(column) = table.headings.iter().position(|heading| row_fact(&heading.words) == Some(RowFact::Unit)) else {
        return Ok(None);
    };
    let mut found: Option<(ReadingUnit, usize)> = None;
    for row in &table.rows {
        let label = labels.map(|column| row.cells.get(column).and_then(|cell| coordinate(&cell.text)));
        if label.is_some_and(|coordinate| coordinate.is_none()) {
            continue;
        }
        let text = row.cells.get(column).map_or("", |cell| cell.text.as_str());
        let Some(unit) = ReadingUnit::find(text) else {
            let message = format!("'{text}' is not the unit of a position");
            return Err(inquiry.refused(message, "write mm or inch into the column of the unit", row.number));
        };
        if let Some((first, line)) = found.filter(|(first, _)| *first != unit) {
            let message = format!("the row is in {}, and line {line} in {}", unit.sign(), first.sign());
            return Err(inquiry.refused(message, "export all positions in one unit", row.number));
        }
        found.get_or_insert((unit, row.number));
    }
    Ok(found)
}

fn read(inquiry: &mut Inquiry<'_>) -> Result<ImportedReadings, ImportStop> {
    let is_dmis = dmis_lines(inquiry.text).next().is_some();
    let is_report = inquiry.text.lines().any(|(_, line, _)| line.trim_start().starts_with("DIM "));
    let (features, unit) = match (is_dmis, is_report) {
        (true, _) => dmis(inquiry)?,
        (false, true) => report(inquiry)?,
        (false, false) => tabular(inquiry)?,
    };
    let (features, gaps) = complete(inquiry, features)?;
    check_order(inquiry, &features)?;
    let mut readings = displacement(inquiry, features, unit)?;
    readings.gaps = gaps;
    Ok(readings)
}

/// Features with a pair of values and all nominal coordinates, and a sentence about the others: without a coordinate the position is not known.
///
/// # Errors
/// If more than half of the features are not complete.
fn complete(inquiry: &Inquiry<'_>, features: Vec<Feature>) -> Result<(Vec<Feature>, Vec<String>), ImportStop> {
    let kinds: Vec<usize> = (0..3).filter(|k| features.iter().any(|one| one.nominal[*k].is_some())).collect();
    let count = features.len();
    let is_complete = |one: &Feature| {
        kinds.iter().all(|k| one.nominal[*k].is_some())
            && one.actual.iter().zip(&one.nominal).any(|(actual, nominal)| actual.is_some() && nominal.is_some())
    };
    let (whole, parts): (Vec<Feature>, Vec<Feature>) = features.into_iter().partition(is_complete);
    let Some(first) = parts.first() else { return Ok((whole, Vec::new())) };
    if 2 * parts.len() > count {
        let message = format!("{} of {count} features lack a nominal coordinate or an actual value", parts.len());
        return Err(inquiry.refused(message, "export nominal and actual value of each coordinate", first.line));
    }
    let lines: Vec<String> = parts.iter().take(6).map(|one| one.line.to_string()).collect();
    let dots = if parts.len() > lines.len() { " …" } else { "" };
    let sentence =
        format!("features that are not complete, and not read: {} (line {}{dots})", parts.len(), lines.join(", "));
    Ok((whole, vec![sentence]))
}

/// Checks that nominal and actual values are not exchanged: nominal values are round, actual ones are not.
///
/// # Errors
/// If the actual values are the round ones, and no option names the columns.
fn check_order(inquiry: &Inquiry<'_>, features: &[Feature]) -> Result<(), ImportStop> {
    if !inquiry.answers().columns.is_empty() {
        return Ok(());
    }
    let pairs = features.iter().flat_map(|one| one.nominal.iter().zip(&one.actual));
    let pairs: Vec<(f64, f64)> = pairs.filter_map(|(nominal, actual)| nominal.zip(*actual)).collect();
    if rows::is_exchanged(&pairs) {
        let message = "the actual values are round and the nominal ones are not: they may be exchanged";
        let help = "correct the headings, or confirm them with --columns, such as name,nominal x,actual x";
        return Err(inquiry.refused(message, help, features.first().map_or(0, |one| one.line)));
    }
    Ok(())
}

/// Features of a table.
fn tabular(inquiry: &mut Inquiry<'_>) -> Result<StatedFeatures, ImportStop> {
    let mut table = grid::table(inquiry.text)?;
    if !inquiry.answers().columns.is_empty() {
        table.headings = inquiry.headings(&table)?;
    }
    let parts = parts(&table);
    let line = table.heading_line;
    let mut unit = inquiry.one_unit(parts.iter().map(|(index, ..)| table.headings.get(*index)?.unit), line)?;
    let unread: Vec<String> = table
        .headings
        .iter()
        .enumerate()
        .filter(|(index, heading)| {
            parts.iter().all(|(own, ..)| own != index)
                && words::role(&heading.words) == ColumnRole::Unknown
                && row_fact(&heading.words) != Some(RowFact::Unit)
                && !words::is_driver(&heading.written)
                && !heading.written.is_empty()
        })
        .map(|(_, heading)| heading.written.clone())
        .collect();
    inquiry.check_places(&table)?;
    if !unread.is_empty() {
        inquiry.note(format!("columns that are not read: {}", unread.join(", ")), line);
    }
    let of = |wanted: Part, axis: Option<usize>| {
        parts.iter().find(|(_, part, own)| *part == wanted && *own == axis).map(|(index, ..)| *index)
    };
    let mut features: Vec<Feature> = Vec::new();
    if let Some(labels) = axis_column(&table).filter(|_| of(Part::Nominal, None).is_some()) {
        let (Some(nominal), Some(actual)) = (of(Part::Nominal, None), of(Part::Actual, None)) else {
            inquiry.ask(
                "columns",
                "no headings name the nominal and the actual values",
                "the meaning of each column, such as name,axis,nominal,actual,-",
            );
            // Whatever the columns are, these are open too: all questions come in one round.
            position_unit(inquiry, unit, 0.0)?;
            inquiry.sign(None, ORIGIN, SignMeaning::Origin)?;
            inquiry.zero(&[Axis::X, Axis::Y, Axis::Z], ZERO);
            inquiry.other_positions(&[Axis::X, Axis::Y, Axis::Z]);
            inquiry.tool();
            inquiry.material(MATERIAL)?;
            return Err(ImportStop::Asks);
        };
        let names = name_column(&table, labels);
        unit = unit.or(row_unit(inquiry, &table, Some(labels))?);
        let mut last = None;
        let mut skipped = 0;
        for row in &table.rows {
            let name = names
                .and_then(|column| row.cells.get(column))
                .map(|cell| cell.text.clone())
                .filter(|name| !name.is_empty());
            let Some(k) = row.cells.get(labels).and_then(|cell| coordinate(&cell.text)) else {
                skipped += 1;
                continue;
            };
            let is_new =
                features.last().is_none_or(|feature| feature.nominal[k].is_some()) || (name.is_some() && name != last);
            if is_new {
                features.push(Feature { line: row.number, ..Feature::default() });
            }
            last = name.or(last);
            let values = (table.needed(row, nominal)?, table.needed(row, actual)?);
            check_deviation(inquiry, &table, row, of(Part::Deviation, None), values)?;
            if let Some(feature) = features.last_mut() {
                feature.nominal[k] = Some(values.0);
                feature.actual[k] = Some(values.1);
            }
        }
        if skipped > 0 {
            inquiry.note(format!("{skipped} rows that are no coordinate (diameter, form, position) are not read"), 0);
        }
        let counts = features.iter().map(|feature| feature.nominal.iter().flatten().count());
        let kinds = (0..3).filter(|k| features.iter().any(|feature| feature.nominal[*k].is_some())).count();
        if kinds > 1 && counts.max() == Some(1) {
            let message = "no two rows belong to one feature, so the other coordinates of its position are not known";
            let help = "give the rows of a feature one name, in a column 'feature'";
            return Err(inquiry.refused(message, help, features.first().map_or(line, |feature| feature.line)));
        }
    } else {
        unit = unit.or(row_unit(inquiry, &table, None)?);
        for row in &table.rows {
            let mut feature = Feature { line: row.number, ..Feature::default() };
            for k in 0..3 {
                let Some(nominal) = of(Part::Nominal, Some(k)) else { continue };
                feature.nominal[k] = table.value(row, nominal)?;
                let Some(actual) = of(Part::Actual, Some(k)) else { continue };
                feature.actual[k] = table.value(row, actual)?;
                if let (Some(nominal), Some(actual)) = (feature.nominal[k], feature.actual[k]) {
                    check_deviation(inquiry, &table, row, of(Part::Deviation, Some(k)), (nominal, actual))?;
                }
            }
            features.push(feature);
        }
    }
    if features.is_empty() {
        return Err(inquiry.refused(
            "the table has no features with nominal and actual positions",
            "name the columns with --columns",
            line,
        ));
    }
    Ok((features, unit))
}

/// Checks a printed deviation against nominal and actual value.
fn check_deviation(
    inquiry: &mut Inquiry<'_>,
    table: &GridTable,
    row: &grid::GridLine,
    column: Option<usize>,
    (nominal, actual): (f64, f64),
) -> Result<(), ImportStop> {
    let Some(column) = column else { return Ok(()) };
    let Some(deviation) = table.value(row, column)? else { return Ok(()) };
    let digits = row
        .cells
        .get(column)
        .and_then(|cell| cell.text.rsplit_once(['.', ',']))
        .map_or(0, |(_, digits)| digits.len().min(9));
    let slack = 1.5 * 10f64.powi(-(digits as i32));
    let difference = actual - nominal;
    if (difference - deviation).abs() <= slack {
        return Ok(());
    }
    if (difference + deviation).abs() <= slack {
        inquiry.note("the printed deviation is nominal minus actual; nominal and actual values are used", row.number);
        return Ok(());
    }
    let message = format!("the deviation {} is not actual minus nominal, {}", shown(deviation), shown(difference));
    Err(inquiry.refused(message, "check the order of the columns, or name them with --columns", row.number))
}

/// Turns features into displacements.
fn displacement(
    inquiry: &mut Inquiry<'_>,
    features: Vec<Feature>,
    unit: Option<(ReadingUnit, usize)>,
) -> Result<ImportedReadings, ImportStop> {
    let largest = features
        .iter()
        .flat_map(|feature| feature.nominal.iter().flatten())
        .map(|value| value.abs())
        .fold(0.0, f64::max);
    let quarters = inquiry.quarter_turns();
    let features: Vec<Feature> = features.into_iter().map(|feature| feature.turned(quarters)).collect();
    let unit = position_unit(inquiry, unit, largest)?;
    let sign = inquiry.sign(None, ORIGIN, SignMeaning::Origin)?;
    let axes: Vec<Axis> = [Axis::X, Axis::Y, Axis::Z]
        .into_iter()
        .enumerate()
        .filter(|(k, axis)| {
            inquiry.machine.axis(*axis).is_some() && features.iter().any(|feature| feature.nominal[*k].is_some())
        })
        .map(|(_, axis)| axis)
        .collect();
    let measured: Vec<usize> = (0..3)
        .filter(|&k| {
            let pairs = features.iter().filter_map(|feature| feature.nominal[k].zip(feature.actual[k]));
            // A coordinate that always has its nominal value was not measured, such as the height of a circle.
            pairs.filter(|(nominal, actual)| nominal.to_bits() != actual.to_bits()).count() > 0
        })
        .collect();
    let all_given =
        |k: usize| features.iter().any(|feature| feature.actual[k].is_some() && feature.nominal[k].is_some());
    for k in (0..3).filter(|k| all_given(*k) && !measured.contains(k)) {
        inquiry.note(format!("{} always has its nominal value and counts as not measured", ['X', 'Y', 'Z'][k]), 0);
    }
    let zero = inquiry.zero(&axes, ZERO);
    let tool = inquiry.tool();
    let material = inquiry.material(MATERIAL)?;
    let names = ["dx_um", "dy_um", "dz_um"];
    let mut out = ImportedReadings::new(
        ImportedKind::Displacement,
        axes.clone(),
        measured.iter().filter_map(|&k| names.get(k).copied()).collect(),
    );
    out.free = vec!["offset", "rotation"];
    out.fixed = inquiry.other_positions(&axes);
    out.tool_mm = [tool[0], tool[1], tool[2]];
    out.sigma = inquiry.answer("sigma", |own| own.sigma);
    if let ReadingMaterial::Expanded { per_k, celsius } = material {
        out.sections = format!(
            "[artefact]\nexpansion_per_K = {}\ntemperature_C = {}\n",
            format_args!("{per_k:e}"),
            shown(celsius)
        );
    }
    let slots = [Axis::X, Axis::Y, Axis::Z];
    let fixed = out.fixed.clone();
    let mut worst: Option<(f64, usize, [f64; 3])> = None;
    for feature in features {
        let place = |k: usize| unit.inner(feature.nominal[k].unwrap_or(0.0)) + zero[k];
        // An axis without a column stands still.
        let at = |k: usize| fixed.iter().find(|(axis, _)| *axis == slots[k]).map_or_else(|| place(k), |(_, mm)| *mm);
        let mut values = Vec::new();
        for &k in &measured {
            let value =
                feature.nominal[k].zip(feature.actual[k]).map(|(nominal, actual)| sign * unit.fine(actual - nominal));
            // Converted: a part that was warm has contracted since, by its distance from its origin (an offset is an unknown of the fit).
            let grown = 1000.0 * material.stretch() * unit.inner(feature.nominal[k].unwrap_or(0.0));
            if let Some(value) = value
                .map(|value| value + grown)
                .filter(|value| worst.is_none_or(|(most, ..): (f64, _, _)| value.abs() > most.abs()))
            {
                worst = Some((value, k, [0, 1, 2].map(at)));
            }
            values.push(value);
        }
        let position = axes.iter().filter_map(|axis| slots.iter().position(|own| own == axis)).map(place).collect();
        out.rows.push(ImportedRow { position, values, line: feature.line, ..ImportedRow::default() });
    }
    // A report is sorted by name or by place.
    out.is_in_order = false;
    inquiry.note("offset and rotation of the report are unknowns: a small misalignment has no influence, but a fit of the scale would lose the scales of the machine", 0);
    if let Some((value, k, place)) = worst {
        let mark = if value < 0.0 { '-' } else { '+' };
        let letter = ['X', 'Y', 'Z'][k];
        out.sign_sentence = format!(
            "at X {} Y {} Z {} the tool is {:.1} µm too far in {mark}{letter}, seen from the workpiece",
            shown(place[0]),
            shown(place[1]),
            shown(place[2]),
            value.abs()
        );
    }
    Ok(out)
}

/// Unit of positions: the size of the numbers does not separate mm from inches.
pub(super) fn position_unit(
    inquiry: &mut Inquiry<'_>,
    found: Option<(ReadingUnit, usize)>,
    largest: f64,
) -> Result<ReadingUnit, ImportStop> {
    if inquiry.answers().unit.is_none() && found.is_none() && inquiry.stated_units()?.is_empty() {
        let sentence = format!("the file does not state the unit of its positions (largest {})", shown(largest));
        inquiry.ask("unit", sentence, "mm or inch");
        return Ok(ReadingUnit::Length("mm", 1.0));
    }
    inquiry.unit(found, false, largest)
}
