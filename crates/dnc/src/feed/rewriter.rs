//! Lines for a control that reads the lines of a program in another way.

/// Converts the lines of a program for a control that reads them in another way. It follows the states that the lines set, so it takes all lines of a job, in
/// their order.
pub trait LineRewriter: Send {
    /// The lines that the control gets instead of this one; none if the line has no effect on it.
    ///
    /// # Errors
    /// The control has no lines with this effect. The error is a sentence.
    fn rewrite(&mut self, text: &[u8]) -> Result<Vec<Vec<u8>>, String>;
}
