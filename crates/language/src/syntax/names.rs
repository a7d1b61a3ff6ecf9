//! Identifiers, stored once and referred to by number.

use std::collections::HashMap;
use std::sync::Arc;

/// Index of a name in the name table of a program; equal ids are equal names, ignoring case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NameId(pub(super) u32);

/// Identifiers of a program, each once.
#[derive(Clone, Debug, Default)]
pub struct Names {
    ids: HashMap<Arc<str>, u32>,
    texts: Vec<Arc<str>>,
}

impl Names {
    /// Returns the id of a name in any case, and stores a new name.
    pub(super) fn intern(&mut self, bytes: &[u8]) -> NameId {
        let text: String = bytes.iter().map(|b| char::from(b.to_ascii_uppercase())).collect();
        if let Some(&id) = self.ids.get(text.as_str()) {
            return NameId(id);
        }
        let id = u32::try_from(self.texts.len()).unwrap_or(u32::MAX);
        let text: Arc<str> = text.into();
        self.texts.push(Arc::clone(&text));
        self.ids.insert(text, id);
        NameId(id)
    }

    /// The id of an upper-case name, if the program has it.
    #[must_use]
    pub fn find(&self, text: &str) -> Option<NameId> {
        self.ids.get(text).map(|&id| NameId(id))
    }

    /// A name's text, upper case.
    #[must_use]
    pub fn text(&self, id: NameId) -> &str {
        self.texts.get(id.0 as usize).map_or("", |text| text)
    }

    /// All names in the order of their ids.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        self.texts.iter().map(|text| &**text)
    }
}

impl NameId {
    /// Its index in the order of [`Names::iter`].
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}
