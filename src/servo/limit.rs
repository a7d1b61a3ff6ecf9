//! Lowers the feed of corrected pieces where the tool would be too far off its path.
//!
//! The pieces of a window are driven with their feeds; where the tool is off by more than allowed, the feed of the piece at that place, and of those
//! that the set-points have reached by then, is lowered, until all fit. Lag goes with the speed and what corners and curves do with its square, so
//! the first step takes the square root of what is too much, and those that follow the power that the last one has shown. Where the worst is at the start of
//! a piece, the axes brought it with them, and the piece before is slowed as long as that helps. The first half of the
//! window is then certain, and the machine goes on from its end: the next pieces are judged with what came before.
//!
//! A feed is never raised, and not lowered below a share of that of the program. Times of moves (G93), rapid moves, threads and probing stay. A feed
//! that changes nothing (the structure gives way while the axes accelerate from rest) is left as it was.

use std::collections::VecDeque;

use super::follow::Moment;
use super::run::{Run, Tally};
use super::waiting::{Waiting, Worst};
use crate::diagnostic::Diagnostic;
use crate::machine::{Machine, Servo};
use crate::model::Model;
use crate::path::{Options, Output};

/// Pieces that become certain together; as many are looked at behind them.
const HALF: usize = 256;
/// Trials of a window at most.
const ROUNDS: usize = 32;
/// Trials by which feeds that fit are brought nearer to those that did not.
const REFINEMENTS: usize = 3;
/// An error of following is forgotten after as many time constants.
const TIME_CONSTANTS: f64 = 3.0;
/// Findings at most; the others are counted.
const MOST_FINDINGS: u64 = 20;

/// What limiting the feed did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limited {
    /// With the feeds of the program.
    pub before: Tally,
    /// As emitted.
    pub after: Tally,
    /// Time of the program with its own feeds, and as emitted, s.
    pub times_s: [f64; 2],
    /// Pieces with a lower feed.
    pub slowed: u64,
    /// Pieces on which the tool is off by more than the limit all the same.
    pub exceeding: u64,
}

/// Pieces of a corrected program with feeds that keep the limit.
#[derive(Debug)]
pub struct Limiter<'a, I> {
    outputs: I,
    limit_mm: f64,
    /// The machine behind what is certain, and as the program would have had it.
    certain: Run<'a>,
    programmed: Run<'a>,
    window: VecDeque<Waiting>,
    /// The number of the first in the window.
    first: u64,
    ready: VecDeque<Result<Output, Diagnostic>>,
    worst: Vec<Worst>,
    /// How long the axes remember what was before, s.
    memory_s: f64,
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
        options: &Options,
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
            ready: VecDeque::new(),
            worst: Vec::with_capacity(2 * HALF),
            memory_s: TIME_CONSTANTS * slowest_s,
            limited: Limited::default(),
            is_ended: false,
        }
    }

    /// What was done; complete when the stream has ended.
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

    /// Lowers feeds until the window fits.
    fn fit(&mut self) {
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
        }
        self.try_out();
        for (waiting, worst) in self.window.iter_mut().zip(&self.worst) {
            waiting.last = Some([worst.off_mm, worst.speed]);
        }
    }

    /// Brings feeds nearer to those that were too high; whether any was.
    fn refine(&mut self) -> bool {
        let feeds: Vec<f64> = self.window.iter().map(Waiting::feed).collect();
        let allowed: Vec<f64> = self.worst.iter().map(|worst| worst.off_mm.max(self.limit_mm)).collect();
        let mut is_raised = false;
        for (waiting, worst) in self.window.iter_mut().zip(&self.worst) {
            is_raised |= waiting.raise(worst.off_mm, self.limit_mm);
        }
        // Where it was too much, it is taken back there; if that does not help, everywhere.
        for is_last in [false, true] {
            if !is_raised {
                break;
            }
            self.try_out();
            let faults: Vec<_> =
                (0..feeds.len()).filter(|&number| self.worst[number].off_mm > allowed[number]).collect();
            if faults.is_empty() {
                break;
            }
            for number in faults {
                let range = if is_last { 0..feeds.len() } else { self.reach(number) };
                for number in range {
                    self.window[number].take_back(feeds[number]);
                }
            }
        }
        is_raised
    }

    /// The pieces that the worst moment of one depends on.
    fn reach(&self, number: usize) -> std::ops::Range<usize> {
        let until = self.worst[number].until.saturating_sub(self.first) as usize;
        number.saturating_sub(1)..until.clamp(number, self.window.len() - 1) + 1
    }

    /// Drives the window with the feeds that it has now.
    fn try_out(&mut self) {
        let Limiter { window, worst, certain, first, .. } = self;
        worst.clear();
        worst.resize(window.len(), Worst::default());
        // When the set-points came to the block that they are in.
        let mut since = (u64::MAX, 0.0);
        let memory_s = self.memory_s;
        let mut see = |moment: &Moment| {
            if since.0 != moment.block {
                since = (moment.block, moment.time_s);
            }
            let Some(on_path) = moment.on_path.filter(|on_path| !on_path.is_rapid) else { return };
            let Some(number) = on_path.block.checked_sub(*first) else { return };
            let Some(worst) = worst.get_mut(number as usize) else { return };
            let off_mm = on_path.off_mm.norm();
            if off_mm > worst.off_mm {
                let speed = on_path.feed_mm_min.max(moment.feed_mm_min);
                let is_early = moment.block == on_path.block && moment.time_s - since.1 < memory_s;
                *worst = Worst { off_mm, speed, until: moment.block, is_early };
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
    }

    /// Lowers the feeds of pieces on which the tool is too far off; whether any was.
    fn lower(&mut self) -> bool {
        let mut is_lowered = false;
        for number in 0..self.window.len() {
            let worst = self.worst[number];
            let before = (0..number).rev().find(|&before| self.window[before].is_piece());
            let had_given_up = self.window[number].has_given_up();
            let Some(target) = self.window[number].judge(&worst, self.limit_mm) else {
                if let Some(before) = before.filter(|_| !had_given_up && self.window[number].has_given_up()) {
                    self.window[before].restore();
                }
                continue;
            };
            // What the axes bring with them from the piece before is its doing.
            if let Some(before) = before.filter(|_| worst.is_early)
                && self.window[before].lower_for_next(target)
            {
                is_lowered = true;
                continue;
            }
            let reach = number..self.reach(number).end;
            for waiting in self.window.range_mut(reach) {
                is_lowered |= waiting.lower_to(target);
            }
        }
        is_lowered
    }

    /// Makes the first pieces certain.
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
            let finding = waiting.exceeds(self.limit_mm);
            self.ready.push_back(waiting.item);
            if let Some(finding) = finding {
                self.limited.exceeding += 1;
                if self.limited.exceeding <= MOST_FINDINGS {
                    self.ready.push_back(Err(finding));
                }
            }
        }
        if self.is_ended && self.window.is_empty() {
            let Limited { before, after, .. } = &mut self.limited;
            self.certain.finish(&mut |moment| after.note(moment));
            self.programmed.finish(&mut |moment| before.note(moment));
        }
        self.limited.times_s = [self.programmed.time_s(), self.certain.time_s()];
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
