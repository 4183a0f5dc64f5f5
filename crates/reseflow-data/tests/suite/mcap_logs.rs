//! MCAP logs, read back with the mcap crate and Foxglove's own decoders.

use std::collections::BTreeMap;
use std::path::Path;

use foxglove::Decode;
use foxglove::messages as fox;
use proptest::prelude::*;
use reseflow_data::{
    EpisodeObserver, Halt, McapLog, McapSummary, RolloutConfig, Scene, TrainingNotes, rollout,
    write_training_log,
};

use crate::point_scene::{Diary, PointScene, TICK_NANOS, WaypointPolicy, spec};

const STEPS: usize = 3;
const TICKS: usize = 4;
const GAP_NANOS: u64 = 1_000_000_000;
const TICK: u64 = TICK_NANOS as u64;

/// One episode of 3 × 4 ticks into `log`; the policy plans at every step.
fn record(log: &mut McapLog, change: impl FnOnce(&mut PointScene, &mut WaypointPolicy)) -> PointScene {
    let diary = Diary::default();
    let mut scene = PointScene::new(&diary);
    let mut policy = WaypointPolicy::towards(&scene, STEPS, &diary);
    change(&mut scene, &mut policy);
    let config =
        RolloutConfig { observation_horizon: 2, n_action_steps: 1, disturb_before: None, policy_seed: 0 };
    rollout(&mut scene, &spec(STEPS, TICKS), &mut policy, &config, log).unwrap();
    scene
}

type Messages = BTreeMap<String, Vec<(u64, Vec<u8>)>>;

fn read(path: &Path) -> Messages {
    let bytes = std::fs::read(path).unwrap();
    let mut messages = Messages::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        assert_eq!(message.log_time, message.publish_time);
        let topic = messages.entry(message.channel.topic.clone()).or_default();
        assert_eq!(message.sequence as usize, topic.len());
        topic.push((message.log_time, message.data.into_owned()));
    }
    messages
}

fn decode<M: Decode>(message: &(u64, Vec<u8>)) -> M {
    M::decode(&message.1[..]).ok().unwrap()
}

fn json(message: &(u64, Vec<u8>)) -> serde_json::Value {
    serde_json::from_slice(&message.1).unwrap()
}

fn times(messages: &[(u64, Vec<u8>)]) -> Vec<u64> {
    messages.iter().map(|(time, _)| *time).collect()
}

#[test]
fn two_episodes_lie_end_to_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let mut log = McapLog::create(&path).unwrap();
    record(&mut log, |_, _| {});
    record(&mut log, |_, _| {});
    assert!(!path.exists(), "nothing half-written is to be seen");
    log.finish().unwrap();

    let messages = read(&path);
    let span = (STEPS * TICKS) as u64 * TICK;
    let second = span + GAP_NANOS;
    let from = |origin: u64, ticks: std::ops::RangeInclusive<usize>, step: usize| {
        ticks.step_by(step).map(move |tick| origin + tick as u64 * TICK)
    };
    let both = |first: usize, last: usize, step: usize| -> Vec<u64> {
        from(0, first..=last, step).chain(from(second, first..=last, step)).collect()
    };
    for topic in ["/observation/points", "/tf", "/scene", "/gripper/opening"] {
        assert_eq!(times(&messages[topic]), both(0, 12, 1), "{topic}");
    }
    for topic in ["/contacts", "/contacts/markers", "/measure"] {
        assert_eq!(times(&messages[topic]), both(1, 12, 1), "{topic}");
    }
    assert_eq!(times(&messages["/plan/poses"]), both(0, 8, 4));
    assert_eq!(times(&messages["/executed/poses"]), both(0, 12, 4));
    assert_eq!(times(&messages["/outcome"]), [span, second + span]);
    assert_eq!(json(&messages["/outcome"][1])["episode"], 1);
}

