//! A part whose program is executed, corrected and written as for a real job: what a transfer of it left behind is held against the place at which it would
//! be taken up again.

use ncfix_base::source::{FileId, Source};
use ncfix_dnc::drip::restart::{RestartSearch, SearchOutcome};
use ncfix_dnc::drip::{Ends, Grammar, Heights, Lines, Settings};
use ncfix_dnc::feed::{JournalContents, Line};
use ncfix_language::exec::{Execution, NoLibrary, Options as ExecOptions};
use ncfix_machine::machine::{Machine, file};
use ncfix_model::Model;
use ncfix_path::emit::{self, Stamp, WriterOptions};
use ncfix_path::path::{CorrectionOptions, Corrector, Increments, Output, OutputFrame, Tips};
use std::sync::LazyLock;

use crate::support;

/// A height that is clear of it, mm.
const CLEARANCE_MM: f64 = 40.0;

/// The part.
pub(crate) struct Part {
    machine: Machine,
    outputs: Vec<Output>,
    pub(crate) lines: Vec<Line>,
}

/// The one of all scripts: rapid moves above the part, plunges, short ways, lines that move nothing.
pub(crate) static PART: LazyLock<Part> = LazyLock::new(Part::new);

fn program() -> String {
    let mut text = "G21 G90 G17 G54\nS500 M3\nG0 Z30\nG0 X-5 Y-5\n".to_owned();
    for k in 0..9 {
        text += &format!("G0 X{} Y{}\nG0 Z2\nG1 Z-1 F600\nG1 Y{}\n", 5 * k, k % 3, k % 3 + 20);
        // A line that moves nothing, one that moves less than a step, and an end where it is already.
        text += ["M8\n", "G1 X0.1\n", "F700\n"][k % 3];
        text += "G1 X60\nG0 Z30\n";
    }
    text
}

impl Part {
    fn new() -> Part {
        let path = support::machine("knee_mill");
        let bytes = std::fs::read(&path).unwrap();
        let source = Source::new(FileId(0), &path, bytes).unwrap();
        let (machine, findings) = file::read_machine(&file::MachineFile::parse(&source).unwrap());
        let machine = machine.unwrap_or_else(|| panic!("{findings:?}"));
        let base = Model::new(&machine, &ncfix_model::ErrorModel::default());
        let source = Source::new(FileId(0), "part.ngc", program().into_bytes()).unwrap();
        let (parsed, _) = ncfix_language::syntax::parse(&source, ncfix_dialect::find("rs274").unwrap());
        let execution = Execution::new(parsed, &machine, Box::new(NoLibrary), ExecOptions::default());
        let outputs: Vec<Output> = Corrector::new(execution, &machine, &base, CorrectionOptions::default())
            .filter(|output| !matches!(output, Err(finding) if !finding.is_error()))
            .map(Result::unwrap)
            .collect();
        let lines = lines_of(&machine, &base, &outputs);
        Part { machine, outputs, lines }
    }

    /// Lines that are taken for carried out, and lines of the program that are not sent when the job is taken up again; none where it is not.
    pub(crate) fn restart(&self, told: &JournalContents, holds: Option<u64>) -> (u64, usize) {
        let options = CorrectionOptions::default();
        let from_start = || Tips::new(&self.machine, &options);
        let (mut ends, mut heights, mut tips) = (Ends::new(told), Heights::default(), from_start());
        for output in &self.outputs {
            ends.element(output);
            heights.look(&tips, output);
            tips.take(output);
        }
        tips = from_start();
        for output in &self.outputs {
            heights.take(&tips, output);
            tips.take(output);
        }
        let sure = ends.sure(told, holds);
        let element = |number: u64| told.lines.iter().find(|line| line.number == number).map(|line| line.element);
        let until = element(sure + 1).or(element(sure)).unwrap_or(0);
        let sent = element(told.frozen).unwrap_or(0);
        let grammar = Grammar::new(ncfix_dialect::find("rs274").unwrap(), false);
        let mut search = RestartSearch::new(grammar, (from_start(), &heights), [until, sent], Some(CLEARANCE_MM));
        let mut lines = self.lines.iter().peekable();
        for (element, output) in (1..).zip(&self.outputs) {
            search.element(output);
            // A line comes with the output behind it.
            while let Some(line) = lines.next_if(|line| line.element < element) {
                search.line(line);
            }
        }
        lines.for_each(|line| search.line(line));
        let skipped = match search.finish() {
            SearchOutcome::Place(place) => self.lines.iter().filter(|line| line.element < place.element).count(),
            _ => 0,
        };
        (sure, skipped)
    }
}

fn lines_of(machine: &Machine, base: &Model, outputs: &[Output]) -> Vec<Line> {
    let writer_options = WriterOptions {
        increments: Increments::new(&machine.control),
        frame: OutputFrame::Work,
        crlf: false,
        names: machine.written_names(),
        stamp: Stamp::default(),
        last_block_number: None,
        has_centers_reversed: false,
    };
    let writer = emit::writer("rs274", &writer_options).unwrap();
    let mut lines = Lines::new(machine, base, &CorrectionOptions::default(), writer, Settings::default());
    let mut out = Vec::new();
    for output in outputs {
        lines.take(output.clone(), None, false).unwrap();
        out.extend(std::iter::from_fn(|| lines.pop()));
    }
    lines.finish().unwrap();
    out.extend(std::iter::from_fn(|| lines.pop()));
    out
}
