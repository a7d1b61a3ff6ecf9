//! The first comment of a corrected program: the machine, model and source it was made for, and that it is valid for nothing else.
//!
//! A corrected program is ephemeral: it contains the errors of one machine at one time. The stamp prevents a second correction and confusion with the
//! part program.

use std::fmt::Write as _;

use crate::path::{HOLE_TOLERANCE_MM, Promise};

/// Contents of the stamp.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stamp {
    /// Name of the machine.
    pub machine: String,
    /// First digits of the hash of the machine file, lower-case hexadecimal.
    pub model: String,
    /// First digits of the hash of the machine state, if one was given.
    pub state: Option<String>,
    /// Zero offsets that contain the error of the machine: `G54-touched,G55-probed`.
    pub zeros: Option<String>,
    /// First digits of the hash of the part program.
    pub source: String,
    /// Tolerances that the correction promises.
    pub promise: Promise,
    /// `true` for the built-in machine.
    pub is_demo: bool,
}

/// Largest tolerance that a stamp may promise, mm; more is not a correction.
const MOST_TOLERANCE_MM: f64 = 10.0;

/// The tolerance of holes without an entry of its own, mm.
fn usual_hole_mm(tolerance_mm: f64) -> f64 {
    HOLE_TOLERANCE_MM.max(tolerance_mm)
}

/// A promise as text of the stamp.
fn promise_text(promise: &Promise) -> String {
    let mut out = format!("tolerance={}", promise.tolerance_mm);
    if promise.hole_tolerance_mm != usual_hole_mm(promise.tolerance_mm) {
        let _ = write!(out, " holes={}", promise.hole_tolerance_mm);
    }
    if let Some(increment_mm) = promise.increment_mm {
        let _ = write!(out, " increment={increment_mm}");
    }
    let ways = [
        ("step", promise.is_stepped),
        ("rapids", promise.leaves_rapids),
        ("limited", promise.limits_feed),
        ("axes", promise.in_axes),
        ("wear", promise.keeps_wear),
        ("rotary", promise.corrects_rotary),
    ];
    let made: Vec<&str> = ways.into_iter().filter(|(_, is_so)| *is_so).map(|(name, _)| name).collect();
    if !made.is_empty() {
        let _ = write!(out, " made={}", made.join("-"));
    }
    out
}

/// Reads the promise from the lower-case line of a stamp; `None` if it has none or an impossible one.
fn promise_of(line: &str) -> Option<Promise> {
    let value = |key: &str| {
        let (_, rest) = line.split_once(key)?;
        rest.split([' ', ')']).next()
    };
    let length = |key: &str| {
        let value: f64 = value(key)?.parse().ok()?;
        (value > 0.0 && value <= MOST_TOLERANCE_MM).then_some(value)
    };
    let has = |name: &str| value(" made=").is_some_and(|made| made.split('-').any(|one| one == name));
    let tolerance_mm = length(" tolerance=")?;
    Some(Promise {
        tolerance_mm,
        hole_tolerance_mm: length(" holes=").unwrap_or(usual_hole_mm(tolerance_mm)),
        increment_mm: length(" increment="),
        is_stepped: has("step"),
        leaves_rapids: has("rapids"),
        limits_feed: has("limited"),
        in_axes: has("axes"),
        keeps_wear: has("wear"),
        corrects_rotary: has("rotary"),
    })
}

/// Beginning of every stamp.
const MARK: &str = "ncfix ";
/// Word that every stamp contains.
const EPHEMERAL: &str = "ephemeral";
/// Key of the checksum.
const CHECK: &str = "check=";
const ONLY: &str = "for this machine only";
/// A stamp stands within this number of bytes from the start.
const HEAD_BYTES: usize = 4096;

impl Stamp {
    /// The text of the comment, without comment delimiters. Plain ASCII without the characters that end a comment in any dialect.
    #[must_use]
    pub fn text(&self) -> String {
        let machine = with_harmless(&self.machine, |c| c.is_ascii_graphic() && !"\"();".contains(c));
        let version = env!("CARGO_PKG_VERSION");
        let (model, source, promise) = (self.model_and_state(), &self.source, promise_text(&self.promise));
        let warning = if self.is_demo { " DEMO MACHINE: not for a real machine" } else { "" };
        let wear = if self.promise.keeps_wear { ", tool radius at the control: 0 plus wear" } else { "" };
        with_check(&format!(
            "{MARK}{version} machine=\"{machine}\" model={model} source={source} {promise} {EPHEMERAL}: {ONLY}{wear}{warning}"
        ))
    }

