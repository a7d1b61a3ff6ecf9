//! A shift that decays, from sudden warming or settling: an effect of the machine, not a fault of the data.
//!
//! If sensors and time absorb a part of the drift, the rest of a decaying shift looks constant. So both forms are fitted together with everything
//! that drifts.

use super::step::ChangePoint;
use super::trail::{ReadingTrail, Trail};
use crate::measure::data::DataSet;
use ncfix_base::numeric::Series;

/// Time constants, s. With a shorter one a shift is a pulse; with a longer one it is constant during a day.
const TAUS_S: [f64; 6] = [450.0, 900.0, 1500.0, 2400.0, 3600.0, 5400.0];
/// Smallest advantage of a decaying shift over a constant one, in squares of the noise: the constant one is simpler, and there are several decaying
/// ones.
const MORE: f64 = 8.0;

/// True if a decaying shift from a row on explains the readings certainly better than a constant one, in addition to the direction terms of their
/// channels.
pub(super) fn fades(trail: &Trail, data: &DataSet, change: &ChangePoint) -> bool {
    let times: Option<Vec<f64>> = data.observations.iter().map(|one| one.t_s).collect();
    let Some(times) = times else { return false };
    let Some(begin) = times.get(change.row) else { return false };
    let is_behind = |row: usize| (change.row..=change.until).contains(&row);
    let fading = |row: usize, tau_s: f64| {
        let since = times.get(row).map_or(0.0, |time| time - begin);
        if is_behind(row) { (-since / tau_s).exp() } else { 0.0 }
    };
    let stays = left(trail, &|row| f64::from(u8::from(is_behind(row))));
    let fades = TAUS_S.iter().map(|&tau_s| left(trail, &|row| fading(row, tau_s)));
    fades.reduce(f64::min).is_some_and(|fades| fades + MORE < stays)
}

/// Sum of squared residuals of all channels after fitting a column by row, in squares of the noise.
fn left(trail: &Trail, column: &dyn Fn(usize) -> f64) -> f64 {
    let of_channel = |channel: &ReadingTrail| {
        let counts = |k: &usize| channel.value[*k].is_finite() && channel.group[*k] < channel.groups;
        let known: Vec<usize> = (0..channel.at.len()).filter(counts).collect();
        // Relative to the same repetitions.
        let centred = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let mut means = vec![[0.0_f64; 2]; channel.groups];
            for &k in &known {
                let mean = &mut means[channel.group[k]];
                *mean = [mean[0] + of(k), mean[1] + 1.0];
            }
            known.iter().map(|&k| of(k) - means[channel.group[k]][0] / means[channel.group[k]][1]).collect()
        };
        let mut series = Series::new(&vec![0; known.len()], &vec![1.0 / channel.noise; known.len()], 0.0);
        for sense in channel.senses() {
            series.take(&centred(&|k| sense[k]));
        }
        series.take(&centred(&|k| column(channel.at[k].0)));
        series.set_values(&centred(&|k| channel.value[k]));
        series.squares()
    };
    trail.channels.iter().filter(|channel| channel.noise > 0.0).map(of_channel).sum()
}
