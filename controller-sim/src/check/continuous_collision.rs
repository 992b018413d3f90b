//! Distances over a continuous motion, by bounds on the displacement between two instants.
//!
//! The signed distance of two bodies changes no faster than they move. If it is `d0` and `d1` at
//! the ends of an interval in which no point moves more than `w` relative to the other body, it
//! never falls below `(d0 + d1 - w) / 2`. Where that does not show that a pair stays clear, and no
//! nearer than the smallest distance so far, the interval is halved for this pair, down to a motion
//! of [`RESOLUTION`] or, of a clear pair, [`MARGIN_SHARE`] of that distance; then the bound counts
//! as the distance, or 0 where both ends of the motion are clear. For the same reason a distance
//! known at an earlier instant, less the motion since then, bounds the distance at every later
//! instant: a pair is measured only where this bound is not enough.

use glam::DVec3;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::{is_at_most, is_below};
use crate::check::allowed_pairs::{JointRange, SelfPair, advice, overlap_depth, placed};
use crate::check::motion::Change;
use crate::check::motion_bounds::LeverArms;
use crate::check::segment::Violation;
use crate::check::tuning::{LOOK_AHEAD, MARGIN_SHARE, RESOLUTION, TOUCH_DEPTH_MAX};
use crate::geometry::body::{CollisionBody, SolidPose};
use crate::geometry::penetration::{body_separation, solid_separation};
use crate::kinematics::forward::{Configuration, Posture};

/// The second body of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OtherBody {
    /// A body of the robot.
    Robot(usize),
    /// A body of the world.
    World(usize),
}

/// Two bodies that must stay apart.
#[derive(Debug, Clone)]
pub struct BodyPair {
    /// The robot's body.
    pub body: usize,
    /// The body that it must not overlap.
    pub other_body: OtherBody,
    /// The bodies' lever arms against each other.
    lever_arms: LeverArms,
    /// Whether its distance counts as a margin; that of a foot and the world, on which it comes to
    /// stand, does not.
    measured: bool,
    /// How deep the bodies may overlap beyond the tolerance, m.
    allowed_depth: f64,
    /// The ranges of the joints between the bodies within which nothing is checked.
    walked: Vec<JointRange>,
    /// The last separating direction.
    hint: Option<DVec3>,
    /// A lower bound on the distance at the end of the motion so far, m.
    bound: f64,
}

impl BodyPair {
    /// A body of the robot and one of the world, without a separating direction yet.
    pub fn of_world(
        (body, lever_arms): (usize, &LeverArms),
        other_body: usize,
        measured: bool,
    ) -> Self {
        let other_body = OtherBody::World(other_body);
        let lever_arms = lever_arms.clone();
        let (allowed_depth, bound) = (0.0, f64::NEG_INFINITY);
        let walked = Vec::new();
        Self { body, other_body, lever_arms, measured, allowed_depth, walked, hint: None, bound }
    }

    /// Two bodies of the robot. If they may overlap, they have no distance to report.
    pub fn of_robot(pair: &SelfPair, lever_arms: &[LeverArms]) -> Self {
        let (body, other) = pair.bodies;
        Self {
            body,
            other_body: OtherBody::Robot(other),
            lever_arms: LeverArms::relative(&lever_arms[body], &lever_arms[other]),
            measured: pair.depth_max == 0.0,
            allowed_depth: pair.depth_max,
            walked: pair.walked.clone(),
            hint: None,
            bound: f64::NEG_INFINITY,
        }
    }

    /// Two bodies of the robot that are clear in this posture must stay apart.
    pub fn excuse_unless_clear(&mut self, robot: &[CollisionBody], posture: &Posture) {
        let OtherBody::Robot(other) = self.other_body else { return };
        if !self.measured && overlap_depth(robot, posture, (self.body, other), 0.0) == 0.0 {
            self.allowed_depth = 0.0;
            self.walked.clear();
        }
    }

