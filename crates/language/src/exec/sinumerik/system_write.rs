//! System variables that a program writes: frames and tools take effect, other values are stored for later reads; all are passed through.

use super::channel::Channel;
use super::frame_store::FrameName;
use super::frame_value::{Component, component_words, frame_text};
use super::level::Loaded;
use super::scope::scope_of;
use super::setup;
use super::system::tool_parameter;
use super::value::Value;
use super::variables::List;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::ArgumentRange;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;
use ncfix_base::source::Span;
use ncfix_machine::snc::Kind;

/// `$TC_DP6`.
const RADIUS: usize = 6;

/// The machine's own compensation: with other values the error model would not match the machine.
const COMPENSATION: &[&str] = &[
    "$AN_CEC",
    "$AA_ENC_COMP",
    "$AA_QEC",
    "$SN_CEC",
    "$MA_CEC",
    "$MN_MM_CEC",
    "$MA_ENC_COMP",
    "$MA_BACKLASH",
    "$MA_COMP",
];

/// Beginnings of variables, without `$`, that shift axes beside the program: overlaid motion, online tool offset, DRF, external zero offset, position
/// offset of the operator.
pub(super) const OVERLAID: &[&str] = &["AA_OFF", "AA_TOFF", "AN_ETC", "AC_TOFF", "AA_ETRANS", "AC_DRF", "AC_PRESET"];

/// The left side of an assignment to a system variable.
#[derive(Clone, Copy)]
pub(super) struct SystemName<'n> {
    pub(super) name: &'n str,
    pub(super) range: Option<ArgumentRange>,
    pub(super) span: Span,
    /// The words after the old value, if the program adds to it: `+5`, `:CTRANS(X,5)`.
    pub(super) step: Option<&'n str>,
}

/// Assigns to a system variable.
pub(super) fn assign_system(
    loaded: &Loaded,
    channel: &mut Channel<'_>,
    target: SystemName<'_>,
    list: List,
) -> Result<(), Fault> {
    let SystemName { name, span, .. } = target;
    if COMPENSATION.iter().any(|known| name.starts_with(known)) {
        let message = format!("{name} is the machine's own compensation, and the program changes it");
        let help = "load it on the machine first, and give ncfix the residual error model";
        return Err(fault(Code::OWN_COMPENSATION, span, message, help));
    }
    let is_overlaid = name.strip_prefix('$').is_some_and(|name| OVERLAID.iter().any(|known| name.starts_with(known)));
    // A value of zero shifts nothing; the limit of the overlaid motion neither.
    let is_zero = matches!(&list, List::One(value) | List::Repeat(value, _) if value.number() == Some(0.0));
    if is_overlaid && !is_zero && !name.ends_with("_LIMIT") {
        let message = format!("{name} shifts an axis beside the program, and the correction does not know this shift");
        let help = "program the shift in the coordinates: TRANS, a zero offset, or the tool length";
        return Err(fault(Code::NOT_SUPPORTED, span, message, help));
    }
    let values = match list {
        List::One(value) => vec![Some(value)],
        List::Set(values) => values,
        List::Repeat(value, Some(count @ 0..=1000)) => vec![Some(value); usize::try_from(count).unwrap_or(0)],
        List::Repeat(..) => {
            let message = "REP needs the number of values of a system variable";
            return Err(fault(Code::BAD_EXPRESSION, span, message, "write REP(value,number)"));
        }
    };
    for (offset, value) in (0..).zip(values) {
        if let Some(value) = value {
            assign_one(loaded, channel, target, offset, value)?;
        }
    }
    Ok(())
}

fn assign_one(
    loaded: &Loaded,
    channel: &mut Channel<'_>,
    SystemName { name, range, span, step }: SystemName<'_>,
    offset: i64,
    value: Value,
) -> Result<(), Fault> {
    let scope = scope_of(loaded, channel);
    if let Some(frame) = scope.frame_name(name, range, span)? {
        let component = range.map(|range| scope.component(range)).transpose()?.flatten();
        return assign_frame(loaded, channel, frame, component, value, (span, step));
    }
    let (mut key, mut indices) = scope.key(name, range)?;
    if offset > 0
        && let Some(Value::Int(last)) = indices.last_mut()
    {
        *last = last.saturating_add(offset);
        let shown: Vec<String> =
            indices.iter().map(|value| String::from_utf8_lossy(&value.text()).into_owned()).collect();
        key = format!("{name}[{}]", shown.join(","));
    }
    if let Some((parameter, tool, edge)) = tool_parameter(name, &indices) {
        let Some(number) = value.number() else { return Err(needs_number(&key, span)) };
        let machine = channel.settings.machine;
        if parameter == RADIUS {
            channel.outlet.check_radius(&format!("T{tool} D{edge}"), number, span)?;
        }
        if !channel.system.tools.set_parameter(machine, parameter, tool, edge, number) {
            return Err(fault(
                Code::BAD_INDEX,
                span,
                format!("there is no {key}"),
                "tool parameters are $TC_DP1 to $TC_DP35",
            ));
        }
    } else if name == "$TC_TP2"
        && let Some(tool) = indices.first().and_then(Value::whole).and_then(|tool| u32::try_from(tool).ok())
    {
        channel.system.tools.set_name(tool, String::from_utf8_lossy(&value.text()).into_owned());
    } else if name == "$R"
        && let Some(index) = indices.first().and_then(Value::whole)
    {
        let number = value.number().ok_or_else(|| needs_number(&key, span))?;
        return channel.variables.set_parameter(index, number, span);
    } else if !channel.system.set(key.clone(), value.clone()) {
        return Err(fault(Code::BAD_INDEX, span, "the program writes too many system variables", "write fewer"));
    }
    let mut text = format!("{key}=").into_bytes();
    match step {
        Some(step) => text.extend(format!("{key}{step}").into_bytes()),
        None => text.extend(written(&value)),
    }
    channel.push(Kind::Verbatim(text));
    Ok(())
}

