//! The rules of radius compensation of each control, and their use by an executor.
//!
//! An executor keeps a [`ContourModal`], created by [`ContourModal::fanuc`], [`ContourModal::rs274`] or [`ContourModal::grundig`] (Sinumerik:
//! `default`). The blocks set
//! * [`ContourModal::side`] by G40, G41, G42,
//! * [`ContourModal::activation`], incremented at each G41, G42 (G41.1, G42.1), because RS274/NGC starts again at a G41 that follows G40 without a motion,
//! * [`ContourModal::leaves_along`] in a block of G40 with I and J (Fanuc): the direction in which the tool leaves, rotated with the frame,
//! * [`ContourModal::reach`] by G43 and G44 (Grundig); G40, G41 and G42 set it to `End` again.
//!
//! Each motion then enters the contour stage with [`ContourRequest::of`], which uses the active radius. A motion may bypass the stage only if
//! [`ContourModal::is_plain`] is `true` and the stage is empty. Otherwise the stage may still need the motion that leaves the contour.

use super::contour_request::{Approach, ContourModal, ContourRequest, FeedAt, Reach, Rules, Side};
use ncfix_base::source::{FileId, Span};
use ncfix_machine::machine::{CompensationCorner, CompensationStart, Control};

impl ContourModal {
    /// Rules of cutter compensation C.
    pub(in crate::exec) fn fanuc(control: &Control) -> ContourModal {
        let approach = match control.compensation_start {
            CompensationStart::A => Approach::Norm,
            CompensationStart::B => Approach::Own,
        };
        let sharp = control.compensation_corner != Some(CompensationCorner::Circular);
        let feed_at = match control.iso.least_arc_feed_percent {
            100 => FeedAt::Center,
            least => FeedAt::InnerContour(least),
        };
        ContourModal { rules: Rules::Fanuc, approach, sharp, feed_at, ..ContourModal::default() }
    }

    /// Rules of LinuxCNC.
    pub(in crate::exec) fn rs274() -> ContourModal {
        ContourModal {
            rules: Rules::Rs274,
            approach: Approach::Own,
            feed_at: FeedAt::Center,
            ..ContourModal::default()
        }
    }

    /// Rules of Grundig, Philips, MillPlus.
    pub(in crate::exec) fn grundig(control: &Control) -> ContourModal {
        let sharp = control.compensation_corner == Some(CompensationCorner::Linear);
        ContourModal { rules: Rules::Grundig, sharp, feed_at: FeedAt::Center, ..ContourModal::default() }
    }

    /// `true` if the tool path depends on the start of the first compensated motion.
    pub(in crate::exec) fn depends_on_start(&self) -> bool {
        self.approach != Approach::Norm || self.reach != Reach::End
    }
}

impl ContourRequest {
    /// The contour request of a motion with a tool radius (a negative one swaps sides), without roundings and soft approaches.
    pub(in crate::exec) fn of(modal: ContourModal, radius_mm: f64, span: Span, file: FileId) -> ContourRequest {
        let distance_mm = match modal.side {
            Side::Left => radius_mm,
            Side::Right => -radius_mm,
            Side::Off if modal.reach == Reach::End => 0.0,
            Side::Off => radius_mm,
        };
        ContourRequest { modal, distance_mm, corner: None, soft: None, doubt: None, span, file }
    }
}
