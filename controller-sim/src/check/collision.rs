//! The robot collides neither with the world nor with itself, at the waypoints and between them.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, Contact, Waypoint};
use surefoot_shared_types::robot::model::{Foot, LinkIndex, RobotModel};

use crate::base::comparison::{is_at_most, largest};
use crate::check::allowed_pairs::SelfPair;
use crate::check::continuous_collision::{BodyPair, ContinuousCollision, overlap_violation};
use crate::check::motion::Sample;
use crate::check::motion_bounds::LeverArms;
use crate::check::segment::{Case, Violation};
use crate::check::swing_clearance::{check_swing_clearance, check_touch, touches_world};
use crate::check::tuning::{BELOW_COS_MIN, DISTANCE_CAP, UNSEEN_DEPTH_MAX};
use crate::geometry::body::{CollisionBody, SolidPose};
use crate::geometry::penetration::solid_separation;
use crate::geometry::separation::{Separation, is_inside_mesh, separation};
use crate::geometry::solid::Solid;
use crate::kinematics::forward::Posture;

/// A measure of the distance of two solids, given a direction to try first and a sufficient
/// distance.
type SeparationOf = fn((&Solid, &SolidPose), (&Solid, &SolidPose), DVec3, f64) -> Separation;

/// The bodies of the robot and of the world, and the pairs that must stay apart.
pub struct CollisionModel {
    robot: Vec<CollisionBody>,
    world: Vec<CollisionBody>,
    world_poses: Vec<SolidPose>,
    self_pairs: Vec<BodyPair>,
    world_pairs: Vec<BodyPair>,
    /// How far each foot reaches below the plane of its sole, m.
    below_sole: Vec<f64>,
}

impl CollisionModel {
    /// Lists the pairs that must stay apart, or may overlap up to a depth.
    pub fn new(
        model: &RobotModel,
        pairs: &[SelfPair],
        robot: Vec<CollisionBody>,
        world: Vec<CollisionBody>,
    ) -> Self {
        let lever_arms: Vec<LeverArms> =
            robot.iter().map(|body| LeverArms::new(model, body)).collect();
        let self_pairs = pairs.iter().map(|pair| BodyPair::of_robot(pair, &lever_arms)).collect();
        let is_foot =
            |link: Option<LinkIndex>| model.feet.iter().any(|foot| Some(foot.link) == link);
        let world_pairs = (0..robot.len()).flat_map(|i| (0..world.len()).map(move |k| (i, k)));
        let world_pairs = world_pairs
            .map(|(i, k)| BodyPair::of_world((i, &lever_arms[i]), k, !is_foot(robot[i].link)))
            .collect();
        let world_poses = world.iter().map(|body| SolidPose::new(body, &Pose::IDENTITY)).collect();
        let below_sole = model.feet.iter().map(|foot| below_sole(foot, &robot)).collect();
        Self { robot, world, world_poses, self_pairs, world_pairs, below_sole }
    }

    /// Excuses no pair that is clear in a posture, whatever the standing posture says.
    pub fn excuse_none_clear_in(&mut self, posture: &Posture) {
        for pair in &mut self.self_pairs {
            pair.excuse_unless_clear(&self.robot, posture);
        }
    }

