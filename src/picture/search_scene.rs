//! Robots that stand, in drawable form: alone, or at the start of a search that found no plan, with
//! the marks of start and goal, and how far the search came.

use glam::DVec3;
use surefoot_planner::kinematics::Kinematics;
use surefoot_planner::pipeline::SearchTrace;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, yaw_of};
use surefoot_shared_types::config::scenario::{Scenario, StancePose};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

use crate::picture::error::PictureError;
use crate::picture::ground_overlay::{EndpointMarker, Foothold, Stance, foothold, hull_from_above};
use crate::picture::motion::PlanMotion;
use crate::picture::scene::PictureScene;

/// How far a mark and a place of the search stay from the picture's border, m.
const MARGIN: f64 = 0.3;
/// How high the lines of the search lie over the ground, m.
const LINE_LIFT: f64 = 0.02;

/// The middle between the soles is the world's origin; the width is the posture's own.
const ORIGIN: StancePose = StancePose { position: DVec3::ZERO, yaw: 0.0, stance_width: 0.0 };

impl PictureScene {
    /// Prepares a search without a plan for drawing.
    ///
    /// # Errors
    /// [`PictureError::Hull`] for a hull without volume, and [`PictureError::NoRobotShapes`].
    pub fn of_search(
        model: &RobotModel,
        world: &World,
        scenario: &Scenario,
        trace: &SearchTrace,
    ) -> Result<Self, PictureError> {
        let motion = PlanMotion::standing(model, world_from_root(model, &scenario.start));
        let ends = [&scenario.start, &scenario.goal].map(|stance| stance.position);
        let mut endpoints = vec![EndpointMarker::start(ends[0]), EndpointMarker::goal(ends[1])];
        endpoints.extend(trace.bottleneck.map(EndpointMarker::bottleneck));
        let mut scene = Self::of_motion(model, world, motion, (Vec::new(), Vec::new()), endpoints)?;
        scene.title = match trace.bottleneck {
            Some(_) => format!("{}: no plan; most sequences failed at the small ring", model.name),
            None => format!("{}: no plan", model.name),
        };
        let places = trace.tree.iter().flatten().chain(&trace.route);
        let around = ends.iter().chain(places).chain(trace.bottleneck.iter());
        scene.sweep.extend(around.flat_map(|place| {
            [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y].map(|side| place + MARGIN * side)
        }));
        let lifted = |place: &DVec3| place + LINE_LIFT * DVec3::Z;
        scene.tree = trace.tree.iter().map(|edge| edge.each_ref().map(lifted)).collect();
        scene.route = trace.route.iter().map(lifted).collect();
        Ok(scene)
    }

    /// Prepares a standing robot for drawing.
    ///
    /// # Errors
    /// [`PictureError::Hull`] for a hull without volume, and [`PictureError::NoRobotShapes`].
    pub fn of_robot(model: &RobotModel, world: &World) -> Result<Self, PictureError> {
        let motion = PlanMotion::standing(model, world_from_root(model, &ORIGIN));
        let links = motion.world_from_links(0.0);
        let footholds: Vec<Foothold> = (0..model.feet.len())
            .map(|limb| {
                let foot = &model.feet[limb];
                foothold(model, limb, links[foot.link] * foot.link_from_sole, 0)
            })
            .collect();
        let corners = footholds.iter().flat_map(|foothold| foothold.outline.clone()).collect();
        let polygon = hull_from_above(corners);
        let stance = Stance { first: 0, last: 0, feet: footholds.len(), polygon };
        let mut scene =
            Self::of_motion(model, world, motion, (footholds, vec![stance]), Vec::new())?;
        let heights = scene.sweep.iter().map(|point| point.z);
        let height = heights.fold(f64::NEG_INFINITY, f64::max);
        scene.title = format!("{}: {:.1} kg, {height:.2} m high", model.name, model.mass());
        Ok(scene)
    }
}

/// The root's pose of the robot that stands on a stance in its standing posture.
fn world_from_root(model: &RobotModel, stance: &StancePose) -> Pose {
    let kinematics = Kinematics::new(model);
    let mut links = vec![Pose::IDENTITY; kinematics.links_len()];
    kinematics.forward(&Pose::IDENTITY, &model.standing_q, &mut links);
    let soles: Vec<Pose> =
        model.feet.iter().map(|foot| links[foot.link] * foot.link_from_sole).collect();
    let count = soles.len().max(1) as f64;
    let middle = soles.iter().map(|sole| sole.translation).sum::<DVec3>() / count;
    let yaw = soles.first().map_or(0.0, |sole| yaw_of(sole.rotation));
    let rotation = rotation_about(DVec3::Z, stance.yaw - yaw);
    Pose::from_parts(stance.position - rotation * middle, rotation)
}
