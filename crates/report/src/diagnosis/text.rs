//! Diagnosis for people: the text on the terminal, and the sentences that it shares with the page.

use std::fmt::Write as _;

use super::DiagnosisReport;
use super::contradiction::contradiction_sentence;
use super::next::next_sentence;
use crate::component::spelled_out;
use crate::number::{grouped, percent, probability, significant};
use ncfix_metrology::diagnose::cause::Correctable;
use ncfix_metrology::diagnose::{CauseId, ExplanationSummary, Gate};
use ncfix_metrology::results::diagnosis::{
    CauseReport, InFile, NoiseFrom, PositionUnit, RejectedReport, ShapePlace, SizeRange,
};
use ncfix_metrology::results::hypotheses::HypothesisReport;

/// Maximum number of other explanations that are named.
const RIVALS: usize = 8;
/// Smallest p-value that is shown as a number.
const LEAST_P: f64 = 1e-12;
/// Maximum number of listed points of a shape.
const PLACES: usize = 7;
/// Maximum number of causes in the verdict.
const CAUSES: usize = 4;
/// Multiple of its expanded uncertainty from which a cause is present in a file.
const SEEN: f64 = 2.0;
/// Ratio of noise to stated noise from which it is reported.
const TIMES: f64 = 2.5;
/// An explanation that is more probable than this is shown alone.
const SURE: f64 = 0.95;
/// Maximum number of listed explanations.
const EXPLANATIONS: usize = 4;
/// Explanations that are less probable are not listed.
const LEAST_SHOWN: f64 = 0.01;
/// A cause with this probability is more probable than everything that may stand in its place.
const MORE_THAN_ALL_OTHERS: f64 = 0.5;
/// A residual beyond this multiple of the noise is no noise.
const NOISY: f64 = 2.0;
/// Maximum number of listed rejected candidates.
const REJECTED: usize = 5;

impl DiagnosisReport {
    /// Returns the text for people.
    #[must_use]
    pub fn page(&self) -> String {
        let mut out = self.hypotheses();
        let _ = writeln!(
            out,
            "{}
{}",
            self.headline(),
            self.before_sentence()
        );
        if self.found.findings.is_empty() {
            let _ = writeln!(out, "No cause accepted ({} candidates tested).", grouped(self.found.tried as u64));
        }
        for (rank, one) in self.found.findings.iter().enumerate() {
            self.cause(rank + 1, one, &mut out);
        }
        self.tail(&mut out);
        out
    }

