//! Executes programs of the Sinumerik.
//!
//! Each block goes through three steps: its words are gathered, checked, and executed in a fixed order (assignments, modal
//! codes, zero offset and frame, tool, feed and speed, auxiliary functions that act before the motion, motion, the others).

mod address;
mod angle;
mod arc;
mod archive;
mod assign;
mod axis_name;
mod beside;
mod call;
mod cells;
mod channel;
mod contour_words;
mod cycles;
mod dwell;
mod expression;
mod flow;
mod forbidden;
mod frame_store;
mod frame_value;
mod frames;
mod functions;
mod gather;
mod gathered;
mod groups;
mod indexed_word;
mod jump;
mod level;
mod library;
mod modal;
mod motion;
mod names;
mod operand;
mod orientation;
mod parameters;
mod part;
mod pass;
mod polar;
mod polynomial;
mod positioning;
mod reference;
mod report;
mod rotary;
mod save;
mod spatial;
mod spline;
mod surface;
mod swivel;
mod sync_action;
mod system;
mod system_write;
mod text_block;
mod thread;
mod tool;
mod tool_data;
mod transform;
mod value;
mod variables;

pub(super) use archive::apply_archive;

use std::collections::{HashMap, VecDeque};

use crate::exec::core::executor::Executor;
use crate::exec::core::fault::{Fault, at};
use crate::exec::core::ledger::Ledger;
use crate::exec::core::library::Library;
use crate::exec::core::options::Options;
use crate::syntax::sinumerik::{self, Block, Macros, Program};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{BlockNumber, Element, Kind, Origin};

use channel::Channel;
use expression::Scope;
use flow::Action;
use gather::Gatherer;
use level::Level;
use library::{Loaded, read_definitions};

/// A running program.
pub(super) struct Interpreter<'a> {
    machine: &'a Machine,
    library: Box<dyn Library + 'a>,
    ledger: Ledger,
    programs: Vec<Loaded>,
    /// Those of the definition files, which hold in every program.
    macros: Macros,
    levels: Vec<Level>,
    channel: Channel<'a>,
    found: HashMap<String, Option<(usize, usize)>>,
    /// Programs of the texts that EXECSTRING executed.
    texts: HashMap<Vec<u8>, usize>,
    /// The program of MCALL.
    modal_call: Option<call::Entry>,
}

impl<'a> Interpreter<'a> {
    /// Starts a program. Syntax findings of the main program are the caller's business; faulty blocks do nothing here.
    pub(super) fn new(
        program: Program,
        machine: &'a Machine,
        mut library: Box<dyn Library + 'a>,
        options: Options,
    ) -> Self {
        let main = program
            .sections
            .iter()
            .position(|section| section.ending == "MPF" && !section.blocks.is_empty())
            .or_else(|| {
                program.sections.iter().position(|section| section.ending != "DEF" && !section.blocks.is_empty())
            })
            .unwrap_or(0);
        let mut channel = Channel::new(machine, &options, program.dialect.codes());
        let source = program.source.clone();
        if let Some(section) = program.sections.get(main) {
            for &header in &section.headers {
                channel.begin_block(Origin { file: source.id(), line: 1, span: header, calls: 0 }, None);
                channel.push(Kind::Header(source.slice(header).to_vec()));
            }
        }
        let start = program.sections.get(main).map_or(0, |section| section.blocks.start);
        let is_main = |section: &&sinumerik::Section| section.ending == "MPF" && !section.blocks.is_empty();
        let mut ledger = Ledger::new(source, program.blocks.len(), &options);
        if let Some(other) = program.sections.iter().filter(is_main).nth(1) {
            let span = other.headers.first().copied().unwrap_or_default();
            let message =
                format!("the main program {} is left out: only the first one of a file is executed", other.name);
            let help = "put each main program into a file of its own";
            ledger.findings.push_back(Diagnostic::at(
                Code::MORE_PROGRAMS,
                Place { file: program.source.id(), span },
                message,
                help,
            ));
        }
        let macros = read_definitions(library.as_mut(), &program, &mut channel, &mut ledger.sources);
        let loaded = Loaded::new(program, &machine.control);
        // A subprogram that is run by itself has the defaults of its parameters.
        if let Err(found) = parameters::bind(&loaded, &mut channel, loaded.parameters(main), &[]) {
            ledger.findings.push_back(found.in_file(loaded.program.source.id()));
        }
        Interpreter {
            machine,
            library,
            ledger,
            macros,
            programs: vec![loaded],
            levels: vec![Level::new(0, main, start, 0)],
            channel,
            found: HashMap::new(),
            texts: HashMap::new(),
            modal_call: None,
        }
    }

