//! f64: equivariance to rounding, gradients against finite differences, continuity across changes of neighbours.

#![expect(
    clippy::expect_used,
    clippy::print_stdout,
    reason = "clippy knows test functions, but not what they call"
)]

#[path = "../support/mod.rs"]
mod support;

mod continuity;
mod finite_differences;

use burn::tensor::FloatDType;
use support::{laws, messages};

/// The float type of this suite's tensors.
const FLOAT: FloatDType = FloatDType::F64;

#[test]
fn the_message_kernel_equals_its_composed_form() {
    messages::the_message_kernel_equals_its_composed_form(1e-13);
}

#[test]
fn every_layer_turns_with_the_world() {
    laws::every_layer_turns_with_the_world(1e-12);
}

#[test]
fn handed_layers_tell_a_scene_from_its_mirror_image() {
    laws::handed_layers_tell_a_scene_from_its_mirror_image(1e-12);
}

#[test]
fn a_world_constant_in_a_vector_channel_is_caught() {
    laws::a_world_constant_in_a_vector_channel_is_caught(1e-12);
}

#[test]
fn a_moved_scene_gives_a_moved_trajectory() {
    laws::a_moved_scene_gives_a_moved_trajectory(1e-9, 1e-9);
}

#[test]
fn a_scene_that_is_not_moved_rigidly_is_caught() {
    laws::a_scene_that_is_not_moved_rigidly_is_caught();
}

#[test]
fn the_order_of_the_points_does_not_matter() {
    laws::the_order_of_the_points_does_not_matter(1e-11);
}

#[test]
fn scenes_of_one_batch_do_not_see_each_other() {
    laws::scenes_of_one_batch_do_not_see_each_other(1e-11);
}

#[test]
fn degenerate_clouds_give_finite_trajectories_and_gradients() {
    laws::degenerate_clouds_give_finite_trajectories_and_gradients();
}

#[test]
fn every_parameter_receives_a_gradient() {
    laws::every_parameter_receives_a_gradient();
}

#[test]
fn the_suite_runs_in_its_float_type() {
    laws::the_suite_runs_in_its_float_type();
}
