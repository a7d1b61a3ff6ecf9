//! Radius compensation: G40, G41, G42 and their kin, and what a motion asks of the contour stage.

use super::channel::Channel;
use super::codes::{Group, name_of};
use super::gather::whole;
use super::gathered::Gathered;
use crate::exec::core::contour::{Shown, Side, Wish, unstated};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::path::Path;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisVector, Plane, PlaneBasis};
use ncfix_base::source::Span;
use ncfix_machine::snc::Kind;

impl Channel<'_> {
    /// G40, G41, G42, G41.1, G42.1.
    pub(super) fn compensation_codes(&mut self, gathered: &Gathered) -> Result<(), Fault> {
        self.modal.contour.leaves_along = None;
        let Some(code) = gathered.code(Group::Compensation) else {
            if !self.is_rs274() && gathered.has(b'D') {
                self.offset_number(gathered)?;
            }
            return Ok(());
        };
        let span = gathered.code_span(Group::Compensation);
        if code == 400 {
            if !self.is_rs274() && self.modal.contour.compensates() {
                self.modal.contour.leaves_along = self.leaving_direction(gathered)?;
            }
            self.modal.contour.side = Side::Off;
            return Ok(());
        }
        let side = if matches!(code, 410 | 411) { Side::Left } else { Side::Right };
        if !self.is_rs274() {
            self.offset_number(gathered)?;
            let Some(number) = self.modal.d else {
                let message = format!("{} and no D: the control takes the D of an earlier program", name_of(code));
                let help = "write the number of the offset with it, for example G41 D1";
                return Err(fault(Code::BAD_COMPENSATION, span, message, help));
            };
            self.modal.radius_mm = self.radius_of(number, span)?;
            self.modal.contour.register = Some(number);
        } else {
            if self.modal.contour.compensates() {
                let message = "radius compensation is on already";
                return Err(fault(Code::BAD_COMPENSATION, span, message, "program G40 first"));
            }
            if self.modal.plane == Plane::YZ {
                let message = "radius compensation in G19";
                return Err(fault(Code::BAD_COMPENSATION, span, message, "select G17 or G18"));
            }
            self.modal.contour.register = None;
            self.modal.radius_mm = match code {
                411 | 421 => match self.length(gathered, b'D')? {
                    Some(diameter) => diameter / 2.0,
                    None => {
                        let message = format!("{} needs D with the diameter", name_of(code));
                        return Err(bad_value(span, message, "write for example G41.1 D6"));
                    }
                },
                _ => {
                    let number = match gathered.raw(b'D') {
                        Some(value) => whole(value, gathered.span_of(b'D'), "D")?,
                        None if self.modal.active.is_none() && self.strict => {
                            let message =
                                format!("{} and no tool: the radius is that of an earlier program", name_of(code));
                            return Err(fault(
                                Code::BAD_COMPENSATION,
                                span,
                                message,
                                "program T and M6, or D, before it",
                            ));
                        }
                        None => self.modal.active.unwrap_or(0),
                    };
                    self.modal.d = Some(number);
                    self.modal.contour.register = Some(number);
                    self.radius_of(number, span)?
                }
            };
            if gathered.raw(b'L').is_some_and(|value| value != 0.0) {
                let message = "the orientation of a lathe tool (L) is not supported";
                return Err(fault(Code::NOT_SUPPORTED, gathered.span_of(b'L'), message, "take L out"));
            }
        }
        self.modal.contour.side = side;
        self.modal.contour.activation = self.modal.contour.activation.wrapping_add(1);
        Ok(())
    }

    /// G40 with I, J, K in the plane: where the contour seems to lead behind its end, in the plane as the frame places it.
    fn leaving_direction(&mut self, gathered: &Gathered) -> Result<Option<[f64; 2]>, Fault> {
        let [abscissa, ordinate, _] = self.modal.plane.axes();
        let letters = [abscissa, ordinate].map(|axis| b"IJK"[axis.slot()]);
        let is_straight = matches!(self.motion_of(gathered), Some(0 | 10));
        if !is_straight || !gathered.has_any(&letters) {
            return Ok(None);
        }
        let mut direction = AxisVector::ZERO;
        for (axis, letter) in [abscissa, ordinate].into_iter().zip(letters) {
            direction[axis] = self.length(gathered, letter)?.unwrap_or_default();
        }
        let frame = &self.setup.frame;
        let turned = frame.apply_direction(direction.xyz());
        direction.set_xyz(turned);
        let basis = PlaneBasis::behind(frame, self.modal.plane);
        Ok(basis.map(|basis| basis.flat(&direction)).filter(|[x, y]| x.hypot(*y) > 0.0))
    }

    /// D of a Fanuc.
    fn offset_number(&mut self, gathered: &Gathered) -> Result<(), Fault> {
        if let Some(value) = gathered.raw(b'D') {
            let number = whole(value, gathered.span_of(b'D'), "D")?;
            self.modal.d = Some(number);
            if self.modal.contour.compensates() {
                self.modal.radius_mm = self.radius_of(number, gathered.span_of(b'D'))?;
                self.modal.contour.register = Some(number);
            }
        }
        Ok(())
    }

    /// The radius of an offset number, mm.
    fn radius_of(&mut self, number: u32, span: Span) -> Result<f64, Fault> {
        if number == 0 {
            return Ok(0.0);
        }
        if let Some(offset) = self.tool_offset(number) {
            return Ok(self.radius.of(offset.radius_mm + offset.radius_wear_mm, offset.radius_wear_mm));
        }
        let message = format!("offset {number} has no radius in the machine file");
        let help = "add a [[tool]] entry of this number there or in a file given with --setup";
        if self.strict {
            return Err(fault(Code::NO_TOOL, span, message, help));
        }
        self.outlet.warnings.push(fault(Code::TOOL_ASSUMED, span, format!("{message}; 0 is used"), help));
        Ok(0.0)
    }

    /// Refuses what does not go together with radius compensation.
    pub(super) fn no_compensation(&self, span: Span, what: &str) -> Result<(), Fault> {
        if !self.modal.contour.compensates() || !self.is_rs274() {
            return Ok(());
        }
        let message = format!("{what} while radius compensation is on");
        Err(fault(Code::BAD_COMPENSATION, span, message, "program G40 and a motion before it"))
    }

    /// Puts a motion into the stream, through the contour stage where it must.
    #[inline]
    pub(super) fn pass(&mut self, path: Path) {
        let mut modal = self.modal.contour;
        let corner = self.corner.take();
        if corner.is_none() && modal.is_plain() && !self.outlet.is_holding() {
            self.outlet.pass_plain(&path);
            return;
        }
        if self.outlet.keeps_wear && modal.compensates() {
            modal.shown = Shown::of(&path.basis, &self.shown.frame, self.modal.plane);
        }
        let file = self.outlet.file();
        let wish = Wish { corner, ..Wish::of(modal, self.modal.radius_mm, path.span, file) };
        if self.strict {
            self.outlet.warnings.extend(unstated(&path, &wish, self.modal.plane));
        }
        let (number, tool) = (modal.register, self.modal.active);
        self.outlet.name_register(&wish, || match (number, tool) {
            (Some(number), Some(tool)) if tool != number => format!("D{number} (T{tool})"),
            (Some(number), _) => format!("D{number}"),
            (None, _) => "the tool".to_owned(),
        });
        let element = self.outlet.element(Kind::Empty);
        self.outlet.pass_path(path, element, wish);
    }
}
