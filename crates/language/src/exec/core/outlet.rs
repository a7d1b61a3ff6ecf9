//! The lower half of every executor: takes elements and paths of blocks and puts the flat stream together.
//!
//! A path goes through the contour stage where something may still change it, is resolved to moves of the axes, and queues up with the
//! elements around it in the order of the program.

use std::collections::VecDeque;

use super::contour::{ContourStage, Item, Moving, Wish};
use super::fault::{Fault, fault};
use super::options::Options;
use super::path::{Path, Shape};
use ncfix_base::diagnostic::{Code, Severity};
use ncfix_base::geometry::{AxisSet, AxisVector};
use ncfix_base::source::FileId;
use ncfix_machine::machine::{Kinematics, Machine};
use ncfix_machine::snc::{BlockNumber, Element, Kind, Origin};

/// Blocks that begin radius compensation and are named at the end of a correction, at most.
const MOST_NOTED: usize = 20;

/// Registers of tools that are named there, at most.
const MOST_REGISTERS: usize = 1000;

/// Who has an outlet.
pub(in crate::exec) trait HasOutlet<'a> {
    /// Where it puts what its blocks do.
    fn outlet(&mut self) -> &mut Outlet<'a>;
}

/// Where an executor puts what its blocks do.
pub(in crate::exec) struct Outlet<'a> {
    pub(in crate::exec) machine: &'a Machine,
    /// Of the machine, once a transformation was in force.
    pub(in crate::exec) kinematics: Option<Box<Kinematics>>,
    /// What is final.
    pub(in crate::exec) queue: VecDeque<Element>,
    /// Findings of the block that do not stop it.
    pub(in crate::exec) warnings: Vec<Fault>,
    /// The block that is being executed.
    pub(in crate::exec) origin: Origin,
    contour: ContourStage,
    released: Vec<Item>,
    number: Option<BlockNumber>,
    starts_block: bool,
    /// Blocks in which radius compensation began, and whether it is on.
    compensated: Vec<Origin>,
    compensates: bool,
    /// Registers of the control whose radius these have.
    registers: Vec<String>,
    /// The control has the wear, and the words that begin and end compensation.
    pub(in crate::exec) keeps_wear: bool,
    tells_compensation: bool,
}