#[test]
fn messages_say_what_the_scene_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let mut log = McapLog::create(&path).unwrap();
    let scene = record(&mut log, |_, policy| policy.uncertainty = Some(vec![0.1, 0.2, 0.3]));
    log.finish().unwrap();
    let messages = read(&path);
    let tick = 5; // counted from 1; message `tick`, because message 0 is the state before the first tick
    let command = scene.commands[tick - 1];
    let position = |v: &Option<fox::Vector3>| v.map(|v| [v.x, v.y, v.z]).unwrap();
    let expected: [f64; 3] = command.world_from_gripper.translation.into();

    let cloud: fox::PointCloud = decode(&messages["/observation/points"][tick]);
    let layout: Vec<_> =
        cloud.fields.iter().map(|field| (field.name.as_str(), field.offset, field.r#type)).collect();
    let colors = [("red", 12, 1), ("green", 13, 1), ("blue", 14, 1), ("alpha", 15, 1)];
    assert_eq!(layout, [("x", 0, 7), ("y", 4, 7), ("z", 8, 7)].into_iter().chain(colors).collect::<Vec<_>>());
    assert_eq!((cloud.frame_id.as_str(), cloud.point_stride, cloud.data.len()), ("world", 16, 32));
    let point: [f32; 3] =
        std::array::from_fn(|i| f32::from_le_bytes(cloud.data[4 * i..4 * i + 4].try_into().unwrap()));
    assert_eq!(point, expected.map(|coordinate| coordinate as f32));
    assert_eq!((&cloud.data[12..16], &cloud.data[28..32]), (&[255, 0, 0, 255][..], &[0, 128, 64, 255][..]));
    assert_eq!(cloud.timestamp.unwrap().total_nanos(), 5 * TICK);

    let transforms: fox::FrameTransforms = decode(&messages["/tf"][tick]);
    let names: Vec<_> =
        transforms.transforms.iter().map(|t| (&*t.parent_frame_id, &*t.child_frame_id)).collect();
    assert_eq!(names, [("world", "gripper"), ("world", "gripper_command")]);
    assert_eq!(position(&transforms.transforms[0].translation), expected);
    let q = transforms.transforms[0].rotation.unwrap();
    assert_eq!([q.x, q.y, q.z, q.w], command.world_from_gripper.rotation.quaternion_xyzw());

    let bodies: fox::SceneUpdate = decode(&messages["/scene"][tick]);
    assert_eq!(bodies.entities.iter().map(|entity| &*entity.id).collect::<Vec<_>>(), ["table", "gripper"]);
    assert_eq!(position(&bodies.entities[0].cubes[0].size), [1.0, 0.8, 0.02]);
    let mesh = &bodies.entities[1].triangles[0];
    assert_eq!((mesh.points.len(), &mesh.indices[..6]), (4, &[0, 2, 1, 0, 1, 3][..]));
    assert_eq!(position(&mesh.pose.unwrap().position), expected);
    let color = mesh.color.unwrap();
    assert_eq!([color.r, color.g, color.b, color.a], [0.2, 0.4, 1.0, 1.0]);
    assert_eq!(bodies.deletions.len(), 1);

    let opening = json(&messages["/gripper/opening"][tick]);
    assert_eq!(
        (opening["commanded"].as_f64(), opening["reached"].as_f64()),
        (Some(command.opening), Some(command.opening))
    );
    assert_eq!(json(&messages["/contacts"][0])["contacts"], serde_json::json!([]));
    let contacts = json(&messages["/contacts"][1]);
    assert_eq!(
        (&contacts["total_force_n"], &contacts["contacts"][0]["body_b"]),
        (&4.0.into(), &"handle".into())
    );
    let markers: fox::SceneUpdate = decode(&messages["/contacts/markers"][1]);
    assert_eq!(position(&markers.entities[0].spheres[0].pose.unwrap().position), [0.1, 0.2, 0.3]);

    let plan: fox::PosesInFrame = decode(&messages["/plan/poses"][1]);
    assert_eq!(plan.poses.len(), STEPS - 1);
    let executed: fox::PosesInFrame = decode(&messages["/executed/poses"][3]);
    assert_eq!(executed.poses.len(), 13);
    assert_eq!(position(&executed.poses[tick].position), expected);
    assert_eq!(json(&messages["/plan/uncertainty"][0])["per_action"], serde_json::json!([0.1, 0.2, 0.3]));
    let outcome = json(&messages["/outcome"][0]);
    assert_eq!((&outcome["success"], &outcome["measure_name"]), (&true.into(), &"distance_m".into()));
    assert_eq!(json(messages["/measure"].last().unwrap())["measure"], outcome["measure"]);
}

#[test]
fn a_summary_states_the_figures() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let mut log = McapLog::create(&path).unwrap();
    record(&mut log, |_, _| {});
    log.finish().unwrap();
    let summary = McapSummary::read(&path).unwrap();
    assert_eq!((summary.start_nanos, summary.end_nanos), (0, 12 * TICK));
    assert_eq!(summary.messages, 4 * 13 + 3 * 12 + 3 + 4 + 1);
    let topic = |name: &str| summary.topics.iter().find(|topic| topic.topic == name).unwrap();
    let points = topic("/observation/points");
    assert_eq!((points.schema.as_str(), points.encoding.as_str()), ("foxglove.PointCloud", "protobuf"));
    assert_eq!((points.messages, points.spacing_nanos), (13, Some([TICK_NANOS; 3])));
    assert_eq!(topic("/outcome").spacing_nanos, None);
    assert_eq!(topic("/measure").encoding, "json");
    assert!(summary.topics.iter().all(|topic| topic.strictly_increasing));
    let text = serde_json::to_string(&summary).unwrap();
    assert_eq!(serde_json::from_str::<McapSummary>(&text).unwrap(), summary);
}

