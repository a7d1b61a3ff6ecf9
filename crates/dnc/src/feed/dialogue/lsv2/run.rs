//! Run of a program that a person starts: its states, and the evidence that it was executed.
//!
//! A report "finished" alone is not evidence: it may be that of an earlier program. The lines count as executed only if the control reported the run of this
//! file first, the run took at least a quarter of the time of its moves, and the file is unchanged afterwards.

use std::time::Duration;

use super::decode::{ProgramState, SelectedProgram};
use crate::feed::watch::Patience;

/// A run that should take longer than this and ends in a quarter of its time was not complete.
const NOTICED: Duration = Duration::from_secs(1);
/// Factor on all durations at a feed override of 10 %.
const SLOWEST: u32 = 10;

/// Last reports of the control.
#[derive(Clone, Debug, Default)]
pub(super) struct ControlReports {
    pub(super) state: Option<ProgramState>,
    /// Operating mode.
    pub(super) mode: &'static str,
    pub(super) selected: SelectedProgram,
    /// Positions by axis, as the control writes them.
    pub(super) position: Vec<(String, String)>,
}

impl ControlReports {
    /// Describes the reports for people.
    pub(super) fn words(&self) -> String {
        let state = self.state.map_or("", ProgramState::words);
        let mut text = format!("{state}, mode {}, line {} of {}", self.mode, self.selected.line, self.selected.current);
        for (axis, value) in &self.position {
            text += &format!(" {axis}{value}");
        }
        text
    }
}

/// Result of a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum RunVerdict {
    /// The run continues, or has not begun; with a message for people.
    Continues(Option<String>),
    /// The control reports that the program has finished.
    Ended,
    /// It is not known which lines were executed, for this reason.
    Lost(String),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Waiting,
    Running,
    Stopped,
}

/// Run of one program.
#[derive(Debug)]
pub(super) struct FileRun {
    patience: Patience,
    /// Total duration of the moves.
    busy: Duration,
    stage: Stage,
    /// Time of the last report, and the times spent waiting, running and stopped.
    last: Duration,
    waited: Duration,
    ran: Duration,
    stood: Duration,
    /// State that was last shown.
    told: Option<ProgramState>,
}

impl FileRun {
    pub(super) fn new(patience: Patience) -> FileRun {
        FileRun {
            patience,
            busy: Duration::ZERO,
            stage: Stage::Waiting,
            last: Duration::ZERO,
            waited: Duration::ZERO,
            ran: Duration::ZERO,
            stood: Duration::ZERO,
            told: None,
        }
    }

    /// Adds the duration of a line.
    pub(super) fn plan(&mut self, busy: Duration) {
        self.busy = self.busy.saturating_add(busy);
    }

    /// Begins to wait for a person.
    pub(super) fn wait(&mut self, now: Duration) {
        self.last = now;
    }

    /// Evaluates a report.
    pub(super) fn look(&mut self, seen: &ControlReports, path: &str, now: Duration) -> RunVerdict {
        let passed = now.saturating_sub(std::mem::replace(&mut self.last, now));
        match self.stage {
            Stage::Waiting => self.waited += passed,
            Stage::Running => self.ran += passed,
            Stage::Stopped => self.stood += passed,
        }
        let Some(state) = seen.state else { return RunVerdict::Continues(None) };
        let is_own = seen.selected.is(path);
        let line = seen.selected.line;
        let is_news = self.told.replace(state) != Some(state);
        let verdict = match (self.stage, state) {
            (Stage::Waiting, ProgramState::Started) if is_own => {
                self.stage = Stage::Running;
                RunVerdict::Continues(Some("the program runs".into()))
            }
            (Stage::Waiting, ProgramState::Started) => {
                let said = format!("the control runs another program ({})", seen.selected.main);
                RunVerdict::Continues(is_news.then_some(said))
            }
            (Stage::Waiting, _) => RunVerdict::Continues(None),
            _ if !is_own => {
                let other = if seen.selected.main.is_empty() { "none" } else { &seen.selected.main };
                RunVerdict::Lost(format!("during the run another program was selected at the control ({other})"))
            }
            (_, ProgramState::Started) => {
                let was_stopped = std::mem::replace(&mut self.stage, Stage::Running) == Stage::Stopped;
                RunVerdict::Continues(was_stopped.then(|| "the program runs again".to_owned()))
            }
            (_, ProgramState::Stopped | ProgramState::Interrupted) => {
                self.stage = Stage::Stopped;
                RunVerdict::Continues(is_news.then(|| format!("{} in line {line}", state.words())))
            }
            (_, ProgramState::Finished) => self.finish(),
            (_, ProgramState::Idle) => {
                RunVerdict::Lost("the control is idle, and did not report that the program has finished".into())
            }
            _ => RunVerdict::Lost(format!("in line {line}, {}", state.words())),
        };
        match verdict {
            RunVerdict::Continues(said) => self.limit(said),
            verdict => verdict,
        }
    }

