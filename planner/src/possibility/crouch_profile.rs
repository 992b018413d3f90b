//! The crouch profile of a guide route: height and lean of the root, which the trees leave open
//! [Grey 3.2].
//!
//! At each vertex one of a grid of crouches is chosen, by dynamic programming over the route: the
//! robot walks from vertex to vertex in one crouch and changes to another where it stands.
//! Without the profile, low obstacles lead to configurations that are free one by one but not
//! connected.

use glam::{DQuat, DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{interpolate, rotation_from_rpy};

use crate::base::arena::reserve;
use crate::base::threads::Threads;
use crate::base::work_budget::items_in;
use crate::constraints::constraints::Constraints;
use crate::geometry::convex_region::ConvexRegion;
use crate::possibility::guide_route::GuideRoute;
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::upper_body::UpperBody;
use crate::robot::configuration::Configuration;
use crate::robot::crouch::Crouch;
use crate::robot::gravity_torques::{FootLoad, effort_use};
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;
use crate::robot::posture_ik::{Posture, solve_posture};
use crate::robot::single_support::SingleSupportPosture;

/// Leg extensions: fractions of the standing reach.
const LEG_EXTENSIONS: [f64; 5] = [1.0, 0.92, 0.84, 0.76, 0.68];
/// How far the root may lean forward, rad.
const PITCHES: [f64; 5] = [0.0, 0.3, 0.6, 0.9, 1.2];
/// Number of crouches.
const COUNT: usize = LEG_EXTENSIONS.len() * PITCHES.len();
/// Offsets of the swing foot ahead of the stance foot at which a crouch is tried, m.
const STRIDES: [f64; 3] = [0.0, 0.2, -0.2];
/// Where the upright robot fits at this many vertices before and after, every crouch counts as
/// free.
const OPEN_REACH: usize = 6;
/// Collision tests between one vertex and the next.
const EDGE_TESTS: usize = 2;
/// Cost of a collision. Finite, because arms may move and the root shifts in single support.
const COLLISION_COST: f64 = 30.0;
/// Cost of each single-support stance in which a crouch is infeasible.
const INFEASIBLE_COST: f64 = 3.0;
/// Cost of each neighbouring crouch that collides.
const NEIGHBOUR_COST: f64 = 1.0;
/// Cost of a change to a neighbouring crouch.
const CHANGE_COST: f64 = 0.5;
/// Most changes at one vertex: enough to reach any crouch from any other.
const CHANGES_MAX: usize = LEG_EXTENSIONS.len() + PITCHES.len();

/// Crouches or vertices that are evaluated in parallel.
const AT_ONCE: usize = 32;

type Batch<T> = heapless::Vec<T, AT_ONCE>;

/// Constants of the crouch profile.
#[derive(Debug, Clone, Copy)]
pub struct CrouchContext<'a> {
    /// The robot and the world.
    pub constraints: &'a Constraints,
    /// The upper body.
    pub upper_body: &'a UpperBody,
    /// The threads that share the work.
    pub threads: &'a Threads,
}

/// The crouches along a route, allocated once.
#[derive(Debug)]
pub struct CrouchProfile {
    /// The root in the mid-feet frame for each crouch evaluated so far; `None` if the crouch is
    /// infeasible.
    mid_feet_from_roots: [Option<Pose>; COUNT],
    /// Number of single-support stances in which each crouch is infeasible.
    failures: [u32; COUNT],
    known: usize,
    /// Cost to leave the last evaluated vertex in each crouch.
    costs: [f64; COUNT],
    /// For each vertex and the crouch it is left in: the crouch it is entered in.
    entries: Vec<[u8; COUNT]>,
    chosen: Vec<u8>,
}

impl CrouchProfile {
    /// An empty profile with reserved capacity. Allocates.
    pub fn new(vertices_max: usize) -> Self {
        let (entries, chosen) = (reserve(2 * vertices_max), reserve(2 * vertices_max));
        Self {
            mid_feet_from_roots: [None; COUNT],
            failures: [0; COUNT],
            known: 0,
            costs: [0.0; COUNT],
            entries,
            chosen,
        }
    }

    /// Resets the profile for a new route.
    pub fn begin(&mut self) {
        self.entries.clear();
        self.chosen.clear();
        self.costs = std::array::from_fn(cost_to_upright);
    }

    /// Tests which crouches are feasible; once all are tested, evaluates the next vertices of a
    /// route. At most `budget` items, each a work unit. Returns the work spent, and whether the
    /// crouches of all vertices are chosen.
    pub fn advance(
        &mut self,
        context: &CrouchContext<'_>,
        route: &GuideRoute,
        budget: u64,
    ) -> (u64, bool) {
        let at_once = items_in(budget, AT_ONCE);
        let spent = if self.known < COUNT {
            self.try_crouches(context, at_once)
        } else {
            self.evaluate_vertices(context, route, at_once)
        };
        if self.entries.len() == route.vertex_count() {
            self.trace();
        }
        (spent as u64, !self.chosen.is_empty())
    }

