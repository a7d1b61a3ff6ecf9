//! Saved states: M70, M71, M72, M73 of LinuxCNC.

use super::channel::Channel;
use super::modal::Modal;
use crate::exec::core::contour::Side;
use crate::exec::core::fault::{Fault, bad_value};
use ncfix_base::source::Span;
use ncfix_machine::snc::{FeedUnit, FrameWords, Kind, Word, WordValue};

/// What M70 or M73 saved at a program level.
#[derive(Debug)]
pub(super) struct SavedState {
    modal: Modal,
    /// M73: it comes back by itself when the level ends.
    pub(super) returns: bool,
}

impl Channel<'_> {
    /// M70, and with `returns` M73.
    pub(super) fn save_state(&mut self, returns: bool) {
        let state = Box::new(SavedState { modal: self.modal.clone(), returns });
        if let Some(place) = self.saved.last_mut() {
            *place = Some(state);
        }
    }

    /// M71
    pub(super) fn drop_state(&mut self) {
        if let Some(place) = self.saved.last_mut() {
            *place = None;
        }
    }

    /// A subroutine begins.
    pub(super) fn enter_level(&mut self) {
        self.saved.push(None);
    }

    /// A subroutine ends.
    pub(super) fn leave_level(&mut self) {
        if self.saved.len() < 2 {
            return;
        }
        if let Some(Some(state)) = self.saved.pop()
            && state.returns
        {
            self.bring_back(&state.modal);
        }
    }

    /// M72
    pub(super) fn restore_state(&mut self, span: Span) -> Result<(), Fault> {
        let state = self.saved.last_mut().and_then(Option::take);
        let Some(state) = state else {
            return Err(bad_value(span, "M72, and no state was saved", "save it with M70 or M73 in this program"));
        };
        self.bring_back(&state.modal);
        if let Some(place) = self.saved.last_mut() {
            *place = Some(state);
        }
        Ok(())
    }

    /// Puts the modal codes of a saved state in force and says so to the output.
    fn bring_back(&mut self, saved: &Modal) {
        let modal = &mut self.modal;
        modal.inch = saved.inch;
        modal.incremental = saved.incremental;
        modal.arc_absolute = saved.arc_absolute;
        modal.to_r_plane = saved.to_r_plane;
        let mut words: Vec<&'static str> = Vec::new();
        if modal.plane != saved.plane {
            modal.plane = saved.plane;
            words.push(match saved.plane.number() {
                17 => "G17",
                18 => "G18",
                _ => "G19",
            });
        }
        if modal.feed_mode != saved.feed_mode {
            modal.feed_mode = saved.feed_mode;
            words.push(match saved.feed_mode {
                FeedUnit::PerMinute => "G94",
                FeedUnit::PerTurn => "G95",
                FeedUnit::InverseTime => "G93",
            });
        }
        modal.feed = saved.feed;
        if modal.spindle_mode != saved.spindle_mode {
            modal.spindle_mode = saved.spindle_mode;
            words.push(if saved.spindle_mode == 960 { "G96" } else { "G97" });
        }
        let mut texts: Vec<String> = Vec::new();
        if modal.path_control != saved.path_control {
            modal.path_control = saved.path_control;
            match saved.path_control {
                (610, ..) => words.push("G61"),
                (611, ..) => words.push("G61.1"),
                (_, p, q) => {
                    let mut text = "G64".to_owned();
                    for (letter, value) in [(b'P', p), (b'Q', q)] {
                        if let Some(value) = value {
                            self.append_length(&mut text, letter, value);
                        }
                    }
                    texts.push(text);
                }
            }
        }
        // Compensation that was off comes back off; that it was on is not brought back by LinuxCNC without its tool either.
        if saved.contour.side == Side::Off {
            self.modal.contour.side = Side::Off;
        }
        if self.modal.length_code != saved.length_code || self.modal.length_mm != saved.length_mm {
            self.modal.length_code = saved.length_code;
            self.modal.h = saved.h;
            let mut text = if saved.length_code == 490 { "G49".to_owned() } else { "G43.1".to_owned() };
            if saved.length_code != 490 {
                for (letter, value) in b"XYZ".iter().zip(saved.length_mm.iter()) {
                    self.append_length(&mut text, *letter, *value);
                }
            }
            texts.push(text);
            self.put_length(saved.length_mm, saved.length_assumed);
        }
        if self.modal.system != saved.system {
            self.modal.system = saved.system;
            let found = self.load_offset(self.outlet.origin.span);
            self.outlet.warnings.extend(found.err());
            self.push(Kind::Frame(FrameWords::Settable(saved.system.words())));
        }
        for word in words {
            self.push(Kind::Keep(word));
        }
        for text in texts {
            self.push(Kind::Verbatim(text.into_bytes()));
        }
        self.bring_back_auxiliaries(saved);
        self.refresh_setup();
    }

    fn bring_back_auxiliaries(&mut self, saved: &Modal) {
        let mut aux: Vec<(u8, f64)> = Vec::new();
        if saved.speed.is_some() && self.modal.speed_word != saved.speed_word {
            aux.push((b'S', saved.speed_word));
        }
        if self.modal.spindle != saved.spindle {
            aux.push((b'M', f64::from(saved.spindle)));
        }
        let word = |(letter, value)| Word { letter, extension: None, value: WordValue::Number(value) };
        if self.modal.coolant != saved.coolant {
            let [mist, flood] = saved.coolant;
            for (code, is_wanted) in [(9.0, true), (7.0, mist), (8.0, flood)] {
                if is_wanted {
                    self.on_its_own(Kind::Before(vec![word((b'M', code))]));
                }
            }
        }
        for (number, (was, is)) in (50..).zip(saved.overrides.into_iter().zip(self.modal.overrides)) {
            if was != is {
                self.on_its_own(Kind::Verbatim(format!("M{number} P{}", u8::from(was)).into_bytes()));
            }
        }
        self.modal.overrides = saved.overrides;
        self.modal.speed = saved.speed;
        self.modal.speed_word = saved.speed_word;
        self.modal.spindle = saved.spindle;
        self.modal.coolant = saved.coolant;
        self.before.extend(aux.into_iter().map(word));
    }

    /// Puts an M code on a line of its own: LinuxCNC takes one code of a group and one P in a block.
    fn on_its_own(&mut self, kind: Kind) {
        self.outlet.begin_line();
        self.push(kind);
        self.outlet.begin_line();
    }
}
