//! Findings of a run: each place once, and an end where there are too many.

use super::{BLOCKS_AFTER_ERROR, Execution, MAX_ERRORS};
use crate::diagnostic::{Code, Diagnostic, Place};
use crate::source::FileId;
use crate::syntax::Block;

impl Execution<'_> {
    pub(super) fn report(&mut self, finding: Diagnostic) {
        let mut finding = self.as_seen_by_user(finding);
        // A place in the text of a macro is shown where the macro is used.
        if let Some(place) = &mut finding.place
            && let Some(source) = self.sources.get(usize::from(place.file.0))
        {
            place.span = source.in_file(place.span);
        }
        if !self.reported.insert((finding.code, finding.place)) {
            return;
        }
        if finding.is_error() {
            self.errors += 1;
            if self.errors == 1 {
                self.limit = self.limit.min(self.executed + BLOCKS_AFTER_ERROR);
            }
            if self.errors >= MAX_ERRORS {
                self.is_over = true;
            }
        }
        self.findings.push_back(finding);
    }

    /// Reports what the contour stage found at the end, in the file of its last block.
    pub(super) fn report_channel(&mut self) {
        let file = self.channel.file();
        for found in std::mem::take(&mut self.channel.warnings) {
            self.report(found.in_file(file));
        }
    }

    pub(super) fn over_limit(&mut self, file: FileId, block: &Block) {
        self.is_over = true;
        if self.errors == 0 {
            let place = Place { file, span: block.span };
            let message = format!("{} blocks were executed and the program goes on here", self.executed);
            self.report(Diagnostic::at(
                Code::TOO_MANY_BLOCKS,
                place,
                message,
                "raise --max-blocks if the program does end",
            ));
        }
    }
}
