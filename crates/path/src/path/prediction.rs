//! The error of the tool tip along the path, before and after the correction, collected from the stream.
//!
//! Samples lie at stations along the programmed path, about one per mm, whatever its division into moves and pieces. "Before" is the programmed command on
//! the error model with the programmed direction of motion. "After" is the emitted command with rounding. Both are measured from the nominal tip at one
//! parameter of the move. The maximum after the correction includes the end and the middle of every piece.

use ncfix_base::geometry::AxisVector;
use ncfix_machine::snc::Origin;
use ncfix_model::Off;

use super::poses::{ErrorPlace, Thinned};
use super::repeated_blocks::RepeatedBlocks;

/// Mean, RMS and maximum of distances, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Number of samples.
    pub samples: u64,
    sum_mm: f64,
    square_sum_mm2: f64,
    /// Largest, mm.
    pub max_mm: f64,
    /// The same figures with each body of unknown side where the tip is nearest to its place.
    nearest: NearestSpread,
    /// Largest magnitude along X, Y and Z, with each body on the side of its dead band that is worst, mm; 0 where only distances were added.
    pub axes_mm: [f64; 3],
}

/// Sums of the smallest distances that the bodies of unknown side allow, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct NearestSpread {
    sum_mm: f64,
    square_sum_mm2: f64,
    max_mm: f64,
}

impl NearestSpread {
    const NONE: NearestSpread = NearestSpread { sum_mm: 0.0, square_sum_mm2: 0.0, max_mm: 0.0 };
}

impl Spread {
    /// Without samples.
    pub const NONE: Spread = Spread {
        samples: 0,
        sum_mm: 0.0,
        square_sum_mm2: 0.0,
        max_mm: 0.0,
        nearest: NearestSpread::NONE,
        axes_mm: [0.0; 3],
    };

    /// Adds a distance, mm.
    pub fn add(&mut self, distance_mm: f64) {
        self.add_between([distance_mm; 2]);
    }

    /// Adds a distance that is between two values, because the side of a body in its dead band is unknown, mm. The figures are those of the larger one.
    pub fn add_between(&mut self, [nearest_mm, most_mm]: [f64; 2]) {
        self.samples += 1;
        self.sum_mm += most_mm;
        self.square_sum_mm2 += most_mm * most_mm;
        self.max_mm = self.max_mm.max(most_mm);
        self.nearest.sum_mm += nearest_mm;
        self.nearest.square_sum_mm2 += nearest_mm * nearest_mm;
        self.nearest.max_mm = self.nearest.max_mm.max(nearest_mm);
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

    /// Mean, root mean square and maximum of the smallest distances that the bodies of unknown side allow, mm; 0 without samples.
    #[must_use]
    pub fn nearest_mm(&self) -> [f64; 3] {
        let NearestSpread { sum_mm, square_sum_mm2, max_mm } = self.nearest;
        let count = f64::max(self.samples as f64, 1.0);
        [sum_mm / count, (square_sum_mm2 / count).sqrt(), max_mm]
    }
}

/// The effect of a correction on the error along the path.
///
/// Only feed moves count, or all moves in a program without feed moves. Moves are left out while an axis that the program moved before is at an
/// unknown position.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prediction {
    feed: SpreadPair,
    rapid: SpreadPair,
    /// Places of feed moves and of rapid moves.
    places: [PlacesOfMoves; 2],
    /// Largest correction of each axis by magnitude: mm, rad.
    pub max_correction: AxisVector,
    /// Number of moves of the program.
    pub moves: u64,
    /// Number of emitted pieces.
    pub pieces: u64,
    /// Executions of the blocks of the program.
    pub repeated: RepeatedBlocks,
    /// Holes that stay a drilling cycle.
    pub kept_holes: u64,
    /// Largest distance of the tip from the path on the feed moves of these holes, mm.
    pub kept_hole_mm: f64,
    /// Holes of drilling cycles that are written as moves.
    pub expanded_holes: u64,
    /// Largest distance of the tip from the path with which these holes could stay cycles, mm; 0 if they are moves for another reason.
    pub expanded_hole_mm: f64,
    /// Number of rapid moves that stay as programmed.
    pub as_programmed: u64,
    /// Largest tip error at the ends of rapid moves that are not an approach to a cut, mm.
    pub off_cut_mm: f64,
    /// Cutting blocks that are shorter than the block cycle of the control.
    pub short_blocks: ShortBlocks,
    /// Path of the counted feed moves and rapid moves so far, mm.
    path_mm: [f64; 2],
    /// `true` if the next feed move begins after a rapid move, at another place.
    is_apart: bool,
}

