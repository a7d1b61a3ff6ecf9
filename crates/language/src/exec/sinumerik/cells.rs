//! Content of a variable: one value, or an array of up to three dimensions, row by row.

use super::value::Value;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::DefinitionType;
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Lengths of the dimensions; 1 for unused dimensions.
pub(super) type Lengths = [usize; 3];

/// Characters of a string variable without given length, and the maximum.
const MAX_STRING: usize = 400;

/// The value cells of a variable.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    kind: DefinitionType,
    /// Characters of a STRING.
    string: usize,
    dimensions: usize,
    lengths: Lengths,
    values: Vec<Value>,
}

impl Cells {
    /// Cells with the initial value of their type, at most `limit`.
    pub(super) fn new(
        kind: DefinitionType,
        string: Option<i64>,
        dimensions: &[i64],
        limit: usize,
        (text, span): (&str, Span),
    ) -> Result<Cells, Fault> {
        let help = "arrays have one to three dimensions, each of at least one element";
        let mut lengths = [1; 3];
        if dimensions.len() > lengths.len() {
            let message = format!("{text} has {} dimensions", dimensions.len());
            return Err(fault(Code::BAD_INDEX, span, message, help));
        }
        for (place, &length) in lengths.iter_mut().zip(dimensions) {
            *place = usize::try_from(length).ok().filter(|length| *length > 0).ok_or_else(|| {
                fault(Code::BAD_INDEX, span, format!("{text} has a dimension of length {length}"), help)
            })?;
        }
        let count = lengths.iter().try_fold(1_usize, |count, length| count.checked_mul(*length));
        let Some(count) = count.filter(|count| *count <= limit) else {
            let message = format!("{text} has more elements than the remaining {limit}");
            return Err(fault(Code::BAD_INDEX, span, message, "make the array smaller"));
        };
        let string = string.and_then(|length| usize::try_from(length).ok()).unwrap_or(MAX_STRING).min(MAX_STRING);
        Ok(Cells { kind, string, dimensions: dimensions.len(), lengths, values: vec![Value::initial(kind); count] })
    }

    /// Number of cells.
    pub(super) fn count(&self) -> usize {
        self.values.len()
    }

    /// Number of indices of an element.
    pub(super) fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Type of the elements.
    pub(super) fn kind(&self) -> DefinitionType {
        self.kind
    }

    /// `true` if it has indices.
    pub(super) fn is_array(&self) -> bool {
        self.dimensions > 0
    }

    /// The first value, that of a variable that is not an array.
    pub(super) fn first(&self) -> Option<&Value> {
        self.values.first()
    }

    /// The value at an index; an additional index selects a character of a string.
    pub(super) fn get(&self, indices: &[i64], at: (&str, Span)) -> Result<Value, Fault> {
        if self.kind == DefinitionType::String && indices.len() == self.dimensions + 1 {
            let (&last, front) = indices.split_last().ok_or_else(|| self.bad_index(indices, at))?;
            let place = self.place(front, at)?;
            let text = self.values.get(place).map(Value::text).unwrap_or_default();
            let index = usize::try_from(last).ok().filter(|index| *index < self.string);
            let index = index.ok_or_else(|| self.bad_index(indices, at))?;
            return Ok(Value::Char(text.get(index).copied().unwrap_or(0)));
        }
        let place = self.place(indices, at)?;
        self.values.get(place).cloned().ok_or_else(|| self.bad_index(indices, at))
    }

    /// Sets the value at an index.
    pub(super) fn set(&mut self, indices: &[i64], value: Value, at: (&str, Span)) -> Result<(), Fault> {
        if self.kind == DefinitionType::String && indices.len() == self.dimensions + 1 {
            return self.set_character(indices, value, at);
        }
        let place = self.place(indices, at)?;
        self.put(place, value, at)
    }

    /// Sets consecutive values from an index on; a slot without value keeps the old one.
    pub(super) fn fill(
        &mut self,
        indices: &[i64],
        values: impl IntoIterator<Item = Option<Value>>,
        at: (&str, Span),
    ) -> Result<(), Fault> {
        let start = self.start(indices, at)?;
        for (offset, value) in values.into_iter().enumerate() {
            let place = start + offset;
            if place >= self.values.len() {
                let message = format!("{} has {} elements, but the list is longer", at.0, self.values.len());
                return Err(fault(Code::BAD_INDEX, at.1, message, "shorten the list, or make the array larger"));
            }
            if let Some(value) = value {
                self.put(place, value, at)?;
            }
        }
        Ok(())
    }

