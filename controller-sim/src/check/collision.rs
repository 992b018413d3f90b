//! The robot collides neither with the world nor with itself, at the waypoints and between them.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, Waypoint};
use surefoot_shared_types::robot::model::{LinkIndex, RobotModel};

use crate::base::comparison::is_at_most;
use crate::check::allowed_pairs::SelfPair;
use crate::check::continuous_collision::{BodyPair, ContinuousCollision, overlap_violation};
use crate::check::motion::Sample;
use crate::check::motion_bounds::LeverArms;
use crate::check::segment::{Case, Violation};
use crate::check::swing_clearance::{check_swing_clearance, check_touch};
use crate::check::tuning::DISTANCE_CAP;
use crate::geometry::body::{CollisionBody, SolidPose};
use crate::geometry::penetration::solid_separation;
use crate::geometry::separation::{Separation, is_inside_mesh, separation};
use crate::geometry::solid::Solid;

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
        Self { robot, world, world_poses, self_pairs, world_pairs }
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
        let stance: Vec<LinkIndex> =
            case.contacts.iter().map(|contact| model.feet[contact.limb as usize].link).collect();
        for (index, sample) in case.motion.samples.iter().enumerate() {
            heartbeat();
            // The stance feet keep their pose, so the depth of meshes is measured once.
            let separation = if index == 0 { solid_separation } else { separation };
            self.check_stance(config, &stance, sample, separation)?;
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

    /// A stance foot stands on the world and may press into it a little. Between samples it stays
    /// within its pose tolerance.
    fn check_stance(
        &self,
        config: &CheckerConfig,
        stance: &[LinkIndex],
        sample: &Sample,
        separation: SeparationOf,
    ) -> Result<(), Violation> {
        let deepest = -config.contact_gap_max;
        for body in &self.robot {
            let Some(link) = body.link.filter(|link| stance.contains(link)) else { continue };
            let placed = SolidPose::new(body, &sample.posture.world_from_link[link]);
            for (other, there) in self.world.iter().zip(&self.world_poses) {
                let found =
                    separation((&body.solid, &placed), (&other.solid, there), -DVec3::Z, deepest);
                if !is_at_most(deepest, found.distance) {
                    return Err(overlap_violation(
                        Check::Collision,
                        sample.waypoint,
                        (body, other),
                        found.distance,
                        config.contact_gap_max,
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
