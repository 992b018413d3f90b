//! Small dense linear programs by the primal simplex method, for those that are solved hundreds of
//! times a second.
//!
//! Solutions are not verified here. Callers verify them, and before they refuse a motion because
//! there is no solution they try [`crate::statics::convex_program`].

/// Smaller reduced costs count as zero. The programs here are scaled to about 1.
const REDUCED_COST_MIN: f64 = 1e-9;
/// Smaller numbers are not divided by: they may be a zero with a rounding error.
const PIVOT_MIN: f64 = 1e-7;
/// By how much a right side may be off by rounding.
const RIGHT_SIDE_ROUNDING: f64 = 1e-10;
/// After this many pivots Dantzig's rule is replaced by Bland's, which cannot cycle.
const DANTZIG_PIVOTS_MAX: usize = 200;
/// No program here needs nearly as many pivots.
const PIVOTS_MAX: usize = 2_000;

/// A row of coefficients, and the number that its product with the variables equals.
pub type Row = (Vec<f64>, f64);

/// The tableau at a vertex of a program in which nonnegative variables meet all rows exactly.
#[derive(Debug, Clone)]
pub struct Simplex {
    columns: usize,
    /// One row per equation: its coefficients, then its right side.
    rows: Vec<Vec<f64>>,
    /// The basic variable of each row; until a vertex is found, those from `columns` on are
    /// artificial variables of unmet rows.
    basis: Vec<usize>,
}

impl Simplex {
    /// A vertex of `rows` over nonnegative variables, or nothing where none is found. `first[i]`
    /// may name a variable that occurs with coefficient 1 in row `i` alone and begins as its
    /// solution.
    pub fn at_vertex(rows: &[Row], first: &[Option<usize>]) -> Option<Self> {
        let columns = rows.first()?.0.len();
        let mut simplex = Self {
            columns,
            rows: Vec::with_capacity(rows.len()),
            basis: Vec::with_capacity(rows.len()),
        };
        for (index, (coefficients, right)) in rows.iter().enumerate() {
            let own = first.get(index).copied().flatten().filter(|_| *right >= 0.0);
            let sign = if *right < 0.0 { -1.0 } else { 1.0 };
            simplex
                .rows
                .push(coefficients.iter().chain([right]).map(|value| sign * value).collect());
            simplex.basis.push(own.unwrap_or(columns + index));
        }
        let mut unmet = vec![0.0; columns + 1];
        for (row, _) in
            simplex.rows.iter().zip(&simplex.basis).filter(|(_, variable)| **variable >= columns)
        {
            unmet.iter_mut().zip(row).for_each(|(sum, value)| *sum -= value);
        }
        simplex.improve(&mut unmet)?;
        if unmet[columns].abs() > 1e-9 {
            return None;
        }
        simplex.drop_artificial_variables();
        Some(simplex)
    }

    /// Moves to a vertex of least `cost` and returns the variables there, or nothing where the cost
    /// is unbounded.
    pub fn minimise(&mut self, cost: &[f64]) -> Option<Vec<f64>> {
        let mut reduced_costs: Vec<f64> = cost.iter().copied().chain([0.0]).collect();
        for (row, &variable) in self.rows.iter().zip(&self.basis) {
            let reduced_cost = reduced_costs[variable];
            reduced_costs.iter_mut().zip(row).for_each(|(sum, value)| *sum -= reduced_cost * value);
        }
        self.improve(&mut reduced_costs)?;
        let mut x = vec![0.0; self.columns];
        for (row, &variable) in self.rows.iter().zip(&self.basis) {
            x[variable] = row[self.columns].max(0.0);
        }
        Some(x)
    }

    /// Pivots while a variable has a negative reduced cost.
    fn improve(&mut self, reduced_costs: &mut [f64]) -> Option<()> {
        for count in 0..PIVOTS_MAX {
            let bland = count >= DANTZIG_PIVOTS_MAX;
            let Some(entering) = entering(&reduced_costs[..self.columns], bland) else {
                return Some(());
            };
            let leaving = self.leaving(entering, bland)?;
            self.pivot(leaving, entering);
            let reduced_cost = reduced_costs[entering];
            reduced_costs
                .iter_mut()
                .zip(&self.rows[leaving])
                .for_each(|(sum, value)| *sum -= reduced_cost * value);
        }
        None
    }

    /// The row of the minimum ratio test. Of rows that tie within rounding it is the one with the
    /// largest pivot, or, under Bland's rule, the one with the first basic variable.
    fn leaving(&self, entering: usize, bland: bool) -> Option<usize> {
        let entries =
            self.rows.iter().map(|row| (row[entering], row[self.columns].max(0.0))).enumerate();
        let limiting = entries.filter(|(_, (pivot, _))| *pivot > PIVOT_MIN);
        let growth = limiting
            .clone()
            .map(|(_, (pivot, right))| (right + RIGHT_SIDE_ROUNDING) / pivot)
            .fold(f64::INFINITY, f64::min);
        let tied = limiting.filter(|(_, (pivot, right))| right / pivot <= growth);
        let best = if bland {
            tied.min_by_key(|(row, _)| self.basis[*row])
        } else {
            tied.max_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b))
        };
        best.map(|(row, _)| row)
    }

    fn pivot(&mut self, leaving: usize, entering: usize) {
        let mut pivot = std::mem::take(&mut self.rows[leaving]);
        let scale = 1.0 / pivot[entering];
        pivot.iter_mut().for_each(|value| *value *= scale);
        for row in self.rows.iter_mut().filter(|row| !row.is_empty()) {
            let factor = row[entering];
            if factor != 0.0 {
                row.iter_mut().zip(&pivot).for_each(|(value, other)| *value -= factor * other);
                row[entering] = 0.0;
            }
        }
        self.rows[leaving] = pivot;
        self.basis[leaving] = entering;
    }

    /// Pivots artificial variables out of the basis; a linearly dependent row is dropped.
    fn drop_artificial_variables(&mut self) {
        let mut row = 0;
        while row < self.rows.len() {
            if self.basis[row] >= self.columns {
                match (0..self.columns).find(|&column| self.rows[row][column].abs() > PIVOT_MIN) {
                    Some(column) => self.pivot(row, column),
                    None => {
                        self.rows.swap_remove(row);
                        self.basis.swap_remove(row);
                        continue;
                    }
                }
            }
            row += 1;
        }
    }
}

/// The variable with the lowest reduced cost, or the first with a negative one.
fn entering(reduced_costs: &[f64], bland: bool) -> Option<usize> {
    let mut negative =
        (0..reduced_costs.len()).filter(|&column| reduced_costs[column] < -REDUCED_COST_MIN);
    if bland {
        negative.next()
    } else {
        negative.min_by(|&a, &b| reduced_costs[a].total_cmp(&reduced_costs[b]))
    }
}

#[cfg(test)]
mod tests;
