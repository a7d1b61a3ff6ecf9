//! Executes programs of the Grundig, Philips and `MillPlus` controls.
//!
//! Each block goes through three steps: its assignments are carried out from left to right, its words are gathered with their values,
//! and each word is taken by what uses it, in a fixed order (modal codes, zero offsets and frame, tool, compensation, feed and speed,
//! auxiliary functions, motion or cycle). A word that nothing has taken is a finding.

mod arc;
mod channel;
mod contour_words;
mod cycles;
mod expression;
mod flow;
mod frames;
mod gathered;
mod geometry;
mod level;
mod library;
mod machining;
mod modal;
mod modes;
mod motion;
mod tables;
mod target;
mod tool;

use std::collections::{HashMap, VecDeque};

pub(super) use tables::apply as apply_tables;

use crate::exec::core::executor::Executor;
use crate::exec::core::fault::{Fault, bad_value};
use crate::exec::core::ledger::Ledger;
use crate::exec::core::library::Library;
use crate::exec::core::options::Options;
use crate::syntax::words::{self, Address, Block, Body, PartKind, Program, Value};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::FileId;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{BlockNumber, Element, Kind, Origin};

use channel::Channel;
use expression::Scope;
use flow::FLOW_CODES;
use gathered::Gathered;
use level::{Level, LevelKind};
use library::Loaded;

/// A running program.
pub(super) struct Interpreter<'a> {
    library: Box<dyn Library + 'a>,
    ledger: Ledger,
    programs: Vec<Loaded>,
    levels: Vec<Level>,
    channel: Channel<'a>,
    gathered: Gathered,
    /// Macros (true) and programs by number, as far as they were looked for.
    found: HashMap<(bool, u32), Option<(usize, usize)>>,
}

impl<'a> Interpreter<'a> {
    /// Starts a program. Syntax findings of the main program are the caller's business; faulty blocks do nothing here.
    pub(super) fn new(
        program: Program,
        machine: &'a Machine,
        library: Box<dyn Library + 'a>,
        options: Options,
    ) -> Self {
        let with_blocks = |kind: PartKind| move |part: &words::Part| part.kind == kind && !part.blocks.is_empty();
        let acts = |part: &words::Part| with_blocks(PartKind::Program)(part) && !program.is_idle(part);
        let main = program
            .parts
            .iter()
            .position(acts)
            .or_else(|| program.parts.iter().position(with_blocks(PartKind::Program)))
            .or_else(|| program.parts.iter().position(with_blocks(PartKind::Macro)))
            .unwrap_or(0);
        let mut channel = Channel::new(machine, &options, program.dialect.codes());
        let source = program.source.clone();
        let mut start = 0;
        if let Some(part) = program.parts.get(main) {
            start = part.blocks.start;
            for &header in &part.headers {
                channel.outlet.begin_block(Origin { file: source.id(), line: 1, span: header, calls: 0 }, None);
                channel.outlet.push(Kind::Header(source.slice(header).to_vec()));
            }
        }
        channel.take_tables(tables::read(&program));
        let mut ledger = Ledger::new(source, program.blocks.len(), &options);
        ledger.findings.extend(left_out(&program, main));
        ledger.findings.extend(tables_left_out(&program));
        Interpreter {
            library,
            ledger,
            programs: vec![Loaded::new(program)],
            levels: vec![Level::new(LevelKind::Main, 0, main, start, 0)],
            channel,
            gathered: Gathered::default(),
            found: HashMap::new(),
        }
    }

    /// Goes on with a repetition whose section has come to its end.
    fn end_repeats(&mut self) -> Result<(), Fault> {
        while let Some(level) = self.levels.last_mut() {
            let Some(repeat) = level.repeats.last_mut().filter(|repeat| level.next == repeat.last + 1) else { break };
            if repeat.left > 0 {
                repeat.left -= 1;
                level.next = repeat.first;
                let counter = repeat.counter;
                return self.count_down(counter);
            }
            level.next = repeat.resume;
            level.repeats.pop();
        }
        Ok(())
    }