    /// The smallest distance of the robot to the world, m, at most [`DISTANCE_CAP`]. Feet, which
    /// touch the world at the ends of every step, are checked but not measured. `heartbeat` is
    /// called at every sample and waypoint.
    pub fn check_world(
        &mut self,
        model: &RobotModel,
        config: &CheckerConfig,
        case: &Case,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<f64, Violation> {
        let link = |contact: &Contact| model.feet[contact.limb as usize].link;
        let stance: Vec<LinkIndex> = case.contacts.iter().map(link).collect();
        for (index, (sample, feet)) in case.samples_with_feet().enumerate() {
            heartbeat();
            // The stance feet keep their pose, so the depth of meshes is measured once.
            let separation = if index == 0 { solid_separation } else { separation };
            for (support, displaced) in case.supports.iter().zip(feet) {
                let foot = &model.feet[support.limb];
                let depth = self.below_sole[support.limb] + support.deepest.max(0.0);
                let known = depth + displaced.displacement + UNSEEN_DEPTH_MAX;
                let limits = [config.contact_gap_max, config.contact_gap_max.min(known)];
                self.check_stance(limits, foot, sample, separation)?;
            }
            self.check_inside(sample)?;
        }
        let moving = |pair: &BodyPair| {
            !self.robot[pair.body].link.is_some_and(|link| stance.contains(&link))
        };
        let (mut checked, resting): (Vec<BodyPair>, Vec<BodyPair>) =
            std::mem::take(&mut self.world_pairs).into_iter().partition(moving);
        let found =
            self.check_pairs(model, config, case, (Check::Collision, &mut checked), heartbeat);
        self.world_pairs = checked.into_iter().chain(resting).collect();
        let nearest = found?;
        check_swing_clearance(model, case, &self.robot, (&self.world, &self.world_poses))?;
        Ok(nearest)
    }

    /// [`check_touch`] of a foot in the world.
    pub fn check_touch(
        &self,
        swing: (&RobotModel, usize),
        waypoints: &[Waypoint],
        before: Option<Pose>,
    ) -> Result<Option<Pose>, Violation> {
        check_touch(swing, waypoints, before, &self.robot, (&self.world, &self.world_poses))
    }

    /// Whether a foot that does not carry the robot touches the world at a waypoint.
    pub fn touches_world(&self, model: &RobotModel, case: &Case, waypoint: &Waypoint) -> bool {
        let stance = case.stance();
        let mut swinging = (0..model.feet.len()).filter(|limb| !stance.contains(limb));
        let world = (&self.world[..], &self.world_poses[..]);
        swinging.any(|limb| touches_world((model, limb), waypoint, &self.robot, world))
    }

    /// The smallest distance between links that may collide, m, at most [`DISTANCE_CAP`].
    /// `heartbeat` is called at every waypoint.
    pub fn check_self(
        &mut self,
        model: &RobotModel,
        config: &CheckerConfig,
        case: &Case,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<f64, Violation> {
        let mut pairs = std::mem::take(&mut self.self_pairs);
        let found =
            self.check_pairs(model, config, case, (Check::SelfCollision, &mut pairs), heartbeat);
        self.self_pairs = pairs;
        found
    }

    fn check_pairs(
        &self,
        model: &RobotModel,
        config: &CheckerConfig,
        case: &Case,
        (check, pairs): (Check, &mut [BodyPair]),
        heartbeat: &mut dyn FnMut(),
    ) -> Result<f64, Violation> {
        let penetration_max = config.penetration_max;
        let mut collision = ContinuousCollision {
            model,
            robot: &self.robot,
            world: &self.world,
            world_poses: &self.world_poses,
            pairs,
            check,
            penetration_max,
            worst: DISTANCE_CAP,
        };
        collision.run(&case.motion.configurations, heartbeat)?;
        Ok(collision.worst)
    }

    /// A stance foot stands on the world and may press into it by the limits (m) `beside` it and
    /// `below` it: there no deeper than the rays under its sole have found, so that it does not
    /// stand on a stone between them or before its sole. Between samples it stays within its pose
    /// tolerance.
    fn check_stance(
        &self,
        [beside, below]: [f64; 2],
        foot: &Foot,
        sample: &Sample,
        separation: SeparationOf,
    ) -> Result<(), Violation> {
        let world_from_link = &sample.posture.world_from_link[foot.link];
        let down = world_from_link.rotation * foot.link_from_sole.rotation * -DVec3::Z;
        for body in self.robot.iter().filter(|body| body.link == Some(foot.link)) {
            let placed = SolidPose::new(body, world_from_link);
            for (other, there) in self.world.iter().zip(&self.world_poses) {
                let solids = ((&body.solid, &placed), (&other.solid, there));
                let found = separation(solids.0, solids.1, -DVec3::Z, -below);
                let is_below = is_at_most(BELOW_COS_MIN, found.direction.dot(down));
                let limit = if is_below { below } else { beside };
                if !is_at_most(-limit, found.distance) {
                    return Err(overlap_violation(
                        Check::Collision,
                        sample.waypoint,
                        (body, other),
                        found.distance,
                        limit,
                    ));
                }
            }
        }
        Ok(())
    }

    /// A body wholly inside a closed mesh touches none of its triangles, so its centre is tested.
    fn check_inside(&self, sample: &Sample) -> Result<(), Violation> {
        for (mesh_body, mesh_placed) in self.world.iter().zip(&self.world_poses) {
            let Solid::Mesh(mesh) = &mesh_body.solid else { continue };
            if !mesh.is_closed {
                continue;
            }
            for body in self.robot.iter().filter(|_| sample.is_waypoint()) {
                let Some(link) = body.link else { continue };
                let placed = SolidPose::new(body, &sample.posture.world_from_link[link]);
                let centre = placed.world_from_solid * body.local_bounds.centre();
                if mesh_placed.bounds.distance(&placed.bounds) <= 0.0
                    && is_inside_mesh(&mesh.surface, &mesh_placed.world_from_solid, centre)
                {
                    let detail =
                        format!("link {} is inside the closed mesh {}", body.name, mesh_body.name);
                    return Err(Violation::new(Check::Collision, sample.waypoint, detail));
                }
            }
        }
        Ok(())
    }
}

/// How far the bodies of a foot reach below the plane of its sole, m; 0 where they do not.
fn below_sole(foot: &Foot, robot: &[CollisionBody]) -> f64 {
    let bodies = robot.iter().filter(|body| body.link == Some(foot.link));
    let sole_from_link = foot.link_from_sole.inverse();
    largest(bodies.map(|body| {
        let sole_from_solid = sole_from_link * body.frame_from_solid;
        let down = sole_from_solid.rotation.inverse() * -DVec3::Z;
        (-(sole_from_solid * body.solid.furthest(down)).z).max(0.0)
    }))
}

#[cfg(test)]
mod tests {
    use surefoot_shared_types::Shape;

    use super::*;
    use crate::check::motion::{Change, SampledMotion, Spacing};
    use crate::check_robot::{at, mesh, robot, waypoint, world};
    use crate::kinematics::forward::Configuration;

    #[test]
    fn the_middle_of_a_link_may_not_lie_inside_a_closed_mesh() {
        let block = || mesh([0.1; 3], 1);
        let inside = |place: Pose, shape: Shape| {
            let model = robot();
            let bodies = CollisionBody::of_robot(&model).unwrap();
            let there = CollisionBody::of_world(&world(vec![("rock", place, shape)])).unwrap();
            let collisions = CollisionModel::new(&model, &[], bodies, there);
            let standing = [waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.05, 0.0)];
            let configurations = standing.each_ref().map(|at| Configuration::of_waypoint(at, 4));
            let changes = vec![Change::between(&configurations[0], &configurations[1])];
            let motion = SampledMotion::new(&model, &standing, Spacing { changes });
            // Only waypoints are tested.
            collisions.check_inside(&motion.samples[1]).unwrap();
            collisions.check_inside(&motion.samples[0])
        };
        // The forearm's middle is at a height of 0.5 m.
        let violation = inside(at(0.0, 0.25, 0.55), block()).unwrap_err();
        assert!(violation.detail.contains("forearm is inside the closed mesh rock"), "{violation}");
        inside(at(0.0, 0.25, 0.3), block()).unwrap();
        inside(at(0.0, 0.45, 0.5), block()).unwrap();
        let Shape::Mesh { vertices, mut triangles, source } = block() else { unreachable!() };
        triangles.pop();
        inside(at(0.0, 0.25, 0.55), Shape::Mesh { vertices, triangles, source }).unwrap();
    }
}
