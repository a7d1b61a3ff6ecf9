//! CYCLE800: tilts the plane of the program, turns the rotary axes until the tool is normal to it, and moves the frame with the workpiece.
//!
//! The tilt T refers to the workpiece: a point p of the new plane is the point T·p of the settable zero offset with the rotary axes at zero. The new
//! frame brings the tip to this point of the workpiece with the rotary axes turned. The linear axes for a turned workpiece are an affine function of
//! p, computed with the kinematics of the machine. If the spindle head turns, the control still adds the tool length along its axes; the shift of the
//! frame contains the difference.

use super::channel::Channel;
use super::gathered::{Call, Gathered};
use super::level::Interpreter;
use super::modal::Modal;
use super::modal::MotionKind;
use super::modal::Swivelled;
use super::order;
use super::save;
use super::scope::scope_of;
use super::tilt_frame::{self, SAME_ROTATION};
use super::value::Value;
use ncfix_machine::machine::Machine;

use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::tilted_plane::{tilting_axis, turned_frame, unknown_places, workpiece_normal};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, Matrix, Vector, about};
use ncfix_base::source::Span;
use ncfix_machine::machine::Kinematics;
use ncfix_machine::snc::{Kind, RotaryDirection};

/// Resolution of the rotary positions, parts of a degree: beyond it is rounding noise.
const PARTS: f64 = 1e9;
/// Angles nearer to each other than this are equal, rad.
const SAME_ANGLE: f64 = 1e-9;
/// _MODE for a rotation about Z and then about the new Y.
const SOLID_ANGLE: f64 = 64.0;

/// The arguments of a call.
struct Request {
    retract: f64,
    retract_by_mm: f64,
    is_additive: bool,
    before: Vector,
    rotation: Matrix,
    behind: Vector,
    direction: f64,
    is_reset: bool,
    span: Span,
}

impl Request {
    /// `true` without an angle, a shift and a motion of the rotary axes: only the frames are deleted.
    fn is_plain(&self) -> bool {
        let has_shift = self.before != Vector::zeros() || self.behind != Vector::zeros();
        self.rotation == Matrix::identity() && !has_shift && self.direction == 0.0 && !self.is_additive
    }
}

impl Interpreter<'_> {
    /// `CYCLE800(…)`
    pub(super) fn swivel(&mut self, call: &Call) -> Result<(), Fault> {
        let Some(level) = self.levels.last() else { return Ok(()) };
        let loaded = &self.programs[level.program];
        let given = call.arguments.map_or(&[][..], |range| loaded.program.arguments_of(range));
        let scope = scope_of(loaded, &self.channel);
        let mut values = [0.0; 16];
        let mut name = Vec::new();
        for (place, argument) in given.iter().enumerate() {
            let Some(id) = argument else { continue };
            let value = scope.value(*id)?;
            match (place, &value) {
                (1, Value::Text(text)) => name.clone_from(text),
                _ => match (values.get_mut(place), value.number()) {
                    (Some(slot), Some(number)) => *slot = number,
                    _ => return Err(save::refused(call.span, format!("argument {} is not valid", place + 1))),
                },
            }
        }
        let [retract, _, status, mode, x0, y0, z0, a, b, c, x1, y1, z1, direction, retract_by, _] = values;
        let length = self.channel.modal.modes.scale();
        let is_reset = given.iter().all(Option::is_none) || name == b"0";
        let digits = status as i64;
        if digits < 0 || status.fract() != 0.0 || digits / 10 % 10_000 != 0 || digits % 10 > 1 {
            return Err(save::refused(
                call.span,
                format!("_ST {status}: only 0 and 1 in the last digit are supported"),
            ));
        }
        let rotation = if is_reset { Matrix::identity() } else { rotation_of(mode, [a, b, c], call.span)? };
        let request = Request {
            retract,
            retract_by_mm: retract_by * length,
            is_additive: digits % 10 == 1,
            before: Vector::new(x0, y0, z0) * length,
            rotation,
            behind: Vector::new(x1, y1, z1) * length,
            direction,
            is_reset,
            span: call.span,
        };
        swivel(&mut self.channel, &request)
    }
}

