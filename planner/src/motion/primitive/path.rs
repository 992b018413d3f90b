//! The primitive trajectories as functions of a parameter [Grey 4.4.5]. Between two placements the
//! swing foot always passes its neutral place beside the stance foot, so that each half of a swing
//! depends on one pair of placements only:
//!
//! ```text
//! place   neutral over a, up as high as b asks, across, down, onto b       the root moves while the foot goes across
//! swing   a place backwards from the old placement, then a place to the new one
//! shift   from the configuration over b to the one over a, both feet standing
//! ```

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::spatial::{interpolate, rotation_about, yaw_of};

use super::gait::Gait;
use super::stand::{Stand, side_of};
use crate::body::{Body, Configuration};
use crate::constraint::Rejection;
use crate::motion::foothold::Foothold;
use crate::motion::track::State;
use crate::motion::transition::mean_yaw;
use crate::posture::{Posture, settle};

/// Stretches of a place.
pub const STRETCHES: usize = 4;
/// The stretch in which the root moves and the foot goes across.
pub const ACROSS: usize = 1;
/// The stretch that ends on the placement.
pub const LANDING: usize = 3;

/// The half of a swing that ends on a placement.
#[derive(Debug, Clone)]
pub struct Place {
    /// The foot that swings.
    pub limb: usize,
    /// The robot on its stance foot alone, the other beside it.
    pub neutral: State,
    /// The robot with its foot on the placement, all weight still on the stance foot.
    pub placed: State,
    /// The swing sole at the ends of the stretches.
    knots: [Pose; STRETCHES + 1],
}

impl Place {
    /// The place over `stance` onto `other`.
    ///
    /// # Errors
    /// The legs do not reach, or the centre of mass does not come to rest over the stance foot.
    pub fn new(
        body: &Body,
        gait: &Gait,
        stance: &Foothold,
        other: &Foothold,
    ) -> Result<Self, Rejection> {
        let stance_stand = Stand::of(&body.legs[stance.limb], &stance.world_from_sole);
        let neutral_sole = neutral_sole(gait, &stance_stand, other.limb);
        let neutral = settled(body, gait, stance, &neutral_sole, stance_stand.yaw)?;
        Self::beside(neutral, body, gait, stance, other)
    }

    /// The place over the same stance foot onto another placement.
    ///
    /// # Errors
    /// As [`Place::new`].
    pub fn onto(
        &self,
        body: &Body,
        gait: &Gait,
        stance: &Foothold,
        other: &Foothold,
    ) -> Result<Self, Rejection> {
        Self::beside(self.neutral, body, gait, stance, other)
    }

    fn beside(
        neutral: State,
        body: &Body,
        gait: &Gait,
        stance: &Foothold,
        other: &Foothold,
    ) -> Result<Self, Rejection> {
        let limb = other.limb;
        let leg = &body.legs[limb];
        let stance_stand = Stand::of(&body.legs[stance.limb], &stance.world_from_sole);
        let stand = Stand::of(leg, &other.world_from_sole);
        let rise = (stand.origin.z - stance_stand.origin.z).max(0.0);
        let neutral_sole = neutral_sole(gait, &stance_stand, limb);
        let lifted = shifted(
            &other.world_from_sole,
            other.world_from_sole.rotation * (DVec3::Z * gait.lift),
        );
        let top = stance_stand.origin.z + gait.lift + rise;
        let lifted_height = Stand::of(leg, &lifted).origin.z;
        let knots = [
            neutral_sole,
            shifted(&neutral_sole, DVec3::Z * rise),
            shifted(&lifted, DVec3::Z * (top - lifted_height).max(0.0)),
            lifted,
            other.world_from_sole,
        ];
        let placed = configuration(body, gait, stance, other)?;
        Ok(Self { limb, neutral, placed, knots })
    }

    /// How far the swing sole travels in a stretch, m.
    pub fn length(&self, stretch: usize) -> f64 {
        self.knots[stretch].translation.distance(self.knots[stretch + 1].translation)
    }

    /// The state a share `t` of the way along a stretch, legs not yet brought to their soles;
    /// `seed` gives their branch.
    pub fn at(&self, stretch: usize, t: f64, seed: &State) -> State {
        let mut state = *seed;
        let moved = match stretch {
            0 => 0.0,
            ACROSS => t,
            _ => 1.0,
        };
        let [from, to] =
            [&self.neutral, &self.placed].map(|end| &end.configuration.world_from_root);
        state.configuration.world_from_root = interpolate(from, to, moved);
        state.world_from_soles[self.limb] =
            interpolate(&self.knots[stretch], &self.knots[stretch + 1], t);
        state
    }
}

/// Where the swing sole is beside the stance foot.
fn neutral_sole(gait: &Gait, stance: &Stand, limb: usize) -> Pose {
    let beside = stance.world_from_stand() * DVec3::new(0.0, side_of(limb) * gait.width, gait.lift);
    Pose::from_parts(beside, rotation_about(DVec3::Z, stance.yaw))
}

/// The primitive configuration of a transition: all weight on `stance`, `other` in touch. It
/// depends on nothing but the two placements.
///
/// # Errors
/// The legs do not reach, or the centre of mass does not come to rest over the stance foot.
pub fn configuration(
    body: &Body,
    gait: &Gait,
    stance: &Foothold,
    other: &Foothold,
) -> Result<State, Rejection> {
    let yaw = mean_yaw(stance.world_from_sole.rotation, other.world_from_sole.rotation);
    settled(body, gait, stance, &other.world_from_sole, yaw)
}

fn settled(
    body: &Body,
    gait: &Gait,
    stance: &Foothold,
    other_sole: &Pose,
    yaw: f64,
) -> Result<State, Rejection> {
    let mut world_from_soles = [*other_sole; 2];
    world_from_soles[stance.limb] = stance.world_from_sole;
    let side = side_of(stance.limb);
    let world_from_root =
        rotation_about(DVec3::Z, yaw) * rotation_about(DVec3::X, -side * gait.roll);
    let inward = rotation_about(DVec3::Z, yaw_of(stance.world_from_sole.rotation))
        * (-side * gait.lean * DVec3::Y);
    let posture = Posture {
        world_from_root,
        reach_share: gait.reach_share,
        com: stance.region.centroid() + inward.truncate(),
    };
    let (configuration, _) = settle(body, &world_from_soles, &posture, body.standing_q)?;
    Ok(State { configuration, world_from_soles })
}

/// The state a share `t` of the way from one primitive configuration to its twin, legs not yet
/// brought to their soles.
pub fn shift_at(from: &Configuration, to: &Configuration, t: f64, seed: &State) -> State {
    let mut state = *seed;
    state.configuration.world_from_root =
        interpolate(&from.world_from_root, &to.world_from_root, t);
    state
}

fn shifted(pose: &Pose, by: DVec3) -> Pose {
    Pose::from_parts(pose.translation + by, pose.rotation)
}
