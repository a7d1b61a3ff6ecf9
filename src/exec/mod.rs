//! Executes a program as the control would and yields the flat stream, lazily and in bounded memory.
//!
//! Each block goes through three steps: its words are gathered, checked, and executed in a fixed order (assignments, modal
//! codes, zero offset and frame, tool, feed and speed, auxiliary functions that act before the motion, motion, the others).
//! Findings are items of the stream too; after an error the execution goes on, so that one run shows them all, but what it
//! yields is then no longer good for anything but more findings.

mod address;
mod arc;
mod archive;
mod assign;
mod axis_name;
mod call;
mod cells;
mod channel;
mod contour;
mod cycles;
mod dwell;
mod expression;
mod fault;
mod five_axis;
mod flow;
mod frame_store;
mod frame_value;
mod frames;
mod functions;
mod gather;
mod gathered;
mod groups;
mod indexed_word;
mod jump;
mod kept;
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
mod path;
mod polar;
mod polynomial;
mod positioning;
mod reference;
mod report;
mod resolve;
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

pub use archive::apply_archive;
pub use library::{Library, NoLibrary};

use std::collections::{HashMap, HashSet, VecDeque};

use crate::diagnostic::{Code, Diagnostic, Place};
use crate::geometry::AxisVector;
use crate::machine::Machine;
use crate::snc::{BlockNumber, Element, Kind, Origin};
use crate::source::Source;
use crate::syntax::{self, Block, Macros, Program};

use channel::Channel;
use expression::Scope;
use fault::{Fault, at};
use flow::Action;
use gather::Gatherer;
use level::Level;
use library::{Loaded, read_definitions};

/// How to execute.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Skip levels whose blocks are left out.
    pub skip_levels: [bool; 10],
    /// Executed blocks after which the run stops with a finding; `None` for ten million, or twenty times the blocks of the
    /// main program if that is more.
    pub max_blocks: Option<u64>,
    /// Axis commands (mm, rad) at the start, where they are known.
    pub start: Option<AxisVector>,
    /// Refuse what a correction must not assume: zero offsets and tools without value, motions from unknown positions.
    pub strict: bool,
}

/// Default of [`Options::max_blocks`].
const MAX_BLOCKS: u64 = 10_000_000;
/// After the first error so many blocks more are executed in search of others.
const BLOCKS_AFTER_ERROR: u64 = 1_000_000;
/// After so many different errors the run ends.
const MAX_ERRORS: usize = 100;

/// A running program: an iterator over the elements of the flat stream and the findings.
pub struct Execution<'a> {
    machine: &'a Machine,
    library: Box<dyn Library + 'a>,
    options: Options,
    programs: Vec<Loaded>,
    sources: Vec<Source>,
    /// Those of the definition files, which hold in every program.
    macros: Macros,
    levels: Vec<Level>,
    channel: Channel<'a>,
    findings: VecDeque<Diagnostic>,
    reported: HashSet<(Code, Option<Place>)>,
    errors: usize,
    executed: u64,
    limit: u64,
    /// Call chains: the chain of the caller and its line.
    chains: Vec<(u32, u32)>,
    chain_ids: HashMap<(u32, u32), u32>,
    found: HashMap<String, Option<(usize, usize)>>,
    /// Programs of the texts that EXECSTRING executed.
    texts: HashMap<Vec<u8>, usize>,
    /// The program of MCALL.
    modal_call: Option<call::Entry>,
    is_over: bool,
    is_finished: bool,
}

