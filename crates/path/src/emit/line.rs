//! A line of the output, built word by word and written when the next one begins. Words after the last piece of a move and words for its first line
//! thus find their places.

use super::block_number::NumberSet;
use super::kept::KeptLines;
use ncfix_base::units::push_integer;

/// Feed modes of a move: by its time, per minute, per revolution. A block can have one.
pub(super) const FEED_WORDS: [&str; 3] = ["G93", "G94", "G95"];

/// The line under construction, with the settings common to all lines: line end, numbers, count.
#[derive(Debug)]
pub(super) struct LineBuilder {
    /// The line so far, without its comment.
    pub(super) text: Vec<u8>,
    /// `true` if the line has a motion; a further move of the same block then needs its own line.
    pub(super) has_motion: bool,
    /// S, M, H and D words of the block, which follow the words of its motion.
    held: Vec<u8>,
    comment: Vec<u8>,
    /// Mark of a line with a comment, which then gets a line of its own: a reader takes only a comment that is the mark alone.
    mark: Vec<u8>,
    has_words: bool,
    is_open: bool,
    /// Byte offset in the line at which its motion begins.
    motion_at: Option<usize>,
    /// `true` if the line has a feed.
    pub(super) has_feed: bool,
    /// Byte offset of a word of the line that may have to change.
    marked_at: Option<usize>,
    ending: &'static [u8],
    /// Bytes beyond which a comment gets a line of its own.
    longest: usize,
    /// The last line number given, if lines are numbered.
    number: Option<u32>,
    /// The largest line number; the next one is 1 again.
    last_number: u32,
    /// Numbers that are reserved for blocks of the source.
    kept_free: NumberSet,
    /// The number of the source's block, if this is its first line.
    own_number: Option<u32>,
    blocks: u64,
    /// Lines of the source, whose bytes stay if nothing in them changes.
    pub(super) kept: KeptLines,
}

impl LineBuilder {
    /// An empty line; lines end with CR LF if `crlf` is set, otherwise with LF.
    pub(super) fn new(crlf: bool, kept: KeptLines) -> LineBuilder {
        LineBuilder {
            kept,
            text: Vec::with_capacity(256),
            has_motion: false,
            held: Vec::with_capacity(64),
            comment: Vec::with_capacity(64),
            mark: Vec::with_capacity(8),
            has_words: false,
            is_open: false,
            motion_at: None,
            has_feed: false,
            marked_at: None,
            ending: if crlf { b"\r\n" } else { b"\n" },
            longest: usize::MAX,
            number: None,
            last_number: u32::MAX,
            kept_free: NumberSet::default(),
            own_number: None,
            blocks: 0,
        }
    }

    /// Limits the length of lines, in bytes; a longer comment gets its own line.
    pub(super) fn no_longer_than(self, longest: usize) -> LineBuilder {
        LineBuilder { longest, ..self }
    }

    /// Numbers the lines N1, N2, … without those reserved by [`Self::keep_free`]; after the last number they start again.
    pub(super) fn numbered(self, last_number: u32) -> LineBuilder {
        LineBuilder { number: Some(0), last_number, ..self }
    }

    /// Reserves the numbers of the source; line numbers start after the largest of them.
    pub(super) fn keep_free(&mut self, numbers: NumberSet) {
        if let Some(number) = &mut self.number {
            *number = numbers.largest();
            self.kept_free = numbers;
        }
    }

    /// Sets the number of the source's block that begins with this line, if lines are numbered.
    pub(super) fn own_number(&mut self, number: Option<u32>) {
        // If no numbers are reserved, the number may be in use by another line.
        self.own_number = number.filter(|&number| self.kept_free.has(number));
    }

    /// The number of lines with words so far.
    pub(super) fn blocks(&self) -> u64 {
        self.blocks
    }

    pub(super) fn open(&mut self) {
        self.is_open = true;
    }

    pub(super) fn is_open(&self) -> bool {
        self.is_open
    }

    pub(super) fn has_comment(&self) -> bool {
        !self.comment.is_empty()
    }

    pub(super) fn has_words(&self) -> bool {
        self.has_words || !self.held.is_empty()
    }

    /// Appends the number of the source's block.
    pub(super) fn block_number(&mut self, letter: u8, number: u32) {
        self.text.push(letter);
        push_integer(&mut self.text, u64::from(number));
    }

    /// Appends the label of the source's block; a label does not count as a word.
    pub(super) fn label(&mut self, label: &[u8]) {
        self.is_open = true;
        if !self.text.is_empty() {
            self.text.push(b' ');
        }
        self.text.extend_from_slice(label);
        self.text.push(b':');
    }

    /// Appends a word with a blank before it.
    pub(super) fn word(&mut self, bytes: &[u8]) {
        self.is_open = true;
        self.has_words = true;
        if !self.text.is_empty() {
            self.text.push(b' ');
        }
        self.text.extend_from_slice(bytes);
    }

    /// Removes words that another of their group replaces in this line. A message keeps its text.
    pub(super) fn remove_words(&mut self, words: &[&str]) {
        if self.motion_at.is_some() || self.text.contains(&b'"') {
            return;
        }
        let is_kept = |word: &&[u8]| !words.iter().any(|other| other.as_bytes() == *word);
        if !self.text.split(|&byte| byte == b' ').all(|word| is_kept(&word)) {
            let kept: Vec<&[u8]> = self.text.split(|&byte| byte == b' ').filter(is_kept).collect();
            self.text = kept.join(&b' ');
        }
    }

