//! The source of the lines of a transfer: a thread executes and corrects; the second step is added when a line is requested.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError};
use std::time::{Duration, Instant};

use crate::run::{self, Opened};
use ncfix_base::geometry::AXES;
use ncfix_base::units::um_from_mm;
use ncfix_dnc::drip::Lines;
use ncfix_dnc::feed::{Line, Supplied, Supply};
use ncfix_language::exec::RapidOrder;
use ncfix_model::Model;
use ncfix_path::path::{Corrector, Output};

use super::job::Transfer;
use super::options::FeedOptions;
use super::thermal::Thermal;

/// Number of batches made in advance: enough to cover the longest search for an arc, few enough to forget quickly.
pub(super) const AHEAD: usize = 4;
/// Outputs of a batch: waking the other thread for each single output costs more than making it.
const BATCH: usize = 64;
/// The longest time that finished lines wait for a batch to fill.
const BATCH_WITHIN: Duration = Duration::from_millis(1);

/// A new warning is possible after the shift has fallen below this share of the limit.
const BELOW: f64 = 0.9;
/// Largest number of elements that are skipped in one step.
const MOST_PASSED: usize = 256;

/// The messages from the thread.
pub(super) enum Made {
    /// The next outputs of the first step.
    Outputs(Vec<Output>),
    /// An error that the survey did not have.
    Fault(String),
    /// The program has ended.
    End,
}

/// Executes and corrects until the program ends, or the receiver closes.
pub(super) fn produce(job: &Transfer, model: &Model, opened: Opened, to: &SyncSender<Made>) {
    let machine = &job.machine.machine;
    let running = job.program.start_as(opened, machine, run::strict(RapidOrder::All));
    let mut last = Made::End;
    let mut batch = Vec::with_capacity(BATCH);
    let mut begun = Instant::now();
    for output in Corrector::new(running, machine, model, job.writing.options.clone()) {
        match output {
            Ok(output) => batch.push(output),
            Err(finding) if finding.is_error() => {
                last = Made::Fault(finding.message);
                break;
            }
            Err(_) => continue,
        }
        if batch.len() >= BATCH || begun.elapsed() > BATCH_WITHIN {
            let full = std::mem::replace(&mut batch, Vec::with_capacity(BATCH));
            if to.send(Made::Outputs(full)).is_err() {
                return;
            }
            begun = Instant::now();
        }
    }
    // A closed receiver is not an error.
    let _ = to.send(Made::Outputs(batch));
    let _ = to.send(last);
}

/// The lines of a job.
pub(super) struct LineSource<'a> {
    made: Receiver<Made>,
    batch: std::vec::IntoIter<Output>,
    /// The result of the execution, after the last batch.
    ended: Option<Result<(), String>>,
    lines: Lines<'a>,
    thermal: &'a Thermal,
    /// Elements up to this one are taken without being sent.
    skip: u64,
    /// The lines that are sent before the first line, and meanwhile that line.
    first: VecDeque<Line>,
    held: Option<Line>,
    max_shift_mm: f64,
    warn_shift_mm: f64,
    is_beyond: bool,
    passed: u64,
    is_over: bool,
    /// The current temperatures, until a line has carried them.
    temperatures_c: Option<Arc<[(String, f64)]>>,
    told: Option<Arc<[(String, f64)]>>,
    /// The first shift beyond the limit for a warning, if any: its size, and the line of the source.
    pub(super) warned: Option<(String, u32)>,
    /// The time that the control needs for the supplied lines, s.
    pub(super) busy_s: f64,
    number: u64,
}

impl<'a> LineSource<'a> {
    /// Begins after the element `skip`, with some lines before.
    pub(super) fn new(
        options: &FeedOptions,
        made: Receiver<Made>,
        lines: Lines<'a>,
        thermal: &'a Thermal,
        (skip, first): (u64, &[String]),
    ) -> Self {
        let line = |text: &String| Line { text: text.clone().into_bytes(), element: skip, ..Line::default() };
        LineSource {
            made,
            batch: Vec::new().into_iter(),
            ended: None,
            lines,
            thermal,
            skip,
            first: first.iter().map(line).collect(),
            held: None,
            max_shift_mm: options.max_shift_mm,
            warn_shift_mm: options.warn_shift_mm,
            is_beyond: false,
            passed: 0,
            is_over: false,
            temperatures_c: None,
            told: None,
            warned: None,
            busy_s: 0.0,
            number: 0,
        }
    }

