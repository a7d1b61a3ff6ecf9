//! Changes values in a TOML text and keeps the rest unchanged: comments, order, spaces.

use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value};

/// Significant digits of written numbers: far beyond the resolution of any instrument, without the noise of the last bits.
const DIGITS: usize = 12;

/// Text that is being changed.
#[derive(Clone, Debug)]
pub struct Edit(DocumentMut);

/// Value to be written for a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Given {
    /// A text.
    Text(String),
    /// A number.
    Number(f64),
    /// A whole number.
    Whole(i64),
    /// A list of numbers.
    Numbers(Vec<f64>),
    /// A list of texts.
    Texts(Vec<String>),
    /// A list of lists of numbers.
    Rows(Vec<Vec<f64>>),
    /// An entry with its own keys.
    Entry(Vec<(String, Given)>),
    /// A list of entries with their own keys.
    Entries(Vec<Vec<(String, Given)>>),
}

impl Edit {
    /// Parses a text; `None` if it is not TOML.
    #[must_use]
    pub fn parse(text: &str) -> Option<Edit> {
        text.parse().ok().map(Edit)
    }

    /// Returns the changed text.
    #[must_use]
    pub fn text(&self) -> String {
        self.0.to_string()
    }

    /// Changes or adds a key of a section; adds the section if it is missing. Returns false if that is not possible.
    pub fn set(&mut self, section: &str, key: &str, given: &Given) -> bool {
        let item = self.0.entry(section).or_insert_with(|| Item::Table(Table::new()));
        item.as_table_like_mut().map(|table| put(table, key, given)).is_some()
    }

    /// Changes or adds a key of a section inside the entry with this index in a list of sections; adds that section if it is missing. Returns false if
    /// there is no such entry.
    pub fn set_of(&mut self, list: &str, index: usize, section: &str, key: &str, given: &Given) -> bool {
        let entry = self.0.get_mut(list).and_then(|item| item.get_mut(index)).and_then(Item::as_table_like_mut);
        let Some(entry) = entry else { return false };
        if entry.get(section).is_none() {
            entry.insert(section, Item::Table(Table::new()));
        }
        let own = entry.get_mut(section).and_then(Item::as_table_like_mut);
        own.map(|table| put(table, key, given)).is_some()
    }

    /// Changes or adds a key of the entry with this index in a list of sections. Returns false if there is no such entry.
    pub fn set_in(&mut self, list: &str, index: usize, key: &str, given: &Given) -> bool {
        let Some(item) = self.0.get_mut(list) else { return false };
        let table: Option<&mut dyn TableLike> = match item {
            Item::ArrayOfTables(tables) => tables.get_mut(index).map(|table| table as &mut dyn TableLike),
            Item::Value(Value::Array(array)) => array
                .get_mut(index)
                .and_then(Value::as_inline_table_mut)
                .map(|table: &mut InlineTable| table as &mut dyn TableLike),
            _ => None,
        };
        table.map(|table| put(table, key, given)).is_some()
    }

    /// Changes a value inside the entry with this index in a list of sections. The path consists of keys and indices: `knots[0].coefficients[2]`. A section
    /// that is not a list is its own entry 0. The last key may be new. Returns false if the change is not possible.
    pub fn set_at(&mut self, list: &str, index: usize, path: &str, given: &Given) -> bool {
        let Some(item) = self.0.get_mut(list) else { return false };
        let found = if item.is_table_like() { Some(item).filter(|_| index == 0) } else { item.get_mut(index) };
        let Some(mut item) = found else { return false };
        let mut words = path.split('.').peekable();
        while let Some(word) = words.next() {
            let (key, numbers) = word.split_at(word.find('[').unwrap_or(word.len()));
            if numbers.is_empty() && words.peek().is_none() {
                return item.as_table_like_mut().map(|table| put(table, key, given)).is_some();
            }
            let Some(next) = item.as_table_like_mut().and_then(|table| table.get_mut(key)) else { return false };
            item = next;
            for number in numbers.split_terminator(']') {
                let number = number.strip_prefix('[').and_then(|number| number.parse::<usize>().ok());
                let Some(next) = number.and_then(|number| item.get_mut(number)) else { return false };
                item = next;
            }
        }
        let mut value = value(given);
        let Some(old) = item.as_value_mut() else { return false };
        *value.decor_mut() = old.decor().clone();
        *old = value;
        true
    }

    /// Returns the number of entries in a list of sections.
    #[must_use]
    pub fn count(&self, list: &str) -> usize {
        match self.0.get(list) {
            Some(Item::ArrayOfTables(tables)) => tables.len(),
            Some(Item::Value(Value::Array(array))) => array.len(),
            _ => 0,
        }
    }

    /// True if the entry with this index has a value at the path.
    #[must_use]
    pub fn has(&self, list: &str, index: usize, path: &str) -> bool {
        self.at(list, index, path).is_some()
    }

