//! The contour stage: holds motions back until what follows them is known.
//!
//! First [`transition`] puts roundings and chamfers between contour elements, then [`compensation`] moves them sideways by the radius
//! of the tool. Motions that nothing changes pass through at once. While one is held, the elements behind it wait with it, so that
//! the order of the stream stays that of the program.

mod angle;
mod approach;
#[cfg(test)]
mod bench;
mod chain;
mod check;
mod compensation;
mod corner;
mod curve;
mod gap;
mod guard;
mod link;
mod moving;
mod reach;
mod rs274;
#[cfg(test)]
mod rs274_tests;
mod rules;
mod soft;
mod stage;
#[cfg(test)]
mod stage_tests;
mod switch;
mod tracking;
mod transition;
mod unknown;
mod wish;

pub(in crate::exec) use angle::crossing;
pub(in crate::exec) use moving::{Item, Moving};
pub(in crate::exec) use stage::ContourStage;
pub(in crate::exec) use unknown::unstated;
pub(in crate::exec) use wish::{
    Approach, Clearance, ContourModal, Corner, FeedAt, Reach, Shown, Side, Soft, SoftForm, SoftSide, Transition, Wish,
};
