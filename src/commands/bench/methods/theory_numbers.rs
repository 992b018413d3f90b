//! The numbers in the bounds of chapter 5, measured on a plan [Grey 5.4, 5.5].

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use serde::Serialize;
use surefoot_planner::Planner;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::constraints::foothold::Foothold;
use surefoot_planner::foot_placement::Scratch;
use surefoot_planner::pipeline::foothold_at;
use surefoot_planner::preparation::necessary;
use surefoot_planner::primitives::transition_configuration::is_step;
use surefoot_planner::theory::coverage::placement_distance;
use surefoot_planner::theory::erosion::Cylinder;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{
    rotation_about, rotation_distance, rotation_from_rpy, rotation_from_scaled_axis,
};
use surefoot_shared_types::message::SupportMode;

/// Radii of cylinders and clearances that are tried, from the largest on, m.
const RADII: [f64; 12] =
    [0.4, 0.3, 0.2, 0.14, 0.1, 0.07, 0.05, 0.035, 0.025, 0.0175, 0.0125, 0.009];
/// Yaw extent of a cylinder relative to its radius, rad/m.
const YAW_PER_RADIUS: f64 = 4.0;
/// Random replacements of all footholds that must all be walks.
const REPLACEMENTS: u64 = 60;
/// Points of a ball about each point of the path that must all satisfy C_N.
const BALL_POINTS: u64 = 40;
/// Points of the path about which balls are tried.
const PATH_POINTS: usize = 24;
/// Samples of E that measure the volume of C_N.
const VOLUME_SAMPLES: u64 = 4_000;
/// Highest root in E above that of the standing robot, relative to its height: as in w-RPG.
const ROOT_HEIGHT_SHARE: f64 = 1.1;

/// The numbers of one plan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TheoryNumbers {
    /// M: single-support modes.
    pub modes: usize,
    /// r_m: largest radius tried at which all random replacements of all footholds were walks, m;
    /// 0 where there is none.
    pub cylinder_radius: f64,
    /// Its yaw extent, rad.
    pub cylinder_yaw_extent: f64,
    /// L: length of the root's path, m, with a metre per radian.
    pub length: f64,
    /// R: largest radius tried at which all random points of balls about the path satisfied C_N;
    /// 0 where there is none.
    pub clearance: f64,
    /// |C_N|, m^6.
    pub volume: f64,
    /// h_m: upper bound of the distance of any foothold in the cylinders from the path, m.
    pub placement_distance: f64,
    /// Length of the path seen from above, m.
    pub route_length: f64,
    /// Largest distance between soles of consecutive footholds, m.
    pub step_max: f64,
}

impl TheoryNumbers {
    /// The least cylinder.
    pub fn cylinder(&self) -> Cylinder {
        Cylinder { radius: self.cylinder_radius, yaw_extent: self.cylinder_yaw_extent }
    }

    /// Measures the plan that a planner found.
    pub fn of(planner: &Planner) -> Self {
        let (walk, path) = (stances(planner), root_path(planner));
        let above: Vec<DVec2> = path.iter().map(|pose| pose.translation.truncate()).collect();
        let step = |pair: &[Pose]| (pair[1].translation - pair[0].translation).length();
        let (placed, poses): (Vec<DVec2>, Vec<Pose>) =
            walk.iter().map(|(_, pose)| (pose.translation.truncate(), *pose)).unzip();
        let radius = largest(|radius| are_walks(planner, &walk, cylinder_of(radius)));
        let length = |pair: &[Pose]| {
            let turn = rotation_distance(pair[0].rotation, pair[1].rotation);
            libm::hypot(step(pair), turn)
        };
        Self {
            modes: walk.len(),
            cylinder_radius: radius,
            cylinder_yaw_extent: cylinder_of(radius).yaw_extent,
            length: path.windows(2).map(length).sum(),
            clearance: largest(|radius| are_balls_free(planner, &path, radius)),
            volume: volume_of_c_n(planner, &path, &poses),
            placement_distance: placement_distance(&placed, radius, &above),
            route_length: above.windows(2).map(|pair| pair[0].distance(pair[1])).sum(),
            step_max: poses.windows(2).map(step).fold(0.0, f64::max),
        }
    }
}

fn cylinder_of(radius: f64) -> Cylinder {
    Cylinder { radius, yaw_extent: YAW_PER_RADIUS * radius }
}

/// The largest radius tried at which a condition holds; 0 where there is none.
fn largest(holds: impl Fn(f64) -> bool) -> f64 {
    RADII.into_iter().find(|&radius| holds(radius)).unwrap_or(0.0)
}

/// The stance soles of all single-support modes in order, with their foot.
fn stances(planner: &Planner) -> Vec<(usize, Pose)> {
    let mut walk: Vec<(usize, Pose)> = vec![];
    for chunk in planner.chunks() {
        let limb = match SupportMode::from_wire(chunk.mode) {
            Some(SupportMode::Left) => 0,
            Some(SupportMode::Right) => 1,
            _ => continue,
        };
        let contact = chunk.contacts().iter().find(|contact| contact.limb as usize == limb);
        let Some(pose) = contact.map(|contact| contact.world_from_sole()) else { continue };
        if walk.last() != Some(&(limb, pose)) {
            walk.push((limb, pose));
        }
    }
    walk
}

