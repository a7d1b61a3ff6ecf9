//! The file formats of the controls: one file each, and the register of them ([`Formats`]), which a caller extends.
//!
//! To add one from another crate, write a static [`Format`] with its functions and give it to
//! [`Formats::with`](ncfix_base::register::Register::with).

mod cec;
mod comp;
mod enc;
mod fanuc;
mod grundig;
mod heidenhain;
mod ini;
mod isg;
mod limits;
mod marks;
mod matrixkins;
mod naming;
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

/// How a control writes its tables.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Its name for `--format`.
    pub name: &'static str,
    /// Which control, in a few words.
    pub title: &'static str,
    /// What its values are and with which sign the control takes them, a sentence for remarks in its files and for the screen.
    pub sign: &'static str,
    /// What it can hold.
    pub holds: &'static [Holds],
    /// How much of it.
    pub limits: FormatLimits,
    /// Rounds values and positions to what the format writes, so that what is written is what was checked.
    pub round: fn(&mut Tables),
    /// What only this format forbids, a sentence each; what [`Holds`] and [`FormatLimits`] forbid is not among it.
    pub faults: fn(&Tables, &Wiring) -> Vec<String>,
    /// The text of rounded tables without faults; comment lines say what they are. One file with an empty suffix, or several.
    pub write: fn(&Tables, &Wiring, &[String]) -> Vec<Written>,
    /// Reads a file, or one of several, into the tables; without an error among the findings it is complete.
    pub read: fn(&Source, &Wiring, &mut Tables) -> Vec<Diagnostic>,
    /// The numbers of the tables that a file has, where a second file with one of them takes the place of the first in the control.
    pub numbers: fn(&Source) -> BTreeSet<usize>,
    /// The formats whose tables the same control may have in the same file, and adds.
    pub beside: &'static [&'static str],
    /// Whether a file looks like this format, from its name and its first bytes.
    pub is_mine: fn(&str, &[u8]) -> bool,
}

/// A file of tables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// What is added to the stem of the name that was asked for, with its ending; empty for the only file.
    pub suffix: String,
    /// What is in it.
    pub text: String,
}

/// What to do about a table with gaps.
const KEEPS: &str =
    "write every point from MIN to MAX: the control keeps what it had there, and nothing here tells what that is";

/// What to do about a point that is set twice.
const TWICE: &str = "leave one of them out: the control takes the last one";

/// Of formats whose tables have no numbers, or whose readers see for themselves that an axis has one already.
#[must_use]
pub fn without_numbers(_: &Source) -> BTreeSet<usize> {
    BTreeSet::new()
}

/// The formats of files of tables: [`Register::default`](ncfix_base::register::Register::default) are those that are built in.
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
        self.name.eq_ignore_ascii_case(other.name).then(|| "letters of either case are the same in its name".into())
    }
}

/// Those that are built in.
pub const FORMATS: &[Format] = &[
    cec::FORMAT,
    enc::FORMAT,
    fanuc::FORMAT,
    heidenhain::FORMAT,
    grundig::FORMAT,
    comp::FORMAT,
    matrixkins::FORMAT,
    isg::FORMAT,
    ssfk::FORMAT,
];

/// The format of a name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Format> {
    FORMATS.iter().find(|format| format.name.eq_ignore_ascii_case(name))
}

/// The format of a file, as far as its name and its first bytes tell.
#[must_use]
pub fn guess(name: &str, bytes: &[u8]) -> Option<&'static Format> {
    guess_with(&Formats::default(), name, bytes)
}

/// The format of a file among these, as [`guess`] finds it.
#[must_use]
pub fn guess_with(formats: &Formats, name: &str, bytes: &[u8]) -> Option<&'static Format> {
    formats.iter().copied().find(|format| (format.is_mine)(name, bytes))
}

/// All formats of which a file has tables: a control may save tables of several kinds in one.
#[must_use]
pub fn guesses(name: &str, bytes: &[u8]) -> Vec<&'static Format> {
    guesses_with(&Formats::default(), name, bytes)
}

/// All formats among these of which a file has tables, as [`guesses`] finds them.
#[must_use]
pub fn guesses_with(formats: &Formats, name: &str, bytes: &[u8]) -> Vec<&'static Format> {
    // Only formats that name their variables stand side by side; the others take a file as a whole.
    let Some(first) = guess_with(formats, name, bytes) else { return Vec::new() };
    let beside = formats.iter().copied().filter(|other| other.name != first.name && first.beside.contains(&other.name));
    std::iter::once(first).chain(beside.filter(|other| (other.is_mine)(name, bytes))).collect()
}

impl Format {
    /// Whether it holds such tables.
    #[must_use]
    pub fn can_hold(&self, what: Holds) -> bool {
        self.holds.contains(&what)
    }

    /// Why the control cannot take these tables, a sentence each.
    #[must_use]
    pub fn faults_of(&self, tables: &Tables, wiring: &Wiring) -> Vec<String> {
        let mut faults = limits::kinds(self, tables);
        faults.extend(limits::exceeded(&self.limits, tables));
        faults.extend(shape::faults(tables));
        faults.extend((self.faults)(tables, wiring));
        faults
    }
}

/// A value rounded to a multiple of 10^-decimals, as its decimal text reads.
pub(crate) fn rounded(value: f64, decimals: usize) -> f64 {
    let text = format!("{value:.decimals$}");
    let read: f64 = text.parse().unwrap_or(value);
    // No minus in front of zero.
    if read == 0.0 { 0.0 } else { read }
}
