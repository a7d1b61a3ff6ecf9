//! Large programs: only one page of blocks is loaded at a time, if blocks contain only words.
//!
//! The first pass reads every page, so that all errors in the file are found before the execution. A program with jumps, labels, loops, calls of
//! parts or macros is kept as a whole.

use std::sync::Arc;

use super::block::Parser;
use super::macros::Macros;
use super::section::empty;
use super::tree::{Body, Program};
use crate::syntax::paged_store::{Pages, Start};
use crate::syntax::plain;
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::source::Source;
use ncfix_dialect::Dialect;

/// Reads a program by pages of `page` bytes; `None` if it must be kept as a whole.
pub(super) fn parse(
    source: &Source,
    dialect: &'static Dialect,
    macros: &Macros,
    page: usize,
) -> Option<(Program, Vec<Diagnostic>)> {
    let length = source.bytes().len();
    let mut parser = Parser::new(source.clone(), dialect, macros.clone());
    let mut pages = Pages::until(length);
    let mut at = (parser.start(), 0);
    let mut does_something = false;
    while at.0 < length {
        let first = parser.program.next();
        parser.program.turn_to(first);
        pages.push(Start { offset: at.0, lines: at.1, first });
        if !parser.program.blocks.is_empty()
            && parser.macros.is_empty()
            && let Some(plain) = plain::count(source.bytes(), at.0, at.0 + page, source.line_end())
        {
            plain.leave_out(&mut parser.program.blocks, &mut parser.program.words);
            at = (plain.end, at.1 + plain.lines);
            does_something |= plain.words > 0;
            continue;
        }
        at = parser.read(at, at.0 + page);
        while parser.program.blocks.is_empty() && at.0 < length {
            // Consecutive headers without a block before them belong to one section: all of them are one page.
            at = parser.read(at, at.0 + page);
        }
        if !(parser.is_unexpanded() && is_plain(&parser.program)) {
            return None;
        }
        does_something |= parser.program.blocks.iter().any(|block| block.body != Body::Empty);
    }
    parser.end();
    let (mut program, findings) = parser.finish();
    let is_empty = !does_something && findings.is_empty();
    if program.sections.len() != 1 || is_empty {
        return None;
    }
    program.pages = Some(Arc::new(pages));
    program.ensure(0);
    Some((program, findings))
}

/// `true` if the meaning of the loaded blocks does not depend on the page boundaries.
fn is_plain(program: &Program) -> bool {
    let is_plain =
        |body| matches!(body, Body::Empty | Body::Words | Body::Define { .. } | Body::Declaration | Body::Faulty);
    program.jumps.is_empty()
        && program.calls.is_empty()
        && program.parameters.is_empty()
        && program.repetitions.is_empty()
        && program.blocks.iter().all(|block| block.label.is_none() && is_plain(block.body))
}

impl Program {
    /// Loads a block with everything that belongs to it.
    pub fn ensure(&mut self, block: usize) {
        if self.blocks.holds(block) || block >= self.blocks.len() {
            return;
        }
        if let Some((start, end)) = self.pages.as_ref().and_then(|pages| pages.of_block(block)) {
            self.load(&start, end);
        }
    }

    /// Loads and keeps the whole program, for a search of blocks by content.
    pub fn keep_whole(&mut self) {
        let first = self.pages.take().and_then(|pages| pages.of_block(0).map(|(start, _)| (start, pages.end)));
        if let Some((start, end)) = first {
            self.load(&start, end);
        }
    }

    /// Loads blocks up to an offset instead of the loaded ones.
    fn load(&mut self, start: &Start<5>, end: usize) {
        let mut parser = Parser::new(self.source.clone(), self.dialect, Macros::default());
        let sections = std::mem::take(&mut self.sections);
        let fresh = std::mem::take(&mut parser.program.sections);
        let hollow = empty(self.source.clone(), self.dialect);
        parser.program = Program { sections: fresh, ..std::mem::replace(self, hollow) };
        parser.program.turn_to(start.first);
        parser.read((start.offset, start.lines), end);
        *self = Program { sections, ..parser.program };
    }

