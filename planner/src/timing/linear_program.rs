//! A dense simplex method for small linear programs: variables that are not negative, equalities,
//! and upper bounds of linear forms. Memory is reserved once; every run is bounded.
//!
//! A program is solved for several objectives in turn, each from the vertex of the one before
//! (primal simplex). Rows may be added in between (dual simplex).

/// Most rows.
pub const ROWS_MAX: usize = 72;
/// Most variables.
pub const VARIABLES_MAX: usize = 288;
/// The column of the right side. Variable `v` has column `v + 1`, slacks follow the variables.
const RIGHT: usize = 0;
/// The right side, variables, and the slack of every row.
const STRIDE: usize = 1 + VARIABLES_MAX + ROWS_MAX;
/// Smallest number that counts as a pivot, and largest error of a feasible point.
const TOLERANCE: f64 = 1e-9;
/// Most pivots of one run.
const PIVOTS_MAX: usize = 300;
/// Pivots after which the first improving column enters instead of the best one, against cycles.
const CAREFUL_AFTER: usize = 120;
/// The basic variable of a row that has none.
const ARTIFICIAL: usize = usize::MAX;

/// A linear program with its current basis.
#[derive(Debug)]
pub struct LinearProgram {
    /// Rows of the tableau.
    table: Vec<f64>,
    /// The column of the variable that each row determines.
    basis: heapless::Vec<usize, ROWS_MAX>,
    /// Gain of the objective by each variable.
    gains: Vec<f64>,
    objective: Vec<f64>,
    variables: usize,
    slacks: usize,
}

/// Why a program has no solution here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoOptimum {
    /// No point meets all rows.
    Infeasible,
    /// The objective has no bound.
    Unbounded,
    /// The bound of pivots, or of rows, is reached.
    Exhausted,
}

impl Default for LinearProgram {
    fn default() -> Self {
        Self {
            table: vec![0.0; ROWS_MAX * STRIDE],
            basis: heapless::Vec::new(),
            gains: vec![0.0; STRIDE],
            objective: vec![0.0; STRIDE],
            variables: 0,
            slacks: 0,
        }
    }
}

impl LinearProgram {
    /// Begins a program of this many variables, without rows.
    ///
    /// # Panics
    /// There are more than [`VARIABLES_MAX`].
    pub fn begin(&mut self, variables: usize) {
        assert!(variables <= VARIABLES_MAX, "{variables} variables");
        self.basis.clear();
        (self.variables, self.slacks) = (variables, 0);
    }

    /// Adds a row before [`Self::find_vertex`]: the form equals `value`, or is at most `value`.
    /// Returns `false` where no row is left.
    pub fn add_row(
        &mut self,
        form: impl Iterator<Item = f64>,
        value: f64,
        is_equality: bool,
    ) -> bool {
        let at = self.basis.len();
        if self.basis.push(ARTIFICIAL).is_err() {
            return false;
        }
        let slack = self.width();
        self.slacks += usize::from(!is_equality);
        if !is_equality {
            (0..at).for_each(|row| self.table[row * STRIDE + slack] = 0.0);
        }
        let width = self.width();
        let row = &mut self.table[at * STRIDE..][..width];
        row.fill(0.0);
        row[1..].iter_mut().zip(form).for_each(|(slot, number)| *slot = number);
        if !is_equality {
            row[slack] = 1.0;
        }
        row[RIGHT] = value;
        if value < 0.0 {
            row.iter_mut().for_each(|number| *number = -*number);
        } else if !is_equality {
            self.basis[at] = slack;
        }
        true
    }

    /// Finds a vertex of the feasible set.
    ///
    /// # Errors
    /// There is none, or it is not found.
    pub fn find_vertex(&mut self) -> Result<(), NoOptimum> {
        let width = self.width();
        self.objective[..width].fill(0.0);
        self.gains[..width].fill(0.0);
        for row in 0..self.basis.len() {
            if self.basis[row] == ARTIFICIAL {
                for column in self.columns() {
                    self.gains[column] += self.table[row * STRIDE + column];
                }
            }
        }
        self.climb(true)?;
        let missing = (0..self.basis.len())
            .filter(|&row| self.basis[row] == ARTIFICIAL)
            .map(|row| self.value_of(row))
            .sum::<f64>();
        if missing > 1e2 * TOLERANCE {
            return Err(NoOptimum::Infeasible);
        }
        self.drop_artificial();
        Ok(())
    }

