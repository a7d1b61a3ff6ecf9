//! The error of the tool tip along the path, before and after the correction, gathered while the program streams by.
//!
//! Samples lie between the ends of the pieces, one about every `sample_mm` of the way: long pieces have several, short ones share one. So
//! means are over the way, however it is divided. "Before" is the programmed command on the error model with the programmed sense of motion,
//! "after" the emitted command, rounding included; both are measured from the nominal tip at the same parameter of the move. For the maximum
//! behind the correction the middle of every piece counts.

use ncfix_base::geometry::AxisVector;
use ncfix_machine::snc::Origin;

/// Mean, RMS and maximum of distances, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Number of samples.
    pub samples: u64,
    sum_mm: f64,
    square_sum_mm2: f64,
    /// Largest, mm.
    pub max_mm: f64,
}

impl Spread {
    /// Adds a distance, mm.
    pub fn add(&mut self, distance_mm: f64) {
        self.samples += 1;
        self.sum_mm += distance_mm;
        self.square_sum_mm2 += distance_mm * distance_mm;
        self.max_mm = self.max_mm.max(distance_mm);
    }

    /// Mean, mm; 0 without samples.
    #[must_use]
    pub fn mean_mm(&self) -> f64 {
        if self.samples == 0 { 0.0 } else { self.sum_mm / self.samples as f64 }
    }

    /// Root of the mean square, mm; 0 without samples.
    #[must_use]
    pub fn rms_mm(&self) -> f64 {
        if self.samples == 0 { 0.0 } else { (self.square_sum_mm2 / self.samples as f64).sqrt() }
    }
}

/// What a correction does to the error along the path.
///
/// Only moves with feed count, or all of them in a program that has none. Left out are moves made while an axis that the program has
/// moved before is at an unknown place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Prediction {
    feed: SpreadPair,
    rapid: SpreadPair,
    /// Largest correction of each axis by size: mm, rad.
    pub max_correction: AxisVector,
    /// Moves of the program.
    pub moves: u64,
    /// Pieces that they became.
    pub pieces: u64,
    /// Rapid moves that stay as programmed.
    pub as_programmed: u64,
    /// How far the tool is off at the ends of rapid moves that are no approach to a cut, mm: nothing is cut there.
    pub off_cut_mm: f64,
    /// Way behind the last sample, mm.
    unsampled_mm: f64,
}

/// Spreads before and after.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SpreadPair {
    pub(super) before: Spread,
    pub(super) after: Spread,
    pub(super) max_at: Option<Origin>,
}

impl SpreadPair {
    pub(super) fn add(&mut self, before_mm: f64, after_mm: f64, origin: &Origin) {
        self.before.add(before_mm);
        if self.max_at.is_none() || after_mm > self.after.max_mm {
            self.max_at = Some(*origin);
        }
        self.after.add(after_mm);
    }
}

/// Below this a correction is the noise of the arithmetic, mm or rad.
const NOISE: f64 = 1e-9;

impl Prediction {
    /// Error of the program as it was written.
    #[must_use]
    pub fn before(&self) -> &Spread {
        &self.counted().before
    }

    /// Error of the emitted program.
    #[must_use]
    pub fn after(&self) -> &Spread {
        &self.counted().after
    }

    /// Where the largest error of the emitted program lies.
    #[must_use]
    pub fn max_at(&self) -> Option<Origin> {
        self.counted().max_at
    }

    /// Whether samples of such a move still count.
    pub(super) fn wants(&self, rapid: bool) -> bool {
        !rapid || self.feed.before.samples == 0
    }

    pub(super) fn add(&mut self, rapid: bool, before_mm: f64, after_mm: f64, origin: &Origin) {
        let pair = if rapid { &mut self.rapid } else { &mut self.feed };
        pair.add(before_mm, after_mm, origin);
    }

    /// Whether a piece of a size (mm) needs no sample of its own, being near the last one.
    pub(super) fn passes(&mut self, rapid: bool, size_mm: f64, sample_mm: f64) -> bool {
        let pair = if rapid { &self.rapid } else { &self.feed };
        self.unsampled_mm += size_mm;
        let passes = pair.before.samples > 0 && self.unsampled_mm < sample_mm;
        if !passes {
            self.unsampled_mm = 0.0;
        }
        passes
    }

    /// A deviation that counts for the maximum alone.
    pub(super) fn note_after(&mut self, rapid: bool, after_mm: f64, origin: &Origin) {
        let pair = if rapid { &mut self.rapid } else { &mut self.feed };
        if after_mm > pair.after.max_mm {
            pair.after.max_mm = after_mm;
            pair.max_at = Some(*origin);
        }
    }

    /// A rapid move that is no approach to a cut.
    pub(super) fn note_as_programmed(&mut self, error_mm: f64, is_programmed: bool) {
        self.as_programmed += u64::from(is_programmed);
        self.off_cut_mm = self.off_cut_mm.max(error_mm);
    }

    pub(super) fn note_correction(&mut self, nominal: &AxisVector, command: &AxisVector) {
        for (slot, largest) in self.max_correction.0.iter_mut().enumerate() {
            let correction = (command.0[slot] - nominal.0[slot]).abs();
            if correction > NOISE {
                *largest = largest.max(correction);
            }
        }
    }

    pub(super) fn counted(&self) -> &SpreadPair {
        if self.feed.before.samples > 0 { &self.feed } else { &self.rapid }
    }
}

/// More samples than this in one piece tell nothing new; it bounds the time that a long rapid move takes.
const MOST_SAMPLES: f64 = 256.0;

/// The number of samples of a piece of a size, mm.
pub(super) fn sample_count(size_mm: f64, sample_mm: f64) -> u32 {
    // The conversion is exact for whole numbers up to 256; what is no number becomes 0.
    ((size_mm / sample_mm).ceil().min(MOST_SAMPLES) as u32).max(1)
}

/// Place of sample `k` of `count` in a piece, 0 … 1: one in each of `count` equal parts, but not at the same place of each, so that
/// an error with a period near the distance of the samples is seen. The golden section spreads the places most evenly.
pub(super) fn sample_place(k: u32, count: u32) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    (f64::from(k) + (0.5 + GOLDEN * f64::from(k)).fract()) / f64::from(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_is_mean_rms_and_maximum() {
        let mut spread = Spread::default();
        assert_eq!((spread.mean_mm(), spread.rms_mm()), (0.0, 0.0));
        [3.0, 4.0, 5.0].into_iter().for_each(|distance| spread.add(distance));
        assert_eq!(spread.mean_mm(), 4.0);
        assert!((spread.rms_mm() - (50.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(spread.max_mm, 5.0);
    }

    #[test]
    fn rapid_moves_count_only_where_there_is_nothing_else() {
        let mut prediction = Prediction::default();
        let place = |line| Origin { line, ..Origin::default() };
        prediction.add(true, 8.0, 7.0, &place(1));
        assert_eq!((prediction.before().max_mm, prediction.max_at()), (8.0, Some(place(1))));
        assert!(prediction.wants(true));
        prediction.add(false, 2.0, 1.0, &place(2));
        prediction.add(false, 2.0, 0.5, &place(3));
        assert!(!prediction.wants(true));
        assert_eq!((prediction.after().max_mm, prediction.max_at()), (1.0, Some(place(2))));
    }

    #[test]
    fn every_piece_has_a_sample_and_none_has_too_many() {
        assert_eq!(sample_count(0.0, 1.0), 1);
        assert_eq!(sample_count(2.5, 1.0), 3);
        assert_eq!(sample_count(1e9, 1.0), 256);
        assert_eq!(sample_count(0.0, 0.0), 256);
    }
}
