//! Isolated pulses of a few minutes: lubrication lifts a carriage, somebody leans on the table. All readings of some minutes are shifted, with
//! sharp ends, and neither before nor behind nor at another visit of the same places.

use std::collections::HashMap;

use super::trail::{Channel, Trail};
use super::{Check, Fault, Then, View, spread};

pub(super) const CHECK: Check = Check {
    name: "isolated pulse",
    made_by: "lubrication, a door, somebody who leans on the machine",
    shown_by: "readings of one to five minutes shifted alike, sharp at both ends, not at other visits of the same places",
    source: "Spaan 1995: pulses of lubrication of 15 to 17 µm",
    look,
};

/// Lengths that are tried, s.
const LENGTHS_S: [f64; 11] = [50.0, 75.0, 100.0, 125.0, 150.0, 175.0, 200.0, 225.0, 250.0, 275.0, 300.0];
/// More of them are no isolated ones.
const MOST: usize = 8;
/// Frames beside a window: readings at least and at most.
const FRAME: [usize; 2] = [6, 60];
/// An end is sharp where the first readings inside differ from the last outside by so much of the whole.
const SHARP: f64 = 0.42;
/// Readings at an end.
const END: usize = 4;
/// Both sides of a window are the same within so much of the pulse.
const BACK: f64 = 0.5;
/// A pulse in units of the noise, at least.
const SIZE: f64 = 1.9;
/// The shortest, s.
const SHORTEST_S: f64 = 45.0;
/// The middle of the readings has so much of what their mean has: it is not one of them alone.
const MIDDLE: f64 = 0.6;
/// Rows that are few.
const FEW: usize = 20;
/// Rows from the end of a piece within which a window is the rest of it.
const REST: usize = 4;
/// Other visits of the same places have less of it.
const AGAIN: f64 = 0.4;

/// A window of rows that stands out.
#[derive(Clone, Copy, Debug)]
struct Window {
    rows: [usize; 2],
    score: f64,
}

/// A mean inside, those on both sides, and numbers of readings of a channel.
struct Contrast {
    inside: f64,
    sides: [f64; 2],
    counts: [usize; 3],
}

impl Contrast {
    fn size(&self) -> f64 {
        self.inside - (self.sides[0] + self.sides[1]) / 2.0
    }

    fn noise(&self) -> f64 {
        let [inside, before, behind] = self.counts.map(|count| 1.0 / count.max(1) as f64);
        (inside + (before + behind) / 4.0).sqrt()
    }
}

fn look(view: &View<'_, '_>, out: &mut Vec<Fault>) {
    for (set, data) in view.sets() {
        let Some(trail) = view.trails.get(set).filter(|trail| trail.is_repeated) else { continue };
        let times: Option<Vec<f64>> = data.observations.iter().map(|one| one.t_s).collect();
        let Some(times) = times else { continue };
        let mut trail = trail.clone();
        let mut found: Vec<(Window, String)> = Vec::new();
        for _ in 0..3 * MOST {
            if found.len() > MOST {
                break;
            }
            let Some((window, evidence)) = best(&trail, &times) else { break };
            trail.forget(window.rows);
            // The rest of one that was found is none of its own.
            let is_rest = |(known, _): &&mut (Window, String)| {
                window.rows[0] <= known.rows[1] + 1 && known.rows[0] <= window.rows[1] + 1
            };
            match found.iter_mut().find(is_rest) {
                Some((known, _)) => {
                    known.rows = [known.rows[0].min(window.rows[0]), known.rows[1].max(window.rows[1])];
                }
                None => found.push((window, evidence)),
            }
        }
        if found.len() > MOST {
            continue;
        }
        for (window, evidence) in found {
            out.push(Fault {
                kind: "pulse",
                set,
                name: data.name.clone(),
                what: "pulse".into(),
                rows: window.rows,
                evidence,
                then: Then::WithoutRows,
            });
        }
    }
}

fn contrast(channel: &Channel, rows: [usize; 2]) -> Option<Contrast> {
    let range = channel.range(rows[0], rows[1]);
    let frame = range.len().clamp(FRAME[0], FRAME[1]);
    let (inside, count) = channel.mean(range.start, range.end)?;
    let (before, of_before) = channel.mean(range.start.checked_sub(frame)?, range.start)?;
    let (behind, of_behind) = channel.mean(range.end, (range.end + frame).min(channel.at.len()))?;
    let enough = FRAME[0] / 2;
    (count >= 2 && of_before >= enough && of_behind >= enough).then_some(Contrast {
        inside,
        sides: [before, behind],
        counts: [count, of_before, of_behind],
    })
}

