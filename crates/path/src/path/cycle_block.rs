//! A hole that the output leaves to a drilling cycle of the control.

use std::sync::Arc;

use ncfix_base::geometry::{AXIS_COUNT, AxisSet, AxisVector};
use ncfix_machine::snc::{BlockNumber, DrillingCycle, FeedUnit, Origin};

/// A corrected hole, its coordinates a whole number of increments in the emitted frame.
#[derive(Clone, Debug, PartialEq)]
pub struct CycleBlock {
    /// Origin of its first move.
    pub origin: Origin,
    /// `true` if a new executed block starts with it.
    pub starts_block: bool,
    /// The block number, on the output that starts the block.
    pub number: Option<BlockNumber>,
    /// The cycle with the words of the program.
    pub cycle: Arc<DrillingCycle>,
    /// Axes across the hole to write; none if the tool is there.
    pub words: AxisSet,
    /// Coordinates of the bottom, increments.
    pub position: [i64; AXIS_COUNT],
    /// Height at which the feed begins along the drilling axis, increments.
    pub reference: i64,
    /// Height of the bottom along the drilling axis, increments.
    pub bottom: i64,
    /// Difference of all heights of the call from those of the program, increments.
    pub shift: i64,
    /// Depth of one peck, increments, if the number of pecks follows from it.
    pub peck: Option<i64>,
    /// Active feed.
    pub feed: f64,
    /// Unit of the feed.
    pub unit: FeedUnit,
    /// `true` if the source names the feed in the block.
    pub feed_named: bool,
    /// Axis commands after the cycle, without tool: mm, rad.
    pub command: AxisVector,
    /// Commands of the program after the cycle.
    pub nominal: AxisVector,
}
