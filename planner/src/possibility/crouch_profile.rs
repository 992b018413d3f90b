//! The crouch profile of a guide route: height and pitch of the root, which the trees do not
//! determine [Grey 3.2].
//!
//! At each vertex one of a grid of crouches is chosen, by dynamic programming over the route: the
//! robot walks from vertex to vertex in one crouch and changes to another at a vertex. Without the
//! profile, low obstacles lead to transition configurations that are free but not connected.

use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::interpolate;

use crate::base::arena::reserve;
use crate::base::work_budget::items_in;
use crate::possibility::crouch_trial::{CrouchContext, CrouchTrial};
use crate::possibility::guide_route::GuideRoute;
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::tuning::{
    CHANGE_COST, COLLISION_COST, CROUCH_BATCH_MAX, CROUCH_LEG_EXTENSIONS, CROUCH_PITCHES,
    CROUCH_TEST_STRIDES, EDGE_TESTS, INFEASIBLE_COST, NEIGHBOUR_COST, OPEN_REACH, TRUNK_OFFSETS,
};
use crate::robot::crouch::Crouch;

/// Number of crouches.
const CROUCH_COUNT: usize = CROUCH_LEG_EXTENSIONS.len() * CROUCH_PITCHES.len();
/// Most changes at one vertex: enough to reach any crouch from any other.
const CHANGES_MAX: usize = CROUCH_LEG_EXTENSIONS.len() + CROUCH_PITCHES.len();

type Batch<T> = heapless::Vec<T, CROUCH_BATCH_MAX>;

/// The crouches along a route, allocated once.
#[derive(Debug)]
pub struct CrouchProfile {
    /// The root in the mid-feet frame for each crouch evaluated so far; `None` if the crouch is
    /// infeasible.
    mid_feet_from_roots: [Option<Pose>; CROUCH_COUNT],
    /// Number of single-support stances in which each crouch is infeasible.
    failures: [u32; CROUCH_COUNT],
    /// Number of crouches evaluated so far.
    known: usize,
    /// Cost to leave the last evaluated vertex in each crouch.
    costs: [f64; CROUCH_COUNT],
    /// For each vertex and the crouch it is left in: the crouch it is entered in.
    entries: Vec<[u8; CROUCH_COUNT]>,
    /// The crouch chosen at each vertex.
    chosen: Vec<u8>,
}

