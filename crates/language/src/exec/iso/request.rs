//! Words that call programs: M98, M198, M99, G65, G66, G67, and the codes that the machine file maps to macros.

use super::arguments;
use super::call::{Call, CallKind, Callee};
use super::expression::Scope;
use super::level::{Action, Level};
use crate::exec::core::fault::{Fault, at, bad_value, fault};
use crate::syntax::words::{Address, Program, Value, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;

/// From this value on, the upper digits of P are the number of repetitions.
const SPLIT: u32 = 10_000;
/// Maximum number of repetitions of a call.
const MAX_REPEATS: i64 = 99_999_999;

/// Request of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Request {
    /// M98, M198
    Subprogram,
    /// M97 with P: the blocks from a number on, up to M99.
    Local,
    /// M99
    Return,
    /// G65
    Macro,
    /// G66
    Modal,
    /// G67
    EndModal,
    /// G66.1
    EachBlock,
    /// A G or M code that the machine file maps to a macro: its program.
    Mapped(u8, u32),
    /// T, if the machine file maps it to a program.
    Tool(u32),
}

/// The request of a block; the first one is used.
pub(super) fn request(machine: &Machine, language: Language, level: &Level, words: &[Word]) -> Option<Request> {
    let is_fanuc = language == Language::Fanuc;
    let codes = &machine.control.macros.codes;
    let may_map = is_fanuc && !codes.is_empty() && !level.own.is_of_code;
    let has = |letter: u8| words.iter().any(|word| word.address == Address::Letter(letter));
    words.iter().find_map(|word| {
        let Address::Letter(letter) = word.address else { return None };
        let Value::Number { value, .. } = word.value else { return None };
        if may_map {
            let key = if letter == b'T' { "T".to_owned() } else { format!("{}{value}", char::from(letter)) };
            let program = matches!(letter, b'G' | b'M' | b'T').then(|| codes.get(&key)).flatten();
            match program {
                Some(&program) if letter == b'T' => return Some(Request::Tool(program)),
                Some(&program) => return Some(Request::Mapped(letter, program)),
                None => {}
            }
        }
        match letter {
            b'M' if value == 98.0 => Some(Request::Subprogram),
            b'M' if value == 97.0 && is_fanuc && has(b'P') && !machine.control.iso.reads_as_fanuc() => {
                Some(Request::Local)
            }
            b'M' if value == 99.0 => Some(Request::Return),
            b'M' if value == 198.0 && is_fanuc => Some(Request::Subprogram),
            b'G' if !is_fanuc => None,
            b'G' if value == 65.0 => Some(Request::Macro),
            b'G' if value == 66.0 => Some(Request::Modal),
            b'G' if value == 66.1 => Some(Request::EachBlock),
            b'G' if value == 67.0 => Some(Request::EndModal),
            _ => None,
        }
    })
}

impl Request {
    /// `true` if a word belongs to the request, and not to the rest of the block.
    pub(super) fn takes(self, program: &Program, word: &Word) -> bool {
        let is_fanuc = program.dialect.language == Language::Fanuc;
        let (letter, code) = match (word.address, word.value) {
            (Address::Letter(letter), Value::Number { value, .. }) => (letter, Some(value)),
            (Address::Letter(letter), _) => (letter, None),
            (Address::Name(_), _) => return true,
            _ => return false,
        };
        match self {
            Request::Subprogram => match letter {
                b'P' | b'L' => true,
                b'Q' => is_fanuc,
                b'M' => code == Some(98.0) || (is_fanuc && code == Some(198.0)),
                _ => false,
            },
            Request::Local => matches!(letter, b'P' | b'L') || (letter == b'M' && code == Some(97.0)),
            Request::Return => letter == b'P' || (letter == b'M' && code == Some(99.0)),
            // Codes before the call are executed; all other words are arguments.
            Request::Macro | Request::Modal | Request::EachBlock => {
                letter != b'G' || matches!(code, Some(65.0 | 66.0 | 66.1))
            }
            Request::EndModal => letter == b'G' && code == Some(67.0),
            Request::Mapped(mapped, _) => letter != b'G' || mapped == b'G' || code.is_none(),
            Request::Tool(_) => letter == b'T',
        }
    }

