//! Effect of a code on the state of a control, and whether that state can be restored by sending it again.
//!
//! Every row of a code table has a rule. A code without a row belongs to the machine builder; its effect is not known.

use ncfix_dialect::{CodeEffect, CodeEntry, CodeTable, Language};

/// Group of motion codes, in all code tables.
const MOTION: u8 = 1;
/// Own groups: for codes that are restored by their own name, for M codes, and for transformations.
const OWN: u8 = 250;
pub(super) const M: u8 = 251;
const TRANSFORM: u8 = 252;
/// Names of the group of override switches and of the gear group.
const OVERRIDES: &str = "overrides";
const GEAR: &str = "gear";

/// Codes that change the meaning of the positions in their block, or that move to places that only the control knows.
const ELSEWHERE: &[&str] = &["G53", "G153", "SUPA", "G27", "G28", "G29", "G30", "G31", "G74", "G75", "G63"];
/// Codes that act only in their block and change no state.
const PASSING: &[&str] = &["G4", "G9", "STOPRE", "M0", "M1", "M2", "M17", "M30"];
/// Motion codes whose words state where the axes are afterwards.
const STRAIGHT: &[&str] = &[
    "G0", "G1", "G2", "G3", "G5", "G5.1", "G5.2", "G5.3", "G33", "G34", "G35", "G80", "CIP", "CT", "ASPLINE",
    "BSPLINE", "CSPLINE", "POLY",
];

/// Key of codes that exclude each other: a group, and a name if a code excludes only itself.
pub(super) type Key = (u8, &'static str);

/// Meaning of axis words in a block with a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axes {
    /// Target positions of that block.
    Positions,
    /// Values of the code.
    Values,
    /// Values that cannot be sent again.
    Refused,
}

/// Effect of a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// Selects the motion. True if the axis words of its block state the end position.
    Motion(bool),
    /// No lasting effect.
    Passing,
    /// Moves the axes to a place that its words do not state.
    Elsewhere,
    /// A state that is restored by the code with the words of its block that it uses.
    State(Key, Axes),
    /// A state that is added to the existing state of its group.
    Added(Key, Axes),
    /// A state that cannot be restored. It ends with another code of its kind.
    InForce(Key),
    /// Spindle: on, off or oriented.
    Spindle,
    /// Switches a coolant on, or all of them off.
    Coolant,
    /// Changes to the selected tool.
    ToolChange,
    /// States the tool in the spindle by its word Q.
    ToolIs,
    /// Switches an output. It is not sent again, and it changes no position.
    Output,
    /// A state that cannot be restored and that nothing ends.
    Never,
}

/// Language, and tool change of a machine.
#[derive(Clone, Copy)]
pub struct Grammar {
    pub(super) codes: &'static CodeTable,
    pub(super) language: Language,
    pub(super) changes_on_t: bool,
}

/// Code of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockCode {
    pub(super) rule: Rule,
    pub(super) entry: Option<&'static CodeEntry>,
}

impl Grammar {
    /// Returns the grammar of a dialect. Set `changes_on_t` if the word T alone changes the tool.
    #[must_use]
    pub fn new(dialect: &ncfix_dialect::Dialect, changes_on_t: bool) -> Grammar {
        Grammar { codes: dialect.codes(), language: dialect.language, changes_on_t }
    }

    /// Returns the code of a word; `None` if it is an address with a value.
    pub(super) fn code(&self, word: &str) -> Option<BlockCode> {
        let number =
            |letter: char| word.strip_prefix(letter).filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
        let entry = match (number('G'), number('M')) {
            (Some(digits), _) => {
                let (whole, tenth) = digits.split_once('.').unwrap_or((digits, "0"));
                let tenths = whole.parse::<usize>().ok().zip(tenth.parse::<usize>().ok());
                tenths
                    .filter(|(_, tenth)| *tenth < 10)
                    .and_then(|(whole, tenth)| self.codes.g_tenths(whole.checked_mul(10)? + tenth))
                    // G505 and similar codes.
                    .or_else(|| self.codes.word(word))
            }
            (_, Some(digits)) => digits.parse().ok().and_then(|number| self.codes.m(number)),
            _ => self.codes.word(word),
        };
        if let Some(entry) = entry {
            return Some(BlockCode { rule: self.rule(entry), entry: Some(entry) });
        }
        let is_code = number('G').is_some() || number('M').is_some();
        is_code.then(|| BlockCode { rule: self.without_row(word), entry: None })
    }

    /// Rule of a code without a row. M codes belong to the machine builder, except those that a Sinumerik has without a table.
    fn without_row(&self, word: &str) -> Rule {
        let number = word.get(1..).and_then(|digits| digits.parse::<u32>().ok());
        if self.language != Language::Sinumerik {
            return Rule::Never;
        }
        match (word.as_bytes().first(), number) {
            (Some(b'M'), Some(0 | 1 | 2 | 17 | 30)) => Rule::Passing,
            (Some(b'M'), Some(3..=5)) => Rule::Spindle,
            (Some(b'M'), Some(6)) => Rule::ToolChange,
            (Some(b'M'), Some(7..=9)) => Rule::Coolant,
            (Some(b'M'), Some(40..=45)) => Rule::State((M, GEAR), Axes::Refused),
            // Settable zero offsets.
            (Some(b'G'), Some(505..=599)) => match self.codes.word("G54") {
                Some(entry) => Rule::State((entry.group, ""), Axes::Refused),
                None => Rule::Never,
            },
            _ => Rule::Never,
        }
    }

