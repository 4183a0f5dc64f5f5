//! Layers of all degrees written and read back, their configurations, and how many parameters the presets have.

use burn::module::Module;
use burn::store::{ModuleSnapshot, SafetensorsStore};
use burn::tensor::Device;
use rand_chacha::ChaCha8Rng;
use reseflow_net::degrees::{
    EdgeFrames, Fiber, FiberHeatMapConfig, FiberLayerNormConfig, FiberLinearConfig, GatedNonlinearityConfig,
    NeighborAttentionConfig, NormNonlinearityConfig, TensorProductConvolutionConfig,
};
use reseflow_net::{Nonlinearity, SE3ManiNetConfig, SE3TransformerConfig};

use crate::support::degree_layers::{RADIAL_MLP, centre_edges, frames, uniform};
use crate::support::fibers::HostFiber;
use crate::support::layers::{GRAPH, RADIAL, clouds};
use crate::support::mani_net::{features_on_host, homes, nodes, poses_on_host, small_mani_net};
use crate::support::weights::shaken;
use crate::support::world::World;
use crate::support::{devices, rng, values};

/// Asserts that a module says the same after its weights went through a file into one with other weights.
#[track_caller]
pub(crate) fn assert_kept<M: Module + ModuleSnapshot>(
    what: &str,
    init: impl Fn(&mut ChaCha8Rng) -> M,
    say: impl Fn(&M) -> Vec<f64>,
) {
    let draw = |stream| {
        let mut rng = rng(stream);
        shaken(init(&mut rng), 0.1, &mut rng)
    };
    let (layer, mut other) = (draw(65), draw(66));
    let folder = tempfile::tempdir().expect("a folder can be made");
    let path = folder.path().join("layer.safetensors");
    layer.save_into(&mut SafetensorsStore::from_file(&path)).expect("weights can be written");
    assert_ne!(say(&other), say(&layer), "{what}: other weights say something else");
    let loaded = other.load_from(&mut SafetensorsStore::from_file(&path)).expect("weights can be read");
    assert!(loaded.missing.is_empty() && loaded.unused.is_empty(), "{what}: {loaded:?}");
    assert_eq!(say(&other), say(&layer), "{what}");
}

fn flat(features: HostFiber) -> Vec<f64> {
    features.degrees.into_iter().flatten().collect()
}

/// Edges among the centres of two clouds.
fn edges(device: &Device) -> EdgeFrames {
    frames(&centre_edges(&clouds(&mut rng(67)), &World::identity()), 3, device)
}

#[test]
fn a_layer_read_back_says_the_same() {
    for (name, device) in devices() {
        let edges = edges(&device);
        let fiber = Fiber { channels: vec![4; 4] };
        let input = HostFiber::random(2 * GRAPH.centres, &fiber, &mut rng(68)).tensors(&device);
        let what = |layer: &str| format!("{name} {layer}");

        let linear = FiberLinearConfig { input: fiber.clone(), output: fiber.clone(), bias: true };
        let say = |output| flat(HostFiber::of(&output));
        assert_kept(&what("linear"), |rng| linear.init(&device, rng), |layer| say(layer.forward(&input)));
        let norm = NormNonlinearityConfig { fiber: fiber.clone() };
        assert_kept(&what("norm"), |_| norm.init(&device), |layer| say(layer.forward(input.clone())));
        let gated = GatedNonlinearityConfig { fiber: fiber.clone() };
        assert_kept(
            &what("gated"),
            |rng| gated.init(&device, rng),
            |layer| say(layer.forward(input.clone())),
        );
        let layer_norm = FiberLayerNormConfig { fiber: fiber.clone() };
        assert_kept(
            &what("layer norm"),
            |_| layer_norm.init(&device),
            |layer| say(layer.forward(input.clone())),
        );
        let heat_map = FiberHeatMapConfig { fiber: fiber.clone(), nodes: 3 };
        assert_kept(
            &what("heat map"),
            |rng| heat_map.init(&device, rng),
            |layer| values(&layer.weights(2, &input)),
        );

        let convolution = TensorProductConvolutionConfig {
            input: uniform(3, 4),
            output: uniform(2, 3),
            radial: RADIAL_MLP,
        };
        let say = |output| flat(HostFiber::of(&output));
        assert_kept(
            &what("convolution"),
            |rng| convolution.init(&device, rng),
            |layer| say(layer.forward(&input, &edges)),
        );
        let attention = NeighborAttentionConfig {
            input: uniform(3, 4),
            output: uniform(2, 2),
            heads: 2,
            radial: RADIAL_MLP,
        };
        assert_kept(
            &what("attention"),
            |rng| attention.init(&device, rng).expect("the heads divide the channels"),
            |layer| say(layer.forward(&input, &edges)),
        );
    }
}

