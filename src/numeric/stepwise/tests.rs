//! What is found in noise, and what is found of effects.

use super::*;

/// Normal numbers from a seed.
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

/// Runs of a drift with 40 candidates as slow as temperatures behind lags: eight sensors that follow two causes, each with five lags; a
/// constant for each run is always in.
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
        handicaps: vec![0.0; sensors * lags],
    }
}

fn noise(rows: &mut Rows, rho: f64, runs: usize, random: &mut Random) {
    let length = rows.values.len() / runs;
    rows.values = (0..runs).flat_map(|_| random.correlated(rho, length)).collect();
}

/// The classical procedure at 99.99 % for each test, as if all rows were independent.
fn classical(tried: f64) -> Rule {
    Rule { significance: 1e-4 * tried, correlated: false, held_out: false }
}

#[test]
#[allow(clippy::print_stdout, reason = "the shares are what one wants to see")]
fn noise_of_correlation_095_is_no_effect() {
    for (runs, length) in [(1, 240), (4, 60), (5, 100)] {
        let trials = 120;
        let (mut naive, mut whitened, mut honest) = (0, 0, 0);
        for seed in 0..trials {
            let mut random = Random(seed * 7919 + 13);
            let mut rows = drift(runs, length, &mut random);
            noise(&mut rows, 0.95, runs, &mut random);
            let found = |rule: Rule| usize::from(!choose(&rows, rule).unwrap().terms.is_empty());
            naive += found(classical(40.0));
            whitened += found(Rule { held_out: false, ..Rule::default() });
            honest += found(Rule::default());
        }
        println!("{runs} runs of {length}: naive {naive}, whitened {whitened}, honest {honest} of {trials}");
    }
}

#[test]
#[allow(clippy::print_stdout, reason = "the shares are what one wants to see")]
fn effects_are_found() {
    for (runs, length) in [(1, 240), (4, 60), (5, 100)] {
        for size in [0.5, 1.0, 1.5] {
            let trials = 60;
            let (mut any, mut class, mut more) = (0, 0, 0);
            for seed in 0..trials {
                let mut random = Random(seed * 104_729 + 5);
                let mut rows = drift(runs, length, &mut random);
                noise(&mut rows, 0.95, runs, &mut random);
                let column = rows.factors.column(runs + 12).into_owned();
                let mean = column.mean();
                let spread = column.variance().sqrt();
                rows.values.iter_mut().zip(column.iter()).for_each(|(value, own)| *value += size * (own - mean) / spread);
                let choice = choose(&rows, Rule::default()).unwrap();
                any += usize::from(!choice.terms.is_empty());
                let is_it = |term: &Term| term.candidate == 12 || term.rivals.iter().any(|rival| rival.candidate == 12);
                class += usize::from(choice.terms.iter().any(is_it));
                more += usize::from(choice.terms.len() > 1);
            }
            println!("{runs} runs of {length}, {size}: any {any}, named {class}, several {more} of {trials}");
        }
    }
}
