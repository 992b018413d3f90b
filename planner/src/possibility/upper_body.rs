//! The upper body: all links that the root carries except the legs, and where they are free
//! [Grey 4.1.1].

use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, yaw_of};
use surefoot_shared_types::robot::model::RobotModel;

use crate::collision::model::CollisionModel;
use crate::constraints::waist::Waist;
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::tuning::{LEG_HALF_WIDTH, SOLE_CLEARANCE, UPPER_BODY_CROUCHES};
use crate::preparation::Preparation;
use crate::robot::configuration::Configuration;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;

/// Postures in which the upper body is free at a pose (C_N).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum UpperBodyFit {
    /// Not even the links rigid with the root are free: C_N fails.
    None,
    /// The links rigid with the root are free in some crouch, but not arms, waist and head.
    Core,
    /// The whole upper body is free in some crouch.
    Crouched,
    /// The whole upper body is free with the robot upright.
    Upright,
}

/// Whether both soles are in the reachable space R of a root pose [Grey 4.2.1].
pub(crate) fn is_in_reach(
    preparation: &Preparation,
    world_from_root: &Pose,
    world_from_soles: [&Pose; 2],
) -> bool {
    let root_from_world = world_from_root.inverse();
    (0..2).all(|limb| {
        preparation.may_reach(limb, root_from_world * world_from_soles[limb].translation)
    })
}

/// The robot above its legs, in its standing posture.
#[derive(Debug)]
pub struct UpperBody {
    /// The links in the root frame, the waist straight.
    root_from_links: Vec<Pose>,
    /// The links in the root frame, the waist bent forward.
    root_from_bent_links: Vec<Pose>,
    /// For each link: whether it is rigid with the root.
    is_core: Vec<bool>,
    /// For each link: whether no leg moves it.
    is_upper: Vec<bool>,
    /// For each link: whether it belongs to the trunk, which moves with the root and the waist.
    is_trunk: Vec<bool>,
    /// The root in the mid-feet frame, the robot upright.
    mid_feet_from_root: Pose,
    root_from_hips: [DVec3; 2],
}

impl UpperBody {
    /// Compiles the upper body of a robot. Allocates.
    pub fn new(model: &RobotModel, robot: &Mechanism, waist: Option<&Waist>) -> Self {
        let mut bent_q = robot.standing_q;
        if let Some(waist) = waist {
            waist.bend(&mut bent_q, waist.bend_max);
        }
        let [root_from_links, root_from_bent_links] = [robot.standing_q, bent_q].map(|q| {
            let at_origin = Configuration { world_from_root: Pose::IDENTITY, q };
            let state = KinematicState::new(robot, &at_origin);
            let links = 0..model.links.len();
            links.map(|link| state.world_from_link(robot, link)).collect::<Vec<Pose>>()
        });
        let mut is_core = vec![true; model.links.len()];
        let mut is_upper = vec![true; model.links.len()];
        let mut is_trunk = vec![true; model.links.len()];
        for (index, link) in model.links.iter().enumerate() {
            let Some(attachment) = &link.parent else { continue };
            let in_a_leg = |joint: usize| {
                robot.legs.iter().any(|leg| leg.joints().iter().any(|known| known.index == joint))
            };
            let in_trunk =
                |joint: usize| robot.trunk_joints.iter().any(|known| known.index == joint);
            is_core[index] = is_core[attachment.parent] && attachment.joint.is_none();
            is_trunk[index] = is_trunk[attachment.parent] && attachment.joint.is_none_or(in_trunk);
            is_upper[index] =
                is_upper[attachment.parent] && !attachment.joint.is_some_and(in_a_leg);
        }
        let soles = [0, 1]
            .map(|limb| root_from_links[robot.soles[limb].link] * robot.soles[limb].link_from_sole);
        let middle = soles[0].translation.midpoint(soles[1].translation);
        let upright = rotation_about(DVec3::Z, -yaw_of(soles[0].rotation));
        let root_from_hips = [0, 1].map(|limb| robot.legs[limb].hip());
        Self {
            root_from_links,
            root_from_bent_links,
            is_core,
            is_upper,
            is_trunk,
            mid_feet_from_root: Pose::from_parts(upright * -middle, upright),
            root_from_hips,
        }
    }

    /// The root in the mid-feet frame, the robot upright.
    pub fn mid_feet_from_root(&self) -> Pose {
        self.mid_feet_from_root
    }

    /// Whether the upper body is free at a root pose, the waist straight or bent as far as it goes.
    pub fn is_free_above_legs(
        &self,
        collision: &CollisionModel,
        world_from_root: &Pose,
        is_bent: bool,
    ) -> bool {
        let links = if is_bent { &self.root_from_bent_links } else { &self.root_from_links };
        collision.links_hit(world_from_root, links, &self.is_upper).is_none()
    }

