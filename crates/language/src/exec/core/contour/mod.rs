//! The contour stage: holds motions back until the following ones are known.
//!
//! First [`transition`] inserts roundings and chamfers between contour elements, then [`compensation`] offsets them by the tool radius. Unaffected
//! motions pass immediately. While a motion is held, the elements after it wait too, so that the stream keeps the program order.

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
