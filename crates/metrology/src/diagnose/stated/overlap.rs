//! Accepted causes and simple errors of the model whose effect on the readings overlaps with that of a stated hypothesis.
//!
//! The amount of a hypothesis is that of a fit in which nothing else can take its place. Three kinds of accepted causes leave this fit:
//!
//! * one that alone has the effect of the hypothesis, or of one of its terms;
//! * those that have it together, also that of one term beside the other terms: an exactly collinear cause would halve an amount, or turn its sign;
//! * flexible shapes of the same error over the same quantities (polynomials, pieces, waves), if they contain most of a term beside the slope. They
//!   leave together.
//!
//! A flexible shape contains a slope. Without the shape, the slope of the same error stays beside the hypothesis if the readings make it more probable. It is not
//! part of a hypothesis that does not state it.

use super::super::cause::{Candidate, EffectKind};
use super::super::entrant::{family, group, is_slope};
use super::super::explain::contest::evidences;
use super::super::verdict::Settled;
use ncfix_base::numeric::Series;
use ncfix_model::motion::EntryFunction;

/// An accepted cause that explains at least this share of the squares of a hypothesis represents it. A parabola over a range from 0 is a straight line to
/// 15/16: readings separate these two.
const STANDS: f64 = 0.97;
/// A simple error of the model that explains at least this share of the squares of a hypothesis was calibrated with a part of it. A flexible shape that does
/// has its form.
const MIXES: f64 = 0.5;
/// A column depends on others if less than this share of its squares remains beside them: rounding.
const DEPENDS: f64 = 1e-9;

/// Causes that share the effect of a hypothesis.
#[derive(Clone, Debug, Default)]
pub(super) struct Overlap {
    /// Places among the accepted causes of those that represent it.
    pub(super) stand_ins: Vec<usize>,
    /// Simple errors of the model that took up a part of it when they were fitted without it: they are fitted again beside it.
    pub(super) refitted: Vec<usize>,
    /// Slope of the same error that stays beside it instead of the shapes that it replaces.
    pub(super) slope: Option<usize>,
}

impl Overlap {
    /// Candidates that are fitted beside the hypothesis although the search did not accept them.
    pub(super) fn added(&self) -> impl Iterator<Item = usize> + '_ {
        self.refitted.iter().copied().chain(self.slope)
    }
}

/// Finds the causes that share the effect of a candidate. Only a stated sum (`is_sum`) has parameters of the model fitted again.
pub(super) fn overlap(outcome: &Settled<'_, '_, '_>, number: usize, is_sum: bool) -> Overlap {
    let refitted = if is_sum { refitted(outcome, number) } else { Vec::new() };
    let slope = slope_of(outcome, number).filter(|_| is_sum);
    let shapes = if is_sum { shapes(outcome, number, slope) } else { Vec::new() };
    let stand_ins = stand_ins(outcome, number, &refitted, &shapes);
    let mut out = Overlap { stand_ins, refitted, slope: None };
    let slope = slope.filter(|one| !shapes.is_empty() && !out.refitted.contains(one));
    let Some(slope) = slope else { return out };
    let place = outcome.kept.iter().position(|(taken, _)| taken.candidate == slope);
    let is_beside = |place: &usize| !out.stand_ins.contains(place);
    if place.as_ref().is_some_and(is_beside) || !is_needed(outcome, number, &out, slope) {
        return out;
    }
    match place {
        Some(place) => out.stand_ins.retain(|own| *own != place),
        None => out.slope = Some(slope),
    }
    out
}

/// The slope of the error of a candidate, if the candidate does not contain it.
fn slope_of(outcome: &Settled<'_, '_, '_>, number: usize) -> Option<usize> {
    let field = &*outcome.field;
    let own = field.candidates.get(number)?;
    let is_one = |one: &Candidate| {
        one.cause.effect == EffectKind::Motion
            && is_slope(one)
            && one.parameter == own.parameter
            && one.drivers.iter().all(|driver| own.drivers.contains(driver))
    };
    let slope = field.candidates.iter().position(is_one)?;
    let [column] = field.columns_of(slope).try_into().ok()?;
    let mut series = field.series(outcome.weights, &[], 0.0);
    series.set_values(&column);
    let whole = series.squares();
    for column in field.columns_of(number) {
        series.take(&column);
    }
    series.set_values(&column);
    (series.squares() > DEPENDS * whole).then_some(slope)
}

