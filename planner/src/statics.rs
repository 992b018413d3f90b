//! Gravity torques of a robot at rest. Contact forces are taken as vertical, which the inclination bound of foot
//! placements keeps inside the friction cone.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::limits::JOINTS_MAX;
use surefoot_shared_types::robot::{JointKind, RobotModel};
use surefoot_shared_types::scene::GRAVITY;

use crate::body::LINKS_MAX;
use crate::region::Region;

/// The robot's mass tree, compiled for gravity torques.
#[derive(Debug, Clone)]
pub struct Statics {
    parents: Vec<usize>,
    masses: Vec<f64>,
    coms: Vec<DVec3>,
    subtree_masses: Vec<f64>,
    joints: Vec<StaticJoint>,
}

#[derive(Debug, Clone)]
struct StaticJoint {
    child: usize,
    axis: DVec3,
    kind: JointKind,
    effort: f64,
    carries: [bool; 2],
}

/// A vertical force on a foot: the share of the weight, and where it acts in world x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootLoad {
    /// Share of the weight, 0 to 1.
    pub share: f64,
    /// Centre of pressure in world x and y, m.
    pub point: DVec2,
}

impl Statics {
    /// Compiles a robot; only `effort_share` of each joint's effort may be used.
    pub fn new(model: &RobotModel, effort_share: f64) -> Self {
        let parents: Vec<_> = model.links.iter().map(|link| link.parent.as_ref().map_or(0, |at| at.parent)).collect();
        let masses: Vec<_> = model.links.iter().map(|link| link.mass).collect();
        let mut subtree_masses = masses.clone();
        for link in (1..parents.len()).rev() {
            subtree_masses[parents[link]] += subtree_masses[link];
        }
        let chains: Vec<_> = model.feet.iter().map(|foot| model.chain(foot.link)).collect();
        let joints = model.joints.iter().enumerate().map(|(index, joint)| StaticJoint {
            child: joint.child,
            axis: joint.axis,
            kind: joint.kind,
            effort: joint.effort * effort_share,
            carries: [0, 1].map(|limb| chains[limb].contains(&index)),
        });
        let coms = model.links.iter().map(|link| link.com).collect();
        Self { joints: joints.collect(), parents, masses, coms, subtree_masses }
    }

    /// The largest share of a joint's usable effort that gravity asks for when the feet carry `loads`.
    pub fn effort_use(&self, world_from_links: &[Pose], loads: &[FootLoad; 2]) -> f64 {
        let mut torques = [0.0; JOINTS_MAX];
        self.torques(world_from_links, loads, &mut torques);
        self.joints.iter().zip(torques).map(|(joint, torque)| torque.abs() / joint.effort).fold(0.0, f64::max)
    }

    /// The torque (N m) or force (N) that each joint must hold, in joint order.
    pub fn torques(&self, world_from_links: &[Pose], loads: &[FootLoad; 2], torques: &mut [f64; JOINTS_MAX]) {
        let moments = self.subtree_moments(world_from_links);
        let weight = self.subtree_masses[0] * GRAVITY;
        for (joint, torque) in self.joints.iter().zip(torques) {
            let pose = &world_from_links[joint.child];
            let axis = pose.rotation * joint.axis;
            let at = pose.translation;
            let mass = self.subtree_masses[joint.child];
            let down = DVec3::NEG_Z * GRAVITY;
            let mut force = down * mass;
            let mut moment = (moments[joint.child] - at * mass).cross(down);
            for (load, _) in loads.iter().zip(joint.carries).filter(|(_, carries)| *carries) {
                let up = DVec3::Z * (weight * load.share);
                force += up;
                moment += (load.point.extend(at.z) - at).cross(up);
            }
            *torque = match joint.kind {
                JointKind::Revolute => -axis.dot(moment),
                JointKind::Prismatic => -axis.dot(force),
            };
        }
    }

    /// The first mass moment (kg m) of every link's subtree in the world.
    fn subtree_moments(&self, world_from_links: &[Pose]) -> [DVec3; LINKS_MAX] {
        let mut moments = [DVec3::ZERO; LINKS_MAX];
        for link in (0..self.parents.len()).rev() {
            moments[link] += (world_from_links[link] * self.coms[link]) * self.masses[link];
            if link > 0 {
                let moment = moments[link];
                moments[self.parents[link]] += moment;
            }
        }
        moments
    }
}

/// Vertical loads on both feet that balance a centre of mass at `com` with `share` of the weight on foot 1, each within
/// its own support polygon; `None` where this share admits none.
pub fn balance_loads(regions: [&Region; 2], com: DVec2, share: f64) -> Option<[FootLoad; 2]> {
    let shares = [1.0 - share, share];
    let mut points = regions.map(Region::centroid);
    for _ in 0..BALANCE_ITERATIONS {
        for foot in 0..2 {
            let other = 1 - foot;
            if shares[foot] > 1e-6 {
                points[foot] = regions[foot].nearest((com - points[other] * shares[other]) / shares[foot]);
            }
        }
    }
    let balanced = points[0] * shares[0] + points[1] * shares[1];
    (balanced.distance(com) < BALANCE_TOLERANCE).then(|| [0, 1].map(|foot| FootLoad { share: shares[foot], point: points[foot] }))
}

/// Alternating projections between the two support polygons.
const BALANCE_ITERATIONS: usize = 12;
/// Largest error of the balanced centre of mass, m.
const BALANCE_TOLERANCE: f64 = 1e-6;
