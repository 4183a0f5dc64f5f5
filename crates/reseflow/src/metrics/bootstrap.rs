//! Percentile bootstrap (Efron, *Bootstrap methods: another look at the jackknife*, 1979) of a statistic over episodes.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::{Interval, mean, quantile};

const RESAMPLES: usize = 2000;

/// The 95 % interval of `statistic` over `values`, resampled with a fixed seed so that a report repeats itself; `None` for fewer than
/// two values, or where a resample has no such statistic.
pub(super) fn bootstrap_interval<T: Copy>(
    values: &[T],
    statistic: impl Fn(&[T]) -> Option<f64>,
) -> Option<Interval> {
    if values.len() < 2 {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(3407);
    let mut resample = Vec::with_capacity(values.len());
    let mut found = Vec::with_capacity(RESAMPLES);
    for _ in 0..RESAMPLES {
        resample.clear();
        resample.extend((0..values.len()).map(|_| values[rng.random_range(0..values.len())]));
        found.push(statistic(&resample)?);
    }
    Some(Interval { low: quantile(&found, 0.025)?, high: quantile(&found, 0.975)? })
}

/// The 95 % interval of the mean of `values`; `None` for fewer than two.
pub fn bootstrap_mean_interval(values: &[f64]) -> Option<Interval> {
    bootstrap_interval(values, mean)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::std_ddof1;

    /// For many values the interval is the normal one: mean ± 1.96 standard errors.
    #[test]
    fn approaches_the_normal_interval() {
        let values: Vec<f64> = (0..400).map(|i| (i as f64 * 0.618_034).fract()).collect();
        let interval = bootstrap_mean_interval(&values).unwrap();
        let half_width = 1.96 * std_ddof1(&values).unwrap() / 20.0;
        assert!((interval.high - interval.low - 2.0 * half_width).abs() < 0.15 * half_width, "{interval:?}");
        let centre = 0.5 * (interval.high + interval.low);
        assert!((centre - mean(&values).unwrap()).abs() < 0.1 * half_width, "{interval:?}");
        assert_eq!(bootstrap_mean_interval(&values), Some(interval));
    }

    #[test]
    fn of_equal_values_it_has_no_width() {
        assert_eq!(bootstrap_mean_interval(&[2.0; 7]), Some(Interval { low: 2.0, high: 2.0 }));
        assert_eq!(bootstrap_mean_interval(&[2.0]), None);
    }
}
