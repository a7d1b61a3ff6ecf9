//! Test fixture of the stage: takes a few program words, and returns the resulting moves.

use std::sync::Arc as Shared;

use super::{ContourModal, ContourRequest, ContourStage, Item, Moving, Reach, Side};
use crate::exec::core::path::{Path, Shape};
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Plane, PlaneBasis};
use ncfix_base::source::{FileId, Span};
use ncfix_machine::machine::Control;
use ncfix_machine::snc::{Element, FeedUnit, Kind, MotionMode, Move, Origin, Setup};

/// Takes lines of `G0 G1 G2 G3 G40 G41 G42 G43 G44 X Y Z I J F` – positions absolute, I J from the start, with G40 a direction – and `(comments)`.
/// Returns the moves in the notation of a reference, comments, and the codes of diagnostics with their lines.
pub(super) struct Fixture {
    pub(super) control: Control,
    pub(super) modal: ContourModal,
    pub(super) radius_mm: f64,
    pub(super) start: [f64; 3],
}

impl Fixture {
    pub(super) fn new(control: Control, modal: fn(&Control) -> ContourModal, radius_mm: f64) -> Fixture {
        let modal = modal(&control);
        Fixture { control, modal, radius_mm, start: [0.0; 3] }
    }

    pub(super) fn run(&self, text: &str) -> (Vec<String>, Vec<String>) {
        let mut stage = ContourStage::new(&self.control, false);
        let mut modal = self.modal;
        let mut place = position(self.start);
        let (mut motion, mut feed) = (1, 0.0);
        let mut out = Vec::new();
        for (line, text) in text.lines().enumerate() {
            let origin = Origin { line: line as u32 + 1, ..Origin::default() };
            let element = |kind| Element { origin, starts_block: true, number: None, kind };
            let text = text.trim();
            if text.starts_with('(') {
                stage.take(Item::Element(element(Kind::Comment(text.into()))), &mut out);
                continue;
            }
            let (mut target, mut center, mut named) = (place, [None; 2], AxisSet::EMPTY);
            for word in text.split_whitespace() {
                let value: f64 = word[1..].parse().unwrap();
                match (&word[..1], value as i32) {
                    ("G", 0..=3) => motion = value as i32,
                    ("G", 40) => (modal.side, modal.reach) = (Side::Off, Reach::End),
                    ("G", code @ (41 | 42)) => {
                        modal.side = if code == 41 { Side::Left } else { Side::Right };
                        modal.reach = Reach::End;
                        modal.activation += 1;
                    }
                    ("G", 43) => modal.reach = Reach::To,
                    ("G", 44) => modal.reach = Reach::Past,
                    ("I", _) => center[0] = Some(value),
                    ("J", _) => center[1] = Some(value),
                    ("F", _) => feed = value,
                    (letter, _) => {
                        let axis = Axis::from_letter(letter.as_bytes()[0]).unwrap();
                        target[axis] = value;
                        named.insert(axis);
                    }
                }
            }
            let offset = [center[0].unwrap_or(0.0), center[1].unwrap_or(0.0)];
            let has_center = center.iter().any(Option::is_some);
            modal.leaves_along = (has_center && modal.side == Side::Off && motion < 2).then_some(offset);
            if named == AxisSet::EMPTY && !(has_center && motion > 1) {
                continue;
            }
            let shape = match motion {
                0 | 1 => Shape::Line,
                code => Shape::Arc {
                    clockwise: code == 2,
                    center: [place[Axis::X] + offset[0], place[Axis::Y] + offset[1]],
                    extra_turns: 0,
                },
            };
            let basis = PlaneBasis::Principal(Plane::XY);
            let made = Move {
                rapid: motion == 0,
                arc: None,
                target,
                named,
                known: AxisSet::EMPTY,
                feed,
                feed_named: false,
                unit: FeedUnit::PerMinute,
                ways: Default::default(),
                in_machine_frame: false,
                motion_mode: MotionMode::default(),
                off_curve_mm: 0.0,
                tip: None,
                arc_basis: None,
            };
            let path = Path {
                motion: made,
                start: place,
                start_known: AxisSet::EMPTY,
                basis,
                shape,
                setup: Shared::new(Setup::default()),
                span: Span { start: origin.line, end: origin.line },
            };
            let wish = ContourRequest::of(modal, self.radius_mm, path.span, FileId(0));
            place = target;
            let moving = Moving::new(path, element(Kind::Empty), wish);
            if modal.is_plain() && !stage.is_holding() {
                out.push(Item::Path(Box::new(moving)));
            } else {
                stage.take(Item::Path(Box::new(moving)), &mut out);
            }
        }
        stage.finish(&mut out);
        let codes: Vec<String> =
            stage.findings.iter().map(|found| format!("{}:{}", found.code, found.span.start)).collect();
        // Moves of a rejected program may have gaps.
        let moves = if codes.is_empty() { self.shown(out) } else { Vec::new() };
        (moves, codes)
    }

    /// The moves; each begins at the end of the previous one.
    fn shown(&self, items: Vec<Item>) -> Vec<String> {
        let mut place = position(self.start);
        let mut out = Vec::new();
        for item in items {
            let moving = match item {
                Item::Element(Element { kind: Kind::Comment(text), .. }) => {
                    out.push(String::from_utf8(text.to_vec()).unwrap());
                    continue;
                }
                Item::Element(_) => continue,
                Item::Path(moving) => moving,
            };
            let target = moving.path.motion.target;
            assert_eq!(moving.path.start, place, "behind {out:?}");
            let (start, basis) = (moving.path.basis.flat(&place), moving.path.basis);
            let code = match &moving.path.shape {
                Shape::Arc { clockwise: true, .. } => "G2",
                Shape::Arc { .. } => "G3",
                _ if moving.path.motion.rapid => "G0",
                _ => "G1",
            };
            let mut text = code.to_owned();
            for axis in [Axis::X, Axis::Y, Axis::Z] {
                text += &word(axis.letter().into(), target[axis]);
            }
            if let Shape::Arc { center, .. } = moving.path.shape {
                text += &word('I', center[0] - start[0]);
                text += &word('J', center[1] - start[1]);
                let wide = |point: [f64; 2]| (point[0] - center[0]).hypot(point[1] - center[1]);
                assert!((wide(start) - wide(basis.flat(&target))).abs() < 1e-2, "{text} from {start:?}");
            }
            if moving.path.motion.feed > 0.0 {
                text += &word('F', moving.path.motion.feed);
            }
            out.push(text);
            place = target;
        }
        out
    }

    /// Checks the diagnostics of a program.
    #[track_caller]
    pub(super) fn check_codes(&self, text: &str, expected: &[&str]) {
        assert_eq!(self.run(text).1, expected);
    }

    /// Checks the moves of a program without diagnostics; zero words are left out on both sides.
    #[track_caller]
    pub(super) fn check(&self, text: &str, expected: &str) {
        let (moves, codes) = self.run(text);
        let expected: Vec<&str> = expected.lines().map(str::trim).collect();
        assert!(codes.is_empty(), "{codes:?}");
        assert_eq!(moves, expected);
    }
}

fn position([x, y, z]: [f64; 3]) -> AxisVector {
    let mut out = AxisVector::ZERO;
    (out[Axis::X], out[Axis::Y], out[Axis::Z]) = (x, y, z);
    out
}

/// ` X12.5` with four decimals; empty for 0.
fn word(letter: char, value: f64) -> String {
    let rounded = (value * 1e4).round() / 1e4;
    if rounded == 0.0 { String::new() } else { format!(" {letter}{rounded}") }
}
