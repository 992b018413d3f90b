//! A smooth walk of a few steps on level ground, in closed form: the centre of mass sways over one
//! foot and on to the next, the legs follow by inverse kinematics.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_planner::timing::path_point::{PathPoint, PathSpan, VELOCITY_MAX};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::scaled_axis_from_rotation;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::message::{Contact, SupportMode};
use surefoot_shared_types::robot::model::RobotModel;

/// Duration of a step and of its single support, in units of the parameter.
const STEP: f64 = 1.2;
const SINGLE: f64 = 0.7;
/// The middle of the first single support.
const FIRST: f64 = 1.5;
const LENGTH: f64 = 0.15;
const LIFT: f64 = 0.05;
/// Parameter between two points, at most.
const SPACING: f64 = 0.02;
/// Step of the differences that give derivatives.
const DIFFERENCE: f64 = 2e-4;

pub struct SmoothWalk {
    pub points: Vec<PathPoint>,
    pub spans: Vec<PathSpan>,
}

impl SmoothWalk {
    /// The same walk on ground that is turned about the world's origin.
    #[allow(dead_code, reason = "each test binary uses its own part")]
    pub fn turned(mut self, turn: DQuat) -> Self {
        let turned = |pose: &Pose| Pose {
            translation: turn * pose.translation,
            rotation: turn * pose.rotation,
        };
        for point in &mut self.points {
            point.world_from_root = turned(&point.world_from_root);
            for list in [&mut point.first, &mut point.second] {
                for part in list[..6].chunks_exact_mut(3) {
                    part.copy_from_slice(&(turn * DVec3::from_slice(part)).to_array());
                }
            }
        }
        for contact in self.spans.iter_mut().flat_map(|span| &mut span.contacts) {
            let pose = turned(&contact.world_from_sole());
            contact.position = pose.translation.to_array();
            contact.rotation = pose.rotation.to_array();
        }
        self
    }
}

struct Gait {
    robot: Mechanism,
    soles: [Pose; 2],
    polygons: [Vec<[f64; 2]>; 2],
    steps: usize,
    /// The sway to each side, m.
    sway: f64,
}

fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * t * (10.0 - t * (15.0 - 6.0 * t))
}

impl Gait {
    fn single(&self, step: usize) -> [f64; 2] {
        let middle = FIRST + STEP * step as f64;
        [middle - 0.5 * SINGLE, middle + 0.5 * SINGLE]
    }

    fn end(&self) -> f64 {
        self.single(self.steps - 1)[1] + 1.15
    }

    /// How far a foot has gone at a parameter, m, and its height.
    fn foot(&self, limb: usize, s: f64) -> (f64, f64) {
        let (mut x, mut z) = (0.0, 0.0);
        for step in 0..self.steps {
            // The left foot stands first.
            if step % 2 != limb {
                let [begin, end] = self.single(step);
                let u = ((s - begin) / (end - begin)).clamp(0.0, 1.0);
                let is_outer = step == 0 || step + 1 == self.steps;
                x += if is_outer { LENGTH } else { 2.0 * LENGTH } * smooth(u);
                z += LIFT * 64.0 * (u * (1.0 - u)).powi(3);
            }
        }
        (x, z)
    }

    fn soles(&self, s: f64) -> [Pose; 2] {
        [0, 1].map(|limb| {
            let (x, z) = self.foot(limb, s);
            Pose::from_parts(
                self.soles[limb].translation + DVec3::new(x, 0.0, z),
                self.soles[limb].rotation,
            )
        })
    }

    fn configuration(&self, s: f64) -> Configuration {
        let weight = smooth(s / 1.1) * smooth((self.end() - s) / 1.1);
        let phase = (s - FIRST) / STEP;
        let side = self.sway * weight * libm::cos(PI * phase);
        let begin = smooth(s / 1.1);
        let end = smooth((self.end() - s) / 1.1);
        let steps = (self.steps - 1) as f64;
        let x = begin * end * (0.02 + LENGTH * phase) + (1.0 - end) * (LENGTH * (steps + 0.5));
        let root = Pose::from_parts(DVec3::new(x, side, -0.01), DQuat::IDENTITY);
        let mut configuration = Configuration { world_from_root: root, q: self.robot.standing_q };
        assert!(self.robot.place_soles(&mut configuration, &self.soles(s)), "no leg at {s}");
        configuration
    }

    fn point(&self, s: f64) -> PathPoint {
        let h = DIFFERENCE;
        let [a, b, c, d, e] = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| self.configuration(s + k * h));
        let mut point = PathPoint {
            parameter: s,
            world_from_root: c.world_from_root,
            q: c.q,
            ..PathPoint::default()
        };
        let coordinate = |of: &Configuration, index: usize| match index {
            0..3 => of.world_from_root.translation[index],
            3..6 => scaled_axis_from_rotation(of.world_from_root.rotation)[index - 3],
            _ => of.q[index - 6],
        };
        for index in 0..VELOCITY_MAX {
            let [a, b, c, d, e] = [&a, &b, &c, &d, &e].map(|of| coordinate(of, index));
            point.first[index] = (a - 8.0 * b + 8.0 * d - e) / (12.0 * h);
            point.second[index] = (-a + 16.0 * b - 30.0 * c + 16.0 * d - e) / (12.0 * h * h);
        }
        point
    }

    fn contact(&self, limb: usize, s: f64) -> Contact {
        let pose = self.soles(s)[limb];
        let mut contact: Contact = bytemuck::Zeroable::zeroed();
        contact.limb = limb as u32;
        contact.polygon_len = self.polygons[limb].len() as u32;
        contact.position = pose.translation.to_array();
        contact.rotation = pose.rotation.to_array();
        contact.polygon[..self.polygons[limb].len()].copy_from_slice(&self.polygons[limb]);
        contact
    }
}

/// A walk of `steps` steps (at least 2) that sways `sway` (m) to each side.
pub fn smooth_walk(model: &RobotModel, steps: usize, sway: f64) -> SmoothWalk {
    let robot = Mechanism::new(model, &PlannerConfig::default()).unwrap();
    let soles = [0, 1].map(|limb| robot.legs[limb].root_from_sole(&robot.standing_q));
    let polygons = [0, 1].map(|limb: usize| {
        model.feet[limb].polygon.iter().map(|corner| corner.to_array()).collect()
    });
    let gait = Gait { robot, soles, polygons, steps, sway };
    let mut borders = vec![(0.0, SupportMode::Double)];
    for step in 0..steps {
        let stance = if step % 2 == 0 { SupportMode::Left } else { SupportMode::Right };
        let [begin, end] = gait.single(step);
        borders.extend([(begin, stance), (end, SupportMode::Double)]);
    }
    let mut walk = SmoothWalk { points: vec![gait.point(0.0)], spans: vec![] };
    for (index, &(begin, support)) in borders.iter().enumerate() {
        let end = borders.get(index + 1).map_or(gait.end(), |(end, _)| *end);
        let count = ((end - begin) / SPACING).ceil() as usize;
        let first = walk.points.len() - 1;
        for at in 1..=count {
            walk.points.push(gait.point(begin + (end - begin) * at as f64 / count as f64));
        }
        let stance = (0..2).filter(|&limb| support.carries(limb));
        walk.spans.push(PathSpan {
            first,
            last: walk.points.len() - 1,
            starts_at_rest: index == 0,
            support,
            contacts: stance.map(|limb| gait.contact(limb, 0.5 * (begin + end))).collect(),
            grounds: Default::default(),
        });
    }
    walk
}
