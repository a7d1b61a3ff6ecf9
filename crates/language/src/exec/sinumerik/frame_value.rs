//! Frames as values: their functions, components, and text form.

use super::expression::Scope;
use super::frame_store;
use super::frame_store::BASES;
use super::frame_store::FrameName;
use super::frame_store::frame_of;
use super::value::Value;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::{ArgumentRange, ExprId, Node};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Frame;
use ncfix_base::geometry::{AXES, Axis, AxisSet, AxisVector, FrameParts, Plane, RotationOrder};
use ncfix_base::source::Span;
use ncfix_base::units::MM_PER_INCH;
use ncfix_machine::snc::{FrameKind, FrameStatement};

/// A component of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    Translation,
    Fine,
    Rotation,
    Scale,
    Mirror,
}

impl Component {
    fn of(name: &str) -> Option<Component> {
        Some(match name {
            "TR" => Component::Translation,
            "FI" => Component::Fine,
            "RT" => Component::Rotation,
            "SC" => Component::Scale,
            "MI" => Component::Mirror,
            _ => return None,
        })
    }

    /// Its name in an index.
    fn word(self) -> &'static str {
        match self {
            Component::Translation => "TR",
            Component::Fine => "FI",
            Component::Rotation => "RT",
            Component::Scale => "SC",
            Component::Mirror => "MI",
        }
    }
}

/// Values are rounded to this many parts of a mm or degree: far finer than any increment, without rounding noise.
const PARTS: f64 = 1e9;
/// Help for a value that does not form a frame.
const HELP: &str = "shift any axis; rotate, scale and mirror only X, Y or Z; scale by factors above 0";

