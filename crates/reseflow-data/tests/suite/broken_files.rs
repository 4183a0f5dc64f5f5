//! Files that are not what they should be: each gives one sentence that names the file, the array, the index and the expectation.

use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use npyz::WriterBuilder;
use proptest::prelude::*;
use reseflow_data::{Dataset, Predictions};
use reseflow_lie::Vector3;
use tempfile::TempDir;
use zip::write::SimpleFileOptions;

use crate::samples;

/// Arrays by name, encoded by npyz, so that our own writer has no part in these files.
#[derive(Clone)]
struct Members(BTreeMap<&'static str, Vec<u8>>);

fn npy<T: npyz::AutoSerialize + Copy>(shape: &[u64], data: &[T]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer =
        npyz::WriteOptions::new().default_dtype().shape(shape).writer(&mut bytes).begin_nd().unwrap();
    writer.extend(data.iter().copied()).unwrap();
    writer.finish().unwrap();
    bytes.into_inner()
}

const IDENTITY: [f32; 16] = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
const SHEARED: [f32; 16] = [1., 0.1, 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
const SCALED: [f32; 16] = [1.5, 0., 0., 0., 0., 1.5, 0., 0., 0., 0., 1.5, 0., 0., 0., 0., 1.];
const REFLECTED: [f32; 16] = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., -1., 0., 0., 0., 0., 1.];
const TRANSPOSED: [f32; 16] = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0.3, 0.2, 0.1, 1.];

impl Members {
    /// A valid data set of two episodes, three steps and four points.
    fn valid() -> Self {
        let poses: Vec<f32> = std::iter::repeat_n(IDENTITY, 6).flatten().collect();
        Self(BTreeMap::from([
            ("points", npy(&[2, 3, 4, 3], &[0.5_f32; 72])),
            ("rgb", npy(&[2, 3, 4, 3], &[7_u8; 72])),
            ("gripper_pose", npy(&[2, 3, 4, 4], &poses)),
            ("gripper_opening", npy(&[2, 3], &[0.5_f32; 6])),
            ("action_pose", npy(&[2, 3, 4, 4], &poses)),
            ("action_opening", npy(&[2, 3], &[1.0_f32; 6])),
        ]))
    }

    fn with(mut self, name: &'static str, member: Vec<u8>) -> Self {
        self.0.insert(name, member);
        self
    }

    fn without(mut self, name: &str) -> Self {
        self.0.remove(name);
        self
    }

    /// One of six poses replaced.
    fn with_pose(self, name: &'static str, at: usize, pose: [f32; 16]) -> Self {
        let poses = (0..6).map(|i| if i == at { pose } else { IDENTITY });
        self.with(name, npy(&[2, 3, 4, 4], &poses.flatten().collect::<Vec<f32>>()))
    }

    fn write(&self) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("demo.npz");
        let mut archive = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
        for (name, member) in &self.0 {
            archive.start_file(format!("{name}.npy"), SimpleFileOptions::default()).unwrap();
            archive.write_all(member).unwrap();
        }
        archive.finish().unwrap();
        (folder, path)
    }

    /// The fault, after "…/demo.npz: ".
    fn fault(&self) -> String {
        let (_folder, path) = self.write();
        fault(&path)
    }
}

fn fault(path: &Path) -> String {
    let message = Dataset::read(path).unwrap_err().to_string();
    assert!(!message.contains('\n'), "one sentence, not {message}");
    message.strip_prefix(&format!("{}: ", path.display())).expect("the message names the file").to_owned()
}

#[test]
fn the_valid_file_is_valid() {
    let (_folder, path) = Members::valid().write();
    assert_eq!(Dataset::read(path).unwrap().len(), 2);
}

#[test]
fn missing_arrays_and_wrong_types_are_named() {
    let valid = Members::valid;
    assert_eq!(
        valid().without("rgb").fault(),
        "has no array `rgb`; it holds action_opening, action_pose, gripper_opening, gripper_pose, points"
    );
    assert_eq!(
        valid().with("points", npy(&[2, 3, 4, 3], &[0.5_f64; 72])).fault(),
        "`points` has dtype float64, expected float32"
    );
    assert_eq!(
        valid().with("rgb", npy(&[2, 3, 4, 3], &[0.5_f32; 72])).fault(),
        "`rgb` has dtype float32, expected uint8"
    );
    assert_eq!(Members(BTreeMap::new()).fault(), "has no array `points`; it holds none");
}