    /// The lowest signed distance allowed, m. Links other than feet stay out of the world.
    fn deepest(&self, penetration_max: f64) -> f64 {
        if self.measured && matches!(self.other_body, OtherBody::World(_)) {
            return -TOUCH_DEPTH_MAX;
        }
        -penetration_max - self.allowed_depth
    }

    /// The lowest bound over a motion that needs no closer look, m; `worst` is the smallest
    /// distance so far. Where links touch, only the tolerance counts.
    fn needed(&self, penetration_max: f64, worst: f64) -> f64 {
        if self.measured && worst > 0.0 { worst } else { self.deepest(penetration_max) }
    }

    /// Whether all configurations between these two leave nothing to check.
    fn is_walked(&self, start: &Configuration, end: &Configuration) -> bool {
        [start, end].iter().all(|configuration| SelfPair::is_walked(&self.walked, configuration))
    }
}

/// One check of one motion.
pub struct ContinuousCollision<'a> {
    /// The robot.
    pub model: &'a RobotModel,
    /// Its bodies.
    pub robot: &'a [CollisionBody],
    /// The world's bodies.
    pub world: &'a [CollisionBody],
    /// The poses of the world's bodies.
    pub world_poses: &'a [SolidPose],
    /// The pairs to keep apart.
    pub pairs: &'a mut [BodyPair],
    /// The check that an overlap violates.
    pub check: Check,
    /// The deepest overlap allowed of two links, and of a foot and the world, m.
    pub penetration_max: f64,
    /// A lower bound on the smallest distance so far, less by at most half of [`RESOLUTION`] or of
    /// [`MARGIN_SHARE`] of it, m; where links touch or overlap, the smallest measured one.
    pub worst: f64,
}

/// A part of the motion between two waypoints.
struct Interval<'a> {
    waypoint: usize,
    start: &'a Configuration,
    end: &'a Configuration,
    /// Its ends, as fractions of the step between the waypoints.
    from: f64,
    to: f64,
}

/// A pair and its distances (m) at both ends of an interval.
struct EndDistances {
    pair: usize,
    at_start: f64,
    at_end: f64,
}

impl EndDistances {
    /// A lower bound on the distance over an interval in which the pair moves by `displacement`, m.
    fn lowest(&self, displacement: f64) -> f64 {
        0.5 * (self.at_start + self.at_end - displacement)
    }
}

