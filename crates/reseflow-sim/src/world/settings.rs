//! The physics engine's settings for a tabletop.
//!
//! rapier's defaults suit metre-sized objects. Here lengths are centimetres, grip forces tens of newtons, and contact
//! is what the tasks are about, so contacts are solved finely (`length_unit`, Coulomb friction at every contact point)
//! and stiffly (a 20 N grip must sink in by well under a millimetre). What has sunk in is pushed out as fast as the gripper
//! moves: at the engine's own limit, 0.3 m/s at this length unit, wild commands drive the brush's handle 17 mm into the board.

use rapier3d::prelude::{FrictionModel, IntegrationParameters, SpringCoefficients};

use crate::error::{SimError, expect};

/// Length of one control tick, nanoseconds: the paper's 0.05 s.
pub(crate) const TICK_NANOS: i64 = 50_000_000;

/// How stiff contacts are: the natural frequency with which touching bodies part, hertz.
const CONTACT_HZ: f32 = 400.0;
/// The greatest speed with which they part, metres per second, over the length unit.
const PARTING_SPEED: f32 = 30.0;

/// The fewest and the most physics steps per control tick.
const SUBSTEPS: [usize; 2] = [12, 1000];
/// The carriage's damper is explicit: its rate times the physics step may be this.
const CARRIAGE_STEP_RAD: f64 = 0.3;

/// How a world is simulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhysicsSettings {
    /// Physics steps per control tick of 0.05 s, 12 to 1000.
    ///
    /// The carriage's and the fingers' dampers are explicit and add up on the palm; with 10 steps they are near their
    /// limit of stability, and palm and fingers ring against each other.
    pub substeps: usize,
    /// The greatest force of the carriage, newtons.
    pub carriage_force_n: f64,
    /// The greatest torque of the carriage, newton metres.
    pub carriage_torque_nm: f64,
    /// The natural frequency ω of the critically damped carriage, rad/s; ω·dt may be 0.3.
    pub carriage_rate_rad_s: f64,
    /// The greatest force of each finger, newtons; the force with which opening 0 grips.
    pub grip_force_n: f64,
    /// Coulomb friction of the pads; the greater of two touching surfaces' coefficients counts.
    pub pad_friction: f64,
}

impl Default for PhysicsSettings {
    fn default() -> Self {
        Self {
            substeps: 16,
            carriage_force_n: 60.0,
            carriage_torque_nm: 6.0,
            carriage_rate_rad_s: 60.0,
            grip_force_n: 20.0,
            pad_friction: 1.0,
        }
    }
}

impl PhysicsSettings {
    /// Checks that the world can be simulated so.
    ///
    /// # Errors
    /// [`SimError::Setting`]: the first setting that is out of its range.
    pub fn validate(&self) -> Result<(), SimError> {
        let [least, most] = SUBSTEPS;
        let in_range = (least..=most).contains(&self.substeps);
        expect(in_range, "substeps", self.substeps, format!("{least} to {most}"))?;
        for (key, value) in [
            ("carriage_force_n", self.carriage_force_n),
            ("carriage_torque_nm", self.carriage_torque_nm),
            ("carriage_rate_rad_s", self.carriage_rate_rad_s),
            ("grip_force_n", self.grip_force_n),
        ] {
            expect(value.is_finite() && value > 0.0, key, value, "a number greater than 0")?;
        }
        let fastest = CARRIAGE_STEP_RAD / self.dt_secs();
        expect(
            self.carriage_rate_rad_s <= fastest,
            "carriage_rate_rad_s",
            self.carriage_rate_rad_s,
            format!("at most {fastest:.1} with {} substeps", self.substeps),
        )?;
        let is_friction = self.pad_friction.is_finite() && self.pad_friction >= 0.0;
        expect(is_friction, "pad_friction", self.pad_friction, "a number, 0 or more")
    }

    /// Length of one physics step, seconds.
    pub fn dt_secs(&self) -> f64 {
        TICK_NANOS as f64 * 1e-9 / self.substeps.max(1) as f64
    }

    /// The engine's parameters.
    pub(crate) fn integration_parameters(&self) -> IntegrationParameters {
        IntegrationParameters {
            dt: self.dt_secs() as f32,
            length_unit: 0.1,
            num_solver_iterations: 4,
            normalized_max_corrective_velocity: PARTING_SPEED,
            friction_model: FrictionModel::Coulomb,
            contact_recycling: false,
            contact_clustering: false,
            warmstart_joints: true,
            contact_softness: SpringCoefficients::new(CONTACT_HZ, 1.0),
            static_contact_softness: SpringCoefficients::new(CONTACT_HZ, 1.0),
            ..IntegrationParameters::default()
        }
    }
}
