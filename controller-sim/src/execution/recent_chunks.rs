//! The last accepted chunks of a plan, as far as the stops of the next one reach back to them.

use surefoot_shared_types::message::{Contact, Margins, PlanChunk, SupportMode, Waypoint};

use crate::check::checker::Checker;
use crate::check::course::{Course, Stop};
use crate::check::segment::{MotionSegment, Violation};

/// The last accepted chunks of a plan, in their order.
#[derive(Debug, Clone, Default)]
pub struct RecentChunks(Vec<RecentChunk>);

/// An accepted chunk.
#[derive(Debug, Clone)]
pub struct RecentChunk {
    mode: SupportMode,
    contacts: Vec<Contact>,
    waypoints: Vec<Waypoint>,
    stop: Stop,
}

impl RecentChunk {
    /// Its motion, on which the robot may stop as `stops` say.
    fn segment<'a>(&'a self, stops: &'a [Stop]) -> MotionSegment<'a> {
        let Self { mode, contacts, waypoints, .. } = self;
        MotionSegment { mode: *mode, contacts, waypoints, course: Course::Smooth(stops) }
    }

    fn begin(&self) -> f64 {
        self.waypoints[0].time
    }

    fn end(&self) -> f64 {
        self.waypoints[self.waypoints.len() - 1].time
    }
}

impl RecentChunks {
    /// Adds a chunk of a known mode with its waypoints, and removes those that no stop reaches from
    /// there on.
    pub fn add(&mut self, mode: SupportMode, chunk: &PlanChunk) {
        self.0.push(RecentChunk {
            mode,
            contacts: chunk.contacts().to_vec(),
            waypoints: chunk.waypoints().to_vec(),
            stop: Stop::of_chunk(chunk),
        });
        let (brakes, end) =
            (self.0[self.0.len() - 1].stop.brake_at, self.0[self.0.len() - 1].end());
        self.0.retain(|recent| brakes <= recent.end() || recent.stop.concerns(end, end));
    }

    /// The physical checks of a smooth chunk of a known mode that follows these chunks, of its
    /// stop, and of their stops as far as the robot moves within the chunk meanwhile. `heartbeat`
    /// is called now and then meanwhile.
    ///
    /// # Errors
    /// The first violation.
    pub fn check_next(
        &self,
        checker: &mut Checker,
        (mode, chunk): (SupportMode, &PlanChunk),
        heartbeat: &mut dyn FnMut(),
    ) -> Result<Margins, Violation> {
        let (contacts, waypoints) = (chunk.contacts(), chunk.waypoints());
        let own = [Stop::of_chunk(chunk)];
        let (begin, end) = (waypoints[0].time, waypoints[waypoints.len() - 1].time);
        let stops = [&own[..], &self.stops_within(begin, end)].concat();
        let mut margins = Margins::UNMEASURED;
        for before in self.concerned_by(&own[0]) {
            let found = checker.check_stops(&before.segment(&own), heartbeat);
            let found = found.map_err(|violation| Violation {
                waypoint: 0,
                detail: format!("while it brakes before this chunk: {}", violation.detail),
                ..violation
            })?;
            margins = margins.min(&found);
        }
        let segment = MotionSegment { mode, contacts, waypoints, course: Course::Smooth(&stops) };
        Ok(margins.min(&checker.check_segment(&segment, heartbeat)?))
    }

    /// Removes all.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// The last waypoint.
    pub fn last_waypoint(&self) -> Option<&Waypoint> {
        self.0.last()?.waypoints.last()
    }

    /// The plan time at which the robot brakes if no chunk follows, s.
    pub fn brake_at(&self) -> Option<f64> {
        self.0.last().map(|recent| recent.stop.brake_at)
    }

    /// The stops of these chunks that concern the plan time between `begin` and `end` (s).
    fn stops_within(&self, begin: f64, end: f64) -> Vec<Stop> {
        let stops = self.0.iter().map(|recent| recent.stop);
        stops.filter(|stop| stop.concerns(begin, end)).collect()
    }

    /// The chunks in which a stop of the next chunk takes place.
    fn concerned_by(&self, stop: &Stop) -> impl Iterator<Item = &RecentChunk> {
        let is_concerned = |recent: &&RecentChunk| stop.concerns(recent.begin(), recent.end());
        self.0.iter().filter(is_concerned)
    }
}
