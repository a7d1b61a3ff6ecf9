//! Interval of the error along a program, from the uncertainty of the error model.
//!
//! Each independent source of uncertainty varies the model by one standard deviation. The forward function of both models gives the displacement of the tip
//! by it, at some places along the program, once. True displacements are sums of these with standard normal amounts, so repetitions of the whole program are sums of
//! numbers. Mean, root mean square and maximum of every repetition give the interval. The same amounts apply before and after the correction.
//!
//! The places are a sample of the program. The figures of the model for the whole program are known: the intervals are moved by their difference from those
//! of the places.

use ncfix_base::geometry::Vector;
use ncfix_base::numeric::noise::Noise;
use ncfix_machine::snc::Origin;
use ncfix_model::Model;

use super::poses::ErrorPlace;
use super::prediction::Spread;

/// Pairs of repetitions with opposite amounts.
const PAIRS: usize = 400;
/// Share of the repetitions beyond each end of the interval.
const BEYOND: f64 = 0.025;
/// Displacements below this are rounding noise, mm.
const NOISE_MM: f64 = 1e-9;
/// Number of stored amounts of unexplained errors, a prime: their repetition has no pattern.
const STORED: usize = 4093;
/// Beginning of the amounts.
const SEED: u64 = 0x5eed_0f1a_7e57;

/// Interval that contains a figure of the true error with a probability of 95 %, mm: lower and upper end of each.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorInterval {
    /// Mean.
    pub mean_mm: [f64; 2],
    /// Root mean square.
    pub rms_mm: [f64; 2],
    /// Maximum.
    pub max_mm: [f64; 2],
    /// Maximum along X, Y and Z of the workpiece.
    pub axes_mm: [[f64; 2]; 3],
}

/// Interval of the error at one place of a program with a probability of 95 %, mm: lower and upper end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StationInterval {
    /// Block of the program.
    pub origin: Origin,
    /// As programmed.
    pub before_mm: [f64; 2],
    /// As emitted.
    pub after_mm: [f64; 2],
}

/// Intervals before and after a correction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PredictedInterval {
    /// As programmed.
    pub before: ErrorInterval,
    /// As emitted.
    pub after: ErrorInterval,
    /// Share of the repetitions in which the correction makes neither the largest nor the root mean square error larger.
    pub better: f64,
    /// Evenly spread places in order of the program.
    pub along: Vec<StationInterval>,
}

impl PredictedInterval {
    /// The intervals that contain these and those of another prediction of the same program.
    #[must_use]
    pub fn including(mut self, other: &PredictedInterval) -> PredictedInterval {
        let widen = |own: &mut [f64; 2], other: &[f64; 2]| *own = [own[0].min(other[0]), own[1].max(other[1])];
        for (own, other) in [(&mut self.before, &other.before), (&mut self.after, &other.after)] {
            widen(&mut own.mean_mm, &other.mean_mm);
            widen(&mut own.rms_mm, &other.rms_mm);
            widen(&mut own.max_mm, &other.max_mm);
            own.axes_mm.iter_mut().zip(&other.axes_mm).for_each(|(own, other)| widen(own, other));
        }
        for (own, other) in self.along.iter_mut().zip(&other.along) {
            widen(&mut own.before_mm, &other.before_mm);
            widen(&mut own.after_mm, &other.after_mm);
        }
        self.better = self.better.min(other.better);
        self
    }
}

/// Figures of one repetition, mm: mean, root mean square, maximum, and the maximum along X, Y and Z.
type ErrorFigures = [f64; 6];

/// Predicts the intervals. `varied` are the models after one standard deviation of each cause, and `unexplained_mm` is a further standard deviation of every
/// place and direction. `whole` has the errors of the model for the whole program before and after. `None` without places.
#[must_use]
pub fn predict(
    places: &[ErrorPlace],
    whole: [&Spread; 2],
    model: &Model,
    varied: &[Model],
    unexplained_mm: f64,
) -> Option<PredictedInterval> {
    predict_from(places, whole, [model; 2], varied, unexplained_mm)
}

