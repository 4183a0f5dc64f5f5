//! How much of the data is left at each noise level: the squared-cosine schedule (Nichol and Dhariwal, arXiv 2102.09672), capped.

use std::f64::consts::FRAC_PI_2;

/// Keeps the first noise level from being almost nothing.
const OFFSET: f64 = 0.008;

/// The largest β_k: without it the last level would hold no data at all, and the first reverse step would divide by nothing.
const LARGEST_BETA: f64 = 0.999;

/// ᾱ_0 = 1 to ᾱ_K: with ᾱ(τ) = cos²((τ + 0.008)/1.008 · π/2), β_k = min(1 − ᾱ(k/K)/ᾱ((k − 1)/K), 0.999) and
/// ᾱ_k = Π (1 − β_i).
#[derive(Debug, Clone, PartialEq)]
pub struct CosineSchedule {
    alpha_bar: Vec<f64>,
}

/// The posterior of x_j where x_k and x_0 are known, j < k, in units of the levels' own noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PosteriorWeights {
    /// λ₀, of the clean value.
    pub clean: f64,
    /// λ₁, of the noisy value.
    pub noisy: f64,
    /// The standard deviation over γ.
    pub deviation: f64,
}

impl CosineSchedule {
    /// The schedule of `steps` noise levels K.
    pub fn new(steps: usize) -> Self {
        let curve = |step: usize| {
            let tau = step as f64 / steps as f64;
            ((tau + OFFSET) / (1.0 + OFFSET) * FRAC_PI_2).cos().powi(2)
        };
        let mut alpha_bar = vec![1.0];
        let mut product = 1.0;
        for step in 1..=steps {
            let beta = (1.0 - curve(step) / curve(step - 1)).min(LARGEST_BETA);
            product *= 1.0 - beta;
            alpha_bar.push(product);
        }
        Self { alpha_bar }
    }

    /// Noise levels K.
    pub fn steps(&self) -> usize {
        self.alpha_bar.len() - 1
    }

    /// √ᾱ_k: the share of the clean value at level `step`, 0 to K.
    ///
    /// # Panics
    /// Where there is no such level.
    pub fn signal(&self, step: usize) -> f64 {
        self.alpha_bar[step].sqrt()
    }

    /// √(1 − ᾱ_k): the noise at level `step` over γ.
    ///
    /// # Panics
    /// Where there is no such level.
    pub fn noise(&self, step: usize) -> f64 {
        (1.0 - self.alpha_bar[step]).sqrt()
    }

    /// The weights of the step from level `from` down to level `to`, with α = ᾱ_from/ᾱ_to:
    /// λ₀ = √ᾱ_to (1 − α)/(1 − ᾱ_from), λ₁ = √α (1 − ᾱ_to)/(1 − ᾱ_from), σ² = (1 − α)(1 − ᾱ_to)/(1 − ᾱ_from).
    ///
    /// For neighbouring levels this is the posterior of DDPM (arXiv 2006.11239, eq. 7); with λ₀ + λ₁ √ᾱ_from = √ᾱ_to the mean keeps to
    /// the forward process's.
    ///
    /// # Panics
    /// Where `from` is not above `to`, or there is no such level.
    pub fn posterior(&self, from: usize, to: usize) -> PosteriorWeights {
        assert!(to < from, "a reverse step goes to less noise, not from level {from} to {to}");
        let (noisy, less_noisy) = (self.alpha_bar[from], self.alpha_bar[to]);
        let alpha = noisy / less_noisy;
        let (left, all) = (1.0 - less_noisy, 1.0 - noisy);
        PosteriorWeights {
            clean: less_noisy.sqrt() * (1.0 - alpha) / all,
            noisy: alpha.sqrt() * left / all,
            deviation: ((1.0 - alpha) * left / all).sqrt(),
        }
    }
}
