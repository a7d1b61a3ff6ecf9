//! Isolated pulses of a few minutes: lubrication lifts a carriage, or somebody leans on the table. All readings of some minutes are shifted, with
//! sharp ends, but not those before, after and at other visits of the same positions.

use super::sharp::{CHANCE, EACH, END, sharpness};
use super::trail::{ReadingTrail, Trail};
use super::{DataDefect, DefectCheck, DefectKind, Then, View, spread, switched};

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "isolated pulse",
    made_by: "lubrication, a door, a person who leans on the machine",
    shown_by: "readings of one to five minutes with an equal shift, sharp at both ends, absent at other visits of these positions",
    source: "Spaan 1995: pulses of lubrication of 15 to 17 µm",
    look,
};

/// Tested lengths, s.
const LENGTHS_S: [f64; 11] = [50.0, 75.0, 100.0, 125.0, 150.0, 175.0, 200.0, 225.0, 250.0, 275.0, 300.0];
/// Maximum number of isolated pulses.
const MOST: usize = 8;
/// Minimum and maximum number of readings on each side of a window.
const FRAME: [usize; 2] = [6, 60];
/// An end is sharp if the first readings inside differ from the last ones outside by this share of the shift.
const SHARP: f64 = 0.42;
/// Smallest share of the shift in channels that show an end.
const PART: f64 = 0.3;
/// Smallest jump at both ends, in squares of the usual jump between readings.
const AT_ONCE: f64 = 13.0;
/// The outer parts of the readings inside, one part in this number at each end,
const BRIM: usize = 6;
/// have at least this share of the shift.
const FULL: f64 = 0.55;
/// Largest difference of both sides of a window, as a share of the pulse.
const BACK: f64 = 0.5;
/// Smallest pulse, in units of the noise.
const SIZE: f64 = 1.9;
/// Shortest pulse, s.
const SHORTEST_S: f64 = 45.0;
/// Smallest ratio of the median of the readings to their mean, which excludes a single outlier.
const MIDDLE: f64 = 0.6;
/// Several values of a row are shifted if the sum of squares exceeds that of one value by this factor.
const MORE: f64 = 1.5;
/// Minimum number of rows if only one value is shifted.
const SEVERAL: usize = 3;
/// Number of rows below which there are few.
const FEW: usize = 20;
/// Longest pulse, s.
const LONGEST_S: f64 = 315.0;
/// Maximum number of windows that are tested.
const TRIED: usize = 24;
/// Largest share of the pulse at other visits of the same positions.
const AGAIN: f64 = 0.4;

/// A window of rows with a significant shift.
#[derive(Clone, Copy, Debug)]
struct Window {
    rows: [usize; 2],
    score: f64,
}

/// Mean inside a window, means of the sides in the same block, and numbers of readings of a channel.
struct Contrast {
    inside: f64,
    sides: [Option<f64>; 2],
    counts: [usize; 3],
    range: std::ops::Range<usize>,
}

impl Contrast {
    fn middle(&self) -> f64 {
        let known = || self.sides.iter().flatten();
        known().sum::<f64>() / known().count().max(1) as f64
    }

    fn size(&self) -> f64 {
        self.inside - self.middle()
    }

