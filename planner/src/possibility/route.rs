//! A guide route: stations from the start to the goal.

use surefoot_shared_types::Pose;
use surefoot_shared_types::config::Mark;

use crate::arena::reserve;

use super::forest::Labelled;
use super::label::Label;
use super::sampling::BACKWARD;
use super::stance::{Pair, Placed};
use super::station::Station;
use super::tree::Vertex;

/// A foot within so many metres (in the metric of Gamma_P) of a station faces as the robot does
/// there: a turn about counts 0.94 m.
const SUITS_WITHIN: f64 = 0.6;

/// Stations from start to goal, both included; the placements found at each are kept by the growth.
#[derive(Debug)]
pub struct Route {
    pub(super) vertices: Vec<Vertex>,
    /// The label of the edge that leads to each vertex from the one before it; the first has none.
    pub(super) labels: Vec<Label>,
    feet_apart: [f64; 2],
}

impl Route {
    /// Room for a route; empty.
    pub(super) fn new(start: &Mark, goal: &Mark, stations_max: usize) -> Self {
        Self {
            vertices: reserve(2 * stations_max),
            labels: reserve(2 * stations_max),
            feet_apart: [start.feet_apart, goal.feet_apart],
        }
    }

    pub(super) fn start_on(&mut self, start: &Mark) {
        self.feet_apart[0] = start.feet_apart;
    }

    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.labels.clear();
    }

    /// The label of the edge from the station before to this one.
    pub fn label(&self, index: usize) -> Label {
        self.labels[index]
    }

    /// How many edges it has, and how many of them are possible.
    pub fn labelled(&self) -> Labelled {
        let edges = self.labels.len().saturating_sub(1) as u64;
        Labelled {
            edges,
            possible: self.labels.iter().filter(|label| label.is_possible()).count() as u64,
        }
    }

    /// Whether primitives stand on a placement at a station.
    pub fn is_stood_on(&self, index: usize, placed: &Placed) -> bool {
        let leads = |label: Option<&Label>| matches!(label, Some(Label::Primitive { .. }));
        let is_on_stretch = leads(self.labels.get(index)) || leads(self.labels.get(index + 1));
        is_on_stretch && self.pair(index).is_some_and(|pair| pair.contains(placed))
    }

    /// The placements that a station stands on, left and right.
    pub fn pair(&self, index: usize) -> Option<&Pair> {
        self.vertices[index].pair.as_ref()
    }

    /// How many stations there are.
    pub fn stations(&self) -> usize {
        self.vertices.len()
    }

    /// Whether the robot has room all along it without stooping.
    pub fn is_upright(&self) -> bool {
        self.vertices.iter().all(|vertex| vertex.is_upright)
    }

    /// Whether it has room so at a station and at so many before and after it.
    pub fn is_upright_about(&self, index: usize, reach: usize) -> bool {
        let about = index.saturating_sub(reach)..self.vertices.len().min(index + reach + 1);
        self.vertices[about].iter().all(|vertex| vertex.is_upright)
    }

    /// Whether it is walked backward, at least in part.
    pub fn is_backward(&self) -> bool {
        self.vertices.iter().any(|vertex| vertex.facing == BACKWARD)
    }

    /// Whether a foot at `place` faces as the robot does on this route. Where that walks backward,
    /// feet that face ahead would draw the search to what has been tried in vain.
    pub fn suits(&self, place: &Station) -> bool {
        !self.is_backward()
            || self.vertices.iter().any(|vertex| vertex.station.distance(place) < SUITS_WITHIN)
    }

    /// One of the stations.
    pub fn station(&self, index: usize) -> Station {
        self.vertices[index].station
    }

    /// Where a foot would ideally stand at a station: beside the route, facing along it, as far
    /// apart as the marks say times `widening`.
    pub fn world_from_ideal_sole(&self, index: usize, limb: usize, widening: f64) -> Pose {
        let walked = index as f64 / (self.stations() - 1).max(1) as f64;
        let [from, to] = self.feet_apart;
        self.station(index).world_from_ideal_sole(limb, widening * (from + walked * (to - from)))
    }
}
