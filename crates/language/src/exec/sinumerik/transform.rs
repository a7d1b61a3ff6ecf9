//! Five-axis transformation on and off: `TRAORI`, `TRAFOOF`, and the codes that say how orientations are meant.
//!
//! Under a transformation the positions of the channel are those of the tip, fixed to the workpiece, with the tool at its zero pose
//! taken off ([`ncfix_machine::machine::Kinematics::on_workpiece`]); [`crate::exec::core::five_axis`] makes axis commands of them.

use super::channel::Channel;
use super::contour_words;
use super::gather::Gatherer;
use super::gathered::Gathered;
use super::setup;
use super::surface;
use super::surface::Surface;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::syntax::sinumerik::{ArgumentRange, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, LINEAR_AXES, ROTARY_AXES};
use ncfix_base::source::Span;
use ncfix_dialect::CodeEntry;
use ncfix_machine::machine::{Kinematics, OrientationAngles};
use ncfix_machine::snc::{Kind, Setup, Turning};

/// What a block says of it.
#[derive(Debug, Default)]
pub(super) struct TransformWords {
    /// `TRAORI`, `TRAORI(2)`, `TRAFOOF`.
    pub(super) switch: Option<(&'static str, Span)>,
    /// `ORIWKS`, `ORIAXES` …
    pub(super) codes: Vec<&'static str>,
}

/// What is in force of it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Transform {
    is_on: bool,
    /// Orientations are meant in the machine's directions (ORIMKS).
    pub(super) in_machine: bool,
    /// ORIAXES, ORIVECT; `None` before the program says it.
    turning: Option<Turning>,
    /// ORIRPY, ORIEULER; `None` before the program says it.
    pub(super) angles: Option<OrientationAngles>,
    /// LEAD, TILT, ORIPATH.
    pub(super) surface: Surface,
}

impl Transform {
    /// Takes over whether a transformation is in force, which SAVE does not bring back.
    pub(super) fn keep_switch_of(&mut self, left: &Transform) {
        self.is_on = left.is_on;
    }

    /// A code of the group of ORIAXES.
    fn turn(&mut self, turning: Turning) {
        self.turning = Some(turning);
        self.surface.follows_path = false;
    }

    /// How the tool turns; `None` without a transformation. Where no code of the group of ORIAXES was programmed, ORIMKS moves the
    /// rotary axes in proportion and ORIWKS the tool along a great circle (Sinumerik MD21104).
    pub(super) fn turning(&self) -> Option<Turning> {
        let usual = if self.in_machine { Turning::Axes } else { Turning::Vector };
        self.is_on.then(|| self.turning.unwrap_or(usual))
    }
}

impl Gatherer<'_> {
    /// `TRAORI(n)`
    pub(super) fn transformation(
        &self,
        entry: &'static CodeEntry,
        range: ArgumentRange,
        word: &Word,
        out: &mut Gathered,
    ) -> Result<(), Fault> {
        let number = match self.scope.program.arguments_of(range) {
            [] | [None] => 1.0,
            [Some(number)] if entry.name == "TRAORI" => self.scope.number(*number)?,
            _ => return Err(self.unsupported(word)),
        };
        let name = match (entry.name, number) {
            ("TRAORI", 2.0) => "TRAORI(2)",
            (name, 1.0) => name,
            _ => {
                return Err(bad_value(
                    word.span,
                    "a control has the transformations 1 and 2",
                    "write TRAORI or TRAORI(2)",
                ));
            }
        };
        self.code(entry, word.span, out)?;
        out.transform.switch = Some((name, word.span));
        Ok(())
    }
}

/// Executes the words of a block that concern the transformation.
pub(super) fn transform(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let words = &gathered.transform;
    if words.codes.is_empty() && words.switch.is_none() {
        return Ok(());
    }
    for &code in &words.codes {
        let modal = &mut channel.modal.transform;
        match code {
            "ORIMKS" => modal.in_machine = true,
            "ORIWKS" => modal.in_machine = false,
            "ORIAXES" => modal.turn(Turning::Axes),
            "ORIEULER" => modal.angles = Some(OrientationAngles::Euler),
            "ORIRPY" => modal.angles = Some(OrientationAngles::Rpy),
            _ => modal.turn(Turning::Vector),
        }
        if code == "ORIPATH" {
            surface::follow_path(channel)?;
        }
    }
    if let Some((name, span)) = words.switch {
        if !gathered.named.is_empty() {
            let message = format!("{name} shares its block with a motion");
            return Err(fault(Code::MUST_STAND_ALONE, span, message, "give it a block of its own"));
        }
        let is_on = name != "TRAFOOF";
        if is_on && channel.modal.swivelled.is_some() {
            let message = format!("{name} in a plane that CYCLE800 has swivelled");
            return Err(fault(Code::BAD_SWIVEL, span, message, "end the swivel with CYCLE800() first"));
        }
        if is_on {
            check_kinematics(channel, span)?;
        }
        contour_words::finish(channel);
        channel.push(Kind::Keep(name));
        switch(channel, is_on);
    }
    setup::refresh_setup(channel);
    Ok(())
}

/// Whether the machine can be transformed at all.
fn check_kinematics(channel: &mut Channel<'_>, span: Span) -> Result<(), Fault> {
    let kinematics = channel.outlet.kinematics.get_or_insert_with(|| Box::new(Kinematics::new(channel.machine)));
    let rotary = kinematics.rotary_axes().count();
    let can = (1..=2).contains(&rotary)
        && kinematics.command_on_workpiece(&channel.modal.command, &channel.setup.tool_mm).is_some();
    if can {
        return Ok(());
    }
    let message = format!("TRAORI needs X, Y, Z and one or two rotary axes, and the machine has {rotary}");
    Err(fault(Code::NO_AXIS, span, message, "check the topology in the machine file"))
}

fn switch(channel: &mut Channel<'_>, is_on: bool) {
    if std::mem::replace(&mut channel.modal.transform.is_on, is_on) == is_on {
        return;
    }
    let Some(kinematics) = &channel.outlet.kinematics else { return };
    let modal = &mut channel.modal;
    let tool_mm = channel.setup.tool_mm;
    modal.command = if is_on {
        kinematics.on_workpiece(&modal.command, &tool_mm)
    } else {
        kinematics.command_on_workpiece(&modal.command, &tool_mm).unwrap_or(modal.command)
    };
    // Each linear coordinate depends on all axes.
    let needed: AxisSet = LINEAR_AXES.into_iter().take(3).chain(kinematics.rotary_axes()).collect();
    if !needed.difference(modal.known).is_empty() {
        modal.known = modal.known.intersection(ROTARY_AXES.into_iter().collect());
    }
    modal.programmed = modal.setup().programmed(&modal.command);
}

/// The machine stands where it stood when frame or tool change: under a transformation the place of the tip follows from it.
pub(super) fn keep_pose(channel: &mut Channel<'_>, setup: &Setup) {
    let (Some(_), Some(kinematics)) = (channel.setup.transform.and(setup.transform), &channel.outlet.kinematics) else {
        return;
    };
    if setup.tool_mm != channel.setup.tool_mm
        && let Some(command) = kinematics.command_on_workpiece(&channel.modal.command, &channel.setup.tool_mm)
    {
        channel.modal.command = kinematics.on_workpiece(&command, &setup.tool_mm);
    }
}