    /// Executes one block.
    fn execute_block(&mut self) {
        if let Err(found) = self.end_repeats() {
            let file = self.channel.outlet.file();
            self.ledger.report(found.in_file(file));
        }
        let Some(level) = self.levels.last_mut() else {
            self.ledger.end();
            return;
        };
        let Some(loaded) = self.programs.get_mut(level.program) else {
            self.ledger.end();
            return;
        };
        let end = loaded.program.parts.get(level.part).map_or(0, |part| part.blocks.end);
        let index = level.next;
        loaded.program.ensure(index);
        let Some(block) = loaded.program.blocks.get(index).copied().filter(|_| index < end) else {
            self.end_of_program(None);
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
        let comment = loaded.take_comment(index, &block);
        let origin = Origin { file, line: block.line, span: block.span, calls: level.calls };
        let number = block.number.map(|number| BlockNumber { main: false, number });
        self.channel.outlet.begin_block(origin, number);
        let done = self.block(&block, index, comment);
        self.report_channel(file);
        if let Err(found) = done {
            self.ledger.report(found.in_file(file));
        }
    }

    fn block(&mut self, block: &Block, index: usize, comment: Option<Vec<u8>>) -> Result<(), Fault> {
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
        assignments(program, block, &mut self.channel)?;
        let scope = Scope { program, parameters: &self.channel.parameters };
        self.gathered.gather(program, block, scope)?;
        self.gathered.put_on_grid(&self.channel.modal, self.channel.machine);
        let gathered = &mut self.gathered;
        if gathered.is_empty() {
            // Nothing but assignments.
            self.channel.comment(comment);
            return Ok(());
        }
        if let Some(code) = gathered.codes.iter().find(|code| FLOW_CODES.contains(&code.number)).copied() {
            self.channel.comment(comment);
            return self.flow(code.number, code.span, block, index);
        }
        let end = gathered.take_function(30).map(|_| 30).or_else(|| gathered.take_function(2).map(|_| 2));
        let mut gathered = std::mem::take(&mut self.gathered);
        let done = if gathered.is_empty() {
            self.channel.comment(comment);
            Ok(())
        } else {
            self.channel.execute(&mut gathered, comment)
        };
        self.gathered = gathered;
        if end.is_some() {
            self.end_of_program(end);
        }
        done
    }

    /// Reports what the stages behind the block have found.
    fn report_channel(&mut self, file: FileId) {
        for found in std::mem::take(&mut self.channel.outlet.warnings) {
            self.ledger.report(found.in_file(file));
        }
    }
}

/// The finding about further programs of the transfer, where nothing in it calls programs.
fn left_out(program: &Program, main: usize) -> Option<Diagnostic> {
    let is_program = |part: &words::Part| part.kind == PartKind::Program && !part.blocks.is_empty();
    let (_, other) = program.parts.iter().enumerate().find(|(index, part)| *index != main && is_program(part))?;
    let calls = |word: &words::Word| {
        word.address == Address::Letter(b'G') && matches!(word.value, Value::Number { value, .. } if value == 23.0)
    };
    if program.words.iter().any(calls) {
        return None;
    }
    let message = "this program is left out: only the first one of a transfer is executed, and nothing calls another";
    let place = Place { file: program.source.id(), span: other.headers.first().copied().unwrap_or_default() };
    Some(Diagnostic::at(Code::MORE_PROGRAMS, place, message, "put each program into a file of its own"))
}

/// The finding about tables of the transfer that the output needs and does not have.
fn tables_left_out(program: &Program) -> Option<Diagnostic> {
    let is_table = |part: &&words::Part| matches!(part.kind, PartKind::Tools | PartKind::ZeroOffsets);
    let table = program.parts.iter().filter(|part| !part.blocks.is_empty()).find(is_table)?;
    let message = "the tables of tools and zero offsets in this transfer are used, and left out of the output";
    let place = Place { file: program.source.id(), span: table.headers.first().copied().unwrap_or_default() };
    Some(Diagnostic::at(
        Code::LEFT_OUT,
        place,
        message,
        "the control must have them before it runs the output: send it the tables as they are",
    ))
}

/// `E1=…`, from left to right, before everything else in the block.
fn assignments(program: &Program, block: &Block, channel: &mut Channel<'_>) -> Result<(), Fault> {
    for word in program.words_of(block) {
        let Address::Indexed(b'E', number) = word.address else { continue };
        let value = match word.value {
            Value::Number { value, .. } => value,
            Value::Expr(id) => Scope { program, parameters: &channel.parameters }.number(id)?,
            Value::None => return Err(bad_value(word.span, "an assignment without a value", "add the value")),
        };
        channel.parameters.set(usize::from(number), value, word.span)?;
    }
    Ok(())
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
        self.channel.finish(self.ledger.has_errors());
        self.report_channel(self.channel.outlet.file());
    }
}