#[test]
fn the_same_rollout_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |name: &str| {
        let mut log = McapLog::create(folder.path().join(name)).unwrap();
        record(&mut log, |_, _| {});
        log.finish().unwrap();
        std::fs::read(folder.path().join(name)).unwrap()
    };
    assert_eq!(bytes("first.mcap"), bytes("second.mcap"));
}

#[test]
fn an_episode_that_halts_at_once_is_logged_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let mut log = McapLog::create(&path).unwrap();
    record(&mut log, |scene, _| scene.object_lost_at = Some(0));
    record(&mut log, |scene, _| scene.object_lost_at = Some(5));
    log.finish().unwrap();
    let messages = read(&path);
    assert_eq!(times(&messages["/outcome"]), [0, GAP_NANOS + 5 * TICK]);
    assert_eq!(json(&messages["/outcome"][0])["halt"], serde_json::to_value(Halt::ObjectLost).unwrap());
    assert_eq!(messages["/observation/points"].len(), 1 + 6);
}

#[test]
fn a_log_that_is_not_finished_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    std::fs::write(&path, "old").unwrap();
    let mut log = McapLog::create(&path).unwrap();
    record(&mut log, |_, _| {});
    drop(log);
    assert_eq!(std::fs::read(&path).unwrap(), b"old");

    // A scene whose clock stands still.
    let mut log = McapLog::create(&path).unwrap();
    let mut scene = record(&mut log, |_, _| {});
    scene.ticks = 0;
    let goal = scene.goal;
    let tick = scene.tick(&goal).unwrap();
    log.on_tick(&tick, &mut scene);
    log.on_tick(&tick, &mut scene);
    let message = log.finish().unwrap_err().to_string();
    let expected = "/observation/points at 50000000 ns does not come after 600000000 ns";
    assert_eq!(message, format!("{}: {expected}", path.display()));
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn what_is_no_log_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let message = |path: &Path| McapSummary::read(path).unwrap_err().to_string();
    assert!(McapLog::create(folder.path().join("nowhere/log.mcap")).is_err());
    assert!(message(&path).contains("No such file"));
    std::fs::write(&path, "hello").unwrap();
    assert!(message(&path).ends_with("log.mcap: is not an MCAP file (it does not start like one)"));
    let mut log = McapLog::create(&path).unwrap();
    record(&mut log, |_, _| {});
    log.finish().unwrap();
    let whole = std::fs::read(&path).unwrap();
    for length in (mcap::MAGIC.len()..whole.len()).step_by(97) {
        std::fs::write(&path, &whole[..length]).unwrap();
        assert!(message(&path).contains("is a broken MCAP file, perhaps cut off"), "cut to {length} bytes");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn a_wrong_byte_is_noticed_or_does_not_matter(at: prop::sample::Index, byte: u8) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.mcap");
        let mut log = McapLog::create(&path).unwrap();
        record(&mut log, |_, _| {});
        log.finish().unwrap();
        let intact = McapSummary::read(&path).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        let at = at.index(bytes.len());
        bytes[at] = byte;
        std::fs::write(&path, &bytes).unwrap();
        match McapSummary::read(&path) {
            Ok(read) => prop_assert_eq!(read, intact, "damage that no checksum noticed"),
            Err(fault) => prop_assert!(fault.to_string().contains("log.mcap: is "), "{}", fault),
        }
    }
}