    /// Compares the requested shifts with the limits.
    fn judge(&mut self, line: &Line) -> Result<(), String> {
        let largest = AXES
            .into_iter()
            .filter(|axis| !axis.is_rotary())
            .map(|axis| (axis, line.target[axis.slot()]))
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let Some((axis, shift_mm)) = largest else { return Ok(()) };
        let said = || format!("temperatures require {:+.1} µm in {axis}", um_from_mm(shift_mm));
        // A value that is not a number exceeds every limit.
        if shift_mm.is_nan() || shift_mm.abs() > self.max_shift_mm {
            let limit = um_from_mm(self.max_shift_mm);
            return Err(format!(
                "{} at line {} of the original, more than {limit} µm (--max-shift); check the sensors and the model",
                said(),
                line.source_line
            ));
        }
        // One warning, until the shift has been well below the limit.
        let is_beyond = shift_mm.abs() > self.warn_shift_mm;
        if is_beyond && !self.is_beyond {
            self.warned = Some((said(), line.source_line));
        }
        self.is_beyond = is_beyond || self.is_beyond && shift_mm.abs() > BELOW * self.warn_shift_mm;
        Ok(())
    }

    fn supply(&mut self, mut line: Line) -> Supplied {
        if let Err(why) = self.judge(&line) {
            return Supplied::Fault(why);
        }
        self.number += 1;
        line.number = self.number;
        self.busy_s += line.busy().as_secs_f64();
        Supplied::Line(line)
    }
}

impl LineSource<'_> {
    /// Checks for the next batch.
    fn receive(&mut self) {
        if self.batch.len() > 0 || self.ended.is_some() {
            return;
        }
        match self.made.try_recv() {
            Ok(Made::Outputs(batch)) => self.batch = batch.into_iter(),
            Ok(Made::Fault(why)) => self.ended = Some(Err(why)),
            Ok(Made::End) => self.ended = Some(Ok(())),
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => {
                self.ended = Some(Err("the execution of the program was aborted".into()));
            }
        }
    }

    /// The next line to be sent.
    fn advance(&mut self) -> Supplied {
        // Skipped elements take time too, and the user may press a key meanwhile.
        for _ in 0..MOST_PASSED {
            while let Some(line) = self.lines.pop() {
                if line.element > self.skip {
                    return Supplied::Line(line);
                }
            }
            if self.is_over {
                return Supplied::End;
            }
            if let Some(output) = self.batch.next() {
                self.passed += 1;
                // Skipped elements get no shift: the first path that is sent begins without one.
                let now = if self.passed > self.skip { self.thermal.now() } else { Now::default() };
                if now.temperatures_c.is_some() {
                    self.temperatures_c = now.temperatures_c;
                }
                if let Err(finding) = self.lines.take(output, now.model.as_ref(), now.is_frozen) {
                    return Supplied::Fault(finding.message);
                }
                continue;
            }
            self.receive();
            match &self.ended {
                None if self.batch.len() == 0 => return Supplied::NotYet,
                None => {}
                Some(Err(why)) => return Supplied::Fault(why.clone()),
                Some(Ok(())) => {
                    self.is_over = true;
                    if let Err(finding) = self.lines.finish() {
                        return Supplied::Fault(finding.message);
                    }
                }
            }
        }
        Supplied::NotYet
    }
}

impl Supply for LineSource<'_> {
    fn next(&mut self) -> Supplied {
        let next = self.held.take().map_or_else(|| self.advance(), Supplied::Line);
        let Supplied::Line(mut line) = next else { return next };
        let is_news = |now: &Arc<_>| self.told.as_ref().is_none_or(|told| !Arc::ptr_eq(told, now));
        if let Some(now) = self.temperatures_c.take_if(|now| is_news(now)) {
            self.told = Some(Arc::clone(&now));
            line.temperatures_c = Some(now);
        }
        // The approach is sent when the first line is ready.
        match self.first.pop_front() {
            Some(first) => {
                self.held = Some(line);
                self.supply(first)
            }
            None => self.supply(line),
        }
    }

    fn look_ahead(&mut self) {
        self.receive();
    }
}

/// The current model.
#[derive(Clone, Default)]
pub(super) struct Now {
    /// The model; `None` without sensors.
    pub(super) model: Option<Arc<Model>>,
    /// True if a sensor is in doubt.
    pub(super) is_frozen: bool,
    /// The temperatures of the model, °C.
    pub(super) temperatures_c: Option<Arc<[(String, f64)]>>,
}