impl ContinuousCollision<'_> {
    /// Checks a whole motion. `heartbeat` is called at every waypoint.
    pub fn run(
        &mut self,
        configurations: &[Configuration],
        heartbeat: &mut dyn FnMut(),
    ) -> Result<(), Violation> {
        for pair in self.pairs.iter_mut() {
            pair.bound = f64::NEG_INFINITY;
        }
        let mut before: Option<Posture> = None;
        for (waypoint, end) in configurations.iter().enumerate() {
            heartbeat();
            let posture = Posture::new(self.model, end);
            // A single waypoint is an interval without motion.
            let (previous, start) = match (&before, waypoint.checked_sub(1)) {
                (Some(previous), Some(index)) => (previous, &configurations[index]),
                _ => (&posture, end),
            };
            if before.is_some() || configurations.len() == 1 {
                let interval = Interval {
                    waypoint: waypoint.saturating_sub(1),
                    start,
                    end,
                    from: 0.0,
                    to: 1.0,
                };
                let displacements = self.displacements(&interval, &Change::between(start, end))?;
                let near = self.pairs_to_measure(&interval, &displacements);
                self.clear_step(&interval, (previous, &posture), &displacements, &near)?;
            }
            before = Some(posture);
        }
        Ok(())
    }

    /// The pairs of which the bound does not show that they stay clear over an interval, and no
    /// nearer than the smallest distance so far. The bounds of the others move on to its end.
    fn pairs_to_measure(&mut self, interval: &Interval, displacements: &[f64]) -> Vec<usize> {
        let (penetration_max, worst) = (self.penetration_max, self.worst);
        let mut near = Vec::new();
        for (index, pair) in self.pairs.iter_mut().enumerate() {
            let needed = if pair.measured { worst } else { pair.deepest(penetration_max) };
            let at_end = pair.bound - displacements[index];
            if is_at_most(needed, at_end) || pair.is_walked(interval.start, interval.end) {
                pair.bound = at_end;
            } else {
                near.push(index);
            }
        }
        near
    }

    /// The motion of each pair; each finite, so that halving it ends.
    fn displacements(&self, interval: &Interval, change: &Change) -> Result<Vec<f64>, Violation> {
        let displacements: Vec<f64> =
            self.pairs.iter().map(|pair| pair.lever_arms.displacement_max(change)).collect();
        match displacements.iter().find(|displacement| !is_below(**displacement, f64::INFINITY)) {
            Some(displacement) => Err(Violation::new(
                self.check,
                interval.waypoint,
                format!("a link moves by {displacement} m to the next waypoint"),
            )),
            None => Ok(displacements),
        }
    }

    /// Clears the given pairs over a whole step between two waypoints, in which they move by
    /// `displacements` (m). The distance at its start is measured where its bound is not enough.
    fn clear_step(
        &mut self,
        interval: &Interval,
        ends: (&Posture, &Posture),
        displacements: &[f64],
        pairs: &[usize],
    ) -> Result<(), Violation> {
        let mut in_doubt = Vec::new();
        for &pair in pairs {
            let (displacement, known) = (displacements[pair], self.pairs[pair].bound);
            let at_end = self.distance(interval.waypoint, ends.1, pair, displacement)?;
            self.pairs[pair].bound = at_end;
            let bound = EndDistances { pair, at_start: known, at_end };
            if !self.is_enough(&bound, displacement) {
                let at_start = self.distance(interval.waypoint, ends.0, pair, displacement)?;
                in_doubt.push(EndDistances { at_start, ..bound });
            }
        }
        self.clear(interval, displacements, in_doubt)
    }

    /// Clears pairs over an interval. `displacements` holds the displacements of all pairs over the
    /// whole step between the waypoints.
    fn clear(
        &mut self,
        interval: &Interval,
        displacements: &[f64],
        mut pairs: Vec<EndDistances>,
    ) -> Result<(), Violation> {
        let share = interval.to - interval.from;
        pairs.retain(|ends| !self.is_clear(ends, share * displacements[ends.pair]));
        if pairs.is_empty() {
            return Ok(());
        }
        let middle = 0.5 * (interval.from + interval.to);
        let posture = Posture::new(self.model, &interval.start.towards(interval.end, middle));
        let (mut before, mut after) = (Vec::new(), Vec::new());
        for EndDistances { pair, at_start, at_end } in pairs {
            let displacement = 0.5 * share * displacements[pair];
            let here = self.distance(interval.waypoint, &posture, pair, displacement)?;
            before.push(EndDistances { pair, at_start, at_end: here });
            after.push(EndDistances { pair, at_start: here, at_end });
        }
        self.clear(&Interval { to: middle, ..*interval }, displacements, before)?;
        self.clear(&Interval { from: middle, ..*interval }, displacements, after)
    }

    /// Whether the distances at the ends of an interval show that a pair stays clear in it, and no
    /// nearer than the smallest distance so far.
    fn is_enough(&self, ends: &EndDistances, displacement: f64) -> bool {
        let needed = self.pairs[ends.pair].needed(self.penetration_max, self.worst);
        is_at_most(needed, ends.lowest(displacement))
    }

    /// Whether a pair stays clear over an interval in which it moves by `displacement` (m), and its
    /// distance there is known as far as it counts.
    fn is_clear(&mut self, ends: &EndDistances, displacement: f64) -> bool {
        if self.is_enough(ends, displacement) {
            return true;
        }
        let lowest = ends.lowest(displacement);
        let deepest = self.pairs[ends.pair].deepest(self.penetration_max);
        let coarse = if is_at_most(deepest, lowest) { MARGIN_SHARE * self.worst } else { 0.0 };
        if !is_at_most(displacement, RESOLUTION.max(coarse)) {
            return false;
        }
        // Bodies that touch or overlap are as deep as measured.
        let measured = ends.at_start.min(ends.at_end).min(0.0);
        self.record(ends.pair, lowest.max(measured));
        true
    }

    /// The distance of a pair, or a bound that is enough to clear a motion of length
    /// `displacement`.
    fn distance(
        &mut self,
        waypoint: usize,
        posture: &Posture,
        index: usize,
        displacement: f64,
    ) -> Result<f64, Violation> {
        let pair = &self.pairs[index];
        let (body, placed) = self.placed(posture, pair.body);
        let (other, there) = match pair.other_body {
            OtherBody::Robot(other) => self.placed(posture, other),
            OtherBody::World(other) => (&self.world[other], self.world_poses[other]),
        };
        let needed = if pair.measured { displacement.max(self.worst) } else { displacement };
        let enough = needed + LOOK_AHEAD * displacement;
        let hint = pair.hint.unwrap_or_else(|| {
            (there.bounds.centre() - placed.bounds.centre()).normalize_or(DVec3::X)
        });
        let stands_on = matches!(pair.other_body, OtherBody::World(_)) && !pair.measured;
        let separation = if stands_on { solid_separation } else { body_separation };
        let found = separation((&body.solid, &placed), (&other.solid, &there), hint, enough);
        let deepest = pair.deepest(self.penetration_max);
        if !is_at_most(deepest, found.distance) {
            let (bodies, is_near) = ((body, other), !pair.walked.is_empty());
            let mut violation =
                overlap_violation(self.check, waypoint, bodies, found.distance, -deepest);
            if is_near {
                violation.detail += &advice(bodies, -found.distance);
            }
            return Err(violation);
        }
        self.record(index, found.distance);
        self.pairs[index].hint = Some(found.direction);
        Ok(found.distance)
    }

    /// A body of the robot and its pose.
    fn placed(&self, posture: &Posture, body: usize) -> (&CollisionBody, SolidPose) {
        let body = &self.robot[body];
        (body, placed(body, posture))
    }

    /// Lowers the smallest distance to that of a pair, if its distance counts.
    fn record(&mut self, index: usize, distance: f64) {
        if self.pairs[index].measured {
            self.worst = self.worst.min(distance);
        }
    }
}

