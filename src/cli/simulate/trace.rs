//! `ncfix simulate PROGRAM`: a part program driven through the servo loops, recorded as a trace.

use std::io::{self, Write};

use crate::cli::arguments::SimulateArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::input::is_standard_stream;
use crate::cli::machine_choice::Chosen;
use crate::cli::measurement::description_of;
use crate::cli::output::{Spool, Target};
use crate::cli::program::{self, Running};
use crate::cli::stop::Stop;
use crate::cli::together::Together;
use crate::cli::{machine_choice, state, tell};
use crate::compare::{block_of, place_of};
use crate::correction::servo;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::source::Source;
use ncfix_base::units::um_from_mm;
use ncfix_language::exec::RapidOrder;
use ncfix_machine::machine::Servo;
use ncfix_metrology::measure::noise::Noise;
use ncfix_model::Model;
use ncfix_path::path::Options;
use ncfix_path::servo::{Moment, Run, Tally};
use ncfix_report::number::{duration, grouped, micrometers};

/// Rows of a trace at most: 3 GB of text, and more than any recorder of a control keeps.
const MOST_ROWS: u64 = 20_000_000;

/// Records a program.
pub(super) fn run(arguments: &SimulateArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let result = record(arguments, &mut findings);
    findings.draw();
    match result? {
        Some(seen) => tell(&seen.text(arguments)),
        None => tell(&format!("{}; nothing was written\n", findings.count())),
    }
    Ok(findings.exit_code())
}

/// What was recorded.
#[derive(Debug, Default)]
struct Seen {
    rows: u64,
    time_s: f64,
    tally: Tally,
    /// Where the tool is off its path most.
    worst: Option<String>,
}

impl Seen {
    fn text(&self, arguments: &SimulateArguments) -> String {
        let [rms, max] = [self.tally.rms_mm(), self.tally.max_mm].map(|mm| micrometers(um_from_mm(mm)));
        let place = self.worst.as_ref().map_or(String::new(), |place| format!(" at {place}"));
        format!(
            "{} rows of {} simulated, tool off its path by {rms} RMS, {max} at most{place}; written {}\n",
            grouped(self.rows),
            duration(self.time_s),
            arguments.output.display()
        )
    }
}

/// Writes both files; `None` where findings forbid it.
fn record(arguments: &SimulateArguments, findings: &mut Findings) -> Result<Option<Seen>, Stop> {
    if is_standard_stream(&arguments.output) {
        return Err(Stop::Usage("a measurement is a pair of files, NAME.csv and NAME.toml; give -o NAME.csv".into()));
    }
    let feeds = &arguments.feed;
    if let Some(twice) = (1..feeds.len()).find(|&k| feeds[..k].contains(&feeds[k])) {
        return Err(Stop::Usage(format!("--feed has {} twice", feeds[twice])));
    }
    let paths = [arguments.output.clone(), description_of(&arguments.output)?];
    let [data, description] = [Target::new(&paths[0])?, Target::new(&paths[1])?];
    let source = program::read(&arguments.plan)?;
    let Some(mut chosen) = machine_choice::choose(&arguments.machine, &arguments.plan, findings)? else {
        return Ok(None);
    };
    if !state::apply(&arguments.state, &mut chosen, findings)? {
        return Ok(None);
    }
    let inputs = [arguments.plan.clone()];
    for target in [&data, &description] {
        program::protect(target, chosen.files.iter().chain(&inputs), findings);
    }
    let Some(servo) = servo(&chosen.machine, findings) else { return Ok(None) };
    let model = chosen.model();
    let mut recorder = Recorder { arguments, chosen: &chosen, servo, model: &model, seen: Seen::default() };
    let mut table = Spool::new(data)?;
    recorder.head(table.writer()).map_err(|error| table.fault(&error))?;
    let programmed = [None];
    let each: Vec<Option<f64>> =
        if feeds.is_empty() { programmed.to_vec() } else { feeds.iter().copied().map(Some).collect() };
    let mut noise = Noise::new(arguments.seed);
    for feed in each {
        // Each pass begins anew: variables, counters and what a program asks for are those of a first run.
        let mut own = Findings::default();
        let Some(opened) = program::open(&source, &arguments.program, Some(&chosen), &mut own)? else {
            findings.absorb(own);
            return Ok(None);
        };
        let order = RapidOrder::Stated;
        let mut running = program::start(opened, &arguments.plan, &arguments.program, &chosen.machine, false, order);
        let result = recorder.pass(&mut running, feed, &mut noise, &mut own, table.writer());
        result.map_err(|error| table.fault(&error))?;
        for target in [table.target(), &description] {
            program::protect(target, &running.files(), &mut own);
        }
        // What a second pass finds has been said.
        let is_over = own.has_errors();
        if feed == feeds.first().copied() {
            findings.absorb(own);
        }
        if is_over {
            return Ok(None);
        }
    }
    if recorder.seen.rows == 0 && !findings.has_errors() {
        let message = format!("{} makes no moves", source.name());
        let help = "give a program that moves the axes: there is nothing to record";
        findings.add(Diagnostic::nowhere(Code::UNKNOWN_START, message, help), &[]);
    } else if recorder.seen.tally.cycles() == 0 && !findings.has_errors() {
        let message = format!("{} makes no move with feed whose start is known", source.name());
        let help = "program all axes before the first move with feed, or say with --start where they stand";
        findings.add(Diagnostic::nowhere(Code::UNKNOWN_START, message, help), &[]);
    }
    if findings.has_errors() {
        return Ok(None);
    }
    let mut together = Together::default();
    together.take(table)?;
    together.add(description, recorder.description(&source).as_bytes())?;
    let seen = recorder.seen;
    together.publish()?;
    Ok(Some(seen))
}

