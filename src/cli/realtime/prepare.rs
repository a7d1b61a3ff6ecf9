//! What stands before the first set-point: machine, condition, kernel, its agreement with the model, and the thread that renews it.

use std::time::Duration;

use crate::cli::arguments::{RealtimeArguments, RotaryChoice, StateChoice};
use crate::cli::findings::Findings;
use crate::cli::machine_choice::{self, Chosen};
use crate::cli::state;
use crate::cli::stop::Stop;
use crate::cli::value::ToolVector;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AxisSet, Vector};
use ncfix_base::units::{mm_from_um, rad_from_urad, um_from_mm, urad_from_rad};
use ncfix_model::{Model, Solve};
use ncfix_report::number::{micrometers, significant};
use ncfix_tables::realtime::{Agreement, Cycle, Dosing, INTERVALS, Kernel, Publisher, Updater, handover};

/// Poses at which a kernel is held against its model.
const POSES: usize = 1000;
/// More than a kernel may differ from its model without a word.
const LIMIT_UM: f64 = 0.5;
const LIMIT_URAD: f64 = 5.0;

/// Ready for set-points.
pub(super) struct Prepared {
    pub(super) cycle: Cycle,
    pub(super) axes: AxisSet,
    /// What is said of the kernel.
    pub(super) summary: String,
    /// Renews the kernel as long as this lives.
    _updater: Updater,
}

/// How kernels are made.
#[derive(Clone, Copy)]
struct Recipe {
    tool_mm: Vector,
    mode: Solve,
    max_correction_mm: f64,
}

/// Reads everything and makes the kernel; `None` where findings forbid it.
pub(super) fn prepare(arguments: &RealtimeArguments, findings: &mut Findings) -> Result<Option<Prepared>, Stop> {
    let nowhere = std::path::Path::new("-");
    let Some(mut chosen) = machine_choice::choose(&arguments.machine, nowhere, findings)? else { return Ok(None) };
    if !state::apply(&arguments.state, &mut chosen, findings)? {
        return Ok(None);
    }
    let recipe = Recipe {
        tool_mm: match arguments.tool {
            None => Vector::zeros(),
            Some(ToolVector::Length(length_mm)) => chosen.machine.spindle.axis * -length_mm,
            Some(ToolVector::Tip(tip_mm)) => tip_mm,
        },
        mode: match arguments.rotary {
            RotaryChoice::Auto | RotaryChoice::Correct => Solve::Full,
            RotaryChoice::Hold => Solve::PositionOnly,
        },
        max_correction_mm: arguments.max_correction,
    };
    let Some((kernel, agreement)) = recipe.make(&chosen, findings) else { return Ok(None) };
    let axes = kernel.axes();
    let summary = summary(&kernel, &agreement);
    let (publisher, subscriber) = handover(kernel);
    let dosing = Dosing::new(mm_from_um(arguments.dose_um), rad_from_urad(arguments.dose_urad));
    let control = &chosen.machine.control;
    let cycle = Cycle::new(subscriber, dosing, control.increment_mm, control.increment_rad);
    let updater = renew(publisher, arguments.update_s, arguments.state.clone(), chosen, recipe);
    Ok(Some(Prepared { cycle, axes, summary, _updater: updater }))
}

impl Recipe {
    /// A kernel for the condition of a machine; `None` where findings forbid it.
    fn make(&self, chosen: &Chosen, findings: &mut Findings) -> Option<(Kernel, Agreement)> {
        let model: Model = chosen.model();
        let kernel = Kernel::new(&chosen.machine, &model, &self.tool_mm, self.mode);
        let agreement = kernel.agreement(&chosen.machine, &model, POSES);
        if agreement.unsolved > 0 {
            let message = format!(
                "at {} of {} poses within the travel no command brings the tip to its place",
                agreement.unsolved, agreement.poses
            );
            let help =
                "check the machine file, its tables, the tool and the state; --rotary hold corrects the position alone";
            findings.add(Diagnostic::nowhere(Code::CORRECTION_TOO_LARGE, message, help), &[]);
            return None;
        }
        if agreement.largest_mm > self.max_correction_mm {
            let message = format!(
                "the correction of an axis reaches {} within the travel, more than the {} allowed",
                micrometers(um_from_mm(agreement.largest_mm)),
                micrometers(um_from_mm(self.max_correction_mm))
            );
            let help = "check the machine file, the tool and the state, or allow more with --max-correction";
            findings.add(Diagnostic::nowhere(Code::CORRECTION_TOO_LARGE, message, help), &[]);
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
            let help =
                "look for errors that change by more than a hundredth of the way: a step in a table, a wrong unit";
            findings.add(Diagnostic::nowhere(Code::KERNEL_DIFFERS, message, help), &[]);
        }
        Some((kernel, agreement))
    }
}

/// `200 intervals per axis, 1 function of X directly; within 0.002 µm and 0.000 µrad of the model`.
fn summary(kernel: &Kernel, agreement: &Agreement) -> String {
    let direct = kernel.axes().iter().map(|axis| (axis, kernel.direct_functions(axis))).filter(|&(_, count)| count > 0);
    let direct: Vec<String> = direct.map(|(axis, count)| format!("{count} of {axis}")).collect();
    let direct =
        if direct.is_empty() { String::new() } else { format!("; functions beside them: {}", direct.join(", ")) };
    format!(
        "{INTERVALS} intervals per axis{direct}; within {} and {} µrad of the model at {} poses\n",
        micrometers(um_from_mm(agreement.position_mm)),
        significant(urad_from_rad(agreement.direction_rad)),
        agreement.poses
    )
}

/// Reads the state again in every period, in a thread of its own. What cannot be used is said, and the kernel in force stays.
fn renew(publisher: Publisher, period: Duration, choice: StateChoice, mut chosen: Chosen, recipe: Recipe) -> Updater {
    let files = chosen.files.len();
    let mut last = chosen.state.clone();
    Updater::start(publisher, period, move || {
        if choice.state.is_empty() {
            return None;
        }
        chosen.files.truncate(files);
        let mut findings = Findings::default();
        let read = state::apply(&choice, &mut chosen, &mut findings);
        let is_usable = matches!(read, Ok(true));
        if is_usable && chosen.state == last {
            return None;
        }
        let made = if is_usable { recipe.make(&chosen, &mut findings) } else { None };
        if made.is_none() {
            if let Err(stop) = read {
                findings.add(not_renewed(&stop.to_string()), &[]);
            } else {
                findings.add(not_renewed("the state cannot be used"), &[]);
            }
            findings.draw();
        }
        // What was refused is not tried again until the state changes.
        last.clone_from(&chosen.state);
        made.map(|(kernel, _)| kernel)
    })
}

fn not_renewed(why: &str) -> Diagnostic {
    let help = "correct the state; it is read again after --update-s";
    Diagnostic::nowhere(Code::NOT_RENEWED, format!("the kernel was not renewed: {why}"), help)
}
