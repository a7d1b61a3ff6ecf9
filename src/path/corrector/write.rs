//! Makes pieces for the output of those that were tried, and samples the error along them.

use crate::diagnostic::Diagnostic;
use crate::geometry::AxisSet;
use crate::snc::Element;

use super::{Active, Corrector};
use crate::path::Piece;
use crate::path::place::Placed;
use crate::path::prediction::{sample_count, sample_place};
use crate::path::rotary_word;
use crate::path::treatment::Treatment;
use crate::path::trial::Trial;

impl<I> Corrector<'_, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// A piece for the output: of a trial, or a step on the spot. `share` is its share of the time of the move. `None` where it is shorter
    /// than an increment.
    pub(super) fn write(
        &mut self,
        active: &mut Active,
        placed: &Placed,
        trial: Option<&Trial>,
        share: f64,
        is_last: bool,
    ) -> Option<Piece> {
        let standing = &mut self.standing;
        let motion = &active.motion;
        let first = std::mem::take(&mut active.is_first);
        let mut words = if first { motion.named } else { AxisSet::EMPTY };
        // The others stay, and what is not written yet is written by a later move.
        let others_stay = active.treatment.leaves_others();
        if others_stay {
            words = active.moving;
        }
        let stated = if others_stay { AxisSet::EMPTY } else { motion.known };
        for axis in stated.iter() {
            let slot = axis.slot();
            if !standing.written.contains(axis) || placed.counts[slot] != standing.counts[slot] {
                words.insert(axis);
            }
        }
        let arc = trial.and_then(|trial| trial.circle);
        let rotary_words = rotary_word::words(&self.placer, self.machine, standing, motion, placed);
        let start = standing.command;
        standing.counts = placed.counts;
        standing.command = placed.command;
        standing.written = if others_stay { standing.written.union(active.moving) } else { motion.known };
        // A step on the spot takes time of its own.
        let share = if trial.is_some() { share + std::mem::take(&mut active.unwritten) } else { share };
        if words.is_empty() && arc.is_none() && !first && !is_last {
            if trial.is_some() {
                active.unwritten = share;
            }
            return None;
        }
        let (feed, unit) = self.feed_of(active, [&start, &placed.command], share, trial.is_none());
        self.prediction.pieces += 1;
        let motion = &active.motion;
        Some(Piece {
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
            feed,
            unit,
            feed_named: first && motion.feed_named,
            rotary_words,
            in_machine_frame: motion.in_machine_frame,
            manner: motion.manner,
            command: placed.command,
            nominal: active.route.at(trial.map_or(active.parameter, |trial| trial.between[1])),
            known: motion.known,
            is_corrected: active.treatment != Treatment::Programmed,
            others_stay,
        })
    }

    /// Samples the error along a piece, unless it is short and near the last sample.
    pub(super) fn predict(&mut self, active: &Active, trial: &Trial) {
        let [from, to] = trial.between;
        let size_mm = active.route.size_mm() * (to - from);
        let (rapid, sample_mm) = (active.motion.rapid, self.options.sample_mm);
        // What is written is a chord of the way that the program asks for.
        let chord_mm = active.motion.off_curve_mm;
        let end_mm = self.placer.tip_error_mm(&active.route.at(to), &trial.end.command, &trial.state());
        if let Some(middle_mm) = trial.middle_mm
            && self.prediction.passes(rapid, size_mm, sample_mm)
        {
            self.prediction.note_after(rapid, middle_mm.max(end_mm) + chord_mm, &active.origin);
            return;
        }
        let count = sample_count(size_mm, sample_mm);
        for k in 0..count {
            let fraction = sample_place(k, count);
            let nominal = active.route.at(from + (to - from) * fraction);
            let before_mm = self.placer.tip_error_mm(&nominal, &nominal, &self.standing.nominal_state);
            let after_mm = match trial.middle_mm {
                Some(middle_mm) if count == 1 => middle_mm,
                _ => self.placer.tip_error_mm(&nominal, &trial.emitted.at(fraction), &trial.state()),
            };
            self.prediction.add(rapid, before_mm, after_mm + chord_mm, &active.origin);
        }
        self.prediction.note_after(rapid, end_mm + chord_mm, &active.origin);
    }
}
