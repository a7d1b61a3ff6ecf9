//! Functions of the language: arithmetic, texts, axes.

use super::value::{Value, half_up, is_axis_name};
use ncfix_base::units::sin_deg;
use ncfix_dialect::{Treatment, WordPlace, words};

/// Reason why a function has no value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NoValue {
    /// Unknown function.
    Unknown,
    /// Wrong number of arguments; the correct number.
    Count(&'static str),
    /// An argument has the wrong type.
    Type,
    /// Undefined for these arguments.
    Undefined(&'static str),
}

/// An arithmetic function, whose number of arguments is in the table of words. Angles in degrees.
fn arithmetic(name: &str) -> Option<fn(&[f64]) -> f64> {
    Some(match name {
        "SIN" => |a| sin_deg(a[0]),
        "COS" => |a| sin_deg(90.0 - a[0]),
        "TAN" => |a| sin_deg(a[0]) / sin_deg(90.0 - a[0]),
        "ASIN" => |a| a[0].asin().to_degrees(),
        "ACOS" => |a| a[0].acos().to_degrees(),
        // The direction from a point to itself is undefined.
        "ATAN2" => |a| if a == [0.0, 0.0] { f64::NAN } else { a[0].atan2(a[1]).to_degrees() },
        "SQRT" => |a| a[0].sqrt(),
        "ABS" => |a| a[0].abs(),
        "POT" => |a| a[0] * a[0],
        "TRUNC" => |a| a[0].trunc(),
        "ROUND" => |a| half_up(a[0]),
        "ROUNDUP" => |a| a[0].ceil(),
        "LN" => |a| a[0].ln(),
        "EXP" => |a| a[0].exp(),
        "MINVAL" => |a| a[0].min(a[1]),
        "MAXVAL" => |a| a[0].max(a[1]),
        "BOUND" => |a| if a[0] > a[1] { f64::NAN } else { a[2].clamp(a[0], a[1]) },
        _ => return None,
    })
}

/// A function of texts and axes; `None` if an argument has the wrong type.
type Textual = fn(&[Value]) -> Option<Value>;

/// A function of texts and axes, whose number of arguments is in the table of words.
fn textual(name: &str) -> Option<Textual> {
    Some(match name {
        "STRLEN" => |a| Some(Value::Int(text(&a[0])?.len() as i64)),
        "TOUPPER" => |a| Some(Value::Text(text(&a[0])?.to_ascii_uppercase())),
        "TOLOWER" => |a| Some(Value::Text(text(&a[0])?.to_ascii_lowercase())),
        "ISNUMBER" => |a| Some(Value::Bool(number_in(&text(&a[0])?).is_some())),
        "NUMBER" => |a| number_in(&text(&a[0])?).map(Value::Real),
        "SUBSTR" => |a| {
            let text = text(&a[0])?;
            let start = usize::try_from(a[1].whole()?).ok()?.min(text.len());
            let length = match a.get(2) {
                Some(length) => usize::try_from(length.whole()?).ok()?,
                None => text.len(),
            };
            let end = start.saturating_add(length).min(text.len());
            Some(Value::Text(text[start..end].to_vec()))
        },
        "INDEX" => |a| {
            let byte = character(&a[1])?;
            Some(place(text(&a[0])?.iter().position(|&candidate| candidate == byte)))
        },
        "RINDEX" => |a| {
            let byte = character(&a[1])?;
            Some(place(text(&a[0])?.iter().rposition(|&candidate| candidate == byte)))
        },
        "MINDEX" => |a| {
            let any = text(&a[1])?;
            Some(place(text(&a[0])?.iter().position(|candidate| any.contains(candidate))))
        },
        "MATCH" => |a| {
            let (text, part) = (text(&a[0])?, text(&a[1])?);
            let found =
                if part.is_empty() { Some(0) } else { text.windows(part.len()).position(|window| window == part) };
            Some(place(found))
        },
        "AXNAME" => |a| {
            let name = String::from_utf8(text(&a[0])?).ok()?.trim().to_ascii_uppercase();
            is_axis_name(&name).then_some(Value::Axis(name))
        },
        "AXSTRING" => |a| match &a[0] {
            Value::Axis(name) => Some(Value::Text(name.clone().into_bytes())),
            _ => None,
        },
        "SPI" => |a| match a[0].whole()? {
            number @ 1..=99 => Some(Value::Axis(format!("SPI{number}"))),
            _ => None,
        },
        "SPRINT" => sprint,
        _ => return None,
    })
}

/// `true` if a name is a function, and so not a variable.
pub(super) fn is_function(name: &str) -> bool {
    words().find(name, WordPlace::Expression).is_some()
}

/// `true` if a name is a function that returns a frame.
pub(super) fn is_frame_function(name: &str) -> bool {
    words().find(name, WordPlace::Expression).is_some_and(|row| row.treatment == Treatment::Frame)
}

/// Evaluates a function that depends only on its arguments.
pub(super) fn evaluate(name: &str, arguments: &[Value]) -> Result<Value, NoValue> {
    let row = words().find(name, WordPlace::Expression).filter(|row| row.treatment == Treatment::Function);
    let (fewest, most) = row.ok_or(NoValue::Unknown)?.counts;
    if !(fewest..=most).contains(&arguments.len()) {
        return Err(NoValue::Count(match (fewest, most) {
            (1, 1) => "1 argument",
            (2, 2) => "2 arguments",
            (3, 3) => "3 arguments",
            (2, 3) => "2 or 3 arguments",
            _ => "1 to 32 arguments",
        }));
    }
    if let Some(function) = arithmetic(name) {
        let numbers: Option<Vec<f64>> = arguments.iter().map(Value::number).collect();
        let result = function(&numbers.ok_or(NoValue::Type)?);
        if !result.is_finite() {
            return Err(NoValue::Undefined(match name {
                "SQRT" => "it takes numbers from 0",
                "ASIN" | "ACOS" => "it takes numbers from -1 to 1",
                "LN" => "it takes numbers above 0",
                "ATAN2" => "one of its two arguments must not be 0",
                "BOUND" => "its first argument must not be above its second",
                "TAN" => "it has no value at 90 degrees from the axis",
                _ => "its result is too large",
            }));
        }
        return Ok(Value::Real(result));
    }
    let function = textual(name).ok_or(NoValue::Unknown)?;
    match function(arguments) {
        Some(value) => Ok(value),
        None if name == "SUBSTR" && text(&arguments[0]).is_some() => {
            Err(NoValue::Undefined("its places and lengths are whole numbers from 0"))
        }
        None if name == "NUMBER" => Err(NoValue::Undefined("ask ISNUMBER first")),
        None if name == "AXNAME" => Err(NoValue::Undefined("give it the name of an axis")),
        None => Err(NoValue::Type),
    }
}

/// A text, or a single character.
fn text(value: &Value) -> Option<Vec<u8>> {
    matches!(value, Value::Text(_) | Value::Char(_)).then(|| value.text())
}

fn character(value: &Value) -> Option<u8> {
    match value {
        Value::Char(byte) => Some(*byte),
        Value::Text(text) => match text[..] {
            [byte] => Some(byte),
            _ => None,
        },
        other => other.whole().and_then(|code| u8::try_from(code).ok()),
    }
}

/// Positions are counted from 0; −1 means not found.
fn place(found: Option<usize>) -> Value {
    Value::Int(found.map_or(-1, |place| place as i64))
}

/// The number in a text, in the notation of the language.
fn number_in(text: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(text).ok()?.trim().to_ascii_uppercase();
    let is_decimal = text.bytes().all(|byte| byte.is_ascii_digit() || b"+-.EX".contains(&byte));
    let plain = text.replace("EX", "e");
    (is_decimal && !plain.contains('E')).then(|| plain.parse().ok()).flatten().filter(|value: &f64| value.is_finite())
}

/// `SPRINT("…%5.2F…", value)`: B, C, D, E, F, G, I, S, X, with width and decimals.
fn sprint(arguments: &[Value]) -> Option<Value> {
    const MOST: usize = 100;
    let (format, mut values) = (text(&arguments[0])?, arguments[1..].iter());
    let mut out = Vec::new();
    let mut rest = format.as_slice();
    while let Some((&byte, behind)) = rest.split_first() {
        rest = behind;
        if byte != b'%' {
            out.push(byte);
            continue;
        }
        let size = |rest: &mut &[u8]| {
            let length = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
            let (digits, behind) = rest.split_at(length);
            *rest = behind;
            std::str::from_utf8(digits).ok().and_then(|digits| digits.parse::<usize>().ok()).map(|size| size.min(MOST))
        };
        let width = size(&mut rest).unwrap_or(0);
        let mut decimals = None;
        if let Some(behind) = rest.strip_prefix(b".") {
            rest = behind;
            decimals = size(&mut rest);
        }
        let (&letter, behind) = rest.split_first()?;
        rest = behind;
        if letter == b'%' {
            out.push(b'%');
            continue;
        }
        let value = values.next()?;
        let shown = match letter.to_ascii_uppercase() {
            b'B' => if value.truth()? { "TRUE" } else { "FALSE" }.into(),
            b'C' => vec![character(value)?],
            b'D' | b'I' => half_up(value.number()?).to_string().into_bytes(),
            b'F' => format!("{:.*}", decimals.unwrap_or(6), value.number()?).into_bytes(),
            b'E' => exponential(value.number()?, decimals.unwrap_or(6)).into_bytes(),
            b'G' => Value::Real(value.number()?).text(),
            b'X' => format!("{:X}", value.whole()?).into_bytes(),
            b'S' => {
                let mut text = value.text();
                text.truncate(decimals.unwrap_or(usize::MAX));
                text
            }
            _ => return None,
        };
        out.resize(out.len() + width.saturating_sub(shown.len()), b' ');
        out.extend_from_slice(&shown);
    }
    Some(Value::Text(out))
}

/// `1.234EX-03`
fn exponential(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$e}");
    let Some((mantissa, exponent)) = text.split_once('e') else { return text };
    let (sign, digits) = exponent.strip_prefix('-').map_or(('+', exponent), |digits| ('-', digits));
    format!("{mantissa}EX{sign}{digits:0>2}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_function_of_the_table_has_a_value_or_says_why_not() {
        for row in words().rows().iter().filter(|row| row.place == WordPlace::Expression) {
            let is_evaluated = arithmetic(row.name).is_some() || textual(row.name).is_some();
            assert_eq!(is_evaluated, row.treatment == Treatment::Function, "{}", row.name);
            if is_evaluated {
                let (fewest, most) = row.counts;
                for count in [fewest, most] {
                    let found = evaluate(row.name, &vec![Value::Int(1); count]);
                    assert!(!matches!(found, Err(NoValue::Unknown | NoValue::Count(_))), "{}: {found:?}", row.name);
                }
                let found = evaluate(row.name, &vec![Value::Int(1); most + 1]);
                assert!(matches!(found, Err(NoValue::Count(_))), "{}: {found:?}", row.name);
            }
        }
    }
}