/// Predicts the intervals if another model is true than the one with which the program was corrected. `models` are the one of the correction, to which the
/// errors of the places and of the whole program belong, and the other one, which `varied` vary.
#[must_use]
pub fn predict_from(
    places: &[ErrorPlace],
    whole: [&Spread; 2],
    [counted, model]: [&Model; 2],
    varied: &[Model],
    unexplained_mm: f64,
) -> Option<PredictedInterval> {
    if places.is_empty() {
        return None;
    }
    let error = |model: &Model, place: &ErrorPlace, is_after: bool| {
        let command = if is_after { &place.command } else { &place.nominal };
        let state = &place.states[usize::from(is_after)];
        model.for_setup(place.head, place.zero).tip_error_mm(&place.nominal, command, &place.tool_mm, state)
    };
    let of = |model: &Model, is_after: bool| -> Vec<Vector> {
        places.iter().map(|place| error(model, place, is_after)).collect()
    };
    let mut own = [0, 1].map(|which: usize| places.iter().map(|place| place.errors_mm[which]).collect::<Vec<Vector>>());
    let of_counted = [0, 1].map(|which: usize| figures(places, own[which].iter().copied()));
    // The same with each body on a side of its dead band, as in the varied models.
    let base = [false, true].map(|is_after| of(model, is_after));
    if !std::ptr::eq(counted, model) {
        for (which, own) in own.iter_mut().enumerate() {
            let errors = of(counted, which == 1).into_iter().zip(&base[which]);
            own.iter_mut().zip(errors).for_each(|(own, (counted, base))| *own += base - counted);
        }
        // The other model cannot be evaluated there.
        if own.iter().flatten().any(|error| error.iter().any(|part| !part.is_finite())) {
            return None;
        }
    }
    // Displacements differ before and after only where the directions of motion do.
    let is_same = places.iter().all(|place| place.states[0] == place.states[1]);
    let sides: &[bool] = if is_same { &[true] } else { &[false, true] };
    let mut causes: Vec<Vec<Vec<Vector>>> = Vec::new();
    for model in varied {
        let by = sides.iter().map(|&is_after| {
            let mut by = of(model, is_after);
            by.iter_mut().zip(&base[usize::from(is_after)]).for_each(|(by, base)| *by -= base);
            by
        });
        let by: Vec<Vec<Vector>> = by.collect();
        let is_felt = by.iter().flatten().any(|by| by.amax() > NOISE_MM);
        // A model that cannot be evaluated there says nothing about its cause.
        if is_felt && by.iter().flatten().all(|by| by.iter().all(|part| part.is_finite())) {
            causes.push(by);
        }
    }
    let mut random = Noise::new(SEED);
    let stored: Vec<f64> =
        if unexplained_mm > 0.0 { (0..STORED).map(|_| random.normal()).collect() } else { Vec::new() };
    let mut next = 0;
    let mut all: [[Vec<f64>; 6]; 2] = std::array::from_fn(|_| std::array::from_fn(|_| Vec::with_capacity(2 * PAIRS)));
    let mut better = 0_usize;
    // At each place the magnitudes of all repetitions, before and after.
    let mut stations: Vec<[Vec<f64>; 2]> = places.iter().map(|_| [Vec::new(), Vec::new()]).collect();
    let mut sums = vec![vec![Vector::zeros(); places.len()]; sides.len()];
    for _ in 0..PAIRS {
        sums.iter_mut().for_each(|sum| sum.fill(Vector::zeros()));
        for cause in &causes {
            let amount = random.normal();
            for (sum, by) in sums.iter_mut().flatten().zip(cause.iter().flatten()) {
                *sum += by * amount;
            }
        }
        if !stored.is_empty() {
            for place in 0..places.len() {
                let local = Vector::from_fn(|row, _| unexplained_mm * stored[(next + row) % STORED]);
                next += 3;
                sums.iter_mut().for_each(|sum| sum[place] += local);
            }
        }
        for sign in [1.0, -1.0] {
            let both = [0, 1].map(|which: usize| {
                let sum = &sums[which.min(sides.len() - 1)];
                let errors = || own[which].iter().zip(sum).map(|(own, by)| own + by * sign);
                stations.iter_mut().zip(errors()).for_each(|(lists, error)| lists[which].push(error.norm()));
                figures(places, errors())
            });
            better += usize::from(both[1][1] <= both[0][1] && both[1][2] <= both[0][2]);
            for (lists, figures) in all.iter_mut().zip(both) {
                lists.iter_mut().zip(figures).for_each(|(list, figure)| list.push(figure));
            }
        }
    }
    let of_before = figures(places, own[0].iter().copied());
    let [mut before, mut after] = all.map(|lists| lists.map(ends));
    before.iter_mut().zip(of_before).for_each(|(ends, figure)| ends[0] = lowered(*ends, figure));
    of_whole(&mut before, &of_counted[0], whole[0]);
    of_whole(&mut after, &of_counted[1], whole[1]);
    let [before, after] = [before, after].map(|[mean_mm, rms_mm, max_mm, x, y, z]| ErrorInterval {
        mean_mm,
        rms_mm,
        max_mm,
        axes_mm: [x, y, z],
    });
    let even = places.iter().zip(&own[0]).zip(stations).filter(|((place, _), _)| place.is_even);
    let along = even.map(|((place, own), lists)| {
        let [mut before_mm, after_mm] = lists.map(ends);
        before_mm[0] = lowered(before_mm, own.norm());
        StationInterval { origin: place.origin, before_mm, after_mm }
    });
    Some(PredictedInterval { before, after, better: better as f64 / (2 * PAIRS) as f64, along: along.collect() })
}