    /// Moves to a vertex that maximizes `objective` of the first variables, and returns the
    /// maximum.
    ///
    /// # Errors
    /// There is none, or it is not found.
    pub fn maximize(&mut self, objective: &[f64]) -> Result<f64, NoOptimum> {
        let width = self.width();
        self.objective[..width].fill(0.0);
        self.objective[1..=objective.len()].copy_from_slice(objective);
        self.gains[..width].copy_from_slice(&self.objective[..width]);
        for row in 0..self.basis.len() {
            let cost = self.cost_of(row);
            if cost != 0.0 {
                for column in self.columns() {
                    self.gains[column] -= cost * self.table[row * STRIDE + column];
                }
            }
        }
        self.climb(false)?;
        Ok(self.maximum())
    }

    /// Adds the row "form is at most `value`" at an optimum and moves to the new one. Returns the
    /// new maximum.
    ///
    /// # Errors
    /// No point meets all rows, or none is found.
    pub fn add_bound(
        &mut self,
        form: impl Iterator<Item = f64>,
        value: f64,
    ) -> Result<f64, NoOptimum> {
        let at = self.basis.len();
        let slack = self.width();
        if self.basis.push(slack).is_err() {
            return Err(NoOptimum::Exhausted);
        }
        self.slacks += 1;
        (self.gains[slack], self.objective[slack]) = (0.0, 0.0);
        for row in 0..at {
            self.table[row * STRIDE + slack] = 0.0;
        }
        let (known, new) = self.table.split_at_mut(at * STRIDE);
        let new = &mut new[..=slack];
        new.fill(0.0);
        new[1..].iter_mut().zip(form).for_each(|(slot, number)| *slot = number);
        (new[slack], new[RIGHT]) = (1.0, value);
        for (row, &basic) in known.chunks_exact(STRIDE).zip(&self.basis) {
            let factor = if basic == ARTIFICIAL { 0.0 } else { new[basic] };
            if factor != 0.0 {
                new.iter_mut().zip(row).for_each(|(number, &known)| *number -= factor * known);
            }
        }
        self.descend()?;
        Ok(self.maximum())
    }

    /// The value of a variable.
    pub fn value(&self, variable: usize) -> f64 {
        let row = self.basis.iter().position(|&basic| basic == variable + 1);
        row.map_or(0.0, |row| self.value_of(row))
    }

    /// Calls `visit` with every variable that is not 0 and its value.
    pub fn for_each_value(&self, mut visit: impl FnMut(usize, f64)) {
        for (row, &basic) in self.basis.iter().enumerate() {
            if basic <= self.variables {
                visit(basic - 1, self.value_of(row));
            }
        }
    }

    /// The columns of variables and slacks.
    fn columns(&self) -> std::ops::Range<usize> {
        1..self.width()
    }

    /// Number of columns in use.
    fn width(&self) -> usize {
        1 + self.variables + self.slacks
    }

    fn value_of(&self, row: usize) -> f64 {
        self.table[row * STRIDE + RIGHT]
    }

    fn cost_of(&self, row: usize) -> f64 {
        if self.basis[row] == ARTIFICIAL { 0.0 } else { self.objective[self.basis[row]] }
    }

    fn maximum(&self) -> f64 {
        (0..self.basis.len()).map(|row| self.cost_of(row) * self.value_of(row)).sum()
    }

    /// The primal simplex method.
    fn climb(&mut self, is_first_phase: bool) -> Result<(), NoOptimum> {
        for pivots in 0..PIVOTS_MAX {
            let mut entering: Option<usize> = None;
            for column in self.columns().filter(|&column| self.gains[column] > TOLERANCE) {
                if entering.is_none_or(|best| self.gains[column] > self.gains[best]) {
                    entering = Some(column);
                    if pivots >= CAREFUL_AFTER {
                        break;
                    }
                }
            }
            let Some(entering) = entering else { return Ok(()) };
            let Some(row) = self.blocking_row(entering) else {
                let end = if is_first_phase { NoOptimum::Exhausted } else { NoOptimum::Unbounded };
                return Err(end);
            };
            self.pivot(row, entering);
        }
        Err(NoOptimum::Exhausted)
    }

    /// The row whose variable reaches 0 first as a variable grows.
    fn blocking_row(&self, entering: usize) -> Option<usize> {
        let slope_of = |row: usize| self.table[row * STRIDE + entering];
        let slack_of = |row: usize| self.value_of(row).max(0.0);
        first_to_block(0..self.basis.len(), slope_of, slack_of, false)
    }

    /// The dual simplex method.
    fn descend(&mut self) -> Result<(), NoOptimum> {
        for pivots in 0..PIVOTS_MAX {
            let is_careful = pivots >= CAREFUL_AFTER;
            let below = (0..self.basis.len()).filter(|&row| self.value_of(row) < -TOLERANCE);
            let row = if is_careful {
                below.min_by_key(|&row| self.basis[row])
            } else {
                below.min_by(|&a, &b| self.value_of(a).total_cmp(&self.value_of(b)))
            };
            let Some(row) = row else { return Ok(()) };
            let slope_of = |column: usize| -self.table[row * STRIDE + column];
            let slack_of = |column: usize| -self.gains[column].min(0.0);
            let entering = first_to_block(self.columns(), slope_of, slack_of, is_careful);
            let Some(entering) = entering else { return Err(NoOptimum::Infeasible) };
            self.pivot(row, entering);
        }
        Err(NoOptimum::Exhausted)
    }

