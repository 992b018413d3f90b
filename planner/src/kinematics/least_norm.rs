//! The least-norm step that removes an error while every unknown stays within its limits.

use heapless::Vec as BoundedVec;

use crate::kinematics::tuning::LIMIT_ROUNDS_MAX;

/// Damping of the normal equations; small enough for superlinear convergence.
const CHOLESKY_DAMPING: f64 = 1e-6;

/// One unknown of a step.
#[derive(Debug, Clone, Copy)]
pub struct Unknown<const ROWS: usize> {
    /// Change of each row of the error per unit.
    pub effect: [f64; ROWS],
    /// Inverse weight of its square in the norm: a larger value makes a larger step.
    pub weight: f64,
    /// Lowest (not positive) and highest step.
    pub range: [f64; 2],
}

/// The step of least weighted norm that removes `error`, as far as the limits allow. Unknowns
/// beyond their limits are fixed there, and the others are solved for again. `None` if the
/// equations are singular.
pub fn least_norm<const ROWS: usize, const UNKNOWNS: usize>(
    unknowns: &BoundedVec<Unknown<ROWS>, UNKNOWNS>,
    error: &[f64; ROWS],
) -> Option<[f64; UNKNOWNS]> {
    let mut step = [0.0; UNKNOWNS];
    let mut is_fixed = [false; UNKNOWNS];
    let mut remaining = *error;
    for _ in 0..LIMIT_ROUNDS_MAX {
        let mut normal = [[0.0; ROWS]; ROWS];
        for (unknown, _) in unknowns.iter().zip(&is_fixed).filter(|(_, is_fixed)| !**is_fixed) {
            add_outer(&mut normal, unknown);
        }
        let multipliers = solve_symmetric(normal, remaining)?;
        let mut is_any_fixed = false;
        let moving =
            unknowns.iter().zip(&mut step).zip(&mut is_fixed).filter(|(_, is_fixed)| !**is_fixed);
        for ((Unknown { effect, weight, range: [lowest, highest] }, step), is_fixed) in moving {
            *step = (weight * dot(effect, &multipliers)).clamp(*lowest, *highest);
            *is_fixed = *step == *lowest || *step == *highest;
            if *is_fixed {
                is_any_fixed = true;
                remaining.iter_mut().zip(effect).for_each(|(row, effect)| *row -= effect * *step);
            }
        }
        if !is_any_fixed {
            break;
        }
    }
    Some(step)
}

/// Adds an unknown's part to the lower half of the normal equations.
fn add_outer<const ROWS: usize>(normal: &mut [[f64; ROWS]; ROWS], unknown: &Unknown<ROWS>) {
    for (row, equation) in normal.iter_mut().enumerate() {
        let scaled = unknown.weight * unknown.effect[row];
        if scaled != 0.0 {
            equation[..=row]
                .iter_mut()
                .zip(&unknown.effect)
                .for_each(|(entry, effect)| *entry += scaled * effect);
        }
    }
}

/// Solves damped symmetric equations, given by their lower half, by Cholesky decomposition.
fn solve_symmetric<const ROWS: usize>(
    mut lower: [[f64; ROWS]; ROWS],
    mut right: [f64; ROWS],
) -> Option<[f64; ROWS]> {
    for row in 0..ROWS {
        for column in 0..row {
            let known = dot(&lower[row][..column], &lower[column][..column]);
            lower[row][column] = (lower[row][column] - known) / lower[column][column];
        }
        let pivot =
            lower[row][row] + CHOLESKY_DAMPING - dot(&lower[row][..row], &lower[row][..row]);
        if pivot <= 0.0 {
            return None;
        }
        lower[row][row] = pivot.sqrt();
        right[row] = (right[row] - dot(&lower[row][..row], &right[..row])) / lower[row][row];
    }
    for row in (0..ROWS).rev() {
        right[row] /= lower[row][row];
        let (above, solved) = right.split_at_mut(row);
        above.iter_mut().zip(&lower[row]).for_each(|(entry, factor)| *entry -= factor * solved[0]);
    }
    Some(right)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unknown(effect: [f64; 2], weight: f64, range: [f64; 2]) -> Unknown<2> {
        Unknown { effect, weight, range }
    }

    #[test]
    fn a_larger_weight_makes_a_larger_step() {
        let free = [-9.0, 9.0];
        let unknowns = [
            unknown([1.0, 0.0], 3.0, free),
            unknown([1.0, 0.0], 1.0, free),
            unknown([0.0, 2.0], 1.0, free),
        ];
        let step: [f64; 4] = least_norm(&unknowns.into_iter().collect(), &[4.0, -2.0]).unwrap();
        for (actual, expected) in step.iter().zip([3.0, 1.0, -1.0, 0.0]) {
            assert!((actual - expected).abs() < 1e-4, "{step:?}");
        }
    }

    #[test]
    fn others_replace_an_unknown_at_its_limit() {
        let unknowns = [
            unknown([1.0, 0.5], 1.0, [-0.25, 0.25]),
            unknown([1.0, 0.0], 1.0, [-9.0, 9.0]),
            unknown([0.0, 1.0], 1.0, [-9.0, 9.0]),
        ];
        let step: [f64; 3] = least_norm(&unknowns.into_iter().collect(), &[2.0, 1.0]).unwrap();
        for (actual, expected) in step.iter().zip([0.25, 1.75, 0.875]) {
            assert!((actual - expected).abs() < 1e-4, "{step:?}");
        }
    }

    #[test]
    fn an_error_beyond_all_limits_remains() {
        let unknowns: BoundedVec<_, 1> =
            [unknown([1.0, 0.0], 1.0, [-0.5, 0.5])].into_iter().collect();
        assert_eq!(least_norm(&unknowns, &[2.0, 1.0]), Some([0.5]));
    }
}