    /// Executes one block.
    fn execute_block(&mut self) {
        let Some(level) = self.levels.last_mut() else {
            self.ledger.end();
            return;
        };
        if let Some(pending) = level.pending.take() {
            self.programs[level.program].program.ensure(level.next.saturating_sub(1));
            if let Err(found) = self.act(pending.0, &pending.1) {
                self.report_here(found);
            }
            return;
        }
        if !level.parts.is_empty() {
            level.end_parts();
        }
        let loaded = &mut self.programs[level.program];
        loaded.program.ensure(level.next);
        // An empty file has no section.
        let Some(section) = loaded.program.sections.get(level.section) else {
            self.ledger.end();
            return;
        };
        let index = level.next;
        if index >= section.blocks.end {
            self.end_of_program(None);
            return;
        }
        level.next += 1;
        let (program, calls, section_blocks) = (level.program, level.calls, section.blocks.clone());
        let block = loaded.program.blocks[index];
        let file = loaded.program.source.id();
        if let Err(found) = self.ledger.count(file, block.span) {
            found.into_iter().for_each(|found| self.report(found));
            return;
        }
        if block.skip.is_some_and(|level| self.ledger.skips(level, file, block.span)) {
            return;
        }
        let loaded = &mut self.programs[program];
        let comment = loaded.take_comment(index, &block);
        let cycle = self.levels.last().and_then(|level| level.cycle);
        let own = Origin { file, line: block.line, span: block.span, calls };
        let origin = cycle.map_or(own, |cycle| cycle.origin);
        let number = block.number.map(|written| BlockNumber { main: written.main, number: written.number });
        self.channel.begin_block(origin, number);
        if let Some(label) = block.label.filter(|_| calls == 0 && cycle.is_none()) {
            let label = loaded.program.names.text(label).as_bytes().to_vec();
            self.channel.push(Kind::Label(label));
        }
        let action = match self.levels.last_mut() {
            Some(level) => {
                flow::block(loaded, level, &mut self.channel, &block, index, section_blocks, comment, self.machine)
            }
            None => Ok(Action::Next),
        };
        self.channel.note_looks();
        let warnings = std::mem::take(&mut self.channel.outlet.warnings);
        for warning in warnings {
            self.report(warning.in_file(file));
        }
        let done = match action {
            // What the block does to the order of execution waits for the modal call that it triggers.
            Ok(action) if self.channel.has_moved && self.modal_call.is_some() && self.trigger(&block) => {
                let caller = self.levels.len().checked_sub(2).and_then(|index| self.levels.get_mut(index));
                if let (Some(level), true) = (caller, action != Action::Next) {
                    level.pending = Some(Box::new((action, block)));
                }
                Ok(())
            }
            Ok(action) => self.act(action, &block),
            Err(found) => Err(found),
        };
        if let Err(found) = done {
            self.report(found.in_file(file));
            self.leave_cycle();
        }
    }

    fn act(&mut self, action: Action, block: &Block) -> Result<(), Fault> {
        match action {
            Action::Next => {}
            Action::Jump(target) | Action::Goto(target) => {
                if let Some(level) = self.levels.last_mut() {
                    level.go_to(target, matches!(action, Action::Goto(_)));
                }
            }
            Action::Repeat(first, last, passes) => {
                self.check_depth("the repetition", block.span)?;
                if let Some(level) = self.levels.last_mut() {
                    part::begin(level, first, last, passes);
                }
            }
            Action::Call(call) => self.call(&call, block)?,
            Action::CallStatement(place) => {
                let program = self.levels.last().map_or(0, |level| level.program);
                let statement = self.programs[program].program.calls[place as usize];
                self.call_statement(&statement, block)?;
            }
            Action::Return(target) => self.return_to(&target, block.span)?,
            Action::End(word) => self.end_of_program(Some(word)),
        }
        Ok(())
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
        self.channel.finish();
        self.channel.outlet.end(self.ledger.has_errors());
        self.report_channel();
    }
}

/// Everything in scope of a block's expressions.
fn scope_of<'s>(loaded: &'s Loaded, channel: &'s Channel<'_>) -> Scope<'s> {
    Scope {
        program: &loaded.program,
        variables: &channel.variables,
        modal: &channel.modal,
        machine: channel.machine,
        system: &channel.system,
    }
}

/// Gathers the words of one block.
fn gatherer<'s>(loaded: &'s Loaded, channel: &'s Channel<'_>, machine: &Machine) -> Gatherer<'s> {
    Gatherer {
        scope: scope_of(loaded, channel),
        meanings: &loaded.meanings,
        codes: loaded.program.dialect.codes(),
        machine_axes: machine.axis_set(),
    }
}