/// A program that takes too long to be recorded.
fn too_long(rows: u64) -> Diagnostic {
    let message = match rows {
        MOST_ROWS.. => format!("the trace would have more than {} rows", grouped(MOST_ROWS)),
        _ => "a chord of a move would take more than an hour".to_owned(),
    };
    let help = "simulate a part of the program, at higher feeds, or with a longer servo.cycle_ms";
    Diagnostic::nowhere(Code::TOO_MANY_BLOCKS, message, help)
}

/// Writes the rows of a trace.
struct Recorder<'a> {
    arguments: &'a SimulateArguments,
    chosen: &'a Chosen,
    servo: &'a Servo,
    model: &'a Model,
    seen: Seen,
}

/// A pass over the program.
struct Pass<'p> {
    feed: Option<f64>,
    /// Tools so far: a run has one.
    tools: u32,
    tool_mm: Option<Vector>,
    label: String,
    sigma_mm: f64,
    noise: &'p mut Noise,
}

impl Pass<'_> {
    /// Another tool makes another run.
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
    fn axes(&self) -> impl Iterator<Item = Axis> + 'a {
        self.chosen.machine.axes.iter().flatten().map(|data| data.axis)
    }

    fn has_feeds(&self) -> bool {
        !self.arguments.feed.is_empty()
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

    /// Drives the program once.
    fn pass(
        &mut self,
        running: &mut Running<'_>,
        feed: Option<f64>,
        noise: &mut Noise,
        findings: &mut Findings,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let options = Options { start: self.arguments.program.start, ..Options::default() };
        let mut drive = Run::new(&self.chosen.machine, self.servo, self.model, &options);
        if let Some(feed) = feed {
            drive = drive.with_feed(feed);
        }
        let sigma_mm = self.arguments.noise.unwrap_or(0.0);
        let mut pass = Pass { feed, tools: 0, tool_mm: None, label: String::new(), sigma_mm, noise };
        let mut written = Ok(());
        let most = self.seen.tally.max_mm;
        while let Some(item) = running.next() {
            match item {
                Ok(element) => {
                    let mut see = |moment: &Moment| {
                        if written.is_ok() {
                            written = self.row(moment, &mut pass, out);
                        }
                    };
                    drive.element(&element, block_of(element.origin), &mut see);
                }
                Err(finding) => findings.add(finding, running.sources()),
            }
            std::mem::replace(&mut written, Ok(()))?;
            if drive.has_left_out() || self.seen.rows > MOST_ROWS {
                findings.add(too_long(self.seen.rows), &[]);
                return Ok(());
            }
        }
        drive.finish(&mut |moment| {
            if written.is_ok() {
                written = self.row(moment, &mut pass, out);
            }
        });
        self.seen.time_s += drive.time_s();
        if self.seen.tally.max_mm > most {
            let (file, line) = place_of(self.seen.tally.max_at);
            let source = running.sources().iter().find(|source| source.id() == file);
            self.seen.worst = source.map(|source| format!("{}:{line}", source.name()));
        }
        written
    }

    /// A cycle of the control.
    fn row(&mut self, moment: &Moment, pass: &mut Pass<'_>, out: &mut dyn Write) -> io::Result<()> {
        self.seen.rows += 1;
        self.seen.tally.note(moment);
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

    /// The tool from the point of the workpiece where the set-points have it, along F's directions, mm.
    fn reading_mm(&self, moment: &Moment) -> Vector {
        let Moment { set_point, encoder, tool_mm, state, .. } = moment;
        let off = self.model.tip_error_mm(set_point, encoder, tool_mm, state);
        let in_tool = self.model.nominal(encoder, tool_mm).rotation.transpose() * off;
        self.model.tool_orientation(encoder) * in_tool
    }

    fn description(&self, source: &Source) -> String {
        let mut text = format!(
            "# {} on {}, simulated. Readings are the tool from where the set-points have it.\n[measurement]\nkind = \"trace\"\n",
            source.name().replace(['\n', '\r'], " "),
            self.chosen.machine.name.replace(['\n', '\r'], " ")
        );
        if let Some(noise) = self.arguments.noise {
            text += &format!("sigma_um = {}\n", um_from_mm(noise));
        }
        text
    }
}
