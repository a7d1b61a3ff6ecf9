//! Access to files: reads programs with their folders, archives of controls, tables and machine files; writes texts
//! completely or not at all.
//!
//! The library opens files only here, and only in functions whose names state it. Each file that is read is logged
//! with the reason.

pub(crate) mod archive;
pub(crate) mod atomic_writes;
pub(crate) mod files;
pub(crate) mod fingerprint;
pub(crate) mod folder_library;
#[cfg(test)]
mod folder_library_tests;
pub(crate) mod hash;
pub(crate) mod kept_library;
pub(crate) mod machine_file;
pub(crate) mod measurements;
pub(crate) mod numbered_programs;
pub(crate) mod origin;
pub(crate) mod output;
pub(crate) mod pager;
pub(crate) mod pages;
pub(crate) mod parameters;
mod replace;
pub(crate) mod stated_machine;
pub(crate) mod table_files;
mod target;
pub(crate) mod traces;