impl CrouchProfile {
    /// An empty profile with reserved capacity. Allocates.
    pub fn new(vertices_max: usize) -> Self {
        let (entries, chosen) = (reserve(2 * vertices_max), reserve(2 * vertices_max));
        Self {
            mid_feet_from_roots: [None; CROUCH_COUNT],
            failures: [0; CROUCH_COUNT],
            known: 0,
            costs: [0.0; CROUCH_COUNT],
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

    /// Tests which crouches are feasible, then evaluates the next vertices of a route: at most
    /// `budget` crouches or vertices, each one work unit. Returns the work spent, and whether the
    /// crouches of all vertices are chosen.
    pub fn advance(
        &mut self,
        context: &CrouchContext<'_>,
        route: &GuideRoute,
        budget: u64,
    ) -> (u64, bool) {
        let count_max = items_in(budget, CROUCH_BATCH_MAX);
        let spent = if self.known < CROUCH_COUNT {
            self.try_crouches(context, count_max)
        } else {
            self.evaluate_vertices(context, route, count_max)
        };
        if self.entries.len() == route.vertex_count() {
            self.trace();
        }
        (spent as u64, !self.chosen.is_empty())
    }

    /// Tests the next crouches, at most `count_max`. Returns their number.
    fn try_crouches(&mut self, context: &CrouchContext<'_>, count_max: usize) -> usize {
        let next: Batch<usize> = (self.known..CROUCH_COUNT).take(count_max).collect();
        let tried = context.threads.map(&next, |index| {
            let trial = CrouchTrial::new(context.constraints, context.upper_body, crouch(index));
            (trial.mid_feet_from_root(), trial.failures(&CROUCH_TEST_STRIDES))
        });
        for (index, (mid_feet_from_root, failures)) in next.iter().zip(tried) {
            (self.mid_feet_from_roots[*index], self.failures[*index]) =
                (mid_feet_from_root, failures);
        }
        self.known += next.len();
        next.len()
    }

    /// Evaluates the costs of the next vertices in each crouch, at most `count_max`. Returns their
    /// number.
    fn evaluate_vertices(
        &mut self,
        context: &CrouchContext<'_>,
        route: &GuideRoute,
        count_max: usize,
    ) -> usize {
        let is_free = |mid_feet_from_root: &Pose, pose: &MidFeetPose| {
            context.upper_body.is_free_above_legs(
                &context.constraints.collision,
                &(pose.world_from_mid_feet() * *mid_feet_from_root),
                false,
            )
        };
        let next: Batch<usize> =
            (self.entries.len()..route.vertex_count()).take(count_max).collect();
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
                root.map(|root| tests.iter().filter(|pose| !is_free(&root, pose)).count())
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
    fn add_edge_costs(&mut self, blocked: &[Option<usize>; CROUCH_COUNT]) {
        for (index, cost) in self.costs.iter_mut().enumerate() {
            let colliding_neighbours =
                neighbours(index).filter(|&near| blocked[near] != Some(0)).count();
            let obstruction =
                blocked[index].map_or(f64::INFINITY, |tests| COLLISION_COST * tests as f64);
            *cost += crouch(index).depth()
                + INFEASIBLE_COST * f64::from(self.failures[index])
                + obstruction
                + NEIGHBOUR_COST * colliding_neighbours as f64;
        }
    }

    /// The crouch at a vertex; upright if none was chosen.
    pub fn crouch(&self, vertex: usize) -> Crouch {
        self.chosen.get(vertex).map_or(Crouch::UPRIGHT, |&index| crouch(index as usize))
    }

    /// Whether the trunk is free along the route in the chosen crouches, or beside it: arms may
    /// move aside, and stage M is not bound to the route.
    pub fn has_free_trunk(&self, context: &CrouchContext<'_>, route: &GuideRoute) -> bool {
        let CrouchContext { constraints, upper_body, .. } = context;
        let is_free = |vertex: usize, pose: &MidFeetPose| {
            self.mid_feet_from_roots[self.chosen[vertex] as usize].is_some_and(|root| {
                let world_from_root = pose.world_from_mid_feet() * root;
                upper_body.is_trunk_free(&constraints.collision, &world_from_root)
            })
        };
        (1..self.chosen.len()).all(|index| {
            let [before, pose] = [index - 1, index].map(|vertex| route.pose(vertex));
            let aside = before.horizontal_offset_to(&pose).perp().normalize_or_zero();
            (1..=EDGE_TESTS).all(|test| {
                let between = before.interpolate(&pose, test as f64 / EDGE_TESTS as f64);
                TRUNK_OFFSETS.iter().any(|&distance| {
                    let position = between.position + (distance * aside).extend(0.0);
                    let beside = MidFeetPose { position, ..between };
                    is_free(index, &beside) || is_free(index - 1, &beside)
                })
            })
        })
    }

    /// Whether the robot can stand on one foot in every chosen crouch, the other foot somewhere
    /// beside it.
    pub fn may_step(&self) -> bool {
        let stances_max = (2 * CROUCH_TEST_STRIDES.len()) as u32;
        self.chosen.iter().all(|&crouch| self.failures[crouch as usize] < stances_max)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.entries.capacity() * size_of::<[u8; CROUCH_COUNT]>() + self.chosen.capacity()
    }

    /// Relaxes changes of crouch at a vertex. A change whose posture halfway is not free costs a
    /// collision.
    fn change_crouches(&mut self, is_free: impl Fn(&Pose) -> bool) {
        let mut entries = std::array::from_fn(|index| index as u8);
        let mut known = [[None; 2]; CROUCH_COUNT];
        for _ in 0..CHANGES_MAX {
            let before = self.costs;
            for (index, (next, direction)) in (0..CROUCH_COUNT).flat_map(|index| {
                successors(index).into_iter().zip(0..).map(move |next| (index, next))
            }) {
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

    /// Traces the cheapest choice back from the last vertex. At a vertex with a change of crouch
    /// the deeper one is chosen.
    fn trace(&mut self) {
        let cost = |index: &usize| self.costs[*index] + cost_to_upright(*index);
        let mut left = (0..CROUCH_COUNT).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(0);
        self.chosen.resize(self.entries.len(), 0);
        for (chosen, entries) in self.chosen.iter_mut().zip(&self.entries).rev() {
            let entered = entries[left] as usize;
            *chosen =
                if crouch(entered).depth() > crouch(left).depth() { entered } else { left } as u8;
            left = entered;
        }
    }
}

/// The crouch of an index in the grid.
fn crouch(index: usize) -> Crouch {
    Crouch {
        leg_extension: CROUCH_LEG_EXTENSIONS[index / CROUCH_PITCHES.len()],
        pitch: CROUCH_PITCHES[index % CROUCH_PITCHES.len()],
        ..Crouch::UPRIGHT
    }
}

/// Cost of the change from upright into a crouch, or back.
fn cost_to_upright(index: usize) -> f64 {
    CHANGE_COST * (index / CROUCH_PITCHES.len() + index % CROUCH_PITCHES.len()) as f64
}

/// The next crouches in the grid: the one with more pitch, and the lower one.
fn successors(index: usize) -> [Option<usize>; 2] {
    let pitched = (index % CROUCH_PITCHES.len() + 1 < CROUCH_PITCHES.len()).then_some(index + 1);
    let lowered =
        (index + CROUCH_PITCHES.len() < CROUCH_COUNT).then_some(index + CROUCH_PITCHES.len());
    [pitched, lowered]
}

/// The up to four neighbours of a crouch in the grid.
fn neighbours(index: usize) -> impl Iterator<Item = usize> {
    let before =
        [1, CROUCH_PITCHES.len()].into_iter().filter_map(move |step| index.checked_sub(step));
    let is_beside = move |near: &usize| successors(*near).contains(&Some(index));
    successors(index).into_iter().flatten().chain(before.filter(is_beside))
}
