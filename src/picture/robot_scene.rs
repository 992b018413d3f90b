//! A robot that stands, in drawable form: its links and its soles on the ground.

use glam::DVec3;
use surefoot_shared_types::config::scenario::StancePose;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

use crate::picture::error::PictureError;
use crate::picture::ground_overlay::{Foothold, Stance, foothold, hull_from_above};
use crate::picture::motion::PlanMotion;
use crate::picture::scene::PictureScene;
use crate::picture::search_scene::world_from_root;

/// The middle between the soles is the world's origin; the width is the posture's own.
const STANCE: StancePose = StancePose { position: DVec3::ZERO, yaw: 0.0, stance_width: 0.0 };

impl PictureScene {
    /// Prepares a standing robot for drawing.
    ///
    /// # Errors
    /// [`PictureError::Hull`] for a hull without volume, and [`PictureError::NoRobotShapes`].
    pub fn of_robot(model: &RobotModel, world: &World) -> Result<Self, PictureError> {
        let motion = PlanMotion::standing(model, world_from_root(model, &STANCE));
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
        Self::of_motion(model, world, motion, (footholds, vec![stance]), Vec::new())
    }
}
