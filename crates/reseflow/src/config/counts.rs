//! Counts that a configuration may ask for, and lists that say everything once.

/// The largest of them; more is a slip of the keyboard.
const LARGEST_COUNT: usize = 1_000_000;

/// Checks that each value is at least 1 and not absurd.
///
/// # Errors
/// A sentence that names the first key that is not.
pub(super) fn check_counts(counts: &[(&str, usize)]) -> Result<(), String> {
    for (key, value) in counts {
        if *value == 0 {
            return Err(format!("`{key}` is 0, expected 1 or more"));
        }
        if *value > LARGEST_COUNT {
            return Err(format!("`{key}` is {value}, expected at most {LARGEST_COUNT}"));
        }
    }
    Ok(())
}

/// The first value of a list that stands in it before.
pub(super) fn first_repeated<T: PartialEq>(values: &[T]) -> Option<&T> {
    let before = |(place, value): &(usize, &T)| values[..*place].contains(value);
    values.iter().enumerate().find(before).map(|(_, value)| value)
}
