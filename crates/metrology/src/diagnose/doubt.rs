//! Extrapolation risk: other errors explain the readings as well, but move the tool differently where nothing was measured.
//!
//! Readings at a few places can fit several errors: on circles away from the middle, a yaw that grows along an axis looks like a squareness and a scale. At
//! the measured places it does not matter which one is named; elsewhere it does. So a finding is compared with the other explanations of its class and with
//! two simpler errors, or with several if it is complex itself. If these explain the readings as well, and correcting the finding would not help over the
//! whole travel, the finding is in doubt.

use nalgebra::{DMatrix, DVector};

use super::cause::{Candidate, CauseId, EffectKind, Term, circle, own};
use super::mimic::RIVAL;
use super::scene::Through;
use super::search::{Field, Weights};
use super::separate::{line_along, separating};
use super::size::{Amounts, EXPANDED, sense_along};
use super::volume::Volume;
use ncfix_base::geometry::AXES;
use ncfix_base::numeric::Series;
use ncfix_base::numeric::sums::dot;
use ncfix_model::parameter::ComponentTerm;

/// A correction helps if its residual is less than this share of the error.
const LEAVES: f64 = 0.8;
/// Other explanations whose effect over the travel exceeds that of the finding by this factor are ignored.
const LARGER: f64 = 2.0;
/// Other explanations count if their complexity exceeds that of the finding by less than this.
const AS_FAR: u32 = 100;
/// More complex ones count if they improve χ² by this much. A correction must then leave a smaller residual.
const BETTER: f64 = 4.0;
const HALF: f64 = 0.5;
/// Several simple errors are simpler than a term of this complexity: angles seen at one arm, cross-couplings, unnamed terms.
const FAR: u32 = 400;
/// Maximum number of these errors.
const MOST: usize = 6;
/// Smallest number of lobes of an out-of-round ball. Slopes and bows of axes cause fewer lobes on a circle.
const LOBES: std::ops::Range<u32> = 4..13;
/// A column is dependent if less than this share of its square remains after the others.
const OWN: f64 = 1e-4;

/// Reason why a finding is in doubt.
#[derive(Clone, Debug)]
pub struct ExtrapolationRisk {
    /// Names of errors that together have the same effect on the readings; empty if the uncertainty over the travel exceeds the size.
    pub rivals: Vec<String>,
    /// Measurement that separates the finding from the first of them.
    pub separate_by: String,
}

/// A simple error: its effect on the readings after the other terms, and over the travel, per amount.
struct Simple {
    candidate: usize,
    reads: Vec<f64>,
    moves: Vec<f64>,
}

