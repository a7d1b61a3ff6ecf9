//! The blocks of an incomplete spline.

use super::curve::End;
use super::modal::MotionKind;
use crate::exec::core::contour::ContourRequest;
use crate::exec::core::fault::Fault;
use crate::exec::core::fault::fault;
use crate::exec::core::path::Path;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisVector;
use ncfix_machine::snc::Element;
/// Maximum number of blocks and elements of one spline.
pub(super) const MOST_HELD: usize = 100_000;

/// The spline data of a block.
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
    Path(Box<Path>, Element, Node, Option<Box<ContourRequest>>),
}

/// The blocks of an incomplete spline.
#[derive(Debug, Default)]
pub(super) struct Splines {
    pub(super) held: Vec<HeldBlock>,
    /// Direction of the preceding motion, if needed.
    pub(super) before: Option<AxisVector>,
}

impl Splines {
    pub(super) fn is_holding(&self) -> bool {
        !self.held.is_empty()
    }

    /// Holds an element after the blocks of a spline; an error if there are too many.
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
