//! Bounded numeric inverse kinematics for a leg without a closed form: damped Newton steps from the
//! caller's positions, from the standing posture, and from those of some known postures whose soles
//! are nearest to the one desired.

use glam::{DMat3, DQuat, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::scaled_axis_from_rotation;
use surefoot_shared_types::robot::model::JointKind;

use crate::base::random::{Random, Stream};
use crate::kinematics::leg::{LEG_JOINTS_MAX, LegJoint, LegPositions};

/// Newton steps from one start; from near the solution three or four suffice.
const ITERATIONS_MAX: usize = 16;
/// Steps after which a start must have come near.
const APPROACH_ITERATIONS: usize = 8;
/// How near, m and rad: from there on every step squares the error.
const NEAR: f64 = 0.2;
/// The cosine of half of a turn (0.4 rad) up to which its chord stands for it.
const COS_HALF_SMALL: f64 = 0.98;
/// A step that leaves more than this share of the least error so far makes no progress.
const STALL: f64 = 0.98;
/// So many such steps in a row end a start.
const STALLS_MAX: usize = 3;
/// So many steps in a row that push a joint against its limit end a start, too: of a thousand
/// starts that lead to a solution one does so, of those that lead to none most.
const PUSHES_MAX: usize = 3;
/// Known postures: the first half near the standing one, the others anywhere within the limits.
const POSTURES: usize = 512;
/// How far the first half strays from the standing posture, rad or m.
const STANDING_STRAY: f64 = 0.7;
/// Known postures that are tried for one sole.
const POSTURE_STARTS: usize = 4;
/// The distance (m) that counts as much as a turn by two radians when postures are compared.
const LENGTH_SCALE: f64 = 0.4;
/// A solution's largest error, m and rad.
const TOLERANCE: f64 = 1e-9;
/// The longest joint motion of one step, rad or m: keeps far starts from leaping across branches.
const STEP_MAX: f64 = 0.5;
/// More than what rounding adds to a length, m.
const ROUNDING: f64 = 1e-9;
/// A smaller pivot than this (m or 1) stands for a leg near a singularity, where steps are damped.
const PIVOT_MIN: f64 = 1e-3;
/// A smaller pivot of the damped system stands for no solution.
const SINGULAR: f64 = 1e-14;
/// Damping of the normal equations; small enough to leave convergence superlinear.
const DAMPING: f64 = 1e-9;

/// The chain and the starts of a leg.
#[derive(Debug, Clone)]
pub struct Newton {
    /// The root from the first joint, its axis along z.
    root_from_first: DMat3,
    links: BoundedVec<Link, LEG_JOINTS_MAX>,
    sole_from_ankle: DVec3,
    reach: f64,
    standing: LegPositions,
    postures: Vec<Posture>,
}

/// What a joint carries up to the next one, or to the sole, in a frame that moves with the joint,
/// its axis along z.
#[derive(Debug, Clone, Copy)]
struct Link {
    joint_from_next: DMat3,
    /// Where the next joint's point is, m.
    next: DVec3,
}

/// A posture of the leg and where its sole is then.
#[derive(Debug, Clone)]
struct Posture {
    root_from_sole: Pose,
    positions: LegPositions,
}

type Vector6 = [f64; 6];

impl Newton {
    /// Prepares the iteration; `standing_q` is the second start after the caller's own.
    pub fn new(joints: &[LegJoint], zero_root_from_sole: &Pose, standing_q: &[f64]) -> Self {
        let standing: LegPositions = joints.iter().map(|joint| standing_q[joint.index]).collect();
        let ankle = joints[joints.len() - 1].point;
        let mut newton = Self {
            root_from_first: frame_along(joints[0].axis),
            links: links(joints, zero_root_from_sole),
            sole_from_ankle: zero_root_from_sole.inverse_transform_point(ankle),
            reach: longest(joints),
            standing,
            postures: Vec::with_capacity(POSTURES),
        };
        for index in 0..POSTURES {
            let positions = newton.sample_posture(joints, index);
            let root_from_sole =
                newton.forward(joints, &positions, &mut [[0.0; 6]; LEG_JOINTS_MAX]);
            newton.postures.push(Posture { root_from_sole, positions });
        }
        newton
    }

    fn sample_posture(&self, joints: &[LegJoint], index: usize) -> LegPositions {
        let mut random = Random::new(0, Stream::Preparation, 1 << 33, index as u64);
        let near_standing = index < POSTURES / 2;
        let draw = |(joint, &standing): (&LegJoint, &f64)| {
            let stray = if near_standing { STANDING_STRAY } else { f64::INFINITY };
            random.uniform(joint.lower.max(standing - stray), joint.upper.min(standing + stray))
        };
        joints.iter().zip(&self.standing).map(draw).collect()
    }

    /// A solution within the limits: from `near`, else from the standing posture, else from known
    /// postures.
    pub fn solve(
        &self,
        joints: &[LegJoint],
        root_from_sole: &Pose,
        near: &LegPositions,
    ) -> Option<LegPositions> {
        if !self.is_within_reach(joints, root_from_sole) {
            return None;
        }
        let found = |at: usize| self.descend(joints, root_from_sole, &self.postures[at].positions);
        let known = || self.nearest_postures(root_from_sole).into_iter().find_map(found);
        self.solve_near(joints, root_from_sole, near).or_else(known)
    }

    /// The same without the known postures: for samples, most of which have no solution.
    pub fn solve_near(
        &self,
        joints: &[LegJoint],
        root_from_sole: &Pose,
        near: &LegPositions,
    ) -> Option<LegPositions> {
        if !self.is_within_reach(joints, root_from_sole) {
            return None;
        }
        let standing = (near != &self.standing).then_some(&self.standing);
        std::iter::once(near)
            .chain(standing)
            .find_map(|start| self.descend(joints, root_from_sole, start))
    }

    /// Whether the ankle may be where the sole has it.
    fn is_within_reach(&self, joints: &[LegJoint], root_from_sole: &Pose) -> bool {
        (*root_from_sole * self.sole_from_ankle).distance(joints[0].point) <= self.reach
    }

    /// The known postures whose soles are nearest, nearest first.
    fn nearest_postures(&self, root_from_sole: &Pose) -> [usize; POSTURE_STARTS] {
        let mut nearest = [(f64::INFINITY, 0); POSTURE_STARTS];
        for (index, posture) in self.postures.iter().enumerate() {
            let shift =
                (posture.root_from_sole.translation - root_from_sole.translation).length_squared();
            let aligned = posture.root_from_sole.rotation.dot(root_from_sole.rotation);
            let mut candidate =
                (shift / (LENGTH_SCALE * LENGTH_SCALE) + 4.0 * (1.0 - aligned * aligned), index);
            for kept in &mut nearest {
                if candidate.0 < kept.0 {
                    std::mem::swap(kept, &mut candidate);
                }
            }
        }
        nearest.map(|(_, index)| index)
    }

    fn descend(
        &self,
        joints: &[LegJoint],
        target: &Pose,
        start: &LegPositions,
    ) -> Option<LegPositions> {
        let mut q = start.clone();
        let (mut least, mut stalls, mut pushes) = (f64::INFINITY, 0, 0);
        for iteration in 0..ITERATIONS_MAX {
            let mut columns = [[0.0; 6]; LEG_JOINTS_MAX];
            let reached = self.forward(joints, &q, &mut columns);
            let error = twist(&reached, target);
            if error.iter().all(|e| e.abs() < TOLERANCE) {
                return joints
                    .iter()
                    .zip(&q)
                    .all(|(joint, &position)| joint.is_within_limits(position))
                    .then_some(q);
            }
            let size = error.iter().fold(0.0_f64, |size, e| size.max(e.abs()));
            stalls = if size > STALL * least { stalls + 1 } else { 0 };
            least = least.min(size);
            if stalls == STALLS_MAX || iteration == APPROACH_ITERATIONS && size > NEAR {
                return None;
            }
            let columns = &columns[..joints.len()];
            let step = exact(columns, &error).or_else(|| least_squares(columns, &error))?;
            let longest = step.iter().fold(0.0_f64, |longest, s| longest.max(s.abs()));
            let scale = if longest > STEP_MAX { STEP_MAX / longest } else { 1.0 };
            let mut is_at_limit = false;
            for ((position, s), joint) in q.iter_mut().zip(&step).zip(joints) {
                let desired = *position + scale * s;
                is_at_limit |= !joint.is_within_limits(desired);
                *position = desired.clamp(joint.lower, joint.upper);
            }
            pushes = if is_at_limit { pushes + 1 } else { 0 };
            if pushes == PUSHES_MAX {
                return None;
            }
        }
        None
    }

    /// The sole's pose, and the twist (linear at the sole's origin, angular) of each joint.
    fn forward(&self, joints: &[LegJoint], q: &LegPositions, columns: &mut [Vector6]) -> Pose {
        let (mut point, mut frame) = (joints[0].point, self.root_from_first);
        let mut axes = [(DVec3::ZERO, DVec3::ZERO); LEG_JOINTS_MAX];
        for (((joint, link), &position), axis) in
            joints.iter().zip(&self.links).zip(q).zip(&mut axes)
        {
            *axis = (point, frame.z_axis);
            match joint.kind {
                JointKind::Revolute => turn_about_z(&mut frame, position),
                JointKind::Prismatic => point += frame.z_axis * position,
            }
            point += frame * link.next;
            frame *= link.joint_from_next;
        }
        for ((joint, (at, axis)), column) in joints.iter().zip(axes).zip(columns) {
            let (linear, angular) = match joint.kind {
                JointKind::Revolute => (axis.cross(point - at), axis),
                JointKind::Prismatic => (axis, DVec3::ZERO),
            };
            *column = [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z];
        }
        Pose::from_parts(point, DQuat::from_mat3(&frame))
    }
}

/// A frame whose z points along an axis.
fn frame_along(axis: DVec3) -> DMat3 {
    let x = axis.any_orthonormal_vector();
    DMat3::from_cols(x, axis.cross(x), axis)
}

/// Turns a frame about its own z.
fn turn_about_z(frame: &mut DMat3, angle: f64) {
    let (sin, cos) = libm::sincos(angle);
    let (x, y) = (frame.x_axis, frame.y_axis);
    (frame.x_axis, frame.y_axis) = (x * cos + y * sin, y * cos - x * sin);
}

fn links(joints: &[LegJoint], zero_root_from_sole: &Pose) -> BoundedVec<Link, LEG_JOINTS_MAX> {
    let ends = joints[1..].iter().map(|joint| (frame_along(joint.axis), joint.point));
    let sole = (DMat3::from_quat(zero_root_from_sole.rotation), zero_root_from_sole.translation);
    let link = |(joint, (frame, point)): (&LegJoint, (DMat3, DVec3))| {
        let joint_from_root = frame_along(joint.axis).transpose();
        Link {
            joint_from_next: joint_from_root * frame,
            next: joint_from_root * (point - joint.point),
        }
    };
    joints.iter().zip(ends.chain(std::iter::once(sole))).map(link).collect()
}

/// An upper bound of the distance between the first and the last joint's points, m.
fn longest(joints: &[LegJoint]) -> f64 {
    let links: f64 = joints.windows(2).map(|pair| pair[0].point.distance(pair[1].point)).sum();
    let slides = joints.iter().filter(|joint| joint.kind == JointKind::Prismatic);
    links + slides.map(|joint| joint.lower.abs().max(joint.upper.abs())).sum::<f64>() + ROUNDING
}

fn twist(from: &Pose, to: &Pose) -> Vector6 {
    let linear = to.translation - from.translation;
    let turn = to.rotation * from.rotation.conjugate();
    // The chord of a small turn leads to the same place as its arc, without an arc tangent.
    let angular =
        if turn.w > COS_HALF_SMALL { 2.0 * turn.xyz() } else { scaled_axis_from_rotation(turn) };
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// The step that six columns make do all of the error, `J^-1 error`; `None` of other numbers of
/// them and near a singularity.
fn exact(columns: &[Vector6], error: &Vector6) -> Option<LegPositions> {
    let columns: &[Vector6; 6] = columns.try_into().ok()?;
    let line = |row: usize| {
        [0, 1, 2, 3, 4, 5, 6].map(|col| columns.get(col).map_or(error[row], |column| column[row]))
    };
    let mut system = [0, 1, 2, 3, 4, 5].map(line);
    let solution = eliminate(&mut system, PIVOT_MIN)?;
    Some(solution.into_iter().collect())
}

/// The least-norm step `J^T (J J^T + damping)^-1 error`, one entry per column of J.
fn least_squares(columns: &[Vector6], error: &Vector6) -> Option<LegPositions> {
    let mut normal = [[0.0; 7]; 6];
    for (row, line) in normal.iter_mut().enumerate() {
        for (col, entry) in line[..6].iter_mut().enumerate() {
            *entry = columns.iter().map(|c| c[row] * c[col]).sum();
        }
        line[row] += DAMPING;
        line[6] = error[row];
    }
    let solution = eliminate(&mut normal, SINGULAR)?;
    Some(columns.iter().map(|c| c.iter().zip(&solution).map(|(a, b)| a * b).sum()).collect())
}

/// Solves a 6 by 6 system given with its right-hand side as a seventh column; `None` where a pivot
/// is less than `pivot_min`.
fn eliminate(system: &mut [[f64; 7]; 6], pivot_min: f64) -> Option<Vector6> {
    for pivot in 0..6 {
        let larger = |best: usize, row: usize| {
            if system[row][pivot].abs() > system[best][pivot].abs() { row } else { best }
        };
        let best = (pivot + 1..6).fold(pivot, larger);
        system.swap(pivot, best);
        let line = system[pivot];
        if line[pivot].abs() < pivot_min {
            return None;
        }
        let inverse = 1.0 / line[pivot];
        for row in &mut system[pivot + 1..] {
            let factor = row[pivot] * inverse;
            // Whole rows, since these are done two numbers at a time; what is left of the pivot is
            // not read again.
            for (entry, above) in row.iter_mut().zip(&line) {
                *entry -= factor * above;
            }
        }
    }
    let mut solution = [0.0; 6];
    for row in (0..6).rev() {
        let known: f64 = (row + 1..6).map(|col| system[row][col] * solution[col]).sum();
        solution[row] = (system[row][6] - known) / system[row][row];
    }
    Some(solution)
}
