//! Page of a correction: verdict, figures, plots, the path, and every line beside that of the original.
//!
//! Words and numbers are present without a script. A script draws plots and lists from packed data; program texts in it are data and never markup. The policy
//! of the page permits only this script: whatever a program text contains, nothing of it runs.

mod lines;
mod packed;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value, json};

use self::lines::{PackedText, Texts};
use self::packed::Packed;
use super::{PageColumn, columns, figure, page_with, pictures, strip, table};
use crate::markup::{Attributes, Markup};
use crate::number::{grouped, micrometers, significant};
use crate::plot::Histogram;
use crate::prediction::PredictionReport;
use crate::review::{Review, place};
use crate::verdict::{Grade, left_in_words};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::units::UnitKey;
use ncfix_path::review::{ReviewTrace, pairs};

/// Plot library; the page includes its license, which is in the file beside it.
const UPLOT: &str = include_str!("uplot/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("uplot/uPlot.min.css");
const UPLOT_LICENSE: &str = include_str!("uplot/LICENSE");
const SCRIPT: &str = include_str!("review.js");
const STYLE: &str = include_str!("review.css");

/// Unit of deviations stored as integers: 10 nm, 0.01 µrad.
const ADDED_UNIT: f64 = 1e-2;
/// Unit of positions stored as integers, mm.
const PLACE_UNIT_MM: f64 = 1e-3;

/// Program with its name.
#[derive(Clone, Copy, Debug)]
pub struct ReviewedProgram<'a> {
    /// Name.
    pub name: &'a str,
    /// Text.
    pub bytes: &'a [u8],
    /// Byte that ends a line.
    pub line_end: u8,
}

/// Content of a page.
#[derive(Debug)]
pub struct Subject<'a> {
    /// Result of the comparison.
    pub review: &'a Review,
    /// All pieces, with their places.
    pub trace: &'a ReviewTrace,
    /// Original program, and the files that it calls.
    pub originals: &'a [ReviewedProgram<'a>],
    /// Corrected program.
    pub corrected: ReviewedProgram<'a>,
    /// Temperatures and corrections of a transfer, if the page is about one.
    pub journal: Option<&'a JournalTrace>,
}

/// Journal of a transfer: temperatures, corrections and the fill of the buffer by time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JournalTrace {
    /// Time since the first entry, s.
    pub times_s: Vec<f64>,
    /// Temperatures by sensor, °C; NaN while one is not known.
    pub sensors_c: Vec<(String, Vec<f64>)>,
    /// Correction of the model and applied correction by axis, µm.
    pub axes_um: Vec<(String, [Vec<f64>; 2])>,
    /// Lines that wait, by the evidence for their end.
    pub waiting: Vec<(String, Vec<f64>)>,
}

