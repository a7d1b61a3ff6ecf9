//! A control that reads blockwise (FE1): a block whose check character fits is answered by ACK as soon as there is room, any other by NAK.

use std::collections::VecDeque;

use super::{Control, Faults};

/// Blocks that wait.
const BUFFER: usize = 5;

pub(crate) struct Blockwise {
    faults: Faults,
    block: Vec<u8>,
    /// Whether the next byte is the check character.
    checks: bool,
    was_opened: bool,
    /// Whether the end of the program was heard.
    pub(crate) is_ended: bool,
    buffer: VecDeque<Vec<u8>>,
    waiting: Option<Vec<u8>>,
    blocks: u64,
    /// Blocks that were taken.
    taken: u64,
    answers: u64,
    done_s: f64,
    busy_s: f64,
    out: Vec<u8>,
    executed: Vec<Vec<u8>>,
}

impl Blockwise {
    pub(crate) fn new(faults: &Faults, busy_s: f64) -> Blockwise {
        Blockwise {
            faults: faults.clone(),
            block: Vec::new(),
            checks: false,
            was_opened: false,
            is_ended: false,
            buffer: VecDeque::new(),
            waiting: None,
            blocks: 0,
            taken: 0,
            answers: 0,
            done_s: 0.0,
            busy_s,
            out: Vec::new(),
            executed: Vec::new(),
        }
    }

    fn answer(&mut self, byte: u8) {
        self.answers += 1;
        if self.faults.lost.contains(&self.answers) {
            return;
        }
        let byte = if self.faults.garbled.contains(&self.answers) { byte ^ 0x40 } else { byte };
        self.out.push(byte);
        if self.faults.doubled.contains(&self.answers) {
            self.out.push(byte);
        }
    }

    fn end_of_block(&mut self, check: u8) {
        let mut block = std::mem::take(&mut self.block);
        self.blocks += 1;
        if self.faults.corrupted.contains(&self.blocks) {
            let at = block.len() / 2;
            block[at] ^= 0x04;
        }
        let sum = block.iter().fold(0, |sum, byte| sum ^ byte);
        // The same block is refused however often it comes.
        let is_refused = block[0] == 0x02 && self.faults.refuses == Some(self.taken + 1);
        if sum != check || is_refused {
            return self.answer(0x15);
        }
        match block[0] {
            0x01 => {
                assert_eq!(block, b"\x01H15E\x17");
                self.was_opened = true;
                self.answer(0x06);
            }
            _ => {
                self.taken += 1;
                self.waiting = Some(block[1..block.len() - 1].to_vec());
            }
        }
    }
}

impl Control for Blockwise {
    fn hear(&mut self, byte: u8, now_s: f64) {
        self.tick(now_s);
        match byte {
            _ if std::mem::take(&mut self.checks) => self.end_of_block(byte),
            0x17 => {
                self.block.push(byte);
                self.checks = true;
            }
            0x01 | 0x02 => self.block = vec![byte],
            0x03 | 0x04 if self.block.is_empty() => self.is_ended = true,
            0x11 => {}
            _ => self.block.push(byte),
        }
    }

    fn tick(&mut self, now_s: f64) {
        while self.done_s <= now_s {
            let Some(block) = self.buffer.pop_front() else { break };
            self.executed.push(block);
            self.done_s += self.busy_s;
        }
        if self.buffer.len() < BUFFER
            && let Some(block) = self.waiting.take()
        {
            if self.buffer.is_empty() {
                self.done_s = now_s + self.busy_s;
            }
            self.buffer.push_back(block);
            self.answer(0x06);
        }
    }

    fn say(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    fn executed(&self) -> &[Vec<u8>] {
        &self.executed
    }
}
