//! Radius compensation: G40, G41, G42 and related codes, and requests of a motion to the contour stage.

use super::channel::Channel;
use super::channel::WrittenData;
use super::codes::{Group, name_of};
use super::gathered::Gathered;
use super::measure;
use super::measure::whole;
use super::modes;
use crate::exec::core::contour::{ContourRequest, Shown, Side};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::path::Path;
use crate::exec::core::settings::RunSettings;
use crate::exec::core::tool::without_value;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisVector, Plane, PlaneBasis};
use ncfix_base::source::Span;
use ncfix_machine::snc::Kind;

/// G40, G41, G42, G41.1, G42.1.
pub(super) fn compensation_codes(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    channel.modal.contour.leaves_along = None;
    let Some(code) = gathered.code(Group::Compensation) else {
        if !channel.is_rs274() && gathered.has(b'D') {
            offset_number(channel, gathered)?;
        }
        return Ok(());
    };
    let span = gathered.code_span(Group::Compensation);
    if code == 400 {
        if !channel.is_rs274() && channel.modal.contour.compensates() {
            channel.modal.contour.leaves_along = leaving_direction(channel, gathered)?;
        } else if !channel.is_rs274() {
            // D stays in force for the next G41 or G42.
            offset_number(channel, gathered)?;
        }
        channel.modal.contour.side = Side::Off;
        return Ok(());
    }
    let side = if matches!(code, 410 | 411) { Side::Left } else { Side::Right };
    if !channel.is_rs274() {
        offset_number(channel, gathered)?;
        let Some(number) = channel.modal.d else {
            let message = format!("{} without D: the control would use the D of an earlier program", name_of(code));
            let help = if gathered.has(b'H') {
                "write the number of the offset with D, for example G41 D1: ncfix takes H for a tool length only (parameter 5001, bit 2: H may be a radius)"
            } else {
                "write the number of the offset with it, for example G41 D1"
            };
            return Err(fault(Code::BAD_COMPENSATION, span, message, help));
        };
        channel.modal.tool.radius_mm =
            radius_of(&channel.settings, &channel.written, &mut channel.outlet, number, span)?;
        channel.modal.contour.register = Some(number);
    } else {
        if channel.modal.contour.compensates() {
            let message = "radius compensation is on already";
            return Err(fault(Code::BAD_COMPENSATION, span, message, "program G40 first"));
        }
        if channel.modal.modes.plane == Plane::YZ {
            let message = "radius compensation in G19";
            return Err(fault(Code::BAD_COMPENSATION, span, message, "select G17 or G18"));
        }
        channel.modal.contour.register = None;
        channel.modal.tool.radius_mm = match code {
            411 | 421 => match measure::length(channel, gathered, b'D')? {
                Some(diameter) => diameter / 2.0,
                None => {
                    let message = format!("{} needs D with the diameter", name_of(code));
                    return Err(bad_value(span, message, "write for example G41.1 D6"));
                }
            },
            _ => {
                let number = match gathered.raw(b'D') {
                    Some(value) => whole(value, gathered.span_of(b'D'), "D")?,
                    None if channel.modal.tool.active.is_none() && channel.settings.strict => {
                        let message =
                            format!("{} without a tool: the radius would be that of an earlier program", name_of(code));
                        return Err(fault(Code::BAD_COMPENSATION, span, message, "program T and M6, or D, before it"));
                    }
                    None => channel.modal.tool.active.unwrap_or(0),
                };
                channel.modal.d = Some(number);
                channel.modal.contour.register = Some(number);
                radius_of(&channel.settings, &channel.written, &mut channel.outlet, number, span)?
            }
        };
        if gathered.raw(b'L').is_some_and(|value| value != 0.0) {
            let message = "the orientation of a lathe tool (L) is not supported";
            return Err(fault(Code::NOT_SUPPORTED, gathered.span_of(b'L'), message, "remove L"));
        }
    }
    channel.modal.contour.side = side;
    channel.modal.contour.activation = channel.modal.contour.activation.wrapping_add(1);
    Ok(())
}

/// G40 with I, J, K in the plane: the direction in which the contour virtually continues after its end, in the plane as placed by the frame.
fn leaving_direction(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<Option<[f64; 2]>, Fault> {
    let [abscissa, ordinate, _] = channel.modal.modes.plane.axes();
    let letters = [abscissa, ordinate].map(|axis| b"IJK"[axis.slot()]);
    let is_straight =
        matches!(modes::motion_of(channel.language, &channel.modal, &channel.cycles, gathered), Some(0 | 10));
    if !is_straight || !gathered.has_any(&letters) {
        return Ok(None);
    }
    let mut direction = AxisVector::ZERO;
    for (axis, letter) in [abscissa, ordinate].into_iter().zip(letters) {
        direction[axis] = measure::length(channel, gathered, letter)?.unwrap_or_default();
    }
    let frame = &channel.standing.setup.frame;
    let turned = frame.apply_direction(direction.xyz());
    direction.set_xyz(turned);
    let basis = PlaneBasis::behind(frame, channel.modal.modes.plane);
    Ok(basis.map(|basis| basis.flat(&direction)).filter(|[x, y]| x.hypot(*y) > 0.0))
}

/// Handles D of a Fanuc.
fn offset_number(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    if let Some(value) = gathered.raw(b'D') {
        let number = whole(value, gathered.span_of(b'D'), "D")?;
        channel.modal.d = Some(number);
        if channel.modal.contour.compensates() {
            channel.modal.tool.radius_mm =
                radius_of(&channel.settings, &channel.written, &mut channel.outlet, number, gathered.span_of(b'D'))?;
            channel.modal.contour.register = Some(number);
        }
    }
    Ok(())
}

/// The radius of an offset number, mm.
pub(super) fn radius_of(
    settings: &RunSettings<'_>,
    written: &WrittenData,
    outlet: &mut MotionSink<'_>,
    number: u32,
    span: Span,
) -> Result<f64, Fault> {
    if number == 0 {
        return Ok(0.0);
    }
    if let Some(size) = written.tools.size(settings.machine, number, 1) {
        return Ok(size.compensated_mm(settings.radius));
    }
    let message = format!("offset {number} has no radius in the machine file");
    let help = "add a [[tool]] entry of this number there or in a file given with --setup";
    without_value(settings.requires_values, &mut outlet.warnings, span, &message, "0", help)?;
    Ok(0.0)
}

/// Emits a motion, through the contour stage if required.
#[inline]
pub(super) fn pass(channel: &mut Channel<'_>, path: Path) {
    let mut modal = channel.modal.contour;
    let corner = channel.block.corner.take();
    if corner.is_none() && modal.is_plain() && !channel.outlet.is_holding() {
        channel.outlet.pass_plain(&path);
        return;
    }
    if channel.outlet.keeps_wear && modal.compensates() {
        modal.shown = Shown::of(&path.basis, &channel.standing.shown.frame, channel.modal.modes.plane);
    }
    let file = channel.outlet.file();
    let wish = ContourRequest { corner, ..ContourRequest::of(modal, channel.modal.tool.radius_mm, path.span, file) };
    if channel.settings.strict {
        channel.outlet.check_stated(&path, &wish, channel.modal.modes.plane);
    }
    let (number, tool) = (modal.register, channel.modal.tool.active);
    channel.outlet.name_register(&wish, || match (number, tool) {
        (Some(number), Some(tool)) if tool != number => format!("D{number} (T{tool})"),
        (Some(number), _) => format!("D{number}"),
        (None, _) => "the tool".to_owned(),
    });
    let element = channel.outlet.element(Kind::Empty);
    channel.outlet.pass_path(path, element, wish);
}
