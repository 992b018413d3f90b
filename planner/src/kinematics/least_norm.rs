//! The smallest step that makes up for an error while nothing goes beyond its limits.

use heapless::Vec as BoundedVec;

/// Damping of the normal equations; small enough to leave convergence superlinear.
const DAMPING: f64 = 1e-6;
/// How often unknowns that would go beyond their limits are stopped there and the others solved for
/// again.
const ROUNDS_MAX: usize = 4;

/// One unknown of a step.
#[derive(Debug, Clone, Copy)]
pub struct Unknown<const ROWS: usize> {
    /// What a unit of it does to each row of the error.
    pub effect: [f64; ROWS],
    /// How readily it moves, compared with the others.
    pub weight: f64,
    /// How far it may go, down (not positive) and up.
    pub range: [f64; 2],
}

/// The step of all unknowns that is smallest, each counted by its ease, and makes up for `error`;
/// as much of it as is possible where some are stopped at their limits. `None` where the equations
/// cannot be solved.
pub fn least_norm<const ROWS: usize, const UNKNOWNS: usize>(
    unknowns: &BoundedVec<Unknown<ROWS>, UNKNOWNS>,
    error: &[f64; ROWS],
) -> Option<[f64; UNKNOWNS]> {
    let mut step = [0.0; UNKNOWNS];
    let mut is_stopped = [false; UNKNOWNS];
    let mut left = *error;
    for _ in 0..ROUNDS_MAX {
        let mut normal = [[0.0; ROWS]; ROWS];
        for (unknown, _) in unknowns.iter().zip(&is_stopped).filter(|(_, is_stopped)| !**is_stopped)
        {
            add_outer(&mut normal, unknown);
        }
        let multipliers = solve_symmetric(normal, left)?;
        let mut stops = false;
        let moving = unknowns
            .iter()
            .zip(&mut step)
            .zip(&mut is_stopped)
            .filter(|(_, is_stopped)| !**is_stopped);
        for ((Unknown { effect, weight, range: [lowest, highest] }, step), is_stopped) in moving {
            *step = (weight * dot(effect, &multipliers)).clamp(*lowest, *highest);
            *is_stopped = *step == *lowest || *step == *highest;
            if *is_stopped {
                stops = true;
                left.iter_mut().zip(effect).for_each(|(row, effect)| *row -= effect * *step);
            }
        }
        if !stops {
            break;
        }
    }
    Some(step)
}

/// Adds an unknown's part of the normal equations, of which the lower half is kept.
fn add_outer<const ROWS: usize>(normal: &mut [[f64; ROWS]; ROWS], unknown: &Unknown<ROWS>) {
    for (row, line) in normal.iter_mut().enumerate() {
        let scaled = unknown.weight * unknown.effect[row];
        if scaled != 0.0 {
            line[..=row]
                .iter_mut()
                .zip(&unknown.effect)
                .for_each(|(entry, effect)| *entry += scaled * effect);
        }
    }
}

/// Solves damped symmetric equations, given by their lower half, by Cholesky's decomposition.
fn solve_symmetric<const ROWS: usize>(
    mut lower: [[f64; ROWS]; ROWS],
    mut right: [f64; ROWS],
) -> Option<[f64; ROWS]> {
    for row in 0..ROWS {
        for column in 0..row {
            let known = dot(&lower[row][..column], &lower[column][..column]);
            lower[row][column] = (lower[row][column] - known) / lower[column][column];
        }
        let pivot = lower[row][row] + DAMPING - dot(&lower[row][..row], &lower[row][..row]);
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
    fn what_moves_more_readily_moves_more() {
        let free = [-9.0, 9.0];
        let unknowns = [
            unknown([1.0, 0.0], 3.0, free),
            unknown([1.0, 0.0], 1.0, free),
            unknown([0.0, 2.0], 1.0, free),
        ];
        let step: [f64; 4] = least_norm(&unknowns.into_iter().collect(), &[4.0, -2.0]).unwrap();
        for (got, wanted) in step.iter().zip([3.0, 1.0, -1.0, 0.0]) {
            assert!((got - wanted).abs() < 1e-4, "{step:?}");
        }
    }

    #[test]
    fn what_is_stopped_is_made_up_for_by_the_others() {
        let unknowns = [
            unknown([1.0, 0.5], 1.0, [-0.25, 0.25]),
            unknown([1.0, 0.0], 1.0, [-9.0, 9.0]),
            unknown([0.0, 1.0], 1.0, [-9.0, 9.0]),
        ];
        let step: [f64; 3] = least_norm(&unknowns.into_iter().collect(), &[2.0, 1.0]).unwrap();
        for (got, wanted) in step.iter().zip([0.25, 1.75, 0.875]) {
            assert!((got - wanted).abs() < 1e-4, "{step:?}");
        }
    }

    #[test]
    fn what_nothing_can_do_is_left() {
        let unknowns: BoundedVec<_, 1> =
            [unknown([1.0, 0.0], 1.0, [-0.5, 0.5])].into_iter().collect();
        assert_eq!(least_norm(&unknowns, &[2.0, 1.0]), Some([0.5]));
    }
}
