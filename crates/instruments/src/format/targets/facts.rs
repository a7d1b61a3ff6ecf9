//! Facts that the lines around a table of targets state.

use ncfix_base::geometry::Axis;

use crate::answers::MeasuredComponent;
use crate::grid::GridTable;
use crate::text::DecodedText;
use crate::unit::ReadingUnit;
use crate::words;

/// One reading before its sign and unit are known.
pub(in crate::format) struct TargetReading {
    /// Label of the repetition.
    pub(in crate::format) run: String,
    /// Target, in the unit of the file.
    pub(in crate::format) target: f64,
    /// Direction of approach.
    pub(in crate::format) sense: Option<i8>,
    /// Reading, in the unit of the file.
    pub(in crate::format) value: f64,
    /// Component, if its heading names it.
    pub(in crate::format) component: Option<MeasuredComponent>,
    /// Unit in its own heading.
    pub(in crate::format) unit: Option<ReadingUnit>,
    /// Line.
    pub(in crate::format) line: usize,
}

/// Facts that the file itself states.
#[derive(Default)]
pub(in crate::format) struct StatedFacts {
    /// Axis and its line.
    pub(in crate::format) axis: Option<(Axis, usize)>,
    /// Sign and its line.
    pub(in crate::format) sign: Option<(f64, usize)>,
    /// Unit of the readings and its line.
    pub(in crate::format) unit: Option<(ReadingUnit, usize)>,
    /// Unit of the targets and its line.
    pub(in crate::format) target_unit: Option<(ReadingUnit, usize)>,
    /// Line with a word for another quantity than positioning.
    pub(in crate::format) other_quantity: Option<usize>,
}

/// Words of quantities other than positioning.
const OTHER: &[&str] = &[
    "straight",
    "gerad",
    "rectitude",
    "rettilin",
    "rectitud",
    "pitch",
    "yaw",
    "roll",
    "angle",
    "angular",
    "winkel",
    "nick",
    "gier",
    "roll",
    "level",
    "neigung",
    "inclin",
    "flatness",
    "squareness",
];

/// Reads the facts in the lines around a table.
pub(in crate::format) fn stated(text: &DecodedText, table: &GridTable) -> StatedFacts {
    let mut facts = StatedFacts::default();
    for &number in table.before.iter().chain([&table.heading_line]).filter(|number| **number > 0) {
        let line = text.line(number).to_lowercase();
        if OTHER.iter().any(|word| line.contains(word)) {
            facts.other_quantity.get_or_insert(number);
        }
        let Some((key, value)) = line.split_once([':', '=', ';', '\t', ',']) else { continue };
        let value = value.trim_matches([' ', ';', ',', '\t', '"']);
        let is_key = |words: &[&str]| words.contains(&key.trim().trim_start_matches(['#', '/']).trim());
        if is_key(&["axis", "achse", "axe", "asse", "eje"])
            && let Some(axis) = words::axis(value)
        {
            facts.axis.get_or_insert((axis, number));
        }
    }
    facts
}
