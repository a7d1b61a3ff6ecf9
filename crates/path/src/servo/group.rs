//! Groups of consecutive pieces that share one speed limit in the window of the limiter.
//!
//! If blocks are shorter than the settling time of the axes, separate speeds would make the axes oscillate, and no single speed would have a clear
//! effect. A group therefore lasts as long as the settling time; a long piece is a group by itself.

use crate::path::{Output, Piece};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_machine::snc::MotionMode;

/// Lowest feed as a share of the programmed feed.
const LEAST_SHARE: f64 = 0.05;
/// Lowest speed after one iteration as a share of the previous speed.
const LEAST_STEP: f64 = 0.5;
/// Ratio of speeds, and of limit to error, below which another iteration is not useful.
const WORTH: f64 = 1.1;
/// Target of the error as a share of the limit.
const AIM: f64 = 0.98;
/// An error that falls by less than this did not respond to the speed.
const FOLLOWS: f64 = 0.98;
/// Number of iterations without response after which the group is given up.
const PATIENCE: u8 = 6;

/// A piece, or an element between pieces, that is not final yet.
#[derive(Debug)]
pub(super) struct Waiting {
    pub(super) item: Result<Output, Diagnostic>,
    /// Programmed feed.
    programmed: f64,
    /// Feed in the unit of the program per mm/min; `None` under G93.
    pub(super) unit: Option<f64>,
    /// Number of its group; `None` before the first iteration and for elements that are not pieces.
    pub(super) group: Option<usize>,
    /// Cycles of the set-points on it in the last iteration.
    pub(super) cycles: u32,
    /// Distance of the tool from the path in the last iteration, mm.
    pub(super) off_mm: f64,
}

/// The moment with the largest error on a group.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WorstMoment {
    pub(super) off_mm: f64,
    /// Path speed at that moment, mm/min.
    pub(super) speed: f64,
    /// The group of the set-points at that moment.
    pub(super) until: usize,
    /// `true` if the set-points had just entered that group.
    pub(super) is_early: bool,
}

/// State common to the pieces of a group.
#[derive(Clone, Copy, Debug)]
pub(super) struct PieceGroup {
    /// The highest programmed speed, mm/min.
    programmed: f64,
    /// Current speed limit, mm/min.
    speed: f64,
    /// `true` if the speed must not be changed.
    is_fixed: bool,
    /// Distance of the tool in the last iteration, mm, and the speed there.
    last: Option<[f64; 2]>,
    /// Iterations in which the error did not respond to the speed, and the speed before them.
    futile: u8,
    speed_before: f64,
    /// The lowest speed that was too high.
    too_high: f64,
    /// The speed before it was lowered for the following group.
    before_next: Option<f64>,
}

impl Waiting {
    pub(super) fn new(item: Result<Output, Diagnostic>) -> Waiting {
        let programmed = if let Ok(Output::Piece(piece)) = &item { piece.feed } else { 0.0 };
        Waiting { item, programmed, unit: None, group: None, cycles: 0, off_mm: 0.0 }
    }

    pub(super) fn piece(&self) -> Option<&Piece> {
        match &self.item {
            Ok(Output::Piece(piece)) => Some(piece),
            _ => None,
        }
    }

    /// `true` if its feed must stay.
    pub(super) fn is_fixed(&self) -> bool {
        self.unit.is_none()
            || self
                .piece()
                .is_none_or(|piece| piece.rapid || piece.motion_mode != MotionMode::Path || piece.feed <= 0.0)
    }

    /// The programmed speed, mm/min.
    pub(super) fn speed(&self) -> f64 {
        self.unit.map_or(0.0, |unit| self.programmed / unit)
    }

    pub(super) fn as_programmed(&self, output: &Output) -> Output {
        match output {
            Output::Piece(piece) => Output::Piece(Piece { feed: self.programmed, ..*piece }),
            Output::Element(_) | Output::Cycle(_) => output.clone(),
        }
    }

    pub(super) fn is_slowed(&self) -> bool {
        self.piece().is_some_and(|piece| piece.feed < self.programmed)
    }

    /// Applies the speed limit of its group, mm/min, if it is lower.
    pub(super) fn go_at(&mut self, speed: f64) {
        let (fixed, programmed) = (self.is_fixed(), self.programmed);
        let Some(unit) = self.unit.filter(|_| !fixed) else { return };
        if let Ok(Output::Piece(piece)) = &mut self.item {
            // Rounded down to two digits, but not below the minimum.
            let least = programmed * LEAST_SHARE;
            piece.feed = if speed * unit < programmed { two_digits(speed * unit).max(least) } else { programmed };
        }
    }

