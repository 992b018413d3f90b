//! Static equilibrium with friction: the contact forces that carry the robot, and the region of its
//! centre of mass.
//!
//! Friction cones are approximated by inscribed pyramids, so every equilibrium found also holds
//! with round cones. Forces are in units of the robot's weight.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use crate::base::comparison::is_at_most;
use crate::geometry::polygon;
use crate::statics::convex_program::ConvexProgram;
use crate::statics::simplex::{Row, Simplex};
use crate::statics::sole_support::SoleSupport;
use crate::statics::tuning::{
    INITIAL_DIRECTIONS, PYRAMID_SIDES, REFINEMENTS_MAX, REGIONS_CACHED_MAX,
};

/// The friction share of all checks except the friction reserve.
pub const ALL_FRICTION: f64 = 1.0;
/// A corner this near (m) to the side that it would split is left out, so the region lies inside
/// the exact one.
const VERTEX_DISTANCE_MIN: f64 = 1e-6;
/// The largest imbalance of forces (weights) and of torques (weights times metres) that counts as
/// equilibrium.
const IMBALANCE_MAX: f64 = 1e-6;
/// Larger shares of a limit count as this one.
const SHARE_MAX: f64 = 10.0;

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

/// The region in which the centre of mass may be, seen from above.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Static equilibrium by some contact forces; no vertices where there is none.
    pub equilibrium: Vec<DVec2>,
    /// The hull of the contact points.
    pub hull: Vec<DVec2>,
}

impl Region {
    /// The distance of a centre of mass to the edge of both polygons, m; negative outside.
    pub fn margin(&self, centre_of_mass: DVec3) -> f64 {
        let at = centre_of_mass.truncate();
        polygon::margin(&self.equilibrium, at).min(polygon::margin(&self.hull, at))
    }
}

/// Statics with one coefficient of friction.
pub struct Equilibrium {
    mu: f64,
    cache: BTreeMap<Vec<u64>, Region>,
}

impl Equilibrium {
    /// Statics with this coefficient of friction.
    pub fn new(mu: f64) -> Self {
        Self { mu, cache: BTreeMap::new() }
    }

    /// The coefficient of friction.
    pub fn mu(&self) -> f64 {
        self.mu
    }

    /// The edges of all friction pyramids, [`PYRAMID_SIDES`] for each contact point in turn, with
    /// only a share of the friction.
    pub fn generators(&self, supports: &[SoleSupport], friction_share: f64) -> Vec<Generator> {
        let mu = friction_share * self.mu;
        let points = supports
            .iter()
            .flat_map(|support| support.points.iter().map(|point| (support.limb, *point)));
        let edges = points.flat_map(|(limb, point)| {
            let (across, along) = point.normal.any_orthonormal_pair();
            (0..PYRAMID_SIDES).map(move |side| {
                let turn = polygon::direction(side, PYRAMID_SIDES);
                (limb, point.position, point.normal, turn.x * across + turn.y * along)
            })
        });
        edges
            .map(|(limb, point, normal, tangent)| Generator {
                limb,
                point,
                force: normal + mu * tangent,
            })
            .collect()
    }

    /// The region over these contacts with a share of the friction.
    pub fn region(&mut self, supports: &[SoleSupport], friction_share: f64) -> Region {
        let vectors = supports
            .iter()
            .flat_map(|support| &support.points)
            .flat_map(|point| [point.position, point.normal]);
        // A support without points makes another region.
        let counts = supports.iter().map(|support| support.points.len() as f64);
        let numbers =
            vectors.flat_map(|vector| vector.to_array()).chain(counts).chain([friction_share]);
        let key: Vec<u64> = numbers.map(f64::to_bits).collect();
        if let Some(region) = self.cache.get(&key) {
            return region.clone();
        }
        let region = self.measure(supports, friction_share);
        if self.cache.len() >= REGIONS_CACHED_MAX {
            self.cache.clear();
        }
        self.cache.insert(key, region.clone());
        region
    }

    fn measure(&self, supports: &[SoleSupport], friction_share: f64) -> Region {
        let points: Vec<DVec2> = supports
            .iter()
            .flat_map(|s| &s.points)
            .map(|point| point.position.truncate())
            .collect();
        let hull = polygon::hull(&points);
        let unsupported = supports.iter().any(|support| support.points.is_empty());
        if supports.is_empty() || unsupported {
            return Region { equilibrium: Vec::new(), hull };
        }
        Region { equilibrium: region_of(&self.generators(supports, friction_share)), hull }
    }
}

