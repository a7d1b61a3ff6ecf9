//! Two rings in shared memory: set-points from a control in another process, and corrections back. One writer and one reader each, without a lock.
//!
//! All data are words of 8 bytes, little endian. Layout of version 1, `n` axes, `c` records (a power of two), `w` words in each (a multiple of 8):
//!
//! ```text
//! word      byte    written by  what
//! 0         0       ncfix       magic: the bytes "NCFIXRT1", written last
//! 1         8       ncfix       version, 1
//! 2         16      ncfix       n
//! 3, 4      24      ncfix       letters of the axes in ASCII, 0 after the last
//! 5         40      ncfix       c
//! 6         48      ncfix       w
//! 16        128     control     set-points written
//! 32        256     ncfix       set-points read
//! 48        384     ncfix       corrections written
//! 64        512     control     corrections read
//! 80        640     ncfix       heartbeat: cycles of waiting
//! 96        768     control     not 0: requests the end of ncfix
//! 104       832     control     tool vector of an order, x, y, z (f64; mm, from the gauge point to the tip along the axes of F)
//! 107       856     control     number of the head of an order, as ncfix prints it
//! 128       1024    control     c records of set-points: number, n values (f64; mm, rad), order before this set-point (0 for none)
//! 128 + cw          ncfix       c records of corrections: number of the set-point, signals, n values (f64; mm, rad)
//! ```
//!
//! A writer fills the record `count mod c`, then increments its count (release). A reader reads the count (acquire), copies the record and then
//! increments its own count. Orders: 1, an axis was referenced, so the control has dropped all corrections; 2, the tool of word 104 is in the spindle; 3,
//! the head of word 107 is active, with the tool of word 104. ncfix answers a set-point with order 2 or 3 when the corrections are ready, which takes longer
//! than a cycle: the axes must stand. Any other order ends the run: the control means something that ncfix does not know. A ring is full when both counts are c apart. Every set-point gets one correction, in order.

use std::fs::File;
use std::io;
use std::sync::atomic::{AtomicU64, Ordering};

use memmap2::{MmapOptions, MmapRaw};

use super::cycle::{Answer, Cycle, Signals};
use ncfix_base::geometry::{AXIS_COUNT, Axis, AxisSet, AxisVector};

/// The first word.
const MAGIC: u64 = u64::from_le_bytes(*b"NCFIXRT1");
const VERSION: u64 = 1;
/// Word indices of the header described above.
const AXES: usize = 2;
const LETTERS: usize = 3;
const CAPACITY: usize = 5;
const STRIDE: usize = 6;
const SET_POINTS_WRITTEN: usize = 16;
const SET_POINTS_READ: usize = 32;
const CORRECTIONS_WRITTEN: usize = 48;
const CORRECTIONS_READ: usize = 64;
const ALIVE: usize = 80;
const STOP: usize = 96;
const TOOL: usize = 104;
const HEAD: usize = 107;
/// Orders of a set-point.
const ORDER_NONE: u64 = 0;
const ORDER_RESET: u64 = 1;
const ORDER_TOOL: u64 = 2;
const ORDER_HEAD: u64 = 3;
const RECORDS: usize = 128;
/// Maximum number of records of a ring.
const MOST_RECORDS: u64 = 1 << 20;

/// The words of a file that other processes may have mapped too.
#[derive(Debug)]
struct Words {
    map: MmapRaw,
}

impl Words {
    fn new(file: &File) -> io::Result<Words> {
        Ok(Words { map: MmapOptions::new().map_raw(file)? })
    }

    /// All words. Every access is atomic, so that a concurrent write by another process is not undefined behavior.
    #[allow(unsafe_code, reason = "memory that another process shares has no other type; this is the one place")]
    fn all(&self) -> &[AtomicU64] {
        let count = self.map.len() / size_of::<AtomicU64>();
        // SAFETY: a map begins at a page and is therefore aligned for words of 8 bytes; `count` of them are within it. It stays mapped, readable and
        // writable, as long as `self`. Any bits are a valid AtomicU64, and no other reference to it is created here.
        unsafe { std::slice::from_raw_parts(self.map.as_mut_ptr().cast::<AtomicU64>(), count) }
    }

    fn get(&self, word: usize, order: Ordering) -> u64 {
        self.all().get(word).map_or(0, |cell| u64::from_le(cell.load(order)))
    }

