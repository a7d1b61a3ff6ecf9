//! Lines of the source that stay as they are: if a written line has the words of its block and nothing else, the source's bytes are written instead.
//!
//! The order of the words, blanks, and how a number is written have no meaning within a block. A decimal point has one on controls that read a number
//! without it in increments.

use ncfix_base::source::Source;
use ncfix_base::units::push_integer;
use ncfix_machine::snc::Origin;

use super::comment::in_parentheses;
use super::passes::LoopPasses;

/// Words of a block that are compared; a longer block is written anew.
const MOST_WORDS: usize = 40;

/// The main program, and the block of the line under construction.
#[derive(Debug)]
pub(super) struct KeptLines {
    source: Option<Source>,
    /// Byte offset of the block whose first line is under construction.
    at: Option<u32>,
    /// Passes of loops, if the output says where they begin.
    pub(super) passes: Option<LoopPasses>,
    /// A word of the line that is in force without it: the source may lack it.
    pub(super) in_force: Option<&'static str>,
    /// Words of the line that are in force, blanks between them: the source may state each again.
    pub(super) may_state: Vec<u8>,
    /// Words in force in the whole output, which the source may state again.
    assumed: &'static [&'static str],
    /// `true` if comments are in parentheses.
    has_parentheses: bool,
    /// `true` if `X10` and `X10.` differ.
    has_points: bool,
    /// Canonical words of the written line and of the source.
    written: BlockWords,
    own: BlockWords,
    /// Canonical form of [`Self::may_state`].
    stated: BlockWords,
}

/// Words of a block in their canonical form.
#[derive(Debug, Default)]
struct BlockWords {
    bytes: Vec<u8>,
    /// End of each word.
    ends: Vec<usize>,
    comment: Vec<u8>,
}

impl KeptLines {
    /// No lines to keep yet.
    pub(super) fn new(assumed: &'static [&'static str], has_parentheses: bool, has_points: bool) -> KeptLines {
        let [written, own, stated] = std::array::from_fn(|_| BlockWords::default());
        let may_state = Vec::new();
        KeptLines {
            source: None,
            at: None,
            passes: None,
            in_force: None,
            may_state,
            assumed,
            has_parentheses,
            has_points,
            written,
            own,
            stated,
        }
    }

    /// Sets the main program.
    pub(super) fn of(&mut self, source: Source) {
        self.source = Some(source);
    }

    /// Notes that a block of the source begins with the next line. Returns the number of the pass if a further pass of a loop begins there.
    pub(super) fn begin(&mut self, origin: &Origin, has_number: bool) -> Option<u64> {
        self.in_force = None;
        self.may_state.clear();
        let is_main = self.source.as_ref().is_some_and(|source| source.id() == origin.file);
        self.at = is_main.then_some(origin.span.start);
        self.passes.as_mut().filter(|_| is_main && origin.calls == 0)?.note(origin.line, has_number)
    }

    /// The line of the source, if the written one has the same words and comment and is the first of its block.
    pub(super) fn line(&mut self, number: Option<u32>, text: &[u8], comment: &[u8]) -> Option<&[u8]> {
        let at = self.at.take()?;
        let source = self.source.as_ref()?;
        let (line, start) = source.line_at(at);
        // A block in lines that a macro made is nowhere in the file.
        if at < start || line.len() as u64 + u64::from(start) < u64::from(at) {
            return None;
        }
        let (has_parentheses, has_points) = (self.has_parentheses, self.has_points);
        self.written.clear();
        if let Some(number) = number {
            self.written.bytes.push(b'N');
            push_integer(&mut self.written.bytes, u64::from(number));
            self.written.end_word()?;
        }
        self.own.clear();
        self.written.read(text, has_parentheses, has_points)?;
        self.own.read(line, has_parentheses, has_points)?;
        self.written.comment.extend_from_slice(comment.trim_ascii());
        if !self.written.has_words_of(&self.own) {
            if let Some(word) = self.in_force.map(str::as_bytes).filter(|word| !self.own.has(word)) {
                self.written.remove(word);
            }
            for word in self.assumed {
                if !self.written.has(word.as_bytes()) {
                    self.own.remove(word.as_bytes());
                }
            }
            if !self.may_state.is_empty() {
                self.stated.clear();
                self.stated.read(&self.may_state, has_parentheses, has_points)?;
                for word in self.stated.words() {
                    if !self.written.has(word) {
                        self.own.remove(word);
                    }
                }
            }
            if !self.written.has_words_of(&self.own) {
                return None;
            }
        }
        let is_comment = if has_parentheses {
            self.own.comment.is_empty() && self.written.comment.is_empty()
                || in_parentheses(&self.own.comment) == in_parentheses(&self.written.comment)
        } else {
            self.own.comment == self.written.comment
        };
        is_comment.then_some(line)
    }
}

impl BlockWords {
    fn clear(&mut self) {
        self.bytes.clear();
        self.ends.clear();
        self.comment.clear();
    }

