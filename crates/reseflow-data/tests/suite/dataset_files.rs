//! Data-set and prediction files: round trips, NumPy's files, determinism, provenance, summaries.

use std::path::PathBuf;

use proptest::prelude::*;
use reseflow_data::{
    ActionChunk, Dataset, DatasetFile, DatasetMeta, DatasetSummary, Disturbance, EpisodeKey, HashCheck,
    Predictions, Split,
};
use reseflow_lie::{SE3, SO3, Vector3};

use crate::samples;

/// Rounding a pose's matrix to `float32` moves an entry of a rotation by at most 2⁻²⁵, of a position within 2 m by at most 2⁻²⁴;
/// taking the nearest rotation then moves it by as much again.
const POSE_ROUNDING: f64 = 1.5e-7;

fn fixture(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests", "fixtures", name].iter().collect()
}

/// Everything but poses must agree bit by bit, poses to rounding.
fn assert_same(left: &Dataset, right: &Dataset) {
    assert_eq!(left.len(), right.len());
    for (a, b) in left.episodes.iter().zip(&right.episodes) {
        assert_eq!(a.observations.len(), b.observations.len());
        assert_eq!(a.actions.len(), b.actions.len());
        for (a, b) in a.observations.iter().zip(&b.observations) {
            assert_eq!(a.cloud, b.cloud);
            assert_eq!(a.gripper_opening.to_bits(), b.gripper_opening.to_bits());
            assert!(samples::pose_error(&a.world_from_gripper, &b.world_from_gripper) < POSE_ROUNDING);
        }
        for (a, b) in a.actions.iter().zip(&b.actions) {
            assert_eq!(a.opening.to_bits(), b.opening.to_bits());
            assert!(samples::pose_error(&a.world_from_gripper, &b.world_from_gripper) < POSE_ROUNDING);
        }
    }
}

#[test]
fn alternative_trajectories_are_read_back_and_part_of_the_hash() {
    let folder = tempfile::tempdir().unwrap();
    let (with, without) = (folder.path().join("with.npz"), folder.path().join("without.npz"));
    let mut data = samples::dataset(5, 3, 4, 2);
    data.write(&without).unwrap();
    let other = samples::dataset(6, 3, 4, 2);
    for (episode, other) in data.episodes.iter_mut().zip(&other.episodes) {
        episode.alternative = Some(other.actions.iter().map(|action| action.world_from_gripper).collect());
    }
    data.write(&with).unwrap();
    let (plain, read) = (DatasetFile::read(&without).unwrap(), DatasetFile::read(&with).unwrap());
    assert!(plain.dataset.episodes.iter().all(|episode| episode.alternative.is_none()));
    assert!(!DatasetSummary::of(&plain).has_alternative && DatasetSummary::of(&read).has_alternative);
    assert_ne!(plain.content_hash, read.content_hash);
    assert_same(&data, &read.dataset);
    for (written, read) in data.episodes.iter().zip(&read.dataset.episodes) {
        let (written, read) = (written.alternative.as_ref().unwrap(), read.alternative.as_ref().unwrap());
        assert_eq!(read.len(), 4);
        assert!(written.iter().zip(read).all(|(a, b)| samples::pose_error(a, b) < POSE_ROUNDING));
    }

    data.episodes[1].alternative = None;
    let fault = data.write(&with).unwrap_err().to_string();
    assert!(fault.contains("episode 1 has no alternative poses"), "{fault}");
    data.episodes[1].alternative = Some(Vec::new());
    let fault = data.write(&with).unwrap_err().to_string();
    assert!(fault.contains("episode 1 has 0 alternative poses, expected T = 4"), "{fault}");
}

