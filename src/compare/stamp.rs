//! The entries of the stamp of a corrected program other than the machine, the state and the original that it is compared with.

use crate::diagnostics::Diagnostics;
use crate::disk::hash::short_hash;
use crate::machine::Machine;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::Source;
use ncfix_base::units::um_from_mm;
use ncfix_path::emit;
use ncfix_path::path::Promise;

/// The tolerance stated by the corrected program; `None` if it is the original itself, which has none. `promised` is a tolerance given by the user,
/// mm.
pub(crate) fn promise(
    sources: &[Source; 2],
    chosen: &Machine,
    promised: Option<f64>,
    findings: &mut Diagnostics,
) -> Option<Promise> {
    let [original, corrected] = sources;
    let bytes = corrected.bytes();
    let name = corrected.name();
    let mut warn = |code, message: String, help: &str| findings.add(Diagnostic::nowhere(code, message, help), sources);
    let assumed = || {
        let default = Promise::default();
        Promise { tolerance_mm: promised.unwrap_or(default.tolerance_mm), ..default }
    };
    if !emit::is_stamped(bytes) {
        if bytes == original.bytes() {
            let message = format!("{name} has no stamp and is the same as {}: nothing was corrected", original.name());
            warn(Code::NO_STAMP, message, "compare a program with the output of ncfix fix for it");
            return promised.map(|_| assumed());
        }
        let message = format!("{name} has no stamp: it is not known for which machine, state and program it was made");
        let help = "compare the output of ncfix fix; if the stamp was removed, correct the program again";
        warn(Code::NO_STAMP, message, help);
        return Some(assumed());
    }
    let is_changed = emit::is_stamp_changed(bytes);
    if is_changed == Some(true) {
        let message = format!("the stamp of {name} was changed since it was written");
        let help = "its promised error is ignored, and 1 µm or --promised is used; correct the program again";
        warn(Code::NO_STAMP, message, help);
    }
    if let Some(model) = emit::stamped_model(bytes).filter(|model| *model != chosen.hash) {
        let message = format!(
            "{name} was corrected for another machine file or set-up (checksum {model}) than this one ({})",
            chosen.hash
        );
        warn(
            Code::OTHER_STAMP,
            message,
            "give the --machine and --setup files of the correction; if a tool, an offset or the machine has changed since, correct the original again",
        );
    } else if emit::is_stamped_for(bytes, &chosen.machine.name) == Some(false) {
        let message = format!("the stamp of {name} names another machine than {}", chosen.machine.name);
        warn(
            Code::OTHER_STAMP,
            message,
            "give the --machine and --setup files of the correction; if a tool, an offset or the machine has changed since, correct the original again",
        );
    }
    let stamped_state = emit::stamped_state(bytes);
    if stamped_state != chosen.state {
        let what = "temperatures, weight or method of the zero";
        let message = match (&stamped_state, &chosen.state) {
            (None, _) => format!("{name} was corrected without stated {what}, but is compared with some"),
            (Some(_), None) => format!("{name} was corrected for stated {what}, but is compared without them"),
            (Some(_), Some(_)) => format!("{name} was corrected for other {what} than those of the comparison"),
        };
        let help = "give the same --zero, --state, --time, --zero-time, --zero-at and --load as for the correction";
        warn(Code::OTHER_STAMP, message, help);
    }
    let hash = short_hash([original.bytes()]);
    if let Some(source) = emit::stamped_source(bytes).filter(|source| *source != hash) {
        let message = format!(
            "{name} was made from another program than {}, or that was changed since (checksum {source} in the stamp, {hash} of the program)",
            original.name()
        );
        warn(
            Code::OTHER_STAMP,
            message,
            "give the program from which it was made; if that has changed, correct it again",
        );
    }
    if let Some(promise) = emit::stamped_promise(bytes).filter(|_| is_changed == Some(false)) {
        return Some(promised.map_or(promise, |tolerance_mm| Promise { tolerance_mm, ..promise }));
    }
    let promise = assumed();
    if promised.is_none() {
        let message = format!(
            "the tolerance in the stamp of {name} is not plausible; {} µm are assumed",
            um_from_mm(promise.tolerance_mm)
        );
        warn(Code::PROMISE_ASSUMED, message, "give it with --promised, or correct the program again");
    }
    Some(promise)
}
