//! `ncfix plan`: poses of a measurement and the program that runs them.

pub(in crate::cli) mod arguments;

use crate::cli::arguments::PlanArguments;
use crate::cli::atomic_writes::AtomicWrites;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::machine_choice;
use crate::cli::output::Target;
use crate::cli::program::protect;
use crate::cli::stop::Stop;
use crate::cli::tell;
use crate::plan::PlanRequest;
use ncfix_report::plan::page;

/// Writes a plan.
pub(in crate::cli) fn run(arguments: &PlanArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let result = plan(arguments, &mut findings);
    findings.draw();
    match result? {
        Some(report) => tell(&report),
        None => tell(&format!("{}; nothing was written\n", findings.count())),
    }
    Ok(findings.exit_code())
}

fn plan(arguments: &PlanArguments, findings: &mut Findings) -> Result<Option<String>, Stop> {
    let description = arguments.output.with_extension("toml");
    let mut targets = vec![Target::new(&arguments.output)?, Target::new(&description)?];
    if description == arguments.output || targets.iter().any(|target| !target.is_file()) {
        return Err(Stop::Usage("the plan is two files; give -o the name of the table, such as plan.csv".into()));
    }
    targets.extend(arguments.program.as_deref().map(Target::new).transpose()?);
    if arguments.program.as_ref().is_some_and(|program| *program == arguments.output || *program == description) {
        return Err(Stop::Usage("the program and the plan have the same name".into()));
    }
    let found = machine_choice::choose(&arguments.machine, &arguments.output, findings)?;
    let Some(chosen) = found else { return Ok(None) };
    for target in &targets {
        protect(target, chosen.files.iter(), findings);
    }
    let request = PlanRequest {
        kind: arguments.kind,
        wishes: &arguments.wishes(&chosen.machine),
        is_seeded: arguments.seed.is_some(),
        model: arguments.model.as_deref(),
        with: &arguments.with,
        more: arguments.improve.unwrap_or(0),
        has_program: arguments.program.is_some(),
    };
    let Some(made) = request.run(&chosen, findings)? else { return Ok(None) };
    let texts = [made.table.into_bytes(), made.description.into_bytes()].into_iter().chain(made.program);
    let mut together = AtomicWrites::default();
    for (target, text) in targets.into_iter().zip(texts) {
        together.add(target, &text)?;
    }
    together.publish()?;
    Ok(Some(page(&made.result, &arguments.output.display().to_string(), &description.display().to_string())))
}
