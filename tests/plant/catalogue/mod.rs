//! The catalogue of physical causes by number: which bench shows which, and how each is hidden. 60 … 67 are faults of the data.

mod motion;
mod rotary;
mod servo;
mod setup;
mod thermal;

pub(crate) use thermal::follower;

use super::bench::Bench;
use super::effect::{Effect, Stage};
use super::random::Random;

/// Rows that no bench shows, with the reason.
pub(crate) const NOT_SHOWN: [(u8, &str); 6] = [
    (29, "friction shows in currents or in encoder errors of a trace, which no kind of measurement has"),
    (31, "residual vibration behind a corner needs a trace of a corner"),
    (35, "rounded corners of continuous-path control need a trace over the joints of blocks"),
    (55, "lobing of a probe needs single touches with their directions; a probing here is the centre of a ball"),
    (56, "a constant pre-travel only changes the radius of a ball, which a probing here does not have"),
    (59, "an R-test reads three sensors at once, for which there is no kind of measurement"),
];

/// The rows that a bench shows.
pub(crate) fn rows_shown(bench: Bench) -> &'static [u8] {
    match bench {
        Bench::Laser => &[1, 2, 3, 5, 6, 7, 20, 21, 24, 25, 47, 58, 63, 64, 65, 66, 67],
        Bench::OnTheFly => &[1, 20, 27, 33, 34, 67],
        Bench::Ballbar => &[1, 3, 5, 8, 20, 21, 22, 23, 24, 26, 28, 30, 32, 36, 37, 50, 51, 52, 67],
        Bench::Plate => &[1, 2, 5, 6, 7, 8, 20, 24, 25, 48, 49, 54, 62, 63, 66, 67],
        Bench::Drift => &[38, 39, 43, 44, 60, 61, 62, 63, 64, 65, 67],
        Bench::DriftRuns => &[38, 39, 43],
        Bench::Load => &[45, 46],
        Bench::FiveAxis => &[4, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 57],
        Bench::HotCold => &[40, 41, 42, 53, 58, 60, 61],
    }
}

/// From here on rows are faults of the data.
pub(crate) const FIRST_FAULT: u8 = 60;

/// The effect of a row, not scaled yet; `None` where the bench does not show it.
pub(crate) fn effect(row: u8, stage: &Stage<'_>, random: &mut Random) -> Option<Effect> {
    if !rows_shown(stage.bench).contains(&row) {
        return None;
    }
    match row {
        1 | 2 | 3 | 5 | 6 | 7 | 8 | 20 | 21 | 24 | 25 | 45 | 46 | 47 | 48 | 49 => motion::effect(row, stage, random),
        4 | 9..=19 | 57 => rotary::effect(row, random),
        22 | 23 | 26 | 27 | 28 | 30 | 32 | 33 | 34 | 36 | 37 => servo::effect(row, stage, random),
        38..=44 => thermal::effect(row, stage, random),
        50..=54 | 58 => setup::effect(row, stage, random),
        _ => None,
    }
}

/// The pair of direction and axis of the squareness between two linear axes: the error of location of that axis which stands further from
/// F; the other would turn both.
pub(crate) fn square(stage: &Stage<'_>, a: usize, b: usize) -> (usize, usize) {
    let direction = 3 + (3 - a - b);
    for branch in [&stage.machine.table, &stage.machine.tool] {
        let place = |axis: usize| branch.iter().position(|&known| known == axis);
        if let (Some(one), Some(other)) = (place(a), place(b)) {
            return (direction, if one > other { a } else { b });
        }
    }
    (direction, if stage.machine.tool.contains(&b) { b } else { a })
}
