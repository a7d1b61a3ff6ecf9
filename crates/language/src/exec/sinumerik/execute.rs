//! Starts a program, and executes its blocks.

use super::flow;
use super::spline;
use super::startup;
use std::collections::HashMap;

use super::channel::Channel;
use super::contour_call::NamedContours;
use super::level::{Action, CallForm, CalledWith, Entry, Interpreter, Level, Loaded, ReturnTarget, Sinumerik};
use super::library::read_definitions;
use super::loaded::load;
use super::parameters;
use crate::exec::core;
use crate::exec::core::executor::Executor;
use crate::exec::core::fault::Fault;
use crate::exec::core::interpreter::Execute;
use crate::exec::core::library::Library;
use crate::exec::core::options::Options;
use crate::exec::core::program::Statement;
use crate::exec::core::run_state::RunState;
use crate::syntax::sinumerik::{self, Block, Macros, Program};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Kind, Origin};

/// State of a run in addition to the channel.
pub(super) struct SinumerikRun {
    /// Macros of the definition files, which are valid in every program.
    pub(super) macros: Macros,
    /// Programs of the texts executed by EXECSTRING.
    pub(super) texts: HashMap<Vec<u8>, usize>,
    /// The program of MCALL.
    pub(super) modal_call: Option<Entry>,
    /// Contours that CYCLE62 has named for the next milling cycle.
    pub(super) contours: NamedContours,
}

/// Starts a program. The caller handles syntax diagnostics of the main program; faulty blocks have no effect here.
pub(in crate::exec) fn start<'a>(
    program: Program,
    machine: &'a Machine,
    mut library: Box<dyn Library + 'a>,
    options: &Options,
) -> Box<dyn Executor + 'a> {
    let main = program
        .sections
        .iter()
        .position(|section| section.ending == "MPF" && !section.blocks.is_empty())
        .or_else(|| program.sections.iter().position(|section| section.ending != "DEF" && !section.blocks.is_empty()))
        .unwrap_or(0);
    let mut channel = startup::begin(machine, options, program.dialect.codes());
    let source = program.source.clone();
    if let Some(section) = program.sections.get(main) {
        for &header in &section.headers {
            channel.begin_block(Origin { file: source.id(), line: 1, span: header, calls: 0 }, None);
            channel.push(Kind::Header(source.slice(header).to_vec()));
        }
    }
    let start = program.sections.get(main).map_or(0, |section| section.blocks.start);
    let is_main = |section: &&sinumerik::Section| section.ending == "MPF" && !section.blocks.is_empty();
    let mut ledger = RunState::new(source, program.blocks.len(), options);
    if let Some(other) = program.sections.iter().filter(is_main).nth(1) {
        let span = other.headers.first().copied().unwrap_or_default();
        let message = format!("the main program {} is ignored: only the first one of a file is executed", other.name);
        let help = "put each main program into its own file";
        ledger.findings.push_back(Diagnostic::at(
            Code::MORE_PROGRAMS,
            Place { file: program.source.id(), span },
            message,
            help,
        ));
    }
    let macros = read_definitions(library.as_mut(), &program, &mut channel, &mut ledger.sources);
    let loaded = load(program, &machine.control);
    // A subprogram that is run directly has the defaults of its parameters.
    if let Err(found) = parameters::bind(&loaded, &mut channel, loaded.parameters(main), &[]) {
        ledger.findings.push_back(found.in_file(loaded.program.source.id()));
    }
    let run = SinumerikRun { macros, texts: HashMap::new(), modal_call: None, contours: NamedContours::default() };
    let level = Level::new(0, main, start, 0, CalledWith::default());
    Box::new(Interpreter::start(machine, library, ledger, (channel, run), (loaded, level)))
}

impl Execute for Sinumerik {
    type Channel<'a> = Channel<'a>;
    type Run = SinumerikRun;

    fn parse(run: &Interpreter<'_>, source: &Source) -> (Program, Vec<Diagnostic>) {
        sinumerik::parse_with(source, run.programs[0].program.dialect, &run.own.macros)
    }

    fn end_of(_: &Channel<'_>, file: &Loaded, level: &Level) -> usize {
        // An empty file has no section.
        file.program.sections.get(level.part).map_or(0, |section| section.blocks.end)
    }

    fn begin(run: &mut Interpreter<'_>, block: &Block, own: Origin) {
        let Some(level) = run.levels.last() else { return };
        let cycle = level.own.cycle;
        let origin = cycle.map_or(own, |cycle| cycle.origin);
        run.channel.begin_block(origin, Statement::number(block));
        if let Some(label) = block.label.filter(|_| own.calls == 0 && cycle.is_none()) {
            let label = run.programs[level.program].program.names.text(label).as_bytes().to_vec();
            run.channel.push(Kind::Label(label));
        }
    }

    fn block(run: &mut Interpreter<'_>, block: &Block, index: usize) -> Result<Action, Fault> {
        let core::interpreter::Runner { machine, programs, levels, channel, .. } = run;
        let Some(level) = levels.last_mut() else { return Ok(Action::Next) };
        let loaded = &mut programs[level.program];
        let comment = loaded.take_comment(index, block);
        let section = loaded.program.sections.get(level.part).map_or(0..0, |section| section.blocks.clone());
        channel.variables.fixed.mute(loaded.own.built_in.is_some());
        let action = flow::block(loaded, level, channel, block, index, section, comment, machine);
        flow::note_looks(&channel.system, &mut channel.outlet);
        action
    }

    fn modal_call(run: &mut Interpreter<'_>, block: &Block) -> Result<bool, Fault> {
        if run.own.modal_call.is_none() {
            return Ok(false);
        }
        if !run.channel.block.has_moved {
            return run.check_still_block(block).map(|()| false);
        }
        Ok(run.trigger(block))
    }

    fn check_repetition(run: &Interpreter<'_>, span: Span) -> Result<(), Fault> {
        run.check_depth("the repetition", span)
    }

    fn call(run: &mut Interpreter<'_>, call: CallForm, block: &Block) -> Result<(), Fault> {
        match call {
            CallForm::Word(call) => run.call(&call, block),
            CallForm::Statement(place) => {
                let program = run.levels.last().map_or(0, |level| level.program);
                let statement = run.programs[program].program.calls[place as usize];
                run.call_statement(&statement, block)
            }
        }
    }

    fn return_to(run: &mut Interpreter<'_>, target: ReturnTarget, span: Span) -> Result<(), Fault> {
        run.return_to(&target, span)
    }

    fn end_of_program(run: &mut Interpreter<'_>, end: Option<u32>) {
        run.end_of_program(end);
    }

    fn end_of_blocks(run: &mut Interpreter<'_>) {
        run.end_of_program(None);
    }

    fn behind_fault(run: &mut Interpreter<'_>) {
        run.leave_cycle();
    }

    fn as_seen_by_user(run: &Interpreter<'_>, finding: Diagnostic) -> Diagnostic {
        run.as_seen_by_user(finding)
    }

    fn finish(run: &mut Interpreter<'_>) {
        spline::finish(&mut run.channel);
        let growing = run.channel.system.frames.growing(run.machine);
        run.channel.outlet.warnings.extend(growing);
        run.channel.outlet.end(run.ledger.has_errors());
        run.report_warnings(run.channel.outlet.file());
    }
}
