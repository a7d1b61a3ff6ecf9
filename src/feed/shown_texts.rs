//! Messages of a control that a display shows: a limited number of limited length. The journal has all.

/// Limits of the characters per message and of the messages that are shown.
const MOST_CHARACTERS: usize = 200;
const MOST_TEXTS: u32 = 100;

/// The number of messages that came.
#[derive(Debug, Default)]
pub(crate) struct ShownTexts {
    count: u32,
}

impl ShownTexts {
    /// Returns the sentence to show for the next message of the control.
    pub(crate) fn next(&mut self, text: &str) -> Option<String> {
        self.count = self.count.saturating_add(1);
        if self.count > MOST_TEXTS {
            let is_first = self.count == MOST_TEXTS + 1;
            return is_first.then(|| "further messages of the control are only in the journal".into());
        }
        let mut shown: String = text.chars().take(MOST_CHARACTERS).collect();
        if shown.len() < text.len() {
            shown.push('…');
        }
        Some(format!("message of the control: {shown}"))
    }
}
