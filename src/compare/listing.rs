//! The rows of a comparison: their selection, their order, and their words.

use super::CompareOptions;
use super::walk::Outcome;
use ncfix_base::geometry::Axis;
use ncfix_base::number::grouped;
use ncfix_base::source::Source;
use ncfix_base::units::{MM_PER_INCH, UnitKey, um_from_mm};
use ncfix_path::review::words::{LineWord, block_number, decimals, words};
use ncfix_path::review::{ReviewRow, moves};
use ncfix_report::review::{Changed, ChangedMove, TerminalStyle};

/// Maximum number of lines above a line in which its modal words are searched.
const ABOVE: u32 = 200;

/// The lines of a file.
pub(crate) struct Text<'a> {
    source: &'a Source,
    /// Byte offset of each line.
    starts: Vec<u32>,
}

impl<'a> Text<'a> {
    pub(crate) fn new(source: &'a Source) -> Text<'a> {
        let ends = source.bytes().iter().enumerate().filter(|(_, byte)| **byte == source.line_end());
        let starts = std::iter::once(0).chain(ends.map(|(place, _)| place as u32 + 1)).collect();
        Text { source, starts }
    }

    /// A line by its number, from 1. Bytes that are not UTF-8 are read as Latin-1; only letters and digits matter
    /// here.
    pub(crate) fn line(&self, number: u32) -> String {
        let at = number.saturating_sub(1) as usize;
        let bytes = self.source.bytes();
        let from = self.starts.get(at).map_or(bytes.len(), |start| *start as usize);
        let to = self.starts.get(at + 1).map_or(bytes.len(), |next| *next as usize - 1);
        String::from_utf8_lossy(bytes.get(from..to).unwrap_or_default()).into_owned()
    }
}

/// The last written row, and the number of equal ones after it: the strokes of a cycle have one line and one correction.
#[derive(Default)]
struct Repeated {
    line: String,
    more: u64,
}

impl Repeated {
    /// Writes the equal rows: a single one as it is, several as their number.
    fn draw<E>(&self, write: &mut impl FnMut(&str) -> Result<(), E>) -> Result<(), E> {
        match self.more {
            0 => Ok(()),
            1 => write(&self.line),
            more => write(&format!("{:10}… {} more rows like this\n", "", grouped(more))),
        }
    }
}

/// Selection of rows.
pub(crate) struct Listing<'a> {
    wanted: &'a CompareOptions,
    rows: &'a [ReviewRow],
    /// Unit of linear axes in the corrected program, mm.
    unit_mm: f64,
    axes: Vec<Axis>,
    original: Vec<Text<'a>>,
    corrected: Text<'a>,
}