fn root_path(planner: &Planner) -> Vec<Pose> {
    let waypoints = planner.chunks().iter().flat_map(|chunk| chunk.waypoints());
    waypoints.map(|waypoint| waypoint.world_from_root()).collect()
}

/// Whether every random choice of all footholds within cylinders about those of a walk has support
/// and is a walk by inverse kinematics.
fn are_walks(planner: &Planner, walk: &[(usize, Pose)], cylinder: Cylinder) -> bool {
    let mut scratch = Scratch::new(planner.surfaces().config());
    (0..REPLACEMENTS).all(|attempt| {
        let mut before: Option<Foothold> = None;
        walk.iter().enumerate().all(|(mode, (limb, pose))| {
            let mut random = Random::new(attempt, Stream::Preparation, mode as u64, 10);
            let moved = moved(pose, cylinder, &mut random);
            let constraints = planner.constraints();
            let found = foothold_at(constraints, planner.surfaces(), &mut scratch, *limb, &moved);
            let Ok(foothold) = found else { return false };
            let is_reached = before.as_ref().is_none_or(|before| {
                before.limb == foothold.limb || is_step(constraints, [before, &foothold])
            });
            before = Some(foothold);
            is_reached
        })
    })
}

/// A uniform random placement of a cylinder about a sole.
fn moved(pose: &Pose, cylinder: Cylinder, random: &mut Random) -> Pose {
    let (angle, share) = (random.uniform(0.0, TAU), random.uniform(0.0, 1.0));
    let length = cylinder.radius * libm::sqrt(share);
    let offset = length * DVec3::new(libm::cos(angle), libm::sin(angle), 0.0);
    let half = 0.5 * cylinder.yaw_extent;
    let turn = rotation_about(DVec3::Z, random.uniform(-half, half));
    Pose::from_parts(pose.translation + offset, turn * pose.rotation)
}

/// Whether random points at a distance from the path, in the metric of E, all satisfy C_N.
fn are_balls_free(planner: &Planner, path: &[Pose], radius: f64) -> bool {
    let stride = (path.len() / PATH_POINTS).max(1);
    path.iter().step_by(stride).enumerate().all(|(index, pose)| {
        (0..BALL_POINTS).all(|attempt| {
            let mut random = Random::new(attempt, Stream::Preparation, index as u64, 11);
            let direction: [f64; 6] = std::array::from_fn(|_| gaussian(&mut random));
            let norm = libm::sqrt(direction.iter().map(|along| along * along).sum());
            let [x, y, z, a, b, c] = direction.map(|along| radius * along / norm);
            let turn = rotation_from_scaled_axis(DVec3::new(a, b, c));
            let moved =
                Pose::from_parts(pose.translation + DVec3::new(x, y, z), turn * pose.rotation);
            holds(planner, &moved)
        })
    })
}

/// A normally distributed number (Box, Muller 1958).
fn gaussian(random: &mut Random) -> f64 {
    let (share, angle) = (random.uniform(f64::EPSILON, 1.0), random.uniform(0.0, TAU));
    libm::sqrt(-2.0 * libm::log(share)) * libm::cos(angle)
}

fn holds(planner: &Planner, world_from_root: &Pose) -> bool {
    let Constraints { robot, collision, .. } = planner.constraints();
    necessary(planner.preparation(), robot, collision, world_from_root).holds()
}

/// The volume of C_N in the box of E, by the share of uniform samples that satisfy it, m^6.
fn volume_of_c_n(planner: &Planner, path: &[Pose], soles: &[Pose]) -> f64 {
    let ground = soles.iter().map(|sole| sole.translation.z).fold(f64::INFINITY, f64::min);
    let root = path.first().map_or(0.0, |root| root.translation.z - ground);
    let world = planner.constraints().collision.world_bounds();
    let low = DVec3::new(world.min.x, world.min.y, ground);
    let high = DVec3::new(world.max.x, world.max.y, ground + ROOT_HEIGHT_SHARE * root);
    let inside = (0..VOLUME_SAMPLES).filter(|&sample| {
        let mut random = Random::new(sample, Stream::Preparation, 0, 12);
        let at = DVec3::from_array([0, 1, 2].map(|axis| random.uniform(low[axis], high[axis])));
        let [roll, pitch, yaw] = [0, 1, 2].map(|_| random.uniform(-PI, PI));
        holds(planner, &Pose::from_parts(at, rotation_from_rpy(roll, pitch, yaw)))
    });
    let share = inside.count() as f64 / VOLUME_SAMPLES as f64;
    share * (high - low).element_product() * TAU * TAU * TAU
}
