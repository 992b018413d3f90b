//! Extension of a branch of Gamma_P by one vertex toward a target (RRT-Connect, Kuffner and LaValle
//! 2000).

use std::f64::consts::PI;

use surefoot_shared_types::base::spatial::wrap_angle;

use crate::possibility::leaning::Leaning;
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::root_vertex::{PostureId, RootVertex, UPRIGHT};
use crate::possibility::route_condition::RouteCondition;
use crate::possibility::tuning::{
    EDGE_CLIMB_MAX, EXTENSION_STRIDES, JOINING_SPACINGS, JOINING_TURN_MAX, PROGRESS_MIN,
    STRIDES_AHEAD, TURN_DRIFT_MAX,
};
use crate::possibility::upper_body::UpperBodyFit;
use crate::possibility::vertex_candidates::{
    FootScratch, StageContext, VertexCandidate, VertexQuery,
};
use crate::possibility::vertex_sampling::SIDES;

/// How a branch is extended toward its target.
#[derive(Debug, Clone, Copy)]
pub struct Extension {
    /// The target pose.
    pub target: MidFeetPose,
    /// The root posture there, or that toward which a branch leans.
    pub target_posture: PostureId,
    /// Whether the branch is walked from the target to its root.
    pub backward: bool,
    /// Heading of the robot relative to the walking direction, rad.
    pub heading_offset: f64,
    /// Whether it ends at the target pose, heading included; else anywhere near its position.
    pub joins: bool,
    /// What vertices and edges must satisfy.
    pub condition: RouteCondition,
    /// Distance between vertices, m.
    pub spacing: f64,
}

/// Result of one extension.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate during the search")]
pub enum Extend {
    /// A new tip, provided that a step leads to it, which the caller tests.
    Advanced {
        /// The new tip.
        candidate: VertexCandidate,
        /// Index of the stride that leads to it. If no step does, the caller tries the next ones.
        stride: usize,
    },
    /// The target is reached.
    Reached {
        /// Whether the upright robot fits between the tip and the target.
        is_upright: bool,
    },
    /// No stride leads further.
    Trapped,
}

impl Extension {
    /// Finds the next vertex after the tip, by strides from index `first` on. `name` names the
    /// query in the random stream.
    pub fn extend(
        &self,
        context: &StageContext<'_>,
        tip: RootVertex,
        first: usize,
        name: u64,
        scratch: &mut FootScratch<'_>,
    ) -> Extend {
        if first == 0
            && let Some(is_upright) = self.edge_to_target(context, tip)
        {
            return Extend::Reached { is_upright };
        }
        let RootVertex { pose: ref at, .. } = tip;
        for (index, &(stride, lateral)) in self.strides().iter().enumerate().skip(first) {
            let desired = self.desired_pose(at, stride, lateral);
            let turns_in_place = desired.position == at.position;
            if index > 0
                && (turns_in_place || at.horizontal_offset_to(&self.target).length() < self.spacing)
            {
                break;
            }
            let query = VertexQuery {
                pose: desired,
                target_height: self.target.position.z,
                condition: self.condition,
                name: name << 3 | index as u64,
            };
            let Some(candidate) = context.find_candidate(&query, scratch) else { continue };
            if !self.advances(at, &desired, &candidate.pose)
                || !self.may_climb(context, at, &candidate.pose)
            {
                continue;
            }
            if let Some(candidate) = self.with_edge(context, tip, candidate, query.name) {
                return Extend::Advanced { candidate, stride: index };
            }
        }
        Extend::Trapped
    }

    /// The candidate with its root posture, if an edge leads to it from the tip.
    fn with_edge(
        &self,
        context: &StageContext<'_>,
        tip: RootVertex,
        candidate: VertexCandidate,
        name: u64,
    ) -> Option<VertexCandidate> {
        if self.condition == RouteCondition::Leaning {
            let to = (&candidate.pose, candidate.pair.as_ref());
            let posture = Leaning(context).lean_to(tip, to, self.target_posture, name)?;
            let is_upright = [tip.posture, posture] == [UPRIGHT; 2];
            return Some(VertexCandidate { is_upright, posture, ..candidate });
        }
        let fit = context.fit_between(&tip.pose, &candidate.pose, self.condition)?;
        let is_upright = candidate.is_upright && fit == UpperBodyFit::Upright;
        Some(VertexCandidate { is_upright, ..candidate })
    }

