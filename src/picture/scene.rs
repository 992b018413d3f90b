//! Everything a picture can show of a plan, in drawable form.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::plan_format::blocks::PlanFile;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

use crate::picture::error::PictureError;
use crate::picture::ground_overlay;
use crate::picture::ground_overlay::{EndpointMarker, Foothold, Stance};
use crate::picture::motion::PlanMotion;
use crate::picture::surface::Surface;
use crate::picture::tessellate::triangles_of;

/// Instants at which the robot's extent is measured to place the camera.
const SWEEP_MOMENTS: usize = 24;
/// How high over a sole's plane something it rests on may reach, m.
const CARRY_GAP: f64 = 0.01;

/// A plan with its robot and world, ready to be drawn.
#[derive(Debug, Clone)]
pub struct PictureScene {
    /// The robot's bodies.
    pub(crate) robot: Vec<RobotBody>,
    /// The world's bodies.
    pub(crate) world: Vec<WorldBody>,
    /// The plan's motion.
    pub(crate) motion: PlanMotion,
    /// Where feet stand.
    pub(crate) footholds: Vec<Foothold>,
    /// On which feet it stands when.
    pub(crate) stances: Vec<Stance>,
    /// The centre of mass at every waypoint, world frame.
    pub(crate) com_path: Vec<DVec3>,
    /// Start and goal, and where a search without a plan failed most often.
    pub(crate) endpoints: Vec<EndpointMarker>,
    /// The edges that a search without a plan explored, world frame.
    pub(crate) tree: Vec<[DVec3; 2]>,
    /// The guide route of a search without a plan, world frame.
    pub(crate) route: Vec<DVec3>,
    /// Corners of boxes around the robot's links over the whole walk, world frame, in the order of
    /// time, and those of the footholds.
    pub(crate) sweep: Vec<DVec3>,
    /// What it shows, in a line.
    pub(crate) title: String,
}

/// A collision shape of the robot.
#[derive(Debug, Clone)]
pub(crate) struct RobotBody {
    /// The link it belongs to.
    pub link: usize,
    /// The foot that it is, if it is one.
    pub limb: Option<usize>,
    /// Its surface, link frame.
    pub surface: Surface,
}

/// A shape of the world.
#[derive(Debug, Clone)]
pub(crate) struct WorldBody {
    /// Its surface, world frame.
    pub surface: Surface,
    /// Its surface.
    pub kind: WorldKind,
    /// Whether a foot stands on it.
    pub carries: bool,
}

/// How a shape of the world is coloured; it affects the picture only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WorldKind {
    /// Wide: a floor or a platform.
    Floor,
    /// Higher than wide: a wall.
    Wall,
    /// Anything else.
    Object,
}

impl PictureScene {
    /// Prepares a plan for drawing.
    ///
    /// # Errors
    /// [`PictureError::Plan`] if the plan does not belong to the robot, and [`PictureError::Hull`]
    /// for a hull without volume.
    pub fn new(model: &RobotModel, world: &World, plan: &PlanFile) -> Result<Self, PictureError> {
        let motion = PlanMotion::new(model, plan)?;
        let contacts = ground_overlay::contacts(model, plan)?;
        let endpoints = ground_overlay::endpoint_markers(plan, &motion, &contacts.0);
        let steps = contacts.1.iter().filter(|stance| stance.feet == 1).count();
        let seconds = motion.time(motion.len() - 1) - motion.time(0);
        let title = format!("{}: {steps} steps in {seconds:.1} s", model.name);
        Ok(Self { title, ..Self::of_motion(model, world, motion, contacts, endpoints)? })
    }

    /// The scene of a motion, without a title and the lines of a search.
    pub(crate) fn of_motion(
        model: &RobotModel,
        world: &World,
        motion: PlanMotion,
        (footholds, stances): (Vec<Foothold>, Vec<Stance>),
        endpoints: Vec<EndpointMarker>,
    ) -> Result<Self, PictureError> {
        let robot = robot_bodies(model)?;
        let world = world.shapes.iter().map(|shape| {
            let surface = Surface::new(&triangles_of(&shape.shape, &shape.name)?)
                .transformed(&shape.world_from_shape);
            let carries = footholds.iter().any(|foothold| carries(&surface, foothold));
            Ok(WorldBody { kind: kind_of(&surface), carries, surface })
        });
        let world = world.collect::<Result<_, PictureError>>()?;
        let com_path = motion.center_of_mass_path();
        let mut scene = Self {
            robot,
            world,
            motion,
            com_path,
            footholds,
            stances,
            endpoints,
            tree: Vec::new(),
            route: Vec::new(),
            sweep: Vec::new(),
            title: String::new(),
        };
        scene.sweep = scene.swept();
        Ok(scene)
    }

