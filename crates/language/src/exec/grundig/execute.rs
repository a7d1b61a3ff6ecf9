//! Starts a program, and executes its blocks.

use super::channel::Channel;
use super::expression::Parameters;
use super::expression::Scope;
use super::flow::FLOW_CODES;
use super::gathered::Gathered;
use super::level::{Action, Grundig, Interpreter, Level, LevelKind, Loaded, MacroCall};
use super::library::take_comment;
use super::order;
use super::setup;
use super::tables;
use crate::exec::core::executor::Executor;
use crate::exec::core::fault::{Fault, bad_value};
use crate::exec::core::interpreter::Execute;
use crate::exec::core::library::Library;
use crate::exec::core::options::Options;
use crate::exec::core::program::Statement;
use crate::exec::core::run_state::RunState;
use crate::syntax::words::{self, Address, Block, Body, PartKind, Program, Value};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Kind, Origin};

/// Starts a program. The caller handles syntax diagnostics of the main program; faulty blocks have no effect here.
pub(in crate::exec) fn start<'a>(
    program: Program,
    machine: &'a Machine,
    library: Box<dyn Library + 'a>,
    options: &Options,
) -> Box<dyn Executor + 'a> {
    let with_blocks = |kind: PartKind| move |part: &words::Part| part.kind == kind && !part.blocks.is_empty();
    let acts = |part: &words::Part| with_blocks(PartKind::Program)(part) && !program.is_idle(part);
    let main = program
        .parts
        .iter()
        .position(acts)
        .or_else(|| program.parts.iter().position(with_blocks(PartKind::Program)))
        .or_else(|| program.parts.iter().position(with_blocks(PartKind::Macro)))
        .unwrap_or(0);
    let mut channel = setup::begin(machine, options, program.dialect.codes());
    let source = program.source.clone();
    let mut start = 0;
    if let Some(part) = program.parts.get(main) {
        start = part.blocks.start;
        for &header in &part.headers {
            channel.outlet.begin_block(Origin { file: source.id(), line: 1, span: header, calls: 0 }, None);
            channel.outlet.push(Kind::Header(source.slice(header).to_vec()));
        }
    }
    tables::take_tables(&mut channel.modal, &mut channel.tools, &mut channel.parameters, tables::read(&program));
    let mut ledger = RunState::new(source, program.blocks.len(), options);
    ledger.findings.extend(left_out(&program, main));
    ledger.findings.extend(tables_left_out(&program));
    let level = Level::new(0, main, start, 0, LevelKind::Main);
    let (state, main) = ((channel, Gathered::default()), (Loaded::with(program, ()), level));
    Box::new(Interpreter::start(machine, library, ledger, state, main))
}

impl Execute for Grundig {
    type Channel<'a> = Channel<'a>;
    /// The words of the current block.
    type Run = Gathered;

    fn parse(run: &Interpreter<'_>, source: &Source) -> (Program, Vec<Diagnostic>) {
        words::parse(source, run.programs[0].program.dialect)
    }

    fn end_of(_: &Channel<'_>, file: &Loaded, level: &Level) -> usize {
        file.program.parts.get(level.part).map_or(0, |part| part.blocks.end)
    }

    fn begin(run: &mut Interpreter<'_>, block: &Block, own: Origin) {
        run.channel.outlet.begin_block(own, Statement::number(block));
    }

    fn block(run: &mut Interpreter<'_>, block: &Block, index: usize) -> Result<Action, Fault> {
        run.execute(block, index).map(|()| Action::Next)
    }

    fn begin_pass(run: &mut Interpreter<'_>, pass: Self::Pass) -> Result<(), Fault> {
        run.count_down(pass)
    }

    fn call(run: &mut Interpreter<'_>, call: MacroCall, block: &Block) -> Result<(), Fault> {
        run.enter(call, block)
    }

    fn return_to(_: &mut Interpreter<'_>, target: Self::Return, _: Span) -> Result<(), Fault> {
        match target {}
    }

    fn end_of_program(run: &mut Interpreter<'_>, end: Self::End) {
        run.end(end);
    }

    fn end_of_blocks(run: &mut Interpreter<'_>) {
        run.end(None);
    }

    fn finish(run: &mut Interpreter<'_>) {
        order::finish(&mut run.channel, run.ledger.has_errors());
        run.report_warnings(run.channel.outlet.file());
    }
}

