//! Paired differences: two things measured on the same episodes, and how sure their difference is.

use serde::{Deserialize, Serialize};

use super::bootstrap::bootstrap_interval;
use super::mean;

/// The difference of two means over the same episodes, with 95 % bootstrap intervals over episodes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PairedDifference {
    /// Episodes that both have.
    pub episodes: usize,
    /// Mean of the values minus that of the reference.
    pub difference: f64,
    /// The lower end of its interval.
    pub low: f64,
    /// The upper end.
    pub high: f64,
    /// The difference as a share of the reference's mean.
    pub relative: f64,
    /// The lower end of its interval.
    pub relative_low: f64,
    /// The upper end.
    pub relative_high: f64,
}

impl PairedDifference {
    /// Of the first episodes, as many as both have; `None` for fewer than two, or where the reference's mean is 0.
    pub fn between(values: &[f64], reference: &[f64]) -> Option<Self> {
        let pairs: Vec<(f64, f64)> = values.iter().copied().zip(reference.iter().copied()).collect();
        let difference = |pairs: &[(f64, f64)]| mean_of(pairs, |(a, b)| a - b);
        let relative = |pairs: &[(f64, f64)]| Some(difference(pairs)? / mean_of(pairs, |(_, b)| b)?);
        let finite = relative(&pairs).filter(|relative| relative.is_finite())?;
        let (absolute, share) =
            (bootstrap_interval(&pairs, difference)?, bootstrap_interval(&pairs, relative)?);
        Some(Self {
            episodes: pairs.len(),
            difference: difference(&pairs)?,
            low: absolute.low,
            high: absolute.high,
            relative: finite,
            relative_low: share.low,
            relative_high: share.high,
        })
    }
}

fn mean_of(pairs: &[(f64, f64)], value: impl Fn((f64, f64)) -> f64) -> Option<f64> {
    mean(&pairs.iter().map(|pair| value(*pair)).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_varies_between_episodes_alike_does_not_blur_the_difference() {
        let reference: Vec<f64> = (0..50).map(|i| 0.1 + (f64::from(i) * 0.618_034).fract()).collect();
        let values: Vec<f64> = reference.iter().map(|value| value + 0.01).collect();
        let paired = PairedDifference::between(&values, &reference).unwrap();
        assert!((paired.difference - 0.01).abs() < 1e-12);
        assert!(paired.high - paired.low < 1e-12, "each pair differs by the same: {paired:?}");
        let share = 0.01 / mean(&reference).unwrap();
        assert!((paired.relative - share).abs() < 1e-12);
        assert!(paired.relative_low < share && share < paired.relative_high, "{paired:?}");
        let twice: Vec<f64> = reference.iter().map(|value| 2.0 * value).collect();
        let paired = PairedDifference::between(&twice, &reference).unwrap();
        assert!((paired.relative - 1.0).abs() < 1e-12);
        assert!(paired.relative_high - paired.relative_low < 1e-9, "a ratio of the same in every episode");
        assert!(paired.low < paired.difference && paired.difference < paired.high);
    }

    #[test]
    fn the_shorter_series_counts_and_too_little_is_no_answer() {
        let paired = PairedDifference::between(&[1.0, 2.0], &[1.0, 1.0, 50.0]).unwrap();
        assert_eq!((paired.episodes, paired.difference), (2, 0.5));
        assert_eq!(PairedDifference::between(&[1.0], &[1.0]), None);
        assert_eq!(PairedDifference::between(&[1.0, 1.0], &[0.0, 0.0]), None);
    }
}
