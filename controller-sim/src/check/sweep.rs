//! Distances over a continuous motion, by bounds on how far anything can move between two instants.
//!
//! The signed distance of two bodies changes no faster than they move. If it is `d0` and `d1` at
//! the ends of an interval in which no point moves more than `w` relative to the other body, it
//! never falls below `(d0 + d1 - w) / 2`. Where that does not clear a pair, the interval is halved
//! for this pair, down to a motion of [`RESOLUTION`].

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::robot::RobotModel;

use super::Violation;
use super::collision::overlap;
use super::levers::Levers;
use super::motion::Change;
use crate::bound::{below, within};
use crate::geometry::body::{Body, Placed};
use crate::geometry::separation::{body_separation, separation};
use crate::kinematics::{Configuration, Posture};

/// Motions up to this length (m) are judged by their ends alone.
const RESOLUTION: f64 = 1e-3;

/// What a body of the robot may meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Partner {
    /// A body of the robot.
    Robot(usize),
    /// A body of the world.
    World(usize),
}

/// Two bodies that must stay apart.
#[derive(Debug, Clone)]
pub struct Pair {
    /// The robot's body.
    pub body: usize,
    /// What it may meet.
    pub partner: Partner,
    /// Whether its distance counts as a margin; that of a foot and the world, on which it comes to
    /// stand, does not.
    measured: bool,
    /// The direction that last told the two apart.
    hint: Option<DVec3>,
}

impl Pair {
    /// A pair about which nothing is known.
    pub fn new(body: usize, partner: Partner, measured: bool) -> Self {
        Self { body, partner, measured, hint: None }
    }
}

/// One check of one motion.
pub struct Sweep<'a> {
    /// The robot.
    pub model: &'a RobotModel,
    /// Its bodies.
    pub robot: &'a [Body],
    /// The world's bodies.
    pub world: &'a [Body],
    /// Where the world's bodies are.
    pub world_placed: &'a [Placed],
    /// Levers of the robot's bodies.
    pub levers: &'a [Levers],
    /// The pairs to keep apart.
    pub pairs: &'a mut [Pair],
    /// What an overlap violates.
    pub check: Check,
    /// The deepest overlap allowed, m.
    pub penetration_max: f64,
    /// The smallest distance met so far, m.
    pub worst: f64,
}

/// Where everything is at an instant.
struct Scene {
    robot: Vec<Placed>,
}

/// A stretch of the motion between two waypoints.
struct Interval<'a> {
    waypoint: usize,
    start: &'a Configuration,
    end: &'a Configuration,
    /// The stretch, as fractions of the way.
    from: f64,
    to: f64,
}

impl Sweep<'_> {
    /// Checks a whole motion. `alive` is called at every waypoint.
    pub fn run(
        &mut self,
        configurations: &[Configuration],
        alive: &mut dyn FnMut(),
    ) -> Result<(), Violation> {
        let mut before: Option<Scene> = None;
        for (waypoint, end) in configurations.iter().enumerate() {
            alive();
            let scene = self.place(end);
            // A single waypoint is an interval without motion.
            let (previous, start) = match (&before, waypoint.checked_sub(1)) {
                (Some(previous), Some(index)) => (previous, &configurations[index]),
                _ => (&scene, end),
            };
            if before.is_some() || configurations.len() == 1 {
                let interval = Interval {
                    waypoint: waypoint.saturating_sub(1),
                    start,
                    end,
                    from: 0.0,
                    to: 1.0,
                };
                let ways = self.ways(&interval, &Change::between(start, end))?;
                let all: Vec<usize> = (0..self.pairs.len()).collect();
                self.clear(&interval, (previous, &scene), &ways, &all)?;
            }
            before = Some(scene);
        }
        Ok(())
    }

    fn place(&self, configuration: &Configuration) -> Scene {
        let posture = Posture::new(self.model, configuration);
        let placed = |body: &Body| {
            Placed::new(
                body,
                &body.link.map_or(Pose::IDENTITY, |link| posture.world_from_link[link]),
            )
        };
        Scene { robot: self.robot.iter().map(placed).collect() }
    }

    /// The motion of each pair; each finite, so that halving it ends.
    fn ways(&self, interval: &Interval, change: &Change) -> Result<Vec<f64>, Violation> {
        let ways: Vec<f64> = self.pairs.iter().map(|pair| self.way(pair, change)).collect();
        match ways.iter().find(|way| !below(**way, f64::INFINITY)) {
            Some(way) => Err(Violation::new(
                self.check,
                interval.waypoint,
                format!("a link moves by {way} m to the next waypoint"),
            )),
            None => Ok(ways),
        }
    }

    fn way(&self, pair: &Pair, change: &Change) -> f64 {
        match pair.partner {
            Partner::World(_) => self.levers[pair.body].way(change),
            Partner::Robot(other) => {
                self.levers[pair.body].relative_way(&self.levers[other], change)
            }
        }
    }

    /// Clears the given pairs over an interval; `ways` are the motions over the whole way between
    /// the waypoints.
    fn clear(
        &mut self,
        interval: &Interval,
        ends: (&Scene, &Scene),
        ways: &[f64],
        pairs: &[usize],
    ) -> Result<(), Violation> {
        let mut in_doubt = Vec::new();
        for &pair in pairs {
            let way = ways[pair] * (interval.to - interval.from);
            let at_start = self.distance(interval.waypoint, ends.0, pair, way)?;
            let at_end = self.distance(interval.waypoint, ends.1, pair, way)?;
            let lowest = 0.5 * (at_start + at_end - way);
            if !within(-self.penetration_max, lowest) && !within(way, RESOLUTION) {
                in_doubt.push(pair);
            }
        }
        if in_doubt.is_empty() {
            return Ok(());
        }
        let middle = 0.5 * (interval.from + interval.to);
        let scene = self.place(&interval.start.towards(interval.end, middle));
        self.clear(&Interval { to: middle, ..*interval }, (ends.0, &scene), ways, &in_doubt)?;
        self.clear(&Interval { from: middle, ..*interval }, (&scene, ends.1), ways, &in_doubt)
    }

    /// The distance of a pair, or a bound that is enough to clear a motion of length `way`.
    fn distance(
        &mut self,
        waypoint: usize,
        scene: &Scene,
        index: usize,
        way: f64,
    ) -> Result<f64, Violation> {
        let pair = &self.pairs[index];
        let (body, placed) = (&self.robot[pair.body], &scene.robot[pair.body]);
        let (other, there) = match pair.partner {
            Partner::Robot(other) => (&self.robot[other], &scene.robot[other]),
            Partner::World(other) => (&self.world[other], &self.world_placed[other]),
        };
        let enough = if pair.measured { way.max(self.worst) } else { way };
        let hint = pair.hint.unwrap_or_else(|| {
            (there.bounds.centre() - placed.bounds.centre()).normalize_or(DVec3::X)
        });
        let separation = if pair.measured { body_separation } else { separation };
        let found = separation((&body.solid, placed), (&other.solid, there), hint, enough);
        if !within(-self.penetration_max, found.distance) {
            return Err(overlap(
                self.check,
                waypoint,
                (body, other),
                found.distance,
                self.penetration_max,
            ));
        }
        if pair.measured {
            self.worst = self.worst.min(found.distance);
        }
        self.pairs[index].hint = Some(found.direction);
        Ok(found.distance)
    }
}
