//! Facts that the lines around a table of targets state.

use ncfix_base::geometry::Axis;

use crate::answers::{MeasuredComponent, component};
use crate::grid::GridTable;
use crate::row_fact::{RowFact, row_fact};
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
    /// Measured component and its line, if a line before the table names it.
    pub(in crate::format) component: Option<(MeasuredComponent, usize)>,
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

/// Keys of a line that names the measured component.
const COMPONENT: &[&str] = &[
    "component",
    "error component",
    "error",
    "measured error",
    "measured component",
    "measurement",
    "quantity",
    "komponente",
    "fehler",
    "fehlerkomponente",
    "messgröße",
    "composante",
    "erreur",
    "componente",
    "errore",
];

/// The motion error that a word names, such as `EYX`; in capitals, because `eau` and `exx` are words too.
fn named(word: &str) -> Option<MeasuredComponent> {
    let is_name = word.len() == 3 && word.bytes().all(|byte| byte.is_ascii_uppercase());
    is_name.then(|| component(word).ok()).flatten()
}

impl StatedFacts {
    /// Takes the components that a line before the table names. A line with a key for it states the component; another one only mentions it.
    pub(in crate::format) fn note_component(&mut self, line: &str, number: usize) {
        let key = line.split_once([':', '=', ';', '\t', ',']).map_or("", |(key, _)| key);
        let key = key.trim().trim_start_matches(['#', '/']).trim().to_lowercase();
        let mut words = line.split(|letter: char| !letter.is_alphanumeric()).filter_map(named);
        let Some(first) = words.next() else { return };
        let is_one = words.all(|other| other == first);
        if is_one && COMPONENT.contains(&key.as_str()) && self.component.is_none_or(|(own, _)| own == first) {
            self.component.get_or_insert((first, number));
        } else if !is_one || !first.is_positioning() {
            self.other_quantity.get_or_insert(number);
        }
    }
}

/// Reads the facts in the lines around a table.
pub(in crate::format) fn stated(text: &DecodedText, table: &GridTable) -> StatedFacts {
    let mut facts = StatedFacts::default();
    for &number in table.before.iter().chain([&table.heading_line]).filter(|number| **number > 0) {
        if number != table.heading_line {
            facts.note_component(text.line(number), number);
        }
        let line = text.line(number).to_lowercase();
        if OTHER.iter().any(|word| line.contains(word)) {
            facts.other_quantity.get_or_insert(number);
        }
        let Some((key, value)) = line.split_once([':', '=', ';', '\t', ',']) else { continue };
        let value = value.trim_matches([' ', ';', ',', '\t', '"']);
        let key = key.trim().trim_start_matches(['#', '/']).trim();
        if row_fact(key) == Some(RowFact::Axis)
            && let Some(axis) = words::axis(value)
        {
            facts.axis.get_or_insert((axis, number));
        }
    }
    facts
}