    /// Marks the beginning of the motion words.
    pub(super) fn begin_motion(&mut self) {
        self.has_motion = true;
        self.motion_at = Some(self.text.len());
    }

    /// Takes everything from `start` on off the line until the motion is written.
    pub(super) fn hold_from(&mut self, start: usize) {
        self.held.extend_from_slice(self.text.get(start..).unwrap_or_default());
        self.text.truncate(start);
    }

    /// Appends the words that were held back for the motion.
    pub(super) fn release(&mut self) {
        let held = self.held.trim_ascii_start();
        if !self.text.is_empty() && !held.is_empty() {
            self.text.push(b' ');
        }
        self.text.extend_from_slice(held);
        self.held.clear();
    }

    /// Appends parts to the comment of the line.
    pub(super) fn note(&mut self, parts: &[&[u8]]) {
        if !self.comment.is_empty() {
            self.comment.push(b' ');
        }
        for part in parts {
            self.comment.extend_from_slice(part);
        }
    }

    /// Marks the line by a comment.
    pub(super) fn mark(&mut self, mark: &[&[u8]]) {
        if self.has_comment() {
            mark.iter().for_each(|part| self.mark.extend_from_slice(part));
        } else {
            self.note(mark);
        }
    }

    /// Inserts a word before the motion words of the line.
    pub(super) fn insert(&mut self, word: &str) {
        match self.motion_at {
            None => self.word(word.as_bytes()),
            Some(0) => {
                self.text.splice(0..0, word.bytes().chain([b' ']));
            }
            Some(at) => {
                self.text.splice(at..at, [b' '].into_iter().chain(word.bytes()));
            }
        }
    }

    /// Marks the last word, which has `length` bytes.
    pub(super) fn mark_last(&mut self, length: usize) {
        self.marked_at = self.text.len().checked_sub(length);
    }

    /// Replaces the marked word, which has `length` bytes; `false` if none is marked.
    pub(super) fn replace_marked(&mut self, length: usize, word: &str) -> bool {
        let Some(at) = self.marked_at else { return false };
        self.text.splice(at..at + length, word.bytes());
        if let Some(motion_at) = &mut self.motion_at {
            *motion_at = *motion_at + word.len() - length;
        }
        true
    }

    /// Writes the line, if it has any content, and begins another.
    pub(super) fn end(&mut self, out: &mut Vec<u8>) {
        if !std::mem::take(&mut self.is_open) {
            return;
        }
        self.release();
        let is_too_long = self.text.len() + 1 + self.comment.len() > self.longest;
        if self.has_comment() && self.has_words && (is_too_long || !self.mark.is_empty()) {
            self.next_number(out);
            out.extend_from_slice(&self.comment);
            out.extend_from_slice(self.ending);
            self.comment.clear();
            self.comment.extend_from_slice(&self.mark);
        }
        self.mark.clear();
        if !self.text.is_empty() || self.has_comment() {
            let own_number = self.own_number.take();
            let has_new_number = self.number.is_some() && own_number.is_none();
            let kept = self.kept.line(own_number, &self.text, &self.comment);
            match kept.filter(|kept| !has_new_number && kept.len() <= self.longest) {
                Some(kept) => out.extend_from_slice(kept),
                None => {
                    match own_number {
                        Some(number) => push_number(number, out),
                        None => self.next_number(out),
                    }
                    out.extend_from_slice(&self.text);
                    if !self.text.is_empty() && self.has_comment() {
                        out.push(b' ');
                    }
                    out.extend_from_slice(&self.comment);
                }
            }
            out.extend_from_slice(self.ending);
            self.blocks += u64::from(self.has_words);
        }
        self.text.clear();
        self.comment.clear();
        self.marked_at = None;
        self.motion_at = None;
        self.has_words = false;
        self.has_motion = false;
        self.has_feed = false;
    }

    /// Writes a line with words before the line under construction.
    pub(super) fn words_before(&mut self, text: &[u8], out: &mut Vec<u8>) {
        self.blocks += 1;
        self.comment_before(text, out);
    }

    /// Writes a line without words before the line under construction.
    pub(super) fn comment_before(&mut self, text: &[u8], out: &mut Vec<u8>) {
        self.next_number(out);
        self.header(text, out);
    }

    /// Writes a line unchanged.
    pub(super) fn header(&self, text: &[u8], out: &mut Vec<u8>) {
        out.extend_from_slice(text);
        out.extend_from_slice(self.ending);
    }

    /// Writes the number of the next line, if lines are numbered.
    fn next_number(&mut self, out: &mut Vec<u8>) {
        let Some(number) = &mut self.number else { return };
        // If every number is reserved, any number is used.
        for _ in 0..=self.last_number {
            *number = if *number >= self.last_number { 1 } else { *number + 1 };
            if !self.kept_free.has(*number) {
                break;
            }
        }
        push_number(*number, out);
    }
}

fn push_number(number: u32, out: &mut Vec<u8>) {
    out.push(b'N');
    push_integer(out, u64::from(number));
    out.push(b' ');
}