    /// Sets `count` elements from an index on to one value; all to the end without a count.
    pub(super) fn repeat(
        &mut self,
        indices: &[i64],
        value: &Value,
        count: Option<i64>,
        at: (&str, Span),
    ) -> Result<(), Fault> {
        let start = self.start(indices, at)?;
        let left = self.values.len().saturating_sub(start);
        let count = count.map_or(left, |count| usize::try_from(count).unwrap_or(0).min(left));
        for place in start..start + count {
            self.put(place, value.clone(), at)?;
        }
        Ok(())
    }

    fn put(&mut self, place: usize, value: Value, (text, span): (&str, Span)) -> Result<(), Fault> {
        let number = value.number();
        let converted = value.converted(self.kind).ok_or_else(|| match (self.kind, number) {
            (DefinitionType::Int, Some(number)) => beyond_int(text, number, span),
            _ => wrong_type(text, span),
        })?;
        if let Some(cell) = self.values.get_mut(place) {
            *cell = match converted {
                // Excess text is cut off.
                Value::Text(mut text) => {
                    text.truncate(self.string);
                    Value::Text(text)
                }
                other => other,
            };
        }
        Ok(())
    }

    fn set_character(&mut self, indices: &[i64], value: Value, at: (&str, Span)) -> Result<(), Fault> {
        let (&last, front) = indices.split_last().ok_or_else(|| self.bad_index(indices, at))?;
        let place = self.place(front, at)?;
        let Some(Value::Char(byte)) = value.converted(DefinitionType::Char) else { return Err(wrong_type(at.0, at.1)) };
        let index = usize::try_from(last).ok().filter(|index| *index < self.string);
        let index = index.ok_or_else(|| self.bad_index(indices, at))?;
        if let Some(Value::Text(text)) = self.values.get_mut(place) {
            if byte == 0 {
                // The character 0 ends a string.
                text.truncate(index);
            } else {
                if text.len() <= index {
                    text.resize(index + 1, b' ');
                }
                if let Some(character) = text.get_mut(index) {
                    *character = byte;
                }
            }
        }
        Ok(())
    }

    /// Start of a list: the index, or the first element without index.
    fn start(&self, indices: &[i64], at: (&str, Span)) -> Result<usize, Fault> {
        if indices.is_empty() { Ok(0) } else { self.place(indices, at) }
    }

    fn place(&self, indices: &[i64], at: (&str, Span)) -> Result<usize, Fault> {
        if indices.len() != self.dimensions {
            let message = format!("{} has {} dimensions, not {}", at.0, self.dimensions, indices.len());
            return Err(fault(Code::BAD_INDEX, at.1, message, "write as many indices as its DEF has lengths"));
        }
        let mut place = 0;
        for (&index, &length) in indices.iter().zip(&self.lengths) {
            let index = usize::try_from(index).ok().filter(|index| *index < length);
            place = place * length + index.ok_or_else(|| self.bad_index(indices, at))?;
        }
        Ok(place)
    }

    fn bad_index(&self, indices: &[i64], (text, span): (&str, Span)) -> Fault {
        let list = |numbers: Vec<String>| numbers.join(",");
        let written = list(indices.iter().map(i64::to_string).collect());
        let lengths = list(self.lengths[..self.dimensions].iter().map(usize::to_string).collect());
        let message = format!("there is no {text}[{written}]");
        let help = if self.dimensions == 0 {
            format!("{text} is not an array")
        } else {
            format!("{text} has the lengths {lengths}, and its indices begin at 0")
        };
        fault(Code::BAD_INDEX, span, message, help)
    }
}

/// The error for a number beyond INT, for which the control has an alarm.
fn beyond_int(text: &str, number: f64, span: Span) -> Fault {
    let message = format!("{text} is an INT (maximum 2147483647) and cannot hold {number}");
    fault(Code::NOT_COMPUTABLE, span, message, "define it as REAL, or check the value")
}

pub(super) fn wrong_type(text: &str, span: Span) -> Fault {
    fault(Code::TYPE_MISMATCH, span, format!("{text} cannot hold this value"), "check the types in the DEF block")
}
