use super::*;
use crate::base::linear_solve::solve;
use crate::check_robot::randoms;
use crate::statics::convex_program::ConvexProgram;

fn rows(equations: &[(&[f64], f64)]) -> Vec<Row> {
    equations.iter().map(|(row, right)| (row.to_vec(), *right)).collect()
}

#[test]
fn a_vertex_is_found_and_improved() {
    // x + y + s = 4, x + 3y + t = 6.
    let program = rows(&[(&[1.0, 1.0, 1.0, 0.0], 4.0), (&[1.0, 3.0, 0.0, 1.0], 6.0)]);
    for first in [&[Some(2), Some(3)][..], &[]] {
        let mut simplex = Simplex::at_vertex(&program, first).unwrap();
        for (cost, corner) in
            [([-1.0, -2.0, 0.0, 0.0], [3.0, 1.0]), ([1.0, -1.0, 0.0, 0.0], [0.0, 2.0])]
        {
            let found = simplex.minimise(&cost).unwrap();
            assert!(
                (found[0] - corner[0]).abs() + (found[1] - corner[1]).abs() < 1e-12,
                "{found:?}"
            );
        }
    }
}

#[test]
fn infeasible_and_unbounded_programs_are_reported() {
    assert!(Simplex::at_vertex(&rows(&[(&[1.0, 1.0], -1.0)]), &[]).is_none());
    let mut endless = Simplex::at_vertex(&rows(&[(&[1.0, -1.0], 1.0)]), &[]).unwrap();
    assert!(endless.minimise(&[-1.0, 0.0]).is_none());
}

#[test]
fn rows_that_repeat_are_dropped() {
    let program =
        rows(&[(&[1.0, 1.0, 0.0], 1.0), (&[2.0, 2.0, 0.0], 2.0), (&[0.0, 0.0, 1.0], 0.0)]);
    let mut simplex = Simplex::at_vertex(&program, &[]).unwrap();
    assert_eq!(simplex.minimise(&[0.0, 1.0, 1.0]).unwrap(), [1.0, 0.0, 0.0]);
}

#[test]
fn random_programs_have_the_cost_of_the_interior_point_method() {
    let mut uniform = randoms(7);
    let mut random = || uniform(-0.5, 0.5);
    for _ in 0..200 {
        let (columns, height) = (24, 6);
        let corner: Vec<f64> = (0..columns).map(|_| random().max(0.0)).collect();
        // The last row bounds all variables, so that there is a least cost.
        let mut matrix: Vec<Vec<f64>> =
            (1..height).map(|_| (0..columns).map(|_| random()).collect()).collect();
        matrix.push(vec![1.0; columns]);
        let product = |row: &[f64]| row.iter().zip(&corner).map(|(a, b)| a * b).sum::<f64>();
        let equalities: Vec<Row> = matrix
            .into_iter()
            .map(|row| (product(&row), row))
            .map(|(right, row)| (row, right))
            .collect();
        let cost: Vec<f64> = (0..columns).map(|_| random()).collect();
        let value = |x: &[f64]| x.iter().zip(&cost).map(|(a, b)| a * b).sum::<f64>();
        let mine = Simplex::at_vertex(&equalities, &[])
            .and_then(|mut simplex| simplex.minimise(&cost))
            .unwrap();
        let unmet = |(row, right): &Row| {
            (row.iter().zip(&mine).map(|(a, b)| a * b).sum::<f64>() - right).abs()
        };
        assert!(equalities.iter().map(unmet).fold(0.0, f64::max) < 1e-9);
        let program = ConvexProgram {
            cost: cost.clone(),
            square_cost: 0.0,
            nonnegative: columns,
            equalities,
            inequalities: Vec::new(),
        };
        assert!((value(&mine) - value(&program.solve().unwrap())).abs() < 1e-6);
    }
}

/// All corners of a program: of each choice of basic columns the solution, if it is one.
fn corners(rows: &[Row]) -> Vec<Vec<f64>> {
    let columns = rows[0].0.len();
    let choices = (0_u32..1 << columns).filter(|chosen| chosen.count_ones() as usize == rows.len());
    let corner = |chosen: u32| {
        let basis: Vec<usize> = (0..columns).filter(|column| chosen >> column & 1 == 1).collect();
        let of_row = |(row, _): &Row| basis.iter().map(|&column| row[column]).collect();
        let right = rows.iter().map(|(_, right)| *right).collect();
        let solution = solve(rows.iter().map(of_row).collect(), right)?;
        let mut x = vec![0.0; columns];
        basis.iter().zip(solution).for_each(|(&column, value)| x[column] = value);
        x.iter_mut().filter(|value| value.abs() < 1e-9).for_each(|value| *value = 0.0);
        meets(rows, &x).then_some(x)
    };
    choices.filter_map(corner).collect()
}

