//! Numbers on the command line.

/// The largest number of episodes, steps or seeds that a call may ask for; more is a slip of the keyboard.
const LARGEST_COUNT: usize = 1_000_000;

pub(super) fn positive(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(0) | Err(_) => Err("expected a whole number, 1 or more".to_owned()),
        Ok(value) if value > LARGEST_COUNT => Err(format!("expected at most {LARGEST_COUNT}")),
        Ok(value) => Ok(value),
    }
}

pub(super) fn above_zero(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| "expected a number greater than 0".to_owned())
}

pub(super) fn share(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| (0.0..=1.0).contains(value));
    value.ok_or_else(|| "expected a share from 0 to 1".to_owned())
}
