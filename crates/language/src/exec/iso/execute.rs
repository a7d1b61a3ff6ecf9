//! Starts a program, and executes its blocks.

use super::call::Call;
use super::channel::Channel;
use super::data;
use super::expression::Scope;
use super::level::{Action, Called, Interpreter, Iso, Level, Loaded};
use super::loaded::Loops;
use super::offsets;
use super::{flow, startup};
use crate::exec::core;
use crate::exec::core::executor::Executor;
use crate::exec::core::fault::Fault;
use crate::exec::core::interpreter::Execute;
use crate::exec::core::library::Library;
use crate::exec::core::options::Options;
use crate::exec::core::program::Statement;
use crate::exec::core::run_state::RunState;
use crate::syntax::words::{self, Block, Comment, CommentKind, Program};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::AxisSet;
use ncfix_base::source::{Source, Span};
use ncfix_dialect::Dialect;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Kind, Origin};

/// State of a run in addition to the channel.
pub(super) struct IsoRun {
    /// The part of the first file that is the main program.
    pub(super) main: usize,
    /// Parts of the first file that were entered.
    pub(super) entered: Vec<bool>,
}

/// Starts a program. The caller handles syntax diagnostics of the main program; faulty blocks have no effect here.
pub(in crate::exec) fn start<'a>(
    program: Program,
    machine: &'a Machine,
    library: Box<dyn Library + 'a>,
    options: &Options,
) -> Box<dyn Executor + 'a> {
    let (first, main) = program.main_parts();
    let mut channel = begin(machine, options, program.dialect);
    let source = program.source.clone();
    let found = startup::start_up(&mut channel, &program);
    let start = program.parts.get(first).map_or(0, |part| part.blocks.start);
    let headers = program.parts.get(main).map_or(&[][..], |part| &part.headers);
    // `%100` is the mark itself: a second one would end the tape.
    let is_marked = headers.first().is_some_and(|&header| source.slice(header).starts_with(b"%"));
    if program.has_tape_marks && !is_marked {
        channel.begin_block(Origin { file: source.id(), line: 1, span: Span::default(), calls: 0 }, None);
        channel.push(Kind::Header(b"%".to_vec()));
    }
    for &header in headers {
        channel.begin_block(Origin { file: source.id(), line: 1, span: header, calls: 0 }, None);
        channel.push(Kind::Header(source.slice(header).to_vec()));
    }
    let mut ledger = RunState::new(source, program.blocks.len(), options);
    found.into_iter().for_each(|found| ledger.report(found));
    if let Some((block, number)) = program.outside() {
        let shown = String::from_utf8_lossy(program.source.slice(number)).into_owned();
        let message =
            format!("blocks before the first program number {shown} do not belong to any program on the control");
        let help = format!("move them after {shown}, or remove them; if they are a separate program end it with M30");
        let place = Place { file: program.source.id(), span: block };
        ledger.report(Diagnostic::at(Code::LOST_PROGRAM, place, message, help));
    }
    channel.variables.add_program(&program);
    let mut entered = vec![false; program.parts.len()];
    [first, main].into_iter().for_each(|part| entered.iter_mut().skip(part).take(1).for_each(|place| *place = true));
    let loops = Loops::of(&program, &ledger);
    let level = Level::new(0, first, start, 0, Called::default());
    let (state, main) = ((channel, IsoRun { main, entered }), (Loaded::with(program, loops), level));
    Box::new(Interpreter::start(machine, library, ledger, state, main))
}

impl Execute for Iso {
    type Channel<'a> = Channel<'a>;
    type Run = IsoRun;

    fn parse(run: &Interpreter<'_>, source: &Source) -> (Program, Vec<Diagnostic>) {
        words::parse(source, run.programs[0].program.dialect)
    }

    /// In RS274/NGC a bare O number only marks a position.
    fn end_of(channel: &Channel<'_>, file: &Loaded, level: &Level) -> usize {
        match (channel.language, file.program.parts.get(level.part)) {
            (Language::Fanuc, part) => part.map_or(0, |part| part.blocks.end),
            _ => file.program.blocks.len(),
        }
    }

    fn begin(run: &mut Interpreter<'_>, block: &Block, own: Origin) {
        run.channel.begin_block(own, Statement::number(block));
    }

