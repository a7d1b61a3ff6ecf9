//! From a running program to the text of its correction: in one thread, or execution, correction and writing side by side.
//!
//! Each stage gets what the one before it yields, in its order, and knows nothing of the others; so the text is the same whatever the
//! number of threads.

use std::io::{self, Write};
use std::panic::resume_unwind;
use std::thread::{available_parallelism, scope};

use crate::channel::channel;
use crate::run::Running;
use ncfix_base::diagnostic::Diagnostic;
use ncfix_machine::machine::{Machine, Servo};
use ncfix_machine::snc::Element;
use ncfix_model::Model;
use ncfix_path::emit::{self, Writer};
use ncfix_path::path::{CorrectionOptions, Corrector, Output, PoseSample, Prediction};
use ncfix_path::servo::{Limited, Limiter};

/// Stages, and so the most threads that are of any use.
pub(crate) const MOST_THREADS: usize = 3;
/// Bytes of a program below which threads cost more than they save.
const WORTH_THREADS: usize = 256 * 1024;

/// The correction of a program in stages.
pub(super) struct Pipeline<'a> {
    pub(super) machine: &'a Machine,
    pub(super) model: &'a Model,
    pub(super) options: &'a CorrectionOptions,
    /// The permitted path deviation at feed, mm, and the servo model that gives it.
    pub(super) feed_limit: Option<(f64, &'a Servo)>,
}

/// The result of the stages.
pub(super) struct Passed {
    /// Blocks written.
    pub(super) blocks: io::Result<u64>,
    /// The error along the path.
    pub(super) prediction: Prediction,
    /// Poses of the corrected moves, some of each part of the program.
    pub(super) poses: Vec<PoseSample>,
    /// The result of the feed limit, if there is one.
    pub(super) limited: Option<Limited>,
    /// Diagnostics of all stages, in the order of the program.
    pub(super) found: Vec<Diagnostic>,
}

/// The results of a correction other than its pieces.
type Learnt = (Prediction, Vec<PoseSample>, Option<Limited>);

/// The default number of threads for a program of `bytes` bytes.
pub(super) fn threads_for(bytes: usize) -> usize {
    let cores = if bytes < WORTH_THREADS { 1 } else { available_parallelism().map_or(1, usize::from) };
    // Three stages share two cores better than two do.
    if cores > 1 { MOST_THREADS } else { 1 }
}

impl Pipeline<'_> {
    /// Executes, corrects and writes to the end of the program. After the first error nothing more is written, but all diagnostics are collected.
    pub(super) fn pass(
        &self,
        running: &mut Running<'_>,
        writer: &mut dyn Writer,
        sink: &mut (dyn Write + Send),
        threads: usize,
    ) -> Passed {
        // Diagnostics are few: the execution and the corrector both stop after a hundred.
        let mut found = Vec::new();
        let note = |finding| found.push(finding);
        let (blocks, (prediction, poses, limited)) = match threads {
            0 | 1 => self.correct(running, |outputs| emit::emit(outputs, writer, sink, note)),
            2 => scope(|scope| {
                let (elements, executed) = channel();
                let rest =
                    scope.spawn(move || self.correct(executed, |outputs| emit::emit(outputs, writer, sink, note)));
                elements.put_all(running);
                rest.join().unwrap_or_else(|fault| resume_unwind(fault))
            }),
            _ => scope(|scope| {
                let (elements, executed) = channel();
                let (outputs, corrected) = channel();
                let correction = scope.spawn(move || self.correct(executed, |pieces| outputs.put_all(pieces)));
                let writing = scope.spawn(move || emit::emit(corrected, writer, sink, note));
                elements.put_all(running);
                let ((), learnt) = correction.join().unwrap_or_else(|fault| resume_unwind(fault));
                (writing.join().unwrap_or_else(|fault| resume_unwind(fault)), learnt)
            }),
        };
        Passed { blocks, prediction, poses, limited, found }
    }

    /// Corrects elements; `take` gets the pieces.
    fn correct<R>(
        &self,
        elements: impl Iterator<Item = Result<Element, Diagnostic>>,
        take: impl FnOnce(&mut dyn Iterator<Item = Result<Output, Diagnostic>>) -> R,
    ) -> (R, Learnt) {
        let mut corrector = Corrector::new(elements, self.machine, self.model, self.options.clone());
        let (done, limited) = match self.feed_limit {
            Some((limit_mm, servo)) => {
                let mut limiter = Limiter::new(&mut corrector, limit_mm, self.machine, servo, self.model, self.options);
                let done = take(&mut limiter);
                (done, Some(*limiter.limited()))
            }
            None => (take(&mut corrector), None),
        };
        (done, (corrector.prediction().clone(), corrector.poses().to_vec(), limited))
    }
}
