//! One step of the Newton iteration: exact away from singularities, damped least squares otherwise.

use crate::kinematics::leg_chain::Vector6;
use crate::kinematics::leg_joint::LegPositions;
use crate::kinematics::tuning::UNDAMPED_PIVOT_MIN;

/// Smallest pivot of the damped system; below it the system counts as singular.
const DAMPED_PIVOT_MIN: f64 = 1e-14;
/// Damping of the normal equations; small enough for superlinear convergence.
const NORMAL_DAMPING: f64 = 1e-9;

/// The joint motion (rad or m) that removes the error to first order, for a Jacobian with one
/// column per joint; `None` if it cannot be computed.
pub(crate) fn newton_step(columns: &[Vector6], error: &Vector6) -> Option<LegPositions> {
    exact(columns, error).or_else(|| damped(columns, error))
}

/// `J^-1 error`; `None` unless there are six columns, and near a singularity.
fn exact(columns: &[Vector6], error: &Vector6) -> Option<LegPositions> {
    let columns: &[Vector6; 6] = columns.try_into().ok()?;
    let equation = |row: usize| {
        [0, 1, 2, 3, 4, 5, 6].map(|col| columns.get(col).map_or(error[row], |column| column[row]))
    };
    let mut system = [0, 1, 2, 3, 4, 5].map(equation);
    let solution = eliminate(&mut system, UNDAMPED_PIVOT_MIN)?;
    Some(solution.into_iter().collect())
}

/// The least-norm step `J^T (J J^T + damping)^-1 error`.
fn damped(columns: &[Vector6], error: &Vector6) -> Option<LegPositions> {
    let mut normal = [[0.0; 7]; 6];
    for (row, equation) in normal.iter_mut().enumerate() {
        for (col, entry) in equation[..6].iter_mut().enumerate() {
            *entry = columns.iter().map(|c| c[row] * c[col]).sum();
        }
        equation[row] += NORMAL_DAMPING;
        equation[6] = error[row];
    }
    let solution = eliminate(&mut normal, DAMPED_PIVOT_MIN)?;
    Some(columns.iter().map(|c| c.iter().zip(&solution).map(|(a, b)| a * b).sum()).collect())
}

/// Solves a 6 by 6 system with its right-hand side as seventh column, by Gaussian elimination with
/// partial pivoting; `None` if a pivot is smaller than `pivot_min`.
fn eliminate(system: &mut [[f64; 7]; 6], pivot_min: f64) -> Option<Vector6> {
    for pivot in 0..6 {
        let larger = |best: usize, row: usize| {
            if system[row][pivot].abs() > system[best][pivot].abs() { row } else { best }
        };
        let best = (pivot + 1..6).fold(pivot, larger);
        system.swap(pivot, best);
        let equation = system[pivot];
        if equation[pivot].abs() < pivot_min {
            return None;
        }
        let inverse = 1.0 / equation[pivot];
        for row in &mut system[pivot + 1..] {
            let factor = row[pivot] * inverse;
            // Whole rows vectorize; entries left of the pivot are not read again.
            for (entry, above) in row.iter_mut().zip(&equation) {
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