    /// The strides that are tried: lateral ones only if the robot sidesteps.
    fn strides(&self) -> &'static [(f64, f64)] {
        if SIDES.contains(&self.heading_offset) {
            &EXTENSION_STRIDES
        } else {
            &EXTENSION_STRIDES[..STRIDES_AHEAD]
        }
    }

    /// Whether a candidate for a desired pose is enough progress from the tip: nearer to the
    /// target, or about at the tip if the robot turns in place.
    fn advances(&self, tip: &MidFeetPose, desired: &MidFeetPose, found: &MidFeetPose) -> bool {
        if desired.position == tip.position {
            return tip.horizontal_offset_to(found).length() <= TURN_DRIFT_MAX;
        }
        let nearer = tip.horizontal_offset_to(&self.target).length()
            - found.horizontal_offset_to(&self.target).length();
        nearer >= PROGRESS_MIN * self.spacing.min(tip.horizontal_offset_to(desired).length())
    }

    /// Number of vertices from the tip to the target on a straight free path.
    pub fn vertices_left(&self, tip: &MidFeetPose) -> usize {
        libm::ceil(
            tip.horizontal_offset_to(&self.target).length() / self.spacing - JOINING_SPACINGS,
        )
        .max(0.0) as usize
    }

    /// The pose one stride ahead of the tip, with a lateral offset.
    fn desired_pose(&self, tip: &MidFeetPose, stride: f64, lateral: f64) -> MidFeetPose {
        let heading_offset =
            if self.backward { PI + self.heading_offset } else { self.heading_offset };
        let ahead = tip.step_toward(&self.target, stride * self.spacing, heading_offset);
        let offset = tip.horizontal_offset_to(&ahead);
        MidFeetPose {
            position: ahead.position + (lateral * offset.perp().normalize_or_zero()).extend(0.0),
            ..ahead
        }
    }

    /// Whether the height difference between two poses is within one step.
    fn may_climb(&self, context: &StageContext<'_>, from: &MidFeetPose, to: &MidFeetPose) -> bool {
        let climb_max = match self.condition {
            RouteCondition::UpperBody => {
                EDGE_CLIMB_MAX[0] * context.constraints.robot.shorter_reach()
            }
            RouteCondition::Root | RouteCondition::Leaning => {
                EDGE_CLIMB_MAX[1] * context.constraints.robot.shorter_reach()
            }
            RouteCondition::Necessary => context.preparation.step_limits().reach(),
        };
        (to.position.z - from.position.z).abs() <= climb_max
    }

    /// Whether the upright robot fits between the tip and the target; `None` if the target is not
    /// reached.
    fn edge_to_target(&self, context: &StageContext<'_>, tip: RootVertex) -> Option<bool> {
        let RootVertex { pose: ref at, .. } = tip;
        let is_near =
            at.horizontal_offset_to(&self.target).length() <= JOINING_SPACINGS * self.spacing;
        let turn = wrap_angle(self.target.yaw - at.yaw);
        let may_join =
            || turn.abs() <= JOINING_TURN_MAX && self.may_climb(context, at, &self.target);
        match (is_near, self.joins) {
            (true, false) => Some(true),
            (true, true) if may_join() => self.edge_between(context, tip),
            _ => None,
        }
    }

    /// Whether the upright robot fits on the edge from the tip to the target; `None` if there is no
    /// edge.
    fn edge_between(&self, context: &StageContext<'_>, tip: RootVertex) -> Option<bool> {
        if self.condition == RouteCondition::Leaning {
            let target = RootVertex { pose: self.target, posture: self.target_posture };
            let is_upright = [tip.posture, target.posture] == [UPRIGHT; 2];
            return Leaning(context).may_lean_between(tip, target).then_some(is_upright);
        }
        let fit = context.fit_between(&tip.pose, &self.target, self.condition)?;
        Some(fit == UpperBodyFit::Upright)
    }
}
