//! Whatever is wrong with a checkpoint, loading it says so and names the file.

use std::path::Path;

use reseflow_data::Split;
use reseflow_train::{DeviceKind, FlowPolicy};

use crate::support::{Shelf, contents, demonstrations, histories, tiny_training};

/// A checkpoint, and a copy of it for every fault.
struct Ward {
    shelf: Shelf,
}

impl Ward {
    fn new() -> Self {
        let shelf = Shelf::new();
        shelf.train("good", &tiny_training(2), &demonstrations(Split::Train, 1), None).unwrap();
        Self { shelf }
    }

    /// Gives the file `name` of a fresh copy to `harm` and loads it.
    fn load_with(&self, name: &str, harm: impl Fn(&Path, Vec<u8>)) -> String {
        let folder = self.shelf.path("copy");
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir(&folder).unwrap();
        for (name, bytes) in contents(&self.shelf.path("good")) {
            std::fs::write(folder.join(name), bytes).unwrap();
        }
        let path = folder.join(name);
        harm(&path, std::fs::read(&path).unwrap());
        match FlowPolicy::load(&folder, DeviceKind::Cpu) {
            Ok(_) => panic!("{name}: the damage was not noticed"),
            Err(fault) => fault.to_string(),
        }
    }
}

fn is_a_sentence(fault: &str) {
    assert!(fault.lines().count() == 1 && fault.len() < 300, "expected one sentence, got:\n{fault}");
}

#[test]
fn damaged_weights_are_refused_by_name() {
    let ward = Ward::new();
    type Harm = fn(&Path, Vec<u8>);
    let cases: [(&str, Harm); 8] = [
        ("absent", |path, _| std::fs::remove_file(path).unwrap()),
        ("a folder", |path, _| {
            std::fs::remove_file(path).unwrap();
            std::fs::create_dir(path).unwrap();
        }),
        ("empty", |path, _| std::fs::write(path, "").unwrap()),
        ("cut in half", |path, bytes| std::fs::write(path, &bytes[..bytes.len() / 2]).unwrap()),
        ("one byte short", |path, bytes| std::fs::write(path, &bytes[..bytes.len() - 1]).unwrap()),
        ("only a header's length", |path, bytes| std::fs::write(path, &bytes[..8]).unwrap()),
        ("garbage", |path, bytes| {
            let noise = (0..bytes.len() as u64).map(|i| (i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 56) as u8);
            std::fs::write(path, noise.collect::<Vec<u8>>()).unwrap();
        }),
        ("a header of 2^64 bytes", |path, mut bytes| {
            bytes[..8].fill(0xFF);
            std::fs::write(path, bytes).unwrap();
        }),
    ];
    for (what, harm) in cases {
        let fault = ward.load_with("model.safetensors", harm);
        println!("{what}: {fault}");
        assert!(fault.contains("copy/model.safetensors: "), "{what}: {fault}");
        is_a_sentence(&fault);
    }
}

#[test]
fn a_damaged_configuration_is_refused_by_name() {
    let ward = Ward::new();
    let edit = |from: &str, to: &str| {
        ward.load_with("config.toml", |path, bytes| {
            let text = String::from_utf8(bytes).unwrap();
            assert!(text.contains(from), "nothing to change in:\n{text}");
            std::fs::write(path, text.replacen(from, to, 1)).unwrap();
        })
    };
    let write = |text: &str| ward.load_with("config.toml", |path, _| std::fs::write(path, text).unwrap());
    let absent = ward.load_with("config.toml", |path, _| std::fs::remove_file(path).unwrap());
    let cases: Vec<(String, &[&str])> = vec![
        (absent, &["No such file"]),
        (write("network = "), &[]),
        (write("\u{0}\u{1}"), &[]),
        (edit("channels = 8", "chanels = 8"), &["chanels", "channels"]),
        (edit("channels = 8", "channels = 'eight'"), &["eight"]),
        (edit("channels = 8", "channels = 0"), &["encoder.channels", "at least 1, got 0"]),
        (edit("channels = 8", "channels = 8000000"), &["encoder.channels", "at most 1024, got 8000000"]),
        (
            edit("sigma_rotation_rad = 0.5", "sigma_rotation_rad = -0.5"),
            &["prior.sigma_rotation_rad", "-0.5"],
        ),
    ];
    for (fault, parts) in cases {
        println!("{fault}");
        assert!(fault.contains("copy/config.toml: "), "{fault}");
        is_a_sentence(&fault);
        for part in parts {
            assert!(fault.contains(part), "expected `{part}` in: {fault}");
        }
    }
}

#[test]
fn weights_of_another_network_are_refused_by_name() {
    let ward = Ward::new();
    for (from, to, part) in [
        ("channels = 8", "channels = 16", "`encoder.embed.weight` has the shape [3, 8], expected [3, 16]"),
        ("layers = 1", "layers = 2", "`encoder.convolutions.1.edge.bias` is missing, and 9 more"),
        ("layers = 1", "layers = 0", "`encoder.convolutions.0.edge.bias` is unknown, and 9 more"),
        ("nodes = 2", "nodes = 3", "`encoder.heat_map.logits.weight` has the shape [16, 2]"),
        ("token_scalars = 16", "token_scalars = 20", "has the shape [50, 16], expected [50, 20]"),
        ("frames = 2", "frames = 3", "`decoder.context.frame_embedding`"),
        ("horizon = 10", "horizon = 9", "`decoder.step_embedding` has the shape [10, 16], expected [9, 16]"),
    ] {
        let fault = ward.load_with("config.toml", |path, bytes| {
            let text = String::from_utf8(bytes).unwrap();
            assert!(text.contains(from), "no `{from}` in:\n{text}");
            std::fs::write(path, text.replacen(from, to, 1)).unwrap();
        });
        println!("{to}: {fault}");
        assert!(fault.contains("copy/model.safetensors: ") && fault.contains(part), "{to}: {fault}");
        is_a_sentence(&fault);
    }
}

#[test]
fn weights_that_are_no_numbers_are_refused() {
    let ward = Ward::new();
    let fault = ward.load_with("model.safetensors", |path, mut bytes| {
        let header = 8 + u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
        for number in bytes[header..].chunks_exact_mut(4) {
            number.copy_from_slice(&f32::NAN.to_le_bytes());
        }
        std::fs::write(path, bytes).unwrap();
    });
    assert!(fault.contains("copy/model.safetensors: ") && fault.contains("finite"), "{fault}");
    let data = demonstrations(Split::Train, 1);
    ward.shelf.policy("good").predict(&histories(&data, 0), &[1], 1).unwrap();
}
