//! Programs that are loaded.

use crate::exec::core::flags::Flags;
use std::collections::HashMap;
use std::ops::Range;

use super::assign::define;
use super::channel::Channel;
use super::jump::Place;
use super::names::{self, Meaning};
use super::{Interpreter, cycles};
use crate::exec::core::library::Library;
use crate::syntax::sinumerik::{self, Block, Body, Definition, Macros, Parameter, Program};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Control;

/// A program file, ready to run.
pub(super) struct Loaded {
    pub(super) program: Program,
    pub(super) meanings: Vec<Meaning>,
    /// Targets of its jumps, where they were looked up already.
    pub(super) targets: Vec<Option<usize>>,
    /// Blocks of its jumps with computed targets, as far as they were looked up.
    pub(super) computed: HashMap<(usize, Place), usize>,
    /// Blocks of its repetitions, where they were looked up already.
    pub(super) parts: Vec<Option<(usize, usize)>>,
    /// By section: first and number of the parameters of its PROC block, and whether it has SAVE.
    procs: Vec<(u32, u16, bool)>,
    /// Blocks whose comments were passed on already.
    commented: Flags,
    /// The name of a built-in cycle.
    pub(super) built_in: Option<&'static str>,
}

impl Loaded {
    pub(super) fn new(program: Program, control: &Control) -> Self {
        let meanings = names::resolve(&program, program.dialect, control);
        let targets = vec![None; program.jumps.len()];
        let commented = Flags::new(program.blocks.len());
        let parts = vec![None; program.repetitions.len()];
        let procs =
            program.sections.iter().map(|section| proc_of(program.blocks.there(section.blocks.clone()))).collect();
        Loaded { program, meanings, targets, computed: HashMap::new(), parts, procs, commented, built_in: None }
    }

    /// Makes it a cycle of the control: its comments are nobody's, and SETAL in it is a finding.
    fn become_built_in(&mut self, name: &str) {
        self.built_in = cycles::source(name).map(|(name, _)| name);
        self.commented.note_all();
        let names = self.program.names.iter();
        for (meaning, _) in self.meanings.iter_mut().zip(names).filter(|(_, name)| *name == "SETAL") {
            *meaning = Meaning::Alarm;
        }
    }

    /// The parameters of a section's program.
    pub(super) fn parameters(&self, section: usize) -> &[Parameter] {
        self.procs.get(section).map_or(&[], |&(start, count, _)| self.program.parameters_of(start, count))
    }

    /// Whether a section's program has SAVE.
    pub(super) fn has_save(&self, section: usize) -> bool {
        self.procs.get(section).is_some_and(|&(_, _, save)| save)
    }

    /// The comment of a block the first time it is executed: a loop does not repeat its comments.
    pub(super) fn take_comment(&mut self, index: usize, block: &Block) -> Option<Vec<u8>> {
        if block.comment.start == block.comment.end || self.commented.note(index).unwrap_or(true) {
            return None;
        }
        Some(self.program.source.slice(block.comment).to_vec())
    }
}

/// What the PROC block says, which stands before all that is executed.
fn proc_of(blocks: &[Block]) -> (u32, u16, bool) {
    let first = blocks.iter().find(|block| !matches!(block.body, Body::Empty | Body::Declaration));
    match first.map(|block| block.body) {
        Some(Body::Proc { start, count, save, .. }) => (start, count, save),
        _ => (0, 0, false),
    }
}

/// The name of a program without path, `_N_` and ending, upper case.
pub(super) fn program_name(path: &str) -> String {
    let name = path.rsplit(['/', '\\', ':']).next().unwrap_or(path).trim().to_ascii_uppercase();
    let name = name.strip_prefix("_N_").unwrap_or(&name);
    let endings = ["_SPF", "_MPF", ".SPF", ".MPF"];
    endings.iter().find_map(|ending| name.strip_suffix(ending)).unwrap_or(name).to_owned()
}

impl Interpreter<'_> {
    /// Loads a program from the library or from among the built-in cycles.
    pub(super) fn load(&mut self, path: &str, name: &str, is_path: bool) -> Option<(usize, usize)> {
        let found = if is_path { self.library.load_path(path, name) } else { self.library.load(name) };
        let built_in =
            || cycles::source(name).filter(|_| !is_path).map(|(_, text)| (format!("{name} (built in)"), text.to_vec()));
        let is_user = found.is_some();
        let (shown, bytes) = found.or_else(built_in)?;
        let id = self.ledger.next_file()?;
        let source = Source::new(id, &shown, bytes).ok()?;
        let (program, findings) = sinumerik::parse_with(&source, self.programs[0].program.dialect, &self.macros);
        // With what its macros made of it.
        self.ledger.sources.push(program.source.clone());
        for finding in findings {
            self.report(finding);
        }
        let section = section_of(&program, name)
            .or_else(|| program.sections.iter().position(|section| !section.blocks.is_empty()))?;
        let mut loaded = Loaded::new(program, &self.machine.control);
        if !is_user {
            loaded.become_built_in(name);
        }
        self.programs.push(loaded);
        Some((self.programs.len() - 1, section))
    }
}

/// Reads the definition files of a library: their macros, and their variables, which all programs see.
pub(super) fn read_definitions(
    library: &mut (dyn Library + '_),
    program: &Program,
    channel: &mut Channel<'_>,
    sources: &mut Vec<Source>,
) -> Macros {
    let mut macros = Macros::default();
    let own = program.sections.iter().filter(|section| section.ending == "DEF").map(|section| section.blocks.clone());
    let own: Vec<Range<usize>> = own.collect();
    if !own.is_empty() {
        let mut program = program.clone();
        program.keep_whole();
        let loaded = Loaded::new(program, &channel.machine.control);
        own.into_iter().for_each(|blocks| define_globals(&loaded, channel, blocks));
    }
    for (name, bytes) in library.definitions() {
        macros.read(&bytes);
        let Ok(id) = u16::try_from(sources.len()) else { break };
        let Ok(source) = Source::new(FileId(id), &name, bytes) else { continue };
        let (mut program, _) = sinumerik::parse_with(&source, program.dialect, &macros);
        program.keep_whole();
        sources.push(program.source.clone());
        let blocks = 0..program.blocks.len();
        define_globals(&Loaded::new(program, &channel.machine.control), channel, blocks);
    }
    macros
}

/// Defines the variables of a definition file. What cannot be defined is missed where it is used.
fn define_globals(loaded: &Loaded, channel: &mut Channel<'_>, blocks: Range<usize>) {
    for block in &loaded.program.blocks[blocks] {
        let Body::Define { start, count } = block.body else { continue };
        for definition in loaded.program.definitions_of(start, count) {
            let _ = define(loaded, channel, &Definition { is_global: true, ..*definition });
        }
    }
}

/// The section of a program that has this name.
pub(super) fn section_of(program: &Program, name: &str) -> Option<usize> {
    program.sections.iter().position(|section| section.name == name)
}