    /// Makes `entering` the variable that `row` determines.
    fn pivot(&mut self, row: usize, entering: usize) {
        let width = self.width();
        let (before, rest) = self.table.split_at_mut(row * STRIDE);
        let (pivot_row, after) = rest.split_at_mut(STRIDE);
        let pivot_row = &mut pivot_row[..width];
        let scale = 1.0 / pivot_row[entering];
        pivot_row.iter_mut().for_each(|number| *number *= scale);
        pivot_row[entering] = 1.0;
        let others = self.basis.len() - row - 1;
        let lists = before
            .chunks_exact_mut(STRIDE)
            .chain(after.chunks_exact_mut(STRIDE).take(others))
            .chain([self.gains.as_mut_slice()]);
        for other in lists {
            let factor = other[entering];
            if factor != 0.0 {
                for (number, &of_pivot) in other[..width].iter_mut().zip(&*pivot_row) {
                    *number -= factor * of_pivot;
                }
                other[entering] = 0.0;
            }
        }
        self.basis[row] = entering;
    }

    /// Gives every row without a variable one; a row that depends on others stays empty.
    fn drop_artificial(&mut self) {
        for row in 0..self.basis.len() {
            if self.basis[row] == ARTIFICIAL {
                let size = |column: usize| self.table[row * STRIDE + column].abs();
                let largest = self.columns().max_by(|&a, &b| size(a).total_cmp(&size(b)));
                match largest.filter(|&column| size(column) > 1e-7) {
                    Some(column) => self.pivot(row, column),
                    None => {
                        let width = self.width();
                        self.table[row * STRIDE..][..width].fill(0.0);
                    }
                }
            }
        }
    }
}

