//! The rings in shared memory, served until the control or a person ends it.

use std::fs::{self, File};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::Tally;
use super::prepare::Prepared;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::stop::Stop;
use crate::cli::tell;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_report::number::grouped;
use ncfix_tables::realtime::ring::{Overrun, Ring};

/// Looks at an empty ring before the thread rests, and for how long it does.
const LOOKS: u32 = 2000;
const REST: Duration = Duration::from_micros(50);

/// Where memory that has a name is found on Linux.
const SHARED: &str = "/dev/shm";

/// A file that goes when this goes.
struct Removed(PathBuf);

impl Drop for Removed {
    fn drop(&mut self) {
        // Somebody else may have removed it; either way it is gone.
        let _ = fs::remove_file(&self.0);
    }
}

/// Serves.
pub(super) fn serve(name: &str, records: u64, prepared: &mut Prepared, tally: &mut Tally) -> Result<ExitCode, Stop> {
    let path = if name.contains(['/', '\\']) { PathBuf::from(name) } else { PathBuf::from(SHARED).join(name) };
    let file = File::options().read(true).write(true).create_new(true).open(&path);
    let file = file.map_err(|error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => Stop::Usage(format!(
            "{} is there already: another ncfix serves it, or did not end well; remove it if none does",
            path.display()
        )),
        _ => Stop::file("write", &path, &error),
    })?;
    let removed = Removed(path);
    let ring = Ring::create(&file, prepared.axes, records).map_err(|error| Stop::file("write", &removed.0, &error))?;
    let is_over = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&is_over))
            .map_err(|error| Stop::Usage(format!("cannot listen to Ctrl-C: {error}")))?;
    }
    tell(&format!("rings of {records} records at {}\n", removed.0.display()));
    let mut looks = 0;
    loop {
        let start = Instant::now();
        let served = match ring.serve(&mut prepared.cycle) {
            Ok(served) => served,
            Err(overrun) => return Ok(refused(overrun, records, tally.count)),
        };
        if let Some(signals) = served {
            tally.times.note(start.elapsed());
            tally.note(signals);
            looks = 0;
            continue;
        }
        if ring.beat() {
            return Ok(ExitCode::Done);
        }
        if is_over.load(Ordering::Relaxed) {
            return Ok(ExitCode::Interrupted);
        }
        looks += 1;
        if looks < LOOKS { std::hint::spin_loop() } else { std::thread::sleep(REST) }
    }
}

/// What is said where a control goes over the end of a ring.
fn refused(overrun: Overrun, records: u64, answered: u64) -> ExitCode {
    let what = match overrun {
        Overrun::SetPoints(count) => format!("the control wrote {count} set-points into a ring of {records}"),
        Overrun::WentBack(count) => {
            format!("the count of set-points written went back: it is {count} below those read")
        }
        Overrun::CorrectionsRead(count) => format!("the control read {count} more corrections than there are"),
        Overrun::Corrections(_) => "the count of corrections read went back".to_owned(),
    };
    let help = format!(
        "{} set-points were answered; wait where the counts are {records} apart, or make the ring larger with --records",
        grouped(answered)
    );
    let mut findings = Findings::default();
    findings.add(Diagnostic::nowhere(Code::BAD_SET_POINT, what, help), &[]);
    findings.draw();
    findings.exit_code()
}
