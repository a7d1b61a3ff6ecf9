//! Puts tried pieces into the output, and samples the error along them.

use crate::diagnostic::Diagnostic;
use crate::geometry::AxisSet;
use crate::snc::{Element, Manner};

use super::{Active, Corrector};
use crate::path::cut::of_share;
use crate::path::place::Placed;
use crate::path::prediction::{sample_count, sample_place};
use crate::path::rotary_word;
use crate::path::treatment::Treatment;
use crate::path::trial::Trial;
use crate::path::{Output, Piece};

impl<I> Corrector<'_, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// Puts a piece into the output: of a trial, or a step on the spot. `share` is its share of the time of the move.
    pub(super) fn write(
        &mut self,
        active: &mut Active,
        placed: &Placed,
        trial: Option<&Trial>,
        share: f64,
        is_last: bool,
    ) {
        let standing = &mut self.standing;
        let motion = &active.motion;
        let first = std::mem::take(&mut active.is_first);
        let mut words = if first { motion.named } else { AxisSet::EMPTY };
        // The others stay, and what is not written yet is written by a later move.
        let is_reference = motion.manner == Manner::Reference;
        let stated = if is_reference { AxisSet::EMPTY } else { motion.known };
        for axis in stated.iter() {
            let slot = axis.slot();
            if !standing.written.contains(axis) || placed.counts[slot] != standing.counts[slot] {
                words.insert(axis);
            }
        }
        let arc = trial.and_then(|trial| trial.circle);
        let rotary_words = rotary_word::words(&self.placer, self.machine, standing, motion, placed);
        standing.counts = placed.counts;
        standing.command = placed.command;
        standing.written = if is_reference { standing.written.union(motion.named) } else { motion.known };
        if words.is_empty() && arc.is_none() && !first && !is_last {
            // Shorter than an increment.
            return;
        }
        self.prediction.pieces += 1;
        let piece = Piece {
            origin: active.origin,
            starts_block: first && active.starts_block,
            number: if first { active.number } else { None },
            first,
            last: is_last,
            take_up: trial.is_none(),
            rapid: motion.rapid,
            arc,
            counts: placed.counts,
            words,
            feed: if motion.inverse_time { of_share(motion.feed, share) } else { motion.feed },
            feed_named: first && motion.feed_named,
            rotary_words,
            in_machine_frame: motion.in_machine_frame,
            manner: motion.manner,
            command: placed.command,
            nominal: active.route.at(trial.map_or(active.parameter, |trial| trial.between[1])),
            known: motion.known,
            is_corrected: active.treatment != Treatment::Round,
        };
        self.pending.push_back(Ok(Output::Piece(piece)));
    }

    /// Samples the error along a piece.
    pub(super) fn predict(&mut self, active: &Active, trial: &Trial) {
        let [from, to] = trial.between;
        let count = sample_count(active.route.size_mm() * (to - from), self.options.sample_mm);
        for k in 0..count {
            let fraction = sample_place(k, count);
            let nominal = active.route.at(from + (to - from) * fraction);
            let before_mm = self.placer.tip_error_mm(&nominal, &nominal, &self.standing.nominal_state);
            let after_mm = match trial.middle_mm {
                Some(middle_mm) if count == 1 => middle_mm,
                _ => self.placer.tip_error_mm(&nominal, &trial.emitted.at(fraction), &trial.state),
            };
            self.prediction.add(active.motion.rapid, before_mm, after_mm, &active.origin);
        }
    }
}
