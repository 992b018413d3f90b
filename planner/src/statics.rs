//! Gravity torques of a robot at rest. Contact forces are taken as vertical, which the inclination bound of foot
//! placements keeps inside the friction cone.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::limits::JOINTS_MAX;
use surefoot_shared_types::robot::{Joint, JointKind, RobotModel};
use surefoot_shared_types::scene::GRAVITY;

use crate::kinematics::carriers::{Carrier, carriers};
use crate::region::Region;

/// The root and one link to each joint.
const CARRIERS_MAX: usize = JOINTS_MAX + 1;

/// The robot's mass tree, compiled for gravity torques.
#[derive(Debug, Clone)]
pub struct Statics {
    carriers: Vec<Carrier>,
    joints: Vec<StaticJoint>,
    mass: f64,
}

#[derive(Debug, Clone)]
struct StaticJoint {
    /// The link that it moves, and this one's place among the carriers.
    child: usize,
    carrier: usize,
    axis: DVec3,
    kind: JointKind,
    /// The mass that it carries, kg.
    mass: f64,
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
        let carriers = carriers(model);
        let mut masses: Vec<f64> = carriers.iter().map(|carrier| carrier.mass).collect();
        for index in (1..carriers.len()).rev() {
            masses[carriers[index].parent] += masses[index];
        }
        let chains: Vec<_> = model.feet.iter().map(|foot| model.chain(foot.link)).collect();
        let joint = |(index, joint): (usize, &Joint)| {
            let carrier = carriers.iter().position(|carrier| carrier.link == joint.child).unwrap_or(0);
            StaticJoint {
                child: joint.child,
                carrier,
                axis: joint.axis,
                kind: joint.kind,
                mass: masses[carrier],
                effort: joint.effort * effort_share,
                carries: [0, 1].map(|limb| chains[limb].contains(&index)),
            }
        };
        Self { joints: model.joints.iter().enumerate().map(joint).collect(), mass: masses[0], carriers }
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
        for (joint, torque) in self.joints.iter().zip(torques) {
            let pose = &world_from_links[joint.child];
            let axis = pose.rotation * joint.axis;
            let at = pose.translation.truncate();
            // All forces are vertical: `lift` is their sum upward, `arm` the sum of each times where it acts from the joint.
            let mut lift = -joint.mass;
            let mut arm = at * joint.mass - moments[joint.carrier];
            for (load, _) in loads.iter().zip(joint.carries).filter(|(_, carries)| *carries) {
                lift += self.mass * load.share;
                arm += (load.point - at) * (self.mass * load.share);
            }
            *torque = -GRAVITY
                * match joint.kind {
                    JointKind::Revolute => axis.x * arm.y - axis.y * arm.x,
                    JointKind::Prismatic => axis.z * lift,
                };
        }
    }

    /// The first mass moment (kg m) of every carrier and what hangs on it, in world x and y.
    fn subtree_moments(&self, world_from_links: &[Pose]) -> [DVec2; CARRIERS_MAX] {
        let mut moments = [DVec2::ZERO; CARRIERS_MAX];
        for (index, carrier) in self.carriers.iter().enumerate().rev() {
            moments[index] += (world_from_links[carrier.link] * carrier.com).truncate() * carrier.mass;
            if index > 0 {
                let moment = moments[index];
                moments[carrier.parent] += moment;
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
        let balanced = points[0] * shares[0] + points[1] * shares[1];
        if balanced.distance(com) < BALANCE_TOLERANCE {
            return Some([0, 1].map(|foot| FootLoad { share: shares[foot], point: points[foot] }));
        }
    }
    None
}

/// Alternating projections between the two support polygons.
const BALANCE_ITERATIONS: usize = 12;
/// Largest error of the balanced centre of mass, m.
const BALANCE_TOLERANCE: f64 = 1e-6;
