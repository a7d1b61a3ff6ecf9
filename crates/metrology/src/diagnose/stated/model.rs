//! Stated terms as parts of a model: a joint fit determines their amounts and the changes of the machine file.

use super::super::cause::{Candidate, Causes, Term, UNNAMED, Weight};
use super::super::extend::{self, Change};
use super::super::readings::{even_out, left_of, weights};
use super::super::scene::{Scene, Through};
use super::super::search::{Field, Taken, Weights};
use super::super::size::EXPANDED;
use super::super::verdict::{AcceptedCause, Settled, propose};
use super::form::{StatedContent, StatedHypothesis, TermAmount};
use super::subject::{amounts, enter, subject};
use super::variant::variant;
use ncfix_machine::machine::State;
use ncfix_model::ParameterName;
use ncfix_model::parameter::ComponentTerm;

/// A stated term in a model.
#[derive(Clone, Debug)]
pub enum ModelTerm {
    /// Parameters of the machine file, which a calibration fits like any others.
    Parameters(Vec<ParameterName>),
    /// Changes of the machine file from a fit of the readings, with the amounts of the terms.
    Changes(Vec<Change>, Vec<TermAmount>),
}

/// The reason why a calibration cannot take a stated term.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TermRefusal {
    /// The readings do not determine its amount.
    NotIdentified(String),
    /// The readings may determine it, but the machine file has no entry for it.
    NotStorable(String),
}

/// Stated terms as parts of a model.
#[derive(Clone, Debug, Default)]
pub struct StatedModel {
    /// Each term, or the reason why it cannot be fitted.
    pub terms: Vec<Result<ModelTerm, TermRefusal>>,
    /// The factors by which the terms that become shapes of the file enlarge the uncertainties of the parameters.
    pub growth: Vec<(ParameterName, f64)>,
    /// Ratio of the residual to the scatter of repeated readings, if the model surely lacks an error.
    pub lack: Option<f64>,
}

/// Fits stated terms to all readings of a scene, together with the parameters `beside` of a model; `bare` contains the readings without any model.
///
/// The amounts are those of least squares, as of a parameter, and do not depend on the order of the rows. An error that the model lacks would pass for
/// autocorrelated noise, and change them with the order.
#[must_use]
pub fn stated_model(
    stated: &[StatedHypothesis],
    beside: &[ParameterName],
    causes: &Causes,
    scene: &Scene<'_>,
    bare: &Scene<'_>,
) -> StatedModel {
    let has_names = stated.iter().any(|one| matches!(one.statement, StatedContent::Named(..)));
    let mut field = if has_names { Field::new(scene, propose(causes, scene)) } else { Field::new(scene, Vec::new()) };
    let used = scene.sets.len();
    let (mut own, held_out) = weights(scene, used);
    let mut kept: Vec<(Taken, f64)> =
        beside.iter().map(|&name| (taken(enter(&mut field, of_parameter(name))), 0.0)).collect();
    let mut subjects = Vec::new();
    // The noise of the measurements is determined with all terms fitted.
    let known = field.candidates.len();
    for is_last in [false, true] {
        field.candidates.truncate(known);
        let mut outcome = Settled::open(&mut field, [&own, &held_out], (causes, bare, used));
        let beside: Vec<usize> = kept.iter().map(|(one, _)| one.candidate).collect();
        subjects = stated.iter().map(|one| subject(one, &mut outcome, &beside)).collect();
        if is_last {
            break;
        }
        let numbers: Vec<usize> =
            kept.iter().map(|(one, _)| one.candidate).chain(subjects.iter().flatten().map(|one| one.number)).collect();
        let left = left_of(&field, &own, &numbers);
        even_out(scene, &mut own, &left);
    }
    kept.extend(subjects.iter().flatten().map(|one| (taken(one.number), 0.0)));
    own.series = (0..own.items.len()).collect();
    let found = Settled::open(&mut field, [&own, &held_out], (causes, bare, used)).verdict_of(&kept);
    let key = |one: &Candidate| one.columns.first().and_then(|parts| parts.first()).map(|(_, weight)| weight.key());
    let of = |one: Result<super::subject::StatedSubject, String>| {
        let lost = |why: &str| TermRefusal::NotIdentified(why.to_owned());
        let one = one.map_err(TermRefusal::NotIdentified)?;
        let candidate = field.candidates.get(one.number).ok_or_else(|| lost("it has no effect"))?;
        if let Term::Parameters(names) = &candidate.term {
            return Ok(ModelTerm::Parameters(names.clone()));
        }
        let is_own = |own: &&AcceptedCause| key(&own.candidate) == key(candidate);
        let accepted = found.findings.iter().find(is_own);
        let accepted = accepted.ok_or_else(|| lost("the readings do not determine its size"))?;
        let changes = extend::of_stated(accepted, scene, used).map_err(TermRefusal::NotStorable)?;
        let of_variant =
            variant(candidate).filter(|_| one.variants > 1).map_or_else(String::new, |own| format!(": {own}"));
        let mut amounts = amounts(&(candidate.title() + &of_variant), &one, accepted);
        let all: Vec<usize> = kept.iter().map(|(one, _)| one.candidate).collect();
        if let Some(share) = uncorrelated(&field, &own, one.number, &all, accepted) {
            amounts.iter_mut().for_each(|amount| amount.sigma = amount.u95 / EXPANDED * share);
        }
        Ok(ModelTerm::Changes(changes, amounts))
    };
    let numbers: Vec<Option<usize>> = subjects.iter().map(|one| Some(one.as_ref().ok()?.number)).collect();
    let out: Vec<Result<ModelTerm, TermRefusal>> = subjects.into_iter().map(of).collect();
    let is_shape = |one: &Result<ModelTerm, TermRefusal>| matches!(one, Ok(ModelTerm::Changes(changes, _)) if changes.iter().any(|change| matches!(change, Change::Shape { .. })));
    let shapes: Vec<usize> =
        out.iter().zip(numbers).filter(|(one, _)| is_shape(one)).filter_map(|(_, number)| number).collect();
    let parameters: Vec<usize> = kept.iter().take(beside.len()).map(|(one, _)| one.candidate).collect();
    let growth = beside.iter().zip(growth(&field, &own, &parameters, &shapes));
    let growth = growth.map(|(&name, factor)| (name, factor)).collect();
    let all: Vec<usize> = kept.iter().map(|(one, _)| one.candidate).collect();
    StatedModel { terms: out, growth, lack: field.lack_of_fit(&own, &all) }
}

