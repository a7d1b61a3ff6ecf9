//! Page about the place of the table look-up: limit cycle and virtual hysteresis under scale compensation, and their residuals under set-point compensation
//! (Spaan 1995, Figs. 6.4–6.8).

use super::{figure, page, pictures};
use crate::markup::Markup;
use crate::plot::{Chart, PlotSeries, Shape};
use ncfix_tables::realtime::stability::{AxisTrace, RestCurve, StabilityResult};

/// Returns the page.
#[must_use]
pub fn stability(data: &StabilityResult) -> String {
    page("Scale compensation and set-point compensation", |out| {
        out.leaf(
            "p",
            &[],
            "A simulated position loop with a cycle of 15 ms, a measuring system with increments of 1 µm and a table of corrections with one step, at \
             position 0. The correction is looked up at the measured position (scale compensation) or at the uncompensated set-point.",
        );
        out.leaf(
            "p",
            &[],
            "On the Maho 700S a step of 2 µm caused a limit cycle of 5 µm, and a step of 1 µm did not (Spaan 1995, ch. 6). The drive of that machine is \
             not published; the size of the cycle is that of the simulated one.",
        );
        pictures(out, |out| draw(out, data));
    })
}

fn draw(out: &mut Markup, data: &StabilityResult) {
    let [scale, steady] = [&data.scale, &data.set_point];
    over_time(out, "Scale compensation: limit cycle", scale);
    over_set_point(
        out,
        "Scale compensation: virtual hysteresis",
        &data.hysteresis,
        "The rest position of the axis depends on its start position, and it jumps in between.",
    );
    over_time(out, "Set-point compensation: at rest", steady);
    over_set_point(
        out,
        "Set-point compensation: position ambiguity",
        &data.ambiguity,
        "A downward step: positions before the grid point belong to two set-points.",
    );
    over_set_point(
        out,
        "Set-point compensation: forbidden zone",
        &data.forbidden,
        "An upward step: positions after the grid point belong to no set-point.",
    );
}

fn over_time(out: &mut Markup, title: &str, traces: &[AxisTrace; 2]) {
    let series = |trace: &AxisTrace| PlotSeries {
        label: format!("step {} µm", trace.step_um),
        points: trace.points.clone(),
        shape: Shape::Line,
        ..PlotSeries::default()
    };
    let chart = Chart {
        title: title.to_owned(),
        across: "time in s".to_owned(),
        up: "measured position in µm".to_owned(),
        series: traces.iter().map(series).collect(),
        ..Chart::default()
    };
    let unrest = traces.iter().map(|trace| format!("{} µm with a step of {} µm", trace.unrest_um, trace.step_um));
    figure(out, &chart, format!("From peak to peak at the end: {}.", unrest.collect::<Vec<_>>().join(", ")));
}

fn over_set_point(out: &mut Markup, title: &str, rest: &RestCurve, caption: &str) {
    let series = |label: &str, points: &[(f64, f64)]| PlotSeries {
        label: label.to_owned(),
        points: points.to_vec(),
        ..PlotSeries::default()
    };
    let chart = Chart {
        title: format!("{title}, step {} µm", rest.step_um),
        across: "set-point in µm".to_owned(),
        up: "position in µm".to_owned(),
        series: vec![series("upwards", &rest.up), series("downwards", &rest.down)],
        ..Chart::default()
    };
    figure(out, &chart, caption);
}