/// Cutting blocks that take less time at their feed than the control needs for a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShortBlocks {
    /// Number in the program as written by its author.
    pub source: u64,
    /// Number in the output.
    pub written: u64,
    /// Time of the shortest one in the output, s; 0 without any.
    pub shortest_s: f64,
    /// Source block of the first one that division has made short.
    pub first_divided: Option<Origin>,
}

/// Duration, s, below which a block does not move the tip. Its rotary axes turn about the tip, and their speed determines the time.
const STANDS_S: f64 = 1e-9;

impl ShortBlocks {
    /// Counts a programmed move that takes `duration_s`, for a block cycle, s.
    pub(super) fn note_source(&mut self, duration_s: f64, cycle_s: f64) {
        self.source += u64::from((STANDS_S..cycle_s).contains(&duration_s));
    }

    /// Counts a written piece that takes `duration_s` of a programmed move that takes `whole_s`, for a block cycle, s.
    pub(super) fn note(&mut self, [duration_s, whole_s]: [f64; 2], cycle_s: f64, origin: &Origin) {
        if duration_s >= cycle_s || whole_s < STANDS_S {
            return;
        }
        self.shortest_s = if self.written == 0 { duration_s } else { self.shortest_s.min(duration_s) };
        self.written += 1;
        if whole_s >= cycle_s {
            self.first_divided = self.first_divided.or(Some(*origin));
        }
    }
}

/// Maximum number of places of each kind of moves.
const MOST_PLACES: usize = 192;

/// Places of samples: some of each part of the program, and those of the largest errors before and after.
#[derive(Clone, Debug, Default, PartialEq)]
struct PlacesOfMoves {
    spread: Thinned<ErrorPlace, MOST_PLACES>,
    /// For each [`ErrorSide`], the largest distance and the largest parts along X, Y and Z, mm.
    largest: [[Option<(f64, ErrorPlace)>; 4]; 2],
}

/// Side of the correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ErrorSide {
    /// As programmed.
    Before,
    /// As emitted.
    After,
}

/// Spreads before and after.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SpreadPair {
    pub(super) before: Spread,
    pub(super) after: Spread,
    pub(super) form: Spread,
    pub(super) max_at: Option<Origin>,
}

impl SpreadPair {
    /// Adds an error as programmed, the error as emitted, and the part of the first one beyond the displacement that a touched zero takes up, mm. Each error
    /// has its smallest and its largest value over the unknown sides of bodies.
    pub(super) fn add(&mut self, [before_mm, after_mm]: [[f64; 2]; 2], form_mm: f64, origin: &Origin) {
        self.before.add_between(before_mm);
        self.form.add(form_mm);
        if self.max_at.is_none() || after_mm[1] > self.after.max_mm {
            self.max_at = Some(*origin);
        }
        self.after.add_between(after_mm);
    }
}

/// Corrections below this are rounding noise, mm or rad.
const NOISE: f64 = 1e-9;

impl Prediction {
    /// Error of the program as written.
    #[must_use]
    pub fn before(&self) -> &Spread {
        &self.counted().before
    }

    /// Error of the program as written, beyond the displacement that a zero touched off takes up.
    #[must_use]
    pub fn form(&self) -> &Spread {
        &self.counted().form
    }

    /// Error of the emitted program.
    #[must_use]
    pub fn after(&self) -> &Spread {
        &self.counted().after
    }

    /// Place of the largest error of the emitted program.
    #[must_use]
    pub fn max_at(&self) -> Option<Origin> {
        self.counted().max_at
    }

    /// `true` if samples of such a move still count.
    pub(super) fn wants(&self, rapid: bool) -> bool {
        !rapid || self.feed.before.samples == 0
    }

    /// Adds errors before and after, each the smallest and the largest value, and the form of the first one, mm.
    pub(super) fn add(&mut self, rapid: bool, errors_mm: [[f64; 2]; 2], form_mm: f64, origin: &Origin) {
        let pair = if rapid { &mut self.rapid } else { &mut self.feed };
        pair.add(errors_mm, form_mm, origin);
    }

