//! A hole with one shift: the deviation that it leaves, and its pecks.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{Axis, AxisSet};
use ncfix_machine::snc::{DrillingCycle, Element, Kind};

use super::{Corrector, HoleFit, HoleLine, HoleShift, MOST_HELD};
use crate::path::place::Placed;
use crate::path::route::Route;
use crate::path::segment_candidate::{SegmentCandidate, SegmentFitter};
use crate::path::side_plan::SidePlan;
use crate::path::standing::PathState;
use crate::path::staying::is_better_whole;

impl<'a, I> Corrector<'a, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// A hole as a cycle with a shift; `None` if the cycle makes other moves, or an axis beside it reverses.
    pub(super) fn fit_hole(
        &mut self,
        cycle: &DrillingCycle,
        line: &HoleLine,
        shift: &HoleShift,
        hole: &[Element],
    ) -> Option<HoleFit> {
        let along = line.axes[2];
        let mut standing = self.positioned(line, shift, self.standing);
        let mut cuts = 0;
        let mut heights = [None; 2];
        let mut deviation_mm = 0.0_f64;
        let increment_mm = self.placer.increments.linear_mm;
        // Rounding may add a peck of nothing: then each peck is one increment longer.
        let own = cycle.peck.map_or(0, |peck| (peck.depth_mm / increment_mm).round() as i64);
        let longer = [own, own + 1];
        let mut besides_mm = [0.0_f64; 2];
        for motion in hole.iter().filter_map(|element| match &element.kind {
            Kind::Move(motion) => Some(motion),
            _ => None,
        }) {
            if !motion.rapid && cuts == 0 {
                standing = self.leveled(line, shift, standing);
            }
            let placed = self.shifted(line, shift, motion, &standing);
            let route = self.placer.nominal(standing.nominal, motion);
            let trial = self.hole_candidate(&route, motion.known, &standing, placed);
            if !motion.rapid {
                cuts += 1;
                let is_open = |axis: &Axis| trial.sense[axis.slot()] == 0;
                if self.sampler.backlash.iter().any(|axis| is_open(&axis)) {
                    return None;
                }
                // On the way out of a thread the drilling axis is on the other side of its dead band: the depth counts.
                let ends_at = self.placer.in_frame(&motion.target)[along];
                let is_down = (ends_at - self.placer.in_frame(&route.start)[along])
                    * (line.bottom[along] - line.top[along])
                    > 0.0;
                if is_down || !is_better_whole(cycle) {
                    deviation_mm = deviation_mm.max(trial.deviation_mm);
                }
                let from = *heights[0].get_or_insert(standing.counts[along.slot()]);
                let end = placed.counts[along.slot()];
                if self.placer.in_frame(&motion.target)[along] == line.bottom[along] {
                    heights[1] = Some(end);
                } else {
                    // The control counts pecks from the reference plane: what their lengths are rounded by adds up.
                    for (besides_mm, peck) in besides_mm.iter_mut().zip(longer) {
                        let off = i64::from(cuts) * peck - (end - from).abs();
                        *besides_mm = besides_mm.max(off.abs() as f64 * increment_mm);
                    }
                }
            }
            self.lead.along(&mut standing.band, &trial.emitted, standing.sensed, [0.0, 1.0]);
            standing.nominal = motion.target;
            standing.command = placed.command;
            standing.counts = placed.counts;
            standing.correction = placed.command - motion.target;
            standing.state.direction = trial.sense;
            standing.sensed = motion.known;
            standing.known = motion.known;
        }
        let Some(peck) = cycle.peck else { return Some(HoleFit { deviation_mm, peck: None }) };
        let [Some(from), Some(to)] = heights else { return None };
        longer
            .into_iter()
            .zip(besides_mm)
            .find(|&(count, _)| pecks(from, to, count, increment_mm, peck.slack_mm) == cuts)
            .map(|(count, besides_mm)| HoleFit { deviation_mm: deviation_mm + besides_mm, peck: Some(count) })
    }

    /// A move of a hole to a position, measured along its path.
    pub(super) fn hole_candidate(
        &mut self,
        route: &Route<'a>,
        known: AxisSet,
        standing: &PathState,
        end: Placed,
    ) -> SegmentCandidate<'a> {
        let mut scratch = std::mem::take(&mut self.scratch);
        let fitter = SegmentFitter {
            placer: &self.placer,
            sampler: &self.sampler,
            lead: &self.lead,
            control: &self.machine.control,
            route,
            samples: self.sampler.whole(route),
            known,
            tolerance_mm: self.options.tolerance_mm,
            takes_up: false,
            limits_turns: false,
            settled: Default::default(),
            plan: SidePlan::default(),
        };
        let trial = fitter.at_end(standing, end, &mut scratch);
        self.scratch = scratch;
        trial
    }
}

/// Number of feed moves that a control makes of a depth, in increments.
fn pecks(from: i64, to: i64, peck: i64, increment_mm: f64, slack_mm: f64) -> u32 {
    let [from_mm, to_mm, peck_mm] = [from, to, peck].map(|count| count as f64 * increment_mm);
    let towards = (to_mm - from_mm).signum();
    let mut depth_mm = from_mm + towards * peck_mm;
    let mut count = 1;
    while peck > 0 && (to_mm - depth_mm) * towards > slack_mm && count < MOST_HELD as u32 {
        depth_mm += towards * peck_mm;
        count += 1;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pecks_are_counted_as_the_control_counts_them() {
        assert_eq!(pecks(2000, -28000, 5000, 1e-3, 1e-6), 6);
        assert_eq!(pecks(2001, -28000, 5000, 1e-3, 1e-6), 7);
        assert_eq!(pecks(2001, -28000, 5001, 1e-3, 1e-6), 6);
        assert_eq!(pecks(-28000, 2000, 40000, 1e-3, 1e-6), 1);
    }
}