    /// The robot's surfaces at a fractional waypoint, world frame, in the order of `robot`.
    pub(crate) fn robot_at(&self, at: f64) -> Vec<Surface> {
        let links = self.motion.world_from_links(at);
        self.robot.iter().map(|body| body.surface.transformed(&links[body.link])).collect()
    }

    /// Fractional waypoints spread over the walk, at which it is measured.
    pub(crate) fn sweep_moments(&self) -> Vec<f64> {
        self.motion.evenly_timed(SWEEP_MOMENTS)
    }

    fn swept(&self) -> Vec<DVec3> {
        let bounds: Vec<(DVec3, DVec3)> =
            self.robot.iter().map(|body| body.surface.bounds()).collect();
        let mut points: Vec<DVec3> = Vec::new();
        for at in self.sweep_moments() {
            let links: Vec<Pose> = self.motion.world_from_links(at);
            for (body, (low, high)) in self.robot.iter().zip(&bounds) {
                points.extend(box_corners(*low, *high).map(|corner| links[body.link] * corner));
            }
        }
        points.extend(self.footholds.iter().flat_map(|foothold| foothold.outline.iter().copied()));
        points
    }
}

fn robot_bodies(model: &RobotModel) -> Result<Vec<RobotBody>, PictureError> {
    let mut bodies = Vec::new();
    for (link, body) in model.links.iter().enumerate() {
        let limb = model.feet.iter().position(|foot| foot.link == link);
        for shape in &body.shapes {
            let surface = Surface::new(&triangles_of(&shape.shape, &body.name)?)
                .transformed(&shape.link_from_shape);
            bodies.push(RobotBody { link, limb, surface });
        }
    }
    if bodies.is_empty() { Err(PictureError::NoRobotShapes) } else { Ok(bodies) }
}

fn kind_of(surface: &Surface) -> WorldKind {
    let (low, high) = surface.bounds();
    let size = high - low;
    if size.z > 1.2 && size.z > size.x.min(size.y) {
        WorldKind::Wall
    } else if size.x * size.y > 0.9 && size.x.min(size.y) > 0.6 {
        WorldKind::Floor
    } else {
        WorldKind::Object
    }
}

fn box_corners(low: DVec3, high: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        DVec3::from_array(
            [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] }),
        )
    })
}

/// Whether some point of a foothold rests on the surface.
fn carries(surface: &Surface, foothold: &Foothold) -> bool {
    let centre = foothold.outline.iter().sum::<DVec3>() / foothold.outline.len().max(1) as f64;
    let inward = [0.0, 0.25, 0.5, 0.75, 1.0];
    let next = foothold.outline.iter().cycle().skip(1);
    let rim = foothold
        .outline
        .iter()
        .zip(next)
        .flat_map(|(a, b)| [*a, a.lerp(*b, 0.33), a.lerp(*b, 0.67)]);
    let samples: Vec<DVec3> = rim.flat_map(|point| inward.map(|t| point.lerp(centre, t))).collect();
    let reach =
        foothold.outline.iter().map(|point| point.distance(centre)).fold(CARRY_GAP, f64::max);
    surface.triangles.iter().any(|triangle| {
        let [a, b, c] = triangle.map(|corner| corner.position);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let near = low.cmple(centre + reach).all() && high.cmpge(centre - reach).all();
        near && samples.iter().any(|&sample| over_triangle(sample, [a, b, c]))
    })
}

/// Whether a point lies within [`CARRY_GAP`] above or below an upward triangle.
fn over_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let normal = (b - a).cross(c - a);
    if normal.z <= 0.0 {
        return false;
    }
    let inside = [[a, b], [b, c], [c, a]]
        .iter()
        .all(|[from, to]| (to - from).truncate().perp_dot((point - from).truncate()) >= 0.0);
    inside && (normal.dot(point - a) / normal.z).abs() <= CARRY_GAP
}