/// Every text in a JSON value that is a path of a message: `/topic` or `/topic.key`, as keys and as values.
fn message_paths(value: &serde_json::Value) -> Vec<String> {
    let own = |text: &str| text.starts_with('/').then(|| text.to_owned());
    match value {
        serde_json::Value::String(text) => own(text).into_iter().collect(),
        serde_json::Value::Array(items) => items.iter().flat_map(message_paths).collect(),
        serde_json::Value::Object(entries) => {
            entries.iter().flat_map(|(key, value)| own(key).into_iter().chain(message_paths(value))).collect()
        }
        _ => Vec::new(),
    }
}

#[test]
fn the_foxglove_layout_shows_topics_and_keys_that_logs_have() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let mut log = McapLog::create(&path).unwrap();
    record(&mut log, |_, _| ());
    log.finish().unwrap();
    let messages = read(&path);

    let layout = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/foxglove_layout.json");
    let layout: serde_json::Value = serde_json::from_slice(&std::fs::read(layout).unwrap()).unwrap();
    let shown = message_paths(&layout["configById"]);
    assert!(shown.len() >= 9, "{shown:?}");
    for path in shown {
        let (topic, key) = path.split_once('.').unwrap_or((&path, ""));
        let last = messages.get(topic).unwrap_or_else(|| panic!("no message on {topic}")).last().unwrap();
        assert!(key.is_empty() || json(last)[key].is_number(), "{path} is no number");
    }
}

#[test]
fn a_trainings_notes_become_topics_on_which_an_update_takes_a_second() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("training.mcap");
    let lines = "{\"update\":1,\"loss\":2.5}\n{\"update\":2,\"loss\":1.5}\n{\"update\":2,\"d_geo\":0.25}\n";
    let notes = |name: &str, lines: &str| TrainingNotes { name: name.to_owned(), lines: lines.to_owned() };
    let both = [notes("train", lines), notes("train-2", "{\"update\":1,\"loss\":0.5}")];
    write_training_log(&path, &both).unwrap();
    let messages = read(&path);
    assert_eq!(
        messages.keys().collect::<Vec<_>>(),
        ["/train-2/updates", "/train/updates", "/train/validations"]
    );
    assert_eq!(times(&messages["/train/updates"]), [1_000_000_000, 2_000_000_000]);
    assert_eq!(json(&messages["/train/updates"][1])["loss"], 1.5);
    assert_eq!(json(&messages["/train/validations"][0])["d_geo"], 0.25);
    assert_eq!(json(&messages["/train-2/updates"][0])["loss"], 0.5);
    McapSummary::read(&path).unwrap();

    let before = std::fs::read(&path).unwrap();
    for (lines, part) in [
        ("{\"loss\":1}", "line 1 of train"),
        ("{\"update\":2,\"loss\":1}\n{\"update\":2,\"loss\":1}", "after"),
    ] {
        let fault = write_training_log(&path, &[notes("train", lines)]).unwrap_err().to_string();
        assert!(fault.contains(part), "{fault}");
        assert!(std::fs::read(&path).unwrap() == before, "the older log was touched");
    }
}
