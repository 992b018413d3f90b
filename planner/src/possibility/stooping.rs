//! How the robot stoops along the guide route: the height and the lean of the root, which the trees
//! leave open [Grey 3.2].
//!
//! At each station one of a grid of stoops is chosen, by dynamic programming over the route: the
//! robot walks from station to station in one stoop, and bends from one into the next where it
//! stands. Where something hangs low, configurations would else be found that have room one by one,
//! but none of which leads to the next.

use glam::{DQuat, DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::spatial::{interpolate, rotation_from_rpy};

use super::route::Route;
use super::station::Station;
use super::torso::Torso;
use crate::allowance::items_in;
use crate::arena::reserve;
use crate::body::{Body, Configuration};
use crate::carriage::Carriage;
use crate::collision::CollisionModel;
use crate::posture::{Posture, settle};
use crate::region::Region;
use crate::snapshot::Snapshot;
use crate::statics::FootLoad;
use crate::stoop::Stoop;
use crate::threads::Threads;

/// The shares of their standing reach that the legs may use.
const SHARES: [f64; 5] = [1.0, 0.92, 0.84, 0.76, 0.68];
/// How far the root may lean forward, rad.
const PITCHES: [f64; 5] = [0.0, 0.3, 0.6, 0.9, 1.2];
/// How many stoops there are.
const COUNT: usize = SHARES.len() * PITCHES.len();
/// How far ahead of the foot that carries it the robot's other foot stands where a stoop is tried,
/// m.
const STRIDES: [f64; 3] = [0.0, 0.2, -0.2];
/// Where the upright robot has room at so many stations before and after, it has no reason to
/// stoop, and is taken to have room however it does.
const OPEN: usize = 6;
/// Looks at the room on the way from one station to the next.
const LOOKS: usize = 2;
/// What a look costs where there is no room: not everything, since arms may give way and a robot on
/// one foot is elsewhere by a hand.
const BLOCKED: f64 = 30.0;
/// What it costs that the robot cannot take a stoop in one of the stances on one foot.
const HARD: f64 = 3.0;
/// What it costs that there is no room in a neighbouring stoop.
const TIGHT: f64 = 1.0;
/// What it costs to bend from one stoop into a neighbouring one.
const BEND: f64 = 0.5;
/// Rounds of bending at one station: enough to go from any stoop into any other.
const BENDS_MAX: usize = SHARES.len() + PITCHES.len();

/// Stoops or stations that are looked at side by side.
const AT_ONCE: usize = 32;

type Batch<T> = heapless::Vec<T, AT_ONCE>;

/// Where the robot stoops.
#[derive(Debug, Clone, Copy)]
pub struct Site<'a> {
    /// The robot.
    pub body: &'a Body,
    /// The robot above its legs.
    pub torso: &'a Torso,
    /// The world.
    pub collision: &'a CollisionModel,
    /// The threads that share the work.
    pub threads: &'a Threads,
}

/// The choice of stoops, allocated once.
#[derive(Debug)]
pub struct Stooping {
    /// The root in the frame of a station in each stoop, as far as these are known; `None` for
    /// those that the robot cannot take.
    station_from_roots: [Option<Pose>; COUNT],
    /// In how many stances on one foot the robot cannot take each stoop.
    failures: [u32; COUNT],
    known: usize,
    /// What it costs to leave the station looked at last in each stoop.
    costs: [f64; COUNT],
    /// In which stoop each station is entered that is left in another.
    entries: Vec<[u8; COUNT]>,
    chosen: Vec<u8>,
}

impl Stooping {
    /// Room for a route. Allocates.
    pub fn new(stations_max: usize) -> Self {
        let (entries, chosen) = (reserve(2 * stations_max), reserve(2 * stations_max));
        Self {
            station_from_roots: [None; COUNT],
            failures: [0; COUNT],
            known: 0,
            costs: [0.0; COUNT],
            entries,
            chosen,
        }
    }

    /// Begins anew, for another route.
    pub fn begin(&mut self) {
        self.entries.clear();
        self.chosen.clear();
        self.costs = std::array::from_fn(bend_to_upright);
    }

