//! Lathe marks in programs of a Sinumerik and of a Grundig, whose blocks contain names and assignments besides letters and numbers.

use std::sync::LazyLock;

use ncfix_base::pattern::{RegexSet, patterns};

use super::Language;
use super::blocks::{LooseBlock, lines};
use super::turning::{HangsOn, Mark, NO_Y};

/// Feeds below this are per revolution, mm.
const FEED_PER_TURN_MM: f64 = 1.0;

/// Sinumerik names that only lathes have: patterns, names in messages, weights.
const NAMES: &[(&str, &str, u32)] = &[
    ("DIAMON", "DIAMON", 3),
    ("DIAM90", "DIAM90", 3),
    (r"CYCLE93\(", "CYCLE93", 4),
    (r"CYCLE94\(", "CYCLE94", 4),
    (r"CYCLE95\(", "CYCLE95", 4),
    (r"CYCLE96\(", "CYCLE96", 4),
    (r"CYCLE97\(", "CYCLE97", 4),
    (r"CYCLE98\(", "CYCLE98", 4),
    (r"CYCLE930\(", "CYCLE930", 4),
    (r"CYCLE940\(", "CYCLE940", 4),
    (r"CYCLE951\(", "CYCLE951", 4),
    (r"CYCLE952\(", "CYCLE952", 4),
    ("LIMS=", "LIMS", 1),
];

static NAME_MARKS: LazyLock<RegexSet> = LazyLock::new(|| patterns(NAMES.iter().map(|(pattern, ..)| *pattern)));

/// Text in the header of programs for the lathe control of Philips.
const PHILIPS_LATHE: &str = "SYSTEM 3000";

static PHILIPS_MARK: LazyLock<RegexSet> = LazyLock::new(|| patterns([PHILIPS_LATHE]));

/// Signs of a lathe program in the blocks so far.
#[derive(Debug, Default)]
struct Search {
    marks: Vec<Mark>,
    has_x: bool,
    has_y: bool,
    has_z: bool,
    /// G93 or G94 was found: F is not a feed per revolution.
    has_own_feed: bool,
    /// G95 was found.
    has_turn_feed: bool,
    has_plane: bool,
    motion: u32,
}

/// Returns the marks of a program.
pub(super) fn marks(language: Language, bytes: &[u8]) -> Vec<Mark> {
    let mut search = Search::default();
    let mut block = LooseBlock::default();
    for (line, (at, text)) in (1..).zip(lines(bytes)) {
        match language {
            Language::Sinumerik => {
                search.names((at, line), text.split(|&byte| byte == b';').next().unwrap_or_default())
            }
            _ if PHILIPS_MARK.is_match(text) => search.note((at, line), PHILIPS_LATHE, 2),
            _ => {}
        }
        block.read_around_names(text);
        if !block.words.is_empty() {
            search.block(language, &block, (at, line));
        }
    }
    search.whole()
}

impl Search {
    fn note(&mut self, place: (usize, u32), what: &'static str, weight: u32) {
        self.note_on(HangsOn::Nothing, place, what, weight);
    }

    fn note_on(&mut self, hangs_on: HangsOn, (at, line): (usize, u32), what: &'static str, weight: u32) {
        if !self.marks.iter().any(|mark| mark.what == what) {
            self.marks.push(Mark { at, line, what, weight, hangs_on });
        }
    }

    fn names(&mut self, place: (usize, u32), code: &[u8]) {
        for &(_, name, weight) in NAME_MARKS.matches(code).iter().filter_map(|mark| NAMES.get(mark)) {
            self.note(place, name, weight);
        }
    }

    fn block(&mut self, language: Language, block: &LooseBlock, place: (usize, u32)) {
        let code = |tenths: u32| block.has_code(tenths);
        if let Some(motion) = block.codes().filter(|code| *code <= 30).last() {
            self.motion = motion;
        }
        self.has_x |= block.has(b'X');
        self.has_y |= block.has(b'Y');
        self.has_z |= block.has(b'Z');
        self.has_own_feed |= code(930) || code(940);
        self.has_turn_feed |= code(950);
        self.has_plane |= code(180) || code(190);
        if code(960) {
            self.note(place, "G96", 2);
        }
        if code(360) && language == Language::Grundig {
            self.note(place, "G36", 3);
        }
        let feed = block.word_of(b'F').and_then(|word| word.value);
        if feed.is_some_and(|feed| feed > 0.0 && feed < FEED_PER_TURN_MM) && !code(40) && !code(840) {
            self.note_on(HangsOn::FeedMode, place, "a feed per revolution", 4);
        }
        let is_arc = matches!(self.motion, 20 | 30) && block.has(b'K') && block.has_any(b"XZ");
        if is_arc && language == Language::Sinumerik && !self.has_plane && !block.has_any(b"YJ") {
            self.note(place, "an arc of X and Z without G18", 2);
        }
    }

    /// Notes marks that only the whole program shows. A program that names Y, even Y0, has such an axis.
    fn whole(mut self) -> Vec<Mark> {
        let is_flat = !self.has_y && self.has_x && self.has_z;
        let (has_own_feed, has_turn_feed) = (self.has_own_feed, self.has_turn_feed);
        self.marks.retain_mut(|mark| {
            if mark.hangs_on != HangsOn::FeedMode {
                return true;
            }
            // A mill also drills and bores with G95.
            mark.weight = if has_turn_feed { 3 } else { 4 };
            is_flat && !has_own_feed
        });
        if is_flat && let Some(first) = self.marks.first().cloned() {
            self.marks.push(Mark { what: NO_Y, weight: 2, hangs_on: HangsOn::Nothing, ..first });
        }
        self.marks
    }
}
