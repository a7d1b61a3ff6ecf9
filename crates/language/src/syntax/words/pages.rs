//! Large programs: only one page of blocks is loaded at a time, if blocks contain only words.
//!
//! The first pass reads every page, so that all errors in the file are found before the execution. A program with jumps, loops or O-words, or one of
//! several in a file, is kept as a whole.

use std::sync::Arc;

use super::parser::{Parser, empty};
use super::tree::{Body, PartKind, Program};
use crate::syntax::paged_store::{Pages, Start};
use crate::syntax::plain;
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::source::Source;
use ncfix_dialect::{Dialect, Language};

/// Reads a program by pages of `page` bytes; `None` if it must be kept as a whole.
pub(super) fn parse(source: &Source, dialect: &'static Dialect, page: usize) -> Option<(Program, Vec<Diagnostic>)> {
    let mut parser = Parser::new(source.clone(), dialect);
    let (mut at, end) = parser.tape();
    let mut pages = Pages::until(end);
    let mut does_something = false;
    let mut last_number = None;
    parser.open_part(PartKind::Program, None);
    while at.0 < end {
        let first = parser.program.next();
        parser.program.turn_to(first);
        pages.push(Start { offset: at.0, lines: at.1, first });
        if dialect.language != Language::Grundig
            && !parser.program.blocks.is_empty()
            && let Some(plain) = plain::count(source.bytes(), at.0, end.min(at.0 + page), source.line_end())
        {
            plain.leave_out(&mut parser.program.blocks, &mut parser.program.words);
            at = (plain.end, at.1 + plain.lines);
            does_something |= plain.words > 0;
            continue;
        }
        at = parser.read(at, end.min(at.0 + page));
        while parser.is_fresh && dialect.language == Language::Grundig && at.0 < end {
            // Whether text before the first block is a header depends on the preceding text: all of it is one page.
            at = parser.read(at, end.min(at.0 + page));
        }
        if !is_plain(&parser.program) {
            return None;
        }
        if dialect.language == Language::Grundig {
            // A repeated number is an error, which can be detected only with all numbers known.
            let mut numbers = parser.program.blocks.iter().filter_map(|block| block.number);
            if !numbers.all(|number| last_number.replace(number).is_none_or(|last| last < number)) {
                return None;
            }
        }
        does_something |= parser.program.blocks.iter().any(|block| block.body != Body::Empty);
    }
    parser.close_part();
    let (mut program, findings) = parser.finish();
    let is_empty = !does_something && findings.is_empty();
    if program.parts.len() != 1 || is_empty {
        return None;
    }
    program.pages = Some(Arc::new(pages));
    program.ensure(0);
    program.take_unread_out();
    Some((program, findings))
}

/// `true` if the meaning of the loaded blocks does not depend on the page boundaries.
fn is_plain(program: &Program) -> bool {
    let is_plain = |body| matches!(body, Body::Empty | Body::Words | Body::Printing(_) | Body::Faulty);
    program.blocks.iter().all(|block| block.label.is_none() && is_plain(block.body))
}

impl Program {
    /// Loads a block with everything that belongs to it.
    pub fn ensure(&mut self, block: usize) {
        if !self.blocks.holds(block) && block < self.blocks.len() {
            self.load(block);
        }
    }

    /// Loads the page of a block.
    fn load(&mut self, block: usize) {
        let Some(pages) = &self.pages else { return };
        let Some((start, end)) = pages.of_block(block) else { return };
        let mut parser = Parser::new(self.source.clone(), self.dialect);
        parser.is_fresh = pages.is_first(&start);
        let parts = std::mem::take(&mut self.parts);
        let hollow = empty(self.source.clone(), self.dialect);
        parser.program = std::mem::replace(self, hollow);
        parser.program.turn_to(start.first);
        parser.open_part(PartKind::Program, None);
        parser.read((start.offset, start.lines), end);
        *self = Program { parts, ..parser.program };
        self.take_unread_out();
    }

    /// Removes unreadable blocks after the end of the program: a program with errors is not executed, so they do not matter.
    fn take_unread_out(&mut self) {
        let last = self.blocks.next();
        for number in last - self.blocks.iter().len()..last {
            if let Some(block) = self.blocks.get_mut(number)
                && block.body == Body::Faulty
            {
                block.body = Body::Empty;
            }
        }
    }

    /// `true` if only a part of the tree is loaded.
    #[must_use]
    pub fn has_pages(&self) -> bool {
        self.pages.is_some()
    }

    /// Finds the block with a number, page by page: the first one after block `from`, otherwise the first one of all.
    pub(super) fn search_block(&self, number: u32, from: usize) -> Option<usize> {
        let pages = self.pages.as_ref()?;
        let mut searched = Program { pages: self.pages.clone(), ..empty(self.source.clone(), self.dialect) };
        searched.names = self.names.clone();
        let mut first = None;
        for start in pages.first_blocks() {
            searched.load(start);
            for (index, block) in (start..).zip(&searched.blocks) {
                if block.number == Some(number) {
                    if index > from {
                        return Some(index);
                    }
                    first = first.or(Some(index));
                }
            }
        }
        first
    }

