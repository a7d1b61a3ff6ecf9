//! Tool center point control: G43.4 and G43.5.
//!
//! Under it the positions of the channel are those of the tip, fixed to the workpiece; [`crate::exec::five_axis`] makes axis commands
//! of them.

use super::channel::Channel;
use crate::diagnostic::Code;
use crate::exec::fault::{Fault, fault};
use crate::geometry::{AxisSet, LINEAR_AXES, ROTARY_AXES};
use crate::machine::Kinematics;
use crate::snc::{Setup, Turning};
use crate::source::Span;

impl Channel<'_> {
    /// Switches it by the code of length compensation, in tenths.
    pub(super) fn switch_tip(&mut self, code: u16, span: Span) -> Result<(), Fault> {
        let turning = match code {
            434 => Some(Turning::Axes),
            435 => {
                let message = "G43.5 gives directions of the tool with I J K and is not supported";
                return Err(fault(Code::NOT_SUPPORTED, span, message, "program G43.4 with rotary axes"));
            }
            _ => None,
        };
        if turning == self.modal.turning {
            return Ok(());
        }
        if turning.is_some() {
            let kinematics = self.outlet.kinematics.get_or_insert_with(|| Box::new(Kinematics::new(self.machine)));
            let rotary = kinematics.rotary_axes().count();
            let can = (1..=2).contains(&rotary)
                && kinematics.command_on_workpiece(&self.modal.command, &self.setup.tool_mm).is_some();
            if !can {
                let message = format!("G43.4 needs X, Y, Z and one or two rotary axes, and the machine has {rotary}");
                return Err(fault(Code::NO_AXIS, span, message, "check the topology in the machine file"));
            }
        }
        self.outlet.finish();
        let Some(kinematics) = &self.outlet.kinematics else { return Ok(()) };
        let tool_mm = self.setup.tool_mm;
        let modal = &mut self.modal;
        modal.turning = turning;
        modal.command = if turning.is_some() {
            kinematics.on_workpiece(&modal.command, &tool_mm)
        } else {
            kinematics.command_on_workpiece(&modal.command, &tool_mm).unwrap_or(modal.command)
        };
        // Each linear coordinate depends on all axes.
        let needed: AxisSet = LINEAR_AXES.into_iter().take(3).chain(kinematics.rotary_axes()).collect();
        if !needed.difference(modal.known).is_empty() {
            modal.known = modal.known.intersection(ROTARY_AXES.into_iter().collect());
        }
        Ok(())
    }

    /// The machine stands where it stood when frame or tool change: under the transformation the place of the tip follows from it.
    pub(super) fn keep_pose(&mut self, setup: &Setup) {
        let (Some(_), Some(kinematics)) = (self.setup.transform.and(setup.transform), &self.outlet.kinematics) else {
            return;
        };
        if setup.tool_mm != self.setup.tool_mm
            && let Some(command) = kinematics.command_on_workpiece(&self.modal.command, &self.setup.tool_mm)
        {
            self.modal.command = kinematics.on_workpiece(&command, &setup.tool_mm);
        }
    }
}
