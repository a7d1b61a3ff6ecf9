//! Words in the output that a firmware of the Grbl family does not have: it answers such a line with an error, and executes nothing of it.

use std::io::{self, Write};

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};
use ncfix_machine::machine::{Firmware, LackingWord};

/// Most different words that are named.
const MOST_WORDS: usize = 12;

/// The text of the output on its way to its file; its words are compared with those of the firmware.
pub(super) struct Watched<'a> {
    sink: &'a mut (dyn Write + Send),
    firmware: Firmware,
    /// The beginning of a line whose end is still to come.
    line: Vec<u8>,
    /// Words that it lacks, with the number of lines that have them.
    lacking: Vec<(LackingWord, u64)>,
}

impl<'a> Watched<'a> {
    pub(super) fn new(sink: &'a mut (dyn Write + Send), firmware: Firmware) -> Watched<'a> {
        Watched { sink, firmware, line: Vec::new(), lacking: Vec::new() }
    }

    fn look(&mut self, line: &[u8]) {
        let Watched { firmware, lacking, .. } = self;
        firmware.each_lacking(line, |word| match lacking.iter().position(|(known, _)| *known == word) {
            Some(index) => lacking[index].1 += 1,
            None if lacking.len() < MOST_WORDS => lacking.push((word, 1)),
            None => {}
        });
    }

    /// The warning about these words, at the first line of the program that has one of them.
    pub(super) fn finish(mut self, program: &Source) -> Option<Diagnostic> {
        let last = std::mem::take(&mut self.line);
        self.look(&last);
        if self.lacking.is_empty() {
            return None;
        }
        let name = self.firmware.name();
        let words = |is_option: bool| {
            let of = self.lacking.iter().filter(|(word, _)| word.is_option == is_option);
            let shown = of.map(|(word, count)| match count {
                1 => word.text(),
                count => format!("{} ({count} lines)", word.text()),
            });
            shown.collect::<Vec<_>>().join(", ")
        };
        let (never, by_build) = (words(false), words(true));
        let mut sentences = Vec::new();
        if !never.is_empty() {
            sentences.push(format!("{name} does not have these words of the output: {never}"));
        }
        if !by_build.is_empty() {
            sentences.push(format!("only some builds of {name} have these words: {by_build}"));
        }
        let message = format!("{}; a control without a word executes nothing of its line", sentences.join("; "));
        let help = "remove them from the program, or choose the post-processor of this control; if the control is another one or a newer version, check its list of words";
        Some(match self.place(program) {
            Some(place) => Diagnostic::at(Code::NOT_AT_THIS_CONTROL, place, message, help),
            None => Diagnostic::nowhere(Code::NOT_AT_THIS_CONTROL, message, help),
        })
    }

    fn place(&self, program: &Source) -> Option<Place> {
        let mut start = 0;
        for line in program.bytes().split(|&byte| byte == program.line_end()) {
            let mut has = false;
            self.firmware.each_lacking(line, |word| has |= self.lacking.iter().any(|(known, _)| *known == word));
            if has {
                let length = line.trim_ascii_end().len();
                return Some(Place { file: program.id(), span: Span::new(start, start + length) });
            }
            start += line.len() + 1;
        }
        None
    }
}

impl Write for Watched<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.sink.write(bytes)?;
        let mut rest = bytes.get(..count).unwrap_or_default();
        while let Some(end) = rest.iter().position(|&byte| byte == b'\n') {
            let (line, after) = rest.split_at(end + 1);
            if self.line.is_empty() {
                self.look(line);
            } else {
                let mut whole = std::mem::take(&mut self.line);
                whole.extend_from_slice(line);
                self.look(&whole);
                whole.clear();
                self.line = whole;
            }
            rest = after;
        }
        self.line.extend_from_slice(rest);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}
