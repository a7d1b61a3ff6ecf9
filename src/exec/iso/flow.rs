//! What a block does to the order of execution.

use super::channel::Channel;
use super::expression::Scope;
use super::gather::gather;
use super::level::Level;
use super::loaded::Loaded;
use crate::diagnostic::Code;
use crate::exec::fault::{Fault, fault};
use crate::syntax::words::{Block, Body};

/// What comes next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Action {
    /// The next block.
    Next,
    /// The program has ended.
    End,
}

/// Executes a block.
pub(super) fn block(
    loaded: &mut Loaded,
    _level: &mut Level,
    channel: &mut Channel<'_>,
    block: &Block,
) -> Result<Action, Fault> {
    match block.body {
        Body::Empty => {
            channel.empty();
            Ok(Action::Next)
        }
        Body::Faulty => Ok(Action::Next),
        Body::Words => words(loaded, channel, block),
        _ => {
            let message = "control statements are not supported yet";
            Err(fault(Code::NOT_SUPPORTED, block.span, message, "write the program without them"))
        }
    }
}

fn words(loaded: &Loaded, channel: &mut Channel<'_>, block: &Block) -> Result<Action, Fault> {
    let mut gathered = channel.take_gathered(block.span);
    let mut warnings = Vec::new();
    let scope = Scope { program: &loaded.program, channel };
    let found = gather(&scope, loaded.program.words_of(block), &mut gathered, &mut warnings);
    channel.outlet.warnings.append(&mut warnings);
    let done = found.and_then(|()| channel.execute(&mut gathered));
    channel.put_back(gathered);
    done?;
    Ok(if channel.ends_program { Action::End } else { Action::Next })
}
