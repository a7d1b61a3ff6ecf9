//! Gathers the words of one block before its execution: gather, check, execute.

use super::codes::{G80, Group, group_of, name_of};
use super::expression::Scope;
use super::gathered::Gathered;
use super::haas_codes;
use super::measure;
use super::measure::NEAR;
use super::origin;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::syntax::words::{Address, Value, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_dialect::{CodeEffect, Language};

/// Largest accepted value of a word.
const MAX_VALUE: f64 = 1e9;

/// Reads words of a block; assignments and names are handled elsewhere.
pub(super) fn gather(scope: &Scope<'_, '_>, words: &[Word], out: &mut Gathered) -> Result<(), Fault> {
    // The unit of the block applies to all its words.
    let mut inch = scope.channel.modal.modes.inch;
    for word in words.iter().filter(|word| word.address == Address::Letter(b'G')) {
        match word.value {
            Value::Number { value: 20.0, .. } => inch = true,
            Value::Number { value: 21.0, .. } => inch = false,
            _ => {}
        }
    }
    for word in words {
        let letter = match word.address {
            Address::Letter(letter) => letter,
            Address::Comma(letter) => letter.to_ascii_lowercase(),
            Address::Variable(_) | Address::Name(_) => continue,
            Address::Indexed(..) => {
                return Err(bad_value(word.span, "an address with an index", "this dialect has no indexed addresses"));
            }
        };
        let (value, has_point) = match word.value {
            Value::None => continue,
            Value::Number { value, has_point, .. } => (value, has_point),
            Value::Expr(id) => match grid_scope(scope, letter, inch).value(id)? {
                Some(value) => (value, true),
                // An address with an undefined variable counts as not programmed.
                None => continue,
            },
        };
        if !value.is_finite() || value.abs() > MAX_VALUE {
            return Err(bad_value(word.span, format!("{value} is too large for a word"), "check the value"));
        }
        match letter {
            b'G' => g_code(scope, value, word.span, out)?,
            b'M' => out.m_codes.push((measure::whole(value, word.span, "M")?, word.span)),
            _ => {
                if out.set_value(letter, value, has_point, word.span) {
                    double(word.span, letter)?;
                }
                if let Value::Expr(id) = word.value
                    && let Some(origin) = origin::of(&grid_scope(scope, letter, inch), id)?
                {
                    out.origins.push((letter, origin));
                }
                if matches!(word.value, Value::Number { has_point: true, .. }) {
                    out.note_point(letter);
                }
            }
        }
    }
    Ok(())
}

/// The scope of an address value: ROUND uses the increment of a Fanuc's lengths and angles.
fn grid_scope<'s, 'a>(scope: &Scope<'s, 'a>, letter: u8, inch: bool) -> Scope<'s, 'a> {
    let grid = match letter {
        _ if scope.channel.is_rs274() => None,
        b'A' | b'B' | b'C' | b'a' => Some(measure::increments_per_degree(scope.channel.settings.machine)),
        b'I'..=b'K' | b'Q' | b'R' | b'U'..=b'Z' | b'c' | b'r' => {
            Some(measure::increments_per(scope.channel.settings.machine, inch))
        }
        _ => None,
    };
    Scope { grid, ..*scope }
}

/// Handles a repeated word or group: an error, or the last one is used.
fn double(span: Span, letter: u8) -> Result<(), Fault> {
    let help = match letter {
        b'T' => "a Mazak changes the first tool and prepares the second; write the second T in the block after M6",
        _ => "remove one of them",
    };
    Err(fault(Code::DOUBLE_WORD, span, "the block already has a word of this kind", help))
}

fn g_code(scope: &Scope<'_, '_>, value: f64, span: Span, out: &mut Gathered) -> Result<(), Fault> {
    let rounded = (value * 10.0).round();
    if (value * 10.0 - rounded).abs() > NEAR || !(0.0..=9999.0).contains(&rounded) {
        return Err(bad_value(span, format!("G{value} is not a G code"), "write a G code of this control"));
    }
    let (tenths, dialect) = (rounded as u16, scope.program.dialect);
    let of_haas = haas_codes::code_of(tenths).filter(|_| dialect.language == Language::Fanuc);
    if let Some((group, code)) = of_haas.filter(|_| scope.channel.settings.machine.control.iso.is_haas()) {
        out.mirrors_zero |= group == Group::Mirror;
        if out.set_code(group, code, span).is_some_and(|old| old != code) {
            double(span, b'G')?;
        }
        return Ok(());
    }
    if let Some(entry) = dialect.codes().g_tenths(tenths.into()).filter(|entry| entry.effect == CodeEffect::Refuse) {
        let message = match of_haas {
            Some(_) => format!("G{value} is a code of Haas and not supported for controller = \"fanuc\""),
            None => format!("{} ({}) is not supported", entry.name, entry.meaning),
        };
        let help = match of_haas {
            Some(_) => {
                "if the control is a Haas, set controller = \"haas\" in the machine file; if the code calls a macro, name it in macro_codes; otherwise write these moves as G0, G1, G2 and G3"
            }
            None => haas_codes::advice(tenths).unwrap_or("write these moves as G0, G1, G2 and G3"),
        };
        return Err(fault(Code::NOT_SUPPORTED, span, message, help));
    }
    if tenths == 530 {
        out.machine_frame = Some(span);
        return Ok(());
    }
    if let Some(group) = group_of(tenths, dialect.language) {
        if group == Group::Motion && dialect.language == Language::Rs274 {
            // Of G80 and another motion code the other one is used.
            match out.code(group) {
                Some(_) if tenths == G80 => return Ok(()),
                Some(G80) => {
                    out.set_code(group, tenths, span);
                    return Ok(());
                }
                _ => {}
            }
        }
        // A repetition of the same code has no effect on a Fanuc.
        let old = out.set_code(group, tenths, span);
        if old.is_some_and(|old| old != tenths || dialect.language == Language::Rs274) {
            double(span, b'G')?;
        }
        return Ok(());
    }
    let name = name_of(tenths);
    match dialect.codes().g_tenths(usize::from(tenths)) {
        Some(entry) if entry.effect == CodeEffect::Display => Ok(()),
        Some(entry) if entry.effect == CodeEffect::Keep && entry.words == "-" => {
            out.keep.push(entry.name);
            Ok(())
        }
        Some(entry) if entry.effect == CodeEffect::Keep => {
            if out.passed.replace((tenths, entry)).is_some() {
                double(span, b'G')?;
            }
            Ok(())
        }
        Some(entry) => {
            let message = format!("{name} ({}) is not supported", entry.meaning);
            Err(fault(Code::NOT_SUPPORTED, span, message, "write these moves as G0, G1, G2 and G3"))
        }
        None => {
            let message = format!("{name} is unknown");
            let help = match homing_help(tenths) {
                Some(help) => help.to_owned(),
                None => format!(
                    "check the code, and --dialect; if the machine builder defines it, name it in the machine file: control.opaque = [\"{name}\"]"
                ),
            };
            Err(fault(Code::NOT_SUPPORTED, span, message, help))
        }
    }
}

/// Help for the codes with which TinyG and g2core home the axes or set their positions.
fn homing_help(tenths: u16) -> Option<&'static str> {
    matches!(tenths, 282..=284).then_some(
        "only TinyG and g2core home axes with this code: home the machine before the program, and omit the block",
    )
}