    fn noise(&self) -> f64 {
        let [inside, before, behind] = self.counts.map(|count| count as f64);
        (1.0 / inside.max(1.0) + 1.0 / (before + behind).max(1.0)).sqrt()
    }
}

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, data) in view.sets() {
        let Some(trail) = view.trails.get(set).filter(|trail| trail.is_repeated) else { continue };
        let times: Option<Vec<f64>> = data.observations.iter().map(|one| one.t_s).collect();
        let Some(times) = times else { continue };
        let mut trail = trail.clone();
        let mut step = super::step::change(&trail, data);
        let mut found: Vec<(Window, String)> = Vec::new();
        for _ in 0..3 * MOST {
            if found.len() > MOST {
                break;
            }
            let Some((window, evidence)) = best(&trail, &times) else { break };
            // The first minutes after a step are not a pulse.
            if let Some(change) = step.take().filter(|change| change.gain >= trail.window_gain(window.rows)) {
                trail = trail.levelled([change.row, change.block[1]]);
                continue;
            }
            trail.forget(window.rows);
            // The rest of a pulse that was found already is not another pulse.
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
        for (window, evidence) in found.into_iter().filter(|(window, _)| !switched::is_on_in(data, window.rows)) {
            out.push(DataDefect {
                kind: DefectKind::Pulse,
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

fn contrast(trail: &Trail, channel: &ReadingTrail, rows: [usize; 2]) -> Option<Contrast> {
    let whole = channel.range(rows[0], rows[1]);
    // The block with most of the window: another block has another zero.
    let middle = channel.at.get(usize::midpoint(whole.start, whole.end.checked_sub(1)?))?.0;
    let block = trail.block_of(middle)?;
    let piece = channel.range(block[0], block[1]);
    let range = whole.start.max(piece.start)..whole.end.min(piece.end);
    let frame = range.len().clamp(FRAME[0], FRAME[1]);
    let (inside, count) = channel.mean(range.start, range.end)?;
    let before = channel.mean(range.start.saturating_sub(frame).max(piece.start), range.start);
    let behind = channel.mean(range.end, (range.end + frame).min(piece.end));
    let sides = [before, behind].map(|side| side.filter(|(_, count)| *count >= FRAME[0] / 2));
    let counts = sides.map(|side| side.map_or(0, |(_, count)| count));
    (count >= 2 && sides.iter().any(Option::is_some)).then_some(Contrast {
        inside,
        sides: sides.map(|side| side.map(|(mean, _)| mean)),
        counts: [count, counts[0], counts[1]],
        range,
    })
}

/// Rows of windows of a length, s, one from every time on.
fn windows(times: &[f64], length: f64) -> Vec<[usize; 2]> {
    let mut last = 0;
    let begins = (0..times.len()).filter(|&row| row == 0 || times[row] > times[row - 1]);
    begins
        .filter_map(|first| {
            last = last.max(first);
            let is_in =
                |row: usize| times.get(row).is_some_and(|time| *time < times[first] + length && *time >= times[first]);
            while is_in(last + 1) {
                last += 1;
            }
            // A window ends if time restarts.
            (is_in(last) && times[last] - times[first] >= SHORTEST_S).then_some([first, last])
        })
        .collect()
}

/// The most significant window that is a pulse.
fn best(trail: &Trail, times: &[f64]) -> Option<(Window, String)> {
    let mut all: Vec<Window> = Vec::new();
    for length in LENGTHS_S {
        let rows = windows(times, length);
        let mut scores: Vec<(f64, f64)> = vec![(0.0, 0.0); rows.len()];
        for channel in &trail.channels {
            let contrasts: Vec<(usize, f64, f64)> = rows
                .iter()
                .enumerate()
                .filter_map(|(k, rows)| contrast(trail, channel, *rows).map(|one| (k, one.size(), one.noise())))
                .collect();
            // Usual difference between such windows and their neighbors.
            let usual = spread(contrasts.iter().map(|(_, size, _)| *size));
            for (k, size, noise) in contrasts {
                let unit = usual.max(0.8 * channel.noise * noise);
                scores[k].0 += (size / unit).powi(2);
                scores[k].1 += 1.0;
            }
        }
        all.extend(scores.into_iter().zip(&rows).filter_map(|((squares, freedom), rows)| {
            let score = squares - EACH * freedom;
            (freedom > 0.0 && score > CHANCE).then_some(Window { rows: *rows, score })
        }));
    }
    all.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.rows.cmp(&b.rows)));
    let mut tried: Vec<[usize; 2]> = Vec::new();
    let mut best: Option<(Window, String)> = None;
    for window in all {
        if tried.len() >= TRIED {
            break;
        }
        if tried.iter().any(|known| is_alike(*known, window.rows)) {
            continue;
        }
        tried.push(window.rows);
        let around = trail.around(window.rows);
        let rows = refined(&around, window.rows);
        let lasts = times[rows[1]] - times[rows[0]];
        if !(SHORTEST_S..=LONGEST_S).contains(&lasts) {
            continue;
        }
        let around = if rows == window.rows { around } else { trail.around(rows) };
        if let Some(evidence) = is_pulse(&around, rows, times) {
            let score = trail.window_gain(rows);
            if best.as_ref().is_none_or(|(best, _)| best.score < score) {
                best = Some((Window { rows, score }, evidence));
            }
        }
    }
    best
}

/// True if two windows have most of their rows in common.
fn is_alike(one: [usize; 2], other: [usize; 2]) -> bool {
    let common = (one[1].min(other[1]) + 1).saturating_sub(one[0].max(other[0]));
    let both = one[1].max(other[1]) + 1 - one[0].min(other[0]);
    10 * common > 7 * both
}

/// Rows near a window in which readings are more likely shifted than not.
fn refined(trail: &Trail, rows: [usize; 2]) -> [usize; 2] {
    let long = rows[1] - rows[0] + 1;
    let [from, until] = [rows[0].saturating_sub(long / 2), rows[1] + long / 2];
    let mut gains = vec![0.0; until + 1 - from];
    for channel in &trail.channels {
        let Some(one) = contrast(trail, channel, rows) else { continue };
        let (size, middle) = (one.size(), one.middle());
        let limit = 5.0 * channel.noise;
        for k in channel.range(from, until) {
            let left = channel.left[k] - middle;
            if left.is_finite() {
                gains[channel.at[k].0 - from] +=
                    size * (left.clamp(-limit, limit) - size / 2.0) / channel.noise.powi(2);
            }
        }
    }
    // The range with the largest sum.
    let (mut best, mut sum, mut begin, mut found) = (0.0, 0.0, 0, None);
    for (k, gain) in gains.iter().enumerate() {
        if sum <= 0.0 {
            (sum, begin) = (0.0, k);
        }
        sum += gain;
        if sum > best {
            (best, found) = (sum, Some([from + begin, from + k]));
        }
    }
    found.unwrap_or(rows)
}

/// Evidence of a pulse if a window has sharp ends and the same level on both sides.
fn is_pulse(trail: &Trail, rows: [usize; 2], times: &[f64]) -> Option<String> {
    let [first, last] = rows;
    // All channels together, each weighted by its share of the pulse.
    let mut whole = 0.0;
    let (mut ends, mut of_ends) = ([0.0; 2], [0.0; 2]);
    let mut parts = [0.0; 2];
    let (mut brims, mut least) = (0.0, usize::MAX);
    let (mut back, mut of_back) = (0.0, 0.0);
    let (mut count, mut middles, mut fourths) = (0.0_f64, 0.0, 0.0);
    for channel in &trail.channels {
        let Some(one) = contrast(trail, channel, rows) else { continue };
        let range = one.range.clone();
        let size = one.size() / channel.noise;
        let unit = |value: f64| size * value / channel.noise;
        let half = usize::midpoint(range.start, range.end);
        let end = END.min(range.len().div_ceil(2)).max(2);
        let mean = |from: usize, to: usize| channel.mean(from, to).map(|(mean, _)| mean);
        whole += size * size;
        fourths += size.powi(4);
        if one.sides[0].is_some()
            && let (Some(out), Some(own)) =
                (mean(range.start.saturating_sub(end), range.start), mean(range.start, range.start + end))
        {
            ends[0] += unit(own - out);
            of_ends[0] += size * size;
        }
        if one.sides[1].is_some()
            && let (Some(own), Some(out)) =
                (mean(range.end.saturating_sub(end), range.end), mean(range.end, range.end + end))
        {
            ends[1] += unit(own - out);
            of_ends[1] += size * size;
        }
        if let [Some(before), Some(behind)] = one.sides {
            back += unit(behind - before);
            of_back += size * size;
        }
        let middle = one.middle();
        parts[0] += unit(mean(range.start, half).unwrap_or(one.inside) - middle);
        parts[1] += unit(mean(half, range.end).unwrap_or(one.inside) - middle);
        // The first and the last readings inside: a gradual rise and fall has small values there.
        let brim = (range.len() / BRIM).max(1);
        let of_brims = [mean(range.start, range.start + brim), mean(range.end.saturating_sub(brim), range.end)];
        brims += of_brims.map(|own| unit(own.unwrap_or(one.inside) - middle) / 2.0).iter().sum::<f64>();
        least = least.min(range.len());
        // With two readings the smaller one counts, as one may be an outlier.
        let inside = channel.left[range].iter().copied().filter(|left| left.is_finite());
        let mut inside: Vec<f64> = inside.map(|left| unit(left - middle)).collect();
        inside.sort_by(f64::total_cmp);
        middles += inside.get(inside.len().saturating_sub(1) / 2).copied().unwrap_or(0.0);
        count += 1.0;
    }
    let is_flat = parts.iter().all(|part| *part > BACK * whole);
    let is_sharp = ends.iter().zip(&of_ends).all(|(end, of)| *of > PART * whole && *end > SHARP * of);
    let is_at_once = || {
        [first, last + 1]
            .into_iter()
            .all(|row| sharpness(trail, row, least).is_none_or(|sharpness| sharpness > AT_ONCE))
    };
    let size = (whole / count.max(1.0)).sqrt();
    // Not exactly one run, nor a few rows if every visit comes from another side: these are motions of the axes.
    let is_run = trail.is_border(first, 1) && trail.is_border(last + 1, 1);
    // Nor rows of one run at its beginning or end.
    let is_part = !trail.has_sense
        && (trail.is_border(first, 4) || trail.is_border(last + 1, 4))
        && !(first + 5..=last.saturating_sub(4)).any(|row| trail.is_border(row, 0));
    // Two consecutive readings of one value may both be outliers.
    let is_one = whole * whole < MORE * fourths;
    let is_little = count < 2.0 && last - first < FEW || is_one && last - first < SEVERAL;
    if is_run || is_part || is_little || !trail.has_sense && last - first < FEW {
        return None;
    }
    let is_alone = is_flat
        && is_sharp
        && brims > FULL * whole
        && middles > MIDDLE * whole
        && back.abs() <= BACK * of_back
        && size > SIZE;
    (is_alone && is_at_once() && again(trail, rows) < AGAIN).then(|| {
        format!(
            "{} consecutive readings shift by {size:.1} times their noise for {:.0} s and back, within one reading at both ends, and not at other visits of the same positions",
            count,
            times[last] - times[first]
        )
    })
}

/// Share of a window at other visits of its points from the same sides.
fn again(trail: &Trail, rows: [usize; 2]) -> f64 {
    let others = trail.other_visits(rows);
    let (mut own, mut other) = (0.0, 0.0);
    for channel in &trail.channels {
        let Some(one) = contrast(trail, channel, rows) else { continue };
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
