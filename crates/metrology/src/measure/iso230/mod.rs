//! Figures of the acceptance tests of ISO 230: plain arithmetic on what was measured, without an error model.

pub mod circle;
pub mod drift;
pub mod figures;
pub mod positioning;
pub mod sphere;
mod zone;

pub use zone::{Zone, minimum_zone};