    /// Returns a number of the entry with this index, by a path as in [`Self::set_at`].
    #[must_use]
    pub fn number(&self, list: &str, index: usize, path: &str) -> Option<f64> {
        let item = self.at(list, index, path)?;
        item.as_float().or_else(|| item.as_integer().map(|whole| whole as f64))
    }

    /// Returns a text of the entry with this index.
    #[must_use]
    pub fn word(&self, list: &str, index: usize, path: &str) -> Option<&str> {
        self.at(list, index, path)?.as_str()
    }

    /// Returns the length of a list in the entry with this index.
    #[must_use]
    pub fn length(&self, list: &str, index: usize, path: &str) -> usize {
        match self.at(list, index, path) {
            Some(Item::ArrayOfTables(tables)) => tables.len(),
            Some(Item::Value(Value::Array(array))) => array.len(),
            _ => 0,
        }
    }

    /// Finds a value. A section that is not a list is its own entry 0, as for [`Self::set_at`].
    fn at(&self, list: &str, index: usize, path: &str) -> Option<&Item> {
        let own = self.0.get(list)?;
        let mut item = if own.is_table_like() { Some(own).filter(|_| index == 0)? } else { own.get(index)? };
        for word in path.split('.') {
            let (key, numbers) = word.split_at(word.find('[').unwrap_or(word.len()));
            item = item.get(key)?;
            for number in numbers.split_terminator(']') {
                item = item.get(number.strip_prefix('[')?.parse::<usize>().ok()?)?;
            }
        }
        Some(item)
    }

    /// Appends an entry to a list in the entry with this index. Returns false if that is not possible.
    pub fn append(&mut self, list: &str, index: usize, key: &str, entries: &[(String, Given)]) -> bool {
        let own = self.0.get_mut(list).and_then(|item| item.get_mut(index)).and_then(|item| item.get_mut(key));
        own.is_some_and(|item| behind(item, entries))
    }

    /// Adds comment lines above the entry with this index. Returns false if it is not a section that can have comments.
    pub fn note(&mut self, list: &str, index: usize, lines: &[String]) -> bool {
        let Some(Item::ArrayOfTables(tables)) = self.0.get_mut(list) else { return false };
        let Some(table) = tables.get_mut(index) else { return false };
        let decor = table.decor_mut();
        let before = decor.prefix().and_then(|prefix| prefix.as_str()).unwrap_or("\n").to_owned();
        decor.set_prefix(before + &comment(lines));
        true
    }

    /// Adds comment lines above a key of a section. Returns false if that is not possible.
    pub fn note_key(&mut self, section: &str, key: &str, lines: &[String]) -> bool {
        let Some(Item::Table(table)) = self.0.get_mut(section) else { return false };
        let Some(mut key) = table.key_mut(key) else { return false };
        let decor = key.leaf_decor_mut();
        let before = decor.prefix().and_then(|prefix| prefix.as_str()).unwrap_or_default().to_owned();
        decor.set_prefix(before + &comment(lines));
        true
    }

    /// Appends an entry to a list of sections. Returns false if that is not possible.
    pub fn push(&mut self, list: &str, entries: &[(String, Given)]) -> bool {
        behind(self.0.entry(list).or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new())), entries)
    }
}

fn comment(lines: &[String]) -> String {
    lines.iter().map(|line| format!("# {}\n", line.replace(char::is_control, " "))).collect()
}

/// Appends an entry to a list.
fn behind(list: &mut Item, entries: &[(String, Given)]) -> bool {
    match list {
        Item::ArrayOfTables(tables) => {
            let mut table = Table::new();
            entries.iter().for_each(|(key, given)| put(&mut table, key, given));
            tables.push(table);
            true
        }
        Item::Value(Value::Array(array)) => {
            array.push(inline(entries));
            true
        }
        _ => false,
    }
}

fn put(table: &mut dyn TableLike, key: &str, given: &Given) {
    let mut value = value(given);
    // The comment after a value belongs to its decoration.
    if let Some(old) = table.get(key).and_then(Item::as_value) {
        *value.decor_mut() = old.decor().clone();
    }
    table.insert(key, Item::Value(value));
}

fn inline(entries: &[(String, Given)]) -> InlineTable {
    entries.iter().map(|(key, given)| (key.as_str(), value(given))).collect()
}

fn value(given: &Given) -> Value {
    match given {
        Given::Text(text) => text.as_str().into(),
        Given::Number(number) => number_value(*number),
        Given::Whole(number) => (*number).into(),
        Given::Numbers(numbers) => numbers.iter().copied().map(number_value).collect::<Array>().into(),
        Given::Texts(texts) => texts.iter().map(String::as_str).collect::<Array>().into(),
        Given::Rows(rows) => rows
            .iter()
            .map(|numbers| Value::Array(numbers.iter().copied().map(number_value).collect()))
            .collect::<Array>()
            .into(),
        Given::Entry(entries) => Value::InlineTable(inline(entries)),
        Given::Entries(all) => all.iter().map(|entries| Value::InlineTable(inline(entries))).collect::<Array>().into(),
    }
}

