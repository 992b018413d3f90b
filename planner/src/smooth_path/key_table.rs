//! Makes the keys of a curve: the centre of mass from one stance to the next, and the heights that
//! the legs allow.

use glam::DVec2;
use surefoot_shared_types::Pose;

use crate::constraints::constraints::Constraints;
use crate::constraints::mode::Mode;
use crate::motion::ids::TransitionId;
use crate::smooth_path::curve::Curve;
use crate::smooth_path::key::Key;
use crate::smooth_path::layout::{Layout, SearchedPlan};
use crate::smooth_path::tuning::{
    BULGE, DOUBLE_SUPPORT_HALF, KEY_MARGIN, REACH_STEP, STANCE_KEYS, SWING_SCAN_STEP,
};
use crate::smooth_path::variant::{VARIANTS, Variant};

/// What keys are made from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct KeySource<'a> {
    pub constraints: &'a Constraints,
    pub plan: SearchedPlan<'a>,
    pub layout: &'a Layout,
    /// Largest share of its reach that a leg uses.
    pub leg_extension: f64,
}

impl KeySource<'_> {
    /// The mode of a swing.
    fn stance(&self, swing: usize) -> Mode {
        self.plan.roadmap.mode(self.plan.edge(self.layout.swing_edge(swing)))
    }

    /// The nodes at both ends of a swing.
    fn nodes(&self, swing: usize) -> [TransitionId; 2] {
        let edge = self.layout.swing_edge(swing);
        [self.plan.nodes[edge], self.plan.nodes[edge + 1]]
    }

    /// The node of the plan at a key where the robot rests.
    pub fn rest_node(&self, key: usize) -> TransitionId {
        if key == 0 {
            return self.plan.nodes[0];
        }
        if key + 1 == self.layout.keys_len() {
            return self.plan.nodes[self.plan.nodes.len() - 1];
        }
        let swing = (key - 1) / STANCE_KEYS;
        self.nodes(swing)[usize::from(!(key - 1).is_multiple_of(STANCE_KEYS))]
    }

    /// Makes the curve of a plan, whose stances have their first variant.
    pub fn begin(&self, curve: &mut Curve) {
        let (swings, keys) = (self.layout.swings_len(), self.layout.keys_len());
        curve.sole_fronts = [0, 1].map(|limb| {
            let corners = self.constraints.robot.soles[limb].polygon.iter();
            corners.map(|corner| corner.x).fold(0.0, f64::max)
        });
        curve.variants.clear();
        curve.variants.resize(swings, 0);
        curve.swings.clear();
        curve.swings.resize(swings, [0.0; 2]);
        curve.rests.clear();
        curve.rests.resize(keys, false);
        curve.keys.clear();
        curve.keys.resize(keys, Key::default());
        for key in [0, keys - 1] {
            curve.rests[key] = true;
            curve.keys[key] = self.node_key(self.rest_node(key));
        }
    }

    /// Makes the keys of a stance, and finds the ends of the swings that they change.
    pub fn make_stance(&self, curve: &mut Curve, swing: usize) {
        let variant = VARIANTS[curve.variants[swing] as usize];
        let keys = self.stance_keys(swing, &variant);
        let first = STANCE_KEYS * swing + 1;
        for (index, key) in (first..).zip(keys) {
            let is_rest = curve.rests[index];
            curve.keys[index] = if is_rest { self.node_key(self.rest_node(index)) } else { key };
        }
    }

    /// Sets the heights of a stance's keys.
    pub fn set_heights(&self, curve: &mut Curve, swing: usize) {
        let first = STANCE_KEYS * swing + 1;
        let variant = VARIANTS[curve.variants[swing] as usize];
        for index in first..first + STANCE_KEYS {
            if curve.rests[index] {
                continue;
            }
            let reached = self.reached_height(curve, index, &variant);
            let planned = curve.keys[index].height;
            let is_planned = variant.follows_plan || reached.is_infinite();
            curve.keys[index].height = if is_planned { reached.min(planned) } else { reached };
        }
    }

    fn node_key(&self, node: TransitionId) -> Key {
        Key::at_node(self.constraints, self.plan.roadmap, node)
    }

    /// The keys of a stance in the plane, with the rotations and heights of the plan.
    fn stance_keys(&self, swing: usize, variant: &Variant) -> [Key; STANCE_KEYS] {
        let mode = self.stance(swing);
        let margin = self.constraints.com_margin(&mode) + KEY_MARGIN;
        let center = mode.region.centroid();
        let toward = |neighbor: DVec2| {
            let aimed = center + variant.overlap * (neighbor - center);
            mode.region.nearest_with_margin(aimed, margin)
        };
        let [before, after] = self.neighbors(swing);
        let [entry, exit] = [toward(before), toward(after)];
        let deeper = (center - 0.5 * (entry + exit)).normalize_or_zero() * BULGE;
        let middle = |fraction: f64| {
            mode.region.nearest_with_margin(entry.lerp(exit, fraction) + deeper, margin)
        };
        let coms = [entry, middle(1.0 / 3.0), middle(2.0 / 3.0), exit];
        let [mut begin, mut end] = self.nodes(swing).map(|node| self.node_key(node));
        if !variant.follows_plan {
            let tilt = 0.5 * (begin.tilt + end.tilt);
            let nodes = [begin.nodes[0], end.nodes[0]];
            for key in [&mut begin, &mut end] {
                (key.tilt, key.nodes) = (tilt, nodes);
            }
        }
        let at = |index: usize| Key {
            com: coms[index],
            ..if index < STANCE_KEYS / 2 { begin } else { end }
        };
        [at(0), at(1), at(2), at(3)]
    }

    /// Where the centre of mass comes from and goes to: the centroids of the stances before and
    /// after, or the ends of the plan.
    fn neighbors(&self, swing: usize) -> [DVec2; 2] {
        let end = |key: usize| self.node_key(self.rest_node(key)).com;
        let stance = |swing: usize| self.stance(swing).region.centroid();
        let before = if swing == 0 { end(0) } else { stance(swing - 1) };
        let is_last = swing + 1 == self.layout.swings_len();
        [before, if is_last { end(self.layout.keys_len() - 1) } else { stance(swing + 1) }]
    }

    /// Finds the ends of a swing: as early and as late as the centre of mass is inside its stance.
    /// The swing has no length where it is never inside.
    pub fn find_swing(&self, curve: &mut Curve, swing: usize) {
        let first = STANCE_KEYS * swing + 1;
        let last = first + STANCE_KEYS - 1;
        let mode = self.stance(swing);
        let margin = self.constraints.com_margin(&mode) + 0.5 * KEY_MARGIN;
        let middle = 0.5 * (first + last) as f64;
        let found = |step: f64, limit: f64| {
            let mut at = middle;
            while (at + step - limit) * step.signum() <= 0.0
                && mode.region.contains(curve.com(at + step, middle), margin)
            {
                at += step;
            }
            at
        };
        let outward = 0.5 - DOUBLE_SUPPORT_HALF;
        let begin = if curve.rests[first] {
            first as f64
        } else {
            found(-SWING_SCAN_STEP, first as f64 - outward)
        };
        let end = if curve.rests[last] {
            last as f64
        } else {
            found(SWING_SCAN_STEP, last as f64 + outward)
        };
        curve.swings[swing] = [begin, end];
    }

    /// The greatest height of the root (m) that the legs allow at all places that a key influences,
    /// and at the variant's level keys beyond; infinite where no leg reaches.
    fn reached_height(&self, curve: &Curve, key: usize, variant: &Variant) -> f64 {
        let (at, reach) = (key as f64, 2.0 + variant.level_keys);
        let extension = self.leg_extension.min(variant.leg_extension);
        let last = (curve.keys.len() - 1) as f64;
        let samples = (2.0 * reach / REACH_STEP) as usize;
        let places = (0..=samples).map(|index| at - reach + REACH_STEP * index as f64);
        places
            .filter(|place| (0.0..=last).contains(place))
            .filter_map(|place| self.height_at(curve, place, extension))
            .fold(f64::INFINITY, f64::min)
    }

    /// The greatest height of the root at a place of the curve, m.
    fn height_at(&self, curve: &Curve, place: f64, extension: f64) -> Option<f64> {
        let robot = &self.constraints.robot;
        let around = curve.around(place, place);
        let rotation = around.rotation();
        let position = around.com() - (rotation * robot.standing_com).truncate();
        let soles = curve.soles(&self.plan, self.layout, place);
        robot.root_height(&Pose::from_parts(position.extend(0.0), rotation), &soles, [extension; 2])
    }
}
