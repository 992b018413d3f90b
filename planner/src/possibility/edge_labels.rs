//! The labels of equation 3.1 on Gamma_P [Grey 3.1, 4.1.1].
//!
//! A vertex has a pair of placements, and an edge leads from one pair to the next with one step of
//! each foot. An edge is possible if C_S holds for both pairs and the step between them; primitives
//! then solve it. All edges of a vertex share its pair, so two possible edges always connect. A
//! vertex whose pair fails C_S is indeterminate, and so are its edges. Poses that fail C_N never
//! become vertices.

use crate::constraints::foothold::{FootPair, FootPlacement};
use crate::possibility::tree::Vertex;
use crate::possibility::vertex_candidates::StageContext;
use crate::preparation::sufficient_pair;

/// Label of an edge of Gamma_P.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Label {
    /// C_N holds, C_S does not.
    #[default]
    Indeterminate,
    /// C_S holds: primitives solve the edge.
    Primitive {
        /// Which feet may step first.
        leads: [bool; 2],
    },
    /// Stage M has solved the edge.
    Traversed,
}

impl Label {
    /// Whether the edge is possible or traversed.
    pub fn is_possible(self) -> bool {
        self != Self::Indeterminate
    }
}

impl StageContext<'_> {
    /// The pair of a vertex if C_S holds for it; the result is kept in the vertex.
    pub(crate) fn pair_of(&self, vertex: &mut Vertex) -> Option<FootPair> {
        let pair = vertex.pair?;
        let has_primitives =
            *vertex.has_primitives.get_or_insert_with(|| self.is_sufficient([&pair[0], &pair[1]]));
        has_primitives.then_some(pair)
    }

    /// The label of the edge between two pairs for which C_S holds.
    pub(crate) fn label_between(&self, from: &FootPair, to: &FootPair) -> Label {
        let may_step_first = |lead: usize| {
            let [mut left, mut right] = [&from[0], &from[1]];
            *(if lead == 0 { &mut left } else { &mut right }) = &to[lead];
            self.is_sufficient([left, right])
        };
        let leads = [0, 1].map(may_step_first);
        if leads.contains(&true) { Label::Primitive { leads } } else { Label::Indeterminate }
    }

    /// Whether C_S holds for a pair of placements.
    fn is_sufficient(&self, [left, right]: [&FootPlacement; 2]) -> bool {
        let robot = &self.constraints.robot;
        sufficient_pair(self.preparation, robot, &self.constraints.collision, [left, right])
    }
}
