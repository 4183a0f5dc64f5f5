//! Flow times: the share at zero, the rest uniform, and which shares are none.

use reseflow_flow::{FlowError, TimeSampling, TimeShape};

use crate::rng;

const COUNT: usize = 20_000;

fn draws(zero_share: f64) -> Vec<f64> {
    shaped(TimeSampling { zero_share, shape: TimeShape::Uniform })
}

fn shaped(sampling: TimeSampling) -> Vec<f64> {
    let mut rng = rng(31);
    (0..COUNT).map(|_| sampling.sample(&mut rng)).collect()
}

/// Kolmogorov and Smirnov's statistic in units of 1/√n; beyond 2 with probability 2 exp(−8) ≈ 7e-4, and the stream is fixed.
fn off(mut times: Vec<f64>, distribution: impl Fn(f64) -> f64) -> f64 {
    times.sort_by(f64::total_cmp);
    let count = times.len() as f64;
    let statistic = times.iter().enumerate().map(|(index, time)| {
        let expected = distribution(*time);
        (expected - index as f64 / count).abs().max(((index + 1) as f64 / count - expected).abs())
    });
    statistic.fold(0.0, f64::max) * count.sqrt()
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
    let times: Vec<f64> = draws(0.3).into_iter().filter(|&time| time > 0.0).collect();
    assert!(times.iter().all(|time| (0.0..1.0).contains(time)));
    let statistic = off(times, |time| time);
    assert!(statistic < 2.0, "{statistic}");
}

#[test]
fn u_shaped_times_follow_their_density_and_keep_the_share_of_zeros() {
    let sampling = TimeSampling { zero_share: 0.25, shape: TimeShape::UShaped };
    assert_eq!(sampling.validate(), Ok(()));
    let all = shaped(sampling);
    let times: Vec<f64> = all.iter().copied().filter(|&time| time > 0.0).collect();
    let zeros = 1.0 - times.len() as f64 / COUNT as f64;
    assert!((zeros - 0.25).abs() < 5.0 * (0.25 * 0.75 / COUNT as f64).sqrt(), "{zeros}");
    assert!(times.iter().all(|time| (0.0..1.0).contains(time)));
    // The integral of (e^{4t} + e^{4(1−t)}) · 2/(e⁴ − 1).
    let distribution = |t: f64| 0.5 * (1.0 + ((4.0 * t).exp() - (4.0 - 4.0 * t).exp()) / 4.0_f64.exp_m1());
    assert!((distribution(0.0), distribution(0.5), distribution(1.0)) == (0.0, 0.5, 1.0));
    let statistic = off(times.clone(), distribution);
    assert!(statistic < 2.0, "{statistic}");
    assert!(off(times, |time| time) > 10.0, "control: uniform they are not");
}

#[test]
fn a_shape_that_is_never_drawn_from_is_refused() {
    let sampling = TimeSampling { zero_share: 1.0, shape: TimeShape::UShaped };
    let Err(FlowError::Config(text)) = sampling.validate() else { panic!("it is taken") };
    assert!(text.contains("time.shape") && text.contains("time.zero_share"), "{text}");
}

#[test]
fn what_is_no_share_is_refused() {
    for share in [0.0, 0.3, 1.0] {
        assert_eq!(TimeSampling { zero_share: share, shape: TimeShape::Uniform }.validate(), Ok(()));
    }
    for share in [-0.01, 1.01, f64::NAN, f64::INFINITY] {
        let Err(FlowError::Config(text)) =
            (TimeSampling { zero_share: share, ..TimeSampling::default() }).validate()
        else {
            panic!("{share} is taken")
        };
        assert!(text.contains("time.zero_share") && text.contains(&share.to_string()), "{text}");
    }
}