/// The violation by two bodies `distance` (negative, m) apart.
pub fn overlap_violation(
    check: Check,
    waypoint: usize,
    (a, b): (&CollisionBody, &CollisionBody),
    distance: f64,
    limit: f64,
) -> Violation {
    let detail = format!(
        "{} overlaps {} by {:.2} mm, limit {:.2} mm",
        a.name,
        b.name,
        -1e3 * distance,
        1e3 * limit
    );
    Violation::new(check, waypoint, detail)
}

#[cfg(test)]
mod tests {
    use surefoot_shared_types::message::Waypoint;
    use surefoot_shared_types::robot::model::RobotModel;
    use surefoot_shared_types::world::world::World;
    use surefoot_shared_types::{Pose, Shape};

    use super::*;
    use crate::check::allowed_pairs::self_pairs;
    use crate::check::tuning::DISTANCE_CAP;
    use crate::check_robot::{at, box_of, mesh, randoms, robot, waypoint, world};
    use crate::geometry::separation::separation;
    use crate::geometry::solid::Solid;

    const PENETRATION_MAX: f64 = 2e-3;
    /// By how much distances may be smaller between the samples of a motion, m.
    const SAMPLING: f64 = 2e-4;

    /// All bodies, and the pairs of one kind.
    struct Scene {
        model: RobotModel,
        robot: Vec<CollisionBody>,
        world: Vec<CollisionBody>,
        poses: Vec<SolidPose>,
        pairs: Vec<BodyPair>,
    }