    /// Tests the next crouches.
    fn try_crouches(&mut self, context: &CrouchContext<'_>, at_once: usize) -> usize {
        let next: Batch<usize> = (self.known..COUNT).take(at_once).collect();
        let tried = context.threads.map(&next, |index| {
            let trial = CrouchTrial::new(context.constraints, context.upper_body, crouch(index));
            (trial.mid_feet_from_root(), trial.failures())
        });
        for (index, (mid_feet_from_root, failures)) in next.iter().zip(tried) {
            (self.mid_feet_from_roots[*index], self.failures[*index]) =
                (mid_feet_from_root, failures);
        }
        self.known += next.len();
        next.len()
    }

    /// Costs of the next vertices in each crouch.
    fn evaluate_vertices(
        &mut self,
        context: &CrouchContext<'_>,
        route: &GuideRoute,
        at_once: usize,
    ) -> usize {
        let is_free = |root: &Pose, place: &MidFeetPose| {
            context.upper_body.is_free_above_legs(
                &context.constraints.collision,
                &(place.world_from_mid_feet() * *root),
            )
        };
        let next: Batch<usize> = (self.entries.len()..route.vertex_count()).take(at_once).collect();
        let mid_feet_from_roots = &self.mid_feet_from_roots;
        let blocked = context.threads.map(&next, |index| {
            let (before, pose) = (route.pose(index.saturating_sub(1)), route.pose(index));
            if route.is_upright_about(index, OPEN_REACH) {
                return mid_feet_from_roots.map(|root| root.map(|_| 0));
            }
            let tests: [MidFeetPose; EDGE_TESTS] = std::array::from_fn(|test| {
                before.interpolate(&pose, (test + 1) as f64 / EDGE_TESTS as f64)
            });
            mid_feet_from_roots.map(|root| {
                root.map(|root| tests.iter().filter(|place| !is_free(&root, place)).count())
            })
        });
        for (&index, blocked) in next.iter().zip(&blocked) {
            let (is_open, pose) = (route.is_upright_about(index, OPEN_REACH), route.pose(index));
            self.add_edge_costs(blocked);
            self.change_crouches(|halfway| is_open || is_free(halfway, &pose));
        }
        next.len()
    }

    /// Adds the costs of the edge to the next vertex: `blocked` are the collisions on it in each
    /// crouch.
    fn add_edge_costs(&mut self, blocked: &[Option<usize>; COUNT]) {
        for (index, cost) in self.costs.iter_mut().enumerate() {
            let tight = neighbours(index).filter(|&near| blocked[near] != Some(0)).count();
            let obstruction =
                blocked[index].map_or(f64::INFINITY, |tests| COLLISION_COST * tests as f64);
            *cost += crouch(index).depth()
                + INFEASIBLE_COST * f64::from(self.failures[index])
                + obstruction
                + NEIGHBOUR_COST * tight as f64;
        }
    }

    /// The crouch at a vertex; upright if none was chosen.
    pub fn crouch(&self, vertex: usize) -> Crouch {
        self.chosen.get(vertex).map_or(Crouch::UPRIGHT, |&index| crouch(index as usize))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.entries.capacity() * size_of::<[u8; COUNT]>() + self.chosen.capacity()
    }

    /// Changes of crouch at a vertex; the posture halfway must be free.
    fn change_crouches(&mut self, is_free: impl Fn(&Pose) -> bool) {
        let mut entries = std::array::from_fn(|index| index as u8);
        let mut known = [[None; 2]; COUNT];
        for _ in 0..CHANGES_MAX {
            let before = self.costs;
            for (index, (next, direction)) in (0..COUNT)
                .flat_map(|index| onward(index).into_iter().zip(0..).map(move |next| (index, next)))
            {
                let Some(next) = next else { continue };
                let [from, to] = if self.costs[index] < self.costs[next] {
                    [index, next]
                } else {
                    [next, index]
                };
                let [Some(root), Some(changed)] =
                    [from, to].map(|index| self.mid_feet_from_roots[index])
                else {
                    continue;
                };
                if self.costs[from] + CHANGE_COST >= self.costs[to] {
                    continue;
                }
                let is_halfway_free = *known[index][direction]
                    .get_or_insert_with(|| is_free(&interpolate(&root, &changed, 0.5)));
                let cost = self.costs[from]
                    + CHANGE_COST
                    + if is_halfway_free { 0.0 } else { COLLISION_COST };
                if cost < self.costs[to] {
                    (self.costs[to], entries[to]) = (cost, entries[from]);
                }
            }
            if before == self.costs {
                break;
            }
        }
        self.entries.push(entries);
    }

