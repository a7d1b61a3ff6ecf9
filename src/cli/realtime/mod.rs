//! `ncfix realtime`: set-points in, corrections out, in the cycle of a control.

mod lines;
mod prepare;
mod served;
mod stability;

use std::io::Write as _;
use std::time::Instant;

use super::arguments::RealtimeArguments;
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::stop::Stop;
use super::tell;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::AxisVector;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_report::number::grouped;
use ncfix_tables::realtime::{Answer, Cycle, LatencyHistogram, Signals};

use lines::{Fault, Lines};
use prepare::Prepared;

/// What the bits of an answer are called in the last column.
const SIGNALS: [(Signals, &str); 5] = [
    (Signals::HELD, "held"),
    (Signals::BEYOND, "beyond"),
    (Signals::DOSED, "dosed"),
    (Signals::UNSOLVED, "unsolved"),
    (Signals::RENEWED, "renewed"),
];

/// Answers set-points.
pub(super) fn run(arguments: &RealtimeArguments) -> Result<ExitCode, Stop> {
    if let Some(path) = &arguments.stability {
        return stability::write(path);
    }
    let mut findings = Findings::default();
    let prepared = prepare::prepare(arguments, &mut findings);
    findings.draw();
    let Some(mut prepared) = prepared? else {
        tell(&format!("{}; no set-point was read\n", findings.count()));
        return Ok(findings.exit_code());
    };
    tell(&prepared.summary);
    let mut tally = Tally::default();
    let result = match &arguments.ring {
        Some(name) => served::serve(name, arguments.records, &mut prepared, &mut tally),
        None => answer_lines(&mut prepared, &mut tally),
    };
    // The page about the run comes also where it broke off.
    if !matches!(result, Err(Stop::Usage(_))) {
        tell(&tally.page(arguments.latency));
    }
    result
}

/// Answers the lines of standard input.
fn answer_lines(prepared: &mut Prepared, tally: &mut Tally) -> Result<ExitCode, Stop> {
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    let axes: Vec<_> = prepared.axes.iter().collect();
    let titles = axes.iter().map(|axis| format!("d{axis}_{}", if axis.is_rotary() { "urad" } else { "um" }));
    let titles = titles.chain(["signals".to_owned()]).collect::<Vec<_>>().join(",");
    writeln!(out, "{titles}").and_then(|()| out.flush()).map_err(|error| Stop::output(&error))?;
    let mut lines = Lines::new(std::io::BufReader::new(std::io::stdin().lock()), prepared.axes);
    loop {
        let set_point = match lines.next() {
            Ok(Some(set_point)) => set_point,
            Ok(None) => break,
            Err(Fault::Unreadable(error)) => {
                return Err(Stop::Usage(format!("cannot read standard input: {error}")));
            }
            Err(Fault::Wrong { line, column, what }) => {
                out.flush().map_err(|error| Stop::output(&error))?;
                let message = format!("standard input:{line}:{column}: {what}");
                let help = format!(
                    "{} set-points before it were answered, nothing behind it; the control must hold its last correction",
                    grouped(tally.count)
                );
                let mut findings = Findings::default();
                findings.add(Diagnostic::nowhere(Code::BAD_SET_POINT, message, help), &[]);
                findings.draw();
                return Ok(findings.exit_code());
            }
        };
        let answer = tally.step(&mut prepared.cycle, &set_point);
        let written = axes.iter().try_for_each(|&axis| {
            let value = answer.correction[axis];
            let value = if axis.is_rotary() { urad_from_rad(value) } else { um_from_mm(value) };
            write!(out, "{value:.4},")
        });
        let written = written.and_then(|()| writeln!(out, "{}", words(answer.signals)));
        // Who writes line by line gets every answer at once; who writes many at once gets theirs together.
        let written = if lines.has_more() { written } else { written.and_then(|()| out.flush()) };
        written.map_err(|error| Stop::output(&error))?;
    }
    out.flush().map_err(|error| Stop::output(&error))?;
    Ok(ExitCode::Done)
}

/// `beyond dosed`.
fn words(signals: Signals) -> String {
    let set = SIGNALS.into_iter().filter(|&(signal, _)| signals.has(signal));
    set.map(|(_, word)| word).collect::<Vec<_>>().join(" ")
}

/// What is counted while set-points are answered.
#[derive(Default)]
struct Tally {
    count: u64,
    by_signal: [u64; SIGNALS.len()],
    times: Box<LatencyHistogram>,
}

impl Tally {
    fn step(&mut self, cycle: &mut Cycle, set_point: &AxisVector) -> Answer {
        let start = Instant::now();
        let answer = cycle.step(set_point);
        self.times.note(start.elapsed());
        self.note(answer.signals);
        answer
    }

    fn note(&mut self, signals: Signals) {
        self.count += 1;
        for (count, (signal, _)) in self.by_signal.iter_mut().zip(SIGNALS) {
            *count += u64::from(signals.has(signal));
        }
    }

    /// `1,000 set-points; 3 beyond, 12 dosed`, and where it is wanted the times.
    fn page(&self, has_times: bool) -> String {
        let counted = self.by_signal.iter().zip(SIGNALS).filter(|(count, _)| **count > 0);
        let counted: Vec<String> = counted.map(|(&count, (_, word))| format!("{} {word}", grouped(count))).collect();
        let separator = if counted.is_empty() { "" } else { "; " };
        let mut page = format!("{} set-points{separator}{}\n", grouped(self.count), counted.join(", "));
        if has_times && self.times.total() > 0 {
            page.push_str("\n        from          to       count     share within\n");
            let (mut passed, total) = (0, self.times.total() as f64);
            for (from, to, count) in self.times.classes() {
                passed += count;
                let share = 100.0 * passed as f64 / total;
                page.push_str(&format!("{from:9} ns {to:8} ns {count:11} {share:13.4} %\n"));
            }
            let [half, most, tail] = [0.5, 0.99, 0.999].map(|share| self.times.quantile_ns(share));
            let max = self.times.max_ns();
            page.push_str(&format!("p50 {half} ns, p99 {most} ns, p99.9 {tail} ns, max {max} ns\n"));
        }
        page
    }
}
