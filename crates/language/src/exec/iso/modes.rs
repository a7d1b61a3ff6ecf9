//! Modal codes: plane, units, dimensions.

use super::channel::Channel;
use super::codes::Group;
use super::compensation;
use super::gathered::Gathered;
use super::setup;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Plane;
use ncfix_machine::snc::Kind;

pub(super) fn plane(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let Some(code) = gathered.code(Group::Plane) else { return Ok(()) };
    let Some(plane) = u8::try_from(code / 10).ok().and_then(Plane::from_number) else { return Ok(()) };
    if plane != channel.modal.plane {
        if channel.is_rs274() {
            compensation::no_compensation(channel, gathered.code_span(Group::Plane), "another plane")?;
        }
        channel.modal.plane = plane;
        setup::refresh_setup(channel);
    }
    channel.push(Kind::Keep(match plane.number() {
        17 => "G17",
        18 => "G18",
        _ => "G19",
    }));
    Ok(())
}

pub(super) fn units(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let Some(code) = gathered.code(Group::Units) else { return Ok(()) };
    channel.modal.inch = code == 200;
    match channel.machine.control.output_inch {
        Some(inch) if inch != channel.modal.inch && !channel.is_rs274() => {
            let message = "the program is in inches in one part and in millimeters in another";
            let help = "correct them as two programs: what the control keeps in tool and zero offsets follows the unit in force";
            Err(fault(Code::MIXED_UNITS, gathered.code_span(Group::Units), message, help))
        }
        _ => Ok(()),
    }
}

pub(super) fn distance(channel: &mut Channel<'_>, gathered: &Gathered) {
    if let Some(code) = gathered.code(Group::Distance) {
        channel.modal.incremental = code == 910;
    }
    if let Some(code) = gathered.code(Group::ArcDistance) {
        channel.modal.arc_absolute = code == 901;
    }
}

pub(super) fn retract(channel: &mut Channel<'_>, gathered: &Gathered) {
    if let Some(code) = gathered.code(Group::Retract) {
        channel.modal.to_r_plane = code == 990;
    }
}
