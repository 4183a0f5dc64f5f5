//! The network that is not equivariant, which must fail the laws of the other, and by nothing but what it is told of the world; and the
//! one that is told the vertical alone, and must fail only those about tilts.

use burn::module::{Module, ModuleMapper, Param};
use burn::tensor::{Device, Tensor};
use rand::RngExt;
use reseflow_lie::{SO3, Vector3};
use reseflow_net::{DriftNet, DriftNetConfig, Symmetry};

use super::laws::example;
use super::trajectory::{Deviation, predict_one};
use super::weights::{drawn_net, shaken_net};
use super::world::World;
use super::{assert_caught, assert_small, devices, rng, small, tensor, values};

/// How far off a control must be to count as caught.
const CAUGHT: f64 = 1e-2;

/// The same of positions: a head whose weights are drawn and not trained moves them by centimetres at most.
const CAUGHT_M: f64 = 2e-3;

/// `config` without its symmetry.
pub(crate) fn plain(config: DriftNetConfig) -> DriftNetConfig {
    DriftNetConfig { symmetry: Symmetry::None, ..config }
}

/// `config` with the vertical.
pub(crate) fn upright(config: DriftNetConfig) -> DriftNetConfig {
    DriftNetConfig { symmetry: Symmetry::Upright, ..config }
}

fn deviation(net: &DriftNet, index: u64, world: &World, device: &Device) -> Deviation {
    let scene = example(index, net.config());
    let still = predict_one(net, &scene, device);
    still.deviation(&predict_one(net, &scene.moved(world), device), world)
}

pub(crate) fn a_plain_network_turns_with_no_world_and_shifts_with_none() {
    for (name, device) in devices() {
        for index in 0..6 {
            let mut rng = rng(15_000 + index);
            let config = plain(if index < 2 { DriftNetConfig::default() } else { small() });
            let drawn = drawn_net(&config, &device, &mut rng);
            let moved = shaken_net(&config, &device, &mut rng);
            let World { turn, shift } = World::rigid(&mut rng);
            let turned = World { turn, shift: Vector3::zeros() };
            let shifted = World { shift, ..World::identity() };
            for (state, net) in [("drawn", &drawn), ("moved", &moved)] {
                for (what, world) in [("turned", &turned), ("shifted", &shifted)] {
                    let found = deviation(net, index, world, &device);
                    let what = format!("{name} plain network, {state} weights, {what}");
                    assert_caught(&format!("{what}, positions"), found.position_m, CAUGHT_M);
                    assert_caught(&format!("{what}, rotations"), found.rotation, CAUGHT);
                }
            }
        }
    }
}

pub(crate) fn an_upright_network_moves_with_the_world_until_it_is_tilted(tolerance: f64) {
    for (name, device) in devices() {
        for index in 0..6 {
            let mut rng = rng(15_200 + index);
            let config = upright(if index < 2 { DriftNetConfig::default() } else { small() });
            let net = shaken_net(&config, &device, &mut rng);
            let moved = |axis: Vector3<f64>, angle: f64, shift: Vector3<f64>| World {
                turn: SO3::exp(&(axis * angle)).matrix(),
                shift,
            };
            let level = moved(Vector3::z(), rng.random_range(-3.0..3.0), World::rigid(&mut rng).shift);
            let tilted = moved(Vector3::x(), rng.random_range(0.3..1.5), Vector3::zeros());
            let found = deviation(&net, index, &level, &device).largest();
            assert_small(&format!("{name} upright network, level"), found, tolerance);
            for eyes in [&EYES[..1], &EYES[1..]] {
                let found = deviation(&blindfolded(&net, eyes, 1), index, &tilted, &device).rotation;
                assert_caught(&format!("{name} upright network, tilted, without {eyes:?}"), found, CAUGHT);
            }
            let found = deviation(&blindfolded(&net, &EYES, 1), index, &tilted, &device).largest();
            assert_small(&format!("{name} upright network, looking away"), found, tolerance);
        }
    }
}

/// Where the world's vectors enter, as the last ones: at the centres and at the tokens.
const EYES: [&str; 2] = ["encoder.place_vectors.weight", "decoder.vector_input.weight"];

/// `net` with zeros for the weights by which the world's vectors enter at `eyes`.
fn blindfolded(net: &DriftNet, eyes: &[&str], vectors: usize) -> DriftNet {
    let mut blindfold = Blindfold { eyes, vectors, path: Vec::new(), found: 0 };
    let blind = net.clone().map(&mut blindfold);
    assert_eq!(blindfold.found, eyes.len(), "{eyes:?}");
    blind
}

struct Blindfold<'a> {
    eyes: &'a [&'a str],
    vectors: usize,
    path: Vec<String>,
    found: usize,
}

impl ModuleMapper for Blindfold<'_> {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        if !self.eyes.contains(&self.path.join(".").as_str()) {
            return param;
        }
        self.found += 1;
        param.map(|weights| {
            let shape = weights.dims();
            let mut kept = values(&weights);
            let of_the_world = self.vectors * shape[D - 1];
            let relative = kept.len() - of_the_world;
            kept[relative..].fill(0.0);
            tensor(kept, shape, &weights.device())
        })
    }

    fn enter_module(&mut self, name: &str, _: &str) {
        self.path.push(name.to_owned());
    }

    fn exit_module(&mut self, _: &str, _: &str) {
        self.path.pop();
    }
}

pub(crate) fn a_plain_network_that_looks_away_from_the_world_turns_with_it(tolerance: f64) {
    for (name, device) in devices() {
        for index in 0..6 {
            let mut rng = rng(15_100 + index);
            let net = shaken_net(&plain(small()), &device, &mut rng);
            let world = World::rigid(&mut rng);
            assert_caught(
                &format!("{name} plain network"),
                deviation(&net, index, &world, &device).largest(),
                CAUGHT,
            );
            let found = deviation(&blindfolded(&net, &EYES, 4), index, &world, &device).largest();
            assert_small(&format!("{name} plain network, looking away"), found, tolerance);
        }
    }
}