/// Mean and root mean square of the distances at evenly spread places, their maximum at all, and the maximum of each direction, mm.
fn figures(places: &[ErrorPlace], errors: impl Iterator<Item = Vector>) -> ErrorFigures {
    let mut out = [0.0; 6];
    let mut count = 0.0;
    for (place, error) in places.iter().zip(errors) {
        let square = error.norm_squared();
        let size = square.sqrt();
        if place.is_even {
            count += 1.0;
            out[0] += size;
            out[1] += square;
        }
        out[2] = f64::max(out[2], size);
        for (largest, part) in out[3..].iter_mut().zip(error.iter()) {
            *largest = f64::max(*largest, part.abs());
        }
    }
    out[0] /= f64::max(count, 1.0);
    out[1] = (out[1] / f64::max(count, 1.0)).sqrt();
    out
}

/// Moves the intervals of the mean, the root mean square and the maxima from the places to the whole program. Squares are moved by the difference of squares:
/// a part that the correction has removed adds to the rest in this way. The places have each body of unknown side where it is best, which is the lower end; the
/// worst side belongs to the upper one.
fn of_whole(intervals: &mut [[f64; 2]; 6], of_places: &ErrorFigures, whole: &Spread) {
    if whole.samples == 0 {
        return;
    }
    let moved = |end: f64, by: f64| (end * end + by).max(0.0).sqrt();
    let sides = [whole.nearest_mm(), [whole.mean_mm(), whole.rms_mm(), whole.max_mm]];
    for (end, [mean_mm, rms_mm, max_mm]) in sides.into_iter().enumerate() {
        intervals[0][end] = (intervals[0][end] + mean_mm - of_places[0]).max(0.0);
        intervals[1][end] = moved(intervals[1][end], rms_mm.powi(2) - of_places[1].powi(2));
        // The places contain those of the largest errors at stations. Ends of pieces may have larger ones.
        intervals[2][end] = moved(intervals[2][end], (max_mm.powi(2) - of_places[2].powi(2)).max(0.0));
    }
    for (axis, [_, high]) in intervals[3..].iter_mut().enumerate() {
        let beyond = whole.axes_mm[axis].powi(2) - of_places[3 + axis].powi(2);
        *high = moved(*high, beyond.max(0.0));
    }
}

/// The lower end of an interval about a figure of the model. The model contains the scatter of its fit once, and each repetition contains it twice: the excess
/// of the upper end over the model, in squares, also lies below the model.
fn lowered([low, high]: [f64; 2], of_model: f64) -> f64 {
    low.min((2.0 * of_model * of_model - high * high).max(0.0).sqrt())
}

