//! The summary of all rows.

use super::{ReviewRow, moves, size, without_noise};
use ncfix_base::geometry::{AXES, Axis};

/// A place in both programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReviewPlace {
    /// Number of the file of the original, and its line.
    pub original: (u16, u32),
    /// Line of the corrected program.
    pub corrected: u32,
}

impl From<&ReviewRow> for ReviewPlace {
    fn from(row: &ReviewRow) -> ReviewPlace {
        ReviewPlace { original: (row.file, row.line), corrected: row.corrected_line }
    }
}

/// Statistics of the corrections added to the commands of an axis; mm or rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisFigures {
    /// The axis.
    pub axis: Axis,
    /// The value of largest magnitude, with its sign.
    pub max: f64,
    /// Place of the largest value.
    pub max_at: ReviewPlace,
    /// Signed mean.
    pub mean: f64,
    /// Root of the mean square.
    pub rms: f64,
    /// The 99th percentile of the magnitudes.
    pub p99: f64,
}

/// Counts of uncorrected moves, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UncorrectedMoves {
    /// The error of the machine there is below an increment.
    pub no_error: u64,
    /// The program has not stated the position of the axes.
    pub unstated: u64,
    /// Rapid moves.
    pub rapid: u64,
    /// Others: reference points, threads, moves that the writer cannot change.
    pub other: u64,
}

/// Summary of a comparison.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Executed moves of the original.
    pub moves: u64,
    /// Pieces of the corrected program.
    pub pieces: u64,
    /// Moves with at least one changed piece.
    pub changed: u64,
    /// Moves of more than one piece.
    pub split: u64,
    /// Unchanged moves.
    pub left: UncorrectedMoves,
    /// Pieces whose feed differs from that of their move.
    pub other_feeds: u64,
    /// Statistics of the axes with changes.
    pub axes: Vec<AxisFigures>,
    /// The largest difference between the corrections of two neighbors, mm (rad at an arm of 1 m), and the place of the second one.
    pub largest_step: Option<(f64, ReviewPlace)>,
}

impl Summary {
    /// Summarizes rows. Changes up to the tolerances, mm and rad, count as equal; `increment_mm` is the finest increment of the control.
    #[must_use]
    pub fn of(rows: &[ReviewRow], axes: &[Axis], tolerance: [f64; 2], increment_mm: f64) -> Summary {
        let is_changed =
            |row: &ReviewRow| axes.iter().any(|&axis| row.added(axis).abs() > tolerance[usize::from(axis.is_rotary())]);
        let mut out = Summary { pieces: rows.len() as u64, ..Summary::default() };
        for own in moves(rows) {
            out.moves += 1;
            out.split += u64::from(own.iter().filter(|row| !row.is_on_the_spot()).count() > 1);
            if own.iter().any(is_changed) {
                out.changed += 1;
                continue;
            }
            let left = &mut out.left;
            let error_mm = own.iter().map(|row| row.error_mm).fold(0.0, f32::max);
            let reason = if f64::from(error_mm) < increment_mm {
                &mut left.no_error
            } else if own.iter().any(|row| !row.is_stated()) {
                &mut left.unstated
            } else if own.iter().all(ReviewRow::is_rapid) {
                &mut left.rapid
            } else {
                &mut left.other
            };
            *reason += 1;
        }
        out.other_feeds = rows.iter().filter(|row| row.has_other_feed()).count() as u64;
        out.axes = AXES.into_iter().filter(|axis| axes.contains(axis)).filter_map(|axis| figures(rows, axis)).collect();
        for pair in rows.windows(2) {
            let step = |&axis: &Axis| size(axis, pair[1].added(axis) - pair[0].added(axis));
            let step = axes.iter().map(step).fold(0.0, f64::max);
            if step > out.largest_step.map_or(0.0, |(largest, _)| largest) {
                out.largest_step = Some((step, (&pair[1]).into()));
            }
        }
        out
    }
}

/// The statistics of an axis; `None` if nothing was added to it.
fn figures(rows: &[ReviewRow], axis: Axis) -> Option<AxisFigures> {
    // The first of equal maxima.
    let size = |row: &ReviewRow| row.added(axis).abs();
    let most = rows.iter().reduce(|most, row| if size(row) > size(most) { row } else { most })?;
    let max = most.added(axis);
    if max == 0.0 {
        return None;
    }
    let count = rows.len() as f64;
    let (mut sum, mut squares) = (0.0, 0.0);
    for value in rows.iter().map(|row| row.added(axis)) {
        sum += value;
        squares += value * value;
    }
    let mut sizes: Vec<f32> = rows.iter().map(|row| row.added[axis.slot()].abs()).collect();
    // The smallest magnitude that 99 of 100 do not exceed.
    let place = (0.99 * count).ceil() as usize;
    let (_, p99, _) = sizes.select_nth_unstable_by(place.clamp(1, rows.len()) - 1, f32::total_cmp);
    let p99 = without_noise(*p99);
    Some(AxisFigures { axis, max, max_at: most.into(), mean: sum / count, rms: (squares / count).sqrt(), p99 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::AXIS_COUNT;

    fn row(line: u32, first: bool, x_um: f32) -> ReviewRow {
        let mut added = [0.0; AXIS_COUNT];
        added[Axis::X.slot()] = x_um / 1e3;
        let flags = if first { ReviewRow::FIRST } else { 0 };
        ReviewRow { file: 0, line, corrected_line: 10 * line, added, error_mm: 0.02, flags }
    }

    #[test]
    fn figures_are_those_of_hand_arithmetic() {
        let rows = [row(1, true, 3.0), row(2, true, -5.0), row(2, false, 1.0), row(3, true, 0.0)];
        let found = Summary::of(&rows, &[Axis::X, Axis::Y], [0.0; 2], 1e-3);
        assert_eq!((found.moves, found.pieces, found.changed, found.split, found.left.other), (3, 4, 2, 1, 1));
        let [x] = &found.axes[..] else { panic!("{found:?}") };
        // Mean (3 − 5 + 1 + 0)/4, RMS √((9 + 25 + 1)/4).
        for (value, um) in [(x.max, -5.0), (x.mean, -0.25), (x.rms, (35.0_f64 / 4.0).sqrt()), (x.p99, 5.0)] {
            assert!((1e3 * value - um).abs() < 1e-5, "{value} {um}");
        }
        assert_eq!((x.max_at.original.1, x.max_at.corrected), (2, 20));
        let (step, at) = found.largest_step.unwrap();
        assert!((step - 8e-3).abs() < 1e-8 && at.original.1 == 2);
        // Of 200 values, 1 to 200 µm, 198 values are at most 198 µm.
        let many: Vec<ReviewRow> = (1_u8..=200).map(|k| row(u32::from(k), true, f32::from(k))).collect();
        let found = Summary::of(&many, &[Axis::X], [0.0; 2], 1e-3);
        assert!((found.axes[0].p99 - 0.198).abs() < 1e-7);
        // With a tolerance of 10 µm the first ten count as equal.
        assert_eq!(Summary::of(&many, &[Axis::X], [0.01; 2], 1e-3).changed, 190);
    }
}
