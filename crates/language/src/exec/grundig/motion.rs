//! Motions: rapid with or without positioning logic, and straight.

use super::arc;
use super::contour_words;
use super::modal::Modal;
use super::step;
use super::target;

use super::channel::Channel;
use super::gathered::Gathered;
use super::modal::MotionKind;
use crate::exec::core::fault::{Fault, bad_value, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;
use ncfix_machine::snc::Kind;

/// The motion of a block, if it has one.
pub(super) fn motion_words(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<(), Fault> {
    let block_feed = block_feed(&channel.modal, gathered)?;
    let modal_feed = channel.modal.modes.feed;
    if let Some(feed) = block_feed {
        channel.modal.modes.feed = feed;
        channel.block.feed_named = true;
    }
    let done = motion(channel, gathered);
    if block_feed.is_some() {
        channel.modal.modes.feed = modal_feed;
    }
    done
}

/// `F6=`: a feed for this block only.
fn block_feed(modal: &Modal, gathered: &mut Gathered) -> Result<Option<f64>, Fault> {
    let Some((feed, span)) = gathered.once(b'F', Some(6))? else { return Ok(None) };
    if feed <= 0.0 {
        return Err(bad_value(span, "a feed must be above 0", "correct F6="));
    }
    Ok(Some(feed * modal.modes.scale()))
}

fn motion(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<(), Fault> {
    if channel.modal.calculates_geometry() {
        contour_words::corner_words(channel, gathered)?;
        if contour_words::open_element(channel, gathered)? {
            return Ok(());
        }
    }
    let points = target::points(&channel.modal, gathered)?;
    let is_arc = matches!(channel.modal.modes.motion, MotionKind::Clockwise | MotionKind::CounterClockwise);
    let incremental = channel.modal.modes.incremental;
    let target = target::target(channel, gathered, incremental)?;
    if points.is_empty() {
        if is_arc {
            return arc::arc_words(channel, gathered, target);
        }
        if !target.named.is_empty() {
            return step::straight(channel, target);
        }
        if channel.block.feed_named {
            channel.outlet.push(Kind::Feed(channel.modal.modes.feed));
        } else if gathered.items.is_empty() && gathered.codes.is_empty() && gathered.functions.is_empty() {
            channel.outlet.push(Kind::Empty);
        }
        return Ok(());
    }
    if is_arc || (points.len() > 1 && !target.named.is_empty()) {
        let message = "a stored point in a block where its meaning is ambiguous";
        return Err(fault(Code::NOT_SUPPORTED, gathered.span, message, "program coordinates, or one point per block"));
    }
    for point in points {
        let mut to = target;
        for axis in point.named.difference(target.named).iter() {
            to.to[axis] = point.values[axis];
        }
        to.named = to.named.union(point.named);
        // Axes that the block does not name stay at the end of the previous motion.
        let here = target::here(&channel.modal, &channel.standing);
        for axis in [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C] {
            if !to.named.contains(axis) {
                to.to[axis] = here[axis];
            }
        }
        step::straight(channel, to)?;
    }
    Ok(())
}
