//! Sections of the output that can become subprograms: a run of a subprogram of the source, or a further pass of a loop in its main program.
//!
//! A section contains the blocks of one call level, so sections follow each other and are never nested. The first pass of a loop is part of the main
//! program, where its block numbers are: a jump back shows only afterwards that there is a loop.

use super::block_number::NumberSet;
use ncfix_machine::snc::Origin;

/// First byte of a line that begins or ends a section. No language has it in a program.
const MARK: u8 = 0x1e;
/// Byte after the mark: a section begins. Its comment follows.
const BEGIN: u8 = b'B';
/// Byte after the mark: the section ends.
const END: u8 = b'E';

/// The section of the last block.
#[derive(Debug)]
struct OpenSection {
    calls: u32,
    first_line: u32,
    last_line: u32,
}

/// Recognizes where sections begin and end, by the places of the blocks in the source.
#[derive(Debug, Default)]
pub(super) struct Sections {
    /// Lines of the main program that were executed.
    executed: NumberSet,
    /// The last line of the main program outside of sections.
    main_line: u32,
    open: Option<OpenSection>,
}

/// A change at the begin of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SectionChange {
    pub(super) ends: bool,
    pub(super) begins: bool,
}

impl SectionChange {
    pub(super) fn is_any(self) -> bool {
        self.ends || self.begins
    }

    /// Appends the lines that mark the change; a section begins with a comment.
    pub(super) fn mark(self, comment: &[u8], out: &mut Vec<u8>) {
        if self.ends {
            out.extend_from_slice(&[MARK, END, b'\n']);
        }
        if self.begins {
            out.extend_from_slice(&[MARK, BEGIN]);
            out.extend_from_slice(comment);
            out.push(b'\n');
        }
    }
}

impl Sections {
    /// Notes the begin of a block.
    pub(super) fn note(&mut self, origin: &Origin) -> SectionChange {
        let &Origin { line, calls, .. } = origin;
        let is_main = calls == 0;
        let is_new = is_main && self.executed.add(line);
        if let Some(section) = self.open.as_mut().filter(|section| section.calls == calls && !is_new) {
            let is_back = line <= section.first_line && line < section.last_line;
            section.last_line = line;
            if is_back {
                section.first_line = line;
            }
            return SectionChange { ends: is_back, begins: is_back };
        }
        let ends = self.open.is_some();
        // A block of the main program can have several lines, also around a call.
        let begins = !is_main || !is_new && line != self.main_line;
        self.open = begins.then_some(OpenSection { calls, first_line: line, last_line: line });
        if is_main && !begins {
            self.main_line = line;
        }
        SectionChange { ends, begins }
    }

    /// `true` within a section.
    pub(super) fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Ends the last section at the end of the program.
    pub(super) fn finish(&mut self) -> SectionChange {
        SectionChange { ends: self.open.take().is_some(), begins: false }
    }
}

/// A line of a text with marks.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum MarkedLine<'a> {
    Begin(&'a [u8]),
    End,
    Text(&'a [u8]),
}

/// The lines of a text, each with its line end.
pub(super) fn lines(text: &[u8]) -> impl Iterator<Item = MarkedLine<'_>> {
    text.split_inclusive(|&byte| byte == b'\n').map(|line| match line {
        [MARK, BEGIN, comment @ ..] => MarkedLine::Begin(comment.trim_ascii_end()),
        [MARK, END, ..] => MarkedLine::End,
        line => MarkedLine::Text(line),
    })
}

/// Removes the marks: the flat program remains.
#[must_use]
pub fn without_sections(text: &[u8]) -> Vec<u8> {
    let parts = lines(text).filter_map(|line| match line {
        MarkedLine::Text(line) => Some(line),
        MarkedLine::Begin(_) | MarkedLine::End => None,
    });
    parts.flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lines and calls of blocks, each with `(` where a section begins before it and `)` where one ends.
    fn drawn(blocks: &[(u32, u32)]) -> String {
        let mut sections = Sections::default();
        let mut out = String::new();
        for &(calls, line) in blocks {
            let change = sections.note(&Origin { line, calls, ..Origin::default() });
            out.push_str(if change.ends { ")" } else { "" });
            out.push_str(if change.begins { "(" } else { "" });
            out.push_str(&line.to_string());
        }
        out.push_str(if sections.finish().ends { ")" } else { "" });
        out
    }

    #[test]
    fn each_run_of_a_subprogram_is_a_section() {
        // Line 2 calls lines 1 to 3 twice, line 3 once.
        let blocks = [(0, 1), (7, 1), (7, 2), (7, 3), (7, 1), (7, 2), (7, 3), (8, 1), (8, 2), (0, 4)];
        assert_eq!(drawn(&blocks), "1(123)(123)(12)4");
        // A loop within the subprogram is a part of its run.
        assert_eq!(drawn(&[(7, 1), (7, 2), (7, 3), (7, 2), (7, 3)]), "(12323)");
        // A call within the subprogram divides it.
        assert_eq!(drawn(&[(7, 1), (8, 5), (7, 3)]), "(1)(5)(3)");
    }

    #[test]
    fn further_passes_of_a_loop_are_sections() {
        assert_eq!(drawn(&[(0, 1), (0, 2), (0, 3), (0, 2), (0, 3), (0, 2), (0, 3), (0, 4)]), "123(23)(23)4");
        // A loop within a loop: a further pass of the outer one has all passes of the inner one.
        let inner = [(0, 2), (0, 3), (0, 3), (0, 2), (0, 3), (0, 1), (0, 2), (0, 3), (0, 2), (0, 3), (0, 5)];
        assert_eq!(drawn(&[&[(0, 1)][..], &inner].concat()), "1233(23)(12323)5");
        // The lines of one block are no pass.
        assert_eq!(drawn(&[(0, 1), (0, 1), (0, 1), (0, 2)]), "1112");
        assert_eq!(drawn(&[(0, 1), (7, 9), (0, 1), (0, 2)]), "1(9)12");
    }

    #[test]
    fn marks_leave_no_trace() {
        let mut text = b"G0 X1\r\n".to_vec();
        SectionChange { ends: false, begins: true }.mark(b"; pass 2", &mut text);
        text.extend_from_slice(b"G1 X2\r\n");
        SectionChange { ends: true, begins: false }.mark(b"", &mut text);
        let found: Vec<_> = lines(&text).collect();
        let expected = [
            MarkedLine::Text(b"G0 X1\r\n"),
            MarkedLine::Begin(b"; pass 2"),
            MarkedLine::Text(b"G1 X2\r\n"),
            MarkedLine::End,
        ];
        assert_eq!(found, expected);
        assert_eq!(without_sections(&text), b"G0 X1\r\nG1 X2\r\n");
    }
}