/// Returns the page. `digest` is SHA-256, by which the policy identifies the script.
///
/// # Errors
/// If data cannot be packed.
pub fn review(subject: &Subject<'_>, digest: &dyn Fn(&[u8]) -> Vec<u8>) -> Result<String, String> {
    let data = data(subject).map_err(|error| error.to_string())?;
    let object = serde_json::to_string(subject.review).map_err(|error| error.to_string())?.replace('<', "\\u003c");
    let hashes: Vec<String> =
        [UPLOT, SCRIPT].iter().map(|text| format!("'sha256-{}'", STANDARD.encode(digest(text.as_bytes())))).collect();
    let policy = format!("default-src 'none'; style-src 'unsafe-inline'; script-src {}", hashes.join(" "));
    let style = format!("{UPLOT_STYLE}\n{STYLE}");
    let mut fault = None;
    let title = format!("Review of {}", subject.corrected.name);
    let page = page_with(&title, &style, &policy, |out| {
        body(out, subject);
        let scripts: [(Attributes<'_>, &str); 4] = [
            (&[("type", &"application/json"), ("id", &"review")], &object),
            (&[("type", &"application/octet-stream"), ("id", &"data")], &data),
            (&[], UPLOT),
            (&[], SCRIPT),
        ];
        for (attributes, text) in scripts {
            if out.verbatim("script", attributes, text).is_err() {
                fault = Some("a script would end within itself".to_owned());
            }
        }
    });
    fault.map_or(Ok(page), Err)
}

/// Writes the part that needs no script.
fn body(out: &mut Markup, subject: &Subject<'_>) {
    let review = subject.review;
    let [original, corrected] = &review.files;
    out.leaf("p", &[("class", &"soft")], format_args!("{corrected}, made from {original}"));
    verdict(out, review);
    out.element("section", &[("id", &"figures")], |out| figures(out, subject));
    let place = |out: &mut Markup, id: &'static str, title: &str, parts: &[&'static str]| {
        out.element("section", &[("id", &id)], |out| {
            out.leaf("h2", &[], title);
            for part in parts {
                out.leaf("div", &[("id", part)], "");
            }
        });
    };
    place(out, "deviation", "Deviation", &["deviation-controls", "deviation-plot"]);
    place(out, "path", "Path", &["path-controls", "path-views"]);
    if subject.journal.is_some() {
        place(out, "journal", "Temperatures, corrections and buffer", &["journal-plots"]);
    }
    out.element("section", &[("id", &"list")], |out| {
        out.leaf("h2", &[], "Lines");
        out.leaf("div", &[("id", &"filters")], "");
        out.leaf("div", &[("id", &"lines"), ("tabindex", &0)], "");
    });
    out.leaf("noscript", &[], "Plots and the list of lines need JavaScript; everything above works without it.");
    out.element("section", &[("id", &"provenance")], |out| {
        out.leaf("h2", &[], "Sources");
        out.element("dl", &[("class", &"evidence")], |out| {
            for (what, value) in &review.provenance {
                out.leaf("dt", &[], what);
                out.leaf("dd", &[], value);
            }
        });
    });
    signoff(out);
    out.element("details", &[("class", &"license")], |out| {
        out.leaf("summary", &[], "Line plots are drawn by uPlot");
        out.leaf("pre", &[], UPLOT_LICENSE);
    });
}

fn verdict(out: &mut Markup, review: &Review) {
    let verdict = &review.verdict;
    // A verdict that rests on the model alone is not shown as one about the machine.
    let support = if verdict.grade > Grade::Ok || verdict.is_supported() { "" } else { " open" };
    let class = format!("verdict {}{support}", verdict.grade.name());
    out.element("section", &[("id", &"verdict"), ("class", &class)], |out| {
        out.leaf("b", &[], capital(verdict.sentence()));
        out.element("ul", &[], |out| {
            for reason in &verdict.reasons {
                out.leaf("li", &[("class", &reason.mark())], &reason.text);
            }
        });
    });
}

fn capital(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}

fn figures(out: &mut Markup, subject: &Subject<'_>) {
    let review = subject.review;
    let [before, after] = review.bytes;
    let growth = 100.0 * (after as f64 - before as f64) / before.max(1) as f64;
    let share = 100.0 * review.changed as f64 / review.moves[0].max(1) as f64;
    let mut entries = vec![
        ("moves", grouped(review.moves[0])),
        ("pieces", grouped(review.moves[1])),
        ("changed", format!("{} ({share:.1} %)", grouped(review.changed))),
        ("in several pieces", grouped(review.split)),
        ("size", format!("{} bytes ({growth:+.0} %)", grouped(after))),
        ("longest line", format!("{} bytes, line {}", review.longest_line[0], review.longest_line[1])),
    ];
    if let Some(step) = &review.largest_step {
        entries.push(("largest step", format!("{}, {}", micrometers(step.um), place(step.line, step.file.as_deref()))));
    }
    if let (Some(before), Some(after)) = (review.before, review.after) {
        let change = |from: f64, to: f64| format!("{} → {}", significant(from), micrometers(to));
        entries.push(("largest error on the model", change(before.max_um, after.max_um)));
        entries.push(("RMS error on the model", change(before.rms_um, after.rms_um)));
    }
    if let Some(largest) = review.prediction.as_ref().and_then(PredictionReport::largest) {
        entries.push(("largest error of the machine, 95 %", largest));
    }
    strip(out, &entries);
    let titles: [PageColumn; 7] = columns(["axis", "#largest", "#at line", "#mean", "#RMS", "#99 %", "unit"]);
    let rows: Vec<super::PageRow> = review
        .axes
        .iter()
        .map(|(axis, one)| {
            let signed = |value: f64| format!("{}{}", if value > 0.0 { "+" } else { "" }, significant(value));
            let unit = one.unit.sign();
            let [rms, p99] = [one.rms, one.p99].map(significant);
            let at = one
                .max_file
                .as_ref()
                .map_or_else(|| one.max_line.to_string(), |file| format!("{file}:{}", one.max_line));
            let cells = vec![axis.clone(), signed(one.max), at, signed(one.mean), rms, p99, unit.into()];
            super::PageRow { class: "", cells }
        })
        .collect();
    table(
        out,
        &titles,
        &rows,
        "Corrections added to the words of each axis; 99 % of them are not larger than the last number.",
        usize::MAX,
    );
    let left: Vec<super::PageRow> = review
        .left
        .iter()
        .map(|(why, count)| super::PageRow { class: "", cells: vec![left_in_words(why).to_owned(), grouped(*count)] })
        .collect();
    if !left.is_empty() {
        table(out, &columns(["moves left unchanged", "#count"]), &left, "", usize::MAX);
    }
    pictures(out, |out| {
        for axis in changed(subject) {
            let (unit, scale) = unit_of(axis);
            let values = subject.trace.rows.iter().map(|row| scale * row.added(axis)).collect();
            let histogram = Histogram {
                title: format!("{axis}: corrections"),
                across: format!("{unit} added to {axis}"),
                counted: "pieces",
                values,
                sigma: None,
            };
            figure(out, &histogram, "");
        }
    });
}

