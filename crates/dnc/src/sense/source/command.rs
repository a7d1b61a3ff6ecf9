//! Command that prints readings: started for each poll, and ended if it takes too long.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use ncfix_base::diagnostic::Code;
use ncfix_machine::machine::file::Section;

use super::super::config::seconds;
use super::super::lines::{LONGEST_LINE, LineReader};
use super::super::outlet::ReadingOutlet;
use super::{Items, Kind, OpenedSource, Polled, SourcePlan, Wanted, items, polled};

/// Interval at which a running command is checked.
const LOOK: Duration = Duration::from_millis(20);

pub(super) const KIND: Kind =
    Kind { name: "command", title: "a command that prints readings", is_record: false, is_standard_input: false, read };

#[derive(Clone, Debug)]
struct Settings {
    command: Vec<String>,
    timeout: Duration,
    has_times: bool,
    items: Items,
}

fn read(section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>> {
    let command = section.required("command", "[\"./read-sensors\", \"--all\"]", Section::texts)?;
    if command.first().is_none_or(String::is_empty) {
        let help = "write the program and each of its arguments as a separate string";
        section.report(Code::BAD_VALUE, section.place_of("command"), "the command has no program", help);
    }
    let timeout = seconds(section, "timeout_s", 0.05).unwrap_or(Duration::from_secs(5));
    let has_times = section.boolean("use_time").unwrap_or(true);
    Some(Arc::new(Settings { command, timeout, has_times, items: items(wanted) }))
}

impl SourcePlan for Settings {
    fn open(&self, base: &Path, poll: Duration) -> Result<OpenedSource, String> {
        // The operating system looks up a bare name; a path is relative to the folder like all others.
        let (program, arguments) = self.command.split_first().ok_or("the command has no program")?;
        let is_path = program.contains('/') || program.contains('\\');
        let program = if is_path { base.join(program) } else { PathBuf::from(program) };
        let folder = if base.as_os_str().is_empty() { Path::new(".") } else { base };
        let program = if is_path { std::path::absolute(&program).unwrap_or(program) } else { program };
        let run = Run {
            program,
            arguments: arguments.to_vec(),
            folder: folder.to_path_buf(),
            settings: self.clone(),
            held: None,
        };
        Ok(polled(run, poll))
    }
}

struct Run {
    program: PathBuf,
    arguments: Vec<String>,
    folder: PathBuf,
    settings: Settings,
    /// Output of a command that its child processes still hold open.
    held: Option<Receiver<Vec<u8>>>,
}

impl Polled for Run {
    fn poll(&mut self, outlet: &ReadingOutlet) -> Result<(), String> {
        if let Some(held) = self.held.take()
            && matches!(held.recv_timeout(Duration::ZERO), Err(RecvTimeoutError::Timeout))
        {
            self.held = Some(held);
            return Err("the previous run of the command still has running processes; it is not started again".into());
        }
        let mut command = Command::new(&self.program);
        command.args(&self.arguments).current_dir(&self.folder);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
        #[cfg(unix)]
        {
            use std::os::unix::process::CommandExt as _;
            // Child processes are ended with it.
            command.process_group(0);
        }
        let mut child = command.spawn().map_err(|error| format!("{}: {error}", self.program.display()))?;
        let output = child.stdout.take().ok_or("the command has no output")?;
        let output = self.gather(output)?;
        let status = self.finish(&mut child, outlet)?;
        let bytes = match output.recv_timeout(self.settings.timeout) {
            Ok(bytes) => bytes,
            Err(RecvTimeoutError::Timeout) => {
                self.held = Some(output);
                return Err("the command ended, but a process that it started keeps its output open".into());
            }
            Err(RecvTimeoutError::Disconnected) => Vec::new(),
        };
        if !status.success() {
            return Err(format!("{} ended with {status}", self.program.display()));
        }
        let mut lines = LineReader::new(&self.settings.items, self.settings.has_times);
        let mut is_silent = true;
        for line in bytes.split(|&byte| byte == b'\n') {
            lines.read(line, &mut |channel, told, stamp| {
                is_silent = false;
                outlet.tell(channel, told, stamp);
            });
        }
        if is_silent { Err(format!("{} printed no reading", self.program.display())) } else { Ok(()) }
    }
}

impl Run {
    /// Reads the output in a thread, so that an output that is held open delays no one.
    fn gather(&self, output: ChildStdout) -> Result<Receiver<Vec<u8>>, String> {
        let (sender, receiver) = sync_channel(1);
        let read = move || {
            let mut bytes = Vec::new();
            let mut output = output.take(LONGEST_LINE as u64);
            let _ = output.read_to_end(&mut bytes);
            let _ = sender.send(bytes);
        };
        thread::Builder::new().spawn(read).map_err(|error| error.to_string())?;
        Ok(receiver)
    }

    /// Waits for the command up to the timeout, then ends it.
    fn finish(&self, child: &mut Child, outlet: &ReadingOutlet) -> Result<ExitStatus, String> {
        let until = Instant::now() + self.settings.timeout;
        loop {
            match child.try_wait() {
                Ok(Some(status)) => return Ok(status),
                Ok(None) if Instant::now() < until && outlet.wait(LOOK) => {}
                Ok(None) => {
                    end(child);
                    let limit_s = self.settings.timeout.as_secs_f64();
                    return Err(format!("{} took longer than {limit_s} s and was terminated", self.program.display()));
                }
                Err(error) => return Err(error.to_string()),
            }
        }
    }
}

/// Ends a command and its child processes.
fn end(child: &mut Child) {
    #[cfg(unix)]
    {
        // The shell supports process groups; the standard library does not.
        let group = format!("kill -9 -{}", child.id());
        let kill = Command::new("/bin/sh").args(["-c", &group]).stdin(Stdio::null()).stderr(Stdio::null()).status();
        drop(kill);
    }
    let _ = child.kill();
    let _ = child.wait();
}