    impl Scene {
        fn new(world: &World, of_robot: bool) -> Self {
            let model = robot();
            let robot = CollisionBody::of_robot(&model).unwrap();
            let world = CollisionBody::of_world(world).unwrap();
            let poses = world.iter().map(|body| SolidPose::new(body, &Pose::IDENTITY)).collect();
            let lever_arms: Vec<LeverArms> =
                robot.iter().map(|body| LeverArms::new(&model, body)).collect();
            let pairs: Vec<BodyPair> = if of_robot {
                let pairs = self_pairs(&model, &robot).into_iter();
                pairs.map(|pair| BodyPair::of_robot(&pair, &lever_arms)).collect()
            } else {
                let pairs = (0..robot.len()).flat_map(|a| (0..world.len()).map(move |b| (a, b)));
                pairs.map(|(a, b)| BodyPair::of_world((a, &lever_arms[a]), b, true)).collect()
            };
            Self { model, robot, world, poses, pairs }
        }

        /// The smallest distance by the check, or that at which it is refused.
        fn checked(&mut self, configurations: &[Configuration]) -> Result<f64, Violation> {
            let mut collision = ContinuousCollision {
                model: &self.model,
                robot: &self.robot,
                world: &self.world,
                world_poses: &self.poses,
                pairs: &mut self.pairs,
                check: Check::Collision,
                penetration_max: PENETRATION_MAX,
                worst: DISTANCE_CAP,
            };
            collision.run(configurations, &mut || {})?;
            Ok(collision.worst)
        }

        /// The smallest distance over many instants, at most [`DISTANCE_CAP`].
        fn sampled(&self, configurations: &[Configuration], count: u32) -> f64 {
            let mut worst = DISTANCE_CAP;
            for pair in configurations.windows(2) {
                for step in 0..=count {
                    let part = f64::from(step) / f64::from(count);
                    let posture = Posture::new(&self.model, &pair[0].towards(&pair[1], part));
                    let placed = |body: &CollisionBody| {
                        SolidPose::new(body, &posture.world_from_link[body.link.unwrap()])
                    };
                    for BodyPair { body, other_body, .. } in &self.pairs {
                        let first = &self.robot[*body];
                        let (second, there) = match other_body {
                            OtherBody::Robot(other) => {
                                (&self.robot[*other], placed(&self.robot[*other]))
                            }
                            OtherBody::World(other) => (&self.world[*other], self.poses[*other]),
                        };
                        let solids = ((&first.solid, &placed(first)), (&second.solid, &there));
                        let found = separation(solids.0, solids.1, DVec3::X, DISTANCE_CAP);
                        worst = worst.min(found.distance);
                    }
                }
            }
            worst
        }
    }

    #[test]
    fn the_distance_over_a_motion_is_that_of_its_nearest_instant() {
        let mut random = randoms(11);
        let (mut clear, mut refused) = (0, 0);
        for case in 0..60 {
            let mut place = || at(random(-0.6, 0.6), random(0.1, 0.6), random(0.2, 1.0));
            let obstacles = vec![
                ("block", place(), box_of(0.03, 0.05, 0.02)),
                ("other", place(), box_of(0.02, 0.02, 0.2)),
            ];
            let mut floor_away = world(obstacles);
            floor_away.shapes.remove(0);
            let mut scene = Scene::new(&floor_away, case % 3 == 0);
            let mut swung = || waypoint(0.0, random(-1.5, 1.5), random(-1.4, 0.6));
            let ends: [Waypoint; 2] = [swung(), swung()];
            let [from, to] =
                ends.each_ref().map(|waypoint| Configuration::of_waypoint(waypoint, 4));
            let motion: Vec<Configuration> =
                (0..=6).map(|step| from.towards(&to, f64::from(step) / 6.0)).collect();
            let sampled = scene.sampled(&motion, 60);
            match scene.checked(&motion) {
                // Of short motions only the ends are measured, so the bound may be a little less.
                Ok(checked) => {
                    let less = 0.5 * RESOLUTION.max(MARGIN_SHARE * sampled) + SAMPLING;
                    let more = if checked > 0.0 { 1e-9 } else { PENETRATION_MAX + RESOLUTION };
                    assert!((sampled - less..=sampled + more).contains(&checked), "{checked}");
                    assert!(sampled > -PENETRATION_MAX - RESOLUTION, "{case}: {sampled}");
                    clear += 1;
                }
                Err(violation) => {
                    assert!(sampled < -PENETRATION_MAX + RESOLUTION, "{sampled}: {violation}");
                    refused += 1;
                }
            }
            assert_eq!(
                scene.checked(&motion[..1]).is_ok(),
                scene.checked(&[from.clone(), from]).is_ok()
            );
        }
        assert!(clear > 15 && refused > 15, "{clear} {refused}");
    }

