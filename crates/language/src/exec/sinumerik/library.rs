//! Finds programs, and reads the definition files of the control.

use std::ops::Range;

use super::assign::define;
use super::channel::Channel;
use super::cycles;
use super::level::{Interpreter, Loaded};
use super::loaded::load;
use crate::exec::core::library::Library;
use crate::syntax::sinumerik::{self, Body, Definition, Macros, Program};
use ncfix_base::source::{FileId, Source};

/// The name of a program without path, `_N_` and extension, upper case.
pub(super) fn program_name(path: &str) -> String {
    let name = path.rsplit(['/', '\\', ':']).next().unwrap_or(path).trim().to_ascii_uppercase();
    let name = name.strip_prefix("_N_").unwrap_or(&name);
    let endings = ["_SPF", "_MPF", ".SPF", ".MPF"];
    endings.iter().find_map(|ending| name.strip_suffix(ending)).unwrap_or(name).to_owned()
}

impl Interpreter<'_> {
    /// Loads a program from the library or from the built-in cycles.
    pub(super) fn load(&mut self, path: &str, name: &str, is_path: bool) -> Option<(usize, usize)> {
        let found = if is_path { self.library.load_path(path, name) } else { self.library.load(name) };
        let built_in =
            || cycles::source(name).filter(|_| !is_path).map(|(_, text)| (format!("{name} (built in)"), text.to_vec()));
        let is_user = found.is_some();
        let (shown, bytes) = found.or_else(built_in)?;
        let program = self.read(&shown, bytes)?;
        let section = section_of(&program, name)
            .or_else(|| program.sections.iter().position(|section| !section.blocks.is_empty()))?;
        let mut loaded = load(program, &self.machine.control);
        if let Some((name, _)) = cycles::source(name).filter(|_| !is_user) {
            loaded.become_built_in(name);
        }
        Some((self.keep(loaded), section))
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
        let loaded = load(program, &channel.settings.machine.control);
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
        define_globals(&load(program, &channel.settings.machine.control), channel, blocks);
    }
    macros
}

/// Defines the variables of a definition file. An invalid definition is reported where its variable is used.
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
