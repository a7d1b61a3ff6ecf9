//! Recognizes lathe programs by their marks. On a lathe the words have other meanings than on a mill, so such a program must not run as a milling program.
//!
//! Each kind of mark counts once. Its weight says how rare it is in milling programs: 6 is sufficient alone, 1 is a hint.

use super::blocks::{LooseBlock, lines};
use super::{Language, turning_names};

/// Smallest sum of weights at which a program counts as a lathe program.
const ENOUGH: u32 = 6;
/// Number of bytes that are examined: a lathe program is shorter, or has its marks there.
const HEAD: usize = 1 << 20;
/// Maximum number of marks in a message.
const MOST_NAMED: usize = 6;
/// Feeds below these are per revolution, mm and inch.
const FEED_PER_TURN: [f64; 2] = [1.0, 0.05];
/// Mark of a program that moves across and along and never names Y.
pub(super) const NO_Y: &str = "no Y";
/// Mark of a G92 whose lead is the F of an earlier block.
const MODAL_THREAD: &str = "G92 with X alone after it, a thread";

/// Feature of a lathe program that milling programs lack.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mark {
    /// Beginning of its line, bytes from the start of the text.
    pub at: usize,
    /// Line, from 1.
    pub line: u32,
    /// Description.
    pub what: &'static str,
    /// Weight of the mark for a lathe.
    pub(super) weight: u32,
    /// Property of the whole program on which its weight depends.
    pub(super) hangs_on: HangsOn,
}

/// Property of a whole program on which the weight of a mark depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HangsOn {
    /// None: the weight is constant.
    Nothing,
    /// Whether tools are changed by their numbers alone.
    Tools,
    /// Whether there is a Y.
    Flat,
    /// Whether there are canned cycles.
    Cycles,
    /// Whether the feed is per revolution.
    FeedMode,
}

/// Returns the marks of a lathe program, in descending order of weight; `None` if their sum is too small. `axes` are the letters of the machine axes.
#[must_use]
pub fn turning(language: Language, axes: &[u8], bytes: &[u8]) -> Option<Vec<Mark>> {
    let bytes = bytes.get(..bytes.len().min(HEAD)).unwrap_or_default();
    let mut found = match language {
        Language::Fanuc | Language::Rs274 => Search::new(language, axes).run(bytes),
        Language::Sinumerik | Language::Grundig => turning_names::marks(language, bytes),
    };
    if found.iter().map(|mark| mark.weight).sum::<u32>() < ENOUGH {
        return None;
    }
    found.sort_by_key(|mark| (std::cmp::Reverse(mark.weight), mark.line));
    found.truncate(MOST_NAMED);
    Some(found)
}

/// Search for marks in Fanuc words.
struct Search<'a> {
    is_fanuc: bool,
    axes: &'a [u8],
    marks: Vec<Mark>,
    motion: u32,
    is_inch: bool,
    /// Tools without M6: the first one, and whether there was another.
    tools: Option<(f64, bool)>,
    has_y: bool,
    has_depth: bool,
    has_cycle: bool,
    has_length: bool,
    has_m6: bool,
    has_plane: bool,
    has_own_feed: bool,
    /// G95 was found: a mill also uses it for drilling and boring.
    has_turn_feed: bool,
    /// Place of a block that was G92 with X and Z and nothing else so far.
    set_place: Option<(usize, u32)>,
}

