//! Simulation of programs in the servo loops of a machine, recorded as traces.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;

use crate::compare::{block_of, place_of};
use crate::correction::servo;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use crate::program::Program;
use crate::run::{Running, Watch};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::units::um_from_mm;
use ncfix_language::exec::{self, RapidOrder};
use ncfix_machine::machine::Servo;
use ncfix_metrology::measure::noise::Noise;
use ncfix_model::Model;
use ncfix_path::path::CorrectionOptions;
use ncfix_path::servo::{CycleState, Run, Tally};
use ncfix_report::number::{duration, grouped, micrometers};

/// Largest number of rows of a trace: 3 GB of text, more than the recorder of any control keeps.
const MOST_ROWS: u64 = 20_000_000;

/// Options of a simulation.
///
/// ```
/// use ncfix::prelude::*;
///
/// let options = SimulateOptions::default();
/// assert!(options.feeds_mm_min.is_empty() && options.noise_mm.is_none());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SimulateOptions {
    /// Feeds with which the program runs, one after the other, mm/min; if empty, those of the program.
    pub feeds_mm_min: Vec<f64>,
    /// Standard deviation of the readings, mm.
    pub noise_mm: Option<f64>,
    /// Seed of the noise: the same seed gives the same noise.
    pub seed: u64,
}

/// The recorded data of a simulated program.
///
/// ```
/// use ncfix::prelude::*;
///
/// let text = std::fs::read_to_string("samples/machines/demo.toml")?
///     + "[servo]\ncycle_ms = 3\nsmoothing_ms = 24\ncorner_tolerance_um = 50\n"
///     + &["X", "Y", "Z"].map(|axis| format!("[servo.{axis}]\nvelocity_gain_per_s = 50\nfeed_forward = 0.98\nmax_acceleration_m_s2 = 5\n")).concat();
/// let machine = Machine::from_text("mill.toml", &text)?;
/// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X10 F2000\nY10\nM30\n", DialectChoice::Sinumerik)?;
/// let recorded = program.simulate(&machine, &SimulateOptions::default(), &mut std::io::sink())?;
/// assert!(recorded.rows > 0 && recorded.time_s > 0.0);
/// assert!(recorded.worst.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Recorded {
    /// Rows, one for each cycle of the control.
    pub rows: u64,
    /// Time on the machine, s.
    pub time_s: f64,
    /// The path deviation of the tool.
    pub(crate) tally: Tally,
    /// The place with the largest path deviation: `part.mpf:12`.
    pub worst: Option<String>,
}

impl Recorded {
    /// Root mean square and maximum of the distance of the tool from its path, µm.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let text = std::fs::read_to_string("samples/machines/demo.toml")?
    ///     + "[servo]\ncycle_ms = 3\nsmoothing_ms = 24\ncorner_tolerance_um = 50\n"
    ///     + &["X", "Y", "Z"].map(|axis| format!("[servo.{axis}]\nvelocity_gain_per_s = 50\nfeed_forward = 0.98\nmax_acceleration_m_s2 = 5\n")).concat();
    /// let machine = Machine::from_text("mill.toml", &text)?;
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X10 F2000\nY10\nM30\n", DialectChoice::Sinumerik)?;
    /// let recorded = program.simulate(&machine, &SimulateOptions::default(), &mut std::io::sink())?;
    /// let [rms_um, max_um] = recorded.off_path_um();
    /// assert!(0.0 < rms_um && rms_um < max_um);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn off_path_um(&self) -> [f64; 2] {
        [um_from_mm(self.tally.rms_mm()), um_from_mm(self.tally.max_mm)]
    }

    /// Summary of the record.
    pub(crate) fn sentence(&self) -> String {
        let [rms, max] = self.off_path_um().map(micrometers);
        let place = self.worst.as_ref().map_or(String::new(), |place| format!(" at {place}"));
        format!(
            "{} rows of {} simulated, path deviation of the tool {rms} RMS, {max} maximum{place}",
            grouped(self.rows),
            duration(self.time_s)
        )
    }
}

impl Program {
    /// Passes the program through the servo model of the machine and writes a trace as the control would record it, a table (CSV) of set-points,
    /// encoders and the tool. The machine file needs `[servo]`.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let text = std::fs::read_to_string("samples/machines/demo.toml")?
    ///     + "[servo]\ncycle_ms = 3\nsmoothing_ms = 24\ncorner_tolerance_um = 50\n"
    ///     + &["X", "Y", "Z"].map(|axis| format!("[servo.{axis}]\nvelocity_gain_per_s = 50\nfeed_forward = 0.98\nmax_acceleration_m_s2 = 5\n")).concat();
    /// let machine = Machine::from_text("mill.toml", &text)?;
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X10 F2000\nY10\nM30\n", DialectChoice::Sinumerik)?;
    /// let mut table = Vec::new();
    /// let recorded = program.simulate(&machine, &SimulateOptions::default(), &mut table)?;
    /// assert_eq!(table.iter().filter(|&&byte| byte == b'\n').count() as u64, recorded.rows + 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the program cannot be parsed or has no motion, the machine file has no `[servo]`, or `out` refuses the text.
    pub fn simulate(
        &self,
        machine: &Machine,
        options: &SimulateOptions,
        out: &mut dyn Write,
    ) -> Result<Recorded, Error> {
        let mut found = Diagnostics::default();
        let Some(mut recorder) = Recorder::new(self, machine, options, &mut found) else {
            return Err(Error::found(found));
        };
        let written = recorder.record(out, None, &mut |_, _| (), &mut found)?;
        let is_whole = written.map_err(|error| Error::sink(&error))?;
        if is_whole { Ok(recorder.recorded) } else { Err(Error::found(found)) }
    }
}

