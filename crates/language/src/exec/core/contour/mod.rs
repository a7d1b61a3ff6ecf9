//! The contour stage: holds motions back until the following ones are known.
//!
//! First [`transition`] inserts roundings and chamfers between contour elements, then [`compensation`] offsets them by the tool radius. Unaffected
//! motions pass immediately. While a motion is held, the elements after it wait too, so that the stream keeps the program order.

mod angle;
mod approach;
mod chain;
mod check;
mod compensation;
mod contour_request;
mod corner;
mod curve;
mod departure;
#[cfg(test)]
mod fixture;
mod gap;
mod guard;
mod link;
mod lost;
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

pub(in crate::exec) use angle::crossing;
pub(in crate::exec) use contour_request::{
    Approach, Clearance, CompensationDoubt, ContourModal, ContourRequest, Corner, FeedAt, Reach, Shown, Side, Soft,
    SoftForm, SoftSide, Transition,
};
pub(in crate::exec) use moving::{Item, Moving};
pub(in crate::exec) use stage::ContourStage;
pub(in crate::exec) use unknown::unstated;
