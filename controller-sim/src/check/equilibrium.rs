//! Static equilibrium with friction: which contact forces carry the robot, and where its centre of mass may be.
//!
//! Friction cones are taken as pyramids inside them, so whatever is found to hold, holds with round cones too. Forces are
//! in units of the robot's weight.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::linear_program::LinearProgram;
use super::support::SoleSupport;
use crate::geometry::polygon;

/// Sides of a friction pyramid.
const PYRAMID_SIDES: usize = 8;
/// Directions in which the region of equilibrium is supported.
const REGION_DIRECTIONS: usize = 32;
/// The largest imbalance of forces (weights) and of torques (weights times metres) that counts as equilibrium.
const IMBALANCE_MAX: f64 = 1e-6;
/// Most regions remembered.
const CACHE_MAX: usize = 256;

/// An edge of a friction pyramid at a contact point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Generator {
    /// The foot.
    pub limb: usize,
    /// The contact point, m.
    pub point: DVec3,
    /// The force along the edge, weights.
    pub force: DVec3,
}

/// Where the centre of mass may be, seen from above.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// In static equilibrium by some contact forces; no vertices if nowhere.
    pub equilibrium: Vec<DVec2>,
    /// Over the hull of the contact points.
    pub hull: Vec<DVec2>,
}

impl Region {
    /// How far inside both a centre of mass is, m.
    pub fn margin(&self, centre_of_mass: DVec3) -> f64 {
        let at = centre_of_mass.truncate();
        polygon::margin(&self.equilibrium, at).min(polygon::margin(&self.hull, at))
    }
}

/// Statics with one coefficient of friction.
pub struct Equilibrium {
    mu: f64,
    known: BTreeMap<Vec<u64>, Region>,
}

impl Equilibrium {
    /// Statics with this coefficient of friction.
    pub fn new(mu: f64) -> Self {
        Self { mu, known: BTreeMap::new() }
    }

    /// The edges of all friction pyramids.
    pub fn generators(&self, supports: &[SoleSupport]) -> Vec<Generator> {
        let points = supports.iter().flat_map(|support| support.points.iter().map(|point| (support.limb, *point)));
        let edges = points.flat_map(|(limb, point)| {
            let (across, along) = point.normal.any_orthonormal_pair();
            (0..PYRAMID_SIDES).map(move |side| {
                let turn = polygon::direction(side, PYRAMID_SIDES);
                (limb, point.position, point.normal, turn.x * across + turn.y * along)
            })
        });
        edges.map(|(limb, point, normal, tangent)| Generator { limb, point, force: normal + self.mu * tangent }).collect()
    }

    /// Where the centre of mass may be over these contacts.
    pub fn region(&mut self, supports: &[SoleSupport]) -> Region {
        let vectors = supports.iter().flat_map(|support| &support.points).flat_map(|point| [point.position, point.normal]);
        let key: Vec<u64> = vectors.flat_map(|vector| vector.to_array().map(f64::to_bits)).collect();
        if let Some(region) = self.known.get(&key) {
            return region.clone();
        }
        let region = self.measure(supports);
        if self.known.len() >= CACHE_MAX {
            self.known.clear();
        }
        self.known.insert(key, region.clone());
        region
    }

    /// The hull of the furthest verified centres of mass in evenly spaced directions: a region inside the true one.
    fn measure(&self, supports: &[SoleSupport]) -> Region {
        let points: Vec<DVec2> = supports.iter().flat_map(|s| &s.points).map(|point| point.position.truncate()).collect();
        let hull = polygon::hull(&points);
        let generators = self.generators(supports);
        let unsupported = supports.iter().any(|support| support.points.is_empty());
        if supports.is_empty() || unsupported {
            return Region { equilibrium: Vec::new(), hull };
        }
        let furthest = (0..REGION_DIRECTIONS).filter_map(|k| furthest_centre(&generators, polygon::direction(k, REGION_DIRECTIONS)));
        let centres: Vec<DVec2> = furthest.collect();
        Region { equilibrium: polygon::hull(&centres), hull }
    }
}

/// The centre of mass furthest along `direction` that some forces of the generators hold.
fn furthest_centre(generators: &[Generator], direction: DVec2) -> Option<DVec2> {
    let origin = middle(generators);
    let count = generators.len();
    let mut equalities = balance_rows(generators, origin, 2);
    // The weight's torque about the origin at a centre of mass (x, y) is (y, -x, 0).
    equalities[3].0[count + 1] = -1.0;
    equalities[4].0[count] = 1.0;
    let mut cost = vec![0.0; count + 2];
    (cost[count], cost[count + 1]) = (-direction.x, -direction.y);
    let program = LinearProgram { cost, nonnegative: count, equalities, inequalities: Vec::new() };
    let x = program.solve()?;
    (program.equality_error(&x) <= IMBALANCE_MAX).then(|| origin.truncate() + DVec2::new(x[count], x[count + 1]))
}

/// The contact forces (one number per generator) that hold a robot with this centre of mass and minimise the largest of some
/// linear functions of them, or nothing where no forces in equilibrium are found.
///
/// Each function is a row of coefficients and an offset: `offset + row . forces`; its absolute value is what is minimised.
pub fn least_effort_forces(generators: &[Generator], centre_of_mass: DVec3, functions: &[(Vec<f64>, f64)]) -> Option<Vec<f64>> {
    let (origin, count) = (middle(generators), generators.len());
    let mut equalities = balance_rows(generators, origin, 1);
    let lever = centre_of_mass - origin;
    (equalities[3].1, equalities[4].1) = (lever.y, -lever.x);
    let bounded = |sign: f64, (row, offset): &(Vec<f64>, f64)| {
        let mut coefficients: Vec<f64> = row.iter().map(|value| sign * value).collect();
        coefficients.push(-1.0);
        (coefficients, -sign * offset)
    };
    let inequalities = functions.iter().flat_map(|function| [bounded(1.0, function), bounded(-1.0, function)]).collect();
    let mut cost = vec![0.0; count + 1];
    cost[count] = 1.0;
    let program = LinearProgram { cost, nonnegative: count + 1, equalities, inequalities };
    let mut x = program.solve()?;
    let error = program.equality_error(&x);
    x.truncate(count);
    (error <= IMBALANCE_MAX).then_some(x)
}

fn middle(generators: &[Generator]) -> DVec3 {
    generators.iter().map(|generator| generator.point).sum::<DVec3>() / generators.len().max(1) as f64
}

/// Six rows: the forces add up to one weight upwards, their torques about `origin` to nothing. `extra` more variables follow
/// the forces.
fn balance_rows(generators: &[Generator], origin: DVec3, extra: usize) -> Vec<(Vec<f64>, f64)> {
    let wrench = |generator: &Generator| {
        let torque = (generator.point - origin).cross(generator.force);
        [generator.force.to_array(), torque.to_array()].concat()
    };
    let wrenches: Vec<Vec<f64>> = generators.iter().map(wrench).collect();
    let row = |axis: usize| wrenches.iter().map(|wrench| wrench[axis]).chain(std::iter::repeat_n(0.0, extra)).collect();
    (0..6).map(|axis| (row(axis), if axis == 2 { 1.0 } else { 0.0 })).collect()
}