    /// `true` if only a part of the tree is loaded.
    #[must_use]
    pub fn has_pages(&self) -> bool {
        self.pages.is_some()
    }

    /// The numbers of the next nodes.
    fn next(&self) -> [usize; 5] {
        [self.blocks.next(), self.words.next(), self.exprs.next(), self.arguments.next(), self.definitions.next()]
    }

    fn turn_to(&mut self, [block, word, expr, argument, definition]: [usize; 5]) {
        self.blocks.turn_to(block);
        self.words.turn_to(word);
        self.exprs.turn_to(expr);
        self.arguments.turn_to(argument);
        self.definitions.turn_to(definition);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::source::FileId;

    /// Compares a paged program with the whole one, forward and backward. Returns `true` if it can be paged.
    fn compare(text: &[u8], dialect: &'static Dialect, page: usize) -> bool {
        let source = Source::new(FileId(0), "p", text.to_vec()).unwrap();
        let Some((mut paged, found)) = parse(&source, dialect, &Macros::default(), page) else { return false };
        let (whole, findings) = super::super::whole(&source, dialect, &Macros::default());
        assert_eq!(found, findings);
        if !findings.is_empty() {
            // Such a program is not executed.
            return true;
        }
        assert_eq!((paged.blocks.len(), &paged.sections), (whole.blocks.len(), &whole.sections));
        assert!(paged.names.iter().eq(whole.names.iter()));
        let count = whole.blocks.len();
        let orders = (0..count).chain((0..count).rev()).chain((0..count).map(|k| k * 7919 % count));
        for index in orders {
            paged.ensure(index);
            let (one, other) = (paged.blocks[index], whole.blocks[index]);
            assert_eq!(one, other);
            assert_eq!(paged.words_of(&one), whole.words_of(&other));
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
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../samples/programs/sinumerik");
        let mut count = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() {
                let text = std::fs::read(&path).unwrap();
                count += u32::from(compare(&text, ncfix_dialect::sinumerik(), 50));
            }
        }
        assert!(count >= 3, "{count}");
        let text = b"%_N_A_MPF\n;$PATH=/_N_WKS_DIR\nDEF REAL H=1.5, K[2]\nN10 G1 X=H*2 Y=IC(R1+3) F100 ; c\n\n/2 N20 K[1]=SIN(H) Z4\nCYCLE832(0.01,1,1)\nM30\n";
        for page in [1, 30, 80, 1000] {
            assert!(compare(text, ncfix_dialect::sinumerik(), page));
        }
    }

    #[test]
    fn what_depends_on_its_surroundings_is_kept_as_a_whole() {
        for text in [
            &b"AA: G1 X1\nM30\n"[..],
            b"G1 X1\nGOTOB AA\n",
            b"IF R1==1\nX1\nENDIF\n",
            b"REPEAT AA\n",
            b"MCALL CYCLE81(1,0,1)\nX1\n",
            b"%_N_A_MPF\nX1\n%_N_B_SPF\nX2\n",
            b"PROC AB(REAL BB)\nX1\n",
            b"DEFINE FF AS G1\nFF X1\n",
            b"\n\n",
            b"; nothing\n",
        ] {
            let source = Source::new(FileId(0), "p", text.to_vec()).unwrap();
            let parsed = parse(&source, ncfix_dialect::sinumerik(), &Macros::default(), 10);
            assert!(parsed.is_none(), "{}", String::from_utf8_lossy(text));
        }
    }

    #[test]
    fn a_paged_program_can_be_made_whole() {
        let text = b"N1 X1\nN2 X=R1\nN3 X3\nN4 Y4\n";
        let source = Source::new(FileId(0), "p", text.to_vec()).unwrap();
        let (mut program, _) = parse(&source, ncfix_dialect::sinumerik(), &Macros::default(), 8).unwrap();
        program.ensure(2);
        assert!(program.has_pages() && program.blocks.get(0).is_none());
        program.keep_whole();
        assert!(!program.has_pages() && (0..4).all(|index| program.blocks.holds(index)));
        assert_eq!(program.words_of(&program.blocks[1]).len(), 1);
    }
}