/// Standard uncertainty of the size of a term for uncorrelated readings, as a share of the one that includes other explanations: that of a parameter in the
/// same fit does not include them either. Where the residual repeats at the poses, it grows. `None` if the readings do not determine the size.
fn uncorrelated(
    field: &Field<'_, '_>,
    own: &Weights,
    number: usize,
    all: &[usize],
    accepted: &AcceptedCause,
) -> Option<f64> {
    let whole = field.series(own, all, 0.0);
    let freedom = whole.count().checked_sub(whole.rank()).filter(|freedom| *freedom > 0)?;
    let others: Vec<usize> = all.iter().copied().filter(|&other| other != number).collect();
    let mut series = field.series(own, &others, 0.0);
    let columns = field.columns_of(number);
    columns.iter().skip(1).for_each(|column| {
        series.take(column);
    });
    series.set_values(columns.first()?);
    let sigma = (whole.squares() / freedom as f64 / series.squares()).sqrt();
    let amount = accepted.amounts.values.first().copied().filter(|amount| *amount != 0.0)?;
    let with = accepted.size.u95 / EXPANDED / accepted.size.value.abs() * amount.abs();
    let with = with.max(accepted.amounts.u95(0) / EXPANDED);
    let growth = field.growth_by_poses(own, all, &others, number).sqrt();
    Some((sigma / with).min(1.0) * growth).filter(|share| share.is_finite() && *share > 0.0)
}

/// Factors of the standard uncertainties of parameters if shapes are fitted together with them: of each column, less remains beside all others.
fn growth(field: &Field<'_, '_>, own: &Weights, parameters: &[usize], shapes: &[usize]) -> Vec<f64> {
    let remains = |number: usize, others: &[usize]| -> f64 {
        let mut series = field.series(own, others, 0.0);
        field.columns_of(number).first().map_or(0.0, |column| {
            series.set_values(column);
            series.squares()
        })
    };
    let of = |&number: &usize| {
        let others: Vec<usize> = parameters.iter().copied().filter(|&other| other != number).collect();
        let with: Vec<usize> = others.iter().chain(shapes).copied().collect();
        let [alone, together] = [others, with].map(|others| remains(number, &others));
        if together > 0.0 { (alone / together).sqrt().max(1.0) } else { 1.0 }
    };
    if shapes.is_empty() { vec![1.0; parameters.len()] } else { parameters.iter().map(of).collect() }
}

fn taken(candidate: usize) -> Taken {
    Taken { candidate, chance: 0.0 }
}

/// Candidate with the effect of a parameter of the machine file.
fn of_parameter(name: ParameterName) -> Candidate {
    let axis = name.component.axis();
    let weight = match name.term {
        ComponentTerm::Backlash => Weight::new(move |row| axis.map_or(0.0, |axis| row.sense_of(axis))),
        _ => Weight::new(move |row| name.weight(&row.position, &State::default())),
    };
    Candidate::one(&UNNAMED, name, Through::Component(name.component), weight)
}