#[test]
fn a_transformer_read_back_says_the_same() {
    for (name, device) in devices() {
        let edges = edges(&device);
        for nonlinearity in [Nonlinearity::Norm, Nonlinearity::Gated] {
            let config = SE3TransformerConfig {
                radial: RADIAL.count,
                layers: 2,
                nonlinearity,
                ..SE3TransformerConfig::default()
            };
            let input =
                HostFiber::random(2 * GRAPH.centres, &config.input.fiber(), &mut rng(69)).tensors(&device);
            assert_kept(
                &format!("{name} SE3Transformer, {nonlinearity:?}"),
                |rng| config.init(&device, rng).expect("the sizes make sense"),
                |net| flat(HostFiber::of(&net.forward(input.clone(), &edges))),
            );
            let clouds = clouds(&mut rng(70));
            assert_kept(
                &format!("{name} SE3ManiNet, {nonlinearity:?}"),
                |rng| small_mani_net(nonlinearity).init(&device, rng).expect("the sizes make sense"),
                |net| {
                    let nodes = nodes(net, &clouds, &homes(2), &World::identity(), &device);
                    [features_on_host(&nodes), poses_on_host(&nodes)].into_iter().flat_map(flat).collect()
                },
            );
        }
    }
}

/// Parameters of NVIDIA's SE(3)-Transformer with these sizes, layer by layer, but for what the test below says.
fn counted(config: &SE3TransformerConfig) -> usize {
    let paths = |inputs: usize, outputs: usize| -> usize {
        (0..=inputs).flat_map(|a| (0..=outputs).map(move |b| 2 * a.min(b) + 1)).sum()
    };
    let (hidden, degree, channels) = (config.radial_hidden, config.max_degree, config.channels);
    let values = channels / config.channels_div;
    // Two hidden layers with biases and layer normalisation, and the last layer without.
    let radial = |weights: usize| {
        config.radial * hidden + hidden + hidden * hidden + hidden + 4 * hidden + hidden * weights
    };
    let mut count = 0;
    let (mut in_degree, mut in_channels) = (config.input.max_degree, config.input.channels);
    for _ in 0..config.layers {
        let key_degree = in_degree.min(degree);
        count += radial(in_channels * values * (paths(in_degree, degree) + paths(in_degree, key_degree)));
        count += (key_degree + 1) * in_channels * values;
        count += (0..=degree)
            .map(|l| (values + if l <= in_degree { in_channels } else { 0 }) * channels)
            .sum::<usize>();
        count += 2 * channels * (degree + 1);
        (in_degree, in_channels) = (degree, channels);
    }
    let output = config.output;
    count += radial(in_channels * output.channels * paths(in_degree, output.max_degree));
    count + (output.max_degree + 1) * in_channels * output.channels
}

/// ET-SEED has "≈ 0.9 M" in two kernels of a position and an orientation network each. What differs here: the radial networks see
/// 8 basis functions instead of the length alone (224 more each); the first block has one radial network for all degrees out, where
/// NVIDIA's has one for each; scalars come out beside the two vectors.
#[test]
fn the_presets_have_the_baselines_parameter_counts() {
    let [(_, device), _] = devices();
    let counts = [SE3TransformerConfig::et_seed_position(), SE3TransformerConfig::et_seed_orientation()].map(
        |config| {
            let net = config.init(&device, &mut rng(71)).expect("the sizes make sense");
            assert_eq!(net.num_params(), counted(&config));
            net.num_params()
        },
    );
    println!(
        "position {}, orientation {}, two kernels {}",
        counts[0],
        counts[1],
        2 * (counts[0] + counts[1])
    );
    let both_kernels = 2.0 * (counts[0] + counts[1]) as f64;
    assert!((both_kernels / 0.9e6 - 1.0).abs() < 0.06, "{both_kernels} parameters");
}

#[test]
fn a_configuration_of_any_degree_survives_toml() {
    for config in [SE3ManiNetConfig::default(), small_mani_net(Nonlinearity::Gated)] {
        let text = toml::to_string_pretty(&config).expect("the configuration can be written");
        let read: SE3ManiNetConfig = toml::from_str(&text).expect("and read");
        assert_eq!(read, config, "{text}");
    }
    let error =
        toml::from_str::<SE3ManiNetConfig>("[transformer]\nlayrs = 3").expect_err("there is no such key");
    assert!(error.to_string().contains("unknown field `layrs`"), "{error}");
}

#[test]
fn a_transformer_size_that_makes_no_sense_is_named() {
    type Spoil = fn(&mut SE3ManiNetConfig);
    let cases: [(&str, Spoil); 9] = [
        ("mani_net.nodes", |config| config.nodes = 0),
        ("mani_net.graph.centres", |config| config.graph.centres = 0),
        ("mani_net.point_radial", |config| config.point_radial.count = 1),
        ("mani_net.transformer.max_degree", |config| config.transformer.max_degree = 0),
        ("mani_net.transformer.output.max_degree", |config| config.transformer.output.max_degree = 0),
        ("transformer.channels", |config| config.transformer.channels = 0),
        ("transformer.channels_div", |config| config.transformer.channels_div = 0),
        ("transformer.output.max_degree", |config| config.transformer.output.max_degree = 4),
        ("heads", |config| config.transformer.heads = 3),
    ];
    for (key, spoil) in cases {
        let mut config = SE3ManiNetConfig::default();
        assert_eq!(config.validate(), Ok(()));
        spoil(&mut config);
        let error = config.validate().expect_err("the size makes no sense");
        assert!(error.to_string().contains(&format!("{key} ")), "{key}: {error}");
        let [(_, device), _] = devices();
        assert_eq!(config.init(&device, &mut rng(72)).map(|_| ()), Err(error));
    }
}
