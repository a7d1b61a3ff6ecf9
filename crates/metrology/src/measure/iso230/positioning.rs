//! Accuracy and repeatability of positioning of one axis (ISO 230-2:2014), from readings at targets that are approached in both directions.
//!
//! At every target i, with deviations xᵢⱼ of runs j: mean x̄ᵢ and standard deviation sᵢ (n − 1) of each direction, reversal `Bᵢ = x̄ᵢ↑ − x̄ᵢ↓`.
//!
//! | figure | formula |
//! | --- | --- |
//! | R↑ | `max 4 sᵢ↑` |
//! | R | `max Rᵢ`, `Rᵢ = max(2 sᵢ↑ + 2 sᵢ↓ + ∣Bᵢ∣, 4 sᵢ↑, 4 sᵢ↓)` |
//! | B, B̄ | `max ∣Bᵢ∣`, mean of `Bᵢ` |
//! | M | `max x̄ᵢ − min x̄ᵢ`, `x̄ᵢ = (x̄ᵢ↑ + x̄ᵢ↓)/2` |
//! | E↑, E | `max x̄ᵢ − min x̄ᵢ` of one direction, of both directions |
//! | A↑, A | `max(x̄ᵢ + 2 sᵢ) − min(x̄ᵢ − 2 sᵢ)` of one direction, of both directions |
//!
//! A drift can be removed before ([`super::drift`]).

use std::fmt;

use crate::measure::data::{DataSet, Observation};
use ncfix_base::geometry::Axis;
use ncfix_model::ErrorName;

/// Distance below which targets are equal, mm or rad.
pub(super) const SAME: f64 = 1e-6;

/// A reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ApproachReading {
    /// The commanded position, mm or rad.
    pub target: f64,
    /// Actual minus commanded position, mm or rad (or any other component of the error).
    pub deviation: f64,
    /// `true` if the axis came in the positive direction.
    pub is_up: bool,
    /// Index of its back-and-forth cycle.
    pub cycle: usize,
    /// Time, s, or the index of the reading if readings are equidistant in time.
    pub time: f64,
}

/// Figures of one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneWay {
    /// A↑ or A↓.
    pub accuracy: f64,
    /// E↑ or E↓.
    pub systematic: f64,
    /// R↑ or R↓.
    pub repeatability: f64,
}

/// Figures of both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BothWays {
    /// A.
    pub accuracy: f64,
    /// E.
    pub systematic: f64,
    /// R.
    pub repeatability: f64,
    /// B.
    pub reversal: f64,
    /// B̄, with its sign.
    pub mean_reversal: f64,
    /// M.
    pub mean_systematic: f64,
}

/// One target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositioningTarget {
    /// Its position.
    pub position: f64,
    /// Mean and standard deviation in the positive direction, if any.
    pub up: Option<[f64; 2]>,
    /// Mean and standard deviation in the negative direction, if any.
    pub down: Option<[f64; 2]>,
    /// The smaller number of approaches of the two directions.
    pub runs: usize,
}

/// All figures.
#[derive(Clone, Debug, PartialEq)]
pub struct PositioningFigures {
    /// Of the positive direction.
    pub up: Option<OneWay>,
    /// Of the negative direction.
    pub down: Option<OneWay>,
    /// Of both, if every target was approached in both directions.
    pub both: Option<BothWays>,
    /// By rising position.
    pub targets: Vec<PositioningTarget>,
    /// The smallest number of approaches of a target in one direction; the standard requires five.
    pub runs: usize,
}

/// Reason why there are no figures.
#[derive(Clone, Debug, PartialEq)]
pub enum FiguresError {
    /// There are no readings of the component.
    Nothing,
    /// The direction of approach of a reading is unknown; its target.
    NoSense(f64),
    /// A target was approached only once in a direction, so that there is no scatter.
    Once(f64),
    /// The first target was approached only in the positive, the second only in the negative direction.
    Mixed(f64, f64),
    /// Too few targets or pairs of readings for a drift.
    TooFew,
    /// A reversal error with its standard error: it cannot be separated from a drift.
    Backlash(f64, f64),
}

