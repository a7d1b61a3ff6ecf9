//! A shift that fades: what warmed up at once and cools down, or settles, is an effect of the machine and no fault of the data.
//!
//! Beside a drift that sensors and time take up, the rest of a shift that fades looks flat. Both are therefore fitted beside all that drifts.

use super::step::ChangePoint;
use super::trail::{ReadingTrail, Trail};
use crate::measure::data::DataSet;
use ncfix_base::numeric::Series;

/// Time constants, s: within the shortest one a shift is a pulse, and what takes as many hours as the longest one stays for a day.
const TAUS_S: [f64; 6] = [450.0, 900.0, 1500.0, 2400.0, 3600.0, 5400.0];
/// One that fades explains so many squares of the noise more than one that stays, which is the simpler one: of the former there are several.
const MORE: f64 = 8.0;

/// Whether a shift from a row on that fades says the readings surely better than one that stays, beside what goes with the senses of their channels.
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

/// Squares, in squares of the noise, that are left of all channels beside a column by row.
fn left(trail: &Trail, column: &dyn Fn(usize) -> f64) -> f64 {
    let of_channel = |channel: &ReadingTrail| {
        let counts = |k: &usize| channel.value[*k].is_finite() && channel.group[*k] < channel.groups;
        let known: Vec<usize> = (0..channel.at.len()).filter(counts).collect();
        // Against the same repetitions.
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
