//! Butcher tableaus of explicit Runge–Kutta schemes. Hairer, Nørsett and Wanner, *Solving Ordinary Differential Equations I*,
//! tables II.1.1, II.1.2 and II.5.2.

/// Coefficients of a scheme with s stages.
pub(crate) struct Tableau {
    /// Row i: how much of each earlier stage's velocity leads to stage i + 1; s − 1 rows.
    pub(crate) stages: &'static [&'static [f64]],
    /// When each stage is asked, as a share of the step.
    pub(crate) times: &'static [f64],
    /// How much of each stage's velocity makes the step.
    pub(crate) step: &'static [f64],
    /// The step less that of the embedded scheme; empty where there is none.
    pub(crate) error: &'static [f64],
}

/// Order 1.
pub(crate) const EULER: Tableau = Tableau { stages: &[], times: &[0.0], step: &[1.0], error: &[] };

/// Order 2.
pub(crate) const MIDPOINT: Tableau =
    Tableau { stages: &[&[0.5]], times: &[0.0, 0.5], step: &[0.0, 1.0], error: &[] };

/// Order 2.
pub(crate) const HEUN: Tableau =
    Tableau { stages: &[&[1.0]], times: &[0.0, 1.0], step: &[0.5, 0.5], error: &[] };

/// Order 4.
pub(crate) const RK4: Tableau = Tableau {
    stages: &[&[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0]],
    times: &[0.0, 0.5, 0.5, 1.0],
    step: &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
    error: &[],
};

/// Order 5 with an embedded order 4; the last stage is the first of the next step (Dormand and Prince, 1980).
pub(crate) const DORMAND_PRINCE: Tableau = Tableau {
    stages: &[
        &[1.0 / 5.0],
        &[3.0 / 40.0, 9.0 / 40.0],
        &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
        &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
        &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
        &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
    ],
    times: &[0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0],
    step: &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0, 0.0],
    error: &[
        71.0 / 57600.0,
        0.0,
        -71.0 / 16695.0,
        71.0 / 1920.0,
        -17253.0 / 339200.0,
        22.0 / 525.0,
        -1.0 / 40.0,
    ],
};

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ wᵢ cᵢⁿ against 1/(n + 1), and row sums against the times.
    fn check(tableau: &Tableau, order: i32) {
        let close = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-14, "{found} {wanted}");
        for (row, time) in tableau.stages.iter().zip(&tableau.times[1..]) {
            close(row.iter().sum(), *time);
        }
        for power in 0..order {
            let moment = |weights: &[f64]| -> f64 {
                weights.iter().zip(tableau.times).map(|(weight, time)| weight * time.powi(power)).sum()
            };
            close(moment(tableau.step), 1.0 / f64::from(power + 1));
            // Both schemes integrate powers below the embedded order 4 exactly.
            if power < 4 {
                close(moment(tableau.error), 0.0);
            }
        }
    }

    #[test]
    fn each_tableau_integrates_powers_of_time_exactly_up_to_its_order() {
        check(&EULER, 1);
        check(&MIDPOINT, 2);
        check(&HEUN, 2);
        check(&RK4, 4);
        check(&DORMAND_PRINCE, 5);
    }
}