impl Field<'_, '_> {
    /// Returns the reason why a candidate is in doubt. Arguments: the other terms, its amounts, and its class, itself first.
    pub(super) fn doubt(
        &self,
        weights: &Weights,
        volume: &Volume,
        (number, others): (usize, &[usize]),
        (amounts, class): (&Amounts, &[usize]),
        (memory, noise): (f64, f64),
    ) -> Option<ExtrapolationRisk> {
        let one = self.candidates.get(number)?;
        if let Some(doubt) = self.turn_in_doubt(one, class) {
            return Some(doubt);
        }
        if !is_of_place(one) {
            return None;
        }
        let fields = volume.fields(one, is_bounded(one));
        let moves = sum(&fields, &amounts.values);
        if dot(&moves, &moves) <= 0.0 {
            return None;
        }
        if is_unsure(one, &fields, amounts, dot(&moves, &moves)) {
            return Some(ExtrapolationRisk {
                rivals: Vec::new(),
                separate_by: "at more places, or more often".to_owned(),
            });
        }
        let mut series = self.series(weights, others, memory);
        let own = series.gain(&self.columns(one)).squares;
        let said = |rivals: &[usize]| {
            let rivals: Vec<&Candidate> = rivals.iter().filter_map(|&number| self.candidates.get(number)).collect();
            // Slope and bow of one motion count as one motion.
            let mut names: Vec<String> = Vec::new();
            for one in &rivals {
                let name = format!("{} {}", one.cause.effect, one.parameter);
                if !names.contains(&name) {
                    names.push(name);
                }
            }
            Some(ExtrapolationRisk { rivals: names, separate_by: separating(self.scene, one, rivals.first()?) })
        };
        for &rival in class.iter().skip(1) {
            let is_single = |other: &&Candidate| is_of_place(other) && !self.is_sum(rival);
            let Some(other) = self.candidates.get(rival).filter(is_single) else { continue };
            // Cross-couplings with and without the contribution of each axis count as one kind.
            let are_cross = [one, other].iter().all(|one| one.cause.effect == EffectKind::Cross);
            let is_as_short = are_cross || other.columns.len() <= one.columns.len();
            let [far, of_other] = [one, other].map(Candidate::plausibility_rank);
            let columns = self.columns(other);
            let is_better = series.gain(&columns).squares > own + BETTER * noise;
            // A bow with a slope fits more by chance; an unnamed term was selected from many candidates.
            let is_any = one.cause.effect == EffectKind::Unknown;
            let is_longer = other.columns.len() == one.columns.len() + 1 && (is_better || is_any);
            // An angle seen at one arm looks like a displacement with the same dependence.
            let is_angle = far >= FAR && one.cause.effect == EffectKind::Motion;
            let is_simpler = of_other.saturating_add(AS_FAR) < far && (is_as_short || is_longer || is_angle);
            let is_alike = is_as_short && of_other <= far.saturating_add(AS_FAR) && other.parameter != one.parameter;
            let is_better = is_as_short && is_better;
            if is_simpler || is_alike || is_better {
                let (parts, _) = series.amounts(&columns);
                let field = sum(&volume.fields(other, is_bounded(other)), &parts);
                // A simpler error may also have a much larger effect than the finding.
                let is_left = is_simpler && leaves(&moves, &field, LEAVES);
                if harms(&moves, &field) || is_left || (is_better && leaves(&moves, &field, HALF)) {
                    return said(&[rival]);
                }
            }
        }
        if let Some(rival) = self.single_instead(weights, volume, (one, others), memory) {
            return said(&[rival]);
        }
        if let Some(doubt) = self.lobes_instead(&series, one, own - RIVAL * noise) {
            return Some(doubt);
        }
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
            .or_else(|| (one.plausibility_rank() >= FAR).then(|| rivals.several(needed, &moves)).flatten())?;
        said(&found)
    }

    /// Returns the reason why the scale of an axis is known only relative to those of others: equal scales of these axes do not change the readings. A bar of
    /// unknown length reads the same if all axes of its circles are longer by the same share.
    pub(super) fn relative_scale(&self, weights: &Weights, number: usize) -> Option<(CauseId, ExtrapolationRisk)> {
        let one = self.candidates.get(number).filter(|one| is_scale(one))?;
        let others = self.candidates.iter().filter(|other| is_scale(other) && other.parameter != one.parameter);
        let others: Vec<&Candidate> = others.take(MOST).collect();
        let mut series = self.series(weights, &[], 0.0);
        let mut left = |column: &[f64]| {
            series.set_values(column);
            dot(series.left(), series.left())
        };
        let along = |one: &Candidate| {
            let sense = sense_along(one, self.scene);
            self.columns(one)
                .into_iter()
                .next()
                .unwrap_or_default()
                .into_iter()
                .map(|value| sense * value)
                .collect::<Vec<f64>>()
        };
        let own = along(one);
        let whole = left(&own);
        // Each choice of other axes, the smallest first: one bit for each.
        let mut choices: Vec<u32> = (1..1 << others.len()).collect();
        choices.sort_by_key(|choice| choice.count_ones());
        let chosen =
            |choice: u32| others.iter().enumerate().filter(move |(k, _)| choice >> k & 1 == 1).map(|(_, other)| *other);
        let with = choices.into_iter().find(|&choice| {
            let mut sum = own.clone();
            for other in chosen(choice) {
                sum.iter_mut().zip(along(other)).for_each(|(sum, value)| *sum += value);
            }
            left(&sum) <= OWN * whole
        })?;
        let rival = CauseId::together(chosen(with).map(Candidate::id).collect());
        let separate_by = format!("a bar of calibrated length, or {}", line_along(self.scene, one));
        let risk = ExtrapolationRisk { rivals: vec![rival.to_string()], separate_by };
        Some((rival, risk))
    }

