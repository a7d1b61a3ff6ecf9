//! Selection in pure noise, and selection of true effects.

use nalgebra::DMatrix;

use super::lagged::Lagged;
use super::*;

/// Normally distributed numbers from a seed.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let size = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        size * (std::f64::consts::TAU * self.uniform()).cos()
    }

    /// First-order autoregression of variance 1.
    fn correlated(&mut self, rho: f64, count: usize) -> Vec<f64> {
        let mut last = self.normal();
        let mut out = vec![last];
        while out.len() < count {
            last = rho * last + (1.0 - rho * rho).sqrt() * self.normal();
            out.push(last);
        }
        out
    }
}

/// Returns runs of a drift with 40 candidates that are slow like lagged temperatures: eight sensors that follow two causes, each with five lags. A constant
/// for each run is always in.
fn drift(runs: usize, length: usize, random: &mut Random) -> Rows {
    let (count, sensors, lags) = (runs * length, 8, 5);
    let mut factors = DMatrix::zeros(count, runs + sensors * lags);
    for run in 0..runs {
        let causes: Vec<Vec<f64>> = (0..2).map(|_| random.correlated(0.98, length)).collect();
        for sensor in 0..sensors {
            let own = random.correlated(0.98, length);
            let mut smooth = [0.0; 5];
            for k in 0..length {
                let now = 0.8 * causes[sensor % 2][k] + 0.6 * own[k];
                for (lag, state) in smooth.iter_mut().enumerate() {
                    let share = 1.0 / (1.0 + 3.0 * lag as f64);
                    *state = if k == 0 { now } else { *state + share * (now - *state) };
                    factors[(run * length + k, runs + sensor * lags + lag)] = *state;
                }
            }
        }
        (0..length).for_each(|k| factors[(run * length + k, run)] = 1.0);
    }
    Rows {
        always: runs,
        factors,
        values: vec![0.0; count],
        series: (0..count).map(|row| row / length).collect(),
        noise: vec![0; count],
        cluster: vec![Some(0); count],
        run: (0..count).map(|row| row / length).collect(),
        place: vec![None; count],
        side: vec![0; count],
        handicaps: vec![0.0; sensors * lags],
    }
}

fn noise(rows: &mut Rows, rho: f64, runs: usize, random: &mut Random) {
    let length = rows.values.len() / runs;
    rows.values = (0..runs).flat_map(|_| random.correlated(rho, length)).collect();
}

/// Classical procedure at 99.99 % per test, as if all rows were independent.
fn classical(tried: f64) -> Rule {
    Rule { significance: 1e-4 * tried, correlated: false, held_out: false }
}

/// Numbers of runs, and their lengths.
const SIZES: [(usize, usize); 2] = [(1, 240), (4, 60)];
/// A candidate without a lag.
const HIDDEN: usize = 10;

#[test]
#[allow(clippy::print_stdout, reason = "the shares are worth reading where the test fails")]
fn in_noise_of_correlation_095_there_is_no_effect() {
    let trials = 120;
    for (runs, length) in SIZES {
        let (mut naive, mut honest) = (0, 0);
        for seed in 0..trials {
            let mut random = Random(seed * 7919 + 13);
            let mut rows = drift(runs, length, &mut random);
            noise(&mut rows, 0.95, runs, &mut random);
            let claims = |rule: Rule| u64::from(!choose(&rows, rule).unwrap().terms.is_empty());
            naive += claims(classical(40.0));
            honest += claims(Rule::default());
        }
        println!("{runs} runs of {length}: as if independent {naive}, honest {honest} of {trials}");
        assert!(naive * 100 >= 90 * trials, "the classical procedure: {naive} of {trials}");
        assert!(honest * 100 <= 5 * trials, "{honest} of {trials}");
    }
}

