//! Converts candidates into output pieces, and samples the error along them.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector};
use ncfix_machine::snc::{Element, MotionMode};
use ncfix_model::DeadBand;

use super::dead_band::Bands;
use super::{Active, Corrector};
use crate::path::Piece;
use crate::path::place::Placed;
use crate::path::rotary_word;
use crate::path::route::Route;
use crate::path::sampling::{LedPath, PieceErrors, SampledPiece};
use crate::path::segment_candidate::SegmentCandidate;
use crate::path::treatment::MoveTreatment;

/// Allowance for the path between the places that are measured, as a share of the tolerance.
const BETWEEN_SHARE: f64 = 0.05;
/// Largest displacement of an arc by the rounding of its center, increments: half of one in each of two directions.
pub(super) const CENTER_INCREMENTS: f64 = std::f64::consts::FRAC_1_SQRT_2;

impl<I> Corrector<'_, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// Creates an output piece from a candidate or a step on the spot, with its share of the move duration and the nominal commands at its end.
    /// `None` if it is shorter than an increment.
    pub(super) fn write(
        &mut self,
        active: &mut Active<'_>,
        placed: &Placed,
        trial: Option<&SegmentCandidate<'_>>,
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
        let (feed, unit) = self.feed_of(active, [&start, &placed.command], share, trial);
        self.prediction.pieces += 1;
        if let (Some(cycle_s), Some(whole_s)) = (self.machine.control.block_cycle_s, active.duration_s) {
            self.prediction.short_blocks.note([share * whole_s, whole_s], cycle_s, &active.origin);
        }
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

    /// Samples the error along a piece; `first` are the command and the bodies before it and its preparatory steps.
    pub(super) fn predict(
        &mut self,
        active: &mut Active<'_>,
        trial: &SegmentCandidate<'_>,
        bands: &Bands,
        first: (&AxisVector, &DeadBand),
    ) {
        if let Some(beyond) = &trial.overshoot {
            let route = self.placer.emitted(*first.0, beyond.command);
            self.sample(active, (&route, first.1, self.standing.sensed), (1.0, false), None);
        }
        let is_last = trial.between[1] >= 1.0;
        let is_whole = is_last && trial.between[0] <= 0.0 && trial.overshoot.is_none();
        let middle_mm = trial.middle_mm.filter(|_| bands.are_led && is_whole);
        let emitted = (&trial.emitted, &bands.start, bands.sensed);
        let found = self.sample(active, emitted, (trial.between[1], is_last), middle_mm);
        let (nearest_mm, start_mm) = found.map_or((0.0, 0.0), |found| (found.nearest_mm, found.start_mm));
        // Rounding may leave bodies within their dead bands, away from the side for which they were placed. Where all are led, one may reverse on the way.
        let (increments, tolerance_mm) = (&self.placer.increments, active.tolerance_mm);
        let is_judged = match bands.are_led {
            true => active.treatment == MoveTreatment::RotaryDirection && !self.sampler.backlash.is_empty(),
            false => true,
        };
        let (between_mm, center_mm) = match bands.are_led {
            // The center of an arc is rounded too. A step on the spot before the arc has no center.
            true => {
                let center_mm = if trial.circle.is_some() { CENTER_INCREMENTS * increments.linear_mm } else { 0.0 };
                (BETWEEN_SHARE * tolerance_mm.max(increments.rounding_mm()), center_mm)
            }
            false => (0.0, 0.0),
        };
        let allowed_mm = increments.allowed_mm(tolerance_mm) + between_mm;
        let is_missed = start_mm > allowed_mm || nearest_mm > allowed_mm + center_mm;
        if is_judged && !active.motion.rapid && is_missed {
            let is_cut = active.motion.motion_mode == MotionMode::Path;
            self.findings.tolerance_missed(&active.origin, is_cut, nearest_mm.max(start_mm), tolerance_mm);
        }
    }

    /// Samples a piece on a path of commands with its bodies and stated axes; `guess` is the parameter at its end.
    fn sample(
        &mut self,
        active: &mut Active<'_>,
        (route, band, stated): (&Route<'_>, &DeadBand, AxisSet),
        (guess, is_last): (f64, bool),
        middle_mm: Option<f64>,
    ) -> Option<PieceErrors> {
        let tool_mm = &self.placer.setup.tool_mm;
        let from = active.sampled;
        let piece = SampledPiece {
            lead: &self.lead,
            base: self.placer.base.for_head(self.placer.setup.head),
            zero: self.placer.setup.zero,
            head: self.placer.setup.head,
            programmed: LedPath {
                route: &active.route,
                band: &self.standing.nominal_band,
                stated: self.standing.sensed,
                tool_mm,
            },
            emitted: LedPath { route, band, stated, tool_mm },
            origin: active.origin,
            rapid: active.motion.rapid,
            // The written path is a chord of the programmed path.
            off_curve_mm: active.motion.off_curve_mm,
            middle_mm,
        };
        active.sampled = if is_last { 1.0 } else { piece.nearest(guess, from) };
        let found = piece.sample([from, active.sampled], &mut self.prediction, &mut self.scratch);
        if is_last {
            self.prediction.end_move(active.motion.rapid, active.route.size_mm());
        }
        found
    }
}