#[test]
fn disturbances_are_read_back_and_part_of_the_hash() {
    let folder = tempfile::tempdir().unwrap();
    let (with, without) = (folder.path().join("with.npz"), folder.path().join("without.npz"));
    let mut data = samples::dataset(5, 3, 4, 2);
    data.write(&without).unwrap();
    let disturbance = Some(Disturbance { before: 1, answered_from: 2 });
    data.episodes[1].disturbance = disturbance;
    data.write(&with).unwrap();
    let (plain, read) = (DatasetFile::read(&without).unwrap(), DatasetFile::read(&with).unwrap());
    assert_ne!(plain.content_hash, read.content_hash);
    assert!(plain.dataset.episodes.iter().all(|episode| episode.disturbance.is_none()));
    assert_eq!(
        read.dataset.episodes.iter().map(|episode| episode.disturbance).collect::<Vec<_>>(),
        [None, disturbance, None]
    );
    assert_eq!((DatasetSummary::of(&plain).disturbed, DatasetSummary::of(&read).disturbed), (0, 1));

    for wrong in [(2, 1), (1, 4)] {
        data.episodes[1].disturbance = Some(Disturbance { before: wrong.0, answered_from: wrong.1 });
        let fault = data.write(&with).unwrap_err().to_string();
        assert!(fault.contains("`disturbed`[1] is ["), "{fault}");
        assert!(fault.contains("expected two steps from 0 to 3"), "{fault}");
    }
    assert_eq!(Dataset::read(&with).unwrap(), read.dataset, "what was there stays");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn what_is_written_is_read_back(seed: u64, e in 1_usize..5, t in 1_usize..6, n in 1_usize..40) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data.npz");
        let written = samples::dataset(seed, e, t, n);
        written.write(&path).unwrap();
        let read = Dataset::read(&path).unwrap();
        prop_assert_eq!((read.len(), read.steps(), read.points()), (e, t, n));
        assert_same(&written, &read);
    }

    #[test]
    fn predictions_are_read_back(seed: u64, e in 1_usize..4, s in 1_usize..4, l in 1_usize..6) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("predictions.npz");
        let mut actions = samples::dataset(seed, 1, e * s * l, 1).episodes.remove(0).actions.into_iter();
        let mut chunk = || ActionChunk(actions.by_ref().take(l).collect());
        let written = Predictions { chunks: (0..e).map(|_| (0..s).map(|_| chunk()).collect()).collect() };
        written.write(&path).unwrap();
        let read = Predictions::read(&path).unwrap();
        prop_assert_eq!(read.chunks.len(), e);
        for (written, read) in written.chunks.iter().zip(&read.chunks) {
            prop_assert_eq!(written.len(), s);
            prop_assert_eq!(read.len(), s);
            for (written, read) in written.iter().zip(read) {
                prop_assert_eq!(read.len(), l);
                for (a, b) in written.iter().zip(read.iter()) {
                    prop_assert_eq!(a.opening, b.opening);
                    prop_assert!(samples::pose_error(&a.world_from_gripper, &b.world_from_gripper) < POSE_ROUNDING);
                }
            }
        }
    }
}

/// The values that scripts/make_dataset_fixtures.py writes.
fn assert_is_the_fixture(data: &Dataset) {
    assert_eq!((data.len(), data.steps(), data.points()), (2, 3, 4));
    let pose = |frame: f64| {
        SE3::new(
            SO3::exp(&Vector3::new(0.0, 0.0, 0.3 * frame)),
            Vector3::new(0.25 * frame, -0.5, 0.5 * frame),
        )
    };
    for (e, episode) in data.episodes.iter().enumerate() {
        for (t, (observation, action)) in episode.observations.iter().zip(&episode.actions).enumerate() {
            for n in 0..4 {
                let point =
                    |c: usize| (e as f64 + t as f64 / 8.0 + n as f64 / 64.0 + c as f64 / 512.0) as f32;
                assert_eq!(
                    observation.cloud.points[n],
                    [point(0), point(1), point(2)],
                    "point [{e}, {t}, {n}]"
                );
                let color = (100 * e + 30 * t + 5 * n) as u8;
                assert_eq!(observation.cloud.colors[n], [color, color + 1, color + 2]);
            }
            let frame = (3 * e + t) as f64;
            assert_eq!((observation.gripper_opening, action.opening), (frame / 8.0, (frame + 1.0) / 8.0));
            assert!(samples::pose_error(&observation.world_from_gripper, &pose(frame)) < POSE_ROUNDING);
            assert!(samples::pose_error(&action.world_from_gripper, &pose(frame + 1.0)) < POSE_ROUNDING);
        }
    }
}

#[test]
fn numpys_own_files_are_read() {
    for name in ["savez.npz", "savez_compressed.npz", "fortran_big_endian.npz"] {
        assert_is_the_fixture(&Dataset::read(fixture(name)).unwrap());
    }
    let plain = DatasetFile::read(fixture("savez.npz")).unwrap();
    let meta = plain.dataset.meta.unwrap();
    assert_eq!(
        (meta.task.as_str(), &meta.extra["note"], plain.meta_fault),
        ("door", &"Öffnung → 1".into(), None)
    );
    assert_eq!(DatasetFile::read(fixture("savez_compressed.npz")).unwrap().dataset.meta, None);
    let pickled = DatasetFile::read(fixture("fortran_big_endian.npz")).unwrap();
    assert_eq!(pickled.dataset.meta, None);
    assert!(pickled.meta_fault.unwrap().starts_with("`meta` has dtype object (pickled)"));
    assert_eq!(
        plain.content_hash, pickled.content_hash,
        "byte order and axis order must not change the hash"
    );
}

#[test]
fn npyz_reads_what_we_write() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let written = samples::dataset(5, 2, 3, 7);
    written.write(&path).unwrap();
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&path).unwrap()).unwrap();
    let array = npyz::NpyFile::new(archive.by_name("points.npy").unwrap()).unwrap();
    assert_eq!((array.shape(), array.order()), (&[2, 3, 7, 3][..], npyz::Order::C));
    let points: Vec<f32> = array.into_vec().unwrap();
    let expected =
        written.episodes.iter().flat_map(|e| &e.observations).flat_map(|o| o.cloud.points.as_flattened());
    assert_eq!(points, expected.copied().collect::<Vec<f32>>());
    let array = npyz::NpyFile::new(archive.by_name("action_pose.npy").unwrap()).unwrap();
    assert_eq!(array.shape(), [2, 3, 4, 4]);
    let entries: Vec<f32> = array.into_vec().unwrap();
    let matrix = written.episodes[1].actions[2].world_from_gripper.matrix();
    for row in 0..4 {
        for column in 0..4 {
            assert_eq!(
                entries[5 * 16 + 4 * row + column],
                matrix[(row, column)] as f32,
                "row-major, [{row}, {column}]"
            );
        }
    }
}

