//! Measurement plans: rows, the program that runs them, and the parameters of a model that they determine.

use std::path::PathBuf;

use crate::diagnostics::Diagnostics;
use crate::disk::{measurements, parameters};
use crate::error::Error;
use crate::machine::Machine;
use ncfix_metrology::measure::data::DataSet;
use ncfix_metrology::measure::plan::builder::PlannedPart;
use ncfix_metrology::measure::plan::duration::{PlanTime, duration};
use ncfix_metrology::measure::plan::{PlanKind, Wishes, table};
use ncfix_metrology::results::planned::{PlanResult, has_reading, judge, told_by_tool};
use ncfix_path::emit::{PartFrame, flat, flat_part};

/// The request for a plan.
#[derive(Clone, Debug)]
pub(crate) struct PlanRequest<'a> {
    /// The kind of test plan.
    pub(crate) kind: &'static PlanKind,
    /// The options of the plan.
    pub(crate) wishes: &'a Wishes,
    /// True if a seed was given.
    pub(crate) is_seeded: bool,
    /// A preset or a file with the parameters that the plan is to determine.
    pub(crate) model: Option<&'a str>,
    /// Tables of existing measurements and plans.
    pub(crate) with: &'a [PathBuf],
    /// Poses that are added for the model.
    pub(crate) more: usize,
    /// True if a program is to be written.
    pub(crate) has_program: bool,
}

/// A finished plan.
#[derive(Clone, Debug)]
pub(crate) struct MadePlan {
    /// The result.
    pub(crate) result: PlanResult,
    /// The table of poses.
    pub(crate) table: String,
    /// Its description.
    pub(crate) description: String,
    /// The program that runs the poses, if requested.
    pub(crate) program: Option<Vec<u8>>,
}

impl PlanRequest<'_> {
    /// Makes the plan; `None` if there are errors.
    ///
    /// # Errors
    /// If there is no such plan on this machine, a file cannot be read, or the parameters of the model cannot be evaluated for it.
    pub(crate) fn run(&self, chosen: &Machine, found: &mut Diagnostics) -> Result<Option<MadePlan>, Error> {
        chosen.check_one_head()?;
        let machine = &chosen.machine;
        self.kind.check(self.wishes, self.is_seeded, machine).map_err(|reason| Error::usage(reason.to_string()))?;
        let refused = |reason: String| Error::usage(format!("plan {} is not possible: {reason}", self.kind.name));
        let head = machine.heads.first().filter(|_| machine.heads.len() > 1);
        let mut plan = (self.kind.build)(machine, self.wishes).map_err(|reason| refused(reason.to_string()))?;
        plan.data.head = head.map(|head| head.name.clone());
        let Some(others) = others(self.with, chosen, found)? else { return Ok(None) };
        let mut result = PlanResult {
            kind: self.kind.name.to_owned(),
            machine: machine.name.clone(),
            model: self.model.map(str::to_owned),
            ..PlanResult::default()
        };
        if let Some(name) = self.model {
            let Some(parameters) = parameters::choose(name, machine, &chosen.errors, found)? else { return Ok(None) };
            let scene = (machine, &chosen.errors);
            result.from_tool = told_by_tool(&plan, &others, &parameters, scene);
            let judged = judge(&mut plan, others, &parameters, self.more, scene);
            result.judgements = judged.map_err(|reason| Error::usage(reason.to_string()))?;
        }
        result.notes.clone_from(&plan.notes);
        result.rows = plan.data.observations.len();
        result.setups = plan.data.setups.len();
        let PlanTime { seconds, stops, is_without_rapids } = duration(&plan);
        (result.duration_s, result.stops, result.is_without_rapids) = (seconds, stops, is_without_rapids);
        let title = format!("plan {} for {}", self.kind.name, machine.name);
        let written = || match &plan.part {
            Some(PlannedPart { zero_offset, origin_mm, tool, tool_mm }) => {
                let (zero_offset, origin_mm) = (zero_offset.clone(), *origin_mm);
                let frame = PartFrame { zero_offset, origin_mm, tool: *tool, tool_mm: *tool_mm };
                flat_part(machine, &title, &plan.path, &frame)
            }
            None => flat(machine, &title, &plan.path),
        };
        let program = self.has_program.then(written).transpose().map_err(refused)?;
        let (table, description) = (table::csv(&plan), table::toml(&plan));
        Ok((!found.has_errors()).then_some(MadePlan { result, table, description, program }))
    }
}

/// Existing measurements and plans; `None` if a table is neither. Empty cells of a measurement are missing readings; a table without any reading is a
/// plan.
fn others(tables: &[PathBuf], chosen: &Machine, found: &mut Diagnostics) -> Result<Option<Vec<DataSet>>, Error> {
    let machine = &chosen.machine;
    let mut out = Vec::new();
    let mut is_sound = true;
    for (number, table) in tables.iter().enumerate() {
        let made = measurements::read(table, number, false, machine, &mut Diagnostics::default())?;
        let made = made.filter(|one| one.data.observations.iter().any(has_reading));
        let read = if made.is_some() { made } else { measurements::read(table, number, true, machine, found)? };
        match read {
            Some(read) => out.push(read.data),
            None => is_sound = false,
        }
    }
    Ok(is_sound.then_some(out))
}
