//! The tools to damage a plan with.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use glam::{DQuat, DVec3};
use surefoot_shared_types::plan_format::blocks::{
    ContactBlock, PhaseBlock, PlanFile, PoseBlock, SceneShapeBlock, ShapeBlock, WaypointBlock,
};

/// Stones further from a sole than this do not carry it, m.
const STONES_WITHIN: f64 = 0.4;

/// A plan to damage, and the folder in which its files lie.
pub struct DamagedPlan {
    pub plan: PlanFile,
    pub folder: PathBuf,
}

impl DamagedPlan {
    /// The phase in this mode nearest the plan's middle.
    pub fn middle_phase(&self, mode: &str) -> usize {
        let middle = self.plan.phases.len() / 2;
        let of_mode =
            (0..self.plan.phases.len()).filter(|&phase| self.plan.phases[phase].mode == mode);
        of_mode.min_by_key(|phase| phase.abs_diff(middle)).unwrap()
    }

    pub fn waypoints_of(&self, phase: usize) -> RangeInclusive<usize> {
        self.plan.phases[phase].first..=self.plan.phases[phase].last
    }

    /// A waypoint in the middle of a step of the left foot.
    pub fn mid_step(&self) -> usize {
        let phase = &self.plan.phases[self.middle_phase("right")];
        (phase.first + phase.last) / 2
    }

    pub fn joint(&self, name: &str) -> usize {
        self.plan.joint_names.iter().position(|joint| joint == name).unwrap()
    }

    /// Adds `change` to a joint at some waypoints.
    pub fn bend(&mut self, joint: &str, change: f64, waypoints: impl IntoIterator<Item = usize>) {
        let joint = self.joint(joint);
        waypoints.into_iter().for_each(|waypoint| self.plan.waypoints[waypoint].q[joint] += change);
    }

    pub fn everywhere(&self) -> std::ops::Range<usize> {
        0..self.plan.waypoints.len()
    }

    pub fn push_root(&mut self, change: DVec3, waypoints: impl IntoIterator<Item = usize>) {
        waypoints
            .into_iter()
            .for_each(|waypoint| push(&mut self.plan.waypoints[waypoint].root_xyz, change));
    }

    /// All contacts of all phases.
    pub fn contacts(&mut self) -> impl Iterator<Item = &mut ContactBlock> {
        self.plan.phases.iter_mut().flat_map(|phase| &mut phase.contacts)
    }

    /// Moves whole plan and declared contacts, but not the world.
    pub fn push_all(&mut self, change: DVec3) {
        self.push_root(change, self.everywhere());
        self.contacts().for_each(|contact| push(&mut contact.sole_pose.xyz, change));
    }

    /// Changes the declared pose of the stance foot of the middle step, in every phase that names
    /// it.
    pub fn redeclare(&mut self, change: impl Fn(&mut PoseBlock)) {
        let declared = self.stance();
        self.contacts()
            .filter(|contact| **contact == declared)
            .for_each(|contact| change(&mut contact.sole_pose));
    }

    /// The foot that stands during the middle step.
    pub fn stance(&self) -> ContactBlock {
        self.plan.phases[self.middle_phase("right")].contacts[0].clone()
    }

    /// The world's shape below the stance foot of the middle step.
    pub fn stone(&mut self) -> &mut SceneShapeBlock {
        let sole = DVec3::from(self.stance().sole_pose.xyz);
        let distance = |shape: &SceneShapeBlock| {
            DVec3::from(shape.pose.xyz).truncate().distance(sole.truncate())
        };
        self.plan
            .scene
            .shapes
            .iter_mut()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .unwrap()
    }

    /// All shapes of the world that may carry the stance foot of the middle step.
    pub fn stones(&mut self) -> impl Iterator<Item = &mut SceneShapeBlock> {
        let sole = DVec3::from(self.stance().sole_pose.xyz);
        self.plan
            .scene
            .shapes
            .iter_mut()
            .filter(move |shape| DVec3::from(shape.pose.xyz).distance(sole) < STONES_WITHIN)
    }

    pub fn remove_stones(&mut self) {
        let names: Vec<String> = self.stones().map(|stone| stone.name.clone()).collect();
        self.plan.scene.shapes.retain(|shape| !names.contains(&shape.name));
    }

    pub fn add(&mut self, at: DVec3, shape: ShapeBlock) {
        let pose = PoseBlock { xyz: at.to_array(), quat_xyzw: DQuat::IDENTITY.to_array() };
        self.plan.scene.shapes.push(SceneShapeBlock { name: "intruder".into(), pose, shape });
    }

    pub fn add_box(&mut self, at: DVec3, half_extents: [f64; 3]) {
        self.add(at, ShapeBlock::Box { half_extents });
    }

    /// Where the root is at a waypoint.
    pub fn root(&self, waypoint: usize) -> DVec3 {
        self.plan.waypoints[waypoint].root_xyz.into()
    }

    /// Keeps the plan's beginning only.
    pub fn cut_after(&mut self, phase: usize) {
        self.plan.phases.truncate(phase + 1);
        self.plan.waypoints.truncate(self.plan.phases[phase].last + 1);
    }

    /// Keeps the plan's end only.
    pub fn cut_before(&mut self, phase: usize) {
        let first = self.plan.phases[phase].first;
        self.plan.phases.drain(..phase);
        self.plan.waypoints.drain(..first);
        self.plan.phases.iter_mut().for_each(|phase| {
            (phase.first, phase.last) = (phase.first - first, phase.last - first)
        });
    }

    /// Keeps every `stride`-th waypoint of a phase, and its ends.
    pub fn thin(&mut self, phase: usize, stride: usize) {
        let PhaseBlock { first, last, .. } = self.plan.phases[phase];
        let stays = |waypoint: usize| {
            waypoint <= first || waypoint >= last || (waypoint - first).is_multiple_of(stride)
        };
        let kept: Vec<WaypointBlock> = self
            .plan
            .waypoints
            .iter()
            .enumerate()
            .filter(|(index, _)| stays(*index))
            .map(|(_, waypoint)| waypoint.clone())
            .collect();
        let lost = self.plan.waypoints.len() - kept.len();
        self.plan.waypoints = kept;
        self.plan.phases[phase].last -= lost;
        self.plan.phases[phase + 1..]
            .iter_mut()
            .for_each(|phase| (phase.first, phase.last) = (phase.first - lost, phase.last - lost));
    }

    pub fn sole_polygons(&mut self) -> impl Iterator<Item = &mut Vec<[f64; 2]>> {
        self.plan.robot.feet.values_mut().map(|foot| &mut foot.polygon)
    }
}

pub fn push(xyz: &mut [f64; 3], change: DVec3) {
    *xyz = (DVec3::from(*xyz) + change).to_array();
}

pub fn turn(pose: &mut PoseBlock, axis: DVec3, degrees: f64) {
    let rotation =
        DQuat::from_axis_angle(axis, degrees.to_radians()) * DQuat::from_array(pose.quat_xyzw);
    pose.quat_xyzw = rotation.normalize().to_array();
}

/// A cube as an OBJ file's text, its triangles facing out.
pub fn cube_obj(half: f64) -> String {
    let corner =
        |i: u32| [i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| if bit == 1 { half } else { -half });
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let vertices = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]);
    vertices.chain(faces.map(|f| format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1))).collect()
}
