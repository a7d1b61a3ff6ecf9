//! Path deviations at feed: passes the elements of a program through the axis model on their way to the comparison (`ncfix verify --at-feed`).

use crate::correction::contouring;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Machine, Servo};
use ncfix_machine::snc::{Element, Origin};
use ncfix_model::Model;
use ncfix_path::path::CorrectionOptions;
use ncfix_path::servo::{Run, Tally};
use ncfix_report::json::AtFeed;

/// A program on its way through the servo loops.
pub(crate) struct Driven<'a> {
    run: Run<'a>,
    tally: Tally,
}

impl<'a> Driven<'a> {
    /// Before the first block.
    pub(crate) fn new(machine: &Machine, servo: &Servo, model: &'a Model, options: &CorrectionOptions) -> Driven<'a> {
        Driven { run: Run::new(machine, servo, model, options), tally: Tally::default() }
    }

    /// Takes the next element.
    pub(crate) fn element(&mut self, element: &Element) {
        let Driven { run, tally } = self;
        run.element(element, block_of(element.origin), &mut |moment| tally.note(moment));
    }

    /// Ends the program; `source` finds its files.
    pub(crate) fn finish(mut self, source: impl Fn(FileId) -> Option<Source>) -> AtFeed {
        let Driven { run, tally } = &mut self;
        run.finish(&mut |moment| tally.note(moment));
        let (file, line) = place_of(tally.max_at);
        let place = (tally.max_mm > 0.0).then(|| source(file)).flatten();
        AtFeed {
            contouring: contouring(tally),
            file: place.as_ref().map(|source| source.name().to_owned()),
            line: place.map(|_| line),
            time_s: run.time_s(),
        }
    }
}

/// A number for a place in a program.
pub(crate) fn block_of(origin: Origin) -> u64 {
    u64::from(origin.file.0) << 32 | u64::from(origin.line)
}

/// File and line of a number.
pub(crate) fn place_of(block: u64) -> (FileId, u32) {
    (FileId((block >> 32) as u16), block as u32)
}