    /// The text of the comment for controls that know only capital letters, digits and a few signs.
    #[must_use]
    pub fn capital_text(&self) -> String {
        let machine = with_harmless(&self.machine, |c| c.is_ascii_alphanumeric() || ".,=_-".contains(c));
        let version = env!("CARGO_PKG_VERSION");
        let (model, source, promise) = (self.model_and_state(), &self.source, promise_text(&self.promise));
        let warning = if self.is_demo { " - DEMO MACHINE NOT FOR A REAL MACHINE" } else { "" };
        let wear = if self.promise.keeps_wear { " - TOOL RADIUS AT THE CONTROL = 0 PLUS WEAR" } else { "" };
        with_check(&format!(
            "{MARK}{version} machine={machine} model={model} source={source} {promise} {EPHEMERAL} - {ONLY}{wear}{warning}"
        ))
        .to_ascii_uppercase()
    }
}

impl Stamp {
    fn model_and_state(&self) -> String {
        let state = self.state.as_ref().map_or_else(String::new, |state| format!(" state={state}"));
        let zeros = self.zeros.as_ref().map_or_else(String::new, |zeros| format!(" zero={zeros}"));
        format!("{}{state}{zeros}", self.model)
    }
}

/// Adds a checksum over letters and digits to a stamp, which reveals changes.
fn with_check(text: &str) -> String {
    let sum = sum(text);
    text.replacen(EPHEMERAL, &format!("{CHECK}{sum} {EPHEMERAL}"), 1)
}

/// FNV-1a over lower-case letters and digits: changes that links and controls make to a comment have no effect.
fn sum(text: &str) -> String {
    const START: u32 = 0x811c_9dc5;
    const PRIME: u32 = 0x0100_0193;
    let letters = text.bytes().filter(u8::is_ascii_alphanumeric).map(|byte| byte.to_ascii_lowercase());
    let sum = letters.fold(START, |sum, byte| (sum ^ u32::from(byte)).wrapping_mul(PRIME));
    format!("{:06x}", sum & 0xff_ffff)
}

/// `true` if the stamp of a program was changed after it was written; `None` without a stamp or, as in earlier versions, without a checksum.
#[must_use]
pub fn is_stamp_changed(bytes: &[u8]) -> Option<bool> {
    let line = line(bytes)?;
    let stamp = &line[line.find(MARK)?..];
    let (before, rest) = stamp.split_once(CHECK)?;
    let (written, behind) = rest.split_once(' ').unwrap_or((rest, ""));
    Some(sum(&format!("{before}{behind}")) != written)
}

fn with_harmless(text: &str, is_harmless: impl Fn(char) -> bool) -> String {
    text.chars().map(|c| if c == ' ' || is_harmless(c) { c } else { '_' }).collect()
}

/// `true` if a program has a stamp: a comment, `; …` or `( … )`, among its first lines. Line numbers, header lines and line ends have no effect.
#[must_use]
pub fn is_stamped(bytes: &[u8]) -> bool {
    bytes[..bytes.len().min(HEAD_BYTES)].split(|&byte| byte == b'\n' || byte == b'\r').any(|line| {
        let Some(at) = line.iter().position(|&byte| byte == b';' || byte == b'(') else { return false };
        let comment = line[at + 1..].trim_ascii_start();
        // Some links and controls convert everything to capitals.
        let holds = |part: &[u8]| comment.windows(part.len()).any(|window| window.eq_ignore_ascii_case(part));
        comment.get(..MARK.len()).is_some_and(|start| start.eq_ignore_ascii_case(MARK.as_bytes()))
            && holds(b"machine=")
            && holds(EPHEMERAL.as_bytes())
            && holds(ONLY.as_bytes())
    })
}

/// The hash of the model in a program's stamp; `None` without a stamp.
#[must_use]
pub fn stamped_model(bytes: &[u8]) -> Option<String> {
    stamped(bytes, "model=")
}

/// The hash of the machine state in a program's stamp; `None` if it has none.
#[must_use]
pub fn stamped_state(bytes: &[u8]) -> Option<String> {
    stamped(bytes, "state=")
}

/// The hash of the part program in a program's stamp; `None` without a stamp.
#[must_use]
pub fn stamped_source(bytes: &[u8]) -> Option<String> {
    stamped(bytes, "source=")
}

/// `true` if the stamp of a program names the machine; `None` without a stamp.
#[must_use]
pub fn is_stamped_for(bytes: &[u8], machine: &str) -> Option<bool> {
    let line = line(bytes)?;
    let named = line.split_once("machine=")?.1;
    let named = named.split_once(" model=").map_or(named, |(name, _)| name);
    // Some controls know only a few signs.
    let plain = |name: &str| name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_lowercase();
    Some(plain(named) == plain(machine))
}

/// The promise in a program's stamp; `None` without a stamp or promise.
#[must_use]
pub fn stamped_promise(bytes: &[u8]) -> Option<Promise> {
    promise_of(&line(bytes)?)
}

fn stamped(bytes: &[u8], key: &str) -> Option<String> {
    let line = line(bytes)?;
    let (_, rest) = line.split_once(key)?;
    Some(rest.chars().take_while(char::is_ascii_alphanumeric).collect())
}