    /// Returns the symbol of the unit of readings.
    #[must_use]
    pub fn unit_sign(&self) -> &'static str {
        self.found.unit.unit().sign()
    }

    /// Returns the residual of the model in one sentence.
    #[must_use]
    pub fn before_sentence(&self) -> String {
        let from = match self.found.noise_from {
            NoiseFrom::Repeats => "from repeated readings",
            NoiseFrom::Instrument => "as stated for the instrument",
            NoiseFrom::Rest => "from the residual, which is not systematic",
            NoiseFrom::Neighbours | NoiseFrom::Nowhere => "from neighboring readings",
        };
        let unit = self.unit_sign();
        let times = self.found.noise_stated_um.map_or(1.0, |stated| self.found.noise_um / stated);
        let after = self.found.after.rms_um;
        let stated = if times > TIMES {
            format!(", {} times the stated sigma", significant(times))
        } else if times * TIMES < 1.0 {
            format!(", and the stated sigma is {} times as large", significant(1.0 / times))
        } else if self.found.noise_from == NoiseFrom::Instrument && after * TIMES < self.found.noise_um {
            format!(
                ", but the residual after all causes is only {} {unit}: this sigma is too large",
                significant(after)
            )
        } else {
            String::new()
        };
        format!(
            "{}: residual {} {unit} RMS over {} readings, {} {unit} at most. Noise {} {unit}, {from}{stated}.",
            self.found.machine,
            significant(self.found.before.rms_um),
            grouped(self.found.readings as u64),
            significant(self.found.before.max_um),
            significant(self.found.noise_um)
        )
    }

    /// Returns the main result: the largest cause, how sure it is, what it costs, and the next step.
    #[must_use]
    pub fn headline(&self) -> String {
        let unit = self.unit_sign();
        let found = &self.found;
        if let Some(expired) = self.expired_sentence().filter(|_| found.findings.is_empty()) {
            return format!("{expired} Next: calibrate again.");
        }
        if let Some(sentence) = found.contradiction.as_ref().and_then(contradiction_sentence) {
            let expired = self.expired_sentence().map_or(String::new(), |sentence| format!("{sentence} "));
            return expired + &sentence;
        }
        // By its fair share: of causes that cancel each other, each alone may be larger than the residual.
        let is_sure = |one: &&CauseReport| one.certain;
        let sure = found.findings.iter().filter(is_sure).max_by(|a, b| a.share.total_cmp(&b.share));
        let Some(largest) = sure.or(found.findings.iter().max_by(|a, b| a.share.total_cmp(&b.share))) else {
            if !found.unexplained.structure && found.after.rms_um > NOISY * found.noise_um {
                return format!(
                    "The residual of {} {unit} RMS is {} times the noise, but no cause is certain. Next: measure the same positions again, in both directions.",
                    significant(found.after.rms_um),
                    significant(found.after.rms_um / found.noise_um)
                );
            }
            // The shape of an error between sparse positions is a part of this scatter.
            let is_known = found.noise_from != NoiseFrom::Neighbours;
            if !found.unexplained.structure && !is_known {
                return format!(
                    "No cause exceeds the scatter of neighboring readings, {} {unit}. Next: measure the same positions again, which shows the noise of a reading.",
                    significant(found.noise_um)
                );
            }
            // The explanations below the verdict may name causes that are probable and not accepted.
            let first = found.explanations.first().filter(|first| !first.terms.is_empty() && first.probability >= 0.5);
            let failed = first.map(|first| self.failed_sentence(first));
            if !found.unexplained.structure {
                return match failed {
                    Some(failed) => {
                        format!("No cause passes all tests: {failed}. Next: measure more readings in both directions.")
                    }
                    _ => "The model explains the readings within their noise: the machine file needs no change.".into(),
                };
            }
            let failed = failed.map_or(String::new(), |failed| format!(": {failed}"));
            return format!(
                "{} {unit} RMS are systematic, but no cause is certain{failed}. Next: measure more set-ups, in both directions of every axis.",
                significant(found.unexplained.rms_um)
            );
        };
        let words = spelled_out(&largest.parameter).filter(|_| largest.is_component());
        let words = words.map_or(String::new(), |words| format!(" ({words})"));
        let sure = largest.probability.map_or_else(|| p_value(largest.p), probability);
        // One that predicts the same readings stands beside it.
        let rival = largest.rivals.first().filter(|_| !largest.certain);
        // Its probability is that beside this cause. Where noise alone is another explanation, it is not that among all.
        let nothing = found.no_cause_probability.unwrap_or(0.0);
        let rival = rival.map_or(String::new(), |one| match one.probability + nothing > 1.0 {
            true => format!(" or {}", one.cause),
            false => format!(" or {} ({})", one.cause, probability(one.probability)),
        });
        let others = match found.findings.len() - 1 {
            0 => String::new(),
            1 => " One more cause was found.".to_owned(),
            count => format!(" {count} more causes were found."),
        };
        let is_doubtful =
            |one: &&CauseReport| one.name() != largest.name() && one.probability.is_some_and(|own| own < 0.5);
        let others = match found.findings.iter().filter(is_doubtful).count() {
            0 => others,
            count if count + 1 == found.findings.len() => {
                others.replace("found.", "found, with a probability below 50 %.")
            }
            count => format!("{} {count} of them with a probability below 50 %.", others.replace("found.", "found,")),
        };
        // Another cause may be larger and not certain, or have a larger effect that others cancel.
        let is_larger = |one: &&CauseReport| one.share > largest.share || one.rms_um > largest.rms_um;
        let first = match (is_sure(&largest), found.findings.iter().filter(is_larger).any(|one| one.certain)) {
            (false, _) => self.not_certain(largest),
            (true, true) => "Cause of the largest part of the residual".to_owned(),
            (true, false) if found.findings.iter().any(|one| is_larger(&one)) => "Largest certain cause".to_owned(),
            (true, false) => "Largest cause".to_owned(),
        };
        let expired = self.expired_sentence().map_or(String::new(), |sentence| format!("{sentence} "));
        // The beginning of an uncertain result states the probability of noise.
        let is_of_noise = found.explanations.first().is_some_and(|first| first.terms.is_empty());
        let is_said = !is_sure(&largest) && is_of_noise && nothing >= LEAST_SHOWN;
        let more_probable = if is_said { String::new() } else { self.more_probable(self.unsure().unwrap_or(largest)) };
        format!(
            "{expired}{first}: {}{words}{}, {} ({sure}){rival}; its effect is {} {unit} RMS, the residual {} {unit} RMS.{others} Next: {}.",
            largest.name(),
            by_sensor(largest),
            largest.size(),
            significant(largest.rms_um),
            significant(found.before.rms_um),
            self.next_step(largest)
        ) + &more_probable
    }

    /// Returns the acceptance test that the most probable explanation failed, as a part of a sentence.
    fn failed_sentence(&self, first: &ExplanationSummary) -> String {
        let test_of = |term: &CauseId| {
            let is_own = |one: &&RejectedReport| term.is_effect(&one.effect, &one.parameter);
            self.found.rejected.iter().find(is_own).map(|one| test(one.why))
        };
        let together = format!("{} ({})", first.joined(" with "), probability(first.probability));
        match first.terms.iter().find_map(|term| Some((term, test_of(term)?))) {
            Some((_, test)) if first.terms.len() == 1 => format!("{together} failed {test}"),
            Some((term, test)) => format!("in the most probable explanation, {together}, {term} failed {test}"),
            None => format!("the search did not confirm the most probable explanation, {together}"),
        }
    }

    /// Returns the beginning of the main result without a certain cause: whether noise alone explains the readings as well.
    fn not_certain(&self, largest: &CauseReport) -> String {
        let nothing = self.found.no_cause_probability.unwrap_or(0.0);
        if nothing >= LEAST_SHOWN && nothing >= largest.probability.unwrap_or(1.0) {
            return format!(
                "Nothing is certain: noise alone explains the readings as well ({}); the largest candidate",
                probability(nothing)
            );
        }
        let noise =
            if nothing >= LEAST_SHOWN { format!(" (noise alone: {})", probability(nothing)) } else { String::new() };
        format!("No cause is certain{noise}; the largest candidate")
    }

    /// Returns a sentence if another explanation is more probable than those that contain a cause: then its readings do not decide.
    fn more_probable(&self, largest: &CauseReport) -> String {
        let is_less = |one: &&ExplanationSummary| {
            largest.probability.is_some_and(|own| own < MORE_THAN_ALL_OTHERS && own < one.probability)
                && !one.terms.iter().any(|term| term.is_effect(&largest.effect, &largest.parameter))
        };
        match self.found.explanations.first().filter(is_less) {
            Some(first) => format!(
                " Another explanation of these readings is more probable: {} ({}).",
                if first.terms.is_empty() { "noise alone".to_owned() } else { first.joined(" with ") },
                probability(first.probability)
            ),
            None => String::new(),
        }
    }

    /// Returns a cause of the extended machine file that is less probable than another explanation: the file must wait for a measurement.
    fn unsure(&self) -> Option<&CauseReport> {
        self.found.findings.iter().find(|one| one.extends && !self.more_probable(one).is_empty())
    }

    /// Returns the next step after this result.
    fn next_step(&self, largest: &CauseReport) -> String {
        let findings = &self.found.findings;
        // A stated hypothesis contests the finding.
        let stated = |cause: &str| self.found.hypotheses.iter().find(|one: &&HypothesisReport| one.text == cause);
        let of_hypothesis = largest.rivals.iter().find_map(|rival| stated(rival.cause.stated()?)?.next.as_ref());
        if let Some(command) = of_hypothesis.filter(|_| !largest.certain) {
            return format!("fit and write the hypothesis with {command}");
        }
        let is_correctable = |one: &&CauseReport| one.correctable == Correctable::Program;
        let unsure = self.unsure().or(Some(largest).filter(|one| !self.more_probable(one).is_empty()));
        // A plan predicts no cause that depends on another quantity, such as a drift.
        let separating = |one: &CauseReport| {
            let next = self.found.measure_next.first().filter(|_| one.rivals.is_empty());
            next.map(next_sentence).or(one.separate_by.clone())
        };
        if let Some(how) = unsure.and_then(separating) {
            return format!("measure what separates the explanations: {how}");
        }
        // A file without the largest cause does not remove it.
        let is_left_out = !largest.extends && largest.correctable == Correctable::No;
        if is_left_out && findings.iter().any(|one| one.extends) {
            let file = self.output.as_deref().unwrap_or("the extended machine file");
            let how = separating(largest).unwrap_or_else(|| "see \"not corrected\" below".to_owned());
            return format!("measure what separates the explanations: {how}; {file} holds only other causes");
        }
        if let Some(path) = &self.output {
            return format!("correct programs with {path}");
        }
        if findings.iter().any(|one| is_correctable(&one)) {
            return "write the extended machine file with -o, and correct programs with it".into();
        }
        if findings.iter().any(|one| one.correctable == Correctable::Live) {
            return "correct it live, with readings of the sensors".into();
        }
        match separating(largest) {
            Some(how) if largest.class.len() > 1 => format!("measure what separates the explanations: {how}"),
            _ if largest.what.is_some() => format!("measure how it depends on {}", largest.drivers.join(" and ")),
            _ => format!("check the machine and the measurement for {}", largest.made_by),
        }
    }

    /// Returns the gain of the written file in one sentence.
    #[must_use]
    pub fn written_sentence(&self) -> Option<String> {
        let written = self.found.written?;
        let unit = self.unit_sign();
        let held_out = match (written.holdout_before_rms_um, written.holdout_after_rms_um) {
            (Some(before), Some(after)) => {
                format!("; data held out: {} → {} {unit}", significant(before), significant(after))
            }
            _ => String::new(),
        };
        let holds = if self.output.is_some() { "holds" } else { "would hold" };
        let all = self.found.findings.len();
        let count = match (written.causes, all) {
            (own, 1) => format!("{own} of 1 cause"),
            (own, all) => format!("{own} of {all} causes"),
        };
        let cancels = if written.after_rms_um > written.before_rms_um {
            " In these readings, causes without an entry in the file cancel a part of its correction."
        } else {
            ""
        };
        // A file with drifts alone changes nothing at the reference temperature.
        let travel = written.travel.filter(|travel| travel.before_rms_um > 0.0 || travel.after_rms_um > 0.0);
        let travel = travel.map_or(String::new(), |travel| {
            format!(
                " Predicted with the extended file, on lines through the whole travel: {} µm RMS uncorrected, {} µm corrected.",
                significant(travel.before_rms_um),
                significant(travel.after_rms_um)
            )
        });
        Some(format!(
            "The extended machine file {holds} {count}: residual {} → {} {unit} RMS{held_out}.{cancels}{travel}",
            significant(written.before_rms_um),
            significant(written.after_rms_um)
        ))
    }

    /// Returns the most probable explanations, each with its probability, if the first one is not sure.
    #[must_use]
    pub fn explanation_lines(&self) -> Vec<String> {
        let all = &self.found.explanations;
        if all.first().is_none_or(|first| first.probability > SURE) {
            return Vec::new();
        }
        let line = |one: &ExplanationSummary| {
            let terms = if one.terms.is_empty() { "no cause".to_owned() } else { one.joined(", ") };
            format!("{}: {terms}", percent(one.probability))
        };
        all.iter().take(EXPLANATIONS).filter(|one| one.probability >= LEAST_SHOWN).map(line).collect()
    }

    /// Returns a sentence if the model is no longer valid.
    #[must_use]
    pub fn expired_sentence(&self) -> Option<String> {
        let without = self.found.without_model.holdout_rms_um.unwrap_or(self.found.without_model.rms_um);
        self.found.expired.then(|| {
            let unit = self.unit_sign();
            format!(
                "The model predicts worse than no model, with which the residual is {} {unit} RMS.",
                significant(without)
            )
        })
    }

    /// Returns the residual with all causes in one sentence.
    fn after_sentence(&self) -> Option<String> {
        let unit = self.unit_sign();
        (!self.found.findings.is_empty()).then(|| {
            format!(
                "With {}: residual {} {unit} RMS, {} {unit} at most; efficiency {:.0} % → {:.0} %.",
                if self.found.findings.len() == 1 { "it" } else { "them" },
                significant(self.found.after.rms_um),
                significant(self.found.after.max_um),
                round_percent(self.found.before.efficiency),
                round_percent(self.found.after.efficiency)
            )
        })
    }

    fn held_out_sentence(&self) -> Option<String> {
        let (before, after) = (self.found.before.holdout_rms_um?, self.found.after.holdout_rms_um?);
        if self.found.findings.is_empty() {
            return Some(format!("Data held out: residual {} {} RMS.", significant(before), self.unit_sign()));
        }
        let [low, high] = self.found.holdout_gain_95.unwrap_or_default();
        let gain = 100.0 * self.found.holdout_gain.unwrap_or_default();
        let change = if gain < 0.0 {
            format!("{:.0} % more", -gain)
        } else {
            format!("{:.0} % less ({:.0} … {:.0} %)", gain + 0.0, 100.0 * low + 0.0, 100.0 * high + 0.0)
        };
        Some(format!("Data held out: {} → {} {}, {change}.", significant(before), significant(after), self.unit_sign()))
    }

    fn unexplained_sentence(&self) -> String {
        if !self.found.unexplained.structure {
            let times = self.found.after.rms_um / self.found.noise_um;
            return if times > NOISY {
                format!(
                    "The residual is {} times the noise, but no test shows on which quantity of these data it depends.",
                    significant(times)
                )
            } else {
                "No systematic residual beyond the noise.".into()
            };
        }
        let unit = self.unit_sign();
        let with: Vec<String> = self
            .found
            .unexplained
            .with
            .iter()
            .map(|one| format!("{} ({} {unit})", one.driver, significant(one.rms_um)))
            .collect();
        format!(
            "An unexplained residual of {} {unit} RMS exceeds the noise{}{}.",
            significant(self.found.unexplained.rms_um),
            if with.is_empty() { "" } else { "; it depends on " },
            with.join(", ")
        )
    }

    /// Returns the verdict in one paragraph.
    #[must_use]
    pub fn verdict(&self) -> String {
        let mut out = vec![self.headline(), self.before_sentence()];
        let named: Vec<String> = self
            .found
            .findings
            .iter()
            .take(CAUSES)
            .map(|one| {
                let what = one.what.as_deref().and_then(|what| what.strip_prefix("unknown: "));
                let what = what.map_or_else(
                    || self.distinct_name(one),
                    |what| what.trim_end_matches("; shape attached").to_owned(),
                );
                format!("{what}, {} ({:.0} % of the sum of squares)", one.size(), round_percent(one.share))
            })
            .collect();
        let more = self.found.findings.len().saturating_sub(CAUSES);
        let rest = if more > 0 { format!("; and {more} more") } else { String::new() };
        out.push(match self.found.findings.len() {
            0 => format!("No cause accepted ({} candidates tested).", grouped(self.found.tried as u64)),
            1 => format!("One cause accepted: {}.", named.join("")),
            count => format!("{count} causes accepted: {}{rest}.", named.join("; ")),
        });
        out.extend(self.after_sentence());
        out.extend(self.held_out_sentence());
        out.extend(self.written_sentence());
        out.push(self.unexplained_sentence());
        match self.found.data_faults.len() {
            0 => {}
            1 => out.push("The data have a fault, see below.".into()),
            count => out.push(format!("The data have {count} faults, see below.")),
        }
        out.join(" ")
    }

    // Writing into a String cannot fail.
    fn tail(&self, out: &mut String) {
        for fault in &self.found.data_faults {
            let rows = match fault.rows.as_slice() {
                // Outliers are listed row by row.
                [first, last] if fault.is_range => format!("rows {first} to {last}"),
                [row] => format!("row {row}"),
                rows => format!("{} rows", rows.len()),
            };
            let _ = writeln!(out, "\n{} {}: {} ({rows})", fault.kind, fault.name, fault.what);
            if !fault.evidence.is_empty() {
                let _ = writeln!(out, "   {}", fault.evidence);
                let _ = writeln!(out, "   excluded: {}", fault.excluded);
            }
        }
        for one in &self.found.not_confirmed {
            let _ = writeln!(out, "\n{one}: found in the data, but the held-out data do not confirm it.");
        }
        let rejected: Vec<String> = self
            .found
            .rejected
            .iter()
            .filter(|one| one.why != Gate::HeldOut)
            .map(|one| format!("{} (failed {})", name(&one.effect, &one.parameter), test(one.why)))
            .collect();
        if !rejected.is_empty() {
            let more = rejected.len().saturating_sub(REJECTED);
            let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
            let shown = rejected.get(..REJECTED.min(rejected.len())).unwrap_or_default().join(", ");
            let _ = writeln!(out, "\nRejected: {shown}{rest}.");
        }
        for one in &self.found.rejected {
            if let Some(differs) = differing(&one.by_file) {
                let _ = writeln!(out, "{} {differs}", name(&one.effect, &one.parameter));
            }
        }
        let explanations = self.explanation_lines();
        if !explanations.is_empty() {
            let _ = writeln!(out, "\nExplanations by probability:\n   {}", explanations.join("\n   "));
            if let Some(next) = self.found.measure_next.first() {
                let _ = writeln!(out, "   to separate them: {}", next_sentence(next));
            }
        }
        out.push('\n');
        for sentence in [self.after_sentence(), self.held_out_sentence(), self.written_sentence()].into_iter().flatten()
        {
            let _ = writeln!(out, "{sentence}");
        }
        let _ = writeln!(out, "{}", self.unexplained_sentence());
        if self.is_to_be_written && self.found.needs_no_change() {
            let _ = writeln!(out, "\nNot written: no extension is necessary; the existing machine file stays valid.");
        }
        if let Some(path) = &self.output {
            let _ = writeln!(out, "\nWritten: {path}");
            for one in self.found.findings.iter().filter(|one| !one.extends) {
                let why = one.extends_why.as_deref().unwrap_or("it has no entry");
                let _ = writeln!(out, "Not written: {}: {why}.", self.distinct_name(one));
            }
        }
    }

    /// Returns the name of a finding, with its form if another finding has the same name.
    fn distinct_name(&self, one: &CauseReport) -> String {
        one.name() + &self.form_among(one)
    }

    /// Returns the form of a finding, after a comma, if another finding has the same name; else nothing.
    fn form_among(&self, one: &CauseReport) -> String {
        let alike = self.found.findings.iter().filter(|other| other.name() == one.name()).count();
        if alike > 1 { format!(", {}", one.form()) } else { String::new() }
    }

    fn cause(&self, rank: usize, one: &CauseReport, out: &mut String) {
        let words = spelled_out(&one.parameter).filter(|_| one.is_component());
        let words = words.map_or(String::new(), |words| format!(" ({words})"));
        let form = self.form_among(one);
        let over = one.over();
        let _ = writeln!(out, "\n{rank}. {}{words}{form}{}: {} (95 %){over}", one.name(), by_sensor(one), one.size());
        let _ = writeln!(
            out,
            "   explains {} {} RMS, {:.0} % of the residual; {:.0} % smaller residual on left-out readings; {}{}",
            significant(one.rms_um),
            self.unit_sign(),
            round_percent(one.share),
            round_percent(one.gain_holdout),
            one.probability.map_or_else(String::new, |value| format!("{}; ", probability(value))),
            p_value(one.p)
        );
        match &one.what {
            Some(what) => {
                let _ = writeln!(out, "   {what}");
            }
            None => {
                let depends = one.depends();
                let goes = if depends.is_empty() { String::new() } else { format!("depends on {depends}; ") };
                let _ = writeln!(out, "   {goes}usual causes: {}{}", one.made_by, one.remedy());
            }
        }
        if let Some(differs) = differing(&one.by_file) {
            let _ = writeln!(out, "   {differs}");
        }
        if let Some(why) = one.extends_why.as_ref().filter(|_| one.correctable == Correctable::No) {
            let _ = writeln!(out, "   not corrected: {why}");
        }
        shape(one, out);
        if !one.same_as.is_empty() {
            let names = one
                .same_as
                .iter()
                .map(|same| format!("{} of {} {}", same.name, significant(same.value), sign(&one.unit)));
            let _ = writeln!(out, "   the same error seen from another axis: {}", names.collect::<Vec<_>>().join(", "));
        }
        let others = one.others();
        if !others.is_empty() {
            let more = others.len().saturating_sub(RIVALS);
            let rivals: Vec<&str> = others.into_iter().take(RIVALS).collect();
            let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
            let _ = writeln!(out, "   other explanations: {}{rest}", rivals.join(", "));
        }
        if let Some(arm) = one.arm.as_ref().filter(|arm| arm.difference_um >= one.rms_um) {
            let _ = writeln!(
                out,
                "   measured at one arm: if it is {} instead, it differs by up to {} µm elsewhere in the travel",
                arm.cause,
                significant(arm.difference_um)
            );
        }
        let is_said = |how: &&String| one.extends_why.as_ref().is_some_and(|why| why.contains(how.as_str()));
        if let Some(how) = one.separate_by.as_ref().filter(|how| !is_said(how)) {
            let _ = writeln!(out, "   to separate them: {how}");
        }
    }
}

