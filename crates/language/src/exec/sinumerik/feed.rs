//! F and S.

use super::channel::Channel;
use super::gathered::Gathered;
use super::thread;
use crate::exec::core::outlet::HasOutlet;
use ncfix_base::units::MM_PER_INCH;
use ncfix_machine::snc::{FeedUnit, Word, WordValue};

/// Before the call of a program of the control, which finds the feed of this one.
pub(super) fn feed_for_call(channel: &mut Channel<'_>) {
    if channel.modal.feed_unit != FeedUnit::InverseTime && !channel.splines.is_holding() {
        channel.outlet.feed_for_call(channel.modal.feed);
    }
}

pub(super) fn feed_and_speed(channel: &mut Channel<'_>, gathered: &mut Gathered) {
    thread::lead_change(channel, gathered);
    if let Some((feed, _)) = gathered.feed {
        let is_inch = channel.modal.inch_feed && channel.modal.feed_unit != FeedUnit::InverseTime;
        channel.modal.feed = if is_inch { feed * MM_PER_INCH } else { feed };
    }
    if let Some((speed, _)) = gathered.speed {
        channel.modal.speed = Some(speed);
        let word = Word { letter: b'S', extension: None, value: WordValue::Number(speed) };
        // Behind D, before M.
        let place = gathered.before.iter().take_while(|word| word.letter == b'D').count();
        gathered.before.insert(place, word);
    }
}
