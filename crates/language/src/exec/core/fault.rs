//! An error or warning before its file is known.

use ncfix_base::diagnostic::{Code, Diagnostic, Place, Unset};
use ncfix_base::source::{FileId, Span};

/// Advice for a word that is not executed. It may move the machine, so nobody is asked just to remove it.
pub(in crate::exec) const WITHOUT_IT: &str =
    "program its effect with plain positions of X, Y and Z; if you only remove it, the moves after it may go elsewhere";

/// An error or warning in the running program. Boxed to keep results small.
pub(in crate::exec) type Fault = Box<FaultData>;

/// Its contents.
#[derive(Debug)]
pub(in crate::exec) struct FaultData {
    pub(in crate::exec) code: Code,
    pub(in crate::exec) span: Span,
    /// The file, if it is not that of the current block.
    pub(in crate::exec) file: Option<FileId>,
    pub(in crate::exec) message: String,
    pub(in crate::exec) help: String,
    unset: Option<Box<Unset>>,
}

/// Creates a fault.
pub(in crate::exec) fn fault(code: Code, span: Span, message: impl Into<String>, help: impl Into<String>) -> Fault {
    let (message, help) = (message.into(), help.into());
    Box::new(FaultData { code, span, file: None, message, help, unset: None })
}

impl FaultData {
    /// Sets the file.
    pub(in crate::exec) fn of_file(mut self: Box<Self>, file: FileId) -> Fault {
        self.file = Some(file);
        self
    }

    /// Marks it as caused by a variable without value: its consequences elsewhere are not reported separately.
    pub(in crate::exec) fn of_variable(mut self: Box<Self>, name: impl Into<String>) -> Fault {
        self.unset.get_or_insert_default().read = Some(name.into());
        self
    }

    /// Marks it as in a block that would have assigned a variable.
    pub(in crate::exec) fn leaves_unset(mut self: Box<Self>, name: impl Into<String>) -> Fault {
        self.unset.get_or_insert_default().left.push(name.into());
        self
    }

    /// Converts it to a diagnostic with its file.
    pub(in crate::exec) fn in_file(self, file: FileId) -> Diagnostic {
        let file = self.file.unwrap_or(file);
        let place = Place { file, span: self.span };
        let found = Diagnostic::at(self.code, place, self.message, self.help);
        Diagnostic { unset: self.unset, ..found }
    }
}

/// A fault at a part of a block.
pub(in crate::exec) fn at(span: Span, code: Code, message: impl Into<String>, help: &str) -> Fault {
    fault(code, span, message, help)
}

/// A fault for an invalid value.
pub(in crate::exec) fn bad_value(span: Span, message: impl Into<String>, help: &str) -> Fault {
    fault(Code::BAD_WORD_VALUE, span, message, help)
}