/// True if the readings are more probable with a slope beside the hypothesis.
fn is_needed(outcome: &Settled<'_, '_, '_>, number: usize, overlap: &Overlap, slope: usize) -> bool {
    let field = &*outcome.field;
    let kept = outcome.kept.iter().enumerate().filter(|(place, _)| !overlap.stand_ins.contains(place));
    let beside = kept.map(|(_, (taken, _))| taken.candidate).chain(overlap.refitted.iter().copied());
    let all: Vec<usize> = beside.chain([number, slope]).collect();
    let groups: Vec<_> =
        all.iter().filter_map(|&number| field.candidates.get(number)).map(|one| group(field, one)).collect();
    let with: Vec<usize> = (0..groups.len()).collect();
    let without = with.iter().copied().take(groups.len().saturating_sub(1)).collect();
    let found = evidences(field.scene, &outcome.weights.items, &groups, &[without, with]);
    matches!(found.as_slice(), [without, with] if with > without)
}

/// The whole effect of a hypothesis at its best amounts, each of its columns, and each column beside its others: a term that a cause absorbs would get no
/// amount in addition to it.
fn parts(outcome: &Settled<'_, '_, '_>, number: usize) -> Vec<(Vec<f64>, Vec<Vec<f64>>)> {
    let field = &*outcome.field;
    let columns = field.columns_of(number);
    let (amounts, _) = field.series(outcome.weights, &[], 0.0).amounts(&columns);
    let mut effect = vec![0.0; field.scene.items.len()];
    for (column, amount) in columns.iter().zip(&amounts) {
        effect.iter_mut().zip(column).for_each(|(sum, value)| *sum += amount * value);
    }
    let alone = std::iter::once(effect).chain(columns.iter().cloned()).map(|part| (part, Vec::new()));
    let beside = of_others(&columns);
    alone.chain(beside.filter(|(_, others)| !others.is_empty())).collect()
}

/// Each column with the other ones.
fn of_others(columns: &[Vec<f64>]) -> impl Iterator<Item = (Vec<f64>, Vec<Vec<f64>>)> + '_ {
    columns.iter().enumerate().map(|(place, column)| {
        let others = columns.iter().enumerate().filter(|(other, _)| *other != place);
        (column.clone(), others.map(|(_, column)| column.clone()).collect())
    })
}

/// Share of the squares of a part, beside other columns, that columns explain; 0 for a part that depends on the others.
fn share(series: &Series, (part, others): &(Vec<f64>, Vec<Vec<f64>>), own: &[Vec<f64>]) -> f64 {
    let mut series = series.clone();
    series.set_values(part);
    let whole = series.squares();
    for other in others {
        series.take(other);
    }
    series.set_values(part);
    if series.squares() <= DEPENDS * whole {
        return 0.0;
    }
    series.gain(own).squares / series.squares().max(f64::MIN_POSITIVE)
}

/// Squareness, offsets, tilts and scales of the model that explain a large part of a hypothesis. A calibration without the hypothesis has put this part into
/// them.
fn refitted(outcome: &Settled<'_, '_, '_>, number: usize) -> Vec<usize> {
    let field = &*outcome.field;
    let errors = &field.scene.errors;
    let is_stated = |one: &Candidate| match one.cause.effect {
        EffectKind::Location => errors.location.iter().any(|error| error.name.to_string() == one.parameter),
        EffectKind::Motion if is_slope(one) => errors.motion.iter().any(|error| {
            error.name.to_string() == one.parameter && !matches!(error.function, EntryFunction::Backlash(_))
        }),
        _ => false,
    };
    let is_kept = |number: usize| outcome.kept.iter().any(|(taken, _)| taken.candidate == number);
    let series = field.series(outcome.weights, &[], 0.0);
    let mut parts = parts(outcome, number);
    parts.retain(|(_, others)| others.is_empty());
    let mut known: Vec<usize> = Vec::new();
    for (other, one) in field.candidates.iter().enumerate() {
        if other == number || is_kept(other) || !is_stated(one) {
            continue;
        }
        let own = field.columns_of(other);
        let largest = parts.iter().map(|part| share(&series, part, &own)).fold(0.0, f64::max);
        if largest > MIXES && largest <= STANDS {
            known.push(other);
        }
    }
    known
}