    /// Finds out which stoops the robot can take, or once that is known, looks at the next stations
    /// of a route: at most `budget` of these, each a unit of work. Answers how many, and whether
    /// the stoops of all stations are chosen.
    pub fn advance(&mut self, site: &Site<'_>, route: &Route, budget: u64) -> (u64, bool) {
        let at_once = items_in(budget, AT_ONCE);
        let spent = if self.known < COUNT {
            self.try_stoops(site, at_once)
        } else {
            self.look_at_stations(site, route, at_once)
        };
        if self.entries.len() == route.stations() {
            self.trace();
        }
        (spent as u64, !self.chosen.is_empty())
    }

    /// Whether the robot can take the next stoops.
    fn try_stoops(&mut self, site: &Site<'_>, at_once: usize) -> usize {
        let next: Batch<usize> = (self.known..COUNT).take(at_once).collect();
        let tried = site.threads.map(&next, |index| {
            let stand = Stand::new(site.body, site.collision, site.torso, stoop(index));
            (stand.station_from_root(), stand.failures())
        });
        for (index, (station_from_root, failures)) in next.iter().zip(tried) {
            (self.station_from_roots[*index], self.failures[*index]) =
                (station_from_root, failures);
        }
        self.known += next.len();
        next.len()
    }

    /// What the next stations cost in each stoop.
    fn look_at_stations(&mut self, site: &Site<'_>, route: &Route, at_once: usize) -> usize {
        let has_room = |root: &Pose, place: &Station| {
            site.torso.has_room_above_legs(site.collision, &(place.world_from_station() * *root))
        };
        let next: Batch<usize> = (self.entries.len()..route.stations()).take(at_once).collect();
        let station_from_roots = &self.station_from_roots;
        let blocked = site.threads.map(&next, |index| {
            let (before, station) = (route.station(index.saturating_sub(1)), route.station(index));
            if route.is_upright_about(index, OPEN) {
                return station_from_roots.map(|root| root.map(|_| 0));
            }
            let looks: [Station; LOOKS] = std::array::from_fn(|look| {
                before.toward_share(&station, (look + 1) as f64 / LOOKS as f64)
            });
            station_from_roots.map(|root| {
                root.map(|root| looks.iter().filter(|place| !has_room(&root, place)).count())
            })
        });
        for (&index, blocked) in next.iter().zip(&blocked) {
            let (is_open, station) = (route.is_upright_about(index, OPEN), route.station(index));
            self.enter(blocked);
            self.bend(|halfway| is_open || has_room(halfway, &station));
        }
        next.len()
    }

    /// Walks on to the next station: `blocked` are the looks on the way there that find no room, in
    /// each stoop.
    fn enter(&mut self, blocked: &[Option<usize>; COUNT]) {
        for (index, cost) in self.costs.iter_mut().enumerate() {
            let tight = neighbours(index).filter(|&near| blocked[near] != Some(0)).count();
            let room = blocked[index].map_or(f64::INFINITY, |looks| BLOCKED * looks as f64);
            *cost += stoop(index).depth()
                + HARD * f64::from(self.failures[index])
                + room
                + TIGHT * tight as f64;
        }
    }

    /// How the robot stoops at a station: upright where no stoops were chosen.
    pub fn stoop(&self, station: usize) -> Stoop {
        self.chosen.get(station).map_or(Stoop::UPRIGHT, |&index| stoop(index as usize))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.entries.capacity() * size_of::<[u8; COUNT]>() + self.chosen.capacity()
    }

