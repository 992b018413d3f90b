//! Joint positions of a chain that place a frame: damped least squares.

use glam::DVec3;

use crate::base::spatial::{Pose, scaled_axis_from_rotation};
use crate::robot::model::JointKind;
use crate::robot_draft::skeleton::{NodeIndex, Skeleton};

/// Most steps of the iteration.
const ITERATIONS_MAX: usize = 300;
/// Errors below this are none, m and rad.
const TOLERANCE: f64 = 1e-8;
/// The squared damping.
const DAMPING: f64 = 1e-6;
/// The longest step of a joint, rad or m.
const STEP_MAX: f64 = 0.2;
/// Distance that solutions keep to the limits, rad or m.
const LIMIT_MARGIN: f64 = 0.05;
/// Distance that solutions keep to the limits as a share of the range, where that is less.
const LIMIT_MARGIN_SHARE: f64 = 0.05;

/// A frame to be placed by the joints of a chain.
pub(crate) struct FrameTarget<'a> {
    pub(crate) chain: &'a [NodeIndex],
    pub(crate) body: NodeIndex,
    pub(crate) body_from_frame: Pose,
    pub(crate) root_from_target: Pose,
}

impl FrameTarget<'_> {
    /// Moves the chain's joints from where they are until the frame is at its target. Returns
    /// whether it is.
    pub(crate) fn solve(&self, skeleton: &Skeleton, positions: &mut [f64]) -> bool {
        for _ in 0..ITERATIONS_MAX {
            let poses = skeleton.poses(positions);
            let error = self.error(&poses);
            if error.iter().all(|part| part.abs() <= TOLERANCE) {
                return true;
            }
            let columns = self.jacobian(skeleton, &poses);
            let Some(weights) = solve_6(normal_matrix(&columns), error) else { return false };
            for (node, column) in self.chain.iter().zip(&columns) {
                let step: f64 = column.iter().zip(&weights).map(|(a, b)| a * b).sum();
                let (lower, upper) = usable_range(skeleton, *node);
                positions[*node] =
                    (positions[*node] + step.clamp(-STEP_MAX, STEP_MAX)).clamp(lower, upper);
            }
        }
        false
    }

    /// Translation and rotation from the frame to its target, root frame.
    fn error(&self, poses: &[Pose]) -> [f64; 6] {
        let frame = poses[self.body] * self.body_from_frame;
        let moved = self.root_from_target.translation - frame.translation;
        let turned = self.root_from_target.rotation * frame.rotation.inverse();
        let turned = scaled_axis_from_rotation(turned);
        [moved.x, moved.y, moved.z, turned.x, turned.y, turned.z]
    }

    /// How the frame moves with each joint of the chain.
    fn jacobian(&self, skeleton: &Skeleton, poses: &[Pose]) -> Vec<[f64; 6]> {
        let at = (poses[self.body] * self.body_from_frame).translation;
        let column = |node: &NodeIndex| {
            let Some(joint) = &skeleton.nodes[*node].joint else { return [0.0; 6] };
            // A joint leaves its own axis where it is.
            let axis = poses[*node].rotation * joint.axis;
            let (moves, turns) = match joint.kind {
                JointKind::Revolute => (axis.cross(at - poses[*node].translation), axis),
                JointKind::Prismatic => (axis, DVec3::ZERO),
            };
            [moves.x, moves.y, moves.z, turns.x, turns.y, turns.z]
        };
        self.chain.iter().map(column).collect()
    }
}

/// The positions of a joint that a posture may use.
pub(crate) fn usable_range(skeleton: &Skeleton, node: NodeIndex) -> (f64, f64) {
    let Some(joint) = &skeleton.nodes[node].joint else { return (0.0, 0.0) };
    let margin = LIMIT_MARGIN.min(LIMIT_MARGIN_SHARE * (joint.upper - joint.lower));
    (joint.lower + margin, joint.upper - margin)
}

fn normal_matrix(columns: &[[f64; 6]]) -> [[f64; 6]; 6] {
    std::array::from_fn(|row| {
        std::array::from_fn(|at| {
            let sum: f64 = columns.iter().map(|column| column[row] * column[at]).sum();
            sum + if row == at { DAMPING } else { 0.0 }
        })
    })
}

/// Solves six linear equations by elimination with pivots; `None` if they are singular.
fn solve_6(mut matrix: [[f64; 6]; 6], mut right: [f64; 6]) -> Option<[f64; 6]> {
    for pivot in 0..6 {
        let best = (pivot..6)
            .max_by(|a, b| matrix[*a][pivot].abs().total_cmp(&matrix[*b][pivot].abs()))?;
        matrix.swap(pivot, best);
        right.swap(pivot, best);
        if matrix[pivot][pivot].abs() < f64::MIN_POSITIVE {
            return None;
        }
        for row in pivot + 1..6 {
            let factor = matrix[row][pivot] / matrix[pivot][pivot];
            let pivot_row = matrix[pivot];
            for (entry, above) in matrix[row].iter_mut().zip(&pivot_row).skip(pivot) {
                *entry -= factor * above;
            }
            right[row] -= factor * right[pivot];
        }
    }
    let mut solution = [0.0; 6];
    for row in (0..6).rev() {
        let known: f64 = (row + 1..6).map(|at| matrix[row][at] * solution[at]).sum();
        solution[row] = (right[row] - known) / matrix[row][row];
    }
    Some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_equations_are_solved() {
        let matrix: [[f64; 6]; 6] = std::array::from_fn(|row| {
            std::array::from_fn(|at| if row == at { 0.0 } else { (1 + row * 7 + at * 3) as f64 })
        });
        let expected = [1.0, -2.0, 0.5, 3.0, 0.0, -1.0];
        let right = matrix.map(|row| row.iter().zip(&expected).map(|(a, b)| a * b).sum());
        let solution = solve_6(matrix, right).unwrap();
        assert!(solution.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9), "{solution:?}");
        assert!(solve_6([[0.0; 6]; 6], right).is_none());
    }
}
