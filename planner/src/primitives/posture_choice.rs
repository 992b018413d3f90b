//! The postures that are tried for a transition: primitive ones, deviations from them
//! [Grey 4.4.5], and random ones.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec2, DVec3};
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::{rotation_about, rotation_from_rpy};

use crate::base::random::Random;
use crate::constraints::constraints::Constraints;
use crate::constraints::mode::Mode;
use crate::geometry::convex_region::ConvexRegion;
use crate::primitives::level_sole::side_of;
use crate::primitives::transition_pair::TransitionPair;
use crate::primitives::tuning::{
    COM_SPREAD, EXTENSION_SPREAD, FREE_JOINT_SPREAD, LEAN_BOUNDS, LEAN_SPREAD,
    NEIGHBOURHOOD_ATTEMPTS, NEIGHBOURHOOD_SPREAD, PRIMITIVE_POSTURES, PrimitivePosture,
    ROTATION_SPREADS, UNBOUNDED_LEG_EXTENSIONS,
};
use crate::robot::crouch::Crouch;
use crate::robot::posture_ik::{COM_TOLERANCE, Posture};
use crate::robot::single_support::SingleSupportPosture;

/// Positions of the joints, of which those of the legs count for nothing.
pub(crate) type FreeJoints = [f64; JOINTS_MAX];

/// The choice of a posture over two footholds.
#[derive(Clone, Copy)]
pub(crate) struct PostureChoice<'a> {
    constraints: &'a Constraints,
    mode: &'a Mode,
    pair: TransitionPair<'a>,
    /// Distance of the centre of mass from the edge of the mode's region, m.
    com_margin: f64,
}

impl<'a> PostureChoice<'a> {
    /// The choice for a transition between these footholds.
    pub fn new(constraints: &'a Constraints, mode: &'a Mode, pair: TransitionPair<'a>) -> Self {
        Self { constraints, mode, pair, com_margin: constraints.com_margin(mode) }
    }

    /// The posture of an attempt and its free joints: a primitive posture, or a random deviation
    /// from one.
    pub fn near_primitive(&self, attempt: u64, stream: &mut Random) -> (Posture, FreeJoints) {
        let primitives = PRIMITIVE_POSTURES.len() as u64;
        let primitive = &PRIMITIVE_POSTURES[(attempt % primitives) as usize];
        let uniform = attempt >= primitives + NEIGHBOURHOOD_ATTEMPTS;
        let spread = match attempt {
            _ if uniform => 1.0,
            _ if attempt >= primitives => NEIGHBOURHOOD_SPREAD,
            _ => 0.0,
        };
        let Self { constraints, mode, pair, com_margin } = *self;
        let crouch = pair.stance.crouch.deeper(pair.other.crouch);
        let mut jitter = |half: f64| spread * stream.uniform(-half, half);
        let world_from_root = self.rotation_near(primitive, crouch, &mut jitter);
        let leg_extension = crouch.leg_extension
            * (primitive.extension + jitter(EXTENSION_SPREAD))
            * constraints.robot.standing_leg_extension;
        let lean = (primitive.lean + jitter(LEAN_SPREAD)).clamp(LEAN_BOUNDS[0], LEAN_BOUNDS[1]);
        let mut free = constraints.single_support_postures[pair.stance.limb].q;
        constraints.bend_waist(&mut free, crouch.waist);
        if uniform {
            self.spread_free_joints(crouch, &mut free, &mut jitter);
        }
        let other = pair.other.region.centroid();
        let target = lean_target(&mode.region, other, lean, com_margin + 2.0 * COM_TOLERANCE);
        let com = target + DVec2::new(jitter(COM_SPREAD), jitter(COM_SPREAD));
        (Posture { world_from_root, leg_extension, com }, free)
    }

    /// The root's rotation of a primitive posture, jittered.
    fn rotation_near(
        &self,
        primitive: &PrimitivePosture,
        crouch: Crouch,
        jitter: &mut dyn FnMut(f64) -> f64,
    ) -> DQuat {
        let side = side_of(self.pair.stance.limb);
        let SingleSupportPosture { rotation: [roll, pitch], .. } =
            self.constraints.single_support_postures[self.pair.stance.limb];
        let [yaw_spread, roll_spread, pitch_spread] = ROTATION_SPREADS;
        rotation_about(DVec3::Z, self.pair.heading() + jitter(yaw_spread))
            * rotation_from_rpy(
                roll - side * primitive.roll + crouch.roll + jitter(roll_spread),
                pitch + primitive.pitch + crouch.pitch + jitter(pitch_spread),
                0.0,
            )
    }

    /// Moves the free joints that are sampled, but for a bent waist, within their limits.
    fn spread_free_joints(
        &self,
        crouch: Crouch,
        free: &mut FreeJoints,
        jitter: &mut dyn FnMut(f64) -> f64,
    ) {
        let waist = self.constraints.waist.filter(|_| crouch.waist > 0.0);
        let is_bent = |index| waist.is_some_and(|waist| waist.joint() == index);
        let joints = self.constraints.robot.free_joints.iter();
        for joint in joints.filter(|joint| joint.is_sampled && !is_bent(joint.index)) {
            let position = free[joint.index] + jitter(FREE_JOINT_SPREAD);
            free[joint.index] = position.clamp(joint.lower, joint.upper);
        }
    }

    /// A random posture anywhere: every rotation of the root, every leg extension, every point of
    /// the region for the centre of mass, and all positions of the free joints within their limits.
    /// Half of the range in the middle is drawn more often, since most postures at the limits
    /// collide.
    pub fn anywhere(&self, stream: &mut Random) -> (Posture, FreeJoints) {
        let Self { constraints, mode, pair, com_margin } = *self;
        let share = stream.uniform(0.0, 1.0);
        let mut angle = |half: f64| share * stream.uniform(-half, half);
        let rotation = rotation_about(DVec3::Z, pair.heading() + angle(PI))
            * rotation_from_rpy(angle(PI), angle(FRAC_PI_2), 0.0);
        let mut free = constraints.single_support_postures[pair.stance.limb].q;
        let share = stream.uniform(0.0, 1.0);
        for joint in constraints.robot.free_joints.iter().filter(|joint| joint.is_sampled) {
            let position = &mut free[joint.index];
            *position += share * (stream.uniform(joint.lower, joint.upper) - *position);
        }
        let leg_extension =
            stream.uniform(UNBOUNDED_LEG_EXTENSIONS[0], UNBOUNDED_LEG_EXTENSIONS[1]);
        let (sin, cos) = libm::sincos(stream.uniform(-PI, PI));
        let centroid = mode.region.centroid();
        let extents = mode.region.vertices().iter().map(|vertex| vertex.distance(centroid));
        let offset = extents.fold(0.0, f64::max) * libm::sqrt(stream.uniform(0.0, 1.0));
        let drawn = centroid + offset * DVec2::new(cos, sin);
        let com = mode.region.nearest_inside(drawn, com_margin + 2.0 * COM_TOLERANCE);
        (Posture { world_from_root: rotation, leg_extension, com }, free)
    }
}

/// The point at the fraction `lean` from the region's centroid to the point nearest to `other` that
/// keeps the margin (m).
fn lean_target(region: &ConvexRegion, other: DVec2, lean: f64, margin: f64) -> DVec2 {
    let centroid = region.centroid();
    let limit = region.nearest_inside(other, margin);
    centroid + lean * (limit - centroid)
}
