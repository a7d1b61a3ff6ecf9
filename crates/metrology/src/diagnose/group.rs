//! Fits many simple errors of a machine at once. A sequential search can start with a wrong term that explains a part of several errors; later terms then
//! compensate for it.
//!
//! All simple errors (locations and motion polynomials) are added together, the least complex first; dependent columns are skipped. Terms that do not justify
//! their penalty are then removed, the most complex first. If the result is equivalent to that of the sequential search, it is preferred.

use nalgebra::{DMatrix, DVector};

use super::cause::{Candidate, EffectKind, Term};
use super::gates::LIMIT;
use super::price::Price;
use super::scene::Through;
use super::search::{Field, TIE, Weights};
use ncfix_base::numeric::in_parts;
use ncfix_base::numeric::sums::dot;
use ncfix_model::ParameterName;
use ncfix_model::name::ErrorName;
use ncfix_model::parameter::ComponentTerm;

/// The group is tried from this number of sequentially found terms on.
const MANY: usize = 3;
/// Complexity from which two simple errors are simpler: angles that act as displacements, dependences on two axes, unnamed terms.
const FAR: u32 = 300;
/// Maximum number of terms of a group, as a multiple of the sequential terms.
const MORE: usize = 2;
/// Highest degree of polynomials.
const DEGREE: u8 = 3;
/// A column is dependent if less than this share of its square remains after the preceding columns. Below the second limit, the set-ups absorb it completely.
const OWN: f64 = 1e-2;
const NOTHING: f64 = 1e-9;
/// Number of columns that are processed at once.
const AT_ONCE: usize = 32;
/// Maximum number of candidates in a group.
const MOST: usize = 16;

/// A simple error.
struct Simple {
    name: ErrorName,
    /// Degree of the polynomial; 0 for a location.
    degree: u8,
    candidate: usize,
    /// The candidate without the linear term.
    bow: Option<usize>,
}

/// A column: its name, its candidate, and its degree.
struct Single {
    name: ErrorName,
    /// Degree of the polynomial; 0 for a location.
    degree: u8,
    candidate: usize,
    /// Effect on the readings after the set-up unknowns, whitened, of unit length.
    does: Vec<f64>,
}

/// A simple error after projection on the set-up unknowns.
struct Fresh<'s> {
    one: &'s Simple,
    /// As [`Single::does`].
    does: Vec<f64>,
    /// True if the set-ups do not absorb it completely.
    is_seen: bool,
}

/// Returns a column minus its projections on the given directions.
fn without(mut column: Vec<f64>, directions: &[Vec<f64>]) -> Vec<f64> {
    for other in directions {
        let share = dot(&column, other);
        column.iter_mut().zip(other).for_each(|(value, part)| *value -= share * part);
    }
    column
}

impl Field<'_, '_> {
    /// Returns the better explanation: the sequentially found terms, or a group of simple errors.
    pub(super) fn together(&mut self, weights: &Weights, taken: Vec<usize>) -> Vec<usize> {
        // Over a part of the travel, one angular error looks like two simple errors at once.
        let is_far = |one: &Candidate| one.plausibility_rank() >= FAR;
        let is_pair =
            |one: &Candidate| is_far(one) && matches!(one.cause.effect, EffectKind::Motion | EffectKind::Cross);
        let is_any_far = taken.iter().filter_map(|&number| self.candidates.get(number)).any(is_far);
        if taken.len() < MANY && !is_any_far {
            return taken;
        }
        let group = self.group(weights);
        // A term that is not significant given the others must not replace anything.
        let group: Vec<usize> =
            self.backward(weights, group, LIMIT, &mut |_| {}).into_iter().map(|term| term.candidate).collect();
        if group.is_empty() {
            return taken;
        }
        let group = self.sound_steps(weights, &group, &[]);
        // Many small terms can fit the shape of a single other cause.
        if group.len() > MORE * taken.len() {
            return taken;
        }
        let far = taken.iter().filter_map(|&number| self.candidates.get(number)).filter(|one| is_far(one));
        let (count, pairs) = far.fold((0_u32, 0), |(count, pairs), one| (count + 1, pairs + usize::from(is_pair(one))));
        let [one, other] = [&taken, &group].map(|all| self.criterion(weights, all));
        // A term that may be two simple errors is replaced by them if they explain as much. Their number carries no penalty then.
        let more = other.1.saturating_sub(one.1).min(pairs);
        let price = Price::new(weights.items.iter().filter(|weight| **weight > 0.0).count() as f64, self.tried);
        if other.0 < one.0 + TIE * f64::from(count) + price.of(more) { group } else { taken }
    }

    /// Returns −2 ln of the likelihood plus the penalty of all columns, and the number of columns.
    fn criterion(&self, weights: &Weights, taken: &[usize]) -> (f64, usize) {
        let [without, with] = [self.series(weights, &[], 0.0), self.series(weights, taken, 0.0)];
        let rank = with.rank().saturating_sub(without.rank());
        let gain = ncfix_base::numeric::Gain { squares: without.squares() - with.squares(), rank };
        (-Price::new(with.count() as f64, self.tried).worth(without.squares(), &gain), rank)
    }