    fn finish(&self) -> RunVerdict {
        if self.busy > NOTICED && self.ran < self.busy / 4 {
            let [ran, busy] = [self.ran, self.busy].map(|time| time.as_secs_f64());
            return RunVerdict::Lost(format!(
                "the program has finished after {ran:.1} s, and its moves take {busy:.1} s: it was not executed completely"
            ));
        }
        RunVerdict::Ended
    }

    /// Applies the limits of time.
    fn limit(&self, said: Option<String>) -> RunVerdict {
        let most = self.patience.stall.saturating_add(self.busy.saturating_mul(SLOWEST));
        for (time, most, what) in [
            (self.waited, self.patience.hold, "no person has started the program"),
            (self.stood, self.patience.hold, "the program stands"),
            (self.ran, most, "the program runs"),
        ] {
            if time > most {
                return RunVerdict::Lost(format!("{what} for {} s: ncfix asks no more", time.as_secs()));
            }
        }
        RunVerdict::Continues(said)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATH: &str = "TNC:\\A.PM";
    const SECOND: Duration = Duration::from_secs(1);

    fn seen(state: ProgramState, main: &str) -> ControlReports {
        let selected = SelectedProgram { line: 7, main: main.to_owned(), current: main.to_owned() };
        ControlReports { state: Some(state), selected, ..ControlReports::default() }
    }

    fn run() -> FileRun {
        let mut run = FileRun::new(Patience { stall: 10 * SECOND, hold: 60 * SECOND });
        run.plan(8 * SECOND);
        run
    }

    fn looks(reports: &[(u32, ProgramState, &str)]) -> RunVerdict {
        let mut run = run();
        let mut last = RunVerdict::Continues(None);
        for (second, state, main) in reports {
            last = run.look(&seen(*state, main), PATH, *second * SECOND);
        }
        last
    }

    #[test]
    fn finished_counts_only_after_a_run_of_this_file() {
        use ProgramState::{Cancelled, Finished, Idle, Started, Stopped};
        // The report of an earlier program.
        assert_eq!(looks(&[(1, Finished, PATH)]), RunVerdict::Continues(None));
        assert_eq!(looks(&[(1, Started, "TNC:\\B.PM"), (9, Finished, "TNC:\\B.PM")]), RunVerdict::Continues(None));
        assert_eq!(looks(&[(1, Started, PATH), (9, Finished, PATH)]), RunVerdict::Ended);
        assert_eq!(
            looks(&[(1, Started, PATH), (2, Stopped, PATH), (9, Started, PATH), (10, Finished, PATH)]),
            RunVerdict::Ended
        );
        for (reports, says) in [
            (&[(1, Started, PATH), (2, Finished, PATH)][..], "not executed completely"),
            // A stop is not a part of the run.
            (&[(1, Started, PATH), (2, Stopped, PATH), (9, Finished, PATH)], "not executed completely"),
            (&[(1, Started, PATH), (9, Idle, PATH)], "did not report"),
            (&[(1, Started, PATH), (9, Cancelled, PATH)], "cancelled"),
            (&[(1, Started, PATH), (9, Finished, "TNC:\\B.PM")], "another program"),
            (&[(61, Idle, PATH)], "no person"),
            (&[(1, Started, PATH), (2, Stopped, PATH), (63, Stopped, PATH)], "stands"),
            (&[(1, Started, PATH), (92, Started, PATH)], "runs for 91 s"),
        ] {
            assert!(
                matches!(looks(reports), RunVerdict::Lost(why) if why.contains(says)),
                "{says}: {:?}",
                looks(reports)
            );
        }
    }
}
