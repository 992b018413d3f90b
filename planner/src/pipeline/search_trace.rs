//! How far a search came, for pictures.

use glam::DVec3;

use crate::pipeline::bottlenecks::Bottleneck;
use crate::possibility::RouteSearch;

/// The places that a search reached. Points lie midway between the soles, in the world, m.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SearchTrace {
    /// The edges of both trees of stage P.
    pub tree: Vec<[DVec3; 2]>,
    /// The guide route found last; empty if none was found.
    pub route: Vec<DVec3>,
    /// Where most sequences failed, if any did.
    pub bottleneck: Option<DVec3>,
}

impl SearchTrace {
    /// The trace of a search. Allocates.
    pub(crate) fn of(
        search: &RouteSearch,
        used_straight_line: bool,
        bottleneck: Option<Bottleneck>,
    ) -> Self {
        let route = search.route();
        let vertices = if used_straight_line { 0 } else { route.vertex_count() };
        Self {
            tree: search.tree_edges().collect(),
            route: (0..vertices).map(|index| route.pose(index).position).collect(),
            bottleneck: bottleneck.map(|place| place.position),
        }
    }
}
