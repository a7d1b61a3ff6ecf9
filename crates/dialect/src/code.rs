//! Code table of a dialect: one row per G code or bare word, read from `grammars/`.

use std::collections::HashMap;

/// Effect of a code on the execution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CodeEffect {
    /// Selects the motion mode.
    Motion,
    /// Dwell.
    Dwell,
    /// Selects the working plane.
    Plane,
    /// Selects the unit.
    Unit,
    /// Selects absolute or incremental dimensions.
    Dimension,
    /// Selects a settable zero offset.
    Offset,
    /// Suppresses frames in this block.
    Suppress,
    /// Programs the frame.
    Frame,
    /// Sets the pole of polar coordinates.
    Pole,
    /// Radius compensation and related codes.
    Contour,
    /// No position changes; passed on.
    Keep,
    /// Selects the meaning of F; passed on.
    FeedMode,
    /// Switches a five-axis transformation.
    Transform,
    /// Sets the meaning of orientation words.
    Orientation,
    /// Sets the end conditions of splines.
    Spline,
    /// Tapping with a compensating chuck, for one block.
    Tap,
    /// Moves axes to a position that only the machine knows: the code and its axes are passed on.
    Reference,
    /// Limits of working area or spindle: the whole block is passed on.
    Limits,
    /// Diameter or radius programming of the transverse axis.
    Diameter,
    /// Concerns display or editor only; omitted from the output.
    Display,
    /// Executed; its effect follows from the code itself.
    Execute,
    /// Known, not executed yet.
    Refuse,
}

/// Row of the table.
#[derive(Clone, Debug)]
pub struct CodeEntry {
    /// Name: `G1`, `G54.1`, `SOFT`; `G600..G699` for a range of codes.
    pub name: &'static str,
    /// Modal group, 0 for none.
    pub group: u8,
    /// Effect.
    pub effect: CodeEffect,
    /// Addresses that it uses, separated by blanks: `X Y I J B1 CR`; `axes` for all axes, `-` for none.
    pub words: &'static str,
    /// Short description.
    pub meaning: &'static str,
    /// Letters without an index among them as bits, A the lowest bit.
    letters: u32,
}

/// Highest G or M number of a table plus one.
const NUMBERS: usize = 1000;
/// Letters for which `axes` stands, and the polar words that stand for two of them.
const AXES: &[u8] = b"XYZABCUVW@^";

/// All codes of a dialect.
#[derive(Default)]
pub struct CodeTable {
    rows: Vec<CodeEntry>,
    /// Row indices by ten times the G number.
    by_g_tenths: Vec<u16>,
    by_m: Vec<u16>,
    by_name: HashMap<&'static str, u16>,
}

impl CodeEntry {
    /// True if it uses any address.
    #[must_use]
    pub fn has_words(&self) -> bool {
        self.words != "-"
    }

    /// True if it uses an address letter, `X`, upper case; `@`, `^` and `$` of RS274/NGC count as letters.
    #[must_use]
    pub fn uses(&self, letter: u8) -> bool {
        self.letters & bit(letter) != 0
    }

    /// True if it uses an address with a comma, such as `,C`, upper case.
    #[must_use]
    pub fn uses_comma(&self, letter: u8) -> bool {
        self.words.split(' ').any(|word| word.as_bytes() == [b',', letter])
    }

    /// True if it uses an address with an index, `B1=`, upper case.
    #[must_use]
    pub fn uses_indexed(&self, letter: u8, index: u16) -> bool {
        let fits = |word: &str| word.as_bytes().first() == Some(&letter) && word[1..].parse() == Ok(index);
        self.words.split(' ').any(fits)
    }
}

fn bit(letter: u8) -> u32 {
    match letter {
        b'A'..=b'Z' => 1 << (letter - b'A'),
        b'@' => 1 << 26,
        b'^' => 1 << 27,
        b'$' => 1 << 28,
        _ => 0,
    }
}

/// Returns the letters of a list of addresses as bits.
fn letters_of(words: &str) -> u32 {
    let of_word = |word: &str| match word.as_bytes() {
        [letter] => bit(*letter),
        b"axes" => AXES.iter().fold(0, |all, &letter| all | bit(letter)),
        _ => 0,
    };
    words.split(' ').fold(0, |all, word| all | of_word(word))
}

/// Converts `54.1` to 541.
fn tenths(number: &str) -> Option<usize> {
    let (whole, decimal) = number.split_once('.').unwrap_or((number, "0"));
    let decimal: usize = decimal.parse().ok().filter(|&decimal| decimal < 10)?;
    Some(whole.parse::<usize>().ok().filter(|&whole| whole < NUMBERS)? * 10 + decimal)
}

