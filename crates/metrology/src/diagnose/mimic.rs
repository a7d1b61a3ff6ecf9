//! Waves that are aliases of a finding at the measured places: other periods of a wave, and short waves that look like a smooth shape.
//!
//! At places one step apart, a wave of frequency ν equals one of |ν − k/step|. With steps of 50 mm, a period of 16 mm (3.125 cycles per step) advances by an
//! eighth of a cycle. A polynomial fits these values, but differs between the places. A usual screw pitch that explains the readings as well is an alias of a
//! smooth shape. For a shape with many coefficients, any wave that explains the readings better with fewer coefficients is one. A shape with more
//! coefficients than a wave with a slope may be both: the pitch of a screw on an axis that has a scale error.

use super::cause::{Candidate, EffectKind, Weight, motion, own, periodic};
use super::doubt::ExtrapolationRisk;
use super::refine::PEAK;
use super::scene::Through;
use super::search::{Field, Weights};
use super::seek::information_of;
use super::separate::steps;
use super::size::weights_at;
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::numeric::sums::dot;
use ncfix_model::motion::EntryFunction;
use ncfix_model::name::{DIRECTIONS, ErrorName};

/// Pitches of ball screws, mm (ISO 3408-2), the coarsest first.
const PITCHES: [f64; 11] = [40.0, 32.0, 25.0, 20.0, 16.0, 12.0, 10.0, 8.0, 6.0, 5.0, 4.0];
/// An alias explains nearly as much: the difference of χ² is at most this.
pub(super) const RIVAL: f64 = 6.0;
/// Largest p-value of a wave against the systematic deviations of single places.
const BY_CHANCE: f64 = 0.01;
/// Assumed period if it is not known, mm.
const MOST_PERIOD: f64 = 40.0;
/// Peaks that explain at least this share of the best are fitted fully.
const ALIAS: f64 = 0.8;
/// An amplitude beyond this multiple of the range of the shape is ignored: if a wave has nearly the same value at all places, its amplitude is not
/// determined.
const LARGER: f64 = 2.0;
/// Smallest number of coefficients of a shape at which a slow wave (sine, cosine, period) is no more complex than the shape.
const MANY: usize = 3;
/// Cycles over the travel of these waves: range and step.
const SLOW: [f64; 2] = [0.5, 3.0];
const STEP: f64 = 0.1;
/// Number of coefficients from which a shape is a table of its own values, and the largest number of cycles that are tried.
const TABLE: usize = 6;
const MOST_CYCLES: f64 = 500.0;
/// Amounts of a wave: sine and cosine.
const WAVE: usize = 2;
/// A sine or cosine is zero at the measured places if the sum of its squares is less than this share of that of the other one.
const SHOWS: f64 = 1e-12;
/// Steps are even if they differ by at most this share of a step.
const EVEN: f64 = 0.02;

impl Field<'_, '_> {
    /// Usual periods along an axis, mm: those of the machine file and pitches of screws.
    pub(super) fn pitches(&self, axis: Axis) -> impl Iterator<Item = f64> {
        let of_file = self.scene.errors.motion.iter().filter(move |error| error.name.axis() == Some(axis));
        let of_file = of_file.filter_map(|error| match &error.function {
            EntryFunction::Periodic(own) => Some(own.period),
            _ => None,
        });
        of_file.chain(PITCHES)
    }

    /// Returns other periods that explain the readings as well as a candidate, in addition to the other terms.
    pub(super) fn aliases(
        &self,
        weights: &Weights,
        number: usize,
        others: &[usize],
        (memory, noise): (f64, f64),
    ) -> Vec<f64> {
        let series = self.series(weights, others, memory);
        let found =
            self.candidates.get(number).filter(|one| one.cause.effect == EffectKind::Periodic).and_then(|one| {
                let (Through::Component(name), _) = *one.columns.first()?.first()? else { return None };
                let axis = name.axis()?;
                let sweep = self.seek.sweep(axis)?;
                let (period, _) = one.constant?;
                let own = series.gain(&self.columns(one)).squares;
                let information = information_of(&self.factors, Through::Component(name), &weights.items);
                let left = series.unwhitened(series.left());
                let products: Vec<f64> =
                    self.factors.get(&Through::Component(name))?.iter().zip(&left).map(|(a, b)| a * b).collect();
                let is_other = |other: &f64| (sweep.travel() / other - sweep.travel() / period).abs() > 2.0 * PEAK;
                let is_rival = |other: &f64| {
                    let near = self.period_near(&series, name, axis, *other);
                    let near = near.unwrap_or_else(|| periodic::candidate(name, axis, *other));
                    (own - series.gain(&self.columns(&near)).squares) / noise < RIVAL
                };
                let all = sweep.peaks(&products, &information, ALIAS).into_iter();
                Some(all.filter(is_other).filter(is_rival).collect::<Vec<f64>>())
            });
        let mut found = found.unwrap_or_default();
        found.sort_by(|a, b| b.total_cmp(a));
        found
    }

