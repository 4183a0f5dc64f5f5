//! The camera sees surfaces, and only those that nothing hides.

use reseflow_data::{PointCloud, Split};
use reseflow_lie::{SE3, Vector3};
use reseflow_sim::{
    CameraSettings, PhysicsSettings, Selection, TriangleSetup, TriangleTask, configured_task, is_salient,
    overview_camera, render, task, tasks,
};

use crate::support::key;

const HEIGHT_M: f64 = 0.025;

fn cloud(setup: &TriangleSetup, camera: CameraSettings) -> PointCloud {
    let task = TriangleTask { camera, ..TriangleTask::default() };
    task.scene(setup.clone(), &key("triangle", Split::Train, 1, 0)).unwrap().observe().cloud
}

fn salient(cloud: &PointCloud) -> usize {
    cloud.colors.iter().filter(|&&rgb| is_salient(rgb)).count()
}

fn noiseless() -> CameraSettings {
    CameraSettings { depth_noise_m: 0.0, ..CameraSettings::default() }
}

/// The prism's side faces as (outward normal, distance from the centre), and the top.
fn faces(setup: &TriangleSetup) -> Vec<(Vector3<f64>, f64)> {
    let inradius = setup.side_m / (2.0 * 3.0_f64.sqrt());
    let side = |turn: i32| {
        let angle = setup.yaw_rad + std::f64::consts::PI + f64::from(turn) * std::f64::consts::TAU / 3.0;
        (Vector3::new(angle.cos(), angle.sin(), 0.0), inradius)
    };
    let mut faces: Vec<_> = (0..3).map(side).collect();
    faces.push((Vector3::z(), 0.5 * HEIGHT_M));
    faces
}

#[test]
fn points_lie_on_the_faces_that_look_at_the_camera() {
    for index in 0..20 {
        let setup = TriangleSetup::draw(&key("triangle", Split::Train, 12, index));
        let center = Vector3::new(setup.center_m[0], setup.center_m[1], 0.5 * HEIGHT_M);
        let eye = setup.camera.world_from_camera.translation - center;
        let mut back_faces = 0;
        for point in cloud(&setup, noiseless()).points {
            let offset = Vector3::from(point.map(f64::from)) - center;
            let seen = faces(&setup).iter().any(|(normal, distance)| {
                normal.dot(&eye) > *distance && (normal.dot(&offset) - distance).abs() < 1e-4
            });
            assert!(seen, "episode {index}: {offset:?} lies on no face that the camera sees");
        }
        back_faces += faces(&setup).iter().filter(|(normal, distance)| normal.dot(&eye) < *distance).count();
        assert!(back_faces > 0, "no face is turned away, the test shows nothing");
    }
}

#[test]
fn what_the_gripper_hides_is_not_seen() {
    let mut setup = TriangleSetup::draw(&key("triangle", Split::Train, 1, 0));
    assert!(salient(&cloud(&setup, noiseless())) >= 24);
    // The palm, 9.5 cm behind the gripper's origin, moves into the line of sight, near the camera.
    let eye = setup.camera.world_from_camera.translation;
    let center = Vector3::new(setup.center_m[0], setup.center_m[1], 0.5 * HEIGHT_M);
    let between = eye + (center - eye) * 0.25;
    let down = SE3::new(setup.world_from_gripper.rotation, between);
    setup.world_from_gripper = SE3::new(down.rotation, down.act(&Vector3::new(0.0, 0.0, 0.095)));
    assert_eq!(salient(&cloud(&setup, noiseless())), 0);
}