    /// Calls `see` with the number of every numbered block.
    pub fn each_block_number(&self, see: &mut dyn FnMut(u32)) {
        let Some(pages) = &self.pages else {
            self.blocks.iter().filter_map(|block| block.number).for_each(see);
            return;
        };
        let mut read = Program { pages: self.pages.clone(), ..empty(self.source.clone(), self.dialect) };
        read.names = self.names.clone();
        for start in pages.first_blocks() {
            read.load(start);
            read.blocks.iter().filter_map(|block| block.number).for_each(&mut *see);
        }
    }

    /// The numbers of the next nodes.
    fn next(&self) -> [usize; 5] {
        [self.blocks.next(), self.words.next(), self.exprs.next(), self.arguments.next(), self.comments.next()]
    }

    fn turn_to(&mut self, [block, word, expr, argument, comment]: [usize; 5]) {
        self.blocks.turn_to(block);
        self.words.turn_to(word);
        self.exprs.turn_to(expr);
        self.arguments.turn_to(argument);
        self.comments.turn_to(comment);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::source::FileId;

    /// Compares a paged program with the whole one, forward and backward. Returns `true` if it can be paged.
    fn compare(text: &[u8], dialect: &'static Dialect, page: usize) -> bool {
        let source = Source::new(FileId(0), "p", text.to_vec()).unwrap();
        let Some((mut paged, found)) = parse(&source, dialect, page) else { return false };
        let (whole, findings) = super::super::whole(&source, dialect);
        assert_eq!(found, findings);
        if !findings.is_empty() {
            // Such a program is not executed.
            return true;
        }
        assert_eq!(paged.blocks.len(), whole.blocks.len());
        assert_eq!(paged.parts.len(), 1);
        assert_eq!(
            (&paged.parts[0].headers, &paged.parts[0].blocks),
            (&whole.parts[0].headers, &whole.parts[0].blocks)
        );
        for number in (0..60).step_by(5) {
            for from in [0, 2, 1000] {
                assert_eq!(
                    paged.find_block(0, number, from),
                    whole.find_block(0, number, from),
                    "N{number} from {from}"
                );
            }
        }
        assert!(paged.names.iter().eq(whole.names.iter()));
        let count = whole.blocks.len();
        let orders = (0..count).chain((0..count).rev()).chain((0..count).map(|k| k * 7919 % count));
        for index in orders {
            paged.ensure(index);
            let (one, other) = (paged.blocks[index], whole.blocks[index]);
            assert_eq!(one, other);
            assert_eq!(paged.words_of(&one), whole.words_of(&other));
            assert_eq!(paged.comments_of(&one), whole.comments_of(&other));
        }
        for index in 0..whole.exprs.len() {
            if let Some(expr) = paged.exprs.get(index) {
                assert_eq!(*expr, whole.exprs[index]);
            }
        }
        true
    }

    #[test]
    fn pages_are_parts_of_the_whole() {
        for (folder, dialect) in [
            ("fanuc", ncfix_dialect::find("fanuc").unwrap()),
            ("rs274", ncfix_dialect::find("rs274").unwrap()),
            ("grundig", ncfix_dialect::find("grundig").unwrap()),
        ] {
            let folder = format!("{}/../../samples/programs/{folder}", env!("CARGO_MANIFEST_DIR"));
            let mut count = 0;
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_file() {
                    let text = std::fs::read(&path).unwrap();
                    count += u32::from(compare(&text, dialect, 40));
                }
            }
            assert!(count >= 1, "{}", dialect.name);
        }
        let text = b"%\nO1234 (A)\nN10 G1 X#1 Y[#2+3] (c)\n/2 N20 Z4 /M8\n\nN20 X2 (a) Y3 (b)\nDPRNT[X]\nN40 M30\n%\n";
        for page in [1, 20, 60, 1000] {
            assert!(compare(text, ncfix_dialect::find("fanuc").unwrap(), page));
        }
    }

    #[test]
    fn what_depends_on_its_surroundings_is_kept_as_a_whole() {
        let (fanuc, rs274, grundig) = (
            ncfix_dialect::find("fanuc").unwrap(),
            ncfix_dialect::find("rs274").unwrap(),
            ncfix_dialect::find("grundig").unwrap(),
        );
        for (text, dialect) in [
            (&b"O1\nGOTO 10\nN10 X1\nM30\n"[..], fanuc),
            (b"O1\nWHILE [#1 LT 2] DO1\nX1\nEND1\n", fanuc),
            (b"O1\nX1\nM99\nO2\nX2\nM99\n", fanuc),
            (b"o100 sub\nX1\no100 endsub\nM2\n", rs274),
            (b"%PM9001\nN10 X1\nN20 X2\nN10 X3\n", grundig),
            (b"\n", fanuc),
        ] {
            let source = Source::new(FileId(0), "p", text.to_vec()).unwrap();
            assert!(parse(&source, dialect, 10).is_none(), "{}", String::from_utf8_lossy(text));
        }
    }
}
