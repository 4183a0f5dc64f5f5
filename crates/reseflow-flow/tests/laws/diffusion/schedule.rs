//! The squared-cosine schedule, the posterior's weights and the respaced levels.

use rand_distr::{Distribution, StandardNormal};
use reseflow_flow::{CosineSchedule, Diffusion, DiffusionConfig, DiffusionFrame, FlowError, respaced};

use crate::rng;

#[test]
fn the_schedule_is_the_squared_cosine_where_it_is_not_capped() {
    let schedule = CosineSchedule::new(100);
    let curve = |level: usize| {
        let tau = level as f64 / 100.0;
        ((tau + 0.008) / 1.008 * std::f64::consts::FRAC_PI_2).cos().powi(2)
    };
    assert_eq!((schedule.steps(), schedule.signal(0), schedule.noise(0)), (100, 1.0, 0.0));
    for level in 1..100 {
        let expected = curve(level) / curve(0);
        assert!((schedule.signal(level).powi(2) - expected).abs() < 1e-12, "level {level}");
        assert!(schedule.signal(level) < schedule.signal(level - 1));
    }
    // The curve ends at 0; the cap leaves a thousandth of what was there before.
    let last = schedule.signal(100).powi(2);
    assert!((last - 1e-3 * schedule.signal(99).powi(2)).abs() < 1e-15 && last > 0.0, "{last}");
    for level in 0..=100 {
        let sum = schedule.signal(level).powi(2) + schedule.noise(level).powi(2);
        assert!((sum - 1.0).abs() < 1e-12);
    }
}

/// λ₁ with √ᾱ_k where √α_k belongs is off by far from the first steps on.
#[test]
fn the_mean_of_the_posterior_stays_on_the_way_of_the_clean_value() {
    let schedule = CosineSchedule::new(100);
    for from in 1..=100 {
        for to in 0..from {
            let weights = schedule.posterior(from, to);
            let kept = weights.clean + weights.noisy * schedule.signal(from);
            assert!((kept - schedule.signal(to)).abs() < 1e-12, "from {from} to {to}: {kept}");
            assert!((0.0..=1.0).contains(&weights.clean) && weights.noisy >= 0.0 && weights.deviation >= 0.0);
        }
    }
    let mistaken = |from: usize| {
        let weights = schedule.posterior(from, from - 1);
        let alpha = (schedule.signal(from) / schedule.signal(from - 1)).powi(2);
        let noisy = weights.noisy / alpha.sqrt() * schedule.signal(from);
        (weights.clean + noisy * schedule.signal(from) - schedule.signal(from - 1)).abs()
    };
    assert!((2..=90).all(|from| mistaken(from) > 1e-4), "control: the published weight");
    assert!(mistaken(50) > 0.1, "{}", mistaken(50));
    assert_eq!(schedule.posterior(100, 0).noisy, 0.0, "a step to level 0 is the clean value alone");
    assert!((schedule.posterior(100, 0).clean - 1.0).abs() < 1e-12);
}

/// One variable, drawn from the forward process by its single steps: x_to given x_from and x_0 is regressed on both.
#[test]
fn the_posterior_is_that_of_the_process_drawn_step_by_step() {
    const COUNT: usize = 40_000;
    let schedule = CosineSchedule::new(20);
    let mut rng = rng(71);
    for (from, to) in [(2, 1), (10, 9), (14, 5)] {
        let alpha = (schedule.signal(from) / schedule.signal(to)).powi(2);
        // Normal equations of x_to = a x_0 + b x_from.
        let (mut cc, mut cn, mut nn, mut ct, mut nt) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let mut draws = Vec::with_capacity(COUNT);
        for _ in 0..COUNT {
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            let clean = normal();
            let target = schedule.signal(to) * clean + schedule.noise(to) * normal();
            let noisy = alpha.sqrt() * target + (1.0 - alpha).sqrt() * normal();
            cc += clean * clean;
            cn += clean * noisy;
            nn += noisy * noisy;
            ct += clean * target;
            nt += noisy * target;
            draws.push((clean, noisy, target));
        }
        let determinant = cc * nn - cn * cn;
        let (a, b) = ((ct * nn - nt * cn) / determinant, (nt * cc - ct * cn) / determinant);
        let rest: f64 = draws.iter().map(|(c, n, t)| (t - a * c - b * n).powi(2)).sum();
        let weights = schedule.posterior(from, to);
        // The least noisy direction decides the standard error of the coefficients.
        let error = 6.0 * weights.deviation * (cc.max(nn) / determinant).sqrt();
        assert!((a - weights.clean).abs() < error, "{from} to {to}: λ₀ {a}, {weights:?}, ± {error}");
        assert!((b - weights.noisy).abs() < error, "{from} to {to}: λ₁ {b}, {weights:?}, ± {error}");
        let deviation = (rest / COUNT as f64).sqrt();
        assert!((deviation / weights.deviation - 1.0).abs() < 6.0 / (2.0 * COUNT as f64).sqrt());
    }
}

#[test]
fn every_number_of_steps_starts_at_the_noise_and_ends_at_the_last_kernel() {
    assert_eq!(respaced(100, 1).unwrap(), [100]);
    assert_eq!(respaced(100, 2).unwrap(), [100, 1]);
    assert_eq!(respaced(100, 100).unwrap(), (1..=100).rev().collect::<Vec<_>>());
    for levels in [2, 7, 100] {
        for steps in 2..=levels {
            let visited = respaced(levels, steps).unwrap();
            assert_eq!((visited.len(), visited[0], visited[steps - 1]), (steps, levels, 1));
            let gaps: Vec<usize> = visited.windows(2).map(|pair| pair[0] - pair[1]).collect();
            let (least, most) = (gaps.iter().min().unwrap(), gaps.iter().max().unwrap());
            assert!(*least >= 1 && most - least <= 1, "{levels} levels, {steps} steps: {visited:?}");
        }
    }
    assert_eq!(respaced(100, 0), Err(FlowError::NoSteps));
    assert!(respaced(100, 101).unwrap_err().to_string().contains("got 101"));
}

#[test]
fn a_value_out_of_range_is_refused_by_its_key() {
    let good = DiffusionConfig::default();
    Diffusion::new(&good).unwrap();
    for (key, bad) in [
        ("steps", DiffusionConfig { steps: 1, ..good }),
        ("steps", DiffusionConfig { steps: 1_000_000, ..good }),
        ("sigma_rotation_rad", DiffusionConfig { sigma_rotation_rad: -0.1, ..good }),
        ("sigma_translation_m", DiffusionConfig { sigma_translation_m: f64::NAN, ..good }),
        ("sigma_opening", DiffusionConfig { sigma_opening: 2.0, ..good }),
    ] {
        let fault = Diffusion::new(&bad).unwrap_err().to_string();
        assert!(fault.contains(&format!("diffusion.{key}")), "{fault}");
    }
    let text = "steps = 50\nframe = \"world\"\nstochastic = true";
    let read: DiffusionConfig = toml::from_str(text).unwrap();
    assert_eq!((read.steps, read.frame, read.stochastic), (50, DiffusionFrame::World, true));
    assert!(toml::from_str::<DiffusionConfig>("step = 50").unwrap_err().to_string().contains("step"));
}