    /// Returns the extrapolation risk of a wave through a few places: among all tested waves, one can fit the deviations of the places by chance.
    pub(super) fn wave_doubt(&self, weights: &Weights, taken: &[usize], number: usize) -> Option<ExtrapolationRisk> {
        let one = self.candidates.get(number).filter(|one| one.cause.effect == EffectKind::Periodic)?;
        let (Through::Component(name), _) = *one.columns.first()?.first()? else { return None };
        let waves = self.seek.sweep(name.axis()?)?.count();
        (self.chance_of_places(weights, taken, number, waves) > BY_CHANCE).then(|| ExtrapolationRisk {
            rivals: vec!["a separate error at each position".to_owned()],
            separate_by: steps(self.scene, one, one.constant.map_or(MOST_PERIOD, |(period, _)| period)),
        })
    }

    /// Returns the periods, mm, of short waves that explain the readings as well as a smooth shape along an axis, in addition to other terms, the longest
    /// first; and the share of the shape in the probability of itself and the best of these waves, by their likelihood (Schwarz 1978).
    pub(super) fn mimics(
        &self,
        weights: &Weights,
        number: usize,
        others: &[usize],
        (memory, noise): (f64, f64),
    ) -> (Vec<f64>, f64) {
        let Some((one, name, axis)) = self.candidates.get(number).and_then(|one| {
            let (name, axis) = smooth(one)?;
            Some((one, name, axis))
        }) else {
            return (Vec::new(), 1.0);
        };
        let series = self.series(weights, others, memory);
        let columns = self.columns(one);
        let own = series.gain(&columns);
        let price = (series.count().max(2) as f64).ln();
        let (amounts, _) = series.amounts(&columns);
        let (mut places, mut values): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let used = self.scene.items.iter().zip(&weights.items).filter(|(_, weight)| **weight > 0.0);
        for row in used.filter_map(|(item, _)| self.scene.rows.get(item.row)) {
            let value = weights_at(one, row).iter().zip(&amounts).map(|(weight, amount)| weight * amount).sum::<f64>();
            places.push(row.position[axis]);
            values.push(value);
        }
        // A shape with as many coefficients as a wave and a slope may be both at once.
        let bends = |is_short: bool| one.columns.len() > if is_short { MANY } else { TABLE };
        let most = [false, true].map(|has_slope| LARGER * range_of(&places, &values, has_slope));
        let line = self.columns(&slope_of(name, axis));
        let explains_with = |has_slope: bool, period: f64, slack: f64, is_short: bool| {
            let mut columns = self.columns(&periodic::candidate(name, axis, period));
            // The readings do not determine the amount of a sine that is zero at all their places.
            let largest = columns.iter().map(|column| dot(column, column)).fold(0.0, f64::max);
            columns.retain(|column| dot(column, column) > SHOWS * largest);
            let waves = columns.len();
            columns.extend(line.iter().filter(|_| has_slope).cloned());
            let (mut parts, _) = series.amounts(&columns);
            parts.truncate(waves);
            let gain = series.gain(&columns);
            let most = most[usize::from(has_slope)];
            // A table with an amount for each place follows the noise too. A slow wave needs no fewer amounts than a curve: its period is one.
            let spared = if is_short { price * own.rank.saturating_sub(gain.rank.max(WAVE)) as f64 } else { 0.0 };
            let less = (own.squares - gain.squares) / noise.max(f64::MIN_POSITIVE) - spared;
            (parts.iter().map(|part| part * part).sum::<f64>().sqrt() <= most && less <= slack).then_some(less)
        };
        let explains = |period: f64, slack: f64, is_short: bool| {
            let both = || bends(is_short).then(|| explains_with(true, period, 0.0, is_short)).flatten();
            explains_with(false, period, slack, is_short).or_else(both)
        };
        let slack = if one.columns.len() > 1 { RIVAL } else { 0.0 };
        let all = self.pitches(axis).filter_map(|period| Some((period, explains(period, slack, true)?)));
        let (mut out, mut less): (Vec<f64>, Vec<f64>) = all.unzip();
        if let Some((step, travel)) = even(places).filter(|_| out.is_empty() && one.columns.len() >= MANY) {
            // A table follows every wave that the places show, a curve only a slow one.
            let most = if one.columns.len() > TABLE { (0.5 * travel / step).max(SLOW[1]) } else { SLOW[1] };
            let count = ((most.min(MOST_CYCLES) - SLOW[0]) / STEP) as u32;
            let slow = (0..=count).map(|k| (SLOW[0] + STEP * f64::from(k)) / travel).filter(|slow| *slow < 0.5 / step);
            if let Some((slow, apart)) =
                slow.into_iter().find_map(|slow| Some((slow, explains(1.0 / slow, 0.0, false)?)))
            {
                out.extend([1.0 / (1.0 / step - slow), 1.0 / (1.0 / step + slow)]);
                less.push(apart);
            }
        }
        out.sort_by(|a, b| b.total_cmp(a));
        out.dedup();
        let best = less.into_iter().fold(f64::INFINITY, f64::min);
        (out, 1.0 / (1.0 + (-0.5 * best).exp()))
    }
}

