//! Lowers the feed of corrected pieces on which the tool would deviate too far from its path.
//!
//! The pieces of a window are simulated with their feeds. If the tool deviates by more than the limit, the speed is lowered for the group of pieces
//! there and for the groups that the set-points have reached by then, until all fit. Lag is proportional to the speed, and errors at corners and
//! curves to its square. The first step therefore uses the square root of the excess; later steps use the power observed in the last one. If the
//! maximum is at the start of a group, the axes brought the error with them, and the previous group is slowed as long as that helps. Then the first
//! half of the window is final, and the simulation continues from its end: the next pieces are evaluated with their history.
//!
//! A feed is never raised, and never lowered below a share of the programmed feed. Move times (G93), rapid moves, threads and probing stay. A feed
//! without effect (compliance while the axes accelerate from rest) stays as it was.

use std::collections::VecDeque;
use std::ops::Range;

use super::follow::CycleState;
use super::group::{PieceGroup, Waiting, WorstMoment};
use super::run::{Run, Tally};
use crate::path::{CorrectionOptions, Output};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_machine::machine::{Machine, Servo};
use ncfix_model::Model;

/// Number of pieces that become final together; as many after them are simulated.
const HALF: usize = 256;
/// Maximum iterations of a window.
const ROUNDS: usize = 32;
/// Iterations that raise acceptable speeds towards those that were too high.
const REFINEMENTS: usize = 3;
/// Number of time constants after which a following error has decayed.
const TIME_CONSTANTS: f64 = 3.0;
/// Maximum number of diagnostics; further ones are only counted.
const MOST_FINDINGS: u64 = 20;

/// Result of the feed limitation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limited {
    /// Contouring error with the programmed feeds.
    pub before: Tally,
    /// Contouring error with the emitted feeds.
    pub after: Tally,
    /// Program time with its own feeds, and as emitted, s.
    pub times_s: [f64; 2],
    /// Pieces with a lower feed.
    pub slowed: u64,
    /// Pieces on which the tool still deviates by more than the limit.
    pub exceeding: u64,
}

/// An iterator over the pieces of a corrected program with feeds that keep the limit.
#[derive(Debug)]
pub struct Limiter<'a, I> {
    outputs: I,
    limit_mm: f64,
    /// The machine after the final pieces, with the emitted and with the programmed feeds.
    certain: Run<'a>,
    programmed: Run<'a>,
    window: VecDeque<Waiting>,
    /// Number of the first piece in the window.
    first: u64,
    groups: VecDeque<PieceGroup>,
    /// Number of the first group.
    first_group: usize,
    /// The worst moment of each group in the last iteration.
    worst: Vec<WorstMoment>,
    /// The last group with a diagnostic, and the number of diagnostics.
    told: Option<usize>,
    findings: u64,
    ready: VecDeque<Result<Output, Diagnostic>>,
    /// Settling time of the axes, s.
    memory_s: f64,
    cycle_s: f64,
    limited: Limited,
    is_ended: bool,
}

