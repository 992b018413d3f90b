//! Linear and quadratic programs by Clarabel.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT,
};

/// Iterations of one program; more than any well-posed one needs.
const ITERATIONS_MAX: u32 = 100;

/// A program over `nonnegative` variables that are at least 0 and some free ones after them.
pub struct ConvexProgram {
    /// Coefficients of the linear cost, one per variable.
    pub cost: Vec<f64>,
    /// Coefficient of the quadratic cost: half of it times the sum of the variables' squares is
    /// added.
    pub square_cost: f64,
    /// The number of variables, from the first, that are at least 0.
    pub nonnegative: usize,
    /// Rows, each with the number that its product with the variables equals.
    pub equalities: Vec<(Vec<f64>, f64)>,
    /// Rows, each with the number that its product with the variables does not exceed.
    pub inequalities: Vec<(Vec<f64>, f64)>,
}

impl ConvexProgram {
    /// A minimiser with its nonnegative variables clamped at 0, or nothing where the solver finds
    /// none. It is accurate to the solver's tolerance only; callers verify it.
    pub fn solve(&self) -> Option<Vec<f64>> {
        let (columns, rows) =
            (self.cost.len(), self.equalities.len() + self.inequalities.len() + self.nonnegative);
        let (mut row_of, mut column_of, mut value_of, mut right) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (row, (coefficients, bound)) in
            self.equalities.iter().chain(&self.inequalities).enumerate()
        {
            for (column, &value) in
                coefficients.iter().enumerate().filter(|(_, value)| **value != 0.0)
            {
                row_of.push(row);
                column_of.push(column);
                value_of.push(value);
            }
            right.push(*bound);
        }
        for column in 0..self.nonnegative {
            row_of.push(right.len());
            column_of.push(column);
            value_of.push(-1.0);
            right.push(0.0);
        }
        let matrix = CscMatrix::new_from_triplets(rows, columns, row_of, column_of, value_of);
        let cones = [
            ZeroConeT(self.equalities.len()),
            NonnegativeConeT(self.inequalities.len() + self.nonnegative),
        ];
        let settings = DefaultSettings {
            verbose: false,
            max_iter: ITERATIONS_MAX,
            ..DefaultSettings::default()
        };
        let quadratic = self.quadratic();
        let mut solver =
            DefaultSolver::new(&quadratic, &self.cost, &matrix, &right, &cones, settings).ok()?;
        solver.solve();
        let found =
            matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
        found.then(|| {
            let mut x = solver.solution.x.clone();
            x[..self.nonnegative].iter_mut().for_each(|value| *value = value.max(0.0));
            x
        })
    }

    fn quadratic(&self) -> CscMatrix<f64> {
        let columns = self.cost.len();
        if self.square_cost == 0.0 {
            return CscMatrix::zeros((columns, columns));
        }
        CscMatrix::new_from_triplets(
            columns,
            columns,
            (0..columns).collect(),
            (0..columns).collect(),
            vec![self.square_cost; columns],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_program_is_solved_and_an_infeasible_one_refused() {
        let mut program = ConvexProgram {
            cost: vec![-1.0, -2.0, 0.0],
            square_cost: 0.0,
            nonnegative: 2,
            equalities: vec![(vec![1.0, 1.0, 1.0], 4.0)],
            inequalities: vec![(vec![0.0, 0.0, -1.0], -1.0), (vec![0.0, 1.0, 0.0], 2.0)],
        };
        let x = program.solve().unwrap();
        assert!(
            (x[0] - 1.0).abs() < 1e-6
                && (x[1] - 2.0).abs() < 1e-6
                && (x[0] + x[1] + x[2] - 4.0).abs() < 1e-6
        );
        program.inequalities.push((vec![0.0, 0.0, 1.0], 0.5));
        assert!(program.solve().is_none());
    }
}
