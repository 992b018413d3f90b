//! Joint torques of a robot at rest.
//!
//! Contact forces are vertical. The largest inclination of a foot placement keeps vertical forces
//! inside the friction cone.

use glam::{DVec2, DVec3};
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::robot::model::JointIndex;
use surefoot_shared_types::world::world::GRAVITY;

use crate::geometry::convex_region::ConvexRegion;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mass_tree::{LoadedJoint, MassTree};

/// A vertical force on a foot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootLoad {
    /// Share of the weight, 0 to 1.
    pub share: f64,
    /// Centre of pressure in world x and y, m.
    pub point: DVec2,
}

impl FootLoad {
    /// The loads of both feet, left first, with the whole weight on foot `limb`.
    pub fn all_on(limb: usize, point: DVec2) -> [Self; 2] {
        [0, 1].map(|foot| Self { share: if foot == limb { 1.0 } else { 0.0 }, point })
    }
}

/// Displacement of the centre of mass in the world per unit of an upper-body joint's motion, m/rad
/// or m/m; zero for a joint of a leg.
pub fn com_shift(
    mass_tree: &MassTree,
    kinematic_state: &KinematicState,
    joint: JointIndex,
) -> DVec3 {
    let lever_arm = mass_tree
        .upper_body_joints()
        .iter()
        .zip(kinematic_state.lever_arms())
        .find(|(candidate, _)| candidate.joint == joint)
        .map_or(DVec3::ZERO, |(_, lever_arm)| *lever_arm);
    *kinematic_state.world_rotation() * (-lever_arm / mass_tree.mass())
}

/// The largest effort that gravity requires of a joint, as a share of its usable effort.
pub fn effort_use(
    mass_tree: &MassTree,
    kinematic_state: &KinematicState,
    loads: &[FootLoad; 2],
) -> f64 {
    let mut most: f64 = 0.0;
    for_each_torque(mass_tree, kinematic_state, loads, |joint, torque| {
        most = most.max(torque.abs() / joint.effort)
    });
    most
}

/// The joint with the largest [`effort_use`], and that share; `None` if all torques are 0.
pub fn most_strained(
    mass_tree: &MassTree,
    kinematic_state: &KinematicState,
    loads: &[FootLoad; 2],
) -> Option<(JointIndex, f64)> {
    let mut most: Option<(JointIndex, f64)> = None;
    for_each_torque(mass_tree, kinematic_state, loads, |joint, torque| {
        let share = torque.abs() / joint.effort;
        if share > most.map_or(0.0, |(_, most)| most) {
            most = Some((joint.joint, share));
        }
    });
    most
}

/// Writes the torque (N m) or force (N) that each joint must hold, in joint order.
pub fn write_torques(
    mass_tree: &MassTree,
    kinematic_state: &KinematicState,
    loads: &[FootLoad; 2],
    torques: &mut [f64; JOINTS_MAX],
) {
    for_each_torque(mass_tree, kinematic_state, loads, |joint, torque| {
        torques[joint.joint] = torque
    });
}

fn for_each_torque(
    mass_tree: &MassTree,
    kinematic_state: &KinematicState,
    loads: &[FootLoad; 2],
    mut visit: impl FnMut(&LoadedJoint, f64),
) {
    let down = kinematic_state.turned_to_root(DVec3::NEG_Z * GRAVITY);
    for (joint, lever_arm) in mass_tree.upper_body_joints().iter().zip(kinematic_state.lever_arms())
    {
        visit(joint, down.dot(*lever_arm));
    }
    let frames = kinematic_state.root_from_nodes();
    let moments = mass_tree.leg_moments(frames);
    // The height of the point of contact does not matter: all forces are vertical.
    let supported = loads.map(|load| {
        let point = kinematic_state
            .turned_to_root(load.point.extend(0.0) - kinematic_state.world_from_root.translation);
        (point, mass_tree.mass() * load.share)
    });
    for joint in mass_tree.leg_joints() {
        let frame = &frames[joint.node];
        let mut lift = -joint.mass;
        let mut arm = frame.translation * joint.mass - moments[joint.node];
        for ((point, mass), _) in
            supported.iter().zip(joint.carries).filter(|(_, carries)| *carries)
        {
            lift += mass;
            arm += (*point - frame.translation) * *mass;
        }
        visit(joint, down.dot(joint.lever_arm(frame, lift, arm)));
    }
}

/// Vertical loads on both feet that balance a centre of mass at `com` (world x and y, m) with
/// `share` of the weight on the right foot, each within its own support polygon; `None` if this
/// share admits none. Found by alternating projections onto both polygons.
pub fn balance_loads(regions: [&ConvexRegion; 2], com: DVec2, share: f64) -> Option<[FootLoad; 2]> {
    let shares = [1.0 - share, share];
    let mut points = regions.map(ConvexRegion::centroid);
    for _ in 0..BALANCE_ITERATIONS {
        for foot in 0..2 {
            let other = 1 - foot;
            if shares[foot] > LOAD_SHARE_MIN {
                points[foot] =
                    regions[foot].nearest((com - points[other] * shares[other]) / shares[foot]);
            }
        }
        let balanced = points[0] * shares[0] + points[1] * shares[1];
        if balanced.distance(com) < BALANCE_TOLERANCE {
            return Some([0, 1].map(|foot| FootLoad { share: shares[foot], point: points[foot] }));
        }
    }
    None
}

/// Iterations of the alternating projections; more are needed only near the border of the feasible
/// set.
const BALANCE_ITERATIONS: usize = 12;
/// Largest error of the balanced centre of mass, m.
const BALANCE_TOLERANCE: f64 = 1e-6;
/// Smallest share of the weight by which a point of pressure is divided.
const LOAD_SHARE_MIN: f64 = 1e-6;
