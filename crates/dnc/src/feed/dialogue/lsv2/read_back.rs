//! Comparison of a file on the control with the file that was sent.
//!
//! In the binary mode all bytes must be equal. In the text mode the control keeps lines, and sends a zero byte, `LF` or `CR LF` at the end of each. So there
//! the line ends count as equal, and all other bytes must be equal.

use super::super::answers::shown;

/// Longest part of a line that is shown, bytes.
const SHOWN: usize = 60;

/// Bytes of the control that are compared as they come.
#[derive(Debug)]
pub(super) struct ReadBack {
    is_binary: bool,
    /// Next byte of the sent file.
    at: usize,
    /// Bytes that have come.
    count: usize,
    /// True if a `CR` waits for the byte after it.
    holds_cr: bool,
    line: u64,
    /// Beginning of the current line of the control.
    begin: Vec<u8>,
    /// The first line that differs.
    difference: Option<u64>,
}

impl ReadBack {
    pub(super) fn new(is_binary: bool) -> ReadBack {
        ReadBack { is_binary, at: 0, count: 0, holds_cr: false, line: 1, begin: Vec::new(), difference: None }
    }

    /// Bytes that have come.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Compares further bytes.
    pub(super) fn take(&mut self, bytes: &[u8], sent: &[u8]) {
        self.count += bytes.len();
        for &byte in bytes {
            if self.is_binary {
                self.compare(byte, sent);
                continue;
            }
            let had_cr = std::mem::take(&mut self.holds_cr);
            match byte {
                b'\r' => {
                    if had_cr {
                        self.compare(b'\r', sent);
                    }
                    self.holds_cr = true;
                }
                0 | b'\n' => {
                    if had_cr && byte == 0 {
                        self.compare(b'\r', sent);
                    }
                    self.compare(b'\n', sent);
                }
                _ => {
                    if had_cr {
                        self.compare(b'\r', sent);
                    }
                    self.compare(byte, sent);
                }
            }
        }
    }

    fn compare(&mut self, byte: u8, sent: &[u8]) {
        if self.difference.is_some() {
            // The rest of the line is shown.
            if byte != b'\n' && self.begin.len() < SHOWN && self.line == self.difference.unwrap_or_default() {
                self.begin.push(byte);
            } else {
                self.line = u64::MAX;
            }
            return;
        }
        let expected = self.next(sent);
        if expected != Some(byte) {
            self.difference = Some(self.line);
        }
        if byte != b'\n' {
            if self.begin.len() < SHOWN {
                self.begin.push(byte);
            }
        } else if self.difference.is_none() {
            self.line += 1;
            self.begin.clear();
        } else {
            self.line = u64::MAX;
        }
    }

    /// Next byte of the sent file; in the text mode a line end is one `LF`.
    fn next(&mut self, sent: &[u8]) -> Option<u8> {
        let rest = sent.get(self.at..)?;
        let (byte, length) = match rest {
            [b'\r', b'\n', ..] if !self.is_binary => (b'\n', 2),
            [byte, ..] => (*byte, 1),
            [] => return None,
        };
        self.at += length;
        Some(byte)
    }

    /// Returns the first difference after the last byte as a sentence; `None` if the files are equal.
    pub(super) fn finish(&mut self, sent: &[u8]) -> Option<String> {
        if std::mem::take(&mut self.holds_cr) {
            self.compare(b'\r', sent);
        }
        if self.difference.is_none() {
            let rest = sent.get(self.at..).unwrap_or_default();
            // A control may keep no line end after the last line.
            let is_end = rest.is_empty() || !self.is_binary && matches!(rest, b"\r\n" | b"\n");
            return (!is_end).then(|| format!("it ends in line {}, before the end of the program", self.line));
        }
        let number = self.difference.unwrap_or_default();
        let index = usize::try_from(number.saturating_sub(1)).unwrap_or(usize::MAX);
        let own = sent.split(|byte| *byte == b'\n').nth(index).unwrap_or_default();
        let text = |bytes: &[u8]| shown(String::from_utf8_lossy(bytes).trim_end());
        Some(format!("line {number} is '{}' instead of '{}'", text(&self.begin), text(own)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENT: &[u8] = b"G0 X1\r\nG1 Y2\r\n";

    fn compare(is_binary: bool, back: &[u8]) -> Option<String> {
        let mut found = ReadBack::new(is_binary);
        back.chunks(3).for_each(|chunk| found.take(chunk, SENT));
        assert_eq!(found.count(), back.len());
        found.finish(SENT)
    }

    #[test]
    fn line_ends_may_differ_in_text_and_nothing_else() {
        for back in [SENT, b"G0 X1\0G1 Y2\0", b"G0 X1\nG1 Y2\n", b"G0 X1\r\nG1 Y2", b"G0 X1\0G1 Y2"] {
            assert_eq!(compare(false, back), None, "{back:?}");
            assert_eq!(compare(true, back).is_none(), back == SENT, "{back:?}");
        }
        for (back, says) in [
            (&b"G0 X1\0G1 Y3\0"[..], "line 2 is 'G1 Y3' instead of 'G1 Y2'"),
            (b"G0 X\0G1 Y2\0", "line 1 is 'G0 X' instead of 'G0 X1'"),
            (b"G0 X1\0\0G1 Y2\0", "line 2 is ''"),
            (b"G0 X1\0", "ends in line 2"),
            (b"", "ends in line 1"),
            (b"G0 X1\0G1 Y2\0M30\0", "line 3 is 'M30' instead of ''"),
            (b"G0 X1\r\0G1 Y2\0", "line 1"),
            (b"G0 X1\0G1 Y2\0\r", "line 3"),
        ] {
            assert!(compare(false, back).is_some_and(|why| why.contains(says)), "{back:?}: {:?}", compare(false, back));
        }
    }
}