impl<'a, I: Iterator<Item = Result<Output, Diagnostic>>> Limiter<'a, I> {
    /// Limits the distance of the tool from its path, mm, on a machine. The options are those of the correction.
    #[must_use]
    pub fn new(
        outputs: I,
        limit_mm: f64,
        machine: &Machine,
        servo: &Servo,
        model: &'a Model,
        options: &CorrectionOptions,
    ) -> Limiter<'a, I> {
        let run = Run::new(machine, servo, model, options);
        let slowest_s = servo.axes.iter().flatten().map(|axis| 1.0 / axis.velocity_gain_per_s).fold(0.0, f64::max);
        Limiter {
            outputs,
            limit_mm,
            programmed: run.clone(),
            certain: run,
            window: VecDeque::with_capacity(2 * HALF),
            first: 0,
            groups: VecDeque::new(),
            first_group: 0,
            worst: Vec::new(),
            told: None,
            findings: 0,
            ready: VecDeque::new(),
            memory_s: TIME_CONSTANTS * slowest_s,
            cycle_s: servo.cycle_s,
            limited: Limited::default(),
            is_ended: false,
        }
    }

    /// The result so far; complete at the end of the stream.
    #[must_use]
    pub fn limited(&self) -> &Limited {
        &self.limited
    }

    fn fill(&mut self) {
        while !self.is_ended && self.window.len() < 2 * HALF {
            match self.outputs.next() {
                Some(item) => self.window.push_back(Waiting::new(item)),
                None => self.is_ended = true,
            }
        }
    }

    /// Groups new pieces by their duration in an iteration.
    fn group(&mut self) {
        let most = (self.memory_s / self.cycle_s).ceil() as u32;
        let mut open: Option<(usize, u32)> = None;
        for waiting in &mut self.window {
            if waiting.group.is_some() || waiting.piece().is_none() {
                continue;
            }
            let is_long = waiting.cycles >= most;
            let group = match open.take().filter(|_| !is_long && !waiting.is_fixed()) {
                Some((number, cycles)) => {
                    self.groups[number - self.first_group].take(waiting);
                    (number, cycles + waiting.cycles)
                }
                None => {
                    self.groups.push_back(PieceGroup::of(waiting));
                    (self.first_group + self.groups.len() - 1, waiting.cycles)
                }
            };
            waiting.group = Some(group.0);
            open = Some(group).filter(|&(_, cycles)| cycles < most && !waiting.is_fixed());
        }
    }

    /// Lowers speeds until the window meets the limit.
    fn fit(&mut self) {
        self.try_out();
        self.group();
        let mut is_slowed = false;
        for _ in 0..ROUNDS {
            self.try_out();
            if !self.lower() {
                break;
            }
            is_slowed = true;
        }
        if is_slowed {
            let _ = (0..REFINEMENTS).all(|_| self.refine());
            self.try_out();
        }
    }

    /// Raises speeds towards those that were too high. Returns `true` if any was raised.
    fn refine(&mut self) -> bool {
        let speeds: Vec<f64> = self.groups.iter().map(PieceGroup::speed).collect();
        let allowed: Vec<f64> = self.worst.iter().map(|worst| worst.off_mm.max(self.limit_mm)).collect();
        let mut is_raised = false;
        for (group, worst) in self.groups.iter_mut().zip(&self.worst) {
            is_raised |= group.raise(worst.off_mm, self.limit_mm);
        }
        // A raise that was too much is reverted in that group; if that does not help, in all groups.
        for is_last in [false, true] {
            if !is_raised {
                break;
            }
            self.try_out();
            let faults: Vec<_> =
                (0..speeds.len()).filter(|&number| self.worst[number].off_mm > allowed[number]).collect();
            for number in &faults {
                let range = if is_last { 0..speeds.len() } else { number.saturating_sub(1)..self.reach(*number).end };
                for number in range {
                    self.groups[number].take_back(speeds[number]);
                }
            }
            if faults.is_empty() {
                break;
            }
        }
        is_raised
    }

    /// The range from a group to the group of the set-points at its worst moment.
    fn reach(&self, number: usize) -> Range<usize> {
        let until = self.worst[number].until.saturating_sub(self.first_group);
        number..until.clamp(number, self.groups.len() - 1) + 1
    }

    /// Simulates the window with the current speeds.
    fn try_out(&mut self) {
        let Limiter { window, worst, certain, first, groups, first_group, .. } = self;
        worst.clear();
        worst.resize(groups.len(), WorstMoment::default());
        for waiting in window.iter_mut() {
            (waiting.cycles, waiting.off_mm) = (0, 0.0);
            if let Some(group) = waiting.group.and_then(|number| groups.get(number.checked_sub(*first_group)?)) {
                waiting.go_at(group.speed());
            }
        }
        // The moments of a block come later than the block itself, so they are assigned afterwards.
        let mut pieces: Vec<(Option<usize>, u32, f64)> = window.iter().map(|waiting| (waiting.group, 0, 0.0)).collect();
        // Time at which the set-points entered the current group.
        let mut since = (None, 0.0);
        let memory_s = self.memory_s;
        let mut see = |moment: &CycleState| {
            let now = moment.block.checked_sub(*first).and_then(|number| pieces.get_mut(number as usize));
            let now = now.map(|(group, cycles, _)| {
                *cycles += 1;
                *group
            });
            let now = now.flatten();
            if since.0 != now {
                since = (now, moment.time_s);
            }
            let Some(on_path) = moment.on_path.filter(|on_path| !on_path.is_rapid) else { return };
            let Some(number) = on_path.block.checked_sub(*first) else { return };
            let Some((group, _, most_mm)) = pieces.get_mut(number as usize) else { return };
            let off_mm = on_path.off_mm.norm();
            *most_mm = most_mm.max(off_mm);
            let Some(number) = *group else { return };
            let Some(worst) = number.checked_sub(*first_group).and_then(|number| worst.get_mut(number)) else { return };
            if off_mm > worst.off_mm {
                let speed = on_path.feed_mm_min.max(moment.feed_mm_min);
                let is_early = now == Some(number) && moment.time_s - since.1 < memory_s;
                *worst = WorstMoment { off_mm, speed, until: now.unwrap_or(number), is_early };
            }
        };
        let mut run = certain.clone();
        for (number, waiting) in window.iter_mut().enumerate() {
            if let Ok(output) = &waiting.item {
                run.output(output, *first + number as u64, &mut see);
                waiting.unit = run.feed_at(1.0);
            }
        }
        run.finish(&mut see);
        for (waiting, (_, cycles, off_mm)) in window.iter_mut().zip(pieces) {
            (waiting.cycles, waiting.off_mm) = (cycles, off_mm);
        }
    }

    /// Lowers the speeds of groups that exceed the limit. Returns `true` if any was lowered.
    fn lower(&mut self) -> bool {
        let mut is_lowered = false;
        for number in 0..self.groups.len() {
            let worst = self.worst[number];
            let before = number.checked_sub(1);
            let had_given_up = self.groups[number].has_given_up();
            let Some(target) = self.groups[number].judge(&worst, self.limit_mm) else {
                if let Some(before) = before.filter(|_| !had_given_up && self.groups[number].has_given_up()) {
                    self.groups[before].restore();
                }
                continue;
            };
            // An error that the axes bring with them is caused by the previous group.
            if let Some(before) = before.filter(|_| worst.is_early)
                && self.groups[before].lower_for_next(target)
            {
                is_lowered = true;
                continue;
            }
            for number in self.reach(number) {
                is_lowered |= self.groups[number].lower_to(target);
            }
        }
        is_lowered
    }

    /// Makes the first `count` pieces final.
    fn release(&mut self, count: usize) {
        for _ in 0..count {
            let Some(waiting) = self.window.pop_front() else { return };
            let number = self.first;
            self.first += 1;
            if let Ok(output) = &waiting.item {
                let Limited { before, after, .. } = &mut self.limited;
                self.certain.output(output, number, &mut |moment| after.note(moment));
                self.programmed.output(&waiting.as_programmed(output), number, &mut |moment| before.note(moment));
                self.limited.slowed += u64::from(waiting.is_slowed());
            }
            let finding = self.finding(&waiting);
            self.ready.push_back(waiting.item);
            self.ready.extend(finding.map(Err));
        }
        let in_use = self.window.iter().find_map(|waiting| waiting.group).unwrap_or(usize::MAX);
        while self.first_group < in_use && self.groups.pop_front().is_some() {
            self.first_group += 1;
        }
        if self.is_ended && self.window.is_empty() {
            let Limited { before, after, .. } = &mut self.limited;
            self.certain.finish(&mut |moment| after.note(moment));
            self.programmed.finish(&mut |moment| before.note(moment));
        }
        self.limited.times_s = [self.programmed.time_s(), self.certain.time_s()];
    }

    /// The diagnostic for a limit that is still exceeded, once per group.
    fn finding(&mut self, waiting: &Waiting) -> Option<Diagnostic> {
        let number = waiting.group.filter(|_| waiting.off_mm > self.limit_mm)?;
        self.limited.exceeding += 1;
        let is_new = self.told.replace(number) != Some(number);
        let group = self.groups.get(number.checked_sub(self.first_group)?).filter(|_| is_new)?;
        let worst = self.worst.get(number - self.first_group)?;
        self.findings += 1;
        (self.findings <= MOST_FINDINGS).then(|| waiting.exceeds(group, worst.off_mm, self.limit_mm))?
    }
}

impl<I: Iterator<Item = Result<Output, Diagnostic>>> Iterator for Limiter<'_, I> {
    type Item = Result<Output, Diagnostic>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ready.is_empty() {
            self.fill();
            self.fit();
            self.release(if self.is_ended { self.window.len() } else { HALF });
        }
        self.ready.pop_front()
    }
}