/// Texts of a cause.
pub(crate) trait CauseText {
    /// Returns true if its parameter is an error component, which is spelled out; other effects have words of their own.
    fn is_component(&self) -> bool;
    /// Returns the form of the effect over its drivers: what distinguishes it from another finding of the same name.
    fn form(&self) -> String;
    /// Returns effect and parameter.
    fn name(&self) -> String;
    /// Returns effect and parameter, and the drivers if the cause is unnamed.
    fn full_name(&self) -> String;
    /// Returns value, uncertainty and unit.
    fn size(&self) -> String;
    /// Returns the measured ranges that the size belongs to, with a space before them; empty if it is the same everywhere.
    fn over(&self) -> String;
    /// Returns the drivers, with period and lag.
    fn depends(&self) -> String;
    /// Returns how ncfix can correct it.
    fn remedy(&self) -> &'static str;
    /// Returns its other explanations, without its own other names.
    fn others(&self) -> Vec<&str>;
}

impl CauseText for CauseReport {
    fn others(&self) -> Vec<&str> {
        let is_own = |other: &str| self.same_as.iter().any(|same| other == name("location", &same.name));
        self.class.iter().skip(1).map(String::as_str).filter(|other| !is_own(other)).collect()
    }

    fn is_component(&self) -> bool {
        matches!(self.effect.as_str(), "motion" | "location")
    }

