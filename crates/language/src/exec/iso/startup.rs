//! Codes that the control executes at its start, before the first block.

use super::channel::Channel;
use super::expression::Scope;
use super::gather::gather;
use super::order;
use crate::syntax::words::{self, Program};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::{FileId, Source};

/// Executes `control.startup_code`, without output.
pub(super) fn start_up(channel: &mut Channel<'_>, program: &Program) -> Option<Diagnostic> {
    let code = &channel.settings.machine.control.iso.startup_code;
    if code.is_empty() {
        return None;
    }
    let complain = |message: &str| {
        let help = "correct it in the machine file: words of one block that move no axis";
        Some(Diagnostic::nowhere(Code::BAD_VALUE, format!("control.startup_code \"{code}\": {message}"), help))
    };
    let Ok(source) = Source::new(FileId(0), "startup_code", code.as_bytes().to_vec()) else {
        return complain("it is too long");
    };
    let (parsed, findings) = words::parse(&source, program.dialect);
    if let Some(found) = findings.iter().find(|found| found.is_error()) {
        return complain(&found.message);
    }
    for block in &parsed.blocks {
        let mut gathered = channel.take_gathered(block.span);
        let scope = Scope { program: &parsed, channel, index: usize::MAX, grid: None };
        let found = gather(&scope, parsed.words_of(block), &mut gathered);
        let done = found.and_then(|()| order::execute(channel, &mut gathered));
        let moves = channel.block.has_moved;
        channel.put_back(gathered);
        if let Err(found) = done {
            return complain(&found.message);
        }
        if moves || channel.block.ends_program {
            return complain("it moves an axis or ends the program");
        }
    }
    channel.outlet.queue.clear();
    channel.standing.changed = true;
    None
}
