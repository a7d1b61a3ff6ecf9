//! The result of a comparison of two programs.

use std::collections::BTreeMap;

use super::CompareOptions;
use super::walk::Outcome;
use crate::correction::spread;
use crate::diagnostics::Diagnostics;
use crate::disk::hash::whole_hash;
use ncfix_base::source::Source;
use ncfix_base::units::{UnitKey, um_from_mm, urad_from_rad};
use ncfix_path::emit;
use ncfix_path::review::{ReviewTrace, Summary};
use ncfix_report::review::{AxisSummary, Beyond, LargestStep, Limit, Review};
use ncfix_report::verdict::{LEFT, Verdict};

/// Two compared programs.
pub(crate) struct ComparedPrograms<'a> {
    pub(crate) wanted: &'a CompareOptions,
    /// The names of both files.
    pub(crate) names: [String; 2],
    pub(crate) trace: &'a ReviewTrace,
    pub(crate) outcome: &'a Outcome,
    pub(crate) corrected: &'a Source,
}

impl ComparedPrograms<'_> {
    /// The result without its rows.
    pub(crate) fn review(&self, findings: &Diagnostics) -> Review {
        let axes = self.wanted.all_axes();
        let found = Summary::of(&self.trace.rows, &axes, self.wanted.tolerance(), self.outcome.increments[0]);
        let counts = [found.left.no_error, found.left.unstated, found.left.rapid, found.left.other];
        let left = LEFT.iter().map(|(why, _)| *why).zip(counts);
        let figures = found.axes.iter().map(|one| {
            let scale: fn(f64) -> f64 = if one.axis.is_rotary() { urad_from_rad } else { um_from_mm };
            let [max, mean, rms, p99] = [one.max, one.mean, one.rms, one.p99].map(scale);
            let unit = UnitKey::of(one.axis.is_rotary());
            let (file, line) = one.max_at.original;
            (
                one.axis.to_string(),
                AxisSummary { unit, max, max_line: line, max_file: self.subprogram(file), mean, rms, p99 },
            )
        });
        let original = self.outcome.sources[0].first();
        let limits = self.wanted.limit_mm.map(|limit_mm| {
            let largest = self.trace.rows.iter().map(|row| row.largest(&axes)).fold(0.0, f64::max);
            let name = "the largest change of an axis".to_owned();
            Limit { name, value_um: largest, limit_um: um_from_mm(limit_mm), is_kept: largest <= um_from_mm(limit_mm) }
        });
        let beyond = self.outcome.beyond.iter();
        let beyond = beyond.map(|(axis, &(pieces, line))| (axis.to_string(), Beyond { pieces, line }));
        let mut review = Review {
            schema: 1,
            same: found.changed == 0,
            compared: "executed",
            files: self.names.clone(),
            bytes: [original.map_or(0, |source| source.bytes().len() as u64), self.corrected.bytes().len() as u64],
            moves: [found.moves, found.pieces],
            changed: found.changed,
            split: found.split,
            left: left.filter(|(_, count)| *count > 0).collect(),
            other_feeds: found.other_feeds,
            feed_share: self.trace.feeds,
            beyond_travel: beyond.collect(),
            axes: figures.collect(),
            largest_step: found.largest_step.map(|(mm, at)| {
                let (file, line) = at.original;
                LargestStep { um: um_from_mm(mm), line, file: self.subprogram(file) }
            }),
            longest_line: longest(self.corrected),
            before: Some(spread(&self.outcome.comparison.before)),
            before_form: Some(spread(&self.outcome.comparison.form)),
            zeros: self.outcome.zeros.clone(),
            after: Some(spread(&self.outcome.comparison.after)),
            rounding_um: um_from_mm(self.outcome.rounding_mm),
            limits: limits.into_iter().collect(),
            coverage: Some(self.outcome.coverage.clone()),
            prediction: self.outcome.prediction.clone(),
            provenance: self.provenance(),
            diagnostics: findings.json(),
            ..Review::default()
        };
        review.verdict = Verdict::of(&review);
        review
    }
}

impl ComparedPrograms<'_> {
    /// The name of a file of the original; `None` for the program itself.
    fn subprogram(&self, file: u16) -> Option<String> {
        let files = self.outcome.sources[0].iter().skip(1);
        files.filter(|source| source.id().0 == file).map(|source| source.name().to_owned()).next()
    }

    /// The origin of the comparison.
    fn provenance(&self) -> BTreeMap<&'static str, String> {
        let machine = &self.outcome.machine;
        let mut all = BTreeMap::from([
            ("made by", format!("ncfix {}", env!("CARGO_PKG_VERSION"))),
            ("machine", machine.name.clone()),
            ("machine file, SHA-256", machine.model.clone()),
            ("corrected program, SHA-256", whole_hash(self.corrected.bytes())),
        ]);
        if let Some(original) = self.outcome.sources[0].first() {
            all.insert("original program, SHA-256", whole_hash(original.bytes()));
        }
        let stamp = [
            ("corrected for the machine file", emit::stamped_model(self.corrected.bytes())),
            ("corrected for the state", emit::stamped_state(self.corrected.bytes())),
            ("state, SHA-256", machine.state.clone()),
        ];
        all.extend(stamp.into_iter().filter_map(|(what, value)| Some((what, value?))));
        all
    }
}

/// Length and number of the longest line.
fn longest(source: &Source) -> [u64; 2] {
    let lines = source.bytes().split(|&byte| byte == source.line_end()).enumerate();
    let length = |line: &[u8]| line.strip_suffix(b"\r").unwrap_or(line).len() as u64;
    let longest = lines.map(|(number, line)| [length(line), number as u64 + 1]);
    longest.max_by(|a, b| a[0].cmp(&b[0]).then(b[1].cmp(&a[1]))).unwrap_or_default()
}