    fn set(&self, word: usize, value: u64, order: Ordering) {
        if let Some(cell) = self.all().get(word) {
            cell.store(value.to_le(), order);
        }
    }

    fn number(&self, word: usize) -> f64 {
        f64::from_bits(self.get(word, Ordering::Relaxed))
    }
}

/// The layout as known to both sides.
#[derive(Clone, Copy, Debug)]
struct Shape {
    axes: [Axis; AXIS_COUNT],
    count: usize,
    capacity: u64,
    stride: usize,
}

impl Shape {
    fn new(set: AxisSet, capacity: u64) -> Shape {
        let mut axes = [Axis::X; AXIS_COUNT];
        let count = set.iter().zip(&mut axes).map(|(axis, place)| *place = axis).count();
        Shape { axes, count, capacity, stride: (2 + count).next_multiple_of(8) }
    }

    fn axes(&self) -> &[Axis] {
        &self.axes[..self.count]
    }

    fn words(&self) -> usize {
        RECORDS + 2 * self.capacity as usize * self.stride
    }

    fn set_point(&self, number: u64) -> usize {
        RECORDS + (number % self.capacity) as usize * self.stride
    }

    /// The order of a set-point. Its record has room for it, because a correction has one word more.
    fn order(&self, number: u64) -> usize {
        self.set_point(number) + 1 + self.count
    }

    fn correction(&self, number: u64) -> usize {
        self.set_point(number) + self.capacity as usize * self.stride
    }
}

/// Inconsistent counts: more than a ring apart, or decreased.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overrun {
    /// This number of set-points were written and not read.
    SetPoints(u64),
    /// The count of written set-points is lower than that of read ones by this number: it has decreased.
    WentBack(u64),
    /// This number of corrections were read without being available.
    CorrectionsRead(u64),
    /// The count of read corrections has decreased: this many corrections seem to be written and not read.
    Corrections(u64),
}

impl Overrun {
    /// Determines the inconsistency from the number of waiting set-points or, if that is consistent, of unread corrections.
    #[cold]
    fn of(waiting: u64, open: u64, capacity: u64) -> Overrun {
        // A negative difference wraps into the upper half.
        let is_below = |difference: u64| difference > u64::MAX / 2;
        match waiting > capacity {
            true if is_below(waiting) => Overrun::WentBack(waiting.wrapping_neg()),
            true => Overrun::SetPoints(waiting),
            false if is_below(open) => Overrun::CorrectionsRead(open.wrapping_neg()),
            false => Overrun::Corrections(open),
        }
    }
}

/// Order of a set-point that takes longer than a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RingOrder {
    /// Another tool is in the spindle, with this vector, mm.
    Tool([f64; 3]),
    /// The head with this number is active, with a tool of this vector, mm.
    Head(u64, [f64; 3]),
    /// A number that is no order.
    Unknown(u64),
}

/// The server side: creates the rings and answers.
#[derive(Debug)]
pub struct Ring {
    words: Words,
    shape: Shape,
    /// Number of set-points that were read when an order was taken, plus one; 0 before the first.
    taken: AtomicU64,
}

/// The side of the control.
#[derive(Debug)]
pub struct Client {
    words: Words,
    shape: Shape,
}

