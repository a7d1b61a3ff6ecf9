//! Whose rules of radius compensation hold, and how the executor of a language asks for them.
//!
//! An executor keeps a [`ContourModal`], made once by [`ContourModal::fanuc`], [`ContourModal::rs274`] or [`ContourModal::grundig`]
//! (Sinumerik: `default`). Of it the blocks set
//! * [`ContourModal::side`] by G40, G41, G42,
//! * [`ContourModal::activation`], one more at each G41, G42 (G41.1, G42.1): RS274/NGC begins anew behind G40 without a motion between,
//! * [`ContourModal::leaves_along`] in the block of G40 with I J only (Fanuc): the direction, turned as the frame turns the plane,
//! * [`ContourModal::reach`] by G43 and G44 (Grundig), `End` again by G40, G41, G42.
//!
//! Each motion then goes into the stage with [`Wish::of`], which takes the radius in force. A motion may stay out of it only where
//! [`ContourModal::is_plain`] says so and the stage holds nothing: the stage may wait for the motion that leads off the contour.

use super::wish::{Approach, ContourModal, FeedAt, Reach, Rules, Side, Wish};
use ncfix_base::source::{FileId, Span};
use ncfix_machine::machine::{CompensationCorner, CompensationStart, Control};

impl ContourModal {
    /// Cutter compensation C.
    pub(in crate::exec) fn fanuc(control: &Control) -> ContourModal {
        let approach = match control.compensation_start {
            CompensationStart::A => Approach::Norm,
            CompensationStart::B => Approach::Own,
        };
        let sharp = control.compensation_corner != Some(CompensationCorner::Circular);
        ContourModal { rules: Rules::Fanuc, approach, sharp, feed_at: FeedAt::Center, ..ContourModal::default() }
    }

    /// LinuxCNC.
    pub(in crate::exec) fn rs274() -> ContourModal {
        ContourModal {
            rules: Rules::Rs274,
            approach: Approach::Own,
            feed_at: FeedAt::Center,
            ..ContourModal::default()
        }
    }

    /// Grundig, Philips, MillPlus.
    pub(in crate::exec) fn grundig(control: &Control) -> ContourModal {
        let sharp = control.compensation_corner == Some(CompensationCorner::Linear);
        ContourModal { rules: Rules::Grundig, sharp, feed_at: FeedAt::Center, ..ContourModal::default() }
    }

    /// Whether the way of the tool depends on where the first compensated motion starts.
    pub(in crate::exec) fn depends_on_start(&self) -> bool {
        self.approach != Approach::Norm || self.reach != Reach::End
    }
}

impl Wish {
    /// What a motion asks of the stage with a tool radius (a negative one changes sides); without roundings and soft approaches.
    pub(in crate::exec) fn of(modal: ContourModal, radius_mm: f64, span: Span, file: FileId) -> Wish {
        let distance_mm = match modal.side {
            Side::Left => radius_mm,
            Side::Right => -radius_mm,
            Side::Off if modal.reach == Reach::End => 0.0,
            Side::Off => radius_mm,
        };
        Wish { modal, distance_mm, corner: None, soft: None, span, file }
    }
}
