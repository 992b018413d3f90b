//! The keys of a plan as one curve, and the soles along it.

use glam::DVec2;
use surefoot_shared_types::Pose;

use crate::base::arena::reserve;
use crate::smooth_path::key::{Key, WeightedKeys};
use crate::smooth_path::layout::{Layout, SearchedPlan, stance_limb};
use crate::smooth_path::spline::{around, end_weights};
use crate::smooth_path::swing_curve::{RollOff, SwingCurve};
use crate::smooth_path::tuning::STANCE_KEYS;
use crate::smooth_path::variant::VARIANTS;

/// The curve through the keys, by the number of the key.
#[derive(Debug)]
pub(crate) struct Curve {
    /// The keys.
    pub keys: Vec<Key>,
    /// Whether the curve ends at a key and begins anew: the robot rests there.
    pub rests: Vec<bool>,
    /// The beginning and the end of each swing along the curve.
    pub swings: Vec<[f64; 2]>,
    /// The variant of each stance.
    pub variants: Vec<u8>,
    /// Distance (m) of the front of each foot's sole from its origin.
    pub sole_fronts: [f64; 2],
}

impl Curve {
    /// Reserves memory for plans of `swings_max` swings.
    pub fn new(swings_max: usize) -> Self {
        let keys_max = STANCE_KEYS * swings_max + 2;
        Self {
            keys: reserve(keys_max),
            rests: reserve(keys_max),
            swings: reserve(swings_max),
            variants: reserve(swings_max),
            sole_fronts: [0.0; 2],
        }
    }

    /// The keys around the place `at` of the curve, in the part of it that contains `within`.
    pub fn around(&self, at: f64, within: f64) -> WeightedKeys<'_> {
        let last = self.keys.len() - 2;
        let interval = self.kept((libm::floor(at) as usize).min(last), within);
        let weights =
            end_weights(at - interval as f64, self.rests[interval], self.rests[interval + 1]);
        WeightedKeys { keys: around(&self.keys, interval), weights }
    }

    /// The interval nearest to `interval` that no rest separates from the place `within`.
    fn kept(&self, mut interval: usize, within: f64) -> usize {
        let home = (libm::floor(within) as usize).min(self.keys.len() - 2);
        while interval < home && (interval + 1..=home).any(|key| self.rests[key]) {
            interval += 1;
        }
        while interval > home && (home + 1..=interval).any(|key| self.rests[key]) {
            interval -= 1;
        }
        interval
    }

    /// The centre of mass at a place of the curve, in the part of it that contains `within`.
    pub fn com(&self, at: f64, within: f64) -> DVec2 {
        self.around(at, within).com()
    }

    /// The swing of a stance.
    pub fn swing(&self, plan: &SearchedPlan<'_>, layout: &Layout, swing: usize) -> SwingCurve {
        let edge = plan.edge(layout.swing_edge(swing));
        let limb = 1 - stance_limb(plan.roadmap.mode(edge).support);
        let [from, to] =
            [edge.from, edge.to].map(|node| plan.roadmap.state(node).world_from_soles[limb]);
        let variant = &VARIANTS[self.variants[swing] as usize];
        let roll_off = RollOff { angle: variant.roll_off, front: self.sole_fronts[limb] };
        SwingCurve::new(from, to, [variant.lift, variant.aside], roll_off)
    }

    /// The poses of both soles at a place of the curve.
    pub fn soles(&self, plan: &SearchedPlan<'_>, layout: &Layout, at: f64) -> [Pose; 2] {
        let Some(last) = layout.swings_len().checked_sub(1) else {
            return plan.roadmap.state(plan.nodes[0]).world_from_soles;
        };
        let swing = ((libm::floor((at - 0.5) / STANCE_KEYS as f64)).max(0.0) as usize).min(last);
        let edge = plan.edge(layout.swing_edge(swing));
        let mut soles = plan.roadmap.state(edge.from).world_from_soles;
        let limb = 1 - stance_limb(plan.roadmap.mode(edge).support);
        soles[limb] = self.swing(plan, layout, swing).pose(self.swing_fraction(swing, at));
        soles
    }

    /// The fraction of a swing at a place of the curve; below 0 before it, above 1 after it.
    pub fn swing_fraction(&self, swing: usize, at: f64) -> f64 {
        let [begin, end] = self.swings[swing];
        (at - begin) / (end - begin)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.keys.capacity() * size_of::<Key>()
            + self.rests.capacity()
            + self.swings.capacity() * size_of::<[f64; 2]>()
            + self.variants.capacity()
    }
}
