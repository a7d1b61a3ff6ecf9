//! The driver of an executor: one step at a time, as far as the stream needs it.

use std::collections::VecDeque;

use super::run_state::{RunState, Stage};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_machine::snc::Element;

/// The executor of a language.
pub(in crate::exec) trait Executor {
    /// The run state.
    fn ledger(&self) -> &RunState;

    /// The run state, and the elements that are final.
    fn books(&mut self) -> (&mut RunState, &mut VecDeque<Element>);

    /// Executes a block.
    fn step(&mut self);

    /// Emits what is held back after the last block; called once.
    fn finish(&mut self);

    /// The next diagnostic or element.
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