    /// A meshed slab whose top is at `height` (m), with a tower 0.5 m beside it, in one mesh.
    fn slab_and_tower(height: f64) -> Shape {
        let [slab, tower] = [mesh([0.3, 0.3, 0.1], 1), mesh([0.1, 0.1, 0.5], 1)];
        let (Shape::Mesh { vertices, triangles, source }, Shape::Mesh { vertices: more, .. }) =
            (slab, tower)
        else {
            unreachable!()
        };
        let below = DVec3::Z * (height - 0.1);
        let beside = below + DVec3::X * 0.5;
        let after = vertices.len() as u32;
        let of_tower = triangles.iter().map(|corners| corners.map(|corner| corner + after));
        Shape::Mesh {
            triangles: triangles.iter().copied().chain(of_tower).collect(),
            vertices: vertices
                .iter()
                .map(|at| *at + below)
                .chain(more.iter().map(|at| *at + beside))
                .collect(),
            source,
        }
    }

    #[test]
    fn only_a_foot_stands_on_a_mesh_within_the_box_around_it() {
        // The right sole, the robot's body 4, reaches so far into the slab. The boxes around both
        // overlap by the sole's 40 mm.
        let check = |depth: f64, change: &dyn Fn(&mut Scene) -> BodyPair| {
            let stairs = world(vec![("stairs", Pose::IDENTITY, slab_and_tower(depth))]);
            let mut scene = Scene::new(&stairs, false);
            scene.robot[4].solid = Solid::new(&mesh([0.1, 0.05, 0.02], 1)).unwrap();
            scene.pairs = vec![change(&mut scene)];
            scene.checked(&[Configuration::of_waypoint(&waypoint(0.0, 0.0, 0.0), 4)])
        };
        let on_world = |measured: bool| {
            move |scene: &mut Scene| {
                let lever_arms = LeverArms::new(&scene.model, &scene.robot[4]);
                BodyPair::of_world((4, &lever_arms), 1, measured)
            }
        };
        check(3e-4, &on_world(false)).unwrap();
        check(5e-3, &on_world(false)).unwrap_err();
        check(3e-4, &on_world(true)).unwrap_err();
        // A link of the robot is no ground either, also where it may be touched.
        let on_robot = |scene: &mut Scene| {
            let frame_from_solid = at(0.0, 0.0, -0.9);
            scene.robot.push(CollisionBody {
                link: Some(0),
                frame_from_solid,
                ..scene.world[1].clone()
            });
            let bodies = (4, scene.robot.len() - 1);
            let lever_arms: Vec<LeverArms> =
                scene.robot.iter().map(|body| LeverArms::new(&scene.model, body)).collect();
            let (standing_depth, depth_max, walked) = (1e-3, 1e-3, vec![]);
            BodyPair::of_robot(&SelfPair { bodies, standing_depth, depth_max, walked }, &lever_arms)
        };
        check(3e-4, &on_robot).unwrap_err();
    }

    #[test]
    fn a_bound_that_reaches_far_saves_measuring() {
        // Nothing is near an arm that hardly moves: all pairs keep a bound and a direction.
        let mut scene = Scene::new(&world(vec![]), true);
        let at =
            |index: usize| Configuration::of_waypoint(&waypoint(0.0, 0.001 * index as f64, 0.0), 4);
        let motion: Vec<Configuration> = (0..4).map(at).collect();
        scene.checked(&motion).unwrap();
        assert!(
            scene.pairs.iter().all(|pair| pair.bound > -PENETRATION_MAX && pair.hint.is_some())
        );
    }
}
