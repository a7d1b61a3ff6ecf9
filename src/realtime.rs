//! Corrections in the cycle of a control: a kernel that is updated with the condition of a machine, for set-points as text or in shared memory.

use std::fs::{self, File};
use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use crate::condition;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use crate::options::ConditionFiles;
use crate::tool::ToolVector;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AxisSet, Vector};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_report::number::grouped;
use ncfix_tables::realtime::ring::{Overrun, Ring, RingOrder};
use ncfix_tables::realtime::set_points::{ControlLine, NoSetPoint, SetPointLines};
use ncfix_tables::realtime::{
    Agreement, Cycle, CycleCounts, Dosing, Kernel, KernelRecipe, Publisher, ServingEnd, Updater, handover, serve,
};
use ncfix_tables::results::realtime::KernelResult;

/// The folder of named shared memory on Linux.
const SHARED: &str = "/dev/shm";

/// Reports the diagnostics that prevent the update of a kernel.
pub(crate) type Complain = fn(&Diagnostics);

/// A correction that is ready for set-points.
pub(crate) struct RealtimeCorrection {
    cycle: Cycle,
    axes: AxisSet,
    /// The properties of the kernel.
    pub(crate) kernel: KernelResult,
    /// The counts of the answers.
    pub(crate) counts: CycleCounts,
    /// The source of its kernels.
    source: KernelSource,
    /// Updates the kernel until it is dropped.
    updater: Option<Updater>,
    /// The machine with all its heads, in no condition.
    all: Machine,
}

/// Source of kernels: the machine in its newest condition.
struct KernelSource {
    machine: Arc<Mutex<Machine>>,
    recipe: KernelRecipe,
    period: Duration,
    files: ConditionFiles,
    complain: Complain,
}

impl RealtimeCorrection {
    /// Makes a kernel for a machine in its condition, which is read again in every period; `None` if there are errors. The machine has one head of those
    /// of `all`, to which a control may change.
    pub(crate) fn new(
        (machine, all): (Machine, Machine),
        recipe: KernelRecipe,
        dosing: Dosing,
        (files, period): (ConditionFiles, Duration),
        complain: Complain,
        found: &mut Diagnostics,
    ) -> Option<RealtimeCorrection> {
        let (kernel, agreement) = make(&recipe, &machine, found)?;
        let axes = kernel.axes();
        let mut result = KernelResult::new(&kernel, &agreement);
        result.heads = all.numbered_heads();
        result.heads.sort_unstable();
        let (publisher, subscriber) = handover(kernel);
        let control = &machine.machine.control;
        let cycle = Cycle::new(subscriber, dosing, control.increment_mm, control.increment_rad);
        let source = KernelSource { machine: Arc::new(Mutex::new(machine)), recipe, period, files, complain };
        let updater = Some(source.renew(publisher));
        Some(RealtimeCorrection { cycle, axes, kernel: result, counts: CycleCounts::default(), source, updater, all })
    }

    /// Changes to another tool, and to another head if one is named: kernels for the old ones are no longer made. The new one is in force from the next
    /// set-point on, and the correction goes to it in doses. `false` if there are errors.
    fn change(&mut self, head: Option<&str>, tool: ToolVector, found: &mut Diagnostics) -> bool {
        // The thread has ended before the condition of the machine is used.
        self.updater = None;
        let made = {
            let mut machine = self.source.machine.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(head) = head {
                // The sensors of this head alone are needed, in their newest state.
                let Ok(mut other) = self.all.with_head(head) else { return false };
                match condition::apply(&self.source.files, &mut other, found) {
                    Ok(true) => *machine = other,
                    Ok(false) => return false,
                    Err(why) => {
                        found.add(not_renewed(&why.to_string()), &[]);
                        return false;
                    }
                }
            }
            self.source.recipe.tool_mm = tool.vector_mm(&machine.machine);
            make(&self.source.recipe, &machine, found)
        };
        let Some((kernel, _)) = made else { return false };
        let (publisher, subscriber) = handover(kernel);
        self.cycle.replace(subscriber);
        self.updater = Some(self.source.renew(publisher));
        true
    }

