//! Contact reports: what touches what, how hard and how deep.

use rapier3d::prelude::PhysicsWorld;
use reseflow_data::Contact;

/// Below this depth and without any force two bodies are neighbours, not touching.
const TOUCHING_N: f64 = 1e-6;

/// One report for each pair of bodies that touch, sorted by name.
///
/// `name_of` gives a collider's body name from its user data. Force is the sum of the normal forces of the last
/// physics step, depth the deepest penetration, the point the deepest contact's.
pub(crate) fn report(physics: &PhysicsWorld, name_of: impl Fn(u128) -> String) -> Vec<Contact> {
    let dt = f64::from(physics.integration_parameters.dt);
    let mut contacts: Vec<Contact> = Vec::new();
    for pair in physics.narrow_phase.contact_pairs() {
        let (Some(first), Some(second)) =
            (physics.colliders.get(pair.collider1), physics.colliders.get(pair.collider2))
        else {
            continue;
        };
        let mut force_n = 0.0;
        let mut deepest: Option<(f64, [f64; 3])> = None;
        for point in pair.solver_manifolds().iter().flat_map(|manifold| &manifold.points) {
            force_n += f64::from(point.data.impulse) / dt;
            let depth = f64::from(-point.dist);
            if deepest.is_none_or(|(depth_so_far, _)| depth > depth_so_far) {
                let world_point = first.position().transform_point(point.local_p1);
                deepest = Some((depth, world_point.to_array().map(f64::from)));
            }
        }
        let Some((depth, point_m)) = deepest else { continue };
        if force_n <= TOUCHING_N && depth <= 0.0 {
            continue;
        }
        let (mut body_a, mut body_b) = (name_of(first.user_data), name_of(second.user_data));
        if body_b < body_a {
            std::mem::swap(&mut body_a, &mut body_b);
        }
        contacts.push(Contact { body_a, body_b, point_m, force_n, depth_m: depth.max(0.0) });
    }
    contacts.sort_by(|a, b| (&a.body_a, &a.body_b).cmp(&(&b.body_a, &b.body_b)));
    contacts
}
