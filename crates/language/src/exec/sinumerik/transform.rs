//! Five-axis transformation on and off: `TRAORI`, `TRAFOOF`, and the codes for the meaning of orientations.
//!
//! Under a transformation the positions of the channel are those of the tip, fixed to the workpiece, minus the tool at its zero pose
//! ([`ncfix_machine::machine::Kinematics::on_workpiece`]); [`crate::exec::core::five_axis`] converts them to axis commands.

use super::channel::Channel;
use super::gathered::Gathered;
use super::gatherer::Gatherer;
use super::modal::Modal;
use super::setup;
use super::spline;
use super::surface;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::settings::RunSettings;
use crate::exec::core::standing::InForce;
use crate::syntax::sinumerik::{ArgumentRange, Word};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, LINEAR_AXES, ROTARY_AXES};
use ncfix_base::source::Span;
use ncfix_dialect::CodeEntry;
use ncfix_machine::machine::{Kinematics, OrientationAngles};
use ncfix_machine::snc::{Kind, Turning};

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
                    "a control has only the transformations 1 and 2",
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
            surface::follow_path(channel.settings.machine, &mut channel.modal, &mut channel.outlet)?;
        }
    }
    if let Some((name, span)) = words.switch {
        if !gathered.named.is_empty() {
            let message = format!("{name} in a block with a motion");
            return Err(fault(Code::MUST_STAND_ALONE, span, message, "give it its own block"));
        }
        let is_on = name != "TRAFOOF";
        if let Some(swivelled) = channel.modal.swivelled.as_ref().filter(|_| is_on) {
            let message = format!("{name} in a plane that {} has tilted", swivelled.source());
            return Err(fault(Code::BAD_SWIVEL, span, message, swivelled.way_out()));
        }
        if is_on {
            check_kinematics(&channel.settings, &channel.modal, &channel.standing, &mut channel.outlet, span)?;
        }
        spline::finish(channel);
        channel.push(Kind::Keep(name));
        switch(&mut channel.modal, &channel.standing, &mut channel.outlet, is_on);
    }
    setup::refresh_setup(&mut channel.modal, &mut channel.standing, &mut channel.outlet);
    Ok(())
}

/// Checks that the machine can be transformed.
fn check_kinematics(
    settings: &RunSettings<'_>,
    modal: &Modal,
    standing: &InForce,
    outlet: &mut MotionSink<'_>,
    span: Span,
) -> Result<(), Fault> {
    let (machine, head) = (settings.machine, modal.tool.head);
    let kinematics = outlet.kinematics.get_or_insert_with(|| Box::new(Kinematics::of_head(machine, head)));
    let rotary = kinematics.rotary_axes().count();
    let can = (1..=2).contains(&rotary)
        && kinematics.command_on_workpiece(&modal.position.command, &standing.setup.tool_mm).is_some();
    if can {
        return Ok(());
    }
    let message = format!("TRAORI needs X, Y, Z and one or two rotary axes, and the machine has {rotary}");
    Err(fault(Code::NO_AXIS, span, message, "check the topology in the machine file"))
}

fn switch(modal: &mut Modal, standing: &InForce, outlet: &mut MotionSink<'_>, is_on: bool) {
    if std::mem::replace(&mut modal.transform.is_on, is_on) == is_on {
        return;
    }
    let Some(kinematics) = &outlet.kinematics else { return };
    let tool_mm = standing.setup.tool_mm;
    modal.position.command = if is_on {
        kinematics.on_workpiece(&modal.position.command, &tool_mm)
    } else {
        kinematics.command_on_workpiece(&modal.position.command, &tool_mm).unwrap_or(modal.position.command)
    };
    // Each linear coordinate depends on all axes.
    let needed: AxisSet = LINEAR_AXES.into_iter().take(3).chain(kinematics.rotary_axes()).collect();
    if !needed.difference(modal.position.known).is_empty() {
        modal.position.keep(modal.position.known.intersection(ROTARY_AXES.into_iter().collect()));
    }
    modal.programmed = modal.setup().programmed(&modal.position.command);
}