    /// True if a reversal rotation of a carriage may as well be a plain backlash, which is independent of the tool position.
    fn turn_in_doubt(&self, one: &Candidate, class: &[usize]) -> Option<ExtrapolationRisk> {
        let is_play = |one: &Candidate| matches!(one.cause.effect, EffectKind::Backlash | EffectKind::LateralPlay);
        if !is_play(one) || one.plausibility_rank() < FAR {
            return None;
        }
        let others = class.iter().skip(1).filter_map(|&number| self.candidates.get(number));
        let plain = others.into_iter().find(|other| is_play(other) && other.plausibility_rank() < FAR)?;
        Some(ExtrapolationRisk {
            rivals: vec![format!("{} {}", plain.cause.effect, plain.parameter)],
            separate_by: separating(self.scene, one, plain),
        })
    }

    /// Returns an error that explains more than the finding, a simple one and another finding together: then it is unlikely that both exist by chance.
    fn single_instead(
        &self,
        weights: &Weights,
        volume: &Volume,
        (one, others): (&Candidate, &[usize]),
        memory: f64,
    ) -> Option<usize> {
        let is_simple = |one: &Candidate| {
            let is_known = matches!(one.cause.effect, EffectKind::Location | EffectKind::Motion);
            is_known && one.columns.len() == 1 && matches!(one.term, Term::Parameters(_))
        };
        let at = |number: usize| self.candidates.get(number).filter(|one| is_simple(one));
        others.iter().filter(|_| is_simple(one)).find_map(|&number| {
            let other = at(number)?;
            let rest: Vec<usize> = others.iter().copied().filter(|&third| third != number).collect();
            let series = self.series(weights, &rest, memory);
            let both = [self.columns(one), self.columns(other)].concat();
            let (amounts, _) = series.amounts(&both);
            let fields = [volume.fields(one, false), volume.fields(other, false)].concat();
            let (moves, explained) = (sum(&fields, &amounts), series.gain(&both).squares);
            (0..self.bows.start).find(|&rival| {
                at(rival).is_some_and(|rival| {
                    let columns = self.columns(rival);
                    series.gain(&columns).squares > explained && {
                        let (amounts, _) = series.amounts(&columns);
                        leaves(&moves, &sum(&volume.fields(rival, false), &amounts), HALF)
                    }
                })
            })
        })
    }

    /// Returns lobes over the angle of circles that explain as much with no more unknowns: they are not errors of axes.
    fn lobes_instead(&self, series: &Series, one: &Candidate, needed: f64) -> Option<ExtrapolationRisk> {
        let most = one.columns.len() / 2;
        let places = if most > 0 { circle::places(self.scene)? } else { return None };
        let mut planes: Vec<usize> =
            places.planes.iter().flatten().filter(|plane| plane.is_finite()).map(|&plane| plane as usize).collect();
        planes.sort_unstable();
        planes.dedup();
        let mut found = LOBES.flat_map(|count| {
            let with = |planes: &[usize], are_alike| {
                let one = circle::lobes(&places, planes, count, are_alike);
                (series.gain(&self.columns(&one)).squares, one)
            };
            let mut each: Vec<(f64, usize)> = planes.iter().map(|&plane| (with(&[plane], true).0, plane)).collect();
            each.sort_by(|a, b| b.0.total_cmp(&a.0));
            let some: Vec<usize> = each.into_iter().take(most).map(|(_, plane)| plane).collect();
            [with(&planes, true), with(&some, false)]
        });
        let (_, lobes) = found.find(|(gain, _)| *gain >= needed)?;
        let count = lobes.constant.map_or(0.0, |(count, _)| count);
        Some(ExtrapolationRisk {
            rivals: vec![format!("{count} lobes over the angle of circles ({})", lobes.parameter)],
            separate_by: lobes.cause.separate_by.to_owned(),
        })
    }