/// The rotation of a mode: about up to three axes, each about the already rotated axes.
fn rotation_of(mode: f64, angles_deg: [f64; 3], span: Span) -> Result<Matrix, Fault> {
    let mut rotation = Matrix::identity();
    if angles_deg == [0.0; 3] {
        return Ok(rotation);
    }
    if mode == SOLID_ANGLE {
        let [about_z, about_y, last] = angles_deg;
        if last != 0.0 {
            return Err(save::refused(span, format!("_MODE {mode} with a third angle {last} is not known")));
        }
        return Ok(about(&Vector::z(), about_z.to_radians()) * about(&Vector::y(), about_y.to_radians()));
    }
    if !(0.0..64.0).contains(&mode) || mode.fract() != 0.0 {
        let reason = match mode {
            192.0 => "the positions of the rotary axes do not state the direction of X in the plane".to_owned(),
            _ => "only rotations axis by axis and by solid angle are supported".to_owned(),
        };
        return Err(save::refused(span, format!("_MODE {mode}: {reason}")));
    }
    // Below 64.
    let bits = mode as u32;
    for (place, angle) in angles_deg.into_iter().enumerate() {
        let unit = match bits >> (2 * place) & 3 {
            1 => Vector::x(),
            2 => Vector::y(),
            3 => Vector::z(),
            _ if angle == 0.0 => continue,
            _ => return Err(save::refused(span, format!("_MODE {mode} has no axis for rotation {}", place + 1))),
        };
        rotation *= about(&unit, angle.to_radians());
    }
    Ok(rotation)
}

fn swivel(channel: &mut Channel<'_>, request: &Request) -> Result<(), Fault> {
    let span = request.span;
    if channel.modal.transform.turning().is_some() {
        return Err(save::refused(span, "the plane cannot be tilted under TRAORI".to_owned()));
    }
    if channel.modal.swivelled.as_ref().is_some_and(|last| last.is_of_tool && !request.is_reset) {
        let message = "CYCLE800 while the frame of TOROT is in force: no manual states which of the two frames remains";
        return Err(fault(Code::BAD_SWIVEL, span, message, "end it with TOROTOF before the cycle"));
    }
    let kinematics = Kinematics::of_head(channel.settings.machine, channel.modal.tool.head);
    check_stated_for(channel, request, &kinematics)?;
    retract(channel, request, &kinematics)?;
    let has_rotary = kinematics.rotary_axes().next().is_some();
    if request.is_reset || request.is_plain() && has_rotary {
        channel.modal.swivelled = None;
        delete_swivel_frames(channel);
        return save::restate(channel, span);
    }
    let below = channel.modal.base.compose(&channel.modal.settable);
    let new =
        translation(request.before).compose(&Frame::rotation(request.rotation)).compose(&translation(request.behind));
    let tilt = match &channel.modal.swivelled {
        Some(last) if request.is_additive => last.tilt.compose(&channel.modal.programmable).compose(&new),
        None if request.is_additive => channel.modal.programmable.compose(&new),
        _ => new,
    };
    let tool_mm = channel.modal.tool_mm();
    let total = if has_rotary {
        let normal = workpiece_normal(&kinematics, &below, &tilt, &tool_mm);
        let turned = if request.direction == 0.0 {
            let here = channel.modal.position.command;
            let along = kinematics.direction(&here).dot(&normal) / normal.norm();
            if along.is_nan() || along < 1.0 - SAME_ROTATION {
                let message = "_DIR 0 moves no axis, and the tool is not normal to this plane";
                return Err(save::refused(span, message.to_owned()));
            }
            here
        } else {
            let turned = choose(channel.settings.machine, &channel.modal, &kinematics, &normal, request)?;
            turn(channel, &kinematics, &turned, span)?;
            turned
        };
        let total = turned_frame(&kinematics, &below, &tilt, &turned, &tool_mm).ok_or_else(|| {
            save::refused(span, "the linear axes of this machine cannot position the tool tip".to_owned())
        })?;
        Some(total)
    } else if request.direction == 0.0 {
        Some(below.compose(&tilt))
    } else {
        return Err(save::refused(
            span,
            "the machine has no rotary axes to tilt the plane; _DIR 0 sets only the frame".to_owned(),
        ));
    };
    let total = total.ok_or_else(|| save::refused(span, "the tilted plane does not give a valid frame".to_owned()))?;
    let relative = below.inverse().compose(&total);
    let (frame, statements) = tilt_frame::stated(channel, &relative, span)?;
    if channel.modal.swivelled.is_none() {
        delete_swivel_frames(channel);
    }
    channel.modal.swivelled = Some(Box::new(Swivelled { frame, statements, tilt, tool_mm, is_of_tool: false }));
    save::restate(channel, span)
}

