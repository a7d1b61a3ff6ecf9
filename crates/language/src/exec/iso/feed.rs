//! Feed, speed, tool word, dwell, path control.

use super::auxiliary;
use super::channel::IsoAtHand;
use super::forbidden;
use super::measure;
use super::modal::Modal;
use super::modes;
use super::text;
use crate::exec::core::motion_sink::MotionSink;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use std::fmt::Write as _;

use super::channel::Channel;
use super::codes::Group;
use super::gathered::Gathered;
use super::measure::whole;
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_machine::snc::{Dwell, FeedUnit, Kind, Word, WordValue};

const METERS_PER_FOOT: f64 = 0.3048;
/// Largest F under G93 that a Fanuc reads, 1/min (B-62764EN, inverse time: 0.001 to 9999.999).
const MOST_INVERSE_OF_FANUC: f64 = 9999.999;
/// Letters whose values are lengths in codes that are passed through.
const LENGTHS: &[u8] = b"XYZIJKUVW";

/// G5 in tenths.
const HIGH_PRECISION: u16 = 50;

/// Rounds to six decimals to remove conversion noise.
fn to_places(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// G93, G94, G95 and G96, G97.
pub(super) fn feed_mode(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    if let Some(code) = gathered.code(Group::SpindleMode) {
        if code == 960 && channel.is_rs274() && !gathered.has(b'S') {
            let span = gathered.code_span(Group::SpindleMode);
            return Err(bad_value(span, "G96 without S", "write the cutting speed with it"));
        }
        channel.modal.codes.set(Group::SpindleMode, code);
        let name = if code == 960 { "G96" } else { "G97" };
        let letters: &[u8] = match (channel.is_rs274(), code) {
            (true, 960) => b"D$",
            (true, _) => b"$",
            (false, 960) => b"P",
            (false, _) => b"",
        };
        if gathered.has_any(letters) {
            let mut text = name.to_owned();
            for &letter in letters {
                if let Some(value) = gathered.raw(letter) {
                    // Writing to a string cannot fail.
                    let _ = write!(text, " {}{value}", char::from(letter));
                }
            }
            channel.push(Kind::Verbatim(text.into_bytes()));
        } else {
            channel.push(Kind::Keep(name));
        }
    }
    let Some(code) = gathered.code(Group::FeedMode) else { return Ok(()) };
    let (mode, word) = match code {
        930 => (FeedUnit::InverseTime, "G93"),
        950 => (FeedUnit::PerTurn, "G95"),
        _ => (FeedUnit::PerMinute, "G94"),
    };
    channel.modal.modes.select_feed_unit(mode);
    if channel.is_rs274() {
        // LinuxCNC resets F at each of these codes.
        channel.modal.modes.drop_feed();
    }
    channel.push(Kind::Keep(word));
    Ok(())
}

pub(super) fn feed(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let limits_inverse = !channel.is_rs274() && !channel.settings.machine.control.iso.is_haas();
    let modal = &mut channel.modal;
    let Some(value) = gathered.raw(b'F') else { return Ok(()) };
    if value.is_nan() || value < 0.0 {
        let message = "a feed must not be negative";
        return Err(bad_value(gathered.span_of(b'F'), message, "program F with a positive value"));
    }
    let is_inverse = modal.modes.feed_unit == FeedUnit::InverseTime;
    if is_inverse && limits_inverse && value > MOST_INVERSE_OF_FANUC {
        let message = format!("F{value} under G93: a Fanuc reads at most F{MOST_INVERSE_OF_FANUC}, a block of 6 ms");
        let help = "program a longer block or a lower F there; the control would stop with an alarm";
        return Err(bad_value(gathered.span_of(b'F'), message, help));
    }
    let scale = if is_inverse { 1.0 } else { modal.modes.scale() };
    modal.modes.set_feed(value * scale);
    Ok(())
}

pub(super) fn speed(
    machine: &Machine,
    modal: &mut Modal,
    block: &mut IsoAtHand,
    gathered: &Gathered,
) -> Result<(), Fault> {
    let Some(value) = gathered.raw(b'S') else { return Ok(()) };
    if value < 0.0 {
        let message = "a speed must not be negative";
        return Err(bad_value(gathered.span_of(b'S'), message, "program S with a positive value"));
    }
    // A cutting speed is in feet per minute if lengths are in inches.
    let in_meters = |inch: bool| if inch { METERS_PER_FOOT } else { 1.0 };
    let (own, output) = (modal.modes.inch, machine.control.output_inch == Some(true));
    let is_other = own != output && modal.has_cutting_speed();
    modal.modes.speed = Some(value);
    modal.speed_word = if is_other { to_places(value * in_meters(own) / in_meters(output)) } else { value };
    let value = WordValue::Number(modal.speed_word);
    block.before.push(Word { letter: b'S', extension: None, value });
    Ok(())
}

pub(super) fn tool_word(modal: &mut Modal, outlet: &mut MotionSink<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let Some(value) = gathered.raw(b'T') else { return Ok(()) };
    let span = gathered.span_of(b'T');
    let number = whole(value, span, "T").map_err(|found| {
        if value < 0.0 {
            return found;
        }
        let help = "write the number of the tool alone; T1.1 is the tool and the offset of a Fagor, whose programs ncfix does not read";
        bad_value(span, found.message.clone(), help)
    })?;
    modal.tool.selected = Some(number);
    outlet.push(Kind::Tool(WordValue::Number(f64::from(number))));
    Ok(())
}

/// P of a dwell or cycle, s: RS274/NGC counts seconds and a Fanuc milliseconds, for literals and computed values.
pub(super) fn dwell_of_p(
    machine: &Machine,
    language: Language,
    gathered: &Gathered,
    name: &str,
) -> Result<Option<f64>, Fault> {
    let Some(value) = gathered.raw(b'P') else { return Ok(None) };
    if language == Language::Rs274 {
        return Ok(Some(value));
    }
    if machine.control.iso.is_haas() {
        // Seconds with a point, milliseconds without.
        return if gathered.is_pointed(b'P') {
            Ok(Some(value))
        } else if gathered.is_unpointed(b'P') {
            Ok(Some(value / 1000.0))
        } else {
            let message = format!("P of {name} from a variable: seconds or milliseconds on a Haas");
            Err(fault(Code::TWO_MEANINGS, gathered.span_of(b'P'), message, "write the time as a number"))
        };
    }
    if gathered.is_pointed(b'P') {
        if let Some(unit_s) = machine.control.iso.pointed_dwell_s {
            return Ok(Some(value * unit_s));
        }
        let message = format!("P of {name} with a decimal point: seconds on a Haas, and a Fanuc stops with an alarm");
        let help = match name {
            "G4" => {
                "write milliseconds without a point, P1000, or seconds with X, X1.; or set control.dwell_with_point if the control accepts the point"
            }
            _ => {
                "write milliseconds without a point, P1000; or set control.dwell_with_point if the control accepts the point"
            }
        };
        return Err(fault(Code::TWO_MEANINGS, gathered.span_of(b'P'), message, help));
    }
    Ok(Some(value / 1000.0))
}

/// `G4 P` in seconds (RS274/NGC) or milliseconds, `G4 X` and `G4 U` in seconds.
pub(super) fn dwell(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    if gathered.code(Group::Action) != Some(40) {
        return Ok(());
    }
    let span = gathered.code_span(Group::Action);
    let letter = if channel.is_rs274() { None } else { [b'X', b'U'].into_iter().find(|&letter| gathered.has(letter)) };
    let seconds = match (gathered.raw(b'P'), letter) {
        (Some(_), None) => dwell_of_p(channel.settings.machine, channel.language, gathered, "G4")?.unwrap_or_default(),
        (None, Some(letter)) => {
            let value = gathered.raw(letter).unwrap_or_default();
            // Without a point the value counts milliseconds, in any length unit.
            let counts = gathered.is_unpointed(letter)
                && measure::length(channel, gathered, letter)? != Some(value * channel.modal.modes.scale());
            if counts { value / 1000.0 } else { value }
        }
        _ => return Err(bad_value(span, "G4 needs the time", "write for example G4 P1000 or, for RS274, G4 P1")),
    };
    if seconds < 0.0 {
        return Err(bad_value(span, "a dwell must not be negative", "check the time"));
    }
    if channel.modal.modes.feed_unit == FeedUnit::PerTurn
        && !channel.is_rs274()
        && channel.settings.machine.control.iso.dwell_turns
    {
        channel.push(Kind::Dwell(Dwell::Turns(seconds)));
    } else {
        channel.push(Kind::Dwell(Dwell::Seconds(seconds)));
    }
    Ok(())
}

/// G61, G61.1, G62, G63, G64.
pub(super) fn path_control(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let Some(code) = gathered.code(Group::Control) else { return Ok(()) };
    if channel.is_rs274() {
        forbidden::no_compensation(
            channel.language,
            &channel.modal,
            gathered.code_span(Group::Control),
            "another path control mode",
        )?;
    }
    modes::leave_exact_stops(channel, true);
    channel.modal.codes.set(Group::Control, code);
    channel.modal.path_tolerance_mm = [None; 2];
    if code == 640 && channel.is_rs274() && gathered.has_any(b"PQR") {
        let mut text = "G64".to_owned();
        let (p, q) = (measure::length(channel, gathered, b'P')?, measure::length(channel, gathered, b'Q')?);
        channel.modal.path_tolerance_mm = [p, q];
        let unit_mm = text::output_unit_mm(channel.settings.machine);
        let (p, q) = (p.map(|length| length / unit_mm), q.map(|length| length / unit_mm));
        for (letter, value) in [(b'P', p), (b'Q', q), (b'R', gathered.raw(b'R'))] {
            if let Some(value) = value {
                text::append(channel.language, &mut text, letter, value);
            }
        }
        channel.push(Kind::Verbatim(text.into_bytes()));
        return Ok(());
    }
    let word = match code {
        610 => "G61",
        611 => "G61.1",
        620 => "G62",
        630 => "G63",
        _ => "G64",
    };
    channel.push(Kind::Keep(word));
    Ok(())
}

/// Emits codes without motion, with their words. Returns `true` if they consumed the axis words.
pub(super) fn passed_on(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<bool, Fault> {
    for &word in &gathered.keep {
        channel.push(Kind::Keep(word));
    }
    let Some((tenths, entry)) = gathered.passed else { return Ok(false) };
    if tenths == HIGH_PRECISION {
        let switch = gathered.raw(b'P');
        if !matches!(switch, Some(0.0 | 10_000.0)) {
            let shown = switch.map_or_else(String::new, |value| format!(" P{value}"));
            let message = format!("G5{shown} runs data that is stored in the control");
            let help = "only G5 P10000 and G5 P0 switch high-precision contour control on and off; replace the call by its moves";
            return Err(fault(Code::NOT_SUPPORTED, gathered.span, message, help));
        }
    }
    // G22 alone, as in the first block of many programs, takes nothing from the motion.
    let takes_axes = entry.uses(b'X') && gathered.has_any(b"XYZABCUVWIJKR");
    if takes_axes && gathered.code(Group::Motion).is_some() {
        let message = format!("{} and a motion both use the axis words of the block", entry.name);
        let help = "give each of them its own block";
        return Err(fault(Code::MUST_STAND_ALONE, gathered.code_span(Group::Motion), message, help));
    }
    let mut text = entry.name.to_owned();
    for letter in entry.words.split(' ').filter_map(|word| word.bytes().next().filter(|_| word.len() == 1)) {
        let is_length = LENGTHS.contains(&letter);
        let is_other = channel.modal.modes.inch && channel.settings.machine.control.output_inch != Some(true);
        if is_other && !is_length && gathered.has(letter) && !gathered.is_unpointed(letter) {
            let message = format!(
                "{} with {} under G20: it may be in inches, and the output is metric",
                entry.name,
                char::from(letter)
            );
            let help = "program the code before G20 in mm, or leave it out";
            return Err(fault(Code::NOT_SUPPORTED, gathered.span_of(letter), message, help));
        }
        let value = if is_length { measure::length(channel, gathered, letter)? } else { gathered.raw(letter) };
        if let Some(value) = value {
            let value = if is_length { value / text::output_unit_mm(channel.settings.machine) } else { value };
            let is_count = gathered.is_unpointed(letter) && !is_length;
            auxiliary::append_plain(channel.language, &mut text, letter, value, is_count);
        }
    }
    channel.push(Kind::Verbatim(text.into_bytes()));
    Ok(takes_axes)
}
