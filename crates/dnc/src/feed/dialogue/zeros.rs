//! Compares the zero offsets of a control with those for which the program was corrected.
//!
//! The machine position is the program position plus the selected offset, the shift of G92 and the tool length. Controls state them in three ways
//! ([`ZeroSource`]):
//!
//! - Grbl answers `$#` (`[G54:0.000,0.000,0.000]` … `[G92:…]`, `[TLO:0.000]`) and `$G` (`[GC:G0 G54 …]`). While the job runs, its reports contain the sum
//!   now and then (`WCO`), and at once after a change.
//! - LinuxCNC prints its parameters, and states the sum without the tool length after every line.
//! - Marlin states the sum in force after a line that selects an offset.
//!
//! While the job runs, the sum may only change by a line of the program.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use ncfix_base::units::MM_PER_INCH;

use super::zero::{ExpectedZero, ZERO_LETTERS, ZeroValues, is_angle, name};

/// Permitted difference of a linear axis, mm. A value typed from a display is rounded to less. Where an error changes by 1 µm per mm, which is steep, the
/// correction changes by 0.1 µm over it.
const MOST_MM: f64 = 0.1;
/// Permitted difference of a rotary axis, degrees: less than 0.1 mm up to 570 mm from its axis line.
const MOST_DEG: f64 = 0.01;
/// Revolution, degrees: offsets of whole revolutions are equal.
const TURN_DEG: f64 = 360.0;
/// Place of the rotation about Z.
const ROTATION: usize = ZERO_LETTERS.len() - 1;
/// Code of G54 in tenths.
const G54: u32 = ExpectedZero::FIRST;
/// Number of questions to Grbl before the first line.
const QUESTIONS: u32 = 2;
/// G codes in tenths that change an offset by values that are not known here.
const CHANGING_G: &[u32] = &[100, 520, 920, 921, 922, 923];
/// G codes in tenths that change the tool length, and M codes of tool changes.
const LENGTHS: &[u32] = &[430, 431, 432];
const CHANGING_M: &[u32] = &[60, 610];
/// Ends of a program, which select G54.
const ENDS: &[u32] = &[20, 300];

/// Kind of statements about offsets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum ZeroSource {
    /// Answers to `$#`, and reports that may be older than the last line.
    #[default]
    Grbl,
    /// Parameters, and statements after each line.
    LinuxCnc,
    /// Statements after lines that select an offset.
    Marlin,
}

/// Zero offsets of the control.
#[derive(Debug, Default)]
pub(super) struct ZeroWatch {
    source: ZeroSource,
    expected: Option<ExpectedZero>,
    /// Letters of the axes in the order of the control; empty for the usual order.
    letters: Vec<u8>,
    answers: u32,
    /// Selectable offsets by code in tenths, the offset of G92, and the tool length.
    systems: BTreeMap<u32, ZeroValues>,
    shift: ZeroValues,
    length: ZeroValues,
    /// Offset in force before the first line, by its code.
    active: Option<u32>,
    /// Offset that the lines sent select.
    selected: Option<u32>,
    /// Offsets that a report may contain; empty if nothing is known.
    allowed: Vec<ZeroValues>,
    /// True from the first line on.
    has_begun: bool,
    /// True if a line has changed offsets by values that are not known here.
    is_over: bool,
}

/// Reads the code of an offset in tenths: `G54` is 540, `G59.1` is 591.
fn system(name: &str) -> Option<u32> {
    let value: f64 = name.strip_prefix('G')?.parse().ok()?;
    let tenths = (value * 10.0).round();
    (540.0..=593.0).contains(&tenths).then_some(tenths as u32)
}

/// Reads values with commas in the usual order; axes that are not stated are 0.
fn read(text: &str) -> Option<ZeroValues> {
    let mut out = ZeroValues::default();
    for (value, word) in out.iter_mut().zip(text.split(',')) {
        *value = word.trim().parse().ok()?;
    }
    Some(out)
}

fn sum(parts: [&ZeroValues; 3]) -> ZeroValues {
    std::array::from_fn(|slot| parts.iter().map(|part| part[slot]).sum())
}

/// True if a value agrees with another one. A value that is not a number differs.
fn is_equal(slot: usize, one: f64, other: f64) -> bool {
    let difference = (one - other).abs();
    if !is_angle(slot) {
        return difference <= MOST_MM;
    }
    let within = difference % TURN_DEG;
    within.min(TURN_DEG - within) <= MOST_DEG
}

