//! A world that is not as the planner believes, and which of its differences the robot meets.
//!
//! The controller checks every chunk against the true world, so that it never steps on what is not
//! there. What it then says is only what it met: the differences near the robot's way in the
//! refused chunk, one at a time. Shapes are matched by their names.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::limits::CORRECTIONS_MAX;
use surefoot_shared_types::message::{Check, Contact, Correction, PlanChunk};
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::scene::{World, WorldShape};
use surefoot_shared_types::spatial::rotation_distance;

use crate::Walker;
use crate::check::Violation;
use crate::geometry::body::{Body, Placed};
use crate::geometry::bounds::Bounds;
use crate::geometry::separation::separation;
use crate::geometry::solid::Solid;
use crate::kinematics::{Configuration, Posture};

/// A difference this near to the robot's way is met, m.
const MET_WITHIN: f64 = 0.05;
/// A shape that moved less than this (m, rad) did not move.
const SAME_POSE_MAX: f64 = 1e-9;

/// What the controller knows of the true world, and the planner does not yet.
pub struct Truth {
    robot: Vec<Body>,
    untold: Vec<Difference>,
    told: usize,
}

/// One difference, and where it can be met.
struct Difference {
    correction: Correction,
    /// Where the shape is, and where it was believed to be.
    places: Vec<(Solid, Placed)>,
}

impl Truth {
    /// The differences between what the planner believes and what is true; or which shape has no
    /// geometry to tell.
    ///
    /// # Errors
    /// The name of a shape whose geometry the checker cannot represent.
    pub fn new(model: &RobotModel, belief: &World, truth: &World) -> Result<Self, String> {
        let mut untold = Vec::new();
        for (index, believed) in belief.shapes.iter().enumerate() {
            let real = truth.shapes.iter().find(|shape| shape.name == believed.name);
            match real {
                Some(real) if real.shape == believed.shape => {
                    if !same_pose(&real.world_from_shape, &believed.world_from_shape) {
                        let places = vec![place(real)?, place(believed)?];
                        untold.push(Difference {
                            correction: Correction::moved(index as u32, &real.world_from_shape),
                            places,
                        });
                    }
                }
                _ => untold.push(Difference {
                    correction: Correction::missing(index as u32),
                    places: vec![place(believed)?],
                }),
            }
        }
        let known = |real: &&WorldShape| {
            belief.shapes.iter().any(|shape| shape.name == real.name && shape.shape == real.shape)
        };
        for real in truth.shapes.iter().filter(|real| !known(real)) {
            let places = vec![place(real)?];
            let bounds = places[0].0.local_bounds();
            let world_from_box = real.world_from_shape * Pose::from_translation(bounds.centre());
            let half_extents = 0.5 * (bounds.high - bounds.low);
            untold.push(Difference {
                correction: Correction::extra(&world_from_box, half_extents.to_array()),
                places,
            });
        }
        Ok(Self { robot: Body::of_robot(model)?, untold, told: 0 })
    }

    /// Leaves out what an earlier controller told already.
    pub fn pass_over(&mut self, told: &[Correction]) {
        self.untold.retain(|difference| !told.contains(&difference.correction));
        self.told += told.len();
    }

    /// What the robot meets in a chunk that the true world refuses: the untold difference nearest
    /// its way. Where none is near and the ground gave way, only that nothing carries the sole of
    /// the foot about to land. Nothing if the refusal has another reason than the world, or if a
    /// word holds no more corrections.
    pub fn met(
        &mut self,
        walker: &Walker,
        chunk: &PlanChunk,
        violation: &Violation,
    ) -> Option<Correction> {
        let by_world =
            matches!(violation.check, Check::Contact | Check::Balance | Check::Collision);
        if !by_world || self.told >= CORRECTIONS_MAX {
            return None;
        }
        let model = walker.checker().model();
        let distances: Vec<f64> =
            self.untold.iter().map(|difference| self.distance(model, chunk, difference)).collect();
        let nearest = (0..distances.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b]));
        let met = match nearest.filter(|&index| distances[index] < MET_WITHIN) {
            Some(index) => Some(self.untold.remove(index).correction),
            None if violation.check == Check::Contact => {
                walker.landing(chunk).map(|contact| nothing_carries(model, contact))
            }
            None => None,
        };
        self.told += usize::from(met.is_some());
        met
    }

    /// The smallest distance of the robot, on its way through the chunk, to a difference; at most
    /// [`MET_WITHIN`].
    fn distance(&self, model: &RobotModel, chunk: &PlanChunk, difference: &Difference) -> f64 {
        let mut nearest = MET_WITHIN;
        for waypoint in chunk.waypoints() {
            let posture =
                Posture::new(model, &Configuration::of_waypoint(waypoint, model.joints.len()));
            for (body, link) in self.robot.iter().filter_map(|body| Some((body, body.link?))) {
                let placed = Placed::new(body, &posture.world_from_link[link]);
                for (solid, there) in &difference.places {
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

fn place(shape: &WorldShape) -> Result<(Solid, Placed), String> {
    let WorldShape { name, world_from_shape, shape } = shape;
    let solid = Solid::new(shape).map_err(|error| format!("{name}: {error}"))?;
    let bounds: Bounds = solid.local_bounds().moved(world_from_shape);
    Ok((solid, Placed { world_from_solid: *world_from_shape, bounds }))
}

/// That nothing carries the sole of a contact.
pub fn nothing_carries(model: &RobotModel, contact: &Contact) -> Correction {
    let sole = &model.feet[contact.limb as usize].polygon;
    let corners = Bounds::of_points(sole.iter().map(|corner| corner.extend(0.0)));
    let half = 0.5 * (corners.high - corners.low);
    let world_from_middle = contact.world_from_sole() * Pose::from_translation(corners.centre());
    Correction::contact_missing(&world_from_middle, [half.x, half.y])
}
