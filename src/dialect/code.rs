//! The code table of a dialect: one row per G code or bare word, read from `grammars/`.

use std::collections::HashMap;

/// What a code does to the execution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Selects the kind of motion.
    Motion,
    /// Dwell.
    Dwell,
    /// Selects the working plane.
    Plane,
    /// Selects the unit.
    Unit,
    /// Absolute or incremental.
    Dimension,
    /// Selects a settable zero offset.
    Offset,
    /// Suppresses frames in this block.
    Suppress,
    /// Programs the frame.
    Frame,
    /// Sets the pole of polar coordinates.
    Pole,
    /// Radius compensation and what belongs to it.
    Contour,
    /// No position changes; passed on.
    Keep,
    /// Selects what F means; passed on.
    FeedMode,
    /// Switches a five-axis transformation.
    Transform,
    /// Says how orientations are meant.
    Orientation,
    /// Says how splines begin or end.
    Spline,
    /// Tapping with a compensating chuck, for one block.
    Tap,
    /// Moves axes to a place that only the machine knows: they and it are passed on.
    Reference,
    /// Limits of working area or spindle: the whole block is passed on.
    Limits,
    /// Diameter or radius programming of the transverse axis.
    Diameter,
    /// Concerns display or editor only; left out of the output.
    Display,
    /// Known, not executed yet.
    Refuse,
}

/// A row of the table.
#[derive(Clone, Debug)]
pub struct CodeEntry {
    /// `G1`, `SOFT`.
    pub name: &'static str,
    /// Modal group, 0 for none.
    pub group: u8,
    /// What it does.
    pub effect: Effect,
    /// A few words.
    pub meaning: &'static str,
}

/// The highest G number of a table plus one.
const G_NUMBERS: usize = 1000;

/// All codes of a dialect.
#[derive(Default)]
pub struct CodeTable {
    rows: Vec<CodeEntry>,
    by_number: Vec<u16>,
    by_name: HashMap<&'static str, u16>,
}

impl CodeTable {
    /// Reads `code TAB group TAB effect TAB meaning` lines; `#` starts a comment line.
    ///
    /// Tables are compiled in and a test reads them all, so a faulty row is left out rather than reported.
    #[must_use]
    pub fn from_tsv(text: &'static str) -> CodeTable {
        let mut table = CodeTable { by_number: vec![u16::MAX; G_NUMBERS], ..CodeTable::default() };
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let fields: Vec<&'static str> = line.split('\t').collect();
            let [name, group, effect, meaning] = fields[..] else { continue };
            let (Ok(group), Some(effect)) = (group.parse(), Effect::from_word(effect)) else { continue };
            let index = u16::try_from(table.rows.len()).unwrap_or(u16::MAX);
            table.rows.push(CodeEntry { name, group, effect, meaning });
            table.by_name.insert(name, index);
            if let Some(number) = name.strip_prefix('G').and_then(|digits| digits.parse::<usize>().ok()) {
                table.by_number[number] = index;
            }
        }
        table
    }

    /// The row of a G number.
    #[must_use]
    pub fn g(&self, number: usize) -> Option<&CodeEntry> {
        self.by_number.get(number).and_then(|&index| self.rows.get(index as usize))
    }

    /// The row of a word, upper case.
    #[must_use]
    pub fn word(&self, name: &str) -> Option<&CodeEntry> {
        self.by_name.get(name).map(|&index| &self.rows[index as usize])
    }

    /// All rows.
    #[must_use]
    pub fn rows(&self) -> &[CodeEntry] {
        &self.rows
    }
}

impl Effect {
    fn from_word(word: &str) -> Option<Effect> {
        Some(match word {
            "motion" => Effect::Motion,
            "dwell" => Effect::Dwell,
            "plane" => Effect::Plane,
            "unit" => Effect::Unit,
            "dimension" => Effect::Dimension,
            "offset" => Effect::Offset,
            "suppress" => Effect::Suppress,
            "frame" => Effect::Frame,
            "pole" => Effect::Pole,
            "contour" => Effect::Contour,
            "keep" => Effect::Keep,
            "feedmode" => Effect::FeedMode,
            "transform" => Effect::Transform,
            "orientation" => Effect::Orientation,
            "spline" => Effect::Spline,
            "tap" => Effect::Tap,
            "reference" => Effect::Reference,
            "limits" => Effect::Limits,
            "diameter" => Effect::Diameter,
            "display" => Effect::Display,
            "refuse" => Effect::Refuse,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialect::DIALECTS;

    #[test]
    fn every_row_of_every_table_is_read_once() {
        let text = include_str!("../../grammars/sinumerik-codes.tsv");
        let lines = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()).count();
        let table = DIALECTS[0].codes();
        assert_eq!(table.rows().len(), lines);
        assert_eq!(table.by_name.len(), lines, "a code stands twice in the table");
        assert_eq!(table.g(1).map(|row| row.effect), Some(Effect::Motion));
        assert_eq!(table.word("SUPA").map(|row| row.group), Some(9));
        assert!(table.g(505).is_none(), "G505 to G599 are a range, not rows");
    }
}
