//! Detectors: recognize the dialect of a file by its name or by one of its lines. Each dialect has one; a caller adds others to [`Detectors`] for the files
//! of a post-processor or of a workshop.

use std::sync::LazyLock;

use ncfix_base::pattern::{Regex, pattern};
use ncfix_base::register::{Register, Registered};

use super::{DIALECTS, Dialect};

/// Number of bytes of a file that are examined.
const HEAD: usize = 8192;

/// Features that identify a dialect.
#[derive(Clone, Debug)]
pub struct Detector {
    name: String,
    dialect: &'static Dialect,
    extensions: Vec<String>,
    mark: Regex,
    /// Matches only the first line that is not blank and not `%` alone.
    first_mark: Option<Regex>,
}

/// Detectors in the order in which they are asked. [`Register::default`] contains those of the dialects.
pub type Detectors = Register<Detector>;

impl Detector {
    /// Creates a detector with a name, file extensions, and a pattern that a line of the dialect matches. Blanks at the ends of the line are removed, and
    /// case is ignored; `^` and `$` match the ends of the line.
    ///
    /// # Errors
    /// The pattern is not valid. The error is a sentence.
    pub fn new(
        name: impl Into<String>,
        dialect: &'static Dialect,
        extensions: &[&str],
        mark: &str,
    ) -> Result<Detector, String> {
        let mark = pattern(mark).map_err(|fault| format!("the pattern '{mark}' is not valid: {fault}"))?;
        let extensions = extensions.iter().map(|extension| extension.to_ascii_lowercase()).collect();
        Ok(Detector { name: name.into(), dialect, extensions, mark, first_mark: None })
    }
}

impl Registered for Detector {
    const KIND: &'static str = "dialect detector";

    fn name(&self) -> &str {
        &self.name
    }

    fn built_in() -> Vec<Box<Self>> {
        static OF_DIALECTS: LazyLock<Vec<Detector>> = LazyLock::new(|| {
            let of = |one: &'static Dialect| {
                let detector = Detector::new(one.name, one, one.extensions, one.mark)?;
                let first_mark = one.first_mark.map(pattern).transpose().map_err(|fault| fault.to_string())?;
                Ok::<_, String>(Detector { first_mark, ..detector })
            };
            // The patterns are constants, and tests match each of them.
            DIALECTS.iter().filter_map(|one| of(one).ok()).collect()
        });
        OF_DIALECTS.iter().cloned().map(Box::new).collect()
    }
}

/// Guesses like [`guess`](super::guess), with these detectors; if several detectors match, the first one counts.
#[must_use]
pub fn guess_with(detectors: &Detectors, file_name: &str, bytes: &[u8]) -> Option<&'static Dialect> {
    let extension = file_name.rsplit_once('.').map(|(_, extension)| extension.to_ascii_lowercase());
    let by_name = extension.and_then(|e| detectors.iter().find(|detector| detector.extensions.contains(&e)));
    let found = by_name.or_else(|| {
        let head = &bytes[..bytes.len().min(HEAD)];
        let is_blank = |byte: &u8| *byte <= b' ' || *byte == 0x7f;
        let lines = || {
            let lines = head.split(|&byte| byte == b'\n' || byte == b'\r');
            lines.map(move |line| {
                let start = line.iter().position(|byte| !is_blank(byte)).unwrap_or(line.len());
                line[start..].trim_ascii_end()
            })
        };
        let first = lines().find(|line| !matches!(*line, b"" | b"%"));
        let begins = |detector: &Detector| {
            detector.first_mark.as_ref().zip(first).is_some_and(|(mark, line)| mark.is_match(line))
        };
        detectors.iter().find(|&detector| begins(detector) || lines().any(|line| detector.mark.is_match(line)))
    });
    found.map(|detector| detector.dialect)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_detector_of_a_caller_tells_what_no_dialect_does() {
        let own = Detector::new("shop", crate::find("fanuc").unwrap(), &["TAP"], r"^\(posted by shop").unwrap();
        let detectors = Detectors::default().with(own);
        let found = |name: &str, text: &str| guess_with(&detectors, name, text.as_bytes()).map(|one| one.name);
        assert_eq!(found("a.tap", ""), Some("fanuc"));
        assert_eq!(found("a.nc", "%\n (Posted by SHOP 3)\nG0 X1"), Some("fanuc"));
        assert_eq!(found("a.nc", "%_N_X_MPF\n(posted by shop)"), Some("sinumerik"));
        assert_eq!(found("a.nc", "G0 X1"), None);
        assert!(Detector::new("bad", crate::sinumerik(), &[], "(").is_err());
    }
}
