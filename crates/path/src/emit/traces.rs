//! Signs that a correction has written a program: the stamp, the check of `--guard`, or the marks of added lines.
//!
//! Some links and editors remove comments, and the stamp with them. A second correction would add all corrections twice, so each remaining sign
//! counts. A program without any of them cannot be recognized.

use std::ops::Range;

use super::guard;
use super::stamp::is_stamped;
use crate::path::{CONTINUES, CONTINUES_ON_THE_SPOT, ON_THE_SPOT};

/// The check of `--guard` stands within this number of bytes from the start.
const HEAD_BYTES: usize = 256 * 1024;
/// A few such comments may be those of the programmer.
const LEAST_MARKS: usize = 3;

/// A sign of an earlier correction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CorrectionTrace {
    /// Name of the sign within a sentence: `its first comment`.
    pub what: &'static str,
    /// Bytes of the program that show it.
    pub at: Range<usize>,
}

/// Returns the most certain sign that a program was written by a correction; `None` without a sign.
#[must_use]
pub fn correction_trace(bytes: &[u8]) -> Option<CorrectionTrace> {
    const NAME: &[u8] = b"ncfix";
    if is_stamped(bytes) {
        let is_name = |window: &[u8]| window.eq_ignore_ascii_case(NAME);
        let at = bytes.windows(NAME.len()).position(is_name).unwrap_or(0);
        return Some(CorrectionTrace { what: "its first comment", at: at..at + NAME.len() });
    }
    let head = &bytes[..bytes.len().min(HEAD_BYTES)];
    if let Some((at, _)) = lines(head).find(|(_, line)| guard::is_of_guard(line)) {
        return Some(CorrectionTrace { what: "the check of --guard", at });
    }
    let mut marked = lines(bytes).filter(|(_, line)| is_marked(line));
    let first = marked.next()?;
    marked.nth(LEAST_MARKS - 2)?;
    Some(CorrectionTrace { what: "marks of added lines", at: first.0 })
}

/// The end of the guard at the start of a program, bytes; 0 without one.
#[must_use]
pub fn guard_end(bytes: &[u8]) -> usize {
    let head = &bytes[..bytes.len().min(HEAD_BYTES)];
    lines(head).filter(|(_, line)| guard::is_of_guard(line)).last().map_or(0, |(at, _)| at.end)
}

/// The lines with their places, without blanks at the ends.
fn lines(bytes: &[u8]) -> impl Iterator<Item = (Range<usize>, &[u8])> {
    let mut start = 0;
    bytes.split(|&byte| byte == b'\n').map(move |line| {
        let from = start;
        start += line.len() + 1;
        let trimmed = line.trim_ascii();
        let skipped = line.len() - line.trim_ascii_start().len();
        (from + skipped..from + skipped + trimmed.len(), trimmed)
    })
}

/// `true` if a line with words has one of the marks as its only comment.
fn is_marked(line: &[u8]) -> bool {
    let words = match line.split_last() {
        Some((b'+' | b'~', _)) => line.iter().position(|&byte| byte == b';').map(|at| (&line[..at], &line[at + 1..])),
        Some((b')', inner)) => line.iter().position(|&byte| byte == b'(').map(|at| (&line[..at], &inner[at + 1..])),
        _ => None,
    };
    words.is_some_and(|(words, comment)| {
        let marks = [CONTINUES, CONTINUES_ON_THE_SPOT, ON_THE_SPOT];
        !words.trim_ascii().is_empty() && marks.iter().any(|mark| mark.as_bytes() == comment)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sign(text: &str) -> Option<(&'static str, &str)> {
        correction_trace(text.as_bytes()).map(|found| (found.what, &text[found.at]))
    }

    #[test]
    fn signs_remain_without_the_stamp() {
        let guard = "the check of --guard";
        for (text, expected) in [
            ("G21\no<ncfix_guard_g54_x> if [ABS[#5221 - [1.]] GT 0.0006]\nM2\n", Some(guard)),
            ("N1 IF[ABS[#5221-[40.125]]GT0.0006]THEN #3000=1\nG0 X1.\n", Some(guard)),
            ("IF[ABS[#5221-[1.]]GT0.0000236]THEN#3000=1(G54 X CHANGED SINCE CORRECTION)", Some(guard)),
            ("SETAL(65000,\"G54: value at the control differs from that of the correction\")\r\n", Some(guard)),
            ("G1 X1 ;+\r\n  G1 X2 ;+~\r\nG1 X3 ;~\r\n", Some("marks of added lines")),
            ("N1 G1 X1. (+)\nN2 G1 X2. (~)\nN3 X3. (+)\n", Some("marks of added lines")),
            ("G1 X1 ;+\nG1 X2 ;~\n", None),
            ("; +\n;+\n(+)\nG1 X1 ; a+\nG1 (a) ;+\n", None),
            ("IF[ABS[#5221-#500]GT0.01]THEN #3000=1(G54 CHANGED)\nG0 X1.\n", None),
        ] {
            assert_eq!(sign(text).map(|(what, _)| what), expected, "{text}");
        }
        assert_eq!(sign("G0 X0\n  G1 X1 ;+\nG1 X2 ;+\nG1 X3 ;+\n").map(|(_, at)| at), Some("G1 X1 ;+"));
    }
}
