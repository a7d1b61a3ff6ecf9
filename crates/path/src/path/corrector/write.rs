//! Converts candidates into output pieces, and samples the error along them.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector};
use ncfix_machine::snc::{Element, MotionMode};

use super::dead_band::Bands;
use super::{Active, Corrector};
use crate::path::place::Placed;
use crate::path::prediction::{sample_count, sample_place};
use crate::path::rotary_word;
use crate::path::segment_candidate::SegmentCandidate;
use crate::path::treatment::MoveTreatment;
use crate::path::{ErrorPlace, Piece};

impl<I> Corrector<'_, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// Creates an output piece from a candidate or a step on the spot, with its share of the move duration and the nominal commands at its end.
    /// `None` if it is shorter than an increment.
    pub(super) fn write(
        &mut self,
        active: &mut Active,
        placed: &Placed,
        trial: Option<&SegmentCandidate>,
        (share, nominal): (f64, &AxisVector),
        is_last: bool,
    ) -> Option<Piece> {
        let standing = &mut self.standing;
        let motion = &active.motion;
        let first = std::mem::take(&mut active.is_first);
        let mut words = if first { motion.named } else { AxisSet::EMPTY };
        // The other axes stay; unwritten positions are written by a later move.
        let others_stay = active.treatment.leaves_others();
        if others_stay {
            let changes = |axis: &Axis| placed.counts[axis.slot()] != standing.counts[axis.slot()];
            words = if first { active.moving } else { active.moving.iter().filter(changes).collect() };
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
        // A step on the spot takes additional time.
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
            motion_mode: motion.motion_mode,
            command: placed.command,
            nominal: *nominal,
            known: motion.known,
            is_corrected: active.treatment != MoveTreatment::Programmed,
            others_stay,
        })
    }

    /// Samples the error along a piece, unless it is short and near the last sample.
    pub(super) fn predict(&mut self, active: &Active, trial: &SegmentCandidate, bands: &Bands) {
        let [from, to] = trial.between;
        let size_mm = active.route.size_mm() * (to - from);
        let (rapid, sample_mm) = (active.motion.rapid, self.options.sample_mm);
        // The written path is a chord of the programmed path.
        let chord_mm = active.motion.off_curve_mm;
        let (lead, placer) = (&self.lead, &self.placer);
        let tool_mm = &placer.setup.tool_mm;
        let off_at = |share: f64| {
            let at = trial.parameter(share);
            let (nominal, command) = (active.route.at(at), trial.emitted.at(share));
            // If the axes continue as placed, the errors depend on nothing else.
            if bands.are_led {
                return [placer.tip_error_mm(&nominal, &command, &trial.state()); 2];
            }
            let mut band = bands.at(lead, trial, share);
            if share == 0.0 {
                lead.put(&mut band, &trial.sense, &command);
            }
            let off = lead.error_mm(&band, (&nominal, &command), tool_mm, active.way_at(at));
            [off.most_mm, off.nearest.norm()]
        };
        let middle_mm = trial.middle_mm.filter(|_| bands.are_led);
        let mut largest = off_at(1.0);
        if let Some(middle_mm) = middle_mm
            && self.prediction.passes(rapid, size_mm, sample_mm)
        {
            self.prediction.note_after(rapid, middle_mm.max(largest[0]) + chord_mm, &active.origin);
            return;
        }
        let mut note = |off: [f64; 2]| largest = [0, 1].map(|k| f64::max(largest[k], off[k]));
        if !bands.are_led {
            note(off_at(0.0));
            self.scratch.clear();
            lead.edges(&bands.start, &trial.emitted, &mut self.scratch);
            self.scratch.iter().for_each(|&share| note(off_at(share)));
        }
        let count = sample_count(size_mm, sample_mm);
        for k in 0..count {
            let share = sample_place(k, count);
            let at = trial.parameter(share);
            let nominal = active.route.at(at);
            let mut programmed = self.standing.state;
            let before_mm = if lead.axes.is_empty() {
                placer.form_mm(placer.model.tip_error_mm(&nominal, &nominal, tool_mm, &programmed))
            } else {
                let mut before = self.standing.nominal_band;
                lead.along(&mut before, &active.route, self.standing.sensed, [from, at]);
                let off = lead.error_mm(&before, (&nominal, &nominal), tool_mm, None);
                let [_, form_mm] = placer.form_mm(off.nearest);
                programmed = before.state();
                [off.most_mm, form_mm]
            };
            let off = middle_mm.filter(|_| count == 1).map_or_else(|| off_at(share), |middle_mm| [middle_mm; 2]);
            note(off);
            self.prediction.add(rapid, before_mm, off[0] + chord_mm, &active.origin);
            self.prediction.offer(rapid, [before_mm[0], off[0]], || ErrorPlace {
                nominal,
                command: trial.emitted.at(share),
                states: [programmed, trial.state()],
                tool_mm: *tool_mm,
                zero: placer.setup.zero,
            });
        }
        let [most_mm, nearest_mm] = largest;
        self.prediction.note_after(rapid, most_mm + chord_mm, &active.origin);
        // Rounding may leave bodies within their dead bands, away from the side for which they were placed.
        let tolerance_mm = self.options.tolerance_mm;
        if !bands.are_led && !rapid && nearest_mm > placer.increments.allowed_mm(tolerance_mm) {
            let is_cut = active.motion.motion_mode == MotionMode::Path;
            self.findings.tolerance_missed(&active.origin, is_cut, nearest_mm, tolerance_mm);
        }
    }
}
