//! F and S.

use super::gathered::Gathered;
use super::modal::Modal;
use super::splines::Splines;
use super::thread;
use crate::exec::core::motion_sink::MotionSink;
use ncfix_base::units::MM_PER_INCH;
use ncfix_machine::snc::{FeedUnit, Word, WordValue};

/// Emits the feed before the call of a program that the control itself executes: it relies on this feed.
pub(super) fn feed_for_call(modal: &Modal, splines: &Splines, outlet: &mut MotionSink<'_>) {
    if modal.modes.feed_unit != FeedUnit::InverseTime && !splines.is_holding() {
        outlet.feed_for_call(modal.modes.feed);
    }
}

pub(super) fn feed_and_speed(modal: &mut Modal, gathered: &mut Gathered) {
    thread::lead_change(modal, gathered);
    if let Some((feed, _)) = gathered.feed {
        let is_inch = modal.inch_feed && modal.modes.feed_unit != FeedUnit::InverseTime;
        modal.modes.set_feed(if is_inch { feed * MM_PER_INCH } else { feed });
    }
    if let Some((speed, _)) = gathered.speed {
        modal.modes.speed = Some(speed);
        let word = Word { letter: b'S', extension: None, value: WordValue::Number(speed) };
        // After D, before M.
        let place = gathered.before.iter().take_while(|word| word.letter == b'D').count();
        gathered.before.insert(place, word);
    }
}
