//! Means, standard deviations and quantiles. Of nothing they are `None`, never NaN.

/// The arithmetic mean.
pub fn mean(values: &[f64]) -> Option<f64> {
    if values.is_empty() { None } else { Some(values.iter().sum::<f64>() / values.len() as f64) }
}

/// The standard deviation with n − 1 in the denominator; `None` for fewer than two values.
pub fn std_ddof1(values: &[f64]) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let mean = mean(values)?;
    let sum_of_squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Some((sum_of_squares / (values.len() - 1) as f64).sqrt())
}

/// The quantile `q` ∈ \[0, 1\], linear between order statistics (numpy's default).
pub fn quantile(values: &[f64], q: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let position = q.clamp(0.0, 1.0) * sorted.len().checked_sub(1)? as f64;
    let (below, above) = (position.floor() as usize, position.ceil() as usize);
    Some(sorted[below] + (position - below as f64) * (sorted[above] - sorted[below]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_numpy() {
        // numpy.std([2, 4, 4, 4, 5, 5, 7, 9], ddof=1) and numpy.percentile(..., [50, 95])
        let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
        assert_eq!(mean(&values), Some(5.0));
        assert!((std_ddof1(&values).unwrap() - 2.138_089_935_299_395).abs() < 1e-15);
        assert_eq!(quantile(&values, 0.5), Some(4.5));
        assert!((quantile(&values, 0.95).unwrap() - 8.3).abs() < 1e-12);
    }

    #[test]
    fn says_nothing_about_too_few_values() {
        assert_eq!(mean(&[]), None);
        assert_eq!(std_ddof1(&[1.0]), None);
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(quantile(&[3.0], 0.99), Some(3.0));
    }
}
