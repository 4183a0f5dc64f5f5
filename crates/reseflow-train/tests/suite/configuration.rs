//! Every value out of range is refused, by the key that a configuration file calls it.

use reseflow_train::{BaselineConfig, ModelConfig, TrainConfig};

use crate::support::{tiny_model, tiny_training};

/// Sets one key in the configuration's TOML and reads it back.
fn with<T: serde::Serialize + serde::de::DeserializeOwned>(config: &T, key: &str, value: &str) -> T {
    let mut table = toml::Table::try_from(config).unwrap();
    let value: toml::Table = toml::from_str(&format!("value = {value}")).unwrap();
    let (path, name) = key.rsplit_once('.').unwrap_or(("", key));
    let mut place = &mut table;
    for part in path.split('.').filter(|part| !part.is_empty()) {
        place = place[part].as_table_mut().unwrap();
    }
    place.insert(name.to_owned(), value["value"].clone()).unwrap();
    table.try_into().unwrap()
}

#[test]
fn a_training_value_out_of_range_is_refused_by_its_key() {
    let good = tiny_training(10);
    good.validate().unwrap();
    for (key, values) in [
        ("updates", &["0"][..]),
        ("batch_size", &["0", "3", "65538"]),
        ("shards", &["0", "3"]),
        ("validate_every", &["0"]),
        ("learning_rate", &["-1e-3", "1.5", "nan", "inf"]),
        ("weight_decay", &["-0.1", "2.0", "nan"]),
        ("clip_norm", &["0.0", "-1.0", "nan", "inf"]),
        ("ema_decay", &["-0.1", "1.1", "nan"]),
        ("first_window_share", &["-0.1", "1.1", "nan"]),
        ("accumulate", &["0"]),
        ("warmup", &["200", "1000000"]),
        ("augment.jitter_m", &["-0.001", "1.5", "nan"]),
        ("augment.drop_points", &["-0.1", "0.6", "nan"]),
        ("augment.scale_std", &["-0.1", "0.6", "nan"]),
        ("augment.hue_shift", &["-0.1", "0.6", "nan"]),
        ("augment.gripper_std_rad", &["-0.1", "1.1", "nan"]),
        ("augment.gripper_std_m", &["-0.1", "1.1", "nan"]),
        ("augment.gripper_yaw_rad", &["-0.1", "3.2", "nan"]),
        ("augment.bend_std", &["-0.1", "0.6", "nan"]),
        ("augment.swirl_std_rad", &["-0.1", "3.2", "nan"]),
        ("augment.redraw_share", &["-0.1", "1.1", "nan"]),
        ("augment.mirror_share", &["-0.1", "1.1", "nan"]),
        ("augment.half_turn_share", &["-0.1", "1.1", "nan"]),
        ("time.zero_share", &["-0.1", "1.1", "nan"]),
        ("objective.nodes", &["-0.5", "nan", "inf"]),
        ("objective.opening", &["-0.5", "nan", "inf"]),
        ("objective.overlap", &["-0.5", "nan", "inf"]),
    ] {
        for value in values {
            let config: TrainConfig = with(&good, key, value);
            let Err(fault) = config.validate() else { panic!("{key} = {value} was accepted") };
            let fault = fault.to_string();
            assert!(fault.contains(key), "{key} = {value}: {fault}");
        }
    }
    for (key, value) in
        [("learning_rate", "0.0"), ("ema_decay", "0.0"), ("augment.jitter_m", "0.0"), ("warmup", "0")]
    {
        with::<TrainConfig>(&good, key, value).validate().unwrap();
    }
    let trial = TrainConfig { updates: 2, ..TrainConfig::default() };
    trial.validate().unwrap();
    let base = TrainConfig { updates: 1000, ..trial };
    for warmup in [999, 1000] {
        let long = BaselineConfig { updates: 1000, warmup, ..BaselineConfig::default() };
        let verdict = long.validate(&ModelConfig::default(), &base).map_err(|fault| fault.to_string());
        assert_eq!(verdict.is_err_and(|fault| fault.contains("baseline.warmup")), warmup == 1000);
    }
}

#[test]
fn a_model_value_out_of_range_is_refused_by_its_key() {
    let good = tiny_model();
    good.validate().unwrap();
    for (key, values) in [
        ("encoder.graph.centres", &["0", "4000000000"][..]),
        ("encoder.graph.point_neighbors", &["0", "100000"]),
        ("encoder.graph.centre_neighbors", &["0", "100000"]),
        ("encoder.channels", &["0", "100000"]),
        ("encoder.layers", &["1000"]),
        ("encoder.nodes", &["0", "1000"]),
        ("encoder.point_radial.count", &["0", "1", "1000000"]),
        ("encoder.point_radial.max_m", &["0.0", "-1.0", "nan", "inf"]),
        ("encoder.centre_radial.count", &["0", "1", "1000000"]),
        ("encoder.centre_radial.max_m", &["0.0", "nan"]),
        ("decoder.horizon", &["0", "1000000"]),
        ("decoder.frames", &["0", "1000"]),
        ("decoder.layers", &["1000"]),
        ("decoder.token_scalars", &["0", "100000"]),
        ("decoder.token_vectors", &["0", "100000"]),
        ("prior.sigma_rotation_rad", &["-0.1", "nan", "inf"]),
        ("prior.sigma_translation_m", &["-0.1", "nan", "inf"]),
        ("prior.sigma_opening", &["-0.1", "nan", "inf"]),
    ] {
        let place = if key.starts_with("prior") { key.to_owned() } else { format!("network.{key}") };
        for value in values {
            let config: ModelConfig = with(&good, &place, value);
            let Err(fault) = config.validate() else { panic!("{key} = {value} was accepted") };
            let fault = fault.to_string();
            let (table, name) = key.rsplit_once('.').unwrap();
            assert!(fault.contains(table) && fault.contains(name), "{key} = {value}: {fault}");
        }
    }
}

#[test]
fn unknown_keys_are_refused() {
    for text in ["update = 3", "[objective]\nnode = 1.0", "[time]\nzero = 0.1", "[augment]\nmirror = 0.5"] {
        let fault = toml::from_str::<TrainConfig>(text).unwrap_err().to_string();
        assert!(fault.contains("unknown field"), "{fault}");
    }
    for text in ["[network.encoder]\nchannel = 8", "[prior]\nsigma = 0.1", "[network.decoder]\nnodes = 4"] {
        let fault = toml::from_str::<ModelConfig>(text).unwrap_err().to_string();
        assert!(fault.contains("unknown field"), "{fault}");
    }
}
