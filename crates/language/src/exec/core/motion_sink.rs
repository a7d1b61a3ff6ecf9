//! The output side of every executor: converts elements and paths of blocks into the flat stream.
//!
//! A path passes the contour stage if that may still change it, is resolved into axis moves, and is queued with the surrounding elements in program
//! order.

use std::collections::VecDeque;

use super::contour::{ContourRequest, ContourStage, Item, Moving, unstated};
use super::fault::{Fault, fault};
use super::options::Options;
use super::path::{Path, Shape};
use ncfix_base::diagnostic::{Code, Severity};
use ncfix_base::geometry::{AxisSet, AxisVector, Plane};
use ncfix_base::source::{FileId, Span};
use ncfix_machine::machine::{Kinematics, Machine};
use ncfix_machine::snc::{BlockNumber, Element, Kind, Origin};

/// Maximum number of blocks that are listed at the end of a correction as starts of radius compensation.
const MOST_NOTED: usize = 20;

/// Maximum number of tool registers that are listed there.
const MOST_REGISTERS: usize = 1000;

/// Types that have a motion sink.
pub(in crate::exec) trait HasOutlet<'a> {
    /// The motion sink.
    fn outlet(&mut self) -> &mut MotionSink<'a>;
}

/// The motion sink of an executor: it receives paths and elements, and queues the resulting moves.
pub(in crate::exec) struct MotionSink<'a> {
    pub(in crate::exec) machine: &'a Machine,
    /// Kinematics of the machine, once a transformation was active.
    pub(in crate::exec) kinematics: Option<Box<Kinematics>>,
    /// Final elements.
    pub(in crate::exec) queue: VecDeque<Element>,
    /// Faults of the block that do not stop it.
    pub(in crate::exec) warnings: Vec<Fault>,
    /// The current block.
    pub(in crate::exec) origin: Origin,
    contour: ContourStage,
    released: Vec<Item>,
    number: Option<BlockNumber>,
    starts_block: bool,
    /// Blocks in which radius compensation began, and `true` while it is active.
    compensated: Vec<Origin>,
    compensates: bool,
    /// Registers of the control with their radius.
    registers: Vec<String>,
    /// Registers with the radius 0 with which compensation began, and the block.
    without_radius: Vec<(String, Origin)>,
    /// `true` if the control handles the wear, and receives the words that begin and end compensation.
    pub(in crate::exec) keeps_wear: bool,
    tells_compensation: bool,
    hides_marks: bool,
    names_cycles: bool,
    /// `true` if curves become arcs where these fit.
    pub(in crate::exec) fits_arcs: bool,
    /// Milling cycles with moves of this program, and their blocks.
    milled: Vec<(&'static str, Origin)>,
}

