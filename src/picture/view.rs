//! The camera's pose, and the bodies that would hide the robot from it.

use glam::{DVec2, DVec3};
use surefoot_shared_types::base::spatial::yaw_of;

use crate::picture::camera::{Camera, Size};
use crate::picture::canvas::{Canvas, NOTHING};
use crate::picture::scene::PictureScene;

/// The raster on which hidden parts are measured.
const PROBE: Size = Size { width: 320, height: 180 };
/// Tangent of half the vertical angle of view.
const TANGENT: f64 = 0.24;
/// Angle of the camera ahead of the walk's side, rad.
const TURN_AHEAD: f64 = 0.55;
/// Its pitch downward, rad.
const LOOK_DOWN: f64 = 0.40;
/// The share of the picture's half sides that the walk fills.
const FILL: f64 = 0.93;
/// A body that hides more than this share of the walk is drawn as glass.
const HIDING_MAX: f64 = 0.03;
/// A walk whose root moves less than this has no direction, m.
const WALK_MIN: f64 = 0.3;

/// A camera and the bodies of the world that are glass to it.
#[derive(Debug, Clone)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// For each body of the world, whether it is drawn as glass.
    pub glass: Vec<bool>,
}

impl View {
    /// A three-quarter view that shows all of `points`, from the walk's right or left, whichever is
    /// hidden less; right if both are equal.
    pub fn of(scene: &PictureScene, points: &[DVec3], size: Size) -> Self {
        let [right, left] = [-1.0, 1.0].map(|side| {
            let camera = camera(scene, side, points, size);
            let hidden = hidden_shares(scene, &camera);
            (camera, hidden)
        });
        let total = |(_, hidden): &(Camera, Vec<f64>)| hidden.iter().sum::<f64>();
        let (camera, hidden) = if total(&left) < 0.8 * total(&right) { left } else { right };
        let glass = hidden
            .iter()
            .zip(&scene.world)
            .map(|(share, body)| *share > HIDING_MAX && !body.carries)
            .collect();
        Self { camera, glass }
    }
}

fn camera(scene: &PictureScene, side: f64, points: &[DVec3], size: Size) -> Camera {
    let first = scene.motion.world_from_root(0);
    let way = scene.motion.world_from_root(scene.motion.len() - 1).translation - first.translation;
    let heading = if way.truncate().length() > WALK_MIN {
        libm::atan2(way.y, way.x)
    } else {
        yaw_of(first.rotation)
    };
    let azimuth = heading + side * (std::f64::consts::FRAC_PI_2 - TURN_AHEAD);
    let (sin, cos) = libm::sincos(azimuth);
    let (drop, flat) = libm::sincos(LOOK_DOWN);
    let aspect = size.width as f64 / size.height as f64;
    let seen = Camera::framing(
        DVec3::new(-cos * flat, -sin * flat, -drop),
        FILL * TANGENT * DVec2::new(aspect, 1.0),
        points,
    );
    seen.widened(1.0 / FILL)
}

/// For each body of the world, the share of the walk's pixels that it hides.
fn hidden_shares(scene: &PictureScene, camera: &Camera) -> Vec<f64> {
    let mut canvas = Canvas::new(PROBE);
    for at in scene.sweep_moments() {
        scene.robot_at(at).iter().for_each(|surface| canvas.draw(camera, surface, 0));
    }
    scene.footholds.iter().for_each(|foothold| canvas.draw(camera, &foothold.plate, 0));
    let walk = canvas.body.iter().filter(|&&body| body != NOTHING).count().max(1);
    let hidden = |body: &crate::picture::scene::WorldBody| {
        let mut pixels = 0;
        canvas.visit(camera, &body.surface, |index| {
            pixels += usize::from(canvas.body[index] != NOTHING)
        });
        pixels as f64 / walk as f64
    };
    scene.world.iter().map(hidden).collect()
}