impl Scope<'_> {
    /// The order of rotation angles.
    pub(super) fn order(&self) -> RotationOrder {
        self.machine.control.rotation_order
    }

    /// mm per length in frame values. Under G70 the unit is ambiguous, so only 0 is accepted.
    fn frame_unit(&self, value: f64, span: Span) -> Result<f64, Fault> {
        match (self.modal.modes.inch, self.modal.inch_feed) {
            (false, _) => Ok(1.0),
            (true, true) => Ok(MM_PER_INCH),
            (true, false) if value == 0.0 => Ok(1.0),
            (true, false) => Err(fault(
                Code::UNITS_DOUBT,
                span,
                "whether this length is inch or mm under G70 depends on the control",
                "state the unit before it with G700, G71 or G710",
            )),
        }
    }

    /// The value of a function that returns a frame.
    pub(super) fn frame_function(&self, name: &str, arguments: &[Value], id: ExprId) -> Result<Value, Fault> {
        let span = self.program.expr(id).span;
        let wrong = |message: String| fault(Code::BAD_EXPRESSION, span, message, HELP);
        let frame = |parts: FrameParts| Ok(Value::Frame(Box::new(parts)));
        let mut parts = FrameParts::default();
        match (name, arguments) {
            ("CRPL", [plane, angle]) => {
                let (Some(plane), Some(angle)) = (plane.whole(), angle.number()) else {
                    return Err(self.type_fault(id));
                };
                let about = match plane {
                    0 => self.modal.modes.plane.axes()[2],
                    1 => Axis::Z,
                    2 => Axis::Y,
                    3 => Axis::X,
                    _ => return Err(wrong(format!("CRPL takes the planes 0 to 3, not {plane}"))),
                };
                parts.rotation[about.slot()] = angle.to_radians();
                frame(parts)
            }
            ("CMIRROR", axes) => {
                // A number in the place of an axis is invalid.
                for value in axes.iter().filter(|value| value.number().is_none()) {
                    let axis = self.axis_in(value, id)?;
                    self.set_component(&mut parts, axis, Component::Mirror, 1.0, span)?;
                }
                frame(parts)
            }
            ("CTRANS" | "CFINE" | "CROT" | "CSCALE", pairs) => {
                let component = match name {
                    "CTRANS" => Component::Translation,
                    "CFINE" => Component::Fine,
                    "CROT" => Component::Rotation,
                    _ => Component::Scale,
                };
                for pair in pairs.chunks(2) {
                    let [axis, value] = pair else {
                        return Err(wrong(format!("{name} takes alternating axes and values")));
                    };
                    let axis = self.axis_in(axis, id)?;
                    let value = value.number().ok_or_else(|| self.type_fault(id))?;
                    self.set_component(&mut parts, axis, component, value, span)?;
                }
                frame(parts)
            }
            ("CROTS", pairs) => {
                let mut values = AxisVector::ZERO;
                let mut named = AxisSet::EMPTY;
                for pair in pairs.chunks(2) {
                    let [axis, value] = pair else {
                        return Err(wrong("CROTS takes alternating axes and angles".to_owned()));
                    };
                    let axis = self.axis_in(axis, id)?;
                    values[axis] = value.number().ok_or_else(|| self.type_fault(id))?.to_radians();
                    named.insert(axis);
                }
                let kind = FrameKind::SolidAngles;
                let statement = FrameStatement { kind, additive: false, values, named, in_plane_rad: None };
                let turned = frame_of(&statement, self.modal.modes.plane, &self.machine.control);
                match turned.and_then(|turned| FrameParts::of(&turned, self.order())) {
                    Some(parts) => frame(parts),
                    None => Err(wrong("these solid angles do not define a plane".to_owned())),
                }
            }
            ("INVFRAME", [Value::Frame(given)]) => match given.inverse(self.order()) {
                Some(inverse) => frame(inverse),
                None => Err(fault(Code::NOT_COMPUTABLE, span, "this frame has no inverse with these components", HELP)),
            },
            _ => Err(fault(
                Code::NOT_SUPPORTED,
                span,
                format!("function {name}( ) is not supported here"),
                "build the frame from CTRANS, CFINE, CROT, CRPL, CSCALE and CMIRROR",
            )),
        }
    }

    /// `outer : inner`
    pub(super) fn chain(&self, outer: &FrameParts, inner: &FrameParts, span: Span) -> Result<Value, Fault> {
        match outer.chain(inner, self.order()) {
            Some(chain) => Ok(Value::Frame(Box::new(chain))),
            None => Err(fault(
                Code::NOT_COMPUTABLE,
                span,
                "this chain has no components: it rotates inside unequal scale factors",
                "scale all axes equally, or rotate before scaling",
            )),
        }
    }

    /// Axis and component at the end of an index, `X,TR`, and the number of indices before them.
    pub(super) fn component(&self, range: ArgumentRange) -> Result<Option<(Axis, Component, usize)>, Fault> {
        let [front @ .., Some(axis), Some(last)] = self.program.arguments_of(range) else { return Ok(None) };
        let Node::Name(name) = self.program.expr(*last).node else { return Ok(None) };
        let Some(component) = Component::of(self.program.names.text(name)) else { return Ok(None) };
        Ok(Some((self.axis(*axis)?, component, front.len())))
    }

    /// A component in the unit of the program.
    pub(super) fn get_component(
        &self,
        parts: &FrameParts,
        axis: Axis,
        component: Component,
        span: Span,
    ) -> Result<Value, Fault> {
        let length = |value: f64| -> Result<f64, Fault> {
            if axis.is_rotary() { Ok(value.to_degrees()) } else { Ok(value / self.frame_unit(value, span)?) }
        };
        let of_space = |value: Option<f64>| value.ok_or_else(|| fault(Code::BAD_INDEX, span, not_of_space(axis), HELP));
        Ok(match component {
            Component::Translation => Value::Real(length(parts.translation[axis])?),
            Component::Fine => Value::Real(length(parts.fine[axis])?),
            Component::Rotation => {
                Value::Real(of_space(parts.rotation.get(axis.slot()).map(|angle| angle.to_degrees()))?)
            }
            Component::Scale => Value::Real(of_space(parts.scale.get(axis.slot()).copied())?),
            Component::Mirror => {
                let mirror = parts.mirror.get(axis.slot()).map(|&mirror| f64::from(u8::from(mirror)));
                Value::Bool(of_space(mirror)? != 0.0)
            }
        })
    }

    /// Sets a component, given in the unit of the program.
    pub(super) fn set_component(
        &self,
        parts: &mut FrameParts,
        axis: Axis,
        component: Component,
        value: f64,
        span: Span,
    ) -> Result<(), Fault> {
        let unit = if axis.is_rotary() { 1_f64.to_radians() } else { 1.0 };
        let missing = || fault(Code::BAD_INDEX, span, not_of_space(axis), HELP);
        match component {
            Component::Translation | Component::Fine => {
                let unit = if axis.is_rotary() { unit } else { self.frame_unit(value, span)? };
                let place = if component == Component::Fine { &mut parts.fine } else { &mut parts.translation };
                place[axis] = value * unit;
            }
            Component::Rotation => {
                *parts.rotation.get_mut(axis.slot()).ok_or_else(missing)? = value.to_radians();
            }
            Component::Scale => {
                let place = parts.scale.get_mut(axis.slot()).ok_or_else(missing)?;
                if value.is_nan() || value <= 0.0 {
                    return Err(fault(
                        Code::BAD_WORD_VALUE,
                        span,
                        format!("{value} is not a valid scale factor"),
                        HELP,
                    ));
                }
                *place = value;
            }
            Component::Mirror => *parts.mirror.get_mut(axis.slot()).ok_or_else(missing)? = value != 0.0,
        }
        Ok(())
    }
}