/// Calls `take` with each G and M code of a line, in tenths.
pub(super) fn each_code(text: &[u8], take: &mut dyn FnMut(u8, u32)) {
    for (at, letter) in text.iter().enumerate() {
        let letter = letter.to_ascii_uppercase();
        if !matches!(letter, b'G' | b'M') {
            continue;
        }
        let rest = text.get(at + 1..).unwrap_or_default();
        let end = rest.iter().position(|byte| !(byte.is_ascii_digit() || *byte == b'.')).unwrap_or(rest.len());
        let value = std::str::from_utf8(rest.get(..end).unwrap_or_default()).ok().and_then(|text| text.parse().ok());
        if let Some(tenths) = value.map(|value: f64| (value * 10.0).round()).filter(|tenths| *tenths < 1e5) {
            take(letter, tenths as u32);
        }
    }
}

impl ZeroWatch {
    pub(super) fn new(source: ZeroSource) -> ZeroWatch {
        ZeroWatch { source, ..ZeroWatch::default() }
    }

    pub(super) fn expect(&mut self, zero: ExpectedZero) {
        self.expected = Some(zero);
    }

    /// True if the control is to be asked.
    pub(super) fn is_expected(&self) -> bool {
        self.expected.is_some()
    }

    /// Notes the axes of the control from `4:XYZA`.
    pub(super) fn has_axes(&mut self, text: &str) {
        if let Some(letters) = text.split(':').nth(1) {
            self.letters = letters.bytes().take(ZERO_LETTERS.len()).collect();
        }
    }

    /// Reads the values of a report in the order of the control.
    pub(super) fn values(&self, text: &str) -> Option<ZeroValues> {
        let listed = read(text)?;
        if self.letters.is_empty() {
            return Some(listed);
        }
        let mut out = ZeroValues::default();
        for (letter, value) in self.letters.iter().zip(listed) {
            if let Some(slot) = ZERO_LETTERS.iter().position(|known| known == letter) {
                out[slot] = value;
            }
        }
        Some(out)
    }

    /// Notes a line of the answers of Grbl: `[G54:…]`, `[G92:…]`, `[TLO:…]`, `[GC:…]`.
    pub(super) fn hear(&mut self, text: &str) {
        let Some((key, rest)) = text.trim_matches(['[', ']']).split_once(':') else { return };
        match key {
            "GC" => self.active = rest.split(' ').find_map(system).or(self.active),
            "G92" => self.shift = self.values(rest).unwrap_or_default(),
            // Grbl states one value, for Z.
            "TLO" if rest.contains(',') => self.length = self.values(rest).unwrap_or_default(),
            "TLO" => self.length[2] = rest.parse().unwrap_or_default(),
            _ => {
                if let Some((code, values)) = system(key).zip(self.values(rest)) {
                    self.systems.insert(code, values);
                }
            }
        }
    }

    /// Notes a selectable offset.
    pub(super) fn has_system(&mut self, code: u32, values: ZeroValues) {
        self.systems.insert(code, values);
    }

    /// Notes the shift of G92.
    pub(super) fn has_shift(&mut self, values: ZeroValues) {
        self.shift = values;
    }

    /// Notes the tool length in force, along Z, mm. It does not matter if the program states its own.
    pub(super) fn has_length(&mut self, length_mm: f64) {
        let is_stated = self.expected.as_ref().is_some_and(|expected| expected.states_length);
        self.length[2] = if is_stated { 0.0 } else { length_mm };
    }

    /// Notes the code of the offset in force.
    pub(super) fn has_active(&mut self, code: u32) {
        self.active = Some(code);
    }

    /// Notes an answer to a question. Returns true if it was the last one.
    pub(super) fn answered(&mut self) -> bool {
        self.answers += 1;
        self.answers >= QUESTIONS
    }

    /// True if the program names an offset.
    pub(super) fn names_any(&self) -> bool {
        self.expected.as_ref().is_some_and(|expected| !expected.named.is_empty())
    }

    /// True if the control has stated every offset that the program uses.
    pub(super) fn is_complete(&self) -> bool {
        self.used().iter().all(|code| self.systems.contains_key(code))
    }

    /// Describes what a person compares if the control states nothing.
    pub(super) fn by_hand(&self) -> String {
        self.expected.as_ref().map_or(String::new(), ExpectedZero::by_hand)
    }

    /// True if the selected offset turns the program about Z, so that program positions are not differences of machine positions.
    pub(super) fn is_turned(&self) -> bool {
        let selected = self.selected.or(self.active).unwrap_or(G54);
        self.systems.get(&selected).is_some_and(|values| values[ROTATION] != 0.0)
    }

    /// Returns the whole offset with this code, if the control has stated it.
    fn whole(&self, code: u32) -> Option<ZeroValues> {
        Some(sum([self.systems.get(&code)?, &self.shift, &self.length]))
    }

    /// Codes of the offsets that the program uses, as far as its text shows.
    fn used(&self) -> Vec<u32> {
        self.expected.as_ref().map_or(vec![G54], ExpectedZero::used)
    }

