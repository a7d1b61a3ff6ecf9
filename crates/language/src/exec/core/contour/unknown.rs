//! Missing information of the contour stage: positions that the program has not stated, and elements between contour elements – programs of the
//! control, stops, tool changes, another zero or tool.

use super::contour_request::ContourRequest;
use super::moving::{Item, Moving, plane_axes};
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::path::Path;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, Plane};
use ncfix_machine::snc::{Element, Kind, Origin, Word, WordValue};

/// Stops the look-ahead of a Sinumerik.
const STOP_OF_LOOK_AHEAD: &str = "STOPRE";
/// M functions at which an operator or tool changer may move the axes: stops and the tool change.
const STANDING: [f64; 4] = [0.0, 1.0, 6.0, 60.0];

/// The fault for a motion that the contour stage changes and that depends on an unstated position.
pub(in crate::exec) fn unstated(path: &Path, wish: &ContourRequest, plane: Plane) -> Option<Fault> {
    let needs_start = wish.corner.is_some() || wish.soft.is_some() || wish.modal.depends_on_start();
    let known = if needs_start { path.start_known.intersection(path.motion.known) } else { path.motion.known };
    let axes: AxisSet = plane.axes().into_iter().take(2).collect();
    let shown: Vec<String> = axes.difference(known).iter().map(|axis| axis.to_string()).collect();
    if shown.is_empty() {
        return None;
    }
    let message = format!("the tool center path depends on {}, whose position is not known yet", shown.join(" and "));
    let help = super::super::position::BEGIN_ABSOLUTE;
    Some(fault(Code::UNKNOWN_START, wish.span, message, help))
}

/// A word that stops the axes until an operator continues, or that changes the tool.
fn stands_still(words: &[Word]) -> Option<&Word> {
    let is_standing = |word: &&Word| {
        let is_function = word.letter == b'M' && word.extension.is_none();
        matches!(word.value, WordValue::Number(number) if is_function && STANDING.contains(&number))
    };
    words.iter().find(is_standing)
}

/// The first item across which a control must not look for the element after a transition; preferably one with a name.
fn first_of(items: &[Item]) -> Option<&Element> {
    let is_unknown = |element: &&Element| match &element.kind {
        Kind::Verbatim(_) | Kind::Message(_) => true,
        Kind::Keep(word) => *word == STOP_OF_LOOK_AHEAD,
        Kind::Before(words) | Kind::After(words) => stands_still(words).is_some(),
        _ => false,
    };
    let is_lost = |element: &&Element| matches!(element.kind, Kind::Lost(_));
    let elements = || items.iter().map(Item::element);
    elements().find(is_unknown).or_else(|| elements().find(is_lost))
}

/// The fault for a transition after an element if the items before the next element are unknown.
pub(super) fn across(first: &Moving, behind: &[Item]) -> Option<Fault> {
    first.wish.corner?;
    let between = first_of(behind)?;
    let (line, origin) = (first.element.origin.line, between.origin);
    let shown = match &between.kind {
        Kind::Verbatim(text) => String::from_utf8_lossy(text).into_owned(),
        Kind::Message(_) => "MSG".to_owned(),
        Kind::Keep(word) => (*word).to_owned(),
        Kind::Before(words) | Kind::After(words) => match stands_still(words).map(|word| &word.value) {
            Some(WordValue::Number(number)) => format!("M{number}"),
            _ => "this block".to_owned(),
        },
        _ => "this block".to_owned(),
    };
    let shown: String = shown.chars().take(40).collect();
    let message = format!(
        "{shown} is between the elements of the rounding or chamfer of line {line}: it is not known whether the control makes the transition"
    );
    Some(fault(Code::CORNER_OVER_UNKNOWN, origin.span, message, BEFORE_OR_BEHIND).of_file(origin.file))
}

/// The fault for a transition after an element if a block before the next one reads the main run.
pub(super) fn across_stop(first: &Moving, stop: Option<(Origin, &str)>) -> Option<Fault> {
    let (origin, name) = stop.filter(|_| first.wish.corner.is_some())?;
    let line = first.element.origin.line;
    let message = format!(
        "{name} is read between the elements of the rounding or chamfer of line {line}: the control stops there to read it, as with STOPRE, and it is not known whether it makes the transition"
    );
    Some(fault(Code::CORNER_OVER_UNKNOWN, origin.span, message, BEFORE_OR_BEHIND).of_file(origin.file))
}

/// The fault for a transition whose second element begins at another position than the end of the first one, or in other coordinates.
pub(super) fn between(first: &Moving, second: &Moving) -> Option<Fault> {
    first.wish.corner.filter(|_| second.is_plane_motion())?;
    let (old, new) = (&first.path.setup, &second.path.setup);
    let lost = first.path.motion.known.difference(second.path.start_known);
    let what = if old.tool_mm != new.tool_mm {
        "the tool or its length changes"
    } else if old.frame != new.frame || old.transform != new.transform {
        "zero offset, frame or coordinates change"
    } else if old.plane != new.plane {
        "the working plane changes"
    } else if !lost.intersection(plane_axes(&first.path.basis)).is_empty() {
        "the tool position becomes unknown"
    } else {
        return None;
    };
    let line = first.element.origin.line;
    let message = format!(
        "{what} between the elements of the rounding or chamfer of line {line}; it is not known where the control then makes the transition"
    );
    let origin = second.element.origin;
    Some(fault(Code::CORNER_OVER_UNKNOWN, origin.span, message, BEFORE_OR_BEHIND).of_file(origin.file))
}

const BEFORE_OR_BEHIND: &str = "move it before the first element or after the second one, or remove the transition";

/// The fault for a program that the control itself executes, or other unseen axis motion, under radius compensation.
pub(super) fn under_compensation(element: &Element) -> Option<Fault> {
    let Kind::Lost(axes) = &element.kind else { return None };
    if axes.intersection(AxisSet::XYZ).is_empty() {
        return None;
    }
    let message = "the machine moves to a position known only to the control while radius compensation is on or the tool has not left the contour: the control compensates there, the output does not";
    let help = "end it with G40 and a motion in the plane before, and begin it again afterwards";
    Some(fault(Code::BAD_COMPENSATION, element.origin.span, message, help).of_file(element.origin.file))
}