/// Writes `CYCLE800()`, which deletes the system frames of the cycle. The output states a tilted plane with the programmable frame, and frame statements
/// delete no system frame. These frames survive a reset: the one of a job that was stopped in a tilted plane would be added to the plane of the output.
fn delete_swivel_frames(channel: &mut Channel<'_>) {
    channel.outlet.begin_line();
    channel.push(Kind::Verbatim(b"CYCLE800()".to_vec()));
}

/// Reports positions on which a retraction or a plane depends, and which the program has not stated. The linear axes keep their places while the rotary
/// axes turn, and the rotary axes go to absolute positions.
fn check_stated_for(channel: &mut Channel<'_>, request: &Request, kinematics: &Kinematics) -> Result<(), Fault> {
    if !channel.settings.strict {
        return Ok(());
    }
    channel.modal.check_length(request.span)?;
    let turns = matches!(request.retract, 4.0 | 5.0)
        && !(request.retract == 4.0 && tool_keeps_direction(kinematics, &channel.modal.tool_mm()));
    let stays = request.direction == 0.0 && !request.is_reset && !request.is_plain();
    let linear = if request.retract == 5.0 { AxisSet::XYZ } else { AxisSet::EMPTY };
    let rotary = kinematics.rotary_axes().filter(|_| turns || stays);
    let needed = linear.iter().chain(rotary);
    let unknown: AxisSet = needed.filter(|&axis| !is_stated(channel.settings.machine, &channel.modal, axis)).collect();
    if !unknown.is_empty() {
        // The plane is activated nevertheless, so that one cause is not reported in every following block.
        channel.outlet.warnings.push(unknown_places(request.span, unknown, "SUPA G0"));
        channel.modal.position.known = channel.modal.position.known.union(unknown);
    }
    Ok(())
}

fn is_stated(machine: &Machine, modal: &Modal, axis: Axis) -> bool {
    machine.axis(axis).is_none() || modal.position.known.contains(axis)
}

/// The angles of the rotary axes that align the tool with the plane.
fn choose(
    machine: &Machine,
    modal: &Modal,
    kinematics: &Kinematics,
    normal: &Vector,
    request: &Request,
) -> Result<AxisVector, Fault> {
    let near = modal.position.command;
    let help = "check the angles of the plane and the travel of the rotary axes";
    match kinematics.orientations(normal, &near) {
        [None, None] => {
            let message = "the rotary axes cannot align the tool with this plane";
            Err(fault(Code::BAD_SWIVEL, request.span, message, help))
        }
        [Some(one), None] | [None, Some(one)] => Ok(one),
        [Some(one), Some(other)] => {
            let reference = machine.control.swivel_direction_axis.or_else(|| tilting_axis(kinematics, machine));
            let Some(axis) = reference else { return Ok(one) };
            if (one[axis] - other[axis]).abs() < SAME_ANGLE {
                return Ok(one);
            }
            Ok(if (one[axis] < other[axis]) == (request.direction < 0.0) { one } else { other })
        }
    }
}

/// Turns the rotary axes at rapid, in machine coordinates.
fn turn(channel: &mut Channel<'_>, kinematics: &Kinematics, turned: &AxisVector, span: Span) -> Result<(), Fault> {
    let mut words = Gathered::new();
    for axis in kinematics.rotary_axes() {
        let (from, to) = (channel.modal.position.command[axis], turned[axis]);
        let is_modulo = channel.settings.machine.axis(axis).is_some_and(|data| data.modulo);
        let shown = (to.to_degrees() * PARTS).round() / PARTS;
        words.axes[axis] = if is_modulo { shown.rem_euclid(360.0) } else { shown };
        if let Some(way) = words.ways.get_mut(axis.dimension()).filter(|_| is_modulo) {
            *way = if to > from { RotaryDirection::Positive } else { RotaryDirection::Negative };
            // The control chooses the direction of a half turn.
            let increment = channel.settings.machine.control.increment_rad.max(SAME_ANGLE);
            let step = (to - from).abs();
            if !is_stated(channel.settings.machine, &channel.modal, axis)
                || step <= increment
                || (step - std::f64::consts::PI).abs() <= increment
            {
                *way = RotaryDirection::Shortest;
            }
        }
        words.as_absolute.insert(axis);
        words.named.insert(axis);
    }
    go(channel, words, span)
}

