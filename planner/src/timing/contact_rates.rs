//! The rates for which contact forces exist: within friction and soles, and within the torques of
//! the stance legs. In double support the forces of both feet are unknowns of a linear program,
//! whose projection onto the rates is found by its border in a few directions.

use glam::{DVec2, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::world::world::GRAVITY;

use crate::timing::linear_program::{LinearProgram, NoOptimum};
use crate::timing::path_dynamics::{Affine, Chains, PathDynamics};
use crate::timing::rate_set::RateSet;
use crate::timing::single_contact;
use crate::timing::support::Support;
use crate::timing::tuning::{
    BORDER_TOLERANCE, DIRECTIONS_MAX, MOMENT_ARM, TORQUE_ROUNDS_MAX, TORQUE_TOLERANCE,
};

/// The variables before those of the contacts: `x`, and `u` as a difference of two.
const RATES: usize = 3;
/// Most variables of the contacts.
const GENERATORS_MAX: usize = 128;
/// Most corners of a projection.
const CORNERS_MAX: usize = DIRECTIONS_MAX + FIRST_DIRECTIONS.len();
/// Weight of a low speed against a high acceleration by which the accelerations from rest are
/// found.
const REST_WEIGHT: f64 = 1e4;
/// The directions in which the border is sought first, counter-clockwise from the strongest braking
/// at rest to the strongest acceleration from rest.
const FIRST_DIRECTIONS: [DVec2; 5] = [
    DVec2::new(-REST_WEIGHT, -1.0),
    DVec2::NEG_Y,
    DVec2::X,
    DVec2::Y,
    DVec2::new(-REST_WEIGHT, 1.0),
];

/// Memory for the programs of all points.
#[derive(Debug, Default)]
pub struct ContactRates {
    program: LinearProgram,
    /// Point and force of every generator, in units of the weight.
    generators: BoundedVec<Generator, GENERATORS_MAX>,
    /// The rate to which the program adds its own.
    base: DVec2,
}

#[derive(Debug, Clone, Copy)]
struct Generator {
    /// Index into the support's feet.
    foot: usize,
    point: DVec3,
    force: DVec3,
}

/// A point of the path with its contacts and the efforts that may be used.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactProblem<'a> {
    /// The dynamics.
    pub dynamics: &'a PathDynamics,
    /// The stance feet.
    pub support: &'a Support,
    /// The joints between the root and each foot.
    pub chains: &'a Chains,
    /// Largest torques.
    pub efforts: &'a [f64; JOINTS_MAX],
    /// The part of them that may be used.
    pub efforts_part: f64,
    /// The robot's mass, kg.
    pub mass: f64,
}

impl ContactProblem<'_> {
    fn weight(&self) -> f64 {
        self.mass * GRAVITY
    }

    /// The joints whose torques depend on how two feet share the load.
    fn shared_joints(&self) -> impl Iterator<Item = usize> + '_ {
        let feet = if self.support.feet.len() > 1 { self.support.feet.as_slice() } else { &[] };
        feet.iter().flat_map(|foot| self.chains[foot.limb].iter().copied())
    }
}

impl ContactRates {
    /// The rates of `rates` for which contact forces exist; empty where there are none.
    pub(crate) fn restrict(&mut self, problem: &ContactProblem<'_>, rates: &RateSet) -> RateSet {
        let mut kept = rates.clone();
        let hull = self.project(problem, rates).unwrap_or_default();
        let count = hull.len();
        for index in 0..count {
            let (a, b) = (hull[index], hull[(index + 1) % count]);
            let normal = DVec2::new(b.y - a.y, a.x - b.x);
            kept.clip(normal, normal.dot(a));
        }
        if count < 3 { RateSet::default() } else { kept }
    }

    /// Whether contact forces exist at a rate.
    pub(crate) fn admits(&mut self, problem: &ContactProblem<'_>, rate: DVec2) -> bool {
        if let [foot] = problem.support.feet.as_slice() {
            let wrench: [f64; 6] = std::array::from_fn(|coordinate| {
                problem.dynamics.wrench(coordinate, foot.center).at(rate)
            });
            let [force, moment] = [0, 3].map(|first| DVec3::from_slice(&wrench[first..]));
            if single_contact::holds(foot, force, moment) {
                return true;
            }
        }
        self.has_forces(problem, rate)
    }

    /// The same by the program.
    fn has_forces(&mut self, problem: &ContactProblem<'_>, rate: DVec2) -> bool {
        let begun = self.begin(problem, DVec2::ZERO, rate);
        begun.and_then(|()| self.maximize(problem, DVec2::ZERO)).is_ok()
    }

