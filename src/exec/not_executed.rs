//! Stands for the executor of a language that is read but not executed yet: one finding, and nothing moves.

use super::ledger::Ledger;
use super::{Executor, Options};
use crate::diagnostic::{Code, Diagnostic};
use crate::snc::Element;
use crate::syntax::words::Program;

/// The executor.
pub(super) struct NotExecuted {
    ledger: Ledger,
    finding: Option<Diagnostic>,
}

impl NotExecuted {
    pub(super) fn new(program: Program, options: &Options) -> NotExecuted {
        let message = format!("programs of {} cannot be executed yet", program.dialect.title);
        let finding = Diagnostic::nowhere(Code::NOT_SUPPORTED, message, "check them with --syntax-only");
        let blocks = program.blocks.len();
        NotExecuted { ledger: Ledger::new(program.source, blocks, options), finding: Some(finding) }
    }
}

impl Iterator for NotExecuted {
    type Item = Result<Element, Diagnostic>;

    fn next(&mut self) -> Option<Self::Item> {
        self.finding.take().map(Err)
    }
}

impl Executor for NotExecuted {
    fn ledger(&self) -> &Ledger {
        &self.ledger
    }
}