    fn name(&self) -> String {
        name(&self.effect, &self.parameter)
    }

    fn form(&self) -> String {
        let drivers = self.drivers.join(" and ");
        let of_drivers = |word: &str| if drivers.is_empty() { String::new() } else { format!(" {word} {drivers}") };
        let over = of_drivers("over");
        match (self.threshold_mm, &self.threshold_axis, self.period) {
            (Some([low, high]), Some(axis), _) => {
                format!("on one side of {axis} {} to {} mm", significant(low), significant(high))
            }
            (_, _, Some(period)) => format!("period {}{over}", significant(period)),
            // A slope has a unit per length or angle; a range over the travel does not.
            _ if self.unit.contains('/') => format!("linear{}", of_drivers("in")),
            _ => format!("a curve{over}"),
        }
    }

    fn full_name(&self) -> String {
        if self.what.is_some() { format!("{} ({})", self.name(), self.drivers.join(", ")) } else { self.name() }
    }

    fn size(&self) -> String {
        plus_minus(self.value, self.u95, &sign(&self.unit))
    }

    fn over(&self) -> String {
        let of = |one: &SizeRange| {
            let unit = match one.unit {
                PositionUnit::Mm => " mm",
                PositionUnit::Deg => "°",
            };
            format!("{} {} … {}{unit}", one.axis, significant(one.low), significant(one.high))
        };
        let ranges: Vec<String> = self.over.iter().map(of).collect();
        if ranges.is_empty() { String::new() } else { format!(" over {}", ranges.join(" and ")) }
    }

