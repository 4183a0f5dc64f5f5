//! Every layer of degrees 0 and 1 written and read back by itself.

use burn::tensor::{Device, Tensor};
use rand_chacha::ChaCha8Rng;
use reseflow_net::{
    ConvolutionConfig, EncoderConfig, Features, HeatMap, HeatMapConfig, InteractionConfig,
    InvariantAttentionConfig, Parameterisation, PointerAttentionConfig, TokenBatch,
};

use crate::degree_checkpoint::assert_kept;
use crate::support::features::HostFeatures;
use crate::support::laws::example;
use crate::support::layers::{CHANNELS, GRAPH, RADIAL, batch, clouds};
use crate::support::scene::Scene;
use crate::support::trajectory::encode;
use crate::support::weights::drawn_net;
use crate::support::world::World;
use crate::support::{devices, normals, rng, small, tensor, values};

fn flat(features: &Features) -> Vec<f64> {
    let HostFeatures { scalars, vectors, .. } = HostFeatures::of(features);
    [scalars, vectors].concat()
}

fn random(points: usize, channels: [usize; 2], rng: &mut ChaCha8Rng, device: &Device) -> Features {
    HostFeatures::random(points, channels, rng).tensors(device)
}

#[test]
fn a_convolution_read_back_says_the_same() {
    for (name, device) in devices() {
        let mut rng = rng(81);
        let batch = batch(&clouds(&mut rng), &World::identity(), &device);
        let centres = 2 * GRAPH.centres;
        let receivers = tensor(normals(centres * CHANNELS, &mut rng), [centres, CHANNELS], &device);
        for (source_vectors, sources, edges) in
            [(false, 65, &batch.point_edges), (true, centres, &batch.centre_edges)]
        {
            let sources = random(sources, [CHANNELS, CHANNELS], &mut rng, &device);
            let config = ConvolutionConfig { channels: CHANNELS, radial: RADIAL.count, source_vectors };
            assert_kept(
                &format!("{name} convolution, source vectors {source_vectors}"),
                |rng| config.init(&device, rng),
                |layer| flat(&layer.forward(&sources, receivers.clone(), edges)),
            );
        }
    }
}

#[test]
fn interactions_attention_and_heat_maps_read_back_say_the_same() {
    for (name, device) in devices() {
        let mut rng = rng(82);
        let what = |layer: &str| format!("{name} {layer}");
        let (tokens, memory) = (random(12, [9, 6], &mut rng, &device), random(18, [7, 5], &mut rng, &device));
        let interaction = InteractionConfig { scalars: 9, vectors: 6, hidden: 11 };
        assert_kept(
            &what("interaction"),
            |rng| interaction.init(&device, rng),
            |layer| flat(&layer.forward(tokens.clone())),
        );
        let attention = InvariantAttentionConfig { query: [9, 6], memory: [7, 5], key: 4 };
        assert_kept(
            &what("attention"),
            |rng| attention.init(&device, rng),
            |layer| flat(&layer.forward(3, &tokens, &memory)),
        );
        let pointers = PointerAttentionConfig { query: [9, 6], memory: [7, 5], heads: 3, key: 4 };
        assert_kept(
            &what("pointer attention"),
            |rng| pointers.init(&device, rng),
            |layer| flat(&layer.forward(3, &tokens, &memory)),
        );
        let features = random(33, [CHANNELS, CHANNELS], &mut rng, &device);
        let heat_map = HeatMapConfig { channels: CHANNELS, nodes: 4 };
        assert_kept(
            &what("heat map"),
            |rng| heat_map.init(&device, rng),
            |layer| {
                let weights = layer.weights(3, &features);
                [values(&weights), flat(&HeatMap::pool(&weights, features.clone()))].concat()
            },
        );
    }
}

#[test]
fn an_encoder_read_back_says_the_same() {
    for (name, device) in devices() {
        let config = EncoderConfig {
            graph: GRAPH,
            channels: CHANNELS,
            point_radial: RADIAL,
            centre_radial: RADIAL,
            ..EncoderConfig::default()
        };
        let batch = batch(&clouds(&mut rng(83)), &World::identity(), &device);
        assert_kept(
            &format!("{name} encoder"),
            |rng| config.init(&device, rng).expect("the sizes make sense"),
            |layer| {
                let encoded = layer.forward(&batch);
                let parts = [values(&encoded.positions), values(&encoded.heat)];
                [flat(&encoded.nodes), flat(&encoded.centres), parts.concat()].concat()
            },
        );
    }
}

/// The decoder's context is a part of it.
#[test]
fn a_decoder_of_either_form_read_back_says_the_same() {
    for (name, device) in devices() {
        let config = small();
        let scenes = [example(0, &config), example(1, &config)];
        let states: Vec<_> = scenes.iter().map(Scene::state).collect();
        let noise: Vec<_> = scenes.iter().map(|scene| scene.noise.clone()).collect();
        let encoded = encode(&drawn_net(&config, &device, &mut rng(84)), &scenes, &device);
        for parameterisation in [Parameterisation::Endpoint, Parameterisation::Twist] {
            let mut decoder = config.decoder.clone();
            decoder.parameterisation = parameterisation;
            (decoder.nodes, decoder.channels) = (config.encoder.nodes, config.encoder.channels);
            assert_kept(
                &format!("{name} decoder, {parameterisation:?}"),
                |rng| decoder.init(&device, rng).expect("the sizes make sense"),
                |decoder| {
                    let context = decoder.context(&encoded, &states).expect("frames and states go together");
                    let tokens = TokenBatch::new(&noise, &[0.1, 0.7], &context.origins_m, &device)
                        .expect("the tokens fit the context");
                    let all = |first: Vec<f64>, rest: [Tensor<2>; 2]| {
                        rest.iter().fold(first, |all, part| [all, values(part)].concat())
                    };
                    match parameterisation {
                        Parameterisation::Endpoint => {
                            let said =
                                decoder.forward(&context, &tokens).expect("the form is the endpoint's");
                            all(values(&said.rotations), [said.positions_m, said.openings])
                        }
                        Parameterisation::Twist => {
                            let said = decoder.twists(&context, &tokens).expect("the form is the twist's");
                            all(values(&said.node_twists), [said.twists, said.openings])
                        }
                    }
                },
            );
        }
    }
}
