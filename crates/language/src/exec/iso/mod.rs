//! Executes programs of Fanuc controls and of RS274/NGC (LinuxCNC).
//!
//! Each block goes through three steps: its words are gathered, its values worked out, and executed in the order of the dialect. What
//! differs between the two is asked of [`ncfix_dialect::Language`].

mod arc;
mod arguments;
mod assign;
mod auxiliary;
mod call;
mod channel;
mod codes;
mod compensation;
mod cycle;
mod cycles;
mod data;
mod direction;
mod drill;
mod expression;
mod feed;
mod flow;
mod forbidden;
mod frames;
mod functions;
mod gather;
mod gathered;
mod home;
mod length;
mod level;
mod library;
mod loaded;
mod measure;
mod message;
mod modal;
mod motion;
mod nurbs;
mod offsets;
mod one_axis;
mod opaque;
mod polar;
mod predefined;
mod probe;
mod reference;
mod request;
mod special;
mod spline;
mod startup;
mod state;
mod system;
mod thread;
mod tilt;
mod tilted;
mod tip;
mod transform;
mod trip;
mod variables;

use std::collections::{HashMap, VecDeque};

use crate::exec::core::executor::Executor;
use crate::exec::core::ledger::Ledger;
use crate::exec::core::library::Library;
use crate::exec::core::options::Options;
use crate::syntax::words::{Comment, CommentKind, Program};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{BlockNumber, Element, Kind, Origin};

use channel::Channel;
use expression::Scope;
use level::Level;
use loaded::Loaded;

/// A running program.
pub(super) struct Interpreter<'a> {
    machine: &'a Machine,
    library: Box<dyn Library + 'a>,
    ledger: Ledger,
    programs: Vec<Loaded>,
    /// The part of the first file that is the main program.
    main: usize,
    /// Which parts of the first file were entered.
    entered: Vec<bool>,
    levels: Vec<Level>,
    channel: Channel<'a>,
    /// Files that were looked for, by the name of the call: their numbers.
    files: HashMap<String, Option<usize>>,
}

impl<'a> Interpreter<'a> {
    /// Starts a program. Syntax findings of the main program are the caller's business; faulty blocks do nothing here.
    pub(super) fn new(
        program: Program,
        machine: &'a Machine,
        library: Box<dyn Library + 'a>,
        options: Options,
    ) -> Self {
        let (first, main) = program.main_parts();
        let mut channel = Channel::new(machine, &options, program.dialect);
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
        let mut ledger = Ledger::new(source, program.blocks.len(), &options);
        found.into_iter().for_each(|found| ledger.report(found));
        if let Some((block, number)) = program.outside() {
            let shown = String::from_utf8_lossy(program.source.slice(number)).into_owned();
            let message =
                format!("blocks before the first program number {shown}: on the control they belong to no program");
            let help = format!(
                "put them behind {shown}, or take them out; where they are a program of their own end it with M30"
            );
            let place = Place { file: program.source.id(), span: block };
            ledger.report(Diagnostic::at(Code::LOST_PROGRAM, place, message, help));
        }
        channel.variables.add_program(&program);
        let mut entered = vec![false; program.parts.len()];
        [first, main]
            .into_iter()
            .for_each(|part| entered.iter_mut().skip(part).take(1).for_each(|place| *place = true));
        Interpreter {
            machine,
            library,
            main,
            entered,
            programs: vec![Loaded::new(program, &ledger)],
            ledger,
            levels: vec![Level::new(0, first, start, 0)],
            channel,
            files: HashMap::new(),
        }
    }

