//! Text files in sections: `HEADER::`, `TARGET DATA::`, `DEVIATIONS::`, as laser software writes them.
//!
//! The layout is not published. The reader relies on little: lines that end with `::` begin a section, targets follow the word, and rows of three numbers are
//! run, number of the target, deviation. Directions follow from the order of the rows. Unit and sign are never assumed.

use ncfix_base::csv::DecimalSign;

use super::InstrumentFormat;
use super::targets::{StatedFacts, TargetReading, direct};
use crate::grid;
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::ImportedReadings;
use crate::text::DecodedText;
use crate::words;

/// The format.
pub(super) const FORMAT: InstrumentFormat = InstrumentFormat {
    name: "sections",
    title: "laser file in sections that begin with HEADER:: (.rtl and its relatives)",
    needs: "axis component at sign unit tool material",
    recognize: |text| u8::from(text.line(1).trim().eq_ignore_ascii_case("HEADER::")) * 3,
    read,
};

/// Most targets of a file.
const MOST_TARGETS: usize = 100_000;

fn read(inquiry: &mut Inquiry<'_>) -> Result<ImportedReadings, ImportStop> {
    let mut section = String::new();
    let mut targets: Vec<f64> = Vec::new();
    let mut count = None;
    let mut is_list = false;
    let mut rows: Vec<(u32, usize, f64, usize)> = Vec::new();
    let mut facts = StatedFacts::default();
    let mut has_end = false;
    let text: &DecodedText = inquiry.text;
    for (number, line, _) in text.lines() {
        let body = line.trim();
        if let Some(name) = body.strip_suffix("::") {
            section = name.to_uppercase();
            has_end |= section.starts_with("EOF");
            is_list = false;
            continue;
        }
        let numbers: Option<Vec<f64>> =
            body.split_whitespace().map(|cell| grid::number(cell, DecimalSign::Point)).collect();
        if let Some((key, value)) = body.split_once(':') {
            facts.note_component(body, number);
            let key = key.trim().to_lowercase();
            is_list = key.starts_with("targets");
            if key.contains("count") && section.starts_with("TARGET") {
                count = value.trim().parse::<usize>().ok();
            }
            if key.trim() == "axis"
                && let Some(axis) = words::axis(&value.trim().to_lowercase())
            {
                facts.axis = Some((axis, number));
            }
            if key.contains("unit")
                && let Some(unit) = crate::unit::ReadingUnit::find(value)
            {
                facts.unit = Some((unit, number));
            }
            if key.contains("type")
                && ["angular", "straight", "flat"].iter().any(|word| value.to_lowercase().contains(word))
            {
                facts.other_quantity = Some(number);
            }
        } else if let Some(numbers) = numbers.filter(|numbers| !numbers.is_empty()) {
            if is_list && targets.len() < MOST_TARGETS {
                targets.extend(numbers);
            } else if let ([run, target, value], true) = (&numbers[..], section.starts_with("DEVIATION")) {
                let is_index = |value: f64| value.fract() == 0.0 && (1.0..=1e6).contains(&value);
                if !is_index(*run) || !is_index(*target) {
                    return Err(inquiry.refused(
                        "the row does not begin with the numbers of run and target",
                        "export the readings as CSV",
                        number,
                    ));
                }
                rows.push((*run as u32, *target as usize, *value, number));
            } else if section.starts_with("DEVIATION") {
                let message = format!("the row has {} numbers instead of run, target and deviation", numbers.len());
                return Err(inquiry.refused(message, "export the readings as CSV", number));
            }
        }
    }
    if let Some(count) = count.filter(|count| *count != targets.len()) {
        return Err(inquiry.refused(
            format!("the file states {count} targets and has {}", targets.len()),
            "the file may be cut: export it again",
            0,
        ));
    }
    if !has_end {
        return Err(inquiry.refused(
            "the file has no end mark EOF::",
            "the file may be cut: copy or export it again",
            0,
        ));
    }
    let mut found: Vec<TargetReading> = Vec::new();
    for (index, (run, target, value, line)) in rows.iter().enumerate() {
        let at = |number: usize| number.checked_sub(1).and_then(|index| targets.get(index)).copied();
        let Some(place) = at(*target) else {
            return Err(inquiry.refused(
                format!("there is no target {target}"),
                "the file may be cut: export it again",
                *line,
            ));
        };
        // Up or down as the rows of the run go; the last row of a run went like the one before it.
        let neighbor =
            |other: usize| rows.get(other).filter(|(own, ..)| own == run).and_then(|(_, number, ..)| at(*number));
        let before = index.checked_sub(1).and_then(neighbor).filter(|before| *before != place);
        let sense = before
            .map(|before| place > before)
            .or(neighbor(index + 1).filter(|after| *after != place).map(|after| after > place));
        found.push(TargetReading {
            run: run.to_string(),
            target: place,
            sense: sense.map(|is_up| if is_up { 1 } else { -1 }),
            value: *value,
            component: None,
            unit: None,
            line: *line,
        });
    }
    inquiry.note(
        format!("{} targets, {} readings; directions follow from the order of the rows", targets.len(), found.len()),
        0,
    );
    direct(inquiry, found, facts)
}
