//! Files of a disk: programs with the folders beside them, archives of controls, tables, machine files are read; texts are written as a whole or not at all.
//!
//! The library opens files here only, and only for functions whose names say so. What was read, and why, is logged.

pub(crate) mod archive;
pub(crate) mod atomic_writes;
pub(crate) mod files;
pub(crate) mod fingerprint;
pub(crate) mod folder_library;
#[cfg(test)]
mod folder_library_tests;
pub(crate) mod hash;
pub(crate) mod machine_file;
pub(crate) mod measurements;
pub(crate) mod origin;
pub(crate) mod output;
pub(crate) mod parameters;
mod replace;
pub(crate) mod table_files;
mod target;
pub(crate) mod traces;
