//! Lowers the feed of corrected pieces where the tool would be too far off its path.
//!
//! The pieces of a window are driven with their feeds; where the tool is off by more than allowed, the feed of the piece at that place, and of those
//! that the set-points have reached by then, is lowered, until all fit. Lag goes with the speed and what corners and curves do with its square, so
//! the first step takes the square root of what is too much, and those that follow the power that the last one has shown. The first half of the
//! window is then certain, and the machine goes on from its end: the next pieces are judged with what came before.
//!
//! A feed is never raised, and not lowered below a share of that of the program. Times of moves (G93), rapid moves, threads and probing stay. A feed
//! that changes nothing (the structure gives way while the axes accelerate from rest) is left as it was.

use std::collections::VecDeque;

use super::follow::Moment;
use super::run::{Run, Tally};
use crate::diagnostic::{Code, Diagnostic, Place};
use crate::machine::{Machine, Servo};
use crate::model::Model;
use crate::path::{Options, Output, Piece};
use crate::snc::Manner;

/// Pieces that become certain together; as many are looked at behind them.
const HALF: usize = 256;
/// Trials of a window at most.
const ROUNDS: usize = 12;
/// Feeds are not lowered below this share of that of the program.
const LEAST_SHARE: f64 = 0.05;
/// In one round a feed falls at most to this share of itself.
const LEAST_STEP: f64 = 0.5;
/// Trials by which feeds that fit are brought nearer to those that did not.
const REFINEMENTS: usize = 3;
/// Feeds that differ less are not worth a trial, and errors that are nearer to the limit neither.
const WORTH: f64 = 1.2;
/// What is aimed at, as a share of the limit.
const AIM: f64 = 0.98;
/// An error that falls less than this has not followed the feed.
const FOLLOWS: f64 = 0.98;
/// Rounds in which an error may do so before its piece is given up.
const PATIENCE: u8 = 2;
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

/// A piece, or what stands between, that is not certain yet.
#[derive(Debug)]
struct Waiting {
    item: Result<Output, Diagnostic>,
    programmed: f64,
    /// Feed in the unit of the program by mm/min; `None` under G93.
    unit: Option<f64>,
    /// How far the tool is off in the last trial, mm, and the speed there, mm/min.
    last: Option<[f64; 2]>,
    /// Rounds in which that has not followed the feed, and the feed before them.
    futile: u8,
    feed_before: f64,
    /// The lowest feed that was too high.
    too_high: f64,
}

