//! The drift model, its training loop, checkpoints and the policies that they become.
