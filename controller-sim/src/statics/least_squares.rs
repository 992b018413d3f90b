//! The contact forces of least squares.
//!
//! Of all forces along the pyramids' edges that hold the robot, those with the least sum of
//! squares. They are the positive part of a combination of the balance rows, so six multipliers
//! determine them; Newton's method finds these in microseconds. It is a quadratic program: where
//! Newton's method ends without forces, Clarabel decides.

use crate::base::linear_solve::solve;
use crate::statics::convex_program::ConvexProgram;
use crate::statics::equilibrium::{dot, is_balanced};
use crate::statics::simplex::Row;

/// Newton steps; the set of positive forces is final long before.
const NEWTON_STEPS_MAX: usize = 100;
/// Halvings of one step.
const HALVINGS_MAX: usize = 30;
/// Added to the diagonal, so that linearly dependent rows can be solved for.
const ROW_DAMPING: f64 = 1e-12;

/// The nonnegative variables with the least sum of squares that satisfy `rows`, or nothing where
/// there are none.
pub fn least_squares_forces(rows: &[Row]) -> Option<Vec<f64>> {
    by_newton(rows).or_else(|| by_interior_point(rows))
}

/// By Clarabel.
fn by_interior_point(rows: &[Row]) -> Option<Vec<f64>> {
    let columns = rows.first()?.0.len();
    let program = ConvexProgram {
        cost: vec![0.0; columns],
        square_cost: 1.0,
        nonnegative: columns,
        equalities: rows.to_vec(),
        inequalities: vec![],
    };
    program.solve().filter(|forces| is_balanced(rows, forces))
}

/// As [`least_squares_forces`], by Newton's method; nothing where it finds none.
fn by_newton(rows: &[Row]) -> Option<Vec<f64>> {
    let mut weights = vec![0.0; rows.len()];
    let mut forces = vec![0.0; rows.first()?.0.len()];
    for _ in 0..NEWTON_STEPS_MAX {
        if is_balanced(rows, &forces) {
            return Some(forces);
        }
        let step = newton_step(rows, &forces)?;
        let before = dual_objective(rows, &weights);
        let mut share = 1.0;
        let next = (0..HALVINGS_MAX).find_map(|_| {
            let next: Vec<f64> =
                weights.iter().zip(&step).map(|(weight, step)| weight + share * step).collect();
            share *= 0.5;
            (dual_objective(rows, &next) < before).then_some(next)
        })?;
        weights = next;
        forces = positive_part(rows, &weights);
    }
    None
}

/// The dual objective that Newton's method minimises; its gradient is the rows' residual.
fn dual_objective(rows: &[Row], weights: &[f64]) -> f64 {
    let squares: f64 = positive_part(rows, weights).iter().map(|force| force * force).sum();
    let reward: f64 = rows.iter().zip(weights).map(|((_, right), weight)| right * weight).sum();
    0.5 * squares - reward
}

fn positive_part(rows: &[Row], weights: &[f64]) -> Vec<f64> {
    let combined = |column: usize| {
        rows.iter().zip(weights).map(|((row, _), weight)| row[column] * weight).sum::<f64>()
    };
    (0..rows[0].0.len()).map(|column| combined(column).max(0.0)).collect()
}

