//! Synchronized actions: passed through as written if they move no axis.
//!
//! They run on the control in parallel with the program, so their effect on positions cannot be simulated. `$` variables live on the control. R
//! parameters and variables of the program are replaced by their values at the place of the action, as the control does in preprocessing.

use super::channel::Channel;
use super::functions::is_function;
use super::level::Loaded;
use super::pass::number_text;
use super::scope::scope_of;
use super::system_write::OVERLAID;
use super::value::Value as ExecValue;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet};
use ncfix_base::source::Span;
use ncfix_dialect::{Treatment, WordPlace, words};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::Kind;

/// Prefixes of variables whose values depend on the start and end of a block.
const OF_BLOCK: &[&str] = &[
    "AC_DTE",
    "AC_DTB",
    "AC_PLT",
    "AC_PATHN",
    "AC_PATHJ",
    "AC_TIMES",
    "AC_TIMEC",
    "AA_DTE",
    "AA_DTB",
    "AC_BLOCKTYPE",
    "AC_SPLITBLOCK",
];

/// A word of the text: its position, and its bracket depth.
struct Token<'a> {
    start: usize,
    text: &'a [u8],
    depth: u32,
}

/// An M word that changes the head, or whose number is not known: `M82`, `M0=82`, `M=$AC_MARKER[1]`.
fn head_word(machine: &Machine, text: &[u8], token: &Token<'_>) -> Option<String> {
    let extension = token.text.strip_prefix(b"M").or_else(|| token.text.strip_prefix(b"m"))?;
    if !extension.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let behind = text.get(token.start + token.text.len()..).unwrap_or_default().trim_ascii_start();
    let shown = String::from_utf8_lossy(token.text).into_owned();
    let assigned = behind.strip_prefix(b"=").filter(|value| !value.starts_with(b"="));
    let digits: Vec<u8> = match assigned {
        Some(value) => value.trim_ascii_start().iter().copied().take_while(u8::is_ascii_digit).collect(),
        None => extension.to_vec(),
    };
    let Some(number) = std::str::from_utf8(&digits).ok().and_then(|digits| digits.parse().ok()) else {
        return assigned.map(|_| format!("{shown}="));
    };
    machine.head_of_word(number).map(|_| if assigned.is_some() { format!("{shown}={number}") } else { shown })
}

/// Executes a synchronized action: passes it through, or reports the reason for rejection.
pub(super) fn execute(
    loaded: &Loaded,
    channel: &mut Channel<'_>,
    [whole, id, condition, actions]: [Span; 4],
) -> Result<(), Fault> {
    let source = |span| loaded.program.source.slice(span);
    let number = std::str::from_utf8(source(id)).ok().and_then(|text| text.trim().parse().ok());
    let is_allowed = channel.settings.machine.control.allows_synchronised(number);
    let help =
        "if this is correct for the machine, add the ID to control.allow_synchronised of the machine file, or \"all\"";
    let refusal = |message: String| fault(Code::NOT_SUPPORTED, whole, message, help);
    if !is_allowed {
        if let Some(word) = moving_word(&with_values(loaded, channel, actions)?, channel.settings.machine.axis_set()) {
            return Err(refusal(format!("a synchronized action that may move an axis ({word})")));
        }
        if let Some(word) = tokens(source(whole)).find_map(|token| of_block(&token)) {
            return Err(refusal(format!("{word} depends on block boundaries, and moves are divided into pieces")));
        }
    }
    if !channel.settings.machine.heads.is_empty() {
        let actions = with_values(loaded, channel, actions)?;
        if let Some(word) = tokens(&actions).find_map(|token| head_word(channel.settings.machine, &actions, &token)) {
            let message = format!("a synchronized action that may change the head ({word})");
            let help = "program the word in a block of the part program";
            return Err(fault(Code::HEAD_CHANGE, whole, message, help));
        }
    }
    let mut text = with_values(loaded, channel, whole)?;
    for index in written_parameters(source(actions)) {
        // Only the control knows the result of the action.
        channel.variables.set_parameter(index, f64::NAN, actions)?;
    }
    if id.start == id.end && condition.start != condition.end {
        let message =
            "a synchronized action without ID is active only during the next block, which may become several blocks";
        channel.outlet.warnings.push(fault(
            Code::WATCHED_ONCE,
            whole,
            message,
            "if it must be active to the end, give it an ID and CANCEL it after the block",
        ));
    }
    text.truncate(text.trim_ascii_end().len());
    channel.push(Kind::Verbatim(text));
    Ok(())
}

