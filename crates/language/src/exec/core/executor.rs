//! What drives an executor: a step at a time, as far as the stream needs it.

use std::collections::VecDeque;

use super::ledger::{Ledger, Stage};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_machine::snc::Element;

/// What an executor of a language is.
pub(in crate::exec) trait Executor {
    /// Its books.
    fn ledger(&self) -> &Ledger;

    /// Its books, and the elements that are final.
    fn books(&mut self) -> (&mut Ledger, &mut VecDeque<Element>);

    /// Executes a block.
    fn step(&mut self);

    /// Ends what is held back when no more blocks are executed; called once.
    fn finish(&mut self);

    /// The next finding or element.
    fn advance(&mut self) -> Option<Result<Element, Diagnostic>> {
        loop {
            let (ledger, queue) = self.books();
            if let Some(finding) = ledger.findings.pop_front() {
                return Some(Err(finding));
            }
            if let Some(element) = queue.pop_front() {
                return Some(Ok(element));
            }
            match ledger.stage {
                Stage::Runs => self.step(),
                Stage::Over => {
                    ledger.stage = Stage::Finished;
                    self.finish();
                }
                Stage::Finished => return None,
            }
        }
    }
}