fn signoff(out: &mut Markup) {
    out.element("section", &[("id", &"signoff")], |out| {
        out.leaf("h2", &[], "Sign-off");
        out.element("form", &[("id", &"signoff-form")], |out| {
            let labelled = |out: &mut Markup, text: &str, inside: &dyn Fn(&mut Markup)| {
                out.element("label", &[], |out| {
                    out.leaf("span", &[], text);
                    inside(out);
                });
            };
            labelled(out, "Name", &|out| out.empty("input", &[("name", &"name"), ("autocomplete", &"name")]));
            labelled(out, "Decision", &|out| {
                out.element("select", &[("name", &"decision")], |out| {
                    for choice in ["", "run", "run with remarks", "do not run"] {
                        out.leaf("option", &[], choice);
                    }
                });
            });
            labelled(out, "Remarks", &|out| out.leaf("textarea", &[("name", &"remarks"), ("rows", &3)], ""));
            out.leaf("button", &[("type", &"button"), ("id", &"signoff-save")], "Save");
            out.leaf("button", &[("type", &"button"), ("id", &"signoff-print")], "Print");
        });
    });
}

/// Returns the axes with changes.
fn changed(subject: &Subject<'_>) -> Vec<Axis> {
    AXES.into_iter().filter(|axis| subject.review.axes.contains_key(&axis.to_string())).collect()
}

/// Returns the unit of an axis, and the factor from mm or rad to it.
fn unit_of(axis: Axis) -> (&'static str, f64) {
    if axis.is_rotary() { ("µrad", 1e6) } else { ("µm", 1e3) }
}