#[test]
fn masks_and_the_crop_do_what_they_say() {
    let setup = TriangleSetup::draw(&key("triangle", Split::Train, 1, 4));
    let highest = |cloud: &PointCloud| cloud.points.iter().map(|p| p[2]).fold(f32::MIN, f32::max);
    let lowest = |cloud: &PointCloud| cloud.points.iter().map(|p| p[2]).fold(f32::MAX, f32::min);
    let plain = cloud(&setup, noiseless());
    assert!(highest(&plain) < 0.0251 && lowest(&plain) >= 0.004);
    let with_gripper = cloud(&setup, CameraSettings { mask_gripper: false, ..noiseless() });
    assert!(highest(&with_gripper) > 0.2);
    let with_table = cloud(&setup, CameraSettings { crop_below_m: -1.0, ..noiseless() });
    let on_the_table = |cloud: &PointCloud| cloud.points.iter().filter(|p| p[2].abs() < 1e-4).count();
    assert!(on_the_table(&with_table) > 20);
    let below = cloud(&setup, CameraSettings { crop_below_m: -0.001, ..noiseless() });
    assert!(on_the_table(&below) > 20, "a crop below the table's top leaves the table in");
}

#[test]
fn a_dropped_pixel_returns_nothing_even_where_points_are_few() {
    let setup = TriangleSetup::draw(&key("triangle", Split::Train, 1, 7));
    let distinct = |drop_fraction: f64| {
        let cloud = cloud(&setup, CameraSettings { drop_fraction, ..noiseless() });
        assert_eq!(cloud.len(), 100);
        let points = cloud.points.iter().map(|point| point.map(f32::to_bits));
        points.collect::<std::collections::HashSet<_>>().len()
    };
    // A measurement without noise says which pixel it is from.
    let (few, all) = (distinct(0.95), distinct(0.0));
    assert!((5..80).contains(&few) && all == 100, "{few} pixels of one in twenty, {all} of all");
    assert_eq!(distinct(1.0), 1, "nothing in view is the view's far end");
}

#[test]
fn farthest_point_sampling_ignores_colour() {
    let setup = TriangleSetup::draw(&key("triangle", Split::Train, 1, 6));
    let farthest = cloud(&setup, CameraSettings { selection: Selection::Farthest, ..noiseless() });
    assert_eq!(farthest.len(), 100);
    // The coloured corner is a fifth of the top face.
    assert!((8..45).contains(&salient(&farthest)), "{}", salient(&farthest));
    assert_eq!(salient(&cloud(&setup, noiseless())), 50);
}

#[test]
fn a_second_view_shows_what_the_first_cannot_see() {
    for index in 0..10 {
        let setup = TriangleSetup::draw(&key("triangle", Split::Train, 13, index));
        let center = Vector3::new(setup.center_m[0], setup.center_m[1], 0.5 * HEIGHT_M);
        let eye = setup.camera.world_from_camera.translation - center;
        // The points on side faces that are turned away from the first camera.
        let hidden = |cloud: &PointCloud| {
            let is_hidden = |point: &&[f32; 3]| {
                let offset = Vector3::from(point.map(f64::from)) - center;
                let on = |(normal, distance): &(Vector3<f64>, f64)| {
                    (normal.dot(&offset) - distance).abs() < 1e-4 && offset.z < 0.5 * HEIGHT_M - 1e-3
                };
                let normals = faces(&setup).into_iter().filter(on).collect::<Vec<_>>();
                !normals.is_empty() && normals.iter().all(|(normal, distance)| normal.dot(&eye) < *distance)
            };
            cloud.points.iter().filter(is_hidden).count()
        };
        let one = cloud(&setup, noiseless());
        let both = CameraSettings { second_view_rad: Some(std::f64::consts::PI), ..noiseless() };
        let both = cloud(&setup, both);
        assert_eq!((hidden(&one), both.len()), (0, 100));
        assert!(hidden(&both) > 3, "episode {index}: {} points on the back", hidden(&both));
    }
}