    /// Appends the words of a line; `None` if they are too many.
    fn read(&mut self, line: &[u8], has_parentheses: bool, has_points: bool) -> Option<()> {
        // The last byte that is not a blank: a letter after an operator continues the word.
        let mut last = b' ';
        let mut at = 0;
        while let Some(&byte) = line.get(at) {
            let rest = &line[at..];
            let mut length = 1;
            match byte {
                b' ' | b'\t' => {
                    at += 1;
                    // A blank ends a name; between a letter and its number it has no meaning.
                    if last.is_ascii_alphabetic()
                        && rest.trim_ascii_start().first().is_some_and(u8::is_ascii_alphabetic)
                    {
                        last = b'0';
                    }
                    continue;
                }
                b';' => {
                    self.comment.extend_from_slice(rest.trim_ascii());
                    break;
                }
                b'(' if has_parentheses => {
                    length = rest.iter().position(|&byte| byte == b')').map_or(rest.len(), |end| end + 1);
                    if !self.comment.is_empty() {
                        self.comment.push(b' ');
                    }
                    self.comment.extend_from_slice(&rest[..length]);
                    at += length;
                    last = b'0';
                    continue;
                }
                b'"' => {
                    length = rest[1..].iter().position(|&byte| byte == b'"').map_or(rest.len(), |end| end + 2);
                    self.bytes.extend_from_slice(&rest[..length]);
                }
                b'0'..=b'9' | b'.' => {
                    length = rest.iter().take_while(|byte| byte.is_ascii_digit() || **byte == b'.').count();
                    self.push_number(&rest[..length], has_points);
                }
                // A sign before a number; not between two.
                b'+' if matches!(last, b'=' | b'(' | b',') || last.is_ascii_alphabetic() => {}
                _ => {
                    let is_letter = byte.is_ascii_alphabetic() || byte == b'$' || byte == b'_';
                    if is_letter
                        && matches!(last, b'0'..=b'9' | b'.' | b')' | b']' | b'"' | b':')
                        && !self.bytes.is_empty()
                    {
                        self.end_word()?;
                    }
                    self.bytes.push(byte.to_ascii_uppercase());
                }
            }
            at += length;
            last = line[at - 1];
        }
        self.end_word()
    }

    fn end_word(&mut self) -> Option<()> {
        if self.ends.last().copied().unwrap_or(0) < self.bytes.len() {
            self.ends.push(self.bytes.len());
        }
        (self.ends.len() <= MOST_WORDS).then_some(())
    }

    /// Appends a number without the zeros that have no meaning.
    fn push_number(&mut self, digits: &[u8], has_points: bool) {
        let point = digits.iter().position(|&byte| byte == b'.');
        let (whole, part) = digits.split_at(point.unwrap_or(digits.len()));
        let zeros = whole.iter().take_while(|&&byte| byte == b'0').count();
        let part = part.get(1..).unwrap_or_default();
        let end = part.iter().rposition(|&byte| byte != b'0').map_or(0, |last| last + 1);
        match &whole[zeros..] {
            [] if end == 0 => self.bytes.push(b'0'),
            whole => self.bytes.extend_from_slice(whole),
        }
        if end > 0 || point.is_some() && has_points {
            self.bytes.push(b'.');
        }
        self.bytes.extend_from_slice(&part[..end]);
    }