/// The ends of the interval of a list.
fn ends(mut list: Vec<f64>) -> [f64; 2] {
    list.sort_unstable_by(f64::total_cmp);
    let last = list.len().saturating_sub(1);
    let out = (BEYOND * last as f64).round() as usize;
    [out, last - out.min(last)].map(|at| list.get(at).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::{Axis, AxisVector};
    use ncfix_base::source::{FileId, Source};
    use ncfix_machine::machine::State;

    /// Without figures of the whole program.
    const NONE: [&Spread; 2] = [&Spread::NONE; 2];

    fn model(scale: f64) -> Model {
        let text = format!(
            "[machine]\nname = \"m\"\ntopology = \"wFXt\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 400]\n\
             [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, {scale}]\n"
        );
        let source = Source::new(FileId(0), "m.toml", text.into_bytes()).unwrap();
        let (machine, errors) = ncfix_model::file::load(&source).0.unwrap();
        Model::new(&machine, &errors)
    }

    /// Places every 10 mm up to 400 mm. As emitted, the error of the model is removed.
    fn places(scale: f64) -> Vec<ErrorPlace> {
        let of = |k: i32| {
            let mut nominal = AxisVector::ZERO;
            nominal[Axis::X] = f64::from(10 * k);
            let mut command = nominal;
            command[Axis::X] -= scale * nominal[Axis::X];
            let states = [State::default(); 2];
            let errors_mm = [nominal[Axis::X], 0.0].map(|x| Vector::new(scale * x, 0.0, 0.0));
            let origin = Origin { line: k as u32, ..Origin::default() };
            ErrorPlace {
                nominal,
                command,
                states,
                errors_mm,
                tool_mm: Vector::zeros(),
                origin,
                zero: None,
                head: 0,
                is_even: true,
            }
        };
        (1..=40).map(of).collect()
    }

    #[test]
    fn one_cause_gives_the_quantiles_of_its_amount() {
        // The scale is 50 ± 5 µm/m: the largest error is that at 400 mm, 20 ± 2 µm before and |0 ± 2| µm after.
        let found = predict(&places(50e-6), NONE, &model(50e-6), &[model(55e-6)], 0.0).unwrap();
        let [low, high] = found.before.max_mm;
        assert!(
            (low - (20.0 - 1.96 * 2.0) * 1e-3).abs() < 1.2e-3 && (high - (20.0 + 1.96 * 2.0) * 1e-3).abs() < 0.8e-3
        );
        let [low, high] = found.after.max_mm;
        // Of the magnitude of a normal number, 2.5 % are below 0.0313 and 2.5 % above 2.24.
        assert!(low < 0.2e-3 && (high - 2.24 * 2e-3).abs() < 0.8e-3, "{low} {high}");
        assert_eq!((found.better, found.after.axes_mm[1]), (1.0, [0.0; 2]));
        assert_eq!(found.after.axes_mm[0], found.after.max_mm);
        // At 100 mm it is a quarter of that, 5 ± 0.5 µm before.
        assert_eq!(found.along.len(), 40);
        let at = found.along[9];
        let [low, high] = at.before_mm;
        assert_eq!(at.origin.line, 10);
        assert!((low - (5.0 - 1.96 * 0.5) * 1e-3).abs() < 0.3e-3 && (high - (5.0 + 1.96 * 0.5) * 1e-3).abs() < 0.2e-3);
    }

    #[test]
    fn a_correction_smaller_than_its_uncertainty_is_not_certain() {
        let found = predict(&places(5e-6), NONE, &model(5e-6), &[model(25e-6)], 0.0).unwrap();
        assert!(found.better > 0.5 && found.better < 0.7, "{}", found.better);
        assert!(predict(&[], NONE, &model(0.0), &[], 0.0).is_none());
        // A further error of 1 µm in each of three directions: √3 µm root mean square.
        let found = predict(&places(5e-6), NONE, &model(5e-6), &[], 1e-3).unwrap();
        let [low, high] = found.after.rms_mm;
        assert!(low < 1.732e-3 && 1.732e-3 < high && high - low < 0.6e-3, "{low} {high}");
    }

    #[test]
    fn another_model_than_that_of_the_correction_has_its_own_errors() {
        // The program was corrected for 50 µm/m, and 60 µm/m are true: 24 ± 2 µm before at 400 mm, and 4 ± 2 µm after.
        let [counted, other] = [50e-6, 60e-6].map(model);
        let found = predict_from(&places(50e-6), NONE, [&counted, &other], &[model(65e-6)], 0.0).unwrap();
        let [low, high] = found.before.max_mm;
        assert!((low - 20.08e-3).abs() < 1.2e-3 && (high - 27.92e-3).abs() < 0.8e-3, "{low} {high}");
        let [low, high] = found.after.max_mm;
        assert!((low - 0.08e-3).abs() < 0.4e-3 && (high - 7.92e-3).abs() < 0.8e-3, "{low} {high}");
    }

    #[test]
    fn the_unknown_side_of_a_body_is_between_the_ends() {
        // At the places a body is best, and the whole program has up to 3 µm more on the worst side: the mean is 0 to 3 µm.
        let mut whole = Spread::NONE;
        whole.add_between([0.0, 3e-3]);
        let found = predict(&places(0.0), [&whole, &Spread::NONE], &model(0.0), &[], 0.0).unwrap();
        for [low, high] in [found.before.mean_mm, found.before.rms_mm, found.before.max_mm] {
            assert!(low == 0.0 && (high - 3e-3).abs() < 1e-12, "{low} {high}");
        }
    }

    #[test]
    fn the_errors_are_those_of_the_places() {
        // A body that waits 3 µm before its side, which no direction of motion states.
        let mut waiting = places(0.0);
        waiting.iter_mut().for_each(|place| place.errors_mm[1] = Vector::new(0.0, 0.0, 3e-3));
        let found = predict(&waiting, NONE, &model(0.0), &[model(1e-6)], 0.0).unwrap();
        assert_eq!(found.before.axes_mm[2], [0.0; 2]);
        assert!(found.after.axes_mm[2].iter().all(|end| (end - 3e-3).abs() < 1e-12));
    }

    #[test]
    fn the_worst_side_of_a_body_belongs_to_the_upper_end_along_its_axis() {
        let mut whole = Spread::NONE;
        whole.add(0.0);
        whole.axes_mm = [0.0, 0.0, 3e-3];
        let found = predict(&places(50e-6), [&Spread::NONE, &whole], &model(50e-6), &[model(55e-6)], 0.0).unwrap();
        let alone = predict(&places(50e-6), NONE, &model(50e-6), &[model(55e-6)], 0.0).unwrap();
        assert_eq!(found.after.axes_mm[0], alone.after.axes_mm[0]);
        assert!(found.after.axes_mm[2][0] == 0.0 && (found.after.axes_mm[2][1] - 3e-3).abs() < 1e-12);
    }

    #[test]
    fn the_interval_is_that_of_the_whole_program() {
        // The errors of the places are 0.5 µm · k for k = 1 … 40: mean 10.25 µm, mean square 0.25 · 41 · 81 / 6 = 138.375 µm², largest 20 µm.
        let mut whole = Spread::default();
        [3e-3, 21e-3, 12e-3].into_iter().for_each(|error_mm| whole.add(error_mm));
        let found = predict(&places(50e-6), [&whole, &Spread::NONE], &model(50e-6), &[model(55e-6)], 0.0).unwrap();
        let alone = predict(&places(50e-6), NONE, &model(50e-6), &[model(55e-6)], 0.0).unwrap();
        // Mean 12 µm; mean square (9 + 441 + 144) / 3 = 198 µm².
        for end in 0..2 {
            assert!((found.before.mean_mm[end] - alone.before.mean_mm[end] - 1.75e-3).abs() < 1e-9);
            let square = found.before.rms_mm[end].powi(2) - alone.before.rms_mm[end].powi(2);
            assert!((square - (198.0 - 138.375) * 1e-6).abs() < 1e-10, "{square}");
            let square = found.before.max_mm[end].powi(2) - alone.before.max_mm[end].powi(2);
            assert!((square - (441.0 - 400.0) * 1e-6).abs() < 1e-10, "{square}");
        }
        assert_eq!(found.after, alone.after);
    }
}