#[test]
fn every_task_can_be_seen_in_every_way() {
    let ways = [
        CameraSettings { selection: Selection::Farthest, ..CameraSettings::default() },
        CameraSettings { crop_below_m: -1.0, mask_gripper: false, ..CameraSettings::default() },
        CameraSettings { second_view_rad: Some(1.2), drop_fraction: 0.3, ..CameraSettings::default() },
    ];
    for name in tasks() {
        let look = |camera| {
            let task = configured_task(name, PhysicsSettings::default(), camera).unwrap();
            let points = task.spec().points;
            let cloud = task.reset(&key(name, Split::Train, 14, 0)).unwrap().observe().cloud;
            assert_eq!((cloud.points.len(), cloud.colors.len()), (points, points));
            cloud
        };
        let usual = look(CameraSettings::default());
        let salient_share = |cloud: &PointCloud| salient(cloud) as f64 / cloud.len() as f64;
        for way in ways {
            let cloud = look(way);
            assert!(cloud.points.iter().flatten().all(|x| x.is_finite()));
            assert_ne!(cloud.points, usual.points, "{name} seen as {way:?}");
            if way.selection == Selection::Farthest {
                assert!(salient_share(&cloud) < salient_share(&usual), "{name}");
            }
        }
    }
}

#[test]
fn depth_noise_has_its_size_and_drops_leave_n_points() {
    let setup = TriangleSetup::draw(&key("triangle", Split::Train, 1, 7));
    let noisy = cloud(&setup, CameraSettings { depth_noise_m: 0.002, drop_fraction: 0.9, ..noiseless() });
    assert_eq!(noisy.len(), 100);
    let center = Vector3::new(setup.center_m[0], setup.center_m[1], 0.5 * HEIGHT_M);
    let nearest_face = |point: [f32; 3]| {
        let offset = Vector3::from(point.map(f64::from)) - center;
        faces(&setup).iter().map(|(n, d)| (n.dot(&offset) - d).abs()).fold(f64::INFINITY, f64::min)
    };
    let mean = noisy.points.iter().map(|&p| nearest_face(p)).sum::<f64>() / 100.0;
    assert!((0.0004..0.003).contains(&mean), "{mean}");
}

#[test]
fn a_picture_shows_table_gripper_and_corner() {
    let setup = TriangleSetup::draw(&key("triangle", Split::Train, 1, 8));
    let scene = TriangleTask::default().scene(setup, &key("triangle", Split::Train, 1, 8)).unwrap();
    let bodies = scene.bodies();
    let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
    let expected = [
        "table",
        "gripper_palm",
        "gripper_finger_left",
        "gripper_finger_right",
        "triangle",
        "triangle_corner",
    ];
    assert_eq!(names, expected);
    let camera = overview_camera(&bodies, 160, 120);
    let whole = render(&bodies, &camera);
    assert_eq!(whole.pixels.len(), 3 * 160 * 120);
    for name in expected {
        let without: Vec<_> = bodies.iter().filter(|body| body.name != name).cloned().collect();
        let other = render(&without, &camera);
        let changed = whole.pixels.chunks(3).zip(other.pixels.chunks(3)).filter(|(a, b)| a != b).count();
        assert!(changed > 10, "{name} is hardly visible: {changed} pixels");
    }
}

#[test]
fn an_overview_shows_everything_but_the_table_whole() {
    for name in tasks() {
        let scene = task(name).unwrap().reset(&key(name, Split::Train, 15, 0)).unwrap();
        let mut bodies = scene.bodies();
        bodies.retain(|body| body.name != "table");
        let camera = overview_camera(&bodies, 96, 72);
        // On black, so that every pixel that is not the backdrop is a body's.
        bodies.iter_mut().for_each(|body| body.color = [0, 0, 0]);
        let picture = render(&bodies, &camera);
        let is_dark = |column: usize, row: usize| picture.pixels[3 * (row * 96 + column)] < 100;
        assert!((0..96).all(|column| !is_dark(column, 0) && !is_dark(column, 71)), "{name}");
        assert!((0..72).all(|row| !is_dark(0, row) && !is_dark(95, row)), "{name}");
        let dark = (0..72 * 96).filter(|pixel| is_dark(pixel % 96, pixel / 96)).count();
        assert!(dark > 150, "{name} is small in its picture: {dark} pixels of 6912");
    }
}
