//! Output of `ncfix plan`.

use super::number::counted;
use std::fmt::Write as _;

use ncfix_metrology::results::planned::{JudgedPlan, PlanJudgement, PlanResult};

/// Maximum number of sentences that are shown.
const MOST_SENTENCES: usize = 12;

/// Returns the text for the user about a plan that was written to `table` and its description in `description`.
#[must_use]
pub fn page(plan: &PlanResult, table: &str, description: &str) -> String {
    let model = plan.model.as_deref().unwrap_or_default();
    let mut out: String = plan.judgements.iter().map(|one| said(one, model)).collect();
    if !plan.from_tool.is_empty() {
        let _ = writeln!(
            out,
            "  only the stated tool tells {}: an error of its length is an error of them; calibrate it, or add a known distance of two balls ([[length]])",
            joined(&plan.from_tool)
        );
    }
    for note in &plan.notes {
        let _ = writeln!(out, "note: {note}");
    }
    let _ = writeln!(out, "measuring time: {}", time(plan));
    let [rows, set_ups] =
        [(plan.rows, "row"), (plan.setups, "set-up")].map(|(count, noun)| counted(count as u64, noun));
    let _ = writeln!(out, "{table}: {rows} in {set_ups}; description in {description}");
    out
}

/// `14 min and 5 stops`
fn time(plan: &PlanResult) -> String {
    const MINUTE_S: f64 = 60.0;
    let moved = if plan.duration_s < MINUTE_S {
        format!("{:.0} s", plan.duration_s)
    } else {
        format!("{:.0} min", plan.duration_s / MINUTE_S)
    };
    let stops = if plan.stops > 0 { format!(" and {}", counted(plan.stops as u64, "stop")) } else { String::new() };
    let rapids = if plan.is_without_rapids { ", without rapid moves" } else { "" };
    format!("{moved} of motion and dwells{stops}{rapids}")
}

/// `A, B and C`
fn joined(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Describes the parameters that measurements by a plan can determine.
fn said(judgement: &PlanJudgement, model: &str) -> String {
    let who = match judgement.of {
        JudgedPlan::Plan => "the plan".to_owned(),
        JudgedPlan::Alone => "the plan alone".to_owned(),
        JudgedPlan::WithOthers(count) => {
            format!("together with {} the plan", counted(count as u64, "other measurement"))
        }
        JudgedPlan::WithMorePoses(count) => format!("with {} the plan", counted(count as u64, "more pose")),
    };
    let Some(told) = &judgement.determined else {
        return format!("{who} has positions that are too large to evaluate it\n");
    };
    let mut out = format!(
        "model {model}, {} and {} of the set-up: {who} determines {} of {} (condition {:.0})\n",
        counted(told.parameters as u64, "parameter"),
        counted(told.unknowns as u64, "unknown"),
        told.rank,
        told.columns,
        told.condition
    );
    for one in told.not_identifiable.iter().take(MOST_SENTENCES) {
        let _ = writeln!(out, "  cannot determine: {}\n    {}", one.sentence, one.remedy);
    }
    let all = told.not_identifiable.len();
    if all > MOST_SENTENCES {
        let _ = writeln!(out, "  cannot determine: and {} more", all - MOST_SENTENCES);
    }
    for sentence in told.harmless.iter().take(MOST_SENTENCES) {
        let _ = writeln!(out, "  not needed: {sentence}");
    }
    if told.left_out > 1 {
        let _ =
            writeln!(out, "  all others could be determined without these {}: {}", told.left_out, told.left_out_names);
    }
    out
}