impl CodeTable {
    /// Reads `code TAB group TAB effect TAB words TAB meaning` lines; `#` starts a comment line.
    ///
    /// Tables are compiled in, and a test reads them all. So a faulty row is omitted, not reported.
    #[must_use]
    pub fn from_tsv(text: &'static str) -> CodeTable {
        let by_g_tenths = vec![u16::MAX; NUMBERS * 10];
        let mut table = CodeTable { by_g_tenths, by_m: vec![u16::MAX; NUMBERS], ..CodeTable::default() };
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let fields: Vec<&'static str> = line.split('\t').collect();
            let [name, group, effect, words, meaning] = fields[..] else { continue };
            let (Ok(group), Some(effect)) = (group.parse(), CodeEffect::from_word(effect)) else { continue };
            let index = u16::try_from(table.rows.len()).unwrap_or(u16::MAX);
            table.rows.push(CodeEntry { name, group, effect, words, meaning, letters: letters_of(words) });
            table.by_name.insert(name, index);
            let (first, last) = name.split_once("..").unwrap_or((name, name));
            let range = |letter| Some((tenths(first.strip_prefix(letter)?)?, tenths(last.strip_prefix(letter)?)?));
            if let Some((first, last)) = range('G') {
                // A range contains whole numbers only.
                for at in (first..=last).step_by(10) {
                    table.by_g_tenths[at] = index;
                }
            } else if let Some((first, last)) = range('M') {
                for at in first / 10..=last / 10 {
                    table.by_m[at] = index;
                }
            }
        }
        table
    }

    /// Returns the row of a whole G number.
    #[must_use]
    pub fn g(&self, number: usize) -> Option<&CodeEntry> {
        self.g_tenths(number.checked_mul(10)?)
    }

    /// Returns the row of a G number in tenths: 541 for G54.1.
    #[must_use]
    pub fn g_tenths(&self, tenths: usize) -> Option<&CodeEntry> {
        self.by_g_tenths.get(tenths).and_then(|&index| self.rows.get(index as usize))
    }

    /// Returns the row of an M number. Most M codes belong to the machine builder and have no row.
    #[must_use]
    pub fn m(&self, number: usize) -> Option<&CodeEntry> {
        self.by_m.get(number).and_then(|&index| self.rows.get(index as usize))
    }

    /// Returns the row of a word, upper case.
    #[must_use]
    pub fn word(&self, name: &str) -> Option<&CodeEntry> {
        self.by_name.get(name).map(|&index| &self.rows[index as usize])
    }

    /// Returns all rows.
    #[must_use]
    pub fn rows(&self) -> &[CodeEntry] {
        &self.rows
    }
}

impl CodeEffect {
    fn from_word(word: &str) -> Option<CodeEffect> {
        Some(match word {
            "motion" => CodeEffect::Motion,
            "dwell" => CodeEffect::Dwell,
            "plane" => CodeEffect::Plane,
            "unit" => CodeEffect::Unit,
            "dimension" => CodeEffect::Dimension,
            "offset" => CodeEffect::Offset,
            "suppress" => CodeEffect::Suppress,
            "frame" => CodeEffect::Frame,
            "pole" => CodeEffect::Pole,
            "contour" => CodeEffect::Contour,
            "keep" => CodeEffect::Keep,
            "feedmode" => CodeEffect::FeedMode,
            "transform" => CodeEffect::Transform,
            "orientation" => CodeEffect::Orientation,
            "spline" => CodeEffect::Spline,
            "tap" => CodeEffect::Tap,
            "reference" => CodeEffect::Reference,
            "limits" => CodeEffect::Limits,
            "diameter" => CodeEffect::Diameter,
            "display" => CodeEffect::Display,
            "execute" => CodeEffect::Execute,
            "refuse" => CodeEffect::Refuse,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DIALECTS;

    #[test]
    fn every_row_of_every_table_is_read_once() {
        for dialect in DIALECTS {
            let path = format!("{}/../../grammars/{}-codes.tsv", env!("CARGO_MANIFEST_DIR"), dialect.name);
            let text = std::fs::read_to_string(path).unwrap();
            let lines = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()).count();
            let table = dialect.codes();
            assert_eq!(table.rows().len(), lines, "{}", dialect.name);
            assert_eq!(table.by_name.len(), lines, "{}: the table lists a code twice", dialect.name);
            for row in table.rows() {
                let is_word = |word: &str| {
                    let first = word.as_bytes()[0];
                    word == "axes" || word == "-" || first == b',' || bit(first) != 0
                };
                assert!(row.words.split(' ').all(is_word), "{}: {}", dialect.name, row.name);
            }
        }
        let table = DIALECTS[0].codes();
        assert_eq!(table.g(1).map(|row| row.effect), Some(CodeEffect::Motion));
        assert_eq!(table.word("SUPA").map(|row| row.group), Some(9));
        assert!(table.g(505).is_none(), "G505 to G599 are a range, not rows");
    }

    #[test]
    fn codes_are_found_by_tenths_ranges_and_words() {
        let table = CodeTable::from_tsv(
            "G54.1\t14\texecute\tP\ta\nG600..G699\t0\trefuse\t-\tb\nG1\t1\texecute\taxes F B1 L12 ,C\tc\nM98\t0\texecute\tP L\td",
        );
        assert_eq!(table.g_tenths(541).map(|row| row.meaning), Some("a"));
        assert!(table.g(54).is_none());
        assert_eq!(table.g(650).map(|row| row.meaning), Some("b"));
        assert!(table.g(700).is_none() && table.g_tenths(6501).is_none() && table.g(usize::MAX).is_none());
        assert_eq!(table.m(98).map(|row| row.meaning), Some("d"));
        let row = table.g(1).unwrap();
        assert!(row.uses(b'X') && row.uses(b'W') && row.uses(b'F'));
        assert!(!row.uses(b'J') && !row.uses(b'L') && !row.uses(b'a'));
        assert!(row.uses_indexed(b'B', 1) && row.uses_indexed(b'L', 12) && !row.uses_indexed(b'L', 1));
        assert!(row.uses_comma(b'C') && !row.uses_comma(b'R'));
    }
}
