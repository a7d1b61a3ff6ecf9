//! Figures of the acceptance tests of ISO 230: direct arithmetic on measured values, without an error model.

pub mod circle;
pub mod drift;
pub mod figures;
pub mod positioning;
pub mod sphere;
mod straightness;
mod zone;

pub use zone::{Zone, minimum_zone};
