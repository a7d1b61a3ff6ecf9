//! The marks `%` of a tape: which lines of a file stand outside them, and are therefore not part of the program.

use super::token::{blanks, find_byte, is_blank};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};
use ncfix_dialect::Language;

/// The offset at which the text begins: after a byte order mark.
pub(super) fn text_start(bytes: &[u8]) -> usize {
    if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 }
}

/// The lines that begin with `%`, each from its start to its end, in order.
pub(super) fn marks(bytes: &[u8], line_end: u8) -> impl Iterator<Item = (usize, usize)> {
    let first = text_start(bytes);
    let mut at = first;
    std::iter::from_fn(move || {
        loop {
            let place = at + find_byte(&bytes[at..], b'%')?;
            at = place + 1;
            // It begins a line where nothing but blanks stands between the end of the line before and it.
            let before = bytes[first..place].iter().rposition(|&byte| byte == line_end || !is_blank(byte));
            let start = match before.map(|before| first + before) {
                None => first,
                Some(before) if bytes[before] == line_end => before + 1,
                Some(_) => continue,
            };
            return Some((start, find_byte(&bytes[place..], line_end).map_or(bytes.len(), |length| place + length)));
        }
    })
}

/// True if no program precedes the first mark, so that this mark begins the program.
pub(super) fn is_leader(before: &[u8], line_end: u8, language: Language) -> bool {
    let mut lines = before[text_start(before)..].split(|&byte| byte == line_end).map(blanks);
    match language {
        Language::Fanuc => !lines.any(is_block),
        _ => !lines.any(|line| is_content(line, language)),
    }
}

/// True if a line before the first `%` is a block of a program and not a leader: it begins with a word and its value.
fn is_block(line: &[u8]) -> bool {
    match line {
        [b'#', ..] => true,
        [b':' | b'O' | b'o', rest @ ..] => blanks(rest).first().is_some_and(u8::is_ascii_digit),
        [letter, rest @ ..] if letter.is_ascii_alphabetic() => {
            matches!(blanks(rest).first(), Some(b'0'..=b'9' | b'.' | b'-' | b'+' | b'#' | b'['))
        }
        _ => false,
    }
}

/// True if a line is more than blanks, a comment or a mark.
fn is_content(line: &[u8], language: Language) -> bool {
    match line.first() {
        None | Some(b';' | b'%') => false,
        Some(b'(') => language == Language::Sinumerik,
        Some(_) => true,
    }
}

/// True for the number of a Fanuc program, which begins another program.
fn is_number(line: &[u8]) -> bool {
    matches!(line, [b':' | b'O' | b'o', rest @ ..] if blanks(rest).first().is_some_and(u8::is_ascii_digit))
}

/// Most bytes of a block number with its blanks.
const MOST_BEFORE: usize = 40;

/// The first `%` after a block number, and the end of its line: `N90 %`. It ends the tape like one at the beginning of a line.
fn numbered_mark(bytes: &[u8], line_end: u8) -> Option<(usize, usize)> {
    let first = text_start(bytes);
    let mut at = first;
    loop {
        let place = at + find_byte(&bytes[at..], b'%')?;
        at = place + 1;
        let from = place.saturating_sub(MOST_BEFORE).max(first);
        let start = match bytes[from..place].iter().rposition(|&byte| byte == line_end) {
            Some(end) => from + end + 1,
            None if from == first => first,
            None => continue,
        };
        if let [b'N' | b'n', number @ ..] = blanks(&bytes[start..place])
            && number.iter().any(u8::is_ascii_digit)
            && number.iter().all(|&byte| byte.is_ascii_digit() || byte == b'.' || is_blank(byte))
        {
            return Some((place, find_byte(&bytes[place..], line_end).map_or(bytes.len(), |length| place + length)));
        }
    }
}

/// Reports the first block that follows a `%` with a block number, in its line or in later ones.
pub(super) fn lost_after_number(source: &Source, language: Language) -> Option<Diagnostic> {
    let (bytes, line_end) = (source.bytes(), source.line_end());
    // A Sinumerik has no such mark: there it is an error of its own.
    let mark = numbered_mark(bytes, line_end).filter(|_| language != Language::Sinumerik)?;
    let own = std::iter::once((mark.0 + 1, mark.1));
    let later = lines_after(bytes, mark.1 + 1, line_end);
    let mut lines = own.chain(later).take_while(|&(start, end)| blanks(&bytes[start..end]).first() != Some(&b'%'));
    let line = lines.find(|&(start, end)| is_block(blanks(&bytes[start..end])))?;
    let text = blanks(&bytes[line.0..line.1]);
    let number = 1 + bytes[..mark.0].iter().filter(|&&byte| byte == line_end).count();
    let start = line.1 - text.len();
    let length = text.iter().rev().skip_while(|&&byte| is_blank(byte)).count();
    let place = Place { file: source.id(), span: Span::new(start, start + length) };
    let message =
        format!("the % after the block number in line {number} ends the program at the control, and blocks follow it");
    let help = format!("remove the % in line {number} if the program continues after it; otherwise remove the blocks");
    Some(Diagnostic::at(Code::LOST_PROGRAM, place, message, help))
}

