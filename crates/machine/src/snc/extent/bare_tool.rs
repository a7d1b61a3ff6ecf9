//! Tools that cut while the control adds no length: no G43, D0.

use super::{Origin, WordValue};

/// Maximum number of noted tools: an endless program may count T up.
const MOST_TOOLS: usize = 64;

/// A tool in the spindle, and the first feed move with it for which the control adds no length.
#[derive(Clone, Debug, PartialEq)]
pub struct BareTool {
    /// Place of the move.
    pub origin: Origin,
    /// T word of the tool.
    pub tool: WordValue,
}

/// The tool in the spindle by the words of a stream.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct BareTools {
    changes_at_t: bool,
    selected: Option<WordValue>,
    in_spindle: Option<WordValue>,
    /// True if a feed move with this tool is noted.
    is_noted: bool,
    cuts: Vec<BareTool>,
}

impl BareTools {
    pub(super) fn new(changes_at_t: bool) -> BareTools {
        BareTools { changes_at_t, ..BareTools::default() }
    }

    pub(super) fn select(&mut self, word: &WordValue) {
        self.selected = Some(word.clone());
        if self.changes_at_t {
            self.change();
        }
    }

    pub(super) fn change(&mut self) {
        if let Some(selected) = &self.selected {
            // T0 empties the spindle.
            self.in_spindle = Some(selected.clone()).filter(|word| *word != WordValue::Number(0.0));
            self.is_noted = false;
        }
    }

    pub(super) fn cut(&mut self, origin: Origin) {
        if std::mem::replace(&mut self.is_noted, true) || self.cuts.len() >= MOST_TOOLS {
            return;
        }
        if let Some(tool) = self.in_spindle.clone().filter(|tool| self.cuts.iter().all(|cut| cut.tool != *tool)) {
            self.cuts.push(BareTool { origin, tool });
        }
    }

    pub(super) fn cuts(&self) -> &[BareTool] {
        &self.cuts
    }
}
