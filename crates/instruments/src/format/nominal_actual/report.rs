//! Features of reports that are no tables: DMIS output, and blocks with `DIM`.

use std::collections::BTreeMap;

use ncfix_base::csv::DecimalSign;

use super::feature::{ACTUAL, Feature, NOMINAL, StatedFeatures, coordinate};
use crate::grid;
use crate::inquiry::{ImportStop, Inquiry};
use crate::text::DecodedText;
use crate::unit::ReadingUnit;

/// Lines of a DMIS output, with those that go on joined: `F(name)=…`, `FA(name)=…`.
pub(super) fn dmis_lines(text: &DecodedText) -> impl Iterator<Item = (usize, bool, String, String)> {
    let mut joined: Vec<(usize, String)> = Vec::new();
    let mut is_open = false;
    for (number, line, _) in text.lines() {
        let body = line.trim();
        match joined.last_mut().filter(|_| is_open) {
            Some((_, last)) if last.len() < 4096 => last.push_str(body.trim_end_matches('$')),
            _ => joined.push((number, body.trim_end_matches('$').to_owned())),
        }
        is_open = body.ends_with('$');
    }
    joined.into_iter().filter_map(|(number, line)| {
        let upper = line.to_uppercase();
        let is_actual = upper.starts_with("FA(");
        if !is_actual && !upper.starts_with("F(") {
            return None;
        }
        let (head, body) = line.split_once('=')?;
        let name = head.split_once('(')?.1.split(')').next()?.trim().to_owned();
        body.trim().to_uppercase().starts_with("FEAT/").then(|| (number, is_actual, name, body.trim().to_owned()))
    })
}

/// Takes the unit that another line of a report states.
///
/// # Errors
/// If it differs from the first one.
fn same_unit(
    inquiry: &Inquiry<'_>,
    first: Option<(ReadingUnit, usize)>,
    next: (ReadingUnit, usize),
) -> Result<Option<(ReadingUnit, usize)>, ImportStop> {
    match first {
        Some((unit, line)) if unit != next.0 => {
            let message = format!("the line states {}, and line {line} {}", next.0.sign(), unit.sign());
            Err(inquiry.refused(message, "export the report in one unit", next.1))
        }
        first => Ok(first.or(Some(next))),
    }
}

/// Features of a DMIS output.
pub(super) fn dmis(inquiry: &mut Inquiry<'_>) -> Result<StatedFeatures, ImportStop> {
    let mut unit = None;
    for (number, line, _) in inquiry.text.lines() {
        if let Some(rest) = line.trim().to_uppercase().strip_prefix("UNITS/") {
            let word = rest.split(',').next().unwrap_or_default().trim().to_owned();
            if let Some(found) = ReadingUnit::find(&word) {
                unit = same_unit(inquiry, unit, (found, number))?;
            }
        }
    }
    let mut found: BTreeMap<String, Feature> = BTreeMap::new();
    let mut order = Vec::new();
    for (line, is_actual, name, body) in dmis_lines(inquiry.text) {
        let cells: Vec<&str> = body.split(',').map(str::trim).collect();
        let Some(start) = cells.iter().position(|cell| cell.eq_ignore_ascii_case("CART")) else {
            inquiry.note(format!("feature {name} is not in Cartesian coordinates and is not read"), line);
            continue;
        };
        let mut values = [None; 3];
        for (k, value) in values.iter_mut().enumerate() {
            let cell = cells.get(start + 1 + k).copied().unwrap_or_default();
            *value = Some(grid::number(cell, DecimalSign::Point).ok_or_else(|| {
                inquiry.refused(format!("'{cell}' of feature {name} is not a number"), "export the report again", line)
            })?);
        }
        if !found.contains_key(&name) {
            order.push(name.clone());
        }
        let one = found.entry(name).or_default();
        one.line = line;
        *(if is_actual { &mut one.actual } else { &mut one.nominal }) = values;
    }
    inquiry.note(format!("DMIS output with {} features", order.len()), 0);
    let without: Vec<&String> =
        order.iter().filter(|name| found[*name].nominal[0].is_none() || found[*name].actual[0].is_none()).collect();
    if let Some(first) = without.first() {
        let message = format!(
            "feature {first} has no nominal or no actual position ({} of {} features)",
            without.len(),
            order.len()
        );
        return Err(inquiry.refused(
            message,
            "export nominal (F) and actual (FA) features, or remove those that were not measured",
            found[*first].line,
        ));
    }
    Ok((order.iter().filter_map(|name| found.get(name).cloned()).collect(), unit))
}

/// Features of a report in blocks: `DIM NAME= LOCATION OF … UNITS=MM`, a heading, and rows that begin with X, Y or Z. The user sets the order of the columns, so the
/// heading decides.
pub(super) fn report(inquiry: &mut Inquiry<'_>) -> Result<StatedFeatures, ImportStop> {
    let mut features: Vec<Feature> = Vec::new();
    let mut unit = None;
    let mut heading: Vec<String> = Vec::new();
    let mut skipped = 0;
    for (number, line, _) in inquiry.text.lines() {
        let mut cells: Vec<&str> = line.split_whitespace().collect();
        // A bar of the position in the tolerance: `----#----`.
        if cells.len() > 1
            && cells.last().is_some_and(|cell| cell.len() > 1 && cell.chars().all(|c| "-#<>|=*.".contains(c)))
        {
            cells.pop();
        }
        let Some(first) = cells.first() else { continue };
        let of = |names: &[&str]| heading.iter().position(|own| names.contains(&own.as_str()));
        if *first == "DIM" {
            features.push(Feature { line: number, ..Feature::default() });
            heading.clear();
            if let Some(found) = line
                .to_uppercase()
                .split_once("UNITS=")
                .and_then(|(_, rest)| ReadingUnit::find(rest.split([',', ' ']).next()?))
            {
                unit = same_unit(inquiry, unit, (found, number))?;
            }
        } else if first.eq_ignore_ascii_case("AX") {
            heading = cells.iter().map(|cell| cell.to_lowercase()).collect();
        } else if let (Some(k), Some(feature)) = (coordinate(first).filter(|_| first.len() == 1), features.last_mut()) {
            let (Some(nominal), Some(actual)) = (of(NOMINAL), of(ACTUAL)) else {
                let message = "the row has no heading that names its nominal and measured value";
                return Err(inquiry.refused(message, "print the headings AX NOMINAL MEAS into the report", number));
            };
            if cells.len() != heading.len() {
                let message = format!("the row has {} cells, and its heading names {}", cells.len(), heading.len());
                return Err(inquiry.refused(message, "print a value for each heading into the report", number));
            }
            let value = |index: usize| cells.get(index).and_then(|cell| grid::number(cell, DecimalSign::Point));
            let (Some(nominal), Some(actual)) = (value(nominal), value(actual)) else {
                return Err(inquiry.refused("a value of the row is not a number", "export the report again", number));
            };
            feature.nominal[k] = Some(nominal);
            feature.actual[k] = Some(actual);
        } else if !heading.is_empty() && cells.len() == heading.len() {
            skipped += 1;
        }
    }
    if skipped > 0 {
        inquiry.note(format!("{skipped} rows that are no coordinate (diameter, form, position) are not read"), 0);
    }
    if features.is_empty() {
        return Err(inquiry.refused("the report has no features", "export nominal and measured positions", 0));
    }
    Ok((features, unit))
}
