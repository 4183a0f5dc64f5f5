//! Checks on arrays, each with one sentence that names the array, the index and what was expected.

use crate::npz::Array;

/// How far an opening may lie outside \[0, 1\].
const OPENING_TOLERANCE: f32 = 1e-3;

/// One axis of an array's expected shape.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Axis {
    /// An axis that several arrays share: its letter and its extent in the first of them.
    Shared(&'static str, usize),
    /// An axis of fixed extent.
    Fixed(usize),
}

impl Axis {
    fn extent(self) -> usize {
        match self {
            Axis::Shared(_, extent) | Axis::Fixed(extent) => extent,
        }
    }
}

/// The extents E, T, N … of the array that sets them: its leading axes are `letters`, its trailing ones `fixed`.
pub(crate) fn leading_extents<T, const LETTERS: usize>(
    name: &str,
    array: &Array<T>,
    letters: [&str; LETTERS],
    fixed: &[usize],
) -> Result<[usize; LETTERS], String> {
    let shape = &array.shape;
    if shape.len() != LETTERS + fixed.len() || shape[LETTERS..] != *fixed {
        let letters = letters.iter().map(|letter| (*letter).to_owned());
        let expected: Vec<String> = letters.chain(fixed.iter().map(usize::to_string)).collect();
        return Err(format!("`{name}` has shape {shape:?}, expected [{}]", expected.join(", ")));
    }
    let mut extents = [0; LETTERS];
    extents.copy_from_slice(&shape[..LETTERS]);
    match extents.iter().position(|&extent| extent == 0) {
        Some(empty) => {
            Err(format!("`{name}` has shape {shape:?}, expected at least 1 for {}", letters[empty]))
        }
        None => Ok(extents),
    }
}

/// Whether an array has the shape that follows from the array `reference`.
pub(crate) fn check_shape<T>(
    name: &str,
    array: &Array<T>,
    expected: &[Axis],
    reference: &str,
) -> Result<(), String> {
    let extents: Vec<usize> = expected.iter().map(|axis| axis.extent()).collect();
    if array.shape == extents {
        return Ok(());
    }
    let fault = format!("`{name}` has shape {:?}, expected {extents:?}", array.shape);
    if array.shape.len() != extents.len() {
        return Err(fault);
    }
    let differing = expected.iter().zip(&array.shape).find(|(axis, got)| axis.extent() != **got);
    Err(match differing {
        Some((Axis::Shared(letter, extent), got)) => {
            format!("{fault}: {letter} is {got} here and {extent} in `{reference}`")
        }
        _ => fault,
    })
}

/// Whether every number is finite.
pub(crate) fn check_finite(name: &str, array: &Array<f32>) -> Result<(), String> {
    match array.data.iter().position(|number| !number.is_finite()) {
        None => Ok(()),
        Some(at) => {
            let index = describe_index(&array.shape, at);
            Err(format!("`{name}`{index} is {}, expected a finite number", array.data[at]))
        }
    }
}

/// Whether every number is an opening.
pub(crate) fn check_openings(name: &str, array: &Array<f32>) -> Result<(), String> {
    check_finite(name, array)?;
    let allowed = -OPENING_TOLERANCE..=1.0 + OPENING_TOLERANCE;
    match array.data.iter().position(|opening| !allowed.contains(opening)) {
        None => Ok(()),
        Some(at) => {
            let index = describe_index(&array.shape, at);
            Err(format!(
                "`{name}`{index} is {}, expected an opening from 0 (closed) to 1 (open)",
                array.data[at]
            ))
        }
    }
}

/// The index, such as `[3, 0, 17]`, of the element at flat position `at`.
pub(crate) fn describe_index(shape: &[usize], mut at: usize) -> String {
    let mut index = vec![0; shape.len()];
    for (slot, &extent) in index.iter_mut().zip(shape).rev() {
        *slot = at % extent.max(1);
        at /= extent.max(1);
    }
    format!("{index:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_positions_become_indices() {
        assert_eq!(describe_index(&[2, 3, 4], 0), "[0, 0, 0]");
        assert_eq!(describe_index(&[2, 3, 4], 12 + 2 * 4 + 3), "[1, 2, 3]");
        assert_eq!(describe_index(&[], 0), "[]");
    }

    #[test]
    fn openings_have_a_little_slack() {
        let openings = |values: &[f32]| Array { shape: vec![values.len()], data: values.to_vec() };
        assert_eq!(check_openings("o", &openings(&[0.0, 1.0, -0.0009, 1.0009])), Ok(()));
        let fault = check_openings("o", &openings(&[0.5, 1.1])).unwrap_err();
        assert_eq!(fault, "`o`[1] is 1.1, expected an opening from 0 (closed) to 1 (open)");
    }
}
