//! Weights and configuration written and read back as a checkpoint does it.

use burn::module::Module;
use burn::store::{ModuleSnapshot, SafetensorsStore};
use burn::tensor::Device;
use reseflow_net::{DriftNet, DriftNetConfig, Parameterisation};

use crate::support::laws::example;
use crate::support::plain::{plain, upright};
use crate::support::trajectory::{Trajectory, predict_one};
use crate::support::twists::{in_twist_form, numbers, twists};
use crate::support::weights::{drawn_net, shaken_net};
use crate::support::{devices, of_degree, rng, small};

/// All numbers of a prediction.
fn flat(trajectory: &Trajectory) -> Vec<f64> {
    let poses = trajectory.consensus.iter().chain(&trajectory.nodes);
    let numbers = poses.flat_map(|(rotation, position)| rotation.iter().chain(position.iter()));
    numbers.chain(&trajectory.scalars).copied().collect()
}

/// One configuration of each choice.
fn every_kind() -> [DriftNetConfig; 6] {
    let [second, third] = [2, 3].map(|degree| of_degree(degree, small()));
    [DriftNetConfig::default(), small(), in_twist_form(small()), plain(small()), second, third]
}

#[test]
fn a_network_read_back_says_the_same_on_every_device() {
    for config in every_kind() {
        let scene = example(1, &config);
        let say = |net: &DriftNet, device: &Device| match config.decoder.parameterisation {
            Parameterisation::Endpoint => flat(&predict_one(net, &scene, device)),
            Parameterisation::Twist => numbers(&twists(net, std::slice::from_ref(&scene), device)),
        };
        for (name, device) in devices() {
            let mut rng = rng(61);
            let net = shaken_net(&config, &device, &mut rng);
            let folder = tempfile::tempdir().expect("a folder can be made");
            let path = folder.path().join("model.safetensors");
            net.save_into(&mut SafetensorsStore::from_file(&path)).expect("weights can be written");

            let mut other = drawn_net(&config, &device, &mut crate::support::rng(62));
            assert_ne!(say(&other, &device), say(&net, &device), "{name}: other weights say something else");
            let loaded =
                other.load_from(&mut SafetensorsStore::from_file(&path)).expect("weights can be read");
            assert!(loaded.missing.is_empty() && loaded.unused.is_empty(), "{name}: {loaded:?}");
            assert_eq!(say(&other, &device), say(&net, &device), "{name}");
            assert_eq!(other.config(), net.config());
        }
    }
}

#[test]
fn weights_of_another_size_are_not_taken() {
    let [(_, device), _] = devices();
    let folder = tempfile::tempdir().expect("a folder can be made");
    let path = folder.path().join("model.safetensors");
    let net = drawn_net(&small(), &device, &mut rng(63));
    net.save_into(&mut SafetensorsStore::from_file(&path)).expect("weights can be written");
    let mut wider = small();
    wider.encoder.channels += 1;
    let mut other = drawn_net(&wider, &device, &mut rng(64));
    let taken = other.load_from(&mut SafetensorsStore::from_file(&path));
    assert!(taken.is_err(), "{taken:?}");
    let mut higher = drawn_net(&of_degree(2, small()), &device, &mut rng(64));
    let taken = higher.load_from(&mut SafetensorsStore::from_file(&path));
    assert!(taken.is_err(), "{taken:?}");
}

#[test]
fn a_configuration_survives_toml() {
    for config in every_kind() {
        let text = toml::to_string_pretty(&config).expect("the configuration can be written");
        let mut read: DriftNetConfig = toml::from_str(&text).expect("and read");
        // Filled in from the encoder, and not written.
        (read.decoder.nodes, read.decoder.channels) = (config.decoder.nodes, config.decoder.channels);
        assert_eq!(read, config, "{text}");
    }
}

#[test]
fn a_configuration_that_chooses_nothing_is_written_as_before_there_were_choices() {
    let written = |config| toml::to_string(&config).expect("the configuration can be written");
    for (key, value, config) in [
        ("parameterisation", "\"twist\"", in_twist_form(DriftNetConfig::default())),
        ("symmetry", "\"none\"", plain(DriftNetConfig::default())),
        ("symmetry", "\"upright\"", upright(DriftNetConfig::default())),
        ("max_degree", "3", of_degree(3, DriftNetConfig::default())),
    ] {
        assert!(!written(DriftNetConfig::default()).contains(key), "{key}");
        let chosen = written(config);
        assert!(chosen.contains(&format!("{key} = {value}")), "{chosen}");
    }
}

#[test]
fn a_partial_configuration_keeps_the_other_defaults() {
    let text = "[encoder.graph]\ncentres = 16\n[decoder]\nhorizon = 7";
    let read: DriftNetConfig = toml::from_str(text).expect("every key has a default");
    let mut expected = DriftNetConfig::default();
    expected.encoder.graph.centres = 16;
    expected.decoder.horizon = 7;
    assert_eq!(read, expected);
}

#[test]
fn an_unknown_key_is_refused_by_name() {
    for text in
        ["[encoder]\nchanels = 3", "[decoder]\nnodes = 3", "[encoder.graph]\ncenters = 3", "width = 3"]
    {
        let error = toml::from_str::<DriftNetConfig>(text).expect_err("there is no such key").to_string();
        let key = text.rsplit('\n').next().and_then(|line| line.split(' ').next()).expect("a line has a key");
        assert!(error.contains(&format!("unknown field `{key}`")), "{error}");
    }
}

#[test]
fn a_plain_network_is_as_large_within_a_tenth() {
    let [(_, device), _] = devices();
    for config in [DriftNetConfig::default(), small()] {
        let count = |config: &DriftNetConfig| drawn_net(config, &device, &mut rng(65)).num_params();
        let (symmetric, without) = (count(&config), count(&plain(config.clone())));
        println!("{symmetric} parameters, without symmetry {without}");
        assert!(without > symmetric && without < symmetric + symmetric / 10, "{symmetric} and {without}");
    }
}
