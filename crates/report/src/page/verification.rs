//! Page of a verification: errors of a program before and after its correction, along the path.

use super::parts::{MOST_ROWS, diagnostics, origin};
use super::{PageRow, columns, figure, page, pictures, strip, table};
use crate::json::AtFeed;
use crate::markup::Markup;
use crate::number::{duration, grouped, micrometers};
use crate::plot::{Chart, Histogram, PlotSeries, Shape};
use crate::verification::Verification;

/// Returns the page.
#[must_use]
pub fn verification(found: &Verification) -> String {
    let [original, corrected] = &found.files;
    page(&format!("Verification of {corrected}"), |out| {
        out.leaf("p", &[("class", &"soft")], format_args!("{corrected}, made from {original}, on {}", found.machine));
        if let (Some(before), Some(after)) = (found.before, found.after) {
            let grows = after.rms_um > before.rms_um && after.max_um > before.max_um;
            let (class, what) =
                if grows { ("banner bad", "The errors increase") } else { ("banner", "The largest error changes") };
            let [from, to] = [before.max_um, after.max_um].map(micrometers);
            out.leaf("p", &[("class", &class)], format_args!("{what} from {from} to {to} on the error model."));
            let change = |from: f64, to: f64| format!("{} → {}", micrometers(from), micrometers(to));
            let entries = [
                ("mean", change(before.mean_um, after.mean_um)),
                ("RMS", change(before.rms_um, after.rms_um)),
                ("largest", change(before.max_um, after.max_um)),
                ("samples", grouped(found.samples)),
                ("pieces", grouped(found.pieces.len() as u64)),
            ];
            strip(out, &entries);
        }
        diagnostics(out, &found.diagnostics);
        if !found.pieces.is_empty() {
            pictures(out, |out| {
                let along = "The largest error of each piece, moves with feed.";
                figure(out, &over_path(found, [0, 1].as_slice(), "Error along the path"), along);
                figure(out, &over_path(found, [1].as_slice(), "Residual along the path"), along);
                for (k, title) in
                    ["Errors of the original program", "Errors of the corrected program"].iter().enumerate()
                {
                    let values = found.pieces.iter().map(|piece| f64::from(piece.errors_um[k])).collect();
                    let histogram = Histogram {
                        title: (*title).to_owned(),
                        across: "largest error of a piece, µm".into(),
                        counted: "pieces",
                        values,
                        sigma: None,
                    };
                    figure(out, &histogram, "");
                }
            });
        }
        if let Some(pair) = &found.at_feed {
            at_feed(out, pair);
        }
        let rows: Vec<PageRow> = found
            .largest
            .iter()
            .map(|(place, errors)| {
                let [before, after] = errors.map(micrometers);
                PageRow { class: "", cells: vec![place.clone(), before, after] }
            })
            .collect();
        if !rows.is_empty() {
            out.leaf("h2", &[], "Largest residuals");
            let note = "Distance of the tool tip from the programmed path, predicted on the error model.";
            table(out, &columns(["line", "#before", "#after"]), &rows, note, MOST_ROWS);
        }
        origin(out, &found.inputs, &format!("ncfix {}, machine {}", env!("CARGO_PKG_VERSION"), found.machine));
    })
}

/// Writes the behavior of both programs at feed.
fn at_feed(out: &mut Markup, pair: &[AtFeed; 2]) {
    let rows: Vec<PageRow> = pair
        .iter()
        .zip(["original", "corrected"])
        .map(|(one, name)| {
            let place = match (&one.file, one.line) {
                (Some(file), Some(line)) => format!("{file}:{line}"),
                _ => String::new(),
            };
            let [rms, max] = [one.contouring.rms_um, one.contouring.max_um].map(micrometers);
            PageRow { class: "", cells: vec![name.to_owned(), rms, max, place, duration(one.time_s)] }
        })
        .collect();
    out.leaf("h2", &[], "At feed");
    let note = "Distance of the tool from the programmed path, at right angles to it, as predicted by [servo] and [[dynamic]] of the machine file, and the machine time without tool changes.";
    table(out, &columns(["program", "#RMS", "#max", "largest deviation at", "#time"]), &rows, note, MOST_ROWS);
}

/// Draws errors before (0) and after (1) over the length of the path.
fn over_path(found: &Verification, which: &[usize], title: &str) -> Chart {
    const LABELS: [&str; 2] = ["original", "corrected"];
    let series = which.iter().filter_map(|&k| {
        let point =
            |piece: &crate::verification::Piece| Some((f64::from(piece.path_m), f64::from(*piece.errors_um.get(k)?)));
        let points = found.pieces.iter().filter_map(point).collect();
        Some(PlotSeries { label: (*LABELS.get(k)?).to_owned(), points, shape: Shape::Line, ..PlotSeries::default() })
    });
    Chart {
        title: title.to_owned(),
        across: "path, m".into(),
        up: "error, µm".into(),
        series: series.collect(),
        ..Chart::default()
    }
}
