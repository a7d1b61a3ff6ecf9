//! Results of a measurement plan: its size, and the identifiability of model parameters, alone and together with other measurements.

use std::fmt;

use serde::Serialize;

use crate::calibrate::words::listed;
use crate::calibrate::{Column, Parameter, identify, improve};
use crate::measure::data::{DataSet, Free, Observation};
use crate::measure::plan::builder::Builder;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

/// Assumed reading of a row without one, for the identifiability.
const READ: f64 = 0.0;
/// Maximum number of shown names of parameters to be left out.
const MOST_NAMES: usize = 30;

/// The result of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlanResult {
    /// The kind of test plan.
    pub kind: String,
    /// Name of the machine.
    pub machine: String,
    /// The preset or parameter file whose identifiability is judged.
    pub model: Option<String>,
    /// Identifiability of the model, in the order of the judgements.
    pub judgements: Vec<PlanJudgement>,
    /// Parameters that only the stated tool tells: with an unknown tool they would not be determined. Empty if the tool is an unknown.
    pub from_tool: Vec<String>,
    /// Notes for the user.
    pub notes: Vec<String>,
    /// Number of table rows.
    pub rows: usize,
    /// Number of set-ups.
    pub setups: usize,
    /// Time of the moves and dwells of its program, s.
    pub duration_s: f64,
    /// True if rapid moves are not included, because an axis has no largest feed.
    pub is_without_rapids: bool,
    /// Number of stops of its program for a person.
    pub stops: usize,
}

/// The judged measurements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum JudgedPlan {
    /// The plan, and there are no other measurements.
    Plan,
    /// The plan without the other existing measurements.
    Alone,
    /// The plan with this number of other measurements.
    WithOthers(usize),
    /// As [`JudgedPlan::WithOthers`], with this number of additional poses.
    WithMorePoses(usize),
}

/// Identifiability of the parameters of a model from measurements.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlanJudgement {
    /// The judged measurements.
    pub of: JudgedPlan,
    /// The result; `null` if positions are too large for a judgement.
    pub determined: Option<Determined>,
}

/// Number of determined unknowns, and the unidentifiable ones.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Determined {
    /// Number of model parameters.
    pub parameters: usize,
    /// Number of set-up unknowns.
    pub unknowns: usize,
    /// Number of determined combinations of both.
    pub rank: usize,
    /// Number of parameters and unknowns.
    pub columns: usize,
    /// Condition number: largest to smallest nonzero singular value.
    pub condition: f64,
    /// Unidentifiable parameters, with remedies.
    pub not_identifiable: Vec<NotIdentifiable>,
    /// Combinations of set-up unknowns alone, which are harmless; empty if parameters must be left out.
    pub harmless: Vec<String>,
    /// Number of parameters to be left out so that all others are determined.
    pub left_out: usize,
    /// Their names, as far as shown.
    pub left_out_names: String,
}

/// Parameters that are not identifiable for one reason.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NotIdentifiable {
    /// The sentence about them.
    pub sentence: String,
    /// The remedy.
    pub remedy: String,
}

/// Reason why a plan cannot be judged for a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PlanNotJudged {
    /// Its readings do not depend on the geometry.
    NotGeometric,
    /// It has no further poses.
    NoCandidates,
    /// A further pose is unreachable: the reason.
    NoWay(String),
}

impl fmt::Display for PlanNotJudged {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PlanNotJudged::NotGeometric => {
                out.write_str("this plan does not measure the parameters of a preset; remove --model")
            }
            PlanNotJudged::NoCandidates => {
                out.write_str("this plan has no further poses to choose from; remove --improve")
            }
            PlanNotJudged::NoWay(reason) => write!(out, "no path to a further pose: {reason}"),
        }
    }
}

impl std::error::Error for PlanNotJudged {}