#[test]
#[allow(clippy::print_stdout, reason = "the shares are worth reading where the test fails")]
fn effects_of_one_and_a_half_standard_deviations_are_found() {
    let trials = 100;
    for (runs, length) in SIZES {
        let (mut found, mut named) = (0, 0);
        for seed in 0..trials {
            let mut random = Random(seed * 104_729 + 5);
            let mut rows = drift(runs, length, &mut random);
            noise(&mut rows, 0.95, runs, &mut random);
            let column = rows.factors.column(runs + HIDDEN).into_owned();
            let scale = 1.5 / column.variance().sqrt();
            rows.values.iter_mut().zip(column.iter()).for_each(|(value, own)| *value += scale * own);
            let choice = choose(&rows, Rule::default()).unwrap();
            let alike = |term: &Term| term.rivals.iter().any(|rival| rival.candidate == HIDDEN);
            found += u64::from(!choice.terms.is_empty());
            named += u64::from(choice.terms.iter().any(|term| term.candidate == HIDDEN || alike(term)));
        }
        println!("{runs} runs of {length}: found {found}, named {named} of {trials}");
        assert!(named * 100 >= 87 * trials, "{named} of {trials}");
    }
}

#[test]
#[ignore = "ten times as many: a minute"]
#[allow(clippy::print_stdout, reason = "the shares are what one wants to see")]
fn shares_of_many_trials() {
    let trials = 1000;
    for (runs, length) in [(1, 240), (4, 60), (5, 100), (10, 20), (2, 400)] {
        let mut claims = 0;
        for seed in 0..trials {
            let mut random = Random(seed * 6151 + 1);
            let mut rows = drift(runs, length, &mut random);
            noise(&mut rows, 0.95, runs, &mut random);
            claims += u64::from(!choose(&rows, Rule::default()).unwrap().terms.is_empty());
        }
        println!("{runs} runs of {length}: {claims} of {trials}");
        assert!(claims * 100 <= 5 * trials);
    }
}

#[test]
#[ignore = "large: seconds"]
#[allow(clippy::print_stdout, reason = "the time is what one wants to see")]
fn many_candidates_of_many_rows_take_seconds() {
    let (count, candidates) = (20_000, 500);
    let mut random = Random(1);
    let mut rows = drift(1, 10, &mut random);
    rows.always = 1;
    rows.factors = DMatrix::from_fn(count, candidates + 1, |_, column| if column == 0 { 1.0 } else { random.normal() });
    rows.values = random.correlated(0.8, count);
    let column = rows.factors.column(77).into_owned();
    rows.values.iter_mut().zip(column.iter()).for_each(|(value, own)| *value += 0.3 * own);
    rows.series = (0..count).map(|row| row / 1000).collect();
    (rows.run, rows.noise) = (rows.series.clone(), vec![0; count]);
    rows.cluster = vec![Some(0); count];
    rows.handicaps = vec![0.0; candidates];
    let begun = std::time::Instant::now();
    let choice = choose(&rows, Rule::default()).unwrap();
    let taken = begun.elapsed();
    println!("{taken:?}");
    assert_eq!(choice.terms.iter().map(|term| term.candidate).collect::<Vec<usize>>(), [76]);
    assert!(taken.as_secs() < 60, "{taken:?}");
}

#[test]
fn the_correlation_comes_back() {
    for rho in [0.0, 0.5, 0.9] {
        let mut random = Random(99);
        let mut rows = drift(4, 300, &mut random);
        noise(&mut rows, rho, 4, &mut random);
        let found = choose(&rows, Rule::default()).unwrap().correlation;
        // Four standard deviations of √((1 − ρ²) / 1200).
        let limit = 4.0 * ((1.0 - rho * rho) / 1200.0_f64).sqrt();
        assert_eq!(found.len(), 1);
        assert!((found[0].1 - rho).abs() < limit, "{rho}: {found:?}");
    }
}

#[test]
fn products_are_those_of_rows_less_their_neighbours() {
    let mut random = Random(3);
    let mut rows = drift(3, 20, &mut random);
    noise(&mut rows, 0.5, 3, &mut random);
    // A series of one row, and a separate group.
    rows.series[59] = 7;
    (40..60).for_each(|row| rows.noise[row] = 1);
    let prepared = PreparedRows::new(&rows).unwrap();
    let lagged = Lagged::new(&prepared.rows, &prepared.groups);
    let correlation = [0.7, 0.2];
    let mut expected = DMatrix::zeros(prepared.width(), prepared.width());
    for k in 0..60 {
        let own = prepared.rows.column(k).into_owned();
        let rho: f64 = correlation[usize::from(k >= 40)];
        let begins = [0, 20, 40, 59].contains(&k);
        let white = if begins { own } else { (own - prepared.rows.column(k - 1) * rho) / (1.0 - rho * rho).sqrt() };
        expected += &white * white.transpose();
    }
    assert!((lagged.gram(&correlation) - expected).amax() < 1e-12);
}

