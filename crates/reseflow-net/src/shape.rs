//! How forward passes refuse tensors of other shapes than their weights were drawn for: they panic, as burn's own modules do, and say
//! what was expected.

use std::fmt::{Debug, Display};

/// Panics where `got` is not what was `expected` of `what`.
#[track_caller]
pub(crate) fn must_be<T: PartialEq + Debug>(what: impl Display, expected: T, got: T) {
    assert!(got == expected, "{what}: expected {expected:?}, got {got:?}");
}
