//! `ncfix sensors S.toml --watch`: current values of live sensors, their age and state.

use std::io::IsTerminal as _;

use crate::cli::arguments::SensorsArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::print;
use crate::cli::stop::Stop;
use crate::watch::{SensorWatch, ShownAt};
use ncfix_report::json;
use ncfix_report::watch::WatchReport;

/// Shows live sensors.
pub(super) fn run(arguments: &SensorsArguments) -> Result<ExitCode, Stop> {
    let [path] = arguments.data.as_slice() else {
        return Err(Stop::Usage("--watch reads one file of live sensors".into()));
    };
    let mut findings = Findings::default();
    let Some(watch) = SensorWatch::open(path, arguments.log.as_deref(), &mut findings)? else {
        findings.draw();
        return Ok(findings.exit_code());
    };
    let is_drawn = !arguments.json && std::io::stdout().is_terminal();
    // Lines of the table on the terminal.
    let mut drawn_lines = 0;
    let mut show = |report: &WatchReport| {
        if is_drawn {
            redraw(report, &mut drawn_lines)
        } else if arguments.json {
            print(&json::line(report).map_err(Stop::Usage)?)
        } else {
            print(&report.line())
        }
    };
    let at = if is_drawn { ShownAt::Redraws } else { ShownAt::Polls };
    let is_good = watch.run(arguments.duration, at, &mut show)?;
    Ok(if is_good { ExitCode::Done } else { ExitCode::Refused })
}

/// Draws the table over the previous one.
fn redraw(report: &WatchReport, drawn_lines: &mut usize) -> Result<(), Stop> {
    let page = report.page();
    let up = if *drawn_lines > 0 { format!("\u{1b}[{drawn_lines}A") } else { String::new() };
    *drawn_lines = page.lines().count();
    let lines: String = page.lines().map(|line| format!("\u{1b}[K{line}\n")).collect();
    // A line that is wider than the terminal is cut, not folded: the table keeps its height.
    print(&format!("\u{1b}[?7l{up}{lines}\u{1b}[J\u{1b}[?7h"))
}
