//! Executes the words of one block in a fixed order.

use super::auxiliary;
use super::channel::Channel;
use super::codes::{G80, Group};
use super::compensation;
use super::cycle;
use super::data;
use super::direction;
use super::feed;
use super::forbidden;
use super::gathered::Gathered;
use super::haas;
use super::home;
use super::kept_cycle;
use super::length;
use super::modal::Modal;
use super::modes;
use super::motion;
use super::offsets;
use super::passed_axis;
use super::reference;
use super::special;
use super::target;
use super::transform;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::motion_sink::MotionSink;
use ncfix_base::diagnostic::Code;
use ncfix_machine::snc::Kind;

/// Executes a block's words.
pub(super) fn execute(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<(), Fault> {
    channel.block.before.clear();
    channel.block.after.clear();
    channel.block.corner = None;
    target::check_axes(channel.language, channel.axes, channel.settings.machine, gathered)?;
    let done = if channel.is_rs274() { execute_rs274(channel, gathered) } else { execute_fanuc(channel, gathered) };
    done?;
    if !channel.is_rs274() && channel.modal.codes.is(Group::Length, 490) && gathered.raw_quietly(b'H') == Some(0.0) {
        // H0 has no effect if no offset is active.
        gathered.use_up(b"H");
    }
    match gathered.unused() {
        None => Ok(()),
        Some((letter, span)) => {
            let message = format!("{letter} has no effect in this block");
            let of_builder = gathered.m_codes.iter().find(|(number, _)| *number > auxiliary::LAST_STANDARD_M);
            let help = match of_builder.filter(|_| !channel.is_rs274()) {
                Some((number, _)) => format!(
                    "remove the word; if M{number} takes it, name the code in control.opaque = [\"M{number}\"] and begin the block with it; if it calls a macro, write its program in control.macro_codes = {{ M{number} = 9010 }}"
                ),
                None => "remove the word, or add the code that it belongs to".to_owned(),
            };
            Err(fault(Code::BAD_WORD_VALUE, span, message, help))
        }
    }
}

/// The order of RS274/NGC in LinuxCNC.
pub(super) fn execute_rs274(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<(), Fault> {
    feed::feed_mode(channel, gathered)?;
    feed::feed(channel, gathered)?;
    feed::speed(channel.settings.machine, &mut channel.modal, &mut channel.block, gathered)?;
    feed::tool_word(&mut channel.modal, &mut channel.outlet, gathered)?;
    auxiliary::m_codes(channel, gathered)?;
    channel.flush_before();
    auxiliary::select_head(channel, gathered)?;
    feed::dwell(channel, gathered)?;
    modes::plane(channel, gathered)?;
    special::lathe(gathered)?;
    modes::units(channel.settings.machine, channel.language, &mut channel.modal, gathered)?;
    compensation::compensation_codes(channel, gathered)?;
    let mut takes_axes = length::length_codes(channel, gathered)?;
    offsets::coordinates(channel, gathered)?;
    feed::path_control(channel, gathered)?;
    modes::distance(&mut channel.modal, gathered);
    if gathered.code(Group::Retract).is_some() {
        forbidden::no_compensation(
            channel.language,
            &channel.modal,
            gathered.code_span(Group::Retract),
            "another retract mode",
        )?;
    }
    modes::retract(&mut channel.modal, gathered);
    takes_axes |= action(channel, gathered)?;
    offsets::shift_codes(channel, gathered)?;
    move_axes(channel, gathered, takes_axes)
}

/// The order of a Fanuc: the modal codes of a block apply to all its words.
pub(super) fn execute_fanuc(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<(), Fault> {
    forbidden::check_state(channel, gathered)?;
    modes::units(channel.settings.machine, channel.language, &mut channel.modal, gathered)?;
    modes::plane(channel, gathered)?;
    modes::distance(&mut channel.modal, gathered);
    feed::feed_mode(channel, gathered)?;
    modes::retract(&mut channel.modal, gathered);
    let mut takes_axes = feed::passed_on(channel, gathered)?;
    feed::path_control(channel, gathered)?;
    if gathered.code(Group::Action) != Some(40) {
        feed::feed(channel, gathered)?;
    }
    feed::tool_word(&mut channel.modal, &mut channel.outlet, gathered)?;
    compensation::compensation_codes(channel, gathered)?;
    offsets::coordinates(channel, gathered)?;
    takes_axes |= length::length_codes(channel, gathered)?;
    feed::speed(channel.settings.machine, &mut channel.modal, &mut channel.block, gathered)?;
    auxiliary::m_codes(channel, gathered)?;
    channel.flush_before();
    auxiliary::select_head(channel, gathered)?;
    feed::dwell(channel, gathered)?;
    takes_axes |= transform::transform_codes(channel, gathered)?;
    takes_axes |= action(channel, gathered)?;
    move_axes(channel, gathered, takes_axes)
}

/// Executes the motion of a block, and the words that act after it.
pub(super) fn move_axes(channel: &mut Channel<'_>, gathered: &Gathered, takes_axes: bool) -> Result<(), Fault> {
    let code = if takes_axes {
        modes::code_of_motion(channel.language, &channel.cycles, gathered)
    } else {
        modes::motion_of(channel.language, &channel.modal, &channel.cycles, gathered)
    };
    let mut done = Ok(());
    if let Some(code) = code {
        if !takes_axes && code == G80 && !gathered.axes.is_empty() {
            let message = "axis words without a motion mode in force";
            let help = "program G0 or G1 in this block: at the start and after G80 no motion code is in force; if the control starts \
                        with one, state it in control.startup_code, for example \"G0\"";
            done = Err(fault(Code::BAD_WORD_VALUE, gathered.span, message, help));
            gathered.use_up(b"XYZABCUVW");
        } else {
            let is_passed = !takes_axes && passed_axis::pass_on(channel, gathered, code)?;
            kept_cycle::note_end(channel, gathered);
            cycle::note_motion(channel, code);
            // G80 alone restores a thread as the motion mode, and does not cut it.
            let is_named = gathered.code(Group::Motion).is_some() || gathered.code(Group::Cycle) != Some(G80);
            let is_special = code > 30 && code != G80 && (is_named || !gathered.axes.is_empty());
            let moves = !is_passed && !takes_axes && (is_special || has_way(&channel.modal, gathered, code));
            if moves && let Some((letter, _)) = gathered.origins.iter().find(|(letter, _)| is_place(*letter)) {
                channel.variables.fixed.note(gathered.span_of(*letter));
            }
            if moves {
                done = motion::motion(channel, gathered, code);
            } else {
                feed_alone(&channel.modal, &mut channel.outlet, gathered);
            }
        }
    } else {
        feed_alone(&channel.modal, &mut channel.outlet, gathered);
    }
    if !channel.block.after.is_empty() {
        let after = std::mem::take(&mut channel.block.after);
        channel.push(Kind::After(after));
    }
    auxiliary::lose_by_functions(&mut channel.modal, &mut channel.outlet, gathered);
    done
}

/// True for the letters of positions, centers, radii and depths.
fn is_place(letter: u8) -> bool {
    matches!(letter, b'A'..=b'C' | b'I'..=b'K' | b'Q' | b'R' | b'U'..=b'Z')
}

/// `true` if a block has words for a line or an arc.
pub(super) fn has_way(modal: &Modal, gathered: &Gathered, code: u16) -> bool {
    let is_arc = matches!(code, 20 | 30) || direction::has_directions(modal);
    !gathered.axes.is_empty() || gathered.has_any(b"@^") || is_arc && gathered.has_any(b"IJKR")
}

/// Handles F of a block without motion.
pub(super) fn feed_alone(modal: &Modal, outlet: &mut MotionSink<'_>, gathered: &Gathered) {
    if gathered.has(b'F') && gathered.code(Group::Action) != Some(40) {
        outlet.push(Kind::Feed(modal.modes.feed));
    }
}

/// Executes non-modal actions: G4, G10, G28, G52, G92 … Returns `true` if one consumed the axis words.
pub(super) fn action(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<bool, Fault> {
    let Some(code) = gathered.code(Group::Action) else { return Ok(false) };
    match code {
        40 => return Ok(gathered.code(Group::Motion).is_none() && !channel.is_rs274()),
        100 => data::set_data(channel, gathered)?,
        280 | 300 => home::home(channel, gathered, code)?,
        270 | 290 => reference::back_to_work(channel, gathered, code)?,
        110 => return Ok(false),
        281 | 301 => {
            home::save_home(channel, code, gathered.code_span(Group::Action))?;
            return Ok(false);
        }
        120 | 130 => haas::circular_pocket(channel, gathered, code)?,
        700 | 710 | 720 => haas::holes(channel, gathered, code)?,
        2540 | 2550 => haas::turned_zero(channel, gathered, code)?,
        520 | 920 => offsets::axis_offsets(channel, gathered, code)?,
        921 => offsets::axis_offsets(channel, gathered, code)?,
        _ => {
            motion::special_motion(channel, gathered, code)?;
        }
    }
    Ok(true)
}