/// The text with the values of the program's variables.
fn with_values(loaded: &Loaded, channel: &Channel<'_>, whole: Span) -> Result<Vec<u8>, Fault> {
    let source = loaded.program.source.slice(whole);
    let scope = scope_of(loaded, channel);
    let mut text = Vec::with_capacity(source.len());
    let mut copied = 0;
    for token in tokens(source) {
        if token.text[0] == b'$' {
            continue;
        }
        let end = token.start + token.text.len();
        let span = Span::new(whole.start as usize + token.start, whole.start as usize + end);
        let upper = String::from_utf8_lossy(token.text).to_ascii_uppercase();
        let behind = source[end..].trim_ascii_start();
        let is_indexed = behind.first() == Some(&b'[');
        let is_written = behind.first() == Some(&b'=') && behind.get(1) != Some(&b'=');
        let value = if let Some(index) = upper.strip_prefix('R').and_then(|digits| digits.parse::<i64>().ok()) {
            ExecValue::Real(scope.variables.parameter(index, span)?)
        } else if upper == "R" && is_indexed {
            return Err(too_clever(span));
        } else {
            let name = loaded.program.names.find(&upper);
            let Some(cells) = name.and_then(|name| scope.variables.cells(name, &upper)) else { continue };
            match cells.first() {
                Some(value) if !is_indexed && !cells.is_array() => value.clone(),
                _ => return Err(too_clever(span)),
            }
        };
        if is_written {
            return Err(too_clever(span));
        }
        text.extend_from_slice(&source[copied..token.start]);
        match value {
            ExecValue::Text(bytes) => text.extend([b"\"", bytes.as_slice(), b"\""].concat()),
            ExecValue::Bool(truth) => text.extend_from_slice(if truth { b"TRUE" } else { b"FALSE" }),
            other => match other.number() {
                Some(number) if number.is_finite() => text.extend(number_text(number)),
                _ => text.extend(other.text()),
            },
        }
        copied = end;
    }
    text.extend_from_slice(&source[copied..]);
    Ok(text)
}

fn too_clever(span: Span) -> Fault {
    fault(
        Code::NOT_SUPPORTED,
        span,
        "a program variable or an array element written by a synchronized action",
        "use a $ variable such as $AC_MARKER[1], or write the value",
    )
}

/// The first word of the actions that may move a machine axis.
fn moving_word(actions: &[u8], axes: AxisSet) -> Option<String> {
    tokens(actions).find_map(|token| {
        let upper = String::from_utf8_lossy(token.text).to_ascii_uppercase();
        let behind = actions[token.start + token.text.len()..].trim_ascii_start();
        is_moving(&upper, token.depth, behind, axes).then_some(upper)
    })
}

