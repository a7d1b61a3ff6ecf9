//! Numbers: what the parsers read against the standard library, and what is written against its formatting.

use ncfix_base::csv::{DecimalSign, Table};
use ncfix_language::syntax::{self, Program, sinumerik, words};
use ncfix_path::emit::Decimals;

use super::programs::dialect_of;
use super::source;

/// The first bytes as digits, the rest as a count.
pub fn agree(bytes: &[u8]) {
    read(&digits(bytes));
    if let Some((head, rest)) = bytes.split_first_chunk::<8>() {
        let places = usize::from(rest.first().copied().unwrap_or(4) % 10);
        let units = u64::from(rest.get(1).copied().unwrap_or(1) % 99) + 1;
        write(i64::from_le_bytes(*head), places, units);
    }
}

/// Digits, one point at most, and a sign, made of any bytes; those that are such stay as they are.
fn digits(bytes: &[u8]) -> String {
    let mut text = String::new();
    for &byte in bytes.iter().take(60) {
        match byte {
            b'0'..=b'9' => text.push(char::from(byte)),
            b'-' if text.is_empty() => text.push('-'),
            b'.' if !text.contains('.') => text.push('.'),
            128.. if text.len() > 2 => text.push('0'),
            other => text.push(char::from(b'0' + other % 10)),
        }
    }
    if !text.contains(|byte: char| byte.is_ascii_digit()) {
        text.push('7');
    }
    text
}

/// All dialects read what the standard library reads, to the last bit.
fn read(text: &str) {
    let wanted: f64 = text.parse().expect("digits");
    let file = format!("X{text}\n");
    for name in ["grundig", "fanuc", "rs274"] {
        let (Program::Words(program), findings) = syntax::parse(&source("n", file.as_bytes()), dialect_of(name)) else {
            panic!("{name} is a language of words");
        };
        assert!(findings.is_empty(), "{name} {file} {findings:?}");
        let word = program.words_of(&program.blocks[0])[0];
        let words::Value::Number { value, has_point, digits } = word.value else { panic!("{name} {word:?}") };
        assert_eq!((value, has_point), (wanted, text.contains('.')), "{name} {text}");
        let before = text.trim_start_matches('-').split('.').next().unwrap_or_default().len();
        assert_eq!(usize::from(digits), before, "{name} {text}");
    }
    let (Program::Sinumerik(program), findings) = syntax::parse(&source("n", file.as_bytes()), dialect_of("sinumerik"))
    else {
        panic!("another family of trees");
    };
    assert!(findings.is_empty(), "{file} {findings:?}");
    let sinumerik::Value::Number(value, is_whole) = program.words_of(&program.blocks[0])[0].value else {
        panic!("{file}")
    };
    assert_eq!((value, is_whole), (wanted, !text.contains('.')), "{text}");
    in_table(text, wanted);
}

/// The same in a cell of a table, with a point or a comma.
fn in_table(text: &str, wanted: f64) {
    for (sign, cell) in [(DecimalSign::Point, text.to_owned()), (DecimalSign::Comma, text.replace('.', ","))] {
        let (table, findings) = Table::read(&source("t", format!("a;b\n{cell};\n").as_bytes()));
        let table = table.unwrap_or_else(|| panic!("{findings:?}"));
        let row = table.rows().next().expect("one row");
        match row.number(0, sign) {
            Ok(value) => assert_eq!(value, wanted),
            Err(finding) => assert!(wanted.abs() > 1e15, "{finding:?}"),
        }
    }
}

/// A count of an increment is the decimal that whole numbers of 128 bits make.
fn write(count: i64, places: usize, units: u64) {
    let increment: f64 = format!("{units}e-{places}").parse().expect("a decimal");
    let decimals = Decimals::of_increment(increment).expect("a decimal of at most nine places");
    let mut line = Vec::new();
    decimals.push(&mut line, count);
    let text = String::from_utf8(line).expect("digits");
    let (whole, fraction) = text.split_once('.').unwrap_or((&text, ""));
    assert!(fraction.len() <= places && !fraction.ends_with('0') && !text.ends_with('.') && text != "-0", "{text}");
    let joined: i128 = format!("{whole}{fraction:0<places$}").parse().expect("digits");
    assert_eq!(joined, i128::from(count) * i128::from(units), "{count} times {units}e-{places}");
    assert_eq!(text.starts_with('-'), count < 0);
}
