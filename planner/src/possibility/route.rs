//! A guide route: stations from the start to the goal.

use surefoot_shared_types::Pose;
use surefoot_shared_types::config::Mark;

use crate::arena::reserve;

use super::growth::Vertex;
use super::station::Station;

/// Stations from start to goal, both included; the placements found at each are kept by the growth.
#[derive(Debug)]
pub struct Route {
    pub(super) vertices: Vec<Vertex>,
    feet_apart: [f64; 2],
}

impl Route {
    /// Room for a route; empty.
    pub(super) fn new(start: &Mark, goal: &Mark, stations_max: usize) -> Self {
        Self { vertices: reserve(2 * stations_max), feet_apart: [start.feet_apart, goal.feet_apart] }
    }

    /// How many stations there are.
    pub fn stations(&self) -> usize {
        self.vertices.len()
    }

    /// One of the stations.
    pub fn station(&self, index: usize) -> Station {
        self.vertices[index].station
    }

    /// Where a foot would ideally stand at a station: beside the route, facing along it, as far apart as the marks say
    /// times `widening`.
    pub fn world_from_ideal_sole(&self, index: usize, limb: usize, widening: f64) -> Pose {
        let walked = index as f64 / (self.stations() - 1).max(1) as f64;
        let [from, to] = self.feet_apart;
        self.station(index).world_from_ideal_sole(limb, widening * (from + walked * (to - from)))
    }
}