/// Makes a number with at most [`DIGITS`] digits; small ones have an exponent.
fn number_value(number: f64) -> Value {
    const SMALL: f64 = 1e-3;
    let text = format!("{number:.*e}", DIGITS - 1);
    // Zero is written without a sign.
    let rounded: f64 = text.parse().ok().filter(|rounded| *rounded != 0.0).unwrap_or_default();
    let plain = if rounded != 0.0 && rounded.abs() < SMALL { format!("{rounded:e}") } else { format!("{rounded:?}") };
    plain.parse().unwrap_or_else(|_| rounded.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# mine\n[a]\nb = 1.5   # why\n\n[[m]]   # first\nk = [1, 2]\n\n[z]\nlast = true\n";

    #[test]
    fn what_is_not_changed_stays() {
        let mut edit = Edit::parse(TEXT).unwrap();
        assert_eq!(edit.text(), TEXT);
        assert!(edit.set("a", "b", &Given::Number(0.1 + 0.2)));
        assert!(edit.set_in("m", 0, "k", &Given::Numbers(vec![0.0, -1.7e-5])));
        assert!(!edit.set_in("m", 1, "k", &Given::Number(1.0)));
        assert_eq!(
            edit.text(),
            "# mine\n[a]\nb = 0.3   # why\n\n[[m]]   # first\nk = [0.0, -1.7e-5]\n\n[z]\nlast = true\n"
        );
    }

    #[test]
    fn values_are_changed_where_they_stand() {
        let text = "[[m]]\n[[m]] # second\nk = [1, [2, 3]] # why\ns = [{ name = \"a\", v = 1 }, { name = \"b\" }]\nt = { u = 2 }\n";
        let mut edit = Edit::parse(text).unwrap();
        for (path, number) in [("k[1][0]", 5.0), ("s[0].v", -1.0), ("s[1].w", 7.0), ("t.u", 9.0), ("new", 4.0)] {
            assert!(edit.set_at("m", 1, path, &Given::Number(number)), "{path}");
        }
        for path in ["k[2]", "k[1][5]", "s[2].v", "x.y", "t.u.v", "k[a]", "k[0].z"] {
            assert!(!edit.set_at("m", 1, path, &Given::Number(0.0)), "{path}");
        }
        assert!(!edit.set_at("m", 2, "new", &Given::Number(0.0)) && !edit.set_at("n", 0, "new", &Given::Number(0.0)));
        let changed = "[[m]]\n[[m]] # second\nk = [1, [5.0, 3]] # why\ns = [{ name = \"a\", v = -1.0 }, { name = \"b\" , w = 7.0 }]\nt = { u = 9.0 }\nnew = 4.0\n";
        assert_eq!(edit.text(), changed);
    }

    #[test]
    fn entries_are_added_behind_their_like() {
        let mut edit = Edit::parse(TEXT).unwrap();
        assert!(edit.push("m", &[("k".into(), Given::Text("new".into()))]));
        assert!(edit.set("a", "c", &Given::Whole(2)));
        assert!(edit.set("n", "d", &Given::Entries(vec![vec![("at_mm".into(), Given::Number(5.0))]])));
        let text = edit.text();
        let places: Vec<usize> = ["c = 2", "[[m]]   # first", "k = \"new\"", "[z]", "[n]", "{ at_mm = 5.0 }"]
            .iter()
            .map(|part| text.find(part).unwrap_or_else(|| panic!("{part}: {text}")))
            .collect();
        assert!(places.is_sorted(), "{text}");
        assert!(!edit.push("a", &[]));
    }

    #[test]
    fn comments_stand_above_what_they_belong_to() {
        let text = "[a]\n# old\nb = 1\n\n# of m\n[[m]]\ns = [{ n = 1 }]\n[[m]]\n";
        let mut edit = Edit::parse(text).unwrap();
        assert_eq!((edit.count("m"), edit.count("a"), edit.count("x")), (2, 0, 0));
        assert_eq!(edit.number("m", 0, "s[0].n"), Some(1.0));
        assert!(edit.append("m", 0, "s", &[("n".into(), Given::Whole(2))]) && edit.length("m", 0, "s") == 2);
        assert!(edit.note("m", 0, &["new\nline".into()]) && edit.note_key("a", "b", &["two".into(), "three".into()]));
        assert!(!edit.note("m", 2, &[]) && !edit.note_key("a", "c", &[]) && !edit.note("a", 0, &[]));
        assert_eq!(
            edit.text(),
            "[a]\n# old\n# two\n# three\nb = 1\n\n# of m\n# new line\n[[m]]\ns = [{ n = 1 }, { n = 2 }]\n[[m]]\n"
        );
    }
}
