//! Creates kernels that are safe to use: their corrections are possible, bounded, and agree with the model.

use super::kernel::{Agreement, Kernel};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Vector;
use ncfix_base::number::{micrometers, significant};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::Machine;
use ncfix_model::{Model, Solve};

/// Number of poses for comparing a kernel with its model.
const POSES: usize = 1000;
/// Differences between kernel and model above which a diagnostic is reported.
const LIMIT_UM: f64 = 0.5;
const LIMIT_URAD: f64 = 5.0;

/// Settings for creating kernels.
#[derive(Clone, Copy, Debug)]
pub struct KernelRecipe {
    /// Vector from the spindle gauge point to the tip, mm.
    pub tool_mm: Vector,
    /// Selects whether rotary axes are corrected too.
    pub mode: Solve,
    /// Largest accepted correction of a linear axis, mm.
    pub max_correction_mm: f64,
}

impl KernelRecipe {
    /// Creates a kernel for the model of a machine in one condition, with its agreement; `None` if there are errors.
    pub fn make(&self, machine: &Machine, model: &Model, found: &mut Vec<Diagnostic>) -> Option<(Kernel, Agreement)> {
        let kernel = Kernel::new(machine, model, &self.tool_mm, self.mode);
        let agreement = kernel.agreement(machine, model, POSES);
        if agreement.unsolved > 0 {
            let message = format!(
                "at {} of {} poses within the travel no command brings the tip to its position",
                agreement.unsolved, agreement.poses
            );
            let help =
                "check the machine file, its tables, the tool and the state; --rotary hold corrects the position alone";
            found.push(Diagnostic::nowhere(Code::CORRECTION_TOO_LARGE, message, help));
            return None;
        }
        if agreement.largest_mm > self.max_correction_mm {
            let message = format!(
                "the correction of an axis reaches {} within the travel, more than the {} allowed",
                micrometers(um_from_mm(agreement.largest_mm)),
                micrometers(um_from_mm(self.max_correction_mm))
            );
            let help = "check the machine file, the tool and the state, or allow more with --max-correction";
            found.push(Diagnostic::nowhere(Code::CORRECTION_TOO_LARGE, message, help));
            return None;
        }
        let [um, urad] = [um_from_mm(agreement.position_mm), urad_from_rad(agreement.direction_rad)];
        if um > LIMIT_UM || urad > LIMIT_URAD || agreement.unequal > 0 {
            let message = format!(
                "the kernel differs from the model by up to {} and {} µrad; {} of {} poses have a correction in the model only",
                micrometers(um),
                significant(urad),
                agreement.unequal,
                agreement.poses
            );
            let help = "check for errors that change by more than 1 % of the distance: a step in a table, a wrong unit";
            found.push(Diagnostic::nowhere(Code::KERNEL_DIFFERS, message, help));
        }
        Some((kernel, agreement))
    }
}
