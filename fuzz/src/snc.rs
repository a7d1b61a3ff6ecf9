//! The text of the flat stream: what is written is read again as the same, and what is read is written as the same.

use ncfix_base::geometry::{AXES, AxisSet};
use ncfix_machine::snc::{Dwell, Element, Kind, TextReader, TextWriter, WordValue};

/// Beyond this the sixth decimal is noise of a double.
const EXACT_TO: f64 = 1e8;

/// Reads any text; what is read without a fault is written, read again and written the same.
pub fn read_and_written(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let read: Vec<_> = TextReader::new(&text).collect();
    let lines = text.lines().count();
    assert!(read.len() <= lines);
    for fault in read.iter().filter_map(|one| one.as_ref().err()) {
        assert!((1..=lines).contains(&fault.line) && !fault.message.is_empty(), "{fault:?}");
    }
    let elements: Result<Vec<Element>, _> = read.into_iter().collect();
    if let Ok(elements) = elements {
        check(&elements, AXES.into_iter().collect());
    }
}

/// Writes, reads and writes again.
pub(super) fn check(elements: &[Element], axes: AxisSet) {
    if !elements.iter().all(is_exact) {
        return;
    }
    let first = written(elements, axes);
    let read: Vec<Element> =
        TextReader::new(&first).map(|one| one.unwrap_or_else(|fault| panic!("{fault:?}\n{first}"))).collect();
    assert_eq!(read.len(), first.lines().count() - 1);
    assert_eq!(written(&read, axes), first);
}

fn written(elements: &[Element], axes: AxisSet) -> String {
    let mut text = TextWriter::new(Vec::new(), "test", axes, |_, tool| *tool).expect("memory takes all");
    for element in elements {
        text.write(element, &[]).expect("memory takes all");
    }
    String::from_utf8(text.finish().expect("memory takes all")).expect("the text is UTF-8")
}

/// Whether the text says all that there is to say of it: numbers to the sixth decimal, names that are text.
fn is_exact(element: &Element) -> bool {
    let is_fit = |value: f64| value.abs() < EXACT_TO;
    match &element.kind {
        Kind::Move(step) => {
            AXES.into_iter().all(|axis| is_fit(step.target[axis]))
                && is_fit(step.feed)
                && step.arc.iter().flat_map(|arc| arc.center_mm).all(is_fit)
        }
        Kind::Dwell(Dwell::Seconds(value) | Dwell::Turns(value)) => is_fit(*value),
        Kind::Tool(value) => is_text(value),
        Kind::Before(words) | Kind::After(words) => words.iter().all(|word| is_text(&word.value)),
        _ => true,
    }
}

fn is_text(value: &WordValue) -> bool {
    match value {
        WordValue::Number(number) => number.abs() < EXACT_TO,
        // A control counts no line ends and no bytes of other encodings among the characters of a name.
        WordValue::Name(name) => std::str::from_utf8(name).is_ok_and(|name| !name.contains(['"', '\n', '\r'])),
    }
}