impl FiguresError {
    /// The reason in words, with the axis of the component and the unit of the target.
    #[must_use]
    pub fn words(&self, axis: Axis) -> String {
        let place = |target: f64| {
            let (value, unit) = if axis.is_rotary() { (target.to_degrees(), "°") } else { (target, " mm") };
            // A target in degrees comes back from radians.
            format!("{axis} {}{unit}", (value * 1e6).round() / 1e6)
        };
        match *self {
            FiguresError::NoSense(target) => {
                format!(
                    "the direction in which {} was approached is not known: give it in the column {axis}_dir",
                    place(target)
                )
            }
            FiguresError::Once(target) => format!(
                "target {} was approached only once in one direction: at least two runs are needed, the standard requires five",
                place(target)
            ),
            FiguresError::Mixed(up, down) => format!(
                "{} was approached in the positive direction only, {} in the negative direction only: approach all targets from one side, or give the directions in the column {axis}_dir",
                place(up),
                place(down)
            ),
            _ => self.to_string(),
        }
    }
}

impl fmt::Display for FiguresError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FiguresError::Nothing => write!(f, "there are no readings of this component"),
            FiguresError::NoSense(target) => {
                write!(f, "the direction in which {target} was approached is not known: give it in the column X_dir …")
            }
            FiguresError::Once(target) => {
                write!(
                    f,
                    "{target} was approached only once in one direction: at least two runs are needed, the standard requires five"
                )
            }
            FiguresError::Mixed(up, down) => {
                write!(
                    f,
                    "{up} was approached in the positive direction only, {down} in the negative direction only: give the directions in the column X_dir …"
                )
            }
            FiguresError::TooFew => {
                write!(f, "too few targets were read in both directions of a cycle: a drift needs three or more")
            }
            FiguresError::Backlash(value, sigma) => write!(
                f,
                "the axis has a reversal value of {value:.6} ± {sigma:.6}, so the two directions differ by more than drift"
            ),
        }
    }
}

/// The figures.
///
/// # Errors
/// [`FiguresError`] if there are no readings, a target was approached only once, or no direction has all targets.
pub fn figures(readings: &[ApproachReading]) -> Result<PositioningFigures, FiguresError> {
    let targets = targets(readings)?;
    let one = |side: fn(&PositioningTarget) -> Option<[f64; 2]>| -> Option<OneWay> {
        let sides: Vec<[f64; 2]> = targets.iter().filter_map(side).collect();
        (sides.len() == targets.len()).then(|| OneWay {
            accuracy: range(sides.iter().flat_map(|&[mean, s]| [mean + 2.0 * s, mean - 2.0 * s])),
            systematic: range(sides.iter().map(|&[mean, _]| mean)),
            repeatability: sides.iter().fold(0.0_f64, |most, &[_, s]| most.max(4.0 * s)),
        })
    };
    let pairs: Vec<[[f64; 2]; 2]> = targets.iter().filter_map(|target| Some([target.up?, target.down?])).collect();
    let both = (pairs.len() == targets.len()).then(|| {
        let sides = || pairs.iter().flatten();
        let reversals = || pairs.iter().map(|[up, down]| up[0] - down[0]);
        let repeat = |[up, down]: &[[f64; 2]; 2]| {
            (2.0 * up[1] + 2.0 * down[1] + (up[0] - down[0]).abs()).max(4.0 * up[1]).max(4.0 * down[1])
        };
        BothWays {
            accuracy: range(sides().flat_map(|&[mean, s]| [mean + 2.0 * s, mean - 2.0 * s])),
            systematic: range(sides().map(|&[mean, _]| mean)),
            repeatability: pairs.iter().map(repeat).fold(0.0, f64::max),
            reversal: reversals().fold(0.0, |most, value| most.max(value.abs())),
            mean_reversal: reversals().sum::<f64>() / pairs.len() as f64,
            mean_systematic: range(pairs.iter().map(|[up, down]| 0.5 * (up[0] + down[0]))),
        }
    });
    let runs = targets.iter().map(|target| target.runs).min().unwrap_or(0);
    let (up, down) = (one(|target| target.up), one(|target| target.down));
    if both.is_none() && up.is_none() && down.is_none() {
        let only_up = targets.iter().find(|target| target.down.is_none());
        let only_down = targets.iter().find(|target| target.up.is_none());
        return Err(only_up
            .zip(only_down)
            .map_or(FiguresError::Nothing, |(up, down)| FiguresError::Mixed(up.position, down.position)));
    }
    Ok(PositioningFigures { up, down, both, targets, runs })
}