    fn depends(&self) -> String {
        let mut depends = self.drivers.join(", ");
        if let Some(period) = self.period {
            let _ = write!(depends, ", every {}", significant(period));
        }
        if let Some(length) = self.decay_mm {
            let _ = write!(depends, ", decaying over {} mm", significant(length));
        }
        if let (Some([last, first]), Some(axis)) = (self.threshold_mm, &self.threshold_axis) {
            let _ = write!(depends, ", on one side of {axis} {} to {} mm", significant(last), significant(first));
        }
        if let Some(lag) = self.lag_s.filter(|lag| *lag > 0.0) {
            let _ = write!(depends, ", delayed by {} s", significant(lag));
        }
        depends
    }

    /// Returns the possible correction, as the end of a sentence; empty if a reason against it follows.
    fn remedy(&self) -> &'static str {
        match self.correctable {
            Correctable::Program => "; a corrected program removes it",
            Correctable::Live => "; only live readings can remove it",
            Correctable::No if self.extends_why.is_some() => "",
            Correctable::No => "; no program can remove it",
        }
    }
}

/// Returns a value with its uncertainty: `10.0 ± 0.2 µm`. Without a finite one, the readings do not separate the value from the other unknowns of its set-up,
/// such as an offset from a tilt of a plate whose holes are on one line.
#[must_use]
pub(crate) fn plus_minus(value: f64, by: f64, unit: &str) -> String {
    match by.is_finite() {
        true => format!("{} ± {} {unit}", significant(value), significant(by)),
        false => format!(
            "{} {unit} (not separable from other unknowns here, such as an offset from a tilt)",
            significant(value)
        ),
    }
}

