//! Tool table of a Heidenhain: `BEGIN TOOL.T MM`, a line of column names, rows at fixed columns, `[END]`. Length is L + DL, radius is R + DR.
//!
//! Preset tables (`.PR`) are recognized and refused: a preset has no name among the zero offsets of the languages that ncfix reads.

use super::lines::number;
use super::{SavedFormat, SavedLine, SavedUnit, SavedValues};
use crate::machine::{Machine, Tool};
use ncfix_base::diagnostic::Diagnostic;

/// Tables of a Heidenhain.
pub(super) const FORMAT: SavedFormat = SavedFormat { name: "Heidenhain table", language: "", is, read };

/// File name and unit of the first line.
fn head(lines: &[SavedLine<'_>]) -> Option<(String, SavedUnit)> {
    let text = lines.first()?.text.trim().to_ascii_uppercase();
    let mut words = text.strip_prefix("BEGIN ")?.split_whitespace();
    let file = words.next()?.to_owned();
    let unit = match words.next()? {
        "MM" => SavedUnit::Millimeter,
        "INCH" => SavedUnit::Inch,
        _ => return None,
    };
    file.contains('.').then_some((file, unit))
}

fn is(lines: &[SavedLine<'_>]) -> bool {
    head(lines).is_some()
}

/// Columns by their names: first and last character.
fn columns(text: &str) -> Vec<(String, usize, usize)> {
    let letters: Vec<char> = text.chars().collect();
    let begins = |at: usize| !letters[at].is_whitespace() && (at == 0 || letters[at - 1].is_whitespace());
    let starts: Vec<usize> = (0..letters.len()).filter(|at| begins(*at)).collect();
    let ends = starts.iter().skip(1).copied().chain([usize::MAX]);
    let name = |start: usize| letters[start..].iter().take_while(|letter| !letter.is_whitespace()).collect::<String>();
    starts.iter().zip(ends).map(|(start, end)| (name(*start).to_ascii_uppercase(), *start, end)).collect()
}

fn read(lines: &[SavedLine<'_>], _machine: &Machine) -> Result<SavedValues, Diagnostic> {
    let mut out = SavedValues::default();
    let (Some((file, unit)), Some(first)) = (head(lines), lines.first()) else { return Ok(out) };
    if !file.ends_with(".T") {
        let message = format!("{file} is not a tool table");
        let help = "ncfix reads TOOL.T; write presets as zero offsets into the machine file, with the name that the program uses";
        return Err(first.fault(message, help));
    }
    let is_header = |line: &&SavedLine<'_>| {
        let names = columns(&line.text);
        names.iter().any(|one| one.0 == "T") && names.iter().any(|one| one.0 == "L")
    };
    let Some(at) = lines.iter().position(|line| is_header(&line)) else {
        return Err(
            first.fault("the line with the column names T and L is missing", "save the table at the control again")
        );
    };
    // The control ends each table with this line: without it, the last row may lack digits.
    if let Some(last) = lines.last().filter(|last| !last.text.trim_start().starts_with("[END]")) {
        let help = "save the table again; if it is complete, write [END] in a last line";
        return Err(last.fault("the table does not end with [END], so its end is missing", help));
    }
    let columns = columns(&lines[at].text);
    for line in lines[at + 1..].iter().take_while(|line| !line.text.trim_start().starts_with("[END]")) {
        let letters: Vec<char> = line.text.chars().collect();
        let cell = |name: &str| -> Option<String> {
            let (_, start, end) = columns.iter().find(|one| one.0 == name)?;
            let part: String = letters.get(*start..(*end).min(letters.len()))?.iter().collect();
            Some(part.trim().to_owned()).filter(|text| !text.is_empty())
        };
        let Some(tool) = cell("T") else { continue };
        // A tool with an index, 5.1, is another edge of tool 5.
        let (whole, index) = tool.split_once('.').unwrap_or((&tool, "0"));
        let (Ok(tool), Ok(index)) = (whole.parse::<u32>(), index.parse::<u32>()) else {
            return Err(line.fault(format!("'{tool}' is not a tool number"), "save the table at the control again"));
        };
        let length = |name: &str| match cell(name) {
            None => Ok(0.0),
            Some(text) => number(&text.replace(',', ".")).map(|value| unit.mm(value)).ok_or_else(|| {
                line.fault(format!("'{text}' in column {name} is not a number"), "save the table at the control again")
            }),
        };
        let length_mm = length("L")? + length("DL")?;
        let radius_mm = (length("R")? + length("DR")?).max(0.0);
        if length_mm == 0.0 && radius_mm == 0.0 {
            continue;
        }
        out.tools.push(Tool {
            number: tool,
            name: cell("NAME"),
            edge: index + 1,
            length_mm: [length_mm, 0.0, 0.0],
            radius_mm,
        });
    }
    Ok(out)
}
