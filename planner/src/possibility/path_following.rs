//! The first branches of a search: the straight line to the goal, and the coarse path.

use glam::DVec3;

use crate::possibility::branch::{BranchEnd, BranchKind};
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::route_run::{Activity, Join};
use crate::possibility::route_search::RouteSearch;
use crate::possibility::tuning::LEG_OVERSHOOT;

impl RouteSearch {
    /// Begins a straight branch to the goal from the vertex nearest to it.
    pub(crate) fn connect_directly(&mut self) {
        self.run.activity = Activity::Growing;
        self.clear_branches();
        if self.traversed.is_empty() {
            self.run.path.restart();
        } else {
            self.run.path.begin_after(&self.forest.trees[0]);
        }
        let goal = self.run.ends[1].pose;
        let tip = self.forest.trees[0].nearest(|pose| pose.distance(&goal));
        self.join(Join { tree: 0, tip, other: 0, heading_offset: self.run.heading_offset });
    }

    /// Sets a path from start to goal that the tree of the start follows: the ends of its straight
    /// legs after the start, m. Branches that have not ended are dropped, and a search that is
    /// exhausted goes on.
    pub fn follow(&mut self, ends: &[DVec3]) {
        self.run.path.set(ends);
        self.run.activity = Activity::Growing;
        self.clear_branches();
    }

    /// Begins a branch along the next leg of the coarse path. Returns `false` if there is none, or
    /// a detour is searched.
    pub(crate) fn follow_next_leg(&mut self) -> bool {
        let Some((tip, position, is_last)) = self.run.path.next_leg() else { return false };
        if self.detour.between.is_some() {
            return false;
        }
        let from = self.forest.trees[0][tip as usize];
        // Branches end before their target; the next leg shall begin at the end of this one.
        let overshoot = if is_last { 0.0 } else { LEG_OVERSHOOT * self.spacing() };
        let beyond = overshoot * (position - from.pose.position).with_z(0.0).normalize_or_zero();
        let target = MidFeetPose { position: position + beyond, yaw: 0.0 };
        let extension = self.extension(0, target, self.run.heading_offset, false);
        self.grow(BranchKind::Follow { tip }, extension, from);
        true
    }

    /// A branch along a leg has ended at a vertex. After the last leg the goal is joined.
    pub(crate) fn end_leg(&mut self, end: Option<BranchEnd>, tip: u32) {
        let is_reached = matches!(end, Some(BranchEnd::Reached { .. }));
        if self.run.path.end_leg(is_reached, tip) {
            let heading_offset = self.run.heading_offset;
            // The list holds one join for each branch, and this one was alone.
            let _ = self.joins.next.push(Join { tree: 0, tip, other: 0, heading_offset });
        }
    }
}