/// The diagnostic for a program that takes too long to record.
fn too_long(rows: u64) -> Diagnostic {
    let message = match rows {
        MOST_ROWS.. => format!("the trace would have more than {} rows", grouped(MOST_ROWS)),
        _ => "a chord of a move would take more than an hour".to_owned(),
    };
    let help = "simulate a part of the program, at higher feeds, or with a longer servo.cycle_ms";
    Diagnostic::nowhere(Code::TOO_MANY_BLOCKS, message, help)
}

/// Writes the rows of a trace.
pub(crate) struct Recorder<'a> {
    options: &'a SimulateOptions,
    program: &'a Program,
    machine: &'a Machine,
    servo: &'a Servo,
    model: Arc<Model>,
    pub(crate) recorded: Recorded,
}

/// A pass over the program.
struct Pass<'p> {
    feed: Option<f64>,
    /// The number of tools so far: a run has one.
    tools: u32,
    tool_mm: Option<Vector>,
    label: String,
    sigma_mm: f64,
    noise: &'p mut Noise,
}

impl Pass<'_> {
    /// A change of the tool begins another run.
    fn take(&mut self, tool_mm: &Vector) {
        if self.tool_mm != Some(*tool_mm) {
            self.tool_mm = Some(*tool_mm);
            self.tools += 1;
            let feed = self.feed.map_or_else(|| "program".to_owned(), |feed| format!("F{feed}"));
            self.label = if self.tools == 1 { feed } else { format!("{feed} tool {}", self.tools) };
        }
    }
}