#[test]
fn what_is_not_finite_or_too_little_has_no_choice() {
    let mut random = Random(3);
    let good = drift(2, 20, &mut random);
    let mut bad = good.clone();
    bad.values[3] = f64::NAN;
    assert!(choose(&bad, Rule::default()).is_none());
    let mut bad = good.clone();
    bad.series.pop();
    assert!(choose(&bad, Rule::default()).is_none());
    let mut bad = drift(1, 20, &mut random);
    bad.always = 31;
    bad.handicaps.truncate(10);
    assert!(choose(&bad, Rule::default()).is_none(), "as many columns as rows");
    // All zeros: no effect.
    assert_eq!(choose(&good, Rule::default()).unwrap().terms, []);
}

#[test]
fn values_without_noise_are_found_exactly() {
    let mut random = Random(8);
    let mut rows = drift(4, 60, &mut random);
    let said = rows.factors.column(4 + 5) * 3.0 - rows.factors.column(4 + 30) * 0.25;
    rows.values = said.iter().copied().collect();
    let choice = choose(&rows, Rule::default()).unwrap();
    let found: Vec<usize> = choice.terms.iter().map(|term| term.candidate).collect();
    assert_eq!(found, [5, 30], "{:?}", choice.steps);
    assert!((choice.terms[0].value - 3.0).abs() < 1e-6 && (choice.terms[1].value + 0.25).abs() < 1e-6);
}

/// A curve over 60 places in five runs of white noise, of which the candidates have the half: what they lack must not count as autocorrelated noise.
#[test]
fn repeats_show_the_noise_where_terms_are_missing() {
    let (runs, length) = (5, 60);
    let count = runs * length;
    let mut random = Random(11);
    let at = |row: usize| (row % length) as f64 / length as f64;
    let shapes: [fn(f64) -> f64; 4] =
        [|x| x, |x| x * x, |x| (x - 0.5).max(0.0).powi(2), |x| (x - 0.75).max(0.0).powi(2)];
    let mut factors = DMatrix::zeros(count, 1 + shapes.len());
    let mut values = Vec::new();
    for row in 0..count {
        factors[(row, 0)] = 1.0;
        shapes.iter().enumerate().for_each(|(k, shape)| factors[(row, 1 + k)] = shape(at(row)));
        values.push(30.0 * at(row).powi(2) - 40.0 * shapes[2](at(row)) + 200.0 * shapes[3](at(row)) + random.normal());
    }
    let mut rows = Rows {
        always: 1,
        factors,
        values,
        series: (0..count).map(|row| row / length).collect(),
        noise: vec![0; count],
        cluster: vec![Some(0); count],
        run: (0..count).map(|row| row / length).collect(),
        place: (0..count).map(|row| Some(row % length)).collect(),
        side: vec![0; count],
        handicaps: vec![0.0; shapes.len()],
    };
    let rule = Rule { significance: 1e-4, ..Rule::default() };
    let with = choose(&rows, rule).unwrap();
    assert!(with.steps.iter().all(|step| step.correlation < 0.15), "{with:#?}");
    assert_eq!(with.terms.iter().map(|term| term.candidate).collect::<Vec<_>>(), [1, 2, 3]);
    rows.place = vec![None; count];
    let without = choose(&rows, rule).unwrap();
    assert!(without.steps[0].correlation > 0.5, "{without:#?}");
}

/// Rows of independent noise in groups of equal length, one after the other, without repeats.
fn groups(factors: DMatrix<f64>, values: Vec<f64>, count: usize) -> Rows {
    let rows = values.len();
    let group = |row: usize| row * count / rows;
    Rows {
        always: 0,
        series: (0..rows).map(group).collect(),
        noise: (0..rows).map(group).collect(),
        cluster: (0..rows).map(|row| Some(group(row))).collect(),
        run: vec![0; rows],
        place: vec![None; rows],
        side: vec![0; rows],
        handicaps: vec![0.0; factors.ncols()],
        factors,
        values,
    }
}