#[test]
fn the_same_episodes_give_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |name: &str, data: &Dataset| {
        let path = folder.path().join(name);
        data.write(&path).unwrap();
        std::fs::read(path).unwrap()
    };
    let mut data = samples::dataset(1, 2, 3, 4);
    data.meta = Some(DatasetMeta { task: "door".into(), ..DatasetMeta::default() });
    let first = bytes("first.npz", &data);
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&first[..])).unwrap();
    for member in 0..archive.len() {
        let stamp = archive.by_index(member).unwrap().last_modified();
        assert_eq!(stamp, Some(zip::DateTime::default()), "the time of writing must not show");
    }
    assert_eq!(first, bytes("second.npz", &data.clone()));
    data.episodes[0].observations[0].cloud.colors[0][0] ^= 1;
    assert_ne!(first, bytes("third.npz", &data));
}

#[test]
fn provenance_is_kept_and_its_hash_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let key =
        |index| EpisodeKey { task: "door".into(), split: Split::Test, seed: u64::MAX, index, attempt: 1 };
    let meta = DatasetMeta {
        task: "door".into(),
        split: Some(Split::Test),
        seeds: vec![key(0), key(1)],
        attempts_dropped: 2,
        engine: "rapier3d".into(),
        config: serde_json::json!({"friction": 0.1, "name": "Tür"}),
        ..DatasetMeta::default()
    };
    let data = Dataset { meta: Some(meta.clone()), ..samples::dataset(2, 2, 4, 9) };
    data.write(&path).unwrap();
    let file = DatasetFile::read(&path).unwrap();
    let read = file.dataset.meta.clone().unwrap();
    assert_eq!(read, DatasetMeta { content_hash: Some(file.content_hash.clone()), ..meta });
    assert_eq!(DatasetSummary::of(&file).hash_check, HashCheck::Matches);

    // The same provenance beside other arrays, as someone editing the file with NumPy would leave it.
    let mut edited = file;
    let mut changed = data;
    changed.episodes[1].actions[3].opening = 0.0;
    let other = folder.path().join("other.npz");
    changed.write(&other).unwrap();
    edited.content_hash = DatasetFile::read(&other).unwrap().content_hash;
    assert_eq!(DatasetSummary::of(&edited).hash_check, HashCheck::Differs);
}

#[test]
fn the_hash_covers_every_array() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let changes: [fn(&mut Dataset); 7] = [
        |_| {},
        |data| data.episodes[1].observations[2].cloud.points[3][1] += 1.0,
        |data| data.episodes[1].observations[2].cloud.colors[3][1] ^= 255,
        |data| data.episodes[1].observations[2].world_from_gripper.translation.x += 1.0,
        |data| data.episodes[1].observations[2].gripper_opening = 0.0,
        |data| data.episodes[1].actions[2].world_from_gripper.translation.x += 1.0,
        |data| data.episodes[1].actions[2].opening = 0.0,
    ];
    let hashes: std::collections::BTreeSet<String> = changes
        .iter()
        .map(|change| {
            let mut data = samples::dataset(6, 2, 3, 4);
            change(&mut data);
            data.write(&path).unwrap();
            DatasetFile::read(&path).unwrap().content_hash
        })
        .collect();
    assert_eq!(hashes.len(), changes.len());
    assert!(hashes.iter().all(|hash| hash.len() == 64));
}

#[test]
fn a_summary_states_the_figures() {
    let summary = DatasetSummary::read(fixture("savez.npz")).unwrap();
    assert_eq!((summary.episodes, summary.steps, summary.points), (2, 3, 4));
    assert_eq!(summary.points_min_m, [0.0, 1.0 / 512.0, 2.0 / 512.0]);
    assert_eq!(summary.points_max_m[2], 1.0 + 2.0 / 8.0 + 3.0 / 64.0 + 2.0 / 512.0);
    assert_eq!((summary.gripper.position_min_m, summary.gripper.opening), ([0.0, -0.5, 0.0], [0.0, 0.625]));
    assert_eq!((summary.action.position_max_m, summary.action.opening), ([1.5, -0.5, 3.0], [0.125, 0.75]));
    assert!((summary.action.angle_max_rad - 1.8).abs() < 1e-6);
    assert!(
        (summary.padded_share - 1.0 / 3.0).abs() < 1e-12,
        "windows of 3 at steps 0, 1, 2 pad 0, 1, 2 of 9 targets"
    );
    assert_eq!(summary.hash_check, HashCheck::Absent);
    let json = serde_json::to_string(&summary).unwrap();
    assert_eq!(serde_json::from_str::<DatasetSummary>(&json).unwrap(), summary);
}