/// The readings of a component, in all set-ups or one, and the number of those left out because the direction of their approach is unknown: without a
/// column of directions, this is the first reading of a series. Readings without `t_s` are equidistant in time, and a cycle ends when the axis returns to
/// the direction of its start.
///
/// # Errors
/// [`FiguresError`] if there are no readings, or a target lacks a direction that the others have and its readings may have.
pub fn approaches(
    data: &DataSet,
    component: ErrorName,
    setup: Option<usize>,
) -> Result<(Vec<ApproachReading>, usize), FiguresError> {
    approaches_of(data, component, &|row| setup.is_none_or(|setup| setup == row.setup))
}

/// The readings of a component in some rows, as [`approaches`] returns them.
///
/// # Errors
/// Those of [`approaches`].
pub fn approaches_of(
    data: &DataSet,
    component: ErrorName,
    is_in: &dyn Fn(&Observation) -> bool,
) -> Result<(Vec<ApproachReading>, usize), FiguresError> {
    let axis: Axis = component.axis().ok_or(FiguresError::Nothing)?;
    let mut out: Vec<ApproachReading> = Vec::new();
    let mut left_out: Vec<f64> = Vec::new();
    let mut cycle = 0;
    let own = |row: &&Observation| row.component == Some(component) && is_in(row);
    for observation in data.observations.iter().filter(own) {
        let Some(deviation) = observation.values[0] else { continue };
        let target = observation.reading.position[axis];
        let is_up = match observation.reading.state.direction[axis.slot()] {
            0 => {
                left_out.push(target);
                continue;
            }
            sense => sense > 0,
        };
        if let (Some(first), Some(last)) = (out.first(), out.last())
            && is_up == first.is_up
            && last.is_up != first.is_up
        {
            cycle += 1;
        }
        out.push(ApproachReading {
            target,
            deviation,
            is_up,
            cycle,
            time: observation.t_s.unwrap_or(out.len() as f64),
        });
    }
    // A reading without a direction is left out only where the figures are complete without it.
    let has = |target: f64, is_up: bool| {
        out.iter().any(|reading| reading.is_up == is_up && (reading.target - target).abs() < SAME)
    };
    let is_bidirectional = out.iter().any(|reading| has(reading.target, true) && has(reading.target, false));
    let is_known = |target: f64| match [has(target, true), has(target, false)] {
        [up, down] if is_bidirectional => up && down,
        [up, down] => up || down,
    };
    match left_out.iter().find(|target| !is_known(**target)) {
        Some(&target) => Err(FiguresError::NoSense(target)),
        None if out.is_empty() => Err(FiguresError::Nothing),
        None => Ok((out, left_out.len())),
    }
}

fn targets(readings: &[ApproachReading]) -> Result<Vec<PositioningTarget>, FiguresError> {
    let mut sorted: Vec<&ApproachReading> = readings.iter().collect();
    sorted.sort_by(|one, other| one.target.total_cmp(&other.target));
    if sorted.is_empty() {
        return Err(FiguresError::Nothing);
    }
    let at_one = sorted.chunk_by(|one, other| (one.target - other.target).abs() < SAME);
    at_one
        .map(|own| {
            let position = own.first().map_or(0.0, |reading| reading.target);
            let side = |is_up: bool| -> Result<Option<[f64; 2]>, FiguresError> {
                let values = || own.iter().filter(|reading| reading.is_up == is_up).map(|reading| reading.deviation);
                match values().count() {
                    0 => Ok(None),
                    1 => Err(FiguresError::Once(position)),
                    count => {
                        let mean = values().sum::<f64>() / count as f64;
                        let squares = values().map(|value| (value - mean).powi(2)).sum::<f64>();
                        Ok(Some([mean, (squares / (count - 1) as f64).sqrt()]))
                    }
                }
            };
            let count = |is_up: bool| own.iter().filter(|reading| reading.is_up == is_up).count();
            let runs = [count(true), count(false)].into_iter().filter(|&count| count > 0).min().unwrap_or(0);
            Ok(PositioningTarget { position, up: side(true)?, down: side(false)?, runs })
        })
        .collect()
}

pub(super) fn range(values: impl Iterator<Item = f64>) -> f64 {
    let [low, high] =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    (high - low).max(0.0)
}
