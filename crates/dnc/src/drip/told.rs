//! State of a control from the lines before a place: last block of every kind of code, tool, spindle, coolant, axis positions.

use std::collections::{BTreeMap, BTreeSet};

use super::block::{AXES, BlockWord, absolute, arguments, block, is_number, words};
use super::rules::{Axes, BlockCode, Grammar, Key, M, Rule};

/// Letters of axes that a tool change does not move.
const TURNING: &[u8] = b"ABC";
/// Beginnings of absolute rotary positions in the notation of a Sinumerik.
const ABSOLUTE: &[&str] = &["DC(", "ACP(", "ACN(", "AC("];
/// Codes after which positions are in inches; then codes of feed per minute, which include constant cutting speed.
const INCH: &[&str] = &["G20", "G70", "G700"];
const PER_MINUTE: &[&str] = &["G94", "G942"];
/// Codes whose words are lengths in the unit in force.
const LENGTHS: &[&str] = &["G43.1", "G43.2", "G64", "G22", "G641"];
/// Motions after which a rapid move brings no new motion mode.
const RAPID: &[&str] = &["G0", "G00", "G80"];
/// Code that orients the spindle.
const ORIENTED: &str = "M19";
/// Codes that start the spindle, and the dwell in which it runs up.
const STARTS: &[&str] = &["M3", "M03", "M4", "M04", "M13", "M14"];
const DWELL: &[&str] = &["G4", "G04"];
/// Code of inverse-time feed.
const INVERSE_TIME: &str = "G93";

/// Millimeters per inch.
const MM_PER_INCH: f64 = 25.4;
/// Feed of the restart path where the program moved down rapidly, mm/min: slow enough to be stopped by hand.
const DOWN_MM_MIN: f64 = 200.0;

/// Path to a restart place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RestartPath {
    /// Clear height, and height of the place, both Z of the program, mm.
    pub(super) clearance_mm: f64,
    pub(super) stands_mm: f64,
}

/// State that a control has received.
#[derive(Clone)]
pub(super) struct SentState {
    grammar: Grammar,
    /// Blocks that restore a state; `None` if no block can.
    states: BTreeMap<Key, Option<Vec<String>>>,
    /// Axis positions in the words of the program; `None` if a stated position is no longer known.
    places: BTreeMap<u8, Option<String>>,
    /// Words F, S, D, H.
    values: BTreeMap<u8, String>,
    motion: Option<String>,
    spindle: Option<String>,
    /// Dwell in which the spindle runs up: it follows the start before any motion.
    run_up: Option<String>,
    /// True from the start of the spindle until the next motion.
    runs_up: bool,
    coolant: BTreeSet<String>,
    /// True if any line switched the coolant.
    has_coolant: bool,
    /// Tool in the spindle, and tool selected for the next change.
    pub(super) tool: Option<String>,
    selected: Option<String>,
    was_changed: bool,
    /// True if a line set a state that cannot be restored.
    pub(super) is_beyond: bool,
    /// True if that may have changed the meaning of a height.
    is_shifted: bool,
}

impl SentState {
    pub(super) fn new(grammar: Grammar) -> SentState {
        SentState {
            grammar,
            states: BTreeMap::new(),
            places: BTreeMap::new(),
            values: BTreeMap::new(),
            motion: None,
            spindle: None,
            run_up: None,
            runs_up: false,
            coolant: BTreeSet::new(),
            has_coolant: false,
            tool: None,
            selected: None,
            was_changed: false,
            is_beyond: false,
            is_shifted: false,
        }
    }

    /// True if every state that `other` has is known here, too.
    pub(super) fn knows(&self, other: &SentState) -> bool {
        other.states.keys().all(|key| self.states.contains_key(key))
            && other.places.keys().all(|axis| self.places.contains_key(axis))
            && other.values.keys().all(|address| self.values.contains_key(address))
            && (self.spindle.is_some() || other.spindle.is_none())
            && (self.has_coolant || !other.has_coolant)
            && (self.tool.is_some() || other.tool.is_none())
            && !other.is_beyond
    }

