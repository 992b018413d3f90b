//! What the root carries apart from the legs, and whether it has room [Grey 4.1.1].

use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::spatial::{rotation_about, yaw_of};

use super::station::Station;
use crate::body::{Body, Configuration};
use crate::collision::CollisionModel;
use crate::prepare::Preparation;

/// Crouches and leans that are tried: the share of the standing height and the pitch, rad.
const STOOPS: [(f64, f64); 6] =
    [(1.0, 0.0), (0.92, 0.1), (0.84, 0.2), (0.75, 0.3), (0.66, 0.35), (1.06, 0.0)];

/// The legs are looked for from this far above the soles, m: rough ground is not in their way.
const SOLE_LIFT: f64 = 0.05;
/// Half the thickness of what hangs from a hip to a sole, m.
const LINE: f64 = 0.005;

/// How much room the root has at a station.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Room {
    /// Not even the part that is rigid with the root has room: C_N fails.
    None,
    /// What is rigid with the root has room in some stoop, but not the arms, waist and head as they
    /// stand.
    Core,
    /// All that the root carries has room in some stoop.
    Stooped,
    /// All that the root carries has room with the robot upright.
    Upright,
}

/// The robot above its legs, in its standing posture.
#[derive(Debug, Clone)]
pub struct Torso {
    root_from_links: Vec<Pose>,
    is_core: Vec<bool>,
    is_upper: Vec<bool>,
    /// The root in the frame of a station, standing upright.
    station_from_root: Pose,
    root_from_hips: [DVec3; 2],
}

impl Torso {
    /// Compiles the upper body of a robot.
    pub fn new(model: &RobotModel, body: &Body) -> Self {
        let at_origin = Configuration { world_from_root: Pose::IDENTITY, q: body.standing_q };
        let standing = body.snapshot(&at_origin);
        let root_from_links: Vec<Pose> =
            (0..model.links.len()).map(|link| body.world_from_link(&standing, link)).collect();
        let mut is_core = vec![true; model.links.len()];
        let mut is_upper = vec![true; model.links.len()];
        for (index, link) in model.links.iter().enumerate() {
            let Some(attachment) = &link.parent else { continue };
            let in_a_leg = |joint: usize| {
                body.legs.iter().any(|leg| leg.joints().iter().any(|known| known.index == joint))
            };
            is_core[index] = is_core[attachment.parent] && attachment.joint.is_none();
            is_upper[index] =
                is_upper[attachment.parent] && !attachment.joint.is_some_and(in_a_leg);
        }
        let soles =
            [0, 1].map(|limb| root_from_links[body.foot_links[limb]] * body.links_from_soles[limb]);
        let middle = soles[0].translation.midpoint(soles[1].translation);
        let upright = rotation_about(DVec3::Z, -yaw_of(soles[0].rotation));
        let root_from_hips = [0, 1].map(|limb| body.legs[limb].hip());
        Self {
            root_from_links,
            is_core,
            is_upper,
            station_from_root: Pose::from_parts(upright * -middle, upright),
            root_from_hips,
        }
    }

    /// The root in the frame of a station, the robot upright.
    pub fn station_from_root(&self) -> Pose {
        self.station_from_root
    }

    /// Whether all that the root carries has room, but for the legs.
    pub fn has_room_above_legs(&self, collision: &CollisionModel, world_from_root: &Pose) -> bool {
        self.is_free(collision, world_from_root, &self.is_upper)
    }

    /// How much room there is at a station.
    pub fn room(&self, collision: &CollisionModel, station: &Station) -> Room {
        let world_from_station = station.world_from_station();
        let is_free = |stoop: (f64, f64), wanted: &[bool]| {
            self.is_free(collision, &(world_from_station * self.stooped(stoop)), wanted)
        };
        if is_free(STOOPS[0], &self.is_upper) {
            Room::Upright
        } else if STOOPS[1..].iter().any(|&stoop| is_free(stoop, &self.is_upper)) {
            Room::Stooped
        } else if STOOPS.iter().any(|&stoop| is_free(stoop, &self.is_core)) {
            Room::Core
        } else {
            Room::None
        }
    }

    /// Whether the legs may hang down to the soles: in some stoop that has room something is not in
    /// the way from a hip to its sole, or from between the hips to between the soles. What bars all
    /// three is a floor or a ceiling, through which no elevation is projected [Grey 4.3].
    pub fn hangs_over(
        &self,
        collision: &CollisionModel,
        station: &Station,
        world_from_soles: [&Pose; 2],
    ) -> bool {
        let soles = world_from_soles.map(|pose| *pose * (DVec3::Z * SOLE_LIFT));
        let is_barred = |from: DVec3, to: DVec3| {
            let way = to - from;
            let rotation = DQuat::from_rotation_arc(DVec3::Z, way.normalize());
            collision
                .box_hit(
                    &Pose::from_parts(from.midpoint(to), rotation),
                    DVec3::new(LINE, LINE, 0.5 * way.length()),
                )
                .is_some()
        };
        STOOPS.iter().any(|&stoop| {
            let world_from_root = station.world_from_station() * self.stooped(stoop);
            let hips = self.root_from_hips.map(|hip| world_from_root * hip);
            let ways = [
                (soles[0].midpoint(soles[1]), hips[0].midpoint(hips[1])),
                (soles[0], hips[0]),
                (soles[1], hips[1]),
            ];
            ways.iter().any(|&(sole, hip)| !is_barred(sole, hip))
                && self.is_free(collision, &world_from_root, &self.is_core)
        })
    }

    /// Whether both soles may be in reach at once in some stoop, by the reachable spaces R
    /// [Grey 4.2.1].
    pub fn may_reach(
        &self,
        preparation: &Preparation<'_>,
        station: &Station,
        world_from_soles: [&Pose; 2],
    ) -> bool {
        let world_from_station = station.world_from_station();
        STOOPS.iter().any(|&stoop| {
            let root_from_world = (world_from_station * self.stooped(stoop)).inverse();
            (0..2).all(|limb| {
                preparation.may_reach(limb, root_from_world * world_from_soles[limb].translation)
            })
        })
    }

    /// Whether the wanted ones of the links that the root carries have room.
    fn is_free(&self, collision: &CollisionModel, world_from_root: &Pose, wanted: &[bool]) -> bool {
        collision.carried_hit(world_from_root, &self.root_from_links, wanted).is_none()
    }

    /// The root in the frame of a station, in a stoop.
    fn stooped(&self, (share, pitch): (f64, f64)) -> Pose {
        let mut station_from_root = self.station_from_root;
        station_from_root.translation.z *= share;
        station_from_root.rotation *= rotation_about(DVec3::Y, pitch);
        station_from_root
    }
}