    fn words(&self) -> impl Iterator<Item = &[u8]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.bytes[start..end])
    }

    fn has(&self, word: &[u8]) -> bool {
        self.words().any(|own| own == word)
    }

    /// Removes the first word with this text.
    fn remove(&mut self, word: &[u8]) {
        let Some(index) = self.words().position(|own| own == word) else { return };
        let start = index.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        self.bytes.drain(start..start + word.len());
        self.ends.remove(index);
        self.ends[index..].iter_mut().for_each(|end| *end -= word.len());
    }

    /// `true` if the other block has these words, each as often.
    fn has_words_of(&self, other: &BlockWords) -> bool {
        if self.ends.len() != other.ends.len() || self.bytes.len() != other.bytes.len() {
            return false;
        }
        let mut is_taken = [false; MOST_WORDS];
        self.words().all(|word| {
            let found = other.words().zip(&mut is_taken).find(|(own, is_taken)| !**is_taken && *own == word);
            found.map(|(_, is_taken)| *is_taken = true).is_some()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::source::{FileId, Span};

    /// `true` if the written line keeps the bytes of the source.
    fn keeps(source: &str, written: &str, has_parentheses: bool, has_points: bool) -> bool {
        let mut kept = KeptLines::new(&[], has_parentheses, has_points);
        kept.of(Source::new(FileId(0), "a", format!("%\n{source}\nM30\n").into_bytes()).unwrap());
        kept.begin(&Origin { span: Span::new(2, 2 + source.len()), ..Origin::default() }, false);
        let at = written.find(if has_parentheses { '(' } else { ';' }).unwrap_or(written.len());
        let (text, comment) = written.split_at(at);
        kept.line(None, text.trim_end().as_bytes(), comment.as_bytes()) == Some(source.as_bytes())
    }

    #[test]
    fn order_blanks_and_zeros_have_no_meaning() {
        for (source, written) in [
            ("N10 G54 G90 G71 T1 M6", "N10 G90 G71 G54 T1 M6"),
            ("n10g1x10.500y+2", "N10 G1 X10.5 Y2"),
            ("N010 G01 X 10 Y-0.50", "N10 G1 X10 Y-.5"),
            ("N20 DIAMOF G90", "N20 G90 DIAMOF"),
            ("N20 X=AC(10) Y=IC(5.0)", "N20 Y=IC(5) X=AC(10)"),
            ("MSG(\"A 01\") ; text", "MSG(\"A 01\") ; text"),
            ("S1=500 F200", "F200 S1=500"),
        ] {
            assert!(keeps(source, written, false, false), "{source}");
        }
    }

    #[test]
    fn other_values_words_and_comments_are_written() {
        for (source, written) in [
            ("N10 G1 X10 Y2", "N10 G1 X10 Y2.001"),
            ("N10 G1 X10", "N10 G1 X10 Y2"),
            ("N10 G1 X10 Y2", "N10 G1 Y10 X2"),
            ("N10 G1 X10 X10", "N10 G1 X10 Y10"),
            ("N20 X=AC(10) Y=IC(5)", "N20 X=IC(10) Y=AC(5)"),
            ("N20 R1=R2 R2=R1", "N20 R1=R1 R2=R2"),
            ("MSG(\"A 1\")", "MSG(\"A 01\")"),
            ("/N10 G0 X1", "N10 G0 X1"),
            ("N10 X1 ; a", "N10 X1 ; b"),
            ("N10 X1", "N10 X1 ;+"),
        ] {
            assert!(!keeps(source, written, false, false), "{source}");
        }
    }

    #[test]
    fn a_word_in_force_may_be_absent() {
        let mut kept = KeptLines::new(&["G90"], false, false);
        kept.of(Source::new(FileId(0), "a", b"N5 Y+20. Z1\n".to_vec()).unwrap());
        let origin = Origin { span: Span::new(0, 11), ..Origin::default() };
        kept.begin(&origin, false);
        assert_eq!(kept.line(None, b"N5 G1 Y20 Z1", b""), None);
        kept.begin(&origin, false);
        kept.in_force = Some("G1");
        assert_eq!(kept.line(None, b"N5 G1 Y20 Z1", b""), Some(&b"N5 Y+20. Z1"[..]));
        kept.begin(&origin, false);
        kept.in_force = Some("G1");
        assert_eq!(kept.line(None, b"N5 G1 Y20 Z2", b""), None);
        // The whole output is absolute.
        kept.of(Source::new(FileId(0), "a", b"N5 G90 Y+20. Z1\n".to_vec()).unwrap());
        kept.begin(&origin, false);
        assert_eq!(kept.line(None, b"N5 Y20 Z1", b""), Some(&b"N5 G90 Y+20. Z1"[..]));
        kept.of(Source::new(FileId(0), "a", b"N5 G91 Y+20. Z1\n".to_vec()).unwrap());
        kept.begin(&origin, false);
        assert_eq!(kept.line(None, b"N5 Y20 Z1", b""), None);
    }

    #[test]
    fn a_word_in_force_may_be_stated_again() {
        let mut kept = KeptLines::new(&["G90"], false, false);
        kept.of(Source::new(FileId(0), "a", b"N7 X20 Y10\n".to_vec()).unwrap());
        let origin = Origin { span: Span::new(0, 10), ..Origin::default() };
        for (in_force, is_kept) in [("X20 Y10", true), ("G0 Y10.0", true), ("X20 Y10.0004", false), ("", false)] {
            kept.begin(&origin, false);
            kept.may_state.extend_from_slice(in_force.as_bytes());
            assert_eq!(kept.line(None, b"N7 X20", b"").is_some(), is_kept, "{in_force}");
        }
    }

    #[test]
    fn a_point_and_a_comment_in_parentheses() {
        assert!(keeps("N1 X10. (A\u{d8} 5)", "N1 X10. (A__ 5)", true, true));
        assert!(keeps("N1 X10.0", "N1 X10.", true, true));
        assert!(!keeps("N1 X10", "N1 X10.", true, true));
        assert!(keeps("N1 X10 (a)", "N1 X10. (a)", true, false));
        assert!(!keeps("N1 X10 (a)", "N1 X10", true, false));
    }

    #[test]
    fn only_the_first_line_of_a_block_of_the_main_program_is_kept() {
        let mut kept = KeptLines::new(&["G90"], false, false);
        kept.of(Source::new(FileId(0), "a", b"X1\n".to_vec()).unwrap());
        kept.begin(&Origin { file: FileId(1), span: Span::new(0, 2), ..Origin::default() }, false);
        assert_eq!(kept.line(None, b"X1", b""), None);
        kept.begin(&Origin { span: Span::new(0, 2), ..Origin::default() }, false);
        assert_eq!(kept.line(None, b"X1", b""), Some(&b"X1"[..]));
        assert_eq!(kept.line(None, b"X1", b""), None);
    }
}
