//! The program of MCALL: blocks after which the control executes it, and blocks after which this is uncertain.

use super::level::Interpreter;
use super::modal::MotionKind;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::{Address, Block, Body, Value, Word};
use ncfix_base::diagnostic::Code;

impl Interpreter<'_> {
    /// Executes the modal call after a block with motion.
    pub(super) fn trigger(&mut self, block: &Block) -> bool {
        if self.levels.iter().any(|level| level.own.is_modal) {
            return false;
        }
        let Some(entry) = self.own.modal_call.clone() else { return false };
        if let Err(found) = self.check_depth("the modal program", block.span) {
            self.report_here(found);
            return false;
        }
        self.begin(entry, block.line);
        true
    }

    /// Rejects a block that moves no geometry axis on the path, but after which the control may execute the modal program at the current position.
    ///
    /// After F or S, or G0 or G1 with other codes, it does so while G0 or G1 is in force (programming manual 840D sl, "modal subprogram call").
    /// The manual says nothing of a rotary axis alone and of POS: without a hole, the part would lack it; with one, the drill would enter twice.
    pub(super) fn check_still_block(&self, block: &Block) -> Result<(), Fault> {
        let is_inside = self.levels.iter().any(|level| level.own.is_modal);
        let Some(level) = self.levels.last().filter(|level| level.own.cycle.is_none() && !is_inside) else {
            return Ok(());
        };
        if self.channel.block.has_moved_beside {
            let message = "only a rotary axis or POS moves in this block after MCALL: it is uncertain whether the control executes the modal program after it";
            let help = "program MCALL alone before this block, and the MCALL of the cycle again after it";
            return Err(fault(Code::TWO_MEANINGS, block.span, message, help));
        }
        if !matches!(block.body, Body::Words)
            || !matches!(self.channel.modal.modes.motion, MotionKind::Rapid | MotionKind::Line)
        {
            return Ok(());
        }
        let words = self.programs[level.program].program.words_of(block);
        let has_code = |codes: &[f64]| {
            words.iter().any(|word: &Word| {
                matches!((word.address, word.value), (Address::Letter(b'G'), Value::Number(code, _)) if codes.contains(&code))
            })
        };
        let has_value = words.iter().any(|word| matches!(word.address, Address::Letter(b'F' | b'S')));
        // F and S beside G4 are its time.
        if has_code(&[4.0]) || !(has_value || has_code(&[0.0, 1.0])) {
            return Ok(());
        }
        let message = "a block with F, S, G0 or G1 without a motion after MCALL: the control executes the modal program at the current position too";
        let help = "write the words in a block before MCALL, or in that of the first position";
        Err(fault(Code::TWO_MEANINGS, block.span, message, help))
    }
}