impl<'a> Outlet<'a> {
    pub(in crate::exec) fn new(machine: &'a Machine, options: &Options) -> Outlet<'a> {
        Outlet {
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
            keeps_wear: options.keeps_wear,
            tells_compensation: options.tells_compensation,
        }
    }

    /// A new block: its elements carry this origin and number.
    pub(in crate::exec) fn begin_block(&mut self, origin: Origin, number: Option<BlockNumber>) {
        self.origin = origin;
        self.number = number;
        self.starts_block = true;
    }

    /// A new line of the output for the same block; the first has the number of the block.
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

    /// An element of the block, the first of them with its number.
    pub(in crate::exec) fn element(&mut self, kind: Kind) -> Element {
        let starts_block = std::mem::take(&mut self.starts_block);
        let number = if starts_block { self.number } else { None };
        Element { origin: self.origin, starts_block, number, kind }
    }

    /// Whether an M function moves axes by what the machine file says (`control.opaque`, `[[opaque]]`).
    pub(in crate::exec) fn function_moves(&self, number: f64) -> bool {
        let control = &self.machine.control;
        !control.opaque.is_empty() && control.opaque_moves(&format!("M{number}")) == Some(true)
    }

    /// Puts something without motion into the stream.
    pub(in crate::exec) fn push(&mut self, kind: Kind) {
        let element = self.element(kind);
        self.pass(element);
    }

    /// Before the call of a program of the control: it finds the feed of the program, whatever a corner, an arc or one block had.
    pub(in crate::exec) fn feed_for_call(&mut self, feed: f64) {
        if feed > 0.0 {
            let kind = Kind::Feed(feed);
            self.pass(Element { origin: self.origin, starts_block: true, number: None, kind });
        }
    }

    /// Puts an element without motion into the stream.
    pub(in crate::exec) fn pass(&mut self, element: Element) {
        if !self.contour.is_holding() {
            self.queue.push_back(element);
            return;
        }
        self.through_contour(Item::Element(element));
    }

    /// The block reads what the control knows only when it has got there: it looks no further ahead.
    pub(in crate::exec) fn stop_look_ahead(&mut self, name: &'static str) {
        self.contour.stop(self.origin, name);
    }

    /// Whether motions are held back, so that whatever comes must wait behind them.
    pub(in crate::exec) fn is_holding(&self) -> bool {
        self.contour.is_holding()
    }

    /// Puts a motion of the block into the stream that wants nothing of the contour stage, while that holds nothing back.
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

    /// Puts a motion into the stream through the contour stage. The kind of the element is a placeholder.
    pub(in crate::exec) fn pass_path(&mut self, path: Path, element: Element, wish: Wish) {
        self.note_compensation(&element, &wish);
        self.through_contour(Item::Path(Box::new(Moving::new(path, element, wish))));
    }

    /// Holds a motion back until [`Self::close`] says where it ends.
    pub(in crate::exec) fn open(&mut self, path: Path, element: Element, wish: Wish) {
        self.note_compensation(&element, &wish);
        self.contour.open(Box::new(Moving::new(path, element, wish)));
    }

    /// The end of the motion of [`Self::open`], or that it has none.
    pub(in crate::exec) fn close(&mut self, end: Option<AxisVector>, axes: AxisSet) {
        let mut released = std::mem::take(&mut self.released);
        self.contour.close(end, axes, &mut released);
        self.release(released);
    }

    fn note_compensation(&mut self, element: &Element, wish: &Wish) {
        let compensates = wish.is_beside();
        if compensates && !self.compensates && self.compensated.len() < MOST_NOTED {
            let is_new = !self.compensated.iter().any(|origin| origin.span == element.origin.span);
            self.compensated.extend(Some(element.origin).filter(|_| is_new));
        }
        self.compensates = compensates;
    }

    /// The program has ended: ends what is held back. A correction says where it has worked radius compensation out.
    pub(in crate::exec) fn end(&mut self, has_errors: bool) {
        self.finish();
        // What is not written needs no advice.
        let is_written = !has_errors && !self.warnings.iter().any(|found| found.code.severity() == Severity::Error);
        let tells = self.tells_compensation && is_written;
        let Some(first) = self.compensated.first().filter(|_| tells) else { return };
        let lines: Vec<String> = self.compensated.iter().map(|origin| origin.line.to_string()).collect();
        let lines = format!("line{} {}", if lines.len() == 1 { "" } else { "s" }, lines.join(", "));
        let (code, message, help) = if self.keeps_wear {
            let message = format!(
                "radius compensation at the control is for wear alone ({lines}): the radius of {} must be 0 there, plus wear",
                self.registers.join(", ")
            );
            let help = "a control that has the radius of the tool there moves the tool away by it a second time; where it has the lengths of the tool too, they stay";
            (Code::WEAR_ALONE, message, help)
        } else {
            let message = format!(
                "radius compensation becomes the way of the tool center ({lines}): another radius and wear that are entered at the control have no effect any more"
            );
            let help = "after a change put radius and wear into [[tool]] of the machine file, or give --setup the tool table, and correct the program again; or correct it with ncfix fix --compensation wear";
            (Code::WEAR_WITHOUT_EFFECT, message, help)
        };
        self.warnings.push(fault(code, first.span, message, help).of_file(first.file));
    }

    /// Before a motion that begins radius compensation: where the control has the radius.
    pub(in crate::exec) fn name_register(&mut self, wish: &Wish, name: impl FnOnce() -> String) {
        if !self.keeps_wear || !wish.compensates() || self.compensates {
            return;
        }
        let name = name();
        if self.registers.len() < MOST_REGISTERS && !self.registers.contains(&name) {
            self.registers.push(name);
        }
    }

    /// Ends what is held back.
    pub(in crate::exec) fn finish(&mut self) {
        let mut released = std::mem::take(&mut self.released);
        self.contour.finish(&mut released);
        self.release(released);
    }

    /// The control looks where the axes are: where the tool center is if radius compensation by the rules of RS274/NGC has ended and nothing
    /// has led back to the contour yet. From here on it is where the program is.
    pub(in crate::exec) fn settle(&mut self) -> Option<AxisVector> {
        let mut released = std::mem::take(&mut self.released);
        let place = self.contour.settle(&mut released);
        self.release(released);
        place
    }

    /// Puts an item into the stage and takes out what is final.
    fn through_contour(&mut self, item: Item) {
        let mut released = std::mem::take(&mut self.released);
        self.contour.take(item, &mut released);
        self.release(released);
    }

    /// Resolves a motion; where it begins or ends compensation at the control, with the words for that.
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

/// The comment of lines that carry on with the motion of the line before, as the output has it.
fn further_line() -> Kind {
    Kind::Comment(b";+".to_vec())
}
