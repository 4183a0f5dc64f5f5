//! Hinges: a revolute joint with stops and Coulomb friction.
//!
//! The friction is a motor that asks for no motion: as stiff as a damper can be, and limited in torque, so that above a
//! creep of [`CREEP_RAD_S`] it brakes with the same torque whatever the speed, and a door stays where it is left.

use nalgebra::Vector3;
use rapier3d::prelude::{MotorModel, RevoluteJointBuilder};

use crate::convert::vec3;
use crate::world::{Object, World};

/// Below this rate the friction torque is proportional to it, rad/s.
const CREEP_RAD_S: f64 = 0.01;

/// How one object hangs on another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hinge {
    /// The axis about which the second object turns by positive angles; both objects' frames have the same axes at angle 0.
    pub(crate) axis: Vector3<f64>,
    /// A point of the axis in the first object's frame, metres.
    pub(crate) anchor_m: Vector3<f64>,
    /// The same point in the second object's frame, metres.
    pub(crate) hung_anchor_m: Vector3<f64>,
    /// The angles at which it stops, radians.
    pub(crate) limits_rad: [f64; 2],
    /// The torque with which it resists motion, newton metres.
    pub(crate) friction_nm: f64,
}

impl World {
    /// Hangs `hung` on `frame`. The two do not collide: the hinge's stops keep them apart.
    pub(crate) fn add_hinge(&mut self, frame: Object, hung: Object, hinge: &Hinge) {
        let joint = RevoluteJointBuilder::new(vec3(&hinge.axis))
            .local_anchor1(vec3(&hinge.anchor_m))
            .local_anchor2(vec3(&hinge.hung_anchor_m))
            .limits(hinge.limits_rad.map(|limit| limit as f32))
            .motor_model(MotorModel::ForceBased)
            .motor_velocity(0.0, (hinge.friction_nm / CREEP_RAD_S) as f32)
            .motor_max_force(hinge.friction_nm as f32)
            .contacts_enabled(false);
        self.physics.insert_impulse_joint(self.objects[frame.0], self.objects[hung.0], joint.build());
    }
}