#[test]
fn wrong_shapes_are_named_with_the_axis() {
    let valid = Members::valid;
    let cases = [
        (
            "points",
            npy(&[2, 3, 12], &[0_f32; 72]),
            "`points` has shape [2, 3, 12], expected [E (episodes), T (steps), N (points), 3]",
        ),
        (
            "points",
            npy(&[2, 3, 6, 2], &[0_f32; 72]),
            "`points` has shape [2, 3, 6, 2], expected [E (episodes), T (steps), N (points), 3]",
        ),
        (
            "points",
            npy::<f32>(&[0, 3, 4, 3], &[]),
            "`points` has shape [0, 3, 4, 3], expected at least 1 for E (episodes)",
        ),
        (
            "points",
            npy::<f32>(&[2, 0, 4, 3], &[]),
            "`points` has shape [2, 0, 4, 3], expected at least 1 for T (steps)",
        ),
        (
            "points",
            npy::<f32>(&[2, 3, 0, 3], &[]),
            "`points` has shape [2, 3, 0, 3], expected at least 1 for N (points)",
        ),
        (
            "rgb",
            npy(&[2, 3, 5, 3], &[0_u8; 90]),
            "`rgb` has shape [2, 3, 5, 3], expected [2, 3, 4, 3]: N is 5 here and 4 in `points`",
        ),
        ("rgb", npy(&[2, 3, 4, 4], &[0_u8; 96]), "`rgb` has shape [2, 3, 4, 4], expected [2, 3, 4, 3]"),
        (
            "gripper_pose",
            npy(&[2, 2, 4, 4], &[0_f32; 64]),
            "`gripper_pose` has shape [2, 2, 4, 4], expected [2, 3, 4, 4]: T is 2 here and 3 in `points`",
        ),
        (
            "action_pose",
            npy(&[2, 3, 16], &[0_f32; 96]),
            "`action_pose` has shape [2, 3, 16], expected [2, 3, 4, 4]",
        ),
        (
            "action_opening",
            npy(&[1, 3], &[0_f32; 3]),
            "`action_opening` has shape [1, 3], expected [2, 3]: E is 1 here and 2 in `points`",
        ),
        (
            "gripper_opening",
            npy(&[2, 3, 1], &[0_f32; 6]),
            "`gripper_opening` has shape [2, 3, 1], expected [2, 3]",
        ),
    ];
    for (name, member, expected) in cases {
        assert_eq!(valid().with(name, member).fault(), expected);
    }
}

#[test]
fn numbers_that_cannot_be_are_named_with_their_index() {
    let valid = Members::valid;
    let mut points = [0.5_f32; 72];
    points[(3 + 2) * 12 + 3 * 3 + 1] = f32::NAN;
    assert_eq!(
        valid().with("points", npy(&[2, 3, 4, 3], &points)).fault(),
        "`points`[1, 2, 3, 1] is NaN, expected a finite number"
    );
    let mut infinite = IDENTITY;
    infinite[3] = f32::INFINITY;
    assert_eq!(
        valid().with_pose("action_pose", 4, infinite).fault(),
        "`action_pose`[1, 1, 0, 3] is inf, expected a finite number"
    );
    let openings = |at: usize, value: f32| {
        npy(&[2, 3], &std::array::from_fn::<f32, 6, _>(|i| if i == at { value } else { 0.0 }))
    };
    let range = "expected an opening from 0 (closed) to 1 (open)";
    assert_eq!(
        valid().with("gripper_opening", openings(5, 1.25)).fault(),
        format!("`gripper_opening`[1, 2] is 1.25, {range}")
    );
    assert_eq!(
        valid().with("action_opening", openings(0, -0.5)).fault(),
        format!("`action_opening`[0, 0] is -0.5, {range}")
    );
    assert_eq!(
        valid().with("action_opening", openings(1, f32::NAN)).fault(),
        "`action_opening`[0, 1] is NaN, expected a finite number"
    );
    let (_folder, path) = valid().with("action_opening", openings(1, 1.0005)).write();
    assert!(Dataset::read(path).is_ok(), "rounding is not a fault");
}

#[test]
fn matrices_that_are_no_poses_are_named_with_their_index() {
    let cases = [
        (SHEARED, "expected an orthonormal matrix"),
        (SCALED, "expected an orthonormal matrix"),
        (REFLECTED, "expected a rotation (determinant 1), got a reflection"),
        (TRANSPOSED, "expected the bottom row (0, 0, 0, 1), got (0.3"),
        ([0.0; 16], "expected the bottom row (0, 0, 0, 1)"),
    ];
    for (pose, reason) in cases {
        for name in ["gripper_pose", "action_pose"] {
            let fault = Members::valid().with_pose(name, 5, pose).fault();
            assert!(fault.starts_with(&format!("`{name}`[1, 2] is no rigid transform: {reason}")), "{fault}");
        }
    }
}

#[test]
fn files_cut_off_anywhere_are_refused_and_never_panic() {
    let (folder, path) = Members::valid().write();
    let whole = std::fs::read(&path).unwrap();
    let cut = folder.path().join("cut.npz");
    for length in (0..whole.len()).step_by(7) {
        std::fs::write(&cut, &whole[..length]).unwrap();
        let fault = fault(&cut);
        let expected =
            if length < 2 { "is not an .npz file" } else { "is a broken .npz file, perhaps cut off" };
        assert!(fault.starts_with(expected), "cut to {length} bytes: {fault}");
    }
    let valid = Members::valid();
    let short = valid.0["points"][..200].to_vec();
    assert_eq!(
        valid.with("points", short).fault(),
        "`points` ends before its last element: the file was cut off"
    );
}

