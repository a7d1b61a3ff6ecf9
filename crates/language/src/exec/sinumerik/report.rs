//! Findings of a run, as the user sees them.

use super::Interpreter;
use ncfix_base::diagnostic::Diagnostic;

impl Interpreter<'_> {
    pub(super) fn report(&mut self, finding: Diagnostic) {
        let finding = self.as_seen_by_user(finding);
        self.ledger.report(finding);
    }

    /// Reports what the stages behind the block have found, in the file of that block.
    pub(super) fn report_channel(&mut self) {
        let file = self.channel.outlet.file();
        for found in std::mem::take(&mut self.channel.outlet.warnings) {
            self.report(found.in_file(file));
        }
    }
}
