//! Recordings of the Sinumerik trace function: an XML file (Operate, "Diagnostics › Trace").
//!
//! `traceSession` has `traceDisplaySetup/signals/signal` (name, description, key) and `traceData/dataFrame`. In these each `dataSignal` has a key and
//! an id, and each `rec` has a time in seconds and the values changed since the previous one, as attributes by id (`f1`, `f2`, …). The format is not
//! published; this is the structure of its files (Sinumerik Operate 4.5 to 4.95, also the `_V20` names). The file has no language-independent meaning
//! of its signals, so the description of the trace states it:
//!
//! ```toml
//! [signals]
//! X = "/Nck/MachineAxis/cmdPos[1]"       # a name or a description of a signal
//! X_enc = "/Nck/MachineAxis/encPos[1]"
//! ```

use std::collections::BTreeMap;

use roxmltree::{Document, Node, ParsingOptions};

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_base::source::{Source, Span};
use ncfix_machine::machine::Machine;

use super::ControlSamples;

/// Maximum number of elements in a file: 15 minutes at 1 ms.
const MOST_NODES: u32 = 2_000_000;

/// The signals of a control.
#[derive(Clone, Debug, Default)]
pub struct TraceSignals {
    /// Set-points and encoders.
    pub control: ControlSamples,
}

/// A signal of the file.
#[derive(Debug)]
struct Signal<'a> {
    /// The attribute of its values in records.
    id: String,
    /// Name and description.
    words: [&'a str; 2],
}

/// Reads a file; `names` are the signals by column (`X`, `X_enc`).
///
/// # Errors
/// All diagnostics.
pub fn read(
    source: &Source,
    names: &BTreeMap<String, String>,
    machine: &Machine,
) -> Result<TraceSignals, Vec<Diagnostic>> {
    let whole = Place { file: source.id(), span: Span::new(0, 0) };
    let none = |place: Place, message: String| {
        let help = "give the XML file that the control saves with Diagnostics › Trace";
        vec![Diagnostic::at(Code::DATA_NO_TABLE, place, message, help)]
    };
    let text = std::str::from_utf8(source.bytes()).map_err(|_| none(whole, "the file is not UTF-8".into()))?;
    let text = text.trim_start_matches('\u{feff}');
    let skipped = source.bytes().len() - text.len();
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let at = offset(text, error.pos().row, error.pos().col) + skipped;
        none(Place { file: source.id(), span: Span::new(at, at + 1) }, format!("the file is not XML: {error}"))
    })?;
    let place = |node: Node<'_, '_>| {
        let range = node.range();
        let end = text[range.clone()].find('>').map_or(range.end, |end| range.start + end + 1);
        Place { file: source.id(), span: Span::new(range.start + skipped, end + skipped) }
    };
    let find = |name: &str| document.descendants().find(|node| node.has_tag_name(name));
    let frame = find("dataFrame").ok_or_else(|| none(whole, "the file has no dataFrame: it is not a trace".into()))?;
    let signals = signals(&document, frame);
    let columns = columns(names, &signals, machine, place(frame))?;
    let mut control = ControlSamples::default();
    let mut now: Vec<Option<f64>> = vec![None; columns.len()];
    for record in frame.children().filter(|node| node.has_tag_name("rec")) {
        let bad = |what: &str, text: &str| {
            let message = format!("'{text}' is not a valid {what}");
            vec![Diagnostic::at(Code::DATA_CELL, place(record), message, "correct the file, or record it again")]
        };
        let stated = record.attribute("time").unwrap_or_default();
        let t_s: f64 = stated.parse().ok().filter(|t: &f64| t.is_finite()).ok_or_else(|| bad("time", stated))?;
        for ((_, _, id), value) in columns.iter().zip(&mut now) {
            if let Some(text) = record.attribute(*id) {
                let number: Option<f64> = text.parse().ok().filter(|value: &f64| value.is_finite());
                *value = Some(number.ok_or_else(|| bad("number", text))?);
            }
        }
        if control.t_s.last().is_some_and(|&last| t_s <= last) {
            return Err(bad("time after the previous one", stated));
        }
        // Records begin before every signal has a value.
        let Some(values) = now.iter().copied().collect::<Option<Vec<f64>>>() else { continue };
        let mut both = [AxisVector::ZERO; 2];
        for (&(axis, which, _), value) in columns.iter().zip(values) {
            both[which][axis] = if axis.is_rotary() { value.to_radians() } else { value };
        }
        control.t_s.push(t_s);
        control.set.push(both[0]);
        control.encoder.push(both[1]);
    }
    Ok(TraceSignals { control })
}