#[test]
fn damage_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data.npz");
    samples::dataset(3, 2, 3, 50).write(&path).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[1000] ^= 1; // inside `points`, the first array
    std::fs::write(&path, &bytes).unwrap();
    let fault = fault(&path);
    assert!(fault.starts_with("`points` is damaged (") && fault.contains("checksum"), "{fault}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn a_wrong_byte_is_noticed_or_does_not_matter(at: prop::sample::Index, byte: u8) {
        let (_folder, path) = Members::valid().write();
        let intact = Dataset::read(&path).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        let at = at.index(bytes.len());
        bytes[at] = byte;
        std::fs::write(&path, &bytes).unwrap();
        match Dataset::read(&path) {
            Ok(read) => prop_assert_eq!(read, intact, "damage that no checksum noticed"),
            Err(fault) => prop_assert!(fault.to_string().contains("demo.npz: ")),
        }
    }
}

#[test]
fn other_kinds_of_file_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other");
    std::fs::write(&path, npy(&[3], &[1_f32, 2.0, 3.0])).unwrap();
    assert_eq!(fault(&path), "is a single .npy array, expected an .npz archive of named arrays");
    std::fs::write(&path, "hello").unwrap();
    assert_eq!(fault(&path), "is not an .npz file (it does not start like a zip archive)");
    assert_eq!(fault(folder.path()), "is a folder, expected an .npz file");
    assert!(fault(&folder.path().join("absent.npz")).starts_with("No such file"));
    let mut not_numpy = Members::valid().with("points", b"not an array at all".to_vec());
    assert_eq!(not_numpy.fault(), "`points` is damaged (it does not start like a .npy array)");
    not_numpy.0.insert("points", b"\x93NUMPY\x01\x00\x05\x00hello".to_vec());
    assert_eq!(not_numpy.fault(), "`points` is damaged (its header is not NumPy's: hello)");
}

#[test]
fn what_cannot_be_read_back_is_not_written_and_the_old_file_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let good = samples::dataset(4, 3, 4, 5);
    good.write(&path).unwrap();
    let before = std::fs::read(&path).unwrap();
    let refused = |change: fn(&mut Dataset), expected: &str| {
        let mut bad = good.clone();
        change(&mut bad);
        assert_eq!(bad.write(&path).unwrap_err().to_string(), format!("{}: {expected}", path.display()));
        assert_eq!(std::fs::read(&path).unwrap(), before, "the old file was touched");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    };
    refused(|data| data.episodes.clear(), "holds no episode, expected at least 1");
    refused(
        |data| data.episodes[2].actions.truncate(3),
        "episode 2 has 4 observations and 3 actions, expected T = 4 of each",
    );
    refused(
        |data| data.episodes[1].observations[3].cloud.colors.truncate(4),
        "episode 1 has 5 points and 4 colours at step 3, expected N = 5 of each",
    );
    refused(
        |data| data.episodes[0].observations[1].cloud.points[2][0] = f32::NAN,
        "`points`[0, 1, 2, 0] is NaN, expected a finite number",
    );
    refused(
        |data| data.episodes[1].actions[1].world_from_gripper.translation = Vector3::new(0.0, 1e60, 0.0),
        "`action_pose`[1, 1, 1, 3] is inf, expected a finite number",
    );
    refused(
        |data| data.episodes[1].actions[1].opening = 2.0,
        "`action_opening`[1, 1] is 2, expected an opening from 0 (closed) to 1 (open)",
    );
}

#[test]
fn predictions_are_checked_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("predictions.npz");
    let write = |pose: Vec<u8>, opening: Vec<u8>| {
        let mut archive = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
        for (name, member) in [("pose.npy", pose), ("opening.npy", opening)] {
            archive.start_file(name, SimpleFileOptions::default()).unwrap();
            archive.write_all(&member).unwrap();
        }
        archive.finish().unwrap();
    };
    let expect = |expected: &str| {
        let message = Predictions::read(&path).unwrap_err().to_string();
        assert_eq!(message, format!("{}: {expected}", path.display()));
    };
    write(npy(&[1, 1, 1, 4, 4], &IDENTITY), npy(&[1, 1, 2], &[0_f32; 2]));
    expect("`opening` has shape [1, 1, 2], expected [1, 1, 1]: L is 2 here and 1 in `pose`");
    write(npy(&[1, 1, 4, 4], &IDENTITY), npy(&[1, 1], &[0_f32]));
    expect("`pose` has shape [1, 1, 4, 4], expected [E (episodes), S (seeds), L (horizon), 4, 4]");
    write(npy(&[1, 1, 1, 4, 4], &REFLECTED), npy(&[1, 1, 1], &[0_f32]));
    expect(
        "`pose`[0, 0, 0] is no rigid transform: expected a rotation (determinant 1), got a reflection (determinant -1)",
    );
    let ragged = Predictions { chunks: vec![vec![Default::default()], vec![]] };
    assert!(
        ragged.write(&path).unwrap_err().to_string().ends_with("episode 1 has 0 predictions, expected S = 1")
    );
}