    /// Returns the rule of a row.
    pub(super) fn rule(&self, entry: &'static CodeEntry) -> Rule {
        let name = entry.name;
        if name.starts_with('M') && name[1..].starts_with(|digit: char| digit.is_ascii_digit()) {
            return self.rule_of_m(entry);
        }
        let key = (entry.group, "");
        if PASSING.contains(&name) || entry.effect == CodeEffect::Display {
            return Rule::Passing;
        }
        let is_elsewhere = ELSEWHERE.contains(&name)
            && !(self.language == Language::Grundig && ["G53", "G27", "G28", "G29", "G63", "G31"].contains(&name))
            && !(self.language == Language::Fanuc && ["G74", "G75", "G63"].contains(&name))
            && !(self.language == Language::Rs274 && ["G74", "G75", "G63"].contains(&name));
        if is_elsewhere {
            return Rule::Elsewhere;
        }
        if entry.group == MOTION {
            // Probing, threads with the spindle and cycles end where their words do not state it.
            let says_where = STRAIGHT.contains(&name);
            return if entry.effect == CodeEffect::Refuse { Rule::InForce(key) } else { Rule::Motion(says_where) };
        }
        match (self.language, name) {
            (Language::Sinumerik, "TRAORI") => return Rule::InForce((TRANSFORM, "")),
            (Language::Sinumerik, "TRAFOOF") => return Rule::State((TRANSFORM, ""), Axes::Refused),
            (Language::Fanuc, "M29") => return Rule::InForce((9, "")),
            _ => {}
        }
        if entry.effect == CodeEffect::Refuse {
            return if entry.group > 0 { Rule::InForce(key) } else { Rule::Never };
        }
        if entry.group == 0 {
            // Fanuc: look-ahead and smoothing, which stay active until they are switched off one by one.
            let is_mode = entry.effect == CodeEffect::Keep && entry.has_words();
            return if is_mode { Rule::State((OWN, name), Axes::Values) } else { Rule::Never };
        }
        let plain = Rule::State(key, Axes::Refused);
        match (self.language, name) {
            // In incremental mode the words do not state where the axes are.
            (_, "G91") => Rule::InForce(key),
            (Language::Rs274, "G43") => plain,
            (Language::Rs274, "G43.1") => Rule::State(key, Axes::Values),
            (Language::Rs274, "G43.2") => Rule::Added(key, Axes::Values),
            (Language::Fanuc, "G43" | "G44") => Rule::State(key, Axes::Positions),
            (Language::Fanuc, "G40") => plain,
            (Language::Fanuc, "G54.1") => plain,
            (Language::Fanuc, "G22" | "G50.1") => Rule::State(key, Axes::Values),
            // The next positions are a radius and an angle.
            (Language::Fanuc, "G16") => Rule::InForce(key),
            (Language::Grundig, "G54" | "G52" | "G28") => plain,
            (Language::Grundig, "G64") => Rule::InForce(key),
            // A contour cannot be entered without its approach.
            (Language::Grundig, "G41" | "G42" | "G43" | "G44") | (Language::Sinumerik, "G41" | "G42") => {
                Rule::InForce(key)
            }
            (Language::Sinumerik, _) if entry.group <= 3 => Rule::Never,
            (Language::Sinumerik, _) => plain,
            // The words of a cycle, a scale or a rotated plane cannot be restored away from their place.
            _ if !entry.has_words() || entry.effect == CodeEffect::Keep => plain,
            _ => Rule::InForce(key),
        }
    }

    fn rule_of_m(&self, entry: &'static CodeEntry) -> Rule {
        let name = entry.name;
        match (self.language, name) {
            _ if PASSING.contains(&name) => Rule::Passing,
            (_, "M3" | "M4" | "M5") | (Language::Grundig, "M13" | "M14") => Rule::Spindle,
            // The oriented position is lost when the spindle turns.
            (_, "M19") => Rule::Spindle,
            (_, "M7" | "M8" | "M9") => Rule::Coolant,
            (_, "M6") | (Language::Grundig, "M66" | "M67") => Rule::ToolChange,
            (Language::Rs274, "M61") => Rule::ToolIs,
            (Language::Rs274 | Language::Fanuc, "M48" | "M49") => Rule::State((M, OVERRIDES), Axes::Refused),
            (Language::Rs274, "M50" | "M51" | "M52" | "M53") => Rule::State((M, name), Axes::Refused),
            (Language::Grundig, "M41..M44") => Rule::State((M, GEAR), Axes::Refused),
            (Language::Fanuc, "M29") => Rule::InForce((9, "")),
            (Language::Rs274, "M62" | "M63" | "M64" | "M65" | "M66" | "M67" | "M68") => Rule::Output,
            // Clamps, pallets, probes, heads: they must not be switched again away from their place.
            _ => Rule::Never,
        }
    }

    /// Returns the group of a code of this name.
    pub(super) fn group(&self, name: &str) -> Option<u8> {
        self.codes.word(name).map(|entry| entry.group).filter(|group| *group > 0)
    }

    /// True if a motion code uses this address with an index or a name. Its effect ends with its block.
    pub(super) fn belongs_to_motion(&self, name: &str) -> bool {
        self.codes.rows().iter().filter(|row| row.group <= 2).any(|row| row.words.split(' ').any(|word| word == name))
    }
}