/// The window that stands out most, if it is a pulse.
fn best(trail: &Trail, times: &[f64]) -> Option<(Window, String)> {
    let mut windows: Vec<Window> = Vec::new();
    for length in LENGTHS_S {
        let begins = (0..times.len()).filter(|&row| row == 0 || times[row] > times[row - 1]);
        let rows: Vec<[usize; 2]> = begins
            .filter_map(|first| {
                let until = times[first] + length;
                let count = times[first..].iter().take_while(|time| **time < until && **time >= times[first]).count();
                let last = first + count.max(1) - 1;
                let is_rest = trail.blocks.iter().any(|block| block[1].abs_diff(last) <= REST);
                (times[last] - times[first] >= SHORTEST_S && !is_rest).then_some([first, last])
            })
            .collect();
        let mut scores: HashMap<usize, (f64, f64)> = HashMap::new();
        for channel in &trail.channels {
            let contrasts: Vec<(usize, Contrast)> =
                rows.iter().enumerate().filter_map(|(k, rows)| Some((k, contrast(channel, *rows)?))).collect();
            // As such windows differ from their neighbours where nothing is.
            let usual = spread(contrasts.iter().map(|(_, one)| one.size()));
            for (k, one) in contrasts {
                let unit = usual.max(0.8 * channel.noise * one.noise());
                let score = scores.entry(k).or_insert((0.0, 0.0));
                score.0 += (one.size() / unit).powi(2);
                score.1 += 1.0;
            }
        }
        windows.extend(scores.into_iter().filter_map(|(k, (squares, freedom))| {
            let score = squares - 4.0 * freedom;
            // A chance of 1e-7 or less.
            (score > 24.0).then_some(Window { rows: rows[k], score })
        }));
    }
    windows.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.rows.cmp(&b.rows)));
    windows.truncate(5000);
    windows.into_iter().find_map(|window| is_pulse(trail, window, times).map(|evidence| (window, evidence)))
}

/// Whether a window has sharp ends and the same on both sides.
fn is_pulse(trail: &Trail, window: Window, times: &[f64]) -> Option<String> {
    let [first, last] = window.rows;
    // All channels together, each by how much it has of the pulse.
    let mut whole = 0.0;
    let mut ends = [0.0; 2];
    let mut parts = [0.0; 2];
    let mut back = 0.0;
    let (mut count, mut middles) = (0.0_f64, 0.0);
    for channel in &trail.channels {
        let Some(one) = contrast(channel, window.rows) else { continue };
        let range = channel.range(first, last);
        let size = one.size() / channel.noise;
        let unit = |value: f64| size * value / channel.noise;
        let half = (range.start + range.end) / 2;
        let end = END.min(range.len().div_ceil(2)).max(2);
        let mean = |from: usize, to: usize| channel.mean(from, to).map(|(mean, _)| mean);
        let edge = |at: usize| Some([mean(at.saturating_sub(end), at)?, mean(at, at + end)?]);
        let (Some(left), Some(right)) = (edge(range.start), edge(range.end)) else { continue };
        whole += size * size;
        ends[0] += unit(left[1] - left[0]);
        ends[1] += unit(right[0] - right[1]);
        back += unit(one.sides[1] - one.sides[0]);
        let middle = (one.sides[0] + one.sides[1]) / 2.0;
        parts[0] += unit(mean(range.start, half).unwrap_or(one.inside) - middle);
        parts[1] += unit(mean(half, range.end).unwrap_or(one.inside) - middle);
        let inside: Vec<f64> = channel.left[range].iter().copied().filter(|left| left.is_finite()).collect();
        middles += unit(super::median(inside) - middle);
        count += 1.0;
    }
    let is_flat = parts.iter().all(|part| *part > BACK * whole);
    let is_sharp = ends.iter().all(|end| *end > SHARP * whole);
    let size = (whole / count.max(1.0)).sqrt();
    // Exactly one run, or a few rows where every visit comes from another side: that is how axes move.
    let is_run = trail.is_border(first, 1) && trail.is_border(last + 1, 1);
    if is_run || !trail.has_sense && last - first < FEW {
        return None;
    }
    let is_alone = is_flat && is_sharp && middles > MIDDLE * whole && back.abs() < BACK * whole && size > SIZE;
    (is_alone && again(trail, window) < AGAIN).then(|| {
        format!(
            "{} readings a row shift by {size:.1} times their noise for {:.0} s and back, within one reading at both ends, and not at other visits of the same places",
            count,
            times[last] - times[first]
        )
    })
}

/// How much of a window the other visits of its points from the same sides have.
fn again(trail: &Trail, window: Window) -> f64 {
    let others = trail.other_visits(window.rows);
    let (mut own, mut other) = (0.0, 0.0);
    for channel in &trail.channels {
        let Some(one) = contrast(channel, window.rows) else { continue };
        let left = others.iter().flat_map(|row| channel.range(*row, *row)).filter_map(|k| channel.left.get(k).copied());
        let left: Vec<f64> = left.filter(|left| left.is_finite()).collect();
        if left.is_empty() {
            continue;
        }
        let size = one.size() / channel.noise;
        own += size * size;
        other += size * left.iter().sum::<f64>() / left.len() as f64 / channel.noise;
    }
    if own > 0.0 { other / own } else { 0.0 }
}