impl<'a> Search<'a> {
    fn new(language: Language, axes: &'a [u8]) -> Search<'a> {
        Search {
            is_fanuc: language == Language::Fanuc,
            axes,
            marks: Vec::new(),
            motion: 0,
            is_inch: false,
            tools: None,
            has_y: false,
            has_depth: false,
            has_cycle: false,
            has_length: false,
            has_m6: false,
            has_plane: false,
            has_own_feed: false,
            has_turn_feed: false,
            set_place: None,
        }
    }

    fn run(mut self, bytes: &[u8]) -> Vec<Mark> {
        let mut block = LooseBlock::default();
        for (line, (at, text)) in (1..).zip(lines(bytes)) {
            block.read(text);
            if !block.words.is_empty() {
                self.block(&block, at, line);
            }
        }
        self.whole()
    }

    fn note(&mut self, place: (usize, u32), what: &'static str, weight: u32) {
        self.note_on(HangsOn::Nothing, place, what, weight);
    }

    fn note_on(&mut self, hangs_on: HangsOn, (at, line): (usize, u32), what: &'static str, weight: u32) {
        if !self.marks.iter().any(|mark| mark.what == what) {
            self.marks.push(Mark { at, line, what, weight, hangs_on });
        }
    }

    fn block(&mut self, block: &LooseBlock, at: usize, line: u32) {
        let place = (at, line);
        let code = |tenths: u32| block.has_code(tenths);
        if let Some(motion) = block.codes().filter(|code| *code <= 30).last() {
            self.motion = motion;
        }
        self.is_inch = (self.is_inch || code(200)) && !code(210);
        self.has_y |= block.word_of(b'Y').is_some_and(|word| word.value != Some(0.0));
        self.has_depth |= block.has(b'Z');
        self.has_length |= code(430) && block.has(b'H');
        self.has_m6 |= block.has_m(6.0);
        self.has_plane |= code(180) || code(190);
        self.has_turn_feed |= code(950);
        self.has_own_feed |= code(930) || code(840) || code(740) && block.has(b'R');
        let is_drilling = block.codes().any(|code| (810..=890).contains(&code) || matches!(code, 730 | 740 | 760));
        self.has_cycle |= is_drilling && block.has_any(b"ZR");
        self.words(block, place);
        self.cycles(block, place);
    }

    /// Notes marks of single words.
    fn words(&mut self, block: &LooseBlock, place: (usize, u32)) {
        let code = |tenths: u32| block.has_code(tenths);
        let is_step = |letter: u8| block.has(letter) && !self.axes.contains(&letter);
        let steps = is_step(b'U') || is_step(b'W');
        let is_mill_header = [170, 200, 490, 690, 800].into_iter().any(code);
        if code(500) && block.has(b'S') && !is_mill_header {
            self.note(place, "G50 S", 4);
        }
        if (code(280) || code(300)) && steps {
            self.note(place, "G28 U W", 4);
        } else if steps && !code(40) && !block.has_m(98.0) && !code(650) && !code(660) {
            self.note(place, "U and W beside X and Z", 3);
        }
        if code(960) && self.is_fanuc {
            self.note(place, "G96", 2);
        }
        if code(970) && self.is_fanuc {
            self.note(place, "G97", 1);
        }
        if let Some(tool) = block.word_of(b'T').filter(|word| word.digits >= 3 && !word.has_point)
            && let Some(number) = tool.value.filter(|&number| tool.digits > 3 || number >= 100.0)
        {
            self.note_on(HangsOn::Tools, place, "T with station and offset", 2);
            let (first, others) = self.tools.unwrap_or((number, false));
            self.tools = Some((first, others || first != number));
        }
        if let Some(feed) = block.word_of(b'F').and_then(|word| word.value).filter(|&feed| feed > 0.0)
            && feed < FEED_PER_TURN[usize::from(self.is_inch)]
            && self.is_fanuc
        {
            self.note_on(HangsOn::FeedMode, place, "a feed per revolution", 4);
        }
        if code(990) {
            self.note_on(HangsOn::Cycles, place, "G99 without a canned cycle", 2);
        }
        let is_arc = matches!(self.motion, 20 | 30) && block.has(b'K') && block.has_any(b"XZ");
        if is_arc && self.is_fanuc && !self.has_plane && !block.has(b'Y') && !block.has_any(b"J") {
            self.note(place, "an arc of X and Z without G18", 2);
        }
    }

    /// Notes marks of the cycles of a lathe.
    fn cycles(&mut self, block: &LooseBlock, place: (usize, u32)) {
        let code = |tenths: u32| block.has_code(tenths);
        let has = |letter: u8| block.has(letter);
        let (across, along) = (block.has_any(b"XU"), block.has_any(b"ZW"));
        let has_motion = block.codes().any(|code| code <= 30);
        if [700, 710, 720, 730].into_iter().any(code) && has(b'P') && has(b'Q') && !block.has_any(b"ZRIJK") {
            self.note(place, "G70 to G73 with P and Q", 6);
        }
        if [710, 720, 730].into_iter().any(code) && block.has_any(b"UWR") && !block.has_any(b"XYZ") && !has(b'Q') {
            self.note(place, "G71 to G73 with U and R", 4);
        }
        let is_packed = block.word_of(b'P').is_some_and(|word| word.digits >= 5 && !word.has_point);
        if code(760) && is_packed && has(b'Q') {
            self.note(place, "G76 with P of six digits", 6);
        } else if code(760) && across && along && has(b'P') && has(b'Q') && !block.has_any(b"RY") && self.is_fanuc {
            self.note(place, "G76 with a height P", 3);
        }
        let is_plain = !has_motion && !has(b'Y') && across && along;
        let is_pass = block.words.iter().all(|word| matches!(word.letter, b'X' | b'N')) && has(b'X');
        if let Some(thread) = self.set_place.take().filter(|_| is_pass) {
            self.note_on(HangsOn::Flat, thread, MODAL_THREAD, if self.is_fanuc { 6 } else { 4 });
        }
        if code(920) && is_plain && !has(b'F') {
            self.set_place = Some(place);
        }
        if code(920) && has(b'F') && (across || along) && !has(b'Y') {
            self.note(place, "G92 with F, a thread", if self.is_fanuc { 6 } else { 4 });
        }
        if (code(900) || code(940)) && is_plain && has(b'F') && self.motion == 0 {
            self.note(place, "G90 or G94 with X, Z and F, a turning cycle", 6);
        }
        if [770, 780, 790, 2900, 2920, 2940].into_iter().any(code) && is_plain {
            self.note(place, "G77 to G79 with X and Z", 4);
        }
        if (2700..=2760).any(|tenths| tenths % 10 == 0 && code(tenths)) {
            self.note(place, "G270 to G276", 4);
        }
        if (code(200) || code(210)) && is_plain && has(b'F') && self.motion == 0 {
            self.note(place, "G20 or G21 with X, Z and F", 3);
        }
        if code(320) && has(b'F') && (across || along) {
            self.note(place, "G32, a thread", 4);
        }
        if code(740) && has(b'R') && !block.has_any(b"XYZ")
            || code(750) && (has(b'R') || has(b'P') || has(b'Q')) && !has(b'Y')
        {
            self.note(place, "G74 or G75 for grooves", 4);
        }
        if code(100) && !has(b'L') && has(b'P') && has(b'Q') && block.has_any(b"XZ") {
            self.note(place, "G10 with the tip of a tool", 3);
        }
    }

    /// Notes marks that only the whole program shows.
    fn whole(mut self) -> Vec<Mark> {
        let is_flat = !self.has_y && self.has_depth;
        let (has_m6, has_cycle, has_own_feed, has_turn_feed, is_fanuc) =
            (self.has_m6, self.has_cycle, self.has_own_feed, self.has_turn_feed, self.is_fanuc);
        let several = self.tools.is_some_and(|(_, others)| others);
        self.marks.retain_mut(|mark| match mark.hangs_on {
            HangsOn::Tools => {
                mark.weight = if several && !has_m6 { 4 } else { 2 };
                true
            }
            HangsOn::Flat => is_flat,
            HangsOn::Cycles => !has_cycle,
            HangsOn::FeedMode => {
                mark.weight = if has_turn_feed { 3 } else { 4 };
                is_flat && !has_own_feed
            }
            HangsOn::Nothing => true,
        });
        if is_flat
            && is_fanuc
            && let Some(first) = self.marks.first().cloned()
        {
            self.marks.push(Mark { what: NO_Y, weight: 2, hangs_on: HangsOn::Nothing, ..first });
        }
        if self.has_length {
            // G43 belongs to mills: additional weight must indicate a lathe.
            let least = self.marks.iter().map(|mark| mark.weight).sum::<u32>();
            if least < ENOUGH + 4 {
                self.marks.clear();
            }
        }
        self.marks
    }
}
