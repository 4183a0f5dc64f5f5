//! Wilson's score interval for a success rate (E. B. Wilson, *Probable inference, the law of succession, and statistical
//! inference*, 1927): sensible even for no failure at all, where the usual ± interval has no width.

use super::Interval;

/// The 97.5 % quantile of the standard normal distribution.
const Z: f64 = 1.959_963_984_540_054;

/// The 95 % interval for the rate behind `successes` of `trials`; \[0, 1\] for no trial.
pub fn wilson_interval(successes: usize, trials: usize) -> Interval {
    if trials == 0 {
        return Interval { low: 0.0, high: 1.0 };
    }
    let n = trials as f64;
    let rate = successes as f64 / n;
    let centre = rate + Z * Z / (2.0 * n);
    let half_width = Z * (rate * (1.0 - rate) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    // Exact at the ends, where rounding would leave a residue.
    let low = if successes == 0 { 0.0 } else { (centre - half_width) / scale };
    let high = if successes == trials { 1.0 } else { (centre + half_width) / scale };
    Interval { low, high }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What defines the interval: at its ends the score test is on the edge, (p̂ − p)² n = z² p (1 − p).
    #[test]
    fn its_ends_solve_the_score_equation() {
        for (successes, trials) in [(0, 10), (5, 10), (10, 10), (45, 50), (198, 200), (1, 3)] {
            let interval = wilson_interval(successes, trials);
            let (n, rate) = (trials as f64, successes as f64 / trials as f64);
            for end in [interval.low, interval.high] {
                let edge = (rate - end).powi(2) * n - Z * Z * end * (1.0 - end);
                assert!(edge.abs() < 1e-12, "{successes}/{trials}: {interval:?} leaves {edge}");
            }
            assert!(interval.low <= rate && rate <= interval.high && interval.low < interval.high);
        }
    }

    #[test]
    fn agrees_with_published_values() {
        let interval = wilson_interval(5, 10);
        assert!(
            (interval.low - 0.2366).abs() < 5e-5 && (interval.high - 0.7634).abs() < 5e-5,
            "{interval:?}"
        );
        assert!((wilson_interval(0, 10).high - 0.2775).abs() < 5e-5);
    }

    #[test]
    fn knows_nothing_without_a_trial() {
        assert_eq!(wilson_interval(0, 0), Interval { low: 0.0, high: 1.0 });
    }
}