/// Reports the first line that no control reads, because it follows the `%` that ends the tape.
///
/// Without a `%` at the start, a `%` between blocks is an error: the tool may stop in the material.
pub(super) fn lost_lines(source: &Source, language: Language) -> Option<Diagnostic> {
    let (bytes, line_end) = (source.bytes(), source.line_end());
    let rest_of = |&(start, end): &(usize, usize)| blanks(&blanks(&bytes[start..end])[1..]);
    // `%_N_PART_MPF` and `%PM9001` begin a program; only a mark without text ends the tape in their languages.
    let is_bare = |mark: &(usize, usize)| match language {
        Language::Sinumerik | Language::Grundig => {
            !rest_of(mark).first().is_some_and(u8::is_ascii_alphanumeric) && !rest_of(mark).starts_with(b"_")
        }
        _ => true,
    };
    let first = marks(bytes, line_end).next()?;
    let is_content_line = |&(start, end): &(usize, usize)| is_content(blanks(&bytes[start..end]), language);
    let content = lines_after(bytes, text_start(bytes), line_end).find(is_content_line)?.0;
    let is_opened = match language {
        Language::Fanuc => is_leader(&bytes[..first.0], line_end, language),
        _ => first.0 < content,
    };
    let mark = match (language, is_opened) {
        // Several programs of a Fanuc may stand between marks; those that are not executed are named when the program ends.
        (Language::Fanuc, true) => marks(bytes, line_end).skip(1).last(),
        (Language::Fanuc, false) => Some(first),
        _ => marks(bytes, line_end).filter(is_bare).find(|mark| mark.0 > content),
    }?;
    let has_later = !is_opened && marks(bytes, line_end).last().is_some_and(|last| last != mark);
    let parts_begin_with_marks = matches!(language, Language::Sinumerik | Language::Grundig);
    let begins_part = |line: &(usize, usize)| {
        parts_begin_with_marks && blanks(&bytes[line.0..line.1]).first() == Some(&b'%') && !is_bare(line)
    };
    let mut lines = lines_after(bytes, mark.1, line_end).take_while(|line| !begins_part(line));
    // Words in the line of the mark are lost too; a number of a program is not.
    let own = rest_of(&mark);
    let is_own = matches!(language, Language::Fanuc | Language::Rs274) && is_block(own) && !is_number(own);
    let own = is_own.then(|| (mark.1 - own.len(), mark.1));
    let line = own.or_else(|| {
        lines.find(|&(start, end)| {
            let text = blanks(&bytes[start..end]);
            if is_opened && matches!(language, Language::Fanuc | Language::Rs274) {
                is_block(text)
            } else {
                is_content(text, language)
            }
        })
    })?;
    let text = blanks(&bytes[line.0..line.1]);
    if language == Language::Fanuc && has_later && (is_number(text) || is_number(rest_of(&mark))) {
        return None;
    }
    let number = 1 + bytes[..mark.0].iter().filter(|&&byte| byte == line_end).count();
    let start = line.1 - text.len();
    let length = text.iter().rev().skip_while(|&&byte| is_blank(byte)).count();
    let place = Place { file: source.id(), span: Span::new(start, start + length) };
    if is_opened {
        let message = format!("this line and those after it are ignored: the % in line {number} ends the program");
        let help = format!("remove the lines, or the % in line {number} if the program continues after it");
        return Some(Diagnostic::at(Code::MORE_PROGRAMS, place, message, help));
    }
    let message = format!("a control that stops at the % in line {number} never executes this line and those after it");
    let help = format!(
        "remove the % in line {number} if the program continues after it; remove the lines before it if the program begins there"
    );
    Some(Diagnostic::at(Code::LOST_PROGRAM, place, message, help))
}

/// The lines after an offset, each from its start to its end without the end of the line.
fn lines_after(bytes: &[u8], from: usize, line_end: u8) -> impl Iterator<Item = (usize, usize)> {
    let mut at = from;
    std::iter::from_fn(move || {
        if at >= bytes.len() {
            return None;
        }
        let start = at;
        let end = find_byte(&bytes[start..], line_end).map_or(bytes.len(), |length| start + length);
        at = end + 1;
        Some((start, end))
    })
}