/// The vertices of the region in which forces of the generators hold a centre of mass. It starts
/// from extreme points in a few directions and adds a vertex beyond every side that the region
/// exceeds (Bretl and Lall 2008).
fn region_of(generators: &[Generator]) -> Vec<DVec2> {
    let mut furthest = FurthestCentre::new(generators);
    let first = (0..INITIAL_DIRECTIONS)
        .filter_map(|k| furthest.along(polygon::direction(k, INITIAL_DIRECTIONS)));
    let mut outline = polygon::hull(&first.collect::<Vec<_>>());
    let (mut side, mut refinements) = (0, 0);
    while side < outline.len() && refinements < REFINEMENTS_MAX {
        let (a, b) = (outline[side], outline[(side + 1) % outline.len()]);
        let outward = -(b - a).perp().normalize_or_zero();
        refinements += 1;
        match furthest.along(outward) {
            Some(corner) if (corner - a).dot(outward) > VERTEX_DISTANCE_MIN => {
                outline.insert(side + 1, corner)
            }
            _ => side += 1,
        }
    }
    polygon::hull(&outline)
}

/// Finds the centre of mass furthest in a direction that some contact forces hold.
struct FurthestCentre {
    origin: DVec2,
    /// The forces sum to one weight upwards and have no torque about the vertical.
    rows: Vec<Row>,
    about_x: Vec<f64>,
    about_y: Vec<f64>,
    simplex: Option<Simplex>,
}

impl FurthestCentre {
    fn new(generators: &[Generator]) -> Self {
        let origin = centroid(generators);
        let mut rows = balance_rows(generators, origin);
        let [about_x, about_y] = [rows.remove(3).0, rows.remove(3).0];
        let simplex = Simplex::at_vertex(&rows, &[]);
        Self { origin: origin.truncate(), rows, about_x, about_y, simplex }
    }

    fn along(&mut self, direction: DVec2) -> Option<DVec2> {
        let torques = self.about_x.iter().zip(&self.about_y);
        let cost: Vec<f64> = torques.map(|(x, y)| direction.x * y - direction.y * x).collect();
        let found = self.simplex.as_mut().and_then(|simplex| simplex.minimise(&cost));
        let forces = found
            .filter(|forces| is_balanced(&self.rows, forces))
            .or_else(|| self.by_interior_point(cost))?;
        // The weight's torque about the origin at a centre of mass (x, y) is (-y, x, 0).
        Some(self.origin + DVec2::new(-dot(&self.about_y, &forces), dot(&self.about_x, &forces)))
    }

    fn by_interior_point(&self, cost: Vec<f64>) -> Option<Vec<f64>> {
        let nonnegative = cost.len();
        let program = ConvexProgram {
            cost,
            square_cost: 0.0,
            nonnegative,
            equalities: self.rows.clone(),
            inequalities: Vec::new(),
        };
        program.solve().filter(|forces| is_balanced(&self.rows, forces))
    }
}

/// The contact forces that hold a robot and minimise the largest share of a joint's effort limit.
pub struct MinimaxEffort {
    /// The balance rows that the forces satisfy.
    balance: Vec<Row>,
    /// One share of a limit each: a row of coefficients and the share without any force.
    shares: Vec<Row>,
}

impl MinimaxEffort {
    /// The forces (one number per generator) that hold this centre of mass and minimise the largest
    /// absolute value of `offset + row . forces` over `shares`.
    pub fn new(generators: &[Generator], centre_of_mass: DVec3, shares: Vec<Row>) -> Self {
        Self { balance: balance(generators, centre_of_mass), shares }
    }

    /// As [`Self::new`], with the rows of another balance.
    pub fn with_balance(balance: Vec<Row>, shares: Vec<Row>) -> Self {
        Self { balance, shares }
    }

