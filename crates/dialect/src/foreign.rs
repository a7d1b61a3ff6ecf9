//! Tells texts of controls whose language is not read here. Where their words look like known ones they move the tool otherwise.

use super::begins;
use super::blocks::lines;

/// Bytes that are looked through: such texts tell of themselves at their beginning.
const HEAD: usize = 8192;

/// A control whose language is not read here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Foreign {
    /// What people call it.
    pub name: &'static str,
    /// What was found, with its line from 1 and the place where that begins, bytes.
    pub found: String,
    /// Its line, from 1.
    pub line: u32,
    /// Where the line begins, bytes from the start of the text.
    pub at: usize,
}

/// A language, the texts that tell of it, and how many kinds of them it takes.
struct Language {
    name: &'static str,
    tells: &'static [fn(&[u8]) -> bool],
    enough: usize,
}

const LANGUAGES: &[Language] = &[
    Language {
        name: "a Heidenhain Klartext program",
        tells: &[
            |line| begins(behind_digits(line), "BEGIN PGM "),
            |line| begins(behind_digits(line), "BLK FORM "),
            |line| begins(behind_digits(line), "TOOL CALL "),
            |line| begins(behind_digits(line), "CYCL DEF "),
            |line| begins(behind_digits(line), "END PGM "),
        ],
        enough: 1,
    },
    Language {
        name: "an Okuma OSP program",
        tells: &[
            |line| line.first() == Some(&b'$') && contains(line, ".MIN"),
            |line| has_name(line, "CALL O"),
            |line| is_assigned(line, "VC"),
            |line| begins(line, "G15 H") || contains(line, " G15 H"),
            |line| begins(line, "G56 H") && has_name(line, "HA"),
            |line| begins(line, "NLAP") || has_name(line, "G85 NLAP"),
        ],
        enough: 2,
    },
    Language {
        name: "a program of a 3D printer",
        tells: &[
            |line| begins(line, ";FLAVOR:"),
            |line| ["M104 S", "M109 S", "M140 S", "M190 S"].iter().any(|code| begins(line, code)),
            |line| begins(line, "G92 E"),
            |line| (begins(line, "G1 ") || begins(line, "G0 ")) && has_number_of(line, b'E'),
        ],
        enough: 2,
    },
    Language {
        name: "a ShopMill or ShopTurn program of a Sinumerik, steps of a work plan",
        tells: &[|line| has_name(line, "E_HEAD("), |line| has_name(line, "F_HEAD(")],
        enough: 1,
    },
    Language {
        name: "a Mazatrol program, which is conversational",
        tells: &[|line| begins(line, "UNo.") && contains(line, "UNIT")],
        enough: 1,
    },
];

/// What control a text is of, where that is none of the known ones.
#[must_use]
pub fn foreign(bytes: &[u8]) -> Option<Foreign> {
    let head = bytes.get(..bytes.len().min(HEAD)).unwrap_or_default();
    LANGUAGES.iter().find_map(|language| {
        let mut kinds = vec![false; language.tells.len()];
        let mut first = None;
        for (number, (at, line)) in (1..).zip(lines(head)) {
            let text = line.trim_ascii();
            for (is_found, tells) in kinds.iter_mut().zip(language.tells) {
                if tells(text) {
                    *is_found = true;
                    first.get_or_insert((number, at, text));
                }
            }
        }
        let (line, at, text) = first.filter(|_| kinds.iter().filter(|&&found| found).count() >= language.enough)?;
        let found = text.iter().take(40).map(|&byte| if (b' '..0x7f).contains(&byte) { char::from(byte) } else { '?' });
        Some(Foreign { name: language.name, found: found.collect(), line, at })
    })
}

fn behind_digits(line: &[u8]) -> &[u8] {
    let digits = line.iter().take_while(|byte| byte.is_ascii_digit()).count();
    line.get(digits..).unwrap_or_default().trim_ascii_start()
}

fn contains(line: &[u8], text: &str) -> bool {
    line.windows(text.len()).any(|part| part.eq_ignore_ascii_case(text.as_bytes()))
}

/// Whether a text stands at the beginning of a line or behind something that is no part of a name.
fn has_name(line: &[u8], text: &str) -> bool {
    let is_free =
        |at: usize| at == 0 || line.get(at - 1).is_some_and(|byte| !byte.is_ascii_alphabetic() && *byte != b'_');
    line.windows(text.len()).enumerate().any(|(at, part)| part.eq_ignore_ascii_case(text.as_bytes()) && is_free(at))
}

/// Whether a name with a number gets a value: `VC1=10`.
fn is_assigned(line: &[u8], name: &str) -> bool {
    let Some(rest) = line.get(name.len()..).filter(|_| begins(line, name)) else { return false };
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    digits > 0 && rest.get(digits..).unwrap_or_default().trim_ascii_start().first() == Some(&b'=')
}

/// Whether a letter with a number stands behind a blank.
fn has_number_of(line: &[u8], letter: u8) -> bool {
    line.windows(3).any(|part| {
        part[0] == b' ' && part[1] == letter && (part[2].is_ascii_digit() || matches!(part[2], b'-' | b'.'))
    })
}
