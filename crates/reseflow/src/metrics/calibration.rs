//! Whether an uncertainty knows: the nodes' spread against the true error.
//!
//! Spearman's rank correlation (C. Spearman, *The proof and measurement of association between two things*, 1904) asks only that more
//! spread goes with more error; the bins show how much.

use serde::{Deserialize, Serialize};

use super::mean;

/// Bins of as many actions each.
const BINS: usize = 10;

/// How spread and error go together, over all actions of all samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Spearman's rank correlation, from −1 to 1.
    pub spearman: f64,
    /// Groups of equal numbers, from little spread to much.
    pub bins: Vec<CalibrationBin>,
}

/// A group of actions of about the same spread.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CalibrationBin {
    /// Actions.
    pub actions: usize,
    /// Their mean spread.
    pub spread: f64,
    /// Their mean D_geo to the truth.
    pub d_geo: f64,
}

impl Calibration {
    /// Of pairs of a spread and an error; `None` for fewer than two, or where all spreads or all errors are equal.
    pub fn of(pairs: &[(f64, f64)]) -> Option<Self> {
        let (spreads, errors): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
        let spearman = correlation(&ranks(&spreads), &ranks(&errors))?;
        let mut sorted = pairs.to_vec();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let bin = |bin: usize| {
            let members = &sorted[bin * pairs.len() / BINS..(bin + 1) * pairs.len() / BINS];
            let (spreads, errors): (Vec<f64>, Vec<f64>) = members.iter().copied().unzip();
            Some(CalibrationBin { actions: members.len(), spread: mean(&spreads)?, d_geo: mean(&errors)? })
        };
        Some(Self { spearman, bins: (0..BINS).filter_map(bin).collect() })
    }
}

/// The rank of each value from 0; equal ones share their mean rank.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for group in order.chunk_by(|a, b| values[*a] == values[*b]) {
        let shared = first as f64 + (group.len() - 1) as f64 / 2.0;
        group.iter().for_each(|place| ranks[*place] = shared);
        first += group.len();
    }
    ranks
}

/// Pearson's correlation; `None` where there is nothing to correlate.
fn correlation(a: &[f64], b: &[f64]) -> Option<f64> {
    let (mean_a, mean_b) = (mean(a)?, mean(b)?);
    let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        a.iter().zip(b).map(|(a, b)| f(a - mean_a, b - mean_b)).sum()
    };
    let scale = (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
    (scale > 0.0).then(|| sum(&|a, b| a * b) / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_scipy() {
        // scipy.stats.spearmanr([1, 2, 2, 4, 5, 9], [0.2, 0.1, 0.3, 0.3, 0.9, 0.5]).statistic
        let pairs = [(1.0, 0.2), (2.0, 0.1), (2.0, 0.3), (4.0, 0.3), (5.0, 0.9), (9.0, 0.5)];
        let expected = 0.808_823_529_411_764_7;
        assert!((Calibration::of(&pairs).unwrap().spearman - expected).abs() < 1e-12);
    }

    #[test]
    fn only_the_order_matters_and_the_bins_keep_everybody() {
        let pairs: Vec<(f64, f64)> = (0..95).map(f64::from).map(|x| (x, (0.1 * x).exp())).collect();
        let rising = Calibration::of(&pairs).unwrap();
        assert!((rising.spearman - 1.0).abs() < 1e-12);
        assert_eq!(rising.bins.iter().map(|bin| bin.actions).sum::<usize>(), 95);
        assert_eq!(rising.bins.len(), 10);
        assert!(rising.bins.windows(2).all(|pair| pair[0].spread < pair[1].spread));
        assert!(rising.bins.windows(2).all(|pair| pair[0].d_geo < pair[1].d_geo));
        let falling: Vec<(f64, f64)> = pairs.iter().map(|(spread, error)| (*spread, -error)).collect();
        assert!((Calibration::of(&falling).unwrap().spearman + 1.0).abs() < 1e-12);
    }

    #[test]
    fn of_equal_spreads_there_is_nothing_to_say() {
        assert_eq!(Calibration::of(&[(1.0, 0.1), (1.0, 0.4)]), None);
        assert_eq!(Calibration::of(&[]), None);
    }
}
