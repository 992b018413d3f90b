//! Whether the robot could perhaps stand at a station: placements for both feet, and room for the
//! torso [Grey 4.1, 4.2].

use std::ops::ControlFlow;

use glam::DVec3;
use surefoot_shared_types::Pose;

use super::station::Station;
use super::torso::{Room, Torso};
use crate::constraint::Constraints;
use crate::foot_placement::{Effort, Scratch, Surfaces};
use crate::foot_query::{FootQuery, YAW_SPREAD_MAX};
use crate::prepare::{Preparation, is_whole};
use crate::threads::Threads;

/// How far below and above the ideal a placement may be, m.
const REACH_Z: [f64; 2] = [-0.5, 0.5];
/// Placements kept for each foot.
const KEPT_MAX: usize = 6;
/// Placements kept at a station.
pub const PLACEMENTS_MAX: usize = 2 * KEPT_MAX;
/// Steps between two stations that are tried by inverse kinematics.
const STEPS_TRIED_MAX: usize = 8;
/// The longest way between two looks at the torso's room, m: no torso is so thin that it slips past
/// a wall between them.
const ROOM_STEP: f64 = 0.12;
/// The effort while the demands are high: what the geometry says.
const EFFORT: Effort = Effort { geometric_max: 64, varied_max: 0, sampled_max: 0 };
/// The effort once the demands are relaxed.
const RELAXED_EFFORT: Effort = Effort { geometric_max: 64, varied_max: 8, sampled_max: 24 };
/// What a metre between the feet's heights costs when a pair is chosen.
const HEIGHT_DIFFERENCE_COST: f64 = 2.0;
/// What a metre of height away from the target costs: elevation is projected toward it where there
/// is a choice [Grey 4.3].
const AWAY_FROM_TARGET_COST: f64 = 0.5;

/// What stage P reads.
#[derive(Debug, Clone, Copy)]
pub struct Context<'a> {
    /// The robot and the world's geometry.
    pub constraints: &'a Constraints,
    /// Where soles can rest.
    pub surfaces: &'a Surfaces,
    /// The robot above its legs.
    pub torso: &'a Torso,
    /// What the legs may reach, and where primitives hold.
    pub preparation: &'a Preparation<'static>,
    /// The seed of all streams.
    pub seed: u64,
    /// How far apart the feet ideally stand, m.
    pub feet_apart: f64,
    /// The threads that share the work.
    pub threads: &'a Threads,
    /// Whether a step leads from the first placement to the second, as stage M would take it.
    pub is_step: fn(&Constraints, [&Placed; 2]) -> bool,
}

