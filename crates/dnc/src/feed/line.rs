//! One line on its way to a control.

use std::sync::Arc;
use std::time::Duration;

use ncfix_base::geometry::AXIS_COUNT;

/// A line that is frozen: nothing of it changes any more.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// Its number in the transfer, from 1.
    pub number: u64,
    /// Its text without its end.
    pub text: Vec<u8>,
    /// Line of the source from which it comes, from 1; 0 for none.
    pub source_line: u32,
    /// Number of the piece or other element of the corrected program from which it comes, from 1; the same whenever the program is run.
    pub element: u64,
    /// What was added to the axes by the second step, mm or rad.
    pub offset: [f64; AXIS_COUNT],
    /// The same as the model asks for.
    pub target: [f64; AXIS_COUNT],
    /// How long the control is busy with it, s; 0 where it does not move.
    pub busy_s: f64,
    /// Temperatures by sensor, °C, that count from this line on, where they are others than before.
    pub temperatures_c: Option<Arc<[(String, f64)]>>,
}

/// No block takes longer: eleven days.
const LONGEST: Duration = Duration::from_secs(1_000_000);

impl Line {
    /// How long the control is busy with it; nothing where that is no time.
    #[must_use]
    pub fn busy(&self) -> Duration {
        Duration::try_from_secs_f64(self.busy_s).unwrap_or_default().min(LONGEST)
    }
}

/// The checksum of bytes (CRC-32 of ISO/IEC 8802-3), by which a line of a journal is known again.
#[must_use]
pub fn crc32(bytes: &[u8]) -> u32 {
    crc32fast::hash(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_value_of_the_catalogue_of_checksums() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }

    #[test]
    fn what_is_no_time_takes_none() {
        let busy = |busy_s| Line { busy_s, ..Line::default() }.busy();
        assert_eq!(busy(0.5), Duration::from_millis(500));
        assert_eq!([f64::NAN, -1.0, f64::INFINITY].map(busy), [Duration::ZERO; 3]);
        assert_eq!(busy(1e9), LONGEST);
    }
}
