//! Patterns for the text of files and controls: regular expressions over bytes that ignore case.
//!
//! Texts of controls are not always UTF-8, so patterns see bytes. `.` matches any byte, also the end of a line; `\s`, `\b` and classes are ASCII.

use regex::bytes::{RegexBuilder, RegexSetBuilder};

pub use regex::bytes::{Regex, RegexSet};

/// Compiles constant patterns. Returns the empty set if one of them is not a pattern: a test must match each.
#[must_use]
pub fn patterns<'p>(patterns: impl IntoIterator<Item = &'p str>) -> RegexSet {
    let set = RegexSetBuilder::new(patterns).unicode(false).case_insensitive(true).dot_matches_new_line(true).build();
    set.unwrap_or_else(|_| RegexSet::empty())
}

/// Compiles one pattern.
///
/// # Errors
/// Returns an error if the text is not a pattern.
pub fn pattern(text: &str) -> Result<Regex, regex::Error> {
    RegexBuilder::new(text).unicode(false).case_insensitive(true).dot_matches_new_line(true).build()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_see_bytes_and_ignore_case() {
        let set = patterns([r"^begin .*\.com", r"\xff"]);
        assert_eq!(set.matches(b"BEGIN A\n.COM").iter().collect::<Vec<_>>(), [0]);
        assert_eq!(set.matches(b"a \xff").iter().collect::<Vec<_>>(), [1]);
        assert!(!set.is_match(b" begin a"));
        assert!(patterns(["("]).is_empty() && pattern("(").is_err() && pattern("^N[0-9]").unwrap().is_match(b"n1"));
    }
}