impl Interpreter<'_> {
    /// Executes a block; `index` is its index in the program.
    fn execute(&mut self, block: &Block, index: usize) -> Result<(), Fault> {
        let comment = self
            .levels
            .last()
            .and_then(|level| self.programs.get_mut(level.program))
            .and_then(|loaded| take_comment(loaded, index, block));
        match block.body {
            Body::Words => {}
            Body::Empty => {
                let is_bare = comment.is_none() && block.number.is_some();
                self.channel.comment(comment);
                if is_bare {
                    self.channel.outlet.push(Kind::Empty);
                }
                return Ok(());
            }
            _ => {
                self.channel.comment(comment);
                return Ok(());
            }
        }
        let Some(loaded) = self.levels.last().and_then(|level| self.programs.get(level.program)) else { return Ok(()) };
        let program = &loaded.program;
        assignments(program, block, &mut self.channel.parameters)?;
        let scope = Scope { program, parameters: &self.channel.parameters };
        self.own.gather(program, block, scope)?;
        self.own.put_on_grid(&self.channel.modal, self.channel.settings.machine);
        let gathered = &mut self.own;
        if gathered.is_empty() {
            // Only assignments.
            self.channel.comment(comment);
            return Ok(());
        }
        if let Some(code) = gathered.codes.iter().find(|code| FLOW_CODES.contains(&code.number)).copied() {
            self.channel.comment(comment);
            return self.flow(code.number, code.span, block, index);
        }
        let end = gathered.take_function(30).map(|_| 30).or_else(|| gathered.take_function(2).map(|_| 2));
        let mut gathered = std::mem::take(&mut self.own);
        let ends_meaning = order::ends_meaning(&gathered);
        let done = if gathered.is_empty() {
            self.channel.comment(comment);
            Ok(())
        } else {
            order::execute(&mut self.channel, &mut gathered, comment)
        };
        self.own = gathered;
        if end.is_some() {
            self.end(end);
        } else if ends_meaning && done.is_err() {
            self.ledger.end();
        }
        done
    }
}

/// The diagnostic for further programs of the transfer that no call reaches.
fn left_out(program: &Program, main: usize) -> Option<Diagnostic> {
    let is_program = |part: &words::Part| part.kind == PartKind::Program && !part.blocks.is_empty();
    // Blocks after a mark without a header are reported with the text.
    let is_other =
        |(index, part): &(usize, &words::Part)| *index != main && is_program(part) && !part.headers.is_empty();
    let (_, other) = program.parts.iter().enumerate().find(is_other)?;
    let calls = |word: &words::Word| {
        word.address == Address::Letter(b'G') && matches!(word.value, Value::Number { value, .. } if value == 23.0)
    };
    if program.words.iter().any(calls) {
        return None;
    }
    let message =
        "this program is ignored: only the first program of a transfer is executed, and this one is not called";
    let place = Place { file: program.source.id(), span: other.headers.first().copied().unwrap_or_default() };
    Some(Diagnostic::at(Code::MORE_PROGRAMS, place, message, "put each program into its own file"))
}

/// The diagnostic for tables of the transfer that the output needs but does not contain.
fn tables_left_out(program: &Program) -> Option<Diagnostic> {
    let is_table = |part: &&words::Part| matches!(part.kind, PartKind::Tools | PartKind::ZeroOffsets);
    let table = program.parts.iter().filter(|part| !part.blocks.is_empty()).find(is_table)?;
    let message = "the tables of tools and zero offsets in this transfer are used, but omitted from the output";
    let place = Place { file: program.source.id(), span: table.headers.first().copied().unwrap_or_default() };
    Some(Diagnostic::at(
        Code::LEFT_OUT,
        place,
        message,
        "the control must have them before it runs the output: send it the tables unchanged",
    ))
}

/// Executes `E1=…`, from left to right, before everything else in the block.
fn assignments(program: &Program, block: &Block, parameters: &mut Parameters) -> Result<(), Fault> {
    for word in program.words_of(block) {
        let Address::Indexed(b'E', number) = word.address else { continue };
        let value = match word.value {
            Value::Number { value, .. } => value,
            Value::Expr(id) => Scope { program, parameters }.number(id)?,
            Value::None => return Err(bad_value(word.span, "an assignment without a value", "add the value")),
        };
        parameters.set(usize::from(number), value, word.span)?;
    }
    Ok(())
}