    /// Corners of the projection, counter-clockwise.
    fn project(
        &mut self,
        problem: &ContactProblem<'_>,
        rates: &RateSet,
    ) -> Result<BoundedVec<DVec2, CORNERS_MAX>, NoOptimum> {
        let extent = rates.vertices().iter().fold(DVec2::ZERO, |most, v| most.max(v.abs()));
        let extent = extent * 1.001 + DVec2::splat(1e-6);
        self.begin(problem, extent, DVec2::ZERO)?;
        let mut border = Border::new(extent);
        for direction in FIRST_DIRECTIONS {
            border.push(self.maximize(problem, direction / extent)?);
        }
        for _ in 0..DIRECTIONS_MAX {
            let Some((edge, normal)) = border.widest_gap() else { break };
            let corner = self.maximize(problem, normal / extent)?;
            border.refine(edge, corner);
        }
        Ok(border.corners)
    }

    /// Sets up the program and finds forces: for rates up to `extent`, or, where that is 0, for
    /// `rate`.
    fn begin(
        &mut self,
        problem: &ContactProblem<'_>,
        extent: DVec2,
        rate: DVec2,
    ) -> Result<(), NoOptimum> {
        self.generators.clear();
        for (foot, support) in problem.support.feet.iter().enumerate() {
            let of_foot = support.generators();
            self.generators.extend(of_foot.map(|(point, force)| Generator { foot, point, force }));
        }
        let is_free = extent != DVec2::ZERO;
        self.program.begin(RATES + self.generators.len());
        let (weight, reference) = (problem.weight(), problem.support.reference());
        for coordinate in 0..6 {
            let unit = if coordinate < 3 { weight } else { weight * MOMENT_ARM };
            let needed = problem.dynamics.wrench(coordinate, reference);
            let slope = if is_free { needed.slope / unit } else { DVec2::ZERO };
            let of_generator = |generator: &Generator| {
                let moment = (generator.point - reference).cross(generator.force) / MOMENT_ARM;
                if coordinate < 3 { generator.force[coordinate] } else { moment[coordinate - 3] }
            };
            let form = [-slope.x, -slope.y, slope.y].into_iter();
            let form = form.chain(self.generators.iter().map(of_generator));
            self.program.add_row(form, needed.at(rate) / unit, true);
        }
        for (variable, bound) in [extent.x, extent.y, extent.y].into_iter().enumerate() {
            let form = (0..=variable).map(|at| f64::from(u8::from(at == variable)));
            self.program.add_row(form, bound, false);
        }
        self.base = rate;
        self.program.find_vertex()
    }

    /// The rate that maximizes `direction`, with forces within the torques.
    fn maximize(
        &mut self,
        problem: &ContactProblem<'_>,
        direction: DVec2,
    ) -> Result<DVec2, NoOptimum> {
        self.program.maximize(&[direction.x, direction.y, -direction.y])?;
        for _ in 0..TORQUE_ROUNDS_MAX {
            if !self.bound_torques(problem)? {
                return Ok(self.rate());
            }
        }
        Err(NoOptimum::Exhausted)
    }

    /// The rate at the present vertex.
    fn rate(&self) -> DVec2 {
        let u = self.program.value(1) - self.program.value(2);
        self.base + DVec2::new(self.program.value(0), u)
    }

    /// Adds a row for every torque beyond its limit. Returns whether there is one.
    fn bound_torques(&mut self, problem: &ContactProblem<'_>) -> Result<bool, NoOptimum> {
        let mut is_beyond = false;
        for joint in problem.shared_joints() {
            let limit = problem.efforts_part * problem.efforts[joint];
            let without = problem.dynamics.torque(joint);
            let torque = without.at(self.rate()) + self.torque_of_contacts(problem, joint);
            if torque.abs() > limit * (1.0 + TORQUE_TOLERANCE) {
                self.add_torque_row(problem, joint, (without, torque.signum() / limit))?;
                is_beyond = true;
            }
        }
        Ok(is_beyond)
    }

    /// The part of a joint's torque by the contact forces of the present vertex.
    fn torque_of_contacts(&self, problem: &ContactProblem<'_>, joint: usize) -> f64 {
        let mut torque = 0.0;
        self.program.for_each_value(|variable, value| {
            if variable >= RATES {
                let generator = &self.generators[variable - RATES];
                torque += value * torque_of(problem, generator, joint);
            }
        });
        torque
    }

    /// Bounds a joint's torque times `scale` by 1.
    fn add_torque_row(
        &mut self,
        problem: &ContactProblem<'_>,
        joint: usize,
        (without, scale): (Affine, f64),
    ) -> Result<f64, NoOptimum> {
        let slope = without.slope * scale;
        let of_contacts =
            self.generators.iter().map(|generator| scale * torque_of(problem, generator, joint));
        let form = [slope.x, slope.y, -slope.y].into_iter().chain(of_contacts);
        self.program.add_bound(form, 1.0 - scale * without.at(self.base))
    }
}

