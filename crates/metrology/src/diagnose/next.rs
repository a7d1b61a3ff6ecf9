//! Next measurement: the plan whose readings the explanations predict most differently.
//!
//! Explanations that fit the readings equally well differ elsewhere: at other positions, with another tool, in another quantity. Every plan of the machine is
//! predicted with the terms of each explanation, and the unknowns of its set-up are eliminated. The doubt that is left between two explanations is the
//! Bhattacharyya coefficient of their predictions (Bhattacharyya 1943, Bulletin of the Calcutta Mathematical Society 35). A measurement like the given ones
//! leaves all of it: the explanations agree there.

use ncfix_base::geometry::{Axis, Plane};
use ncfix_base::numeric::in_parts;
use ncfix_base::units::{UnitKey, um_from_mm, urad_from_rad};
use ncfix_machine::machine::Machine;
use ncfix_model::name::DIRECTIONS;
use ncfix_model::{ErrorName, name};

use super::cause::{Candidate, CauseId, EffectKind};
use super::entrant::EntrantSource;
use super::explain::contest::Contest;
use super::readings::{projected, weights};
use super::scene::Scene;
use super::search::Field;
use super::separate::{LONGER, hundredths};
use super::twins::{Twin, Twins};
use crate::measure::plan::{self, Wishes};

/// The explanations are certain if the first one has at least this probability.
const CERTAIN: f64 = 0.95;
/// Explanations with a smaller probability are not compared, and no more than this many.
const LEAST: f64 = 0.01;
const MOST: usize = 12;
/// The compared explanations must have at least this probability together: a plan predicts no temperatures and no fault of an instrument.
const ENOUGH: f64 = 0.5;
/// A plan is named if it resolves at least this share of the doubt.
const WORTHWHILE: f64 = 0.2;
/// Plans that resolve nearly as much: the instrument of the given readings comes first, then the smaller plan.
const NEARLY: f64 = 0.02;
/// Number of plans that are named.
const NAMED: usize = 3;
/// Standard uncertainty of a length reading, mm: usual for ball-bars, probes and lasers in a workshop (the default of a description).
const LENGTH_SIGMA_MM: f64 = 1e-3;
/// Standard uncertainty of an angle reading, rad: 0.4″, usual for autocollimators and levels.
const ANGLE_SIGMA_RAD: f64 = 2e-6;
/// Share of the shorter travel that a plate covers, and number of its steps.
const PLATE_SHARE: f64 = 0.8;
const PLATE_STEPS: f64 = 4.0;

/// A measurement that separates the explanations.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NextMeasurement {
    /// Command that plans it.
    pub command: String,
    /// Share of the doubt between the explanations that it resolves, 0 to 1.
    pub resolves: f64,
    /// RMS difference of the readings that the two most probable explanations predict, in `unit`.
    pub difference: f64,
    /// Unit of the difference.
    pub unit: UnitKey,
    /// Number of readings.
    pub readings: usize,
}

impl NextMeasurement {
    /// True if the predictions of the two most probable explanations differ by more than the usual uncertainty of a reading.
    #[must_use]
    pub fn separates_the_first_two(&self) -> bool {
        let sigma = match self.unit {
            UnitKey::Urad => urad_from_rad(ANGLE_SIGMA_RAD),
            UnitKey::Um => um_from_mm(LENGTH_SIGMA_MM),
        };
        self.difference > sigma
    }
}

/// A plan with its options.
struct Proposal {
    kind: &'static str,
    options: String,
    wishes: Wishes,
}

/// An explanation whose terms depend on position, direction and speed alone, so that any plan shows them.
struct Predictor<'f> {
    probability: f64,
    /// Its causes, sorted.
    causes: Vec<CauseId>,
    terms: Vec<(&'f Candidate, Vec<f64>)>,
}

/// Returns the plans that separate the explanations of a comparison, the best first; none if the first explanation is certain, or if no plan separates them.
pub(super) fn measurements(
    field: &Field<'_, '_>,
    found: &Contest,
    sources: &[EntrantSource],
    twins: &Twins,
) -> Vec<NextMeasurement> {
    let mut compared = predictors(field, found, sources, twins);
    if compared.first().is_none_or(|first| first.probability >= CERTAIN) {
        return Vec::new();
    }
    let whole: f64 = compared.iter().map(|one| one.probability).sum();
    if compared.len() < 2 || whole < ENOUGH {
        return Vec::new();
    }
    compared.iter_mut().for_each(|one| one.probability /= whole);
    let machine = field.scene.machine;
    let proposals = proposals(machine, tool_length_mm(field.scene));
    let mut all: Vec<(bool, NextMeasurement)> =
        in_parts(&proposals, &|one: &Proposal| of_plan(field.scene, one, &compared)).into_iter().flatten().collect();
    all.retain(|(_, one)| one.resolves >= WORTHWHILE);
    let best = all.iter().map(|(_, one)| one.resolves).fold(0.0, f64::max);
    let rank = |one: &NextMeasurement| ((best - one.resolves) / NEARLY).floor();
    all.sort_by(|(has_own, a), (has_other, b)| {
        rank(a).total_cmp(&rank(b)).then(has_other.cmp(has_own)).then(a.readings.cmp(&b.readings))
    });
    all.truncate(NAMED);
    all.into_iter().map(|(_, one)| one).collect()
}

