//! From the flat stream to the corrected program: subdivision, correction, the motion of the control in time, the output text, and the review of
//! changes.

pub mod emit;
pub mod path;
pub mod review;
pub mod servo;
