//! Differences between the actual world and the planner's world, and which of them the robot
//! encounters.
//!
//! The controller checks every chunk against the actual world, so that it never steps on a missing
//! surface. It reports only the differences near the robot's path in the refused chunk, one at a
//! time. Shapes are matched by their names.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::CORRECTIONS_MAX;
use surefoot_shared_types::base::spatial::rotation_distance;
use surefoot_shared_types::message::{Check, Contact, PlanChunk, WorldCorrection};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::{World, WorldShape};

use crate::check::segment::Violation;
use crate::execution::executor::ChunkExecutor;
use crate::execution::tuning::ENCOUNTER_DISTANCE_MAX;
use crate::geometry::body::{CollisionBody, SolidPose};
use crate::geometry::bounds::Bounds;
use crate::geometry::separation::separation;
use crate::geometry::solid::Solid;
use crate::kinematics::forward::{Configuration, Posture};

/// A shape that moved less than this (m, rad) did not move.
const SAME_POSE_MAX: f64 = 1e-9;

/// Differences of the actual world that are not reported to the planner yet.
pub struct GroundTruth {
    robot: Vec<CollisionBody>,
    unreported: Vec<Difference>,
    reported: usize,
}

/// One difference and its geometry.
struct Difference {
    correction: WorldCorrection,
    /// The shape at its actual and at its assumed pose.
    geometry: Vec<(Solid, SolidPose)>,
}

impl GroundTruth {
    /// The differences between the assumed world of the planner and the actual world.
    ///
    /// # Errors
    /// The name of a shape whose geometry the checker cannot represent.
    pub fn new(model: &RobotModel, planner_world: &World, actual: &World) -> Result<Self, String> {
        let mut unreported = Vec::new();
        for (index, assumed) in planner_world.shapes.iter().enumerate() {
            let actual = actual.shapes.iter().find(|shape| shape.name == assumed.name);
            match actual {
                Some(actual) if actual.shape == assumed.shape => {
                    if !same_pose(&actual.world_from_shape, &assumed.world_from_shape) {
                        let geometry = vec![solid_pose(actual)?, solid_pose(assumed)?];
                        unreported.push(Difference {
                            correction: WorldCorrection::moved(
                                index as u32,
                                &actual.world_from_shape,
                            ),
                            geometry,
                        });
                    }
                }
                _ => unreported.push(Difference {
                    correction: WorldCorrection::missing(index as u32),
                    geometry: vec![solid_pose(assumed)?],
                }),
            }
        }
        let known = |actual: &&WorldShape| {
            planner_world
                .shapes
                .iter()
                .any(|shape| shape.name == actual.name && shape.shape == actual.shape)
        };
        for actual in actual.shapes.iter().filter(|actual| !known(actual)) {
            let geometry = vec![solid_pose(actual)?];
            let bounds = geometry[0].0.local_bounds();
            let world_from_box = actual.world_from_shape * Pose::from_translation(bounds.centre());
            let half_extents = 0.5 * (bounds.high - bounds.low);
            unreported.push(Difference {
                correction: WorldCorrection::extra(&world_from_box, half_extents.to_array()),
                geometry,
            });
        }
        Ok(Self { robot: CollisionBody::of_robot(model)?, unreported, reported: 0 })
    }

    /// Marks the corrections that an earlier controller reported.
    pub fn mark_reported(&mut self, reported: &[WorldCorrection]) {
        self.unreported.retain(|difference| !reported.contains(&difference.correction));
        self.reported += reported.len();
    }

    /// The correction for a chunk that violates a check in the actual world: the unreported
    /// difference nearest the robot's path. Where none is near and the contact check failed, the
    /// missing contact of the foot about to land. Nothing if the refusal has another reason than
    /// the world, or if a feedback message holds no more corrections.
    pub fn encountered(
        &mut self,
        executor: &ChunkExecutor,
        chunk: &PlanChunk,
        violation: &Violation,
    ) -> Option<WorldCorrection> {
        let by_world = matches!(
            violation.check,
            Check::Contact
                | Check::Balance
                | Check::Collision
                | Check::ZeroMoment
                | Check::DynamicTorque
        );
        if !by_world || self.reported >= CORRECTIONS_MAX {
            return None;
        }
        let model = executor.checker().model();
        let distances: Vec<f64> = self
            .unreported
            .iter()
            .map(|difference| self.distance(model, chunk, difference))
            .collect();
        let nearest = (0..distances.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b]));
        let correction = match nearest.filter(|&index| distances[index] < ENCOUNTER_DISTANCE_MAX) {
            Some(index) => Some(self.unreported.remove(index).correction),
            None if violation.check == Check::Contact => {
                executor.landing(chunk).map(|contact| missing_contact(model, contact))
            }
            None => None,
        };
        self.reported += usize::from(correction.is_some());
        correction
    }

    /// The smallest distance of the robot, over the whole chunk, to a difference; at most
    /// [`ENCOUNTER_DISTANCE_MAX`].
    fn distance(&self, model: &RobotModel, chunk: &PlanChunk, difference: &Difference) -> f64 {
        let mut nearest = ENCOUNTER_DISTANCE_MAX;
        for waypoint in chunk.waypoints() {
            let posture =
                Posture::new(model, &Configuration::of_waypoint(waypoint, model.joints.len()));
            for (body, link) in self.robot.iter().filter_map(|body| Some((body, body.link?))) {
                let placed = SolidPose::new(body, &posture.world_from_link[link]);
                for (solid, there) in &difference.geometry {
                    let found =
                        separation((&body.solid, &placed), (solid, there), DVec3::Z, nearest);
                    nearest = nearest.min(found.distance);
                }
            }
        }
        nearest
    }
}

fn same_pose(a: &Pose, b: &Pose) -> bool {
    a.translation.distance(b.translation) <= SAME_POSE_MAX
        && rotation_distance(a.rotation, b.rotation) <= SAME_POSE_MAX
}

fn solid_pose(shape: &WorldShape) -> Result<(Solid, SolidPose), String> {
    let WorldShape { name, world_from_shape, shape } = shape;
    let solid = Solid::new(shape).map_err(|error| format!("{name}: {error}"))?;
    let bounds: Bounds = solid.local_bounds().transformed(world_from_shape);
    Ok((solid, SolidPose { world_from_solid: *world_from_shape, bounds }))
}

/// The correction that no surface supports the sole of a contact.
pub fn missing_contact(model: &RobotModel, contact: &Contact) -> WorldCorrection {
    let sole = &model.feet[contact.limb as usize].polygon;
    let corners = Bounds::of_points(sole.iter().map(|corner| corner.extend(0.0)));
    let half = 0.5 * (corners.high - corners.low);
    let world_from_middle = contact.world_from_sole() * Pose::from_translation(corners.centre());
    WorldCorrection::contact_missing(&world_from_middle, [half.x, half.y])
}