/// Explanations that a plan can predict, the most probable first.
fn predictors<'f>(
    field: &'f Field<'_, '_>,
    found: &Contest,
    sources: &'f [EntrantSource],
    twins: &Twins,
) -> Vec<Predictor<'f>> {
    let candidate = |entrant: usize| match sources.get(entrant)? {
        EntrantSource::Known(number) => field.candidates.get(*number),
        EntrantSource::Shape(shape) => Some(&**shape),
    };
    let mut out = Vec::new();
    for one in found.explanations.iter().filter(|one| one.probability >= LEAST) {
        let mut amounts = one.posterior.mean.iter().copied();
        let width = |entrant: &usize| found.widths.get(*entrant).copied().unwrap_or(1);
        let of_terms: Vec<Vec<f64>> =
            one.set.iter().map(|entrant| amounts.by_ref().take(width(entrant)).collect()).collect();
        for (way, share) in twins.ways(&one.set) {
            let term = |(twin, amounts): (&Twin, &Vec<f64>)| {
                let one = candidate(twin.entrant).filter(|one| is_of_the_pose(one))?;
                Some((one, amounts.iter().map(|amount| amount * twin.ratio).collect()))
            };
            let terms: Option<Vec<(&Candidate, Vec<f64>)>> = way.iter().zip(&of_terms).map(term).collect();
            let Some(terms) = terms else { continue };
            let causes = CauseId::in_order(terms.iter().map(|(candidate, _)| candidate.id()).collect());
            // Variants of the same causes, such as shapes of another order, are one explanation.
            let probability = share * one.probability;
            match out.iter_mut().find(|known: &&mut Predictor<'_>| known.causes == causes) {
                Some(known) => known.probability += probability,
                None => out.push(Predictor { probability, causes, terms }),
            }
        }
    }
    out.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    out.truncate(MOST);
    out
}

/// True for a cause that depends on the position and the motion of the axes alone.
fn is_of_the_pose(one: &Candidate) -> bool {
    matches!(
        one.cause.effect,
        EffectKind::Location
            | EffectKind::Motion
            | EffectKind::Backlash
            | EffectKind::LateralPlay
            | EffectKind::Cross
            | EffectKind::Periodic
            | EffectKind::ReversalSpike
            | EffectKind::ServoMismatch
            | EffectKind::Following
    )
}

/// The longest measured tool, mm.
fn tool_length_mm(scene: &Scene<'_>) -> f64 {
    let length = |tool: &[f64; 3]| tool.iter().map(|part| part * part).sum::<f64>().sqrt();
    hundredths(scene.rows.iter().map(|row| length(&row.tool_mm)).fold(0.0, f64::max))
}

/// Every plan that the machine can carry out with this tool, and with a longer one.
fn proposals(machine: &Machine, length_mm: f64) -> Vec<Proposal> {
    let tool = |length_mm: f64| machine.spindle.axis * -length_mm;
    let longer_mm = hundredths(length_mm + LONGER);
    let named = if length_mm > 0.0 { format!(" --tool {length_mm}") } else { String::new() };
    let base =
        Wishes { tools_mm: if length_mm > 0.0 { vec![tool(length_mm)] } else { Vec::new() }, ..Wishes::default() };
    let mut out = Vec::new();
    let mut add = |kind, options: String, wishes| out.push(Proposal { kind, options, wishes });
    for (letters, plane) in [("XY", Plane::XY), ("YZ", Plane::YZ), ("ZX", Plane::ZX)] {
        add("ballbar", format!(" --plane {letters}{named}"), Wishes { planes: vec![plane], ..base.clone() });
        let [abscissa, ordinate, _] = plane.axes();
        let travel = |axis: Axis| machine.axis(axis).and_then(|data| data.travel).map(|[low, high]| high - low);
        let (Some(one), Some(other)) = (travel(abscissa), travel(ordinate)) else { continue };
        let every = (one.min(other) * PLATE_SHARE / PLATE_STEPS / 10.0).floor() * 10.0;
        // Readings without a tool vector are at the spindle nose, where no probe can be.
        let [short_mm, long_mm] = if length_mm > 0.0 { [length_mm, longer_mm] } else { [LONGER, 2.0 * LONGER] };
        if every > 0.0 {
            let wishes = Wishes {
                planes: vec![plane],
                every: Some(every),
                tools_mm: vec![tool(short_mm), tool(long_mm)],
                ..Wishes::default()
            };
            add("plate", format!(" --plane {letters} --every {every} --tool {short_mm} --tool {long_mm}"), wishes);
        }
    }
    for data in machine.axes.iter().flatten() {
        for component in components(data.axis) {
            let wishes = Wishes { axis: Some(data.axis), components: vec![component], ..base.clone() };
            add("laser", format!(" --axis {} --component {component}{named}", data.axis), wishes);
        }
    }
    add("diagonal", named.clone(), base);
    if machine.axes.iter().flatten().any(|data| data.axis.is_rotary()) {
        let wishes = Wishes { tools_mm: vec![tool(longer_mm)], ..Wishes::default() };
        add("probe", format!(" --tool {longer_mm}"), wishes.clone());
        add("rtest", format!(" --tool {longer_mm}"), wishes);
    }
    out
}