impl<'a> Execution<'a> {
    /// Starts a program. Syntax findings of the main program are the caller's business; faulty blocks do nothing here.
    #[must_use]
    pub fn new(program: Program, machine: &'a Machine, mut library: Box<dyn Library + 'a>, options: Options) -> Self {
        let limit = options.max_blocks.unwrap_or_else(|| MAX_BLOCKS.max(program.blocks.len() as u64 * 20));
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
        let is_main = |section: &&syntax::Section| section.ending == "MPF" && !section.blocks.is_empty();
        let mut findings = VecDeque::new();
        if let Some(other) = program.sections.iter().filter(is_main).nth(1) {
            let span = other.headers.first().copied().unwrap_or_default();
            let message =
                format!("the main program {} is left out: only the first one of a file is executed", other.name);
            let help = "put each main program into a file of its own";
            findings.push_back(Diagnostic::at(Code::MORE_PROGRAMS, Place { file: source.id(), span }, message, help));
        }
        let mut sources = vec![source];
        let macros = read_definitions(library.as_mut(), &program, &mut channel, &mut sources);
        let loaded = Loaded::new(program, &machine.control);
        // A subprogram that is run by itself has the defaults of its parameters.
        if let Err(found) = parameters::bind(&loaded, &mut channel, loaded.parameters(main), &[]) {
            findings.push_back(found.in_file(loaded.program.source.id()));
        }
        Execution {
            machine,
            library,
            options,
            sources,
            macros,
            programs: vec![loaded],
            levels: vec![Level::new(0, main, start, 0)],
            channel,
            findings,
            reported: HashSet::new(),
            errors: 0,
            executed: 0,
            limit,
            chains: Vec::new(),
            chain_ids: HashMap::new(),
            found: HashMap::new(),
            texts: HashMap::new(),
            modal_call: None,
            is_over: false,
            is_finished: false,
        }
    }

    /// All files of the run so far, by [`crate::source::FileId`].
    #[must_use]
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Blocks executed so far.
    #[must_use]
    pub fn executed_blocks(&self) -> u64 {
        self.executed
    }

    /// Lines of the calls that led to an element, innermost first; empty in the main program.
    #[must_use]
    pub fn call_lines(&self, origin: &Origin) -> Vec<u32> {
        let mut lines = Vec::new();
        let mut chain = origin.calls;
        while let Some(&(caller, line)) = (chain as usize).checked_sub(1).and_then(|index| self.chains.get(index)) {
            lines.push(line);
            chain = caller;
        }
        lines
    }

    /// Executes one block.
    fn step(&mut self) {
        let Some(level) = self.levels.last_mut() else {
            self.is_over = true;
            return;
        };
        if let Some(pending) = level.pending.take() {
            if let Err(found) = self.act(pending.0, &pending.1) {
                self.report_here(found);
            }
            return;
        }
        if !level.parts.is_empty() {
            level.end_parts();
        }
        let loaded = &mut self.programs[level.program];
        // An empty file has no section.
        let Some(section) = loaded.program.sections.get(level.section) else {
            self.is_over = true;
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
        if self.executed >= self.limit {
            self.over_limit(file, &block);
            return;
        }
        self.executed += 1;
        if let Some(skip) = block.skip {
            let place = Place { file, span: block.span };
            let is_skipped = self.options.skip_levels.get(usize::from(skip)).copied().unwrap_or(false);
            // One finding a run: every further block would say the same.
            if !self.reported.iter().any(|(code, _)| *code == Code::SKIP_EXECUTED) {
                let done = if is_skipped { "skipped" } else { "executed" };
                let help = "choose with --skip which levels are left out";
                self.report(Diagnostic::at(
                    Code::SKIP_EXECUTED,
                    place,
                    format!("blocks with / are decided now; this one is {done}"),
                    help,
                ));
            }
            if is_skipped {
                return;
            }
        }
        let loaded = &mut self.programs[program];
        let comment = loaded.take_comment(index, &block);
        let cycle = self.levels.last().and_then(|level| level.cycle);
        let own = Origin { file, line: block.line, span: block.span, calls };
        let origin = cycle.map_or(own, |cycle| cycle.origin);
        let number = block.number.map(|written| BlockNumber { main: written.main, number: written.number });
        self.channel.begin_block(origin, number);
        let action = match self.levels.last_mut() {
            Some(level) => {
                flow::block(loaded, level, &mut self.channel, &block, index, section_blocks, comment, self.machine)
            }
            None => Ok(Action::Next),
        };
        let warnings = std::mem::take(&mut self.channel.warnings);
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

impl Iterator for Execution<'_> {
    type Item = Result<Element, Diagnostic>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(finding) = self.findings.pop_front() {
                return Some(Err(finding));
            }
            if let Some(element) = self.channel.queue.pop_front() {
                return Some(Ok(element));
            }
            if self.is_over {
                if std::mem::replace(&mut self.is_finished, true) {
                    return None;
                }
                self.channel.finish();
                self.report_channel();
                continue;
            }
            self.step();
        }
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
