//! The blocks of a spline that is not complete yet.

use super::curve::End;
use super::modal::MotionKind;
use crate::exec::core::contour::Wish;
use crate::exec::core::fault::Fault;
use crate::exec::core::fault::fault;
use crate::exec::core::path::Path;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisVector;
use ncfix_machine::snc::Element;
/// Blocks and elements of one spline at most.
pub(super) const MOST_HELD: usize = 100_000;

/// What a block says of its place in a spline.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) kind: MotionKind,
    pub(super) length: Option<f64>,
    pub(super) weight: f64,
    pub(super) degree: Option<usize>,
    pub(super) ends: [End; 2],
}

#[derive(Debug)]
pub(super) enum HeldBlock {
    Element(Element),
    Path(Box<Path>, Element, Node, Option<Box<Wish>>),
}

/// The blocks of the spline that is not complete yet.
#[derive(Debug, Default)]
pub(super) struct Splines {
    pub(super) held: Vec<HeldBlock>,
    /// Direction of the motion before it, where it matters.
    pub(super) before: Option<AxisVector>,
}

impl Splines {
    pub(super) fn is_holding(&self) -> bool {
        !self.held.is_empty()
    }

    /// Holds an element back behind the blocks of a spline; a finding where these are too many.
    pub(super) fn hold(&mut self, element: Element) -> Option<Fault> {
        let found = (self.held.len() >= MOST_HELD).then(|| {
            let message = format!("a spline of more than {MOST_HELD} blocks");
            self.held.clear();
            fault(Code::NOT_SUPPORTED, element.origin.span, message, "end it with G1 earlier")
        });
        self.held.push(HeldBlock::Element(element));
        found
    }
}