/// Components of an axis that instruments show: of a linear axis all but its roll, of a rotary axis its position.
fn components(axis: Axis) -> Vec<ErrorName> {
    let own = axis.dimension();
    if axis.is_rotary() {
        return vec![ErrorName::motion(DIRECTIONS[own + 3], axis)];
    }
    let is_shown = |direction: &name::Direction| *direction != DIRECTIONS[own + 3];
    DIRECTIONS.into_iter().filter(is_shown).map(|direction| ErrorName::motion(direction, axis)).collect()
}

/// Returns the doubt that a plan resolves, and `true` if the given readings are from its kind of instrument; `None` if the machine cannot carry it out.
fn of_plan(given: &Scene<'_>, proposal: &Proposal, compared: &[Predictor<'_>]) -> Option<(bool, NextMeasurement)> {
    let kind = plan::find(proposal.kind)?;
    let plan = (kind.build)(given.machine, &proposal.wishes).ok()?;
    let mut data = plan.as_measured();
    (data.sigma, data.sigma_rad) = (Some(LENGTH_SIGMA_MM), Some(ANGLE_SIGMA_RAD));
    let sets = [data];
    let scene = Scene::new(given.machine, &given.errors, &sets).ok()?;
    let (weights, _) = weights(&scene, sets.len());
    let mut field = Field::bare(&scene);
    let predictions: Vec<Vec<f64>> = compared
        .iter()
        .map(|one| {
            let mut values = vec![0.0; scene.items.len()];
            for (candidate, amounts) in &one.terms {
                field.know(candidate);
                for (column, amount) in field.columns(candidate).iter().zip(amounts) {
                    values.iter_mut().zip(column).for_each(|(sum, value)| *sum += amount * value);
                }
            }
            projected(&field, &weights, &values)
        })
        .collect();
    let count = weights.series.iter().max().map_or(0, |most| most + 1);
    // The error of an instrument is mostly common to a run: the readings of a run count as one.
    let distance = |one: &[f64], other: &[f64]| -> f64 {
        let mut sums = vec![(0.0, 0.0); count];
        for (((a, b), weight), &series) in one.iter().zip(other).zip(&weights.items).zip(&weights.series) {
            if let Some((square, readings)) = sums.get_mut(series) {
                *square += ((a - b) * weight).powi(2);
                *readings += 1.0;
            }
        }
        sums.iter().map(|(square, readings)| square / f64::max(*readings, 1.0)).sum()
    };
    let (mut before, mut after) = (0.0, 0.0);
    for (k, (one, own)) in compared.iter().zip(&predictions).enumerate() {
        for (other, others) in compared.iter().zip(&predictions).skip(k + 1) {
            let weight = one.probability * other.probability;
            before += weight;
            after += weight * (-distance(own, others) / 8.0).exp();
        }
    }
    let (first, second) = (predictions.first()?, predictions.get(1)?);
    let is_angle = scene.items.first()?.is_angle;
    let readings = scene.rows.len();
    let square: f64 = first.iter().zip(second).map(|(a, b)| (a - b).powi(2)).sum();
    let command = format!("ncfix plan {}{} --machine M.toml -o PLAN.csv", proposal.kind, proposal.options);
    let next = NextMeasurement {
        command,
        resolves: 1.0 - after / before,
        // The factor of a million is that of radians too.
        difference: if is_angle { 1e3 } else { 1.0 } * um_from_mm((square / scene.items.len() as f64).sqrt()),
        unit: UnitKey::of(is_angle),
        readings,
    };
    let has_instrument = given.sets.iter().any(|set| set.kind.measurand == sets[0].kind.measurand);
    next.resolves.is_finite().then_some((has_instrument, next))
}