    /// The diagnostic at this piece for a group that exceeds the limit.
    pub(super) fn exceeds(&self, group: &PieceGroup, off_mm: f64, limit_mm: f64) -> Option<Diagnostic> {
        let piece = self.piece()?;
        let (why, help) = if piece.motion_mode != MotionMode::Path {
            ("its motion is not part of the path", "feeds of threads, positioning and probing stay as they are")
        } else if self.unit.is_none() {
            ("its feed is a time (G93), which is not changed", "program it with G94, or program longer times")
        } else if group.is_fixed {
            ("its feed is not changed", "check the moves before it, or allow more")
        } else if group.has_given_up() {
            (
                "a lower feed does not help",
                "the acceleration of the axes is too high: lower it on the control, or allow more",
            )
        } else if group.is_lowest() {
            (
                "its feed is already at the lower limit",
                "allow more, or check the velocity gains and feed-forwards in [servo]",
            )
        } else {
            (
                "no feed was found within the maximum number of trials",
                "cut it into shorter pieces with --step, or allow more",
            )
        };
        let message = format!(
            "the tool will be {:.1} µm off its path; {:.1} µm are allowed: {why}",
            off_mm * 1e3,
            limit_mm * 1e3
        );
        let place = Place { file: piece.origin.file, span: piece.origin.span };
        Some(Diagnostic::at(Code::FEED_LIMIT_MISSED, place, message, help))
    }
}

impl PieceGroup {
    /// Creates a group from a piece.
    pub(super) fn of(waiting: &Waiting) -> PieceGroup {
        let programmed = waiting.speed();
        PieceGroup {
            programmed,
            speed: programmed,
            is_fixed: waiting.is_fixed(),
            last: None,
            futile: 0,
            speed_before: programmed,
            too_high: programmed,
            before_next: None,
        }
    }

    /// Adds a piece, before any speed has been changed.
    pub(super) fn take(&mut self, waiting: &Waiting) {
        let speed = waiting.speed().max(self.programmed);
        (self.programmed, self.speed, self.speed_before, self.too_high) = (speed, speed, speed, speed);
    }

    /// Speed limit, mm/min.
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// `true` if lower speeds had no effect.
    pub(super) fn has_given_up(&self) -> bool {
        self.futile > PATIENCE
    }

    fn is_lowest(&self) -> bool {
        self.speed <= self.programmed * LEAST_SHARE
    }

    /// The speed, mm/min, at which the error would meet the limit; `None` if it already does or if the speed has no effect.
    pub(super) fn judge(&mut self, worst: &WorstMoment, limit_mm: f64) -> Option<f64> {
        let before = self.last.replace([worst.off_mm, worst.speed]);
        if worst.off_mm <= limit_mm || self.has_given_up() {
            return None;
        }
        let mut power = 2.0;
        if let Some([off_mm, speed]) = before.filter(|&[off_mm, _]| off_mm > limit_mm) {
            if worst.off_mm > FOLLOWS * off_mm {
                self.futile += 1;
                if self.has_given_up() {
                    self.speed = self.speed_before;
                    return None;
                }
            } else {
                (self.futile, self.speed_before) = (0, self.speed);
                let shown = (worst.off_mm / off_mm).ln() / (worst.speed / speed).ln();
                power = if shown.is_finite() { shown.clamp(1.0, 2.0) } else { 2.0 };
            }
        }
        let share = (AIM * limit_mm / worst.off_mm).powf(1.0 / power);
        Some(worst.speed * share)
    }

    /// Lowers the speed to `speed`, mm/min. Returns `true` if it was higher.
    pub(super) fn lower_to(&mut self, speed: f64) -> bool {
        if self.is_fixed || self.has_given_up() {
            return false;
        }
        let lower = speed.max(LEAST_STEP * self.speed).max(LEAST_SHARE * self.programmed);
        let is_lower = lower < self.speed;
        if is_lower {
            (self.too_high, self.speed) = (self.speed, lower);
        }
        is_lower
    }

    /// Lowers the speed for the following group. Returns `true` if it was higher.
    pub(super) fn lower_for_next(&mut self, speed: f64) -> bool {
        let before = self.speed;
        let is_lower = self.lower_to(speed);
        if is_lower {
            self.before_next.get_or_insert(before);
        }
        is_lower
    }

    /// Restores the speed if lowering it for the following group had no effect.
    pub(super) fn restore(&mut self) {
        if let Some(speed) = self.before_next.take() {
            self.speed = speed;
        }
    }

    /// Raises the speed halfway to the one that was too high, if useful. Returns `true` if it was raised.
    pub(super) fn raise(&mut self, off_mm: f64, limit_mm: f64) -> bool {
        let is_worth = self.speed < self.programmed && self.too_high > WORTH * self.speed && WORTH * off_mm < limit_mm;
        if is_worth {
            self.speed = (self.speed * self.too_high).sqrt();
        }
        is_worth
    }

    /// Reverts a raise.
    pub(super) fn take_back(&mut self, speed: f64) {
        if self.speed > speed {
            (self.too_high, self.speed) = (self.speed, speed);
        }
    }
}

/// Rounds down to two significant digits, for a readable feed.
fn two_digits(value: f64) -> f64 {
    if value.is_nan() || value <= 0.0 {
        return 0.0;
    }
    let step = 10_f64.powi(value.log10().floor() as i32 - 1);
    let digits = (value / step + 1e-9).floor();
    // Division by a whole number gives the double nearest to the decimal text.
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