    /// Offers the place of a station.
    pub(super) fn offer(&mut self, rapid: bool, place: impl FnOnce() -> ErrorPlace) {
        self.places[usize::from(rapid)].spread.offer(place);
    }

    /// Offers a place with its error, which may be the largest: as a distance, or along X, Y or Z. Returns `true` if it is.
    pub(super) fn offer_largest(
        &mut self,
        rapid: bool,
        side: ErrorSide,
        off: &Off,
        place: impl Fn() -> ErrorPlace,
    ) -> bool {
        let [x, y, z]: [f64; 3] = off.nearest.into();
        let mut is_largest = false;
        let pair = if rapid { &mut self.rapid } else { &mut self.feed };
        let spread = if side == ErrorSide::Before { &mut pair.before } else { &mut pair.after };
        spread.axes_mm.iter_mut().zip(&off.most).for_each(|(largest, most)| *largest = largest.max(*most));
        let own = &mut self.places[usize::from(rapid)].largest[side as usize];
        for (largest, error_mm) in own.iter_mut().zip([off.most_mm, x.abs(), y.abs(), z.abs()]) {
            if largest.as_ref().is_none_or(|(known_mm, _)| error_mm > *known_mm) {
                *largest = Some((error_mm, ErrorPlace { is_even: false, ..place() }));
                is_largest = true;
            }
        }
        is_largest
    }

    /// `true` if an emitted place with this distance has the largest one.
    pub(super) fn is_largest_after(&self, rapid: bool, after_mm: f64) -> bool {
        let [of_distance, ..] = &self.places[usize::from(rapid)].largest[ErrorSide::After as usize];
        of_distance.as_ref().is_none_or(|(known_mm, _)| after_mm > *known_mm)
    }

    /// Places of the samples, spread over the program, and then those of the largest errors before and after: as distances, and along X, Y and Z.
    #[must_use]
    pub fn places(&self) -> Vec<ErrorPlace> {
        let own = &self.places[usize::from(self.feed.before.samples == 0)];
        let largest = own.largest.iter().flatten().flatten().map(|(_, place)| *place);
        own.spread.kept().iter().copied().chain(largest).collect()
    }

    /// Parameters of the stations of the current move, of a size in mm, between two others. The first move, and the first cut after a rapid
    /// move, have at least one: a short cut may be the one with the largest error.
    pub(super) fn stations(
        &self,
        rapid: bool,
        size_mm: f64,
        [from, to]: [f64; 2],
    ) -> impl Iterator<Item = f64> + use<> {
        // A longer move has stations of its own, which bounds its time.
        let own_mm = size_mm / MOST_STATIONS;
        let (start_mm, step_mm) =
            if own_mm > STATION_MM { (0.0, own_mm) } else { (self.path_mm[usize::from(rapid)], STATION_MM) };
        let of_part = move |[from, to]: [f64; 2]| {
            let [first, last] = [from, to].map(|parameter| ((start_mm + parameter * size_mm) / step_mm) as u64);
            let parameters = (first..=last).map(move |k| (step_mm * station(k) - start_mm) / size_mm);
            parameters.filter(move |&parameter| from < parameter && parameter <= to)
        };
        let pair = if rapid { &self.rapid } else { &self.feed };
        let is_apart = self.is_apart && !rapid;
        let is_first = (is_apart || pair.before.samples == 0) && of_part([0.0, 1.0]).next().is_none();
        let middle = (is_first && from < 0.5 && 0.5 <= to).then_some(0.5);
        of_part([from, to]).chain(middle)
    }

    /// Ends a counted move of a size, mm.
    pub(super) fn end_move(&mut self, rapid: bool, size_mm: f64) {
        self.path_mm[usize::from(rapid)] += size_mm;
        self.is_apart &= rapid;
    }

    /// Records a rapid move.
    pub(super) fn note_rapid(&mut self) {
        self.is_apart = true;
    }

    /// Records a deviation for the maximum only: its smallest and its largest value over the unknown sides of bodies.
    pub(super) fn note_after(&mut self, rapid: bool, [nearest_mm, after_mm]: [f64; 2], origin: &Origin) {
        let pair = if rapid { &mut self.rapid } else { &mut self.feed };
        pair.after.nearest.max_mm = pair.after.nearest.max_mm.max(nearest_mm);
        if after_mm > pair.after.max_mm {
            pair.after.max_mm = after_mm;
            pair.max_at = Some(*origin);
        }
    }

