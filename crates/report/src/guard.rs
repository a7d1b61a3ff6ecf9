//! Check by the control at the start of a corrected program.

use serde::Serialize;

/// Zero offsets and tools that the output compares with those of the correction.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GuardReport {
    /// Names of zero offsets and tools whose values the control compares.
    pub checked: Vec<String>,
    /// Names of those that the program uses but the control cannot compare at the start of a program.
    pub left: Vec<String>,
}

impl GuardReport {
    /// `the control checks G54, T2 D1; not T3`
    #[must_use]
    pub fn words(&self) -> String {
        let left = if self.left.is_empty() { String::new() } else { format!("; not {}", self.left.join(", ")) };
        match self.checked.is_empty() {
            true => format!("the control checks nothing{left}"),
            false => format!("the control checks {}{left}", self.checked.join(", ")),
        }
    }
}
