//! Growing a branch of Gamma_P station by station toward a target.

use std::f64::consts::PI;

use super::sampling::SIDES;
use super::stance::{Context, ScratchOfFeet, Stance, Wish};
use super::station::Station;
use super::torso::Room;

/// Strides that are tried, as multiples of the station spacing, and how far each also leads aside,
/// m: farther ones lead across gaps.
const STRIDES: [(f64, f64); 7] =
    [(1.0, 0.0), (1.8, 0.0), (2.6, 0.0), (1.0, 0.06), (1.0, -0.06), (1.0, 0.12), (1.0, -0.12)];
/// How many of them are tried where the robot does not step sideways: what is passed sideways
/// leaves little room before and behind.
const STRIDES_AHEAD: usize = 3;
/// The share of a stride by which a station must come nearer to the target.
const PROGRESS_MIN: f64 = 0.25;
/// Within this many station spacings of the target the branch may join it.
const JOINING_SPACINGS: f64 = 1.3;
/// The largest difference in height between two stations as shares of a leg's reach, C_S demanded
/// and not: what one step climbs.
const CLIMB_MAX: [f64; 2] = [0.4, 0.55];
/// The largest turn with which a branch joins, rad.
const JOINING_TURN_MAX: f64 = 0.5;
/// A turn in place may move the station by this much aside, m.
const TURN_DRIFT_MAX: f64 = 0.2;

/// A branch on its way.
#[derive(Debug, Clone, Copy)]
pub struct Extension {
    /// Where it leads.
    pub target: Station,
    /// Whether it will be walked from the target to its root.
    pub backward: bool,
    /// How far off the way it is walked on the robot faces, rad.
    pub facing: f64,
    /// Whether it ends on the target itself, heading and all; else anywhere near it.
    pub joins: bool,
    /// Whether C_N alone is enough.
    pub relaxed: bool,
    /// Distance between stations, m.
    pub spacing: f64,
}

/// How a branch may go on from its tip.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate during the search")]
pub enum Step {
    /// To a new tip, if a step leads there: that is still to be asked.
    Reached {
        /// The new tip.
        stance: Stance,
        /// The stride that leads to it; longer ones are to be tried where no step does.
        stride: usize,
    },
    /// It has arrived.
    Arrived {
        /// Whether the upright robot has room on the last piece of the way.
        is_upright: bool,
    },
    /// It cannot go on.
    Blocked,
}

impl Extension {
    /// Looks for the next station after the tip, by strides from `first` on. `name` is the query's
    /// in the random stream.
    pub fn step(
        &self,
        context: &Context<'_>,
        tip: &Station,
        first: usize,
        name: u64,
        scratch: &mut ScratchOfFeet<'_>,
    ) -> Step {
        if first == 0
            && let Some(room) = self.room_to_arrive(context, tip)
        {
            return Step::Arrived { is_upright: room == Room::Upright };
        }
        let strides =
            if SIDES.contains(&self.facing) { &STRIDES[..] } else { &STRIDES[..STRIDES_AHEAD] };
        for (index, &(stride, aside)) in strides.iter().enumerate().skip(first) {
            let wished = self.wished(tip, stride, aside);
            let turns_in_place = wished.position == tip.position;
            if index > 0 && (turns_in_place || tip.way_to(&self.target).length() < self.spacing) {
                break;
            }
            let target_height = self.target.position.z;
            let wish = Wish {
                station: wished,
                target_height,
                relaxed: self.relaxed,
                name: name << 3 | index as u64,
            };
            let Some(stance) = context.stand(&wish, scratch) else { continue };
            let advances = if turns_in_place {
                tip.way_to(&stance.station).length() <= TURN_DRIFT_MAX
            } else {
                let nearer = tip.way_to(&self.target).length()
                    - stance.station.way_to(&self.target).length();
                nearer >= PROGRESS_MIN * self.spacing.min(tip.way_to(&wished).length())
            };
            if !advances || !self.can_climb(context, tip, &stance.station) {
                continue;
            }
            if let Some(room) = context.room_between(tip, &stance.station, self.relaxed) {
                let is_upright = stance.is_upright && room == Room::Upright;
                return Step::Reached { stance: Stance { is_upright, ..stance }, stride: index };
            }
        }
        Step::Blocked
    }

    /// How many stations a branch still needs where nothing is in its way.
    pub fn stations_left(&self, tip: &Station) -> usize {
        libm::ceil(tip.way_to(&self.target).length() / self.spacing - JOINING_SPACINGS).max(0.0)
            as usize
    }

    /// A stride on from the tip, and aside of the way there.
    fn wished(&self, tip: &Station, stride: f64, aside: f64) -> Station {
        let facing = if self.backward { PI + self.facing } else { self.facing };
        let on = tip.toward(&self.target, stride * self.spacing, facing);
        let way = tip.way_to(&on);
        Station {
            position: on.position + (aside * way.perp().normalize_or_zero()).extend(0.0),
            ..on
        }
    }

    /// Whether a step may lead from one station to the next, up or down.
    fn can_climb(&self, context: &Context<'_>, from: &Station, to: &Station) -> bool {
        (to.position.z - from.position.z).abs()
            <= CLIMB_MAX[usize::from(self.relaxed)] * context.constraints.body.shorter_reach()
    }

    /// How much room there is on the last piece of the way; `None` where the branch has not
    /// arrived.
    fn room_to_arrive(&self, context: &Context<'_>, tip: &Station) -> Option<Room> {
        let near = tip.way_to(&self.target).length() <= JOINING_SPACINGS * self.spacing;
        let turn = surefoot_shared_types::spatial::wrap_angle(self.target.yaw - tip.yaw);
        let may_join =
            || turn.abs() <= JOINING_TURN_MAX && self.can_climb(context, tip, &self.target);
        match (near, self.joins) {
            (true, false) => Some(Room::Upright),
            (true, true) if may_join() => context.room_between(tip, &self.target, self.relaxed),
            _ => None,
        }
    }
}