/// The memory in which the placements of both feet are found.
#[derive(Debug)]
pub enum ScratchOfFeet<'a> {
    /// One foot after the other.
    Shared(&'a mut Scratch),
    /// Side by side.
    Each([&'a mut Scratch; 2]),
}

/// A foot placement that was found along the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// Which foot.
    pub limb: usize,
    /// The sole's pose in the world.
    pub world_from_sole: Pose,
    /// Whether the whole sole is carried.
    pub is_whole: bool,
}

/// Two placements on which the robot stands at a station, left and right.
pub type Pair = [Placed; 2];

/// A station at which the necessary conditions hold.
#[derive(Debug, Clone)]
pub struct Stance {
    /// Where: the wished-for station, moved onto the ground that was found.
    pub station: Station,
    /// The placements of both feet.
    pub placements: heapless::Vec<Placed, PLACEMENTS_MAX>,
    /// The pair of them over which the station is, unless the feet would meet on it.
    pub pair: Option<Pair>,
    /// Whether all that the root carries has room with the robot upright.
    pub is_upright: bool,
}

/// What is asked of a stance.
#[derive(Debug, Clone, Copy)]
pub struct Wish {
    /// Where.
    pub station: Station,
    /// The height that the way leads to, m.
    pub target_height: f64,
    /// Whether C_N alone is enough.
    pub relaxed: bool,
    /// The name of the query in the random stream.
    pub name: u64,
}

impl Context<'_> {
    /// Finds placements for both feet near a station, and moves the station over the best pair of
    /// them: its elevation, and aside where the ground is narrow. `None` where C_N fails, or C_S
    /// where the wish insists on it.
    pub fn stand(&self, wish: &Wish, scratch: &mut ScratchOfFeet<'_>) -> Option<Stance> {
        let placements = self.find_both_placements(wish, scratch)?;
        let (position, pair, are_apart) = self.best_pair(wish, &placements)?;
        let station = Station { position, yaw: wish.station.yaw };
        let [left, right] = &pair;
        let room = self.torso.room(&self.constraints.collision, &station);
        let fits = room >= least_room(wish.relaxed)
            && self.torso.hangs_over(
                &self.constraints.collision,
                &station,
                [&left.world_from_sole, &right.world_from_sole],
            );
        fits.then_some(Stance {
            station,
            placements,
            pair: are_apart.then_some(pair),
            is_upright: room == Room::Upright,
        })
    }

    /// Whether the robot above its legs has room at a station.
    pub fn has_room(&self, station: &Station, relaxed: bool) -> bool {
        self.torso.room(&self.constraints.collision, station) >= least_room(relaxed)
    }

    /// How much room there is all the way between two stations, looked at every hand's breadth;
    /// `None` where it is too little.
    pub fn room_between(&self, from: &Station, to: &Station, relaxed: bool) -> Option<Room> {
        let pieces = libm::ceil(from.position.distance(to.position) / ROOM_STEP).max(2.0);
        (1..pieces as usize).try_fold(Room::Upright, |least, piece| {
            let room = self
                .torso
                .room(&self.constraints.collision, &from.toward_share(to, piece as f64 / pieces));
            (room >= least_room(relaxed)).then_some(room.min(least))
        })
    }

    /// Whether a step leads from one of these placements to one of those, by inverse kinematics
    /// [Grey 4.4.2]; only the shortest few of those that the robot may make are tried. True where
    /// no placements are known.
    pub fn has_step_between(&self, from: &[Placed], to: &[Placed]) -> bool {
        let mut steps: heapless::Vec<(f64, [&Placed; 2]), { PLACEMENTS_MAX * PLACEMENTS_MAX }> =
            heapless::Vec::new();
        let possible = self.preparation.possible_steps();
        for from in from {
            let is_possible = |to: &Placed| {
                let [left, right] = if from.limb == 0 { [from, to] } else { [to, from] };
                possible.may_step([&left.world_from_sole, &right.world_from_sole])
            };
            for to in to.iter().filter(|to| to.limb != from.limb && is_possible(to)) {
                let length =
                    from.world_from_sole.translation.distance(to.world_from_sole.translation);
                let _full = steps.push((length, [from, to]));
            }
        }
        steps.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        from.is_empty()
            || steps
                .iter()
                .take(STEPS_TRIED_MAX)
                .any(|(_, step)| (self.is_step)(self.constraints, *step))
    }

    /// Placements of the left foot, then of the right one; `None` where one of them has none.
    fn find_both_placements(
        &self,
        wish: &Wish,
        scratch: &mut ScratchOfFeet<'_>,
    ) -> Option<heapless::Vec<Placed, PLACEMENTS_MAX>> {
        let (left, right) = match scratch {
            ScratchOfFeet::Each([left, right]) => self.threads.both(
                || self.find_placements(wish, 0, left),
                || self.find_placements(wish, 1, right),
            ),
            ScratchOfFeet::Shared(scratch) => {
                let left = self.find_placements(wish, 0, scratch);
                if left.is_empty() {
                    return None;
                }
                (left, self.find_placements(wish, 1, scratch))
            }
        };
        let has_both = !left.is_empty() && !right.is_empty();
        has_both.then(|| left.into_iter().chain(right).collect())
    }

    fn find_placements(
        &self,
        wish: &Wish,
        limb: usize,
        scratch: &mut Scratch,
    ) -> heapless::Vec<Placed, KEPT_MAX> {
        let mut placements = heapless::Vec::new();
        let query = FootQuery {
            limb,
            ideal: wish.station.world_from_ideal_sole(limb, self.feet_apart),
            reach_z: REACH_Z,
            yaw_spread: YAW_SPREAD_MAX.min(self.preparation.possible_steps().turn_max()),
            seed: self.seed,
            name: (wish.name << 1 | limb as u64 | 1 << 60, 0),
            effort: if wish.relaxed { RELAXED_EFFORT } else { EFFORT },
            kept_max: KEPT_MAX,
        };
        query.run((self.constraints, self.surfaces), scratch, &mut |placement| {
            let is_whole = is_whole(&self.constraints.body, limb, &placement.support.polygon);
            match placements.push(Placed {
                limb,
                world_from_sole: placement.world_from_sole,
                is_whole,
            }) {
                Ok(()) => ControlFlow::Continue(true),
                Err(_) => ControlFlow::Break(()),
            }
        });
        placements
    }

    /// The point midway of the pair of soles that suits best, near their ideals, level, toward the
    /// target, this pair, and whether its soles are apart. Soles that meet count only where all do:
    /// one foot goes before the other there. Only soles that R lets both legs reach at once make a
    /// pair.
    fn best_pair(&self, wish: &Wish, placements: &[Placed]) -> Option<(DVec3, Pair, bool)> {
        let mut apart: Option<(f64, DVec3, Pair)> = None;
        let mut any = apart;
        for left in placements.iter().filter(|placed| placed.limb == 0) {
            for right in placements.iter().filter(|placed| placed.limb == 1) {
                let soles = [&left.world_from_sole, &right.world_from_sole];
                let (cost, middle) = self.pair_cost(wish, soles);
                let station = Station { position: middle, yaw: wish.station.yaw };
                if apart.is_some_and(|(least, ..)| least <= cost)
                    || !self.torso.may_reach(self.preparation, &station, soles)
                {
                    continue;
                }
                if any.is_none_or(|(least, ..)| cost < least) {
                    any = Some((cost, middle, [*left, *right]));
                }
                if !self.constraints.collision.feet_hit(soles) {
                    apart = Some((cost, middle, [*left, *right]));
                }
            }
        }
        let are_apart = apart.is_some();
        apart.or(any).map(|(_, middle, pair)| (middle, pair, are_apart))
    }

    fn pair_cost(&self, wish: &Wish, [left, right]: [&Pose; 2]) -> (f64, DVec3) {
        let middle = left.translation.midpoint(right.translation);
        let ideals = [0, 1]
            .map(|limb| wish.station.world_from_ideal_sole(limb, self.feet_apart).translation);
        let aside = left.translation.distance(ideals[0]) + right.translation.distance(ideals[1]);
        let uneven = (left.translation.z - right.translation.z).abs();
        let away = (wish.target_height - middle.z).abs();
        (aside + HEIGHT_DIFFERENCE_COST * uneven + AWAY_FROM_TARGET_COST * away, middle)
    }
}

/// The room that a station must have.
fn least_room(relaxed: bool) -> Room {
    if relaxed { Room::Core } else { Room::Stooped }
}
