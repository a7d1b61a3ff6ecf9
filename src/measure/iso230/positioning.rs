//! Accuracy and repeatability of positioning of one axis (ISO 230-2:2014), from readings at targets that are approached in both senses.
//!
//! At every target i, with deviations xᵢⱼ of runs j: mean x̄ᵢ and standard deviation sᵢ (n − 1) of each sense, reversal `Bᵢ = x̄ᵢ↑ − x̄ᵢ↓`.
//!
//! | figure | formula |
//! | --- | --- |
//! | R↑ | `max 4 sᵢ↑` |
//! | R | `max Rᵢ`, `Rᵢ = max(2 sᵢ↑ + 2 sᵢ↓ + ∣Bᵢ∣, 4 sᵢ↑, 4 sᵢ↓)` |
//! | B, B̄ | `max ∣Bᵢ∣`, mean of `Bᵢ` |
//! | M | `max x̄ᵢ − min x̄ᵢ`, `x̄ᵢ = (x̄ᵢ↑ + x̄ᵢ↓)/2` |
//! | E↑, E | `max x̄ᵢ − min x̄ᵢ` of one sense, of both senses |
//! | A↑, A | `max(x̄ᵢ + 2 sᵢ) − min(x̄ᵢ − 2 sᵢ)` of one sense, of both senses |
//!
//! [`without_drift`] takes a linear drift in time out of every back-and-forth cycle (Spaan 1995, ch. 3). At one target the way back differs from
//! the way out by drift × time and by the reversal; only where there is no reversal is the difference the drift alone, which is why an axis
//! with backlash is refused. Both are told apart by the time between the two: next to the turn it is short, at the begin of the cycle long.

use std::fmt;

use crate::geometry::Axis;
use crate::measure::data::DataSet;
use crate::model::ErrorName;

/// Targets closer than this are one, mm or rad.
const SAME: f64 = 1e-6;
/// Standard errors from which a reversal is one.
const SIGNIFICANT: f64 = 3.0;
/// A reversal below this share of the range of the readings harms no drift, however well it is known.
const HARMLESS: f64 = 0.01;

/// A reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// The commanded position, mm or rad.
    pub target: f64,
    /// Actual less commanded position, mm or rad (or any other component of the error).
    pub deviation: f64,
    /// Whether the axis came in the positive sense.
    pub is_up: bool,
    /// Number of its back-and-forth cycle.
    pub cycle: usize,
    /// When: s, or the number of the reading where readings are evenly spaced.
    pub time: f64,
}

/// Figures of one sense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneWay {
    /// A↑ or A↓.
    pub accuracy: f64,
    /// E↑ or E↓.
    pub systematic: f64,
    /// R↑ or R↓.
    pub repeatability: f64,
}

/// Figures of both senses.
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
pub struct Target {
    /// Its position.
    pub position: f64,
    /// Mean and standard deviation of the positive sense, where there is one.
    pub up: Option<[f64; 2]>,
    /// The same of the negative sense.
    pub down: Option<[f64; 2]>,
}

/// All figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// Of the positive sense.
    pub up: Option<OneWay>,
    /// Of the negative sense.
    pub down: Option<OneWay>,
    /// Of both, where every target was approached in both.
    pub both: Option<BothWays>,
    /// By rising position.
    pub targets: Vec<Target>,
    /// The smallest number of approaches of a target in one sense; the standard asks for five.
    pub runs: usize,
}

/// Why there are no figures.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// There are no readings of the component.
    Nothing,
    /// The sense of approach of a reading is not known; its target.
    NoSense(f64),
    /// A target was approached once only in a sense, so that there is no scatter.
    Once(f64),
    /// Too few targets or pairs of readings for a drift.
    TooFew,
    /// A reversal with its standard error: it cannot be told from a drift.
    Backlash(f64, f64),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::Nothing => write!(f, "there are no readings of this component"),
            Fault::NoSense(target) => write!(
                f,
                "the sense in which {target} was approached is not known: give it in the column of the sense (X_dir …)"
            ),
            Fault::Once(target) => {
                write!(
                    f,
                    "{target} was approached only once in a sense: at least two runs are needed, the standard asks for five"
                )
            }
            Fault::TooFew => write!(
                f,
                "too few targets were read on the way out and on the way back of a cycle: a drift needs three or more"
            ),
            Fault::Backlash(value, sigma) => write!(
                f,
                "the axis has a backlash of {value:.6} ± {sigma:.6}, so that way out and way back differ by more than drift"
            ),
        }
    }
}