/// Returns the size of a cause in each file if files differ; those that have it come first.
#[must_use]
pub(crate) fn differing(files: &[InFile]) -> Option<String> {
    let size = |one: &&InFile| format!("{}: {}", one.file, plus_minus(one.value, one.u95, &sign(&one.unit)));
    let (with, without): (Vec<&InFile>, Vec<&InFile>) = files.iter().partition(|one| one.value.abs() > SEEN * one.u95);
    let list = |files: &[&InFile]| files.iter().map(size).collect::<Vec<String>>().join(", ");
    match [with.as_slice(), without.as_slice()] {
        [[], []] => None,
        [all, []] | [[], all] => Some(format!("differs between files: {}", list(all))),
        [with, without] => {
            Some(format!("is significant in some files only: in {}; not in {}", list(with), list(without)))
        }
    }
}

/// Returns the sensor that an effect follows, and its delay; empty if it follows none.
fn by_sensor(one: &CauseReport) -> String {
    let Some(sensor) = &one.sensor else { return String::new() };
    let lag = one.lag_s.filter(|lag| *lag > 0.0);
    let lag = lag.map_or(String::new(), |lag| format!(" {} s later", significant(lag)));
    format!(" with {sensor}{lag}")
}

/// Returns a share in whole percent, without the sign of a zero.
fn round_percent(share: f64) -> f64 {
    (100.0 * share).round() + 0.0
}