    /// Traces the cheapest choice back from the last vertex. Where the crouch changes, the deeper
    /// one counts.
    fn trace(&mut self) {
        let cost = |index: &usize| self.costs[*index] + cost_to_upright(*index);
        let mut left = (0..COUNT).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(0);
        self.chosen.resize(self.entries.len(), 0);
        for (chosen, entries) in self.chosen.iter_mut().zip(&self.entries).rev() {
            let entered = entries[left] as usize;
            *chosen =
                if crouch(entered).depth() > crouch(left).depth() { entered } else { left } as u8;
            left = entered;
        }
    }
}

fn crouch(index: usize) -> Crouch {
    Crouch {
        leg_extension: LEG_EXTENSIONS[index / PITCHES.len()],
        pitch: PITCHES[index % PITCHES.len()],
    }
}

/// Cost of the change from upright into a crouch, or back.
fn cost_to_upright(index: usize) -> f64 {
    CHANGE_COST * (index / PITCHES.len() + index % PITCHES.len()) as f64
}

/// The next crouches of the grid: the one that leans farther, and the one that is lower.
fn onward(index: usize) -> [Option<usize>; 2] {
    let leans = (index % PITCHES.len() + 1 < PITCHES.len()).then_some(index + 1);
    let crouches = (index + PITCHES.len() < COUNT).then_some(index + PITCHES.len());
    [leans, crouches]
}

/// The up to four neighbours of a crouch in the grid.
fn neighbours(index: usize) -> impl Iterator<Item = usize> {
    let before = [1, PITCHES.len()].into_iter().filter_map(move |step| index.checked_sub(step));
    let is_beside = move |near: &usize| onward(*near).contains(&Some(index));
    onward(index).into_iter().flatten().chain(before.filter(is_beside))
}

/// The robot in a crouch on level ground, in the mid-feet frame.
struct CrouchTrial<'a> {
    constraints: &'a Constraints,
    robot: &'a Mechanism,
    upright: DQuat,
    soles: [Pose; 2],
    crouch: Crouch,
}

impl<'a> CrouchTrial<'a> {
    fn new(constraints: &'a Constraints, upper_body: &UpperBody, crouch: Crouch) -> Self {
        let robot = &constraints.robot;
        let upright = upper_body.mid_feet_from_root();
        let soles = [0, 1].map(|limb| upright * robot.legs[limb].root_from_sole(&robot.standing_q));
        Self { constraints, robot, upright: upright.rotation, soles, crouch }
    }

    /// The root, the robot on both feet; `None` if that is infeasible.
    fn mid_feet_from_root(&self) -> Option<Pose> {
        let [left, right] =
            [0, 1].map(|limb| self.robot.soles[limb].ankle_support_region(&self.soles[limb]));
        let com =
            ConvexRegion::hull(left.vertices().iter().chain(right.vertices()).copied()).centroid();
        let (configuration, _) =
            self.solve(&self.soles, &SingleSupportPosture::standing(self.robot.standing_q), com)?;
        Some(configuration.world_from_root)
    }

    /// Number of infeasible single-support stances, the other foot beside, ahead or behind.
    fn failures(&self) -> u32 {
        let stances = [0, 1].into_iter().flat_map(|limb| STRIDES.map(|stride| (limb, stride)));
        stances.filter(|&(limb, stride)| !self.is_feasible_on(limb, stride)).count() as u32
    }

    fn is_feasible_on(&self, limb: usize, stride: f64) -> bool {
        let mut soles = self.soles;
        soles[1 - limb].translation += stride * DVec3::X;
        let com = self.robot.soles[limb].ankle_support_region(&self.soles[limb]).centroid();
        let solved = self.solve(&soles, &self.constraints.single_support_postures[limb], com);
        solved.is_some_and(|(_, kinematic_state)| {
            effort_use(&self.robot.mass_tree, &kinematic_state, &FootLoad::all_on(limb, com)) <= 1.0
        })
    }

    /// On its soles, the links apart.
    fn solve(
        &self,
        soles: &[Pose; 2],
        carriage: &SingleSupportPosture,
        com: DVec2,
    ) -> Option<(Configuration, KinematicState)> {
        let [roll, pitch] = carriage.rotation;
        let world_from_root =
            self.upright * rotation_from_rpy(roll, pitch + self.crouch.pitch, 0.0);
        let posture = Posture {
            world_from_root,
            leg_extension: self.crouch.leg_extension * self.robot.standing_leg_extension,
            com,
        };
        let solved = solve_posture(self.robot, soles, &posture, carriage.q).ok()?;
        self.constraints.collision.self_hit(&solved.1).is_none().then_some(solved)
    }
}
