//! Several texts of one run, written all or none.

use super::output::{Spool, Target};
use super::stop::Stop;

/// Texts of one run: each is on the disk before the first gets its name.
#[derive(Default)]
pub(super) struct Together {
    spools: Vec<Spool>,
}

impl Together {
    /// Takes a text that is complete.
    ///
    /// # Errors
    /// A sentence where the disk has no room for it.
    pub(super) fn take(&mut self, mut spool: Spool) -> Result<(), Stop> {
        spool.spare_inputs()?;
        if let Some(other) = self.spools.iter().find(|other| other.target().is_also(spool.target())) {
            return Err(Stop::Usage(format!("two outputs of this run would be {}", other.target())));
        }
        spool.settle()?;
        self.spools.push(spool);
        Ok(())
    }

    /// The same of a text in memory.
    ///
    /// # Errors
    /// A sentence where it cannot be written.
    pub(super) fn add(&mut self, target: Target, text: &[u8]) -> Result<(), Stop> {
        let mut spool = Spool::new(target)?;
        spool.writer().write_all(text).map_err(|error| spool.fault(&error))?;
        self.take(spool)
    }

    /// Writes to devices and pipes, which may refuse, and gives the others their names, the first that came, which matters most, last.
    ///
    /// # Errors
    /// A sentence where that fails.
    pub(super) fn publish(self) -> Result<(), Stop> {
        let (files, others): (Vec<Spool>, Vec<Spool>) =
            self.spools.into_iter().partition(|spool| spool.target().is_file());
        others.into_iter().chain(files.into_iter().rev()).try_for_each(|spool| spool.publish(false).map(drop))
    }
}