/// The line of the stamp, in lower case.
fn line(bytes: &[u8]) -> Option<String> {
    if !is_stamped(bytes) {
        return None;
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD_BYTES)]).to_ascii_lowercase();
    head.lines().find(|line| line.contains(EPHEMERAL)).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamp() -> Stamp {
        Stamp {
            machine: "mill".into(),
            model: "0123456789ab".into(),
            state: None,
            zeros: None,
            source: "ba9876543210".into(),
            promise: Promise::default(),
            is_demo: false,
        }
    }

    #[test]
    fn a_stamp_says_all_and_is_found() {
        let text = stamp().text();
        let version = env!("CARGO_PKG_VERSION");
        let head =
            format!("ncfix {version} machine=\"mill\" model=0123456789ab source=ba9876543210 tolerance=0.001 check=");
        assert!(text.starts_with(&head) && text.ends_with(" ephemeral: for this machine only"), "{text}");
        for program in [
            format!("; {text}\nG0 X0\n"),
            format!("%_N_A_MPF\r\n;$PATH=/_N_MPF_DIR\r\n;{text}\r\nG0"),
            format!("%\nO1000\nN10 ({text})\n"),
            format!("; {}", Stamp { is_demo: true, ..stamp() }.text()),
            format!("%\nO1000 (PLATE)\n({})\n", stamp().capital_text()),
            format!("%PM\nN9001 (PLATE)\nN1 ({})\n", Stamp { is_demo: true, ..stamp() }.capital_text()),
        ] {
            assert!(is_stamped(program.as_bytes()), "{program}");
        }
    }

    #[test]
    fn a_state_is_in_the_stamp() {
        let warm = Stamp { state: Some("00ff00ff00ff".into()), ..stamp() };
        for text in [warm.text(), warm.capital_text()] {
            let program = format!("; {text}\nG0 X0\n");
            assert!(is_stamped(program.as_bytes()));
            assert_eq!(stamped_model(program.as_bytes()).as_deref(), Some("0123456789ab"));
            assert_eq!(stamped_state(program.as_bytes()).as_deref(), Some("00ff00ff00ff"));
        }
        assert_eq!(stamped_state(format!("; {}\n", stamp().text()).as_bytes()), None);
    }

    #[test]
    fn a_stamp_that_was_changed_is_known_by_its_sum() {
        for text in [stamp().text(), stamp().capital_text()] {
            let changed = |from: &str, to: &str| {
                let text = text.replace(from, to);
                is_stamp_changed(format!("%\nN10 ({text})\nG0 X0\n").as_bytes())
            };
            assert_eq!(changed("%", "%"), Some(false), "{text}");
            assert_eq!(changed("0.001", "0.1"), Some(true));
            assert_eq!(changed("BA9", "ba9"), Some(false));
            assert_eq!(changed("=0.001", "=0.001 made=step"), Some(true));
        }
        let old = b"; ncfix 0.1.0 machine=\"m\" model=0 source=1 ephemeral: for this machine only\n";
        assert_eq!(is_stamp_changed(old), None);
    }

    #[test]
    fn a_promise_is_in_the_stamp() {
        let promise = Promise {
            tolerance_mm: 2.5e-4,
            hole_tolerance_mm: 5e-4,
            increment_mm: Some(1e-5),
            is_stepped: true,
            limits_feed: true,
            ..Promise::default()
        };
        let stamp = Stamp { promise, ..stamp() };
        for text in [stamp.text(), stamp.capital_text()] {
            assert_eq!(stamped_promise(format!("({text})\nG0 X0\n").as_bytes()), Some(promise), "{text}");
        }
        // A stamp of an earlier version has no promise, and an invalid value is not a promise.
        for bad in ["", "tolerance=-1", "tolerance=nan", "tolerance=1e9", "tolerance=x"] {
            let text = stamp.text().replace(&promise_text(&promise), bad);
            assert_eq!(stamped_promise(format!("; {text}\n").as_bytes()), None, "{text}");
            assert_eq!(stamped_source(format!("; {text}\n").as_bytes()).as_deref(), Some("ba9876543210"));
        }
    }

    #[test]
    fn other_programs_carry_none() {
        let late = format!("{}; {}\n", "G1 X1\n".repeat(1000), stamp().text());
        for program in ["", "; ncfix is a program\nG0 X0", "G0 X0", "; for ncfix 0.1 machine=", late.as_str()] {
            assert!(!is_stamped(program.as_bytes()), "{program}");
        }
    }

    #[test]
    fn a_strange_name_does_not_end_the_comment() {
        let odd = Stamp { machine: "a\"b(c)\nd;e µ".into(), ..stamp() };
        assert!(odd.text().contains("machine=\"a_b_c__d_e _\""), "{}", odd.text());
        assert!(is_stamped(format!("({})", odd.text()).as_bytes()));
    }
}
