//! Flow times: the share at zero, the rest uniform, and which shares are none.

use reseflow_flow::{FlowError, TimeSampling};

use crate::rng;

const COUNT: usize = 20_000;

fn draws(zero_share: f64) -> Vec<f64> {
    let mut rng = rng(31);
    (0..COUNT).map(|_| TimeSampling { zero_share }.sample(&mut rng)).collect()
}

#[test]
fn the_share_of_zeros_is_the_one_asked_for() {
    for share in [0.05, 0.3, 0.8] {
        let zeros = draws(share).iter().filter(|&&time| time == 0.0).count() as f64 / COUNT as f64;
        let five_deviations = 5.0 * (share * (1.0 - share) / COUNT as f64).sqrt();
        assert!((zeros - share).abs() < five_deviations, "{zeros} instead of {share}");
    }
}

#[test]
fn an_extreme_share_is_exact() {
    assert!(draws(1.0).iter().all(|&time| time == 0.0));
    assert!(draws(0.0).iter().filter(|&&time| time == 0.0).count() <= 1);
}

#[test]
fn the_other_times_are_uniform() {
    let mut times: Vec<f64> = draws(0.3).into_iter().filter(|&time| time > 0.0).collect();
    assert!(times.iter().all(|time| (0.0..1.0).contains(time)));
    times.sort_by(f64::total_cmp);
    // Kolmogorov–Smirnov: beyond 2/√n with probability 2 exp(−8) ≈ 7e-4, and the stream is fixed.
    let count = times.len() as f64;
    let statistic = times.iter().enumerate().map(|(index, time)| {
        (time - index as f64 / count).abs().max(((index + 1) as f64 / count - time).abs())
    });
    let statistic = statistic.fold(0.0, f64::max);
    assert!(statistic < 2.0 / count.sqrt(), "{statistic}");
}

#[test]
fn what_is_no_share_is_refused() {
    for share in [0.0, 0.3, 1.0] {
        assert_eq!(TimeSampling { zero_share: share }.validate(), Ok(()));
    }
    for share in [-0.01, 1.01, f64::NAN, f64::INFINITY] {
        let Err(FlowError::Config(text)) = (TimeSampling { zero_share: share }).validate() else {
            panic!("{share} is taken")
        };
        assert!(text.contains("time.zero_share") && text.contains(&share.to_string()), "{text}");
    }
}
