//! Codes that a Fanuc rejects in its current state: within rotation, scaling and mirroring, under radius compensation, under tool center point
//! control, in polar coordinates. `docs/reference/states.md` has the table.

use super::channel::Channel;
use super::channel::Special;
use super::codes::{Group, name_of};
use super::gathered::Gathered;
use super::modal::Modal;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::settings::RunSettings;
use crate::exec::core::standing::InForce;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Axis;
use ncfix_base::geometry::AxisSet;
use ncfix_base::geometry::Plane;
use ncfix_base::source::Span;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;

/// Kinds of codes that a state may forbid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// G17, G18, G19
    Plane,
    /// G54 to G59, G54.1, G52, G92, G92.1, G10 L2 and L20
    Origin,
    /// G27 to G30, G53
    Machine,
}

/// A code of a block: its kind, name and span.
type Found = (Kind, String, Span);

/// The machine file setting for makers who allow it.
const SETTING: &str =
    "or, if the machine builder allows it, set control.codes_within_rotation = \"allowed\" in the machine file";

/// Rejects codes that the state before the block does not allow. A code that ends a state ends it for its whole block.
pub(super) fn check_state(channel: &Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let is_plain = channel.modal.transforms.is_empty()
        && !channel.modal.contour.compensates()
        && channel.modal.turning.is_none()
        && channel.special.polar.is_none();
    if is_plain {
        return Ok(());
    }
    for found in found(gathered) {
        within_transforms(channel.settings.machine, &channel.modal, gathered, &found)?;
        within_compensation(&channel.modal, gathered, &found)?;
        within_tip_control(&channel.modal, gathered, &found)?;
        within_polar(&channel.modal, &channel.special, gathered, &found)?;
    }
    Ok(())
}

/// The codes of a block that a state may forbid.
fn found(gathered: &Gathered) -> Vec<Found> {
    let named = |kind: Kind, group: Group, code: u16| (kind, name_of(code), gathered.code_span(group));
    let mut out = Vec::new();
    out.extend(gathered.code(Group::Plane).map(|code| named(Kind::Plane, Group::Plane, code)));
    out.extend(gathered.code(Group::Coordinates).map(|code| named(Kind::Origin, Group::Coordinates, code)));
    out.extend(gathered.machine_frame.map(|span| (Kind::Machine, "G53".to_owned(), span)));
    out.extend(gathered.code(Group::Action).and_then(|code| {
        let kind = match code {
            270 | 280 | 290 | 300 => Kind::Machine,
            520 | 920 | 921 => Kind::Origin,
            100 if gathered.raw(b'L').is_some_and(|l| l == 2.0 || l == 20.0) => Kind::Origin,
            _ => return None,
        };
        Some(named(kind, Group::Action, code))
    }));
    out
}

/// Operator's manual, "coordinate system rotation", "scaling" and "programmable mirror image": no plane selection, G27 to G30, G52 to G59 or G92
/// (alarm 144 for another plane).
fn within_transforms(
    machine: &Machine,
    modal: &Modal,
    gathered: &Gathered,
    (kind, name, span): &Found,
) -> Result<(), Fault> {
    let Some((what, end, group)) = transform_within(modal, gathered) else { return Ok(()) };
    let is_tilted = modal.transforms.tilt().is_some();
    // Machine positions do not rotate with a tilted plane, and its working plane is selected within it.
    let is_free = is_tilted && *kind != Kind::Origin || shifts_nothing(machine, modal, gathered);
    // `G17 G68 X0 Y0 R30.`: the plane of the rotation that begins here.
    let begins =
        *kind == Kind::Plane && gathered.code(group).is_some() && plane_of(modal, gathered) == modal.modes.plane;
    if is_free || begins || machine.control.iso.codes_within_rotation {
        return Ok(());
    }
    let message = format!("{name} while {what}: a Fanuc forbids it, and the resulting position is not defined");
    let help = format!("end it with {end} first, and begin it again after {name}; {SETTING}");
    Err(fault(Code::FORBIDDEN_STATE, *span, message, help))
}

/// `true` for a G52 of zeros while the local shift is zero: a Haas executes it, and nothing changes.
fn shifts_nothing(machine: &Machine, modal: &Modal, gathered: &Gathered) -> bool {
    let is_zero = |axis: Axis| modal.local[axis] == 0.0 && gathered.raw_quietly(axis.letter()) == Some(0.0);
    machine.control.iso.is_haas() && gathered.code(Group::Action) == Some(520) && gathered.axes.iter().all(is_zero)
}

/// The active rotation, scaling or mirroring that the block does not end, the code that ends it, and its group.
fn transform_within(modal: &Modal, gathered: &Gathered) -> Option<(&'static str, &'static str, Group)> {
    let transforms = &modal.transforms;
    let ends = |group: Group, code: u16| gathered.code(group) == Some(code);
    [
        (transforms.tilt().is_some(), Group::Rotation, 690, "the working plane is tilted (G68.2)", "G69"),
        (transforms.is_turned(), Group::Rotation, 690, "the coordinate system is rotated (G68)", "G69"),
        (transforms.is_scaled(), Group::Scale, 500, "scaling is in force (G51)", "G50"),
        (transforms.is_mirrored(), Group::Mirror, 501, "a mirror is in force (G51.1)", "G50.1"),
    ]
    .into_iter()
    .find(|&(is_on, group, code, ..)| is_on && !ends(group, code))
    .map(|(_, group, _, what, end)| (what, end, group))
}

