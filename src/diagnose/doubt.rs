//! Which findings readings do not tell from other errors that would move the tool otherwise where was not measured.
//!
//! Readings of a few places fit several errors alike: on circles that are off the middle a yaw that grows along an axis is a squareness and a scale.
//! Which of them is named does not matter where was measured, and matters all the more elsewhere. So a finding is held against the rivals of its class,
//! and against two errors that are less far-fetched, or a few of them where it is far-fetched itself: if these explain the readings as well, and the
//! correction of the finding would then not help over the whole travel of the machine, it is in doubt.

use nalgebra::{DMatrix, DVector};

use super::cause::{Candidate, Effect, Term};
use super::refine::RIVAL;
use super::scene::Through;
use super::search::{Field, Weights};
use super::separate::separating;
use super::size::{Amounts, EXPANDED};
use super::volume::Volume;
use crate::geometry::AXES;
use crate::model::parameter::Term as Part;
use crate::numeric::sums::dot;

/// A correction helps where it leaves less than this share of an error.
const LEAVES: f64 = 0.8;
/// Others that would do so many times what the finding does over the travel are none.
const LARGER: f64 = 2.0;
/// Rivals that are more far-fetched by less than this count.
const AS_FAR: u32 = 100;
/// Several simple errors are less far-fetched than what is so far-fetched: angles that one arm shows, cross-couplings, what has no name.
const FAR: u32 = 400;
/// So many of them.
const MOST: usize = 6;
/// Of a column of which less than this share of the square is left beside others these have all.
const OWN: f64 = 1e-4;

/// Why a finding is in doubt.
#[derive(Clone, Debug)]
pub struct Doubt {
    /// Names of errors that together do the same to the readings; none where it is less sure over the travel than it is large.
    pub rivals: Vec<String>,
    /// What tells it from the first of them.
    pub separate_by: String,
}

/// A simple error: what it does to readings beside others, and over the travel, per amount.
struct Simple {
    candidate: usize,
    reads: Vec<f64>,
    moves: Vec<f64>,
}

impl Field<'_, '_> {
    /// Why one beside others, with its amounts and its class (itself first), is in doubt.
    pub(super) fn doubt(
        &self,
        weights: &Weights,
        volume: &Volume,
        (number, others): (usize, &[usize]),
        (amounts, class): (&Amounts, &[usize]),
        (memory, noise): (f64, f64),
    ) -> Option<Doubt> {
        let one = self.candidates.get(number).filter(|one| is_of_place(one))?;
        let fields = volume.fields(one, is_bounded(one));
        let moves = sum(&fields, &amounts.values);
        if dot(&moves, &moves) <= 0.0 {
            return None;
        }
        if is_unsure(one, &fields, amounts, dot(&moves, &moves)) {
            return Some(Doubt { rivals: Vec::new(), separate_by: "at more places, or more often".to_owned() });
        }
        let mut series = self.series(weights, others, memory);
        let said = |rivals: &[usize]| {
            let rivals: Vec<&Candidate> = rivals.iter().filter_map(|&number| self.candidates.get(number)).collect();
            // A slope and a bow of one motion are one motion.
            let mut names: Vec<String> = Vec::new();
            for one in &rivals {
                let name = format!("{} {}", one.cause.effect, one.parameter);
                if !names.contains(&name) {
                    names.push(name);
                }
            }
            Some(Doubt { rivals: names, separate_by: separating(self.scene, one, rivals.first()?) })
        };
        for &rival in class.iter().skip(1) {
            let Some(other) = self.candidates.get(rival).filter(|other| is_of_place(other)) else { continue };
            // Cross-couplings with and without what each axis does alone are one kind.
            let are_cross = [one, other].iter().all(|one| one.cause.effect == Effect::Cross);
            let is_alike = (are_cross || other.columns.len() <= one.columns.len())
                && other.far_fetched() <= one.far_fetched().saturating_add(AS_FAR)
                && other.parameter != one.parameter;
            if is_alike {
                let (parts, _) = series.amounts(&self.columns(other));
                if harms(&moves, &sum(&volume.fields(other, is_bounded(other)), &parts)) {
                    return said(&[rival]);
                }
            }
        }
        let own = series.gain(&self.columns(one)).squares;
        let left = series.left().to_vec();
        let mut simple: Vec<Simple> = Vec::new();
        for candidate in self.simpler(one) {
            let Some(other) = self.candidates.get(candidate) else { continue };
            let columns = self.columns(other).pop().zip(volume.fields(other, false).pop());
            let Some((column, moves)) = columns else { continue };
            let whitened = series.whitened(&column);
            let whole = dot(&whitened, &whitened);
            series.set_values(&column);
            let reads = series.left().to_vec();
            if dot(&reads, &reads) > OWN * whole {
                simple.push(Simple { candidate, reads, moves });
            }
        }
        let needed = own - RIVAL * noise;
        let rivals = Rivals::new(&simple, &left);
        let found = rivals
            .pair(needed, &moves)
            .or_else(|| (one.far_fetched() >= FAR).then(|| rivals.several(needed, &moves)).flatten())?;
        said(&found)
    }