/// A joint's torque by unit of a generator.
fn torque_of(problem: &ContactProblem<'_>, generator: &Generator, joint: usize) -> f64 {
    let limb = problem.support.feet[generator.foot].limb;
    if !problem.chains[limb].contains(&joint) {
        return 0.0;
    }
    let (force, point) = (generator.force * problem.weight(), generator.point);
    -problem.dynamics.frames.torque_of_wrench(joint, force, DVec3::ZERO, point)
}

/// The border of a set of rates as far as it is known: a convex polygon inside it.
struct Border {
    /// The largest rates, the unit of both axes.
    extent: DVec2,
    /// Corners, counter-clockwise.
    corners: BoundedVec<DVec2, CORNERS_MAX>,
    /// Whether the edge after a corner is part of the border.
    is_final: BoundedVec<bool, CORNERS_MAX>,
}

impl Border {
    fn new(extent: DVec2) -> Self {
        Self { extent, corners: BoundedVec::new(), is_final: BoundedVec::new() }
    }

    /// Appends a corner unless it repeats the last one or the first one.
    fn push(&mut self, corner: DVec2) {
        let is_apart = |other: &&DVec2| {
            ((**other - corner) / self.extent).length() > BORDER_TOLERANCE * BORDER_TOLERANCE
        };
        let ends = [self.corners.first(), self.corners.last()];
        if ends.iter().flatten().all(is_apart) {
            let _fits = (self.corners.push(corner), self.is_final.push(false));
        }
    }

    fn edge(&self, index: usize) -> [DVec2; 2] {
        [index, (index + 1) % self.corners.len()].map(|at| self.corners[at] / self.extent)
    }

    /// The longest edge that may not be part of the border, and its outward normal. Rates below
    /// rest do not exist.
    fn widest_gap(&self) -> Option<(usize, DVec2)> {
        let length = |index: &usize| {
            let [a, b] = self.edge(*index);
            let is_open = !self.is_final[*index] && a.x.max(b.x) > REST_WIDTH;
            if is_open { a.distance(b) } else { 0.0 }
        };
        let longest = (0..self.corners.len())
            .reduce(|best, index| if length(&index) > length(&best) { index } else { best })?;
        let [a, b] = self.edge(longest);
        let normal = DVec2::new(b.y - a.y, a.x - b.x).normalize_or_zero();
        (length(&longest) > 0.0).then_some((longest, normal))
    }

    /// Takes the farthest corner beyond an edge.
    fn refine(&mut self, edge: usize, corner: DVec2) {
        let [a, b] = self.edge(edge);
        let normal = DVec2::new(b.y - a.y, a.x - b.x).normalize_or_zero();
        if normal.dot(corner / self.extent - a) > BORDER_TOLERANCE {
            let at = edge + 1;
            let _fits = (self.corners.insert(at, corner), self.is_final.insert(at, false));
        } else {
            self.is_final[edge] = true;
        }
    }
}

/// Width of the edge of rates at rest, in units of the largest rates.
const REST_WIDTH: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Random, Stream};
    use crate::robot::inverse_dynamics::{GeneralizedForce, LinkFrames};
    use crate::timing::support::FootSupport;

    #[test]
    fn forces_in_closed_form_are_forces_of_the_program_too() {
        let corners = [(-0.1, -0.05), (0.1, -0.05), (0.12, 0.0), (0.1, 0.05), (-0.1, 0.05)];
        let foot = FootSupport {
            limb: 0,
            center: DVec3::ZERO,
            polygon: corners.map(DVec2::from).into_iter().collect(),
            axes: glam::DMat3::from_rotation_x(0.1),
            friction: 0.6,
        };
        let support = Support { feet: [foot].into_iter().collect() };
        let (chains, efforts) = (Chains::default(), [1.0; JOINTS_MAX]);
        let mut rates = ContactRates::default();
        let mut random = Random::new(5, Stream::Shortcut, 0, 0);
        let [mut closed, mut held] = [0; 2];
        for _ in 0..400 {
            let mut number = |size: f64| random.uniform(-size, size);
            let force = DVec3::new(number(300.0), number(300.0), 500.0 + number(100.0));
            let moment = DVec3::new(number(40.0), number(80.0), number(30.0));
            let dynamics = PathDynamics {
                frames: LinkFrames::default(),
                by_acceleration: GeneralizedForce::default(),
                by_speed: GeneralizedForce::default(),
                standing: GeneralizedForce { force, moment, torques: [0.0; JOINTS_MAX] },
                origin: DVec3::ZERO,
            };
            let problem = ContactProblem {
                dynamics: &dynamics,
                support: &support,
                chains: &chains,
                efforts: &efforts,
                efforts_part: 1.0,
                mass: 50.0,
            };
            let by_program = rates.has_forces(&problem, DVec2::ZERO);
            let in_closed_form = single_contact::holds(&support.feet[0], force, moment);
            assert!(by_program || !in_closed_form, "{force} {moment}");
            closed += u32::from(in_closed_form);
            held += u32::from(by_program);
        }
        assert!(held < 390 && 2 * closed > held, "{closed} of {held}");
    }
}
