//! What a family of languages is made of: its tree, and what it keeps for each file, level and call.

use std::fmt::Debug;
use std::hash::Hash;

use super::program::{LoadedFile, ProgramText};

/// A family of languages.
pub(in crate::exec) trait Family: Sized {
    /// A file as its grammar reads it.
    type Program: ProgramText;
    /// What is worked out of a file once, when it is loaded.
    type Prepared;
    /// How a program is named where it is looked for.
    type Name: Eq + Hash;
    /// Where a program begins.
    type Entry: Copy;
    /// A call that a block asks for.
    type Call: Debug;
    /// Where a return leads.
    type Return: Debug;
    /// How a program says that it ends.
    type End: Debug;
    /// What happens with each pass of a repetition; nothing is `()`.
    type Pass: Copy + Debug;
    /// What a level keeps beside its place: how it was called, what it gives back.
    type Level;
}

/// A file of a family.
pub(in crate::exec) type FileOf<F> = LoadedFile<<F as Family>::Program, <F as Family>::Prepared>;

/// A block of a family.
pub(in crate::exec) type BlockOf<F> = <<F as Family>::Program as ProgramText>::Block;
