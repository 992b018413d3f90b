//! How far a search came, for pictures.

use glam::DVec3;

use crate::pipeline::planner::Planner;

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

impl Planner {
    /// How far the search came. Allocates.
    pub fn trace(&self) -> SearchTrace {
        let route = &self.search.route;
        let is_searched = !self.stats().used_straight_line;
        let found = route.route();
        let vertices = if is_searched { found.vertex_count() } else { 0 };
        SearchTrace {
            tree: route.tree_edges().collect(),
            route: (0..vertices).map(|index| found.pose(index).position).collect(),
            bottleneck: self.bottleneck().map(|place| place.position),
        }
    }
}
