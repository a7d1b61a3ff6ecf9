//! Emits the motion of a block.

use super::channel::Channel;
use super::context::MotionContext;
use super::contour_words;
use super::gathered::Gathered;
use super::modal::Modal;
use super::motion;
use super::orientation;
use super::rotary;
use super::spline;
use super::thread;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::standing::InForce;
use crate::exec::core::standing::known_behind;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Frame, LINEAR_AXES};
use ncfix_base::source::Span;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Kind, MotionMode, Setup};
use std::sync::Arc;

pub(super) fn send(channel: &mut Channel<'_>, gathered: &Gathered, span: Span) -> Result<(), Fault> {
    check_swivelled(channel.settings.machine, &channel.modal, span)?;
    let geometry = || LINEAR_AXES.into_iter().take(3).any(|axis| gathered.named.contains(axis));
    channel.block.has_moved = gathered.positioned.is_empty() && (gathered.named.is_empty() || geometry());
    channel.block.has_moved_beside = !channel.block.has_moved;
    let setup = if let Some(word) = gathered.suppress {
        let bare = Arc::new(suppressed(&channel.modal, &channel.standing, word));
        channel.push(Kind::Setup(Arc::clone(&bare)));
        channel.standing.changed = true;
        channel.modal.position.known =
            known_behind(channel.modal.position.known, &channel.standing.setup.frame, &bare.frame);
        bare
    } else {
        if std::mem::take(&mut channel.standing.changed) {
            channel.push(Kind::Setup(Arc::clone(&channel.standing.setup)));
        }
        Arc::clone(&channel.standing.setup)
    };
    contour_words::corner_words(&channel.modal, &mut channel.block, &channel.standing, gathered)?;
    let context = MotionContext {
        machine: channel.settings.machine,
        control: &channel.settings.machine.control,
        setup: &setup,
        is_suppressed: gathered.suppress.is_some(),
        strict: channel.settings.strict,
        span,
    };
    let modal_feed = channel.modal.modes.feed;
    if let Some(feed) = gathered.block_feed {
        channel.modal.modes.feed = feed;
    }
    let found = motion::motion(gathered, &mut channel.modal, context);
    channel.modal.modes.feed = modal_feed;
    if gathered.suppress.is_some() {
        channel.modal.position.known =
            known_behind(channel.modal.position.known, &setup.frame, &channel.standing.setup.frame);
    }
    let mut path = found?;
    if path.motion.rapid {
        path.motion.feed = modal_feed;
    } else {
        path.motion.feed_named |= gathered.block_feed.is_some();
    }
    channel.outlet.warnings.extend(rotary::either_way(&path.motion.ways, span));
    thread::check_manner(&channel.modal, &channel.block, &mut path)?;
    let step = &path.motion;
    let is_driven = matches!(step.motion_mode, MotionMode::Thread(thread) if thread.code.is_spindle_driven());
    if !step.rapid && !is_driven && step.feed <= 0.0 && !std::mem::replace(&mut channel.feed_warned, true) {
        let (message, help) = channel.modal.modes.no_feed();
        channel.outlet.warnings.push(fault(Code::FEED_ASSUMED, span, message, help));
    }
    orientation::orient(&channel.settings, &mut channel.modal, &mut channel.outlet, gathered, &mut path)?;
    let node = spline::node(gathered, &channel.modal)?;
    spline::push_path(channel, path, node)
}

/// The setup of a block with a word that suppresses frames: G53 keeps the base frame.
pub(super) fn suppressed(modal: &Modal, standing: &InForce, word: &str) -> Setup {
    let frame = if word == "G53" { modal.base } else { Frame::identity() };
    Setup { frame, zero: None, written_zero: None, ..(*standing.setup).clone() }
}

/// Rejects state that is incompatible with a swivelled plane.
pub(super) fn check_swivelled(machine: &Machine, modal: &Modal, span: Span) -> Result<(), Fault> {
    let Some(swivelled) = &modal.swivelled else { return Ok(()) };
    let turns_tool = !swivelled.is_of_tool && machine.topology.tool.iter().any(|axis| axis.is_rotary());
    if turns_tool && swivelled.tool_mm != modal.tool_mm() {
        let message = "the tool length changed in a tilted plane on a swivel head";
        return Err(fault(Code::BAD_SWIVEL, span, message, "tilt the plane again after the tool change"));
    }
    Ok(())
}