    /// Answers the lines of a text, each immediately, or those that arrive together at once; a line that is not a set-point ends it.
    ///
    /// # Errors
    /// If it cannot be read or an answer cannot be written.
    pub(crate) fn answer(&mut self, input: impl Read, out: &mut dyn Write) -> Result<Option<Diagnostic>, Error> {
        let failed = |error: std::io::Error| Error::output(&error);
        let axes: Vec<_> = self.axes.iter().collect();
        let titles = axes.iter().map(|axis| format!("d{axis}_{}", if axis.is_rotary() { "urad" } else { "um" }));
        let titles = titles.chain(["signals".to_owned()]).collect::<Vec<_>>().join(",");
        writeln!(out, "{titles}").and_then(|()| out.flush()).map_err(failed)?;
        let mut lines = SetPointLines::new(BufReader::new(input), self.axes);
        loop {
            let set_point = match lines.next_line() {
                Ok(Some(ControlLine::SetPoint(set_point))) => set_point,
                Ok(Some(ControlLine::Reset)) => {
                    self.cycle.reset();
                    continue;
                }
                Ok(Some(line @ (ControlLine::Tool(_) | ControlLine::Head(..)))) => {
                    let (head, numbers) = match line {
                        ControlLine::Head(name, numbers) => (Some(name), numbers),
                        ControlLine::Tool(numbers) => (None, numbers),
                        ControlLine::SetPoint(_) | ControlLine::Reset => continue,
                    };
                    let tool = match numbers[..] {
                        [x, y, z] => ToolVector::Tip(Vector::new(x, y, z)),
                        _ => ToolVector::Length(numbers.first().copied().unwrap_or_default()),
                    };
                    if let Some(name) = head.as_deref().filter(|name| !self.all.heads().any(|one| one == *name)) {
                        out.flush().map_err(failed)?;
                        return Ok(Some(self.no_head(&format!("the head {name}"))));
                    }
                    let mut found = Diagnostics::default();
                    let is_made = self.change(head.as_deref(), tool, &mut found);
                    (self.source.complain)(&found);
                    if is_made {
                        continue;
                    }
                    out.flush().map_err(failed)?;
                    return Ok(Some(self.no_kernel()));
                }
                Ok(None) => break,
                Err(NoSetPoint::Unreadable(error)) => {
                    return Err(Error::usage(format!("cannot read standard input: {error}")));
                }
                Err(NoSetPoint::Wrong { line, column, what }) => {
                    out.flush().map_err(failed)?;
                    let message = format!("standard input:{line}:{column}: {what}");
                    return Ok(Some(Diagnostic::nowhere(Code::BAD_SET_POINT, message, self.held())));
                }
            };
            let answer = self.counts.step(&mut self.cycle, &set_point);
            let written = axes.iter().try_for_each(|&axis| {
                let value = answer.correction[axis];
                let value = if axis.is_rotary() { urad_from_rad(value) } else { um_from_mm(value) };
                write!(out, "{value:.4},")
            });
            let written = written.and_then(|()| writeln!(out, "{}", answer.signals.words()));
            // A sender of single lines gets every answer immediately; a sender of several lines gets the answers together.
            let written = if lines.has_more() { written } else { written.and_then(|()| out.flush()) };
            written.map_err(failed)?;
        }
        out.flush().map_err(failed)?;
        Ok(None)
    }

    /// The help text of a run that ends at a line.
    fn held(&self) -> String {
        format!(
            "{} set-points before it were answered, none after it; the control must hold its last correction",
            grouped(self.counts.set_points)
        )
    }

    /// Opens the rings in a file, each with `records` records.
    ///
    /// # Errors
    /// If they cannot be made.
    pub(crate) fn ring(&self, file: &RingFile, records: u64) -> Result<Ring, Error> {
        Ring::create(&file.file, self.axes, records).map_err(|error| Error::file("write", &file.path, &error))
    }

    /// Serves rings until the control or `is_over` ends it.
    pub(crate) fn serve(&mut self, ring: &Ring, is_over: impl Fn() -> bool) -> ServingEnd {
        loop {
            match serve(ring, &mut self.cycle, &mut self.counts, &is_over) {
                ServingEnd::Order(order) => {
                    let mut found = Diagnostics::default();
                    let is_made = self.carry_out(&order, &mut found);
                    (self.source.complain)(&found);
                    match is_made {
                        Some(true) => {}
                        Some(false) => return ServingEnd::NoKernel,
                        None => return ServingEnd::Order(order),
                    }
                }
                end => return end,
            }
        }
    }

    /// Carries out an order of a ring; `Some(false)` if there is no kernel, `None` if it is no order for this machine.
    fn carry_out(&mut self, order: &RingOrder, found: &mut Diagnostics) -> Option<bool> {
        let (head, tool_mm) = match order {
            RingOrder::Tool(tool_mm) => (None, tool_mm),
            RingOrder::Head(number, tool_mm) => {
                let heads = self.all.numbered_heads();
                (Some(heads.into_iter().find(|(own, _)| own == number)?.1), tool_mm)
            }
            RingOrder::Unknown(_) => return None,
        };
        let is_sound = tool_mm.iter().all(|mm| mm.is_finite());
        Some(is_sound && self.change(head.as_deref(), ToolVector::Tip(Vector::from(*tool_mm)), found))
    }

    /// The diagnostic for an order that is not possible: it does not exist, the machine lacks its head, or its tool has no kernel.
    pub(crate) fn no_order(&self, end: &ServingEnd) -> Diagnostic {
        match end {
            ServingEnd::Order(RingOrder::Head(number, _)) => self.no_head(&format!("the head {number}")),
            ServingEnd::Order(RingOrder::Unknown(number)) => {
                let message = format!("the control wrote the order {number}, which does not exist");
                Diagnostic::nowhere(Code::BAD_SET_POINT, message, self.held())
            }
            _ => self.no_kernel(),
        }
    }