    /// Notes a line that the control receives.
    pub(super) fn note(&mut self, text: &str) {
        let mut words = words(text, &self.grammar);
        // A tool selected in the block of the change is the tool that is loaded.
        for word in words.iter_mut().filter(|word| word.name == "T" && word.code.is_none()) {
            word.is_claimed = true;
            if self.grammar.changes_on_t {
                self.change(Some(word.text.to_owned()));
            } else {
                self.selected = Some(word.text.to_owned());
            }
        }
        let mut is_elsewhere = false;
        for at in 0..words.len() {
            if let Some(code) = words[at].code {
                words[at].is_claimed = true;
                is_elsewhere |= self.act(code, at, &mut words);
            }
        }
        let is_incremental =
            self.grammar.group("G90").and_then(|group| self.states.get(&(group, ""))).is_some_and(Option::is_none);
        // Offsets first: the axis words of the block refer to them.
        for is_axis in [false, true] {
            for word in words.iter().filter(|word| !word.is_claimed && word.is_axis() == is_axis) {
                self.value(word, is_incremental);
            }
        }
        if is_elsewhere {
            self.forget(AXES);
        }
    }

    /// Applies the effect of a code. Returns true if it moves the axes to a place that its block does not state.
    fn act(&mut self, code: BlockCode, at: usize, words: &mut [BlockWord<'_>]) -> bool {
        let text = words[at].text;
        match code.rule {
            Rule::Motion(says_where) => {
                self.motion = Some(text.to_owned());
                self.runs_up = false;
                return !says_where;
            }
            Rule::Passing => {
                let dwell = block(text, arguments(code, words, Axes::Values));
                if self.runs_up && DWELL.contains(&text) {
                    self.run_up = dwell;
                }
            }
            Rule::Elsewhere => return true,
            Rule::State(key, axes) => {
                let block = block(text, arguments(code, words, axes));
                self.set(key, block.map(|block| vec![block]));
            }
            Rule::Added(key, axes) => {
                let added = block(text, arguments(code, words, axes));
                let before = self.states.get(&key).cloned().unwrap_or(Some(Vec::new()));
                let all = before.zip(added).map(|(mut all, added)| {
                    all.push(added);
                    all
                });
                self.set(key, all);
            }
            Rule::InForce(key) => {
                let has_axes = arguments(code, words, Axes::Refused).is_none();
                self.set(key, None);
                return has_axes;
            }
            Rule::Spindle => {
                // For example the number of the spindle.
                let has_more = arguments(code, words, Axes::Values).is_none_or(|more| !more.is_empty());
                self.is_beyond |= has_more && text != ORIENTED;
                self.spindle = Some(text.to_owned());
                (self.run_up, self.runs_up) = (None, STARTS.contains(&text));
                if ["M13", "M14"].contains(&text) {
                    self.has_coolant = true;
                }
            }
            Rule::Coolant => {
                self.has_coolant = true;
                if ["M9", "M09"].contains(&text) {
                    self.coolant.clear();
                    // The code that started the spindle had also switched the coolant on.
                    let turns = self.spindle.as_deref().and_then(|spindle| match spindle {
                        "M13" => Some("M3"),
                        "M14" => Some("M4"),
                        _ => None,
                    });
                    self.spindle = turns.map(str::to_owned).or(self.spindle.take());
                } else {
                    self.coolant.insert(text.to_owned());
                }
            }
            Rule::ToolChange => {
                let tool = self.selected.take().or(self.tool.take());
                self.change(tool);
            }
            Rule::ToolIs => {
                let number = words.iter_mut().find(|word| word.name == "Q" && is_number(word.value));
                let tool = number.map(|word| {
                    word.is_claimed = true;
                    format!("T{}", word.value)
                });
                self.change(tool);
            }
            Rule::Output | Rule::Never => {
                let _ = arguments(code, words, Axes::Values);
                self.is_beyond = true;
                self.is_shifted |= code.rule == Rule::Never;
            }
        }
        false
    }

    /// Notes an address with its value.
    fn value(&mut self, word: &BlockWord<'_>, is_incremental: bool) {
        let is_plain = is_number(word.value);
        match word.letter() {
            b'N' | b':' | b'%' | b'/' | b'O' => {}
            letter if word.is_axis() => {
                self.runs_up = false;
                let is_absolute = is_plain || ABSOLUTE.iter().any(|begin| absolute(word.value, begin));
                let place = (is_absolute && !is_incremental).then(|| word.text.to_owned());
                self.places.insert(letter, place);
            }
            letter @ (b'F' | b'S') if word.name.len() == 1 && is_plain => {
                _ = self.values.insert(letter, word.text.to_owned())
            }
            letter @ (b'D' | b'H') if word.name.len() == 1 && is_plain => {
                if self.values.get(&letter).is_none_or(|old| old != word.text) {
                    self.forget(AXES);
                }
                self.values.insert(letter, word.text.to_owned());
            }
            // Arc words and similar words end with their block.
            _ if self.grammar.belongs_to_motion(word.name) => {}
            _ if word.name.len() == 1 && !b"FSTDH".contains(&word.letter()) && is_plain => {}
            _ => (self.is_beyond, self.is_shifted) = (true, true),
        }
    }

    fn set(&mut self, key: Key, blocks: Option<Vec<String>>) {
        // With another zero offset, tool length or unit the old positions have another meaning.
        let shifting = ["G54", "G43", "G21", "G71"].map(|name| self.grammar.group(name));
        let units = ["G21", "G71"].map(|name| self.grammar.group(name));
        if units.contains(&Some(key.0)) && self.states.get(&key).is_some_and(|old| *old != blocks) {
            // Lengths were given in the previous unit.
            let has_length = |blocks: &Option<Vec<String>>| {
                blocks.iter().flatten().any(|block| {
                    LENGTHS.iter().any(|code| block.split(' ').next() == Some(code) && block.contains(' '))
                })
            };
            self.states.values_mut().filter(|blocks| has_length(blocks)).for_each(|blocks| *blocks = None);
        }
        let is_shifted = shifting.contains(&Some(key.0)) && self.states.get(&key) != Some(&blocks);
        if is_shifted {
            self.forget(AXES);
            self.values.remove(&b'H');
        }
        self.states.insert(key, blocks);
    }

    fn change(&mut self, tool: Option<String>) {
        self.tool = tool;
        self.was_changed = true;
        // The tool changer has moved the axes; rotary axes keep their positions.
        let moved: Vec<u8> = AXES.iter().copied().filter(|axis| !TURNING.contains(axis)).collect();
        self.forget(&moved);
    }

    fn forget(&mut self, axes: &[u8]) {
        for (_, place) in self.places.iter_mut().filter(|(axis, _)| axes.contains(axis)) {
            *place = None;
        }
    }

    /// Returns the blocks of the states; codes without words share a block. `None` if a state cannot be restored.
    fn codes(&self) -> Option<Vec<String>> {
        let (mut plain, mut own): (Vec<&str>, Vec<String>) = (Vec::new(), Vec::new());
        for (key, blocks) in &self.states {
            for block in blocks.as_ref()? {
                if key.0 == M || block.contains(' ') || !block.starts_with(['G', 'g']) {
                    own.push(block.clone());
                } else {
                    plain.push(block);
                }
            }
        }
        let mut out = vec![plain.join(" ")];
        out.append(&mut own);
        let offsets: Vec<&str> =
            b"DH".iter().filter_map(|address| self.values.get(address)).map(String::as_str).collect();
        out.push(offsets.join(" "));
        Some(out)
    }

    /// Returns the lines that restore the state and move to the place via the clear height. `None` if an axis position is unknown or a state cannot be
    /// restored. Rapid moves go down no further than the clear height.
    pub(super) fn lines(&self, is_numbered: bool, way: RestartPath) -> Option<Vec<String>> {
        if self.is_beyond || self.motion.as_deref().is_some_and(|motion| !RAPID.contains(&motion)) {
            return None;
        }
        let places: BTreeMap<u8, &str> =
            self.places.iter().map(|(axis, place)| Some((*axis, place.as_deref()?))).collect::<Option<_>>()?;
        let [x, y, z] = [places.get(&b'X')?, places.get(&b'Y')?, places.get(&b'Z')?];
        let others: Vec<&str> = b"ABCUVW".iter().filter_map(|axis| places.get(axis).copied()).collect();
        let mut out = self.codes()?;
        // Tool prepared for the next change.
        out.extend(self.selected.clone());
        out.extend(self.turning()?);
        // Up first; no rotary axis turns while the tool moves across.
        out.push(self.lift(way.clearance_mm));
        if !others.is_empty() {
            out.push(format!("G0 {}", others.join(" ")));
        }
        out.push(format!("G0 {x} {y}"));
        if way.stands_mm > way.clearance_mm {
            out.push(format!("G0 {z}"));
        } else if way.stands_mm < way.clearance_mm {
            if !self.is_per_minute() {
                return None;
            }
            let (unit, feed) = (self.mm_per_unit(), DOWN_MM_MIN);
            out.push(format!("G1 {z} F{}", trimmed(feed / unit)));
            // Not a move: the next line may rely on its G0.
            out.push(format!("G0 {x} {y}"));
        }
        out.extend(self.values.get(&b'F').filter(|_| !self.plain().any(|block| block == INVERSE_TIME)).cloned());
        out.retain(|line| !line.is_empty());
        Some(numbered(out, is_numbered))
    }

    /// Returns the blocks of spindle and coolant; `None` if the spindle is oriented.
    fn turning(&self) -> Option<Vec<String>> {
        if self.spindle.as_deref() == Some(ORIENTED) {
            return None;
        }
        let speed = self.values.get(&b'S').map(String::as_str);
        let spindle = [speed, self.spindle.as_deref()].into_iter().flatten().collect::<Vec<_>>().join(" ");
        let mut out = vec![spindle];
        if self.coolant.is_empty()
            && self.has_coolant
            && !self.spindle.as_deref().is_some_and(|spindle| ["M13", "M14"].contains(&spindle))
        {
            out.push("M9".to_owned());
        }
        // One line each: some controls accept only one M code per block.
        out.extend(self.coolant.iter().cloned());
        out.extend(self.run_up.clone());
        Some(out)
    }

    /// Returns the lines that lift the tool before the beginning. `None` after a tool or a tool length, which changes the meaning of Z.
    pub(super) fn beginning(&self, is_numbered: bool, clearance_mm: f64) -> Option<Vec<String>> {
        let length = self.grammar.group("G43").and_then(|group| self.states.get(&(group, "")));
        let has_length =
            length.is_some_and(|blocks| blocks.as_ref().is_none_or(|blocks| blocks.iter().any(|block| block != "G49")));
        let has_offset = b"DH".iter().any(|address| self.values.contains_key(address));
        if self.is_shifted
            || has_offset
            || has_length && self.grammar.group("G49").is_some()
            || self.was_changed
            || self.selected.is_some()
        {
            return None;
        }
        let mut out = self.codes()?;
        out.push(self.lift(clearance_mm));
        out.retain(|line| !line.is_empty());
        Some(numbered(out, is_numbered))
    }

    fn plain(&self) -> impl Iterator<Item = &str> {
        self.states.values().flatten().flatten().map(String::as_str)
    }

    fn mm_per_unit(&self) -> f64 {
        if self.plain().any(|block| INCH.contains(&block)) { MM_PER_INCH } else { 1.0 }
    }

    /// True if the feed is per minute.
    fn is_per_minute(&self) -> bool {
        let group = self.grammar.group("G94");
        let block = group.and_then(|group| self.states.get(&(group, "")));
        block.is_none_or(|blocks| {
            blocks.as_ref().is_some_and(|blocks| blocks.iter().all(|block| PER_MINUTE.contains(&block.as_str())))
        })
    }

    /// Returns the rapid move to a height, in the unit in force.
    fn lift(&self, mm: f64) -> String {
        format!("G0 Z{}", trimmed(mm / self.mm_per_unit()))
    }
}

/// Formats a number without trailing zeros; the decimal point stays.
fn trimmed(value: f64) -> String {
    format!("{value:.4}").trim_end_matches('0').to_owned()
}

fn numbered(lines: Vec<String>, is_numbered: bool) -> Vec<String> {
    if !is_numbered {
        return lines;
    }
    (1..).zip(lines).map(|(number, line)| format!("N{number} {line}")).collect()
}

#[cfg(test)]
mod tests;
