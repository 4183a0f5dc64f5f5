//! f32: the same laws to f32 rounding, on clouds as a data set stores them too; checkpoints; what is refused.

#![expect(
    clippy::expect_used,
    clippy::print_stdout,
    reason = "clippy knows test functions, but not what they call"
)]

#[path = "../support/mod.rs"]
mod support;

mod checkpoint;
mod degree_checkpoint;
mod layer_checkpoint;
mod mani_loss;
mod numbers;
mod pointer;
mod refusals;
mod shapes;

use burn::tensor::FloatDType;
use reseflow_net::DriftNetConfig;
use support::scene::{Cloud, Scene};
use support::{
    assert_small, degenerate, degree_laws, devices, edge_messages, fading, laws, messages, plain, statistics,
    twists, views,
};

/// The float type of this suite's tensors.
const FLOAT: FloatDType = FloatDType::F32;

#[test]
fn the_message_kernel_equals_its_composed_form() {
    messages::the_message_kernel_equals_its_composed_form(1e-5);
}

#[test]
fn every_layer_turns_with_the_world() {
    laws::every_layer_turns_with_the_world(1e-5);
}

#[test]
fn handed_layers_tell_a_scene_from_its_mirror_image() {
    laws::handed_layers_tell_a_scene_from_its_mirror_image(1e-5);
}

#[test]
fn a_world_constant_in_a_vector_channel_is_caught() {
    laws::a_world_constant_in_a_vector_channel_is_caught(1e-5);
}

#[test]
fn a_moved_scene_gives_a_moved_trajectory() {
    laws::a_moved_scene_gives_a_moved_trajectory(1e-5);
}

#[test]
fn a_scene_stored_in_f32_gives_a_moved_trajectory() {
    let stored = |cloud: &Cloud| Cloud {
        points: cloud.points.iter().map(|point| point.map(|value| f64::from(value as f32))).collect(),
        colors: cloud.colors.clone(),
    };
    let store = |scene: Scene| Scene { clouds: scene.clouds.iter().map(stored).collect(), ..scene };
    for (name, device) in devices() {
        let worst = laws::net_deviation(&device, &DriftNetConfig::default(), 24, store);
        assert_small(&format!("{name} stored in f32, positions, m"), worst.position_m, 1e-5);
        assert_small(&format!("{name} stored in f32, rotations"), worst.rotation, 1e-5);
    }
}

#[test]
fn a_trained_network_turns_with_the_world_on_graphs_built_again() {
    statistics::a_trained_network_turns_with_the_world_on_graphs_built_again([1e-5, 1e-5]);
}

#[test]
fn a_scene_that_is_not_moved_rigidly_is_caught() {
    laws::a_scene_that_is_not_moved_rigidly_is_caught();
}

#[test]
fn the_order_of_the_points_does_not_matter() {
    laws::the_order_of_the_points_does_not_matter(1e-5);
}

#[test]
fn scenes_of_one_batch_do_not_see_each_other() {
    laws::scenes_of_one_batch_do_not_see_each_other(1e-5);
}

#[test]
fn degenerate_clouds_give_finite_trajectories_and_gradients() {
    degenerate::degenerate_clouds_give_finite_trajectories_and_gradients();
}

#[test]
fn the_grasp_is_told_to_those_who_ask() {
    laws::the_grasp_is_told_to_those_who_ask();
}

#[test]
fn every_parameter_receives_a_gradient() {
    laws::every_parameter_receives_a_gradient();
}

#[test]
fn the_suite_runs_in_its_float_type() {
    laws::the_suite_runs_in_its_float_type();
}

#[test]
fn the_product_in_the_edges_frame_is_the_sum_over_paths() {
    degree_laws::the_product_in_the_edges_frame_is_the_sum_over_paths(1e-5);
}

#[test]
fn the_product_is_that_of_e3nn() {
    degree_laws::the_product_is_that_of_e3nn(1e-5);
}

#[test]
fn a_world_constant_in_a_higher_degree_is_caught() {
    degree_laws::a_world_constant_in_a_higher_degree_is_caught(1e-5);
}

#[test]
fn nodes_see_neither_the_order_of_points_nor_other_scenes() {
    degree_laws::nodes_see_neither_the_order_of_points_nor_other_scenes(1e-5);
}

#[test]
fn degenerate_clouds_give_finite_nodes_and_gradients() {
    degenerate::degenerate_clouds_give_finite_nodes_and_gradients();
}

#[test]
fn every_parameter_of_mani_net_receives_a_gradient() {
    degree_laws::every_parameter_of_mani_net_receives_a_gradient();
}

#[test]
fn poses_of_nodes_turn_with_the_world() {
    degree_laws::poses_of_nodes_turn_with_the_world(1e-5);
}

#[test]
fn a_moved_scene_gives_the_same_body_twists() {
    twists::a_moved_scene_gives_the_same_body_twists(1e-5);
}

#[test]
fn body_twists_of_another_scene_are_others() {
    twists::body_twists_of_another_scene_are_others();
}

#[test]
fn the_consensus_twist_is_the_weighted_mean_of_the_nodes() {
    twists::the_consensus_twist_is_the_weighted_mean_of_the_nodes(1e-5);
}

#[test]
fn twists_are_read_in_the_frame_of_the_noisy_pose() {
    twists::twists_are_read_in_the_frame_of_the_noisy_pose(1e-4);
}

#[test]
fn every_parameter_of_the_twist_form_receives_a_gradient() {
    twists::every_parameter_of_the_twist_form_receives_a_gradient();
}

#[test]
fn degenerate_clouds_give_a_finite_transformer() {
    degenerate::degenerate_clouds_give_a_finite_transformer();
}

#[test]
fn a_scene_ten_metres_away_gives_the_same_trajectory() {
    degenerate::a_scene_ten_metres_away_gives_the_same_trajectory(1e-3);
}

#[test]
fn a_wide_scene_far_away_gives_a_moved_trajectory() {
    degenerate::a_wide_scene_far_away_gives_a_moved_trajectory(1e-5);
}

#[test]
fn what_attention_gathers_fades_with_all_neighbours() {
    fading::what_attention_gathers_fades_with_all_neighbours(1e-5);
}

#[test]
fn the_edge_messages_equal_their_composed_form() {
    edge_messages::the_edge_messages_equal_their_composed_form(1e-5);
}

#[test]
fn silu_is_x_over_one_plus_exp_of_minus_x() {
    edge_messages::silu_is_x_over_one_plus_exp_of_minus_x(3e-7);
}

#[test]
fn messages_do_not_depend_on_how_their_inputs_lie() {
    views::messages_do_not_depend_on_how_their_inputs_lie(1e-5);
}

#[test]
fn edge_messages_do_not_depend_on_how_their_inputs_lie() {
    views::edge_messages_do_not_depend_on_how_their_inputs_lie(1e-5);
}

#[test]
fn silu_does_not_depend_on_how_its_input_lies() {
    views::silu_does_not_depend_on_how_its_input_lies(1e-6);
}

#[test]
fn a_plain_network_turns_with_no_world_and_shifts_with_none() {
    plain::a_plain_network_turns_with_no_world_and_shifts_with_none();
}

#[test]
fn an_upright_network_moves_with_the_world_until_it_is_tilted() {
    plain::an_upright_network_moves_with_the_world_until_it_is_tilted(1e-5);
}

#[test]
fn a_plain_network_that_looks_away_from_the_world_turns_with_it() {
    plain::a_plain_network_that_looks_away_from_the_world_turns_with_it(1e-5);
}