/// Operator's manual, "cutter compensation": another plane is alarm 037. The effect of the other codes on the offset vector depends on parameters
/// (5003, 5008), and the tool moves by the radius in any case.
fn within_compensation(modal: &Modal, gathered: &Gathered, (kind, name, span): &Found) -> Result<(), Fault> {
    if !modal.contour.compensates() || *kind == Kind::Plane && plane_of(modal, gathered) == modal.modes.plane {
        return Ok(());
    }
    let why = match kind {
        Kind::Plane => "the control stops with alarm 037",
        Kind::Origin => "the move to the new zero depends on parameters of the control",
        Kind::Machine => "when the tool leaves its distance from the contour depends on parameters of the control",
    };
    let message = format!("{name} while radius compensation is on: {why}");
    let help = format!("program G40 with a motion in the plane before {name}, and G41 or G42 again after it");
    Err(fault(Code::BAD_COMPENSATION, *span, message, help))
}

/// Machine positions are not tip positions: whether the control tracks the tool on the path there is not specified.
fn within_tip_control(modal: &Modal, gathered: &Gathered, (kind, name, span): &Found) -> Result<(), Fault> {
    let ends = gathered.code(Group::Length) == Some(490);
    if modal.turning.is_none() || ends || *kind != Kind::Machine {
        return Ok(());
    }
    let message = format!("{name} while the tool center point is controlled (G43.4)");
    Err(fault(Code::FORBIDDEN_STATE, *span, message, "end it with G49 first"))
}

/// The plane determines the radius axis and the angle axis. Words of G52, G53, G92 and G10 are not polar; for G27 to G30 no manual specifies it.
fn within_polar(
    modal: &Modal,
    special: &Special,
    gathered: &Gathered,
    (kind, name, span): &Found,
) -> Result<(), Fault> {
    if special.polar.is_none() || gathered.code(Group::Polar).is_some() {
        return Ok(());
    }
    let [abscissa, ordinate, _] = modal.modes.plane.axes();
    let has_words = [abscissa, ordinate].into_iter().any(|axis| {
        gathered.axes.contains(axis) && !(modal.modes.incremental && gathered.raw_quietly(axis.letter()) == Some(0.0))
    });
    let is_forbidden = match kind {
        Kind::Plane => plane_of(modal, gathered) != modal.modes.plane,
        Kind::Machine => name != "G53" && has_words,
        Kind::Origin => false,
    };
    if !is_forbidden {
        return Ok(());
    }
    let message = format!("{name} while polar coordinates are in force (G16): the meaning of its words is not defined");
    Err(fault(Code::FORBIDDEN_STATE, *span, message, "end them with G15 first"))
}

fn plane_of(modal: &Modal, gathered: &Gathered) -> Plane {
    let number = gathered.code(Group::Plane).and_then(|code| u8::try_from(code / 10).ok());
    number.and_then(Plane::from_number).unwrap_or(modal.modes.plane)
}

/// Applies the same check to an active zero offset that is written as a variable.
pub(super) fn check_offset_write(
    machine: &Machine,
    language: Language,
    modal: &Modal,
    number: u32,
    span: Span,
) -> Result<(), Fault> {
    if language == Language::Rs274 {
        return Ok(());
    }
    let gathered = Gathered::default();
    let found = (Kind::Origin, format!("#{number}"), span);
    within_transforms(machine, modal, &gathered, &found)?;
    within_compensation(modal, &gathered, &found)
}

/// Rejects motions in a tilted plane that would differ from those of the control.
pub(super) fn check_tilt(
    settings: &RunSettings<'_>,
    modal: &Modal,
    standing: &InForce,
    named: AxisSet,
    span: Span,
) -> Result<(), Fault> {
    let Some(stand) = modal.transforms.stand() else {
        let has_rotary = settings.machine.axis_set().iter().any(Axis::is_rotary);
        if settings.strict && has_rotary && !named.intersection(AxisSet::XYZ).is_empty() {
            let message = "a motion in a tilted plane with which the tool is not aligned";
            return Err(refused_with(span, message, "program G53.1 after G68.2"));
        }
        return Ok(());
    };
    if stand.tool_mm != standing.setup.tool_mm {
        let message = "the tool length changes within a tilted plane";
        return Err(refused_with(span, message, "change it before G68.2, or after G69"));
    }
    if stand.below != modal.below_transforms() {
        let message = "the zero offset changes within a tilted plane";
        return Err(refused_with(span, message, "change it before G68.2, or after G69"));
    }
    if named.iter().any(Axis::is_rotary) {
        let message = "rotary axes move within a tilted plane";
        return Err(refused_with(span, message, "end it with G69 first, or leave them to G53.1"));
    }
    Ok(())
}

pub(super) fn refused_with(span: Span, message: &str, help: &str) -> Fault {
    fault(Code::NOT_SUPPORTED, span, message, help)
}

/// Rejects functions that are incompatible with radius compensation.
pub(super) fn no_compensation(language: Language, modal: &Modal, span: Span, what: &str) -> Result<(), Fault> {
    if !modal.contour.compensates() || language != Language::Rs274 {
        return Ok(());
    }
    let message = format!("{what} while radius compensation is on");
    Err(fault(Code::BAD_COMPENSATION, span, message, "program G40 and a motion before it"))
}
