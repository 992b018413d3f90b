//! The motion of a plan: where the robot is at each instant, and which instants are worth drawing.

use glam::DVec3;
use surefoot_planner::kinematics::Kinematics;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::interpolate;
use surefoot_shared_types::plan_format::blocks::{PlanFile, PoseBlock};
use surefoot_shared_types::robot::model::RobotModel;

use crate::picture::error::PictureError;

/// Root motion up to this long counts as swaying in place, not as walking, m.
const SWAY: f64 = 0.15;

/// A configuration at an instant.
#[derive(Debug, Clone)]
struct Moment {
    time: f64,
    world_from_root: Pose,
    q: Vec<f64>,
}

/// A plan's waypoints in the robot's joint order.
#[derive(Debug, Clone)]
pub struct PlanMotion {
    kinematics: Kinematics,
    moments: Vec<Moment>,
}

impl PlanMotion {
    /// Takes the waypoints out of a plan.
    pub fn new(model: &RobotModel, plan: &PlanFile) -> Result<Self, PictureError> {
        let order = joint_order(model, plan)?;
        let moment = |(index, waypoint): (
            usize,
            &surefoot_shared_types::plan_format::blocks::WaypointBlock,
        )| {
            let finite = waypoint
                .q
                .iter()
                .chain(&waypoint.root_xyz)
                .chain(&waypoint.root_quat_xyzw)
                .all(|v| v.is_finite());
            if waypoint.q.len() != plan.joint_names.len() || !finite || !waypoint.t.is_finite() {
                return Err(PictureError::plan(format!(
                    "waypoint {index} needs {} finite joint positions",
                    plan.joint_names.len()
                )));
            }
            let root = PoseBlock { xyz: waypoint.root_xyz, quat_xyzw: waypoint.root_quat_xyzw };
            Ok(Moment {
                time: waypoint.t,
                world_from_root: root.pose(),
                q: order.iter().map(|&from| waypoint.q[from]).collect(),
            })
        };
        let moments: Vec<Moment> =
            plan.waypoints.iter().enumerate().map(moment).collect::<Result<_, _>>()?;
        if moments.is_empty() {
            return Err(PictureError::plan("it has no waypoints"));
        }
        Ok(Self { kinematics: Kinematics::new(model), moments })
    }

    /// The robot that stays in its standing posture.
    pub fn standing(model: &RobotModel, world_from_root: Pose) -> Self {
        let moment = Moment { time: 0.0, world_from_root, q: model.standing_q.clone() };
        Self { kinematics: Kinematics::new(model), moments: vec![moment] }
    }

    /// The number of waypoints, at least 1.
    pub fn len(&self) -> usize {
        self.moments.len()
    }

    /// The time of a waypoint, s.
    pub fn time(&self, waypoint: usize) -> f64 {
        self.moments[waypoint].time
    }

    /// The time at a fractional waypoint, s.
    pub fn time_at(&self, at: f64) -> f64 {
        let before = (at as usize).min(self.len() - 1);
        let after = (before + 1).min(self.len() - 1);
        let (from, to) = (self.time(before), self.time(after));
        from + (at - before as f64).clamp(0.0, 1.0) * (to - from)
    }

    /// The root's pose at a waypoint.
    pub fn world_from_root(&self, waypoint: usize) -> Pose {
        self.moments[waypoint].world_from_root
    }

    /// Every link's pose at a fractional waypoint, 0 to `len() - 1`.
    pub fn world_from_links(&self, at: f64) -> Vec<Pose> {
        let first = (at as usize).min(self.len() - 1);
        let (a, b) = (&self.moments[first], &self.moments[(first + 1).min(self.len() - 1)]);
        let t = (at - first as f64).clamp(0.0, 1.0);
        let q: Vec<f64> = a.q.iter().zip(&b.q).map(|(a, b)| a + t * (b - a)).collect();
        let mut links = vec![Pose::IDENTITY; self.kinematics.links_len()];
        self.kinematics.forward(
            &interpolate(&a.world_from_root, &b.world_from_root, t),
            &q,
            &mut links,
        );
        links
    }

    /// The centre of mass at every waypoint, world frame.
    pub fn center_of_mass_path(&self) -> Vec<DVec3> {
        (0..self.len())
            .map(|waypoint| self.kinematics.center_of_mass(&self.world_from_links(waypoint as f64)))
            .collect()
    }

    /// `count` (at least 2) fractional waypoints at equal intervals of time.
    pub fn evenly_timed(&self, count: usize) -> Vec<f64> {
        let (begin, end) = (self.moments[0].time, self.moments[self.len() - 1].time);
        (0..count)
            .map(|i| self.at_time(begin + (end - begin) * i as f64 / (count - 1) as f64))
            .collect()
    }

    /// Between 2 and `count_max` waypoints, first and last included, about equally far apart along
    /// the walk and not nearer than `spacing` (m) unless there are only 2. A robot that stays where
    /// it is gives one.
    pub fn evenly_spaced(&self, spacing: f64, count_max: usize) -> Vec<usize> {
        let walked = self.walked();
        let total = walked[self.len() - 1];
        if total == 0.0 {
            return vec![self.len() - 1];
        }
        let count = (libm::floor(total / spacing) as usize + 1).clamp(2, count_max.max(2));
        let inner = (1..count - 1)
            .map(|i| walked.partition_point(|&w| w < total * i as f64 / (count - 1) as f64));
        std::iter::once(0).chain(inner).chain([self.len() - 1]).collect()
    }

    /// The share of the walk that lies behind the robot at each waypoint, 0 to 1.
    pub fn progress(&self) -> Vec<f32> {
        let walked = self.walked();
        let total = walked[self.len() - 1].max(f64::MIN_POSITIVE);
        walked.iter().map(|&w| (w / total) as f32).collect()
    }

    /// The horizontal distance to each waypoint, m, without swaying.
    fn walked(&self) -> Vec<f64> {
        let ground = |moment: &Moment| moment.world_from_root.translation.truncate();
        let mut anchor = ground(&self.moments[0]);
        let mut walked = 0.0;
        let distance = self.moments.iter().map(|moment| {
            let step = (ground(moment) - anchor).length();
            if step > SWAY {
                walked += step;
                anchor = ground(moment);
            }
            walked
        });
        distance.collect()
    }

    fn at_time(&self, time: f64) -> f64 {
        let next = self
            .moments
            .partition_point(|moment| moment.time <= time)
            .clamp(1, self.len().max(2) - 1);
        let Some(after) = self.moments.get(next) else { return 0.0 };
        let before = &self.moments[next - 1];
        next as f64 - 1.0
            + ((time - before.time) / (after.time - before.time).max(f64::MIN_POSITIVE))
                .clamp(0.0, 1.0)
    }
}

/// For each joint of the model, its place in the plan's joint vectors.
fn joint_order(model: &RobotModel, plan: &PlanFile) -> Result<Vec<usize>, PictureError> {
    let place = |name: &str| plan.joint_names.iter().position(|listed| listed == name);
    let order = model.joints.iter().map(|joint| {
        place(&joint.name).ok_or_else(|| {
            PictureError::plan(format!(
                "joint '{}' of the robot is not among its joint_names",
                joint.name
            ))
        })
    });
    order.collect()
}
