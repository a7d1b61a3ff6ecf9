//! Output of `ncfix realtime`: the kernel, and at the end the answered set-points.

use std::fmt::Write as _;

use super::number::{grouped, micrometers, significant};
use ncfix_tables::results::realtime::{KernelResult, RealtimeResult};

/// Describes the kernel: `200 intervals per axis; functions beside them: 1 of X; within 0.002 µm and 0.000 µrad of the model at 1000 poses`.
#[must_use]
pub fn kernel(kernel: &KernelResult) -> String {
    let direct = &kernel.direct_functions;
    let direct: Vec<String> = direct.iter().map(|(axis, count)| format!("{count} of {axis}")).collect();
    let direct =
        if direct.is_empty() { String::new() } else { format!("; additional functions: {}", direct.join(", ")) };
    let heads: Vec<String> = kernel.heads.iter().map(|(number, name)| format!("{number} {name}")).collect();
    let heads = if heads.is_empty() { String::new() } else { format!("heads: {}\n", heads.join(", ")) };
    format!(
        "{} intervals per axis{direct}; within {} and {} µrad of the model at {} poses\n{heads}",
        kernel.intervals,
        micrometers(kernel.position_um),
        significant(kernel.direction_urad),
        kernel.poses
    )
}

/// Returns the text at the end, such as `1,000 set-points; 3 beyond, 12 dosed`; with `has_times` also the times.
#[must_use]
pub fn page(result: &RealtimeResult, has_times: bool) -> String {
    let counted: Vec<String> =
        result.signals.iter().map(|&(word, count)| format!("{} {word}", grouped(count))).collect();
    let separator = if counted.is_empty() { "" } else { "; " };
    let mut page = format!("{} set-points{separator}{}\n", grouped(result.set_points), counted.join(", "));
    let total: u64 = result.times.iter().map(|one| one.count).sum();
    if has_times && total > 0 {
        page.push_str("\n        from          to       count     share within\n");
        let mut passed = 0;
        for one in &result.times {
            passed += one.count;
            let share = 100.0 * passed as f64 / total as f64;
            let _ = writeln!(page, "{:9} ns {:8} ns {:11} {share:13.4} %", one.from_ns, one.to_ns, one.count);
        }
        let [half, most, tail] = result.quantiles_ns;
        let max = result.max_ns;
        let _ = writeln!(page, "p50 {half} ns, p99 {most} ns, p99.9 {tail} ns, max {max} ns");
    }
    page
}
