//! A swing foot comes clear of the world: it does not slide over the ground.
//!
//! While one foot carries the robot, the other may touch the world before it lifts off, where it
//! lands, and where it is set down on its way. As long as it touches, it keeps its pose, from one
//! chunk to the next, too.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_distance;
use surefoot_shared_types::message::{Check, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::is_at_most;
use crate::check::segment::{Case, Violation};
use crate::geometry::body::{CollisionBody, SolidPose};
use crate::geometry::separation::separation;
use crate::kinematics::forward::{Configuration, Posture};

/// A foot nearer to the world than this touches it, m.
const CLEAR_MIN: f64 = 1e-3;
/// A foot that touches the world may be this far from the pose at which it began to, m.
/// A misplaced foot slides by up to 5 mm and 1 degree to where it comes to rest.
const SLIDE_MAX: f64 = 6e-3;
/// The same for its rotation, rad.
const SLIDE_TURN_MAX: f64 = 0.025;

/// The bodies and the poses of the bodies of a world.
type Bodies<'a> = (&'a [CollisionBody], &'a [SolidPose]);

/// Whether each swing foot keeps its pose from the sample at which it begins to touch the world to
/// that at which it comes clear.
///
/// # Errors
/// The first sample at which a foot has slid.
pub fn check_swing_clearance(
    model: &RobotModel,
    case: &Case,
    robot: &[CollisionBody],
    world: Bodies<'_>,
) -> Result<(), Violation> {
    let stance = case.stance();
    for limb in (0..model.feet.len()).filter(|limb| !stance.contains(limb)) {
        let mut foot = SwingFoot::new((model, limb), robot, world);
        for sample in &case.motion.samples {
            foot.follow(&sample.posture, sample.waypoint)?;
        }
    }
    Ok(())
}

/// The pose in which the sole of a swing foot began to touch the world, if it still does at the
/// last of some waypoints. `before` is what this was at the first of them, after other motions of
/// the same swing.
///
/// # Errors
/// The first waypoint at which the foot has slid since then.
pub fn check_touch(
    swing: (&RobotModel, usize),
    waypoints: &[Waypoint],
    before: Option<Pose>,
    robot: &[CollisionBody],
    world: Bodies<'_>,
) -> Result<Option<Pose>, Violation> {
    let model = swing.0;
    let posture = |waypoint: &Waypoint| {
        Posture::new(model, &Configuration::of_waypoint(waypoint, model.joints.len()))
    };
    let mut foot = SwingFoot { rest: before, ..SwingFoot::new(swing, robot, world) };
    let Some(last) = waypoints.last() else { return Ok(before) };
    if before.is_none() && !foot.touches(&posture(last)) {
        return Ok(None);
    }
    for (index, waypoint) in waypoints.iter().enumerate() {
        foot.follow(&posture(waypoint), index)?;
    }
    Ok(foot.rest)
}

/// Whether a foot touches the world at a waypoint.
pub fn touches_world(
    swing: (&RobotModel, usize),
    waypoint: &Waypoint,
    robot: &[CollisionBody],
    world: Bodies<'_>,
) -> bool {
    let configuration = Configuration::of_waypoint(waypoint, swing.0.joints.len());
    SwingFoot::new(swing, robot, world).touches(&Posture::new(swing.0, &configuration))
}

/// A foot that swings, and whether it touches the world.
struct SwingFoot<'a> {
    model: &'a RobotModel,
    limb: usize,
    contact: FootContact<'a>,
    /// The pose in which its sole began to touch the world, while it does.
    rest: Option<Pose>,
}

impl<'a> SwingFoot<'a> {
    fn new(
        (model, limb): (&'a RobotModel, usize),
        robot: &'a [CollisionBody],
        world: Bodies<'a>,
    ) -> Self {
        let link = model.feet[limb].link;
        let bodies = robot.iter().filter(|body| body.link == Some(link)).collect();
        Self { model, limb, contact: FootContact::new(bodies, world), rest: None }
    }

    fn touches(&mut self, posture: &Posture) -> bool {
        self.contact.touches(&posture.world_from_link[self.model.feet[self.limb].link])
    }

    /// Moves the foot on to a posture, after the waypoint `waypoint`.
    fn follow(&mut self, posture: &Posture, waypoint: usize) -> Result<(), Violation> {
        if !self.touches(posture) {
            self.rest = None;
            return Ok(());
        }
        let at = posture.world_from_sole(self.model, self.limb);
        let Some(slide) = slide(self.rest.get_or_insert(at), &at) else { return Ok(()) };
        let foot = &self.model.feet[self.limb].name;
        let detail = format!("the {foot} foot slides over the world while it swings{slide}");
        Err(Violation::new(Check::Collision, waypoint, detail))
    }
}

/// The distance and rotation from a pose of rest, as a part of a message; nothing if both are
/// small.
fn slide(rest: &Pose, pose: &Pose) -> Option<String> {
    let distance = rest.translation.distance(pose.translation);
    let turn = rotation_distance(rest.rotation, pose.rotation);
    let is_small = is_at_most(distance, SLIDE_MAX) && is_at_most(turn, SLIDE_TURN_MAX);
    (!is_small).then(|| {
        format!(
            ", {:.1} mm and {:.2} deg from its pose of rest; limits {:.1} mm and {:.2} deg",
            1e3 * distance,
            turn.to_degrees(),
            1e3 * SLIDE_MAX,
            SLIDE_TURN_MAX.to_degrees()
        )
    })
}

/// Contact of the bodies of one foot with the world.
struct FootContact<'a> {
    foot: Vec<&'a CollisionBody>,
    world: &'a [CollisionBody],
    poses: &'a [SolidPose],
    /// The last separating direction of each body of the foot and each of the world.
    hints: Vec<DVec3>,
}

impl<'a> FootContact<'a> {
    fn new(foot: Vec<&'a CollisionBody>, (world, poses): Bodies<'a>) -> Self {
        let hints = vec![-DVec3::Z; foot.len() * world.len()];
        Self { foot, world, poses, hints }
    }

    /// Whether the foot is nearer than [`CLEAR_MIN`] to the world.
    fn touches(&mut self, world_from_link: &Pose) -> bool {
        let mut hints = self.hints.iter_mut();
        let mut touches = false;
        for body in &self.foot {
            let placed = SolidPose::new(body, world_from_link);
            for (other, there) in self.world.iter().zip(self.poses) {
                let Some(hint) = hints.next() else { continue };
                let solids = ((&body.solid, &placed), (&other.solid, there));
                let found = separation(solids.0, solids.1, *hint, CLEAR_MIN);
                *hint = found.direction;
                touches |= !is_at_most(CLEAR_MIN, found.distance);
            }
        }
        touches
    }
}
