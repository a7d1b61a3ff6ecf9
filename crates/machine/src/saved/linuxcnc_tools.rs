//! Tool table of LinuxCNC: `T1 P1 Z+1.25 D0.25 ;remark`. D is a diameter, X Y Z are the offsets of the tip (LinuxCNC manual, *Tool Table*).

use super::lines::{number, words};
use super::{SavedFormat, SavedLine, SavedUnit, SavedValues};
use crate::machine::{Machine, Tool};
use ncfix_base::diagnostic::Diagnostic;

/// Tool table of LinuxCNC.
pub(super) const FORMAT: SavedFormat = SavedFormat { name: "LinuxCNC tool table", language: "rs274", is, read };

/// Words of a line before its remark.
fn entry<'a>(line: &'a SavedLine<'_>) -> Option<Vec<(u8, &'a str)>> {
    words(line.text.split(';').next().unwrap_or_default())
}

fn is(lines: &[SavedLine<'_>]) -> bool {
    let entries: Vec<_> = lines.iter().filter(|line| !line.text.trim_start().starts_with(';')).map(entry).collect();
    let is_tool = |entry: &Option<Vec<(u8, &str)>>| {
        entry
            .as_ref()
            .is_some_and(|words| words.len() >= 2 && words[0].0 == b'T' && words.iter().any(|word| word.0 == b'P'))
    };
    !entries.is_empty() && entries.iter().all(is_tool)
}

fn read(lines: &[SavedLine<'_>], machine: &Machine) -> Result<SavedValues, Diagnostic> {
    let mut out = SavedValues::default();
    for line in lines.iter().filter(|line| !line.text.trim_start().starts_with(';')) {
        let unit = SavedUnit::required(machine, line)?;
        let words = entry(line).unwrap_or_default();
        let get = |letter: u8| words.iter().find(|word| word.0 == letter).and_then(|word| number(word.1));
        let length = |letter: u8| unit.mm(get(letter).unwrap_or_default());
        let Some(tool) = get(b'T').filter(|tool| (0.0..=1e6).contains(tool) && tool.fract() == 0.0) else {
            return Err(line.fault("T is not a tool number", "write for example T1 P1 Z25 D6"));
        };
        out.tools.push(Tool {
            number: tool as u32,
            name: None,
            edge: 1,
            length_mm: [length(b'Z'), length(b'Y'), length(b'X')],
            radius_mm: length(b'D').abs() / 2.0,
        });
    }
    Ok(out)
}
