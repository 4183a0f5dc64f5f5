//! Pair files come back as they were written, and nothing else is taken for one.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use reseflow_data::{ActionChunk, FlowPair, PairMeta, PairSet, Window, WindowPairs};

use crate::samples::{action, dataset, pose_error};

fn sample(windows: usize, noises: usize, horizon: usize) -> PairSet {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut chunk = || ActionChunk((0..horizon).map(|_| action(&mut rng)).collect());
    let of = |index: usize| WindowPairs {
        window: Window { episode: index / 2, step: 3 * (index % 2) },
        pairs: (0..noises).map(|_| FlowPair { noise: chunk(), image: chunk() }).collect(),
    };
    let meta = PairMeta {
        checkpoint_hash: "c".to_owned(),
        data_hash: "d".to_owned(),
        settings: serde_json::json!({"noises": noises}),
    };
    PairSet { windows: (0..windows).map(of).collect(), meta }
}

#[test]
fn pairs_come_back_as_they_were_written() {
    let folder = tempfile::tempdir().unwrap();
    let (path, again) = (folder.path().join("pairs.npz"), folder.path().join("again.npz"));
    let mut written = sample(3, 2, 4);
    // Noise is not confined to 0 … 1.
    written.windows[1].pairs[0].noise.0[2].opening = -0.5;
    written.write(&path).unwrap();
    let read = PairSet::read(&path).unwrap();
    assert_eq!(read.meta, written.meta);
    assert_eq!(read.windows.len(), 3);
    for (read, written) in read.windows.iter().zip(&written.windows) {
        assert_eq!((read.window, read.pairs.len()), (written.window, 2));
        for (read, written) in read.pairs.iter().zip(&written.pairs) {
            for (read, written) in [(&read.noise, &written.noise), (&read.image, &written.image)] {
                assert_eq!(read.len(), 4);
                for (read, written) in read.iter().zip(written.iter()) {
                    assert!(pose_error(&read.world_from_gripper, &written.world_from_gripper) < 1e-6);
                    assert_eq!(read.opening, written.opening);
                }
            }
        }
    }
    written.write(&again).unwrap();
    assert!(std::fs::read(&path).unwrap() == std::fs::read(&again).unwrap(), "the same pairs, other bytes");
}

#[test]
fn what_is_no_pair_set_is_refused_and_the_older_file_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("kept.npz");
    dataset(1, 2, 3, 4).write(&path).unwrap();
    let before = std::fs::read(&path).unwrap();
    let fault = PairSet::read(&path).unwrap_err().to_string();
    assert!(fault.contains("kept.npz") && fault.contains("no array `window`"), "{fault}");

    let (mut uneven, mut short, mut broken) = (sample(2, 2, 3), sample(2, 2, 3), sample(2, 2, 3));
    uneven.windows[1].pairs.pop();
    short.windows[0].pairs[1].image.0.pop();
    broken.windows[0].pairs[0].noise.0[0].opening = f64::NAN;
    let cases = [
        (uneven, "window 1 has 1 pairs, expected M = 2"),
        (short, "window 0 has 2 actions, expected L = 3"),
        (broken, "`noise_opening`[0, 0, 0] is NaN"),
        (PairSet::default(), "at least 1 for W (windows)"),
    ];
    for (pairs, expected) in cases {
        let fault = pairs.write(&path).unwrap_err().to_string();
        assert!(fault.contains(expected), "{fault}");
    }
    assert!(std::fs::read(&path).unwrap() == before, "a refused write touched the older file");
}