/// The worst moment on a piece.
#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    off_mm: f64,
    speed: f64,
    /// The block that the set-points were in.
    until: u64,
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
        Limiter {
            outputs,
            limit_mm,
            programmed: run.clone(),
            certain: run,
            window: VecDeque::with_capacity(2 * HALF),
            first: 0,
            ready: VecDeque::new(),
            worst: Vec::with_capacity(2 * HALF),
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
        let mut see = |moment: &Moment| {
            let Some(on_path) = moment.on_path.filter(|on_path| !on_path.is_rapid) else { return };
            let Some(number) = on_path.block.checked_sub(*first) else { return };
            let Some(worst) = worst.get_mut(number as usize) else { return };
            let off_mm = on_path.off_mm.norm();
            if off_mm > worst.off_mm {
                *worst = Worst { off_mm, speed: on_path.feed_mm_min.max(moment.feed_mm_min), until: moment.block };
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
            let waiting = &mut self.window[number];
            let Some(target) = waiting.judge(&worst, self.limit_mm) else { continue };
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

impl Waiting {
    fn new(item: Result<Output, Diagnostic>) -> Waiting {
        let programmed = if let Ok(Output::Piece(piece)) = &item { piece.feed } else { 0.0 };
        Waiting { item, programmed, unit: None, last: None, futile: 0, feed_before: programmed, too_high: programmed }
    }

    fn piece(&self) -> Option<&Piece> {
        match &self.item {
            Ok(Output::Piece(piece)) => Some(piece),
            _ => None,
        }
    }

    fn as_programmed(&self, output: &Output) -> Output {
        match output {
            Output::Piece(piece) => Output::Piece(Piece { feed: self.programmed, ..*piece }),
            Output::Element(_) => output.clone(),
        }
    }

    fn is_slowed(&self) -> bool {
        self.piece().is_some_and(|piece| piece.feed < self.programmed)
    }

    /// The speed, mm/min, at which the error would fit; `None` where it does, or where the feed does not help.
    fn judge(&mut self, worst: &Worst, limit_mm: f64) -> Option<f64> {
        let before = self.last.replace([worst.off_mm, worst.speed]);
        let feed = self.piece()?.feed;
        if worst.off_mm <= limit_mm || self.futile > PATIENCE {
            return None;
        }
        let mut power = 2.0;
        if let Some([off_mm, speed]) = before.filter(|&[off_mm, _]| off_mm > limit_mm) {
            if worst.off_mm > FOLLOWS * off_mm {
                self.futile += 1;
                if self.futile > PATIENCE {
                    self.set_feed(self.feed_before);
                    return None;
                }
            } else {
                (self.futile, self.feed_before) = (0, feed);
                let shown = (worst.off_mm / off_mm).ln() / (worst.speed / speed).ln();
                power = if shown.is_finite() { shown.clamp(1.0, 2.0) } else { 2.0 };
            }
        }
        let share = (AIM * limit_mm / worst.off_mm).powf(1.0 / power);
        Some(worst.speed * share)
    }

    /// Lowers the feed to a speed, mm/min, where it is higher; whether it was.
    fn lower_to(&mut self, speed: f64) -> bool {
        let Some(piece) = self.piece() else { return false };
        let is_fixed = piece.rapid || piece.manner != Manner::Path || piece.feed <= 0.0 || self.futile > PATIENCE;
        let Some(unit) = self.unit.filter(|_| !is_fixed) else { return false };
        let feed = two_digits((speed * unit).max(LEAST_STEP * piece.feed)).max(self.programmed * LEAST_SHARE);
        let before = piece.feed;
        let is_lower = feed < before;
        if is_lower {
            self.too_high = before;
            self.set_feed(feed);
        }
        is_lower
    }

    /// Raises the feed half of the way to the one that was too high, where that is worth a trial; whether it was.
    fn raise(&mut self, off_mm: f64, limit_mm: f64) -> bool {
        let feed = self.feed();
        let is_worth = feed < self.programmed && self.too_high > WORTH * feed && WORTH * off_mm < limit_mm;
        let raised = two_digits((feed * self.too_high).sqrt());
        if is_worth && raised > feed {
            self.set_feed(raised);
        }
        is_worth && raised > feed
    }

    /// Takes back what was raised.
    fn take_back(&mut self, feed: f64) {
        if self.feed() > feed {
            self.too_high = self.feed();
            self.set_feed(feed);
        }
    }

    fn feed(&self) -> f64 {
        self.piece().map_or(0.0, |piece| piece.feed)
    }

    fn set_feed(&mut self, feed: f64) {
        if let Ok(Output::Piece(piece)) = &mut self.item {
            piece.feed = feed;
        }
    }

    /// A finding where the limit is not kept.
    fn exceeds(&self, limit_mm: f64) -> Option<Diagnostic> {
        let piece = self.piece()?;
        let [off_mm, _] = self.last.filter(|[off_mm, _]| *off_mm > limit_mm)?;
        let (why, help) = if piece.manner != Manner::Path {
            ("its motion is none of the path", "feeds of threads, positioning and probing stay as they are")
        } else if self.unit.is_none() {
            ("its feed is a time (G93), which stays", "program it with G94, or take longer times")
        } else if self.futile > PATIENCE {
            (
                "a lower feed does not help",
                "the axes accelerate too hard for it: lower their acceleration on the control, or allow more",
            )
        } else {
            (
                "its feed is as low as it may be made",
                "allow more, or look at the velocity gains and feed-forwards in [servo]",
            )
        };
        let message = format!(
            "the tool will be {:.1} µm off its path and {:.1} µm are allowed: {why}",
            off_mm * 1e3,
            limit_mm * 1e3
        );
        let place = Place { file: piece.origin.file, span: piece.origin.span };
        Some(Diagnostic::at(Code::FEED_LIMIT_MISSED, place, message, help))
    }
}

/// The number of two significant digits below: a feed that can be read.
fn two_digits(value: f64) -> f64 {
    if value.is_nan() || value <= 0.0 {
        return 0.0;
    }
    let step = 10_f64.powi(value.log10().floor() as i32 - 1);
    let digits = (value / step + 1e-9).floor();
    // A division by a whole number gives the double nearest to the decimal text.
    if step < 1.0 { digits / (1.0 / step).round() } else { digits * step.round() }
}

#[cfg(test)]
mod tests {
    use super::two_digits;

    #[test]
    fn feeds_are_cut_to_two_digits() {
        let cases = [(5271.0, 5200.0), (999.9, 990.0), (0.128, 0.12), (12.0, 12.0), (0.3, 0.3), (f64::NAN, 0.0)];
        for (value, expected) in cases {
            assert_eq!(two_digits(value), expected, "{value}");
        }
    }
}
