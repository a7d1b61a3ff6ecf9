//! Growth of a program: written blocks per line with words of the source.

/// Number of lines that have words: neither empty nor only a comment.
#[must_use]
pub fn lines_with_words(text: &[u8]) -> u64 {
    let has_words = |line: &&[u8]| !matches!(line.trim_ascii().first(), None | Some(b';' | b'(' | b'%'));
    text.split(|&byte| byte == b'\n').filter(has_words).count() as u64
}

/// Written blocks per line of the source.
#[must_use]
pub fn growth(lines: u64, blocks: u64) -> f64 {
    blocks as f64 / lines.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_empty_lines_do_not_count() {
        assert_eq!(lines_with_words(b"%\n; plate\n\nN10 G0 X1\r\n (note)\nG1 X2\n"), 2);
        assert!((growth(2, 9) - 4.5).abs() < 1e-12);
        assert!((growth(0, 3) - 3.0).abs() < 1e-12);
    }
}
