//! Maximum of a function of one variable, in few evaluations.

/// Share of an interval for each step of the golden section, used if a parabola does not help.
const SHARE: f64 = 0.381_966_011_250_105_2;

/// Returns the position of the maximum of `of` between two numbers, to within `close`, and its value. The method uses parabolas through the best points, and
/// the golden section if these fail (Brent, *Algorithms for Minimization without Derivatives*, 1973, chapter 5). For a function with several peaks it returns
/// one of them.
#[must_use]
pub fn peak(low: f64, high: f64, close: f64, most: usize, of: &dyn Fn(f64) -> f64) -> (f64, f64) {
    let (mut low, mut high) = (low.min(high), low.max(high));
    let mut best = low + SHARE * (high - low);
    let mut at_best = of(best);
    // Second and third best point.
    let [(mut second, mut at_second), (mut third, mut at_third)] = [(best, at_best); 2];
    // Last step, and the one before it.
    let (mut step, mut earlier) = (0.0_f64, 0.0_f64);
    for _ in 1..most {
        let middle = f64::midpoint(low, high);
        if (best - middle).abs() <= 2.0 * close - 0.5 * (high - low) {
            break;
        }
        let parabola = vertex([(best, at_best), (second, at_second), (third, at_third)]);
        // It must lead inside, and by less than half of the step before the last; otherwise it does not converge.
        let by_parabola = parabola.map(|vertex| vertex - best).filter(|by| {
            earlier.abs() > close && by.abs() < 0.5 * earlier.abs() && best + by > low && best + by < high
        });
        (step, earlier) = if let Some(by) = by_parabola {
            // Not next to an end, which is known.
            let is_at_end = best + by - low < 2.0 * close || high - (best + by) < 2.0 * close;
            (if is_at_end { close.copysign(middle - best) } else { by }, step)
        } else {
            let rest = if best < middle { high - best } else { low - best };
            (SHARE * rest, rest)
        };
        let at = best + if step.abs() < close { close.copysign(step) } else { step };
        let value = of(at);
        if value >= at_best {
            *(if at < best { &mut high } else { &mut low }) = best;
            (third, at_third, second, at_second, best, at_best) = (second, at_second, best, at_best, at, value);
        } else {
            *(if at < best { &mut low } else { &mut high }) = at;
            if value >= at_second || second == best {
                (third, at_third, second, at_second) = (second, at_second, at, value);
            } else if value >= at_third || third == best || third == second {
                (third, at_third) = (at, value);
            }
        }
    }
    (best, at_best)
}

/// Returns the vertex of the parabola through three points; `None` if they are on a line.
fn vertex([(a, at_a), (b, at_b), (c, at_c)]: [(f64, f64); 3]) -> Option<f64> {
    let (by_b, by_c) = ((a - b) * (at_a - at_c), (a - c) * (at_a - at_b));
    let under = 2.0 * (by_b - by_c);
    let by = ((a - b) * by_b - (a - c) * by_c) / under;
    by.is_finite().then_some(a - by)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn a_peak_is_found_in_few_trials() {
        // −(x − 2)² + 5, sin x, and x·e^(−x): peaks at 2, π/2, 1.
        type Case = (fn(f64) -> f64, [f64; 2], [f64; 2]);
        let cases: [Case; 3] = [
            (|x| 5.0 - (x - 2.0).powi(2), [-4.0, 10.0], [2.0, 5.0]),
            (f64::sin, [0.0, 3.0], [std::f64::consts::FRAC_PI_2, 1.0]),
            (|x| x * (-x).exp(), [0.2, 4.0], [1.0, (-1.0_f64).exp()]),
        ];
        for (of, [low, high], [at, value]) in cases {
            let count = Cell::new(0);
            let close = 1e-3 * (high - low);
            let found = peak(low, high, close, 30, &|x| {
                count.set(count.get() + 1);
                assert!(x > low && x < high);
                of(x)
            });
            assert!((found.0 - at).abs() < 2.0 * close && (found.1 - value).abs() < 1e-5, "{found:?}");
            // The golden section needs 16 for that.
            assert!(count.get() <= 11, "{}", count.get());
        }
    }

    #[test]
    fn an_end_is_found_and_trials_are_limited() {
        let (at, _) = peak(0.0, 1.0, 1e-4, 60, &|x| x);
        assert!(at > 0.999);
        let (at, _) = peak(1.0, 0.0, 1e-4, 60, &|x| -x);
        assert!(at < 0.001);
        let count = Cell::new(0);
        let _ = peak(0.0, 1.0, 1e-12, 7, &|x| {
            count.set(count.get() + 1);
            (50.0 * x).sin() - (x * 7.0).fract()
        });
        assert_eq!(count.get(), 7);
        // NaN gives no information.
        assert!(peak(0.0, 1.0, 1e-6, 20, &|_| f64::NAN).0.is_finite());
        assert!((0.0..=1.0).contains(&peak(0.0, 1.0, 1e-6, 20, &|_| 1.0).0));
    }
}
