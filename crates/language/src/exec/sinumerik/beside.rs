//! Rejects assignments next to words that depend on them.
//!
//! The programming manual requires a separate block for assignments to variables if axes are programmed. Whether `X=R1 R1=20` moves to the old or the
//! new value is not specified. The same applies to frames and tool data next to words that use them.

use super::channel::Channel;
use super::level::Loaded;
use super::names::Meaning;
use super::variables::Variables;
use crate::exec::core::fault::{Fault, at};
use crate::syntax::sinumerik::{Address, ArgumentRange, Block, ExprId, NameId, Node, Value, Word};
use ncfix_base::diagnostic::Code;

/// Prefixes of system variables whose assignment changes the meaning of other words: frames, zero offsets, tools.
const IN_FORCE: &[&str] = &["$P_", "$TC_"];

/// Role of a word in its block.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    /// An assignment to a variable or an R parameter.
    Assignment,
    /// An assignment to a frame or to tool data.
    Data,
    /// Text for the display.
    Display,
    Other,
}

/// Rejects a block whose words depend on its assignments.
pub(super) fn check(loaded: &Loaded, channel: &Channel<'_>, block: &Block) -> Result<(), Fault> {
    let words = loaded.program.words_of(block);
    let (mut assigns, mut writes_data) = (false, false);
    for word in words {
        let part = part(loaded, channel, word);
        assigns |= matches!(part, Part::Assignment | Part::Data);
        writes_data |= part == Part::Data;
    }
    if !assigns {
        return Ok(());
    }
    let look = Look { loaded, channel };
    let depends = |word: &&Word| part(loaded, channel, word) == Part::Other && (writes_data || look.word(word));
    match words.iter().find(depends) {
        Some(word) => {
            let message = if writes_data {
                "it is not clear whether this word uses the frames and tools before or after the assignment of its block"
            } else {
                "it is not clear whether this word uses the variables before or after the assignments of its block"
            };
            Err(at(word.span, Code::BAD_EXPRESSION, message, "put the assignments into their own block"))
        }
        None => Ok(()),
    }
}

fn part(loaded: &Loaded, channel: &Channel<'_>, word: &Word) -> Part {
    let program = &loaded.program;
    let of_name = |text: &str| match IN_FORCE.iter().any(|start| text.starts_with(start)) {
        true => Part::Data,
        false => Part::Assignment,
    };
    match word.address {
        Address::Extended(b'R', _) => Part::Assignment,
        Address::Name(name) => {
            let text = program.names.text(name);
            match loaded.own.meanings[name.index()] {
                Meaning::Message => Part::Display,
                _ if text.starts_with('$') => of_name(text),
                _ if channel.variables.has(name, text) => Part::Assignment,
                _ => Part::Other,
            }
        }
        Address::Indexed(left) if is_assignable(loaded, &channel.variables, left) => match program.expr(left).node {
            Node::Indexed(name, _) => of_name(program.names.text(name)),
            _ => Part::Assignment,
        },
        _ => Part::Other,
    }
}

/// Searches words for variables.
#[derive(Clone, Copy)]
struct Look<'a> {
    loaded: &'a Loaded,
    channel: &'a Channel<'a>,
}

impl Look<'_> {
    fn word(self, word: &Word) -> bool {
        let in_address = matches!(word.address, Address::Indexed(left) if self.expression(left));
        in_address
            || match word.value {
                Value::Expr(id) | Value::Dimension(_, id) => self.expression(id),
                Value::Arguments(range) => self.list(range),
                Value::None | Value::Number(..) => false,
            }
    }

    fn list(self, range: ArgumentRange) -> bool {
        self.loaded.program.arguments_of(range).iter().flatten().any(|&id| self.expression(id))
    }

    fn expression(self, id: ExprId) -> bool {
        match self.loaded.program.expr(id).node {
            Node::Real(_) | Node::Integer(_) | Node::Boolean(_) | Node::Text(_) => false,
            Node::Parameter(_) | Node::ParameterAt(_) => true,
            Node::Name(name) => self.is_variable(name),
            Node::Indexed(name, range) => self.is_variable(name) || self.list(range),
            Node::Call(_, range) => self.list(range),
            Node::Unary(_, inner) => self.expression(inner),
            Node::Binary(_, left, right) => self.expression(left) || self.expression(right),
        }
    }

    fn is_variable(self, name: NameId) -> bool {
        let text = self.loaded.program.names.text(name);
        text.starts_with('$') && text != "$PI" || self.channel.variables.has(name, text)
    }
}

/// `true` if the left side is not an address of the language such as `POS[X]=`.
pub(super) fn is_assignable(loaded: &Loaded, variables: &Variables, left: ExprId) -> bool {
    match loaded.program.expr(left).node {
        Node::Indexed(name, _) => {
            let text = loaded.program.names.text(name);
            text.starts_with('$') || variables.has(name, text)
        }
        _ => true,
    }
}