fn is_moving(upper: &str, depth: u32, behind: &[u8], axes: AxisSet) -> bool {
    let is_written = behind.first() == Some(&b'=') || behind.first() == Some(&b'[') && is_element_written(behind);
    if let Some(name) = upper.strip_prefix("$$").or_else(|| upper.strip_prefix('$')) {
        let on_position = name.starts_with("AN_CEC") || OVERLAID.iter().any(|start| name.starts_with(start));
        // Variables that the control provides for synchronized actions; other variables may affect axes.
        let is_free = ["AC_", "AA_", "A_", "AN_"].iter().any(|start| name.starts_with(start));
        let is_parameter =
            name == "R" || name.strip_prefix('R').is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()));
        return on_position || depth == 0 && is_written && !is_free && !is_parameter;
    }
    let treatment = words().find(upper, WordPlace::Action).map(|row| row.treatment);
    if treatment == Some(Treatment::Axis) {
        let inside = behind.get(1..).unwrap_or_default().trim_ascii_start();
        let length = inside.iter().take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'_').count();
        return match inside.get(..length) {
            // Another letter is an axis outside the model.
            Some(&[letter]) if matches!(behind.first(), Some(b'[' | b'(')) => {
                Axis::from_letter(letter.to_ascii_uppercase()).is_some_and(|axis| axes.contains(axis))
            }
            _ => true,
        };
    }
    if depth > 0 || treatment == Some(Treatment::Still) || is_function(upper) {
        return false;
    }
    let letter = upper.as_bytes()[0];
    let is_word = upper[1..].bytes().all(|byte| byte.is_ascii_digit());
    match letter {
        b'G' | b'L' | b'T' | b'D' if is_word => true,
        _ if is_word => Axis::from_letter(letter).is_some_and(|axis| axes.contains(axis)),
        // A variable of the control, or a program.
        _ => behind.first() != Some(&b'='),
    }
}

/// `true` if `[…]` is followed by a single `=`.
fn is_element_written(behind: &[u8]) -> bool {
    let close = behind.iter().position(|&byte| byte == b']').map_or(behind.len(), |at| at + 1);
    let rest = behind[close..].trim_ascii_start();
    rest.first() == Some(&b'=') && rest.get(1) != Some(&b'=')
}

fn of_block(token: &Token<'_>) -> Option<String> {
    let upper = String::from_utf8_lossy(token.text).to_ascii_uppercase();
    let name = upper.trim_start_matches('$');
    (name.len() < upper.len() && OF_BLOCK.iter().any(|start| name.starts_with(start))).then_some(upper.clone())
}

/// R parameters that the actions write: `$R5=`, `$R[5]=`.
fn written_parameters(actions: &[u8]) -> Vec<i64> {
    let mut found = Vec::new();
    for token in tokens(actions) {
        let upper = String::from_utf8_lossy(token.text).to_ascii_uppercase();
        let Some(rest) = upper.trim_start_matches('$').strip_prefix('R').filter(|_| upper.starts_with('$')) else {
            continue;
        };
        let behind = actions[token.start + token.text.len()..].trim_ascii_start();
        let digits = if rest.is_empty() && behind.first() == Some(&b'[') && is_element_written(behind) {
            let inside = String::from_utf8_lossy(&behind[1..]).into_owned();
            inside.split(']').next().unwrap_or_default().trim().to_owned()
        } else if behind.first() == Some(&b'=') && behind.get(1) != Some(&b'=') {
            rest.to_owned()
        } else {
            continue;
        };
        found.extend(digits.parse::<i64>().ok());
    }
    found
}

/// Names and addresses with their number, outside quotation marks.
fn tokens(text: &[u8]) -> impl Iterator<Item = Token<'_>> {
    let (mut at, mut depth, mut quoted) = (0, 0_u32, false);
    std::iter::from_fn(move || {
        while let Some(&byte) = text.get(at) {
            let start = at;
            at += 1;
            match byte {
                b'"' => quoted = !quoted,
                _ if quoted => {}
                b'(' | b'[' => depth += 1,
                b')' | b']' => depth = depth.saturating_sub(1),
                b'A'..=b'Z' | b'a'..=b'z' | b'_' | b'$' => {
                    let more =
                        text[at..].iter().take_while(|&&b| b.is_ascii_alphanumeric() || b == b'_' || b == b'$').count();
                    at += more;
                    return Some(Token { start, text: &text[start..at], depth });
                }
                // Digits and their suffixes: 10, 1EX3, the H of 'H1F'.
                b'0'..=b'9' | b'\'' => {
                    at += text[at..].iter().take_while(|&&b| b.is_ascii_alphanumeric() || b == b'.').count();
                }
                _ => {}
            }
        }
        None
    })
}
