//! Several output files of one run, of which either all or none are written.

use std::cmp::Reverse;
use std::path::PathBuf;

use super::output::{Old, Spool, Target};
use crate::error::Error;

/// Texts of one run: each is on the disk before the first one gets its name.
#[derive(Default)]
pub(crate) struct AtomicWrites {
    spools: Vec<Spool>,
}

impl AtomicWrites {
    /// Adds a complete text.
    ///
    /// # Errors
    /// If the disk has no room for it.
    pub(crate) fn take(&mut self, spool: Spool) -> Result<(), Error> {
        spool.spare_inputs()?;
        self.put(spool)
    }

    /// Adds a file that replaces the input program, and keeps the old version ([`Old::Kept`]).
    ///
    /// # Errors
    /// If the disk has no room for it.
    pub(crate) fn put(&mut self, mut spool: Spool) -> Result<(), Error> {
        if let Some(other) = self.spools.iter().find(|other| other.target().is_also(spool.target())) {
            let message = format!("two outputs of this run would be {}; give each its own file", other.target());
            return Err(Error::usage(message));
        }
        spool.settle()?;
        self.spools.push(spool);
        Ok(())
    }

    /// Adds a file with a text in memory.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(crate) fn add(&mut self, target: Target, text: &[u8]) -> Result<(), Error> {
        let mut spool = Spool::new(target)?;
        spool.writer().write_all(text).map_err(|error| spool.fault(&error))?;
        self.take(spool)
    }

    /// Writes first to devices and pipes, which may refuse the text. Then gives the other files their names; the
    /// first one added, which matters most, is last.
    ///
    /// # Errors
    /// If a text cannot be written.
    pub(crate) fn publish(self) -> Result<(), Error> {
        self.publish_first(Old::Replaced).map(drop)
    }

    /// Publishes the texts; `old` is the handling of the file that the first one replaces. Returns the path of that
    /// file if it is kept.
    ///
    /// # Errors
    /// If a text cannot be written.
    pub(crate) fn publish_first(self, old: Old<'_>) -> Result<Option<PathBuf>, Error> {
        let mut order: Vec<(usize, Spool)> = self.spools.into_iter().enumerate().collect();
        order.sort_by_key(|(number, spool)| (spool.target().is_file(), Reverse(*number)));
        let mut kept = None;
        // Checked before the first one is written: a newer file refuses all.
        for (number, spool) in &order {
            spool.is_expected(if *number == 0 { old } else { Old::Replaced })?;
        }
        for (number, spool) in order {
            kept = kept.or(spool.publish(if number == 0 { old } else { Old::Replaced })?);
        }
        Ok(kept)
    }
}