    /// The diagnostic for a head that the machine lacks.
    fn no_head(&self, what: &str) -> Diagnostic {
        let known: Vec<String> = self.kernel.heads.iter().map(|(number, name)| format!("{number} {name}")).collect();
        let has = if known.is_empty() { "no [[head]]".to_owned() } else { known.join(", ") };
        let message = format!("the control selects {what}, and the machine {} has {has}", self.all.machine.name);
        Diagnostic::nowhere(Code::BAD_SET_POINT, message, self.held())
    }

    /// The diagnostic for a tool without a kernel.
    fn no_kernel(&self) -> Diagnostic {
        let message = "the tool of the set-points has no kernel".to_owned();
        Diagnostic::nowhere(Code::BAD_SET_POINT, message, self.held())
    }

    /// The diagnostic for a control that writes past the end of a ring with `records` records.
    pub(crate) fn overrun(&self, overrun: Overrun, records: u64) -> Diagnostic {
        let what = match overrun {
            Overrun::SetPoints(count) => format!("the control wrote {count} set-points into a ring of {records}"),
            Overrun::WentBack(count) => {
                format!("the count of set-points written decreased: it is {count} below those read")
            }
            Overrun::CorrectionsRead(count) => format!("the control read {count} more corrections than there are"),
            Overrun::Corrections(_) => "the count of corrections read decreased".to_owned(),
        };
        let help = format!(
            "{} set-points were answered; wait where the counts are {records} apart, or make the ring larger with --records",
            grouped(self.counts.set_points)
        );
        Diagnostic::nowhere(Code::BAD_SET_POINT, what, help)
    }
}

/// The file of rings in shared memory, which is removed when this is dropped.
pub(crate) struct RingFile {
    file: File,
    path: PathBuf,
}

impl RingFile {
    /// A new file: a name in the shared memory, or a path with a separator.
    ///
    /// # Errors
    /// If it cannot be made, or exists already.
    pub(crate) fn create(name: &str) -> Result<RingFile, Error> {
        let path = if name.contains(['/', '\\']) { PathBuf::from(name) } else { PathBuf::from(SHARED).join(name) };
        let file = File::options().read(true).write(true).create_new(true).open(&path);
        let file = file.map_err(|error| match error.kind() {
            std::io::ErrorKind::AlreadyExists => Error::usage(format!(
                "{} already exists: another ncfix serves it, or ended unexpectedly; remove it if none is running",
                path.display()
            )),
            _ => Error::file("write", &path, &error),
        })?;
        Ok(RingFile { file, path })
    }

    /// Its path.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for RingFile {
    fn drop(&mut self) {
        // Another process may have removed it already.
        let _ = fs::remove_file(&self.path);
    }
}

/// The machine with the head at the start, in its condition; `None` if it cannot be used.
///
/// # Errors
/// If the head is not clear, or a file cannot be read.
pub(crate) fn in_use(
    all: &Machine,
    head: Option<&str>,
    files: &ConditionFiles,
    found: &mut Diagnostics,
) -> Result<Option<Machine>, Error> {
    let mut chosen = all.clone().with_one_head(head)?;
    Ok(condition::apply(files, &mut chosen, found)?.then_some(chosen))
}

/// A kernel for the condition of a machine; `None` if there are errors.
fn make(recipe: &KernelRecipe, machine: &Machine, found: &mut Diagnostics) -> Option<(Kernel, Agreement)> {
    let mut own = Vec::new();
    let made = recipe.make(&machine.machine, &machine.model(), &mut own);
    found.extend(own, &[]);
    made
}

impl KernelSource {
    /// Reads the condition again in every period, in a separate thread. An unusable condition is reported, and the kernel in use stays.
    fn renew(&self, publisher: Publisher) -> Updater {
        let (shared, choice, recipe, complain) =
            (Arc::clone(&self.machine), self.files.clone(), self.recipe, self.complain);
        let mut machine = self.machine.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let files = machine.files.len();
        let mut last = machine.state.clone();
        Updater::start(publisher, self.period, move || {
            if choice.files.is_empty() {
                return None;
            }
            machine.files.truncate(files);
            let mut found = Diagnostics::default();
            let read = condition::apply(&choice, &mut machine, &mut found);
            let is_usable = matches!(read, Ok(true));
            if is_usable && machine.state == last {
                return None;
            }
            let made = if is_usable { make(&recipe, &machine, &mut found) } else { None };
            if made.is_some() {
                let mut current = shared.lock().unwrap_or_else(PoisonError::into_inner);
                current.clone_from(&machine);
                current.files.truncate(files);
            } else {
                let why = read.err().map_or_else(|| "the state cannot be used".to_owned(), |error| error.to_string());
                found.add(not_renewed(&why), &[]);
                complain(&found);
            }
            // A refused condition is not tried again until the state changes.
            last.clone_from(&machine.state);
            made.map(|(kernel, _)| kernel)
        })
    }
}

fn not_renewed(why: &str) -> Diagnostic {
    let help = "correct the state; it is read again after --update-s";
    Diagnostic::nowhere(Code::NOT_RENEWED, format!("the kernel was not updated: {why}"), help)
}