    /// Bends from the stoops in which a station is entered into others, where halfway there is
    /// room.
    fn bend(&mut self, has_room: impl Fn(&Pose) -> bool) {
        let mut entries = std::array::from_fn(|index| index as u8);
        let mut known = [[None; 2]; COUNT];
        for _ in 0..BENDS_MAX {
            let before = self.costs;
            for (index, (next, way)) in (0..COUNT)
                .flat_map(|index| onward(index).into_iter().zip(0..).map(move |next| (index, next)))
            {
                let Some(next) = next else { continue };
                let [from, to] = if self.costs[index] < self.costs[next] {
                    [index, next]
                } else {
                    [next, index]
                };
                let [Some(root), Some(bent)] =
                    [from, to].map(|index| self.station_from_roots[index])
                else {
                    continue;
                };
                if self.costs[from] + BEND >= self.costs[to] {
                    continue;
                }
                let is_free = *known[index][way]
                    .get_or_insert_with(|| has_room(&interpolate(&root, &bent, 0.5)));
                let cost = self.costs[from] + BEND + if is_free { 0.0 } else { BLOCKED };
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

    /// Follows the cheapest choice back from the last station. Where the robot bends, the deeper
    /// stoop counts.
    fn trace(&mut self) {
        let cost = |index: &usize| self.costs[*index] + bend_to_upright(*index);
        let mut left = (0..COUNT).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(0);
        self.chosen.resize(self.entries.len(), 0);
        for (chosen, entries) in self.chosen.iter_mut().zip(&self.entries).rev() {
            let entered = entries[left] as usize;
            *chosen =
                if stoop(entered).depth() > stoop(left).depth() { entered } else { left } as u8;
            left = entered;
        }
    }
}

fn stoop(index: usize) -> Stoop {
    Stoop { share: SHARES[index / PITCHES.len()], pitch: PITCHES[index % PITCHES.len()] }
}

/// What it costs to bend into a stoop from upright, or back.
fn bend_to_upright(index: usize) -> f64 {
    BEND * (index / PITCHES.len() + index % PITCHES.len()) as f64
}

/// The next stoops of the grid: the one that leans farther, and the one that crouches deeper.
fn onward(index: usize) -> [Option<usize>; 2] {
    let leans = (index % PITCHES.len() + 1 < PITCHES.len()).then_some(index + 1);
    let crouches = (index + PITCHES.len() < COUNT).then_some(index + PITCHES.len());
    [leans, crouches]
}

/// The up to four stoops beside one in the grid.
fn neighbours(index: usize) -> impl Iterator<Item = usize> {
    let before = [1, PITCHES.len()].into_iter().filter_map(move |step| index.checked_sub(step));
    let is_beside = move |near: &usize| onward(*near).contains(&Some(index));
    onward(index).into_iter().flatten().chain(before.filter(is_beside))
}

/// The robot in a stoop on level ground, in the frame of a station.
struct Stand<'a> {
    body: &'a Body,
    collision: &'a CollisionModel,
    upright: DQuat,
    soles: [Pose; 2],
    stoop: Stoop,
}

impl<'a> Stand<'a> {
    fn new(body: &'a Body, collision: &'a CollisionModel, torso: &Torso, stoop: Stoop) -> Self {
        let upright = torso.station_from_root();
        let soles = [0, 1].map(|limb| upright * body.legs[limb].root_from_sole(&body.standing_q));
        Self { body, collision, upright: upright.rotation, soles, stoop }
    }

    /// The root, the robot on both feet; `None` where it cannot stand so.
    fn station_from_root(&self) -> Option<Pose> {
        let [left, right] = [0, 1].map(|limb| self.body.held_region(limb, &self.soles[limb]));
        let com = Region::hull(left.vertices().iter().chain(right.vertices()).copied()).centroid();
        let (configuration, _) =
            self.settled(&self.soles, &Carriage::standing(self.body.standing_q), com)?;
        Some(configuration.world_from_root)
    }

    /// In how many stances it cannot stand on one foot, the other one beside it, ahead or behind.
    fn failures(&self) -> u32 {
        let stances = [0, 1].into_iter().flat_map(|limb| STRIDES.map(|stride| (limb, stride)));
        stances.filter(|&(limb, stride)| !self.stands_on(limb, stride)).count() as u32
    }

    fn stands_on(&self, limb: usize, stride: f64) -> bool {
        let mut soles = self.soles;
        soles[1 - limb].translation += stride * DVec3::X;
        let com = self.body.held_region(limb, &self.soles[limb]).centroid();
        let settled = self.settled(&soles, &self.body.carriages[limb], com);
        settled.is_some_and(|(_, snapshot)| {
            self.body.statics.effort_use(&snapshot, &FootLoad::all_on(limb, com)) <= 1.0
        })
    }

    /// On its soles, the links apart.
    fn settled(
        &self,
        soles: &[Pose; 2],
        carriage: &Carriage,
        com: DVec2,
    ) -> Option<(Configuration, Snapshot)> {
        let [roll, pitch] = carriage.rotation;
        let world_from_root = self.upright * rotation_from_rpy(roll, pitch + self.stoop.pitch, 0.0);
        let posture = Posture {
            world_from_root,
            reach_share: self.stoop.share * self.body.standing_reach_share,
            com,
        };
        let settled = settle(self.body, soles, &posture, carriage.q).ok()?;
        self.collision.self_hit(&settled.1).is_none().then_some(settled)
    }
}
