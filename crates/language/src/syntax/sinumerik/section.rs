//! The sections of an archive, and the empty program before the first one.

use super::block::Parser;
use super::tree::{Program, Section};
use crate::syntax::MAX_PARTS;
use crate::syntax::names::Names;
use crate::syntax::paged_store::PagedStore;
use ncfix_base::source::{Source, Span};
use ncfix_dialect::Dialect;

/// A program without content.
pub(super) fn empty(source: Source, dialect: &'static Dialect) -> Program {
    Program {
        source,
        dialect,
        sections: vec![Section { name: String::new(), ending: String::new(), headers: Vec::new(), blocks: 0..0 }],
        blocks: PagedStore::default(),
        words: PagedStore::default(),
        exprs: PagedStore::default(),
        arguments: PagedStore::default(),
        jumps: Vec::new(),
        definitions: PagedStore::default(),
        parameters: Vec::new(),
        calls: Vec::new(),
        repetitions: Vec::new(),
        names: Names::default(),
        pages: None,
    }
}

impl Parser {
    pub(super) fn section_is_fresh(&self) -> bool {
        self.program
            .sections
            .last()
            .is_some_and(|section| section.headers.len() == 1 && self.program.blocks.next() == section.blocks.start)
    }

    pub(super) fn close_section(&mut self) {
        let end = self.program.blocks.next();
        if let Some(section) = self.program.sections.last_mut() {
            section.blocks.end = end;
        }
    }

    /// Productions `section` and `header`: `%_N_NAME_MPF`, `%NAME_MPF` or a bare `%`.
    pub(super) fn open_section(&mut self, text: &[u8]) {
        let span = Span::new(self.offset(text), self.line_end);
        self.close_section();
        if self.program.sections.len() >= MAX_PARTS {
            self.give_up_at_section(span);
            return;
        }
        match self.program.sections.last() {
            Some(section) if section.ending == "DEF" => self.shared = self.macros.clone(),
            _ => self.macros = self.shared.clone(),
        }
        let shown = String::from_utf8_lossy(&text[1..]).trim().to_ascii_uppercase();
        let full = shown.strip_prefix("_N_").unwrap_or(&shown);
        let (name, ending) = match full.rsplit_once('_') {
            Some((name, ending)) if ending.len() == 3 => (name.to_owned(), ending.to_owned()),
            _ => (full.to_owned(), String::new()),
        };
        let start = self.program.blocks.next();
        self.program.sections.push(Section { name, ending, headers: vec![span], blocks: start..start });
    }
}
