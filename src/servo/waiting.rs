//! A piece in the window of [`super::limit`]: how far the tool is off on it, and which feed would do.

use crate::diagnostic::{Code, Diagnostic, Place};
use crate::path::{Output, Piece};
use crate::snc::Manner;

/// Feeds are not lowered below this share of that of the program.
const LEAST_SHARE: f64 = 0.05;
/// Feeds up to this many times the least are as low as they get: they are cut to two digits.
const AS_LOW: f64 = 1.1;
/// In one round a feed falls at most to this share of itself.
const LEAST_STEP: f64 = 0.5;
/// Feeds that differ less are not worth a trial, and errors that are nearer to the limit neither.
const WORTH: f64 = 1.2;
/// What is aimed at, as a share of the limit.
const AIM: f64 = 0.98;
/// An error that falls less than this has not followed the feed.
const FOLLOWS: f64 = 0.98;
/// Rounds in which an error may do so before its piece is given up.
const PATIENCE: u8 = 2;

/// A piece, or what stands between, that is not certain yet.
#[derive(Debug)]
pub(super) struct Waiting {
    pub(super) item: Result<Output, Diagnostic>,
    programmed: f64,
    /// Feed in the unit of the program by mm/min; `None` under G93.
    pub(super) unit: Option<f64>,
    /// How far the tool is off in the last trial, mm, and the speed there, mm/min.
    pub(super) last: Option<[f64; 2]>,
    /// Rounds in which that has not followed the feed, and the feed before them.
    futile: u8,
    feed_before: f64,
    /// The lowest feed that was too high.
    too_high: f64,
    /// The feed before it was lowered for what comes behind.
    feed_before_next: Option<f64>,
}

/// The worst moment on a piece.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Worst {
    pub(super) off_mm: f64,
    pub(super) speed: f64,
    /// The block that the set-points were in.
    pub(super) until: u64,
    /// Whether they had come to it just before.
    pub(super) is_early: bool,
}

impl Waiting {
    pub(super) fn new(item: Result<Output, Diagnostic>) -> Waiting {
        let programmed = if let Ok(Output::Piece(piece)) = &item { piece.feed } else { 0.0 };
        Waiting {
            item,
            programmed,
            unit: None,
            last: None,
            futile: 0,
            feed_before: programmed,
            too_high: programmed,
            feed_before_next: None,
        }
    }

    pub(super) fn piece(&self) -> Option<&Piece> {
        match &self.item {
            Ok(Output::Piece(piece)) => Some(piece),
            _ => None,
        }
    }

    pub(super) fn as_programmed(&self, output: &Output) -> Output {
        match output {
            Output::Piece(piece) => Output::Piece(Piece { feed: self.programmed, ..*piece }),
            Output::Element(_) => output.clone(),
        }
    }

    pub(super) fn is_piece(&self) -> bool {
        self.piece().is_some()
    }

    /// Whether a lower feed has not helped.
    pub(super) fn has_given_up(&self) -> bool {
        self.futile > PATIENCE
    }

    /// Lowers the feed for the sake of the next piece; whether it was.
    pub(super) fn lower_for_next(&mut self, speed: f64) -> bool {
        let before = self.feed();
        let is_lower = self.lower_to(speed);
        if is_lower {
            self.feed_before_next.get_or_insert(before);
        }
        is_lower
    }

    /// Takes that back: it has not helped.
    pub(super) fn restore(&mut self) {
        if let Some(feed) = self.feed_before_next.take() {
            self.set_feed(feed);
        }
    }

    pub(super) fn is_slowed(&self) -> bool {
        self.piece().is_some_and(|piece| piece.feed < self.programmed)
    }

    /// The speed, mm/min, at which the error would fit; `None` where it does, or where the feed does not help.
    pub(super) fn judge(&mut self, worst: &Worst, limit_mm: f64) -> Option<f64> {
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
    pub(super) fn lower_to(&mut self, speed: f64) -> bool {
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
    pub(super) fn raise(&mut self, off_mm: f64, limit_mm: f64) -> bool {
        let feed = self.feed();
        let is_worth = feed < self.programmed && self.too_high > WORTH * feed && WORTH * off_mm < limit_mm;
        let raised = two_digits((feed * self.too_high).sqrt());
        if is_worth && raised > feed {
            self.set_feed(raised);
        }
        is_worth && raised > feed
    }

    /// Takes back what was raised.
    pub(super) fn take_back(&mut self, feed: f64) {
        if self.feed() > feed {
            self.too_high = self.feed();
            self.set_feed(feed);
        }
    }

    pub(super) fn feed(&self) -> f64 {
        self.piece().map_or(0.0, |piece| piece.feed)
    }

    pub(super) fn set_feed(&mut self, feed: f64) {
        if let Ok(Output::Piece(piece)) = &mut self.item {
            piece.feed = feed;
        }
    }

    /// A finding where the limit is not kept.
    pub(super) fn exceeds(&self, limit_mm: f64) -> Option<Diagnostic> {
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
        } else if piece.feed <= AS_LOW * LEAST_SHARE * self.programmed {
            (
                "its feed is as low as it may be made",
                "allow more, or look at the velocity gains and feed-forwards in [servo]",
            )
        } else {
            ("no feed was found in the trials that are made", "cut it into shorter pieces with --step, or allow more")
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