impl<'a> Recorder<'a> {
    /// A recorder of a program; `None` if there are errors.
    pub(crate) fn new(
        program: &'a Program,
        machine: &'a Machine,
        options: &'a SimulateOptions,
        found: &mut Diagnostics,
    ) -> Option<Recorder<'a>> {
        let servo = servo(&machine.machine, found)?;
        Some(Recorder {
            options,
            program,
            machine,
            servo,
            model: Arc::new(machine.model()),
            recorded: Recorded::default(),
        })
    }

    /// Runs the program once with each feed and writes the table; returns whether it is complete. `guard` reports other reasons against the output
    /// when the list of read files is complete.
    ///
    /// # Errors
    /// If the dialect does not exist; the inner error is that of `out`.
    pub(crate) fn record(
        &mut self,
        out: &mut dyn Write,
        watch: Option<fn() -> Box<dyn Watch>>,
        guard: &mut dyn FnMut(&[PathBuf], &mut Diagnostics),
        found: &mut Diagnostics,
    ) -> Result<io::Result<bool>, Error> {
        if let Err(error) = self.head(out) {
            return Ok(Err(error));
        }
        let feeds = &self.options.feeds_mm_min;
        let each: Vec<Option<f64>> =
            if feeds.is_empty() { vec![None] } else { feeds.iter().copied().map(Some).collect() };
        let mut noise = Noise::new(self.options.seed);
        for feed in each {
            // Each pass starts with new variables, counters and inputs of the program, as in a first run.
            let mut own = Diagnostics::default();
            let Some(opened) = self.program.open(Some(self.machine), &mut own)? else {
                found.absorb(own);
                return Ok(Ok(false));
            };
            let options = exec::Options { rapid_order: RapidOrder::Stated, ..exec::Options::default() };
            let mut running = self.program.start_as(opened, &self.machine.machine, options);
            if let Some(watch) = watch {
                running = running.watched(watch());
            }
            if let Err(error) = self.pass(&mut running, feed, &mut noise, &mut own, out) {
                return Ok(Err(error));
            }
            guard(&running.files(), &mut own);
            // The diagnostics of a second pass were already reported.
            let is_over = own.has_errors();
            if feed == feeds.first().copied() {
                found.absorb(own);
            }
            if is_over {
                return Ok(Ok(false));
            }
        }
        if self.recorded.rows == 0 && !found.has_errors() {
            let message = format!("{} makes no moves", self.program.name());
            let help = "give a program that moves the axes: there is nothing to record";
            found.add(Diagnostic::nowhere(Code::UNKNOWN_START, message, help), &[]);
        } else if self.recorded.tally.cycles() == 0 && !found.has_errors() {
            let message = format!("{} makes no move with feed whose start is known", self.program.name());
            let help = "program all axes before the first move with feed, or give their positions with --start";
            found.add(Diagnostic::nowhere(Code::UNKNOWN_START, message, help), &[]);
        }
        Ok(Ok(!found.has_errors()))
    }

    fn axes(&self) -> impl Iterator<Item = Axis> + 'a {
        self.machine.machine.axes.iter().flatten().map(|data| data.axis)
    }

    fn has_feeds(&self) -> bool {
        !self.options.feeds_mm_min.is_empty()
    }

    fn head(&self, out: &mut dyn Write) -> io::Result<()> {
        write!(out, "run,")?;
        if self.has_feeds() {
            write!(out, "feed_mm_min,")?;
        }
        write!(out, "t_s")?;
        self.axes().try_for_each(|axis| write!(out, ",{axis}"))?;
        self.axes().try_for_each(|axis| write!(out, ",{axis}_enc"))?;
        writeln!(out, ",dx_um,dy_um,dz_um,tool_x_mm,tool_y_mm,tool_z_mm")
    }

    /// Passes the program through the model once.
    fn pass(
        &mut self,
        running: &mut Running<'_>,
        feed: Option<f64>,
        noise: &mut Noise,
        findings: &mut Diagnostics,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let options = CorrectionOptions { start: self.program.reading().start, ..CorrectionOptions::default() };
        let model = Arc::clone(&self.model);
        let mut drive = Run::new(&self.machine.machine, self.servo, &model, &options);
        if let Some(feed) = feed {
            drive = drive.with_feed(feed);
        }
        let sigma_mm = self.options.noise_mm.unwrap_or(0.0);
        let mut pass = Pass { feed, tools: 0, tool_mm: None, label: String::new(), sigma_mm, noise };
        let mut written = Ok(());
        let most = self.recorded.tally.max_mm;
        while let Some(item) = running.next() {
            match item {
                Ok(element) => {
                    let mut see = |moment: &CycleState| {
                        if written.is_ok() {
                            written = self.row(moment, &mut pass, out);
                        }
                    };
                    drive.element(&element, block_of(element.origin), &mut see);
                }
                Err(finding) => findings.add(finding, running.sources()),
            }
            std::mem::replace(&mut written, Ok(()))?;
            if drive.has_left_out() || self.recorded.rows > MOST_ROWS {
                findings.add(too_long(self.recorded.rows), &[]);
                return Ok(());
            }
        }
        drive.finish(&mut |moment| {
            if written.is_ok() {
                written = self.row(moment, &mut pass, out);
            }
        });
        self.recorded.time_s += drive.time_s();
        if self.recorded.tally.max_mm > most {
            let (file, line) = place_of(self.recorded.tally.max_at);
            let source = running.sources().iter().find(|source| source.id() == file);
            self.recorded.worst = source.map(|source| format!("{}:{line}", source.name()));
        }
        written
    }

    /// A cycle of the control.
    fn row(&mut self, moment: &CycleState, pass: &mut Pass<'_>, out: &mut dyn Write) -> io::Result<()> {
        self.recorded.rows += 1;
        self.recorded.tally.note(moment);
        pass.take(&moment.tool_mm);
        write!(out, "{},", pass.label)?;
        if let Some(feed) = pass.feed {
            write!(out, "{feed},")?;
        }
        write!(out, "{:.7}", moment.time_s)?;
        for position in [&moment.set_point, &moment.encoder] {
            for axis in self.axes() {
                let value = if axis.is_rotary() { position[axis].to_degrees() } else { position[axis] };
                write!(out, ",{value:.8}")?;
            }
        }
        let off_mm = self.reading_mm(moment);
        for value in off_mm.iter() {
            let noise = if pass.sigma_mm > 0.0 { pass.sigma_mm * pass.noise.normal() } else { 0.0 };
            write!(out, ",{:.5}", um_from_mm(value + noise))?;
        }
        let [x, y, z] = moment.tool_mm.into();
        writeln!(out, ",{x},{y},{z}")
    }

    /// The tool position relative to the point of the workpiece given by the set-points, in the directions of frame F, mm.
    fn reading_mm(&self, moment: &CycleState) -> Vector {
        let CycleState { set_point, encoder, tool_mm, state, .. } = moment;
        let off = self.model.tip_error_mm(set_point, encoder, tool_mm, state);
        let in_tool = self.model.nominal(encoder, tool_mm).rotation.transpose() * off;
        self.model.tool_orientation(encoder) * in_tool
    }

    /// The description of the table.
    pub(crate) fn description(&self) -> String {
        let mut text = format!(
            "# {} on {}, simulated. Readings are the deviation of the tool from the set-points.\n[measurement]\nkind = \"trace\"\n",
            self.program.name().replace(['\n', '\r'], " "),
            self.machine.machine.name.replace(['\n', '\r'], " ")
        );
        if let Some(noise) = self.options.noise_mm {
            text += &format!("sigma_um = {}\n", um_from_mm(noise));
        }
        text
    }
}