/// A signal of three standard deviations that is the difference of two nearly equal columns.
#[test]
fn two_columns_enter_together_if_neither_explains_anything_alone() {
    let mut random = Random(3);
    let count = 120;
    let mut factors = DMatrix::zeros(count, 2);
    let mut values = Vec::new();
    for row in 0..count {
        let (signal, common) = (random.normal(), random.normal());
        factors[(row, 0)] = common + 0.02 * signal;
        factors[(row, 1)] = common;
        values.push(3.0 * signal + random.normal());
    }
    let found = choose(&groups(factors, values, 1), Rule::default()).unwrap();
    let values: Vec<f64> = found.terms.iter().map(|term| term.value).collect();
    // 3 / 0.02, with opposite signs.
    assert!(values.len() == 2 && (values[0] - 150.0).abs() < 20.0 && (values[1] + 150.0).abs() < 20.0, "{values:?}");
}

/// The first group has a term of two standard deviations. The second one has readings of a hundred times the noise, which no column explains.
#[test]
fn the_misfit_of_one_group_hides_nothing_in_another() {
    let mut random = Random(9);
    let count = 160;
    let mut factors = DMatrix::zeros(count, 1);
    let mut values = Vec::new();
    for row in 0..count {
        let is_first = row < count / 2;
        let shape = random.normal();
        factors[(row, 0)] = if is_first { shape } else { 0.0 };
        values.push(if is_first { 2.0 * shape + random.normal() } else { 100.0 * random.normal() });
    }
    let found = choose(&groups(factors, values, 2), Rule::default()).unwrap();
    assert!(found.terms.len() == 1 && (found.terms[0].value - 2.0).abs() < 0.4, "{found:#?}");
}

/// One run forward and back over 60 places, with a curve that no column has and a backlash of ten standard deviations: white noise stays white.
#[test]
fn readings_from_two_sides_are_repeats_but_for_a_constant() {
    let mut random = Random(21);
    let places = 60;
    let at = |row: usize| if row < places { row } else { 2 * places - 1 - row };
    let values: Vec<f64> = (0..2 * places)
        .map(|row| {
            let side = if row < places { 5.0 } else { -5.0 };
            20.0 * (0.1 * at(row) as f64).sin() + side + random.normal()
        })
        .collect();
    let mut factors = DMatrix::zeros(2 * places, 1);
    (0..2 * places).for_each(|row| factors[(row, 0)] = if row < places { 0.5 } else { -0.5 });
    let mut rows = groups(factors, values, 1);
    rows.always = 1;
    rows.handicaps = Vec::new();
    rows.place = (0..2 * places).map(|row| Some(at(row))).collect();
    rows.side = (0..2 * places).map(|row| usize::from(row < places)).collect();
    let correlation = |rows: &Rows| choose(rows, Rule::default()).unwrap().correlation[0].1;
    assert!(correlation(&rows) < 0.3, "{}", correlation(&rows));
    rows.place = vec![None; 2 * places];
    assert!(correlation(&rows) > 0.8, "{}", correlation(&rows));
}

/// Errors of 25 places that follow no curve, each read six times with a tenth of this scatter: six readings of a place are one piece of evidence.
#[test]
fn readings_of_one_place_are_no_evidence_for_a_curve() {
    let (places, runs, trials) = (25, 6, 60);
    let mut claims = 0;
    for seed in 0..trials {
        let mut random = Random(4000 + seed);
        let own: Vec<f64> = (0..places).map(|_| 10.0 * random.normal()).collect();
        let count = places * runs;
        let at = |row: usize| (row % places) as f64 / places as f64;
        let mut factors = DMatrix::zeros(count, 11);
        let mut values = Vec::new();
        for row in 0..count {
            factors[(row, 0)] = 1.0;
            factors[(row, 1)] = at(row).powi(2);
            (0..9).for_each(|knot| factors[(row, 2 + knot)] = (at(row) - 0.1 * (knot + 1) as f64).max(0.0).powi(2));
            values.push(own[row % places] + random.normal());
        }
        let rows = Rows {
            always: 1,
            factors,
            values,
            series: (0..count).map(|row| row / places).collect(),
            noise: vec![0; count],
            cluster: vec![Some(0); count],
            run: (0..count).map(|row| row / places).collect(),
            place: (0..count).map(|row| Some(row % places)).collect(),
            side: vec![0; count],
            handicaps: vec![0.0; 10],
        };
        claims += usize::from(!choose(&rows, Rule::default()).unwrap().terms.is_empty());
    }
    assert!(claims * 20 <= 60, "{claims} of 60");
}