    /// Returns the simple errors that justify their penalty, in the order of their complexity.
    fn group(&self, weights: &Weights) -> Vec<usize> {
        let mut series = self.series(weights, &[], 0.0);
        let left = series.left().to_vec();
        let mut all: Vec<Single> = Vec::new();
        let mut own: Vec<Vec<f64>> = Vec::new();
        // Components whose slope equals a location error.
        let mut bent: Vec<ErrorName> = Vec::new();
        for some in self.simple().chunks(AT_ONCE) {
            let mut fresh: Vec<Fresh<'_>> = Vec::new();
            for one in some {
                // A polynomial of higher degree is used without its linear term: far from zero, a square is nearly linear.
                let columns = self.candidates.get(one.bow.unwrap_or(one.candidate)).map(|one| self.columns(one));
                let Some(column) = columns.and_then(|mut all| all.pop()) else { continue };
                let whitened = series.whitened(&column);
                let whole = dot(&whitened, &whitened);
                series.set_values(&column);
                let mut does = series.left().to_vec();
                let beside = dot(&does, &does);
                let length = beside.sqrt();
                does.iter_mut().for_each(|value| *value /= length);
                fresh.push(Fresh { one, does, is_seen: beside > NOTHING * whole });
            }
            let from = own.len();
            let directions = in_parts(&fresh, &|fresh: &Fresh<'_>| without(fresh.does.clone(), &own));
            for (Fresh { one, does, is_seen }, direction) in fresh.into_iter().zip(directions) {
                let mut direction = without(direction, &own[from..]);
                let rest = dot(&direction, &direction);
                if !(is_seen && rest > OWN) {
                    bent.push(one.name);
                    continue;
                }
                direction.iter_mut().for_each(|value| *value /= rest.sqrt());
                own.push(direction);
                let candidate = one.bow.filter(|_| bent.contains(&one.name)).unwrap_or(one.candidate);
                all.push(Single { name: one.name, degree: one.degree, candidate, does });
            }
        }
        series.set_values(&[]);
        let squares = dot(&left, &left);
        self.pruned(all, (&left, squares), series.count() as f64)
    }

    /// Returns locations and motion polynomials by degree, the least complex first.
    fn simple(&self) -> Vec<Simple> {
        let mut out: Vec<(u32, Simple)> = Vec::new();
        let bow = |name: ErrorName, degree: u8| {
            let is_it = |&number: &usize| {
                self.candidates.get(number).is_some_and(|one| {
                    one.columns.len() + 1 == usize::from(degree)
                        && one
                            .columns
                            .first()
                            .and_then(|parts| parts.first())
                            .is_some_and(|part| part.0 == Through::Component(name))
                })
            };
            self.bows.clone().find(is_it)
        };
        for (candidate, one) in self.candidates.iter().enumerate() {
            let Term::Parameters(parameters) = &one.term else { continue };
            let degrees: Option<Vec<u8>> = parameters.iter().map(degree).collect();
            let (Some(degrees), Some(first)) = (degrees, parameters.first()) else { continue };
            let degree = match one.cause.effect {
                EffectKind::Location if parameters.len() == 1 => 0,
                EffectKind::Motion if degrees.iter().copied().eq(1..=degrees.len() as u8) => degrees.len() as u8,
                _ => continue,
            };
            let name = first.component;
            let bow = bow(name, degree).filter(|_| degree > 1);
            if degree <= 1 || (degree <= DEGREE && bow.is_some()) {
                out.push((one.plausibility_rank(), Simple { name, degree, candidate, bow }));
            }
        }
        out.sort_by_key(|(far, one)| (one.degree, *far, one.candidate));
        out.into_iter().map(|(_, one)| one).collect()
    }

    /// Removes terms that do not justify their penalty, the most complex first. A lower degree is never removed before a higher one.
    fn pruned(&self, all: Vec<Single>, (left, squares): (&[f64], f64), count: f64) -> Vec<usize> {
        let places: Vec<usize> = (0..all.len()).collect();
        let row = |&k: &usize| -> Vec<f64> { all[..=k].iter().map(|other| dot(&all[k].does, &other.does)).collect() };
        let rows = in_parts(&places, &row);
        let products = DMatrix::from_fn(all.len(), all.len(), |k, l| rows[k.max(l)][k.min(l)]);
        let right = DVector::from_fn(all.len(), |k, _| dot(&all[k].does, left));
        let price = Price::new(count, self.tried);
        let mut open: Vec<usize> = (0..all.len()).collect();
        while !open.is_empty() {
            let part = DMatrix::from_fn(open.len(), open.len(), |k, l| products[(open[k], open[l])]);
            let own = DVector::from_fn(open.len(), |k, _| right[open[k]]);
            let Some(inverse) = part.cholesky().map(|one| one.inverse()) else { return Vec::new() };
            let amounts = &inverse * &own;
            let rest = (squares - own.dot(&amounts)).max(squares * 1e-12);
            let is_top = |k: usize| {
                let one = &all[open[k]];
                !open.iter().any(|&other| all[other].name == one.name && all[other].degree > one.degree)
            };
            let loss = |k: usize| amounts[k] * amounts[k] / inverse[(k, k)];
            let worth =
                |k: usize| price.worth(rest + loss(k), &ncfix_base::numeric::Gain { squares: loss(k), rank: 1 });
            let tops: Vec<usize> = (0..open.len()).filter(|&k| is_top(k)).collect();
            // The most complex of the unjustified terms. If all are justified but too many, the one that explains least.
            let out = tops.iter().copied().rfind(|&k| worth(k) <= 0.0);
            let least = || tops.iter().copied().min_by(|&k, &l| loss(k).total_cmp(&loss(l)));
            let Some(k) = out.or_else(|| least().filter(|_| tops.len() > MOST)) else { break };
            open.remove(k);
        }
        let mut out: Vec<usize> = Vec::new();
        for &k in &open {
            let one = &all[k];
            if !open.iter().any(|&other| all[other].name == one.name && all[other].degree > one.degree) {
                out.push(one.candidate);
            }
        }
        out
    }
}

/// Returns the degree of a polynomial coefficient.
fn degree(parameter: &ParameterName) -> Option<u8> {
    match parameter.term {
        ComponentTerm::Coefficient(degree) => Some(degree),
        ComponentTerm::Whole => Some(0),
        _ => None,
    }
}
