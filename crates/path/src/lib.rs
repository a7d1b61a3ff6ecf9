//! From the flat stream to a corrected program: subdivision, correction, what the control makes of it in time, the text, and what changed.

pub mod emit;
pub mod path;
pub mod review;
pub mod servo;