    fn shown(&self, values: &ZeroValues) -> String {
        self.expected.clone().unwrap_or_default().shown(values, false)
    }

    /// True if all axes of the machine agree.
    fn agree(&self, one: &ZeroValues, other: &ZeroValues) -> bool {
        let expected = self.expected.clone().unwrap_or_default();
        (0..one.len()).filter(|&slot| expected.has(slot)).all(|slot| is_equal(slot, one[slot], other[slot]))
    }

    /// True if an offset of the control is the expected one; the control may report inches.
    fn is_near(&self, has: &ZeroValues, wants: &ZeroValues) -> bool {
        let in_mm = std::array::from_fn(|slot| if is_angle(slot) { has[slot] } else { has[slot] * MM_PER_INCH });
        self.agree(has, wants) || self.agree(&in_mm, wants)
    }

    /// Compares before the first line. Returns why no line may be sent; `None` if all is well, or the control states nothing.
    pub(super) fn begin(&mut self) -> Option<String> {
        let has_none = self.expected.as_ref().is_none_or(|expected| expected.named.is_empty());
        if let Some(active) = self.active.filter(|active| *active != G54 && has_none) {
            let name = name(active);
            return Some(format!(
                "the control has {name} in force, and the program states no zero offset, so it is corrected for G54: write {name} into the program, or select G54 at the control"
            ));
        }
        if let Some(why) = self.used().into_iter().find_map(|code| self.check(code)) {
            return Some(why);
        }
        self.has_begun = true;
        self.selected = self.active;
        self.allowed.extend(self.active.or(Some(G54)).and_then(|code| self.whole(code)));
        None
    }

    /// Compares an offset with that of the correction, and with that of the beginning of an interrupted job.
    fn check(&self, code: u32) -> Option<String> {
        let (expected, has) = (self.expected.as_ref()?, self.whole(code)?);
        if let Some(wants) = expected.of(code).filter(|wants| !self.is_near(&has, wants)) {
            return Some(self.differs(code, &has, &wants));
        }
        let earlier = expected.earlier.as_deref().filter(|_| !expected.is_changed_by_program)?;
        let had = earlier_of(earlier, code).filter(|had| !self.agree(&has, had))?;
        Some(format!(
            "{} of the control has moved since the job began: it is {}, and was {}; a part of the program would be machined at another place: set it back, or feed the program from its beginning",
            name(code),
            self.shown(&has),
            self.shown(&had)
        ))
    }

    /// Returns the sentence about an offset of the control that is not that of the correction, with both ways out.
    fn differs(&self, code: u32, has: &ZeroValues, wants: &ZeroValues) -> String {
        let (name, zero) = (name(code), ZeroValues::default());
        let parts = match (self.shift != zero, self.length != zero) {
            (false, false) => "",
            (true, false) => " with its G92",
            (false, true) => " with its tool length",
            (true, true) => " with its G92 and its tool length",
        };
        // G10 L2 has numbers for G54 to G59 and G59.1 to G59.3: P1 to P9.
        let place = if code > 590 { code - 584 } else { code.saturating_sub(530) / 10 };
        let expected = self.expected.clone().unwrap_or_default();
        let is_turned = has[ROTATION] != wants[ROTATION];
        let command = format!("G21 G10 L2 P{place} {}", expected.shown(wants, is_turned));
        let saved = match self.source {
            ZeroSource::Grbl => ", or save its answer to $# in a file and give that with --setup",
            ZeroSource::LinuxCnc => ", or give its variable file with --setup",
            ZeroSource::Marlin => "",
        };
        // Without a shift or a length that nobody wanted it may be right.
        let less = |part: &ZeroValues| self.is_near(&std::array::from_fn(|slot| has[slot] - part[slot]), wants);
        let back = match self.source {
            ZeroSource::Marlin => format!("set {name} at the control with {name} and G92"),
            _ if self.length != zero && less(&self.length) => "send G49 to the control".to_owned(),
            _ if self.shift != zero && less(&self.shift) => "send G92.1 to the control".to_owned(),
            ZeroSource::Grbl | ZeroSource::LinuxCnc => format!("send {command} to the control"),
        };
        format!(
            "{name} of the control{parts} is {}, and the program is corrected for {}: at another place of the machine the correction is another one. To take the value of the control, write {} under [zero_offset.{name}] in the machine file{saved}. To take that of the file, {back}",
            self.shown(has),
            self.shown(wants),
            keys(&expected, has, is_turned),
        )
    }

