//! The file formats of the controls: one file each, and their registry ([`Formats`]), which a caller may extend.
//!
//! To add one from another crate, write a static [`Format`] with its functions and pass it to `ncfix::Registry::with_format`.

mod cec;
mod comp;
mod enc;
mod etalon;
mod fanuc;
mod grundig;
mod heidenhain;
mod ini;
mod isg;
mod limits;
mod marks;
mod matrixkins;
mod naming;
mod pitch;
mod plain;
mod scan;
mod shape;
mod ssfk;

pub use limits::{FormatLimits, Holds};
pub use marks::multiplication_of;

use std::collections::BTreeSet;

use super::{Tables, Wiring};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::register::{Register, Registered};
use ncfix_base::source::Source;

/// The table format of a control.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Its name for `--format`.
    pub name: &'static str,
    /// The control, in a few words.
    pub title: &'static str,
    /// Meaning and sign of its values, as a sentence for remarks in its files and for the screen.
    pub sign: &'static str,
    /// Supported table kinds.
    pub holds: &'static [Holds],
    /// Limits.
    pub limits: FormatLimits,
    /// Rounds values and positions to the written resolution, so that written and checked tables are identical.
    pub round: fn(&mut Tables),
    /// Errors specific to this format, one sentence each, other than those of [`Holds`] and [`FormatLimits`].
    pub faults: fn(&Tables, &Wiring) -> Vec<String>,
    /// The text of rounded tables without errors; comment lines describe them. One file with an empty suffix, or several.
    pub write: fn(&Tables, &Wiring, &[String]) -> Vec<Written>,
    /// Reads a file, or one of several, into the tables; it is complete if there is no error among the diagnostics.
    pub read: fn(&Source, &Wiring, &mut Tables) -> Vec<Diagnostic>,
    /// The numbers of the tables in a file, if a second file with one of them replaces it in the control.
    pub numbers: fn(&Source) -> BTreeSet<usize>,
    /// Formats whose tables may be in the same file of a control; the control adds the values of both.
    pub beside: &'static [&'static str],
    /// The setting of the control that limits the sum of the corrections of an axis, as a remark: from the name of the axis at the control, the largest
    /// sum in mm or deg, and its unit.
    pub sum_limit: Option<fn(&str, f64, &str) -> String>,
    /// True if files name axes by their numbers at the control (`AX4`), which only the control knows.
    pub has_axis_numbers: bool,
    /// `true` if a file looks like this format, by its name and first bytes.
    pub is_mine: fn(&str, &[u8]) -> bool,
}

/// A file of tables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// Suffix added to the stem of the requested name, with its extension; empty for the only file.
    pub suffix: String,
    /// Content.
    pub text: String,
}

/// Help for a table with gaps.
const KEEPS: &str =
    "write every point from MIN to MAX: at a missing point the control keeps its old value, which is unknown here";

/// Help for a point that is set twice.
const TWICE: &str = "remove one of them: the control uses the last one";

/// For formats whose tables have no numbers, or whose readers detect repeated axes themselves.
#[must_use]
pub fn without_numbers(_: &Source) -> BTreeSet<usize> {
    BTreeSet::new()
}

/// The table file formats: [`Register::default`](ncfix_base::register::Register::default) contains the built-in ones.
pub type Formats = Register<&'static Format>;

impl Registered for &'static Format {
    const KIND: &'static str = "table format";

    fn name(&self) -> &str {
        self.name
    }

    fn built_in() -> Vec<Box<Self>> {
        FORMATS.iter().map(Box::new).collect()
    }

    fn conflict(&self, other: &Self) -> Option<String> {
        self.name.eq_ignore_ascii_case(other.name).then(|| "names that differ only in case are the same".into())
    }
}

/// The built-in formats.
pub const FORMATS: &[Format] = &[
    cec::FORMAT,
    enc::FORMAT,
    fanuc::FORMAT,
    pitch::FORMAT,
    heidenhain::FORMAT,
    grundig::FORMAT,
    comp::FORMAT,
    matrixkins::FORMAT,
    isg::FORMAT,
    etalon::FORMAT,
    ssfk::FORMAT,
];

/// The format of a name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Format> {
    FORMATS.iter().find(|format| format.name.eq_ignore_ascii_case(name))
}

/// The format of a file, as far as its name and first bytes determine it.
#[must_use]
pub fn guess(name: &str, bytes: &[u8]) -> Option<&'static Format> {
    guess_with(&Formats::default(), name, bytes)
}

/// The format of a file among these, as [`guess`] determines it.
#[must_use]
pub fn guess_with(formats: &Formats, name: &str, bytes: &[u8]) -> Option<&'static Format> {
    formats.iter().copied().find(|format| (format.is_mine)(name, bytes))
}

/// All formats of which a file has tables: a control may save several kinds of tables in one file.
#[must_use]
pub fn guesses(name: &str, bytes: &[u8]) -> Vec<&'static Format> {
    guesses_with(&Formats::default(), name, bytes)
}

/// All formats among these of which a file has tables, as [`guesses`] determines them.
#[must_use]
pub fn guesses_with(formats: &Formats, name: &str, bytes: &[u8]) -> Vec<&'static Format> {
    // Only formats with named variables may share a file; the others use a file as a whole.
    let Some(first) = guess_with(formats, name, bytes) else { return Vec::new() };
    let beside = formats.iter().copied().filter(|other| other.name != first.name && first.beside.contains(&other.name));
    std::iter::once(first).chain(beside.filter(|other| (other.is_mine)(name, bytes))).collect()
}

impl Format {
    /// `true` if it supports such tables.
    #[must_use]
    pub fn can_hold(&self, what: Holds) -> bool {
        self.holds.contains(&what)
    }

    /// The reasons why the control cannot accept these tables, one sentence each.
    #[must_use]
    pub fn faults_of(&self, tables: &Tables, wiring: &Wiring) -> Vec<String> {
        let mut faults = limits::kinds(self, tables);
        faults.extend(limits::exceeded(&self.limits, tables));
        faults.extend(shape::faults(tables));
        faults.extend((self.faults)(tables, wiring));
        faults
    }
}

/// A value rounded to a multiple of 10^-decimals, identical to its decimal text.
pub(crate) fn rounded(value: f64, decimals: usize) -> f64 {
    let text = format!("{value:.decimals$}");
    let read: f64 = text.parse().unwrap_or(value);
    // No negative zero.
    if read == 0.0 { 0.0 } else { read }
}
