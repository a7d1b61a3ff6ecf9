//! What stands between contour elements and is not known: programs of the control, stops of the look-ahead, words that are passed on.

use super::moving::{Item, Moving};
use crate::diagnostic::Code;
use crate::exec::fault::{Fault, fault};
use crate::geometry::AxisSet;
use crate::snc::{Element, Kind};

/// Stops the look-ahead of a Sinumerik.
const STOP_OF_LOOK_AHEAD: &str = "STOPRE";

/// The first item that a control may not look across for the element behind a transition.
fn first_of(items: &[Item]) -> Option<&Element> {
    let is_unknown = |element: &&Element| match &element.kind {
        Kind::Verbatim(_) | Kind::Message(_) | Kind::Lost(_) => true,
        Kind::Keep(word) => *word == STOP_OF_LOOK_AHEAD,
        _ => false,
    };
    items.iter().map(Item::element).find(is_unknown)
}

/// The finding about a transition behind an element, where what follows it before the next one is not known.
pub(super) fn across(first: &Moving, behind: &[Item]) -> Option<Fault> {
    first.wish.corner?;
    let between = first_of(behind)?;
    let (line, origin) = (first.element.origin.line, between.origin);
    let shown = match &between.kind {
        Kind::Verbatim(text) => String::from_utf8_lossy(text).into_owned(),
        Kind::Message(_) => "MSG".to_owned(),
        Kind::Keep(word) => (*word).to_owned(),
        _ => "this block".to_owned(),
    };
    let shown: String = shown.chars().take(40).collect();
    let message = format!(
        "{shown} stands between the elements of the rounding or chamfer of line {line}: whether the control makes that is not known"
    );
    let help = "put it before the first element or behind the second one, or take the transition out";
    Some(fault(Code::CORNER_OVER_UNKNOWN, origin.span, message, help).of_file(origin.file))
}

/// The finding about a program of the control, or whatever else moves axes unseen, under radius compensation.
pub(super) fn under_compensation(element: &Element) -> Option<Fault> {
    let Kind::Lost(axes) = &element.kind else { return None };
    if axes.intersection(AxisSet::XYZ).is_empty() {
        return None;
    }
    let message = "the machine goes to a place that only the control knows, and radius compensation is on, or no motion has led the tool off its contour: on the control it acts there too, in the output it does not";
    let help = "end it with G40 and a motion in the plane before, and begin it again behind";
    Some(fault(Code::BAD_COMPENSATION, element.origin.span, message, help).of_file(element.origin.file))
}
