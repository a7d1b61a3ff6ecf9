//! Threads: G33 to G35, rigid tapping with G331 and G332, tapping with a compensating chuck (G63).
//!
//! All are straight moves. Except for G63 the spindle drives them, so they have no feed; the lead is at I, J or K (for X, Y or Z) and is passed
//! through. SF and similar words are passed through as words of their block.

use super::address::Named;
use super::channel::SinumerikAtHand;
use super::gathered::Gathered;
use super::modal::{Modal, MotionKind};
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::path::Path;
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;
use ncfix_machine::snc::{FeedUnit, MotionMode, Thread, ThreadCode};

/// Largest lead, mm (Sinumerik: 2000 mm).
const LARGEST_LEAD_MM: f64 = 2000.0;

/// The active thread code of a block.
pub(super) fn code(gathered: &Gathered, modal: &Modal) -> Option<ThreadCode> {
    match modal.modes.motion {
        _ if gathered.taps => Some(ThreadCode::G63),
        MotionKind::Thread(code) => Some(code),
        _ => None,
    }
}

/// The thread of a block with motion; `None` for another motion.
///
/// Production `thread`.
pub(super) fn thread(gathered: &Gathered, modal: &Modal, block: Span) -> Result<Option<Thread>, Fault> {
    let Some(code) = code(gathered, modal) else { return Ok(None) };
    let of_arc = [Named::Cr, Named::Turn, Named::Ar, Named::I1, Named::J1, Named::K1];
    if let Some(value) = of_arc.into_iter().find_map(|word| gathered.named(word)) {
        let message = format!("an arc word in a block with {}", code.word());
        return Err(fault(Code::BAD_ARC, value.span, message, "remove it"));
    }
    let mut leads =
        [b'I', b'J', b'K'].into_iter().zip(gathered.center).filter_map(|(letter, word)| Some((letter, word?)));
    let (lead, another) = (leads.next(), leads.next());
    let span = gathered.center_span;
    if code == ThreadCode::G63 {
        if lead.is_some() {
            return Err(bad_value(span, "G63 has no lead", "program F as speed times lead"));
        }
        return Ok(Some(Thread { code, lead: None, change: None }));
    }
    let Some((letter, (value, is_absolute))) = lead else {
        let message = format!("{} without a lead", code.word());
        return Err(bad_value(block, message, "program I, J or K, the lead along X, Y or Z, in the same block"));
    };
    if another.is_some() || is_absolute {
        return Err(bad_value(span, "a thread has one lead", "keep only the one of I, J and K along the thread axis"));
    }
    let lead_mm = value * modal.modes.scale();
    let is_signed = matches!(code, ThreadCode::G331 | ThreadCode::G332);
    if !(lead_mm.abs() <= LARGEST_LEAD_MM && (lead_mm > 0.0 || is_signed && lead_mm != 0.0)) {
        let allowed = if is_signed { "not 0, and at most" } else { "above 0 and at most" };
        let message = format!("a lead of {lead_mm} mm");
        return Err(bad_value(span, message, &format!("a lead is {allowed} {LARGEST_LEAD_MM} mm")));
    }
    let change = match (code, gathered.lead_change) {
        (ThreadCode::G34 | ThreadCode::G35, None) => {
            let message = format!("{} without F, the change of the lead", code.word());
            return Err(bad_value(span, message, "program F in the same block, mm per turn and turn"));
        }
        (_, change) => change.map(|change| change * modal.modes.scale()),
    };
    Ok(Some(Thread { code, lead: Some((letter, lead_mm)), change }))
}

/// In a block with G34 or G35, F is the change of the lead.
pub(super) fn lead_change(modal: &Modal, gathered: &mut Gathered) {
    if matches!(code(gathered, modal), Some(ThreadCode::G34 | ThreadCode::G35)) {
        gathered.lead_change = gathered.feed.take().map(|(value, _)| value);
    }
}

/// Rejects threads and positioning axes that cannot be simulated, and removes the feed of spindle-driven motions.
pub(super) fn check_manner(modal: &Modal, block: &SinumerikAtHand, path: &mut Path) -> Result<(), Fault> {
    let (what, help) = match path.motion.motion_mode {
        MotionMode::Path | MotionMode::Reference | MotionMode::Probe(_) => return Ok(()),
        MotionMode::Thread(thread) => {
            if thread.code.is_spindle_driven() {
                path.motion.feed = 0.0;
                path.motion.feed_named = false;
                path.motion.unit = FeedUnit::PerMinute;
            }
            (thread.code.word(), "end it before the thread")
        }
        MotionMode::Positioning => ("POS", "end it before the block with POS"),
    };
    let refusal = if path.setup.transform.is_some() {
        "a transformation (TRAORI)"
    } else if modal.contour.compensates() {
        "radius compensation"
    } else if block.corner.is_some() {
        "a rounding or chamfer"
    } else if path.motion.motion_mode == MotionMode::Positioning && !path.setup.frame.is_translation() {
        "a frame that rotates, scales or mirrors"
    } else {
        return Ok(());
    };
    let message = format!("{what} under {refusal} is not supported yet");
    Err(fault(Code::NOT_SUPPORTED, path.span, message, help))
}
