//! What a division found, in the units of reports, and the machine file with it.

use ncfix_base::geometry::Vector;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::edit::{Edit, Given};
use ncfix_metrology::decompose::{self, Compliance, RunParts, Smooth};
use ncfix_metrology::measure::trace::Trace;
use ncfix_model::source::dynamic;
use ncfix_report::decomposition::{self as shown, Along, BySource, Decomposition, Delay, Law, Link, Loop, Run};

/// The words of the orders.
const OF: [&str; 2] = ["acceleration", "jerk"];

/// Fills the report.
pub(super) fn fill(found: &decompose::Decomposition, trace: &Trace, report: &mut Decomposition) {
    let ms = |s: f64| 1e3 * s;
    report.cycle_ms = ms(found.cycle_s);
    if let Some(servo) = &found.servo {
        report.record_delay =
            Delay { ms: ms(servo.delay_s), uncertainty_ms: ms(servo.uncertainty_s), by_run_ms: Vec::new() };
        for axis in &servo.axes {
            let is_rotary = axis.axis.is_rotary();
            report.servo.push(Loop {
                axis: axis.axis.to_string(),
                velocity_gain_per_s: axis.velocity_gain,
                feed_forward: axis.feed_forward,
                lag_ms: ms(axis.lag_s()),
                rms: if is_rotary { urad_from_rad(axis.rms) } else { um_from_mm(axis.rms) },
                unit: if is_rotary { "urad" } else { "um" },
                shift_ms: axis.shift_s.iter().map(|(shift, _)| shift.is_finite().then_some(ms(*shift))).collect(),
            });
        }
    }
    report.reading_delay = found.clock.as_ref().map(|clock| Delay {
        ms: ms(clock.delay_s),
        uncertainty_ms: ms(clock.uncertainty_s),
        by_run_ms: clock.by_run.iter().map(|(delay, _)| ms(*delay)).collect(),
    });
    report.links = found.links.iter().map(link).collect();
    report.motion = match found.smooth {
        Smooth::Pose(degree) => format!("pose:{degree}"),
        Smooth::Path(degree) => format!("path:{degree}"),
    };
    let held = |number: usize| found.held_out_mm.get(number).map(|both| both.map(um_from_mm));
    let runs = found.runs.iter().enumerate();
    report.runs = runs.map(|(place, run)| shown_run(run, trace, held(found.fold(place)))).collect();
    report.compliances = found.compliances.iter().map(compliance).collect();
    for (source, laws) in ["contouring", "dynamic"].into_iter().zip(&found.laws) {
        for (direction, law) in shown::DIRECTIONS.into_iter().zip(laws) {
            report.power_laws.extend(law.map(|law| Law {
                source,
                direction,
                factor_um: um_from_mm(law.factor),
                exponent: law.exponent,
                exponent_95: law.exponent_limit.is_finite().then_some(law.exponent_limit),
                explained: law.explained,
                without_slowest: law.without_first,
            }));
        }
    }
}

fn link(link: &decompose::Link) -> Link {
    let is_rotation = link.name.component.direction.is_rotation();
    Link {
        parameter: link.name.to_string(),
        value: if is_rotation { urad_from_rad(link.value) } else { um_from_mm(link.value) },
        unit: if is_rotation { "urad" } else { "um" },
        is_told: link.is_told,
    }
}

fn compliance(one: &Compliance) -> shown::Compliance {
    let factor = dynamic::factor(one.name);
    shown::Compliance {
        component: one.name.to_string(),
        axis: one.name.axis().map_or_else(String::new, |axis| axis.to_string()),
        of: OF[usize::from(one.order == 3)],
        value: one.value / factor,
        uncertainty: one.uncertainty / factor,
        unit: dynamic::key(one.name, one.order),
        gain: one.gain,
    }
}

fn um(vector: &Vector) -> [f64; 3] {
    [0, 1, 2].map(|k| um_from_mm(vector[k]))
}

fn shown_run(run: &RunParts, trace: &Trace, held_out_um: Option<[f64; 2]>) -> Run {
    let in_um = |of: &[[f64; 3]; 5]| BySource::new(of.map(|along| along.map(um_from_mm)));
    let norms: Vec<f64> = run.moving.clone().map(|k| um_from_mm(run.contouring[k].norm())).collect();
    let rms = (norms.iter().map(|norm| norm * norm).sum::<f64>() / norms.len().max(1) as f64).sqrt();
    let start = run.t_s.get(run.moving.start).copied().unwrap_or(0.0);
    let along = run.moving.clone().map(|k| {
        let none = Vector::zeros();
        let parts = run.parts[k].unwrap_or([run.following[k], none, none, none, none]);
        Along { t_s: run.t_s[k] - start, parts_um: parts.map(|part| um(&part)), explained_um: um(&run.explained[k]) }
    });
    Run {
        run: trace.runs.get(run.number).map_or_else(String::new, |one| one.label.clone()),
        feed_mm_min: run.feed_mm_min,
        samples: run.moving.len(),
        moving_s: run.t_s.get(run.moving.end.saturating_sub(1)).map_or(0.0, |end| end - start),
        share_percent: BySource::new(run.shares.percent),
        max_um: in_um(&run.shares.max_mm),
        rms_um: in_um(&run.shares.rms_mm),
        thermal_um: um(&run.thermal_mm),
        contouring_error_um: [norms.iter().copied().fold(0.0, f64::max), rms],
        path_in_workpiece_mm: run.in_workpiece_mm,
        noise_um: run.fast_mm.map(um_from_mm),
        held_out_um,
        along: along.collect(),
    }
}

/// The text of a machine file with the compliances added to those that it has; `None` where it cannot take them.
pub(super) fn extended(text: &[u8], found: &decompose::Decomposition) -> Option<String> {
    let mut edit = Edit::parse(std::str::from_utf8(text).ok()?)?;
    for one in &found.compliances {
        let (component, key) = (one.name.to_string(), dynamic::key(one.name, one.order));
        let value = rounded(one.value / dynamic::factor(one.name));
        let known = (0..edit.count("dynamic"))
            .find(|&index| edit.word("dynamic", index, "component") == Some(component.as_str()));
        let is_done = match known {
            Some(index) => {
                let sum = edit.number("dynamic", index, &key).unwrap_or(0.0) + value;
                edit.set_in("dynamic", index, &key, &Given::Number(sum))
            }
            None => {
                edit.push("dynamic", &[("component".to_owned(), Given::Text(component)), (key, Given::Number(value))])
            }
        };
        if !is_done {
            return None;
        }
    }
    Some(edit.text())
}

/// Five digits: more were not measured.
fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}