fn not_of_space(axis: Axis) -> String {
    format!("{axis} can be shifted, but not rotated, scaled or mirrored")
}

/// The frame as an expression of the language, in mm and degrees: `CTRANS(X,100):CROT(Z,90)`.
pub(super) fn frame_text(parts: &FrameParts) -> String {
    let listed = |name: &str, pairs: Vec<String>| (!pairs.is_empty()).then(|| format!("{name}({})", pairs.join(",")));
    let shift = |name: &str, values: &AxisVector| {
        let shown = |axis: Axis| if axis.is_rotary() { values[axis].to_degrees() } else { values[axis] };
        let pairs = AXES.into_iter().filter(|&axis| values[axis] != 0.0).map(|axis| pair(axis, shown(axis)));
        listed(name, pairs.collect())
    };
    let space = || [Axis::X, Axis::Y, Axis::Z].into_iter();
    let turned = space().filter(|axis| parts.rotation[axis.slot()] != 0.0);
    let scaled = space().filter(|axis| parts.scale[axis.slot()] != 1.0);
    let mirrored = space().filter(|axis| parts.mirror[axis.slot()]);
    let terms = [
        shift("CTRANS", &parts.translation),
        shift("CFINE", &parts.fine),
        listed("CROT", turned.map(|axis| pair(axis, parts.rotation[axis.slot()].to_degrees())).collect()),
        listed("CSCALE", scaled.map(|axis| pair(axis, parts.scale[axis.slot()])).collect()),
        listed("CMIRROR", mirrored.map(|axis| axis.to_string()).collect()),
    ];
    let terms: Vec<String> = terms.into_iter().flatten().collect();
    if terms.is_empty() { "CTRANS(X,0)".to_owned() } else { terms.join(":") }
}

fn pair(axis: Axis, value: f64) -> String {
    format!("{axis},{}", rounded(value))
}

fn rounded(value: f64) -> f64 {
    (value * PARTS).round() / PARTS
}

/// The index of a component and its value, in mm and degrees: `X,TR` and `100`.
pub(super) fn component_words(parts: &FrameParts, axis: Axis, component: Component) -> (String, f64) {
    let shift = |values: &AxisVector| if axis.is_rotary() { values[axis].to_degrees() } else { values[axis] };
    let of_space = |values: [f64; 3]| values.get(axis.slot()).copied().unwrap_or_default();
    let value = match component {
        Component::Translation => shift(&parts.translation),
        Component::Fine => shift(&parts.fine),
        Component::Rotation => of_space(parts.rotation).to_degrees(),
        Component::Scale => of_space(parts.scale),
        Component::Mirror => f64::from(u8::from(parts.mirror.get(axis.slot()).copied().unwrap_or_default())),
    };
    (format!("{axis},{}", component.word()), rounded(value))
}

/// The plane's axes in the order of `$P_AXN1` to `$P_AXN3`.
pub(super) fn plane_axis(plane: Plane, number: usize) -> Option<Axis> {
    number.checked_sub(1).and_then(|index| plane.axes().get(index).copied())
}

/// Settable frames: G500, G54 to G57, G505 to G599.
const SETTABLE: i64 = 100;

