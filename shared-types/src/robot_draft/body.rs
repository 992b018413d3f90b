//! The surface points of links, from their collision shapes or else from their looks.

use glam::DVec3;

use crate::base::input_error::InputError;
use crate::base::spatial::Pose;
use crate::geometry::shape::Shape;
use crate::mesh::store::MeshStore;
use crate::robot::links::{ShapeChoice, build_link};
use crate::robot::mesh_path::links_without_meshes;
use crate::robot::model::LinkShape;
use crate::robot_draft::skeleton::{NodeIndex, Skeleton};

/// Corners of the polygon that stands for a cylinder's rim.
const RIM_CORNERS: usize = 24;

/// The shapes of every node.
pub(crate) struct LinkShapes {
    /// Collision shapes that can be read.
    pub(crate) collision: Vec<Vec<LinkShape>>,
    /// Shapes of looks; read only for nodes whose body has no collision shape, or balls alone.
    pub(crate) visual: Vec<Vec<LinkShape>>,
}

/// Points of a surface, and balls of which every surface point counts.
#[derive(Debug, Clone, Default)]
pub(crate) struct SurfacePoints {
    pub(crate) points: Vec<DVec3>,
    /// Centres and radii, m.
    pub(crate) balls: Vec<(DVec3, f64)>,
}

impl LinkShapes {
    /// Reads all shapes. Looks that cannot be read are passed over, and meshes whose files are
    /// missing if `skip_missing`.
    ///
    /// # Errors
    /// Collision shapes that cannot be read.
    pub(crate) fn read(skeleton: &Skeleton, skip_missing: bool) -> Result<Self, InputError> {
        let mut meshes = MeshStore::default();
        let mut complaints = Vec::new();
        let mut read = |node: NodeIndex, visual: bool| {
            let (urdf, link) = (skeleton.urdf, skeleton.nodes[node].urdf_link);
            let choice = ShapeChoice { exact: false, visual, may_lack_meshes: skip_missing };
            let mut found = Vec::new();
            let shapes = build_link(urdf, link, choice, &mut meshes, &mut found).shapes;
            complaints.extend(found.into_iter().filter(|_| !visual));
            shapes
        };
        let count = skeleton.nodes.len();
        let collision: Vec<_> = (0..count).map(|node| read(node, false)).collect();
        let has_flat_shape = |body| {
            let nodes = skeleton.body_nodes(body);
            nodes.iter().flat_map(|node| &collision[*node]).any(|part| !is_ball(&part.shape))
        };
        let visual = (0..count)
            .map(|node| {
                let is_bare = !has_flat_shape(skeleton.body(node));
                if is_bare { read(node, true) } else { Vec::new() }
            })
            .collect();
        if let [complaint] = &mut complaints[..] {
            hint_at_one(skeleton, complaint);
        } else if let Some(hint) = hint_at_several(skeleton).filter(|_| !complaints.is_empty()) {
            complaints.insert(0, hint);
        }
        InputError::all(complaints)?;
        Ok(Self { collision, visual })
    }

    /// The shapes that stand for a node.
    pub(crate) fn of(&self, node: NodeIndex) -> &[LinkShape] {
        if self.visual[node].is_empty() { &self.collision[node] } else { &self.visual[node] }
    }

    /// Whether a body has collision shapes.
    pub(crate) fn has_collision(&self, skeleton: &Skeleton, body: NodeIndex) -> bool {
        skeleton.body_nodes(body).iter().any(|node| !self.collision[*node].is_empty())
    }

    /// The nodes of a body whose looks stand for them.
    pub(crate) fn visual_nodes(&self, skeleton: &Skeleton, body: NodeIndex) -> Vec<NodeIndex> {
        let mut nodes = skeleton.body_nodes(body);
        nodes.retain(|node| !self.visual[*node].is_empty());
        nodes
    }

    /// The surface of all links of a body, in the body's frame.
    pub(crate) fn surface(&self, skeleton: &Skeleton, body: NodeIndex) -> SurfacePoints {
        surface_of(skeleton, body, |node| self.of(node))
    }

