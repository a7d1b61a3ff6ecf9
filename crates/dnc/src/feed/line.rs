//! A line on its way to a control.

use std::sync::Arc;
use std::time::Duration;

use ncfix_base::geometry::AXIS_COUNT;

/// Frozen line: it does not change any more.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// Number in the transfer, from 1.
    pub number: u64,
    /// Text without line end.
    pub text: Vec<u8>,
    /// Source line, from 1; 0 if there is none.
    pub source_line: u32,
    /// Number of the piece or other element of the corrected program, from 1; the number is equal in every run of the program.
    pub element: u64,
    /// Thermal correction added to the axes, mm or rad.
    pub offset: [f64; AXIS_COUNT],
    /// Correction that the model asks for, mm or rad.
    pub target: [f64; AXIS_COUNT],
    /// Time for which it keeps the control busy, s; 0 without motion.
    pub busy_s: f64,
    /// Temperatures by sensor, °C, valid from this line on; `None` if they have not changed.
    pub temperatures_c: Option<Arc<[(String, f64)]>>,
}

/// Upper limit of the duration of a block: eleven days.
const LONGEST: Duration = Duration::from_secs(1_000_000);

impl Line {
    /// Returns the time for which the line keeps the control busy; zero if the number is not a valid time.
    #[must_use]
    pub fn busy(&self) -> Duration {
        Duration::try_from_secs_f64(self.busy_s).unwrap_or_default().min(LONGEST)
    }
}

/// Returns the checksum of bytes (CRC-32 of ISO/IEC 8802-3), which identifies a line of a journal.
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
