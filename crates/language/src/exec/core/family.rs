//! The types of a family of languages: its tree, and its data per file, level and call.

use std::fmt::Debug;
use std::hash::Hash;

use super::program::{LoadedFile, ProgramText};

/// A family of languages.
pub(in crate::exec) trait Family: Sized {
    /// A file as parsed by its grammar.
    type Program: ProgramText;
    /// Data derived once from a file when it is loaded.
    type Prepared;
    /// Name of a program in searches.
    type Name: Eq + Hash;
    /// Start of a program.
    type Entry: Copy;
    /// A call requested by a block.
    type Call: Debug;
    /// Target of a return.
    type Return: Debug;
    /// Form of a program end.
    type End: Debug;
    /// Action at each pass of a repetition; `()` for none.
    type Pass: Copy + Debug;
    /// Data of a level other than its position: its call, and the state to restore.
    type Level;
}

/// A file of a family.
pub(in crate::exec) type FileOf<F> = LoadedFile<<F as Family>::Program, <F as Family>::Prepared>;

/// A block of a family.
pub(in crate::exec) type BlockOf<F> = <<F as Family>::Program as ProgramText>::Block;