    /// Returns what the control has stated of the offsets of the program, for the journal.
    pub(super) fn stated(&self) -> Option<String> {
        let mut out = String::new();
        for code in self.used() {
            let Some(values) = self.whole(code) else { continue };
            let last = values.iter().rposition(|value| *value != 0.0).unwrap_or(0).max(2);
            let blank = if out.is_empty() { "" } else { " " };
            let _ = write!(out, "{blank}{} ", name(code));
            for (slot, value) in values.iter().enumerate().take(last + 1) {
                let _ = write!(out, "{}{value:.3}", if slot > 0 { "," } else { "" });
            }
        }
        (!out.is_empty()).then_some(out)
    }

    /// Notes a line that is sent: it may select another offset, or change one. Returns true if it selects one.
    pub(super) fn sent(&mut self, text: &[u8]) -> bool {
        if self.is_over || !text.iter().any(|byte| byte.is_ascii_alphabetic()) {
            return false;
        }
        let mut selected = None;
        let mut is_over = false;
        let has_length = self.source == ZeroSource::Grbl;
        each_code(text, &mut |letter, code| match letter {
            b'G' if (540..=593).contains(&code) => selected = Some(code),
            // Without a length nothing changes.
            b'G' if code == 490 => is_over |= has_length && self.length != ZeroValues::default(),
            b'G' => is_over |= CHANGING_G.contains(&code) || has_length && LENGTHS.contains(&code),
            _ if ENDS.contains(&code) => selected = Some(G54),
            _ => is_over |= has_length && CHANGING_M.contains(&code),
        });
        self.is_over |= is_over;
        let Some(code) = selected else { return false };
        self.selected = Some(code);
        match self.whole(code) {
            _ if !has_length => {}
            Some(whole) if self.allowed.contains(&whole) => {}
            Some(whole) => self.allowed.push(whole),
            None => self.is_over |= self.active != Some(code) && code != G54,
        }
        !self.is_over
    }

    /// Compares a report of Grbl after [`Self::begin`]. Returns why the job must end.
    pub(super) fn see(&mut self, offset: Option<&str>) -> Option<String> {
        let now = offset.and_then(|text| self.values(text)).filter(|_| self.has_begun && !self.is_over)?;
        if self.allowed.is_empty() {
            // A control that does not answer the question: its first report counts.
            self.allowed.push(now);
            let wants = self.expected.as_ref().and_then(|expected| expected.of(G54))?;
            return (!self.is_near(&now, &wants)).then(|| self.differs(G54, &now, &wants));
        }
        if self.allowed.iter().any(|allowed| self.agree(allowed, &now)) {
            return None;
        }
        Some(self.changed(&now, &self.allowed.last().copied().unwrap_or_default()))
    }

    fn changed(&self, now: &ZeroValues, was: &ZeroValues) -> String {
        format!(
            "the zero offset was changed at the control while the job runs: it is {}, and was {}",
            self.shown(now),
            self.shown(was)
        )
    }

    /// Compares the sum of the selected offset and the shift of G92 that a control states when it has executed the lines sent. Axes that it does not state are
    /// not compared. Returns why the job must end.
    pub(super) fn see_in_force(&mut self, stated: &[(u8, f64)]) -> Option<String> {
        let expected = self.expected.as_ref().filter(|_| !self.is_over)?;
        let code = self.selected.or(self.active).unwrap_or(G54);
        let known = self.systems.get(&code).map(|system| sum([system, &self.shift, &ZeroValues::default()]));
        let mut now = known.or_else(|| expected.of(code)).unwrap_or_default();
        for &(letter, value) in stated {
            if let Some(slot) = ZERO_LETTERS.iter().position(|known| *known == letter) {
                now[slot] = value;
            }
        }
        if let Some(known) = known {
            return (!self.agree(&known, &now)).then(|| self.changed(&now, &known));
        }
        // The first statement about this offset.
        self.systems.insert(code, now);
        self.check(code)
    }
}

/// Returns the keys of the machine file for an offset: `X_mm = 1.000, A_deg = 15.000`.
fn keys(expected: &ExpectedZero, values: &ZeroValues, is_turned: bool) -> String {
    let mut out: Vec<String> = Vec::new();
    for (slot, (&letter, value)) in ZERO_LETTERS.iter().zip(values).enumerate() {
        match letter {
            b'R' if is_turned => out.push(format!("rotation_deg = [0, 0, {value:.3}]")),
            b'R' => {}
            _ if expected.has(slot) => {
                let unit = if is_angle(slot) { "deg" } else { "mm" };
                out.push(format!("{}_{unit} = {value:.3}", char::from(letter)));
            }
            _ => {}
        }
    }
    out.join(", ")
}

/// Returns an offset from a journal: `G54 100.000,100.000,-60.000 G55 …`.
fn earlier_of(text: &str, code: u32) -> Option<ZeroValues> {
    let mut words = text.split(' ');
    while let (Some(key), Some(values)) = (words.next(), words.next()) {
        if system(key) == Some(code) {
            return read(values);
        }
    }
    None
}

#[cfg(test)]
mod tests;