impl<'a> Listing<'a> {
    pub(crate) fn new(
        wanted: &'a CompareOptions,
        (rows, outcome): (&'a [ReviewRow], &'a Outcome),
        corrected: &'a Source,
    ) -> Listing<'a> {
        let original = outcome.sources[0].iter().map(Text::new).collect();
        let unit_mm = if outcome.is_inch { MM_PER_INCH } else { 1.0 };
        Listing { wanted, rows, unit_mm, axes: wanted.all_axes(), original, corrected: Text::new(corrected) }
    }

    /// The largest change of a move, µm.
    fn largest(&self, own: &[ReviewRow]) -> f64 {
        own.iter().map(|row| row.largest(&self.axes)).fold(0.0, f64::max)
    }

    fn is_wanted(&self, own: &[ReviewRow]) -> bool {
        let largest = self.largest(own);
        let least = self.wanted.least_mm.map_or(0.0, um_from_mm);
        let same = um_from_mm(self.wanted.tolerance_mm);
        largest > same && largest >= least
    }

    /// The moves with the largest changes, in descending order.
    fn top(&self, count: usize) -> (Vec<&'a [ReviewRow]>, u64) {
        let mut all: Vec<(f64, &[ReviewRow])> =
            moves(self.rows).filter(|own| self.is_wanted(own)).map(|own| (self.largest(own), own)).collect();
        let more = all.len().saturating_sub(count) as u64;
        // If changes are equal, the first move counts.
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        all.truncate(count);
        (all.into_iter().map(|(_, own)| own).collect(), more)
    }

    /// A number of rows for the result of the library, and the number of the others.
    pub(crate) fn some(&self, count: usize) -> (Vec<ChangedMove>, u64) {
        let (own, more) = self.top(count);
        (own.into_iter().map(|own| self.shown(own, 0)).collect(), more)
    }

    /// Draws the rows in sequence.
    ///
    /// # Errors
    /// The errors of `write`.
    pub(crate) fn draw<E>(&self, style: &TerminalStyle, mut write: impl FnMut(&str) -> Result<(), E>) -> Result<(), E> {
        if let Some(count) = self.wanted.rows {
            let (own, more) = self.top(count);
            for own in own {
                write(&self.shown(own, 0).line(style))?;
            }
            if more > 0 {
                write(&format!("and {more} more\n"))?;
            }
            return Ok(());
        }
        let mut folded = 0;
        let mut last = Repeated::default();
        for own in moves(self.rows) {
            if self.is_wanted(own) {
                let line = self.shown(own, std::mem::take(&mut folded)).line(style);
                if line == last.line {
                    last.more += 1;
                } else {
                    last.draw(&mut write)?;
                    write(&line)?;
                    last = Repeated { line, more: 0 };
                }
            } else {
                folded += 1;
            }
        }
        last.draw(&mut write)?;
        if folded > 0 {
            write(&format!("{:10}… {folded} not changed\n", ""))?;
        }
        Ok(())
    }

    /// A move in the result.
    fn shown(&self, own: &[ReviewRow], folded: u64) -> ChangedMove {
        let (Some(first), Some(last)) = (own.first(), own.last()) else { return ChangedMove::default() };
        let text = self.original.get(usize::from(first.file));
        let before = text.map_or(String::new(), |text| text.line(first.line));
        let file = text.filter(|_| first.file > 0).map(|text| text.source.name());
        let file = file.map(|name| name.rsplit(['/', '\\']).next().unwrap_or(name).to_owned());
        // The change of the end of the move, or the largest change of its pieces if the end is unchanged.
        let most = own.iter().max_by(|a, b| a.largest(&self.axes).total_cmp(&b.largest(&self.axes))).unwrap_or(last);
        let row = if last.largest(&self.axes) > 0.0 { last } else { most };
        let [mm, rad] = self.wanted.tolerance();
        let is_changed = |axis: &&Axis| row.added(**axis).abs() > if axis.is_rotary() { rad } else { mm };
        ChangedMove {
            line: first.line,
            file,
            number: block_number(&before).unwrap_or_default().to_owned(),
            corrected: [first.corrected_line, last.corrected_line],
            pieces: own.iter().filter(|row| !row.is_on_the_spot()).count() as u64,
            words: self.words(row, &before, self.axes.iter().filter(is_changed).copied()),
            folded,
        }
    }

    /// The changed axis words.
    fn words(&self, row: &ReviewRow, before: &str, axes: impl Iterator<Item = Axis>) -> Vec<Changed> {
        let after = self.corrected.line(row.corrected_line);
        let [of_before, of_after] = [before, &after].map(words);
        axes.map(|axis| {
            let written = word_of(&of_before, axis);
            match word_of(&of_after, axis) {
                Some(word) => changed((row, axis, self.unit_mm), Some(word), written),
                None => self.above(row, axis, written),
            }
        })
        .collect()
    }

    /// A modal word on a line above, whose value is still in force.
    fn above(&self, row: &ReviewRow, axis: Axis, written: Option<&LineWord<'_>>) -> Changed {
        let highest = row.corrected_line.saturating_sub(ABOVE).max(1);
        for line in (highest..row.corrected_line).rev() {
            let text = self.corrected.line(line);
            if let Some(word) = word_of(&words(&text), axis) {
                return changed((row, axis, self.unit_mm), Some(word), written);
            }
        }
        changed((row, axis, self.unit_mm), None, written)
    }
}

/// A changed word, from that of the corrected program and that of the original. `unit_mm` is the unit of linear axes in the corrected program.
fn changed(
    (row, axis, unit_mm): (&ReviewRow, Axis, f64),
    word: Option<&LineWord<'_>>,
    written: Option<&LineWord<'_>>,
) -> Changed {
    let added = row.added(axis);
    let unit = UnitKey::of(axis.is_rotary());
    let mut out = Changed { axis: axis.to_string(), added: unit.unit().shown(added), unit, ..Changed::default() };
    let Some(word) = word else { return out };
    let digits = decimals(word.value);
    let was = word.number.unwrap_or_default() - if axis.is_rotary() { added.to_degrees() } else { added / unit_mm };
    // The written text if it has this value; otherwise the executed value.
    let near = 0.6 * 10_f64.powi(-(digits as i32));
    let written = written.filter(|written| written.number.is_some_and(|number| (number - was).abs() < near));
    out.after = word.value.to_owned();
    out.before = written.map_or_else(|| rounded(was, digits), |word| word.value.to_owned());
    out
}

/// The number with `decimals` decimals, without a minus before zero.
fn rounded(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(bare) if bare.bytes().all(|byte| matches!(byte, b'0' | b'.')) => bare.to_owned(),
        _ => text,
    }
}

/// The word of an axis with a number.
fn word_of<'w, 't>(words: &'w [LineWord<'t>], axis: Axis) -> Option<&'w LineWord<'t>> {
    let letter = axis.letter();
    let is_own = |address: &str| {
        let bare = address.strip_prefix("POS[").and_then(|rest| rest.strip_suffix(']')).unwrap_or(address);
        // X, or X1 if the machine names its axes like this.
        bare.as_bytes().first().is_some_and(|first| first.eq_ignore_ascii_case(&letter))
            && matches!(&bare[1..], "" | "1")
    };
    words.iter().find(|word| is_own(word.address) && word.number.is_some())
}
