//! The gathered words of one block: a G code per group, a value per letter, M codes.
//!
//! Values are taken with [`Gathered::raw`], which marks them as used. Unused words at the end of a block belong to no code and are reported.

use std::cell::Cell;

use super::codes::{GROUPS, Group};
use super::data_origin::DataOrigin;
use ncfix_base::geometry::{Axis, AxisSet};
use ncfix_base::source::Span;
use ncfix_dialect::CodeEntry;

/// Letters A to Z, then those of [`slot_of`].
const SLOTS: usize = 32;
/// No code.
const NONE: u16 = u16::MAX;

/// Words of a block. The corner words `,C`, `,R` and `,A` are the letters `c`, `r` and `a`.
#[derive(Debug)]
pub(super) struct Gathered {
    codes: [u16; GROUPS],
    code_spans: [Span; GROUPS],
    values: [f64; SLOTS],
    spans: [Span; SLOTS],
    present: u32,
    /// Plain numbers without a decimal point.
    unpointed: u32,
    /// Plain numbers with one.
    pointed: u32,
    used: Cell<u32>,
    /// `true` if the mirror code of the block is that of a Haas, which mirrors about the workpiece zero.
    pub(super) mirrors_zero: bool,
    /// Span of `G53`.
    pub(super) machine_frame: Option<Span>,
    /// G codes that are passed through unchanged.
    pub(super) keep: Vec<&'static str>,
    /// A G code that is passed through with its words, in tenths, and its row.
    pub(super) passed: Option<(u16, &'static CodeEntry)>,
    /// M codes in the order of the block.
    pub(super) m_codes: Vec<(u32, Span)>,
    /// Letters whose value depends on data of the control.
    pub(super) origins: Vec<(u8, DataOrigin)>,
    /// Named axes.
    pub(super) axes: AxisSet,
    /// The whole block.
    pub(super) span: Span,
}

impl Default for Gathered {
    fn default() -> Self {
        Gathered {
            codes: [NONE; GROUPS],
            code_spans: [Span::default(); GROUPS],
            values: [0.0; SLOTS],
            spans: [Span::default(); SLOTS],
            present: 0,
            unpointed: 0,
            pointed: 0,
            used: Cell::new(0),
            mirrors_zero: false,
            machine_frame: None,
            keep: Vec::new(),
            passed: None,
            m_codes: Vec::new(),
            origins: Vec::new(),
            axes: AxisSet::EMPTY,
            span: Span::default(),
        }
    }
}

/// The slot of a letter.
fn slot_of(letter: u8) -> Option<usize> {
    Some(match letter {
        b'A'..=b'Z' => usize::from(letter - b'A'),
        b'@' => 26,
        b'^' => 27,
        b'$' => 28,
        b'c' => 29,
        b'r' => 30,
        b'a' => 31,
        _ => return None,
    })
}

/// The letter of a slot as written.
fn letter_of(slot: usize) -> String {
    match b"ABCDEFGHIJKLMNOPQRSTUVWXYZ@^$".get(slot) {
        Some(&letter) => char::from(letter).to_string(),
        None => [",C", ",R", ",A"].get(slot.wrapping_sub(29)).copied().unwrap_or_default().to_owned(),
    }
}

impl Gathered {
    /// Origin of the value of a letter in data of the control.
    pub(super) fn origin(&self, letter: u8) -> Option<DataOrigin> {
        self.origins.iter().find(|(known, _)| *known == letter).map(|&(_, origin)| origin)
    }

    /// Clears it for the next block; allocated storage is kept.
    pub(super) fn clear(&mut self, span: Span) {
        self.codes = [NONE; GROUPS];
        self.present = 0;
        self.unpointed = 0;
        self.pointed = 0;
        self.used = Cell::new(0);
        self.mirrors_zero = false;
        self.machine_frame = None;
        self.keep.clear();
        self.passed = None;
        self.m_codes.clear();
        self.origins.clear();
        self.axes = AxisSet::EMPTY;
        self.span = span;
    }

