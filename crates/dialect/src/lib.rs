//! Control languages (dialects) as values: tables of codes and words, file extensions and settings. This crate does not parse or execute programs.

mod block_ends;
mod blocks;
mod code;
mod detector;
mod elimination;
mod fanuc;
mod foreign;
mod grundig;
mod likeness;
mod rs274;
mod sinumerik;
mod turning;
mod turning_names;
mod word;

use std::sync::LazyLock;

pub use block_ends::{BlockEnd, BlockEnds};
pub use code::{CodeEffect, CodeEntry, CodeTable};
pub use detector::{Detector, Detectors, guess_with};
pub use elimination::{elimination, usual_of_name};
pub use foreign::{Foreign, foreign};
pub use likeness::{Likeness, likeness};
pub use turning::{Mark, turning};
pub use word::{Treatment, ValueUnit, WordEntry, WordPlace, WordTable, words};

/// Language of a dialect, on which parser and execution depend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// Sinumerik.
    Sinumerik,
    /// Grundig, Philips, MillPlus.
    Grundig,
    /// Fanuc with custom macros.
    Fanuc,
    /// RS274/NGC.
    Rs274,
}

/// Dialect of a control.
pub struct Dialect {
    /// Language.
    pub language: Language,
    /// Name on the command line and in machine files.
    pub name: &'static str,
    /// Common name.
    pub title: &'static str,
    /// File extensions, lower case.
    pub extensions: &'static [&'static str],
    /// Pattern of lines that identify the dialect, without blanks at their ends; case is ignored.
    mark: &'static str,
    /// A pattern that only the first line of the dialect matches.
    first_mark: Option<&'static str>,
    /// True if programs of this dialect can be executed.
    pub is_executable: bool,
    /// Words for exact stops.
    pub block_ends: BlockEnds,
    codes: fn() -> &'static CodeTable,
}

impl Dialect {
    /// Returns the table of G codes and words without a value.
    #[must_use]
    pub fn codes(&self) -> &'static CodeTable {
        (self.codes)()
    }
}

impl std::fmt::Debug for Dialect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// Built-in dialects; if several match a file, the first one counts.
pub static DIALECTS: &[Dialect] = &[sinumerik::SINUMERIK, grundig::GRUNDIG, rs274::RS274, fanuc::FANUC];

/// Returns the Sinumerik dialect.
#[must_use]
pub fn sinumerik() -> &'static Dialect {
    &DIALECTS[0]
}

/// Returns the dialect of a name; case is ignored.
#[must_use]
pub fn find(name: &str) -> Option<&'static Dialect> {
    DIALECTS.iter().find(|dialect| dialect.name.eq_ignore_ascii_case(name))
}

/// Guesses the dialect from the file name, then from the first kilobytes. Words that occur in several dialects are not used: a wrong guess would
/// change the meaning of numbers, for example of those without a decimal point.
#[must_use]
pub fn guess(file_name: &str, bytes: &[u8]) -> Option<&'static Dialect> {
    static OF_DIALECTS: LazyLock<Detectors> = LazyLock::new(Detectors::default);
    guess_with(&OF_DIALECTS, file_name, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn name_goes_before_content() {
        assert_eq!(guess("a.MPF", b"").map(|d| d.name), Some("sinumerik"));
        assert_eq!(guess("a.pm", b"N1 G17").map(|d| d.name), Some("grundig"));
        assert_eq!(guess("a.ngc", b"O1\n").map(|d| d.name), Some("rs274"));
    }

    #[test]
    fn content_tells_where_the_name_does_not() {
        for (text, name) in [
            ("%\r\nO1234 (X)\r\n", "fanuc"),
            ("%\nO0001\nN10 G0 X1", "fanuc"),
            ("%O0001\nN10 G0 X1", "fanuc"),
            (":1234(X)\nG0 X1", "fanuc"),
            ("G0 X1\nIF[#1EQ2]GOTO10", "fanuc"),
            ("%\nO915100 (WARMING UP)\nN0001 (START)\nN9990\nM9", "fanuc"),
            ("%\nN9001 (ARCS)\nN1 G17", "grundig"),
            ("\n%_N_X_MPF\n", "sinumerik"),
            ("%PM9001\n", "grundig"),
            ("% pm\nN9001", "grundig"),
            ("\0\0%PM\r\n\r\nN9000 (X)", "grundig"),
            ("N9001 (ARCS)\nN1 G17", "grundig"),
            ("N10 G54 I3\nN20 X=E1+3 F=E2", "grundig"),
            ("%\no<a> sub\n", "rs274"),
            ("o100 sub\nG0 X1\no100 endsub", "rs274"),
            ("O100 IF [#1 GT 2]", "rs274"),
            ("#<depth> = 5", "rs274"),
            ("g0 x#<_hal[a]>", "rs274"),
            ("(debug, #1)", "rs274"),
        ] {
            assert_eq!(guess("a.nc", text.as_bytes()).map(|d| d.name), Some(name), "{text}");
        }
        for text in
            ["G0 X1", "N10 G0 X1\nN20 G1 X2. F100", "", "%\nG0 X1", "#1=5", "N10 (TEXT)\nG0 X1", "N1 G0 X1\nN9990\nM9"]
        {
            assert!(guess("a.nc", text.as_bytes()).is_none(), "{text}");
        }
    }
}