    /// The balls among the collision shapes of a body whose looks stand for it, in the body's
    /// frame: centres and radii, m.
    pub(crate) fn contact_balls(&self, skeleton: &Skeleton, body: NodeIndex) -> Vec<(DVec3, f64)> {
        let is_shown = |node: NodeIndex| !self.visual[node].is_empty();
        let shapes = |node| if is_shown(node) { &self.collision[node][..] } else { &[] };
        surface_of(skeleton, body, shapes).balls
    }
}

/// The surface of shapes of a body's links, in the body's frame.
fn surface_of<'s>(
    skeleton: &Skeleton,
    body: NodeIndex,
    shapes: impl Fn(NodeIndex) -> &'s [LinkShape],
) -> SurfacePoints {
    let poses = skeleton.poses(&vec![0.0; skeleton.nodes.len()]);
    let body_from_root = poses[body].inverse();
    let mut surface = SurfacePoints::default();
    for node in skeleton.body_nodes(body) {
        let body_from_link = body_from_root * poses[node];
        for part in shapes(node) {
            surface.add(&part.shape, &(body_from_link * part.link_from_shape));
        }
    }
    surface
}

/// Says how to go on where the only complaint is a missing mesh file.
fn hint_at_one(skeleton: &Skeleton, complaint: &mut InputError) {
    if !links_without_meshes(skeleton.urdf).is_empty() {
        complaint.message += ", or add --skip-missing-meshes to go on without this shape";
    }
}

/// How to go on where mesh files are missing.
fn hint_at_several(skeleton: &Skeleton) -> Option<InputError> {
    let path = &skeleton.urdf.source.path;
    let count = links_without_meshes(skeleton.urdf).len();
    let message = format!(
        "mesh files of {count} of its {} links are missing; with --skip-missing-meshes these links get no shape, and nothing keeps them from colliding",
        skeleton.nodes.len()
    );
    (count > 0).then(|| InputError::file(path, message))
}

fn is_ball(shape: &Shape) -> bool {
    matches!(shape, Shape::Sphere { .. })
}

impl SurfacePoints {
    fn add(&mut self, shape: &Shape, from_shape: &Pose) {
        match shape {
            Shape::Box { half_extents } => {
                let corner = |bits: usize| {
                    DVec3::from_array([0, 1, 2].map(|axis| {
                        let sign = if bits >> axis & 1 == 1 { 1.0 } else { -1.0 };
                        sign * half_extents[axis]
                    }))
                };
                self.points.extend((0..8).map(|bits| *from_shape * corner(bits)));
            }
            Shape::Sphere { radius } => self.balls.push((from_shape.translation, *radius)),
            Shape::Capsule { radius, half_length } => {
                let end = |z: f64| (*from_shape * DVec3::new(0.0, 0.0, z), *radius);
                self.balls.extend([end(*half_length), end(-*half_length)]);
            }
            Shape::Cylinder { radius, half_length } => {
                for corner in 0..RIM_CORNERS {
                    let angle = std::f64::consts::TAU * corner as f64 / RIM_CORNERS as f64;
                    let (sin, cos) = libm::sincos(angle);
                    for z in [-half_length, *half_length] {
                        self.points.push(*from_shape * DVec3::new(radius * cos, radius * sin, z));
                    }
                }
            }
            Shape::ConvexHull { points, .. } | Shape::Mesh { vertices: points, .. } => {
                self.points.extend(points.iter().map(|point| *from_shape * *point));
            }
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.points.is_empty() && self.balls.is_empty()
    }

    /// The farthest extent along a unit direction, m.
    pub(crate) fn extent(&self, direction: DVec3) -> f64 {
        let points = self.points.iter().map(|point| point.dot(direction));
        let balls = self.balls.iter().map(|(centre, radius)| centre.dot(direction) + radius);
        points.chain(balls).fold(f64::NEG_INFINITY, f64::max)
    }
}