    /// Returns the simple errors: locations, slopes of motions and bows.
    fn simpler(&self, than: &Candidate) -> Vec<usize> {
        let is_simple = |&number: &usize| {
            let Some(one) = self.candidates.get(number).filter(|one| one.columns.len() == 1) else { return false };
            let is_kind = match (&one.cause.effect, &one.term) {
                (EffectKind::Location, Term::Parameters(_)) => true,
                (EffectKind::Motion, Term::Parameters(names)) => {
                    names.iter().all(|name| name.term == ComponentTerm::Coefficient(1))
                }
                (EffectKind::Motion, Term::None) => self.bows.contains(&number),
                _ => false,
            };
            is_kind && one.plausibility_rank() / 10 < than.plausibility_rank() / 10
        };
        (0..self.bows.end).filter(is_simple).collect()
    }
}

/// Simple errors and their products with each other and with the readings.
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

    /// Returns the amounts of some errors and the sum of squares that they explain; `None` if they are not separable.
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

    /// Returns the two errors that explain most, if they explain enough and a correction would do harm.
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

    /// Returns a few errors by forward selection: each step adds the one that explains most in addition to the others.
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

/// True if the uncertainty of a shape with several columns over the travel exceeds its size.
fn is_unsure(one: &Candidate, fields: &[Vec<f64>], amounts: &Amounts, square: f64) -> bool {
    // A constant that is not identifiable is not written.
    let is_constant = |k: usize| match &one.term {
        Term::Parameters(names) => names.get(k).is_some_and(|name| name.term == ComponentTerm::Coefficient(0)),
        Term::File(_) | Term::None => false,
    };
    let told: Vec<usize> = (0..fields.len()).filter(|&k| !is_constant(k)).collect();
    let entry = |k: usize, l: usize| amounts.covariance.get(k).and_then(|row| row.get(l)).copied().unwrap_or(0.0);
    let pairs = told.iter().flat_map(|&k| told.iter().map(move |&l| (k, l)));
    let variance: f64 = pairs.map(|(k, l)| entry(k, l) * dot(&fields[k], &fields[l])).sum();
    told.len() > 1 && EXPANDED * EXPANDED * variance >= square
}

/// True if correcting by one error does not help when the other is the true one, and the other is not larger than allowed.
fn harms(own: &[f64], other: &[f64]) -> bool {
    dot(other, other) <= LARGER * LARGER * dot(own, own) && leaves(own, other, LEAVES)
}

/// True if the residual after correcting by one error is at least this share of the other.
pub(super) fn leaves(own: &[f64], other: &[f64], share: f64) -> bool {
    let left: f64 = own.iter().zip(other).map(|(own, other)| (own - other).powi(2)).sum();
    left > share * share * dot(other, other)
}

/// Returns the sum of columns times amounts.
pub(super) fn sum(columns: &[impl AsRef<[f64]>], amounts: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; columns.first().map_or(0, |column| column.as_ref().len())];
    for (column, amount) in columns.iter().zip(amounts) {
        out.iter_mut().zip(column.as_ref()).for_each(|(sum, value)| *sum += amount * value);
    }
    out
}

/// True for a positioning error proportional to the position.
fn is_scale(one: &Candidate) -> bool {
    let is_proportional = matches!(&one.term, Term::Parameters(names)
    if names.iter().all(|name| {
        name.term == ComponentTerm::Coefficient(1) && name.component.axis().is_some_and(|axis| own(axis) == name.component && !axis.is_rotary())
    }));
    one.cause.effect == EffectKind::Motion && one.columns.len() == 1 && is_proportional
}

/// True if the term stays constant beyond the measured places: nonlinear terms.
pub(super) fn is_bounded(one: &Candidate) -> bool {
    let is_straight = |term: ComponentTerm| matches!(term, ComponentTerm::Coefficient(0 | 1) | ComponentTerm::Whole);
    !matches!(&one.term, Term::Parameters(names) if names.iter().all(|name| is_straight(name.term)))
}

/// True if it is an error of the machine that depends only on positions.
fn is_of_place(one: &Candidate) -> bool {
    let is_place = |driver: &String| AXES.iter().any(|axis| axis.to_string() == *driver);
    matches!(one.cause.effect, EffectKind::Location | EffectKind::Motion | EffectKind::Cross | EffectKind::Unknown)
        && one.constant.is_none()
        && one.drivers.iter().all(is_place)
        && one.columns.iter().flatten().all(|(through, _)| matches!(through, Through::Component(_) | Through::Tip(_)))
}

#[cfg(test)]
mod tests;