/// Packs the data.
fn data(subject: &Subject<'_>) -> Result<String, std::io::Error> {
    let (trace, mut packed) = (subject.trace, Packed::default());
    let rows = &trace.rows;
    let column = |of: &dyn Fn(&ncfix_path::review::ReviewRow) -> i64| rows.iter().map(of).collect::<Vec<i64>>();
    packed.put("row.file", &column(&|row| row.file.into()));
    packed.put("row.line", &column(&|row| row.line.into()));
    packed.put("row.corrected", &column(&|row| row.corrected_line.into()));
    packed.put("row.flags", &column(&|row| row.flags().into()));
    let axes = changed(subject);
    for &axis in &axes {
        let scale = unit_of(axis).1 / ADDED_UNIT;
        packed.put(format!("row.add.{axis}"), &column(&|row| (scale * row.added(axis)).round() as i64));
    }
    for k in 0..3 {
        let places: Vec<i64> = trace.at_mm.iter().map(|at| (f64::from(at[k]) / PLACE_UNIT_MM).round() as i64).collect();
        packed.put(format!("row.at.{k}"), &places);
    }
    // Intermediate points of arcs.
    packed.put("via.row", &trace.via.iter().map(|(row, _)| i64::from(*row)).collect::<Vec<i64>>());
    for k in 0..3 {
        let places = trace.via.iter().map(|(_, at)| (f64::from(at[k]) / PLACE_UNIT_MM).round() as i64);
        packed.put(format!("via.at.{k}"), &places.collect::<Vec<i64>>());
    }
    let originals: Vec<PackedText<'_>> =
        subject.originals.iter().map(|one| PackedText::new(one.bytes, one.line_end)).collect();
    let corrected = PackedText::new(subject.corrected.bytes, subject.corrected.line_end);
    let empty = PackedText::new(b"", b'\n');
    let main = originals.first().unwrap_or(&empty);
    let pair: Vec<i64> = pairs(rows, main.lines(), corrected.lines()).into_iter().map(i64::from).collect();
    packed.put("pair", &pair);
    let mut furthest = pair;
    let mut most = 0;
    furthest.iter_mut().for_each(|line| {
        most = most.max(*line);
        *line = most;
    });
    let mut texts = Texts::default();
    originals.iter().chain([&corrected]).for_each(|text| texts.learn(text));
    for (number, text) in originals.iter().enumerate() {
        texts.put(&number.to_string(), text, None, &mut packed);
    }
    texts.put("c", &corrected, Some((main, &furthest)), &mut packed);
    let mut header = Map::new();
    header.insert("version".into(), 1.into());
    header.insert("rows".into(), rows.len().into());
    let axis =
        |axis: &Axis| json!({ "name": axis.to_string(), "unit": UnitKey::of(axis.is_rotary()), "scale": ADDED_UNIT });
    header.insert("axes".into(), axes.iter().map(axis).collect());
    header.insert("position_mm".into(), PLACE_UNIT_MM.into());
    let file =
        |one: &ReviewedProgram<'_>, text: &PackedText<'_>| json!({ "name": one.name, "lines": text.lines().count() });
    header
        .insert("files".into(), subject.originals.iter().zip(&originals).map(|(one, text)| file(one, text)).collect());
    header.insert("corrected".into(), file(&subject.corrected, &corrected));
    let tool = |(row, name): &(usize, String)| json!({ "row": row, "name": name });
    header.insert("tools".into(), trace.tools.iter().map(tool).collect());
    let (templates, scales) = texts.header();
    header.insert("templates".into(), templates.into());
    header.insert("scales".into(), scales.into());
    header.insert("journal".into(), subject.journal.map_or(Value::Null, |one| journal(one, &mut packed)));
    packed.text(&mut header)
}

/// Packs a journal; returns its header entries.
fn journal(journal: &JournalTrace, packed: &mut Packed) -> Value {
    /// Marks an unknown temperature.
    const GAP: i64 = -(1 << 31);
    let whole = |values: &[f64], parts: f64| -> Vec<i64> {
        values.iter().map(|value| if value.is_finite() { (value * parts).round() as i64 } else { GAP }).collect()
    };
    packed.put("journal.t", &whole(&journal.times_s, 1e3));
    for (number, (_, values)) in journal.sensors_c.iter().enumerate() {
        packed.put(format!("journal.sensor.{number}"), &whole(values, 1e3));
    }
    for (axis, both) in &journal.axes_um {
        for (name, values) in ["target", "applied"].iter().zip(both) {
            packed.put(format!("journal.axis.{axis}.{name}"), &whole(values, 1.0 / ADDED_UNIT));
        }
    }
    for (number, (_, values)) in journal.waiting.iter().enumerate() {
        packed.put(format!("journal.waiting.{number}"), &whole(values, 1.0));
    }
    let [sensors, axes, waiting] = [
        journal.sensors_c.iter().map(|(name, _)| name.clone()).collect::<Vec<String>>(),
        journal.axes_um.iter().map(|(name, _)| name.clone()).collect(),
        journal.waiting.iter().map(|(name, _)| name.clone()).collect(),
    ];
    json!({ "sensors": sensors, "axes": axes, "waiting": waiting })
}