/// Returns the component of an error along a linear axis that depends only on the position of this axis.
fn smooth(one: &Candidate) -> Option<(ErrorName, Axis)> {
    let [driver] = one.drivers.as_slice() else { return None };
    let axis = AXES.into_iter().find(|axis| !axis.is_rotary() && axis.to_string() == *driver)?;
    let mut all = one.columns.iter().flatten().map(|(through, _)| *through);
    let first = all.next()?;
    let name = match first {
        Through::Component(name) => name,
        Through::Tip(direction) => ErrorName::motion(*DIRECTIONS.get(direction)?, axis),
        _ => return None,
    };
    // Errors of screws and scales are periodic along their own axis.
    let is_own = name == own(axis) && all.all(|through| through == first);
    (matches!(one.cause.effect, EffectKind::Motion | EffectKind::Unknown) && is_own).then_some((name, axis))
}

/// A positioning error that grows with the position.
fn slope_of(name: ErrorName, axis: Axis) -> Candidate {
    let slope = Weight::new(move |row| row.position[axis]);
    Candidate::one(&motion::CAUSE, name, Through::Component(name), slope)
}

/// Returns the range of values at places, with or without their slope.
fn range_of(places: &[f64], values: &[f64], has_slope: bool) -> f64 {
    let count = places.len().max(1) as f64;
    let [middle, mean] = [places, values].map(|all| all.iter().sum::<f64>() / count);
    let squares: f64 = places.iter().map(|at| (at - middle).powi(2)).sum();
    let along: f64 = places.iter().zip(values).map(|(at, value)| (at - middle) * (value - mean)).sum();
    let slope = if has_slope && squares > 0.0 { along / squares } else { 0.0 };
    let straight = places.iter().zip(values).map(|(at, value)| value - slope * (at - middle));
    let ends = straight.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], one| [low.min(one), high.max(one)]);
    ends[1] - ends[0]
}

/// Returns the step of evenly spaced places, some of which may be missing, and their range.
fn even(mut places: Vec<f64>) -> Option<(f64, f64)> {
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| (*a - *b).abs() < 1e-3);
    let gaps = || places.windows(2).map(|pair| pair[1] - pair[0]);
    let step = gaps().fold(f64::INFINITY, f64::min);
    let is_even = gaps().all(|gap| ((gap / step).round() - gap / step).abs() < EVEN);
    let travel = places.last()? - places.first()?;
    (is_even && travel > 0.0).then_some((step, travel))
}