/// Programs of small whole numbers, so that corners coincide, rows meet with 0 and ratios tie. The
/// last row bounds all variables, or all but three.
fn small_program(random: &mut impl FnMut(f64, f64) -> f64, is_bounded: bool) -> Vec<Row> {
    let (columns, height) = (7, 3);
    let mut whole = |low: f64, high: f64| random(low, high + 1.0).floor();
    let mut rows: Vec<Row> = (1..height)
        .map(|_| ((0..columns).map(|_| whole(-2.0, 2.0)).collect(), whole(-2.0, 2.0)))
        .collect();
    let mut last = vec![1.0; columns];
    if !is_bounded {
        last[columns - 3..].fill(0.0);
    }
    rows.push((last, whole(1.0, 4.0)));
    rows
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn meets(rows: &[Row], x: &[f64]) -> bool {
    x.iter().all(|value| *value >= 0.0)
        && rows.iter().all(|(row, right)| (product(row, x) - right).abs() < 1e-9)
}

#[test]
fn small_programs_have_the_cost_of_the_best_corner() {
    let mut random = randoms(3);
    let [mut solved, mut infeasible] = [0; 2];
    for _ in 0..1_000 {
        let rows = small_program(&mut random, true);
        let corners = corners(&rows);
        let Some(mut simplex) = Simplex::at_vertex(&rows, &[]) else {
            assert!(corners.is_empty(), "{rows:?}");
            infeasible += 1;
            continue;
        };
        for _ in 0..3 {
            let cost: Vec<f64> = (0..7).map(|_| random(-3.0, 3.0).floor()).collect();
            let found = simplex.minimise(&cost).unwrap();
            assert!(meets(&rows, &found), "{rows:?} {found:?}");
            // Dependent rows have no corner with as many basic columns.
            let best = corners.iter().map(|x| product(x, &cost)).fold(f64::INFINITY, f64::min);
            assert!(
                corners.is_empty() || (product(&found, &cost) - best).abs() < 1e-9,
                "{rows:?} {cost:?}: {found:?}, best {best}"
            );
            solved += usize::from(!corners.is_empty());
        }
    }
    assert!(solved > 1_000 && infeasible > 100, "{solved} {infeasible}");
}

#[test]
fn without_a_least_cost_there_is_no_solution() {
    let mut random = randoms(4);
    let [mut bounded, mut unbounded] = [0; 2];
    for _ in 0..400 {
        let rows = small_program(&mut random, false);
        let Some(mut simplex) = Simplex::at_vertex(&rows, &[]) else { continue };
        let cost: Vec<f64> = (0..7).map(|_| random(-3.0, 3.0).floor()).collect();
        // With all variables at most 1e4, the cost falls far where it is unbounded.
        let mut boxed: Vec<Row> = rows.clone();
        boxed.iter_mut().for_each(|(row, _)| row.push(0.0));
        boxed.push((vec![1.0; 8], 1e4));
        let mut at_corner = Simplex::at_vertex(&boxed, &[]).unwrap();
        let widened: Vec<f64> = cost.iter().copied().chain([0.0]).collect();
        let least = product(&at_corner.minimise(&widened).unwrap(), &widened);
        match simplex.minimise(&cost) {
            Some(found) => {
                assert!(meets(&rows, &found) && (product(&found, &cost) - least).abs() < 1e-6);
                bounded += 1;
            }
            None => {
                assert!(least < -500.0, "{rows:?} {cost:?}: {least}");
                unbounded += 1;
            }
        }
    }
    assert!(bounded > 50 && unbounded > 50, "{bounded} {unbounded}");
}

#[test]
fn variables_that_begin_as_the_solution_of_their_row_change_nothing() {
    let mut random = randoms(5);
    for _ in 0..300 {
        let (columns, height) = (5, 3);
        let cost: Vec<f64> = (0..columns + height).map(|_| random(0.0, 2.0)).collect();
        // Each row has a slack; where its right side is negative, the slack cannot begin.
        let rows: Vec<Row> = (0..height)
            .map(|index| {
                let slack = (0..height).map(|other| f64::from(u8::from(other == index)));
                let row = (0..columns).map(|_| random(-2.0, 2.0)).chain(slack).collect();
                // Some right sides are 0.
                (row, random(-1.0, 2.0).floor() * random(0.5, 1.0))
            })
            .collect();
        let first: Vec<Option<usize>> = (0..height).map(|index| Some(columns + index)).collect();
        let cost_from = |first: &[Option<usize>]| {
            let found = Simplex::at_vertex(&rows, first)?.minimise(&cost)?;
            assert!(meets(&rows, &found), "{rows:?} {found:?}");
            Some(product(&found, &cost))
        };
        match (cost_from(&first), cost_from(&[])) {
            (Some(with), Some(without)) => assert!((with - without).abs() < 1e-9),
            (with, without) => assert_eq!(with, without, "{rows:?}"),
        }
    }
}

#[test]
fn blands_rule_takes_the_first_variables() {
    assert_eq!(entering(&[0.0, -1.0, -3.0, 2.0], false), Some(2));
    assert_eq!(entering(&[0.0, -1.0, -3.0, 2.0], true), Some(1));
    assert_eq!(entering(&[0.0, -1e-10, 1e-9], false), None);
    assert_eq!(entering(&[0.0, -1e-10, 1e-9], true), None);
    // Two rows that tie at a ratio of 2, and one that limits later.
    let simplex = Simplex {
        columns: 3,
        rows: vec![
            vec![1.0, 0.0, 0.0, 2.0],
            vec![3.0, 0.0, 0.0, 6.0],
            vec![1.0, 0.0, 0.0, 2.5],
            vec![-1.0, 0.0, 0.0, 0.0],
            vec![1e-8, 0.0, 0.0, 0.0],
        ],
        basis: vec![1, 2, 0, 3, 4],
    };
    assert_eq!((simplex.leaving(0, false), simplex.leaving(0, true)), (Some(1), Some(0)));
    assert_eq!(simplex.leaving(1, false), None);
}
