//! Saved states: M70, M71, M72, M73 of LinuxCNC.

use super::channel::Channel;
use super::channel::SavedState;
use super::codes::Group;
use super::modal::Modal;
use super::modes;
use super::offsets;
use super::setup;
use super::text;
use crate::exec::core::contour::Side;
use crate::exec::core::fault::{Fault, bad_value};
use crate::exec::core::motion_sink::MotionSink;
use ncfix_base::source::Span;
use ncfix_machine::snc::{FeedUnit, FrameWords, Kind, Word, WordValue};

/// M70, and with `returns` M73.
pub(super) fn save_state(modal: &Modal, saved: &mut [Option<Box<SavedState>>], returns: bool) {
    let state = Box::new(SavedState { modal: modal.clone(), returns });
    if let Some(place) = saved.last_mut() {
        *place = Some(state);
    }
}

/// M71
pub(super) fn drop_state(saved: &mut [Option<Box<SavedState>>]) {
    if let Some(place) = saved.last_mut() {
        *place = None;
    }
}

/// Begins a subroutine.
pub(super) fn enter_level(saved: &mut Vec<Option<Box<SavedState>>>) {
    saved.push(None);
}

/// Ends a subroutine.
pub(super) fn leave_level(channel: &mut Channel<'_>) {
    if channel.saved.len() < 2 {
        return;
    }
    if let Some(Some(state)) = channel.saved.pop()
        && state.returns
    {
        bring_back(channel, &state.modal);
    }
}

/// M72
pub(super) fn restore_state(channel: &mut Channel<'_>, span: Span) -> Result<(), Fault> {
    let state = channel.saved.last_mut().and_then(Option::take);
    let Some(state) = state else {
        return Err(bad_value(span, "M72 without a saved state", "save it with M70 or M73 in this program"));
    };
    bring_back(channel, &state.modal);
    if let Some(place) = channel.saved.last_mut() {
        *place = Some(state);
    }
    Ok(())
}

/// Activates the modal codes of a saved state and emits them.
fn bring_back(channel: &mut Channel<'_>, saved: &Modal) {
    let modal = &mut channel.modal;
    modal.modes.inch = saved.modes.inch;
    modal.modes.incremental = saved.modes.incremental;
    for group in [Group::ArcDistance, Group::Retract] {
        modal.codes.bring_back(&saved.codes, group);
    }
    let mut words: Vec<&'static str> = Vec::new();
    if modal.modes.plane != saved.modes.plane {
        modal.modes.plane = saved.modes.plane;
        words.push(match saved.modes.plane.number() {
            17 => "G17",
            18 => "G18",
            _ => "G19",
        });
    }
    if modal.modes.feed_unit != saved.modes.feed_unit {
        modal.modes.feed_unit = saved.modes.feed_unit;
        words.push(match saved.modes.feed_unit {
            FeedUnit::PerMinute => "G94",
            FeedUnit::PerTurn => "G95",
            FeedUnit::InverseTime => "G93",
        });
    }
    modal.modes.feed = saved.modes.feed;
    if let Some(code) = modal.codes.bring_back(&saved.codes, Group::SpindleMode) {
        words.push(if code == 960 { "G96" } else { "G97" });
    }
    let mut texts: Vec<String> = Vec::new();
    let is_other = modal.codes.bring_back(&saved.codes, Group::Control).is_some();
    if is_other || modal.path_tolerance_mm != saved.path_tolerance_mm {
        modal.path_tolerance_mm = saved.path_tolerance_mm;
        match saved.code(Group::Control) {
            610 => words.push("G61"),
            611 => words.push("G61.1"),
            _ => texts.push(modes::blending(channel.settings.machine, channel.language, saved.path_tolerance_mm)),
        }
    }
    // Compensation that was off is switched off again; LinuxCNC does not switch it on again without its tool.
    if saved.contour.side == Side::Off {
        channel.modal.contour.side = Side::Off;
    }
    let is_other = channel.modal.codes.bring_back(&saved.codes, Group::Length).is_some();
    if is_other || channel.modal.tool.length_mm != saved.tool.length_mm {
        channel.modal.h = saved.h;
        let is_off = saved.codes.is(Group::Length, 490);
        let mut text = if is_off { "G49".to_owned() } else { "G43.1".to_owned() };
        if !is_off {
            for (letter, value) in b"XYZ".iter().zip(saved.tool.length_mm.iter()) {
                text::append_length(channel.settings.machine, channel.language, &mut text, *letter, *value);
            }
        }
        texts.push(text);
        setup::put_length(channel, saved.tool.length_mm, saved.tool.assumed);
    }
    if channel.modal.system != saved.system {
        channel.modal.system = saved.system;
        let found = offsets::load_offset(channel, channel.outlet.origin.span);
        channel.outlet.warnings.extend(found.err());
        channel.push(Kind::Frame(FrameWords::Settable(offsets::words_of(channel.settings.machine, saved.system))));
    }
    for word in words {
        channel.push(Kind::Keep(word));
    }
    for text in texts {
        channel.push(Kind::Verbatim(text.into_bytes()));
    }
    bring_back_auxiliaries(channel, saved);
    setup::refresh_setup(channel);
}

fn bring_back_auxiliaries(channel: &mut Channel<'_>, saved: &Modal) {
    let mut aux: Vec<(u8, f64)> = Vec::new();
    if saved.modes.speed.is_some() && channel.modal.speed_word != saved.speed_word {
        aux.push((b'S', saved.speed_word));
    }
    if channel.modal.spindle != saved.spindle {
        aux.push((b'M', f64::from(saved.spindle)));
    }
    let word = |(letter, value)| Word { letter, extension: None, value: WordValue::Number(value) };
    if channel.modal.coolant != saved.coolant {
        let [mist, flood] = saved.coolant;
        for (code, is_wanted) in [(9.0, true), (7.0, mist), (8.0, flood)] {
            if is_wanted {
                on_its_own(&mut channel.outlet, Kind::Before(vec![word((b'M', code))]));
            }
        }
    }
    for (number, (was, is)) in (50..).zip(saved.overrides.into_iter().zip(channel.modal.overrides)) {
        if was != is {
            on_its_own(&mut channel.outlet, Kind::Verbatim(format!("M{number} P{}", u8::from(was)).into_bytes()));
        }
    }
    channel.modal.overrides = saved.overrides;
    channel.modal.modes.speed = saved.modes.speed;
    channel.modal.speed_word = saved.speed_word;
    channel.modal.spindle = saved.spindle;
    channel.modal.coolant = saved.coolant;
    channel.block.before.extend(aux.into_iter().map(word));
}

/// Emits an M code in a separate line: LinuxCNC accepts one code of a group and one P in a block.
fn on_its_own(outlet: &mut MotionSink<'_>, kind: Kind) {
    outlet.begin_line();
    outlet.push(kind);
    outlet.begin_line();
}