/// Executes a rapid block in machine coordinates; the active motion code stays.
fn go(channel: &mut Channel<'_>, mut words: Gathered, span: Span) -> Result<(), Fault> {
    let motion = channel.modal.modes.motion;
    words.suppress = Some("SUPA");
    words.keep.push("SUPA");
    words.motion = Some((MotionKind::Rapid, span));
    channel.outlet.begin_line();
    let found = order::execute(channel, &mut words, None, span);
    channel.modal.modes.motion = motion;
    found
}

/// Retracts from the workpiece as the call requests.
fn retract(channel: &mut Channel<'_>, request: &Request, kinematics: &Kinematics) -> Result<(), Fault> {
    let (span, scale) = (request.span, channel.modal.modes.scale());
    let tool_mm = channel.modal.tool_mm();
    let mut words = Gathered::new();
    let mut go_to = |axis: Axis, command: f64| {
        words.axes[axis] = (command + tool_mm[axis.slot()]) / scale;
        words.as_absolute.insert(axis);
        words.named.insert(axis);
    };
    if request.retract == 0.0 {
        return Ok(());
    }
    if request.retract == 5.0 {
        let tip = kinematics.tip_mm(&channel.modal.position.command, &tool_mm);
        let away = tip + kinematics.direction(&channel.modal.position.command) * request.retract_by_mm;
        let target = kinematics.placed(&away, &channel.modal.position.command, &tool_mm);
        let target =
            target.ok_or_else(|| save::refused(span, "the linear axes cannot position the tool tip".to_owned()))?;
        AxisSet::XYZ.iter().for_each(|axis| go_to(axis, target[axis]));
        return go(channel, words, span);
    }
    let is_along_z = lifts_along_z(kinematics, &channel.modal.position.command, &tool_mm);
    let is_known = matches!(request.retract, 1.0 | 2.0) || request.retract == 4.0 && is_along_z;
    let control = &channel.settings.machine.control;
    let in_plane = [control.swivel_retract_x_mm, control.swivel_retract_y_mm];
    match (control.swivel_retract_z_mm.filter(|_| is_known), in_plane) {
        (Some(z), [Some(x), Some(y)]) if request.retract == 2.0 => {
            go_to(Axis::Z, z);
            go(channel, words, span)?;
            let mut words = Gathered::new();
            for (axis, command) in [(Axis::X, x), (Axis::Y, y)] {
                words.axes[axis] = (command + tool_mm[axis.slot()]) / scale;
                words.as_absolute.insert(axis);
                words.named.insert(axis);
            }
            go(channel, words, span)
        }
        (Some(z), _) if request.retract != 2.0 => {
            go_to(Axis::Z, z);
            go(channel, words, span)
        }
        _ => {
            let message = format!("_FR {}: the retract position is not known", request.retract);
            let help = "set control.swivel_retract_z_mm for _FR 1, 2 and 4 (tool along Z), for _FR 2 also swivel_retract_x_mm and \
                        swivel_retract_y_mm, or program _FR 0 and a separate retraction";
            Err(fault(Code::BAD_SWIVEL, span, message, help))
        }
    }
}

/// `true` if Z alone lifts the tool along its own axis.
fn lifts_along_z(kinematics: &Kinematics, command: &AxisVector, tool_mm: &Vector) -> bool {
    let lifted = kinematics.tip_mm(command, tool_mm) + kinematics.direction(command);
    let Some(target) = kinematics.placed(&lifted, command, tool_mm) else { return false };
    let way = target.xyz() - command.xyz();
    way[2] > (1.0 - SAME_ROTATION) * way.norm()
}

/// `true` if the rotary axes turn only the workpiece: the tool keeps its direction.
fn tool_keeps_direction(kinematics: &Kinematics, tool_mm: &Vector) -> bool {
    let turned = |axis: Axis| {
        let mut command = AxisVector::ZERO;
        command[axis] = std::f64::consts::FRAC_PI_3;
        command
    };
    let mut places = kinematics.rotary_axes().map(turned).chain([AxisVector::ZERO]);
    places.all(|command| lifts_along_z(kinematics, &command, tool_mm))
}

fn translation(shift: Vector) -> Frame {
    let mut offset = AxisVector::ZERO;
    offset.set_xyz(shift);
    Frame::translation(offset)
}