/// A name, the number of its indices, and the frame for an index.
type Row = (&'static str, i64, fn(i64) -> FrameName);

const NAMES: &[Row] = &[
    ("$P_UIFR", SETTABLE, FrameName::Settable),
    ("$P_NCBFR", BASES, FrameName::StoredBase),
    ("$P_CHBFR", BASES, |number| FrameName::StoredBase(number + BASES)),
    ("$P_UBFR", 0, |_| FrameName::StoredBase(BASES)),
    ("$P_NCBFRAME", BASES, FrameName::Base),
    ("$P_CHBFRAME", BASES, |number| FrameName::Base(number + BASES)),
    ("$P_BFRAME", 0, |_| FrameName::Base(BASES)),
    ("$P_IFRAME", 0, |_| FrameName::ActiveSettable),
    ("$P_PFRAME", 0, |_| FrameName::Programmable),
    ("$P_ACTBFRAME", 0, |_| FrameName::AllBases),
    ("$P_ACTFRAME", 0, |_| FrameName::All),
    ("$P_PARTFRAME", 0, |_| FrameName::System),
    ("$P_SETFRAME", 0, |_| FrameName::System),
    ("$P_EXTFRAME", 0, |_| FrameName::System),
    ("$P_TOOLFRAME", 0, |_| FrameName::System),
    ("$P_WPFRAME", 0, |_| FrameName::System),
    ("$P_TRAFRAME", 0, |_| FrameName::System),
    ("$P_CYCFRAME", 0, |_| FrameName::System),
    ("$P_PARTFR", 0, |_| FrameName::System),
    ("$P_SETFR", 0, |_| FrameName::System),
    ("$P_EXTFR", 0, |_| FrameName::System),
    ("$P_TOOLFR", 0, |_| FrameName::System),
    ("$P_WPFR", 0, |_| FrameName::System),
    ("$P_TRAFR", 0, |_| FrameName::System),
    ("$P_CYCFR", 0, |_| FrameName::System),
];

impl Scope<'_> {
    /// The frame of the control for a name and its indices; `None` if it is not a frame.
    pub(super) fn frame_name(
        &self,
        name: &str,
        range: Option<ArgumentRange>,
        span: Span,
    ) -> Result<Option<FrameName>, Fault> {
        let Some(&(_, count, make)) = NAMES.iter().find(|(known, ..)| *known == name) else { return Ok(None) };
        if count == 0 {
            return Ok(Some(make(0)));
        }
        let first = range.and_then(|range| self.program.arguments_of(range).first().copied().flatten());
        let missing = || {
            let message = format!("{name} needs the number of the frame");
            fault(Code::BAD_INDEX, span, message, format!("write {name}[n] with n from 0 to {}", count - 1))
        };
        let number = self.whole(first.ok_or_else(missing)?)?;
        if !(0..count).contains(&number) {
            let message = format!("there is no {name}[{number}]");
            return Err(fault(Code::BAD_INDEX, span, message, format!("its indices run from 0 to {}", count - 1)));
        }
        Ok(Some(make(number)))
    }

    /// A frame of the control.
    pub(super) fn frame(&self, name: FrameName, span: Span) -> Result<FrameParts, Fault> {
        let frames = &self.system.frames;
        let of = |frame: &Frame| {
            FrameParts::of(frame, self.order()).ok_or_else(|| {
                let message = "this frame has no components: it rotates inside unequal scale factors";
                fault(Code::NOT_COMPUTABLE, span, message, "scale all axes equally, or rotate before scaling")
            })
        };
        match name {
            FrameName::Settable(number) => match frames.settable(self.machine, number) {
                Some(parts) => Ok(parts),
                None if self.system.strict => {
                    Err(super::frame_store::no_offset(&frame_store::settable_code(number), span))
                }
                None => Ok(FrameParts::default()),
            },
            FrameName::StoredBase(number) => Ok(frames.stored_base.get(&number).copied().unwrap_or_default()),
            FrameName::Base(number) => Ok(frames.active_base.get(&number).copied().unwrap_or_default()),
            FrameName::System => Ok(FrameParts::default()),
            FrameName::ActiveSettable => of(&self.modal.settable),
            FrameName::Programmable => of(&self.modal.programmable),
            FrameName::AllBases => of(&self.modal.base),
            FrameName::All => of(&self.modal.frame()),
        }
    }

    /// Reads a frame of the control or a component of it.
    pub(super) fn read_frame(&self, name: FrameName, range: Option<ArgumentRange>, id: ExprId) -> Result<Value, Fault> {
        let span = self.program.expr(id).span;
        let parts = self.frame(name, span)?;
        // A frame that the program itself has set is the same at the control.
        if let FrameName::Settable(number) = name
            && !self.system.frames.settable.contains_key(&number)
        {
            self.variables.fixed.note(span);
        }
        match range.map(|range| self.component(range)).transpose()?.flatten() {
            Some((axis, component, _)) => self.get_component(&parts, axis, component, span),
            None => Ok(Value::Frame(Box::new(parts))),
        }
    }
}
