//! Search of macros and programs.

use super::level::{Interpreter, Loaded};
use crate::syntax::words::{Block, PartKind};

/// The comments of a block at its first execution: a loop does not repeat them.
pub(super) fn take_comment(loaded: &mut Loaded, index: usize, block: &Block) -> Option<Vec<u8>> {
    let comments = loaded.program.comments_of(block);
    let first = *comments.first()?;
    if !loaded.takes_comments_of(index) {
        return None;
    }
    let (comments, source) = (loaded.program.comments_of(block), &loaded.program.source);
    if comments.len() == 1 {
        return Some(source.slice(first.span).to_vec());
    }
    // Several comments of a block become one.
    let mut text = vec![b'('];
    for comment in comments {
        if comment.span != first.span {
            text.push(b' ');
        }
        text.extend_from_slice(source.slice(comment.text));
    }
    text.push(b')');
    Some(text)
}

impl Interpreter<'_> {
    /// The part with a number: in the loaded files, otherwise in a file of its name (`9101.MM`).
    pub(super) fn find(&mut self, kind: PartKind, number: u32) -> Option<(usize, usize)> {
        let key = (kind == PartKind::Macro, number);
        self.find_once(&key, |run| run.find_loaded(kind, number).or_else(|| run.load(kind, number)))
    }

    fn find_loaded(&self, kind: PartKind, number: u32) -> Option<(usize, usize)> {
        let mut programs = self.programs.iter().enumerate();
        programs.find_map(|(index, loaded)| loaded.program.find_part(kind, number).map(|part| (index, part)))
    }

    fn load(&mut self, kind: PartKind, number: u32) -> Option<(usize, usize)> {
        let ending = if kind == PartKind::Macro { "MM" } else { "PM" };
        let (shown, bytes) =
            self.library.load(&format!("{number}.{ending}")).or_else(|| self.library.load(&number.to_string()))?;
        let program = self.read(&shown, bytes)?;
        let with_number = program.find_part(kind, number);
        // A file of this name without headers is the called part.
        let part = with_number.or_else(|| program.parts.iter().position(|part| !part.blocks.is_empty()))?;
        Some((self.keep(Loaded::with(program, ())), part))
    }
}