/// The candidate whose slack is used up first as something grows that takes `slope` of it. Of those
/// whose slacks end together within the tolerance it is the one of the largest slope, since a pivot
/// near 0 multiplies every rounding error [Harris 1973]. A careful choice is the first of them,
/// against cycles [Bland 1977].
fn first_to_block(
    candidates: std::ops::Range<usize>,
    slope_of: impl Fn(usize) -> f64,
    slack_of: impl Fn(usize) -> f64,
    is_careful: bool,
) -> Option<usize> {
    let blocking = candidates.filter(|&at| slope_of(at) > TOLERANCE);
    let end_of = |at: usize| (slack_of(at) + TOLERANCE) / slope_of(at);
    let end = blocking.clone().map(end_of).fold(f64::INFINITY, f64::min);
    let mut best: Option<usize> = None;
    for at in blocking.filter(|&at| slack_of(at) / slope_of(at) <= end) {
        if best.is_none_or(|best| !is_careful && slope_of(at) > slope_of(best)) {
            best = Some(at);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Random, Stream};

    /// Maximizes by trying all vertices of rows `a x <= b` with two variables that are not
    /// negative.
    fn brute_force(rows: &[[f64; 3]], objective: [f64; 2]) -> Option<f64> {
        let all: Vec<[f64; 3]> =
            rows.iter().copied().chain([[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]).collect();
        let mut best: Option<f64> = None;
        for (i, a) in all.iter().enumerate() {
            for b in &all[..i] {
                let det = a[0] * b[1] - a[1] * b[0];
                if det.abs() > 1e-12 {
                    let x = (a[2] * b[1] - b[2] * a[1]) / det;
                    let y = (a[0] * b[2] - b[0] * a[2]) / det;
                    if all.iter().all(|row| row[0] * x + row[1] * y <= row[2] + 1e-9) {
                        let value = objective[0] * x + objective[1] * y;
                        best = Some(best.map_or(value, |best: f64| best.max(value)));
                    }
                }
            }
        }
        best
    }

    #[test]
    fn random_programs_agree_with_all_their_vertices() {
        let mut random = Random::new(7, Stream::Shortcut, 0, 0);
        let mut program = LinearProgram::default();
        let (mut feasible, mut infeasible) = (0, 0);
        for _ in 0..500 {
            let mut number = |least| random.uniform(least, 1.0);
            let mut rows: Vec<[f64; 3]> =
                (0..6).map(|_| [number(-1.0), number(-1.0), number(-0.2)]).collect();
            rows.push([1.0, 1.0, 5.0]);
            let objective = [0; 2].map(|_: i32| random.uniform(-1.0, 1.0));
            program.begin(2);
            for row in &rows[..4] {
                assert!(program.add_row(row[..2].iter().copied(), row[2], false));
            }
            assert!(program.add_row([1.0, 1.0].into_iter(), 5.0, false));
            let solved = program
                .find_vertex()
                .and_then(|()| program.maximize(&objective))
                .and_then(|_| program.add_bound(rows[4][..2].iter().copied(), rows[4][2]))
                .and_then(|_| program.add_bound(rows[5][..2].iter().copied(), rows[5][2]));
            match brute_force(&rows, objective) {
                Some(best) => {
                    feasible += 1;
                    assert!((solved.unwrap() - best).abs() < 1e-7, "{solved:?} {best}");
                    let again = program.maximize(&[objective[1], objective[0]]).unwrap();
                    let swapped = brute_force(&rows, [objective[1], objective[0]]).unwrap();
                    assert!((again - swapped).abs() < 1e-7);
                }
                None => {
                    infeasible += 1;
                    assert_eq!(solved, Err(NoOptimum::Infeasible));
                }
            }
        }
        assert!(feasible > 100 && infeasible > 20, "{feasible} {infeasible}");
    }

    #[test]
    fn equalities_hold() {
        let mut program = LinearProgram::default();
        program.begin(3);
        assert!(program.add_row([1.0, 1.0, 1.0].into_iter(), 1.0, true));
        assert!(program.add_row([2.0, 2.0, 2.0].into_iter(), 2.0, true), "a row that depends");
        assert!(program.add_row([-1.0, 1.0, 0.0].into_iter(), -0.5, true));
        program.find_vertex().unwrap();
        assert!((program.maximize(&[0.0, 1.0, 0.0]).unwrap() - 0.25).abs() < 1e-9);
        assert!((program.value(0) - 0.75).abs() < 1e-9);
        program.begin(1);
        assert!(program.add_row([1.0].into_iter(), 1.0, true));
        assert!(program.add_row([1.0].into_iter(), 2.0, true));
        assert_eq!(program.find_vertex(), Err(NoOptimum::Infeasible));
    }

    /// Coefficients of the forces along four edges of a friction pyramid at the corners of two
    /// soles, as contact forces have them: many are equal, so that many vertices coincide.
    fn pyramid_edges(random: &mut Random) -> Vec<[f64; 6]> {
        let mut edges = Vec::new();
        for foot in 0..2 {
            let [x, y] = [0; 2].map(|_: i32| random.uniform(-0.2, 0.2));
            let tilt = random.uniform(-0.2, 0.2).max(0.0);
            for corner in 0..7 {
                let angle = f64::from(corner) * 0.9;
                let at =
                    [x + 0.1 * libm::cos(angle), y + 0.05 * libm::sin(angle) + f64::from(foot)];
                for (along, across) in [(0.4, 0.4), (-0.4, 0.4), (-0.4, -0.4), (0.4, -0.4)] {
                    let force = [along + tilt, across, 1.0 - along * tilt];
                    let moment =
                        [at[1] * force[2], -at[0] * force[2], at[0] * force[1] - at[1] * force[0]];
                    edges.push([force, moment].concat().try_into().unwrap());
                }
            }
        }
        edges
    }

    #[test]
    fn bounds_that_a_known_point_meets_are_met() {
        let mut random = Random::new(3, Stream::Shortcut, 0, 0);
        let mut program = LinearProgram::default();
        for number in 0..1000 {
            let edges = pyramid_edges(&mut random);
            let known: Vec<f64> =
                edges.iter().map(|_| random.uniform(-3.0, 1.0).max(0.0)).collect();
            let sum = |form: &dyn Fn(usize) -> f64| -> f64 {
                known.iter().enumerate().map(|(at, value)| form(at) * value).sum()
            };
            program.begin(edges.len());
            for row in 0..6 {
                let form = |at: usize| edges[at][row];
                assert!(program.add_row((0..edges.len()).map(form), sum(&form), true));
            }
            let found = program.find_vertex().and_then(|()| program.maximize(&[0.0]));
            assert!(found.is_ok(), "{number}: {found:?}");
            for joint in 0..12 {
                let arm: [f64; 6] = std::array::from_fn(|_| random.uniform(-1.0, 1.0));
                let form = |at: usize| -> f64 {
                    let is_of_foot = at * 2 / edges.len() == joint / 6;
                    let torque = arm.iter().zip(edges[at]).map(|(arm, edge)| arm * edge).sum();
                    if is_of_foot { torque } else { 0.0 }
                };
                let bound = sum(&form) + random.uniform(-1e-3, 1e-3).max(0.0);
                let solved = program.add_bound((0..edges.len()).map(form), bound);
                assert!(solved.is_ok(), "{number}, joint {joint}: {solved:?}");
            }
        }
    }
}