    /// Sets a G code, in tenths; returns the code of the group that it replaces.
    pub(super) fn set_code(&mut self, group: Group, tenths: u16, span: Span) -> Option<u16> {
        let index = group as usize;
        self.code_spans[index] = span;
        let old = std::mem::replace(&mut self.codes[index], tenths);
        (old != NONE).then_some(old)
    }

    /// The G code of a group, in tenths.
    pub(super) fn code(&self, group: Group) -> Option<u16> {
        let code = self.codes[group as usize];
        (code != NONE).then_some(code)
    }

    /// The span of the G code of a group; without one, that of the block.
    pub(super) fn code_span(&self, group: Group) -> Span {
        if self.code(group).is_some() { self.code_spans[group as usize] } else { self.span }
    }

    /// Sets a value. Returns `true` if the letter already had one.
    pub(super) fn set_value(&mut self, letter: u8, value: f64, has_point: bool, span: Span) -> bool {
        let Some(slot) = slot_of(letter) else { return false };
        let bit = 1_u32 << slot;
        let is_double = self.present & bit != 0;
        self.present |= bit;
        if has_point {
            self.unpointed &= !bit;
        } else {
            self.unpointed |= bit;
        }
        self.values[slot] = value;
        self.spans[slot] = span;
        if let Some(axis) = Axis::from_letter(letter).filter(|_| letter.is_ascii_uppercase()) {
            self.axes.insert(axis);
        }
        is_double
    }

    /// `true` if the block has a letter.
    pub(super) fn has(&self, letter: u8) -> bool {
        slot_of(letter).is_some_and(|slot| self.present & (1 << slot) != 0)
    }

    /// `true` if the block has one of these letters.
    pub(super) fn has_any(&self, letters: &[u8]) -> bool {
        letters.iter().any(|&letter| self.has(letter))
    }

    /// The value of a letter as written; marks it as used.
    pub(super) fn raw(&self, letter: u8) -> Option<f64> {
        let slot = slot_of(letter).filter(|slot| self.present & (1 << slot) != 0)?;
        self.used.set(self.used.get() | 1 << slot);
        Some(self.values[slot])
    }

    /// The value of a letter as written, without marking it as used.
    pub(super) fn raw_quietly(&self, letter: u8) -> Option<f64> {
        slot_of(letter).filter(|_| self.has(letter)).map(|slot| self.values[slot])
    }

    /// `true` if the value of a letter is a plain number without decimal point.
    pub(super) fn is_unpointed(&self, letter: u8) -> bool {
        slot_of(letter).is_some_and(|slot| self.unpointed & (1 << slot) != 0)
    }

    /// Records that the value of a letter is a plain number with a decimal point.
    pub(super) fn note_point(&mut self, letter: u8) {
        self.pointed |= slot_of(letter).map_or(0, |slot| 1 << slot);
    }

    /// `true` if the value of a letter is a plain number with a decimal point.
    pub(super) fn is_pointed(&self, letter: u8) -> bool {
        slot_of(letter).is_some_and(|slot| self.pointed & (1 << slot) != 0)
    }

    /// The span of a letter.
    pub(super) fn span_of(&self, letter: u8) -> Span {
        slot_of(letter).map_or(self.span, |slot| if self.has(letter) { self.spans[slot] } else { self.span })
    }

    /// Marks letters as used.
    pub(super) fn use_up(&self, letters: &[u8]) {
        for slot in letters.iter().filter_map(|&letter| slot_of(letter)) {
            self.used.set(self.used.get() | 1 << slot);
        }
    }

    /// An unused word: its letter as written, and its span.
    pub(super) fn unused(&self) -> Option<(String, Span)> {
        let left = self.present & !self.used.get();
        if left == 0 {
            return None;
        }
        let slot = left.trailing_zeros() as usize;
        Some((letter_of(slot), self.spans[slot]))
    }
}