    /// The action after the block.
    pub(super) fn read(self, scope: &Scope<'_, '_>, words: &[Word], block: Span) -> Result<Action, Fault> {
        let value = |letter: u8| {
            let is_letter = |word: &&Word| word.address == Address::Letter(letter);
            words.iter().rev().find(is_letter).map(|word| whole(scope, word)).transpose()
        };
        let call_at = |callee, kind, repeats, at_block, arguments| {
            Action::Call(Box::new(Call { callee, kind, repeats, at_block, arguments, span: block, is_of_code: false }))
        };
        let call = |callee, kind, repeats, arguments| call_at(callee, kind, repeats, None, arguments);
        Ok(match self {
            Request::EndModal => Action::Next,
            Request::EachBlock => {
                let message = "G66.1, which makes every following block the arguments of a macro, is not supported";
                return Err(at(block, Code::NOT_SUPPORTED, message, "write the calls with G65"));
            }
            Request::Return => match value(b'P')?.map(u32::try_from) {
                None => Action::Return(None),
                Some(Ok(number)) if scope.program.dialect.language == Language::Fanuc => Action::Return(Some(number)),
                Some(_) => return Err(bad_value(block, "P of M99 is not a block number", "write M99 alone")),
            },
            Request::Local => {
                let repeats = repeats(scope, value(b'L')?, block)?.unwrap_or(1);
                call_at(Callee::Own, CallKind::Subprogram, repeats, block_number(value(b'P')?, block)?, Vec::new())
            }
            Request::Subprogram => {
                let repeats = repeats(scope, value(b'L')?, block)?;
                let is_fanuc = scope.program.dialect.language == Language::Fanuc;
                let at_block = block_number(value(b'Q')?.filter(|_| is_fanuc), block)?;
                let number = value(b'P')?;
                let is_named = words.iter().any(|word| matches!(word.address, Address::Name(_)));
                if at_block.is_some() && number.is_none() && !is_named {
                    let kind = CallKind::Subprogram;
                    return Ok(call_at(Callee::Own, kind, repeats.unwrap_or(1), at_block, Vec::new()));
                }
                let callee = callee(scope, words, number, block, "M98")?;
                let callee = match (callee, repeats) {
                    // Without L, the digits before the last four are the number of repetitions.
                    (Callee::Number(number), None)
                        if number >= SPLIT
                            && scope.program.dialect.language == Language::Fanuc
                            && !scope.channel.settings.machine.control.iso.is_haas() =>
                    {
                        Callee::Counted(number)
                    }
                    (callee, _) => callee,
                };
                call_at(callee, CallKind::Subprogram, repeats.unwrap_or(1), at_block, Vec::new())
            }
            Request::Macro | Request::Modal => {
                let callee = callee(scope, words, value(b'P')?, block, "G65")?;
                let arguments = arguments::read(scope, words, b"GLNOP", scope.increment())?;
                let repeats = repeats(scope, value(b'L')?, block)?.unwrap_or(1);
                call(callee, CallKind::Macro, repeats, arguments)
            }
            Request::Mapped(letter, program) => {
                let taken: &[u8] = if letter == b'G' { b"GLNOP" } else { b"GLNOPM" };
                let arguments = arguments::read(scope, words, taken, scope.increment())?;
                let repeats = repeats(scope, value(b'L')?, block)?.unwrap_or(1);
                let callee = Callee::Number(program);
                let span = block;
                let kind = CallKind::Macro;
                Action::Call(Box::new(Call {
                    callee,
                    kind,
                    repeats,
                    at_block: None,
                    arguments,
                    span,
                    is_of_code: true,
                }))
            }
            Request::Tool(program) => {
                let number = value(b'T')?.unwrap_or(0) as f64;
                let kind = CallKind::Tool(number);
                let callee = Callee::Number(program);
                Action::Call(Box::new(Call {
                    callee,
                    kind,
                    repeats: 1,
                    at_block: None,
                    arguments: Vec::new(),
                    span: block,
                    is_of_code: true,
                }))
            }
        })
    }
}

/// The value of a word as a whole number.
fn whole(scope: &Scope<'_, '_>, word: &Word) -> Result<i64, Fault> {
    let value = scope.word(word)?.unwrap_or(0.0);
    let nearest = value.round();
    if nearest.abs() > 1e9 {
        let message = format!("{value} is too large for a repetition count or a program number");
        return Err(bad_value(word.span, message, "write a smaller number"));
    }
    if (value - nearest).abs() > 1e-3 {
        return Err(bad_value(word.span, format!("{value} is not a whole number"), "write a whole number"));
    }
    Ok(nearest as i64)
}

fn repeats(scope: &Scope<'_, '_>, written: Option<i64>, block: Span) -> Result<Option<u32>, Fault> {
    let least = if scope.program.dialect.language == Language::Fanuc { 1 } else { 0 };
    match written {
        None => Ok(None),
        Some(count) if (least..=MAX_REPEATS).contains(&count) => Ok(u32::try_from(count).ok()),
        Some(count) => Err(bad_value(
            block,
            format!("L{count} is not a valid number of repetitions"),
            "write a number, 1 or larger",
        )),
    }
}

/// The number of the block at which a call begins.
fn block_number(written: Option<i64>, block: Span) -> Result<Option<u32>, Fault> {
    match written.map(u32::try_from) {
        None => Ok(None),
        Some(Ok(number)) => Ok(Some(number)),
        Some(Err(_)) => Err(bad_value(block, "this call begins at a block number below 0", "write the N of the block")),
    }
}

/// The program named by P or in < >.
fn callee(
    scope: &Scope<'_, '_>,
    words: &[Word],
    number: Option<i64>,
    block: Span,
    code: &str,
) -> Result<Callee, Fault> {
    let name = words.iter().find_map(|word| match word.address {
        Address::Name(name) => Some(scope.program.names.text(name).to_owned()),
        _ => None,
    });
    match (name, number.map(u32::try_from)) {
        (Some(name), _) => Ok(Callee::Name(name)),
        (None, Some(Ok(number))) => Ok(Callee::Number(number)),
        (None, _) => {
            let message = format!("{code} needs P with the number of the program");
            Err(fault(Code::BAD_WORD_VALUE, block, message, "write P1234, or the name in < >"))
        }
    }
}