    /// Records a rapid move that is not an approach to a cut.
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

/// Mean distance of the stations along the path, mm.
const STATION_MM: f64 = 1.0;
/// Maximum number of stations of one move.
const MOST_STATIONS: f64 = 1024.0;
/// The golden section spreads places most evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Place of station `k` on a path, in mean distances: one in each of them. The place varies, so that an error with a period near the distance is detected.
fn station(k: u64) -> f64 {
    let k = k as f64;
    k + (0.5 + GOLDEN * k).fract()
}

/// Place of sample `k` of `count` in a piece, 0 … 1: one in each of `count` equal parts.
pub(super) fn sample_place(k: u32, count: u32) -> f64 {
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
        let [mean, rms, max] = spread.nearest_mm();
        assert_eq!((mean, max), (4.0, 5.0));
        assert!((rms - spread.rms_mm()).abs() < 1e-15);
        // A body of unknown side: between 0 and 8 mm.
        spread.add_between([0.0, 8.0]);
        assert_eq!((spread.mean_mm(), spread.max_mm, spread.nearest_mm()[0]), (5.0, 8.0, 3.0));
        assert_eq!((spread.nearest_mm()[1], spread.nearest_mm()[2]), (12.5_f64.sqrt(), 5.0));
    }

    #[test]
    fn rapid_moves_count_only_where_there_is_nothing_else() {
        let mut prediction = Prediction::default();
        let place = |line| Origin { line, ..Origin::default() };
        prediction.add(true, [[8.0; 2], [7.0; 2]], 8.0, &place(1));
        assert_eq!((prediction.before().max_mm, prediction.max_at()), (8.0, Some(place(1))));
        assert!(prediction.wants(true));
        prediction.add(false, [[2.0; 2], [1.0; 2]], 2.0, &place(2));
        prediction.add(false, [[2.0; 2], [0.5; 2]], 2.0, &place(3));
        assert!(!prediction.wants(true));
        assert_eq!((prediction.after().max_mm, prediction.max_at()), (1.0, Some(place(2))));
    }

    #[test]
    fn a_short_cut_after_a_rapid_move_counts() {
        let mut prediction = Prediction::default();
        prediction.add(false, [[1.0; 2]; 2], 1.0, &Origin::default());
        prediction.end_move(false, 2.0);
        // The next station is at 2.736 mm.
        assert_eq!(prediction.stations(false, 0.3, [0.0, 1.0]).count(), 0);
        prediction.note_rapid();
        assert_eq!(prediction.stations(false, 0.3, [0.0, 1.0]).collect::<Vec<_>>(), [0.5]);
        assert_eq!(prediction.stations(true, 0.3, [0.0, 1.0]).count(), 1);
        prediction.end_move(false, 0.3);
        assert_eq!(prediction.stations(false, 0.3, [0.0, 1.0]).count(), 0);
    }

    /// Stations of a move of 10.4 mm after 2 mm of path, in two parts.
    #[test]
    fn stations_do_not_depend_on_the_division() {
        let mut prediction = Prediction::default();
        // A first move of 0.3 mm has no station of its own: the first one is at 0.5 mm.
        assert_eq!(prediction.stations(false, 0.3, [0.0, 1.0]).collect::<Vec<_>>(), [0.5]);
        assert_eq!(prediction.stations(false, 0.3, [0.5, 1.0]).count(), 0);
        prediction.add(false, [[1.0; 2]; 2], 1.0, &Origin::default());
        assert_eq!(prediction.stations(false, 0.3, [0.0, 1.0]).count(), 0);
        prediction.end_move(false, 2.0);
        let whole: Vec<f64> = prediction.stations(false, 10.4, [0.0, 1.0]).collect();
        let parts = [[0.0, 0.37], [0.37, 1.0]].map(|part| prediction.stations(false, 10.4, part).collect::<Vec<_>>());
        assert_eq!(whole, parts.concat());
        // 0.5 + 2 · 0.618 = 1.736: the station of the third millimetre is at 2.736 mm.
        assert!(((whole[0] * 10.4) - 0.736).abs() < 1e-3 && (10..=11).contains(&whole.len()), "{whole:?}");
        assert!(whole.is_sorted() && prediction.stations(false, 0.0, [0.0, 1.0]).count() == 0);
        assert_eq!(prediction.stations(false, 1e7, [0.0, 1.0]).count(), 1024);
    }
}
