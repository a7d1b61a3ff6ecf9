//! How a program is executed: what a caller chooses.

use super::radius::Radius;
use ncfix_base::geometry::AxisVector;

/// How to execute.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Skip levels whose blocks are left out.
    pub skip_levels: [bool; 10],
    /// Executed blocks after which the run stops with a finding; `None` for ten million, or twenty times the blocks of the
    /// main program if that is more.
    pub max_blocks: Option<u64>,
    /// Axis commands (mm, rad) at the start, where they are known.
    pub start: Option<AxisVector>,
    /// Refuse what a correction must not assume: zero offsets and tools without value, motions from unknown positions.
    pub strict: bool,
    /// Say at the end where radius compensation has become the way of the tool center (`W0236`).
    pub tells_compensation: bool,
    /// Which radius G41 and G42 work with.
    pub radius: Radius,
    /// Leave the control the words that begin and end radius compensation, for wear alone (`W0237`).
    pub keeps_wear: bool,
    /// Which rapid moves are taken apart, where the control orders its axes.
    pub rapid_order: RapidOrder,
}

/// Which rapid moves an executor takes apart as a control does that moves the tool axis first or last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RapidOrder {
    /// All; a start that is not known is assumed, unless the run is strict.
    #[default]
    All,
    /// Those whose start the program has stated.
    Stated,
    /// None: in a corrected program they are apart already, and what else they move is micrometers.
    None,
}