    /// Whether the trunk is free at a root pose.
    pub fn is_trunk_free(&self, collision: &CollisionModel, world_from_root: &Pose) -> bool {
        self.are_links_free(collision, world_from_root, &self.is_trunk)
    }

    /// The fit of the upper body at a pose.
    pub fn fit(&self, collision: &CollisionModel, pose: &MidFeetPose) -> UpperBodyFit {
        let world_from_mid_feet = pose.world_from_mid_feet();
        let is_free = |crouch: (f64, f64), selected: &[bool]| {
            self.are_links_free(collision, &(world_from_mid_feet * self.crouched(crouch)), selected)
        };
        if is_free(UPPER_BODY_CROUCHES[0], &self.is_upper) {
            UpperBodyFit::Upright
        } else if UPPER_BODY_CROUCHES[1..].iter().any(|&crouch| is_free(crouch, &self.is_upper)) {
            UpperBodyFit::Crouched
        } else if UPPER_BODY_CROUCHES.iter().any(|&crouch| is_free(crouch, &self.is_core)) {
            UpperBodyFit::Core
        } else {
            UpperBodyFit::None
        }
    }

    /// Whether a leg can extend down to the soles. In some crouch with a free core, the line from a
    /// hip to its sole or from the midpoint of the hips to that of the soles is free. If all three
    /// are blocked, a floor or a ceiling lies between them, through which no elevation is projected
    /// [Grey 4.3].
    pub fn are_legs_free(
        &self,
        collision: &CollisionModel,
        pose: &MidFeetPose,
        world_from_soles: [&Pose; 2],
    ) -> bool {
        UPPER_BODY_CROUCHES.iter().any(|&crouch| {
            let world_from_root = pose.world_from_mid_feet() * self.crouched(crouch);
            self.is_leg_free(collision, &world_from_root, world_from_soles)
                && self.are_links_free(collision, &world_from_root, &self.is_core)
        })
    }

    /// Whether a leg can extend down to the soles from a root pose: the line from a hip to its sole
    /// or from the midpoint of the hips to that of the soles is free.
    pub fn is_leg_free(
        &self,
        collision: &CollisionModel,
        world_from_root: &Pose,
        world_from_soles: [&Pose; 2],
    ) -> bool {
        let soles = world_from_soles.map(|pose| *pose * (DVec3::Z * SOLE_CLEARANCE));
        let is_blocked = |from: DVec3, to: DVec3| {
            let offset = to - from;
            let rotation = DQuat::from_rotation_arc(DVec3::Z, offset.normalize());
            collision
                .box_hit(
                    &Pose::from_parts(from.midpoint(to), rotation),
                    DVec3::new(LEG_HALF_WIDTH, LEG_HALF_WIDTH, 0.5 * offset.length()),
                )
                .is_some()
        };
        let hips = self.root_from_hips.map(|hip| *world_from_root * hip);
        let lines = [
            (soles[0].midpoint(soles[1]), hips[0].midpoint(hips[1])),
            (soles[0], hips[0]),
            (soles[1], hips[1]),
        ];
        lines.iter().any(|&(sole, hip)| !is_blocked(sole, hip))
    }

    /// Whether both soles may be in reach at once in some crouch, by the reachable spaces R
    /// [Grey 4.2.1].
    pub fn may_reach(
        &self,
        preparation: &Preparation,
        pose: &MidFeetPose,
        world_from_soles: [&Pose; 2],
    ) -> bool {
        let world_from_mid_feet = pose.world_from_mid_feet();
        UPPER_BODY_CROUCHES.iter().any(|&crouch| {
            let world_from_root = world_from_mid_feet * self.crouched(crouch);
            is_in_reach(preparation, &world_from_root, world_from_soles)
        })
    }

    /// Whether the selected links are free.
    fn are_links_free(
        &self,
        collision: &CollisionModel,
        world_from_root: &Pose,
        selected: &[bool],
    ) -> bool {
        collision.links_hit(world_from_root, &self.root_from_links, selected).is_none()
    }

    /// The root in the mid-feet frame, in a crouch.
    fn crouched(&self, (leg_extension, pitch): (f64, f64)) -> Pose {
        let mut mid_feet_from_root = self.mid_feet_from_root;
        mid_feet_from_root.translation.z *= leg_extension;
        mid_feet_from_root.rotation *= rotation_about(DVec3::Y, pitch);
        mid_feet_from_root
    }
}
