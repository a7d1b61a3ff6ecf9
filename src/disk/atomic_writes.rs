//! Several texts of one run, written all or none.

use std::cmp::Reverse;
use std::path::PathBuf;

use super::output::{Old, Spool, Target};
use crate::error::Error;

/// Texts of one run: each is on the disk before the first gets its name.
#[derive(Default)]
pub(crate) struct AtomicWrites {
    spools: Vec<Spool>,
}

impl AtomicWrites {
    /// Takes a text that is complete.
    ///
    /// # Errors
    /// A sentence where the disk has no room for it.
    pub(crate) fn take(&mut self, spool: Spool) -> Result<(), Error> {
        spool.spare_inputs()?;
        self.put(spool)
    }

    /// Adds a file that replaces the program that was read, whose old version is then kept ([`Old::Kept`]).
    ///
    /// # Errors
    /// A sentence where the disk has no room for it.
    pub(crate) fn put(&mut self, mut spool: Spool) -> Result<(), Error> {
        if let Some(other) = self.spools.iter().find(|other| other.target().is_also(spool.target())) {
            let message = format!("two outputs of this run would be {}; give each its own file", other.target());
            return Err(Error::usage(message));
        }
        spool.settle()?;
        self.spools.push(spool);
        Ok(())
    }

    /// Adds a file from a text in memory.
    ///
    /// # Errors
    /// A sentence where it cannot be written.
    pub(crate) fn add(&mut self, target: Target, text: &[u8]) -> Result<(), Error> {
        let mut spool = Spool::new(target)?;
        spool.writer().write_all(text).map_err(|error| spool.fault(&error))?;
        self.take(spool)
    }

    /// Writes to devices and pipes, which may refuse, and gives the others their names, the first that came, which matters most, last.
    ///
    /// # Errors
    /// A sentence where that fails.
    pub(crate) fn publish(self) -> Result<(), Error> {
        self.publish_first(Old::Replaced).map(drop)
    }

    /// The same; `old` says what becomes of the file that the first one takes the place of. The path of that file, where it was kept.
    ///
    /// # Errors
    /// A sentence where that fails.
    pub(crate) fn publish_first(self, old: Old<'_>) -> Result<Option<PathBuf>, Error> {
        let mut order: Vec<(usize, Spool)> = self.spools.into_iter().enumerate().collect();
        order.sort_by_key(|(number, spool)| (spool.target().is_file(), Reverse(*number)));
        let mut kept = None;
        // Before the first of them is written: a file that is newer refuses all.
        for (number, spool) in &order {
            spool.is_expected(if *number == 0 { old } else { Old::Replaced })?;
        }
        for (number, spool) in order {
            kept = kept.or(spool.publish(if number == 0 { old } else { Old::Replaced })?);
        }
        Ok(kept)
    }
}
