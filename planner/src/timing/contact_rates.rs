//! The rates for which contact forces exist: within friction and soles, and within the torques of
//! the stance legs.
//!
//! The rates with forces are a convex set. Where forces in closed form exist at every corner of a
//! polygon around it, it is that polygon. Elsewhere the forces of all feet are unknowns of a linear
//! program, whose projection onto the rates is found by its border in a few directions.

use glam::{DVec2, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::base::limits::{JOINTS_MAX, POLYGON_VERTICES_MAX};
use surefoot_shared_types::world::world::GRAVITY;

use crate::timing::border::Border;
use crate::timing::contact_bounds;
use crate::timing::friction_pyramid::EDGES_MAX;
use crate::timing::limit::Limit;
use crate::timing::linear_program::{LinearProgram, NoOptimum};
use crate::timing::load_sharing::splits;
use crate::timing::path_dynamics::{Affine, Chains, PathDynamics};
use crate::timing::rate_set::RateSet;
use crate::timing::single_contact;
use crate::timing::support::{FootSupport, FootWrench, Support};
use crate::timing::tuning::{DIRECTIONS_MAX, MOMENT_ARM, TORQUE_ROUNDS_MAX, TORQUE_TOLERANCE};

/// The variables before those of the contacts: `x`, and `u` as a difference of two.
const RATES: usize = 3;
/// Most variables of the contacts.
const GENERATORS_MAX: usize = 2 * EDGES_MAX * POLYGON_VERTICES_MAX;
/// Part of the weight up to which a foot counts as unloaded.
const UNLOADED: f64 = 1e-9;
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

    /// Whether contact forces in closed form hold the robot at a rate. Where they do not, others
    /// may.
    fn has_closed_form(&self, rate: DVec2) -> bool {
        let (force, moment) = self.dynamics.wrench_at(rate);
        match self.support.feet.as_slice() {
            [foot] => single_contact::holds(foot, force, moment - foot.center.cross(force)),
            [first, second] => {
                let mut splits = splits([first, second], (force, moment));
                splits.any(|wrenches| self.feet_hold(wrenches) && self.legs_hold(rate, &wrenches))
            }
            _ => false,
        }
    }

    /// Whether contact forces hold the robot at a rate for which no program is needed: those in
    /// closed form, or any where the only sole is a rectangle.
    pub(crate) fn is_known_to_hold(&self, rate: DVec2) -> bool {
        self.has_closed_form(rate) || {
            let [foot] = self.support.feet.as_slice() else { return false };
            let (force, moment) = self.dynamics.wrench_at(rate);
            single_contact::rectangle_holds(foot, force, moment - foot.center.cross(force))
        }
    }

    /// Whether each of two feet bears its wrench. One without load does.
    fn feet_hold(&self, wrenches: [FootWrench; 2]) -> bool {
        let loaded = |force: DVec3| force.length() > UNLOADED * self.weight();
        let pairs = self.support.feet.iter().zip(wrenches);
        pairs.into_iter().all(|(foot, (force, moment))| {
            !loaded(force) || single_contact::holds(foot, force, moment)
        })
    }

    /// Whether the torques of both legs are within their limits at a rate.
    fn legs_hold(&self, rate: DVec2, wrenches: &[FootWrench; 2]) -> bool {
        self.leg_load(rate, wrenches) <= 1.0 + TORQUE_TOLERANCE
    }

    /// The largest ratio of a torque of a stance leg to its limit at a rate, under the wrenches of
    /// two feet.
    pub(crate) fn leg_load(&self, rate: DVec2, wrenches: &[FootWrench; 2]) -> f64 {
        let feet = self.support.feet.iter().zip(wrenches);
        let loads = feet.flat_map(|(foot, (force, moment))| {
            self.chains[foot.limb].iter().map(|&joint| {
                let frames = &self.dynamics.frames;
                let of_foot = frames.torque_of_wrench(joint, *force, *moment, foot.center);
                let torque = self.dynamics.torque(joint).at(rate) - of_foot;
                torque.abs() / (self.efforts_part * self.efforts[joint])
            })
        });
        loads.fold(0.0, f64::max)
    }

    /// The joints whose torques depend on how two feet share the load.
    fn shared_joints(&self) -> impl Iterator<Item = usize> + '_ {
        let feet = if self.support.feet.len() > 1 { self.support.feet.as_slice() } else { &[] };
        feet.iter().flat_map(|foot| self.chains[foot.limb].iter().copied())
    }
}

/// Whether forces in closed form of the soles alone, without the torques of the legs, bear a force
/// (N) and a moment about the world's origin (N m).
pub(crate) fn soles_hold(support: &Support, (force, moment): FootWrench) -> bool {
    let bears = |foot: &FootSupport, (force, moment): FootWrench| {
        single_contact::holds(foot, force, moment)
            || single_contact::rectangle_holds(foot, force, moment)
    };
    match support.feet.as_slice() {
        [foot] => bears(foot, (force, moment - foot.center.cross(force))),
        [first, second] => splits([first, second], (force, moment))
            .any(|[of_first, of_second]| bears(first, of_first) && bears(second, of_second)),
        _ => false,
    }
}