/// Returns the words for an acceptance test, as the object of a sentence.
fn test(gate: Gate) -> &'static str {
    match gate {
        Gate::Chance => "the test of significance",
        Gate::Unseen => "the test on left-out readings",
        Gate::HeldOut => "the test on the held-out data",
    }
}

fn name(effect: &str, parameter: &str) -> String {
    format!("{effect} {parameter}").trim_end().to_owned()
}

/// Returns a unit with its usual symbol.
#[must_use]
pub(crate) fn sign(unit: &str) -> String {
    unit.replace("urad", "µrad").replace("um", "µm").replace("m/s2", "m/s²")
}

/// Formats a p-value: `p = 3e-4`, `p < 1e-12`.
#[must_use]
pub(crate) fn p_value(p: f64) -> String {
    match p {
        p if p < LEAST_P => format!("p < {LEAST_P:e}"),
        p if p < 0.01 => format!("p = {p:.0e}"),
        p => format!("p = {p:.2}"),
    }
}

/// Appends the shape over one driver as a line, over two as a small table.
fn shape(one: &CauseReport, out: &mut String) {
    let unit = one.shape_unit.unit();
    let along = |k: usize| -> Vec<f64> {
        let mut values: Vec<f64> = one.shape.iter().filter_map(|place| place.at.get(k).copied()).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        // The ends and some values in between. The largest value, which may be narrow, replaces the nearest of these.
        let count = values.len();
        let most = if k == 0 && one.drivers.len() == 1 { PLACES } else { PLACES - 2 };
        if count > most {
            values = (0..most).filter_map(|k| values.get(k * (count - 1) / (most - 1)).copied()).collect();
            let peak = one.shape.iter().max_by(|a, b| a.value_um.abs().total_cmp(&b.value_um.abs()));
            if let Some(peak) = peak.and_then(|place| place.at.get(k).copied()).filter(|peak| !values.contains(peak)) {
                let between = values.iter_mut().take(most - 1).skip(1);
                let next = between.min_by(|a, b| (**a - peak).abs().total_cmp(&(**b - peak).abs()));
                next.into_iter().for_each(|value| *value = peak);
            }
        }
        values
    };
    let at = |wanted: &[f64]| {
        let is_there = |place: &&ShapePlace| {
            place.at.iter().map(|value| value.to_bits()).eq(wanted.iter().map(|value| value.to_bits()))
        };
        one.shape.iter().find(is_there).map_or("–".to_owned(), |place| significant(place.value_um))
    };
    match one.drivers.as_slice() {
        _ if one.shape.is_empty() => {}
        [driver] => {
            let places: Vec<String> =
                along(0).into_iter().map(|value| format!("{} at {}", at(&[value]), significant(value))).collect();
            let _ = writeln!(out, "   {unit} over {driver}: {}", places.join(", "));
        }
        [first, second] => {
            let (across, down) = (along(0), along(1));
            let head: String = across.iter().map(|value| format!("{:>9}", significant(*value))).collect();
            let _ = writeln!(out, "   {unit:>18}  {first} {head}");
            for value in down {
                let cells: String = across.iter().map(|first| format!("{:>9}", at(&[*first, value]))).collect();
                let label = format!("{second} {}", significant(value));
                let _ = writeln!(out, "   {label:>18}{:width$}{cells}", "", width = first.chars().count() + 3);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::plus_minus;

    #[test]
    fn an_unknown_uncertainty_is_no_number() {
        assert_eq!(plus_minus(10.04, 0.25, "µm"), "10.0 ± 0.250 µm");
        let text = plus_minus(10.04, f64::INFINITY, "µm");
        assert!(text.starts_with("10.0 µm (not separable") && !text.contains('±'), "{text}");
    }
}