impl<'a> MotionSink<'a> {
    pub(in crate::exec) fn new(machine: &'a Machine, options: &Options) -> MotionSink<'a> {
        MotionSink {
            machine,
            kinematics: None,
            queue: VecDeque::with_capacity(16),
            warnings: Vec::new(),
            origin: Origin::default(),
            contour: ContourStage::new(&machine.control, options.keeps_wear),
            released: Vec::new(),
            number: None,
            starts_block: false,
            compensated: Vec::new(),
            compensates: false,
            registers: Vec::new(),
            without_radius: Vec::new(),
            keeps_wear: options.keeps_wear,
            tells_compensation: options.tells_compensation,
            hides_marks: options.hides_marks,
            names_cycles: options.names_cycles,
            fits_arcs: options.fits_arcs,
            milled: Vec::new(),
        }
    }

    /// Begins a block: its elements carry this origin and number.
    pub(in crate::exec) fn begin_block(&mut self, origin: Origin, number: Option<BlockNumber>) {
        self.origin = origin;
        self.number = number;
        self.starts_block = true;
    }

    /// Begins a new output line for the same block; the first line has the number of the block.
    pub(in crate::exec) fn begin_line(&mut self) {
        if !self.starts_block {
            self.number = None;
        }
        self.starts_block = true;
    }

    /// The file of the block.
    pub(in crate::exec) fn file(&self) -> FileId {
        self.origin.file
    }

    /// Creates an element of the block; the first one has the block's number.
    pub(in crate::exec) fn element(&mut self, kind: Kind) -> Element {
        let starts_block = std::mem::take(&mut self.starts_block);
        let number = if starts_block { self.number } else { None };
        Element { origin: self.origin, starts_block, number, kind }
    }

    /// `true` if an M function moves axes according to the machine file (`control.opaque`, `[[opaque]]`).
    pub(in crate::exec) fn function_moves(&self, number: f64) -> bool {
        let control = &self.machine.control;
        !control.opaque.is_empty() && control.opaque_moves(&format!("M{number}")) == Some(true)
    }

    /// Emits an element without motion.
    pub(in crate::exec) fn push(&mut self, kind: Kind) {
        let kind = match kind {
            Kind::Comment(text) if self.hides_marks => Kind::Comment(without_mark(text)),
            kind => kind,
        };
        let element = self.element(kind);
        self.pass(element);
    }

    /// Emits an element with its own line.
    pub(in crate::exec) fn push_line(&mut self, kind: Kind) {
        self.pass(Element { origin: self.origin, starts_block: true, number: None, kind });
    }

    /// Restores the programmed feed before the call of a program that the control itself executes, independent of corner, arc and block feeds.
    pub(in crate::exec) fn feed_for_call(&mut self, feed: f64) {
        if feed > 0.0 {
            let kind = Kind::Feed(feed);
            self.pass(Element { origin: self.origin, starts_block: true, number: None, kind });
        }
    }

    /// Records a milling cycle: the tool path is calculated by ncfix, because that of the control is not published. The output has a comment in
    /// front of its moves.
    pub(in crate::exec) fn mill(&mut self, name: &'static str, comment: impl FnOnce(String) -> String) {
        let origin = self.origin;
        let is_known =
            self.milled.iter().any(|(known, at)| *known == name && at.line == origin.line && at.file == origin.file);
        if !is_known && self.milled.len() < MOST_NOTED {
            self.milled.push((name, origin));
        }
        if self.names_cycles {
            let text = comment(format!("{name} of line {}: passes by ncfix", origin.line)).into_bytes();
            self.push_line(Kind::Comment(text));
        }
    }

    /// Emits an element without motion.
    pub(in crate::exec) fn pass(&mut self, element: Element) {
        if !self.contour.is_holding() {
            self.queue.push_back(element);
            return;
        }
        self.through_contour(Item::Element(element));
    }

    /// Records that the block reads current axis data, which makes the control stop its look-ahead here.
    pub(in crate::exec) fn stop_look_ahead(&mut self, name: &'static str) {
        self.contour.stop(self.origin, name);
    }

    /// `true` if motions are held back, so that following elements must wait.
    pub(in crate::exec) fn is_holding(&self) -> bool {
        self.contour.is_holding()
    }

    /// Emits a motion that requests nothing from the contour stage while the stage holds nothing.
    #[inline]
    pub(in crate::exec) fn pass_plain(&mut self, path: &Path) {
        if matches!(path.shape, Shape::Line) && path.setup.transform.is_none() {
            let element = self.element(Kind::Move(path.motion));
            self.queue.push_back(element);
            return;
        }
        let element = self.element(Kind::Empty);
        self.resolve(path, element);
    }

    /// Emits a motion through the contour stage. The kind of the element is a placeholder.
    pub(in crate::exec) fn pass_path(&mut self, path: Path, element: Element, wish: ContourRequest) {
        self.note_compensation(&element, &wish);
        self.through_contour(Item::Path(Box::new(Moving::new(path, element, wish))));
    }

    /// Reports a motion that the contour stage changes and that depends on a position that the program has not stated.
    pub(in crate::exec) fn check_stated(&mut self, path: &Path, wish: &ContourRequest, plane: Plane) {
        if !self.contour.ends_by_loss(path, wish) {
            self.warnings.extend(unstated(path, wish, plane));
        }
    }

    /// Holds a motion back until [`Self::close`] gives its end.
    pub(in crate::exec) fn open(&mut self, path: Path, element: Element, wish: ContourRequest) {
        self.note_compensation(&element, &wish);
        self.contour.open(Box::new(Moving::new(path, element, wish)));
    }

    /// Sets the end of the motion of [`Self::open`]; `None` if it has none.
    pub(in crate::exec) fn close(&mut self, end: Option<AxisVector>, axes: AxisSet) {
        let mut released = std::mem::take(&mut self.released);
        self.contour.close(end, axes, &mut released);
        self.release(released);
    }

    /// Refuses a block that gives a register of the control a radius: the output keeps the block, and the control would offset the tool center path by it.
    pub(in crate::exec) fn check_radius(&self, register: &str, radius_mm: f64, span: Span) -> Result<(), Fault> {
        if !self.keeps_wear || radius_mm == 0.0 {
            return Ok(());
        }
        let message = format!(
            "the program sets the radius of {register} to {radius_mm} mm: with --compensation wear the control would apply the radius twice"
        );
        Err(fault(
            Code::NO_WEAR,
            span,
            message,
            "remove this statement from the program, give the radius in the machine file or with --setup, and enter 0 at the control; or leave out --compensation wear",
        ))
    }

    fn note_compensation(&mut self, element: &Element, wish: &ContourRequest) {
        let compensates = wish.is_beside();
        if compensates && !self.compensates && self.compensated.len() < MOST_NOTED {
            let is_new = !self.compensated.iter().any(|origin| origin.span == element.origin.span);
            self.compensated.extend(Some(element.origin).filter(|_| is_new));
        }
        self.compensates = compensates;
    }

    /// Emits what is held back at the end of the program. A correction reports what it has converted: radius compensation and milling cycles.
    pub(in crate::exec) fn end(&mut self, has_errors: bool) {
        self.finish();
        // Output that is not written needs no advice.
        let is_written = !has_errors && !self.warnings.iter().any(|found| found.code.severity() == Severity::Error);
        if self.tells_compensation && is_written {
            let found = [self.compensation_note(), self.radius_note(), self.milling_note()];
            self.warnings.extend(found.into_iter().flatten());
        }
    }

    fn compensation_note(&self) -> Option<Fault> {
        let first = self.compensated.first()?;
        let lines = lines_of(&self.compensated);
        let (code, message, help) = if self.keeps_wear {
            let message = format!(
                "radius compensation at the control is for wear alone ({lines}): the radius of {} must be 0 there, plus wear",
                self.registers.join(", ")
            );
            let help = "before the program runs, set the radius of these registers to 0 at the control and enter only the wear: a tool radius there acts twice; the lengths stay";
            (Code::WEAR_ALONE, message, help)
        } else {
            let message = format!(
                "radius compensation is replaced by the tool center path ({lines}): a radius or wear entered at the control no longer has any effect"
            );
            let help = "when radius or wear changes, write it into [[tool]] of the machine file or the file of --setup, and correct the program again; or correct it with --compensation wear, and wear at the control keeps its effect";
            (Code::WEAR_WITHOUT_EFFECT, message, help)
        };
        Some(fault(code, first.span, message, help).of_file(first.file))
    }

    /// A radius of 0 is right for a program that already has the path of the tool center, and cuts into the part where the radius is only missing.
    fn radius_note(&self) -> Option<Fault> {
        let (_, first) = self.without_radius.first()?;
        let names: Vec<&str> = self.without_radius.iter().map(|(name, _)| name.as_str()).collect();
        let origins: Vec<Origin> = self.without_radius.iter().map(|(_, origin)| *origin).collect();
        let message = format!(
            "radius compensation with radius 0 ({} in {}): the tool center moves on the programmed contour",
            names.join(", "),
            lines_of(&origins)
        );
        let help = "state radius_mm of the tool in [[tool]], or give --setup a file of the control that has the radius; if the program already has the path of the tool center, 0 is right";
        Some(fault(Code::RADIUS_ZERO, first.span, message, help).of_file(first.file))
    }

    fn milling_note(&self) -> Option<Fault> {
        let (_, first) = self.milled.first()?;
        let mut names: Vec<&str> = self.milled.iter().map(|(name, _)| *name).collect();
        names.sort_unstable();
        names.dedup();
        let listed = names.iter().map(|name| {
            let origins = self.milled.iter().filter(|(known, _)| known == name).map(|(_, origin)| *origin);
            format!("{name} ({})", lines_of(&origins.collect::<Vec<_>>()))
        });
        let listed: Vec<String> = listed.collect();
        let message = format!("passes and plunges are those of ncfix, not of the control: {}", listed.join(", "));
        let help = "check them like those of a new program; or give ncfix the cycles of the control as files (control.search_path), or leave the cycle uncorrected (control.opaque)";
        Some(fault(Code::OWN_STROKES, first.span, message, help).of_file(first.file))
    }

    /// Records the control's radius register before a motion that begins radius compensation, if the control handles the wear or the radius is 0.
    pub(in crate::exec) fn name_register(&mut self, wish: &ContourRequest, name: impl FnOnce() -> String) {
        let is_zero = wish.distance_mm == 0.0;
        if !wish.compensates() || self.compensates || !(self.keeps_wear || is_zero) {
            return;
        }
        let name = name();
        if self.keeps_wear {
            if self.registers.len() < MOST_REGISTERS && !self.registers.contains(&name) {
                self.registers.push(name);
            }
        } else if self.without_radius.len() < MOST_REGISTERS
            && self.without_radius.iter().all(|(known, _)| *known != name)
        {
            self.without_radius.push((name, self.origin));
        }
    }

    /// Emits what is held back.
    pub(in crate::exec) fn finish(&mut self) {
        let mut released = std::mem::take(&mut self.released);
        self.contour.finish(&mut released);
        self.release(released);
    }

    /// Handles a read of the axis positions by the control. If radius compensation by the rules of RS274/NGC has ended and no motion has led back to
    /// the contour, this is the tool center. From here on it is the programmed position.
    pub(in crate::exec) fn settle(&mut self) -> Option<AxisVector> {
        let mut released = std::mem::take(&mut self.released);
        let place = self.contour.settle(&mut released);
        self.release(released);
        place
    }

    /// Passes an item through the stage and emits the final ones.
    fn through_contour(&mut self, item: Item) {
        let mut released = std::mem::take(&mut self.released);
        self.contour.take(item, &mut released);
        self.release(released);
    }

    /// Resolves a motion, with the words that begin or end compensation at the control.
    fn moved(&mut self, moving: Box<Moving>) {
        let Some(words) = moving.switch_words() else {
            self.resolve(&moving.path, moving.element);
            return;
        };
        let (before, mut switching, behind) = moving.parted();
        let is_further = before.is_some();
        if let Some(before) = before {
            self.resolve(&before.path, before.element);
        }
        let element = &mut switching.element;
        let kind = Kind::Verbatim(words.into_bytes());
        self.queue.push_back(Element { kind, ..element.clone() });
        (element.starts_block, element.number) = (false, None);
        if is_further {
            self.queue.push_back(Element { kind: further_line(), ..element.clone() });
        }
        self.resolve(&switching.path, switching.element);
        if let Some(behind) = behind {
            self.queue.push_back(Element { kind: further_line(), starts_block: true, ..behind.element.clone() });
            self.resolve(&behind.path, behind.element);
        }
    }

    fn release(&mut self, mut released: Vec<Item>) {
        for item in released.drain(..) {
            match item {
                Item::Element(element) => self.queue.push_back(element),
                Item::Path(moving) => self.moved(moving),
            }
        }
        self.released = released;
        self.warnings.append(&mut self.contour.findings);
    }
}

/// Texts of comments that mark added lines.
const MARKS: [&[u8]; 3] = [b"+", b"~", b"+~"];

/// A comment of the program that is not a mark of an added line.
fn without_mark(mut text: Vec<u8>) -> Vec<u8> {
    let whole = text.trim_ascii();
    let (inner, is_closed) = match whole.strip_prefix(b"(") {
        Some(inner) => (inner.strip_suffix(b")").unwrap_or(inner), true),
        None => (whole.strip_prefix(b";").unwrap_or(whole), false),
    };
    if MARKS.contains(&inner.trim_ascii()) {
        let mut plain = if is_closed { b"(".to_vec() } else { b";".to_vec() };
        plain.extend_from_slice(inner.trim_ascii());
        plain.extend_from_slice(if is_closed { b" .)" } else { b" ." });
        text = plain;
    }
    text
}

/// `line 6` or `lines 6, 9`.
fn lines_of(origins: &[Origin]) -> String {
    let lines: Vec<String> = origins.iter().map(|origin| origin.line.to_string()).collect();
    format!("line{} {}", if lines.len() == 1 { "" } else { "s" }, lines.join(", "))
}

/// The comment of lines that continue the motion of the previous line.
fn further_line() -> Kind {
    Kind::Comment(b";+".to_vec())
}

#[cfg(test)]
mod tests {
    use super::without_mark;

    #[test]
    fn a_comment_of_the_program_is_no_mark() {
        for (text, plain) in
            [(";+", ";+ ."), ("; ~", ";~ ."), ("(+)", "(+ .)"), ("(+~)", "(+~ .)"), ("; + 5", "; + 5"), ("(A)", "(A)")]
        {
            assert_eq!(without_mark(text.as_bytes().to_vec()), plain.as_bytes());
        }
    }
}