/// Judges the identifiability of parameters from a plan together with other measurements, and adds the `more` most helpful poses.
///
/// # Errors
/// An error if it does not measure them, or there are no further poses.
pub fn judge(
    plan: &mut Builder,
    others: Vec<DataSet>,
    parameters: &[Parameter],
    more: usize,
    (machine, errors): (&Machine, &ErrorModel),
) -> Result<Vec<PlanJudgement>, PlanNotJudged> {
    if !plan.is_geometric {
        return Err(PlanNotJudged::NotGeometric);
    }
    let judged = |of: JudgedPlan, data: &[DataSet]| PlanJudgement {
        of,
        determined: determined((machine, errors), parameters, data),
    };
    let mut all = vec![as_read(plan)];
    let mut judgements = Vec::new();
    let who = match others.len() {
        0 => JudgedPlan::Plan,
        count => {
            judgements.push(judged(JudgedPlan::Alone, &all));
            all.extend(others);
            JudgedPlan::WithOthers(count)
        }
    };
    judgements.push(judged(who, &all));
    if more > 0 {
        if plan.candidates.is_empty() {
            return Err(PlanNotJudged::NoCandidates);
        }
        let mut candidates = plan.candidates.clone();
        for candidate in &mut candidates {
            candidate.values = values(plan.reads);
        }
        for chosen_one in improve(machine, errors, parameters, &all, &candidates, more) {
            if let Some(candidate) = plan.candidates.get(chosen_one).copied() {
                plan.visit(&candidate, "more").map_err(|reason| PlanNotJudged::NoWay(reason.to_string()))?;
            }
        }
        if let Some(own) = all.first_mut() {
            *own = as_read(plan);
        }
        judgements.push(judged(JudgedPlan::WithMorePoses(more), &all));
    }
    Ok(judgements)
}

/// The parameters that a plan with other measurements determines only because its tool is stated: those that are lost if one tool vector of all rows is
/// an unknown. An error of the stated length is then an error of these parameters.
#[must_use]
pub fn told_by_tool(
    plan: &Builder,
    others: &[DataSet],
    parameters: &[Parameter],
    (machine, errors): (&Machine, &ErrorModel),
) -> Vec<String> {
    let own = as_read(plan);
    if !own.kind.free.contains(&Free::Tool) || own.free.contains(&Free::Tool) {
        return Vec::new();
    }
    let mut freed = own.clone();
    freed.free.push(Free::Tool);
    freed.setups.truncate(1);
    freed.observations.iter_mut().for_each(|row| row.setup = 0);
    let lost = |data: DataSet| {
        let all: Vec<DataSet> = std::iter::once(data).chain(others.iter().cloned()).collect();
        let told = identify(machine, errors, parameters, &all);
        let names = told.map_or_else(Vec::new, |told| told.lost.leave_out);
        names.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let known = lost(own);
    lost(freed).into_iter().filter(|name| !known.contains(name)).collect()
}

/// The identifiability from measurements; `None` if their positions are too large.
fn determined(
    (machine, errors): (&Machine, &ErrorModel),
    parameters: &[Parameter],
    data: &[DataSet],
) -> Option<Determined> {
    let told = identify(machine, errors, parameters, data)?;
    let lost = &told.lost;
    let reason = |one: &crate::calibrate::words::Confused| NotIdentifiable {
        sentence: one.sentence.clone(),
        remedy: one.remedy.clone(),
    };
    Some(Determined {
        parameters: parameters.len(),
        unknowns: told.columns.iter().filter(|column| matches!(column, Column::Unknown(..))).count(),
        rank: told.rank,
        columns: told.columns.len(),
        condition: told.condition,
        not_identifiable: lost.confused.iter().map(reason).collect(),
        harmless: if lost.leave_out.is_empty() { lost.unknowns.clone() } else { Vec::new() },
        left_out: lost.leave_out.len(),
        left_out_names: listed(&lost.leave_out, MOST_NAMES),
    })
}

/// `true` if a row has a reading: a value, or a position at a ball. A table without any such row is a plan.
#[must_use]
pub fn has_reading(row: &Observation) -> bool {
    row.values.iter().any(Option::is_some) || row.target.is_some() && row.component.is_none()
}

/// The measurement as if it had been carried out.
fn as_read(plan: &Builder) -> DataSet {
    let mut read = plan.data.clone();
    for (row, extra) in read.observations.iter_mut().zip(&plan.extras) {
        row.values = values(plan.reads_of(extra));
    }
    read
}

fn values(reads: [bool; 3]) -> [Option<f64>; 3] {
    reads.map(|is_read| is_read.then_some(READ))
}
