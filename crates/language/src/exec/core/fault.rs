//! A finding while it still lacks its file.

use ncfix_base::diagnostic::{Code, Diagnostic, Place, Unset};
use ncfix_base::source::{FileId, Span};

/// A finding in the program that is being executed. Boxed, because it travels through every result.
pub(in crate::exec) type Fault = Box<FaultData>;

/// Its contents.
#[derive(Debug)]
pub(in crate::exec) struct FaultData {
    pub(in crate::exec) code: Code,
    pub(in crate::exec) span: Span,
    /// Where it is not the file of the block that is being executed.
    pub(in crate::exec) file: Option<FileId>,
    pub(in crate::exec) message: String,
    pub(in crate::exec) help: String,
    unset: Option<Box<Unset>>,
}

/// Makes a finding.
pub(in crate::exec) fn fault(code: Code, span: Span, message: impl Into<String>, help: impl Into<String>) -> Fault {
    let (message, help) = (message.into(), help.into());
    Box::new(FaultData { code, span, file: None, message, help, unset: None })
}

impl FaultData {
    /// The same finding in a file of its own.
    pub(in crate::exec) fn of_file(mut self: Box<Self>, file: FileId) -> Fault {
        self.file = Some(file);
        self
    }

    /// The same finding about a variable without a value: what comes of it elsewhere is no finding of its own.
    pub(in crate::exec) fn of_variable(mut self: Box<Self>, name: impl Into<String>) -> Fault {
        self.unset.get_or_insert_default().read = Some(name.into());
        self
    }

    /// The same finding in a block that would have given a variable its value.
    pub(in crate::exec) fn leaves_unset(mut self: Box<Self>, name: impl Into<String>) -> Fault {
        self.unset.get_or_insert_default().left.push(name.into());
        self
    }

    /// The finding with its file.
    pub(in crate::exec) fn in_file(self, file: FileId) -> Diagnostic {
        let file = self.file.unwrap_or(file);
        let place = Place { file, span: self.span };
        let found = Diagnostic::at(self.code, place, self.message, self.help);
        Diagnostic { unset: self.unset, ..found }
    }
}

/// A finding about a part of a block.
pub(in crate::exec) fn at(span: Span, code: Code, message: impl Into<String>, help: &str) -> Fault {
    fault(code, span, message, help)
}

/// A finding about a value.
pub(in crate::exec) fn bad_value(span: Span, message: impl Into<String>, help: &str) -> Fault {
    fault(Code::BAD_WORD_VALUE, span, message, help)
}