/// Places of the accepted flexible shapes of the same error over the same quantities, if together they contain most of a term beside the other terms and the
/// slope.
fn shapes(outcome: &Settled<'_, '_, '_>, number: usize, slope: Option<usize>) -> Vec<usize> {
    let field = &*outcome.field;
    let Some(own) = field.candidates.get(number) else { return Vec::new() };
    let is_shape = |one: &Candidate| {
        let is_flexible = match one.cause.effect {
            EffectKind::Motion => !is_slope(one),
            EffectKind::Cross | EffectKind::Periodic | EffectKind::Unknown => true,
            _ => false,
        };
        let acts = |one: &Candidate| one.columns.iter().flatten().map(|(through, _)| *through).collect::<Vec<_>>();
        let of_own = acts(own);
        is_flexible
            && acts(one).iter().all(|through| of_own.contains(through))
            && one.drivers.iter().all(|driver| own.drivers.contains(driver))
    };
    let places: Vec<usize> = outcome
        .kept
        .iter()
        .enumerate()
        .filter(|(_, (taken, _))| {
            taken.candidate != number && field.candidates.get(taken.candidate).is_some_and(is_shape)
        })
        .map(|(place, _)| place)
        .collect();
    let of_shapes: Vec<Vec<f64>> = places
        .iter()
        .filter_map(|&place| outcome.kept.get(place))
        .flat_map(|(taken, _)| field.columns_of(taken.candidate))
        .collect();
    let of_slope = slope.map_or_else(Vec::new, |slope| field.columns_of(slope));
    let series = field.series(outcome.weights, &[], 0.0);
    let columns = field.columns_of(number);
    let mut parts = of_others(&columns);
    let is_contained = parts.any(|(part, others)| {
        let others = others.into_iter().chain(of_slope.iter().cloned()).collect();
        share(&series, &(part, others), &of_shapes) > MIXES
    });
    if is_contained { places } else { Vec::new() }
}

/// Places of the accepted causes that have the effect of a hypothesis on the readings, alone or together, and those of `shapes`.
fn stand_ins(outcome: &Settled<'_, '_, '_>, number: usize, refitted: &[usize], shapes: &[usize]) -> Vec<usize> {
    let field = &*outcome.field;
    let parts = parts(outcome, number);
    let series = field.series(outcome.weights, &[], 0.0);
    let of_refitted: Vec<Vec<f64>> = refitted.iter().flat_map(|&number| field.columns_of(number)).collect();
    let of_cause: Vec<Vec<Vec<f64>>> =
        outcome.kept.iter().map(|(taken, _)| field.columns_of(taken.candidate)).collect();
    let mut beside: Vec<usize> = Vec::new();
    let mut found: Vec<usize> = Vec::new();
    for (place, (taken, _)) in outcome.kept.iter().enumerate() {
        let is_alone = taken.candidate == number
            || shapes.contains(&place)
            || parts.iter().any(|part| share(&series, part, &of_cause[place]) > STANDS);
        if is_alone { found.push(place) } else { beside.push(place) }
    }
    // Those that do it only together leave one by one: rare causes before those that most machines have, then the one with the largest share.
    let is_rare = |place: usize| {
        let of_place = outcome.kept.get(place).and_then(|(taken, _)| field.candidates.get(taken.candidate));
        of_place.is_some_and(|one| !family(one).is_simple())
    };
    for part in &parts {
        loop {
            let of_beside = beside.iter().flat_map(|&place| &of_cause[place]);
            let all: Vec<Vec<f64>> = of_beside.chain(&of_refitted).cloned().collect();
            if share(&series, part, &all) <= STANDS {
                break;
            }
            let shares: Vec<f64> = beside.iter().map(|&place| share(&series, part, &of_cause[place])).collect();
            let rank = |k: usize| (is_rare(beside[k]), shares[k]);
            let most = (0..beside.len()).max_by(|&a, &b| {
                let (one, other) = (rank(a), rank(b));
                one.0.cmp(&other.0).then(one.1.total_cmp(&other.1))
            });
            let Some(most) = most else { break };
            found.push(beside.remove(most));
        }
    }
    found.sort_unstable();
    found
}