    fn block(run: &mut Interpreter<'_>, block: &Block, index: usize) -> Result<Action, Fault> {
        let core::interpreter::Runner { programs, levels, channel, ledger, .. } = run;
        let Some(level) = levels.last() else { return Ok(Action::Next) };
        let Some(loaded) = programs.get_mut(level.program) else { return Ok(Action::Next) };
        let takes_all = !loaded.program.comments_of(block).is_empty() && loaded.takes_comments_of(index);
        // Comments that display or write something act in each pass of a loop, with the values of that pass.
        let acts = |comment: &&Comment| comment.kind != CommentKind::Plain;
        for comment in loaded.program.comments_of(block).iter().filter(|comment| takes_all || acts(comment)) {
            let scope = Scope { program: &loaded.program, index: level.program, channel, grid: None };
            let kind = scope.comment(comment);
            channel.push(kind);
        }
        let file = loaded.program.source.id();
        let cut = block.inner_skip.filter(|skip| ledger.skips(skip.level, file, block.span));
        let program = &loaded.program;
        let words = if cut.is_some() { program.words_before_skip(block) } else { program.words_of(block) };
        flow::block(loaded, level, channel, block, index, words)
    }

    fn modal_call(run: &mut Interpreter<'_>, block: &Block) -> Result<bool, Fault> {
        Ok(run.channel.block.has_moved && !run.channel.modal_calls.is_empty() && run.trigger(block.line)?)
    }

    fn call(run: &mut Interpreter<'_>, call: Box<Call>, block: &Block) -> Result<(), Fault> {
        run.call(call, block.line, None)
    }

    fn return_to(run: &mut Interpreter<'_>, target: Option<u32>, span: Span) -> Result<(), Fault> {
        run.return_to(target, span)
    }

    fn end_of_program(run: &mut Interpreter<'_>, (): ()) {
        run.ledger.end();
    }

    fn end_of_blocks(run: &mut Interpreter<'_>) {
        run.end_of_part();
    }

    fn finish(run: &mut Interpreter<'_>) {
        let growing = data::growing_offsets(&run.channel);
        run.channel.outlet.warnings.extend(growing);
        run.channel.outlet.end(run.ledger.has_errors());
        run.report_rest();
    }
}

impl Interpreter<'_> {
    /// Reports a program of a Fanuc file that nothing calls: the output contains the first one only.
    fn report_uncalled(&mut self) {
        let Some(program) = self.programs.first().map(|loaded| &loaded.program) else { return };
        if self.channel.language != Language::Fanuc || program.outside().is_some() {
            return;
        }
        let is_left = |(part, entered): &(&crate::syntax::words::Part, &bool)| !**entered && !part.blocks.is_empty();
        let Some((part, _)) = program.parts.iter().zip(&self.own.entered).find(is_left) else { return };
        let header = part.headers.first().copied();
        let first = program.blocks.range(part.blocks.clone()).iter().next().map(|block| block.span);
        let (message, help) = match header {
            Some(header) => {
                let shown = String::from_utf8_lossy(program.source.slice(header)).into_owned();
                let message = format!(
                    "the program {shown} is ignored: only the first one of a file is executed, and it does not call this one"
                );
                (message, "put each main program into its own file")
            }
            None => (
                "this line and those after it are ignored: the % before it ends the program".to_owned(),
                "remove the lines, or the % if the program continues after it",
            ),
        };
        let place = Place { file: program.source.id(), span: header.or(first).unwrap_or_default() };
        self.ledger.report(Diagnostic::at(Code::MORE_PROGRAMS, place, message, help));
    }

    /// Reports diagnostics at the end of the run.
    fn report_rest(&mut self) {
        self.report_uncalled();
        let file = self.channel.outlet.file();
        for warning in std::mem::take(&mut self.channel.outlet.warnings) {
            self.ledger.report(warning.in_file(file));
        }
        // For other rules the contour stage reports it.
        if self.channel.modal.contour.compensates() && self.channel.is_rs274() {
            let place = Place { file, span: self.channel.outlet.origin.span };
            let message = "radius compensation is still on at the end of the program";
            self.ledger.report(Diagnostic::at(
                Code::COMPENSATION_LEFT_ON,
                place,
                message,
                "program G40 before the end",
            ));
        }
    }
}

/// A channel in its state at the start of a program.
pub(super) fn begin<'a>(machine: &'a Machine, options: &Options, dialect: &'static Dialect) -> Channel<'a> {
    let mut channel = Channel::new(machine, options, dialect);
    // G54 is active at the start of a program.
    if let Err(found) = offsets::load_offset(&mut channel, Span::default()) {
        channel.outlet.warnings.push(found);
    }
    channel.modal.position.known = if options.start.is_some() { channel.axes } else { AxisSet::EMPTY };
    channel
}