/// The signals of a frame with their names, which are in the display set-up.
fn signals<'a>(document: &'a Document<'_>, frame: Node<'a, '_>) -> Vec<Signal<'a>> {
    let shown: BTreeMap<&str, [&str; 2]> = document
        .descendants()
        .filter(|node| node.has_tag_name("signal"))
        .filter_map(|node| {
            Some((node.attribute("key")?, ["name", "description"].map(|word| node.attribute(word).unwrap_or_default())))
        })
        .collect();
    let own = frame.children().filter(|node| node.has_tag_name("dataSignal")).enumerate();
    own.map(|(number, node)| {
        // Older files do not name the attributes: they are numbered.
        let id = node.attribute("id").map_or_else(|| format!("f{}", number + 1), str::to_owned);
        let known = node.attribute("key").and_then(|key| shown.get(key)).copied().unwrap_or_default();
        let words = [0, 1]
            .map(|k| node.attribute(["name", "description"][k]).filter(|text| !text.is_empty()).unwrap_or(known[k]));
        Signal { id, words }
    })
    .collect()
}

/// The axis of each signal: 0 for its set-point, 1 for its encoder.
fn columns<'a>(
    names: &BTreeMap<String, String>,
    signals: &'a [Signal<'_>],
    machine: &Machine,
    place: Place,
) -> Result<Vec<(Axis, usize, &'a str)>, Vec<Diagnostic>> {
    let mut columns = Vec::new();
    let (mut unnamed, mut faults) = (Vec::new(), Vec::new());
    for axis in machine.axes.iter().flatten().map(|data| data.axis) {
        for (which, column) in [axis.to_string(), format!("{axis}_enc")].into_iter().enumerate() {
            let Some(name) = names.get(&column) else {
                unnamed.push(column);
                continue;
            };
            let mut fitting = signals.iter().filter(|one| one.words.contains(&name.as_str()));
            match (fitting.next(), fitting.next()) {
                (Some(one), None) => columns.push((axis, which, one.id.as_str())),
                (Some(_), Some(_)) => faults.push(format!("several signals are named \"{name}\"")),
                _ => faults.push(format!("there is no signal \"{name}\" for {column}")),
            }
        }
    }
    if !unnamed.is_empty() {
        faults.push(format!("the signal for {} is not given", unnamed.join(", ")));
    }
    if faults.is_empty() {
        return Ok(columns);
    }
    let all: Vec<&str> = signals.iter().map(|one| one.words[0]).collect();
    let help = format!("write X = \"…\" below [signals] of the description; the file has: {}", all.join(", "));
    Err(vec![Diagnostic::at(Code::DATA_COLUMN, place, faults.join("; "), help)])
}

/// Byte offset of a line and column of characters, both from 1, in a text.
fn offset(text: &str, row: u32, column: u32) -> usize {
    let line = text.split_inclusive('\n').take(row.saturating_sub(1) as usize).map(str::len).sum::<usize>();
    let rest = text.get(line..).unwrap_or_default();
    let within = rest.char_indices().nth(column.saturating_sub(1) as usize).map_or(rest.len(), |(at, _)| at);
    (line + within).min(text.len().saturating_sub(1))
}