    /// Simple errors that are less far-fetched: locations, slopes of motions and bows.
    fn simpler(&self, than: &Candidate) -> Vec<usize> {
        let is_simple = |&number: &usize| {
            let Some(one) = self.candidates.get(number).filter(|one| one.columns.len() == 1) else { return false };
            let is_kind = match (&one.cause.effect, &one.term) {
                (Effect::Location, Term::Parameters(_)) => true,
                (Effect::Motion, Term::Parameters(names)) => names.iter().all(|name| name.term == Part::Coefficient(1)),
                (Effect::Motion, Term::None) => self.bows.contains(&number),
                _ => false,
            };
            is_kind && one.far_fetched() / 10 < than.far_fetched() / 10
        };
        (0..self.bows.end).filter(is_simple).collect()
    }
}

/// Simple errors and what products of them and of readings are.
struct Rivals<'a> {
    simple: &'a [Simple],
    products: DMatrix<f64>,
    right: DVector<f64>,
}

impl<'a> Rivals<'a> {
    fn new(simple: &'a [Simple], left: &[f64]) -> Rivals<'a> {
        let count = simple.len();
        let mut products = DMatrix::zeros(count, count);
        for k in 0..count {
            for l in 0..=k {
                let product = dot(&simple[k].reads, &simple[l].reads);
                products[(k, l)] = product;
                products[(l, k)] = product;
            }
        }
        let right = DVector::from_fn(count, |k, _| dot(&simple[k].reads, left));
        Rivals { simple, products, right }
    }

    /// Amounts of some and what they explain; `None` where they are not told apart.
    fn amounts(&self, some: &[usize]) -> Option<(Vec<f64>, f64)> {
        let scale: Vec<f64> = some.iter().map(|&k| self.products[(k, k)].sqrt()).collect();
        let matrix =
            DMatrix::from_fn(some.len(), some.len(), |k, l| self.products[(some[k], some[l])] / (scale[k] * scale[l]));
        let right = DVector::from_fn(some.len(), |k, _| self.right[some[k]] / scale[k]);
        if matrix.determinant() < OWN {
            return None;
        }
        let found = matrix.cholesky()?.solve(&right);
        let explained = found.dot(&right);
        Some((found.iter().zip(&scale).map(|(amount, scale)| amount / scale).collect(), explained))
    }

    fn moves(&self, some: &[usize], amounts: &[f64]) -> Vec<f64> {
        let all: Vec<&[f64]> = some.iter().map(|&k| self.simple[k].moves.as_slice()).collect();
        sum(&all, amounts)
    }

    fn numbers(&self, some: &[usize]) -> Vec<usize> {
        some.iter().map(|&k| self.simple[k].candidate).collect()
    }

    /// The two that explain most, if that is as much as is needed and a correction would do harm.
    fn pair(&self, needed: f64, own: &[f64]) -> Option<Vec<usize>> {
        let count = self.simple.len();
        let pairs = (0..count).flat_map(|k| (0..k).map(move |l| [l, k]));
        let alike = pairs.filter_map(|pair| {
            let (amounts, explained) = self.amounts(&pair)?;
            (explained >= needed && harms(own, &self.moves(&pair, &amounts))).then_some((explained, pair))
        });
        let best = alike.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(self.numbers(&best.1))
    }

    /// A few, the next always the one that explains most beside the others.
    fn several(&self, needed: f64, own: &[f64]) -> Option<Vec<usize>> {
        let mut some: Vec<usize> = Vec::new();
        while some.len() < MOST {
            let with = |k: usize| some.iter().copied().chain([k]).collect::<Vec<_>>();
            let open = (0..self.simple.len()).filter(|k| !some.contains(k));
            let all = open.filter_map(|k| Some((self.amounts(&with(k))?, k)));
            let ((amounts, explained), next) = all.max_by(|a, b| a.0.1.total_cmp(&b.0.1))?;
            some.push(next);
            if explained >= needed {
                return harms(own, &self.moves(&some, &amounts)).then(|| self.numbers(&some));
            }
        }
        None
    }
}

/// Whether the amounts of a shape of several columns are less sure over the travel than it is large.
fn is_unsure(one: &Candidate, fields: &[Vec<f64>], amounts: &Amounts, square: f64) -> bool {
    // A constant that is not told is not written.
    let is_constant = |k: usize| match &one.term {
        Term::Parameters(names) => names.get(k).is_some_and(|name| name.term == Part::Coefficient(0)),
        Term::None => false,
    };
    let told: Vec<usize> = (0..fields.len()).filter(|&k| !is_constant(k)).collect();
    let entry = |k: usize, l: usize| amounts.covariance.get(k).and_then(|row| row.get(l)).copied().unwrap_or(0.0);
    let pairs = told.iter().flat_map(|&k| told.iter().map(move |&l| (k, l)));
    let variance: f64 = pairs.map(|(k, l)| entry(k, l) * dot(&fields[k], &fields[l])).sum();
    told.len() > 1 && EXPANDED * EXPANDED * variance >= square
}

/// Whether it does not help to correct by one where the other is true, which is no larger than may be.
fn harms(own: &[f64], other: &[f64]) -> bool {
    let left: f64 = own.iter().zip(other).map(|(own, other)| (own - other).powi(2)).sum();
    let [one, whole] = [dot(own, own), dot(other, other)];
    whole <= LARGER * LARGER * one && left > LEAVES * LEAVES * whole
}

/// A sum of columns times amounts.
fn sum(columns: &[impl AsRef<[f64]>], amounts: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; columns.first().map_or(0, |column| column.as_ref().len())];
    for (column, amount) in columns.iter().zip(amounts) {
        out.iter_mut().zip(column.as_ref()).for_each(|(sum, value)| *sum += amount * value);
    }
    out
}

/// Whether it is taken for no more beyond the last places that were measured than there: what bends.
fn is_bounded(one: &Candidate) -> bool {
    let is_straight = |term: Part| matches!(term, Part::Coefficient(0 | 1) | Part::Whole);
    !matches!(&one.term, Term::Parameters(names) if names.iter().all(|name| is_straight(name.term)))
}

/// Whether it is an error of the machine that depends on places alone.
fn is_of_place(one: &Candidate) -> bool {
    let is_place = |driver: &String| AXES.iter().any(|axis| axis.to_string() == *driver);
    matches!(one.cause.effect, Effect::Location | Effect::Motion | Effect::Cross | Effect::Unknown)
        && one.constant.is_none()
        && one.drivers.iter().all(is_place)
        && one.columns.iter().flatten().all(|(through, _)| matches!(through, Through::Component(_) | Through::Tip(_)))
}
