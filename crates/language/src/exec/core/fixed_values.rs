//! Zero offsets and tool values of the control that a program reads to compute a position or a condition. The output has the number, or the branch, so it is
//! right only while the control has the values of the machine file. Each such place is named once.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;

use super::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Uses of values of the control in a run.
#[derive(Clone, Debug, Default)]
pub(in crate::exec) struct FixedValues {
    /// A use that is not named yet.
    new: Cell<Option<Span>>,
    /// Places that were named, by their first byte.
    named: RefCell<BTreeSet<u32>>,
    /// True while a cycle of ncfix runs: the control executes its own one, or the output has the moves.
    is_muted: Cell<bool>,
}

impl FixedValues {
    /// Notes a use.
    pub(in crate::exec) fn note(&self, span: Span) {
        if !self.is_muted.get() && self.new.get().is_none() && !self.named.borrow().contains(&span.start) {
            self.new.set(Some(span));
        }
    }

    /// Notes nothing while a cycle of ncfix runs.
    pub(in crate::exec) fn mute(&self, is_muted: bool) {
        self.is_muted.set(is_muted);
    }

    /// Forgets a use that is not named yet: the output keeps the computation.
    pub(in crate::exec) fn forget(&self) {
        self.new.set(None);
    }

    /// Takes the warning of a use that is not named yet.
    pub(in crate::exec) fn take(&self) -> Option<Fault> {
        let span = self.new.take()?;
        self.named.borrow_mut().insert(span.start);
        let message = "a zero offset or tool value of the control decides a position or a condition; the output has the number, or the branch, that it gives now";
        let help = "correct the program again after each change of these values; --guard lets the control stop if a zero offset or tool length differs, but it does not compare radii";
        Some(fault(Code::VALUE_FIXED, span, message, help))
    }
}
