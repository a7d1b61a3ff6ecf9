//! `ncfix decompose`: sources of the error at speed.

pub(in crate::cli) mod arguments;

use std::path::Path;

use crate::cli::arguments::DecomposeArguments;
use crate::cli::atomic_writes::AtomicWrites;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::input::{self, is_standard_stream, one_stream};
use crate::cli::machine_choice::{self, Chosen};
use crate::cli::output::Target;
use crate::cli::pages::{self, Pages};
use crate::cli::progress::Progress;
use crate::cli::stop::Stop;
use crate::cli::{print, program, tell, trace};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::FileId;
use ncfix_machine::machine::Machine;
use ncfix_metrology::decompose::{self, DecompositionOptions, links};
use ncfix_metrology::results::decomposition::{self, SCHEMA};
use ncfix_report::decomposition::DecompositionReport;
use ncfix_report::{json, page};

/// Splits the errors at speed into their causes.
pub(in crate::cli) fn run(arguments: &DecomposeArguments) -> Result<ExitCode, Stop> {
    let goes_out = arguments.output.as_deref().is_some_and(is_standard_stream);
    one_stream(arguments.json, goes_out)?;
    let mut findings = Findings::default();
    let mut report = DecompositionReport::default();
    report.found.schema = SCHEMA;
    let page = arguments.page.pages(arguments.output.as_deref(), arguments.json)?;
    let mut files = AtomicWrites::default();
    let mut result = find(arguments, page.as_ref(), &mut files, &mut findings, &mut report);
    report.diagnostics = findings.json();
    if let (Some(page), Ok(())) = (page.filter(|_| !report.inputs.is_empty()), &result) {
        result = page.add(&page::decomposition::decomposition(&report), &mut files).map_err(Stop::from);
        if result.is_ok() {
            report.report = arguments.page.report.as_ref().map(|path| path.display().to_string());
        }
    }
    result = result.and_then(|()| Ok(files.publish()?));
    if result.is_ok() && arguments.json {
        print(&json::line(&report).map_err(Stop::Usage)?)?;
        return Ok(findings.exit_code());
    }
    findings.draw();
    result?;
    if !report.found.runs.is_empty() {
        let text = report.page();
        if goes_out || arguments.page.report.as_deref().is_some_and(is_standard_stream) {
            tell(&text);
        } else {
            print(&text)?;
        }
    }
    if findings.has_errors() {
        tell(&format!("{}; nothing was written\n", findings.count()));
    }
    Ok(findings.exit_code())
}

fn find(
    arguments: &DecomposeArguments,
    page: Option<&Pages>,
    files: &mut AtomicWrites,
    findings: &mut Findings,
    report: &mut DecompositionReport,
) -> Result<(), Stop> {
    let first = arguments.traces.first().ok_or_else(|| Stop::Usage("give a trace".into()))?;
    let target = arguments.output.as_deref().map(Target::new).transpose()?;
    let Some(chosen) = machine_choice::choose(&arguments.machine, first, findings)? else { return Ok(()) };
    report.found.machine.clone_from(&chosen.machine.name);
    if target.is_some() && chosen.is_demo {
        return Err(Stop::Usage("-o extends a machine file; give it with --machine".into()));
    }
    let mut inputs = chosen.files.clone();
    inputs.extend(trace::files(&arguments.traces));
    for target in target.iter().chain(page.and_then(Pages::target)) {
        program::protect(target, &inputs, findings);
    }
    let options = options(arguments, &chosen.machine)?;
    if findings.has_errors() {
        return Ok(());
    }
    for path in &chosen.files {
        report.inputs.push(pages::input(&input::read(path, FileId(0), "")?, "machine"));
    }
    let mut all = Vec::new();
    for (number, path) in arguments.traces.iter().enumerate() {
        let read = trace::read(path, number, &chosen.machine, findings)?;
        for (source, role) in read.iter().flat_map(|one| one.sources.iter().zip(["trace", "description", "control"])) {
            report.inputs.push(pages::input(source, role));
        }
        all.extend(read);
    }
    if findings.has_errors() {
        return Ok(());
    }
    let Some((whole, sources)) = trace::joined(all, findings) else { return Ok(()) };
    let mut progress = Progress::new();
    let found = decompose::decompose(&chosen.machine, &chosen.errors, &whole, &options, &mut |what, share| {
        progress.share(what, share);
    });
    progress.clear();
    match found {
        Ok(found) => {
            decomposition::fill(&found, &whole, &mut report.found);
            if let (Some(target), Some(name)) = (target, &arguments.output) {
                let to = (target, name.as_path(), files);
                extend(&chosen, &found, to, findings, report)?;
            }
        }
        Err(fault) => findings.add(decomposition::told(&fault), &sources),
    }
    Ok(())
}

fn options(arguments: &DecomposeArguments, machine: &Machine) -> Result<DecompositionOptions, Stop> {
    let links = arguments.links.as_deref().map_or_else(|| Ok(Vec::new()), |list| links(list, machine));
    Ok(DecompositionOptions {
        links: links.map_err(|reason| Stop::Usage(reason.to_string()))?,
        smooth: arguments.motion,
        record_delay_s: arguments.record_delay_ms.map(|ms| ms / 1e3),
        reading_delay_s: arguments.reading_delay_ms.map(|ms| ms / 1e3),
    })
}

/// Adds the machine file with links, loops and compliances to the files to write.
fn extend(
    chosen: &Chosen,
    found: &decompose::Decomposition,
    (target, name, files): (Target, &Path, &mut AtomicWrites),
    findings: &mut Findings,
    report: &mut DecompositionReport,
) -> Result<(), Stop> {
    let Some(path) = chosen.files.first() else { return Err(Stop::Usage("-o needs --machine".into())) };
    let old = input::read_written(path, FileId(0), "machine file to extend")?;
    match decomposition::extended(old.bytes(), found) {
        Some(text) if text.as_bytes() == old.bytes() => {
            let help = "no link, loop or compliance is determined; the machine file needs no change";
            findings.add(Diagnostic::nowhere(Code::NOT_TOLD, "there is nothing to write", help), &[]);
        }
        Some(text) => {
            files.add(target, text.as_bytes())?;
            report.output = Some(name.display().to_string());
        }
        None => {
            let help = "write [location] and [[dynamic]] as separate sections";
            findings.add(Diagnostic::nowhere(Code::NOT_TOLD, "the machine file cannot be extended", help), &[]);
        }
    }
    Ok(())
}