fn needs_number(key: &str, span: Span) -> Fault {
    fault(Code::TYPE_MISMATCH, span, format!("{key} holds a number"), "assign a number")
}

/// Sets a frame of the control, or a component of it.
fn assign_frame(
    loaded: &Loaded,
    channel: &mut Channel<'_>,
    name: FrameName,
    component: Option<(Axis, Component, usize)>,
    value: Value,
    (span, step): (Span, Option<&str>),
) -> Result<(), Fault> {
    let scope = scope_of(loaded, channel);
    let order = setup::rotation_order(channel.settings.machine);
    let mut component_text = None;
    let parts = match (component, value) {
        (None, Value::Frame(parts)) => *parts,
        (Some((axis, component, _)), value) => {
            let mut parts = scope.frame(name, span)?;
            let number = value.number().ok_or_else(|| needs_number("a component of a frame", span))?;
            scope.set_component(&mut parts, axis, component, number, span)?;
            component_text = Some(component_words(&parts, axis, component));
            parts
        }
        (None, _) => {
            return Err(fault(
                Code::TYPE_MISMATCH,
                span,
                "this is a frame",
                "assign CTRANS(…), CROT(…) or a FRAME variable",
            ));
        }
    };
    let frame = parts
        .frame(order)
        .ok_or_else(|| fault(Code::NOT_COMPUTABLE, span, "this frame cannot be undone", "scale by factors above 0"))?;
    let is_stored = matches!(name, FrameName::Settable(_) | FrameName::StoredBase(_));
    if channel.modal.swivelled.is_some() && !is_stored {
        let message = "a frame is assigned in a plane that CYCLE800 has tilted";
        return Err(fault(Code::BAD_SWIVEL, span, message, "end the tilted plane with CYCLE800() first"));
    }
    let origin = channel.outlet.origin;
    let frames = &mut channel.system.frames;
    let shown = match name {
        FrameName::Settable(number) => {
            if step.is_some() {
                frames.grow(number, origin);
            }
            frames.set_settable(number, parts);
            format!("$P_UIFR[{number}]")
        }
        FrameName::StoredBase(number) => {
            frames.set_stored_base(number, parts);
            base_name("$P_NCBFR", "$P_CHBFR", number)
        }
        FrameName::Base(number) => {
            frames.set_base(number, parts);
            channel.modal.base = frames.base(order).unwrap_or(channel.modal.base);
            base_name("$P_NCBFRAME", "$P_CHBFRAME", number)
        }
        FrameName::ActiveSettable => {
            channel.modal.settable = frame;
            let name = channel.modal.stated.offset().to_owned();
            channel.modal.written_zero = frames.zeros.entry(channel.settings.machine.zero_offsets.len(), &name, &parts);
            channel.modal.zero = channel.modal.written_zero.as_ref().map(|written| written.index);
            channel.modal.offset_assumed = false;
            "$P_IFRAME".to_owned()
        }
        FrameName::Programmable => {
            channel.modal.programmable = frame;
            channel.modal.fine = parts.fine;
            "$P_PFRAME".to_owned()
        }
        FrameName::AllBases | FrameName::All => {
            let message = "the sum of all frames is read-only";
            return Err(fault(Code::BAD_WORD_VALUE, span, message, "assign one of its frames, such as $P_PFRAME"));
        }
        FrameName::System if parts.is_identity() => return Ok(()),
        FrameName::System => {
            let message = "system frames that change positions are not supported yet";
            return Err(fault(Code::NOT_SUPPORTED, span, message, "put the shift into a base or settable frame"));
        }
    };
    let mut text = format!("{shown}={}", frame_text(&parts));
    match name {
        FrameName::ActiveSettable => channel.modal.stated.assign_settable(&text),
        FrameName::Programmable => channel.modal.stated.assign_programmable(&text),
        _ => {}
    }
    // The other components may come from the machine file: written too, they would replace those of the control.
    if let Some((index, value)) = component_text.filter(|_| name != FrameName::Programmable) {
        let shown = match shown.strip_suffix(']') {
            Some(shown) => format!("{shown},{index}]"),
            None => format!("{shown}[{index}]"),
        };
        text = match step {
            Some(step) => format!("{shown}={shown}{step}"),
            None => format!("{shown}={value}"),
        };
    } else if let Some(step) = step
        && matches!(name, FrameName::Settable(_) | FrameName::StoredBase(_))
    {
        text = format!("{shown}={shown}{step}");
    }
    setup::refresh_setup(&mut channel.modal, &mut channel.standing, &mut channel.outlet);
    channel.push(Kind::Verbatim(text.into_bytes()));
    Ok(())
}

/// The name of a base frame: numbers continue from those of the control to those of the channel.
fn base_name(of_control: &str, of_channel: &str, number: i64) -> String {
    match number - super::frame_store::BASES {
        index @ 0.. => format!("{of_channel}[{index}]"),
        _ => format!("{of_control}[{number}]"),
    }
}

/// A value in the notation of the language.
fn written(value: &Value) -> Vec<u8> {
    match value {
        Value::Text(text) => [b"\"", text.as_slice(), b"\""].concat(),
        Value::Bool(true) => b"TRUE".to_vec(),
        Value::Bool(false) => b"FALSE".to_vec(),
        Value::Char(code) => code.to_string().into_bytes(),
        Value::Frame(parts) => frame_text(parts).into_bytes(),
        other => other.text(),
    }
}
