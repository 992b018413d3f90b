//! The labels of equation 3.1 on Gamma_P [Grey 3.1, 4.1.1].
//!
//! A vertex stands on a pair of placements, and an edge leads from one pair to the next with one
//! step of each foot. Both are possible where C_S holds on all that this takes: then primitives
//! lead along. Since all edges of a vertex share its pair, two possible ones always join there,
//! unless primitives do not lead over the pair itself: such a vertex is indeterminate, an edge
//! without length. What fails C_N never becomes a vertex or an edge.

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
    /// C_S holds: primitives lead along.
    Primitive {
        /// Which feet may step first.
        leads: [bool; 2],
    },
    /// Stage M has solved it.
    Traversed,
}

impl Label {
    /// Whether the edge is possible.
    pub fn is_possible(self) -> bool {
        self != Self::Indeterminate
    }
}

impl StageContext<'_> {
    /// The pair of a vertex over which primitives lead: onto and off it with either foot.
    pub(crate) fn pair_of(&self, vertex: &mut Vertex) -> Option<FootPair> {
        let pair = vertex.pair?;
        let has_primitives =
            *vertex.has_primitives.get_or_insert_with(|| self.holds([&pair[0], &pair[1]]));
        has_primitives.then_some(pair)
    }

    /// The label of the edge between two vertices over which primitives lead.
    pub(crate) fn label_between(&self, from: &FootPair, to: &FootPair) -> Label {
        let may_lead = |lead: usize| {
            let [mut left, mut right] = [&from[0], &from[1]];
            *(if lead == 0 { &mut left } else { &mut right }) = &to[lead];
            self.holds([left, right])
        };
        let leads = [0, 1].map(may_lead);
        if leads.contains(&true) { Label::Primitive { leads } } else { Label::Indeterminate }
    }

    fn holds(&self, [left, right]: [&FootPlacement; 2]) -> bool {
        let robot = &self.constraints.robot;
        sufficient_pair(self.preparation, robot, &self.constraints.collision, [left, right])
    }
}
