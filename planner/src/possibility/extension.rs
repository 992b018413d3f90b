//! Extension of a branch of Gamma_P, vertex by vertex, toward a target.

use std::f64::consts::PI;

use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::upper_body::UpperBodyFit;
use crate::possibility::vertex_candidates::{
    FootScratch, StageContext, VertexCandidate, VertexQuery,
};
use crate::possibility::vertex_sampling::SIDES;

/// Strides that are tried, as multiples of the vertex spacing, each with its lateral offset, m.
/// Longer strides lead across gaps.
const STRIDES: [(f64, f64); 7] =
    [(1.0, 0.0), (1.8, 0.0), (2.6, 0.0), (1.0, 0.06), (1.0, -0.06), (1.0, 0.12), (1.0, -0.12)];
/// Number of them that are tried without sidestepping: narrow passages leave little clearance in
/// front of the robot and behind it.
const STRIDES_AHEAD: usize = 3;
/// The share of a stride by which a vertex must come nearer to the target.
const PROGRESS_MIN: f64 = 0.25;
/// Within this many vertex spacings of the target the branch may join it.
const JOINING_SPACINGS: f64 = 1.3;
/// The largest difference in height between two vertices as shares of a leg's reach, C_S demanded
/// and not: what one step climbs.
const CLIMB_MAX: [f64; 2] = [0.4, 0.55];
/// The largest turn with which a branch joins, rad.
const JOINING_TURN_MAX: f64 = 0.5;
/// A turn in place may move the vertex by this much lateral, m.
const TURN_DRIFT_MAX: f64 = 0.2;

/// How a branch is extended toward its target.
#[derive(Debug, Clone, Copy)]
pub struct Extension {
    /// Where it leads.
    pub target: MidFeetPose,
    /// Whether it will be walked from the target to its root.
    pub backward: bool,
    /// Heading of the robot relative to the walking direction, rad.
    pub heading_offset: f64,
    /// Whether it ends on the target itself, heading and all; else anywhere near it.
    pub joins: bool,
    /// Whether C_N alone is enough.
    pub relaxed: bool,
    /// Distance between vertices, m.
    pub spacing: f64,
}

/// Result of one extension (RRT-Connect).
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate during the search")]
pub enum Extend {
    /// A new tip, on the condition that a step leads to it, which the caller tests.
    Advanced {
        /// The new tip.
        candidate: VertexCandidate,
        /// Index of the stride that leads to it. The caller tries longer ones if no step does.
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
    /// Looks for the next vertex after the tip, by strides from `first` on. `name` is the query's
    /// in the random stream.
    pub fn extend(
        &self,
        context: &StageContext<'_>,
        tip: &MidFeetPose,
        first: usize,
        name: u64,
        scratch: &mut FootScratch<'_>,
    ) -> Extend {
        if first == 0
            && let Some(fit) = self.fit_to_target(context, tip)
        {
            return Extend::Reached { is_upright: fit == UpperBodyFit::Upright };
        }
        let strides = if SIDES.contains(&self.heading_offset) {
            &STRIDES[..]
        } else {
            &STRIDES[..STRIDES_AHEAD]
        };
        for (index, &(stride, lateral)) in strides.iter().enumerate().skip(first) {
            let desired = self.desired_pose(tip, stride, lateral);
            let turns_in_place = desired.position == tip.position;
            if index > 0
                && (turns_in_place
                    || tip.horizontal_offset_to(&self.target).length() < self.spacing)
            {
                break;
            }
            let target_height = self.target.position.z;
            let query = VertexQuery {
                pose: desired,
                target_height,
                relaxed: self.relaxed,
                name: name << 3 | index as u64,
            };
            let Some(candidate) = context.find_candidate(&query, scratch) else { continue };
            let advances = if turns_in_place {
                tip.horizontal_offset_to(&candidate.pose).length() <= TURN_DRIFT_MAX
            } else {
                let nearer = tip.horizontal_offset_to(&self.target).length()
                    - candidate.pose.horizontal_offset_to(&self.target).length();
                nearer
                    >= PROGRESS_MIN * self.spacing.min(tip.horizontal_offset_to(&desired).length())
            };
            if !advances || !self.may_climb(context, tip, &candidate.pose) {
                continue;
            }
            if let Some(fit) = context.fit_between(tip, &candidate.pose, self.relaxed) {
                let is_upright = candidate.is_upright && fit == UpperBodyFit::Upright;
                return Extend::Advanced {
                    candidate: VertexCandidate { is_upright, ..candidate },
                    stride: index,
                };
            }
        }
        Extend::Trapped
    }

    /// Number of vertices that a branch still needs on a free path to its target.
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
        let on = tip.step_toward(&self.target, stride * self.spacing, heading_offset);
        let offset = tip.horizontal_offset_to(&on);
        MidFeetPose {
            position: on.position + (lateral * offset.perp().normalize_or_zero()).extend(0.0),
            ..on
        }
    }

    /// Whether the height difference between two poses is within one step.
    fn may_climb(&self, context: &StageContext<'_>, from: &MidFeetPose, to: &MidFeetPose) -> bool {
        (to.position.z - from.position.z).abs()
            <= CLIMB_MAX[usize::from(self.relaxed)] * context.constraints.robot.shorter_reach()
    }

    /// Fit of the upper body between the tip and the target; `None` if the target is not reached.
    fn fit_to_target(&self, context: &StageContext<'_>, tip: &MidFeetPose) -> Option<UpperBodyFit> {
        let near =
            tip.horizontal_offset_to(&self.target).length() <= JOINING_SPACINGS * self.spacing;
        let turn = surefoot_shared_types::base::spatial::wrap_angle(self.target.yaw - tip.yaw);
        let may_join =
            || turn.abs() <= JOINING_TURN_MAX && self.may_climb(context, tip, &self.target);
        match (near, self.joins) {
            (true, false) => Some(UpperBodyFit::Upright),
            (true, true) if may_join() => context.fit_between(tip, &self.target, self.relaxed),
            _ => None,
        }
    }
}
