//! The zero-moment point of a motion keeps its distance to the edge of the support, as the
//! controller demands it: on the plane at the mean height of the soles, inside the hull of all
//! soles' supports.
//!
//! The forces of the contacts are known to exist without it. It is stricter where two soles stand
//! at different heights, and where a centre of pressure may come nearer to the edge of a sole.

use glam::{DVec2, DVec3};
use surefoot_shared_types::message::Contact;

use crate::timing::ground::Ground;
use crate::timing::limits::Level;
use crate::timing::path_dynamics::{Affine, PathDynamics};
use crate::timing::rate_set::RateSet;
use crate::timing::tuning::{
    ZERO_MOMENT_BARE_SHARE, ZERO_MOMENT_DEPTH_SHARE, ZERO_MOMENT_PARTIAL_RESERVE,
    ZERO_MOMENT_RESERVE, ZERO_MOMENT_SHIFT_MIN,
};

/// The ground under the contacts of a span, and how far inside the zero-moment point stays.
#[derive(Debug)]
pub(crate) struct ContactGround {
    ground: Ground,
    /// The margin that the controller demands, m.
    checked: f64,
    /// Distance beyond that margin, m.
    reserve: f64,
}

/// The part of the ground on which the zero-moment point stays.
#[derive(Debug)]
pub(crate) struct ZeroMomentRegion<'a> {
    ground: &'a Ground,
    /// Distance to the edge of the ground's region, m.
    margin: f64,
}

impl ContactGround {
    /// The ground under these contacts. `checked` is the margin (m) that the controller demands,
    /// `is_partial`: whether the world supports only a part of a sole.
    pub fn new(contacts: &[Contact], checked: f64, is_partial: bool) -> Self {
        let ground = Ground::under(contacts);
        let depth = ground.region.margin(ground.region.centroid()).max(0.0);
        let wanted = if is_partial { ZERO_MOMENT_PARTIAL_RESERVE } else { ZERO_MOMENT_RESERVE };
        Self { ground, checked, reserve: wanted.min(ZERO_MOMENT_DEPTH_SHARE * depth) }
    }

    /// The region of a level, `extra` (m) further inside.
    pub fn region(&self, level: Level, extra: f64) -> ZeroMomentRegion<'_> {
        let share = match level {
            Level::Full | Level::NarrowSole => 1.0,
            Level::Bare | Level::Unsupported => ZERO_MOMENT_BARE_SHARE,
        };
        let margin = self.checked + share * self.reserve + extra;
        ZeroMomentRegion { ground: &self.ground, margin }
    }
}

impl ZeroMomentRegion<'_> {
    /// Keeps the rates whose zero-moment point is inside.
    pub fn clip(&self, dynamics: &PathDynamics, rates: &mut RateSet) {
        for (excess, spare) in self.excesses(dynamics) {
            rates.clip(excess.slope, spare);
        }
    }

    /// Whether the zero-moment point of a motion is inside. `at_rest` gives the dynamics of its
    /// configuration at rest.
    pub fn holds(&self, moving: &PathDynamics, at_rest: impl FnOnce() -> PathDynamics) -> bool {
        let is_beyond = |(excess, _): &(Affine, f64)| excess.constant > 0.0;
        if !self.excesses(moving).any(|excess| is_beyond(&excess)) {
            return true;
        }
        let rest = at_rest();
        self.excesses(moving)
            .zip(self.excesses(&rest))
            .all(|((moving, _), (rest, spare))| moving.constant - rest.constant <= spare)
    }

    /// For every side of the region: how far the zero-moment point is beyond it, as an affine
    /// function of the rates that is positive beyond; and how much of that a motion may add to the
    /// configuration at rest, which is positive even where that is beyond.
    fn excesses(&self, dynamics: &PathDynamics) -> impl Iterator<Item = (Affine, f64)> {
        let origin = DVec3::new(0.0, 0.0, self.ground.height);
        let [press, about_x, about_y] =
            [2, 3, 4].map(|coordinate| dynamics.wrench(coordinate, origin));
        self.ground.region.sides().iter().map(move |side| {
            // The point is (-m_y, m_x) / f_z; inside, its depth is at least the margin.
            let limit = side.offset + self.margin;
            let excess = |of: &dyn Fn(&Affine) -> f64| {
                limit * of(&press) - side.normal.dot(DVec2::new(-of(&about_y), of(&about_x)))
            };
            let excess = Affine {
                slope: DVec2::new(excess(&|a| a.slope.x), excess(&|a| a.slope.y)),
                constant: excess(&|a| a.constant),
            };
            (excess, (-excess.constant).max(ZERO_MOMENT_SHIFT_MIN * press.constant))
        })
    }
}
