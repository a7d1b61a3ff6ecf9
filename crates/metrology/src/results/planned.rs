//! A plan of a measurement: how large it is, and what it tells of the parameters of a model, alone and together with others.

use std::fmt;

use serde::Serialize;

use crate::calibrate::words::listed;
use crate::calibrate::{Column, Parameter, identify, improve};
use crate::measure::data::{DataSet, Observation};
use crate::measure::plan::builder::Builder;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

/// What a row without a reading is taken for when it is asked what it tells.
const READ: f64 = 0.0;
/// Names that are shown of those that would have to be left out.
const MOST_NAMES: usize = 30;

/// A plan that was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlanResult {
    /// The kind of measurement.
    pub kind: String,
    /// Name of the machine.
    pub machine: String,
    /// The preset or file of parameters that the measurement shall tell.
    pub model: Option<String>,
    /// What is told of the model, in the order in which it was asked.
    pub judgements: Vec<PlanJudgement>,
    /// What a person should know.
    pub notes: Vec<String>,
    /// Rows of the table.
    pub rows: usize,
    /// Set-ups.
    pub setups: usize,
}

/// Which measurements are asked about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum JudgedPlan {
    /// The plan, and there is nothing beside it.
    Plan,
    /// The plan without the others that there are.
    Alone,
    /// The plan with this many others.
    WithOthers(usize),
    /// The same with this many poses more.
    WithMorePoses(usize),
}

/// What measurements tell of the parameters of a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlanJudgement {
    /// Which measurements.
    pub of: JudgedPlan,
    /// What they tell; `null` where positions are too large to judge it.
    pub determined: Option<Determined>,
}

/// How many unknowns are determined, and what is not.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Determined {
    /// Parameters of the model.
    pub parameters: usize,
    /// Unknowns of the set-ups.
    pub unknowns: usize,
    /// How many combinations of both are determined.
    pub rank: usize,
    /// Both together.
    pub columns: usize,
    /// Largest by smallest singular value that is not zero.
    pub condition: f64,
    /// What is not identifiable, and what would help.
    pub not_identifiable: Vec<NotIdentifiable>,
    /// Combinations of unknowns of set-ups alone, which do no harm; empty where parameters have to be left out.
    pub harmless: Vec<String>,
    /// How many parameters have to be left out so that all others are determined.
    pub left_out: usize,
    /// Their names, as far as they are shown.
    pub left_out_names: String,
}

/// Parameters that are not identifiable for one reason.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NotIdentifiable {
    /// What cannot be told from what.
    pub sentence: String,
    /// What would help.
    pub remedy: String,
}

/// Why a plan cannot be asked about a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PlanNotJudged {
    /// Its readings are not of the geometry.
    NotGeometric,
    /// It has no further poses.
    NoCandidates,
    /// A further pose cannot be reached: why.
    NoWay(String),
}

impl fmt::Display for PlanNotJudged {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PlanNotJudged::NotGeometric => {
                out.write_str("this plan is no measurement of a preset's parameters; leave --model out")
            }
            PlanNotJudged::NoCandidates => {
                out.write_str("this plan has no further poses to choose from; leave --improve out")
            }
            PlanNotJudged::NoWay(reason) => write!(out, "no way to a further pose: {reason}"),
        }
    }
}

impl std::error::Error for PlanNotJudged {}

/// Asks what a plan tells of parameters, together with other measurements, and adds the `more` poses that help most.
///
/// # Errors
/// Where it is no measurement of them, or there are no further poses.
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
            candidate.values = values(plan);
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

/// What measurements determine; `None` where their positions are too large.
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

/// Whether something was read in a row: a value, or the position at a ball. A table without any such row is a plan.
#[must_use]
pub fn has_reading(row: &Observation) -> bool {
    row.values.iter().any(Option::is_some) || row.target.is_some() && row.component.is_none()
}

/// The measurement as if it had been made.
fn as_read(plan: &Builder) -> DataSet {
    let mut read = plan.data.clone();
    let values = values(plan);
    for row in &mut read.observations {
        row.values = values;
    }
    read
}

fn values(plan: &Builder) -> [Option<f64>; 3] {
    plan.reads.map(|is_read| is_read.then_some(READ))
}