    /// By the simplex method; nothing where it finds no forces in equilibrium.
    pub fn by_simplex(&self) -> Option<Vec<f64>> {
        let (count, bounds) = (self.balance[0].0.len(), 2 * self.shares.len());
        let columns = count + 1 + bounds;
        // Variables after the forces: the distance of the largest share below `top`, and the slack
        // of each bound.
        let top =
            SHARE_MAX + self.shares.iter().map(|(_, offset)| offset.abs()).fold(0.0, f64::max);
        let widened = |(row, right): &Row| {
            (row.iter().copied().chain(std::iter::repeat_n(0.0, 1 + bounds)).collect(), *right)
        };
        let mut rows: Vec<Row> = self.balance.iter().map(widened).collect();
        let mut first = vec![None; rows.len()];
        for (index, (sign, (row, offset))) in
            self.shares.iter().flat_map(|share| [(1.0, share), (-1.0, share)]).enumerate()
        {
            let mut coefficients = vec![0.0; columns];
            coefficients.iter_mut().zip(row).for_each(|(place, value)| *place = sign * value);
            (coefficients[count], coefficients[count + 1 + index]) = (1.0, 1.0);
            rows.push((coefficients, top - sign * offset));
            first.push(Some(count + 1 + index));
        }
        let mut cost = vec![0.0; columns];
        cost[count] = -1.0;
        let mut forces = Simplex::at_vertex(&rows, &first)?.minimise(&cost)?;
        forces.truncate(count);
        is_balanced(&self.balance, &forces).then_some(forces)
    }

    /// By the interior point method, used where [`Self::by_simplex`] finds none.
    pub fn by_interior_point(&self) -> Option<Vec<f64>> {
        let count = self.balance[0].0.len();
        let equalities = self
            .balance
            .iter()
            .map(|(row, right)| (row.iter().copied().chain([0.0]).collect(), *right))
            .collect();
        let bounded = |sign: f64, (row, offset): &Row| {
            (row.iter().map(|value| sign * value).chain([-1.0]).collect(), -sign * offset)
        };
        let inequalities = self
            .shares
            .iter()
            .flat_map(|share| [bounded(1.0, share), bounded(-1.0, share)])
            .collect();
        let mut cost = vec![0.0; count + 1];
        cost[count] = 1.0;
        let mut forces =
            ConvexProgram { cost, square_cost: 0.0, nonnegative: count, equalities, inequalities }
                .solve()?;
        forces.truncate(count);
        is_balanced(&self.balance, &forces).then_some(forces)
    }
}

/// Whether forces satisfy the rows of a balance.
pub fn is_balanced(rows: &[Row], forces: &[f64]) -> bool {
    rows.iter().all(|(row, right)| is_at_most((dot(row, forces) - right).abs(), IMBALANCE_MAX))
}

/// The sum of the products.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn centroid(generators: &[Generator]) -> DVec3 {
    generators.iter().map(|generator| generator.point).sum::<DVec3>()
        / generators.len().max(1) as f64
}

/// The balance rows of forces that hold a centre of mass: see [`balance_rows`].
pub fn balance(generators: &[Generator], centre_of_mass: DVec3) -> Vec<Row> {
    let origin = centroid(generators);
    let mut rows = balance_rows(generators, origin);
    let lever = centre_of_mass - origin;
    (rows[3].1, rows[4].1) = (lever.y, -lever.x);
    rows
}

/// The balance rows of forces that exert a wrench: a force (weights), and a torque about the
/// world's origin (weights times metres).
pub fn wrench_balance(generators: &[Generator], force: DVec3, torque: DVec3) -> Vec<Row> {
    let origin = centroid(generators);
    let mut rows = balance_rows(generators, origin);
    let about_origin = torque - origin.cross(force);
    for axis in 0..3 {
        (rows[axis].1, rows[3 + axis].1) = (force[axis], about_origin[axis]);
    }
    rows
}

/// Six rows: the forces sum to one weight upwards, their torques about `origin` to zero.
fn balance_rows(generators: &[Generator], origin: DVec3) -> Vec<Row> {
    let wrench = |generator: &Generator| {
        (generator.force, (generator.point - origin).cross(generator.force))
    };
    let wrenches: Vec<(DVec3, DVec3)> = generators.iter().map(wrench).collect();
    let force = |axis: usize| {
        (wrenches.iter().map(|(force, _)| force[axis]).collect(), if axis == 2 { 1.0 } else { 0.0 })
    };
    let torque = |axis: usize| (wrenches.iter().map(|(_, torque)| torque[axis]).collect(), 0.0);
    (0..3).map(force).chain((0..3).map(torque)).collect()
}

#[cfg(test)]
mod tests;
