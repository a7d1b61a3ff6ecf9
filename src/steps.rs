//! The largest fixed step for the subdivision of moves, over the working volume or along a program.

use std::collections::BTreeMap;

use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use crate::program::Program;
use crate::run::{self, Watch};
use crate::tool::ToolVector;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, Axis, AxisKey, AxisVector};
use ncfix_base::source::Source;
use ncfix_base::units::um_from_mm;
use ncfix_language::exec::RapidOrder;
use ncfix_path::path::{Moves, ResidualSteps, Rotary, StepTrial, Steps, StraightLine, volume};
use ncfix_report::steps::{StepAnswer, StepReport, StepRow, Worst};

/// The options of the search.
#[derive(Clone, Debug)]
pub(crate) struct StepSearch<'a> {
    /// The program whose moves are searched; without it, lines through the whole travel.
    pub(crate) program: Option<&'a Program>,
    /// The tool; without it that of the longest tool of the machine file, or those of the program.
    pub(crate) tool: Option<ToolVector>,
    /// Largest residual allowed, mm.
    pub(crate) residual_mm: f64,
    /// Participation of rotary axes in the correction.
    pub(crate) rotary: Rotary,
}

/// Lines, with the program that they belong to.
struct Gathered<'m> {
    lines: Vec<StraightLine>,
    trial: StepTrial<'m>,
    files: Vec<Source>,
}

impl StepSearch<'_> {
    /// Runs the search; the report has no answer if there are errors. `share` receives the progress, 0 to 1.
    ///
    /// # Errors
    /// If the dialect does not exist, or there is neither a program nor travel.
    pub(crate) fn run(
        &self,
        machine: &Machine,
        watch: Option<fn() -> Box<dyn Watch>>,
        share: impl FnMut(f64),
        found: &mut Diagnostics,
    ) -> Result<StepReport, Error> {
        machine.check_one_head()?;
        let model = machine.model();
        let trial = StepTrial::new(&model, self.rotary);
        let mut report = StepReport { machine: machine.machine.name.clone(), ..self.empty() };
        let gathered = match self.program {
            Some(program) => {
                let Some(gathered) = self.gather((program, machine), trial, watch, found, &mut report)? else {
                    return Ok(report);
                };
                gathered
            }
            None => {
                let longest_mm =
                    || machine.machine.tools.iter().map(|tool| tool.length_mm[0].abs()).fold(0.0, f64::max);
                let tool_mm = self.tool.unwrap_or_else(|| ToolVector::Length(longest_mm())).vector_mm(&machine.machine);
                report.tool_length_mm = Some(tool_mm.norm());
                Gathered { lines: volume(&machine.machine, &tool_mm), trial, files: Vec::new() }
            }
        };
        let Gathered { lines, mut trial, files } = gathered;
        if self.program.is_none() && lines.is_empty() {
            return Err(Error::usage(
                "no axis of the machine has travel limits, so there is no volume to examine; give a program".into(),
            ));
        }
        let steps = trial.search(&lines, self.residual_mm, share);
        if steps.worst.failures > 0 && steps.rows.last().is_some_and(|row| row.largest_mm == 0.0) {
            let message = "no correction was found on any line";
            let help = "check the error model: a coefficient in a wrong unit is the usual reason; then check that the machine can move the tool in all directions";
            found.add(Diagnostic::nowhere(Code::NOT_CONVERGED, message, help), &[]);
            return Ok(report);
        }
        note(&mut report, &steps, &lines, &files, machine);
        Ok(report)
    }

    /// A report without an answer.
    pub(crate) fn empty(&self) -> StepReport {
        StepReport { residual_limit_um: um_from_mm(self.residual_mm), ..StepReport::default() }
    }

    /// Executes the program and gathers its moves; `None` if there are errors.
    fn gather<'m>(
        &self,
        (program, machine): (&Program, &'m Machine),
        trial: StepTrial<'m>,
        watch: Option<fn() -> Box<dyn Watch>>,
        found: &mut Diagnostics,
        report: &mut StepReport,
    ) -> Result<Option<Gathered<'m>>, Error> {
        let Some(opened) = program.open(Some(machine), found)? else { return Ok(None) };
        let mut running = program.start_as(opened, &machine.machine, run::strict(RapidOrder::All));
        if let Some(watch) = watch {
            running = running.watched(watch());
        }
        let fixed_tool_mm = self.tool.map(|tool| tool.vector_mm(&machine.machine));
        let mut moves = Moves::new(&machine.machine, trial, fixed_tool_mm);
        if let Some(start) = program.reading().start {
            moves.start_at(start);
        }
        while let Some(item) = running.next() {
            match item {
                Ok(element) => moves.note(&element),
                Err(diagnostic) => found.add(diagnostic, running.sources()),
            }
            if found.is_hopeless() {
                break;
            }
        }
        if found.has_errors() {
            return Ok(None);
        }
        report.tool_length_mm = fixed_tool_mm.map(|tool_mm| tool_mm.norm());
        (report.moves, report.arcs) = (Some(moves.lines), Some(moves.arcs));
        let (lines, trial) = moves.finish();
        Ok(Some(Gathered { lines, trial, files: running.sources().to_vec() }))
    }
}

/// Enters the result in the report.
fn note(report: &mut StepReport, steps: &Steps, lines: &[StraightLine], files: &[Source], machine: &Machine) {
    (report.answer, report.largest_step_mm) = match steps.answer {
        ResidualSteps::Any => (Some(StepAnswer::Any), None),
        ResidualSteps::UpTo(step_mm) => (Some(StepAnswer::UpTo), Some(step_mm)),
        ResidualSteps::None => (Some(StepAnswer::None), None),
    };
    report.residual_um = um_from_mm(steps.worst.max_mm);
    report.failures = steps.worst.failures;
    report.lines = lines.len() as u64;
    report.steps = steps
        .rows
        .iter()
        .map(|row| StepRow {
            step_mm: row.step_mm,
            residual_um: um_from_mm(row.residual_mm),
            largest_um: um_from_mm(row.largest_mm),
        })
        .collect();
    let place = |position: &AxisVector| {
        let axes = AXES.into_iter().filter(|&axis| machine.machine.axis(axis).is_some());
        let entry = |axis: Axis| {
            let key = AxisKey::of_position(axis);
            (key, key.shown(position[axis]))
        };
        axes.map(entry).collect::<BTreeMap<_, _>>()
    };
    report.worst = lines.get(steps.worst.line).filter(|_| steps.worst.max_mm > 0.0).map(|line| Worst {
        at: place(&steps.worst.at),
        from: place(line.start()),
        to: place(line.end()),
        file: line
            .origin
            .and_then(|origin| files.iter().find(|source| source.id() == origin.file))
            .map(|source| source.name().to_owned()),
        line: line.origin.map(|origin| origin.line),
    });
}