    /// Executes one block.
    fn execute_block(&mut self) {
        let Some(level) = self.levels.last_mut() else {
            self.ledger.end();
            return;
        };
        let Some(loaded) = self.programs.get_mut(level.program) else {
            self.ledger.end();
            return;
        };
        if let Some(pending) = level.pending.take() {
            loaded.program.ensure(level.next.saturating_sub(1));
            let file = loaded.program.source.id();
            if let Err(found) = self.act(pending.0, &pending.1) {
                self.ledger.report(found.in_file(file));
            }
            return;
        }
        // In RS274/NGC a bare O number only marks a place.
        let end = match (self.channel.language, loaded.program.parts.get(level.part)) {
            (Language::Fanuc, part) => part.map_or(0, |part| part.blocks.end),
            _ => loaded.program.blocks.len(),
        };
        let index = level.next;
        loaded.program.ensure(index);
        let Some(&block) = loaded.program.blocks.get(index).filter(|_| index < end) else {
            self.end_of_part();
            return;
        };
        level.next += 1;
        let file = loaded.program.source.id();
        if let Err(found) = self.ledger.count(file, block.span) {
            found.into_iter().for_each(|found| self.ledger.report(found));
            return;
        }
        if block.skip.is_some_and(|level| self.ledger.skips(level, file, block.span)) {
            return;
        }
        let origin = Origin { file, line: block.line, span: block.span, calls: level.calls };
        let number = block.number.map(|number| BlockNumber { main: false, number });
        self.channel.begin_block(origin, number);
        let takes_all = loaded.takes_comments(index, &block);
        // What shows or writes something does so with each pass of a loop, with the values of that pass.
        let acts = |comment: &&Comment| comment.kind != CommentKind::Plain;
        for comment in loaded.program.comments_of(&block).iter().filter(|comment| takes_all || acts(comment)) {
            let scope = Scope { program: &loaded.program, index: level.program, channel: &self.channel, grid: None };
            let kind = scope.comment(comment);
            self.channel.push(kind);
        }
        let cut = block.inner_skip.filter(|skip| self.ledger.skips(skip.level, file, block.span));
        let program = &loaded.program;
        let words = if cut.is_some() { program.words_before_skip(&block) } else { program.words_of(&block) };
        let action = flow::block(loaded, level, &mut self.channel, &block, index, words);
        for warning in std::mem::take(&mut self.channel.outlet.warnings) {
            self.ledger.report(warning.in_file(file));
        }
        let done = match action {
            Ok(action) if self.channel.has_moved && !self.channel.modal_calls.is_empty() => {
                self.behind_motion(action, &block)
            }
            Ok(action) => self.act(action, &block),
            Err(found) => Err(found),
        };
        if let Err(found) = done {
            self.ledger.report(found.in_file(file));
        }
    }

    /// The finding about a program of a Fanuc's file that nothing has called: the output is that of the first one alone.
    fn report_uncalled(&mut self) {
        let Some(program) = self.programs.first().map(|loaded| &loaded.program) else { return };
        if self.channel.language != Language::Fanuc || program.outside().is_some() {
            return;
        }
        let is_left = |(part, entered): &(&crate::syntax::words::Part, &bool)| !**entered && !part.blocks.is_empty();
        let Some((part, _)) = program.parts.iter().zip(&self.entered).find(is_left) else { return };
        let span = part.headers.first().copied().unwrap_or_default();
        let shown = String::from_utf8_lossy(program.source.slice(span)).into_owned();
        let message =
            format!("the program {shown} is left out: the first one of a file is executed, and does not call it");
        let place = Place { file: program.source.id(), span };
        let help = "put each main program into a file of its own";
        self.ledger.report(Diagnostic::at(Code::MORE_PROGRAMS, place, message, help));
    }

    /// What was found at the very end.
    fn report_rest(&mut self) {
        self.report_uncalled();
        let file = self.channel.outlet.file();
        for warning in std::mem::take(&mut self.channel.outlet.warnings) {
            self.ledger.report(warning.in_file(file));
        }
        // By the other rules the contour stage says so itself.
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

impl Executor for Interpreter<'_> {
    fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    fn books(&mut self) -> (&mut Ledger, &mut VecDeque<Element>) {
        (&mut self.ledger, &mut self.channel.outlet.queue)
    }

    fn step(&mut self) {
        self.execute_block();
    }

    fn finish(&mut self) {
        self.channel.outlet.end(self.ledger.has_errors());
        self.report_rest();
    }
}
