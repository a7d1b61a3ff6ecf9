//! Options of a transfer.

use std::time::Duration;

/// Options for sending a program to a control. `FeedOptions::default()` gives the options of `ncfix feed` without arguments.
///
/// ```
/// use ncfix::prelude::*;
///
/// let mut options = FeedOptions::default();
/// assert_eq!(options.max_shift_mm, 0.2);
/// options.rapids_only = true;
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FeedOptions {
    /// Sends the program even if the control will have to wait for lines.
    pub allow_starvation: bool,
    /// The user has checked that the machine stands still. Needed for links that cannot query it.
    pub machine_stands_still: bool,
    /// Path of the file on the control, for links that send the program as one file; `None` for that of the profile.
    pub control_file: Option<String>,
    /// Interval between two evaluations of the temperatures.
    pub every: Duration,
    /// The zero point of the workpiece was set in the condition at the start of the job: drift is relative to this condition.
    pub zero_now: bool,
    /// True if temperature changes take effect on rapid moves only.
    pub rapids_only: bool,
    /// Largest change of the thermal correction from one feed block to the next, mm.
    pub dose_per_block_mm: f64,
    /// Largest change of the thermal correction per mm of path, mm.
    pub dose_per_mm: f64,
    /// Largest change of the thermal correction per second, mm.
    pub dose_per_s_mm: f64,
    /// A thermal correction above this value causes a warning, mm.
    pub warn_shift_mm: f64,
    /// A thermal correction above this value stops the transfer, mm.
    pub max_shift_mm: f64,
}

impl Default for FeedOptions {
    fn default() -> FeedOptions {
        FeedOptions {
            allow_starvation: false,
            machine_stands_still: false,
            control_file: None,
            every: Duration::from_secs(60),
            zero_now: false,
            rapids_only: false,
            dose_per_block_mm: 1e-3,
            dose_per_mm: 1e-4,
            dose_per_s_mm: 5e-4,
            warn_shift_mm: 0.05,
            max_shift_mm: 0.2,
        }
    }
}