/// The figures.
///
/// # Errors
/// [`Fault`] where there is nothing, or a target was approached once only.
pub fn figures(readings: &[Approach]) -> Result<Figures, Fault> {
    let targets = targets(readings)?;
    let one = |side: fn(&Target) -> Option<[f64; 2]>| -> Option<OneWay> {
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
    let mut runs = usize::MAX;
    for target in &targets {
        for is_up in [true, false] {
            let count = at(readings, target.position, is_up).count();
            if count > 0 {
                runs = runs.min(count);
            }
        }
    }
    Ok(Figures { up: one(|target| target.up), down: one(|target| target.down), both, targets, runs })
}

/// The readings without a drift that is linear in time within every cycle; cycles are brought to the mean of all.
///
/// # Errors
/// [`Fault::Backlash`] where the two ways differ by a reversal, [`Fault::TooFew`] where they cannot be compared.
pub fn without_drift(readings: &[Approach]) -> Result<Vec<Approach>, Fault> {
    let cycles = readings.iter().map(|reading| reading.cycle).max().ok_or(Fault::Nothing)?.saturating_add(1);
    if cycles > readings.len() {
        return Err(Fault::TooFew);
    }
    // Of every cycle the time between the ways and the difference of what was read.
    let mut pairs: Vec<Vec<[f64; 2]>> = vec![Vec::new(); cycles];
    for up in readings.iter().filter(|reading| reading.is_up) {
        let is_other =
            |other: &&Approach| !other.is_up && other.cycle == up.cycle && (other.target - up.target).abs() < SAME;
        for down in readings.iter().filter(is_other) {
            let pair = [up.time - down.time, up.deviation - down.deviation];
            pairs.get_mut(up.cycle).into_iter().for_each(|own| own.push(pair));
        }
    }
    if pairs.iter().any(|own| own.len() < 3) {
        return Err(Fault::TooFew);
    }
    let (reversal, sigma) = reversal(&pairs).ok_or(Fault::TooFew)?;
    let spread = range(readings.iter().map(|reading| reading.deviation));
    if reversal.abs() > SIGNIFICANT * sigma && reversal.abs() > HARMLESS * spread {
        return Err(Fault::Backlash(reversal, sigma));
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let level = mean(&readings.iter().map(|reading| reading.deviation).collect::<Vec<_>>());
    let mut out = readings.to_vec();
    for (cycle, own) in pairs.iter().enumerate() {
        let slope = sum(own, |[time, difference]| time * difference) / sum(own, |[time, _]| time * time);
        let members: Vec<&Approach> = readings.iter().filter(|reading| reading.cycle == cycle).collect();
        let time = mean(&members.iter().map(|reading| reading.time).collect::<Vec<_>>());
        let deviation = mean(&members.iter().map(|reading| reading.deviation).collect::<Vec<_>>());
        for reading in out.iter_mut().filter(|reading| reading.cycle == cycle) {
            reading.deviation += level - deviation - slope * (reading.time - time);
        }
    }
    Ok(out)
}

/// What was read of a component; readings are evenly spaced in time, and a cycle ends where the axis comes back to the sense of its begin.
///
/// # Errors
/// [`Fault`] where there are no readings or their sense is not known.
pub fn approaches(data: &DataSet, component: ErrorName) -> Result<Vec<Approach>, Fault> {
    let axis: Axis = component.axis().ok_or(Fault::Nothing)?;
    let mut out: Vec<Approach> = Vec::new();
    let mut cycle = 0;
    for observation in data.observations.iter().filter(|observation| observation.component == Some(component)) {
        let Some(deviation) = observation.values[0] else { continue };
        let target = observation.reading.position[axis];
        let is_up = match observation.reading.state.direction[axis.slot()] {
            0 => return Err(Fault::NoSense(target)),
            sense => sense > 0,
        };
        if let (Some(first), Some(last)) = (out.first(), out.last())
            && is_up == first.is_up
            && last.is_up != first.is_up
        {
            cycle += 1;
        }
        out.push(Approach { target, deviation, is_up, cycle, time: out.len() as f64 });
    }
    if out.is_empty() { Err(Fault::Nothing) } else { Ok(out) }
}

fn targets(readings: &[Approach]) -> Result<Vec<Target>, Fault> {
    let mut positions: Vec<f64> = readings.iter().map(|reading| reading.target).collect();
    positions.sort_by(f64::total_cmp);
    positions.dedup_by(|one, other| (*one - *other).abs() < SAME);
    if positions.is_empty() {
        return Err(Fault::Nothing);
    }
    let side = |position: f64, is_up: bool| -> Result<Option<[f64; 2]>, Fault> {
        let count = at(readings, position, is_up).count();
        match count {
            0 => Ok(None),
            1 => Err(Fault::Once(position)),
            _ => {
                let mean = at(readings, position, is_up).sum::<f64>() / count as f64;
                let squares = at(readings, position, is_up).map(|value| (value - mean).powi(2)).sum::<f64>();
                Ok(Some([mean, (squares / (count - 1) as f64).sqrt()]))
            }
        }
    };
    positions
        .into_iter()
        .map(|position| Ok(Target { position, up: side(position, true)?, down: side(position, false)? }))
        .collect()
}

/// Deviations at a target in one sense.
fn at(readings: &[Approach], position: f64, is_up: bool) -> impl Iterator<Item = f64> {
    let here = move |reading: &&Approach| reading.is_up == is_up && (reading.target - position).abs() < SAME;
    readings.iter().filter(here).map(|reading| reading.deviation)
}

/// The reversal that all cycles have in common, beside a drift of their own each, and its standard error.
fn reversal(pairs: &[Vec<[f64; 2]>]) -> Option<(f64, f64)> {
    let (mut factor, mut value, mut squares, mut count) = (0.0, 0.0, 0.0, 0.0);
    for own in pairs {
        let (tt, t, td) = (sum(own, |[t, _]| t * t), sum(own, |[t, _]| t), sum(own, |[t, d]| t * d));
        let n = own.len() as f64;
        // The drift of the cycle is swept out.
        factor += n - t * t / tt;
        value += sum(own, |[_, d]| d) - t * td / tt;
        squares += sum(own, |[_, d]| d * d) - td * td / tt;
        count += n - 1.0;
    }
    if !(factor > 1e-9 && count > 1.0) {
        return None;
    }
    let reversal = value / factor;
    let left = (squares - reversal * value).max(0.0);
    Some((reversal, (left / (count - 1.0) / factor).sqrt()))
}

fn sum(pairs: &[[f64; 2]], term: impl Fn([f64; 2]) -> f64) -> f64 {
    pairs.iter().map(|&pair| term(pair)).sum()
}

fn range(values: impl Iterator<Item = f64>) -> f64 {
    let [low, high] =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    (high - low).max(0.0)
}
