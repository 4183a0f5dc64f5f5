//! Configuration: strict TOML files and overrides on the command line.

mod nearest;
mod overrides;
mod strict;

pub use nearest::nearest;
pub use overrides::Override;
pub use strict::{load, parse};