impl Ring {
    /// Creates the rings in an empty file that is open for reading and writing, with `capacity` records, a power of two.
    ///
    /// # Errors
    /// An I/O error if the file cannot be extended or mapped, or the capacity is invalid.
    pub fn create(file: &File, axes: AxisSet, capacity: u64) -> io::Result<Ring> {
        if !capacity.is_power_of_two() || capacity > MOST_RECORDS {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                "the number of records is not a power of two up to 1048576",
            ));
        }
        let shape = Shape::new(axes, capacity);
        file.set_len((shape.words() * size_of::<u64>()) as u64)?;
        let words = Words::new(file)?;
        let mut letters = [0; 16];
        letters.iter_mut().zip(shape.axes()).for_each(|(letter, axis)| *letter = axis.letter());
        let [low, high] = [0, 8].map(|start| letters[start..start + 8].try_into().map_or(0, u64::from_le_bytes));
        let head = [
            (1, VERSION),
            (AXES, shape.count as u64),
            (LETTERS, low),
            (LETTERS + 1, high),
            (CAPACITY, capacity),
            (STRIDE, shape.stride as u64),
        ];
        head.into_iter().for_each(|(word, value)| words.set(word, value, Ordering::Relaxed));
        words.set(0, MAGIC, Ordering::Release);
        Ok(Ring { words, shape, taken: AtomicU64::new(0) })
    }

    /// Answers one set-point and returns the status bits of the answer; `None` if there is none, no room for the answer, or an order to carry
    /// out before ([`Ring::order`]). Does not allocate or wait.
    ///
    /// # Errors
    /// [`Overrun`]: some set-points were overwritten before they were answered, so answers would not match their set-points.
    pub fn serve(&self, cycle: &mut Cycle) -> Result<Option<Signals>, Overrun> {
        let read = self.words.get(SET_POINTS_READ, Ordering::Relaxed);
        let written = self.words.get(CORRECTIONS_WRITTEN, Ordering::Relaxed);
        let waiting = self.words.get(SET_POINTS_WRITTEN, Ordering::Acquire).wrapping_sub(read);
        let open = written.wrapping_sub(self.words.get(CORRECTIONS_READ, Ordering::Acquire));
        if waiting > self.shape.capacity || open > self.shape.capacity {
            return Err(Overrun::of(waiting, open, self.shape.capacity));
        }
        if waiting == 0 || open == self.shape.capacity {
            return Ok(None);
        }
        let from = self.shape.set_point(read);
        match self.words.get(self.shape.order(read), Ordering::Relaxed) {
            ORDER_NONE => {}
            ORDER_RESET => cycle.reset(),
            _ if self.taken.load(Ordering::Relaxed) != read.wrapping_add(1) => return Ok(None),
            _ => {}
        }
        let number = self.words.get(from, Ordering::Relaxed);
        let mut set_point = AxisVector::ZERO;
        for (index, &axis) in self.shape.axes().iter().enumerate() {
            set_point[axis] = self.words.number(from + 1 + index);
        }
        self.words.set(SET_POINTS_READ, read.wrapping_add(1), Ordering::Release);
        let answer = cycle.step(&set_point);
        let to = self.shape.correction(written);
        self.words.set(to, number, Ordering::Relaxed);
        self.words.set(to + 1, answer.signals.0, Ordering::Relaxed);
        for (index, &axis) in self.shape.axes().iter().enumerate() {
            self.words.set(to + 2 + index, answer.correction[axis].to_bits(), Ordering::Relaxed);
        }
        self.words.set(CORRECTIONS_WRITTEN, written.wrapping_add(1), Ordering::Release);
        Ok(Some(answer.signals))
    }

    /// Returns the order that must be carried out before the next set-point is answered, once; `None` without one.
    #[must_use]
    pub fn order(&self) -> Option<RingOrder> {
        let read = self.words.get(SET_POINTS_READ, Ordering::Relaxed);
        if self.words.get(SET_POINTS_WRITTEN, Ordering::Acquire) == read {
            return None;
        }
        let tool_mm = || [0, 1, 2].map(|k| self.words.number(TOOL + k));
        let order = match self.words.get(self.shape.order(read), Ordering::Relaxed) {
            ORDER_NONE | ORDER_RESET => return None,
            ORDER_TOOL => RingOrder::Tool(tool_mm()),
            ORDER_HEAD => RingOrder::Head(self.words.get(HEAD, Ordering::Relaxed), tool_mm()),
            number => RingOrder::Unknown(number),
        };
        let before = self.taken.swap(read.wrapping_add(1), Ordering::Relaxed);
        (before != read.wrapping_add(1)).then_some(order)
    }

    /// Signals that this side is alive. Returns `true` if the control requests the end.
    pub fn beat(&self) -> bool {
        self.words.set(ALIVE, self.words.get(ALIVE, Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
        self.words.get(STOP, Ordering::Acquire) != 0
    }
}

impl Client {
    /// Opens existing rings.
    ///
    /// # Errors
    /// An I/O error if the file cannot be mapped or does not have this version.
    pub fn open(file: &File) -> io::Result<Client> {
        let none = || io::Error::new(io::ErrorKind::InvalidData, "the file holds no rings of this version");
        let words = Words::new(file)?;
        let word = |word| words.get(word, Ordering::Acquire);
        if word(0) != MAGIC || word(1) != VERSION {
            return Err(none());
        }
        let letters = [word(LETTERS), word(LETTERS + 1)].map(u64::to_le_bytes);
        let set: AxisSet = letters.as_flattened().iter().filter_map(|&letter| Axis::from_letter(letter)).collect();
        let capacity = word(CAPACITY);
        if !capacity.is_power_of_two() || capacity > MOST_RECORDS {
            return Err(none());
        }
        let shape = Shape::new(set, capacity);
        let is_sound = word(AXES) == shape.count as u64
            && word(STRIDE) == shape.stride as u64
            && words.all().len() >= shape.words();
        if is_sound { Ok(Client { words, shape }) } else { Err(none()) }
    }

    /// The axes, in the order of the records.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        self.shape.axes()
    }

    /// Writes a set-point with a number; `false` if the ring is full.
    #[must_use]
    pub fn put(&self, number: u64, set_point: &AxisVector) -> bool {
        self.put_after(number, set_point, 0)
    }

    /// As [`Client::put`], after an axis was referenced: the correction begins again at 0.
    #[must_use]
    pub fn put_after_reference(&self, number: u64, set_point: &AxisVector) -> bool {
        self.put_after(number, set_point, ORDER_RESET)
    }

    /// As [`Client::put`], with another tool in the spindle: its vector, mm. The set-points before must be answered, and the axes must stand until
    /// this one is.
    #[must_use]
    pub fn put_with_tool(&self, number: u64, set_point: &AxisVector, tool_mm: &[f64; 3]) -> bool {
        tool_mm.iter().enumerate().for_each(|(k, mm)| self.words.set(TOOL + k, mm.to_bits(), Ordering::Relaxed));
        self.put_after(number, set_point, ORDER_TOOL)
    }

    /// As [`Client::put_with_tool`], with another head: its number, as ncfix prints it.
    #[must_use]
    pub fn put_with_head(&self, number: u64, set_point: &AxisVector, head: u64, tool_mm: &[f64; 3]) -> bool {
        self.words.set(HEAD, head, Ordering::Relaxed);
        tool_mm.iter().enumerate().for_each(|(k, mm)| self.words.set(TOOL + k, mm.to_bits(), Ordering::Relaxed));
        self.put_after(number, set_point, ORDER_HEAD)
    }

    /// As [`Client::put`], with an order by its number.
    #[must_use]
    pub fn put_after(&self, number: u64, set_point: &AxisVector, order: u64) -> bool {
        let written = self.words.get(SET_POINTS_WRITTEN, Ordering::Relaxed);
        let read = self.words.get(SET_POINTS_READ, Ordering::Acquire);
        if written.wrapping_sub(read) >= self.shape.capacity {
            return false;
        }
        let to = self.shape.set_point(written);
        self.words.set(to, number, Ordering::Relaxed);
        for (index, &axis) in self.shape.axes().iter().enumerate() {
            self.words.set(to + 1 + index, set_point[axis].to_bits(), Ordering::Relaxed);
        }
        self.words.set(self.shape.order(written), order, Ordering::Relaxed);
        self.words.set(SET_POINTS_WRITTEN, written.wrapping_add(1), Ordering::Release);
        true
    }

    /// The next correction, with the number of its set-point; `None` if there is none yet.
    #[must_use]
    pub fn take(&self) -> Option<(u64, Answer)> {
        let read = self.words.get(CORRECTIONS_READ, Ordering::Relaxed);
        if self.words.get(CORRECTIONS_WRITTEN, Ordering::Acquire) == read {
            return None;
        }
        let from = self.shape.correction(read);
        let number = self.words.get(from, Ordering::Relaxed);
        let mut answer = Answer { signals: Signals(self.words.get(from + 1, Ordering::Relaxed)), ..Answer::default() };
        for (index, &axis) in self.shape.axes().iter().enumerate() {
            answer.correction[axis] = self.words.number(from + 2 + index);
        }
        self.words.set(CORRECTIONS_READ, read.wrapping_add(1), Ordering::Release);
        Some((number, answer))
    }

    /// Requests the end of the server side.
    pub fn stop(&self) {
        self.words.set(STOP, 1, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::Overrun;

    /// Counts of a ring of 16: 5 set-points are answered.
    #[test]
    fn a_count_that_goes_back_is_no_huge_number() {
        let found = |written: u64, read: u64| Overrun::of(written.wrapping_sub(5), 5_u64.wrapping_sub(read), 16);
        assert_eq!(found(22, 5), Overrun::SetPoints(17));
        assert_eq!(found(3, 5), Overrun::WentBack(2));
        assert_eq!(found(5, 7), Overrun::CorrectionsRead(2));
        assert_eq!(Overrun::of(0, 40, 16), Overrun::Corrections(40));
    }
}
