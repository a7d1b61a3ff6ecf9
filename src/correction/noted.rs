//! Results of a run in the units of the report.

use std::collections::BTreeMap;

use crate::run::Running;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, AxisKey};
use ncfix_base::source::Source;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_path::path::{self, Prediction};
use ncfix_report::correction::{CorrectionReport, RepeatedBlock};
use ncfix_report::json;

/// The residual of an error source, in the units of reports.
pub(super) fn remaining(left: &path::Remaining) -> json::RemainingReport {
    json::RemainingReport {
        source: left.source,
        position_um: um_from_mm(left.position_mm),
        tilt_urad: urad_from_rad(left.tilt_rad),
        roll_urad: urad_from_rad(left.roll_rad),
    }
}

/// A spread in the units of reports.
pub(crate) fn spread(spread: &path::Spread) -> json::SpreadReport {
    json::SpreadReport {
        mean_um: um_from_mm(spread.mean_mm()),
        rms_um: um_from_mm(spread.rms_mm()),
        max_um: um_from_mm(spread.max_mm),
    }
}

/// The diagnostic for blocks that the division of moves has made shorter than the block cycle, and its source.
pub(super) fn short_blocks(
    short: &path::ShortBlocks,
    sources: &[Source],
    report: &CorrectionReport,
) -> Option<(Diagnostic, Source)> {
    let origin = short.first_divided?;
    let source = sources.iter().find(|source| source.id() == origin.file)?.clone();
    let said = report.short_blocks?;
    let message = format!(
        "here the correction divides a move into blocks shorter than the block cycle of {} ms; in the whole output {} blocks are shorter, in the program {}",
        said.block_cycle_ms, said.written, said.source
    );
    let help = "the control moves through them more slowly: allow a larger --tolerance for fewer blocks, or program a lower feed";
    Some((Diagnostic::at(Code::SHORT_BLOCKS, Place { file: origin.file, span: origin.span }, message, help), source))
}

/// Takes the numbers of a prediction into the report.
pub(super) fn note(
    prediction: &Prediction,
    running: &Running,
    machine: &ncfix_machine::machine::Machine,
    tolerance_mm: f64,
    report: &mut CorrectionReport,
) {
    // Without a move from a known position, nothing is known of its error.
    let is_known = prediction.before().samples > 0 || prediction.moves == 0;
    let known = |own: &path::Spread| is_known.then(|| spread(own));
    report.before = known(prediction.before());
    report.before_form = known(prediction.form());
    report.after = known(prediction.after());
    report.rapids_as_programmed = prediction.as_programmed;
    report.off_at_rapids_um = um_from_mm(prediction.off_cut_mm);
    report.short_blocks = machine.control.block_cycle_s.map(|cycle_s| ncfix_report::correction::ShortBlocksReport {
        block_cycle_ms: cycle_s * 1e3,
        source: prediction.short_blocks.source,
        written: prediction.short_blocks.written,
        shortest_ms: (prediction.short_blocks.written > 0).then_some(prediction.short_blocks.shortest_s * 1e3),
    });
    report.blocks_in = running.blocks();
    report.drilling_cycles = prediction.kept_holes;
    let off_um = um_from_mm(prediction.kept_hole_mm);
    report.cycles_off_um = (off_um > um_from_mm(tolerance_mm)).then_some(off_um);
    report.drilled_by_moves = prediction.expanded_holes;
    let needed_um = um_from_mm(prediction.expanded_hole_mm);
    report.cycles_need_um = (needed_um > 0.0).then(|| needed_um.ceil());
    let name_of =
        |file| running.sources().iter().find(|source| source.id() == file).map(|source| source.name().to_owned());
    report.most_repeated = prediction
        .repeated
        .largest()
        .and_then(|(file, line, times)| Some(RepeatedBlock { line, file: name_of(file)?, times }));
    if let Some(origin) = prediction.max_at() {
        report.max_at_line = Some(origin.line);
        let source = running.sources().iter().find(|source| source.id() == origin.file);
        report.max_at_file = source.map(|source| source.name().to_owned());
    }
    report.max_correction = AXES
        .into_iter()
        .filter(|&axis| prediction.max_correction[axis] > 0.0)
        .map(|axis| {
            let key = AxisKey::of_deviation(axis);
            (key, key.shown(prediction.max_correction[axis]))
        })
        .collect::<BTreeMap<_, _>>();
}
