//! The `reseflow` command.
fn main() {}
