//! Changes values in a TOML text and leaves the rest of it as it is: comments, order, spaces.

use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value};

/// Digits of a number that is written: far beyond what any instrument knows, and without the noise of the last bits.
const DIGITS: usize = 12;

/// A text that is being changed.
#[derive(Clone, Debug)]
pub struct Edit(DocumentMut);

/// What is written behind a key.
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
    /// Lists of numbers in a list.
    Rows(Vec<Vec<f64>>),
    /// An entry with keys of its own.
    Entry(Vec<(String, Given)>),
    /// A list of entries with keys of their own.
    Entries(Vec<Vec<(String, Given)>>),
}

impl Edit {
    /// Takes a text; `None` where it is no TOML.
    #[must_use]
    pub fn parse(text: &str) -> Option<Edit> {
        text.parse().ok().map(Edit)
    }

    /// The changed text.
    #[must_use]
    pub fn text(&self) -> String {
        self.0.to_string()
    }

    /// Changes or adds a key of a section, which is added where there is none; whether that is possible.
    pub fn set(&mut self, section: &str, key: &str, given: &Given) -> bool {
        let item = self.0.entry(section).or_insert_with(|| Item::Table(Table::new()));
        item.as_table_like_mut().map(|table| put(table, key, given)).is_some()
    }

    /// Changes or adds a key of the entry of this number in a list of sections; whether there is such an entry.
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

    /// Changes a value somewhere in the entry of this number in a list of sections, by keys and numbers: `knots[0].coefficients[2]`. A section
    /// that is no list is its own entry 0. The last key may be new. Whether that is possible.
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

    /// How many entries a list of sections has.
    #[must_use]
    pub fn count(&self, list: &str) -> usize {
        match self.0.get(list) {
            Some(Item::ArrayOfTables(tables)) => tables.len(),
            Some(Item::Value(Value::Array(array))) => array.len(),
            _ => 0,
        }
    }

    /// Whether the entry of this number has a key.
    #[must_use]
    pub fn has(&self, list: &str, index: usize, path: &str) -> bool {
        self.at(list, index, path).is_some()
    }

    /// A number in the entry of this number, by keys and numbers as [`Self::set_at`] has them.
    #[must_use]
    pub fn number(&self, list: &str, index: usize, path: &str) -> Option<f64> {
        let item = self.at(list, index, path)?;
        item.as_float().or_else(|| item.as_integer().map(|whole| whole as f64))
    }

    /// A text in it.
    #[must_use]
    pub fn word(&self, list: &str, index: usize, path: &str) -> Option<&str> {
        self.at(list, index, path)?.as_str()
    }

    /// How long a list in it is.
    #[must_use]
    pub fn length(&self, list: &str, index: usize, path: &str) -> usize {
        match self.at(list, index, path) {
            Some(Item::ArrayOfTables(tables)) => tables.len(),
            Some(Item::Value(Value::Array(array))) => array.len(),
            _ => 0,
        }
    }

    /// A section that is no list is its own entry 0, as for [`Self::set_at`].
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

    /// Adds an entry behind the others of a list in the entry of this number; whether that is possible.
    pub fn append(&mut self, list: &str, index: usize, key: &str, entries: &[(String, Given)]) -> bool {
        let own = self.0.get_mut(list).and_then(|item| item.get_mut(index)).and_then(|item| item.get_mut(key));
        own.is_some_and(|item| behind(item, entries))
    }

    /// Lines of comment above the entry of this number; whether it is a section that can have some.
    pub fn note(&mut self, list: &str, index: usize, lines: &[String]) -> bool {
        let Some(Item::ArrayOfTables(tables)) = self.0.get_mut(list) else { return false };
        let Some(table) = tables.get_mut(index) else { return false };
        let decor = table.decor_mut();
        let before = decor.prefix().and_then(|prefix| prefix.as_str()).unwrap_or("\n").to_owned();
        decor.set_prefix(before + &comment(lines));
        true
    }

    /// Lines of comment above a key of a section; whether it can have some.
    pub fn note_key(&mut self, section: &str, key: &str, lines: &[String]) -> bool {
        let Some(Item::Table(table)) = self.0.get_mut(section) else { return false };
        let Some(mut key) = table.key_mut(key) else { return false };
        let decor = key.leaf_decor_mut();
        let before = decor.prefix().and_then(|prefix| prefix.as_str()).unwrap_or_default().to_owned();
        decor.set_prefix(before + &comment(lines));
        true
    }

    /// Adds an entry behind the others of a list of sections; whether that is possible.
    pub fn push(&mut self, list: &str, entries: &[(String, Given)]) -> bool {
        behind(self.0.entry(list).or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new())), entries)
    }
}

fn comment(lines: &[String]) -> String {
    lines.iter().map(|line| format!("# {}\n", line.replace(char::is_control, " "))).collect()
}

/// Adds an entry behind the others of a list.
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
    // The comment behind a value belongs to its decoration.
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

/// A number with at most [`DIGITS`] digits, small ones with an exponent.
fn number_value(number: f64) -> Value {
    const SMALL: f64 = 1e-3;
    let text = format!("{number:.*e}", DIGITS - 1);
    // A zero has no sign for people.
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