fn newton_step(rows: &[Row], forces: &[f64]) -> Option<Vec<f64>> {
    // Before any force is positive, all of them may become so.
    let all = forces.iter().all(|force| *force == 0.0);
    let counts: Vec<bool> = forces.iter().map(|force| all || *force > 0.0).collect();
    let product = |a: &[f64], b: &[f64]| {
        a.iter()
            .zip(b)
            .zip(&counts)
            .filter(|(_, counts)| **counts)
            .map(|((x, y), _)| x * y)
            .sum::<f64>()
    };
    let mut matrix: Vec<Vec<f64>> =
        rows.iter().map(|(a, _)| rows.iter().map(|(b, _)| product(a, b)).collect()).collect();
    for (index, row) in matrix.iter_mut().enumerate() {
        row[index] += ROW_DAMPING;
    }
    solve(matrix, rows.iter().map(|(row, right)| right - dot(row, forces)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_robot::randoms;

    #[test]
    fn least_squares_forces_are_even_and_nonnegative() {
        let forces = by_newton(&[(vec![1.0, 1.0, 1.0, 1.0], 1.0)]).unwrap();
        assert!(forces.iter().all(|force| (force - 0.25).abs() < 1e-6), "{forces:?}");
        // A beam on three supports, loaded at its end: the free solution would pull at the far one.
        let forces = by_newton(&[(vec![1.0, 1.0, 1.0], 1.0), (vec![-1.0, 0.0, 1.0], 0.9)]).unwrap();
        assert!(
            (forces[2] - 0.9).abs() < 1e-5 && (forces[1] - 0.1).abs() < 1e-5 && forces[0] == 0.0,
            "{forces:?}"
        );
    }

    #[test]
    fn infeasible_rows_have_no_forces() {
        assert_eq!(by_newton(&[(vec![1.0, 1.0], 1.0), (vec![-1.0, 1.0], 1.1)]), None);
    }

    #[test]
    fn no_other_forces_have_a_smaller_sum_of_squares() {
        let rows: Vec<Row> = vec![
            (vec![1.0, 0.9, 1.1, 1.0, 0.8], 1.0),
            (vec![0.3, -0.2, 0.1, 0.0, -0.4], 0.05),
            (vec![0.1, 0.2, -0.3, 0.4, 0.1], 0.02),
        ];
        let forces = by_newton(&rows).unwrap();
        // The sum of squares grows in every feasible direction: compare with the vertices of the
        // feasible set.
        for cost in 0..5 {
            let costs: Vec<f64> =
                (0..5).map(|column| f64::from(u8::from(column == cost))).collect();
            let corner = crate::statics::simplex::Simplex::at_vertex(&rows, &[])
                .unwrap()
                .minimise(&costs)
                .unwrap();
            let slope: f64 =
                forces.iter().zip(&corner).map(|(force, other)| force * (other - force)).sum();
            assert!(slope > -1e-5, "{slope}");
        }
    }

    #[test]
    fn clarabel_finds_the_same_few_forces() {
        let mut random = randoms(2);
        let mut held = 0;
        for _ in 0..400 {
            let (columns, height) = (random(3.0, 9.0) as usize, random(2.0, 5.0) as usize);
            let mut rows: Vec<Row> = vec![(vec![1.0; columns], 1.0)];
            for _ in 1..height {
                rows.push(((0..columns).map(|_| random(-1.0, 1.0)).collect(), random(-0.4, 0.4)));
            }
            let (ours, theirs) = (by_newton(&rows), by_interior_point(&rows));
            assert_eq!(ours.is_some(), theirs.is_some(), "{rows:?}");
            let (Some(ours), Some(theirs)) = (ours, theirs) else { continue };
            held += 1;
            let apart = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-4, "{rows:?}: {apart:.1e} apart");
        }
        assert!((100..400).contains(&held), "{held}");
    }

    #[test]
    fn clarabel_finds_the_same_forces() {
        let mut uniform = randoms(1);
        let mut random = || uniform(0.0, 1.0);
        let mut held = 0;
        for _ in 0..200 {
            let columns = 32 + (random() * 200.0) as usize;
            let mut rows: Vec<Row> = vec![((0..columns).map(|_| 1.0).collect(), 1.0)];
            for _ in 0..5 {
                rows.push(((0..columns).map(|_| random() - 0.5).collect(), 0.5 * (random() - 0.5)));
            }
            let (ours, theirs) = (by_newton(&rows), by_interior_point(&rows));
            assert_eq!(ours.is_some(), theirs.is_some());
            let (Some(ours), Some(theirs)) = (ours, theirs) else { continue };
            held += 1;
            let apart = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-4, "{columns} columns: {apart:.1e} apart");
        }
        assert!((50..200).contains(&held), "{held}");
    }
}