impl ContactRates {
    /// The rates of `rates` for which contact forces exist; empty where there are none.
    pub(crate) fn restrict(&mut self, problem: &ContactProblem<'_>, rates: &RateSet) -> RateSet {
        let mut kept = rates.clone();
        contact_bounds::clip(problem.dynamics, problem.support, &mut kept);
        if kept.vertices().len() < 3 {
            return RateSet::default();
        }
        let extent = extent_of(&kept);
        let known = Border::within(extent, kept.vertices(), |rate| problem.has_closed_form(rate));
        let border = self.project(problem, extent, known);
        within(kept, &border)
    }

    /// The same by the program alone.
    pub(crate) fn restrict_by_program(
        &mut self,
        problem: &ContactProblem<'_>,
        rates: &RateSet,
    ) -> RateSet {
        let border = self.project(problem, extent_of(rates), None);
        within(rates.clone(), &border)
    }

    /// Whether contact forces exist at a rate.
    pub(crate) fn admits(&mut self, problem: &ContactProblem<'_>, rate: DVec2) -> bool {
        problem.is_known_to_hold(rate) || self.has_forces(problem, rate)
    }

    /// The same by the program.
    fn has_forces(&mut self, problem: &ContactProblem<'_>, rate: DVec2) -> bool {
        let begun = self.begin(problem, DVec2::ZERO, rate);
        begun.and_then(|()| self.maximize(problem, DVec2::ZERO)).is_ok()
    }

    /// The border of the projection, as far as the program finds it beyond the known part.
    fn project(
        &mut self,
        problem: &ContactProblem<'_>,
        extent: DVec2,
        known: Option<Border>,
    ) -> Border {
        let is_known = known.is_some();
        let mut border = known.unwrap_or_else(|| Border::new(extent));
        if is_known && border.widest_gap().is_none()
            || self.begin(problem, extent, DVec2::ZERO).is_err()
        {
            return border;
        }
        for direction in FIRST_DIRECTIONS.iter().filter(|_| !is_known) {
            let Ok(corner) = self.maximize(problem, *direction / extent) else { return border };
            border.push(corner);
        }
        for _ in 0..DIRECTIONS_MAX {
            let Some((edge, normal)) = border.widest_gap() else { break };
            let Ok(corner) = self.maximize(problem, normal / extent) else { break };
            border.refine(edge, corner);
        }
        border
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

/// The largest rates of a set, a little more.
fn extent_of(rates: &RateSet) -> DVec2 {
    let largest = rates.vertices().iter().fold(DVec2::ZERO, |most, v| most.max(v.abs()));
    largest * 1.001 + DVec2::splat(1e-6)
}

/// The rates of a set within a border; none where that has no inside.
fn within(mut rates: RateSet, border: &Border) -> RateSet {
    for [a, b] in border.inner_edges() {
        let normal = DVec2::new(b.y - a.y, a.x - b.x);
        rates.clip(normal, normal.dot(a), Limit::Contacts);
    }
    if border.corners().len() < 3 { RateSet::default() } else { rates }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Random, Stream};
    use crate::robot::inverse_dynamics::{GeneralizedForce, LinkFrames};
    use crate::timing::friction_pyramid::FrictionPyramid;
    use crate::timing::support::FootSupport;

    fn foot(corners: &[(f64, f64)]) -> FootSupport {
        FootSupport {
            limb: 0,
            center: DVec3::ZERO,
            polygon: corners.iter().copied().map(DVec2::from).collect(),
            twist_arm: 0.1,
            axes: glam::DMat3::from_rotation_x(0.1),
            friction: FrictionPyramid::with_four_sides(0.6),
        }
    }

    /// Of 400 loads of a foot, those that it bears as the program has it and in another way, and
    /// those of which both have the same.
    fn borne(foot: FootSupport, holds: fn(&FootSupport, DVec3, DVec3) -> bool) -> [u32; 3] {
        let support = Support { feet: [foot].into_iter().collect() };
        let (chains, efforts) = (Chains::default(), [1.0; JOINTS_MAX]);
        let mut rates = ContactRates::default();
        let mut random = Random::new(5, Stream::Shortcut, 0, 0);
        let [mut held, mut closed, mut both] = [0; 3];
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
            let in_closed_form = holds(&support.feet[0], force, moment);
            held += u32::from(by_program);
            closed += u32::from(in_closed_form);
            both += u32::from(by_program && in_closed_form);
        }
        [held, closed, both]
    }

    #[test]
    fn forces_in_closed_form_are_forces_of_the_program_too() {
        let corners = [(-0.1, -0.05), (0.1, -0.05), (0.12, 0.0), (0.1, 0.05), (-0.1, 0.05)];
        let [held, closed, both] = borne(foot(&corners), single_contact::holds);
        assert!(closed == both && held < 390 && 2 * closed > held, "{closed} of {held}");
        let [_, closed, _] = borne(foot(&corners), single_contact::rectangle_holds);
        assert_eq!(closed, 0, "not known of other polygons");
    }

    #[test]
    fn the_forces_of_a_rectangle_are_those_of_the_program() {
        let corners = [(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)];
        let [held, closed, both] = borne(foot(&corners), single_contact::rectangle_holds);
        assert!(closed == both && held == both, "{held} {closed} {both}");
        assert!((20..380).contains(&held), "{held}");
    }
}
