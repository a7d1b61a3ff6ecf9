//! Programs that are loaded, and where macros and programs are found.

use super::Interpreter;
use crate::exec::core::flags::Flags;
use crate::syntax::words::{self, Block, PartKind, Program};
use ncfix_base::source::Source;

/// A file, ready to run.
pub(super) struct Loaded {
    pub(super) program: Program,
    /// Blocks whose comments were passed on already.
    commented: Flags,
}

impl Loaded {
    pub(super) fn new(program: Program) -> Loaded {
        let commented = Flags::new(program.blocks.len());
        Loaded { program, commented }
    }

    /// The comments of a block the first time it is executed: a loop does not repeat them.
    pub(super) fn take_comment(&mut self, index: usize, block: &Block) -> Option<Vec<u8>> {
        let comments = self.program.comments_of(block);
        let first = comments.first()?;
        if self.commented.note(index)? {
            return None;
        }
        if comments.len() == 1 {
            return Some(self.program.source.slice(first.span).to_vec());
        }
        // Several comments of a block become one.
        let mut text = vec![b'('];
        for comment in comments {
            if comment.span != first.span {
                text.push(b' ');
            }
            text.extend_from_slice(self.program.source.slice(comment.text));
        }
        text.push(b')');
        Some(text)
    }
}

impl Interpreter<'_> {
    /// The part with a number: in the files that are loaded, else in a file of its name (`9101.MM`).
    pub(super) fn find(&mut self, kind: PartKind, number: u32) -> Option<(usize, usize)> {
        let key = (kind == PartKind::Macro, number);
        if let Some(found) = self.found.get(&key) {
            return *found;
        }
        let found = self.find_loaded(kind, number).or_else(|| self.load(kind, number));
        self.found.insert(key, found);
        found
    }

    fn find_loaded(&self, kind: PartKind, number: u32) -> Option<(usize, usize)> {
        let mut programs = self.programs.iter().enumerate();
        programs.find_map(|(index, loaded)| loaded.program.find_part(kind, number).map(|part| (index, part)))
    }

    fn load(&mut self, kind: PartKind, number: u32) -> Option<(usize, usize)> {
        let ending = if kind == PartKind::Macro { "MM" } else { "PM" };
        let (shown, bytes) =
            self.library.load(&format!("{number}.{ending}")).or_else(|| self.library.load(&number.to_string()))?;
        let id = self.ledger.next_file()?;
        let source = Source::new(id, &shown, bytes).ok()?;
        let dialect = self.programs.first()?.program.dialect;
        let (program, findings) = words::parse(&source, dialect);
        self.ledger.sources.push(program.source.clone());
        for finding in findings {
            self.ledger.report(finding);
        }
        let with_number = program.find_part(kind, number);
        // A file of this name without headers is what it is called.
        let part = with_number.or_else(|| program.parts.iter().position(|part| !part.blocks.is_empty()))?;
        self.programs.push(Loaded::new(program));
        Some((self.programs.len() - 1, part))
    }
}
